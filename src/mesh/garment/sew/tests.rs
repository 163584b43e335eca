//! Tests of sewing without files.

use super::*;
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

fn merged(meshes: &[Garment], seams: &Seams) -> Result<Sewn, Error> {
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

    let sewn = merged(&meshes[..2], &seams).expect("panels that agree");
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
    let mut sewn = merged(&[left, placed], &seams).expect("panels that agree");
    let mut warnings = std::mem::take(&mut sewn.warnings);
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
    let sewn = merged(&meshes, &found(&meshes)).expect("panels that agree");
    assert_eq!(sewn.mesh.subsets[0].indices, [0, 1, 4, 5]);
    let (garment, _) = check_garment(sewn.mesh).expect("a good mesh");
    let (st, weight) = (garment.primvar("st").expect("UVs"), garment.primvar("weight").expect("weights"));
    let rows: std::collections::BTreeSet<u32> = st.indices.as_ref().expect("indices").iter().copied().collect();
    assert_eq!(rows.len(), 18);
    let Values::F32(values) = &weight.values else { panic!("floats") };
    let on_seam = |x: f32| garment.points.iter().zip(values).filter(move |(p, _)| p.x == x).map(|(_, w)| *w);
    assert!(on_seam(2.0).all(|w| w == 0.5) && on_seam(1.0).all(|w| w == 0.0) && on_seam(3.0).all(|w| w == 1.0));
    assert_eq!(sewn.warnings.iter().count(), 1);
}

#[test]
fn many_copies_in_one_place_are_found_without_comparing_all_edges() {
    // 30 sheets of 120 border edges each, all at one place.
    let meshes: Vec<Garment> = (0..30).map(|i| sheet(&i.to_string(), 30, 0.0)).collect();
    let seams = found(&meshes);
    assert_eq!((seams.garments.len(), seams.seams.len()), (1, 30 * 29 / 2));
    assert!(seams.seams.iter().all(|seam| seam.edges == 120));
}

/// A sheet each row of whose quads has points of its own, as if cut there: `rows` rows of `n` quads.
fn cut_sheet(n: i32, rows: i32) -> Garment {
    let mut mesh = Garment { prim: "/Suit/cut".to_owned(), ..Garment::default() };
    for row in 0..rows {
        let first = mesh.points.len() as i32;
        let point = |i: i32| Vec3::new((i % (n + 1)) as f32, (row + i / (n + 1)) as f32, 0.0);
        mesh.points.extend((0..2 * (n + 1)).map(point));
        mesh.face_vertex_indices.extend((0..n).flat_map(|i| [i, i + 1, i + n + 2, i + n + 1].map(|p| first + p)));
    }
    mesh.face_vertex_counts = vec![4; (n * rows) as usize];
    mesh
}

#[test]
fn doubled_points_of_one_mesh_are_sewn_and_their_uvs_stay_cut() {
    let mut mesh = cut_sheet(3, 2);
    let uvs: Vec<f32> = mesh.points.iter().enumerate().flat_map(|(i, p)| [p.x, p.y + (i / 8) as f32]).collect();
    let st = PrimvarInput::new("st", crate::garment::Interpolation::Vertex, Values::F32(uvs));
    mesh.primvars = vec![PrimvarInput { components: 2, ..st }, PrimvarInput::weights("weight", vec![0.5; 16])];
    let (hem, element_type) = (vec![4, 5, 8, 9], "edge".to_owned());
    mesh.subsets = vec![SubsetInput { name: "hem".to_owned(), element_type, family: String::new(), indices: hem }];
    let (found, warnings) = sew_own_borders(&mesh, TOLERANCE);
    let (sewn, seam) = found.expect("a seam");
    assert!(warnings.is_empty() && sewn.warnings.is_empty() && sewn.panels.is_empty());
    assert_eq!((seam.edges, seam.gap, sewn.mesh.points.len()), (3, 0.0, 12));
    assert_eq!(sewn.points[0], [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 8, 9, 10, 11]);
    // Both sides of the seam named the same edge.
    assert_eq!(sewn.mesh.subsets[0].indices, [4, 5]);
    let (garment, of_check) = check_garment(sewn.mesh).expect("a good mesh");
    assert!(of_check.is_empty() && garment.subset("sewn").is_some_and(|set| set.elements.len() == 3));
    let topology = crate::connectivity::Topology::new(garment.faces.clone(), 12);
    let st = garment.primvar("st").filter(|st| st.is_uv_set()).expect("face-varying UVs");
    let seams = crate::garment::UvSeams::new(st, &topology);
    let cut: Vec<_> = topology.edges.ids().filter(|&e| seams.is_cut(&topology, e)).map(|e| topology.edges[e]).collect();
    assert_eq!(cut.len(), 3);
    assert!(cut.iter().flatten().all(|v| (4..8).contains(&v.index())));
    assert_eq!(garment.primvar("weight").map(|w| w.interpolation), Some(crate::garment::Interpolation::Vertex));
}

#[test]
fn borders_of_one_mesh_that_cannot_be_sewn_are_named() {
    // A third sheet on the seam of two; a sheet of the other winding; a border of other points.
    let mut third = cut_sheet(3, 2);
    let more = cut_sheet(3, 1);
    third.points.extend(more.points.iter().map(|p| Vec3::new(p.x, 1.0, p.y)));
    third.face_vertex_indices.extend(more.face_vertex_indices.iter().map(|p| p + 16));
    third.face_vertex_counts.extend([4; 3]);
    let mut turned = cut_sheet(3, 2);
    turned.face_vertex_indices[12..].reverse();
    let mut other = cut_sheet(4, 2);
    other.points[10..].iter_mut().for_each(|p| p.x = if p.x < 1.5 { p.x * 1.3 } else { p.x });
    for (mesh, edges) in [(third, 9), (turned, 6), (other, 4)] {
        let (sewn, warnings) = sew_own_borders(&mesh, TOLERANCE);
        let warnings: Vec<_> = warnings.iter().collect();
        assert!(warnings.len() == 1 && warnings[0].code == crate::codes::UNSEWN_BORDERS, "{warnings:?}");
        assert!(warnings[0].problem.starts_with(&format!("{edges} border edges")), "{warnings:?} {sewn:?}");
    }
}

#[test]
fn a_dart_and_a_fine_border_are_not_unsewn() {
    // A border of edges that are much shorter than the others lies beside nothing.
    let mut mesh = sheet("fine", 3, 0.0);
    mesh.points.iter_mut().filter(|p| p.x == 1.0).for_each(|p| p.x = 0.02);
    assert!(sew_own_borders(&mesh, TOLERANCE).1.is_empty());
    // A slit with one end inside the sheet, whose sides coincide.
    let mut slit = cut_sheet(3, 2);
    slit.face_vertex_indices.iter_mut().filter(|p| **p == 8).for_each(|p| *p = 4);
    let (found, warnings) = sew_own_borders(&slit, TOLERANCE);
    let (sewn, seam) = found.expect("a seam");
    assert_eq!((seam.edges, warnings.is_empty(), sewn.mesh.subsets[0].indices.len()), (3, true, 6));
}
