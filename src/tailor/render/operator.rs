//! Operators: the new connectivity of a cage, and the heights of its new surface over the old one.
//!
//! `placement` computes the points from both, so an edit of heights alone keeps the connectivity.

use super::child::OperatorDerivation;
use super::reference::ReferenceNormals;
use crate::codes;
use crate::contact::{Clearance, UNBOUNDED, smaller};
use glam::Vec3;
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor_mesh::connectivity::{FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings, counted};
use tailor_mesh::garment::{Elements, Mesh, Subset};
use tailor_mesh::subdivide::{Carrier, Derivation, INFINITE_SHARPNESS, Level, carried_points};

/// Remaining share of a height or distance below which a reduction is reported.
pub(super) const REPORTED: f32 = 0.98;

/// One step of the stack from a cage to its render mesh.
pub trait Operator: Any + Send + Sync {
    /// Kind and name for messages, such as `seam.placket`.
    fn label(&self) -> String;

    /// The largest height over the surface of a garment, on either side. \[mesh units\]
    fn reach(&self, garment: &Mesh) -> f32;

    /// Names of the face subsets that it folds over at the border. Faces that bend too far there are halved before
    /// operators run. By default none.
    fn folded_sets(&self) -> Vec<String> {
        Vec::new()
    }

    /// The refinements of a garment after which its faces still have room for the operator, which then runs on the
    /// refined cage, as all operators after it do. None for operators of the coarse cage, as by default. \[levels\]
    fn levels_with_room(&self, _: &Mesh, _: &Topology) -> Option<u32> {
        None
    }

    /// The operators that do its work one after the other; none if it does its work itself, as by default.
    fn parts(&self) -> Vec<Arc<dyn Operator>> {
        Vec::new()
    }

    /// The new connectivity and its controls.
    ///
    /// # Errors
    /// Options that do not fit the cage.
    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error>;

    /// The height of each control over the parent's surface, along its normal. \[mesh units\]
    fn heights(&self, output: &OperatorOutput) -> Vec<f32>;

    /// True if `other` gives the same output and heights. By default, only the operator itself.
    fn is_same(&self, other: &dyn Operator) -> bool {
        std::ptr::addr_eq(std::ptr::from_ref(self), other)
    }

    /// True if [`Operator::apply`] of `other` gives the same output; heights may differ.
    fn has_same_output(&self, other: &dyn Operator) -> bool {
        self.is_same(other)
    }

    /// Warnings of reduced heights; `given` holds the remaining height of each control. By default, one warning for
    /// all.
    fn reduced(&self, output: &OperatorOutput, given: &[f32]) -> Warnings {
        let asked = self.heights(output);
        let shares = given.iter().zip(&asked).map(|(given, asked)| given.abs() / asked.abs());
        let reduced = output.controls.iter().zip(shares).filter(|(_, share)| *share < REPORTED);
        let mut warnings = Warnings::default();
        let least = reduced.clone().map(|(_, share)| share).fold(f32::INFINITY, f32::min);
        if least.is_finite() {
            let vertices = counted(reduced.clone().count(), "vertex", "vertices");
            let problem = format!("its height is reduced to {:.0} % at {vertices}", 100.0 * least);
            let points = output.input_points(reduced.map(|(control, _)| control.vertex));
            warnings.push(Warning::new(codes::REDUCED_HEIGHT, self.label(), problem).at(points).amount(least));
        }
        warnings
    }

    /// The warning of faces that intersect others or are flipped after repair.
    fn intersections(&self, output: &OperatorOutput, faces: &[FaceId]) -> Warning {
        intersections(self.label(), output, faces)
    }
}

/// The warning of faces of an operator that intersect others or are flipped.
pub(super) fn intersections(label: String, output: &OperatorOutput, faces: &[FaceId]) -> Warning {
    let one = "face of the cage intersects others or is flipped";
    let problem = counted(faces.len(), one, "faces of the cage intersect others or are flipped");
    Warning::new(codes::INTERSECTIONS, label, problem)
        .at(output.input_points(output.sources(faces)))
        .remedy("Make it narrower or thinner where the surface bends tightly, or remove those elements from its sets")
}

