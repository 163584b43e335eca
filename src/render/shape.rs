//! An operator: what it makes of the cage's connectivity, and where the new surface is to be.
//!
//! The two are apart, so that an edit that only moves points repeats only the second.

use super::derivation::{Derivation, Table};
use super::front::Front;
use super::placed::{Placed, Room, least};
use super::settle::{Raise, Settling, graded, unfolded};
use super::sound::{Kin, LEAST_SHARE, OPEN, States, order, sound};
use super::surface::{Surface, limit_rows};
use crate::error::{Error, Warning, Warnings};
use crate::garment::{Garment, Orientation, Subset};
use crate::mesh::{CornerId, Csr, FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, INFINITE_SHARPNESS, Level, Lineage, carried_points};
use glam::Vec3;
use rayon::prelude::*;
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A step of the stack. Every operator is one type with this trait.
pub trait Operator: Any + Sync + Send {
    /// The options on which [`Operator::shape`] depends, as text.
    fn structure(&self) -> String;

    /// The furthest that it goes from the surface of a garment. \[stage units\]
    fn reach(&self, garment: &Garment) -> f32;

    /// All options, as text.
    fn options(&self) -> String;

    /// The new connectivity and the vertices whose place on the surface is held. `clearance` is the room that the input
    /// leaves about each vertex; where it is more than the operator's reach it may be any.
    ///
    /// # Errors
    /// Options that do not fit the cage.
    fn shape(&self, cage: &Cage, clearance: &IdVec<VertexId, Room>) -> Result<Shape, Error>;

    /// How far from the parent's surface each role of the shape is, along the normal. \[stage units\]
    fn heights(&self, shape: &Shape) -> Vec<f32>;

    /// What to say of the heights that were given, where they are less than asked.
    fn reduced(&self, shape: &Shape, given: &[f32]) -> Warnings;

    /// What to say of faces that cross others or are turned over in spite of that.
    fn unsound(&self, shape: &Shape, faces: &[FaceId]) -> Warning;
}

/// What a held vertex is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// On the surface as it was.
    Surface,
    /// On a border that is folded: where it was.
    Fold,
    /// On a marked edge.
    Centre {
        /// The instances of the operator there.
        instances: Vec<usize>,
        /// The part of the height that it has: 1, less where its end is near or where there is no room for its width.
        part: f32,
    },
    /// On a line.
    Line {
        /// Number of the line, from 0 nearest to the marked edge.
        line: usize,
        /// The instance of the operator.
        instance: usize,
        /// The part of the height that it has: 1, less where its end is near or where there is no room for its width.
        part: f32,
    },
    /// On the second layer.
    Layer {
        /// The vertex that it is a copy of.
        over: VertexId,
        /// The painted weight.
        weight: f32,
        /// 1 before the surface, -1 behind it.
        side: f32,
    },
}

/// A vertex that is held, before its height is known.
#[derive(Clone, Debug)]
pub struct Held {
    /// The vertex.
    pub vertex: VertexId,
    /// What it is for.
    pub role: Role,
}

/// Part of the room that is left which an operator may take, so that later ones have some too.
const PART_OF_ROOM: f32 = 0.5;
/// Part of the distance of two layers that a later operator may take on either.
const PART_BETWEEN: f32 = 0.8;
/// Heights below which another layer is near: it may be raised too, and the limit surface is not quite where it was. Less
/// misses some that cross, and more looks at more faces and finds no others.
const NEAR: f32 = 3.0;

/// What an operator makes of a cage, but for the places of the points.
pub struct Shape {
    /// The connectivity.
    pub derivation: Derivation,
    /// The vertices that are held.
    pub held: Vec<Held>,
    /// Sets of new faces.
    pub subsets: Vec<Subset>,
    /// Vertices that become infinitely sharp.
    pub corners: Vec<VertexId>,
    /// Edges that become infinitely sharp.
    pub creases: Vec<[VertexId; 2]>,
    /// New vertices that coincide with others until they are held, moved apart so that later operators can measure.
    pub apart: Vec<(VertexId, Vec3)>,
    /// What was met on the way.
    pub warnings: Warnings,
}

impl Shape {
    /// The place of each vertex among those held for a role that is `wanted`.
    pub fn index(&self, wanted: impl Fn(&Role) -> bool) -> IdVec<VertexId, Option<usize>> {
        let mut index = IdVec::filled(None, self.derivation.vertices.len());
        let held = self.held.iter().enumerate().filter(|(_, held)| wanted(&held.role));
        held.for_each(|(i, held)| index[held.vertex] = Some(i));
        index
    }

