//! What is read, and what is refused.

use crate::stage::*;
use glam::Vec3;
use std::fs;
use tailor_usd::{ReadOptions, Source};

#[test]
fn files_that_are_no_stage_are_named() {
    let at = Stages::new();
    assert_fault(open(&at.at("none.usda")), &["none.usda", "no such file"]);
    assert_fault(open(at.0.path()), &["is a folder", "hint"]);
    fs::write(at.at("empty.usdc"), "").unwrap();
    assert_fault(open(&at.at("empty.usdc")), &["empty.usdc is empty"]);
    fs::write(at.at("coat.obj"), "v 0 0 0").unwrap();
    assert_fault(open(&at.at("coat.obj")), &["coat.obj", ".usdz", "hint"]);
    for name in ["text.usda", "text.usdc", "text.usd", "text.usdz"] {
        fs::write(at.at(name), "hello, this is not USD").unwrap();
        assert_fault(open(&at.at(name)), &[name, "cannot be read as USD", "hint"]);
    }
    let source = open(&at.usda("coat.usda", &coat(""))).unwrap();
    tailor(&source, &at.at("whole.usdc"), &FLATTEN).unwrap();
    let bytes = fs::read(at.at("whole.usdc")).unwrap();
    fs::write(at.at("half.usdc"), &bytes[..bytes.len() / 2]).unwrap();
    assert_fault(open(&at.at("half.usdc")), &["half.usdc", "cannot be read as USD"]);
}

#[test]
fn the_mesh_is_the_only_one_or_the_one_named() {
    let at = Stages::new();
    let none =
        at.usda("none.usda", "def Xform \"A\" {}\nclass Mesh \"C\" {}\ndef Mesh \"Off\" ( active = false ) {}\n");
    assert_fault(open(&none), &["holds no mesh", "hint"]);
    let several: String = (0..10).map(|i| format!("def Mesh \"M{i}\" {{\n{QUADS}}}\n")).collect();
    let several = at.usda("several.usda", &(several + "def Xform \"X\" {}\n"));
    assert_fault(open(&several), &["10 meshes", "--prim", "/M0, /M1", "and 2 more"]);
    assert_eq!(open_prim(&several, "/M3").unwrap().prim(), "/M3");
    assert_fault(open_prim(&several, "/Nope"), &["has no prim /Nope", "/M0"]);
    assert_fault(open_prim(&several, "/X"), &["/X is Xform, not a Mesh"]);
    for bad in ["M3", "/M3.points", "", "/", "/a b", "//"] {
        assert_fault(open_prim(&several, bad), &["is not the path of a prim"]);
    }
    assert_fault(open_prim(&none, "/C"), &["/C is inactive, undefined, or a class"]);
}

#[test]
fn a_mesh_in_an_instance_is_refused_and_one_beside_it_is_not() {
    let at = Stages::new();
    at.usda("coat.usda", &coat(""));
    let inside = at.usda("inside.usda", "def \"I\" (\n instanceable = true\n references = @./coat.usda@\n) {}\n");
    assert_fault(open(&inside), &["/I/model is inside an instance", "instanceable = false"]);
    let plain = at.usda("plain.usda", "def \"I\" (\n references = @./coat.usda@\n) {}\n");
    let source = open(&plain).unwrap();
    assert_eq!(source.prim(), "/I/model");
    assert_eq!(source.facts().layers.len(), 2);
}

#[test]
fn arcs_that_lead_nowhere_are_warnings() {
    let at = Stages::new();
    let file = at.usda("coat.usda", &(coat("") + "def \"B\" (\n references = @./gone.usda@\n) {}\n"));
    let (_, warnings) = open(&file).unwrap().garment().unwrap();
    let text: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(text.len(), 1);
    assert!(text[0].contains("gone.usda"), "{text:?}");
    let file = at.usda("lost.usda", "def \"B\" (\n references = @./gone.usda@\n) {}\n");
    assert_fault(open(&file), &["holds no mesh", "gone.usda"]);
}

