//! Levels of detail of a builder.

use std::sync::Arc;
use tailor::SeamOptions;
use tailor_costume::{Builder, Products, Recipe};
use tailor_mesh::garment::Garment;
use tailor_testing::garments;
use tailor_usd::{ReadOptions, Source};

fn coat() -> Garment {
    Source::open(&garments::named("coat.usda"), &ReadOptions::default())
        .and_then(|source| source.garment())
        .expect("a good garment")
        .0
}

fn recipe(levels: u32) -> Recipe {
    let mut recipe = Recipe::default();
    recipe.lod.levels = levels;
    recipe.sim.max_edge_length = 6.0;
    recipe.render.level = 1;
    let seam = SeamOptions { edges: vec!["centre_back".into()], ..SeamOptions::default() };
    recipe.seam.insert("back".into(), seam);
    recipe
}

/// The largest distance of a bound point from its place on the simulation mesh, less its height.
fn off(products: &Products, to: &Products, level: usize) -> f32 {
    let binding = &products.level_bindings[level];
    let sim = &to.sim;
    let off = |i: usize| {
        let vertices = sim.faces.vertices_of(tailor_mesh::connectivity::FaceId::new(binding.faces[i] as usize));
        let coords = binding.coords[i];
        let weights = [coords.x, coords.y, 1.0 - coords.x - coords.y];
        let place: glam::Vec3 = vertices.iter().zip(weights).map(|(&v, w)| w * sim.points[v]).sum();
        products.render.points.as_slice()[i].distance(place)
    };
    (0..binding.faces.len()).map(off).fold(0.0, f32::max)
}

#[test]
fn each_render_mesh_is_bound_to_each_simulation_mesh() {
    let products = Builder::new(coat()).and_then(|mut builder| builder.update(&recipe(3))).expect("products");
    let all: Vec<&Products> = products.all_levels().collect();
    assert_eq!(all.len(), 3);
    for render in &all {
        assert_eq!(render.level_bindings.len(), 3);
        for (level, sim) in all.iter().enumerate() {
            let binding = &render.level_bindings[level];
            assert_eq!(binding.faces.len(), render.render.points.len());
            assert!(binding.faces.iter().all(|&face| (face as usize) < sim.sim.faces.len()));
            // Within half of an edge of the coarsest mesh: on the same place of the garment, not on another layer of it.
            let off = off(render, sim, level);
            assert!(off < 0.5 * 24.0, "{level}: {off}");
        }
    }
    assert!(all[0].cloth.is_some() && all[1..].iter().all(|level| level.cloth.is_none()));
    assert_eq!(all[0].level_bindings[0], all[0].binding);
}

#[test]
fn an_edit_repeats_what_it_changes_at_every_level() {
    let mut builder = Builder::new(coat()).expect("a builder");
    let first = builder.update(&recipe(2)).expect("products");
    let mut edited = recipe(2);
    edited.seam.get_mut("back").expect("the seam").normal_offset = -0.05;
    let second = builder.update(&edited).expect("products");
    assert!(Arc::ptr_eq(&first.sim, &second.sim) && Arc::ptr_eq(&first.levels[0].sim, &second.levels[0].sim));
    assert!(!Arc::ptr_eq(&first.render, &second.render));
    let alone = Builder::new(coat()).and_then(|mut builder| builder.update(&edited)).expect("products");
    assert_eq!(second.levels[0].render.points, alone.levels[0].render.points);
    assert_eq!(second.levels[0].level_bindings, alone.levels[0].level_bindings);
    let one = builder.update(&recipe(1)).expect("products");
    assert!(one.levels.is_empty() && one.level_bindings.is_empty());
}
