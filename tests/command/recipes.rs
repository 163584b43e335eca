//! Where options come from: flag, recipe file, attribute of the model, default.

use crate::cloth::{CLOTH, cloth_and};
use crate::folder::Folder;
use serde_json::Value;

/// The value of `sim.iterations` and of `sim.maxEdgeLength` that a build uses.
#[track_caller]
fn used(folder: &Folder, args: &str) -> (Value, Value) {
    folder.good(&format!("build {args} -o out/coat.usda --report out/report.json --force -q"));
    let report: Value = serde_json::from_slice(&folder.read("out/report.json")).expect("JSON");
    let sim = &report["recipe"]["sim"];
    (sim["iterations"].clone(), sim["maxEdgeLength"].clone())
}

#[test]
fn flag_file_attribute_default() {
    let folder = Folder::new();
    folder.file("plain.usda", CLOTH);
    folder.file(
        "own.usda",
        cloth_and("uniform int tailor:sim:iterations = 2\nuniform float tailor:sim:maxEdgeLength = 0.75"),
    );
    folder.file("my.tailor", "{\"sim\": {\"iterations\": 3}}");
    let is = |args: &str, iterations: i32, length: f32| {
        let (i, l) = used(&folder, args);
        assert_eq!((i.as_i64(), l.as_f64()), (Some(iterations.into()), Some(length.into())), "{args}");
    };
    let (iterations, automatic) = used(&folder, "plain.usda");
    assert_eq!(iterations, 5);
    assert!(automatic.as_f64().is_some_and(|l| (0.4..0.6).contains(&l)), "half the mean edge: {automatic}");
    is("own.usda", 2, 0.75);
    is("own.usda --recipe my.tailor", 3, 0.75);
    is("own.usda --recipe my.tailor --set sim.iterations=4", 4, 0.75);
    is("own.usda --set sim.maxEdgeLength=0.5 --set sim.maxEdgeLength=0.25", 2, 0.25);
}

/// Edges have a length of 1 to 1.03 mesh units.
#[test]
fn a_seam_without_a_width_has_that_of_a_real_one() {
    let folder = Folder::new();
    let width = |meters: &str| {
        folder.file("in.usda", CLOTH.replace("metersPerUnit = 0.01", &format!("metersPerUnit = {meters}")));
        folder.good("build in.usda -o out.usda --set seam.s.edges=placket --report report.json --force -q");
        let report: Value = serde_json::from_slice(&folder.read("report.json")).expect("JSON");
        report["recipe"]["seam"]["s"]["width"].as_f64().expect("a width")
    };
    let is_near = |width: f64, wanted: f64| (width - wanted).abs() < 0.02 * wanted;
    assert!(is_near(width("0.1"), 0.05), "5 mm in faces of 10 cm");
    assert!(is_near(width("1"), 0.005), "5 mm in faces of 1 m");
    assert!(is_near(width("0.01"), 0.25), "a quarter of an edge of 1 cm");
    assert!(is_near(width("0.001"), 0.25), "a quarter of an edge of 1 mm");
}

#[test]
fn a_recipe_may_name_the_source_and_the_prim() {
    let folder = Folder::new();
    std::fs::create_dir(folder.at("recipes")).expect("a folder");
    let two = CLOTH.replace("def Xform \"Coat\"", "def Mesh \"other\" {}\n\ndef Xform \"Coat\"");
    folder.file("in.usda", two);
    folder.file(
        "recipes/coat.tailor",
        "{\"source\": \"../in.usda\", \"prim\": \"/Coat/model\", \"render\": {\"level\": 2}}",
    );
    let run = folder.good("build --recipe recipes/coat.tailor -o out/coat.usda");
    run.prints(&["64 faces, 100.0 % quads, level 2"]);
    folder.good("check --recipe recipes/coat.tailor");
    folder.good("info --recipe recipes/coat.tailor").prints(&["/Coat/model"]);
    // What the command line names is stronger.
    assert_eq!(folder.run("check --recipe recipes/coat.tailor --prim /other").code, Some(1));
}

#[test]
fn an_attribute_of_no_schema_is_told_and_stays() {
    let folder = Folder::new();
    folder.file("in.usda", cloth_and("uniform float tailor:sim:stretch = 2"));
    folder.good("build in.usda -o out/coat.usda").says(&["warning[not-carried]: tailor:sim:stretch: not carried"]);
}

#[test]
fn a_recipe_is_an_input_too() {
    let folder = Folder::new();
    std::fs::create_dir(folder.at("recipes")).expect("a folder");
    folder.file("in.usda", cloth_and("uniform int tailor:sim:iterations = 2\nuniform int tailor:render:level = 3"));
    folder.file("recipes/coat.tailor", "{\"source\": \"../in.usda\", \"sim\": {\"iterations\": 3}}");
    folder.file("fine.tailor", "{\"render\": {\"level\": 2}}");
    folder.good("build recipes/coat.tailor -o out/coat.usda").prints(&["recipes/coat.tailor -> out/coat.usda"]);
    folder.good("build in.usda -o out/same.usda --set sim.iterations=3");
    // All but the record of what each was made of.
    let layer = |name: &str| folder.text(name).split_once("\n)\n").map(|(_, layer)| layer.to_owned());
    let (coat, same) = (layer("out/coat.usda"), layer("out/same.usda"));
    assert!(coat.is_some() && coat == same, "the same layer over the same source");
    // Attribute, the input's own file, --recipe, --set.
    let of = |args: &str| used(&folder, &format!("recipes/coat.tailor {args}")).0;
    assert_eq!((of(""), of("--set sim.iterations=4")), (3.into(), 4.into()));
    folder.good("build recipes/coat.tailor --recipe fine.tailor -o out/fine.usda").prints(&["level 2"]);
    folder.good("info recipes/coat.tailor").prints(&["in.usda /Coat/model"]);
    folder.good("check recipes/coat.tailor in.usda").prints(&["recipes/coat.tailor: good"]);
    folder.good("build recipes/coat.tailor in.usda -o out");
    assert!(folder.at("out/coat_tailored.usdc").is_file() && folder.at("out/in_tailored.usdc").is_file());
}

#[test]
fn a_recipe_without_a_usd_source_is_no_input() {
    let folder = Folder::new();
    for (text, expected) in [
        ("{\"render\": {\"level\": 2}}", "bad.tailor: it names no source"),
        ("{\"source\": \"\"}", "bad.tailor: it names no source"),
        ("{\"source\": \"other.tailor\"}", "bad.tailor: its source is a recipe too"),
        ("{\"source\": \"gone.usda\"}", "cannot read gone.usda: no such file"),
        ("{\"source\": 3}", "bad.tailor: "),
    ] {
        folder.file("bad.tailor", text);
        let run = folder.run("build bad.tailor -o out/coat.usda");
        run.says(&[expected, "hint:"]);
        assert_eq!(run.code, Some(1), "{text}");
    }
    folder.run("check gone.tailor").says(&["gone.tailor: cannot read recipe: no such file", "hint:"]);
}
