//! Faults of recipes: files, and the attributes of the model.

use super::{Fault, each_is_told, fault};
use crate::cloth::{CLOTH, cloth_and};

const ARGS: &str = "build in.usda -o out/coat.usda --recipe my.tailor";

/// A recipe beside a sound garment.
fn recipe(text: &'static str, says: &'static [&'static str]) -> Fault {
    fault(
        ARGS,
        move |folder| {
            folder.file("in.usda", CLOTH);
            folder.file("my.tailor", text);
        },
        says,
    )
}

/// A garment with attributes of a recipe.
fn attribute(statement: &'static str, says: &'static [&'static str]) -> Fault {
    fault("build in.usda -o out/coat.usda", move |folder| folder.file("in.usda", cloth_and(statement)), says)
}

#[test]
fn of_the_file() {
    each_is_told(&[
        fault(ARGS, |f| f.file("in.usda", CLOTH), &["my.tailor: cannot read recipe: no such file", "check the path"]),
        fault(
            ARGS,
            |f| {
                f.file("in.usda", CLOTH);
                std::fs::create_dir(f.at("my.tailor")).expect("a folder");
            },
            &["my.tailor: cannot read recipe", "is a folder"],
        ),
        recipe("", &["my.tailor: ", "line 1 column 0", "JSON"]),
        recipe("{\"sim\": {\n  \"maxEdgeLength\": 2,\n}}", &["my.tailor: trailing comma at line 3 column 1"]),
        recipe(
            "{\"sim\": {\n  \"maxEdge\": 2\n}}",
            &["my.tailor: unknown field `maxEdge`", "line 2 column 11", "maxEdgeLength"],
        ),
        recipe("{\n\"sin\": {}}", &["my.tailor: unknown field `sin`", "line 2 column 5", "`sim`"]),
        recipe("{\"render\": {\"levels\": 2}}", &["unknown field `levels`", "line 1 column 20", "`level`"]),
        recipe(
            "{\"sim\": {\"maxEdgeLength\": \"2\"}}",
            &["my.tailor: invalid type: string \"2\", expected a number", "line 1 column 29"],
        ),
        recipe(
            "{\"sim\": {\"iterations\": 2.5}}",
            &["invalid type: floating point `2.5`, expected a whole number", "line 1 column 26"],
        ),
        recipe("{\"sim\": {\"constraints\": \"hem\"}}", &["expected a list", "line 1 column 29"]),
        recipe("{\"sim\": 3}", &["my.tailor: ", "expected { options }", "line 1 column 9"]),
        recipe("[1, 2]", &["my.tailor: ", "line 1"]),
        recipe("{\"sim\": {\"maxEdgeLength\": -2}}", &["sim.maxEdgeLength: -2 is not a length"]),
        recipe("{\"sim\": {\"uvSet\": \"map1\"}}", &["sim.uvSet: \"map1\" is no", "the mesh has: st"]),
        recipe("{\"sim\": {\"density\": \"paint\"}}", &["sim.density: \"paint\" is no", "density, tint"]),
        recipe("{\"sim\": {\"constraints\": [\"hem\"]}}", &["sim.constraints: \"hem\" is no", "placket, waist"]),
        recipe("{\"prim\": \"/Coat/hat\"}", &["in.usda has no prim /Coat/hat", "/Coat/model"]),
        fault(
            "build --recipe my.tailor -o out/coat.usda",
            |f| f.file("my.tailor", "{\"source\": \"gone.usda\"}"),
            &["cannot read gone.usda: no such file"],
        ),
        fault(
            "build --recipe my.tailor -o out/coat.usda",
            |f| f.file("my.tailor", "{}"),
            &["no input", "a recipe with a \"source\""],
        ),
        fault(
            "check --recipe my.tailor",
            |f| f.file("my.tailor", "{\"source\": \"gone.usda\""),
            &["my.tailor: EOF", "line 1 column 22"],
        ),
    ]);
}

#[test]
fn of_the_models_attributes() {
    each_is_told(&[
        attribute(
            "uniform token tailor:sim:maxEdgeLength = \"long\"",
            &["tailor:sim:maxEdgeLength of the model: ", "expected a number", "declare it as float"],
        ),
        attribute(
            "uniform float tailor:sim:iterations = 2.5",
            &["tailor:sim:iterations of the model: ", "expected a whole number", "declare it as int"],
        ),
        attribute("uniform float tailor:sim:maxEdgeLength = -3", &["sim.maxEdgeLength: -3 is not a length"]),
        attribute("uniform token tailor:sim:uvSet = \"map1\"", &["sim.uvSet: \"map1\" is no", "the mesh has: st"]),
        attribute("uniform token tailor:sim:density = \"ply\"", &["sim.density: \"ply\" is no", "density, tint"]),
        attribute(
            "rel tailor:sim:constraints = </Coat/model/hem>",
            &["/Coat/model.tailor:sim:constraints targets /Coat/model/hem", "placket, waist"],
        ),
        attribute(
            "rel tailor:sim:constraints = </Coat/model/left>",
            &["sim.constraints: \"left\" is a subset of faces of"],
        ),
        attribute("uniform int tailor:render:level = 9", &["render.level: 9 is out of range"]),
        attribute(
            "uniform int tailor:render:level = -1",
            &["tailor:render:level of the model: ", "expected a whole number"],
        ),
        attribute(
            "uniform float3 tailor:sim:maxEdgeLength = (1, 2, 3)",
            &["/Coat/model.tailor:sim:maxEdgeLength has a type that no recipe field has", "recipe fields are"],
        ),
    ]);
}
