//! The bodies of the fuzz targets: each takes any bytes, and panics if the library does what it must not.
//!
//! `tests/fuzz/targets` runs them with cargo-fuzz, `tests/stages/fuzz_replay.rs` with a stored corpus and a seeded generator.

mod choices;
mod meshes;
mod recipes;

use choices::Choices;
use std::path::Path;
use std::sync::Arc;
use tailor_costume::Builder;
use tailor_costume::recipe::{Layers, RecipeFile};
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::{Elements, Garment, Mesh};
use tailor_usd::session::PayloadRecipe;
use tailor_usd::{ReadOptions, Source};

/// A target: its name and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 4] = [("recipe", recipe), ("document", document), ("layer", layer), ("pipeline", pipeline)];

/// Bound of the simulation mesh, so that a case takes no more than seconds. \[triangles\]
const MAX_FACES: usize = 20_000;
/// Points of larger size may overflow in single precision. \[mesh units\]
const SANE: f32 = 1e15;

/// The text of a `.tailor` file.
pub fn recipe(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Some(file) = sound(RecipeFile::parse(Path::new("a.tailor"), text)) else { return };
    let mut layers = Layers::default();
    layers.add(file.into_layer());
    sound(layers.recipe());
}

/// A `.tailor` file and the arguments that OpenUSD opens it with: texts between null bytes, each `key=value`.
pub fn document(data: &[u8]) {
    let mut texts = data.split(|byte| *byte == 0).filter_map(|text| std::str::from_utf8(text).ok());
    let Some(text) = texts.next() else { return };
    let arguments = texts.map(|argument| argument.split_once('=').unwrap_or((argument, "")));
    if let Some(document) = sound(PayloadRecipe::new(Path::new("/a/b.tailor"), text, arguments)) {
        assert!(!document.source().is_empty(), "a document has a source");
    }
}

/// The bytes of a layer, text or crate, as `usdtailor check` reads it.
pub fn layer(data: &[u8]) {
    let source = Source::from_layer(Arc::from(data), Path::new("a.usd"), &ReadOptions::default());
    let Some(source) = sound(source) else { return };
    let Some((mesh, mut warnings)) = sound(source.garment()) else { return };
    let Some(attributes) = sound(source.recipe()) else { return };
    let mut layers = Layers::default();
    warnings.extend(layers.add_attributes(attributes));
    let Some(builder) = sound(Builder::new(mesh)) else { return };
    if let Some(recipe) = sound(layers.recipe_for(builder.garment())) {
        sound(builder.resolve(&recipe));
    }
}

/// A mesh and a recipe of arbitrary trouble, through the whole build.
pub fn pipeline(data: &[u8]) {
    let choices = &mut Choices::new(data);
    let mesh = meshes::mesh(choices);
    let layers = recipes::layers(choices);
    let finite = is_sane(&mesh);
    let Some(builder) = sound(Builder::new(mesh)) else { return };
    let Some(recipe) = sound(layers.recipe_for(builder.garment())) else { return };
    let Some(products) = sound(builder.with_max_faces(MAX_FACES).update(&recipe)) else { return };
    check_product("sim", &products.sim, finite);
    check_product("render", &products.render, finite);
    let faces = &products.sim.faces;
    assert!(faces.ids().all(|face| faces.valence(face) == 3), "the simulation mesh has triangles alone");
}

/// The result of a step; an error must have words, and be the fault of the input.
fn sound<T>(result: Result<T, Error>) -> Option<T> {
    let error = match result {
        Ok(value) => return Some(value),
        Err(error) => error,
    };
    assert!(error.kind != ErrorKind::Internal, "{error}");
    assert!(!error.faults.is_empty() && error.faults.iter().all(|fault| !fault.text.is_empty()), "an error has words");
    None
}

/// True if all points are finite, and so near that nothing overflows.
fn is_sane(mesh: &Garment) -> bool {
    mesh.points.iter().all(|p| p.is_finite() && p.abs().max_element() < SANE)
}

/// Indices in range, and points finite where those of the input are.
fn check_product(name: &str, mesh: &Mesh, finite: bool) {
    let (points, faces) = (mesh.points.len(), mesh.faces.len());
    assert!(mesh.faces.corners().iter().all(|v| v.index() < points), "{name}: corners name points");
    assert!(!finite || mesh.points.iter().all(|p| p.is_finite()), "{name}: points are finite");
    for subset in mesh.subsets.iter() {
        let in_range = match &subset.elements {
            Elements::Faces(all) => all.iter().all(|f| f.index() < faces),
            Elements::Points(all) => all.iter().all(|v| v.index() < points),
            Elements::Edges(all) => all.iter().flatten().all(|v| v.index() < points),
        };
        assert!(in_range, "{name}: the elements of {} exist", subset.name);
    }
}
