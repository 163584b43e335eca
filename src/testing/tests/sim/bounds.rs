//! Bounds of the simulation mesh: bad UVs, limits of its size, and garments of any place and scale.

use super::{MAX_FACES, baseline, prepare};
use glam::Vec3;
use proptest::prelude::*;
use std::collections::BTreeSet;
use tailor::codes;
use tailor::sim::{SimProduct, simulate};
use tailor_costume::{Builder, Products, Recipe};
use tailor_mesh::error::Warning;
use tailor_mesh::garment::{Elements, Garment, Mesh, Orientation, Values};
use tailor_testing::cases::few;
use tailor_testing::sheets;

/// Quads along a side of the sheet.
const SIDE: usize = 10;

/// The sheet, and with the UVs of one point elsewhere.
fn sheet(bad: Option<(usize, [f32; 2])>) -> Garment {
    let mut input = sheets::grid(SIDE, SIDE, |_, _| true);
    let Some((point, uv)) = bad else { return input };
    let corners: Vec<usize> =
        (0..input.face_vertex_indices.len()).filter(|&c| input.face_vertex_indices[c] == point as i32).collect();
    for primvar in input.primvars.iter_mut().filter(|p| p.name == "st") {
        let Values::F32(values) = &mut primvar.values else { panic!("UVs are floats") };
        corners.iter().for_each(|&c| values[2 * c..2 * c + 2].copy_from_slice(&uv));
    }
    input
}

fn product(input: Garment, options: &[&str], max_faces: usize) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), &prepared.recipe.sim, max_faces)
}

fn built(input: Garment, recipe: &Recipe) -> Products {
    let mut builder = Builder::new(input).unwrap_or_else(|e| panic!("{e}"));
    builder.update(recipe).unwrap_or_else(|e| panic!("{e}"))
}

/// The faces that the warning of flipped UVs names.
fn told(products: &Products) -> BTreeSet<usize> {
    let of = |warning: &Warning| match &warning.elements {
        Elements::Faces(faces) if warning.code == codes::FLIPPED_UVS => faces.iter().map(|f| f.index()).collect(),
        _ => BTreeSet::new(),
    };
    products.warnings.iter().flat_map(of).collect()
}

proptest! {
    #![proptest_config(few(12, 20_041_212))]

    #[test]
    fn a_bad_uv_costs_no_more_than_the_faces_around_it(
        point in 0usize..(SIDE + 1) * (SIDE + 1),
        uv in prop::array::uniform2(-64.0f32..64.0),
    ) {
        let good = product(sheet(None), &[], MAX_FACES).triangles.len();
        let product = product(sheet(Some((point, uv))), &[], MAX_FACES);
        let count = product.triangles.len();
        prop_assert!(count.abs_diff(good) * 20 <= good, "{count} triangles for {good}");
        // Values are those of the surface at each corner, however bad.
        for place in product.places.iter() {
            prop_assert!(place.uv.distance(product.baseline.uv(place.location)) <= 1e-3);
        }
        let flipped = product.baseline.flipped.iter().map(|&f| product.baseline.source_face[f].index()).collect();
        let products = built(sheet(Some((point, uv))), &Recipe::default());
        prop_assert_eq!(products.sim.faces.len(), count);
        prop_assert_eq!(told(&products), flipped);
        // Subdivision spreads a value over two rings of faces.
        let [x, y] = [point % (SIDE + 1), point / (SIDE + 1)];
        for face in told(&products) {
            let near = |at: usize, of: usize| at <= of + 2 && of <= at + 3;
            prop_assert!(near(face % SIDE, x) && near(face / SIDE, y), "face {face} is not near point {point}");
        }
    }

    #[test]
    fn no_limit_is_exceeded(share in 0.1f32..0.9, length in 0.2f32..0.6) {
        let length = format!("sim.maxEdgeLength={length}");
        let options = [length.as_str(), "sim.uvSet=", "sim.baselineLevel=0"];
        let free = product(sheet(None), &options, MAX_FACES);
        prop_assert!(!free.report.full);
        // The mesh that remeshing starts from is within it.
        let limit = ((share * free.triangles.len() as f32) as usize).max(2 * SIDE * SIDE);
        let limited = product(sheet(None), &options, limit);
        prop_assert!(limited.triangles.len() <= limit, "{} for {limit}", limited.triangles.len());
        prop_assert!(limited.report.full);
    }
}

#[test]
fn good_uvs_are_not_told() {
    assert!(told(&built(sheet(None), &Recipe::default())).is_empty());
}

#[test]
fn uvs_without_area_are_as_none() {
    let mut input = sheet(None);
    for primvar in input.primvars.iter_mut().filter(|p| p.name == "st") {
        primvar.values = Values::F32(vec![0.5; 8 * SIDE * SIDE]);
    }
    let all = told(&built(input.clone(), &Recipe::default())).len();
    assert_eq!(all, SIDE * SIDE);
    let (with, without) = (product(input, &[], MAX_FACES), product(sheet(None), &["sim.uvSet="], MAX_FACES));
    assert_eq!(with.triangles, without.triangles);
}

#[test]
fn a_mesh_that_reaches_its_limit_says_so() {
    // Grading asks for more than the density, by which triangles are expected.
    let mut builder = Builder::new(sheet(None)).unwrap_or_else(|e| panic!("{e}"));
    let mut recipe = Recipe::default();
    (recipe.sim.density, recipe.sim.baseline_level) = ("density".into(), 0);
    (recipe.sim.min_edge_length, recipe.sim.max_edge_length, recipe.sim.grading) = (0.1, 1.0, 1.05);
    let expected = builder.plan(&recipe).unwrap_or_else(|e| panic!("{e}")).meshes.expected_faces;
    let is_told = |products: &Products| products.warnings.iter().any(|w| w.code == codes::FACE_LIMIT);
    let free = builder.update(&recipe).unwrap_or_else(|e| panic!("{e}"));
    assert!(free.sim.faces.len() > expected && !is_told(&free), "{} for {expected}", free.sim.faces.len());
    let limited = builder.sibling().with_max_faces(expected).update(&recipe).unwrap_or_else(|e| panic!("{e}"));
    assert!(limited.sim.faces.len() <= expected && is_told(&limited), "{} for {expected}", limited.sim.faces.len());
}

