//! Positions of the points of an operator's cage: the limit surface of the parent plus the operator's heights.
//!
//! [`Placement`] holds what depends on the cages alone. [`Placement::flat`] fits the new cage to the parent's limit
//! surface without heights. [`Placement::raised`] limits the heights to the clearance, adds them, and repairs
//! self-intersections and flipped faces. An edit of heights repeats only the last step.

mod clearance;
mod even;
mod fit;
mod normals;
mod patches;

use super::child::{OperatorDerivation, Table};
use super::operator::{Control, ControlRole, DerivedCage, LayerEnd, Operator, OperatorOutput};
use super::points::CagePoints;
use super::repair::{LEAST_SHARE, RepairInput, SecondRefinementInput, repair};
use crate::codes;
use crate::contact::{Clearance, TEST, each_once, morton_order};
use clearance::lifted;
use even::EvenNormals;
use fit::{LimitFit, Raise, unfolded};
use glam::Vec3;
use normals::OuterNormals;
use patches::{CagePlace, Patches};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, Csr, EdgeId, FaceId, IdVec, VertexId};
use tailor_mesh::error::{Warning, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::{Connectivity, Derivation, Level, carried_points, edges_at};

/// Share of its shortest edge by which the fit may move a vertex along the surface.
const MAX_SLIDE: f32 = 0.4;
/// Clearance, as a multiple of the height, below which a face is checked against other layers. The other layer may be
/// raised too, and the fit moves both. A smaller range misses intersections; a larger one finds no more.
const NEAR_HEIGHTS: f32 = 3.0;
/// Clearance, as a share of a face's size, below which another layer may intersect it on the second refinement.
const CLOSE_SIZE: f32 = 0.03;

/// The inputs of positions apart from the parent's points and the heights.
pub struct Placement {
    cage: Arc<DerivedCage>,
    child: Arc<Connectivity>,
    parent: Arc<Connectivity>,
    /// The reference normal of each face, zero where both directions are accepted.
    reference_normals: IdVec<FaceId, Vec3>,
    /// For each control, the parent's corners and weights of its position on the limit surface.
    surface_corners: Table<CornerId>,
    /// For each control, where it, or the original of a copy, is on the parent.
    places: Vec<Option<CagePlace>>,
    /// The parent's faces in which they are, ascending.
    placed_faces: Vec<FaceId>,
    /// For each control, the control whose limit it shares without heights.
    reference_control: Vec<usize>,
    /// Vertices with their copies on the second layer.
    copy_pairs: Vec<[VertexId; 2]>,
    /// True for vertices on seam edges.
    on_seam: IdVec<VertexId, bool>,
    /// For each control, that of the original which it lifts where it lacks room.
    lifted: Vec<Option<usize>>,
    /// Edges of the second layer, as indices of controls.
    layer_edges: Vec<[usize; 2]>,
    /// Faces with a control, ascending.
    controlled_faces: Vec<FaceId>,
    /// All faces in an order that keeps neighbours close in memory.
    face_order: Vec<FaceId>,
}

/// The points of a cage without heights, and the surface that heights are measured from.
pub struct FlatPoints {
    /// Position and normal of each control on the limit surface of the parent.
    targets: Vec<(Vec3, Vec3)>,
    /// Positions by linear interpolation of the parent's points, without a fit.
    linear: IdVec<VertexId, Vec3>,
    /// Positions fitted along normals alone.
    upright: IdVec<VertexId, Vec3>,
    /// Fitted positions.
    fitted: CagePoints,
    parent_points: IdVec<VertexId, Vec3>,
}

/// The limit surface of a parent, where a cage has controls.
pub struct LimitSurface {
    patches: Patches,
    normals: OuterNormals,
}

impl LimitSurface {
    /// Its memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.patches.bytes() + self.normals.bytes()
    }
}

/// Where controls are on a limit surface.
struct Targets {
    /// Position and normal of each control.
    targets: Vec<(Vec3, Vec3)>,
    /// Positions of all vertices by linear interpolation of the parent's points.
    linear: IdVec<VertexId, Vec3>,
}

impl FlatPoints {
    /// The fitted points, if these are the parent's.
    pub fn fitted_on(&self, parent: &IdVec<VertexId, Vec3>) -> Option<&IdVec<VertexId, Vec3>> {
        (self.parent_points == *parent).then_some(&self.fitted.points)
    }
}

