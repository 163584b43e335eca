//! Tests of sewing without files.

use super::*;
use crate::error::Warnings;
use crate::garment::{PrimvarInput, SubsetInput, Units, Values, check_garment};
use glam::{DVec3, Vec3};

/// A flat sheet of `n` by `n` quads of side 1, with its first corner at `(x, 0, 0)`.
fn sheet(name: &str, n: i32, x: f32) -> Garment {
    let point = |i: i32| Vec3::new((i % (n + 1)) as f32 + x, (i / (n + 1)) as f32, 0.0);
    let corners = (0..n * n).map(|f| f / n * (n + 1) + f % n).flat_map(|i| [i, i + 1, i + n + 2, i + n + 1]);
    Garment {
        prim: format!("/Suit/{name}"),
        points: (0..(n + 1) * (n + 1)).map(point).collect(),
        face_vertex_counts: vec![4; (n * n) as usize],
        face_vertex_indices: corners.collect(),
        ..Garment::default()
    }
}

fn found(meshes: &[Garment]) -> Seams {
    let placed: Vec<_> = meshes.iter().map(|mesh| (mesh, DMat4::IDENTITY)).collect();
    find_seams(&placed, TOLERANCE).expect("few edges in one place")
}

fn merged(meshes: &[Garment], seams: &Seams) -> Result<(Sewn, Warnings), Error> {
    let name = |mesh: &Garment| mesh.prim.rsplit('/').next().unwrap_or_default().to_owned();
    let panels = meshes.iter().map(|mesh| Panel { name: name(mesh), mesh: mesh.clone() }).collect();
    merge("/Suit/all".into(), Units::default(), panels, &seams.welds)
}

#[test]
fn whole_edges_are_sewn_and_points_are_their_mean() {
    let mut right = sheet("right", 3, 3.0);
    right.points.iter_mut().for_each(|p| p.z = 0.0008);
    let meshes = [sheet("left", 3, 0.0), right, sheet("far", 3, 20.0)];
    let seams = found(&meshes);
    assert_eq!(seams.garments, [vec![0, 1], vec![2]]);
    assert_eq!((seams.seams[0].panels, seams.seams[0].edges), ([0, 1], 3));
    assert!((seams.seams[0].gap - 0.0008).abs() < 1e-6 && seams.unsewn.is_empty());

    let (sewn, _) = merged(&meshes[..2], &seams).expect("panels that agree");
    assert_eq!(sewn.mesh.points.len(), 2 * 16 - 4);
    assert_eq!((sewn.panels, sewn.seams.as_str()), (vec!["left".to_owned(), "right".to_owned()], "sewn"));
    assert!(sewn.mesh.points.iter().filter(|p| p.x == 3.0).all(|p| p.z == 0.0004));
    let (garment, _) = check_garment(sewn.mesh).expect("a good mesh");
    assert_eq!(garment.subset("sewn").map(|set| set.elements.len()), Some(3));
}

#[test]
fn single_points_are_not_sewn() {
    let mut corner = sheet("corner", 3, 3.0);
    corner.points.iter_mut().for_each(|p| p.y += 3.0);
    let seams = found(&[sheet("left", 3, 0.0), corner]);
    assert_eq!((seams.garments.len(), seams.unsewn.len()), (2, 0));
}

#[test]
fn borders_with_other_points_are_told() {
    let mut fine = sheet("fine", 6, 6.0);
    fine.points.iter_mut().for_each(|p| *p *= 0.5);
    let seams = found(&[sheet("left", 3, 0.0), fine]);
    assert_eq!(seams.garments.len(), 2);
    let [unsewn] = seams.unsewn.as_slice() else { panic!("{:?}", seams.unsewn) };
    assert_eq!(unsewn.edges.each_ref().map(Vec::len), [3, 6]);
    assert!((unsewn.place[0] - 3.0).abs() < 1e-9);
}

#[test]
fn transforms_bring_borders_together_and_mirrors_turn_faces() {
    let right = sheet("right", 3, 0.0);
    let mirror = DMat4::from_translation(DVec3::new(6.0, 0.0, 0.0)) * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let left = sheet("left", 3, 0.0);
    let seams = find_seams(&[(&left, DMat4::IDENTITY), (&right, mirror)], TOLERANCE).expect("two sheets");
    assert_eq!(seams.seams[0].edges, 3);
    let mut placed = right;
    place(&mut placed, &mirror);
    let (sewn, mut warnings) = merged(&[left, placed], &seams).expect("panels that agree");
    warnings.absorb(check_garment(sewn.mesh).expect("a good mesh"));
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn a_slit_narrower_than_the_tolerance_is_no_reason_to_close_a_face() {
    // The last face of the sheet is a sliver whose two corners at the seam are nearer than the tolerance.
    let mut left = sheet("left", 3, 0.0);
    left.points[7].y = 0.0004;
    let seams = found(&[left.clone(), sheet("right", 3, 3.0)]);
    // The short edge matches nothing, so its ends stay apart.
    assert!(merged(&[left, sheet("right", 3, 3.0)], &seams).is_ok());
}

#[test]
fn values_keep_their_panel_and_sets_their_name() {
    let mut meshes = [sheet("left", 2, 0.0), sheet("right", 2, 2.0)];
    for (i, mesh) in meshes.iter_mut().enumerate() {
        let uvs: Vec<[f32; 2]> = mesh.points.iter().map(|p| [p.x, p.y]).collect();
        // One panel with indices and one without: each stays one shell.
        let mut uvs = PrimvarInput::uvs("st", &uvs, mesh.face_vertex_indices.clone());
        if i == 1 {
            let rows = mesh.face_vertex_indices.iter().map(|&p| p as usize);
            uvs = PrimvarInput { values: uvs.values.gather(2, rows), indices: None, ..uvs };
        }
        let weights = PrimvarInput::weights("weight", vec![i as f32; 9]);
        mesh.primvars = vec![uvs, weights];
        let (name, element_type) = ("hem".to_owned(), "face".to_owned());
        mesh.subsets = vec![SubsetInput { name, element_type, family: String::new(), indices: vec![0, 1] }];
    }
    let (sewn, warnings) = merged(&meshes, &found(&meshes)).expect("panels that agree");
    assert_eq!(sewn.mesh.subsets[0].indices, [0, 1, 4, 5]);
    let (garment, _) = check_garment(sewn.mesh).expect("a good mesh");
    let (st, weight) = (garment.primvar("st").expect("UVs"), garment.primvar("weight").expect("weights"));
    let rows: std::collections::BTreeSet<u32> = st.indices.as_ref().expect("indices").iter().copied().collect();
    assert_eq!(rows.len(), 18);
    let Values::F32(values) = &weight.values else { panic!("floats") };
    let on_seam = |x: f32| garment.points.iter().zip(values).filter(move |(p, _)| p.x == x).map(|(_, w)| *w);
    assert!(on_seam(2.0).all(|w| w == 0.5) && on_seam(1.0).all(|w| w == 0.0) && on_seam(3.0).all(|w| w == 1.0));
    assert_eq!(warnings.iter().count(), 1);
}

#[test]
fn many_copies_in_one_place_are_found_without_comparing_all_edges() {
    // 30 sheets of 120 border edges each, all at one place.
    let meshes: Vec<Garment> = (0..30).map(|i| sheet(&i.to_string(), 30, 0.0)).collect();
    let seams = found(&meshes);
    assert_eq!((seams.garments.len(), seams.seams.len()), (1, 30 * 29 / 2));
    assert!(seams.seams.iter().all(|seam| seam.edges == 120));
}
