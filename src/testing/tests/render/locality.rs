//! An edit of a seam stays where it is made: what is farther from the seam than its width, and from its junctions than an
//! edge more, does not move.

use super::cloth::limit;
use super::on_garments::{load, load_named, parents};
use super::referee::{LimitPatches, edges_in, plain, segments};
use crate::nearest::Nearest;
use crate::operators::stack;
use glam::Vec3;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;
use tailor::pipeline::mean_edge_length;
use tailor::render::RenderSteps;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::garment::{Elements, Mesh};

/// Largest move of a point. \[mean edges\]
const MOST: f32 = 0.002;
/// Width and height of all seams before an edit. \[mean edges\]
const WIDTH: f32 = 0.15;
const OFFSET: f32 = -0.03;

/// An option of a seam and its value, in mean edges where it is a length.
#[derive(Clone, Copy, Debug)]
enum Edit {
    Width(f32),
    Offset(f32),
    Depth(f32),
    Asymmetry(f32),
}

const EDITS: [Edit; 4] = [Edit::Width(1.3 * WIDTH), Edit::Offset(-0.05), Edit::Depth(0.05), Edit::Asymmetry(0.4)];

impl Edit {
    fn option(self, seam: &str, edge: f32) -> String {
        let (key, value) = match self {
            Self::Width(width) => ("width", width * edge),
            Self::Offset(offset) => ("normalOffset", offset * edge),
            Self::Depth(depth) => ("depth", depth * edge),
            Self::Asymmetry(share) => ("asymmetry", share),
        };
        format!("seam.{seam}.{key}={value}")
    }

    /// The larger of the widths before and after. \[mean edges\]
    fn width(self) -> f32 {
        if let Self::Width(width) = self { width.max(WIDTH) } else { WIDTH }
    }
}

fn edge_sets(garment: &Mesh) -> Vec<String> {
    let of_edges = garment.subsets.iter().filter(|s| matches!(s.elements, Elements::Edges(_)));
    of_edges.map(|s| s.name.clone()).collect()
}

/// A seam along each edge set.
fn all_seams(sets: &[String], edge: f32) -> Vec<String> {
    let own = |set: &String| {
        let [width, offset] = [Edit::Width(WIDTH), Edit::Offset(OFFSET)].map(|edit| edit.option(set, edge));
        [format!("seam.{set}.edges={set}"), width, offset]
    };
    sets.iter().flat_map(own).chain(["render.level=2".to_owned()]).collect()
}

/// Where an edit of a seam may move points: beside its curves, and around its junctions.
struct Reach {
    curves: Nearest,
    /// Where it meets others or itself; none where it meets nothing.
    junctions: Option<Nearest>,
    edge: f32,
}

impl Reach {
    fn new(garment: &Mesh, fine: &Mesh, sets: &[String], own: &str) -> Self {
        let mut meets: BTreeMap<VertexId, usize> = BTreeMap::new();
        let own_edges = edges_in(garment, own);
        own_edges.iter().flatten().for_each(|&v| *meets.entry(v).or_default() += 1);
        let others = sets.iter().filter(|set| *set != own);
        let others: HashSet<VertexId> = others.flat_map(|set| edges_in(garment, set)).flatten().collect();
        let places = limit(garment);
        let is_junction = |&(&v, &count): &(&VertexId, &usize)| count > 2 || others.contains(&v);
        let junctions: Vec<[Vec3; 3]> = meets.iter().filter(is_junction).map(|(&v, _)| [places[v]; 3]).collect();
        Self {
            curves: segments(&edges_in(fine, own), &limit(fine)),
            junctions: (!junctions.is_empty()).then(|| Nearest::new(junctions)),
            edge: mean_edge_length(garment),
        }
    }

    /// Whether a seam of some width, in mean edges, is farther from a point than it may reach.
    fn is_beyond(&self, p: Vec3, width: f32) -> bool {
        let from_junction = self.junctions.as_ref().map_or(f32::MAX, |junctions| junctions.find(p).1);
        self.curves.find(p).1 > width * self.edge && from_junction > (width + 1.0) * self.edge
    }
}

/// A render mesh with its limit points, which are known by all of their bits.
struct Product {
    mesh: Arc<Mesh>,
    places: IdVec<VertexId, Vec3>,
    known: HashSet<[u32; 3]>,
}

fn bits(p: Vec3) -> [u32; 3] {
    p.to_array().map(f32::to_bits)
}

impl Product {
    fn new(mesh: &Arc<Mesh>) -> Self {
        let places = limit(mesh);
        Self { mesh: Arc::clone(mesh), known: places.iter().map(|&p| bits(p)).collect(), places }
    }

