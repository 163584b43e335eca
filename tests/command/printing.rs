//! What is printed.

use crate::cloth::cloth_and;
use crate::outputs::with_cloth;
use serde_json::Value;

#[test]
fn a_build_is_told_on_one_screen() {
    let folder = with_cloth();
    let run = folder.good("build in.usda -o out/coat.usda");
    run.prints(&[
        "in.usda -> out/coat.usda",
        "sim ",
        "triangles",
        "render ",
        "64 faces, 100.0 % quads, level 2",
        "time ",
        " ms",
    ]);
    assert!(run.stdout.lines().count() <= 24, "{run}");
    assert!(run.stdout.lines().all(|l| l.chars().count() <= 120), "{run}");
    let (hint, warnings) = run.stderr.lines().collect::<Vec<_>>().split_last().map(|(l, w)| (*l, w.to_vec())).unwrap();
    assert_eq!(hint, "hint: -v says what to do about warnings");
    assert!(warnings.iter().all(|l| l.starts_with("warning[") && l.chars().count() <= 160), "{run}");
    let more = folder.good("build in.usda -o out/coat.usda --force -v");
    let is_hint = |l: &&str| l.starts_with("  hint: ");
    assert_eq!(more.stderr.lines().filter(is_hint).count(), warnings.len(), "a remedy for each warning: {more}");
    more.prints(&["rounds ", "set     left: area", "recipe  {\"sim\":"]);
}

#[test]
fn quiet_prints_nothing() {
    let folder = with_cloth();
    folder.file("odd.usda", cloth_and("uniform token subdivisionScheme = \"none\""));
    for args in
        ["build in.usda -o out/coat.usda -q", "build odd.usda -o out/odd.usda --quiet", "check in.usda odd.usda -q"]
    {
        let run = folder.good(args);
        assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""), "{run}");
    }
    // But a fault is reported.
    folder.run("build in.usda -o out/coat.usda -q").says(&["error[output-exists]: out/coat.usda exists already"]);
}

#[test]
fn info_tells_what_there_is_and_what_would_be_done() {
    let folder = with_cloth();
    let before = folder.snapshot();
    let run =
        folder.good("info in.usda --set sim.constraints=placket --set sim.maxEdgeLength=0.5 --set render.level=2");
    run.prints(&[
        "in.usda /Coat/model",
        "Y up, 0.01 metres a unit",
        "9 points, 4 faces",
        "2 creases, 2 corners, 0 holes",
        "purpose default, visibility inherited",
        "primvar  st texCoord2f[] faceVarying, indexed",
        "primvar  ply double[] uniform",
        "primvar  skel:jointWeights float[] vertex, elementSize 2",
        "subset   left of 2 faces, family panels",
        "subset   placket of 2 edges, family seams",
        "subset   pins of 2 points",
        "triangles at length 0.5000 mesh units (5.00 mm)",
        "constraint chains",
        "render   64 faces at level 2",
    ]);
    folder.good("info in.usda -v").prints(&["schema   MaterialBindingAPI", "recipe   {\"sim\":"]);
    assert_eq!(folder.snapshot(), before, "info writes nothing");
}

#[test]
fn info_foretells_the_build() {
    let folder = with_cloth();
    let info = folder.good("info in.usda --set sim.maxEdgeLength=0.1").stdout;
    let expected: f64 = info
        .split_once("about ")
        .and_then(|(_, rest)| rest.split(' ').next()?.parse().ok())
        .unwrap_or_else(|| panic!("no number of triangles in {info}"));
    folder.good("build in.usda -o out/coat.usda --set sim.maxEdgeLength=0.1 --report out/report.json");
    let report: Value = serde_json::from_slice(&folder.read("out/report.json")).expect("JSON");
    let faces = report["sim"]["faces"].as_f64().expect("a number of faces");
    assert!((0.7..1.6).contains(&(faces / expected)), "{faces} faces, {expected} expected");
}

#[test]
fn check_says_good_or_what_is_odd() {
    let folder = with_cloth();
    let run = folder.good("check in.usda");
    assert_eq!(run.stdout, "in.usda: good\n");
    run.says(&["warning[sets-blurred]: face sets `left`, `right`"]);
    folder.file("odd.usda", cloth_and("uniform token subdivisionScheme = \"none\""));
    let run = folder.good("check odd.usda in.usda");
    assert_eq!(run.stdout, "odd.usda: good\nin.usda: good\n");
    run.says(&["warning[polygonal-cage]: odd.usda: /Coat/model: subdivisionScheme is none"]);
}