/// The cage that an operator starts from.
pub struct OperatorInput<'a> {
    /// The mesh. Its points are without the heights of earlier operators.
    pub garment: &'a Mesh,
    /// Connectivity and subdivision rules of the mesh.
    pub level: &'a Level,
    /// Clearance that the garment leaves beside each vertex, measured within the operators' reach.
    pub clearance: &'a IdVec<VertexId, Clearance>,
    /// The vertex of the input garment at or beside each vertex, for messages.
    pub inputs: &'a Arc<IdVec<VertexId, VertexId>>,
    /// True for faces of hems and inner layers, which cover the operators that run below them.
    pub covers: &'a IdVec<FaceId, bool>,
    /// True if operators add face subsets of their new faces.
    pub names_sets: bool,
}

/// The points of the input garment at some vertices, each once.
fn input_points(inputs: &IdVec<VertexId, VertexId>, vertices: impl IntoIterator<Item = VertexId>) -> Elements {
    let known = vertices.into_iter().filter(|v| v.index() < inputs.len());
    Elements::Points(known.map(|v| inputs[v]).collect::<BTreeSet<_>>().into_iter().collect())
}

/// The input vertices after an operator: a new vertex has that of its heaviest source.
fn passed_on(
    inputs: &Arc<IdVec<VertexId, VertexId>>,
    derivation: &OperatorDerivation,
) -> Arc<IdVec<VertexId, VertexId>> {
    let mut all = Arc::clone(inputs);
    for v in inputs.len()..derivation.vertices.len() {
        let heaviest = derivation.vertices.at(v).iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
        Arc::make_mut(&mut all).push(heaviest.map_or(VertexId::new(0), |source| inputs[source.0]));
    }
    all
}

impl OperatorInput<'_> {
    /// The points of the input garment at some vertices, as elements of a warning.
    pub fn input_points(&self, vertices: impl IntoIterator<Item = VertexId>) -> Elements {
        input_points(self.inputs, vertices)
    }

    /// The edges of the input garment at some edges, as elements of a warning.
    pub(super) fn input_edges(&self, edges: impl IntoIterator<Item = [VertexId; 2]>) -> Elements {
        let known = edges.into_iter().filter(|ends| ends.iter().all(|v| v.index() < self.inputs.len()));
        let inputs = known.map(|ends| ends.map(|v| self.inputs[v])).filter(|[a, b]| a != b);
        Elements::Edges(inputs.collect::<BTreeSet<_>>().into_iter().collect())
    }

    /// The vertices on the surface, along which distances are measured. The cage is beside it where faces are uneven.
    pub fn on_surface(&self) -> IdVec<VertexId, Vec3> {
        carried_points(&&self.level.limit_rows(), &self.garment.points)
    }

    /// The connectivity of the cage.
    pub fn topology(&self) -> &Topology {
        &self.level.topology
    }
}

/// The role of a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlRole {
    /// On the surface.
    Surface,
    /// On the surface, at its place: a border or the border of a set leads there.
    Kept,
    /// Raised by its height from its place on the surface.
    Raised,
    /// Raised so, on the line that gives the operator its shape: repair lowers it only where its own faces are at fault.
    Crest,
    /// A copy of another vertex, on a second layer.
    Copy {
        /// The original.
        of: VertexId,
        /// 1 on the outer side of the surface, -1 on the inner side.
        side: f32,
        /// Whether the layer is near the end of a fold.
        closing: LayerEnd,
    },
}

/// Where a second layer closes at the end of a fold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerEnd {
    /// Away from ends.
    Open,
    /// Beside an end: the layer rises no faster than its cage.
    Beside,
    /// On the surface, or where the fold tapers towards it: its neighbours may be much higher.
    Closed,
}

