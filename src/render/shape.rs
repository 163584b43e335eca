//! An operator: what it makes of the cage's connectivity, and where the new surface is to be.
//!
//! The two are apart, so that an edit that only moves points repeats only the second.

use super::derivation::{Derivation, Table};
use super::surface::{Aim, Pin, Surface, fit, limit_rows};
use crate::error::{Error, Warnings};
use crate::garment::{Interpolation, Mixing, Orientation, Primvar, Subset, Values};
use crate::mesh::{CornerId, Csr, FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, INFINITE_SHARPNESS, Level, Lineage, carried_points};
use glam::Vec3;
use rayon::prelude::*;

/// A step of the stack. Every operator is one type with this trait.
pub trait Operator: Sync + Send {
    /// The options on which [`Operator::shape`] depends, as text.
    fn structure(&self) -> String;

    /// All options, as text.
    fn options(&self) -> String;

    /// The new connectivity and the vertices whose place on the surface is held.
    ///
    /// # Errors
    /// Options that do not fit the cage.
    fn shape(&self, cage: &Cage) -> Result<Shape, Error>;

    /// How far from the parent's surface each role of the shape is, along the normal. \[stage units\]
    fn heights(&self, shape: &Shape, surface: &[(Vec3, Vec3)], warnings: &mut Warnings) -> Vec<f32>;
}

/// What a held vertex is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// On the surface as it was.
    Surface,
    /// On a marked edge of these instances of the operator.
    Centre(Vec<usize>),
    /// On a line.
    Line {
        /// Number of the line, from 0 nearest to the marked edge.
        line: usize,
        /// The instance of the operator.
        instance: usize,
    },
    /// On the second layer.
    Layer {
        /// The vertex that it is a copy of.
        over: VertexId,
        /// The painted weight.
        weight: f32,
    },
}

/// A vertex that is held, before its height is known.
#[derive(Clone, Debug)]
pub struct Held {
    /// The vertex.
    pub vertex: VertexId,
    /// How it is held.
    pub pin: Pin,
    /// What it is for.
    pub role: Role,
    /// How far it may go behind and before the surface.
    pub room: Room,
}

/// How far a vertex may go against and along the normal until it meets the other layer of a fold. \[stage units\]
pub type Room = [f32; 2];

/// No layer is near.
pub const FREE: Room = [1e30; 2];

/// The primvar in which the room of vertices goes through later operators; a `/` is in no name of USD's.
const ROOM: &str = "tailor/room";

/// The room at a weighted mean of a cage's vertices.
pub fn room_at(cage: &Cage, sources: &[(VertexId, f32)]) -> Room {
    let Some(Primvar { values: Values::F32(values), .. }) = cage.garment().primvar(ROOM) else { return FREE };
    let mut room = [0.0; 2];
    for &(v, w) in sources {
        (0..2).for_each(|k| room[k] += w * values[2 * v.index() + k]);
    }
    room
}

/// The cage with its rooms narrowed to those of `held`.
fn with_rooms(cage: Cage, held: &[Held]) -> Cage {
    if held.iter().all(|h| h.room == FREE) {
        return cage;
    }
    let mut rooms = match cage.garment().primvar(ROOM) {
        Some(Primvar { values: Values::F32(values), .. }) => values.clone(),
        _ => vec![FREE[0]; 2 * cage.garment().points.len()],
    };
    for held in held {
        let over = if let Role::Layer { over, .. } = held.role { Some(over) } else { None };
        for vertex in over.into_iter().chain([held.vertex]) {
            let at = 2 * vertex.index();
            (0..2).for_each(|k| rooms[at + k] = rooms[at + k].min(held.room[k]));
        }
    }
    cage.with_primvar(Primvar {
        name: ROOM.into(),
        type_name: "float2[]".into(),
        interpolation: Interpolation::Vertex,
        components: 2,
        element_size: 1,
        mixing: Mixing::Linear,
        values: Values::F32(rooms),
        indices: None,
    })
}

/// The cage without what operators tell each other.
pub fn without_rooms(cage: Cage) -> Cage {
    cage.without_primvar(ROOM)
}

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

