//! Builds many sources in one process within a memory bound, for the OpenUSD plugin.
//!
//! A [`Session`] keeps a [`Builder`] for each recent source, so an edit recomputes only the steps that depend on it.

mod document;
mod fitted;
mod input;

pub use document::PayloadRecipe;
pub use fitted::{FitWay, fit_options};
pub use input::{Input, OpenGarment, beside, is_usd};

use crate::{
    Format, LodSchema, Product, ProductNames, ProductRole, ReadOptions, Source, Surroundings, WriteOptions, layer_bytes,
};
use document::ignored;
use fitted::follow_body;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tailor_costume::fit::BodyOptions;
use tailor_costume::pipeline::{Builder, Products, RenderPanel};
use tailor_costume::recipe::{Layers, Recipe};
use tailor_costume::trim::TrimOptions;
use tailor_mesh::error::{Error, ErrorKind, Warnings};

/// A bounded cache of builders, which evicts the least recently used source first.
///
/// All methods are thread-safe. A source is read once, and its builds run one at a time.
pub struct Session {
    /// The most recently used source is last.
    kept: Mutex<Vec<Kept>>,
    /// Bound of the total memory. \[bytes\]
    capacity: usize,
    /// Threads of the builds, separate from the caller's.
    pool: ThreadPool,
}

/// A source: its content and read options. The file is included because messages name it.
struct Entry {
    content: Arc<[u8]>,
    file: PathBuf,
    options: ReadOptions,
    /// `None` until the source is read.
    opened: Mutex<Option<Read>>,
}

/// A cached source.
struct Kept {
    entry: Arc<Entry>,
    /// Estimated memory after the last use. \[bytes\]
    bytes: usize,
}

/// A source and its products; none where its metadata suffices.
type Updated = (Arc<Source>, Option<Products>);

/// A source that was read, on the body that the last recipe named.
struct Read {
    source: Source,
    body: BodyOptions,
    /// The trims of the last recipe with a body.
    trims: BTreeMap<String, TrimOptions>,
    on_body: Arc<Source>,
    builder: Builder,
}

impl Read {
    fn new(source: Source) -> Result<Self, Error> {
        let (mesh, warnings) = source.garment()?;
        let builder = Builder::new(mesh)?.with_warnings(warnings);
        let (body, trims) = (BodyOptions::default(), BTreeMap::new());
        Ok(Self { on_body: Arc::new(source.clone()), source, body, trims, builder })
    }

    /// Builds the recipe, on the body that it names.
    fn update(&mut self, recipe: &Recipe, time: Option<f64>) -> Result<Products, Error> {
        if recipe.fit != self.body || (!recipe.fit.to.is_empty() && recipe.trim != self.trims) {
            let mut on_body = self.source.clone();
            let (mut mesh, mut warnings) = self.source.garment()?;
            warnings.extend(follow_body(&mut on_body, &mut mesh, recipe, time)?.1);
            let builder = Builder::new(mesh)?.with_warnings(warnings);
            self.on_body = Arc::new(on_body);
            (self.body, self.trims, self.builder) = (recipe.fit.clone(), recipe.trim.clone(), builder);
        }
        self.builder.update(recipe)
    }
}

