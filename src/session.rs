//! The pipeline as it is run again and again: each stage's result is kept, so that an edit repeats only the stages
//! that depend on it.
//!
//! ```text
//! source (content, prim, time) ┬→ remesh (its options) → transfer (options of the simulation mesh)
//!                              └→ operator (its options) → … → refinement → … → render
//! ```
//!
//! An operator and a refinement are two stages each (`render::stages`): what the mesh is made of, and where its points
//! are. An option that only moves points repeats the second ones. What depends on the faces alone is known by them, so that
//! it is kept where another option makes the same faces.
//!
//! A stage is known by the content of its source and by the options that it reads, never by the name of a file.

use crate::error::{Error, Warnings};
use crate::garment::{Elements, Garment, Primvar, Subset, Values};
pub use crate::memo::Made;
use crate::memo::{Footprint, Memo};
use crate::mesh::{Faces, IdVec, VertexId};
use crate::pipeline::{Checked, Clock, DEFAULT_MAX_FACES, Prepared};
use crate::recipe::Document;
use crate::render::{Front, Ground, Placed, Placing, Rendered, Shaped, Stack, Stages, render};
use crate::sim::{SimOptions, SimProduct};
use crate::subdivide::{Cage, Channels, Connectivity, Level};
use crate::usd::{Format, Product, ProductRole, ReadOptions, Source, Surroundings, WriteOptions, layer_bytes};
use glam::Vec3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Keeps results of stages within a bound of memory. All methods may be called from many threads at once; what two ask
/// for is made once.
pub struct Session {
    memo: Memo<Key>,
    /// Where the work is done, so that the caller's own threads are left alone.
    pool: ThreadPool,
    sources: AtomicU64,
}

/// What a result depends on.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Key {
    Source { content: Arc<[u8]>, options: String },
    Stage { name: &'static str, source: u64, options: String },
}

/// A source that was read and checked.
pub struct Opened {
    /// The source.
    pub source: Source,
    /// Its garment.
    pub checked: Checked,
    warnings: Warnings,
    /// Names the source among those of the session.
    serial: u64,
    content: usize,
}

