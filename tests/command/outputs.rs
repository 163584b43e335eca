//! What a build writes.

use crate::cloth::{CLOTH, cloth_and};
use crate::folder::Folder;
use tailor_usd::{ReadOptions, Source};

/// A folder with the cloth in it.
pub fn with_cloth() -> Folder {
    let folder = Folder::new();
    folder.file("in.usda", CLOTH);
    folder
}

/// Opens one mesh of a written file, as the library reads it.
#[track_caller]
fn mesh(folder: &Folder, file: &str, prim: &str) -> Source {
    let options = ReadOptions { prim: Some(prim.into()), ..ReadOptions::default() };
    Source::open(&folder.at(file), &options).unwrap_or_else(|e| panic!("{file} {prim}: {e}"))
}

#[test]
fn every_format_holds_the_model_and_both_meshes() {
    for (name, magic) in
        [("coat.usda", "#usda 1.0"), ("coat.usdc", "PXR-USDC"), ("coat.usd", "PXR-USDC"), ("coat.usdz", "PK")]
    {
        for flag in ["", "--flatten"] {
            let folder = with_cloth();
            let out = format!("out/{name}");
            folder.good(&format!("build in.usda -o {out} {flag}"));
            assert_eq!(folder.written(), [name]);
            assert!(folder.read(&out).starts_with(magic.as_bytes()), "{name} is in its own format");
            for prim in ["/Coat/model", "/Coat/sim", "/Coat/render"] {
                mesh(&folder, &out, prim);
            }
            assert_eq!(folder.text("in.usda"), CLOTH, "the input is as it was");
        }
    }
}

#[test]
fn a_layer_needs_its_input_and_a_flat_file_does_not() {
    let folder = with_cloth();
    folder.good("build in.usda -o out/layer.usda");
    folder.good("build in.usda -o out/flat.usda --flatten");
    folder.good("build in.usda -o out/flat.usdz");
    assert!(folder.text("out/layer.usda").contains("@../in.usda@"), "a layer names its input by a relative path");
    assert!(
        !folder.text("out/layer.usda").contains("primvars:ply = [1, 2, 3, 4]"),
        "a layer copies nothing of the model"
    );
    std::fs::remove_file(folder.at("in.usda")).expect("the input is there");
    mesh(&folder, "out/flat.usda", "/Coat/model");
    mesh(&folder, "out/flat.usdz", "/Coat/model");
    assert!(Source::open(&folder.at("out/layer.usda"), &ReadOptions::default()).is_err());
}

#[test]
fn several_inputs_go_into_a_folder() {
    let folder = with_cloth();
    folder.file("b.usda", CLOTH);
    let run = folder.good("build in.usda b.usda -o out");
    assert_eq!(folder.written(), ["b_tailored.usdc", "in_tailored.usdc"]);
    run.prints(&["in.usda  built", "b.usda   built", "2 inputs: 2 built, 0 fresh, 0 failed"]);
    folder.good("build in.usda -o out --force");
    assert_eq!(folder.written().len(), 2, "one input goes into a folder too");
}

#[test]
fn a_folder_of_outputs_is_made() {
    let folder = with_cloth();
    folder.file("b.usda", CLOTH);
    folder.good("build in.usda b.usda -o out/new/er --report out/new/er/report.json");
    assert!(folder.at("out/new/er/in_tailored.usdc").is_file() && folder.at("out/new/er/report.json").is_file());
    folder.good("build in.usda -o out/one/");
    assert!(folder.at("out/one/in_tailored.usdc").is_file(), "a path that ends as a folder is one");
}

#[test]
fn a_run_that_writes_nothing_leaves_no_folder() {
    let folder = with_cloth();
    folder.file("bad.usda", "#usda 1.0\n");
    folder.file("worse.usda", "#usda 1.0\n");
    let before = folder.snapshot();
    for args in [
        "build bad.usda worse.usda -o out/new/er",
        "build in.usda bad.usda -o out/new/er --dry-run",
        "build in.usda bad.usda -o out/new/er --report in.usda",
        "build bad.usda -o new/",
    ] {
        let run = folder.run(args);
        assert_eq!(run.code, Some(1), "{run}");
        assert_eq!(folder.snapshot(), before, "something was written by {run}");
    }
}