    /// Its limit surface. Its own faces are fine enough for patches where they are quads.
    fn surface(&self) -> LimitPatches {
        let has_others = self.mesh.faces.ids().any(|f| self.mesh.faces.valence(f) != 4);
        LimitPatches::new(&self.mesh, u32::from(has_others))
    }

    /// Points that are on none of another product, and where an edit may not reach.
    fn moved(&self, from: &Self, is_beyond: impl Fn(Vec3) -> bool) -> Vec<(VertexId, Vec3)> {
        let all = self.places.enumerated().map(|(v, &p)| (v, p));
        all.filter(|&(_, p)| !from.known.contains(&bits(p)) && is_beyond(p)).collect()
    }

    /// The worst of some of its points off a surface, told, if it is off by more than it may be.
    fn complaint(&self, points: &[(VertexId, Vec3)], surface: &LimitPatches, reach: &Reach) -> Option<String> {
        let measured = points.iter().map(|&(v, p)| (surface.foot(p).off / reach.edge, v, p));
        let off: Vec<_> = measured.filter(|&(off, ..)| off >= MOST).collect();
        let &(worst, vertex, p) = off.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let face = self.mesh.faces.ids().find(|&f| self.mesh.faces.vertices_of(f).contains(&vertex))?;
        let (parent, from_seam) = (parents(&self.mesh)[face.index()], reach.curves.find(p).1 / reach.edge);
        let count = off.len();
        Some(format!("{count} points move, {worst:.4} edges at {p}, {from_seam:.2} from the seam, input face {parent}"))
    }
}

/// Where edits of each seam of a garment move the rest of its render mesh.
fn complaints(name: &str, garment: &Mesh) -> Vec<String> {
    let (sets, edge, fine) = (edge_sets(garment), mean_edge_length(garment), plain(garment, 3));
    let mut steps = RenderSteps::new(Arc::new(garment.clone()));
    let mut render =
        |options: &[String]| steps.update(&stack(options)).unwrap_or_else(|e| panic!("{name}, {options:?}: {e}")).mesh;
    let options = all_seams(&sets, edge);
    let before = Product::new(&render(&options));
    let surface = before.surface();
    let (mut complaints, mut effects) = (Vec::new(), 0);
    // Each fourth of the sets, unless all tests run.
    let step = if std::env::var_os("TAILOR_TEST_ALL").is_some() { 1 } else { 4 };
    let edited_sets = sets.iter().step_by(step);
    for set in edited_sets.clone() {
        let reach = Reach::new(garment, &fine, &sets, set);
        for edit in EDITS {
            let edited = [&options[..], &[edit.option(set, edge)]].concat();
            let after = Product::new(&render(&edited));
            effects += usize::from(after.known != before.known);
            let is_beyond = |p| reach.is_beyond(p, edit.width());
            let told = after.complaint(&after.moved(&before, is_beyond), &surface, &reach);
            complaints.extend(told.map(|told| format!("{name}, {set}, {edit:?}: {told}")));
            if !matches!(edit, Edit::Depth(_)) {
                continue;
            }
            // Lines come with a depth and go with it, so what was there before is compared too.
            let gone = before.moved(&after, is_beyond);
            if !gone.is_empty() {
                let told = before.complaint(&gone, &after.surface(), &reach);
                complaints.extend(told.map(|told| format!("{name}, {set}, {edit:?} back to 0: {told}")));
            }
            assert_eq!(render(&options).points, before.mesh.points, "{name}, {set}: not as before after {edit:?}");
        }
    }
    let count = edited_sets.len();
    assert!(effects > 2 * count, "{name}: {effects} edits of {count} sets do anything");
    complaints
}

/// The garments in layers, and their edits that move something further away, where repair decides anew. A number here may only be
/// lowered.
const LAYERED: [(&str, usize); 2] = [("layered_suit.usdc", 0), ("male_worksuit01.usdc", 10)];

fn check(name: &str, garment: &Mesh, known: usize) {
    let complaints = complaints(name, garment);
    assert!(complaints.len() <= known, "{} edits\n{}", complaints.len(), complaints.join("\n"));
}

#[test]
fn an_edit_of_a_seam_of_the_coat_stays_beside_it() {
    check("coat.usda", &load_named("coat.usda"), 12);
}

#[test]
fn an_edit_of_a_seam_of_layered_garments_stays_beside_it() {
    for (name, garment) in load() {
        let known = LAYERED.iter().find(|(file, _)| *file == name);
        known.into_iter().for_each(|(_, known)| check(&name, &garment, *known));
    }
}
