//! Halves faces at a fold that the surface bends across too far, before other operators run.
//!
//! ```text
//!   o-----------o          o-----o-----o     A face of a cuff of six spans a sixth of a turn. Where its fold ends, the
//!   |           |          |     |     |     border would overshoot by much of that bend. So the edges across the bend
//!   |           |    ->    |     |     |     are halved, from the border on through the strip of quads as far as it
//!   =============          ======.======     bends. The last halved edge leaves a pentagon behind it.
//! ```
//!
//! A face of a cuff of three spans a third of a turn: a second operator halves the halves of its edges.

use super::border;
use crate::contact::twice_area;
use crate::render::child::ChildBuilder;
use crate::render::operator::{Control, ControlRole, Operator, OperatorInput, OperatorOutput};
use std::any::Any;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Elements, Mesh};
use tailor_mesh::subdivide::Level;

/// Largest turn of the surface across a face at a fold; a circle of eight faces is not halved. \[radians\]
const MAX_TURN: f32 = 0.8;
/// Least length of an edge that is halved, as a multiple of the thickness of the fold: smaller bends are within the fold.
const LEAST_LENGTH: f32 = 4.0;

/// Halves edges, and the faces between them.
#[derive(Clone, Debug, PartialEq)]
struct Halving {
    /// The ends of the edges.
    edges: Vec<[VertexId; 2]>,
}

/// The operators that halve bent faces of the named subsets at the border of a garment. `thickness` is the largest
/// of the folds. \[mesh units\]
pub fn halving(garment: &Mesh, level: &Level, faces: &[String], thickness: f32) -> Vec<Arc<dyn Operator>> {
    let t = &level.topology;
    let turns = edge_turns(garment, t, &bent(garment, t, faces, LEAST_LENGTH * thickness));
    let (mut halved, mut again) = (Vec::new(), Vec::new());
    for edge in t.edges.ids().filter(|&edge| turns[edge] > 0.0) {
        let [a, b] = t.edges[edge];
        let middle = VertexId::new(t.vertex_count() + halved.len());
        halved.push([a, b]);
        if turns[edge] > 2.0 * MAX_TURN {
            again.extend([[a, middle], [middle, b]]);
        }
    }
    let operator = |edges: Vec<[VertexId; 2]>| Arc::new(Halving { edges }) as Arc<dyn Operator>;
    [halved, again].into_iter().filter(|edges| !edges.is_empty()).map(operator).collect()
}

/// The half-edges of folds, and of the border beside their ends, at quads that bend along them; none without ends. Edges
/// up to `least_length` are left out.
fn bent(garment: &Mesh, t: &Topology, faces: &[String], least_length: f32) -> Vec<CornerId> {
    let mut folded = IdVec::filled(false, t.faces.len());
    for subset in faces.iter().filter_map(|name| garment.subset(name)) {
        if let Elements::Faces(faces) = &subset.elements {
            faces.iter().for_each(|&face| folded[face] = true);
        }
    }
    let mut near = folded.clone();
    let vertices = folded.ids().filter(|&face| folded[face]).flat_map(|face| t.faces.vertices_of(face));
    vertices.flat_map(|&v| t.faces_at(v)).for_each(|face| near[face] = true);
    if border(t, &near).count() == border(t, &folded).count() {
        return Vec::new();
    }
    let length = |half: CornerId| {
        let [a, b] = t.faces.half_edge(half);
        garment.points[a].distance(garment.points[b])
    };
    let is_bent = |&half: &CornerId| length(half) > least_length && turn_along(garment, t, half) > MAX_TURN;
    border(t, &near).filter(is_bent).collect()
}

/// The turn for which each edge is halved: the largest of the strips of quads that lead there from `bent` half-edges; 0
/// for others. \[radians\]
fn edge_turns(garment: &Mesh, t: &Topology, bent: &[CornerId]) -> IdVec<EdgeId, f32> {
    let mut turns = IdVec::filled(0.0f32, t.edges.len());
    for &first in bent {
        let (mut half, turn) = (first, turn_along(garment, t, first));
        while turns[t.corner_edge[half]] < turn {
            turns[t.corner_edge[half]] = turn;
            let opposite = t.faces.next(t.faces.next(half));
            let Some(next) = t.twin(opposite).filter(|&next| turn_along(garment, t, next) > MAX_TURN) else {
                let last = &mut turns[t.corner_edge[opposite]];
                *last = last.max(turn);
                break;
            };
            half = next;
        }
    }
    turns
}