/// The stage of a stack that an operator makes: all but the places of its points.
pub struct Formed {
    /// The cage; its points are where they are without any seam's height.
    pub cage: Cage,
    /// What the operator made.
    pub shape: Shape,
    aims: Vec<Aim>,
    /// Limit rows of the aims.
    rows: Table<VertexId>,
    parent: Level,
    orientation: Orientation,
    /// Limit rows of the parent.
    parent_rows: Table<VertexId>,
    /// For each aim the corners of the parent that its place is a weighted mean of.
    seen: Vec<Vec<(CornerId, f32)>>,
}

impl Formed {
    /// Applies an operator to a cage.
    ///
    /// # Errors
    /// As [`Operator::shape`].
    pub fn new(operator: &dyn Operator, parent: &Cage) -> Result<Self, Error> {
        let shape = operator.shape(parent)?;
        let corners: Vec<VertexId> = kept_corners(parent, &shape).chain(shape.corners.iter().copied()).collect();
        let mut cage = parent.derived(&shape.derivation, &corners, &shape.creases);
        let mut points = cage.garment().points.clone();
        shape.apart.iter().for_each(|&(vertex, offset)| points[vertex] += offset);
        cage = cage.with_points(points).with_subsets(shape.subsets.iter().cloned());
        cage = with_rooms(cage, &shape.held);
        let aims: Vec<Aim> = shape.held.iter().map(|h| Aim { vertex: h.vertex, pin: h.pin }).collect();
        let rows = limit_rows(cage.level(), aims.par_iter().map(|a| a.vertex));
        let every = (0..parent.level().topology.vertex_count()).into_par_iter().map(VertexId::new);
        let parent_rows = limit_rows(parent.level(), every);
        let seen = seen(&shape, cage.level(), parent.level());
        let (level, orientation) = (parent.level().clone(), parent.garment().orientation);
        Ok(Self { cage, shape, aims, rows, parent: level, orientation, parent_rows, seen })
    }

    /// The points of the new cage, where the parent's are `points`.
    pub fn points(
        &self,
        operator: &dyn Operator,
        points: &IdVec<VertexId, Vec3>,
        warnings: &mut Warnings,
    ) -> IdVec<VertexId, Vec3> {
        let surface = Surface::new(&self.parent, self.orientation, &self.parent_rows, points);
        let t = &self.parent.topology;
        let mut targets: Vec<(Vec3, Vec3)> = self.seen.iter().map(|seen| surface.at(t, seen)).collect();
        let heights = operator.heights(&self.shape, &targets, warnings);
        let mut made = carried_points(&self.shape.derivation.vertex(), points);
        for ((held, target), height) in self.shape.held.iter().zip(&mut targets).zip(heights) {
            target.0 += height * target.1;
            // Those that slide in the surface begin where they are to be; old ones keep their place in it.
            let is_new = held.vertex.index() >= points.len() || matches!(held.role, Role::Centre(_));
            match is_new && held.pin != Pin::Place {
                true => made[held.vertex] = target.0,
                false => made[held.vertex] += height * target.1,
            }
        }
        fit(&self.aims, &self.rows, &targets, &mut made);
        made
    }
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
fn seen(shape: &Shape, child: &Level, parent: &Level) -> Vec<Vec<(CornerId, f32)>> {
    let derivation = &shape.derivation;
    let vertex_corners: &Csr<VertexId, CornerId> = &child.topology.vertex_corners;
    let of = |held: &Held| {
        let over = if let Role::Layer { over, .. } = held.role { over } else { held.vertex };
        let around = vertex_corners.row(over).iter().map(|&c| derivation.parent_face(derivation.faces.face_of(c)));
        let mut faces: Vec<FaceId> = around.collect();
        faces.sort_unstable();
        faces.dedup();
        let share = 1.0 / faces.len().max(1) as f32;
        let corner = |face: FaceId, v: VertexId| {
            parent.topology.faces.corners_of(face).find(|&c| parent.topology.faces.vertex(c) == v)
        };
        let sources = derivation.vertices.at(over.index());
        let pairs = faces.iter().flat_map(|&f| sources.iter().map(move |&(v, w)| (f, v, w)));
        pairs.filter_map(|(f, v, w)| Some((corner(f, v)?, w * share))).collect()
    };
    shape.held.par_iter().map(of).collect()
}
