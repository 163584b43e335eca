//! Seams: edge sets as grooves or ridges of a width.
//!
//! ```text
//!                 left            right                 height along the normal
//!  hold | width | flank | centre | flank | width | hold
//!    o------o-------o-------*-------o-------o------o    * = normalOffset, which a cubic B-spline brings to 0 at the
//!                                                       width; with a depth the flanks are further out
//! ```
//!
//! Only the centre has a height, with a depth also the line beside it, and two lines follow to the width. All lines are
//! as far from each other, so by the masks of Catmull-Clark the limits of the flank and of the width are where their
//! lines are, and all that is outside the width is the surface as it was. Without the line that holds, the width would
//! be drawn outwards by the faces beside it, by a third of it.
//!
//! Seams that follow one another in the stack are one network: they cross, meet and share room as equals, whatever
//! their order. Left is the left-hand side of one who walks the chain with the normals up; a chain runs as most of its
//! edges were authored.

mod chains;

use super::REPORTED;
use super::kind::{Context, Instance, Key, Options};
use super::lines::{self, Lines, Narrowed, Request};
use super::placed::Room;
use super::shape::{Held, Operator, Role, Shape};
use crate::checks;
use crate::error::{EXAMPLES, Error, Warning, Warnings};
use crate::garment::{Elements, Garment, Scheme, Subset};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use crate::subdivide::Cage;
use chains::Network;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::collections::BTreeSet;

/// Lines of each side as shares of its width: on the flank, where the surface begins, and outside, to hold it there.
const LINES: [f32; 3] = [0.5, 1.0, 1.5];
/// The same with a line on the flank.
const SWOLLEN_LINES: [f32; 4] = [1.0 / 3.0, 2.0 / 3.0, 1.0, 4.0 / 3.0];
/// Width of a seam that says none, as a share of the mean edge.
const AUTOMATIC_WIDTH: f32 = 0.25;
/// Least part of the width on one side, so that at full asymmetry both lines are apart and the steep flank is not turned
/// over.
const LEAST_SIDE: f32 = 0.05;

/// Options of a seam: the attributes of `TailorSeamAPI`, with the same names and defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct SeamOptions {
    /// Names of the edge subsets that it follows.
    pub edges: Vec<String>,
    /// From one side to the other; 0: a quarter of the input's mean edge. \[stage units\]
    pub width: f32,
    /// How far the flanks swell along the normal over straight ones; larger is rounder. \[stage units\]
    pub depth: f32,
    /// How far the centre is pushed along the normal; below 0 is a groove, above a ridge. \[stage units\]
    pub normal_offset: f32,
    /// Part of the width on either side: -1 most on the left, 0 even, 1 most on the right; a twentieth stays on the other.
    pub asymmetry: f32,
}

impl SeamOptions {
    /// Widths of the left and right side. \[stage units\]
    fn sides(&self) -> [f32; 2] {
        let left = (0.5 * (1.0 - self.asymmetry)).clamp(LEAST_SIDE, 1.0 - LEAST_SIDE);
        [self.width * left, self.width * (1.0 - left)]
    }
}

impl Options for SeamOptions {
    const KIND: &'static str = "seam";
    const KEYS: &'static [Key] = &[
        Key { field: "edges", unit: "names", meaning: "edge subsets that the seam follows" },
        Key { field: "width", unit: "stage units", meaning: "from side to side; 0: a quarter of the mean edge" },
        Key { field: "depth", unit: "stage units", meaning: "how far the flanks swell over straight ones" },
        Key {
            field: "normalOffset",
            unit: "stage units",
            meaning: "height of the centre; below 0 a groove, above a ridge",
        },
        Key { field: "asymmetry", unit: "-1 to 1", meaning: "-1: all of the width on the left, 1: all on the right" },
    ];
}

impl Instance for SeamOptions {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), Error> {
        checks::named(&key("edges"), &self.edges, "edge")?;
        checks::length(&key("width"), self.width)?;
        checks::finite(&key("depth"), self.depth)?;
        checks::finite(&key("normalOffset"), self.normal_offset)?;
        if !(-1.0..=1.0).contains(&self.asymmetry) {
            let value = format!("{} is not between -1 and 1", self.asymmetry);
            return checks::fault(&key("asymmetry"), &value, "give -1 for all on the left, 1 for all on the right");
        }
        Ok(())
    }

    fn bind(&self, key: &dyn Fn(&str) -> String, garment: &Garment) -> Result<(), Error> {
        checks::subsets_are(garment, &key("edges"), &self.edges, "edge")
    }

    fn settle(&mut self, mean_edge: f32) {
        if self.width == 0.0 {
            self.width = AUTOMATIC_WIDTH * mean_edge;
        }
    }

    /// Seams in a row are one operator.
    fn stack(&self, name: &str, context: Context, operators: &mut Vec<Box<dyn Operator>>) {
        let seam = (name.to_owned(), self.clone());
        let last = operators.last_mut().and_then(|o| (o.as_mut() as &mut dyn Any).downcast_mut::<Seams>());
        match last {
            Some(seams) => seams.seams.push(seam),
            None => operators.push(Box::new(Seams::new(vec![seam], context))),
        }
    }
}

