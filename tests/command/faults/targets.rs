//! Faults of the files that are to be written.

use super::{Fault, each_is_told, fault};
use crate::cloth::{CLOTH, cloth_and, cloth_with};
use crate::folder::Folder;

fn cloth(folder: &Folder) {
    folder.file("in.usda", CLOTH);
}

/// A fault of the arguments, with a sound garment.
fn of(args: &'static str, says: &'static [&'static str]) -> Fault {
    fault(args, cloth, says)
}

#[test]
fn of_the_output() {
    let there = |f: &Folder| {
        cloth(f);
        f.file("out/coat.usda", "precious");
        f.file("out/note.txt", "precious");
    };
    each_is_told(&[
        of("build in.usda -o out/coat.obj", &["out/coat.obj does not end in .usd, .usda, .usdc or .usdz", "hint: "]),
        of("build in.usda -o out/coat", &["out/coat does not end in"]),
        of("build in.usda -o gone/coat.usda", &["cannot write gone/coat.usda", "no folder", "create the folder first"]),
        fault("build in.usda -o out/coat.usda", there, &["out/coat.usda exists already", "--force"]),
        fault("build in.usda -o out/note.txt/coat.usda", there, &["cannot write out/note.txt/coat.usda", "no folder"]),
        of("build in.usda -o in.usda", &["in.usda is the input", "write to another file"]),
        of("build in.usda -o in.usda --force", &["in.usda is the input", "never changed"]),
        of("build in.usda -o out/../in.usda --force --flatten", &["is the input"]),
        of("build in.usda -o out/coat.usda --sim-name model", &["/Coat/model is taken by another prim", "--sim-name"]),
        of(
            "build in.usda -o out/coat.usda --sim-name both --render-name both",
            &["/Coat/both is taken", "--render-name"],
        ),
        of("build in.usda -o out/coat.usda --sim-name 1st", &["--sim-name \"1st\"", "no digit first"]),
        of("build in.usda -o out/coat.usda --sim-name a/b", &["--sim-name \"a/b\"", "letters, digits and _"]),
        of(
            "build in.usda -o out/coat.usda --render-name LOD1/b",
            &["--render-name \"LOD1/b\"", "letters, digits and _"],
        ),
        of("build in.usda -o out/a:SDF_FORMAT_ARGS:x=y.usdc", &["has `:SDF_FORMAT_ARGS:`", "name it otherwise"]),
        #[cfg(unix)]
        of("build in.usda -o out/a\\b.usdc", &["out/a\\b.usdc has a backslash in its path", "name it otherwise"]),
        fault(
            "build in.usda -o out/coat.usda",
            |f| {
                f.file(
                    "in.usda",
                    cloth_with("    def Mesh \"model\"", "    def Scope \"sim\" {}\n    def Mesh \"model\""),
                );
            },
            &["/Coat/sim is taken by another prim", "--sim-name"],
        ),
    ]);
}

#[test]
fn of_an_output_that_the_input_uses() {
    let layered = |f: &Folder| {
        cloth(f);
        f.file("top.usda", "#usda 1.0\n(\n subLayers = [@in.usda@]\n)\n");
    };
    each_is_told(&[
        fault("build top.usda -o in.usda --force", layered, &["in.usda is the input, or a file that the input uses"]),
        fault("build top.usda -o top.usda --force", layered, &["top.usda is the input"]),
    ]);
}

#[cfg(unix)]
#[test]
fn of_links_to_the_input() {
    let soft = |f: &Folder| {
        cloth(f);
        std::os::unix::fs::symlink("../in.usda", f.at("out/soft.usda")).expect("a link");
    };
    let hard = |f: &Folder| {
        cloth(f);
        std::fs::hard_link(f.at("in.usda"), f.at("out/hard.usda")).expect("a link");
    };
    let folder = |f: &Folder| {
        cloth(f);
        std::os::unix::fs::symlink("..", f.at("out/up")).expect("a link");
    };
    each_is_told(&[
        fault("build in.usda -o out/soft.usda", soft, &["out/soft.usda is the input"]),
        fault("build in.usda -o out/soft.usda --force", soft, &["out/soft.usda is the input"]),
        fault("build in.usda -o out/hard.usda --force", hard, &["out/hard.usda is the input"]),
        fault("build out/soft.usda -o in.usda --force", soft, &["in.usda is the input"]),
        fault("build in.usda -o out/up/in.usda --force", folder, &["out/up/in.usda is the input"]),
    ]);
}

#[test]
fn of_the_report() {
    let there = |f: &Folder| {
        cloth(f);
        f.file("out/report.json", "precious");
        f.file("my.tailor", "{}");
    };
    each_is_told(&[
        of(
            "build in.usda -o out/coat.usda --report in.usda --force",
            &["report in.usda does not end in .json", "report.json"],
        ),
        of("build in.usda -o out/coat.usda --report out/coat.usda", &["report out/coat.usda does not end in .json"]),
        of(
            "build in.usda -o out/coat.usda --report gone/report.json",
            &["cannot write report gone/report.json", "no folder", "create the folder"],
        ),
        of("build in.usda -o out/coat.usda --report out", &["cannot write report out", "is a folder"]),
        fault(
            "build in.usda -o out/coat.usda --report out/report.json",
            there,
            &["report out/report.json exists already", "--force"],
        ),
        fault(
            "build in.usda -o out/coat.usda --recipe my.tailor --report my.tailor --force",
            there,
            &["report my.tailor does not end in .json"],
        ),
    ]);
}

#[test]
fn of_several_inputs() {
    let both = |f: &Folder| {
        f.file("a.usda", CLOTH);
        f.file("b.usda", CLOTH);
        std::fs::create_dir(f.at("more")).expect("a folder");
        f.file("more/a.usda", CLOTH);
    };
    each_is_told(&[
        fault(
            "build a.usda b.usda -o out/coat.usda",
            both,
            &["-o out/coat.usda: 2 inputs need a folder", "name a folder"],
        ),
        fault("build a.usda more/a.usda -o out", both, &["two inputs are named a", "separate folders"]),
    ]);
}

/// A full disk, as a limit on the size of files: the write fails in its middle.
#[cfg(unix)]
#[test]
fn of_a_full_disk() {
    let folder = Folder::new();
    cloth(&folder);
    let before = folder.snapshot();
    for (output, trap) in [("out/coat.usda", "trap '' XFSZ; "), ("out/coat.usdc", ""), ("out/coat.usdz", "")] {
        // The signal of a limit ends nothing before the command has said a word.
        let run = folder.run_in_shell(
            &format!("{trap}ulimit -f 1; exec \"$@\""),
            &format!("build in.usda -o {output} --flatten --set render.level=3"),
        );
        super::check(&run, &[&format!("cannot write {output}"), "space on its disk"]);
        assert_eq!(folder.snapshot(), before, "something was written by {run}");
    }
}

#[cfg(unix)]
#[test]
fn of_a_folder_that_may_not_be_written_to() {
    use std::io::Write;
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    cloth(&folder);
    let locked =
        |mode| std::fs::set_permissions(folder.at("out"), std::fs::Permissions::from_mode(mode)).expect("own folder");
    locked(0o555);
    if std::fs::write(folder.at("out/probe"), "").is_ok() {
        // Past the capture of the test harness, so that it is seen.
        let _ = writeln!(std::io::stderr(), "SKIPPED: this user (root?) may write to any folder, none can be closed");
        return;
    }
    let run = folder.run("build in.usda -o out/coat.usda");
    locked(0o755);
    super::check(&run, &["cannot write out/coat.usda: permission denied", "permissions"]);
    assert!(folder.written().is_empty(), "{run}");
}

/// One garment that fails does not keep the others from being built, and is named.
#[test]
fn of_one_input_among_several() {
    let folder = Folder::new();
    folder.file("a.usda", CLOTH);
    folder.file("b.usda", cloth_and("int[] holeIndices = [4]"));
    folder.file("c.usda", CLOTH);
    let run = folder.run("build a.usda b.usda c.usda -o out --report out/report.json");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["error[index-out-of-range]: b.usda: /Coat/model.holeIndices", "hint: "]);
    run.prints(&["a.usda  built", "b.usda  failed", "c.usda  built", "3 inputs: 2 built, 0 fresh, 1 failed"]);
    assert_eq!(folder.written(), ["a_tailored.usdc", "c_tailored.usdc", "report.json"]);
    let run = folder.run("check a.usda b.usda c.usda");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["error[index-out-of-range]: b.usda: /Coat/model.holeIndices"]);
    run.prints(&["a.usda: good", "c.usda: good"]);
}
