//! What crosses on the second refinement of a cage, and what parts it.
//!
//! A refinement moves the points of the one before it. Where two sheets all but touch, or a fold is tight, faces that do
//! not cross on the first may cross on the second. Only the part of the cage that is close to itself is refined twice.

use super::apart::{Quad, on_two_sides, separating_axis};
use super::close::ChildOf;
use super::skin::{Skin, place};
use super::untangle::{Apart, Row, add_row};
use super::{each_once, faces_at};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::subdivide::{Level, Numbering, Stencils, VertexRows};
use glam::Vec3;
use rayon::prelude::*;

/// Pairs of children that are looked at in one go. Fewer refine more of the cage twice.
const PART: usize = 1024;

/// A cage before any operator, which later ones are held to.
pub struct Before<'a> {
    /// Its level.
    pub level: &'a Level,
    /// Its points.
    pub points: &'a IdVec<VertexId, Vec3>,
    /// The face of it that each face of the last cage is part of.
    pub parent_faces: &'a IdVec<FaceId, FaceId>,
}

/// Faces that cross on the second refinement, and how they are parted.
pub struct Later {
    /// The faces.
    pub pairs: Vec<[FaceId; 2]>,
    /// What is to hold of the points.
    pub apart: Vec<Apart>,
}

/// Of children of a skin that are close to each other, those whose own children cross, and did not before.
///
/// They are parted as they are where the points of the cage are `parted`.
pub fn crossing_later(skin: &Skin, parted: &IdVec<VertexId, Vec3>, close: &[[ChildOf; 2]], before: &Before) -> Later {
    let parts: Vec<Later> = close.par_chunks(PART).map(|close| of_part(skin, parted, close, before)).collect();
    let mut all = Later { pairs: Vec::new(), apart: Vec::new() };
    for part in parts {
        all.pairs.extend(part.pairs);
        all.apart.extend(part.apart);
    }
    Later { pairs: each_once(all.pairs), ..all }
}

/// The same of pairs that are looked at in one go.
fn of_part(skin: &Skin, parted: &IdVec<VertexId, Vec3>, close: &[[ChildOf; 2]], before: &Before) -> Later {
    let ahead = Ahead::new(skin.level, &children_of(close), |v| skin.child_point(v));
    let next = ahead.skin();
    let mut found = ahead.crossing(&next, close);
    let parents = |pair: &[ChildOf; 2]| pair.map(|(face, _)| before.parent_faces[face]);
    let known = before.crossing(&each_once(found.iter().map(parents).map(sorted).collect()));
    found.retain(|pair| known.binary_search(&sorted(parents(pair))).is_err());
    let pairs = found.iter().map(|pair| sorted(pair.map(|(face, _)| face))).collect();
    let parting = Parting { ahead: &ahead, skin: &next, rows: &skin.rows, points: parted };
    Later { pairs, apart: found.iter().flat_map(|pair| parting.apart(pair)).collect() }
}

impl Before<'_> {
    /// Of pairs of faces, those that cross on the second refinement.
    fn crossing(&self, pairs: &[[FaceId; 2]]) -> Vec<[FaceId; 2]> {
        if pairs.is_empty() {
            return Vec::new();
        }
        let faces = &self.level.topology.faces;
        let of = |face: FaceId| (0..faces.valence(face)).map(move |number| (face, number));
        let all = pairs.iter().flat_map(|&[f, g]| of(f).flat_map(move |a| of(g).map(move |b| [a, b])));
        let all: Vec<[ChildOf; 2]> = all.collect();
        let rows = self.level.vertex_stencils();
        let ahead = Ahead::new(self.level, &children_of(&all), |v| place(&rows, v, self.points));
        let found = ahead.crossing(&ahead.skin(), &all);
        each_once(found.iter().map(|pair| sorted(pair.map(|(face, _)| face))).collect())
    }
}

/// A part of a cage that is refined.
struct Ahead {
    /// The children that are looked at, in their order.
    children: Vec<ChildOf>,
    /// Each of them in the refined part.
    places: Vec<FaceId>,
    refined: Level,
    /// The vertices of the refined part in the refinement of the whole.
    vertices: IdVec<VertexId, VertexId>,
    points: IdVec<VertexId, Vec3>,
}

