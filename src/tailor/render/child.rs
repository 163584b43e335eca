//! The connectivity that an operator makes of a cage, and the parents of its elements.
//!
//! The parent's vertices keep their numbers, and new ones follow: a number in a message is the user's own. Every new vertex
//! is a weighted sum of vertices of one parent face or edge. The same weights give the values at its corners, taken from
//! the parent face of each corner, so values of different UV shells never mix.

use rayon::prelude::*;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, Csr, EdgeId, FaceId, Faces, IdVec, Topology, ValueId, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Primvar};
pub use tailor_mesh::subdivide::Table;
use tailor_mesh::subdivide::{Derivation, Stencils, blended_channel};

/// Difference below which weights are equal: far above rounding, far below a visible one.
const SAME_WEIGHT: f32 = 1e-5;

/// The connectivity of an operator's cage.
#[derive(Clone, Debug)]
pub struct OperatorDerivation {
    parent: Topology,
    /// The child's faces.
    pub faces: Faces,
    parent_face: Vec<FaceId>,
    children: Csr<FaceId, FaceId>,
    /// Child vertices from parent vertices.
    pub vertices: Table<VertexId>,
    /// The children of each parent edge, in its direction.
    edges: Csr<EdgeId, [VertexId; 2]>,
}

/// Builds the connectivity of an operator's cage, face by face.
pub struct ChildBuilder<'a> {
    parent: &'a Topology,
    starts: Vec<usize>,
    counts: Vec<usize>,
    corners: Vec<VertexId>,
    parent_face: Vec<FaceId>,
    vertices: Table<VertexId>,
    edges: Vec<(EdgeId, [VertexId; 2])>,
}

impl<'a> ChildBuilder<'a> {
    /// A cage that has the parent's vertices and no face.
    pub fn new(parent: &'a Topology) -> Self {
        let mut vertices = Table::default();
        (0..parent.vertex_count()).for_each(|v| vertices.push([(VertexId::new(v), 1.0)]));
        let (faces, corners) = (parent.faces.len(), parent.faces.corners().len());
        Self {
            parent,
            starts: Vec::with_capacity(2 * faces),
            counts: Vec::with_capacity(2 * faces),
            corners: Vec::with_capacity(2 * corners),
            parent_face: Vec::with_capacity(2 * faces),
            vertices,
            edges: Vec::with_capacity(2 * parent.edges.len()),
        }
    }

    /// Adds a vertex that is a weighted sum of vertices of one parent face, or of the two that all its faces share.
    pub fn vertex(&mut self, sources: &[(VertexId, f32)]) -> VertexId {
        self.vertices.push(sources.iter().copied());
        VertexId::new(self.vertices.len() - 1)
    }

    /// The sources and weights of a vertex.
    pub fn sources(&self, vertex: VertexId) -> Vec<(VertexId, f32)> {
        self.vertices.at(vertex.index()).to_vec()
    }

    /// Number of vertices so far.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// The vertices of a face.
    pub fn corners_of(&self, face: usize) -> Vec<VertexId> {
        self.corners[self.starts[face]..self.starts[face] + self.counts[face]].to_vec()
    }

    /// The children of each parent edge so far.
    pub fn edges(&self) -> Csr<EdgeId, [VertexId; 2]> {
        Csr::group(self.parent.edges.len(), self.edges.iter().copied(), [VertexId::new(0); 2])
    }

    /// Number of faces so far.
    pub fn face_count(&self) -> usize {
        self.counts.len()
    }

    /// Adds a face that is part of a parent face.
    pub fn face(&mut self, parent: FaceId, corners: &[VertexId]) -> FaceId {
        self.starts.push(self.corners.len());
        self.counts.push(corners.len());
        self.corners.extend_from_slice(corners);
        self.parent_face.push(parent);
        FaceId::new(self.counts.len() - 1)
    }

    /// Adds a child of a parent edge, after those it has, in the direction of the parent.
    pub fn edge(&mut self, parent: EdgeId, child: [VertexId; 2]) {
        self.edges.push((parent, child));
    }

    /// The finished connectivity.
    pub fn finish(self) -> OperatorDerivation {
        let children = self.parent_face.iter().enumerate().map(|(child, &parent)| (parent, FaceId::new(child)));
        OperatorDerivation {
            children: Csr::group(self.parent.faces.len(), children, FaceId::new(0)),
            edges: self.edges(),
            parent: self.parent.clone(),
            faces: Faces::mixed(self.counts, self.corners),
            parent_face: self.parent_face,
            vertices: self.vertices,
        }
    }
}

impl OperatorDerivation {
    /// The weights of a child vertex as corners of a parent face, which has all its sources (see
    /// [`OperatorDerivation::check`]).
    fn at_corners<'a>(&'a self, vertex: VertexId, face: FaceId) -> impl Iterator<Item = (CornerId, f32)> + 'a {
        let corner = move |v: VertexId| self.corner_in(v, face).expect("checked: the parent face has all sources");
        self.vertices.at(vertex.index()).iter().map(move |&(v, w)| (corner(v), w))
    }

    fn corner_in(&self, parent: VertexId, face: FaceId) -> Option<CornerId> {
        self.parent.faces.corners_of(face).find(|&c| self.parent.faces.vertex(c) == parent)
    }

    /// Checks that each corner's vertex is made of vertices of the parent face, and that each vertex has a source.
    ///
    /// # Errors
    /// A fault of the operator, which `label` names.
    pub fn check(&self, label: &str) -> Result<(), Error> {
        let is_made_of = |vertex: VertexId, face: FaceId| {
            let sources = self.vertices.at(vertex.index());
            !sources.is_empty() && sources.iter().all(|&(v, _)| self.corner_in(v, face).is_some())
        };
        let is_bad = |child: &FaceId| {
            let parent = self.parent_face[child.index()];
            !self.faces.vertices_of(*child).iter().all(|&v| is_made_of(v, parent))
        };
        match (0..self.faces.len()).into_par_iter().map(FaceId::new).find_first(is_bad) {
            None => Ok(()),
            Some(face) => {
                let parent = self.parent_face[face.index()].index();
                let fault = format!(
                    "its face {} has a vertex that is not a sum of vertices of parent face {parent}",
                    face.index()
                );
                Err(Error::internal(format!("{label}: {fault}")))
            }
        }
    }
}

