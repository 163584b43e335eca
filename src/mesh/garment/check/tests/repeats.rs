//! Faces that name a point more than once.

use super::{cloth, subset};
use crate::codes;
use crate::connectivity::FaceId;
use crate::error::{Warning, Warnings};
use crate::garment::{Elements, Garment, Interpolation, Mesh, PrimvarInput, Values, check_garment, split_repeats};
use glam::Vec3;

/// Values that tell from which corner or face they come.
fn counted(name: &str, interpolation: Interpolation, count: usize) -> PrimvarInput {
    PrimvarInput::new(name, interpolation, Values::I32((0..count as i32).collect()))
}

/// A garment of some faces, each in a subset of its own, with a value for each face and each corner.
fn garment(faces: &[&[i32]]) -> Garment {
    let corners: Vec<i32> = faces.concat();
    let indexed = PrimvarInput {
        indices: Some((0..corners.len() as i32).rev().collect()),
        ..counted("indexed", Interpolation::FaceVarying, corners.len())
    };
    Garment {
        prim: "/Coat/model".into(),
        points: (0..12).map(|i| Vec3::new((i % 4) as f32, (i / 4) as f32, 0.0)).collect(),
        face_vertex_counts: faces.iter().map(|face| face.len() as i32).collect(),
        primvars: vec![
            counted("corner", Interpolation::FaceVarying, corners.len()),
            counted("face", Interpolation::Uniform, faces.len()),
            indexed,
        ],
        face_vertex_indices: corners,
        hole_indices: (0..faces.len() as i32).collect(),
        subsets: (0..faces.len() as i32).map(|f| subset(&format!("f{f}"), "face", "", &[f])).collect(),
        ..Garment::default()
    }
}

/// The checked garment without repeats, and the warning of them.
fn split(faces: &[&[i32]]) -> (Mesh, Garment, Warning) {
    let mut input = garment(faces);
    let warning = split_repeats(&mut input).expect("there are repeats");
    assert_eq!(warning.code, codes::REPEATED_POINTS);
    let (mesh, _) = check_garment(input.clone()).unwrap_or_else(|e| panic!("{e}"));
    (mesh, input, warning)
}

fn numbers(mesh: &Mesh, name: &str) -> Vec<i32> {
    let primvar = mesh.primvar(name).expect("it is kept");
    let Values::I32(values) = &primvar.values else { panic!("not integers") };
    (0..primvar.elements()).map(|element| values[primvar.row(element)]).collect()
}

fn faces(numbers: &[usize]) -> Elements {
    Elements::Faces(numbers.iter().copied().map(FaceId::new).collect())
}

/// Each corner has the values and each face the sets of the corner and the face that it was.
fn assert_followed(before: &[&[i32]], mesh: &Mesh, after: &Garment) {
    let old_corners: Vec<i32> = before.concat();
    let (corner, indexed) = (numbers(mesh, "corner"), numbers(mesh, "indexed"));
    for (at, &point) in after.face_vertex_indices.iter().enumerate() {
        assert_eq!(old_corners[corner[at] as usize], point, "corner {at}");
        assert_eq!(indexed[at], old_corners.len() as i32 - 1 - corner[at], "corner {at}");
    }
    for (face, old) in numbers(mesh, "face").into_iter().enumerate() {
        assert_eq!(after.face_numbers.in_file(faces(&[face])), faces(&[old as usize]));
        let set = mesh.subset(&format!("f{old}")).expect("a set for each face");
        let Elements::Faces(own) = &set.elements else { panic!("{set:?}") };
        assert!(own.contains(&FaceId::new(face)), "face {face} is in {set:?}");
    }
    let all: usize = mesh.subsets.iter().map(|set| set.elements.len()).sum();
    assert_eq!((all, mesh.holes.len()), (mesh.faces.len(), mesh.faces.len()));
}

