//! An operator: what it makes of the cage's connectivity, and how high the new surface is to be.
//!
//! Where its points are to be is apart from that (`placing`), so that an edit that only moves points repeats only the second.

use super::derivation::Derivation;
use super::front::Front;
use super::placed::Room;
use crate::contact::{UNBOUNDED as OPEN, smaller as least};
use crate::error::{Error, Warning, Warnings};
use crate::garment::{Garment, Subset};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Cage, Connectivity, Fingerprint, INFINITE_SHARPNESS, Level, Lineage};
use glam::Vec3;
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

    /// The garment that it makes of a cage's, without primvars.
    fn frame(&self, parent: &Cage) -> Garment {
        let corners: Vec<VertexId> = kept_corners(parent, self).chain(self.corners.iter().copied()).collect();
        let mut frame = parent.frame(&self.derivation, &corners, &self.creases);
        self.apart.iter().for_each(|&(vertex, offset)| frame.points[vertex] += offset);
        Arc::make_mut(&mut frame.subsets).extend(self.subsets.iter().cloned());
        frame
    }

    /// The room about each vertex: the least of those about what it is made of.
    pub fn carried(&self, rooms: &IdVec<VertexId, Room>) -> IdVec<VertexId, Room> {
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
    /// The input.
    pub cage: Arc<Cage>,
    /// The face of the input that each face is part of.
    pub faces: Arc<IdVec<FaceId, FaceId>>,
}

/// The stage of a stack that an operator makes: all but the primvars and the places of the points.
pub struct Shaped {
    /// What the operator made.
    pub shape: Shape,
    /// The garment without primvars. Its points are where they are without any seam's height.
    pub frame: Garment,
    /// That of its level.
    pub fingerprint: Fingerprint,
    /// What is known of the input.
    pub origin: Origin,
}

/// What an operator made, with the connectivity of both cages.
pub struct Formed {
    /// What it made.
    pub shaped: Arc<Shaped>,
    /// The connectivity of the new cage.
    pub child: Arc<Connectivity>,
    /// That of the parent.
    pub parent: Arc<Connectivity>,
}

impl Origin {
    /// What is known of it after an operator.
    fn carried(&self, shape: &Shape) -> Self {
        let is_copy = shape.index(|role| matches!(role, Role::Layer { .. })).iter().map(Option::is_some).collect();
        let parents = shape.derivation.faces.ids().map(|face| shape.derivation.parent_face(face));
        Self {
            clearance: Arc::new(shape.carried(&self.clearance)),
            front: Arc::new(self.front.carried(&shape.derivation, &is_copy)),
            cage: Arc::clone(&self.cage),
            faces: Arc::new(parents.map(|face| self.faces[face]).collect()),
        }
    }
}

impl Shaped {
    /// Applies an operator to a cage.
    ///
    /// # Errors
    /// As [`Operator::shape`].
    pub fn new(operator: &dyn Operator, parent: &Cage, origin: &Origin) -> Result<Self, Error> {
        let shape = operator.shape(parent, &origin.clearance)?;
        let frame = || {
            let frame = shape.frame(parent);
            (Level::fingerprint(&frame), frame)
        };
        let ((fingerprint, frame), origin) = rayon::join(frame, || origin.carried(&shape));
        Ok(Self { shape, frame, fingerprint, origin })
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