impl Session {
    /// A session that keeps at most `capacity` bytes and works with `threads` threads, or with one for each core.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(capacity: usize, threads: Option<usize>) -> Result<Self, Error> {
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
        let pool = pool.map_err(|e| Error::Internal(format!("cannot start threads: {e}")))?;
        Ok(Self { memo: Memo::new(capacity), pool, sources: AtomicU64::new(0) })
    }

    /// Memory that the kept results hold, as far as it can be told. \[bytes\]
    pub fn memory(&self) -> usize {
        self.memo.used()
    }

    /// The garment of `content`, a layer that is all of a stage and was composed from `file`.
    ///
    /// # Errors
    /// As [`Source::from_layer`] and [`Checked::new`].
    pub fn open(&self, content: &[u8], file: &Path, options: &ReadOptions) -> Result<Arc<Opened>, Error> {
        let content: Arc<[u8]> = content.into();
        // The file is part of what is made: of its messages.
        let key = Key::Source { content: Arc::clone(&content), options: format!("{options:?} {file:?}") };
        self.memo.get(&key, || {
            let mut warnings = Warnings::default();
            let source = Source::from_layer(Arc::clone(&content), file, options)?;
            let checked = self.pool.install(|| Checked::new(source.garment(&mut warnings)?, &mut warnings))?;
            let serial = self.sources.fetch_add(1, Ordering::Relaxed);
            Ok(Opened { source, checked, warnings, serial, content: content.len() })
        })
    }

    /// The simulation mesh.
    ///
    /// # Errors
    /// A mesh that would be too large.
    pub fn sim(&self, opened: &Opened, prepared: &Prepared) -> Result<Arc<Made<Garment>>, Error> {
        let sim = &prepared.recipe.sim;
        self.memo.get(&opened.key("transfer", sim)?, || {
            let remeshed = self.remeshed(opened, prepared)?;
            let mut warnings = remeshed.warnings.clone();
            let transfer = || prepared.transfer(&remeshed.value, &mut Clock::default(), &mut warnings);
            let (transferred, _) = self.pool.install(transfer)?;
            Ok(Made { value: transferred.mesh, warnings })
        })
    }

    fn remeshed(&self, opened: &Opened, prepared: &Prepared) -> Result<Arc<Made<SimProduct>>, Error> {
        // Without the options that transfer alone reads.
        let (transfer_samples, seed, clean_islands, provenance) = (0, 0, false, false);
        let options = SimOptions { transfer_samples, seed, clean_islands, provenance, ..prepared.recipe.sim.clone() };
        self.memo.get(&opened.key("remesh", &options)?, || {
            let mut warnings = Warnings::default();
            let remesh = || prepared.remesh(DEFAULT_MAX_FACES, &mut Clock::default(), &mut warnings);
            let value = self.pool.install(remesh)?;
            Ok(Made { value, warnings })
        })
    }

    /// The render mesh. Each operator and each refinement is a stage, and where its points are is another.
    ///
    /// # Errors
    /// A mesh that would be too large; operators that do not fit the garment.
    pub fn render(&self, opened: &Opened, prepared: &Prepared) -> Result<Arc<Made<Garment>>, Error> {
        let stack = prepared.stack()?;
        let told: Vec<String> = stack.warnings.iter().map(ToString::to_string).collect();
        let key = opened.key("render", &(options_of(&stack), told))?;
        self.memo.get(&key, || {
            let Rendered { mesh, warnings, .. } = render(&prepared.garment, &stack, &Kept { session: self, opened })?;
            Ok(Made { value: mesh, warnings })
        })
    }

    /// The layer of a `.tailor` file as crate bytes: what the command writes for it. `content` is the composed source.
    /// With `metadata_only` the products are neither made nor in it.
    ///
    /// # Errors
    /// Faults of the source and of the recipe.
    pub fn layer(
        &self,
        document: &Document,
        content: &[u8],
        metadata_only: bool,
        warnings: &mut Warnings,
    ) -> Result<Vec<u8>, Error> {
        let opened = self.open(content, &document.source_file(), document.options())?;
        let layers = document.layers(&opened.source, warnings)?;
        warnings.extend(&opened.warnings);
        if metadata_only {
            return encode(document, &opened.source, &[], warnings);
        }
        let prepared = opened.checked.prepare(&layers)?;
        let (sim, render) = (self.sim(&opened, &prepared)?, self.render(&opened, &prepared)?);
        warnings.extend(&sim.warnings);
        warnings.extend(&render.warnings);
        let products = [
            Product { name: ProductRole::Sim.name(), role: ProductRole::Sim, mesh: &sim.value },
            Product { name: ProductRole::Render.name(), role: ProductRole::Render, mesh: &render.value },
        ];
        encode(document, &opened.source, &products, warnings)
    }
}

fn encode(
    document: &Document,
    source: &Source,
    products: &[Product],
    warnings: &mut Warnings,
) -> Result<Vec<u8>, Error> {
    let surroundings = Surroundings { folder: document.folder(), source: Some(document.source()) };
    Ok(layer_bytes(source, products, Format::Usdc, surroundings, &WriteOptions::default(), warnings)?)
}

impl Opened {
    fn key(&self, name: &'static str, options: &impl serde::Serialize) -> Result<Key, Error> {
        let options = serde_json::to_string(options)
            .map_err(|e| Error::Internal(format!("options cannot be told apart: {e}")))?;
        Ok(Key::Stage { name, source: self.serial, options })
    }
}

impl Footprint for Opened {
    fn footprint(&self) -> usize {
        // The content as key, and again as what was read of it.
        2 * self.content + garment_bytes(&self.checked.garment)
    }
}

/// The stages of a source that a session keeps. They are asked for on the caller's thread only: one that waits in the
/// pool could wait for work under itself.
struct Kept<'a> {
    session: &'a Session,
    opened: &'a Opened,
}

impl Stages for Kept<'_> {
    fn get<V: Footprint + Send + Sync + 'static>(
        &self,
        name: &'static str,
        options: &impl serde::Serialize,
        make: impl FnOnce() -> Result<V, Error> + Send,
    ) -> Result<Arc<V>, Error> {
        self.session.memo.get(&self.opened.key(name, options)?, || self.make(make))
    }

    fn make<V: Send>(&self, make: impl FnOnce() -> V + Send) -> V {
        self.session.pool.install(make)
    }
}

/// All options of a stack.
fn options_of(stack: &Stack) -> (Vec<String>, Vec<String>, u32) {
    let operators = stack.operators.iter();
    (operators.clone().map(|o| o.structure()).collect(), operators.map(|o| o.options()).collect(), stack.level)
}