/// Seams that are made together.
pub struct Seams {
    seams: Vec<(String, SeamOptions)>,
    /// Points of the input, whose numbers are the user's.
    own_points: usize,
    names_sets: bool,
}

impl Seams {
    /// Seams by name.
    pub fn new(seams: Vec<(String, SeamOptions)>, context: Context) -> Self {
        Self { seams, own_points: context.points, names_sets: context.names_sets }
    }

    /// Lines of each side as shares of its width. Seams with swollen flanks have one more.
    fn shares(&self) -> &'static [f32] {
        if self.is_swollen() { &SWOLLEN_LINES } else { &LINES }
    }

    /// The line of the width; those before it are on the flank.
    fn width_line(&self) -> usize {
        self.shares().len() - 2
    }

    fn is_swollen(&self) -> bool {
        self.seams.iter().any(|(_, options)| options.depth != 0.0)
    }

    fn examples<T: Copy, U>(&self, of: &[T], points: impl Fn(T) -> Vec<VertexId>, name: impl Fn(T) -> U) -> Vec<U> {
        let known = |&x: &T| points(x).iter().all(|v| v.index() < self.own_points);
        of.iter().copied().filter(known).take(EXAMPLES).map(name).collect()
    }

    /// The edges of a seam on the cage, as they were authored.
    fn edges(&self, cage: &Cage, options: &SeamOptions) -> Vec<[VertexId; 2]> {
        let sets = options.edges.iter().filter_map(|name| cage.garment().subset(name));
        let edges = sets.filter_map(|set| if let Elements::Edges(edges) = &set.elements { Some(edges) } else { None });
        edges.flatten().copied().collect()
    }

    /// How far a role is from the surface, and the seam that says so.
    fn height(&self, role: &Role) -> (f32, usize) {
        match role {
            Role::Centre { instances, part } => {
                // Where seams meet, the one that goes furthest decides.
                let of = |&i: &usize| (part * self.seams[i].1.normal_offset, i);
                let further = |a: (f32, usize), b: (f32, usize)| if b.0.abs() > a.0.abs() { b } else { a };
                instances.iter().map(of).reduce(further).unwrap_or((0.0, 0))
            }
            Role::Line { line: 0, instance, part } if self.is_swollen() => {
                let options = &self.seams[*instance].1;
                (part * ((1.0 - self.shares()[0]) * options.normal_offset + options.depth), *instance)
            }
            _ => (0.0, 0),
        }
    }

    fn warn(&self, network: &Network, narrowed: &[Narrowed]) -> Warnings {
        let mut warnings = Warnings::default();
        for (instance, (name, _)) in self.seams.iter().enumerate() {
            let shared: Vec<EdgeId> = network.shared.iter().filter(|s| s.1 == instance).map(|s| s.0).collect();
            if !shared.is_empty() {
                let ends = |e: EdgeId| network.ends(e).to_vec();
                let examples = self.examples(&shared, ends, |e| network.ends(e).map(|v| v.index()));
                warnings.push(Warning::SharedSeamEdges { seam: name.clone(), count: shared.len(), examples });
            }
            let lone: Vec<EdgeId> =
                network.lone.iter().copied().filter(|&e| network.seam[e] == Some(instance)).collect();
            if !lone.is_empty() {
                let ends = |e: EdgeId| network.ends(e).to_vec();
                let examples = self.examples(&lone, ends, |e| network.ends(e).map(|v| v.index()));
                warnings.push(Warning::NoRoomToTaper { seam: name.clone(), count: lone.len(), examples });
            }
            let mut narrow: Vec<VertexId> = Vec::new();
            let mut least = 1.0f32;
            for n in narrowed.iter().filter(|n| network.seam[n.mark] == Some(instance)) {
                narrow.push(n.vertex);
                least = least.min(n.share);
            }
            narrow.sort_unstable();
            narrow.dedup();
            if !narrow.is_empty() {
                let examples = self.examples(&narrow, |v| vec![v], |v| v.index());
                warnings.push(Warning::NarrowSeam { seam: name.clone(), count: narrow.len(), examples, least });
            }
        }
        warnings
    }

    fn held(&self, t: &Topology, network: &Network, lines: &Lines) -> Vec<Held> {
        let near = lines.near.enumerated().filter(|(_, near)| **near).map(|(v, _)| v);
        let kept = near.map(|vertex| {
            let instances = network.at(t, vertex);
            if instances.is_empty() || network.tapers[vertex] {
                return Held { vertex, role: Role::Surface };
            }
            Held { vertex, role: Role::Centre { instances, part: lines.widths[vertex] } }
        });
        let on_lines = lines.vertices.iter().map(|l| {
            let instance = network.seam[l.mark].unwrap_or(0);
            let part = l.part;
            let role = match l.line {
                Some(line) => Role::Line { line, instance, part },
                None => Role::Centre { instances: vec![instance], part },
            };
            Held { vertex: l.vertex, role }
        });
        kept.chain(on_lines).collect()
    }

    /// The faces within the width of each seam.
    fn subsets(&self, cage: &Cage, network: &Network, lines: &Lines, warnings: &mut Warnings) -> Vec<Subset> {
        if !self.names_sets {
            return Vec::new();
        }
        let width = self.width_line();
        let of = |(instance, (name, _)): (usize, &(String, SeamOptions))| {
            let within = lines.strips.iter().filter(|s| s.line <= width && network.seam[s.mark] == Some(instance));
            (format!("{name}_seam"), within.map(|s| s.face).collect())
        };
        super::new_sets(cage.garment(), self.seams.iter().enumerate().map(of).collect(), warnings)
    }

    fn distances(&self, cage: &Cage, network: &Network) -> IdVec<CornerId, f32> {
        let t = &cage.level().topology;
        let is_left_handed = cage.garment().orientation == crate::garment::Orientation::LeftHanded;
        let distance = |corner: CornerId| {
            let edge = t.corner_edge[corner];
            let Some(instance) = network.seam[edge] else { return 0.0 };
            // A face is on the left of the half-edge that runs around it, seen from its front.
            let is_left = (t.faces.vertex(corner) == network.start[edge]) != is_left_handed;
            self.seams[instance].1.sides()[usize::from(!is_left)]
        };
        t.corner_edge.ids().map(distance).collect()
    }
}

