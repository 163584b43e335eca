//! Every fault that a garment can have, each with what is said of it.

use super::{cloth, varying};
use crate::garment::{Garment, Interpolation, Meaning, PrimvarInput, Scheme, Values, check_garment};

/// One way to break the cloth, and what must be said of it.
struct FaultCase {
    attribute: &'static str,
    fault: &'static str,
    remedy: &'static str,
    breaks: fn(&mut Garment),
}

const fn fault(
    attribute: &'static str,
    fault: &'static str,
    remedy: &'static str,
    breaks: fn(&mut Garment),
) -> FaultCase {
    FaultCase { attribute, fault, remedy, breaks }
}

/// The numbers of a primvar of floats.
fn floats(input: &mut Garment, primvar: usize) -> &mut Vec<f32> {
    match &mut input.primvars[primvar].values {
        Values::F32(values) => values,
        other => panic!("no floats: {other:?}"),
    }
}

/// Checks that `faults` are each found, alone, and told as the table says.
fn each_is_told(faults: &[FaultCase]) {
    for row in faults {
        let mut input = cloth();
        (row.breaks)(&mut input);
        let expected = row.fault;
        let Err(error) = check_garment(input) else { panic!("not found: {expected}") };
        let [problem] = error.faults.as_slice() else { panic!("{expected}: told with others\n{error}") };
        assert_eq!(error.more, 0, "{expected}");
        assert_eq!(attribute(&problem.place), row.attribute, "{expected}\n{error}");
        assert!(problem.text.contains(row.fault), "{expected}\n{error}");
        assert!(problem.remedy.contains(row.remedy), "{expected}\n{error}");
    }
}

/// The attribute of a path, with the name of the subset where it is one's.
fn attribute(path: &str) -> &str {
    path.strip_prefix("/Coat/model").map_or(path, |rest| &rest[1..])
}

const COUNTS: &str = "faceVertexCounts";
const INDICES: &str = "faceVertexIndices";
const SCHEME: &str = "subdivisionScheme";

#[test]
fn faults_of_points_and_faces() {
    each_is_told(&[
        fault("points", "has no points", "author the points", |i| i.points.clear()),
        fault("points", "point 5 is (2, NaN, 0)", "finite position", |i| i.points[5].y = f32::NAN),
        fault("points", "point 8 is (2, 2, -inf)", "finite position", |i| i.points[8].z = f32::NEG_INFINITY),
        fault(COUNTS, "face 1 has a count of 2", "remove the face", |i| i.face_vertex_counts = vec![4, 2, 6, 4]),
        fault(COUNTS, "face 2 has a count of 0", "remove the face", |i| i.face_vertex_counts = vec![4, 8, 0, 4]),
        fault(COUNTS, "face 0 has a count of -4", "remove the face", |i| i.face_vertex_counts[0] = -4),
        fault(INDICES, "holds 15 indices, but faceVertexCounts adds up to 16", "add the missing 1 index", |i| {
            i.face_vertex_indices.truncate(15);
        }),
        fault(INDICES, "holds 18 indices, but faceVertexCounts adds up to 16", "remove the surplus 2 indices", |i| {
            i.face_vertex_indices.extend([1, 2]);
        }),
        fault(INDICES, "corner 2 of face 1 names point -1", "from 0 to 8", |i| i.face_vertex_indices[6] = -1),
        fault(INDICES, "corner 3 of face 3 names point 9, but there are 9 points, 0 to 8", "from 0 to 8", |i| {
            i.face_vertex_indices[15] = 9;
        }),
        fault(INDICES, "face 3 has point 4 twice, at corners 0 and 2", "split the face", |i| {
            i.face_vertex_indices[14] = 4;
        }),
        fault("holeIndices", "entry 1 names face 4, but there are 4 faces", "from 0 to 3", |i| i.hole_indices[1] = 4),
        fault("holeIndices", "entry 0 names face -2", "from 0 to 3", |i| i.hole_indices[0] = -2),
        fault(SCHEME, "face 0 has 4 corners (4 faces in all)", "triangulate", |i| i.rules.scheme = Scheme::Loop),
    ]);
}

