//! Folds on the simulation mesh: kept where the surface is sharp, told where they are cut short.

use glam::Vec3;
use tailor_costume::recipe::Layers;
use tailor_costume::{Builder, Products};
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::{Garment, SubsetInput};

/// Vertices along one side of the cloth.
const SIDE: usize = 7;

/// A cloth of six by six quads, folded flat on itself along a slanting row; `crease` is the sharpness of the fold.
fn folded_cloth(crease: f32) -> Garment {
    let middle = SIDE / 2;
    let point = |x: usize, y: usize| {
        let (u, v) = (x as f32, y as f32 - middle as f32);
        Vec3::new(u + 0.3 * v.abs(), -v.abs(), if v < 0.0 { 0.0 } else { 0.05 * v })
    };
    let at = |x: usize, y: usize| (y * SIDE + x) as i32;
    let cells = || (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| (x, y)));
    Garment {
        prim: "/Cloth/model".into(),
        points: (0..SIDE * SIDE).map(|i| point(i % SIDE, i / SIDE)).collect(),
        face_vertex_counts: cells().map(|_| 4).collect(),
        face_vertex_indices: cells()
            .flat_map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)])
            .collect(),
        crease_indices: (0..SIDE).map(|x| at(x, middle)).collect(),
        crease_lengths: vec![SIDE as i32],
        crease_sharpnesses: vec![crease],
        subsets: vec![SubsetInput {
            name: "cloth".into(),
            element_type: "face".into(),
            family: String::new(),
            indices: (0..cells().count() as i32).collect(),
        }],
        ..Garment::default()
    }
}

fn build(input: Garment, length: f32) -> (Products, Warnings) {
    let mut layers = Layers::default();
    layers.add_override(&format!("sim.maxEdgeLength={length}")).expect("an option");
    let mut builder = Builder::new(input).expect("a good cloth").with_max_faces(100_000);
    let products = builder.update(&layers.recipe().expect("a good recipe")).expect("both meshes");
    let warnings = products.warnings.clone();
    (products, warnings)
}

fn kept(products: &Products) -> f64 {
    let cloth = &products.sim_figures().subset_areas[0];
    cloth.area / cloth.source_area
}

#[test]
fn a_sharp_crease_is_an_edge_of_the_mesh() {
    let (products, warnings) = build(folded_cloth(10.0), 1.0);
    assert!((kept(&products) - 1.0).abs() < 0.01, "{} of the area is kept", kept(&products));
    assert!(!warnings.iter().any(|w| w.code == tailor::codes::AREA_CHANGED));
    // Every point of the fold lies on an edge of the mesh, so as many vertices as edges of the length asked for are on it.
    let on_fold = products.sim.points.iter().filter(|p| p.y.abs() < 1e-5).count();
    assert!(on_fold >= SIDE, "{on_fold} vertices on the fold");
}

#[test]
fn a_fold_that_the_length_cannot_follow_becomes_a_chain() {
    let (products, _) = build(folded_cloth(0.0), 2.0);
    assert!(products.remesh().feature_lines > 0);
    assert!((kept(&products) - 1.0).abs() < 0.03, "{} of the area is kept", kept(&products));
}

#[test]
fn a_fold_that_is_cut_short_is_told() {
    // The fold is too short for edges of this length to be laid along it.
    let (products, warnings) = build(folded_cloth(0.0), 3.5);
    let told = warnings.iter().any(|w| w.code == tailor::codes::AREA_CHANGED && w.place == "face sets `cloth`");
    assert!(kept(&products) < 0.95, "{} of the area is kept, which tests nothing", kept(&products));
    assert!(told, "{:?}", warnings.iter().collect::<Vec<_>>());
}
