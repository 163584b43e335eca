//! Simulation meshes with the same triangles on both sides of a plane (`sim.symmetry`).

use crate::built::{Built, build};
use glam::Vec3;
use std::collections::BTreeSet;
use tailor::codes;
use tailor_mesh::connectivity::{Topology, VertexId};
use tailor_mesh::garment::{Garment, Interpolation, PrimvarInput, Values};
use tailor_testing::sheets;

const OPTIONS: [&str; 2] = ["sim.maxEdgeLength=0.45", "sim.symmetry=true"];
const ROWS: usize = 7;

/// A sheet that bends alike on both sides of x = 0. With an odd number of columns, faces lie across the plane.
fn sheet(columns: usize) -> Garment {
    let mut input = sheets::grid(columns, ROWS, |_, _| true);
    for point in &mut input.points {
        let x = point.x - 0.5 * columns as f32;
        *point = Vec3::new(x, point.y, 0.4 * (0.8 * x).cos() + 0.05 * point.y * x.abs());
    }
    input
}

/// The twin of each vertex by place; none where no vertex is within a thousandth of it.
fn twins(built: &Built) -> Vec<Option<usize>> {
    let points = built.products.sim.points.as_slice();
    let mirrored = points.iter().map(|p| Vec3::new(-p.x, p.y, p.z));
    mirrored.map(|p| points.iter().position(|other| other.distance(p) < 1e-3)).collect()
}

/// Triangles whose twins are triangles too, and those without.
fn counts(built: &Built) -> [usize; 2] {
    let (twins, mesh) = (twins(built), &built.products.sim);
    let sorted = |mut triangle: Vec<usize>| {
        triangle.sort_unstable();
        triangle
    };
    let own =
        || mesh.faces.ids().map(|face| mesh.faces.vertices_of(face).iter().map(|v| v.index()).collect::<Vec<_>>());
    let all: BTreeSet<Vec<usize>> = own().map(sorted).collect();
    let twin = |triangle: &Vec<usize>| triangle.iter().map(|&v| twins[v]).collect::<Option<Vec<_>>>();
    let (paired, alone): (Vec<_>, Vec<_>) =
        own().partition(|triangle| twin(triangle).is_some_and(|twin| all.contains(&sorted(twin))));
    [paired.len(), alone.len()]
}

#[test]
fn both_sides_have_the_same_triangles() {
    for columns in [8, 9] {
        let built = build(sheet(columns), &OPTIONS);
        let [paired, alone] = counts(&built);
        assert!(alone == 0 && paired > 500, "{columns} columns: {alone} of {paired} triangles have no twin");
        assert!(built.warnings.iter().all(|warning| warning.code != codes::ASYMMETRIC), "{:?}", built.warnings);
        // One piece: its borders are those of the sheet, and its UVs go through.
        let mesh = &built.products.sim;
        let t = Topology::new(mesh.faces.clone(), mesh.points.len());
        let inner = t.edges.ids().filter(|&edge| t.is_border(edge)).flat_map(|edge| t.edges[edge]);
        let is_inside = |v: &VertexId| {
            let p = mesh.points[*v];
            p.x.abs() < 0.49 * columns as f32 && (0.01..ROWS as f32 - 0.01).contains(&p.y)
        };
        assert_eq!(inner.filter(is_inside).count(), 0, "{columns} columns: a border inside the sheet");
        let Some(Values::F32(uvs)) = mesh.primvar("st").map(|uv| uv.values.clone()) else { panic!("UVs") };
        assert_eq!(uvs.len() / 2, mesh.points.len(), "{columns} columns: UVs are cut");
        // Without the option, most triangles have no twin.
        let [_, alone] = counts(&build(sheet(columns), &OPTIONS[..1]));
        assert!(alone > 100, "{alone}");
    }
}

#[test]
fn lengths_and_lines_of_one_side_hold_on_both() {
    let mut input = sheet(8);
    let right = |i: usize| if i % 9 > 5 { 1.0 } else { 0.0 };
    let weights = Values::F32((0..input.points.len()).map(right).collect());
    input.primvars.retain(|primvar| primvar.name != "density");
    input.primvars.push(PrimvarInput::new("density", Interpolation::Vertex, weights));
    let line: Vec<[i32; 2]> = (2..5).map(|y| [9 * y + 6, 9 * (y + 1) + 6]).collect();
    let options = ["sim.density=density", "sim.minEdgeLength=0.2", "sim.constraints=line"];
    let built = build(sheets::with_edges(input, "line", &line), &[&OPTIONS[..], &options].concat());
    let [paired, alone] = counts(&built);
    assert!(alone == 0 && paired > 1000, "{alone} {paired}");
    // The set is where it was, on one side.
    let set = built.products.sim.subset("line").expect("the set");
    let tailor_mesh::garment::Elements::Edges(edges) = &set.elements else { panic!("edges") };
    assert!(!edges.is_empty() && edges.iter().flatten().all(|&v| (built.products.sim.points[v].x - 2.0).abs() < 0.05));
}

#[test]
fn faces_without_a_twin_have_triangles_of_their_own() {
    let mut input = sheet(8);
    let first = input.points.len() as i32;
    input.points.extend([[1.0, 1.0, 2.0], [3.0, 1.0, 2.0], [3.0, 2.0, 2.0], [1.0, 2.0, 2.0]].map(Vec3::from));
    input.face_vertex_counts.push(4);
    input.face_vertex_indices.extend((0..4).map(|k| first + k));
    input.primvars.clear();
    input.subsets.clear();
    input.families.clear();
    let built = build(input, &OPTIONS);
    let told: Vec<_> = built.warnings.iter().filter(|warning| warning.code == codes::ASYMMETRIC).collect();
    assert!(told.len() == 1 && told[0].to_string().contains("1 face has no twin"), "{told:?}");
    let [paired, alone] = counts(&built);
    assert!(paired > 500 && alone > 10 && alone < 40, "{paired} {alone}");
}