#[test]
fn faults_of_creases_and_corners() {
    const SHARP: &str = "creaseSharpnesses";
    const CORNERS: &str = "cornerIndices";
    each_is_told(&[
        fault("creaseLengths", "crease 1 has a length of 1", "other end", |i| i.crease_lengths = vec![4, 1]),
        fault("creaseLengths", "crease 0 has a length of -3", "remove the crease", |i| i.crease_lengths[0] = -3),
        fault("creaseIndices", "holds 4 indices, but creaseLengths adds up to 5", "correct creaseLengths", |i| {
            i.crease_indices.truncate(4);
        }),
        fault("creaseIndices", "entry 2 names point 90", "from 0 to 8", |i| i.crease_indices[2] = 90),
        fault("creaseIndices", "entry 4 names point -5", "from 0 to 8", |i| i.crease_indices[4] = -5),
        fault("creaseIndices", "step 1 of crease 0, point 4 to 8, is not an edge", "in between", |i| {
            i.crease_indices[2] = 8;
        }),
        fault("creaseIndices", "step 0 of crease 1, point 4 to 4, is not an edge", "in between", |i| {
            i.crease_indices[4] = 4;
        }),
        fault(SHARP, "holds 4 numbers, but there are 2 creases of 3 edges", "(2) or one for each edge (3)", |i| {
            i.crease_sharpnesses.push(1.0);
        }),
        fault(SHARP, "holds 0 numbers", "give one sharpness", |i| i.crease_sharpnesses.clear()),
        fault(SHARP, "entry 1 is -1,", "use 0", |i| i.crease_sharpnesses[1] = -1.0),
        fault(SHARP, "entry 0 is NaN", "use 0", |i| i.crease_sharpnesses[0] = f32::NAN),
        fault(SHARP, "entry 2 is -inf", "use 0", |i| i.crease_sharpnesses[2] = f32::NEG_INFINITY),
        fault(CORNERS, "entry 1 names point 9", "from 0 to 8", |i| i.corner_indices[1] = 9),
        fault(CORNERS, "entry 0 names point -1", "from 0 to 8", |i| i.corner_indices[0] = -1),
        fault(CORNERS, "entry 1 names point 8 again, after entry 0", "keep one", |i| i.corner_indices[1] = 8),
        fault("cornerSharpnesses", "holds 1 number, but cornerIndices holds 2", "each corner (2)", |i| {
            i.corner_sharpnesses.truncate(1);
        }),
        fault("cornerSharpnesses", "holds 3 numbers", "each corner (2)", |i| i.corner_sharpnesses.push(1.0)),
        fault("cornerSharpnesses", "entry 1 is NaN", "use 0", |i| i.corner_sharpnesses[1] = f32::NAN),
        fault("cornerSharpnesses", "entry 0 is -0.5", "use 0", |i| i.corner_sharpnesses[0] = -0.5),
    ]);
}

#[test]
fn faults_of_primvars() {
    const ST: &str = "primvars:st";
    const ST_INDICES: &str = "primvars:st:indices";
    const WEIGHTS: &str = "primvars:skel:jointWeights";
    each_is_told(&[
        fault(WEIGHTS, "holds 16 values, but vertex interpolation needs 18: 2 for each of 9 points", "give 18", |i| {
            floats(i, 1).truncate(16);
        }),
        fault(ST, "holds 13 values, but faceVarying interpolation needs 16", "give 16", |i| {
            i.primvars[0].indices = None;
        }),
        fault(WEIGHTS, "holds 17 values, no multiple of elementSize 2", "correct elementSize", |i| {
            floats(i, 1).truncate(17);
        }),
        fault(ST, "25 numbers do not make whole values of 2", "full type", |i| {
            floats(i, 0).truncate(25);
        }),
        fault(WEIGHTS, "elementSize is 0", "set elementSize", |i| i.primvars[1].element_size = 0),
        fault(WEIGHTS, "elementSize is -2", "set elementSize", |i| i.primvars[1].element_size = -2),
        fault(ST_INDICES, "corner 0 of face 1 names value -1", "from 0 to 12", |i| st_indices(i)[4] = -1),
        fault(ST_INDICES, "corner 1 of face 2 names value 13, but there are 13 values, 0 to 12", "from 0 to 12", |i| {
            st_indices(i)[9] = 13;
        }),
        fault(
            ST_INDICES,
            "holds 17 indices, but faceVarying interpolation needs 16, one for each corner",
            "give 16",
            |i| st_indices(i).push(0),
        ),
        fault(ST_INDICES, "holds 0 indices", "give 16 indices", |i| st_indices(i).clear()),
        fault(ST, "value 3 holds NaN", "finite number", |i| floats(i, 0)[7] = f32::NAN),
        fault(ST, "corner 2 of face 1 holds inf", "finite number", |i| {
            i.primvars[0].indices = None;
            *floats(i, 0) = vec![0.0; 32];
            floats(i, 0)[13] = f32::INFINITY;
        }),
        fault(WEIGHTS, "point 3 holds inf", "finite number", |i| floats(i, 1)[7] = f32::INFINITY),
        fault("primvars:tint", "two primvars of this name", "rename", |i| i.primvars.push(varying())),
    ]);
}

