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
use tailor_costume::fit::{Bodies, FitOptions, fit as fit_garment};
use tailor_costume::recipe::{Layers, Recipe, RecipeFile};
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::{Elements, Garment, Mesh};
use tailor_usd::session::PayloadRecipe;
use tailor_usd::{ReadOptions, Source};

/// A target: its name and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 6] = [
    ("recipe", recipe),
    ("document", document),
    ("layer", layer),
    ("pipeline", pipeline),
    ("sets", sets),
    ("fit", fit),
];

/// Bound of the simulation mesh, so that a case takes no more than seconds. \[triangles\]
const MAX_FACES: usize = 20_000;
/// Pairs of places on two bodies; the least are 4.
const PAIRS: usize = 5;
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

/// An expression of sets before the first null byte, on the mesh of the bytes from there on.
pub fn sets(data: &[u8]) {
    let (text, mesh) = data.split_at(data.iter().position(|byte| *byte == 0).unwrap_or(data.len()));
    let Ok(text) = std::str::from_utf8(text) else { return };
    let Some(builder) = sound(Builder::new(meshes::mesh(&mut Choices::new(mesh)))) else { return };
    if let Some(set) = sound(builder.derived_set(&Recipe::default(), "a", text)) {
        assert!(has_elements(builder.garment(), &set.elements), "the elements of {text} exist");
    }
}

/// A garment on two bodies, each another shape of the first or of other faces, by faces, UVs or pairs of places.
pub fn fit(data: &[u8]) {
    let choices = &mut Choices::new(data);
    let body = meshes::mesh(choices);
    let mut like_body = || if choices.once_in(4) { meshes::mesh(choices) } else { meshes::moved(&body, choices) };
    let (to, garment) = (like_body(), like_body());
    let finite = [&body, &to, &garment].into_iter().all(is_sane);
    let checked: Option<Vec<Builder>> = [garment, body, to].into_iter().map(|mesh| sound(Builder::new(mesh))).collect();
    let Some([garment, from, to]) =
        checked.as_deref().and_then(|all| Some(all.first_chunk()?.each_ref().map(Builder::garment)))
    else {
        return;
    };
    let mut place = |mesh: &Mesh| mesh.points.as_slice()[choices.below(mesh.points.len())].as_dvec3();
    let pairs: Vec<_> = (0..PAIRS).map(|_| [place(from), place(to)]).collect();
    let bodies = if choices.once_in(3) { Bodies::by_pairs(from, to, &pairs) } else { Bodies::new(from, to) };
    let mut some_sets =
        || garment.subsets.iter().filter(|_| choices.once_in(3)).map(|set| set.elements.clone()).collect();
    let options = FitOptions { rigid: some_sets(), keep_length: some_sets(), ease: 0.0 };
    let Some(fitted) = sound(bodies).and_then(|bodies| sound(fit_garment(garment, &bodies, &options))) else { return };
    assert_eq!(fitted.points.len(), garment.points.len(), "a point for each of the garment");
    assert!(!finite || fitted.points.iter().all(|p| p.is_finite()), "points are finite");
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
    let points = mesh.points.len();
    assert!(mesh.faces.corners().iter().all(|v| v.index() < points), "{name}: corners name points");
    assert!(!finite || mesh.points.iter().all(|p| p.is_finite()), "{name}: points are finite");
    for subset in mesh.subsets.iter() {
        assert!(has_elements(mesh, &subset.elements), "{name}: the elements of {} exist", subset.name);
    }
}

/// True if a mesh has all of these elements.
fn has_elements(mesh: &Mesh, elements: &Elements) -> bool {
    let (points, faces) = (mesh.points.len(), mesh.faces.len());
    match elements {
        Elements::Faces(all) => all.iter().all(|f| f.index() < faces),
        Elements::Points(all) => all.iter().all(|v| v.index() < points),
        Elements::Edges(all) => all.iter().flatten().all(|v| v.index() < points),
    }
}