impl Placement {
    /// The placement of a cage with the connectivity `child` on that of its parent.
    pub fn new(cage: Arc<DerivedCage>, child: Arc<Connectivity>, parent: Arc<Connectivity>) -> Self {
        let DerivedCage { output, frame, ancestry } = cage.as_ref();
        let level = child.level();
        let (surface_corners, face_order) = rayon::join(
            || surface_corners(output, level, parent.level()),
            || morton_order(&frame.faces, &frame.points),
        );
        let pair = |control: &Control| match control.role {
            ControlRole::Copy { of, .. } => Some([of, control.vertex]),
            _ => None,
        };
        let places = places(output, level, parent.level());
        let placed = places.iter().flatten().map(|place| place.face(&parent.level().topology));
        Self {
            placed_faces: each_once(placed.collect()),
            places,
            reference_normals: ancestry.reference.directions(&frame.faces),
            surface_corners,
            reference_control: reference_controls(output, level),
            copy_pairs: output.controls.iter().filter_map(pair).collect(),
            on_seam: output.index(|role| role == ControlRole::Crest).iter().map(Option::is_some).collect(),
            lifted: lifted(output, level),
            layer_edges: layer_edges(output, level),
            controlled_faces: controlled_faces(output),
            face_order,
            cage,
            child,
            parent,
        }
    }

    /// Vertices with their copies on the second layer.
    pub fn copy_pairs(&self) -> &[[VertexId; 2]] {
        &self.copy_pairs
    }

    /// The derivation of the cage from its parent.
    pub fn derivation(&self) -> &OperatorDerivation {
        &self.output().derivation
    }

    fn output(&self) -> &OperatorOutput {
        &self.cage.output
    }

    /// The points of the new cage without heights.
    pub fn flat(&self, surface: &LimitSurface, parent: &CagePoints) -> FlatPoints {
        let Targets { targets, linear } = self.targets(surface, &parent.points);
        let fit = self.limit_fit();
        let upright = || fit.base(&surface.patches, &targets, &vec![0.0; targets.len()], &linear);
        let fitted = || self.fitted_to(surface, &targets, &linear);
        let (points, upright) = rayon::join(fitted, || fit.aligned(&targets, upright()));
        let fitted = CagePoints { points, clearance: self.output().carried_clearance(&parent.clearance) };
        let linear = fit.aligned(&targets, linear);
        FlatPoints { targets, linear, upright, fitted, parent_points: parent.points.clone() }
    }

    /// The points of the new cage without heights, on a parent with these points.
    pub fn fitted(&self, surface: &LimitSurface, parent: &IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        let Targets { targets, linear } = self.targets(surface, parent);
        self.fitted_to(surface, &targets, &linear)
    }

    fn fitted_to(
        &self,
        surface: &LimitSurface,
        targets: &[(Vec3, Vec3)],
        linear: &IdVec<VertexId, Vec3>,
    ) -> IdVec<VertexId, Vec3> {
        let fit = self.limit_fit();
        let start = fit.on_surface(targets, linear);
        fit.aligned(targets, fit.base(&surface.patches, targets, &self.room_along(&start), &start))
    }

    /// The limit surface of a parent with these points, where the new cage has controls.
    pub fn surface(&self, parent: &IdVec<VertexId, Vec3>) -> LimitSurface {
        let (level, orientation) = (self.parent.level(), self.cage.frame.orientation);
        let (normals, patches) = rayon::join(
            || OuterNormals::new(level, orientation, self.parent.limits(), parent),
            || Patches::new(Arc::clone(&self.parent), parent, &self.placed_faces),
        );
        LimitSurface { patches, normals }
    }

    /// The parent and its faces that [`Placement::surface`] depends on.
    pub fn surface_inputs(&self) -> (&Arc<Connectivity>, &[FaceId]) {
        (&self.parent, &self.placed_faces)
    }

    fn targets(&self, surface: &LimitSurface, parent: &IdVec<VertexId, Vec3>) -> Targets {
        let linear = carried_points(&&self.output().derivation.vertices, parent);
        let target = |i: usize| {
            let point = self.places[i].and_then(|place| surface.patches.at(place));
            let point = point.unwrap_or(linear[self.output().controls[i].vertex]);
            (point, surface.normals.normal(self.surface_corners.at(i)))
        };
        let targets = (0..self.surface_corners.len()).into_par_iter().map(target).collect();
        Targets { targets, linear }
    }