    /// The room about each vertex: the least of those about what it is made of.
    fn carried(&self, rooms: &IdVec<VertexId, Room>) -> IdVec<VertexId, Room> {
        let vertices = &self.derivation.vertices;
        let room = |row| vertices.at(row).iter().fold(OPEN, |room, &(v, _)| least(room, rooms[v]));
        (0..vertices.len()).map(room).collect()
    }

    /// The vertices of the parent that those of faces are made of, each once.
    pub fn sources(&self, faces: &[FaceId]) -> BTreeSet<VertexId> {
        let vertices = faces.iter().flat_map(|&f| self.derivation.faces.vertices_of(f));
        vertices.flat_map(|v| self.derivation.vertices.at(v.index()).iter().map(|s| s.0)).collect()
    }
}

/// What is known of the input, at the elements of a cage after it.
#[derive(Clone)]
pub struct Origin {
    /// The room that the input leaves about each vertex, whatever operators take of it.
    pub clearance: Arc<IdVec<VertexId, Room>>,
    /// Its front.
    pub front: Arc<Front>,
}

/// The stage of a stack that an operator makes: all but the places of its points.
pub struct Formed {
    /// The cage; its points are where they are without any seam's height.
    pub cage: Cage,
    /// What the operator made.
    pub shape: Shape,
    /// What is known of the input.
    pub origin: Origin,
    /// Where the front of the input is for each face, zero where either side may be.
    front: IdVec<FaceId, Vec3>,
    /// Limit rows of the held vertices.
    rows: Table<VertexId>,
    parent: Arc<Level>,
    orientation: Orientation,
    /// Limit rows of the parent.
    parent_rows: Table<VertexId>,
    /// For each held vertex the corners of the parent that its place is a weighted mean of.
    seen: Table<CornerId>,
    /// For each held vertex the one whose limit, before any height, its own is measured from.
    from: Vec<usize>,
    /// Vertices with their copies.
    pairs: Vec<[VertexId; 2]>,
    /// Vertices on marked edges.
    marked: IdVec<VertexId, bool>,
    /// Edges of the second layer, by their held vertices.
    between: Vec<[usize; 2]>,
    /// Faces whose points may move, in their order.
    moved: Vec<FaceId>,
    /// Faces in an order in which neighbours are near.
    order: Vec<FaceId>,
}

/// Where the points of a stage are without heights; what heights are measured from.
pub struct Ground {
    /// Place and normal for each held vertex.
    targets: Vec<(Vec3, Vec3)>,
    /// The operator's weights alone.
    linear: IdVec<VertexId, Vec3>,
    placed: Placed,
    parent: IdVec<VertexId, Vec3>,
}

impl Ground {
    /// Memory that it holds. \[bytes\]
    pub fn bytes(&self) -> usize {
        let points = size_of_val(self.linear.as_slice()) + size_of_val(self.parent.as_slice());
        self.placed.bytes() + points + size_of_val(self.targets.as_slice())
    }
}

impl Origin {
    /// What is known of it after an operator.
    fn carried(&self, shape: &Shape) -> Self {
        let is_copy = shape.index(|role| matches!(role, Role::Layer { .. })).iter().map(Option::is_some).collect();
        Self {
            clearance: Arc::new(shape.carried(&self.clearance)),
            front: Arc::new(self.front.carried(&shape.derivation, &is_copy)),
        }
    }
}

impl Formed {
    /// Applies an operator to a cage.
    ///
    /// # Errors
    /// As [`Operator::shape`].
    pub fn new(operator: &dyn Operator, parent: &Cage, origin: &Origin) -> Result<Self, Error> {
        let shape = operator.shape(parent, &origin.clearance)?;
        let corners: Vec<VertexId> = kept_corners(parent, &shape).chain(shape.corners.iter().copied()).collect();
        let every = (0..parent.level().topology.vertex_count()).into_par_iter().map(VertexId::new);
        let derived = || parent.derived(&shape.derivation, &corners, &shape.creases);
        let (mut cage, parent_rows) = rayon::join(derived, || limit_rows(parent.level(), every));
        let mut points = cage.garment().points.clone();
        shape.apart.iter().for_each(|&(vertex, offset)| points[vertex] += offset);
        cage = cage.with_points(points).with_subsets(shape.subsets.iter().cloned());
        let of_held = || limit_rows(cage.level(), shape.held.par_iter().map(|h| h.vertex));
        let (rows, seen) = rayon::join(of_held, || seen(&shape, cage.level(), parent.level()));
        let (level, orientation) = (parent.shared_level(), parent.garment().orientation);
        let pair = |held: &Held| match held.role {
            Role::Layer { over, .. } => Some([over, held.vertex]),
            _ => None,
        };
        let (pairs, moved) = (shape.held.iter().filter_map(pair).collect(), moved(&shape));
        let marked = shape.index(|role| matches!(role, Role::Centre { .. })).iter().map(Option::is_some).collect();
        let order = order(&cage.level().topology.faces, &cage.garment().points);
        let origin = origin.carried(&shape);
        let front = origin.front.directions(&cage);
        let (from, between) = (measured_from(&shape, cage.level()), layer_edges(&shape, cage.level()));
        Ok(Self {
            cage,
            shape,
            origin,
            front,
            rows,
            parent: level,
            orientation,
            parent_rows,
            seen,
            from,
            pairs,
            marked,
            between,
            moved,
            order,
        })
    }

