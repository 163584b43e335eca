//! Garments on other bodies.

use crate::folder::{Folder, Run};
use std::fmt::Write;

/// A sheet of `n` by `n` quads of the size 4, in waves, with one primvar.
fn sheet(n: usize, height: f64, scale: f64, primvar: &str) -> String {
    let points = (0..(n + 1) * (n + 1)).map(|i| ((i % (n + 1)) as f64 / n as f64, (i / (n + 1)) as f64 / n as f64));
    let mut text = format!(
        "#usda 1.0\n(\n    metersPerUnit = 0.01\n    upAxis = \"Y\"\n)\ndef Xform \"A\"\n{{\ndef Mesh \"m\"\n{{\n\
         int[] faceVertexCounts = {:?}\nint[] faceVertexIndices = {:?}\npoint3f[] points = [",
        vec![4; n * n],
        corners(n)
    );
    for (x, y) in points {
        let z = height + 0.1 * (3.0 * x).sin();
        write!(text, "({:e}, {:e}, {:e}), ", 4.0 * scale * x, 4.0 * scale * y, scale * z).expect("text");
    }
    text + "]\n" + primvar + "}\n}\n"
}

fn corners(n: usize) -> Vec<usize> {
    let quad = |i: usize| i / n * (n + 1) + i % n;
    (0..n * n).flat_map(|i| [0, 1, n + 2, n + 1].map(|k| quad(i) + k)).collect()
}

/// The UVs of a sheet as a primvar of a type and an interpolation.
fn uvs(n: usize, kind: &str, interpolation: &str) -> String {
    let at = |i: usize| ((i % (n + 1)) as f64 / n as f64, (i / (n + 1)) as f64 / n as f64);
    let all: Vec<usize> = if interpolation == "faceVarying" { corners(n) } else { (0..(n + 1) * (n + 1)).collect() };
    let third = if kind.contains('3') { ", 0" } else { "" };
    let values: Vec<String> = all.into_iter().map(at).map(|(u, v)| format!("({u}, {v}{third})")).collect();
    format!("{kind}[] primvars:st = [{}] (interpolation = \"{interpolation}\")\n", values.join(", "))
}

/// The points that a fit wrote.
fn points(folder: &Folder, file: &str) -> String {
    let text = folder.text(file);
    text.lines().find(|line| line.contains("point3f[] points")).expect("the layer has points").to_owned()
}

/// Runs the command, which must refuse its input.
#[track_caller]
fn bad(folder: &Folder, args: &str) -> Run {
    let run = folder.run(args);
    assert_eq!(run.code, Some(1), "{run}");
    run
}

pub fn with_sleeve() -> Folder {
    let folder = Folder::new();
    folder.file("in.usda", sheet(4, 0.3, 1.0, ""));
    folder.file("a.usda", sheet(6, 0.0, 1.0, &uvs(6, "texCoord2f", "faceVarying")));
    folder.file("b.usda", sheet(9, 0.0, 1.5, &uvs(9, "texCoord2f", "faceVarying")));
    folder
}

#[test]
fn bodies_correspond_by_uvs_of_corners_or_of_points() {
    let folder = with_sleeve();
    folder.good("fit in.usda --from a.usda --to b.usda -o out/corners.usda");
    let expected = points(&folder, "out/corners.usda");
    for interpolation in ["vertex", "varying"] {
        for kind in ["texCoord2f", "texCoord2h"] {
            folder.file("a.usda", sheet(6, 0.0, 1.0, &uvs(6, kind, interpolation)));
            folder.good("fit in.usda --from a.usda --to b.usda -o out/points.usda --force");
            if kind == "texCoord2f" {
                assert_eq!(points(&folder, "out/points.usda"), expected, "{interpolation}");
            }
            let recipe = "--set fit.from=a.usda --set fit.to=b.usda";
            folder.good(&format!("build in.usda -o out/built.usda --force {recipe}"));
            folder.good(&format!("check in.usda {recipe}"));
        }
    }
}

#[test]
fn a_body_is_checked_as_a_garment_is() {
    let folder = with_sleeve();
    for (body, words) in [
        (sheet(9, 0.0, 0.0, ""), "all points are in one place"),
        (sheet(9, 0.0, 1e20, ""), "too far from 1"),
        (sheet(9, 0.0, 1e-20, ""), "too far from 1"),
        (sheet(9, 0.0, 1.5, &uvs(9, "texCoord3f", "vertex")), "no UV set in common"),
        (sheet(9, 0.0, 1.5, &uvs(9, "texCoord2f", "uniform")), "primvars:st"),
    ] {
        folder.file("b.usda", body);
        let run = bad(&folder, "fit in.usda --from a.usda --to b.usda -o out/fitted.usda");
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        let run = bad(&folder, "build in.usda -o out/built.usda --set fit.from=a.usda --set fit.to=b.usda");
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        assert!(folder.written().is_empty());
    }
}

#[test]
fn a_fit_keeps_its_limit_of_memory() {
    let folder = with_sleeve();
    let run = bad(&folder, "fit in.usda --from a.usda --to b.usda -o out/fitted.usda --max-memory 100k");
    assert!(run.stderr.contains("too-large") && run.stderr.contains("--max-memory"), "{}", run.stderr);
    // Each of several is refused by itself.
    let run = bad(&folder, "fit in.usda --from a.usda --to a.usda b.usda -o out --max-memory 100k");
    assert_eq!(run.stderr.matches("too-large").count(), 2, "{}", run.stderr);
    assert!(folder.written().is_empty());
    folder.good("fit in.usda --from a.usda --to b.usda -o out/fitted.usda --max-memory 1G");
}
