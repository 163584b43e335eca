//! Meshes as binary frames: a length, a JSON header ([`MeshHeader`]) and blocks of numbers.
//!
//! A frame holds what is new since the last one of the same page. After an edit that moves points alone it is 12 bytes
//! a point.

mod channels;
mod smooth;

use crate::hub::Shown;
use crate::messages::{Block, Blocks, DrawnSet, DrawnValues, MeshHeader, NumberType, Role, Times, View};
use channels::{Channel, UV_SEAMS, channel, uv_seams, uv_set, uvs};
use smooth::Drawn;
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use tailor::report::TriangleQuality;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Elements, Mesh, Orientation, Primvar};
use tailor_mesh::subdivide::refined_faces;

/// The version of a mesh that one page has.
pub struct Sent {
    shown: Arc<Shown>,
    drawn: Drawn,
    smooth: u32,
    uv: bool,
    values: Option<String>,
}

/// The frame that brings a page up to date with a mesh; none if it is. `sent` is updated.
///
/// # Errors
/// A refinement for display that would be too large.
pub fn frame(role: Role, shown: &Arc<Shown>, view: &View, sent: &mut Option<Sent>) -> Result<Option<Vec<u8>>, Error> {
    let start = Instant::now();
    // Triangles have no subdivision surface.
    let smooth = if role == Role::Sim { 0 } else { most_smooth(&shown.mesh, view.smooth) };
    let same_mesh = |s: &&Sent| Arc::ptr_eq(&s.shown.mesh, &shown.mesh) && s.smooth == smooth;
    let drawn = match sent.as_ref().filter(same_mesh) {
        Some(sent) => sent.drawn.clone(),
        None => Drawn::new(&shown.mesh, smooth, sent.as_ref().map(|sent| &sent.drawn))?,
    };
    let now = Sent { shown: Arc::clone(shown), drawn, smooth, uv: view.uv, values: view.values.clone() };
    let frame = Update { last: sent.as_ref(), now: &now }.encode(role, start);
    *sent = Some(now);
    Ok(frame)
}

/// Refinements for display at most. \[levels\]
const MOST_SMOOTH: u32 = 2;
/// Largest mesh that is refined for display. Browsers draw larger ones slowly. \[faces\]
const MOST_FACES: usize = 500_000;

/// The refinements for display that the size of a mesh allows, at most `wanted`. \[levels\]
fn most_smooth(mesh: &Mesh, wanted: u32) -> u32 {
    let fits = |level: &u32| *level == 0 || refined_faces(mesh, *level) <= MOST_FACES;
    (0..=wanted.min(MOST_SMOOTH)).rev().find(fits).unwrap_or(0)
}

struct Update<'a> {
    last: Option<&'a Sent>,
    now: &'a Sent,
}

impl Sent {
    fn mesh(&self) -> &Mesh {
        &self.drawn.mesh
    }

    fn uvs(&self) -> Option<&Primvar> {
        uv_set(self.mesh(), &self.shown.recipe.sim.uv_set)
    }

    /// The sources of drawn values, to compare them.
    fn source(&self, name: &str) -> (Option<*const TriangleQuality>, Option<&Primvar>) {
        (self.shown.quality.get().map(Arc::as_ptr), self.mesh().primvar(name))
    }
}

impl<'a> Update<'a> {
    fn encode(&self, role: Role, start: Instant) -> Option<Vec<u8>> {
        let mut data = Data::default();
        let replaces = self.replaces();
        let mut blocks = if replaces { self.faces(&mut data) } else { Blocks::default() };
        if replaces || self.differ(|s| s.mesh().points.as_slice()) {
            blocks.points = Some(data.f32(bytemuck::cast_slice(self.now.mesh().points.as_slice())));
        }
        if replaces || self.differ(|s| s.shown.sources.as_slice()) {
            blocks.sources = Some(data.u32(self.now.shown.sources.iter().map(|face| face.index() as u32)));
        }
        let cuts_changed = self.differ(|s| s.uvs().map(|p| &p.indices));
        let sets_changed = replaces || self.differ(|s| s.mesh().subsets.as_slice()) || cuts_changed;
        let (sets, elements) = sets_changed.then(|| self.sets(role, &mut data)).unzip();
        blocks.elements = elements;
        blocks.uvs = self.uvs(replaces, &mut data);
        let (values, of_values) = self.values(replaces, &mut data).unzip();
        blocks.values = of_values.flatten();
        if data.0.is_empty() && sets.is_none() && values.is_none() {
            return None;
        }
        let shown = &self.now.shown;
        let sent = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64() * 1e3;
        let encode = start.elapsed().as_secs_f64() * 1e3;
        let header = MeshHeader {
            role,
            revision: shown.revision,
            replaces,
            left_handed: shown.mesh.orientation == Orientation::LeftHanded,
            sets,
            values,
            times: Times { build: shown.build, encode, sent },
            blocks,
        };
        Some(data.behind(&header))
    }

    /// True if the faces are new.
    fn replaces(&self) -> bool {
        self.last.is_none_or(|last| {
            let (old, new) = (last.mesh(), self.now.mesh());
            last.smooth != self.now.smooth
                || !(Arc::ptr_eq(&last.drawn.mesh, &self.now.drawn.mesh)
                    || (old.faces == new.faces && old.holes == new.holes && old.points.len() == new.points.len()))
        })
    }

