//! `check` and `info` of an output speak of the build that made it.

use crate::cloth::CLOTH;
use crate::folder::{Folder, Run};
use serde_json::Value;

/// The recipe that `info` tells of an output.
#[track_caller]
fn recipe(folder: &Folder, args: &str) -> Value {
    let run = folder.good(&format!("info {args} --json"));
    let found: Value = serde_json::from_str(&run.stdout).expect("JSON");
    found["inputs"][0]["recipe"].clone()
}

#[track_caller]
fn warns(run: &Run, code: &str) -> bool {
    run.stderr.contains(&format!("warning[{code}]"))
}

#[test]
fn options_of_the_command_line_are_those_of_the_build() {
    let folder = Folder::new();
    folder.file("in.usda", CLOTH);
    folder.file("my.tailor", "{\"render\": {\"level\": 2}}");
    let options = "--recipe my.tailor --set sim.maxEdgeLength=0.25 --set sim.iterations=2";
    folder.good(&format!("build in.usda -o out/coat.usda {options}"));
    assert_eq!(recipe(&folder, "out/coat.usda"), recipe(&folder, &format!("in.usda {options}")));
    folder.good("info out/coat.usda").prints(&[
        "  made     of ../in.usda --recipe ../my.tailor --set sim.maxEdgeLength=0.25 --set sim.iterations=2; fresh",
        "render   64 faces at level 2",
    ]);
    // What the command line says now is stronger.
    let changed = recipe(&folder, "out/coat.usda --set sim.iterations=3");
    assert_eq!((&changed["sim"]["iterations"], &changed["render"]["level"]), (&3.into(), &2.into()));
    folder.file("my.tailor", "{\"render\": {\"level\": 3}}");
    folder.good("info out/coat.usda").prints(&["; stale: ../my.tailor has changed"]);
}

#[test]
fn an_output_of_a_recipe_is_described_by_it() {
    let folder = Folder::new();
    let two = CLOTH.replace("def Xform \"Coat\"", "def Mesh \"other\" {}\n\ndef Xform \"Coat\"");
    folder.file("in.usda", two);
    folder.file("coat.tailor", "{\"source\": \"in.usda\", \"prim\": \"/Coat/model\", \"render\": {\"level\": 2}}");
    for flag in ["", "--flatten"] {
        folder.good(&format!("build coat.tailor -o out/coat.usda --force {flag}"));
        assert_eq!(recipe(&folder, "out/coat.usda")["render"]["level"], 2);
        let run = folder.good("check out/coat.usda");
        assert_eq!(run.stdout, "out/coat.usda: good, and fresh\n");
    }
    std::fs::remove_file(folder.at("coat.tailor")).expect("the recipe");
    let run = folder.run("check out/coat.usda --prim /Coat/model");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["stale: ../coat.tailor cannot be read any more"]);
}

/// A check finds the warnings of the build that was made, and no others.
#[test]
fn a_check_warns_as_the_build_did() {
    let folder = Folder::new();
    folder.file("in.usda", CLOTH);
    let options = "--set seam.s.edges=placket --set seam.s.width=1.35 --set seam.s.asymmetry=0.5";
    let built = folder.good(&format!("build in.usda -o out/coat.usda {options}"));
    assert!(warns(&built, "narrow-seam"), "{built}");
    let run = folder.good("check out/coat.usda");
    assert!(warns(&run, "narrow-seam"), "{run}");
    assert!(!warns(&folder.good("check in.usda"), "narrow-seam"));
}

#[test]
fn a_prim_a_time_and_all_meshes_are_those_of_the_build() {
    let folder = Folder::new();
    let (before, rest) = CLOTH.split_once("point3f[] points = [").expect("the cloth has points");
    let (points, after) = rest.split_once("]\n").expect("the points end");
    let wider = points.replace("(2, ", "(5, ");
    let timed = format!("{before}point3f[] points.timeSamples = {{ 1: [{points}], 2: [{wider}] }}\n{after}");
    folder.file("in.usda", timed);
    folder.good("build in.usda -o out/coat.usda --time 2 --prim /Coat/model");
    let described = |args: &str| {
        let run = folder.good(&format!("info {args}"));
        run.stdout.lines().find(|line| line.contains("mean edge")).map(str::to_owned)
    };
    assert_eq!(described("out/coat.usda"), described("in.usda --time 2"));
    assert_ne!(described("out/coat.usda --time 1"), described("in.usda --time 2"));

    let suit = CLOTH.replace("def Xform \"Coat\"", "def Xform \"Coat\" (references = </Cut>) {}\n\ndef Xform \"Cut\"");
    folder.file("suit.usda", suit.replace("defaultPrim = \"Coat\"", "defaultPrim = \"Cut\""));
    folder.good("build suit.usda -o out/suit.usda --all --exclude Cut");
    folder.good("info out/suit.usda").prints(&["/Coat/model", "--all --exclude Cut"]);
    folder.good("check out/suit.usda").prints(&["good, and fresh"]);
}