    /// The points of the new cage, and warnings of reduced heights and of remaining intersections. The points of the
    /// last cage are checked on the second refinement too.
    pub fn raised(&self, operator: &dyn Operator, base: &FlatPoints, is_last: bool) -> (CagePoints, Warnings) {
        let mut asked = operator.heights(self.output());
        let controls = &self.output().controls;
        let targets = self.even_targets(&asked, base, is_last);
        unfolded(&mut asked, &self.layer_edges, &targets);
        let mut cage = base.fitted.clone();
        let given = self.within_clearance(&asked, &targets, &mut cage.clearance, is_last);
        let is_beside = |i: usize| matches!(controls[i].role, ControlRole::Copy { closing: LayerEnd::Beside, .. });
        let is_least = |i: usize| given[i] != asked[i] || is_beside(i);
        let raise = |i: usize| Raise { normal: targets[i].1, height: given[i], is_least: is_least(i) };
        let raises: Vec<Raise> = (0..given.len()).map(raise).collect();
        let raised = || self.limit_fit().raised(&raises, &base.fitted.points);
        let unraised = [&base.linear, &base.upright, &base.fitted.points];
        let least = || unraised.map(|points| self.least_raised(&raises, points.clone()));
        let (raised, [linear, upright, flat]) = rayon::join(raised, least);
        let most: Vec<f32> = asked.iter().zip(&given).map(|(a, g)| if *a == 0.0 { *g } else { *a }).collect();
        let displaced = RepairInput {
            child: &self.child,
            parent: self.parent.level(),
            parent_points: &base.parent_points,
            derivation: &self.output().derivation,
            copy_pairs: &self.copy_pairs,
            on_seam: &self.on_seam,
            face_order: &self.face_order,
            reference_normals: &self.reference_normals,
            controlled_faces: &self.controlled_faces,
            near: &self.faces_near_other_layers(&most, &base.fitted.clearance),
            unfitted: &linear,
            upright: &upright,
            least: &flat,
            full: &raised,
            ahead: is_last.then(|| self.look_ahead(&base.fitted.clearance)),
        };
        let repaired = repair(&displaced);
        cage.points = repaired.points;
        let controls = self.output().controls.iter().zip(&given);
        let given: Vec<f32> = controls.map(|(control, height)| height * repaired.shares[control.vertex]).collect();
        let mut warnings = operator.reduced(self.output(), &given);
        if !repaired.faults.is_empty() {
            warnings.push(operator.intersections(self.output(), &repaired.faults));
        }
        if repaired.is_cut_short {
            warnings.push(cut_short(operator.label(), displaced.most_work()));
        }
        (cage, warnings)
    }

    /// The targets with even normals of a second layer, over the heights that the clearance leaves it.
    fn even_targets<'a>(&self, asked: &[f32], base: &'a FlatPoints, is_last: bool) -> Cow<'a, [(Vec3, Vec3)]> {
        if self.layer_edges.is_empty() {
            return Cow::Borrowed(&base.targets);
        }
        let layer = EvenNormals {
            targets: &base.targets,
            edges: &self.layer_edges,
            controls: &self.output().controls,
            topology: &self.child.level().topology,
            points: &base.fitted.points,
        };
        let given = self.within_clearance(asked, &base.targets, &mut base.fitted.clearance.clone(), is_last);
        Cow::Owned(layer.over(&given))
    }

    /// The points raised by the least share of their heights that repair leaves.
    fn least_raised(&self, raises: &[Raise], mut points: IdVec<VertexId, Vec3>) -> IdVec<VertexId, Vec3> {
        for (control, raise) in self.output().controls.iter().zip(raises) {
            points[control.vertex] += LEAST_SHARE * raise.height * raise.normal;
        }
        points
    }

    /// True for faces with another layer near on the side to which they are raised.
    fn faces_near_other_layers(&self, asked: &[f32], clearance: &IdVec<VertexId, Clearance>) -> IdVec<FaceId, bool> {
        let mut is_near: IdVec<VertexId, bool> = IdVec::filled(false, clearance.len());
        for (control, asked) in self.output().controls.iter().zip(asked) {
            is_near[control.vertex] |=
                clearance[control.vertex][usize::from(*asked > 0.0)] < NEAR_HEIGHTS * asked.abs();
            // Where a layer closes, its own surface is near.
            if let ControlRole::Copy { of, closing: LayerEnd::Beside | LayerEnd::Closed, .. } = control.role {
                (is_near[control.vertex], is_near[of]) = (true, true);
            }
        }
        let faces = &self.output().derivation.faces;
        let is_near = |face: usize| faces.vertices_of(FaceId::new(face)).iter().any(|&v| is_near[v]);
        (0..faces.len()).into_par_iter().map(is_near).collect::<Vec<_>>().into()
    }

    /// The faces to check on the second refinement. `clearance` is measured within the operators' reach only.
    fn look_ahead(&self, clearance: &IdVec<VertexId, Clearance>) -> SecondRefinementInput<'_> {
        let DerivedCage { frame: Mesh { faces, points, .. }, ancestry, .. } = self.cage.as_ref();
        let is_close = |face: usize| {
            let vertices = faces.vertices_of(FaceId::new(face));
            let size = vertices.iter().map(|&v| points[v].distance(points[vertices[0]])).fold(0.0, f32::max);
            vertices.iter().any(|&v| clearance[v][0].min(clearance[v][1]) < CLOSE_SIZE * size)
        };
        let close = (0..faces.len()).into_par_iter().map(is_close).collect::<Vec<_>>().into();
        let (level, points) = (ancestry.level.as_ref(), &ancestry.garment.points);
        SecondRefinementInput { input: level, input_points: points, input_faces: &ancestry.faces, close }
    }

    /// How far each control may go along the surface.
    fn room_along(&self, linear: &IdVec<VertexId, Vec3>) -> Vec<f32> {
        let t = &self.child.level().topology;
        let length = |edge: EdgeId| linear[t.edges[edge][0]].distance(linear[t.edges[edge][1]]);
        let room = |control: &Control| edges_at(t, control.vertex).map(length).fold(f32::INFINITY, f32::min);
        let slide =
            |control: &Control| if control.role == ControlRole::Surface { 0.0 } else { MAX_SLIDE * room(control) };
        self.output().controls.par_iter().map(slide).collect()
    }

    fn limit_fit(&self) -> LimitFit<'_> {
        let (controls, places, rows) = (&self.output().controls, &self.places, self.child.limits());
        LimitFit { controls, places, rows, reference_control: &self.reference_control }
    }
}

