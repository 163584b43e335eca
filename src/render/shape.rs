//! An operator: what it makes of the cage's connectivity, and where the new surface is to be.
//!
//! The two are apart, so that an edit that only moves points repeats only the second.

use super::derivation::{Derivation, Table};
use super::sound::{Kin, LEAST_SHARE, Sound, States, sound};
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
    fn heights(&self, shape: &Shape, surface: &[(Vec3, Vec3)]) -> Vec<f32>;

    /// What to say of the heights that were given, where they are less than asked.
    fn reduced(&self, shape: &Shape, given: &[f32]) -> Warnings;
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

/// Part of its height that the free border of a layer keeps: nearer, it is within what a refined mesh differs from the
/// limit, and weaves through the other layer.
const LEAST_AT_BORDER: f32 = 0.4;

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
    /// Vertices with their copies.
    pairs: Vec<[VertexId; 2]>,
    /// Faces whose points may move.
    moved: IdVec<FaceId, bool>,
}

/// Where the points of a stage are without heights; what heights are measured from.
pub struct Ground {
    parent: IdVec<VertexId, Vec3>,
    /// Place and normal for each held vertex.
    targets: Vec<(Vec3, Vec3)>,
    linear: IdVec<VertexId, Vec3>,
    flat: IdVec<VertexId, Vec3>,
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
        let pair = |held: &Held| match held.role {
            Role::Layer { over, .. } => Some([over, held.vertex]),
            _ => None,
        };
        let (pairs, moved) = (shape.held.iter().filter_map(pair).collect(), moved(&shape));
        Ok(Self { cage, shape, aims, rows, parent: level, orientation, parent_rows, seen, pairs, moved })
    }

    /// The points of the new cage without heights, where the parent's are `points`.
    pub fn ground(&self, points: &IdVec<VertexId, Vec3>) -> Ground {
        let surface = Surface::new(&self.parent, self.orientation, &self.parent_rows, points);
        let t = &self.parent.topology;
        let targets: Vec<(Vec3, Vec3)> = self.seen.par_iter().map(|seen| surface.at(t, seen)).collect();
        let linear = carried_points(&self.shape.derivation.vertex(), points);
        let mut flat = linear.clone();
        for (held, target) in self.shape.held.iter().zip(&targets) {
            // Those that slide in the surface begin where they are to be; old ones keep their place in it.
            let is_new = held.vertex.index() >= points.len() || matches!(held.role, Role::Centre(_));
            if is_new && matches!(held.pin, Pin::Across(_)) {
                flat[held.vertex] = target.0;
            }
        }
        fit(&self.aims, &self.rows, &targets, &mut flat);
        // Fitted apart, a layer of no height would weave through the one it copies. At its own border it has to be.
        let mut linear = linear;
        for held in &self.shape.held {
            let Role::Layer { over, .. } = held.role else { continue };
            match self.is_alike(held) {
                true => flat[held.vertex] = flat[over],
                false => linear[held.vertex] += flat[held.vertex] - flat[over],
            }
        }
        Ground { parent: points.clone(), targets, linear, flat }
    }

    /// Whether a copy has as many faces, and the same rule, as the vertex it is a copy of.
    fn is_alike(&self, held: &Held) -> bool {
        let Role::Layer { over, .. } = held.role else { return true };
        let level = self.cage.level();
        let of = |v: VertexId| (level.topology.vertex_corners.row(v).len(), level.rules[v]);
        of(held.vertex) == of(over)
    }

    /// The points of the new cage, and what was met on the way.
    pub fn raised(&self, operator: &dyn Operator, ground: &Ground) -> (IdVec<VertexId, Vec3>, Warnings) {
        let mut heights = operator.heights(&self.shape, &ground.targets);
        let mut raised = ground.flat.clone();
        let mut targets = ground.targets.clone();
        // Some height is always left, as layers that coincide are no better than ones that cross.
        let (mut linear, mut flat) = (ground.linear.clone(), ground.flat.clone());
        for ((held, target), height) in self.shape.held.iter().zip(&mut targets).zip(&heights) {
            let step = *height * target.1;
            target.0 += step;
            raised[held.vertex] += step;
            let least = if self.is_alike(held) { LEAST_SHARE } else { LEAST_AT_BORDER };
            flat[held.vertex] += least * step;
            linear[held.vertex] += least * step;
        }
        fit(&self.aims, &self.rows, &targets, &mut raised);
        let kin = Kin {
            child: self.cage.level(),
            parent: &self.parent,
            parent_points: &ground.parent,
            derivation: &self.shape.derivation,
            pairs: &self.pairs,
            moved: &self.moved,
        };
        let Sound { points, shares } = sound(&kin, &States { linear: &linear, flat: &flat, raised: &raised });
        for (held, height) in self.shape.held.iter().zip(&mut heights) {
            *height *= shares[held.vertex];
        }
        let warnings = operator.reduced(&self.shape, &heights);
        (points, warnings)
    }

    /// The points of the new cage, where the parent's are `points`.
    pub fn points(
        &self,
        operator: &dyn Operator,
        points: &IdVec<VertexId, Vec3>,
        warnings: &mut Warnings,
    ) -> IdVec<VertexId, Vec3> {
        let (points, met) = self.raised(operator, &self.ground(points));
        warnings.extend(&met);
        points
    }
}

/// Faces with a held vertex.
fn moved(shape: &Shape) -> IdVec<FaceId, bool> {
    let mut held = vec![false; shape.derivation.vertices.len()];
    shape.held.iter().for_each(|h| held[h.vertex.index()] = true);
    let faces = &shape.derivation.faces;
    faces.ids().map(|f| faces.vertices_of(f).iter().any(|v| held[v.index()])).collect()
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