/// A tube around the origin whose coordinates are multiples of an eighth, and so exact a million units away too.
fn tube() -> Garment {
    let mut input = sheets::tube(8, 6);
    input.points.iter_mut().for_each(|p| *p = (*p * 32.0).round() / 8.0 - 8.375 * Vec3::Z);
    input
}

fn moved(to: impl Fn(Vec3) -> Vec3) -> Garment {
    let mut input = tube();
    input.points.iter_mut().for_each(|p| *p = to(*p));
    input
}

/// Checks that points are those of another mesh with the same faces after a transform.
fn same_up_to(mesh: &Mesh, other: &Mesh, tolerance: f32, to: impl Fn(Vec3) -> Vec3) {
    assert!(mesh.faces == other.faces, "{} and {} faces", mesh.faces.len(), other.faces.len());
    for (&p, &q) in mesh.points.iter().zip(other.points.iter()) {
        assert!(to(p).distance(q) <= tolerance, "{p} is {q}");
    }
}

/// Checks that two meshes have about as many triangles, and the 5th percentile of the smallest angle up to a difference.
fn as_good(one: &Products, other: &Products, degrees: f32) {
    let (count, theirs) = (one.sim.faces.len(), other.sim.faces.len());
    assert!(theirs.abs_diff(count) * 50 <= count, "{theirs} for {count}");
    let angles = [one, other].map(|products| products.sim_figures().min_angle_p5);
    assert!((angles[0] - angles[1]).abs() <= degrees, "{angles:?}");
}

#[test]
fn products_are_the_same_at_every_scale() {
    let own = built(tube(), &Recipe::default());
    for exponent in [-3, 3] {
        let scale = 2f32.powi(exponent);
        let scaled = built(moved(|p| p * scale), &Recipe::default());
        same_up_to(&own.sim, &scaled.sim, 0.0, |p| p * scale);
        same_up_to(&own.render, &scaled.render, 0.0, |p| p * scale);
    }
    for scale in [1e-4, 1e5] {
        as_good(&own, &built(moved(|p| p * scale), &Recipe::default()), 2.0);
    }
}

#[test]
fn products_are_the_same_wherever_the_garment_is() {
    let own = built(tube(), &Recipe::default());
    let far = 2f32.powi(20);
    for offset in [Vec3::new(far, 0.0, 0.0), Vec3::new(-far, far, far)] {
        let mut builder = Builder::new(moved(|p| p + offset)).unwrap_or_else(|e| panic!("{e}"));
        let products = builder.update(&Recipe::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(builder.plan(&Recipe::default()).unwrap_or_else(|e| panic!("{e}")).recipe, own.recipe);
        // Half the spacing of numbers at the offset, along each axis.
        same_up_to(&own.sim, &products.sim, 0.11, |p| p + offset);
        same_up_to(&own.render, &products.render, 0.11, |p| p + offset);
        assert!(products.warnings.iter().any(|w| w.code == codes::FAR_FROM_ORIGIN));
        assert_eq!(products.binding.faces, own.binding.faces);
        let again = builder.update(&Recipe::default()).unwrap_or_else(|e| panic!("{e}"));
        assert!(std::sync::Arc::ptr_eq(&again.sim, &products.sim), "results are kept");
    }
}

#[test]
fn left_handed_and_mirrored_tubes_have_meshes_as_good() {
    let own = built(tube(), &Recipe::default());
    let left = Garment { orientation: Orientation::LeftHanded, ..tube() };
    same_up_to(&own.sim, &built(left, &Recipe::default()).sim, 0.0, |p| p);
    as_good(&own, &built(moved(|p| Vec3::new(-p.x, p.y, p.z)), &Recipe::default()), 3.0);
    as_good(&own, &built(moved(|p| Vec3::new(p.x, -p.z, p.y)), &Recipe::default()), 3.0);
}

#[test]
fn no_length_is_shorter_than_points_can_be_apart_or_far_beyond_the_garment() {
    let mut recipe = Recipe::default();
    recipe.sim.density = "density".into();
    (recipe.sim.min_edge_length, recipe.sim.max_edge_length) = (1e-7, 5.0);
    let mut builder = Builder::new(sheet(None)).unwrap_or_else(|e| panic!("{e}"));
    let error = builder.update(&recipe).err().unwrap_or_else(|| panic!("it is refused"));
    assert!(error.to_string().contains("sim.minEdgeLength"), "{error}");
    for longest in [1e3, 1e4] {
        (recipe.sim.min_edge_length, recipe.sim.max_edge_length) = (0.0, longest);
        let products = builder.update(&recipe).unwrap_or_else(|e| panic!("{longest}: {e}"));
        assert!(products.sim.points.iter().all(|p| p.is_finite()), "{longest}");
        assert!(products.sim.faces.len() < 200, "{} for {longest}", products.sim.faces.len());
    }
    for longest in [1e12, 1e30, f32::MAX] {
        recipe.sim.max_edge_length = longest;
        let error = builder.update(&recipe).err().unwrap_or_else(|| panic!("{longest} is refused"));
        assert!(error.to_string().contains("sim.maxEdgeLength"), "{error}");
    }
}