impl Operator for Seams {
    fn structure(&self) -> String {
        let of = |(name, o): &(String, SeamOptions)| format!("{name:?} {:?} {} {}", o.edges, o.width, o.asymmetry);
        let seams: Vec<String> = self.seams.iter().map(of).collect();
        format!("seams {} {} {}", seams.join("; "), self.is_swollen(), self.names_sets)
    }

    fn reach(&self, _: &Garment) -> f32 {
        self.seams.iter().map(|(_, o)| o.normal_offset.abs() + o.depth.abs()).fold(0.0, f32::max)
    }

    fn options(&self) -> String {
        format!("seams {:?}", self.seams)
    }

    fn shape(&self, cage: &Cage, _: &IdVec<VertexId, Room>) -> Result<Shape, Error> {
        super::refuse_loop(cage, &format!("seam.{}", self.seams.first().map_or("", |s| &s.0)))?;
        let edges = self.seams.iter().map(|(_, options)| self.edges(cage, options)).collect::<Vec<_>>();
        let t = &cage.level().topology;
        let network = Network::new(t, &edges);
        let request = Request {
            topology: t,
            points: &cage.garment().points,
            marked: network.seam.iter().map(Option::is_some).collect(),
            distance: self.distances(cage, &network),
            tapers: network.tapers.clone(),
            cuttable: IdVec::filled(true, t.faces.len()),
            shares: self.shares(),
            kept_line: self.width_line(),
        };
        let lines = lines::insert(&request);
        let held = self.held(t, &network, &lines);
        let mut warnings = self.warn(&network, &lines.narrowed);
        let subsets = self.subsets(cage, &network, &lines, &mut warnings);
        let (corners, creases, apart) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Shape { derivation: lines.builder.finish(), held, subsets, corners, creases, apart, warnings })
    }

    fn heights(&self, shape: &Shape) -> Vec<f32> {
        shape.held.iter().map(|held| self.height(&held.role).0).collect()
    }

    fn unsound(&self, shape: &Shape, faces: &[FaceId]) -> Warning {
        let of = seams_at(shape, faces);
        let names: Vec<String> = of.iter().map(|&i| format!("seam.{}", self.seams[i].0)).collect();
        let examples = super::examples(self.own_points, shape.sources(faces));
        Warning::Unsound { operator: names.join(", "), count: faces.len(), examples }
    }

    fn reduced(&self, shape: &Shape, given: &[f32]) -> Warnings {
        let mut warnings = Warnings::default();
        let mut shallow: Vec<(usize, VertexId, f32)> = Vec::new();
        for (held, given) in shape.held.iter().zip(given) {
            let (asked, instance) = self.height(&held.role);
            if matches!(held.role, Role::Centre { .. }) && given.abs() < REPORTED * asked.abs() {
                shallow.push((instance, held.vertex, given.abs() / asked.abs()));
            }
        }
        for (instance, (name, _)) in self.seams.iter().enumerate() {
            let here = shallow.iter().filter(|s| s.0 == instance);
            let vertices: Vec<VertexId> = here.clone().map(|s| s.1).collect();
            if !vertices.is_empty() {
                let examples = self.examples(&vertices, |v| vec![v], |v| v.index());
                let (seam, least) = (name.clone(), here.map(|s| s.2).fold(1.0, f32::min));
                warnings.push(Warning::ShallowSeam { seam, count: vertices.len(), examples, least });
            }
        }
        warnings
    }
}