impl Ahead {
    /// The part of a cage that the children of some children depend on, which are in their order. `point` is where a vertex
    /// of the first refinement is.
    fn new(level: &Level, children: &[ChildOf], point: impl Fn(VertexId) -> Vec3) -> Self {
        let t = &level.topology;
        // Of what is further away they depend by the points alone.
        let corner = |&(face, number): &ChildOf| t.faces.vertices_of(face)[number];
        let faces = faces_at(t, children.iter().map(corner));
        let (part, own) = level.part(&faces);
        let [whole, within] = [level, &part].map(Numbering::new);
        let mut vertices = IdVec::filled(VertexId::new(0), within.vertices());
        own.enumerated().for_each(|(v, &old)| vertices[within.of_vertex(v)] = whole.of_vertex(old));
        part.topology.faces.ids().zip(&faces).for_each(|(f, &old)| vertices[within.of_face(f)] = whole.of_face(old));
        let corners = faces.iter().flat_map(|&f| t.faces.corners_of(f));
        corners.zip(part.topology.corner_edge.iter()).for_each(|(old, &edge)| {
            vertices[within.of_edge(edge)] = whole.of_edge(t.corner_edge[old]);
        });
        let points = vertices.iter().map(|&v| point(v)).collect();
        let of_part = &part.topology.faces;
        let place = |&(face, number): &ChildOf| {
            let parent = FaceId::new(faces.partition_point(|&f| f < face));
            within.of_face_within(of_part, parent).nth(number).unwrap_or(parent)
        };
        let places = children.iter().map(place).collect();
        Self { children: children.to_vec(), places, refined: part.refined(), vertices, points }
    }

    /// A child as a face of the refined part.
    fn place(&self, child: ChildOf) -> FaceId {
        self.places[self.children.partition_point(|&other| other < child)]
    }

    /// The skin of the children.
    fn skin(&self) -> Skin<'_> {
        let mut skin = Skin::bare(&self.refined);
        skin.learn(&self.points, &self.places);
        skin
    }

    /// Pairs that cross.
    fn crossing(&self, skin: &Skin, pairs: &[[ChildOf; 2]]) -> Vec<[ChildOf; 2]> {
        let cross = |pair: &&[ChildOf; 2]| {
            let [a, b] = pair.map(|child| self.place(child));
            skin.cross(a, b)
        };
        pairs.par_iter().filter(cross).copied().collect()
    }
}

/// How what crosses on the second refinement is parted.
struct Parting<'a> {
    ahead: &'a Ahead,
    /// That of the part.
    skin: &'a Skin<'a>,
    /// What each vertex of the first refinement is made of.
    rows: &'a VertexRows<'a>,
    /// The points of the cage while it did not cross.
    points: &'a IdVec<VertexId, Vec3>,
}

impl Parting<'_> {
    /// What parts two children that cross: the plane that parts them before they are refined.
    fn apart(&self, pair: &[ChildOf; 2]) -> Vec<Apart> {
        let [a, b] = pair.map(|child| self.ahead.place(child));
        let axis = separating_axis(&self.quad(a), &self.quad(b));
        let crossing = self.skin.crossing_children(a, b).into_iter();
        crossing.flat_map(|children| on_two_sides(self.skin, children, axis, |v| self.row(v))).collect()
    }

    fn quad(&self, face: FaceId) -> Quad {
        let vertices = self.ahead.refined.topology.faces.vertices_of(face);
        let vertices = std::array::from_fn(|i| vertices[i]);
        Quad { points: vertices.map(|v| place(self.rows, self.ahead.vertices[v], self.points)), vertices }
    }

    /// A point of the second refinement.
    fn row(&self, vertex: VertexId) -> Row {
        let mut row = Row::new();
        self.skin.rows.row(vertex.index(), &mut |middle, weight| {
            add_row(&mut row, self.rows, self.ahead.vertices[middle], weight);
        });
        row
    }
}

/// The children of pairs, each once, in their order.
fn children_of(pairs: &[[ChildOf; 2]]) -> Vec<ChildOf> {
    each_once(pairs.iter().flatten().copied().collect())
}

