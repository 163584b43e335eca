//! A valid garment, what it becomes, and the oddities that are only warned of. The faults have a file of their own.

mod families;
mod faults;
mod repeats;

use super::*;
use crate::codes;
use crate::connectivity::{FaceId, VertexId};
use crate::error::WarningCode;
use crate::garment::{
    Corner, Crease, Elements, Family, FamilyType, Interpolation, Meaning, Primvar, PrimvarInput, Scheme,
    SubdivisionRules, Subset, SubsetInput, Values,
};
use glam::Vec3;
use std::sync::Arc;

/// A cloth of 2 x 2 quads over 3 x 3 points, numbered row by row, with an attribute of each kind.
fn cloth() -> Garment {
    let point = |i: usize| Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0);
    Garment {
        prim: "/Coat/model".into(),
        points: (0..9).map(point).collect(),
        face_vertex_counts: vec![4; 4],
        face_vertex_indices: vec![0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7],
        hole_indices: vec![3, 1],
        crease_indices: vec![1, 4, 7, 4, 5],
        crease_lengths: vec![3, 2],
        crease_sharpnesses: vec![2.5, 3.0, f32::INFINITY],
        corner_indices: vec![8, 0],
        corner_sharpnesses: vec![f32::INFINITY, 4.0],
        primvars: vec![uv(), weights(), joints(), uniform(), varying()],
        subsets: vec![
            subset("right", "face", "panels", &[3, 1]),
            subset("left", "face", "panels", &[0, 2]),
            subset("placket", "edge", "seams", &[7, 4, 1, 4]),
            subset("waist", "edge", "seams", &[4, 3]),
            subset("pins", "point", "", &[8, 2]),
        ],
        families: vec![
            Family { name: "panels".into(), kind: FamilyType::Partition },
            Family { name: "seams".into(), kind: FamilyType::NonOverlapping },
            Family { name: "empty".into(), kind: FamilyType::Partition },
        ],
        ..Garment::default()
    }
}

/// Two columns of UVs, cut along the middle; value 12 is used by no corner.
fn uv() -> PrimvarInput {
    let values = Values::F32((0..26).map(|i| i as f32 / 10.0).collect());
    let indices = Some(vec![0, 1, 4, 3, 2, 6, 7, 5, 3, 4, 9, 8, 5, 7, 11, 10]);
    let st = PrimvarInput::new("st", Interpolation::FaceVarying, values);
    PrimvarInput { meaning: Meaning::TextureCoordinate, components: 2, indices, ..st }
}

fn weights() -> PrimvarInput {
    let values = Values::F32([0.25, 0.75].repeat(9));
    PrimvarInput { element_size: 2, ..PrimvarInput::new("skel:jointWeights", Interpolation::Vertex, values) }
}

fn joints() -> PrimvarInput {
    let joints = PrimvarInput::new("skel:jointIndices", Interpolation::Vertex, Values::I32([0, 1].repeat(9)));
    PrimvarInput { element_size: 2, ..joints }
}

fn uniform() -> PrimvarInput {
    PrimvarInput::new("ply", Interpolation::Uniform, Values::F64(vec![1.0, 2.0, 3.0, 4.0]))
}

fn varying() -> PrimvarInput {
    PrimvarInput::new("tint", Interpolation::Varying, Values::F32(vec![0.5; 9]))
}

fn subset(name: &str, element_type: &str, family: &str, indices: &[i32]) -> SubsetInput {
    let (element_type, family, indices) = (element_type.into(), family.into(), indices.to_vec());
    SubsetInput { name: name.into(), element_type, family, indices }
}