impl Session {
    /// A session that caches at most `capacity` bytes and builds on `threads` threads; `None` is one for each core.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(capacity: usize, threads: Option<usize>) -> Result<Self, Error> {
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
        let pool = pool.map_err(|e| Error::internal(format!("cannot start threads: {e}")))?;
        Ok(Self { kept: Mutex::default(), capacity, pool })
    }

    /// Estimated memory of all cached results. \[bytes\]
    pub fn memory(&self) -> usize {
        lock(&self.kept).iter().map(|kept| kept.bytes).sum()
    }

    /// The layer of a `.tailor` file as crate (`.usdc`) bytes, equal to that of `usdtailor build`, with the warnings of the build.
    ///
    /// `content` is the composed source. With `metadata_only`, the products are neither built nor written.
    ///
    /// # Errors
    /// Errors in the source or the recipe.
    pub fn layer(
        &self,
        document: &PayloadRecipe,
        content: &[u8],
        metadata_only: bool,
    ) -> Result<(Vec<u8>, Warnings), Error> {
        let entry = self.entry(document, content);
        let mut opened = lock(&entry.opened);
        let result = self.update(&mut opened, document, &entry, metadata_only);
        let bytes = opened.as_ref().map_or(0, |opened| 2 * content.len() + opened.builder.bytes());
        drop(opened);
        self.note(&entry, bytes);
        let ((source, meshes), mut warnings) = result?;
        let levels = meshes.as_ref().map_or(1, |products| products.recipe.lod.levels);
        let names = ProductNames::new("sim", "render").with_levels(levels, LodSchema::default());
        let products = meshes.as_ref().map_or_else(Vec::new, |products| written(products, &[], &names));
        let surroundings = Surroundings { folder: document.folder(), source: Some(document.source()) };
        let options = WriteOptions::default();
        let bytes = warnings.absorb(layer_bytes(&source, &products, Format::Usdc, surroundings, &options)?);
        Ok((bytes, warnings))
    }

    fn update(
        &self,
        opened: &mut Option<Read>,
        document: &PayloadRecipe,
        entry: &Entry,
        metadata_only: bool,
    ) -> Result<(Updated, Warnings), Error> {
        let opened = match opened {
            Some(opened) => opened,
            None => opened.insert(self.open(entry)?),
        };
        let (layers, mut warnings) = document.layers(&opened.source)?;
        let arguments = warnings.absorb(document.arguments());
        if metadata_only {
            warnings.extend(opened.builder.warnings().iter().cloned());
            return Ok(((Arc::clone(&opened.on_body), None), warnings));
        }
        let time = document.options().time;
        let products = warnings.absorb(self.pool.install(|| products(opened, &layers, arguments, time))?);
        warnings.extend(products.warnings.iter().cloned());
        Ok(((Arc::clone(&opened.on_body), Some(products)), warnings))
    }

    fn open(&self, entry: &Entry) -> Result<Read, Error> {
        let source = Source::from_layer(Arc::clone(&entry.content), &entry.file, &entry.options)?;
        self.pool.install(|| Read::new(source))
    }

    /// The cache entry of a source, now the most recently used. The content is copied only for a new one.
    fn entry(&self, document: &PayloadRecipe, content: &[u8]) -> Arc<Entry> {
        let (file, options) = (document.source_file(), document.options());
        let is_same = |e: &Entry| e.file == file && e.options == *options && *e.content == *content;
        let mut kept = lock(&self.kept);
        let found = match kept.iter().position(|k| is_same(&k.entry)) {
            Some(at) => kept.remove(at),
            None => {
                let (content, options) = (content.into(), options.clone());
                Kept { entry: Arc::new(Entry { content, file, options, opened: Mutex::default() }), bytes: 0 }
            }
        };
        let entry = Arc::clone(&found.entry);
        kept.push(found);
        entry
    }

    /// Records the memory of a source and evicts the least recently used ones while the total exceeds the capacity.
    ///
    /// Zero bytes mean that the source could not be read; its entry is removed.
    fn note(&self, entry: &Arc<Entry>, bytes: usize) {
        let mut kept = lock(&self.kept);
        let is_own = |k: &Kept| Arc::ptr_eq(&k.entry, entry);
        kept.iter_mut().filter(|k| is_own(k)).for_each(|k| k.bytes = bytes);
        kept.retain(|k| bytes > 0 || !is_own(k));
        let mut total: usize = kept.iter().map(|k| k.bytes).sum();
        kept.retain(|k| {
            let stays = total <= self.capacity;
            total -= if stays { 0 } else { k.bytes };
            stays
        });
    }
}

/// The products of the options in `layers` and of stronger `arguments`. An argument that no recipe can have is left out with a
/// warning, so that the garment stays while its user mends the value.
fn products(
    opened: &mut Read,
    layers: &Layers,
    mut arguments: Layers,
    time: Option<f64>,
) -> Result<(Products, Warnings), Error> {
    let mut warnings = Warnings::default();
    loop {
        let mut all = layers.clone();
        all.add(arguments.clone().into_map());
        all.convert_lengths(opened.builder.garment().units);
        let result = all.recipe_for(opened.builder.garment()).and_then(|recipe| opened.update(&recipe, time));
        match result {
            Err(error) if error.kind == ErrorKind::Recipe && !arguments.is_empty() => {
                warnings.push(ignored(&error));
                // An error of another option may still come from them.
                if !error.faults.iter().any(|fault| arguments.remove(&fault.place)) {
                    arguments = Layers::default();
                }
            }
            result => return Ok((result?, warnings)),
        }
    }
}

/// The products of an update as [`write`](crate::write) takes them, under the names of their prims: at each level of detail with
/// the parts of its render mesh in its place, if there are some.
pub fn written<'a>(
    products: &'a Products,
    panels: &'a [Vec<RenderPanel>],
    names: &'a ProductNames,
) -> Vec<Product<'a>> {
    let levels = products.all_levels().zip(std::iter::once(names).chain(&names.levels));
    let of_level = |(level, (of, names)): (u32, (&'a Products, &'a ProductNames))| {
        let panels = panels.get(level as usize).map_or(&[][..], Vec::as_slice);
        let scale = products.recipe.lod.scale(level);
        level_products(of, panels, names).into_iter().map(move |product| Product { level, scale, ..product })
    };
    (0..).zip(levels).flat_map(of_level).collect()
}

fn level_products<'a>(products: &'a Products, panels: &'a [RenderPanel], names: &'a ProductNames) -> Vec<Product<'a>> {
    let cloth = products.cloth.as_deref();
    let sim = Product::new(&names.sim, ProductRole::Sim, &products.sim);
    let trims = Some(&products.recipe.trim);
    let sim =
        Product { cloth, cage_binding: Some(&products.cage_binding), trims, stitches: Some(&products.stitches), ..sim };
    let whole = (None, &*products.render, &*products.binding, &products.level_bindings);
    let of_panel = |(i, panel): (usize, &'a RenderPanel)| (Some(i), &panel.mesh, &panel.binding, &panel.level_bindings);
    let meshes: Vec<_> =
        if panels.is_empty() { vec![whole] } else { panels.iter().enumerate().map(of_panel).collect() };
    let renders = names.render.iter().zip(meshes).map(|(name, (panel, mesh, binding, level_bindings))| {
        let render = Product::new(name, ProductRole::Render, mesh);
        Product { panel, cloth, binding: Some(binding), level_bindings, ..render }
    });
    std::iter::once(sim).chain(renders).collect()
}

/// Locks a mutex even after a panic, as build steps keep a builder consistent at every point.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