fn sorted([a, b]: [FaceId; 2]) -> [FaceId; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::super::close::Nearness;
    use super::super::untangle::{Wanted, untangled};
    use super::*;
    use crate::garment::{Crease, Garment};
    use crate::mesh::Faces;
    use crate::subdivide::{Cage, carried_points};

    /// The first vertex of the small quad.
    const QUAD: usize = 25;
    /// How high it may be so that nothing crosses on any refinement.
    const LOW: f32 = 0.05;
    /// How high it is below the first refinement and through the second one.
    const HIGH: f32 = 0.098;

    /// Sixteen quads with a ridge across their middle, and a small quad that stands below one of them as high as `top`.
    fn ridge(top: f32) -> Cage {
        let sheet = (0..25).map(|i| Vec3::new((i % 5) as f32, (i / 5) as f32, if i % 5 == 2 { 0.2 } else { 0.0 }));
        let small = [(2.49, 0.02), (2.51, 0.02), (2.51, top), (2.49, top)].map(|(x, z)| Vec3::new(x, 2.3, z));
        let first = (0..20).filter(|i| i % 5 < 4);
        let quads = first.flat_map(|i| [i, i + 1, i + 6, i + 5]).chain(QUAD..QUAD + 4).map(VertexId::new);
        Cage::new(Garment {
            points: sheet.chain(small).collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            ..Garment::default()
        })
    }

    fn skin<'a>(cage: &'a Cage, points: &IdVec<VertexId, Vec3>) -> Skin<'a> {
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        Skin::new(cage.level(), points, &all, None)
    }

    fn close(skin: &Skin) -> Vec<[ChildOf; 2]> {
        let all: Vec<FaceId> = skin.level.topology.faces.ids().collect();
        Nearness::new(skin).close(skin, &all)
    }

    /// What crosses later of a cage with these points, and did not where the small quad was as high as `before`.
    fn later(cage: &Cage, points: &IdVec<VertexId, Vec3>, before: f32) -> Later {
        let (skin, input) = (skin(cage, points), ridge(before));
        let faces = cage.garment().faces.ids().collect();
        let before = Before { level: input.level(), points: &input.garment().points, parent_faces: &faces };
        crossing_later(&skin, points, &close(&skin), &before)
    }

    #[test]
    fn what_crosses_on_the_second_refinement_is_found() {
        let cage = ridge(HIGH);
        let points = &cage.garment().points;
        let all: Vec<FaceId> = cage.garment().faces.ids().collect();
        assert!(skin(&cage, points).crossings(&all).is_empty(), "on the first");
        let both = [10, 16].map(FaceId::new);
        assert_eq!(later(&cage, points, LOW).pairs, [both]);
        assert_eq!(later(&cage, points, HIGH).pairs, [[both[0]; 2]; 0], "it did before");
        let low = ridge(LOW);
        assert_eq!(later(&low, &low.garment().points, LOW).pairs, [[both[0]; 2]; 0]);
        assert!(close(&skin(&low, &low.garment().points)).is_empty());
    }

    #[test]
    fn what_crosses_is_parted_by_small_moves() {
        let cage = ridge(HIGH);
        let points = &cage.garment().points;
        let wanted = Wanted { apart: later(&cage, points, LOW).apart, ..Wanted::default() };
        let after = untangled(&skin(&cage, points), points, &wanted, &[]).points;
        assert!(later(&cage, &after, LOW).pairs.is_empty());
        assert!(points.ids().all(|v| points[v].distance(after[v]) < 0.05));
        assert!(points.ids().any(|v| points[v] != after[v]));
    }

    /// Two pentagons, two triangles and three quads, with a crease.
    fn mixed() -> Cage {
        let places = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [0.0, 1.0], [1.2, 1.1], [2.0, 1.0], [3.0, 1.0]];
        let above = [[0.0, 2.0], [1.0, 2.0], [2.0, 2.0], [3.0, 2.0], [1.0, 3.0]];
        let all = places.into_iter().chain(above).enumerate();
        let points = all.map(|(i, [x, y])| Vec3::new(x, y, (i * i % 7) as f32 / 7.0));
        let faces: [&[usize]; 7] =
            [&[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7], &[2, 7, 6], &[4, 5, 9, 12, 8], &[5, 6, 10, 9], &[6, 7, 11, 10]];
        let corners = faces.iter().flat_map(|face| face.iter().copied().map(VertexId::new));
        let crease = Crease { vertices: [1, 5, 9].map(VertexId::new).to_vec(), sharpnesses: vec![1.5, 3.0] };
        Cage::new(Garment {
            points: points.collect(),
            faces: Faces::mixed(faces.iter().map(|face| face.len()), corners.collect::<Vec<_>>()),
            creases: vec![crease],
            ..Garment::default()
        })
    }

    #[test]
    fn a_part_is_refined_as_the_whole_is() {
        let cage = mixed();
        let (level, first) = (cage.level(), carried_points(&cage.level().vertex_rows(), &cage.garment().points));
        let (numbering, whole) = (Numbering::new(level), level.refined());
        let mut expected = Skin::bare(&whole);
        expected.learn(&first, &whole.topology.faces.ids().collect::<Vec<_>>());
        let faces = &level.topology.faces;
        for face in faces.ids() {
            for (number, in_whole) in numbering.of_face_within(faces, face).enumerate() {
                let ahead = Ahead::new(level, &[(face, number)], |v| first[v]);
                let skin = ahead.skin();
                let place = ahead.place((face, number));
                for child in 0..4 {
                    let (found, right) = (skin.child_quad((place, child)), expected.child_quad((in_whole, child)));
                    let same = found.iter().zip(&right).all(|(a, b)| a.abs_diff_eq(*b, 1e-6));
                    assert!(same, "child {child} of {number} of {face:?}: {found:?}, not {right:?}");
                }
            }
        }
    }
}