#[test]
fn corners_that_follow_each_other_become_one() {
    let before: &[&[i32]] = &[&[0, 1, 5, 4], &[1, 1, 2, 5], &[2, 6, 5, 2], &[6, 7, 7, 7, 10]];
    let (mesh, after, warning) = split(before);
    assert_eq!(after.face_vertex_counts, [4, 3, 3, 3]);
    assert_eq!(after.face_vertex_indices, [0, 1, 5, 4, 1, 2, 5, 2, 6, 5, 6, 7, 10]);
    assert_eq!(numbers(&mesh, "corner"), [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 12, 13, 16]);
    assert_eq!(warning.elements, faces(&[1, 2, 3]));
    assert_followed(before, &mesh, &after);
}

#[test]
fn faces_of_fewer_than_three_points_are_left_out() {
    let before: &[&[i32]] = &[&[0, 0, 1], &[0, 1, 5, 4], &[5, 6, 5, 6], &[5, 6, 10, 9]];
    let (mesh, after, warning) = split(before);
    assert_eq!(after.face_vertex_counts, [4, 4]);
    assert_eq!(warning.elements, faces(&[0, 2]));
    assert!(warning.problem.contains("fewer than three points: faces 0, 2"), "{}", warning.problem);
    assert_followed(before, &mesh, &after);
    // Warnings of the mesh name the face of the file, and the other way round.
    let of_mesh: Warnings = [Warning::new(codes::DEGENERATE_FACES, "", "").at(faces(&[1]))].into_iter().collect();
    let in_file = after.face_numbers.warnings_in_file(of_mesh.clone());
    assert_eq!(in_file.iter().map(|w| w.elements.clone()).collect::<Vec<_>>(), [faces(&[3])]);
    assert_eq!(after.face_numbers.warnings_in_mesh(in_file), of_mesh);
}

#[test]
fn a_face_that_meets_itself_is_split() {
    let before: &[&[i32]] = &[&[0, 1, 5, 10, 9, 5], &[1, 2, 6, 5]];
    let (mesh, after, warning) = split(before);
    // The first part is in the place of the face, so that no other face has a new number.
    assert_eq!(after.face_vertex_counts, [3, 4, 3]);
    assert_eq!(warning.elements, faces(&[0]));
    assert!(warning.problem.contains("split where they meet themselves: face 0"), "{}", warning.problem);
    assert_eq!(numbers(&mesh, "face"), [0, 1, 0]);
    assert_followed(before, &mesh, &after);
}

#[test]
fn a_spur_is_removed() {
    let before: &[&[i32]] = &[&[0, 1, 2, 1, 5, 4]];
    let (mesh, after, _) = split(before);
    assert_eq!(after.face_vertex_indices, [0, 1, 5, 4]);
    assert_followed(before, &mesh, &after);
}

#[test]
fn a_face_around_a_hole_is_refused() {
    let mut input = garment(&[&[0, 3, 11, 8, 0, 5, 9, 6, 5]]);
    let before = input.clone();
    assert_eq!(split_repeats(&mut input), None);
    assert_eq!(input, before);
    let error = check_garment(input).expect_err("the hole would be filled").to_string();
    assert!(error.contains("face 0 has point 0 twice"), "{error}");
}

#[test]
fn meshes_without_repeats_and_with_other_faults_stay() {
    let changes: [fn(&mut Garment); 4] = [
        |_| {},
        |i| (i.face_vertex_indices[1], i.face_vertex_indices[5]) = (0, 90),
        |i| (i.face_vertex_indices[1], i.face_vertex_counts[0]) = (0, 3),
        |i| (i.face_vertex_indices[1], i.hole_indices[0]) = (0, 9),
    ];
    for change in changes {
        let mut input = cloth();
        change(&mut input);
        let before = input.clone();
        assert_eq!(split_repeats(&mut input), None);
        assert_eq!(input, before);
    }
}

#[test]
fn values_that_do_not_fit_the_mesh_do_not_fit_it_afterwards() {
    // A value for each corner that is left.
    let mut input = garment(&[&[0, 1, 5, 4], &[1, 1, 2, 5]]);
    input.primvars = vec![counted("short", Interpolation::FaceVarying, 7)];
    split_repeats(&mut input).expect("there are repeats");
    let (mesh, _) = check_garment(input).expect("no step needs it");
    assert!(mesh.primvar("short").is_none() && mesh.left_out("short").is_some());
}
