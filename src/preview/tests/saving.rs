//! Saving: what is written, what is kept, and what is refused.

use super::*;
use crate::continued;
use crate::messages::SaveStatus;
use crate::save::{plan, save};
use tailor_usd::ReadOptions;

/// Edits with an option of every type.
fn edits() -> Options {
    options(&json!({
        "sim": {"maxEdgeLength": 3.1, "iterations": 2, "constraints": ["placket"], "cleanIslands": true},
        "render": {"level": 0, "operators": ["seam.side", "fold.hem"]},
        "seam": {"side": {"edges": ["side_seams"], "normalOffset": -0.1, "asymmetry": 0.25}},
        "fold": {"hem": {"faces": ["cuff_left"], "side": "outer", "enabled": false}},
    }))
}

fn edited(file: &Path) -> Arc<Hub> {
    let hub = idle(file);
    hub.edit(|document| document.edit(edits(), String::new()));
    hub
}

/// The recipe of a saved file.
fn recipe(file: &Path) -> tailor_costume::Recipe {
    let opened = input(file).open_one().expect("a good file");
    opened.check().expect("a good recipe").2
}

fn asked(hub: &Hub) -> tailor_costume::Recipe {
    let now = hub.snapshot();
    now.stage.recipe(&now.state.edits).expect("a good recipe")
}

#[test]
fn a_new_file_of_each_format_gives_the_recipe_on_screen() {
    let folder = TempDir::new().expect("a folder");
    let hub = edited(&example("coat.usda"));
    for name in ["a.usda", "a.usdc", "a.usd", "a.tailor"] {
        let file = folder.path().join(name);
        let planned = plan(&hub, &file.display().to_string());
        assert_eq!((planned.status, planned.exists), (SaveStatus::Planned, false), "{:?}", planned.fault);
        assert!(!file.exists());
        let answer = save(&hub, &file.display().to_string(), false);
        assert_eq!((answer.status, answer.text), (SaveStatus::Saved, planned.text.clone()), "{:?}", answer.fault);
        assert_eq!(recipe(&file), asked(&hub), "{name}");
        assert_eq!(save(&hub, &file.display().to_string(), false).status, SaveStatus::Refused, "{name} exists");
        if name == "a.usda" {
            assert_eq!(fs::read_to_string(&file).expect("the file"), planned.text);
            for part in ["TailorSeamAPI:side", "coat.usda@", "maxEdgeLength = 3.1\n", "normalOffset = -0.1\n"] {
                assert!(planned.text.contains(part), "{part}:\n{}", planned.text);
            }
        }
    }
}

#[test]
fn painted_weights_are_primvars_of_a_layer() {
    let folder = TempDir::new().expect("a folder");
    let (garment, file) = (example("tshirt.usda"), folder.path().join("look.usda"));
    let hub = idle(&garment);
    let mesh = Arc::clone(hub.snapshot().stage.checks.garment());
    let painted = |step: usize| {
        let weights: Vec<f32> = (0..mesh.points.len()).map(|point| (point % step) as f32 / step as f32).collect();
        tailor::sets::painted_expression(&mesh.faces, &weights)
    };
    let path = file.display().to_string();
    let saved = |edits: serde_json::Value| {
        hub.edit(|document| document.edit(options(&edits), String::new()));
        let answer = save(&hub, &path, true);
        assert_eq!(answer.status, SaveStatus::Saved, "{:?}", answer.fault);
        fs::read_to_string(&file).expect("the file")
    };
    for step in [3, 4] {
        let text = saved(json!({
            "sim": {"density": painted(step)},
            "cloth": {"pins": ["neckband_edge", painted(2), painted(6)]},
            "fold": {"neck": {"faces": ["neckband"], "weights": painted(5)}},
        }));
        for name in ["sim_density", "cloth_pins", "cloth_pins_2", "fold_neck_weights"] {
            assert_eq!(text.matches(&format!("float[] primvars:tailor:painted_{name} = ")).count(), 1, "{text}");
        }
        // Named as a recipe of the garment below, the layer gives the weights themselves.
        let recipe = Input { recipe: Some(file.clone()), ..input(&garment) };
        assert_eq!(Stage::open(&recipe, None).expect("a good layer").given, hub.snapshot().state.edits);
    }
    assert!(!saved(json!({"sim": {"iterations": 2}})).contains("painted_"), "weights that are no longer used go");
}