#[test]
fn a_valid_garment_is_kept_as_it_was_authored() {
    let mut input = cloth();
    input.hole_indices = vec![3, 1, 3];
    input.rules = SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() };
    let (garment, warnings) = check_garment(input).expect("the cloth is valid");
    assert!(warnings.is_empty(), "{warnings:?}");

    let given = cloth();
    assert_eq!(garment.prim, given.prim);
    assert_eq!(*garment.points, given.points);
    let corners: Vec<i32> = garment.faces.corners().iter().map(|v| v.index() as i32).collect();
    assert_eq!(corners, given.face_vertex_indices);
    assert_eq!((garment.faces.len(), garment.faces.regular_valence()), (4, Some(4)));
    assert_eq!(garment.rules.scheme, Scheme::Bilinear);
    assert_eq!(garment.holes, [3, 1].map(FaceId::new));
    assert_eq!(garment.creases, creases());
    let corner = |vertex, sharpness| Corner { vertex: VertexId::new(vertex), sharpness };
    assert_eq!(garment.corners, [corner(8, 10.0), corner(0, 4.0)]);
    assert_eq!(*garment.primvars, given.primvars.into_iter().map(unchecked).collect::<Vec<_>>());
    assert_eq!(*garment.subsets, checked_subsets());
    assert_eq!(garment.families, given.families);
}

/// The creases of the cloth.
fn creases() -> [Crease; 2] {
    let crease = |vertices: &[usize], sharpnesses: &[f32]| Crease {
        vertices: vertices.iter().map(|&v| VertexId::new(v)).collect(),
        sharpnesses: sharpnesses.to_vec(),
    };
    [crease(&[1, 4, 7], &[2.5, 3.0]), crease(&[4, 5], &[10.0])]
}

/// A primvar as it is, indices aside.
fn unchecked(p: PrimvarInput) -> Primvar {
    Primvar {
        name: p.name,
        role: p.role,
        meaning: p.meaning,
        half: p.half,
        interpolation: p.interpolation,
        components: p.components,
        element_size: p.element_size as usize,
        values: p.values,
        indices: p.indices.map(|i| Arc::new(i.into_iter().map(|i| i as u32).collect())),
    }
}

/// The subsets of the cloth.
fn checked_subsets() -> Vec<Subset> {
    let faces = |faces: [usize; 2]| Elements::Faces(faces.map(FaceId::new).to_vec());
    let edges = |edges: &[[usize; 2]]| Elements::Edges(edges.iter().map(|e| e.map(VertexId::new)).collect());
    let points = Elements::Points([8, 2].map(VertexId::new).to_vec());
    let subset = |name: &str, family: &str, elements| Subset {
        name: name.into(),
        family: family.into(),
        elements,
        sharpness: None,
    };
    vec![
        subset("right", "panels", faces([3, 1])),
        subset("left", "panels", faces([0, 2])),
        subset("placket", "seams", edges(&[[7, 4], [1, 4]])),
        subset("waist", "seams", edges(&[[4, 3]])),
        subset("pins", "", points),
    ]
}

#[test]
fn one_sharpness_a_crease_is_given_to_its_edges() {
    let mut input = cloth();
    input.crease_sharpnesses = vec![1.5, 12.0];
    let (garment, _) = check_garment(input).expect("one a crease is valid");
    assert_eq!(garment.creases[0].sharpnesses, [1.5, 1.5]);
    assert_eq!(garment.creases[1].sharpnesses, [12.0]);
}

#[test]
fn faces_of_any_valence_are_kept() {
    let mut input = bare(&[&[0, 1, 4], &[0, 4, 3], &[1, 2, 5, 8, 4]]);
    input.points.truncate(9);
    let (garment, _) = check_garment(input).expect("n-gons are valid");
    let valences: Vec<usize> = garment.faces.ids().map(|f| garment.faces.valence(f)).collect();
    assert_eq!(valences, [3, 3, 5]);
    let mut triangles = bare(&[&[0, 1, 4], &[0, 4, 3]]);
    triangles.rules.scheme = Scheme::Loop;
    assert!(check_garment(triangles).is_ok());
}