#[test]
fn the_report_has_counts_figures_times_and_warnings() {
    let folder = with_cloth();
    folder.file("odd.usda", cloth_and("uniform token subdivisionScheme = \"none\""));
    let run = folder.good("build odd.usda -o out/coat.usda --report out/report.json -v");
    let report: Value = serde_json::from_slice(&folder.read("out/report.json")).expect("JSON");
    assert_eq!(report["input"], "odd.usda");
    assert_eq!(report["output"], "out/coat.usda");
    assert_eq!(report["recipe"]["sim"]["iterations"], 5);
    assert_eq!(report["render"]["faces"], 64);
    assert_eq!(report["render"]["quads"], 1.0);
    assert!(report["cloth"]["mass"].as_f64().is_some_and(|mass| mass > 0.0), "{report:#}");
    for figure in ["vertices", "faces", "minAngle", "lengthErrorRms", "distanceMax", "chainLengthMin", "uvFlips"] {
        assert!(report["sim"][figure].is_number(), "sim.{figure} in {report:#}");
    }
    let names: Vec<&str> =
        report["stages"].as_array().expect("stages").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(
        names,
        ["read", "check", "baseline", "remesh", "places", "transfer", "render", "cloth", "binding", "write", "figures"]
    );
    let warnings = report["warnings"].as_array().expect("warnings");
    assert!(warnings.iter().any(|w| w["code"] == "polygonal-cage"), "{report:#}");
    for warning in warnings {
        let [code, severity, message, remedy] =
            ["code", "severity", "message", "remedy"].map(|key| warning[key].as_str().expect("a text"));
        let headline = message.strip_suffix(&format!(". {remedy}")).expect("the remedy is the end of the message");
        run.says(&[&format!("warning[{code}]: {headline} ({severity})\n  hint: {remedy}\n")]);
    }
    folder.good("build in.usda odd.usda -o out --report out/both.json");
    let both: Value = serde_json::from_slice(&folder.read("out/both.json")).expect("JSON");
    assert_eq!(both["builds"].as_array().map(Vec::len), Some(2));
}

#[test]
fn codes_are_explained() {
    let folder = with_cloth();
    let all = folder.good("explain");
    all.prints(&["no-mesh", "polygonal-cage", "The stage holds no mesh to build from."]);
    assert!(all.stdout.lines().all(|line| line.len() <= 120), "{all}");
    folder.good("explain output-exists").prints(&["output-exists\n", "Cause: ", "Remedy: ", "--force"]);
    let unknown = folder.run("explain output-exsits");
    assert_eq!(unknown.code, Some(2), "{unknown}");
    unknown.says(&["error[command-line]: there is no code", "did you mean output-exists?"]);
    let far = folder.run("explain foo");
    far.says(&["there is no code \"foo\"", "`usdtailor explain` lists all codes"]);
    assert!(!far.stderr.contains("did you mean"), "{far}");
}

/// A tube with its normals outward, as it is and with the winding turned.
#[test]
fn info_tells_which_way_normals_point() {
    let folder = with_cloth();
    let (mut points, mut corners) = (Vec::new(), Vec::new());
    for i in 0..8 {
        let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
        points.extend([format!("({cos:.6}, 0, {sin:.6})"), format!("({cos:.6}, 3, {sin:.6})")]);
        let next = (i + 1) % 8;
        corners.extend([2 * i, 2 * i + 1, 2 * next + 1, 2 * next].map(|v| v.to_string()));
    }
    let tube = |more: &str| {
        format!(
            "#usda 1.0\ndef Mesh \"tube\" {{\n point3f[] points = [{}]\n int[] faceVertexCounts = [{}]\n int[] faceVertexIndices = \
             [{}]\n {more}\n}}\n",
            points.join(", "),
            ["4"; 8].join(", "),
            corners.join(", ")
        )
    };
    folder.file("out.usda", tube(""));
    folder.file("in.usda", tube("uniform token orientation = \"leftHanded\""));
    folder.good("info out.usda").prints(&["  normals  point outward\n"]);
    folder.good("info in.usda").prints(&["  normals  point inward"]);
    folder.file("flat.usda", cloth_and("").replace("0.25)", "0)"));
    folder.good("info flat.usda").prints(&["  normals  point neither outward nor inward"]);
    let found: Value = serde_json::from_str(&folder.good("info in.usda --json").stdout).expect("JSON");
    assert_eq!(found["inputs"][0]["mesh"]["normals"], "inward");
}

#[test]
fn info_tells_the_plane_of_symmetry() {
    let folder = with_cloth();
    let sheet = |points: &str| {
        format!(
            "#usda 1.0\ndef Mesh \"sheet\" {{\n int[] faceVertexCounts = [4, 4, 3]\n int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4, 3, \
             4, 5]\n point3f[] points = [{points}]\n}}\n"
        )
    };
    folder.file("even.usda", sheet("(-1, 0, 0), (0, 0, 0.1), (1, 0, 0), (-1, 1, 0), (0, 1, 0.1), (1, 1, 0)"));
    folder.file("odd.usda", sheet("(-1, 0, 0), (0.5, 0, 0.1), (1, 0, 0), (-1, 1, 0), (0, 1, 0.7), (3, 1, 0)"));
    folder.good("info even.usda").prints(&["  mirror   plane x = 0.0000, 100 % of the faces have a twin\n"]);
    folder.good("info odd.usda").prints(&["  mirror   no plane of symmetry\n"]);
    let found: Value = serde_json::from_str(&folder.good("info even.usda --json").stdout).expect("JSON");
    assert_eq!(found["inputs"][0]["mesh"]["mirror"]["axis"], "x");
}