/// The turn of the surface across a quad along a half-edge: the smaller angle to its two neighbours there, so that a
/// single crease beside the face does not count; 0 for other faces. \[radians\]
fn turn_along(garment: &Mesh, t: &Topology, half: CornerId) -> f32 {
    let face = t.faces.face_of(half);
    if t.faces.valence(face) != 4 {
        return 0.0;
    }
    let normal = |face: FaceId| twice_area(t.faces.vertices_of(face), &garment.points).normalize_or_zero();
    let own = normal(face);
    let angle = |side: CornerId| t.twin(side).map(|twin| own.angle_between(normal(t.faces.face_of(twin))));
    let angles = [angle(t.faces.prev(half)), angle(t.faces.next(half))];
    let turn = angles.into_iter().flatten().reduce(f32::min).unwrap_or(0.0);
    if turn.is_finite() { turn } else { 0.0 }
}

impl Operator for Halving {
    fn label(&self) -> String {
        "fold".to_owned()
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    fn reach(&self, _: &Mesh) -> f32 {
        0.0
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        let t = cage.topology();
        let mut halved = IdVec::filled(false, t.edges.len());
        self.edges.iter().filter_map(|&[a, b]| t.find_edge(a, b)).for_each(|edge| halved[edge] = true);
        let mut builder = ChildBuilder::new(t);
        let mut middle: IdVec<EdgeId, Option<VertexId>> = IdVec::filled(None, t.edges.len());
        for (edge, &[a, b]) in t.edges.enumerated() {
            if halved[edge] {
                let vertex = builder.vertex(&[(a, 0.5), (b, 0.5)]);
                middle[edge] = Some(vertex);
                builder.edge(edge, [a, vertex]);
                builder.edge(edge, [vertex, b]);
            } else {
                builder.edge(edge, [a, b]);
            }
        }
        let mut on_surface = IdVec::filled(false, t.vertex_count());
        for face in t.faces.ids() {
            if add_face(t, face, &middle, &mut builder) {
                t.faces.vertices_of(face).iter().for_each(|&v| on_surface[v] = true);
            }
        }
        let mut on_border = IdVec::filled(false, t.vertex_count());
        let border = t.edges.ids().filter(|&edge| t.is_border(edge));
        border.for_each(|edge| t.edges[edge].iter().for_each(|&v| on_border[v] = true));
        // The middles of edges are those of the refinement of a B-spline; its old vertices move.
        let vertices = on_surface.ids().filter(|&v| on_surface[v]);
        let role = |v: VertexId| if on_border[v] { ControlRole::Kept } else { ControlRole::Surface };
        let controls = vertices.map(|vertex| Control { vertex, role: role(vertex) }).collect();
        Ok(OperatorOutput { controls, ..OperatorOutput::new(builder.finish(), cage) })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        vec![0.0; output.controls.len()]
    }
}

/// Adds the children of a face with the middles of its edges. True if it has any.
fn add_face(t: &Topology, face: FaceId, middle: &IdVec<EdgeId, Option<VertexId>>, builder: &mut ChildBuilder) -> bool {
    let corners: Vec<VertexId> = t.faces.vertices_of(face).to_vec();
    let middles: Vec<Option<VertexId>> = t.faces.corners_of(face).map(|c| middle[t.corner_edge[c]]).collect();
    match *middles.as_slice() {
        [Some(m), None, Some(n), None] => {
            builder.face(face, &[corners[0], m, n, corners[3]]);
            builder.face(face, &[m, corners[1], corners[2], n]);
        }
        [None, Some(m), None, Some(n)] => {
            builder.face(face, &[corners[0], corners[1], m, n]);
            builder.face(face, &[n, m, corners[2], corners[3]]);
        }
        [Some(k), Some(l), Some(m), Some(n)] => {
            let quarters: Vec<(VertexId, f32)> = corners.iter().map(|&v| (v, 0.25)).collect();
            let centre = builder.vertex(&quarters);
            for (corner, [before, after]) in corners.into_iter().zip([[n, k], [k, l], [l, m], [m, n]]) {
                builder.face(face, &[corner, after, centre, before]);
            }
        }
        _ => {
            let around = corners.into_iter().zip(middles.iter()).flat_map(|(v, middle)| [Some(v), *middle]);
            builder.face(face, &around.flatten().collect::<Vec<_>>());
        }
    }
    middles.iter().any(Option::is_some)
}