#[test]
fn an_existing_layer_keeps_what_else_it_holds_and_loses_earlier_options() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("look.usda");
    let coat = example("coat.usda").display().to_string();
    let text = format!(
        "#usda 1.0\n(\n    customLayerData = {{ string note = \"kept\" }}\n    subLayers = [@{coat}@]\n)\n\
         def Scope \"lights\" {{ float power = 3 }}\n\
         over \"Coat\" {{\n    over \"model\" (\n        prepend apiSchemas = [\"TailorSeamAPI:old\", \"MyAPI\"]\n    )\n    {{\n        \
         uniform float tailor:seam:old:width = 2\n        custom string owner = \"me\"\n        \
         uniform float tailor:later:option = 4\n    }}\n}}\n"
    );
    fs::write(&file, text).expect("a file");
    let hub = edited(&example("coat.usda"));
    let path = file.display().to_string();
    assert!(!plan(&hub, &path).note.contains("comments"));
    fs::write(&file, fs::read_to_string(&file).expect("the file") + "# to be checked\n").expect("a file");
    assert!(plan(&hub, &path).note.contains("comments"), "what is lost is reported before");
    assert_eq!(save(&hub, &path, false).status, SaveStatus::Refused, "it exists");
    let answer = save(&hub, &path, true);
    assert_eq!(answer.status, SaveStatus::Saved, "{:?}", answer.fault);
    let after = fs::read_to_string(&file).expect("the file");
    for kept in ["note = \"kept\"", "\"lights\"", "power = 3", "owner = \"me\"", "tailor:later:option = 4", "\"MyAPI\""]
    {
        assert!(after.contains(kept), "{kept} is lost:\n{after}");
    }
    assert!(!after.contains(":old"), "{after}");
    assert_eq!(recipe(&file), asked(&hub));
    // A second save replaces the first.
    hub.edit(|document| document.edit(options(&json!({"render": {"level": 0}})), String::new()));
    assert_eq!(save(&hub, &path, true).status, SaveStatus::Saved);
    assert_eq!(recipe(&file), asked(&hub));
}

#[test]
fn an_existing_layer_gets_the_garment_as_its_weakest_sublayer() {
    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("lights.usda"), "#usda 1.0\ndef Scope \"lights\" {}\n").expect("a file");
    let hub = edited(&example("coat.usda"));
    for (name, sublayers) in [("plain.usda", ""), ("shot.usda", "(\n    subLayers = [@./lights.usda@]\n)\n")] {
        let file = folder.path().join(name);
        fs::write(&file, format!("#usda 1.0\n{sublayers}def Scope \"shot\" {{}}\n")).expect("a file");
        let answer = save(&hub, &file.display().to_string(), true);
        assert_eq!(answer.status, SaveStatus::Saved, "{:?}", answer.fault);
        assert_eq!(recipe(&file), asked(&hub));
        let text = fs::read_to_string(&file).expect("the file");
        let at = |part: &str| text.find(part);
        assert!(at("shot").is_some() && at("coat.usda@").is_some() && at("lights.usda@") < at("coat.usda@"), "{text}");
    }
}

#[test]
fn a_crate_layer_keeps_its_overs() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("look.usdc").display().to_string();
    let hub = edited(&example("coat.usda"));
    assert_eq!(save(&hub, &file, false).status, SaveStatus::Saved);
    assert_eq!(save(&hub, &file, true).status, SaveStatus::Saved);
    // An over that becomes a def would hide the type of the mesh.
    assert_eq!(recipe(Path::new(&file)), asked(&hub));
}