/// Adjacency and rules that a level keeps for a corner. \[bytes\]
const LEVEL_CORNER: usize = 40;
/// Masks of its refinement that a level of any faces keeps for a corner. \[bytes\]
const MASKS_CORNER: usize = 90;
/// Limit rows that a level keeps for a corner. \[bytes\]
const LIMITS_CORNER: usize = 30;
/// Parents and sources that an operator keeps for a corner. \[bytes\]
const SHAPED_CORNER: usize = 60;
/// What the places of an operator's points are measured from, for a corner. \[bytes\]
const PLACING_CORNER: usize = 70;

/// Without its level, which others have too.
impl Footprint for Cage {
    fn footprint(&self) -> usize {
        garment_bytes(self.garment())
    }
}

impl Footprint for Faces {
    fn footprint(&self) -> usize {
        4 * self.corners().len()
    }
}

impl Footprint for Channels {
    fn footprint(&self) -> usize {
        self.bytes()
    }
}

impl Footprint for Level {
    fn footprint(&self) -> usize {
        LEVEL_CORNER * self.topology.faces.corners().len()
    }
}

impl Footprint for Connectivity {
    fn footprint(&self) -> usize {
        let faces = &self.level().topology.faces;
        let masks = if faces.regular_valence().is_some() { 0 } else { MASKS_CORNER };
        self.level().footprint() + (masks + LIMITS_CORNER) * faces.corners().len()
    }
}

impl Footprint for Shaped {
    fn footprint(&self) -> usize {
        let origin = &self.origin;
        let by_vertex = size_of_val(origin.clearance.as_slice());
        let by_face = origin.front.bytes() + size_of_val(origin.faces.as_slice());
        garment_bytes(&self.frame) + SHAPED_CORNER * self.frame.faces.corners().len() + by_vertex + by_face
    }
}

impl Footprint for Placing {
    fn footprint(&self) -> usize {
        PLACING_CORNER * self.corner_count()
    }
}

impl Footprint for Front {
    fn footprint(&self) -> usize {
        self.bytes()
    }
}

impl Footprint for Ground {
    fn footprint(&self) -> usize {
        self.bytes()
    }
}

impl Footprint for Made<Placed> {
    fn footprint(&self) -> usize {
        self.value.bytes()
    }
}

impl Footprint for IdVec<VertexId, Vec3> {
    fn footprint(&self) -> usize {
        size_of::<Vec3>() * self.len()
    }
}

impl Footprint for Garment {
    fn footprint(&self) -> usize {
        garment_bytes(self)
    }
}

impl Footprint for Arc<Vec<Subset>> {
    fn footprint(&self) -> usize {
        self.iter().map(subset_bytes).sum()
    }
}

impl Footprint for Made<Garment> {
    fn footprint(&self) -> usize {
        garment_bytes(&self.value)
    }
}

/// A baseline triangle's share of the refined levels, their stencils' tables and the adjacency, as measured on
/// garments of 10 to 100 thousand triangles. \[bytes\]
const BASELINE_TRIANGLE: usize = 400;
/// A triangle's share of points, places and chains. \[bytes\]
const SIM_TRIANGLE: usize = 150;

impl Footprint for Made<SimProduct> {
    fn footprint(&self) -> usize {
        let product = &self.value;
        BASELINE_TRIANGLE * product.baseline.source_face.len() + SIM_TRIANGLE * product.triangles.len()
    }
}

fn garment_bytes(garment: &Garment) -> usize {
    let primvars: usize = garment.primvars.iter().map(primvar_bytes).sum();
    12 * garment.points.len() + 4 * garment.faces.corners().len() + primvars + garment.subsets.footprint()
}

fn subset_bytes(subset: &Subset) -> usize {
    subset.elements.len() * if matches!(subset.elements, Elements::Edges(_)) { 8 } else { 4 }
}

fn primvar_bytes(primvar: &Primvar) -> usize {
    let indices = primvar.indices.as_ref().map_or(0, |indices| indices.len());
    let values = match &primvar.values {
        Values::Bool(v) => v.len(),
        Values::U8(v) => v.len(),
        Values::F64(_) | Values::I64(_) | Values::U64(_) => 8 * primvar.values.len(),
        Values::Text(texts) => texts.iter().map(|t| t.len() + size_of::<String>()).sum(),
        Values::F32(_) | Values::I32(_) | Values::U32(_) => 4 * primvar.values.len(),
    };
    4 * indices + values
}