impl ControlRole {
    /// The original of a copy.
    pub fn original(self) -> Option<VertexId> {
        if let Self::Copy { of, .. } = self { Some(of) } else { None }
    }
}

/// A vertex with a controlled limit position.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// The vertex.
    pub vertex: VertexId,
    /// Its role, which decides how it moves.
    pub role: ControlRole,
}

/// The output of an operator, without positions.
pub struct OperatorOutput {
    /// The new connectivity, and the parents of its elements.
    pub derivation: OperatorDerivation,
    /// The vertices with a controlled limit position.
    pub controls: Vec<Control>,
    /// Data of the operator for [`Operator::heights`].
    pub details: Arc<dyn Any + Send + Sync>,
    /// Subsets of new faces.
    pub subsets: Vec<Subset>,
    /// Vertices that become infinitely sharp.
    pub corners: Vec<VertexId>,
    /// Edges that become infinitely sharp.
    pub creases: Vec<[VertexId; 2]>,
    /// Provisional offsets of copies from their originals, so that later operators can measure edges. \[mesh units\]
    pub offsets: Vec<(VertexId, Vec3)>,
    /// The vertex of the input garment at or beside each vertex, for messages.
    pub inputs: Arc<IdVec<VertexId, VertexId>>,
    /// Warnings of elements that were narrowed or omitted.
    pub warnings: Warnings,
}

impl OperatorOutput {
    /// An output of a connectivity, without controls.
    pub fn new(derivation: OperatorDerivation, cage: &OperatorInput) -> Self {
        Self {
            inputs: passed_on(cage.inputs, &derivation),
            derivation,
            controls: Vec::new(),
            details: Arc::new(()),
            subsets: Vec::new(),
            corners: Vec::new(),
            creases: Vec::new(),
            offsets: Vec::new(),
            warnings: Warnings::default(),
        }
    }

    /// The index in `controls` of each vertex whose role is `wanted`.
    pub fn index(&self, wanted: impl Fn(ControlRole) -> bool) -> IdVec<VertexId, Option<usize>> {
        let mut index = IdVec::filled(None, self.derivation.vertices.len());
        let controls = self.controls.iter().enumerate().filter(|(_, control)| wanted(control.role));
        controls.for_each(|(i, control)| index[control.vertex] = Some(i));
        index
    }

    /// The child's garment without primvars.
    fn frame(&self, parent: &OperatorInput) -> Mesh {
        let carrier = Carrier::new(parent.garment, &self.derivation);
        let mut frame = carrier.frame(carrier.subsets());
        frame.points = carried_points(&self.derivation.vertex(), &parent.garment.points);
        self.offsets.iter().for_each(|&(vertex, offset)| frame.points[vertex] += offset);
        let mut sharp: BTreeSet<VertexId> = frame.corners.iter().map(|c| c.vertex).collect();
        let corners = kept_corners(parent.level, self).chain(self.corners.iter().copied());
        let new = corners.filter(|&v| sharp.insert(v));
        let sharpness = INFINITE_SHARPNESS;
        frame.corners.extend(new.map(|vertex| tailor_mesh::garment::Corner { vertex, sharpness }));
        frame.creases.extend(
            self.creases
                .iter()
                .map(|ends| tailor_mesh::garment::Crease { vertices: ends.to_vec(), sharpnesses: vec![sharpness] }),
        );
        Arc::make_mut(&mut frame.subsets).extend(self.subsets.iter().cloned());
        frame
    }

    /// The clearance of each vertex: the smallest of its sources'.
    pub fn carried_clearance(&self, clearance: &IdVec<VertexId, Clearance>) -> IdVec<VertexId, Clearance> {
        let vertices = &self.derivation.vertices;
        let of = |row| vertices.at(row).iter().fold(UNBOUNDED, |smallest, &(v, _)| smaller(smallest, clearance[v]));
        (0..vertices.len()).map(of).collect()
    }