#[test]
fn the_garment_and_its_layers_are_never_written() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("over.usda");
    let coat = folder.path().join("coat.usda");
    fs::copy(example("coat.usda"), &coat).expect("a copy");
    fs::write(&file, "#usda 1.0\n(\n    subLayers = [@./coat.usda@]\n)\n").expect("a file");
    let hub = edited(&file);
    for target in [&file, &coat] {
        let before = fs::read(target).expect("the file");
        let answer = save(&hub, &target.display().to_string(), true);
        assert_eq!(answer.status, SaveStatus::Refused);
        assert!(answer.fault.is_some_and(|fault| fault.text.contains("input")));
        assert_eq!(fs::read(target).expect("the file"), before);
    }
}

#[test]
fn what_cannot_be_written_back_is_refused_and_stays() {
    let folder = TempDir::new().expect("a folder");
    let coat = example("coat.usda").display().to_string();
    let hub = edited(&example("coat.usda"));
    for (name, body) in [
        ("inherit.usda", "class \"_c\" {}\nover \"Coat\" (prepend inherits = </_c>) {}\n"),
        (
            "stronger.usda",
            "over \"Coat\" { over \"model\" { int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2] } }\n",
        ),
        ("broken.usda", "over {"),
    ] {
        let file = folder.path().join(name);
        let text = format!("#usda 1.0\n(\n    subLayers = [@{coat}@]\n)\n{body}");
        fs::write(&file, &text).expect("a file");
        let answer = save(&hub, &file.display().to_string(), true);
        assert_eq!(answer.status, SaveStatus::Refused, "{name}");
        assert_eq!(fs::read_to_string(&file).expect("the file"), text, "{name}");
        assert_eq!(
            fs::read_dir(folder.path())
                .expect("the folder")
                .filter(|e| { e.as_ref().is_ok_and(|e| e.file_name().to_string_lossy().starts_with(".usdtailor")) })
                .count(),
            0
        );
    }
}

#[test]
fn a_selected_variant_is_saved_in_a_layer_and_refused_in_a_recipe_file() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("a.usda");
    fs::write(&file, sheet(3, "fold")).expect("a file");
    let hub = idle(&file);
    hub.select(Selection { prim: "/A".into(), set: "size".into(), choice: "two".into() });
    let look = folder.path().join("look.usda");
    assert_eq!(save(&hub, &look.display().to_string(), false).status, SaveStatus::Saved);
    assert_eq!(recipe(&look).render.level, 2);
    // The next session begins with the variant, and can save it again.
    let again = continued(input(&look));
    let next = Hub::new(again.clone(), Stage::open(&again, None).expect("a good garment"));
    assert_eq!(next.snapshot().stage.source.facts().variants[0].selected.choice, "two");
    next.edit(|document| document.edit(options(&json!({"sim": {"iterations": 2}})), String::new()));
    let answer = save(&next, &look.display().to_string(), true);
    assert_eq!(answer.status, SaveStatus::Saved, "{:?}", answer.fault);
    assert_eq!((recipe(&look).render.level, recipe(&look).sim.iterations), (2, 2));
    let answer = save(&hub, &folder.path().join("a.tailor").display().to_string(), false);
    assert!(answer.fault.is_some_and(|fault| fault.text.contains("variants")));
}

#[test]
fn a_layer_that_was_saved_is_the_start_of_the_next_session() {
    let folder = TempDir::new().expect("a folder");
    let look = folder.path().join("look.usda");
    let hub = edited(&example("coat.usda"));
    assert_eq!(save(&hub, &look.display().to_string(), false).status, SaveStatus::Saved);
    let again = continued(input(&look));
    assert_eq!(again.file.canonicalize().ok(), example("coat.usda").canonicalize().ok());
    assert_eq!(again.recipe, Some(look));
    let stage = Stage::open(&again, None).expect("a good garment");
    assert_eq!(stage.recipe(&stage.given).expect("a good recipe"), asked(&hub));
    assert_eq!(stage.given, edits());
}

#[test]
fn a_layer_of_somebody_else_is_a_garment_and_not_a_recipe() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("look.usda");
    let coat = example("coat.usda").display().to_string();
    fs::write(&file, format!("#usda 1.0\n(\n    subLayers = [@{coat}@]\n)\nover \"Coat\" {{}}\n")).expect("a file");
    for garment in [file, example("coat.usda"), example("sewn/coat.usda")] {
        let again = continued(input(&garment));
        assert_eq!((again.file, again.recipe), (garment, None));
    }
}

