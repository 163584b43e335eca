//! Where the points of an operator's stage are to be, by its connectivity.

use super::derivation::Table;
use super::placed::{Placed, Room};
use super::repair::{Displaced, LEAST_SHARE, LookAhead, repair};
use super::settle::{Raise, Settling, graded, unfolded};
use super::shape::{Formed, Held, Operator, Role, Shape, Shaped};
use super::surface::Surface;
use crate::contact::morton_order;
use crate::error::Warnings;
use crate::garment::Garment;
use crate::mesh::{CornerId, Csr, FaceId, IdVec, VertexId};
use crate::subdivide::{Level, Lineage, carried_points};
use glam::Vec3;
use rayon::prelude::*;

/// Part of the room that is left which an operator may take, so that later ones have some too.
const PART_OF_ROOM: f32 = 0.5;
/// Part of the distance of two layers that a later operator may take on either.
const PART_BETWEEN: f32 = 0.8;
/// Heights below which another layer is near: it may be raised too, and the limit surface is not quite where it was. Less
/// misses some that cross, and more looks at more faces and finds no others.
const NEAR: f32 = 3.0;

/// Part of a face's size within which another layer may cross it on the second refinement, where neither is bent.
const CLOSE: f32 = 0.03;

/// What the points of a stage are placed by: all that depends on its connectivity only.
pub struct Placing {
    formed: Formed,
    /// Where the front of the input is for each face, zero where either side may be.
    front: IdVec<FaceId, Vec3>,
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

impl Placing {
    /// What the points of a stage are placed by.
    pub fn new(formed: Formed) -> Self {
        let Shaped { shape, frame, origin, .. } = formed.shaped.as_ref();
        let (level, parent) = (formed.child.level(), formed.parent.level());
        let (seen, order) = rayon::join(|| seen(shape, level, parent), || morton_order(&frame.faces, &frame.points));
        let pair = |held: &Held| match held.role {
            Role::Layer { over, .. } => Some([over, held.vertex]),
            _ => None,
        };
        let is_centre = |role: &Role| matches!(role, Role::Centre { .. });
        Self {
            front: origin.front.directions(&frame.faces),
            seen,
            from: measured_from(shape, level),
            pairs: shape.held.iter().filter_map(pair).collect(),
            marked: shape.index(is_centre).iter().map(Option::is_some).collect(),
            between: layer_edges(shape, level),
            moved: moved(shape),
            order,
            formed,
        }
    }

    fn shape(&self) -> &Shape {
        &self.formed.shaped.shape
    }

    /// The number of corners of the cage.
    pub fn corner_count(&self) -> usize {
        self.formed.shaped.frame.faces.corners().len()
    }

    /// The points of the new cage without heights.
    pub fn ground(&self, parent: &Placed) -> Ground {
        let Formed { shaped, parent: connectivity, .. } = &self.formed;
        let (level, orientation) = (connectivity.level(), shaped.frame.orientation);
        let surface = Surface::new(level, orientation, connectivity.limits(), &parent.points);
        let t = &level.topology;
        let targets: Vec<(Vec3, Vec3)> =
            (0..self.seen.len()).into_par_iter().map(|i| surface.at(t, self.seen.at(i))).collect();
        let linear = carried_points(&&shaped.shape.derivation.vertices, &parent.points);
        let settling = self.settling();
        let points = || settling.aligned(&targets, settling.base(&targets, &linear));
        let others = || (settling.aligned(&targets, linear.clone()), shaped.shape.carried(&parent.rooms));
        let (points, (linear, rooms)) = rayon::join(points, others);
        Ground { targets, linear, placed: Placed { points, rooms }, parent: parent.points.clone() }
    }