    /// The source vertices in the parent of some faces, each once.
    pub fn sources(&self, faces: &[FaceId]) -> BTreeSet<VertexId> {
        let vertices = faces.iter().flat_map(|&f| self.derivation.faces.vertices_of(f));
        vertices.flat_map(|v| self.derivation.vertices.at(v.index()).iter().map(|s| s.0)).collect()
    }

    /// The points of the input garment at some vertices, as elements of a warning.
    pub fn input_points(&self, vertices: impl IntoIterator<Item = VertexId>) -> Elements {
        input_points(&self.inputs, vertices)
    }
}

/// Data of the input garment at the elements of a derived cage.
#[derive(Clone)]
pub struct Ancestry {
    /// Clearance that the garment leaves beside each vertex, before operators use it.
    pub clearance: Arc<IdVec<VertexId, Clearance>>,
    /// Reference normals.
    pub reference: Arc<ReferenceNormals>,
    /// The input garment.
    pub garment: Arc<Mesh>,
    /// Its level.
    pub level: Arc<Level>,
    /// Ancestor of each face in the garment.
    pub faces: Arc<IdVec<FaceId, FaceId>>,
    /// True for faces of hems and inner layers.
    pub covers: Arc<IdVec<FaceId, bool>>,
}

impl Ancestry {
    /// The data after an operator.
    fn carried(&self, output: &OperatorOutput) -> Self {
        let is_copy = output.index(|role| role.original().is_some()).iter().map(Option::is_some).collect();
        let is_inner = output.index(|role| matches!(role, ControlRole::Copy { side, .. } if side < 0.0));
        let faces = &output.derivation.faces;
        let covers = |face| {
            let is_new = faces.vertices_of(face).iter().any(|&v| is_inner[v].is_some());
            is_new || self.covers[output.derivation.parent_face(face)]
        };
        let parents = faces.ids().map(|face| output.derivation.parent_face(face));
        Self {
            clearance: Arc::new(output.carried_clearance(&self.clearance)),
            reference: Arc::new(self.reference.carried(&output.derivation, &is_copy)),
            faces: Arc::new(parents.map(|face| self.faces[face]).collect()),
            covers: Arc::new(faces.ids().map(covers).collect()),
            ..self.clone()
        }
    }
}

/// The cage of an operator, without primvars and heights.
pub struct DerivedCage {
    /// The output of the operator.
    pub output: OperatorOutput,
    /// The mesh without primvars and heights.
    pub frame: Mesh,
    /// Data of the input garment.
    pub ancestry: Ancestry,
}

impl DerivedCage {
    /// Applies an operator to a cage.
    ///
    /// # Errors
    /// As [`Operator::apply`].
    pub fn new(operator: &dyn Operator, parent: &OperatorInput, ancestry: &Ancestry) -> Result<Self, Error> {
        let output = operator.apply(parent)?;
        let check = || output.derivation.check(&operator.label());
        let ((checked, frame), ancestry) =
            rayon::join(|| rayon::join(check, || output.frame(parent)), || ancestry.carried(&output));
        checked?;
        Ok(Self { output, frame, ancestry })
    }
}

/// Sharp corners of single faces that have several faces in the child.
fn kept_corners<'a>(parent: &'a Level, output: &'a OperatorOutput) -> impl Iterator<Item = VertexId> + 'a {
    let mut faces = vec![0u32; output.derivation.vertices.len()];
    output.derivation.faces.corners().iter().for_each(|v| faces[v.index()] += 1);
    parent.vertex_sharpness.ids().filter(move |&v| is_lone_corner(parent, v) && faces[v.index()] > 1)
}

/// True if a vertex is a sharp corner of a single face.
pub fn is_lone_corner(level: &Level, vertex: VertexId) -> bool {
    level.topology.vertex_corners.row(vertex).len() == 1 && level.vertex_sharpness[vertex] >= INFINITE_SHARPNESS
}