#[test]
fn help_is_grouped_and_gives_units() {
    let folder = with_cloth();
    let run = folder.good("build --help");
    run.prints(&[
        "Usage: usdtailor build",
        "Input:",
        "Recipe:",
        "Output:",
        "Run:",
        "[mesh units]",
        "[time codes]",
        "[triangles]",
        "sim.maxEdgeLength",
    ]);
    assert!(run.stderr.is_empty(), "{run}");
    folder.good("--help").prints(&["build", "info", "check", "Usage: usdtailor [OPTIONS] <COMMAND>"]);
    let bare = folder.run("");
    assert_eq!((bare.code, bare.stdout.as_str()), (Some(2), ""), "{bare}");
    bare.says(&["build", "info", "check", "Usage: usdtailor [OPTIONS] <COMMAND>"]);
    assert!(folder.good("--version").stdout.starts_with("usdtailor "));
}

/// Whoever closes the pipe has read enough.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    let folder = with_cloth();
    for args in ["info in.usda -v", "check in.usda", "build in.usda -o out/coat.usda --force", "--help", "build --help"]
    {
        // Standard output is a pipe whose reader has gone for certain.
        let script = "exec 3>&1; { sleep 0.1; \"$@\" 2>&3; echo \"code $?\" >&3; } | exec true";
        let run = folder.run_in_shell(script, args);
        assert_eq!(run.stdout.lines().last(), Some("code 0"), "{run}");
        assert!(!run.stdout.contains("error"), "{run}");
    }
    assert_eq!(folder.written(), ["coat.usda"]);
}

#[test]
fn severities_are_in_the_text_and_in_the_table() {
    let folder = with_cloth();
    folder.file("warned.usda", cloth_and("uniform float tailor:sim:stretch = 2"));
    let run = folder.good("build in.usda warned.usda -o out --set sim.maxEdgeLength=0.1");
    run.says(&["warning[not-carried]: warned.usda: tailor:sim:stretch: not carried"]);
    let line = run.stderr.lines().find(|line| line.contains("tailor:sim:stretch")).expect("a warning");
    assert!(line.ends_with(" (fault)"), "{line}");
    for flags in ["", "--skip-fresh"] {
        let run = folder.good(&format!("build in.usda warned.usda -o out --force --set sim.maxEdgeLength=0.1 {flags}"));
        let numbers = |name: &str| -> Vec<String> {
            let line = run.stdout.lines().find(|line| line.starts_with(name)).expect("a line of the table");
            line.split_whitespace().rev().take(3).map(str::to_owned).collect()
        };
        let [plain, warned] = ["in.usda", "warned.usda"].map(numbers);
        assert_eq!((&plain[2][..], &warned[2][..]), ("0", "1"), "{run}");
        assert_eq!(plain[..2], warned[..2], "{run}");
        run.prints(&["faults  quality  notes"]);
    }
}

#[test]
fn slips_are_answered_shortly() {
    let folder = with_cloth();
    folder.file("typo.tailor", "{\"sim\": {\"maxEdgeLenth\": 2}}");
    for (args, words) in [
        ("--set sim.maxEdgeLenth=2", "did you mean sim.maxEdgeLength? the options of sim are maxEdgeLength,"),
        ("--set simm.x=2", "options begin with sim, render, cloth"),
        ("--recipe typo.tailor", "unknown field `maxEdgeLenth`, did you mean `maxEdgeLength`? at line 1 column"),
        ("--set sim.maxEdgeLength=4yd", "a number with mm, cm, m, in, inch or ft"),
        ("--set sim.maxEdgeLength=-4mm", "\"-4mm\" is negative"),
    ] {
        let run = folder.run(&format!("check in.usda {args}"));
        assert!(run.code != Some(0) && run.stderr.lines().all(|line| line.len() < 500), "{run}");
        run.says(&[words]);
    }
    folder.run("check inn.usda").says(&["no such file", "did you mean in.usda?"]);
    folder.good("check in.usda --set sim.maxEdgeLength=4inch");
}

#[test]
fn threads_of_the_environment_are_capped_too() {
    let folder = with_cloth();
    for command in ["info in.usda", "build in.usda -o out/coat.usda", "check in.usda"] {
        let run = folder.command(command).env("RAYON_NUM_THREADS", "1000000000").output().expect("the command starts");
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success() && told.contains("RAYON_NUM_THREADS 1000000000"), "{command}: {told}");
    }
}