    /// The points of the new cage without heights.
    pub fn ground(&self, parent: &Placed) -> Ground {
        let surface = Surface::new(&self.parent, self.orientation, &self.parent_rows, &parent.points);
        let t = &self.parent.topology;
        let targets: Vec<(Vec3, Vec3)> =
            (0..self.seen.len()).into_par_iter().map(|i| surface.at(t, self.seen.at(i))).collect();
        let linear = carried_points(&&self.shape.derivation.vertices, &parent.points);
        let settling = self.settling();
        let points = settling.aligned(&targets, settling.base(&targets, &linear));
        let linear = settling.aligned(&targets, linear);
        let rooms = self.shape.carried(&parent.rooms);
        Ground { targets, linear, placed: Placed { points, rooms }, parent: parent.points.clone() }
    }

    /// The points of the new cage, and what was met on the way.
    pub fn raised(&self, operator: &dyn Operator, ground: &Ground) -> (Placed, Warnings) {
        let mut asked = operator.heights(&self.shape);
        unfolded(&mut asked, &self.between, &ground.targets);
        let mut placed = ground.placed.clone();
        let mut given = self.within_room(&asked, &ground.targets, &mut placed.rooms);
        let raise = |i: usize| Raise { normal: ground.targets[i].1, height: given[i], is_least: given[i] != asked[i] };
        let mut raises: Vec<Raise> = (0..given.len()).map(raise).collect();
        graded(&mut raises, &self.between);
        given.iter_mut().zip(&raises).for_each(|(given, raise)| *given = raise.height);
        let raised = self.settling().raised(&ground.targets, &raises, &ground.placed.points);
        let (mut linear, mut flat) = (ground.linear.clone(), ground.placed.points.clone());
        for (held, raise) in self.shape.held.iter().zip(&raises) {
            let step = LEAST_SHARE * raise.height * raise.normal;
            linear[held.vertex] += step;
            flat[held.vertex] += step;
        }
        let kin = Kin {
            child: &self.cage,
            parent: &self.parent,
            parent_points: &ground.parent,
            derivation: &self.shape.derivation,
            pairs: &self.pairs,
            marked: &self.marked,
            order: &self.order,
            front: &self.front,
            moved: &self.moved,
            near: &self.near(&asked, &ground.placed.rooms),
        };
        let sound = sound(&kin, &States { linear: &linear, flat: &flat, raised: &raised });
        placed.points = sound.points;
        let given: Vec<f32> =
            self.shape.held.iter().zip(&given).map(|(held, height)| height * sound.shares[held.vertex]).collect();
        let mut warnings = operator.reduced(&self.shape, &given);
        if !sound.faults.is_empty() {
            warnings.push(operator.unsound(&self.shape, &sound.faults));
        }
        (placed, warnings)
    }

    /// Faces with another layer near on the side to which they are raised.
    fn near(&self, asked: &[f32], rooms: &IdVec<VertexId, Room>) -> IdVec<FaceId, bool> {
        let mut is_near: IdVec<VertexId, bool> = IdVec::filled(false, rooms.len());
        for (held, asked) in self.shape.held.iter().zip(asked) {
            is_near[held.vertex] |= rooms[held.vertex][usize::from(*asked > 0.0)] < NEAR * asked.abs();
        }
        let faces = &self.shape.derivation.faces;
        faces.ids().map(|f| faces.vertices_of(f).iter().any(|&v| is_near[v])).collect()
    }