/// Faces over the points of the cloth and one above its middle (9), without any attribute.
fn bare(faces: &[&[i32]]) -> Garment {
    let mut points = cloth().points;
    points.push(Vec3::new(1.0, 1.0, 1.0));
    Garment {
        prim: "/Coat/model".into(),
        points,
        face_vertex_counts: faces.iter().map(|f| f.len() as i32).collect(),
        face_vertex_indices: faces.concat(),
        ..Garment::default()
    }
}

/// The warnings for `faces`, those for unused points aside.
fn warnings_for(faces: &[&[i32]]) -> Vec<(WarningCode, Elements)> {
    let (_, warnings) = check_garment(bare(faces)).expect("odd, but no error");
    let others = warnings.iter().filter(|w| w.code != codes::UNUSED_POINTS);
    others.map(|w| (w.code, w.elements.clone())).collect()
}

fn vertices<const N: usize>(numbers: [usize; N]) -> Elements {
    Elements::Points(numbers.map(VertexId::new).to_vec())
}

#[test]
fn oddities_are_counted_and_located() {
    let edge = || Elements::Edges(vec![[1, 4].map(VertexId::new)]);
    let face = || Elements::Faces(vec![FaceId::new(1)]);
    let three_on_an_edge = warnings_for(&[&[0, 1, 4, 3], &[1, 2, 5, 4], &[1, 4, 9]]);
    let expected = [(codes::NON_MANIFOLD_EDGES, edge()), (codes::BOW_TIE_VERTICES, vertices([1, 4]))];
    assert_eq!(three_on_an_edge, expected);

    let bow_tie = warnings_for(&[&[0, 1, 4, 3], &[4, 5, 8, 7]]);
    assert_eq!(bow_tie, [(codes::BOW_TIE_VERTICES, vertices([4]))]);

    let flipped = warnings_for(&[&[0, 1, 4, 3], &[1, 4, 5, 2]]);
    assert_eq!(flipped, [(codes::WINDING_DISAGREEMENTS, edge())]);

    let collinear = warnings_for(&[&[0, 1, 4, 3], &[3, 4, 5]]);
    assert_eq!(collinear, [(codes::DEGENERATE_FACES, face())]);

    let twice = warnings_for(&[&[0, 1, 4, 3], &[4, 1, 0, 3]]);
    assert_eq!(twice, [(codes::DUPLICATE_FACES, face())]);
}

#[test]
fn closed_fans_and_borders_are_not_bow_ties() {
    assert_eq!(warnings_for(&[&[0, 1, 4, 3], &[1, 2, 5, 4], &[3, 4, 7, 6], &[4, 5, 8, 7]]), []);
    assert_eq!(warnings_for(&[&[0, 1, 9], &[1, 4, 9], &[4, 3, 9], &[3, 0, 9]]), []);
}

#[test]
fn all_oddities_are_listed_and_the_first_three_are_printed() {
    let (_, warnings) = check_garment(bare(&[&[0, 1, 4]])).expect("unused points are not an error");
    let [warning] = &warnings.iter().collect::<Vec<_>>()[..] else { panic!("{warnings:?}") };
    assert_eq!((warning.code, &warning.elements), (codes::UNUSED_POINTS, &vertices([2, 3, 5, 6, 7, 8, 9])));
    let printed = "/Coat/model: 7 points have no face (points 2, 3, 5, …). ";
    assert!(warning.to_string().starts_with(printed), "{warning}");
}

#[test]
fn a_face_far_from_the_origin_has_its_area() {
    let mut input = bare(&[&[0, 1, 4, 3], &[1, 2, 5, 4]]);
    input.points.iter_mut().for_each(|p| *p = *p * 1e-3 + Vec3::splat(1000.0));
    let (_, warnings) = check_garment(input).expect("small faces are not an error");
    assert!(!warnings.iter().any(|w| w.code == codes::DEGENERATE_FACES), "{warnings:?}");
}
