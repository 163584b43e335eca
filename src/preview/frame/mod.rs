//! Meshes as binary frames: a length, a JSON header and blocks of numbers (`page/src/server/protocol.ts` describes them).
//!
//! A frame holds what is new since the last one of the same page. After an edit that moves points alone it is 12 bytes
//! a point.

mod channels;
mod smooth;

use crate::error::Error;
use crate::garment::{Elements, Garment, Orientation, Primvar, Subset};
use crate::preview::hub::Shown;
use crate::preview::messages::{Role, View};
use crate::report::TriangleQuality;
use crate::subdivide::refined_faces;
use channels::{UV_SEAMS, channel, uv_seams, uv_set, uvs};
use serde_json::{Map, Value, json};
use smooth::Drawn;
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

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
fn most_smooth(mesh: &Garment, wanted: u32) -> u32 {
    let fits = |level: &u32| *level == 0 || refined_faces(mesh, *level) <= MOST_FACES;
    (0..=wanted.min(MOST_SMOOTH)).rev().find(fits).unwrap_or(0)
}

struct Update<'a> {
    last: Option<&'a Sent>,
    now: &'a Sent,
}

impl Sent {
    fn mesh(&self) -> &Garment {
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

impl Update<'_> {
    fn encode(&self, role: Role, start: Instant) -> Option<Vec<u8>> {
        let mut blocks = Blocks::default();
        let mut header = Map::new();
        let replaces = self.replaces();
        if replaces {
            self.faces(&mut blocks);
        }
        if replaces || self.differ(|s| s.mesh().points.as_slice()) {
            let points: &[f32] = bytemuck::cast_slice(self.now.mesh().points.as_slice());
            blocks.add("points", "f32", bytemuck::cast_slice(points), points.len());
        }
        let cuts_changed = self.differ(|s| s.uvs().map(|p| &p.indices));
        if replaces || self.differ(|s| s.mesh().subsets.as_slice()) || cuts_changed {
            header.insert("sets".into(), self.sets(role, &mut blocks));
        }
        self.uvs(replaces, &mut blocks);
        self.values(replaces, &mut blocks, &mut header);
        if blocks.data.is_empty() && header.is_empty() {
            return None;
        }
        let shown = &self.now.shown;
        let sent = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64() * 1e3;
        let encode = start.elapsed().as_secs_f64() * 1e3;
        header.extend([
            ("type".to_owned(), json!("mesh")),
            ("role".to_owned(), json!(role)),
            ("revision".to_owned(), json!(shown.revision)),
            ("replaces".to_owned(), json!(replaces)),
            ("leftHanded".to_owned(), json!(shown.mesh.orientation == Orientation::LeftHanded)),
            ("times".to_owned(), json!({"build": shown.build, "encode": encode, "sent": sent})),
        ]);
        Some(blocks.finish(header))
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

    fn differ<'a, T: PartialEq>(&'a self, part: impl Fn(&'a Sent) -> T) -> bool {
        self.last.is_none_or(|last| part(last) != part(self.now))
    }

    fn faces(&self, blocks: &mut Blocks) {
        let mesh = self.now.mesh();
        blocks.add_u32("faceCounts", mesh.faces.ids().map(|face| mesh.faces.valence(face) as u32));
        blocks.add_u32("facePoints", mesh.faces.corners().iter().map(|v| v.index() as u32));
        blocks.add_u32("holes", mesh.holes.iter().map(|face| face.index() as u32));
        if let Some(origin) = &self.now.drawn.origin {
            blocks.add("edges", "u8", &origin.edges, origin.edges.len());
            blocks.add_u32("faceOf", origin.face_of.iter().copied());
        }
    }

    /// All sets in one block. The seams of the UV set come first, so that named sets are drawn over them.
    fn sets(&self, role: Role, blocks: &mut Blocks) -> Value {
        let mesh = self.now.mesh();
        let cuts = match self.now.uvs() {
            // The simulation mesh has its own set of seams.
            Some(primvar) if role != Role::Sim => uv_seams(mesh, primvar),
            _ => Vec::new(),
        };
        let cuts = (!cuts.is_empty()).then(|| Subset {
            name: UV_SEAMS.into(),
            elements: Elements::Edges(cuts),
            family: String::new(),
            sharpness: None,
        });
        let (mut sets, mut numbers) = (Vec::new(), Vec::<u32>::new());
        for set in cuts.iter().chain(mesh.subsets.iter()) {
            let offset = numbers.len();
            match &set.elements {
                Elements::Faces(faces) => numbers.extend(faces.iter().map(|face| face.index() as u32)),
                Elements::Points(points) => numbers.extend(points.iter().map(|point| point.index() as u32)),
                Elements::Edges(edges) => numbers.extend(edges.iter().flatten().map(|end| end.index() as u32)),
            }
            sets.push(json!({
                "name": set.name, "kind": set.elements.kind(), "family": set.family,
                "offset": offset, "length": numbers.len() - offset,
            }));
        }
        blocks.add_u32("elements", numbers.into_iter());
        Value::Array(sets)
    }

    fn uvs(&self, replaces: bool, blocks: &mut Blocks) {
        if !self.now.uv {
            return;
        }
        let is_known = self.last.is_some_and(|last| last.uv) && !replaces && !self.differ(Sent::uvs);
        if !is_known {
            let corners = self.now.mesh().faces.corners().len();
            let values = self.now.uvs().map_or(Vec::new(), |primvar| uvs(primvar, corners));
            blocks.add("uvs", "f32", bytemuck::cast_slice(&values), values.len());
        }
    }

    fn values(&self, replaces: bool, blocks: &mut Blocks, header: &mut Map<String, Value>) {
        let Some(name) = &self.now.values else { return };
        let is_known = |last: &Sent| last.values.as_ref() == Some(name) && last.source(name) == self.now.source(name);
        if !replaces && self.last.is_some_and(is_known) {
            return;
        }
        let quality: Option<&TriangleQuality> = self.now.shown.quality.get().map(|quality| &**quality);
        let Some(channel) = channel(self.now.mesh(), quality, name) else {
            header.insert("values".into(), Value::Null);
            return;
        };
        let finite = || channel.values.iter().copied().filter(|v| v.is_finite());
        let (least, most) = (finite().fold(f32::MAX, f32::min), finite().fold(f32::MIN, f32::max));
        let (least, most) = if least <= most { (least, most) } else { (0.0, 1.0) };
        header.insert("values".into(), json!({"name": name, "of": channel.of, "least": least, "most": most}));
        blocks.add("values", "f32", bytemuck::cast_slice(&channel.values), channel.values.len());
    }
}

/// The blocks of a frame.
#[derive(Default)]
struct Blocks {
    index: Map<String, Value>,
    data: Vec<u8>,
}

impl Blocks {
    fn add(&mut self, name: &str, kind: &str, bytes: &[u8], length: usize) {
        self.index.insert(name.into(), json!({"type": kind, "offset": self.data.len(), "length": length}));
        self.data.extend_from_slice(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
    }

    fn add_u32(&mut self, name: &str, numbers: impl Iterator<Item = u32>) {
        let numbers: Vec<u32> = numbers.collect();
        self.add(name, "u32", bytemuck::cast_slice(&numbers), numbers.len());
    }

    fn finish(self, mut header: Map<String, Value>) -> Vec<u8> {
        header.insert("blocks".into(), Value::Object(self.index));
        let mut header = Value::Object(header).to_string().into_bytes();
        header.resize(header.len().next_multiple_of(4), b' ');
        let mut frame = Vec::with_capacity(4 + header.len() + self.data.len());
        frame.extend_from_slice(&(header.len() as u32).to_le_bytes());
        frame.extend_from_slice(&header);
        frame.extend_from_slice(&self.data);
        frame
    }
}