impl Derivation for OperatorDerivation {
    // A fold turns a line of edges around to the other layer, where lines that meet share a step.
    const EDGES_ARE_OWN: bool = false;

    fn parent(&self) -> &Topology {
        &self.parent
    }

    fn faces(&self) -> &Faces {
        &self.faces
    }

    fn parent_face(&self, child: FaceId) -> FaceId {
        self.parent_face[child.index()]
    }

    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId> {
        self.children.row(parent).iter().copied()
    }

    fn parent_corner(&self, child: CornerId) -> CornerId {
        let face = self.parent_face[self.faces.face_of(child).index()];
        let heavier = |a: (CornerId, f32), b: (CornerId, f32)| if b.1 > a.1 + SAME_WEIGHT { b } else { a };
        let heaviest = self.at_corners(self.faces.vertex(child), face).reduce(heavier);
        heaviest.map(|(corner, _)| corner).expect("checked: each vertex has a source")
    }

    fn child_vertex(&self, vertex: VertexId) -> VertexId {
        vertex
    }

    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>) {
        children.extend_from_slice(self.edges.row(edge));
    }

    fn remaining(&self, sharpness: f32) -> f32 {
        sharpness
    }

    fn vertex(&self) -> impl Stencils<Source = VertexId> {
        &self.vertices
    }

    fn varying(&self) -> impl Stencils<Source = VertexId> {
        &self.vertices
    }

    fn face_varying(&self, garment: &Mesh, place: usize) -> Primvar {
        let primvar = &garment.primvars[place];
        let rows = primvar.corner_rows(&garment.faces, garment.points.len());
        let (stencils, indices) = self.channel(&rows);
        blended_channel(&&stencils, Arc::new(indices), None, primvar)
    }
}

/// Vertices of one task.
const BLOCK: usize = 512;

/// The face-varying values at some child vertices in a row.
#[derive(Default)]
struct VertexValues {
    /// Sources and weights of each value.
    sums: Table<ValueId>,
    /// The value of each corner, by its row here.
    corners: Vec<(CornerId, usize)>,
}

impl OperatorDerivation {
    /// The values of a face-varying channel whose parent corners have `rows`, and the value of each child corner. Corners
    /// of a vertex share equal sums.
    fn channel(&self, rows: &IdVec<CornerId, u32>) -> (Table<ValueId>, Vec<u32>) {
        let corners = self.faces.corners();
        let by_vertex = corners.enumerated().map(|(c, &v)| (v, c));
        let by_vertex = Csr::group(self.vertices.len(), by_vertex, CornerId::new(0));
        let vertices = (0..self.vertices.len()).into_par_iter().map(VertexId::new);
        let add = |mut shared: VertexValues, v| {
            self.values_at(v, by_vertex.row(v), rows, &mut shared);
            shared
        };
        let (sums, of_corners): (Vec<_>, Vec<_>) =
            vertices.fold_chunks(BLOCK, VertexValues::default, add).map(|s| (s.sums, s.corners)).unzip();
        let mut corner_values = vec![0; corners.len()];
        let mut first = 0;
        for (sums, of_corners) in sums.iter().zip(of_corners) {
            of_corners.into_iter().for_each(|(c, row)| corner_values[c.index()] = (first + row) as u32);
            first += sums.len();
        }
        (Table::joined(&sums), corner_values)
    }

    /// Adds the values at a vertex.
    fn values_at(
        &self,
        vertex: VertexId,
        corners: &[CornerId],
        rows: &IdVec<CornerId, u32>,
        shared: &mut VertexValues,
    ) {
        let first = shared.sums.len();
        let mut sum: Vec<(ValueId, f32)> = Vec::with_capacity(4);
        for &corner in corners {
            let face = self.parent_face[self.faces.face_of(corner).index()];
            sum.clear();
            for (parent, weight) in self.at_corners(vertex, face) {
                let value = ValueId::new(rows[parent] as usize);
                match sum.iter_mut().find(|(v, _)| *v == value) {
                    Some((_, known)) => *known += weight,
                    None => sum.push((value, weight)),
                }
            }
            sum.sort_unstable_by_key(|(value, _)| *value);
            let known = (first..shared.sums.len()).find(|&row| same(shared.sums.at(row), &sum));
            let row = known.unwrap_or_else(|| {
                shared.sums.push(sum.iter().copied());
                shared.sums.len() - 1
            });
            shared.corners.push((corner, row));
        }
        debug_assert!(
            self.vertices.at(vertex.index()).len() > 1
                || (first..shared.sums.len()).all(|row| shared.sums.at(row).len() == 1)
        );
    }
}

fn same(a: &[(ValueId, f32)], b: &[(ValueId, f32)]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.0 == y.0 && (x.1 - y.1).abs() < SAME_WEIGHT)
}
