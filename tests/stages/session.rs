//! Builders repeat only what an edit changes and give what new ones give; sessions stay within their memory.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use tailor::{FoldOptions, SeamOptions};
use tailor_costume::{Builder, Products, Progress, Recipe};
use tailor_mesh::glam::Vec3;
use tailor_mesh::{Error, ErrorKind, Garment, SubsetInput};
use tailor_usd::session::{PayloadRecipe, Session, written};
use tailor_usd::{Format, ProductNames, ReadOptions, Source, Surroundings, WriteOptions, layer_bytes, write};

const ROOM: usize = 1 << 30;

/// An example with its composed content, as the plugin hands it over.
struct Example {
    folder: PathBuf,
    content: Vec<u8>,
}

impl Example {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
        let source = Source::open(&folder.join(name), &ReadOptions::default()).expect("an example");
        let temporary = tempfile::tempdir().expect("a folder");
        let flat = temporary.path().join("flat.usdc");
        let options = WriteOptions { flatten: true, model_guide: false, ..WriteOptions::default() };
        write(&source, &[], &flat, &options).expect("a flat layer");
        Self { folder, content: std::fs::read(flat).expect("a flat layer") }
    }

    /// A `.tailor` file for it.
    fn document(&self, arguments: &[(&str, &str)]) -> PayloadRecipe {
        let text = r#"{"source": "tshirt.usda", "sim": {"iterations": 2}}"#;
        PayloadRecipe::new(&self.folder.join("tshirt.tailor"), text, arguments.iter().copied()).expect("a good file")
    }

    fn layer(&self, session: &Session, arguments: &[(&str, &str)]) -> Vec<u8> {
        session.layer(&self.document(arguments), &self.content, false).expect("a layer").0
    }

    fn source(&self) -> Source {
        let document = self.document(&[]);
        Source::from_layer(self.content.clone().into(), &document.source_file(), document.options()).expect("a garment")
    }

    fn builder(&self) -> Builder {
        let (mesh, _) = self.source().garment().expect("a mesh");
        Builder::new(mesh).expect("a good garment")
    }

    fn recipe(&self, arguments: &[(&str, &str)]) -> Recipe {
        let document = self.document(arguments);
        let (mut layers, _) = document.layers(&self.source()).expect("a recipe");
        layers.add(document.arguments().0.into_map());
        layers.recipe().expect("a good recipe")
    }

    fn update(&self, builder: &mut Builder, arguments: &[(&str, &str)]) -> Products {
        builder.update(&self.recipe(arguments)).expect("products")
    }
}

/// The layer that a new builder gives.
fn straight(example: &Example, arguments: &[(&str, &str)]) -> Vec<u8> {
    let (document, source) = (example.document(arguments), example.source());
    let products = example.update(&mut example.builder(), arguments);
    let names = ProductNames::new("sim", "render");
    let meshes = written(&products, &[], &names);
    let (surroundings, options) =
        (Surroundings { folder: document.folder(), source: Some(document.source()) }, WriteOptions::default());
    layer_bytes(&source, &meshes, Format::Usdc, surroundings, &options).expect("a layer").0
}

#[test]
fn a_session_gives_what_a_new_builder_gives() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    for arguments in [&[][..], &[("render.level", "2")], &[("sim.maxEdgeLength", "6"), ("sim.seed", "3")], &[]] {
        assert!(example.layer(&session, arguments) == straight(&example, arguments), "{arguments:?}");
    }
}

#[test]
fn operators_give_the_same_after_other_edits() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    let of = |amount: &'static str, offset: &'static str, operators: &'static str| {
        [
            ("seam.side.edges", "side_seams"),
            ("seam.side.normalOffset", offset),
            ("fold.all.faces", "front,back"),
            ("fold.all.thickness", amount),
            ("render.operators", operators),
        ]
    };
    // From small to large, so that what is kept of the first was made for less.
    for arguments in [
        of("0.1", "-0.1", ""),
        of("4", "-0.1", ""),
        of("4", "-0.3", ""),
        of("0.1", "-0.1", "side"),
        of("0.1", "-0.1", "all,side"),
    ] {
        assert!(example.layer(&session, &arguments) == straight(&example, &arguments), "{arguments:?}");
    }
}

