//! A session gives what the pipeline gives, makes each stage once, and stays within its memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor::error::Warnings;
use tailor::pipeline::{DEFAULT_MAX_FACES, Limits};
use tailor::recipe::Document;
use tailor::session::{Opened, Session};
use tailor::usd::{Format, Product, ProductRole, ReadOptions, Source, Surroundings, WriteOptions, layer_bytes, write};

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
        write(&source, &[], &flat, &options, &mut Warnings::default()).expect("a flat layer");
        Self { folder, content: std::fs::read(flat).expect("a flat layer") }
    }

    /// A `.tailor` file for it.
    fn document(&self, arguments: &[(&str, &str)]) -> Document {
        let text = r#"{"source": "tshirt.usda", "sim": {"iterations": 2}}"#;
        Document::new(&self.folder.join("tshirt.tailor"), text, arguments.iter().copied()).expect("a good file")
    }

    fn layer(&self, session: &Session, arguments: &[(&str, &str)]) -> Vec<u8> {
        let mut warnings = Warnings::default();
        session.layer(&self.document(arguments), &self.content, false, &mut warnings).expect("a layer")
    }

    fn open(&self, session: &Session, document: &Document) -> Arc<Opened> {
        session.open(&self.content, &document.source_file(), document.options()).expect("a garment")
    }
}

/// The same without a session.
fn straight(example: &Example, arguments: &[(&str, &str)]) -> Vec<u8> {
    let document = example.document(arguments);
    let content: Arc<[u8]> = example.content.clone().into();
    let mut warnings = Warnings::default();
    let source = Source::from_layer(content, &document.source_file(), document.options()).expect("a garment");
    let layers = document.layers(&source, &mut warnings).expect("a recipe");
    let input = source.garment(&mut warnings).expect("a mesh");
    let prepared = tailor::pipeline::Prepared::new(input, &layers, &mut warnings).expect("a good garment");
    let limits = Limits { max_faces: DEFAULT_MAX_FACES, progress: &|_| () };
    let products = prepared.build(&limits, &mut warnings).expect("products");
    let meshes = [
        Product { name: "sim", role: ProductRole::Sim, mesh: &products.sim },
        Product { name: "render", role: ProductRole::Render, mesh: &products.render },
    ];
    let surroundings = Surroundings { folder: document.folder(), source: Some(document.source()) };
    layer_bytes(&source, &meshes, Format::Usdc, surroundings, &WriteOptions::default(), &mut warnings).expect("a layer")
}

#[test]
fn a_session_gives_what_the_pipeline_gives() {
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
            ("thickness.all.faces", "front,back"),
            ("thickness.all.amount", amount),
            ("render.operators", operators),
        ]
    };
    // From small to large, so that what is kept of the first was made for less.
    for arguments in [of("0.1", "-0.1", ""), of("4", "-0.1", ""), of("4", "-0.3", ""), of("0.1", "-0.1", "side")] {
        assert!(example.layer(&session, &arguments) == straight(&example, &arguments), "{arguments:?}");
    }
}

#[test]
fn an_edit_repeats_only_what_depends_on_it() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    let products = |arguments: &[(&str, &str)]| {
        let document = example.document(arguments);
        let opened = example.open(&session, &document);
        let layers = document.layers(&opened.source, &mut Warnings::default()).expect("a recipe");
        let prepared = opened.checked.prepare(&layers).expect("a recipe that fits");
        (session.sim(&opened, &prepared).expect("a mesh"), session.render(&opened, &prepared).expect("a mesh"))
    };
    let (sim, render) = products(&[]);
    let (other_sim, other_render) = products(&[("render.level", "2")]);
    assert!(Arc::ptr_eq(&sim, &other_sim) && !Arc::ptr_eq(&render, &other_render));
    let (other_sim, other_render) = products(&[("sim.maxEdgeLength", "6")]);
    assert!(!Arc::ptr_eq(&sim, &other_sim) && Arc::ptr_eq(&render, &other_render));
    // Another option of transfer gives another mesh, on the same triangles.
    let before = session.memory();
    let (other_sim, _) = products(&[("sim.seed", "1")]);
    assert!(!Arc::ptr_eq(&sim, &other_sim) && sim.value.faces == other_sim.value.faces);
    let transferred = session.memory() - before;
    let (_, _) = products(&[("sim.iterations", "1")]);
    assert!(session.memory() - before > 2 * transferred, "a seed does not remesh, a round does");
}

#[test]
fn other_widths_of_a_seam_have_the_same_faces() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    let of = |width: &'static str, edges: &'static str| {
        [
            ("seam.side.edges", edges),
            ("seam.side.width", width),
            ("thickness.all.faces", "front,back"),
            ("thickness.all.amount", "0.3"),
            ("render.level", "2"),
        ]
    };
    let mesh = |arguments: &[(&str, &str)]| {
        let document = example.document(arguments);
        let opened = example.open(&session, &document);
        let layers = document.layers(&opened.source, &mut Warnings::default()).expect("a recipe");
        let prepared = opened.checked.prepare(&layers).expect("a recipe that fits");
        session.render(&opened, &prepared).expect("a mesh")
    };
    let (narrow, wide, other) = (of("0.4", "side_seams"), of("0.8", "side_seams"), of("0.4", "shoulder_seams"));
    let meshes = [&narrow, &wide, &other].map(|arguments| mesh(arguments));
    let [first, again, others] = meshes.each_ref().map(|mesh| &mesh.value.faces);
    assert!(std::ptr::eq(first.corners(), again.corners()), "they were made once");
    assert!(first != others);
    let [first, again, others] = meshes.each_ref().map(|mesh| mesh.value.subsets.as_slice());
    assert!(std::ptr::eq(first, again) && !first.is_empty() && first != others);
    let uv = meshes.each_ref().map(|mesh| mesh.value.primvars.iter().find(|p| p.name == "st").expect("UVs"));
    let [first, again, others] = uv.map(|uv| uv.indices.as_ref().expect("indices"));
    assert!(Arc::ptr_eq(first, again) && first != others);
    assert!(uv[0].values != uv[1].values, "what is at the corners is not the same");
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
}

#[test]
fn metadata_needs_no_products() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    let mut warnings = Warnings::default();
    let layer = session.layer(&example.document(&[]), &example.content, true, &mut warnings).expect("a layer");
    assert!(layer.len() < 4096, "{} bytes", layer.len());
    assert!(layer.starts_with(b"PXR-USDC"));
}

#[test]
fn faults_come_back_each_time() {
    let (example, session) = (Example::new("tshirt.usda"), Session::new(ROOM, None).expect("threads"));
    for _ in 0..2 {
        let bad = example.document(&[("sim.density", "nowhere")]);
        let message = session.layer(&bad, &example.content, false, &mut Warnings::default()).expect_err("a fault");
        assert!(message.to_string().contains("nowhere"), "{message}");
        let bad = example.document(&[]);
        let message =
            session.layer(&bad, b"PXR-USDC and no more", false, &mut Warnings::default()).expect_err("a fault");
        assert!(message.to_string().contains("tshirt.usda"), "{message}");
    }
}