#[test]
fn attributes_at_fault_are_named() {
    let at = Stages::new();
    let cases: &[(&str, &[&str])] = &[
        ("uniform token subdivisionScheme = \"catmul\"", &["subdivisionScheme is \"catmul\"", "catmullClark, loop"]),
        ("uniform token orientation = \"left\"", &["orientation is \"left\"", "rightHanded, leftHanded"]),
        ("token interpolateBoundary = \"x\"", &["interpolateBoundary", "edgeAndCorner"]),
        ("token faceVaryingLinearInterpolation = \"x\"", &["faceVaryingLinearInterpolation", "cornersPlus2"]),
        ("token triangleSubdivisionRule = \"x\"", &["triangleSubdivisionRule", "smooth"]),
        ("float[] holeIndices = [1]", &["/Coat/model.holeIndices is not of type int[]"]),
        (
            "float[] creaseSharpnesses.timeSamples = { 3: [1], 4: [2] }",
            &["creaseSharpnesses has values at 2 times", "--time 3"],
        ),
        ("float[] primvars:a = [1] ( interpolation = \"edge\" )", &["primvars:a", "\"edge\"", "faceVarying"]),
        ("uniform token subsetFamily:f:familyType = \"x\"", &["subsetFamily:f:familyType", "partition"]),
        ("def GeomSubset \"s\" {\n float[] indices = [1]\n}", &["/Coat/model/s.indices is not of type int[]"]),
    ];
    for (extra, parts) in cases {
        let source = open(&at.usda("coat.usda", &coat(extra))).unwrap();
        assert_fault(read(&source), parts);
    }
    for (missing, body) in [
        ("points", "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0,1,2]\n"),
        ("faceVertexCounts", "point3f[] points = [(0,0,0)]\n int[] faceVertexCounts = None\n"),
    ] {
        let file = at.usda("bare.usda", &format!("def Mesh \"M\" {{\n{body}}}\n"));
        assert_fault(read(&open(&file).unwrap()), &["/M has no", missing]);
    }
}

#[test]
fn schema_fallbacks_stand_in() {
    let at = Stages::new();
    let source = open(&at.usda("coat.usda", &coat("def GeomSubset \"s\" {\n int[] indices = [1]\n}"))).unwrap();
    let input = read(&source).unwrap();
    assert_eq!(input.rules, Default::default());
    assert_eq!(input.orientation, Default::default());
    assert_eq!(input.subsets[0].element_type, "face");
    assert_eq!((source.facts().purpose.as_str(), source.facts().visibility.as_str()), ("default", "inherited"));
}

#[test]
fn values_are_taken_at_the_time_asked_for() {
    let at = Stages::new();
    let moving = "point3f[] points.timeSamples = { 0: [(0,0,0),(1,0,0),(2,0,0),(0,1,0),(1,1,0),(2,1,0)], \
                  10: [(0,0,4),(1,0,4),(2,0,4),(0,1,4),(1,1,4),(2,1,4)] }\n\
                  float[] primvars:w.timeSamples = { 0: [0,0,0,0,0,0], 10: [1,1,1,1,1,1] }\n\
                  float[] primvars:w ( interpolation = \"vertex\" )\n\
                  token[] primvars:t.timeSamples = { 0: [\"a\",\"b\"], 10: [\"c\",\"d\"] }\n\
                  token[] primvars:t ( interpolation = \"uniform\" )";
    let body = coat(moving).replace("point3f[] points = [(0,0,0),(1,0,0),(2,0,0),(0,1,0),(1,1,0),(2,1,0)]\n", "");
    let file = at.usda("coat.usda", &body);
    assert_fault(read(&open(&file).unwrap()), &["points has values at 2 times", "--time 0"]);
    let input =
        read(&Source::open(&file, &ReadOptions { time: Some(2.5), ..ReadOptions::default() }).unwrap()).unwrap();
    assert_eq!(input.points[5], Vec3::new(2.0, 1.0, 1.0));
    let values = |name: &str| input.primvars.iter().find(|p| p.name == name).unwrap().values.clone();
    assert_eq!(values("w"), tailor_mesh::Values::F32(vec![0.25; 6]));
    assert_eq!(values("t"), tailor_mesh::Values::Text(vec!["a".into(), "b".into()]));
    let nan = ReadOptions { time: Some(f64::NAN), ..ReadOptions::default() };
    assert_fault(Source::open(&file, &nan), &["the time is not a number"]);
}

#[test]
fn the_recipe_is_read_with_its_targets() {
    let at = Stages::new();
    let extra = "double tailor:sim:maxEdgeLength = 2.5\n float tailor:sim:minEdgeLength = 0.1\n\
                 uniform token[] tailor:render:operators = [\"a\", \"b\"]\n token tailor:sim:uvSet = None\n\
                 rel tailor:seam:side:edges = </Coat/model/hem>\n\
                 def GeomSubset \"hem\" {\n uniform token elementType = \"edge\"\n int[] indices = [0,1]\n}";
    let source = open(&at.usda("coat.usda", &coat(extra))).unwrap();
    let recipe = serde_json::to_string(&source.recipe().unwrap()).unwrap();
    let expected = r#"{"render":{"operators":["a","b"]},"seam":{"side":{"edges":["hem"]}},"sim":{"maxEdgeLength":2.5,"minEdgeLength":0.1}}"#;
    assert_eq!(recipe, expected);
    for (extra, parts) in [
        ("rel tailor:sim:constraints = </Coat>", ["targets /Coat", "not a GeomSubset of the mesh"]),
        ("double3 tailor:sim:x = (1,2,3)", ["tailor:sim:x", "type that no recipe field has"]),
        ("int tailor:sim = 1\n int tailor:sim:x = 1", ["tailor:sim", "both a value and a namespace"]),
    ] {
        assert_fault(open(&at.usda("bad.usda", &coat(extra))).unwrap().recipe(), &parts);
    }
}