#[test]
fn primvars_that_no_step_needs_are_left_out() {
    let cases = [
        fault("primvars:ply", "holds 9 values, but uniform interpolation needs 4", "interpolation to vertex", |i| {
            i.primvars[3].values = Values::F64(vec![0.0; 9]);
        }),
        fault(
            "primvars:tint",
            "holds 7 values, but varying interpolation needs 9: 1 for each of 9 points",
            "give 9",
            |i| floats(i, 4).truncate(7),
        ),
        fault("primvars:tint", "needs 16: 1 for each of 16 corners", "interpolation to vertex", |i| {
            i.primvars[4].interpolation = Interpolation::FaceVarying;
        }),
        fault("primvars:ply", "face 2 holds NaN", "finite number", |i| {
            i.primvars[3].values = Values::F64(vec![0.0, 0.0, f64::NAN, 0.0]);
        }),
        fault("primvars:tint:indices", "point 3 names value 9", "from 0 to 8", |i| {
            i.primvars[4].indices = Some(vec![0, 1, 2, 9, 4, 5, 6, 7, 8]);
        }),
        fault("primvars:tint", "elementSize is 0", "set elementSize", |i| i.primvars[4].element_size = 0),
    ];
    for row in &cases {
        let mut input = cloth();
        (row.breaks)(&mut input);
        let (mesh, warnings) = check_garment(input).unwrap_or_else(|e| panic!("{}: {e}", row.fault));
        let [left_out] = mesh.left_out.as_slice() else { panic!("{}: {:?}", row.fault, mesh.left_out) };
        assert!(mesh.primvar(&left_out.name).is_none() && mesh.primvars.len() == 4, "{}", row.fault);
        assert_eq!(attribute(&left_out.fault.place), row.attribute, "{}", row.fault);
        let all: Vec<_> = warnings.iter().collect();
        let [warning] = all.as_slice() else { panic!("{}: {warnings:?}", row.fault) };
        assert!(warning.problem.contains(row.fault), "{warning}");
        assert!(warning.remedy.to_lowercase().contains(&row.remedy.to_lowercase()), "{warning}");
    }
}

/// The indices of the UVs.
fn st_indices(input: &mut Garment) -> &mut Vec<i32> {
    input.primvars[0].indices.as_mut().expect("the UVs are indexed")
}

#[test]
fn an_index_without_values_is_told() {
    let mut input = cloth();
    input.primvars = vec![PrimvarInput { meaning: Meaning::TextureCoordinate, indices: Some(vec![0; 9]), ..varying() }];
    floats(&mut input, 0).clear();
    let error = check_garment(input).expect_err("there are no values");
    assert!(error.faults[0].text.contains("point 0 names value 0, but there are no values"), "{error}");
    assert_eq!((error.faults.len(), error.more), (5, 4));
}

#[test]
fn faults_of_subsets() {
    const PLACKET: &str = "placket.indices";
    each_is_told(&[
        fault("left.indices", "entry 1 names face 4, but there are 4 faces, 0 to 3", "from 0 to 3", |i| {
            i.subsets[1].indices[1] = 4;
        }),
        fault("pins.indices", "entry 0 names point -8", "from 0 to 8", |i| i.subsets[4].indices[0] = -8),
        fault(PLACKET, "pair 1 names point 10", "from 0 to 8", |i| i.subsets[2].indices[3] = 10),
        fault("left.indices", "entry 2 names face 0 again, after entry 0", "remove one", |i| {
            i.subsets[1].indices.push(0);
        }),
        fault("pins.indices", "entry 1 names point 8 again", "remove one", |i| i.subsets[4].indices[1] = 8),
        fault(PLACKET, "holds 5 indices, which do not pair up", "two end points", |i| i.subsets[2].indices.push(4)),
        fault(PLACKET, "pair 0, points 7 and 1, is not an edge", "one pair for each edge", |i| {
            i.subsets[2].indices[1] = 1;
        }),
        fault(PLACKET, "pair 1 joins point 4 to itself", "remove the pair", |i| i.subsets[2].indices[2] = 4),
        fault(PLACKET, "pair 2, points 1 and 4, is the edge of pair 1 again", "remove one", |i| {
            i.subsets[2].indices.extend([1, 4]);
        }),
        fault(PLACKET, "pair 2, points 4 and 7, is the edge of pair 0 again", "remove one", |i| {
            i.subsets[2].indices.extend([4, 7]);
        }),
        fault("left.elementType", "\"tetrahedron\" is not an element of a mesh", "face, edge or point", |i| {
            i.subsets[1].element_type = "tetrahedron".into();
        }),
        fault("pins.elementType", "is point, but subset right of the same family \"panels\" is face", "of its own", {
            |i| i.subsets[4].family = "panels".into()
        }),
    ]);
}

#[test]
fn a_mesh_without_faces_is_told() {
    let bare = Garment { points: cloth().points, prim: "/Coat/model".into(), ..Garment::default() };
    let error = check_garment(bare).expect_err("there are no faces");
    assert_eq!(
        error.to_string(),
        "/Coat/model.faceVertexCounts: the mesh has no faces\n  hint: author the faces, or name another mesh with --prim"
    );
}

#[test]
fn independent_faults_are_told_together_in_a_fixed_order() {
    let mut input = cloth();
    input.points[2].x = f32::NAN;
    input.face_vertex_indices[3] = 99;
    input.hole_indices.push(12);
    input.crease_lengths[1] = 1;
    input.corner_sharpnesses[0] = -1.0;
    input.primvars[1].element_size = 0;
    st_indices(&mut input)[0] = 77;
    input.subsets[4].indices[1] = 8;
    let error = check_garment(input).expect_err("broken throughout");
    let attributes: Vec<&str> = error.faults.iter().map(|p| attribute(&p.place)).collect();
    let expected = [
        "points",
        INDICES,
        "holeIndices",
        "creaseLengths",
        "cornerSharpnesses",
        "primvars:st:indices",
        "primvars:skel:jointWeights",
        "pins.indices",
    ];
    assert_eq!(attributes, expected);
}