    fn differ<T: PartialEq>(&self, part: impl Fn(&'a Sent) -> T) -> bool {
        self.last.is_none_or(|last| part(last) != part(self.now))
    }

    fn faces(&self, data: &mut Data) -> Blocks {
        let mesh = self.now.mesh();
        let origin = self.now.drawn.origin.as_ref();
        Blocks {
            face_counts: Some(data.u32(mesh.faces.ids().map(|face| mesh.faces.valence(face) as u32))),
            face_points: Some(data.u32(mesh.faces.corners().iter().map(|v| v.index() as u32))),
            holes: Some(data.u32(mesh.holes.iter().map(|face| face.index() as u32))),
            edges: origin.map(|origin| data.u8(&origin.edges)),
            face_of: origin.map(|origin| data.u32(origin.face_of.iter().copied())),
            ..Blocks::default()
        }
    }

    /// All sets in one block. The seams of the UV set come first, so that named sets are drawn over them.
    fn sets(&self, role: Role, data: &mut Data) -> (Vec<DrawnSet<'a>>, Block) {
        let mesh = self.now.mesh();
        let cuts = match self.now.uvs() {
            // The simulation mesh has its own set of seams.
            Some(primvar) if role != Role::Sim => uv_seams(mesh, primvar),
            _ => Vec::new(),
        };
        let mut numbers = Vec::<u32>::new();
        let mut drawn = |name: &'a str, family: &'a str, elements: &Elements| {
            let offset = numbers.len();
            match elements {
                Elements::Faces(faces) => numbers.extend(faces.iter().map(|face| face.index() as u32)),
                Elements::Points(points) => numbers.extend(points.iter().map(|point| point.index() as u32)),
                Elements::Edges(edges) => numbers.extend(edges.iter().flatten().map(|end| end.index() as u32)),
            }
            DrawnSet { name, kind: elements.into(), family, offset, length: numbers.len() - offset }
        };
        let cuts = (!cuts.is_empty()).then(|| drawn(UV_SEAMS, "", &Elements::Edges(cuts)));
        let named = mesh.subsets.iter().map(|set| drawn(&set.name, &set.family, &set.elements));
        let sets = cuts.into_iter().chain(named).collect();
        (sets, data.u32(numbers.into_iter()))
    }

    fn uvs(&self, replaces: bool, data: &mut Data) -> Option<Block> {
        let is_known = self.last.is_some_and(|last| last.uv) && !replaces && !self.differ(Sent::uvs);
        if !self.now.uv || is_known {
            return None;
        }
        let corners = self.now.mesh().faces.corners().len();
        Some(data.f32(&self.now.uvs().map_or(Vec::new(), |primvar| uvs(primvar, corners))))
    }

    /// The values that are drawn, if they are new; the inner options are empty if the mesh has none of that name.
    fn values(&self, replaces: bool, data: &mut Data) -> Option<(Option<DrawnValues<'a>>, Option<Block>)> {
        let name = self.now.values.as_ref()?;
        let is_known = |last: &Sent| last.values.as_ref() == Some(name) && last.source(name) == self.now.source(name);
        if !replaces && self.last.is_some_and(is_known) {
            return None;
        }
        let quality: Option<&TriangleQuality> = self.now.shown.quality.get().map(|quality| &**quality);
        let Some(Channel { of, values }) = channel(self.now.mesh(), quality, name) else { return Some((None, None)) };
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let (least, most) = (finite().fold(f32::MAX, f32::min), finite().fold(f32::MIN, f32::max));
        let (least, most) = if least <= most { (least, most) } else { (0.0, 1.0) };
        Some((Some(DrawnValues { name, of, least, most }), Some(data.f32(&values))))
    }
}

/// The blocks of a frame as bytes.
#[derive(Default)]
struct Data(Vec<u8>);

impl Data {
    fn add(&mut self, number: NumberType, bytes: &[u8], length: usize) -> Block {
        let offset = self.0.len();
        self.0.extend_from_slice(bytes);
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        Block { number, offset, length }
    }

    fn u8(&mut self, numbers: &[u8]) -> Block {
        self.add(NumberType::U8, numbers, numbers.len())
    }

    fn f32(&mut self, numbers: &[f32]) -> Block {
        self.add(NumberType::F32, bytemuck::cast_slice(numbers), numbers.len())
    }

    fn u32(&mut self, numbers: impl Iterator<Item = u32>) -> Block {
        let numbers: Vec<u32> = numbers.collect();
        self.add(NumberType::U32, bytemuck::cast_slice(&numbers), numbers.len())
    }

    /// The frame.
    fn behind(&self, header: &MeshHeader) -> Vec<u8> {
        let mut header = serde_json::to_vec(header).unwrap_or_default();
        header.resize(header.len().next_multiple_of(4), b' ');
        let mut frame = Vec::with_capacity(4 + header.len() + self.0.len());
        frame.extend_from_slice(&(header.len() as u32).to_le_bytes());
        frame.extend_from_slice(&header);
        frame.extend_from_slice(&self.0);
        frame
    }
}
