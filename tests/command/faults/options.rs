//! Faults of flags.

use super::{Fault, each_is_told, fault};
use crate::cloth::CLOTH;

/// A fault of the arguments, with a sound garment.
fn of(args: &'static str, says: &'static [&'static str]) -> Fault {
    fault(args, |folder| folder.file("in.usda", CLOTH), says)
}

#[test]
fn of_the_command_line() {
    each_is_told(&[
        of("sew in.usda", &["unrecognized subcommand 'sew'"]),
        of("build in.usda", &["--output <OUT>"]),
        of("build in.usda -o", &["a value is required for '--output <OUT>'"]),
        of("build -o out/coat.usda", &["no input", "name a USD file"]),
        of("check", &["no input", "--help"]),
        of("info -q", &["no input"]),
        of("build in.usda -o out/coat.usda --fast", &["unexpected argument '--fast'"]),
        of("build in.usda -o out/coat.usda --threads 0", &["--threads 0: at least one thread is needed", "1 or more"]),
        of("build in.usda -o out/coat.usda --threads two", &["invalid value 'two' for '--threads <N>'"]),
        of("build in.usda -o out/coat.usda --max-faces -1", &["invalid value '-1' for '--max-faces <N>'"]),
        of("build in.usda -o out/coat.usda -q -v", &["--quiet", "cannot be used with", "--verbose"]),
        of("check in.usda --force", &["unexpected argument '--force'"]),
    ]);
}

#[test]
fn of_overrides() {
    each_is_told(&[
        of(
            "build in.usda -o out/coat.usda --set sim.edgeLength=2",
            &["--set sim.edgeLength", "no such option", "sim.maxEdgeLength"],
        ),
        of(
            "build in.usda -o out/coat.usda --set maxEdgeLength=2",
            &["--set maxEdgeLength", "no such option", "sim.maxEdgeLength"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.iterations",
            &["--set sim.iterations: it has no value", "--set sim.maxEdgeLength=2"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.iterations=many",
            &["\"many\" is not a whole number", "default is 5"],
        ),
        of("build in.usda -o out/coat.usda --set sim.maxEdgeLength=wide", &["\"wide\" is not a number", "0"]),
        of(
            "build in.usda -o out/coat.usda --set sim.maxEdgeLength=nan",
            &["sim.maxEdgeLength: \"nan\" is not a number"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.maxEdgeLength=1e300",
            &["sim.maxEdgeLength: inf is not a length", "positive number of mesh units"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.maxEdgeLength=-1",
            &["sim.maxEdgeLength: -1 is not a length", "positive number"],
        ),
        of("check in.usda --set sim.grading=1", &["sim.grading: 1 is out of range", "1.05 or more, or 0"]),
        of("check in.usda --set sim.grading=nan", &["sim.grading"]),
        of("check in.usda --set sim.smallestShell=-1", &["sim.smallestShell: -1 is out of range", "0 or more"]),
        of("check in.usda --set sim.cornerAngle=0", &["sim.cornerAngle: 0 is out of range", "give 1 to 180"]),
        of("check in.usda --set sim.cornerAngle=181", &["sim.cornerAngle: 181 is out of range"]),
        of("check in.usda --set sim.featureAngle=0", &["sim.featureAngle: 0 is out of range", "give 1 to 180"]),
        of("check in.usda --set sim.featureAngle=181", &["sim.featureAngle: 181 is out of range"]),
        of("check in.usda --set sim.minEdgeLength=-0.5", &["sim.minEdgeLength: -0.5 is not a length"]),
        of(
            "build in.usda -o out/coat.usda --set sim.minEdgeLength=2 --set sim.maxEdgeLength=1",
            &["sim.minEdgeLength: 2 is more than sim.maxEdgeLength, 1", "swap"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.baselineLevel=40",
            &["sim.baselineLevel: 40 is out of range", "give 0 to 6"],
        ),
        of("build in.usda -o out/coat.usda --set render.level=7", &["render.level: 7 is out of range", "give 0 to 6"]),
        of("build in.usda -o out/coat.usda --set render.level=-1", &["render.level", "\"-1\" is not a whole number"]),
        of("build in.usda -o out/coat.usda --set sim.iterations=1000", &["sim.iterations: 1000 is out of range"]),
        of("build in.usda -o out/coat.usda --set sim.constrainUvSeams=maybe", &["\"maybe\" is not true or false"]),
        of(
            "build in.usda -o out/coat.usda --set render.operators=pleat",
            &["render.operators", "which is not an operator of the recipe", "the operators of the recipe are: none"],
        ),
        of("build in.usda -o out/coat.usda --set sim.uvSet=map1", &["sim.uvSet: \"map1\" is no", "the mesh has: st"]),
        of(
            "build in.usda -o out/coat.usda --set sim.density=ply",
            &["sim.density: \"ply\" is no", "the mesh has: density, tint"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.constraints=placket,hem",
            &["sim.constraints: \"hem\" is no", "placket, waist"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.constraints=left",
            &["sim.constraints: \"left\" is a subset of faces of"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.maxEdgeLength=0.01 --max-faces 1000",
            &["sim.maxEdgeLength: the target lengths ask for about", "more than 1000", "--max-faces"],
        ),
        of(
            "build in.usda -o out/coat.usda --set seam.s.edges=placket --set seam.s.depth=-1e9",
            &["seam.s.depth: -1000000000 is more than 0.5 times the size of /Coat/model", "keep it within 1.4"],
        ),
        of(
            "check in.usda --set seam.s.edges=placket --set seam.s.normalOffset=1000",
            &["seam.s.normalOffset: 1000 is more than 0.5 times the size"],
        ),
        of(
            "check in.usda --set seam.s.edges=placket --set seam.s.width=2",
            &["seam.s.width: 2 is more than 0.5 times the size"],
        ),
        of(
            "build in.usda -o out/coat.usda --set fold.t.faces=left --set fold.t.thickness=3",
            &["fold.t.thickness: 3 is more than 0.5 times the size", "keep it within 1.4"],
        ),
        of(
            "build in.usda -o out/coat.usda --set fabric.felt.thickness=1",
            &["fabric.felt.thickness: 1 is more than 0.5 times the size", "keep it within 0.014", "metres"],
        ),
        of(
            "build in.usda -o out/coat.usda --set sim.maxEdgeLength=1e-30",
            &["the target lengths ask for about", "raise sim."],
        ),
    ]);
}