/// A dry run refuses and tells what the build would.
#[test]
fn a_dry_run_says_what_the_build_would_say() {
    let folder = with_cloth();
    folder.file("there.usda", "precious");
    folder.file("my.tailor", "{}");
    folder.file("taken.usda", CLOTH.replacen("    def Mesh", "    def Scope \"sim\" {}\n    def Mesh", 1));
    let before = folder.snapshot();
    let narrow = "--set seam.s.edges=placket --set seam.s.width=1.35 --set seam.s.asymmetry=0.5";
    for args in [
        "in.usda -o there.usda".to_owned(),
        "in.usda -o in.usda --force".to_owned(),
        "in.usda -o gone/coat.usda".to_owned(),
        "in.usda -o out/coat.obj".to_owned(),
        "in.usda -o out/coat.usda --sim-name 1st".to_owned(),
        "in.usda -o out/coat.usda --sim-name model".to_owned(),
        "in.usda -o out/coat.usda --sim-name both --render-name both".to_owned(),
        "in.usda --recipe my.tailor -o my.tailor --force".to_owned(),
        "taken.usda -o out/coat.usda".to_owned(),
        "in.usda -o out/coat.usda --set seam.s.edges=hem".to_owned(),
        "in.usda -o out/coat.usda --set sim.maxEdgeLength=0.01 --max-faces 1000".to_owned(),
        format!("in.usda -o out/coat.usda {narrow}"),
        format!("in.usda -o out/coat.usdz {narrow}"),
    ] {
        let dry = folder.run(&format!("build {args} --dry-run"));
        assert_eq!(folder.snapshot(), before, "something was written by {dry}");
        let run = folder.run(&format!("build {args}"));
        assert_eq!((dry.code, &dry.stderr), (run.code, &run.stderr), "{dry}\n{run}");
        if run.code == Some(0) {
            dry.says(&["warning[narrow-seam]"]);
            dry.prints(&["would write", "triangles to sim", "faces to render"]);
            std::fs::remove_dir_all(folder.at("out"))
                .and_then(|()| std::fs::create_dir(folder.at("out")))
                .expect("a folder");
        }
    }
}

#[test]
fn a_prim_above_the_only_mesh_names_it() {
    let folder = Folder::new();
    let (other, cloth) = ("def Xform \"Other\" (references = </Coat>) {}", "def Xform \"Coat\"");
    folder.file("in.usda", CLOTH.replacen(cloth, &format!("{other}\n\n{cloth}"), 1));
    folder.good("build in.usda -o out/coat.usda --prim /Coat");
    mesh(&folder, "out/coat.usda", "/Coat/sim");
    folder.good("info in.usda --prim /Other").prints(&["/Other/model"]);
    assert_eq!(mesh(&folder, "in.usda", "/Other").prim(), "/Other/model");
    // Products beside it are not garments.
    assert_eq!(mesh(&folder, "out/coat.usda", "/Coat").prim(), "/Coat/model");
    folder.file("my.tailor", "{\"source\": \"in.usda\", \"prim\": \"/Coat\"}");
    folder.good("check my.tailor");
}

#[test]
fn an_output_is_replaced_by_force_only() {
    let folder = with_cloth();
    folder.good("build in.usda -o out/coat.usda");
    let first = folder.read("out/coat.usda");
    assert_eq!(folder.run("build in.usda -o out/coat.usda --set render.level=2").code, Some(1));
    assert_eq!(folder.read("out/coat.usda"), first);
    folder.good("build in.usda -o out/coat.usda --set render.level=2 --force");
    assert_ne!(folder.read("out/coat.usda"), first);
    assert_eq!(folder.written(), ["coat.usda"]);
}

#[test]
fn meshes_are_called_as_asked() {
    let folder = with_cloth();
    folder.good("build in.usda -o out/coat.usda --sim-name cloth --render-name skin --keep-model-purpose");
    mesh(&folder, "out/coat.usda", "/Coat/cloth");
    mesh(&folder, "out/coat.usda", "/Coat/skin");
    let purpose = |prim| mesh(&folder, "out/coat.usda", prim).facts().purpose.clone();
    assert_eq!(["/Coat/model", "/Coat/cloth", "/Coat/skin"].map(purpose), ["default", "guide", "default"]);
    folder.good("build in.usda -o out/other.usda");
    assert_eq!(mesh(&folder, "out/other.usda", "/Coat/model").facts().purpose, "guide");
}