/// Two quads that share an edge, each a mesh of its own, and a belt beside them.
const PANELS: &str = "#usda 1.0\ndef Xform \"Suit\"\n{\n    def Mesh \"front\"\n    {\n        int[] faceVertexCounts = [4]\n        \
    int[] faceVertexIndices = [0, 1, 2, 3]\n        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n    }\n    \
    def Mesh \"back\"\n    {\n        int[] faceVertexCounts = [4]\n        int[] faceVertexIndices = [0, 1, 2, 3]\n        \
    point3f[] points = [(1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)]\n    }\n}\ndef Mesh \"belt\"\n{\n    int[] faceVertexCounts = [4]\n    \
    int[] faceVertexIndices = [0, 1, 2, 3]\n    point3f[] points = [(0, 0, 5), (1, 0, 5), (1, 1, 5), (0, 1, 5)]\n}\n";

#[test]
fn sewn_panels_are_shown_as_one_and_saved_in_a_recipe_file() {
    let folder = TempDir::new().expect("a folder");
    let [file, saved, look] = ["suit.usda", "suit.tailor", "look.usda"].map(|name| folder.path().join(name));
    fs::write(&file, PANELS).expect("a file");
    let below = ReadOptions { prim: Some("/Suit".into()), ..ReadOptions::default() };
    let input = Input { file: file.clone(), read: below, ..Input::default() };
    let hub = Hub::new(input.clone(), Stage::open(&input, None).expect("a good garment"));
    let stage = hub.snapshot().stage;
    assert_eq!((stage.mesh.face_vertex_counts.len(), stage.mesh.points.len()), (2, 6));
    assert!(
        stage.message.contains("\"layer\":null") && stage.message.contains("/Suit/front+back"),
        "{}",
        stage.message
    );
    let seam = json!({"render": {"level": 1}, "seam": {"middle": {"edges": ["sewn"], "width": 0.1}}});
    hub.edit(|document| document.edit(options(&seam), String::new()));
    let refused = save(&hub, &look.display().to_string(), false);
    assert!(refused.fault.is_some_and(|fault| fault.remedy.contains(".tailor")) && !look.exists());
    let answer = save(&hub, &saved.display().to_string(), false);
    assert_eq!(answer.status, SaveStatus::Saved, "{:?}", answer.fault);
    assert_eq!(recipe(&saved), asked(&hub));
    let all = ReadOptions { all: true, ..ReadOptions::default() };
    let error =
        Stage::open(&Input { file, read: all, ..Input::default() }, None).err().expect("two garments").to_string();
    assert!(error.contains("2 garments") && error.contains("/Suit, /belt"), "{error}");
}

#[cfg(unix)]
#[test]
fn the_file_that_a_link_leads_to_is_written() {
    let folder = TempDir::new().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("far")).expect("a folder");
    let hub = edited(&example("coat.usda"));
    for name in ["a.tailor", "a.usda"] {
        fs::write(at("far").join(name), if name == "a.usda" { "#usda 1.0\n" } else { "{}" }).expect("a file");
        std::os::unix::fs::symlink(at("far").join(name), at(name)).expect("a link");
        let answer = save(&hub, &at(name).display().to_string(), true);
        assert_eq!(answer.status, SaveStatus::Saved, "{name}: {:?}", answer.fault);
        assert!(at(name).is_symlink(), "{name}");
        for file in [at(name), at("far").join(name)] {
            assert_eq!(recipe(&file), asked(&hub), "{}", file.display());
        }
    }
    std::os::unix::net::UnixListener::bind(at("socket.tailor")).expect("a socket");
    let answer = save(&hub, &at("socket.tailor").display().to_string(), true);
    let words = format!("{:?}", answer.fault);
    assert!(answer.status == SaveStatus::Refused && words.contains("not a regular file"), "{words}");
    assert!(!at("socket.tailor").is_file(), "it stays");
}
