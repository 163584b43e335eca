//! Tests of the state that pages share, without a server.

mod keeping;
mod protocol;
mod saving;

use super::document::Options;
use super::hub::{Hub, Snapshot};
use super::messages::{Origin, Role};
use super::stage::Stage;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};
use tailor_usd::Selection;
use tailor_usd::session::Input;
use tempfile::TempDir;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn input(file: &Path) -> Input {
    Input { file: file.to_path_buf(), ..Input::default() }
}

/// A hub that builds nothing.
fn idle(file: &Path) -> Arc<Hub> {
    Hub::new(input(file), Stage::open(&input(file), None).expect("a good garment"))
}

fn building(file: &Path) -> Arc<Hub> {
    let hub = idle(file);
    hub.start(Some(1)).expect("threads");
    hub
}

fn options(value: &serde_json::Value) -> Options {
    value.as_object().cloned().expect("an object")
}

/// The state once `is_there` holds.
fn when(hub: &Hub, is_there: impl Fn(&Snapshot) -> bool) -> Snapshot {
    let start = Instant::now();
    loop {
        let now = hub.snapshot();
        if is_there(&now) {
            return now;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "it never came");
        sleep(Duration::from_millis(5));
    }
}

fn faults(now: &Snapshot, origin: Origin) -> usize {
    now.faults.get(&origin).map_or(0, Vec::len)
}

/// A grid of quads with a subset and a variant set, as text.
fn sheet(size: usize, set: &str) -> String {
    let at = |i: usize, j: usize| i * (size + 1) + j;
    let cells = || (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
    let points: Vec<String> = (0..=size).flat_map(|i| (0..=size).map(move |j| format!("({j}, {i}, 0)"))).collect();
    let corners: Vec<String> = cells()
        .map(|(i, j)| format!("{}, {}, {}, {}", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)))
        .collect();
    format!(
        "#usda 1.0\n(\n    defaultPrim = \"A\"\n)\ndef Xform \"A\" (\n    variants = {{ string size = \"one\" }}\n    \
         prepend variantSets = \"size\"\n)\n{{\n    def Mesh \"model\"\n    {{\n        int[] faceVertexCounts = [{}]\n        \
         int[] faceVertexIndices = [{}]\n        point3f[] points = [{}]\n        def GeomSubset \"{set}\"\n        {{\n            \
         uniform token elementType = \"edge\"\n            int[] indices = [{}, {}]\n        }}\n    }}\n    \
         variantSet \"size\" = {{\n        \"one\" {{ }}\n        \"two\" {{ over \"model\" {{ bool doubleSided = 1\n        \
         uniform int tailor:render:level = 2 }} }}\n    }}\n}}\n",
        vec!["4"; size * size].join(", "),
        corners.join(", "),
        points.join(", "),
        at(1, 1),
        at(1, 2),
    )
}

#[test]
fn the_newest_edit_is_built_and_the_other_product_stays() {
    let hub = building(&example("tshirt.usda"));
    let first =
        when(&hub, |now| now.shown.len() == 3 && !now.messages.values().any(|text| text.contains("\"step\":\"")));
    for level in [0, 2, 1, 2, 0] {
        hub.edit(|document| document.edit(options(&json!({"render": {"level": level}})), String::new()));
    }
    let faces = hub.snapshot().stage.checks.garment().faces.len();
    let last = when(&hub, |now| now.shown[&Role::Render].mesh.faces.len() == faces);
    assert!(Arc::ptr_eq(&first.shown[&Role::Sim].mesh, &last.shown[&Role::Sim].mesh));
}

#[test]
fn a_fault_keeps_the_last_good_mesh_and_names_the_option() {
    let hub = building(&example("tshirt.usda"));
    let good = when(&hub, |now| now.shown.contains_key(&Role::Render));
    hub.edit(|document| document.edit(options(&json!({"render": {"level": 9}})), String::new()));
    let bad = when(&hub, |now| faults(now, Origin::Recipe) > 0);
    assert!(bad.faults[&Origin::Recipe][0].place.contains("render.level"), "{:?}", bad.faults);
    assert!(Arc::ptr_eq(&good.shown[&Role::Render].mesh, &bad.shown[&Role::Render].mesh));
    hub.edit(|document| document.undo());
    when(&hub, |now| faults(now, Origin::Recipe) == 0);
}

#[test]
fn a_file_that_breaks_is_told_and_a_mended_one_keeps_the_edits() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("a.usda");
    fs::write(&file, sheet(3, "fold")).expect("a file");
    let hub = idle(&file);
    hub.edit(|document| document.edit(options(&json!({"render": {"level": 0}})), String::new()));
    fs::write(&file, "#usda 1.0\ndef Mesh \"A\" {").expect("a file");
    hub.reload();
    let broken = hub.snapshot();
    assert_eq!((faults(&broken, Origin::File), broken.shown[&Role::Model].mesh.faces.len()), (1, 9));
    fs::write(&file, sheet(4, "fold")).expect("a file");
    hub.reload();
    let mended = hub.snapshot();
    assert_eq!((faults(&mended, Origin::File), mended.shown[&Role::Model].mesh.faces.len()), (0, 16));
    assert_eq!(mended.state.edits, options(&json!({"render": {"level": 0}})));
}

#[test]
fn a_variant_is_selected_over_the_stage() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("a.usda");
    fs::write(&file, sheet(3, "fold")).expect("a file");
    let hub = idle(&file);
    let sets = hub.snapshot().stage.source.facts().variants.clone();
    assert_eq!((sets.len(), sets[0].choices.as_slice()), (1, &["one".to_owned(), "two".to_owned()][..]));
    hub.select(Selection { prim: "/A".into(), set: "size".into(), choice: "two".into() });
    let now = hub.snapshot();
    assert_eq!(now.stage.source.facts().variants[0].selected.choice, "two");
    assert_eq!(now.stage.upstream, options(&json!({"render": {"level": 2}})));
}