#[test]
fn a_build_can_be_built_again() {
    let folder = with_cloth();
    folder.good("build in.usda -o out/first.usda");
    folder.good("build out/first.usda -o out/second.usda");
    mesh(&folder, "out/second.usda", "/Coat/render");
}

#[test]
fn a_time_chooses_the_points() {
    let (before, rest) = CLOTH.split_once("point3f[] points = [").expect("the cloth has points");
    let (points, after) = rest.split_once("]\n").expect("the points end");
    let wider = points.replace("(2, ", "(5, ");
    let folder = Folder::new();
    folder
        .file("in.usda", format!("{before}point3f[] points.timeSamples = {{ 1: [{points}], 2: [{wider}] }}\n{after}"));
    let wide = |time: &str| {
        let run = folder.good(&format!("info in.usda --time {time}"));
        run.stdout.lines().find(|l| l.contains("mean edge")).map(str::to_owned)
    };
    assert_ne!(wide("1"), wide("2"));
    assert_eq!(wide("2"), wide("7"), "the last sample holds on");
}

#[test]
fn a_strict_build_writes_nothing_where_there_is_more_than_a_note() {
    let folder = with_cloth();
    folder.file("warned.usda", cloth_and("uniform float tailor:sim:stretch = 2"));
    for command in ["build warned.usda --strict -o out/coat.usda", "check warned.usda --strict"] {
        let run = folder.run(command);
        run.says(&["error[strict-warning]: tailor:sim:stretch: not-carried: not carried"]);
        assert_eq!(run.code, Some(1), "{command}");
        assert!(!run.stdout.contains("good"), "{run}");
    }
    assert!(folder.written().is_empty());
    folder.good("build in.usda --strict -o out/coat.usda --set sim.maxEdgeLength=0.1");
    folder.good("check out/coat.usda --strict").prints(&["good, and fresh"]);
    folder.good("build warned.usda -o out/warned.usda").says(&["warning[not-carried]"]);
}

/// An output and its report come together, or not at all.
#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_written_leaves_no_output() {
    let folder = crate::fit::with_sleeve();
    for command in ["build in.usda", "fit in.usda --from a.usda --to b.usda"] {
        let run = folder.run(&format!("{command} -o out/coat.usda --report /dev/full"));
        assert_eq!(run.code, Some(1), "{run}");
        run.says(&["error[write-failed]: cannot write report /dev/full: the disk is full"]);
        let run =
            folder.run_in_shell("\"$@\" > /dev/full", &format!("{command} -o out/coat.usda --report - --force -q"));
        assert_eq!(run.code, Some(1), "{run}");
        run.says(&["cannot write report standard output: the disk is full"]);
        assert!(folder.written().is_empty(), "{:?}", folder.written());
        folder.good(&format!("{command} -o out/coat.usda --report out/coat.json"));
        assert_eq!(folder.written(), ["coat.json", "coat.usda"]);
        let before = folder.snapshot();
        folder.run(&format!("{command} -o out/coat.usda --report /dev/full --force"));
        assert_eq!(folder.snapshot(), before, "an earlier output stays");
        for file in ["out/coat.json", "out/coat.usda"] {
            std::fs::remove_file(folder.at(file)).expect("a file");
        }
    }
}

#[test]
fn warnings_are_refused_by_their_code_too() {
    let folder = with_cloth();
    folder.file("warned.usda", cloth_and("uniform float tailor:sim:stretch = 2"));
    let code = |args: &str| folder.run(&format!("build warned.usda -o out/coat.usda --force {args}")).code;
    let notes = "--set sim.maxEdgeLength=0.1";
    assert_eq!(code(notes), Some(0));
    for (args, expected) in [
        ("--strict", Some(1)),
        ("--strict --allow not-carried", Some(0)),
        ("--deny not-carried", Some(1)),
        ("--deny narrow-seam", Some(0)),
        ("--deny not-carried --allow not-carried", Some(1)),
    ] {
        assert_eq!(code(&format!("{notes} {args}")), expected, "{args}");
    }
    let run = folder.run("check warned.usda --deny not-caried");
    assert_eq!(run.code, Some(2), "{run}");
    run.says(&["--deny not-caried: no warning has this code", "did you mean not-carried?"]);
}