    /// The points of the new cage, and what was met on the way. Those of the last cage are held to the second refinement
    /// too.
    pub fn raised(&self, operator: &dyn Operator, ground: &Ground, is_last: bool) -> (Placed, Warnings) {
        let mut asked = operator.heights(self.shape());
        unfolded(&mut asked, &self.between, &ground.targets);
        let mut placed = ground.placed.clone();
        let mut given = self.within_room(&asked, &ground.targets, &mut placed.rooms);
        let raise = |i: usize| Raise { normal: ground.targets[i].1, height: given[i], is_least: given[i] != asked[i] };
        let mut raises: Vec<Raise> = (0..given.len()).map(raise).collect();
        graded(&mut raises, &self.between);
        given.iter_mut().zip(&raises).for_each(|(given, raise)| *given = raise.height);
        let raised = || self.settling().raised(&ground.targets, &raises, &ground.placed.points);
        let least = || [&ground.linear, &ground.placed.points].map(|points| self.least_raised(&raises, points.clone()));
        let (raised, [linear, flat]) = rayon::join(raised, least);
        let displaced = Displaced {
            child: &self.formed.child,
            parent: self.formed.parent.level(),
            parent_points: &ground.parent,
            derivation: &self.shape().derivation,
            copies: &self.pairs,
            marked: &self.marked,
            order: &self.order,
            front: &self.front,
            displaced: &self.moved,
            near: &self.near(&asked, &ground.placed.rooms),
            unfitted: &linear,
            least: &flat,
            full: &raised,
            ahead: is_last.then(|| self.look_ahead(&ground.placed.rooms)),
        };
        let repaired = repair(&displaced);
        placed.points = repaired.points;
        let held = self.shape().held.iter().zip(&given);
        let given: Vec<f32> = held.map(|(held, height)| height * repaired.shares[held.vertex]).collect();
        let mut warnings = operator.reduced(self.shape(), &given);
        if !repaired.faults.is_empty() {
            warnings.push(operator.unsound(self.shape(), &repaired.faults));
        }
        (placed, warnings)
    }

    /// The points with the least part of their heights.
    fn least_raised(&self, raises: &[Raise], mut points: IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        for (held, raise) in self.shape().held.iter().zip(raises) {
            points[held.vertex] += LEAST_SHARE * raise.height * raise.normal;
        }
        points
    }

    /// Faces with another layer near on the side to which they are raised.
    fn near(&self, asked: &[f32], rooms: &IdVec<VertexId, Room>) -> IdVec<FaceId, bool> {
        let mut is_near: IdVec<VertexId, bool> = IdVec::filled(false, rooms.len());
        for (held, asked) in self.shape().held.iter().zip(asked) {
            is_near[held.vertex] |= rooms[held.vertex][usize::from(*asked > 0.0)] < NEAR * asked.abs();
        }
        let faces = &self.shape().derivation.faces;
        let is_near = |face: usize| faces.vertices_of(FaceId::new(face)).iter().any(|&v| is_near[v]);
        (0..faces.len()).into_par_iter().map(is_near).collect::<Vec<_>>().into()
    }

    /// What is to be seen to on the second refinement. Of rooms only those are known that are within the operators' reach.
    fn look_ahead(&self, rooms: &IdVec<VertexId, Room>) -> LookAhead<'_> {
        let Shaped { frame: Garment { faces, points, .. }, origin, .. } = self.formed.shaped.as_ref();
        let is_close = |face: usize| {
            let vertices = faces.vertices_of(FaceId::new(face));
            let size = vertices.iter().map(|&v| points[v].distance(points[vertices[0]])).fold(0.0, f32::max);
            vertices.iter().any(|&v| rooms[v][0].min(rooms[v][1]) < CLOSE * size)
        };
        let close = (0..faces.len()).into_par_iter().map(is_close).collect::<Vec<_>>().into();
        let (level, points) = (origin.cage.level(), &origin.cage.garment().points);
        LookAhead { input: level, input_points: points, input_faces: &origin.faces, close }
    }

    fn settling(&self) -> Settling<'_> {
        let child = &self.formed.child;
        let edges = &child.level().topology.edges;
        Settling { held: &self.shape().held, rows: child.limits(), from: &self.from, edges }
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
        self.shape().held.iter().zip(asked).zip(targets).map(of).collect()
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