#[test]
fn each_variant_of_the_build_is_described() {
    let folder = Folder::new();
    let sized = CLOTH.replace(
        "def Xform \"Coat\"",
        "def Xform \"Coat\" (\n    prepend variantSets = \"size\"\n    variants = { string size = \"S\" }\n)",
    );
    let end = sized.rfind('}').expect("the end of the root");
    let large = "over \"model\" { int tailor:render:level = 1 }";
    let sets = format!("    variantSet \"size\" = {{ \"L\" {{ {large} }} \"S\" {{ }} }}\n}}\n");
    folder.file("in.usda", sized[..end].to_owned() + &sets);
    folder.good("build in.usda -o out/coat.usda --variants size");
    folder.good("info out/coat.usda").prints(&[
        "/Coat/model size=L",
        "16 faces at level 1",
        "/Coat/model size=S",
        "64 faces",
    ]);
    folder.good("check out/coat.usda").prints(&["good, and fresh"]);
}

/// The second of two garments in one shot records its own build; the first one keeps its options.
#[test]
fn another_prim_is_not_described_by_the_build() {
    let folder = Folder::new();
    let two =
        CLOTH.replace("def Xform \"Coat\"", "def Xform \"Other\" (references = </Coat>) {}\n\ndef Xform \"Coat\"");
    folder.file("in.usda", two);
    folder.good("build in.usda -o out/coat.usda --prim /Coat/model --set render.level=1");
    assert_eq!(recipe(&folder, "out/coat.usda")["render"]["level"], 1);
    assert_eq!(recipe(&folder, "out/coat.usda --prim /Coat/model")["render"]["level"], 1);
    assert_eq!(recipe(&folder, "out/coat.usda --prim /Other/model")["render"]["level"], 2);
}

/// `check`, `info` and `--skip-fresh` are of one mind about an output that was built over another.
#[test]
fn an_output_over_another_is_fresh_until_one_of_them_is_stale() {
    for (fit, build) in [("--variant-set body", "--variants body"), ("", "--lods 3"), ("", "")] {
        let folder = crate::fit::with_sleeve();
        let fit = format!("fit in.usda --from a.usda --to b.usda -o out/fitted.usda {fit}");
        let build = format!("build out/fitted.usda -o out/coat.usda --force {build}");
        folder.good(&fit);
        folder.good(&build);
        folder.good("check out/coat.usda").prints(&["good, and fresh"]);
        folder.good("check out/fitted.usda").prints(&["good, and fresh"]);
        folder.good("info out/coat.usda").prints(&["; fresh"]);
        folder.good(&format!("{build} --skip-fresh")).prints(&["out/coat.usda: fresh"]);
        // The body is an input of the fit alone.
        folder.file("b.usda", folder.text("b.usda") + "\n");
        let run = folder.run("check out/coat.usda");
        assert_eq!(run.code, Some(1), "{run}");
        run.says(&["fitted.usda: stale: ../b.usda has changed", "build it again"]);
        folder.good("info out/coat.usda").prints(&["; stale, as ", "fitted.usda is: ../b.usda has changed"]);
        let run = folder.good(&format!("{build} --skip-fresh"));
        assert!(!run.stdout.contains("fresh"), "{run}");
        // The remedy helps.
        folder.good(&format!("{fit} --force"));
        folder.good(&format!("{build} --skip-fresh"));
        folder.good("check out/coat.usda").prints(&["good, and fresh"]);
        folder.good(&format!("{build} --skip-fresh")).prints(&["out/coat.usda: fresh"]);
    }
}