#[test]
fn what_is_not_carried_is_said() {
    let at = Stages::new();
    let extra = "normal3f[] normals = [(0,0,1)]\n vector3f[] velocities = None\n vector3f[] accelerations = [(0,0,1)]\n\
                 uniform token[] skel:blendShapes = [\"a\"]\n float primvars:single = 1 ( interpolation = \"vertex\" )\n\
                 def GeomSubset \"t\" {\n uniform token elementType = \"tetrahedron\"\n}";
    let (input, warnings) = open(&at.usda("coat.usda", &coat(extra))).unwrap().garment().unwrap();
    assert!(input.subsets.is_empty() && input.primvars.is_empty());
    let text: String = warnings.iter().map(|w| w.to_string() + "\n").collect();
    for part in ["model.normals", "model.accelerations", "skel:blendShapes", "primvars:single", "tetrahedron"] {
        assert!(text.contains(part), "{part} in:\n{text}");
    }
    assert!(!text.contains("velocities"), "a blocked value is not a value:\n{text}");
}

#[test]
fn facts_tell_what_surrounds_the_model() {
    let at = Stages::new();
    let body = coat(
        "custom int userProperties:x = 1\n double3 xformOp:translate = (1, 2, 3)\n\
                     uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:translate\"]",
    )
    .replace(
        "def Xform \"Coat\"\n{",
        "def Xform \"Coat\" (\n prepend apiSchemas = [\"MaterialBindingAPI\"]\n)\n{\n\
                color3f primvars:tint = (1,0,0)\n rel material:binding:preview = </Looks/A>\n",
    );
    let source = open(&at.usda("coat.usda", &body)).unwrap();
    let facts = source.facts();
    assert_eq!((facts.up_axis.as_str(), facts.meters_per_unit), ("Y", 0.01));
    assert_eq!(facts.staying, ["userProperties:x"]);
    assert_eq!(facts.transform.len(), 2);
    assert_eq!(facts.transform[1].value, "(1.0, 2.0, 3.0)");
    assert_eq!(
        (facts.inherited_primvars[0].name.as_str(), facts.inherited_primvars[0].from.as_str()),
        ("tint", "/Coat")
    );
    assert_eq!(facts.bindings[0].relationship, "material:binding:preview");
    assert_eq!(facts.bindings[0].targets, ["/Looks/A"]);
}

#[test]
fn variants_inherits_and_payloads_compose() {
    let at = Stages::new();
    at.usda("part.usda", &coat("int[] primvars:a = [1,2] ( interpolation = \"uniform\" )"));
    let file = at.usda(
        "coat.usda",
        "class \"_c\" {\n over \"model\" {\n int[] primvars:b = [3,4] ( interpolation = \"uniform\" )\n}\n}\n\
         def Xform \"A\" (\n payload = @./part.usda@</Coat>\n inherits = </_c>\n variants = { string v = \"two\" }\n\
         prepend variantSets = \"v\"\n) {\n variantSet \"v\" = {\n \"one\" {}\n \"two\" {\n over \"model\" {\n\
         uniform token orientation = \"leftHanded\"\n int[] holeIndices = [1]\n}\n}\n}\n}\n",
    );
    let input = read(&open(&file).unwrap()).unwrap();
    assert_eq!(input.prim, "/A/model");
    assert_eq!(input.primvars.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(input.orientation, tailor_mesh::Orientation::LeftHanded);
    assert_eq!(input.hole_indices, [1]);
}

#[test]
fn deep_stages_are_read_and_written() {
    let at = Stages::new();
    let depth = 200;
    let body = "def \"a\" {\n".repeat(depth) + &format!("def Mesh \"model\" {{\n{QUADS}}}\n") + &"}\n".repeat(depth);
    let source = open(&at.usda("deep.usda", &body)).unwrap();
    for (name, options) in [("over.usda", FORCE), ("flat.usdc", FLATTEN)] {
        tailor(&source, &at.at(name), &options).unwrap();
        assert!(open(&at.at(name)).unwrap().prim().ends_with("/a/model"));
    }
}