/// Two sheets of four by four quads, one a hundredth of an edge over the other, with a seam across the lower one.
fn sheets() -> Garment {
    let at = |i: usize, z: f32| Vec3::new((i % 5) as f32, (i / 5) as f32, z);
    let first = (0..20).filter(|i| i % 5 < 4);
    let quads = first.flat_map(|i| [i, i + 1, i + 6, i + 5]);
    let set = |name: &str, element_type: &str, indices: Vec<i32>| SubsetInput {
        name: name.into(),
        element_type: element_type.into(),
        family: String::new(),
        indices,
    };
    let seam = vec![10, 11, 11, 12, 12, 13, 13, 14];
    Garment {
        points: [0.0, 0.01].into_iter().flat_map(|z| (0..25).map(move |i| at(i, z))).collect(),
        face_vertex_counts: vec![4; 32],
        face_vertex_indices: quads.clone().chain(quads.map(|v| v + 25)).collect(),
        subsets: vec![set("across", "edge", seam), set("all", "face", (0..32).collect())],
        ..Garment::default()
    }
}

#[test]
fn what_is_kept_of_a_low_operator_is_no_clearance_for_a_high_one() {
    let mut kept = Builder::new(sheets()).expect("a good mesh");
    let mut faces = Vec::new();
    for amount in [1e-3, 0.5, 1e-3] {
        let mut recipe = Recipe::default();
        let seam = SeamOptions { edges: vec!["across".into()], normal_offset: -1e-3, ..SeamOptions::default() };
        let hem = FoldOptions { faces: vec!["all".into()], thickness: amount, ..FoldOptions::default() };
        recipe.seam.insert("seam".into(), seam);
        recipe.fold.insert("hem".into(), hem);
        let planned = kept.plan(&recipe).expect("sizes").meshes.render_faces;
        let [edited, new] = [kept.update(&recipe), Builder::new(sheets()).and_then(|mut new| new.update(&recipe))]
            .map(|products| products.expect("products").render);
        assert!(edited.faces == new.faces && edited.points == new.points, "amount {amount}");
        assert_eq!(planned, new.faces.len());
        faces.push(new.faces.len());
    }
    assert!(faces[1] < faces[0] && faces[2] == faces[0], "a high layer has no room between the sheets: {faces:?}");
}

#[test]
fn an_edit_repeats_only_what_depends_on_it() {
    let example = Example::new("tshirt.usda");
    let mut builder = example.builder();
    let mut update = |arguments: &[(&str, &str)]| {
        let products = example.update(&mut builder, arguments);
        let steps: Vec<&str> = products.timings.iter().map(|t| t.name).collect();
        (products, steps)
    };
    let (first, _) = update(&[]);
    let (other, _) = update(&[("render.level", "1")]);
    assert!(Arc::ptr_eq(&first.sim, &other.sim) && !Arc::ptr_eq(&first.render, &other.render));
    let (first, _) = update(&[]);
    let (other, _) = update(&[("sim.maxEdgeLength", "6")]);
    assert!(!Arc::ptr_eq(&first.sim, &other.sim) && Arc::ptr_eq(&first.render, &other.render));
    // Another option of transfer gives another mesh, on the same triangles.
    let (first, _) = update(&[]);
    let (other, steps) = update(&[("sim.seed", "1")]);
    assert!(!Arc::ptr_eq(&first.sim, &other.sim) && first.sim.faces == other.sim.faces);
    assert!(steps.contains(&"transfer") && !steps.contains(&"remesh"), "{steps:?}");
    let (_, steps) = update(&[("sim.iterations", "1")]);
    assert!(steps.contains(&"remesh"), "{steps:?}");
    let (_, steps) = update(&[("sim.iterations", "1")]);
    assert_eq!(steps, ["render"], "nothing is repeated");
}

#[test]
fn other_widths_of_a_seam_have_the_same_faces() {
    let example = Example::new("tshirt.usda");
    let of = |width: &'static str, edges: &'static str| {
        [
            ("seam.side.edges", edges),
            ("seam.side.width", width),
            ("fold.all.faces", "front,back"),
            ("fold.all.thickness", "0.3"),
            ("render.level", "2"),
        ]
    };
    let mut builder = example.builder();
    let mut mesh = |arguments: &[(&str, &str)]| example.update(&mut builder, arguments).render;
    let (narrow, wide, other) = (of("0.4", "side_seams"), of("0.8", "side_seams"), of("0.4", "shoulder_seams"));
    let meshes = [&narrow, &wide, &other].map(|arguments| mesh(arguments));
    let [first, again, others] = meshes.each_ref().map(|mesh| &mesh.faces);
    assert!(std::ptr::eq(first.corners(), again.corners()), "they were made once");
    assert!(first != others);
    let [first, again, others] = meshes.each_ref().map(|mesh| mesh.subsets.as_slice());
    assert!(std::ptr::eq(first, again) && !first.is_empty() && first != others);
    let uv = meshes.each_ref().map(|mesh| mesh.primvars.iter().find(|p| p.name == "st").expect("UVs"));
    let [first, again, others] = uv.map(|uv| uv.indices.as_ref().expect("indices"));
    assert!(Arc::ptr_eq(first, again) && first != others);
    assert!(uv[0].values != uv[1].values, "what is at the corners is not the same");
    let session = Session::new(ROOM, None).expect("threads");
    for arguments in [narrow, wide, other] {
        assert!(example.layer(&session, &arguments) == straight(&example, &arguments), "{arguments:?}");
    }
}