/// The warning of a repair that its bound of work has ended.
fn cut_short(label: String, most: usize) -> Warning {
    let problem = format!(
        "repair has ended at its bound of {} tests of faces, as very many of them are near each other: more may intersect \
         than are reported",
        most / TEST
    );
    Warning::new(codes::REPAIR_CUT_SHORT, label, problem)
        .remedy("Leave out elements where the garment is crumpled or passes through itself")
}

/// The edges between copies, as indices of their controls, without those of closed ends.
fn layer_edges(output: &OperatorOutput, level: &Level) -> Vec<[usize; 2]> {
    let index =
        output.index(|role| matches!(role, ControlRole::Copy { closing: LayerEnd::Open | LayerEnd::Beside, .. }));
    let of = |ends: &[VertexId; 2]| Some([index[ends[0]]?, index[ends[1]]?]);
    level.topology.edges.iter().filter_map(of).collect()
}

/// Faces with a control, ascending.
fn controlled_faces(output: &OperatorOutput) -> Vec<FaceId> {
    let mut is_control = vec![false; output.derivation.vertices.len()];
    output.controls.iter().for_each(|c| is_control[c.vertex.index()] = true);
    let faces = &output.derivation.faces;
    faces.ids().filter(|&f| faces.vertices_of(f).iter().any(|v| is_control[v.index()])).collect()
}

/// For each control, the control whose limit it shares without heights. It is the control itself, or the original of a
/// copy with another valence or vertex rule, as at the free border of a layer: there the masks give different limits.
fn reference_controls(output: &OperatorOutput, level: &Level) -> Vec<usize> {
    let index = output.index(|_| true);
    let mask = |v: VertexId| (level.topology.vertex_corners.row(v).len(), level.rules[v]);
    let of = |(i, control): (usize, &Control)| match control.role {
        ControlRole::Copy { of, .. } if mask(of) != mask(control.vertex) => index[of].unwrap_or(i),
        _ => i,
    };
    output.controls.iter().enumerate().map(of).collect()
}

/// For each control, where it, or the original of a copy, is on the parent.
fn places(output: &OperatorOutput, child: &Level, parent: &Level) -> Vec<Option<CagePlace>> {
    let (derivation, faces) = (&output.derivation, &child.topology.faces);
    let place = |control: &Control| {
        let over = control.role.original().unwrap_or(control.vertex);
        let corners = child.topology.vertex_corners.row(over).iter();
        let parents = corners.map(|&c| derivation.parent_face(faces.face_of(c)));
        CagePlace::new(&parent.topology, parents.min()?, derivation.vertices.at(over.index()))
    };
    output.controls.par_iter().map(place).collect()
}

/// For each control, the corners of the parent's faces around it, with weights that sum to one.
fn surface_corners(output: &OperatorOutput, child: &Level, parent: &Level) -> Table<CornerId> {
    let derivation = &output.derivation;
    let vertex_corners: &Csr<VertexId, CornerId> = &child.topology.vertex_corners;
    let corner = |face: FaceId, v: VertexId| {
        parent.topology.faces.corners_of(face).find(|&c| parent.topology.faces.vertex(c) == v)
    };
    Table::of(output.controls.par_iter(), Vec::new, |table, faces: &mut Vec<FaceId>, control| {
        let over = control.role.original().unwrap_or(control.vertex);
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
