//! Faults of the mesh itself: each is reported with prim, attribute, element and remedy.

use super::{Fault, check, fault};
use crate::cloth::{cloth_and, cloth_with};
use crate::folder::Folder;

const ARGS: &str = "build in.usda -o out/coat.usda";

/// The cloth with `old` replaced.
fn broken(old: &'static str, new: &'static str, says: &'static [&'static str]) -> Fault {
    fault(ARGS, move |folder| folder.file("in.usda", cloth_with(old, new)), says)
}

/// The cloth with statements added.
fn with(statements: &'static str, says: &'static [&'static str]) -> Fault {
    fault(ARGS, move |folder| folder.file("in.usda", cloth_and(statements)), says)
}

/// Checks each fault by all three subcommands, which tell the same.
fn each_is_told(faults: &[Fault]) {
    super::each_is_told(faults);
    for fault in faults {
        let folder = Folder::new();
        (fault.make)(&folder);
        let told = folder.run(ARGS).stderr;
        for args in ["check in.usda", "info in.usda"] {
            let run = folder.run(args);
            check(&run, fault.says);
            assert_eq!(run.stderr, told, "check, info and build tell the same");
        }
    }
}

#[test]
fn of_a_lone_mesh_among_all() {
    let broken = |folder: &Folder| {
        folder.file("in.usda", cloth_with("faceVertexIndices = [0, 1, 4", "faceVertexIndices = [0, 1, -1"));
    };
    let says = &["/Coat/model.faceVertexIndices", "corner 2 of face 0 names point -1"];
    super::each_is_told(&[fault("build in.usda -o out/coat.usda --all", broken, says)]);
}

#[test]
fn of_points_and_faces() {
    const POINTS: &str = "/Coat/model.points";
    const COUNTS: &str = "/Coat/model.faceVertexCounts";
    const INDICES: &str = "/Coat/model.faceVertexIndices";
    const FACES: &str = "int[] faceVertexCounts = [4, 4, 4, 4]";
    const ALL: &str =
        "(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0.25), (2, 1, 0), (0, 2, 0), (1, 2, 0), (2, 2, 0)";
    each_is_told(&[
        broken("(1, 1, 0.25)", "(1, nan, 0)", &[POINTS, "point 4 is (1, NaN, 0)", "finite position"]),
        broken("(1, 1, 0.25)", "(1, 1, -inf)", &[POINTS, "point 4 is (1, 1, -inf)", "finite position"]),
        broken(ALL, "", &[POINTS, "the mesh has no points", "--prim"]),
        broken(FACES, "int[] faceVertexCounts = []", &[COUNTS, "the mesh has no faces", "author the faces"]),
        broken(FACES, "int[] faceVertexCounts = [4, 2, 6, 4]", &[COUNTS, "face 1 has a count of 2", "remove the face"]),
        broken(
            FACES,
            "int[] faceVertexCounts = [4, 4, -4, 4]",
            &[COUNTS, "face 2 has a count of -4", "remove the face"],
        ),
        broken(
            FACES,
            "int[] faceVertexCounts = [4, 4, 4, 5]",
            &[INDICES, "holds 16 indices", "up to 17", "add the missing"],
        ),
        broken(
            FACES,
            "int[] faceVertexCounts = [4, 4, 4]",
            &[INDICES, "holds 16 indices", "up to 12", "remove the surplus"],
        ),
        broken(
            "faceVertexIndices = [0, 1,",
            "faceVertexIndices = [0, 9,",
            &[INDICES, "corner 1 of face 0 names point 9", "9 points", "from 0 to 8"],
        ),
        broken(
            "faceVertexIndices = [0, 1,",
            "faceVertexIndices = [-1, 1,",
            &[INDICES, "corner 0 of face 0 names point -1", "from 0 to 8"],
        ),
        with("int[] holeIndices = [4]", &["/Coat/model.holeIndices", "entry 0 names face 4", "from 0 to 3"]),
        with(
            "uniform token subdivisionScheme = \"loop\"",
            &["/Coat/model.subdivisionScheme", "face 0 has 4 corners", "triangulate"],
        ),
        with(
            "uniform token subdivisionScheme = \"catmull\"",
            &["/Coat/model.subdivisionScheme", "\"catmull\"", "use one of: catmullClark"],
        ),
        with("uniform token orientation = \"up\"", &["/Coat/model.orientation", "\"up\"", "rightHanded"]),
        broken(
            "int[] faceVertexCounts",
            "float[] faceVertexCounts",
            &[COUNTS, "is not of type int[]", "declare it as int[]"],
        ),
        broken(
            "int[] faceVertexCounts",
            "int[] counts",
            &["/Coat/model has no faceVertexCounts", "a mesh needs points"],
        ),
    ]);
}

#[test]
fn of_creases_and_corners() {
    const INDICES: &str = "/Coat/model.creaseIndices";
    const LENGTHS: &str = "/Coat/model.creaseLengths";
    const SHARP: &str = "/Coat/model.creaseSharpnesses";
    const CORNERS: &str = "/Coat/model.cornerIndices";
    each_is_told(&[
        broken(
            "creaseLengths = [3, 2]",
            "creaseLengths = [4, 1]",
            &[LENGTHS, "crease 1 has a length of 1", "remove the crease"],
        ),
        broken(
            "creaseLengths = [3, 2]",
            "creaseLengths = [3, 3]",
            &[INDICES, "holds 5 indices", "up to 6", "correct creaseLengths"],
        ),
        broken(
            "creaseIndices = [1, 4, 7",
            "creaseIndices = [1, 4, 90",
            &[INDICES, "entry 2 names point 90", "from 0 to 8"],
        ),
        broken(
            "creaseIndices = [1, 4, 7",
            "creaseIndices = [1, 4, 8",
            &[INDICES, "step 1 of crease 0, point 4 to 8, is not an edge", "end it at point 4"],
        ),
        broken(
            "creaseSharpnesses = [2, 3, 4]",
            "creaseSharpnesses = [2, 3, 4, 5]",
            &[SHARP, "holds 4 numbers", "one for each edge (3)"],
        ),
        broken(
            "creaseSharpnesses = [2, 3, 4]",
            "creaseSharpnesses = [2, -1, 4]",
            &[SHARP, "entry 1 is -1", "use 0 for smooth"],
        ),
        broken("cornerIndices = [8, 0]", "cornerIndices = [8, 9]", &[CORNERS, "entry 1 names point 9", "from 0 to 8"]),
        broken("cornerIndices = [8, 0]", "cornerIndices = [8, 8]", &[CORNERS, "names point 8 again", "keep one"]),
        broken(
            "cornerSharpnesses = [10, 4]",
            "cornerSharpnesses = [10]",
            &["/Coat/model.cornerSharpnesses", "holds 1 number", "each corner (2)"],
        ),
        broken(
            "cornerSharpnesses = [10, 4]",
            "cornerSharpnesses = [10, nan]",
            &["/Coat/model.cornerSharpnesses", "entry 1 is NaN", "use 0"],
        ),
    ]);
}

#[test]
fn of_primvars() {
    const ST: &str = "/Coat/model.primvars:st";
    const ST_INDICES: &str = "/Coat/model.primvars:st:indices";
    const WEIGHTS: &str = "/Coat/model.primvars:skel:jointWeights";
    each_is_told(&[
        broken("primvars:st = [(0, 0)", "primvars:st = [(nan, 0)", &[ST, "value 0 holds NaN", "finite number"]),
        broken(
            "primvars:st = [(0, 0), (1, 0)",
            "primvars:st = [(0, 0), (inf, 0)",
            &[ST, "value 1 holds inf", "finite number"],
        ),
        broken(
            "st:indices = [0, 1, 4",
            "st:indices = [0, 1, 9",
            &[ST_INDICES, "corner 2 of face 0 names value 9", "from 0 to 8"],
        ),
        broken(
            "st:indices = [0, 1, 4",
            "st:indices = [0, 4",
            &[ST_INDICES, "holds 15 indices, but faceVarying", "give 16"],
        ),
        broken(
            "jointWeights = [0.25, 0.75, 0.25,",
            "jointWeights = [0.25, 0.75,",
            &[WEIGHTS, "holds 17 values, no multiple of elementSize 2", "correct elementSize"],
        ),
        broken(
            "jointWeights = [0.25, 0.75, 0.25, 0.75,",
            "jointWeights = [0.25, 0.75,",
            &[WEIGHTS, "holds 16 values", "needs 18: 2 for each of 9 points", "give 18"],
        ),
        broken(
            "(1, 2), (2, 2)] (\n            interpolation = \"faceVarying\"",
            "(1, 2), (2, 2)] (\n            interpolation = \"everywhere\"",
            &[ST, "\"everywhere\"", "faceVarying"],
        ),
    ]);
}

#[test]
fn of_primvars_that_no_step_needs() {
    const TINT: &str = "/Coat/model.primvars:tint";
    const DENSITY: [&str; 3] =
        ["/Coat/model.primvars:density", "holds 8 values, but vertex interpolation needs 9", "ive 9"];
    let rows: [(&str, &str, &[&str]); 5] = [
        ("density = [0, 0, 0,", "density = [0, 0,", &DENSITY),
        ("tint = [0, 1, 2,", "tint = [1, 2,", &[TINT, "holds 8 values, but varying", "9 points", "ive 9"]),
        ("tint = [0, 1, 2,", "tint = [0, nan, 2,", &[TINT, "point 1 holds NaN", "finite number"]),
        (
            "ply = [1, 2, 3, 4]",
            "ply = [1, 2, 3]",
            &["/Coat/model.primvars:ply", "holds 3 values, but uniform", "4 faces", "ive 4"],
        ),
        (
            "gloss = [0, 1,",
            "gloss = [1,",
            &["/Coat/model.primvars:gloss", "holds 15 values, but faceVarying", "16 corners", "ive 16"],
        ),
    ];
    for (old, new, says) in rows {
        let folder = Folder::new();
        folder.file("in.usda", cloth_with(old, new));
        let run = folder.good(&format!("{ARGS} -v"));
        run.says(&["warning[not-carried]"]);
        run.says(says);
    }
    super::each_is_told(&[fault(
        "build in.usda -o out/coat.usda --set sim.density=density",
        |folder| folder.file("in.usda", cloth_with("density = [0, 0, 0,", "density = [0, 0,")),
        &["sim.density", DENSITY[1]],
    )]);
}

#[test]
fn of_subsets() {
    const PLACKET: &str = "/Coat/model/placket.indices";
    const LEFT: &str = "/Coat/model/left.indices";
    each_is_told(&[
        broken("indices = [0, 2]", "indices = [0, 4]", &[LEFT, "entry 1 names face 4", "from 0 to 3"]),
        broken("indices = [0, 2]", "indices = [0, 2, 0]", &[LEFT, "entry 2 names face 0 again", "remove one"]),
        broken("indices = [0, 2]", "indices = [0, -2]", &[LEFT, "entry 1 names face -2", "from 0 to 3"]),
        broken(
            "indices = [8, 2]",
            "indices = [8, 12]",
            &["/Coat/model/pins.indices", "entry 1 names point 12", "from 0 to 8"],
        ),
        broken(
            "indices = [7, 4, 1, 4]",
            "indices = [7, 4, 1]",
            &[PLACKET, "holds 3 indices, which do not pair up", "two end points"],
        ),
        broken(
            "indices = [7, 4, 1, 4]",
            "indices = [7, 4, 7, 5]",
            &[PLACKET, "pair 1, points 7 and 5, is not an edge", "remove the pair"],
        ),
        broken(
            "indices = [7, 4, 1, 4]",
            "indices = [7, 4, 4, 4]",
            &[PLACKET, "pair 1 joins point 4 to itself", "remove the pair"],
        ),
        broken(
            "indices = [7, 4, 1, 4]",
            "indices = [7, 4, 4, 7]",
            &[PLACKET, "is the edge of pair 0 again", "remove one"],
        ),
        broken("indices = [7, 4, 1, 4]", "indices = [7, 4, 1, 70]", &[PLACKET, "pair 1 names point 70", "from 0 to 8"]),
        broken(
            "elementType = \"point\"",
            "elementType = \"point\"\n uniform token familyName = \"panels\"",
            &["/Coat/model/pins.elementType", "is point, but subset left", "familyName of its own"],
        ),
        broken(
            "familyType = \"partition\"",
            "familyType = \"partial\"",
            &["/Coat/model.subsetFamily:panels:familyType", "\"partial\"", "partition"],
        ),
    ]);
}

#[test]
fn of_a_mesh_without_a_surface() {
    const POINTS: &str = "/Coat/model.points";
    const ALL: &str =
        "(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0.25), (2, 1, 0), (0, 2, 0), (1, 2, 0), (2, 2, 0)";
    let scaled = |text: fn(i32) -> String, says| {
        let points: Vec<String> = (0..9).map(text).collect();
        fault(ARGS, move |folder| folder.file("in.usda", cloth_with(ALL, &points.join(", "))), says)
    };
    each_is_told(&[
        scaled(|_| "(3, 4, 5)".into(), &[POINTS, "all points are in one place", "positions"]),
        scaled(|i| format!("({i}, 0, 0)"), &[POINTS, "no face has an area", "positions"]),
        scaled(|i| format!("({}e30, {}e30, 0)", i % 3, i / 3), &[POINTS, "mean edge length is", "metersPerUnit"]),
        scaled(|i| format!("({}e-30, {}e-30, 0)", i % 3, i / 3), &[POINTS, "mean edge length is", "metersPerUnit"]),
        with(
            "int[] holeIndices = [0, 1, 2, 3]",
            &["/Coat/model.holeIndices", "no face is left", "interpolateBoundary"],
        ),
        with("uniform token interpolateBoundary = \"none\"", &["no face is left", "edgeAndCorner"]),
    ]);
}