#[test]
fn many_threads_get_the_same_bytes() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, Some(2)).expect("threads"));
    let levels = ["0", "1", "2"];
    let expected = levels.map(|level| straight(&example, &[("render.level", level)]));
    std::thread::scope(|scope| {
        for i in 0..24 {
            let (example, session, expected) = (&example, &session, &expected);
            scope.spawn(move || {
                let layer = example.layer(session, &[("render.level", levels[i % 3])]);
                assert!(layer == expected[i % 3]);
            });
        }
    });
}

#[test]
fn memory_is_bounded_and_a_small_session_still_works() {
    let example = Example::new("tshirt.usda");
    let capacity = 3 * example.content.len();
    let session = Session::new(capacity, None).expect("threads");
    for length in ["8", "9", "10"] {
        let arguments = [("sim.maxEdgeLength", length)];
        assert!(example.layer(&session, &arguments) == straight(&example, &arguments));
        assert!(session.memory() <= capacity);
    }
    let large = Session::new(ROOM, None).expect("threads");
    example.layer(&large, &[]);
    assert!(large.memory() > 2 * example.content.len(), "what is kept counts");
}

#[test]
fn metadata_needs_no_products() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    let (layer, _) = session.layer(&example.document(&[]), &example.content, true).expect("a layer");
    assert!(layer.len() < 4096, "{} bytes", layer.len());
    assert!(layer.starts_with(b"PXR-USDC"));
}

#[test]
fn faults_come_back_each_time() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    for _ in 0..2 {
        let bad = example.document(&[("sim.density", "nowhere")]);
        let (layer, warnings) = session.layer(&bad, &example.content, false).expect("a layer without the value");
        assert_eq!(layer, straight(&example, &[]));
        assert!(warnings.iter().any(|warning| warning.to_string().contains("nowhere")), "the fault is reported");
        let bad = example.document(&[]);
        let message = session.layer(&bad, b"PXR-USDC and no more", false).expect_err("a fault");
        assert!(message.to_string().contains("tshirt.usda"), "{message}");
    }
}

#[test]
fn a_build_is_cancelled_at_its_next_step_and_runs_again_later() {
    let example = Example::new("tshirt.usda");
    let progress = Progress::default();
    let mut builder = example.builder().with_progress(progress.clone());
    progress.cancel();
    let stopped: Result<_, Error> = builder.update(&example.recipe(&[]));
    assert_eq!(stopped.map(|_| ()).expect_err("cancelled").kind, ErrorKind::Cancelled);
    let products = builder.update(&example.recipe(&[])).expect("products");
    assert_eq!(products.sim.points.len(), example.update(&mut example.builder(), &[]).sim.points.len());
}

#[test]
fn a_cancel_during_the_last_step_ends_that_build_and_no_other() {
    let example = Example::new("tshirt.usda");
    let own: Arc<OnceLock<Progress>> = Arc::default();
    let seen = Arc::clone(&own);
    let progress = Progress::new(move |step| {
        if step == "render" {
            seen.get().into_iter().for_each(Progress::cancel);
        }
    });
    let mut builder = example.builder().with_progress(progress.clone());
    own.set(progress).expect("set once");
    let stopped = builder.update(&example.recipe(&[])).map(|_| ()).expect_err("cancelled");
    assert_eq!(stopped.kind, ErrorKind::Cancelled);
    // Nothing cancels the plan or the next builder; the flag is not left set.
    let mut builder = builder.with_progress(Progress::default());
    assert!(builder.update(&example.recipe(&[])).is_ok());
    assert!(own.get().is_some_and(|progress| format!("{progress:?}").contains("false")), "{own:?}");
}