/// The seams at some faces, or the next ones, by their places among the instances.
fn seams_at(shape: &Shape, faces: &[FaceId]) -> BTreeSet<usize> {
    let instances = |held: &Held| match &held.role {
        Role::Centre { instances, .. } => instances.clone(),
        Role::Line { instance, .. } => vec![*instance],
        _ => Vec::new(),
    };
    let all = &shape.derivation.faces;
    let mut there: BTreeSet<VertexId> = faces.iter().flat_map(|&f| all.vertices_of(f)).copied().collect();
    loop {
        let of: BTreeSet<usize> = shape.held.iter().filter(|h| there.contains(&h.vertex)).flat_map(instances).collect();
        let touches = |f: &FaceId| all.vertices_of(*f).iter().any(|v| there.contains(v));
        let wider: BTreeSet<VertexId> = all.ids().filter(touches).flat_map(|f| all.vertices_of(f)).copied().collect();
        if !of.is_empty() || wider.len() == there.len() {
            return of;
        }
        there = wider;
    }
}

/// Whether a scheme has faces that seams can be cut into.
pub(super) fn is_supported(scheme: Scheme) -> bool {
    scheme != Scheme::Loop
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::UNBOUNDED as OPEN;
    use crate::mesh::Faces;
    use crate::subdivide::Lineage;
    use glam::Vec3;

    #[test]
    fn faults_beside_a_seam_name_the_next_one() {
        // A strip of quads with a seam across it near each end.
        let (length, at) = (12, |x: usize, y: usize| VertexId::new(2 * x + y));
        let quads = (0..length).flat_map(|x| [at(x, 0), at(x + 1, 0), at(x + 1, 1), at(x, 1)]);
        let subset = |name: &str, x: usize| Subset {
            name: name.into(),
            family: String::new(),
            elements: Elements::Edges(vec![[at(x, 0), at(x, 1)]]),
            sharpness: None,
        };
        let points = (0..=length).flat_map(|x| [0.0, 1.0].map(|y| Vec3::new(x as f32, y, 0.0)));
        let garment = Garment {
            points: points.collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            subsets: vec![subset("first", 2), subset("second", 10)].into(),
            ..Garment::default()
        };
        let seam = |name: &str| {
            (name.to_owned(), SeamOptions { edges: vec![name.to_owned()], width: 0.3, ..SeamOptions::default() })
        };
        let points = garment.points.len();
        let seams = Seams::new(vec![seam("first"), seam("second")], Context { points, names_sets: false });
        let shape = seams.shape(&Cage::new(garment), &IdVec::filled(OPEN, points)).expect("a shape");
        let name = |face: FaceId| match seams.unsound(&shape, &[face]) {
            Warning::Unsound { operator, .. } => operator,
            other => panic!("{other}"),
        };
        let middle = |f: FaceId| {
            let parents = shape.derivation.parent_face(f).index();
            (parents as f32 + 0.5) / length as f32
        };
        for face in shape.derivation.faces.ids() {
            if middle(face) < 0.4 {
                assert_eq!(name(face), "seam.first");
            } else if middle(face) > 0.6 {
                assert_eq!(name(face), "seam.second");
            } else {
                assert!(!name(face).is_empty());
            }
        }
    }
}