    fn settling(&self) -> Settling<'_> {
        let edges = &self.cage.level().topology.edges;
        Settling { held: &self.shape.held, rows: &self.rows, from: &self.from, edges }
    }

    /// The heights that there is room for, which they take.
    fn within_room(&self, asked: &[f32], targets: &[(Vec3, Vec3)], rooms: &mut IdVec<VertexId, Room>) -> Vec<f32> {
        let of = |((held, &asked), target): ((&Held, &f32), &(Vec3, Vec3))| {
            // Where the surface turns back on itself there is no way off it.
            let asked = if target.1 == Vec3::ZERO { 0.0 } else { asked };
            let on = if let Role::Layer { over, .. } = held.role { over } else { held.vertex };
            let (side, height) = (usize::from(asked > 0.0), asked.abs());
            let given = height.min((PART_OF_ROOM * rooms[on][side]).max(LEAST_SHARE * height));
            match held.role {
                Role::Layer { over, .. } => {
                    // Both layers have one between them; the second one faces the other way.
                    let (between, rest) = (PART_BETWEEN * given, rooms[over][side] - given);
                    rooms[held.vertex][side] = between;
                    rooms[held.vertex][1 - side] = rest.max(0.0);
                    rooms[over][side] = between;
                }
                _ => rooms[on][side] -= given,
            }
            if asked < 0.0 { -given } else { given }
        };
        self.shape.held.iter().zip(asked).zip(targets).map(of).collect()
    }
}

/// The edges between copies, as the places of both among the held vertices.
fn layer_edges(shape: &Shape, level: &Level) -> Vec<[usize; 2]> {
    let index = shape.index(|role| matches!(role, Role::Layer { .. }));
    let of = |ends: &[VertexId; 2]| Some([index[ends[0]]?, index[ends[1]]?]);
    level.topology.edges.iter().filter_map(of).collect()
}

/// Faces with a held vertex, in their order.
fn moved(shape: &Shape) -> Vec<FaceId> {
    let mut held = vec![false; shape.derivation.vertices.len()];
    shape.held.iter().for_each(|h| held[h.vertex.index()] = true);
    let faces = &shape.derivation.faces;
    faces.ids().filter(|&f| faces.vertices_of(f).iter().any(|v| held[v.index()])).collect()
}

/// The held vertex from whose limit each is measured: itself, but for copies that have other faces or another rule than
/// what they are a copy of, as at the free border of a layer. Those have another limit at the same place.
fn measured_from(shape: &Shape, level: &Level) -> Vec<usize> {
    let index = shape.index(|_| true);
    let like = |v: VertexId| (level.topology.vertex_corners.row(v).len(), level.rules[v]);
    let of = |(i, held): (usize, &Held)| match held.role {
        Role::Layer { over, .. } if like(over) != like(held.vertex) => index[over].unwrap_or(i),
        _ => i,
    };
    shape.held.iter().enumerate().map(of).collect()
}

/// Vertices that are sharp as the corners of single faces, where they have more faces now.
fn kept_corners<'a>(parent: &'a Cage, shape: &'a Shape) -> impl Iterator<Item = VertexId> + 'a {
    let mut faces = vec![0u32; shape.derivation.vertices.len()];
    shape.derivation.faces.corners().iter().for_each(|v| faces[v.index()] += 1);
    parent.level().vertex_sharpness.ids().filter(move |&v| is_lone_corner(parent, v) && faces[v.index()] > 1)
}

/// Whether a vertex is sharp as the corner of a single face.
pub fn is_lone_corner(cage: &Cage, vertex: VertexId) -> bool {
    let level = cage.level();
    level.topology.vertex_corners.row(vertex).len() == 1 && level.vertex_sharpness[vertex] >= INFINITE_SHARPNESS
}

/// For each held vertex the corners of the parent's faces around it, with weights that sum to one.
fn seen(shape: &Shape, child: &Level, parent: &Level) -> Table<CornerId> {
    let derivation = &shape.derivation;
    let vertex_corners: &Csr<VertexId, CornerId> = &child.topology.vertex_corners;
    let corner = |face: FaceId, v: VertexId| {
        parent.topology.faces.corners_of(face).find(|&c| parent.topology.faces.vertex(c) == v)
    };
    Table::of(shape.held.par_iter(), Vec::new, |table, faces: &mut Vec<FaceId>, held| {
        let over = if let Role::Layer { over, .. } = held.role { over } else { held.vertex };
        faces.clear();
        faces.extend(vertex_corners.row(over).iter().map(|&c| derivation.parent_face(derivation.faces.face_of(c))));
        faces.sort_unstable();
        faces.dedup();
        let share = 1.0 / faces.len().max(1) as f32;
        let sources = derivation.vertices.at(over.index());
        let pairs = faces.iter().flat_map(|&f| sources.iter().map(move |&(v, w)| (f, v, w)));
        table.push(pairs.filter_map(|(f, v, w)| Some((corner(f, v)?, w * share))));
    })
}
