//! What is written: layers over the input, flattened layers and packages.

use crate::stage::*;
use std::fs;
use std::path::Path;
use tailor_mesh::Garment;
use tailor_testing::garments::garments;
use tailor_usd::{Format, Product, ProductRole, ReadOptions, Source, Surroundings, WriteOptions, layer_bytes, write};

/// A coat with attributes of many kinds.
fn rich() -> String {
    coat(
        "uniform token orientation = \"leftHanded\"\n int[] holeIndices = [1]\n int[] creaseIndices = [0,1,2,3,4]\n\
         int[] creaseLengths = [3,2]\n float[] creaseSharpnesses = [1,2.5,3]\n int[] cornerIndices = [0]\n\
         float[] cornerSharpnesses = [10]\n token interpolateBoundary = \"edgeOnly\"\n\
         token faceVaryingLinearInterpolation = \"all\"\n token triangleSubdivisionRule = \"smooth\"\n\
         half2[] primvars:h = [(0.333,1),(2,3)] (\n interpolation = \"vertex\"\n doc = \"said\"\n)\n\
         int[] primvars:h:indices = [0,1,1,0,0,1]\n\
         uint64[] primvars:u = [18446744073709551615,0] ( interpolation = \"uniform\" )\n\
         texCoord2f[] primvars:st = [(0,0),(1,0),(1,1),(0,1),(0,0),(1,0),(1,1),(0,1)] ( interpolation = \"faceVarying\" )\n\
         int[] primvars:j = [0,1,0,1,0,1,0,1,0,1,0,1] (\n interpolation = \"vertex\"\n elementSize = 2\n)\n\
         color3f[] primvars:displayColor = [(1,0,0)] ( colorSpace = \"lin_rec709_scene\" )\n\
         float primvars:moving.timeSamples = { 1: 2, 3: 4 }\n token visibility.timeSamples = { 1: \"invisible\" }\n\
         double3 xformOp:translate.timeSamples = { 1: (1,2,3) }\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\"]\n rel material:binding = </Coat/Looks/A> (\n\
         bindMaterialAs = \"strongerThanDescendants\"\n)\n uniform token subsetFamily:f:familyType = \"partition\"\n\
         def GeomSubset \"a\" (\n doc = \"left\"\n prepend apiSchemas = [\"MaterialBindingAPI\"]\n) {\n\
         uniform token familyName = \"f\"\n int[] indices = [0]\n rel material:binding = </Coat/Looks/B>\n}\n\
         def GeomSubset \"b\" {\n uniform token familyName = \"f\"\n int[] indices = [1]\n}\n\
         def GeomSubset \"e\" {\n uniform token elementType = \"edge\"\n int[] indices = [0,1,1,2]\n}\n\
         def GeomSubset \"p\" {\n uniform token elementType = \"point\"\n int[] indices = [5]\n}\n",
    )
}

/// Compares all but the path. The text writer drops the sign of a zero, so signs of zeros do not count.
#[track_caller]
fn same(a: &Garment, b: &Garment) {
    let text = |g: &Garment| format!("{:#?}", Garment { prim: String::new(), ..g.clone() }).replace(" -0.0,", " 0.0,");
    let (a, b) = (text(a), text(b));
    for (line, (a, b)) in a.lines().zip(b.lines()).enumerate() {
        assert_eq!(a, b, "line {line}");
    }
    assert_eq!(a.lines().count(), b.lines().count());
}

#[test]
fn products_come_back_as_they_went_in_every_format() {
    let at = Stages::new();
    let source = open(&at.usda("coat.usda", &rich())).unwrap();
    let input = read(&source).unwrap();
    for name in ["o.usda", "o.usdc", "o.usd", "o.usdz", "f.usda", "f.usdc"] {
        let options = if name.starts_with('f') { FLATTEN } else { FORCE };
        assert_eq!(tailor(&source, &at.at(name), &options).unwrap(), [""; 0]);
        same(&read(&open_prim(&at.at(name), "/Coat/render").unwrap()).unwrap(), &input);
        let mut sim = read(&open_prim(&at.at(name), "/Coat/sim").unwrap()).unwrap();
        assert_eq!(
            sim.rules,
            tailor_mesh::SubdivisionRules { scheme: tailor_mesh::Scheme::None, ..Default::default() }
        );
        sim.rules = input.rules;
        same(&sim, &input);
        // The model itself is as it was, and the only mesh that counts.
        let model = open(&at.at(name)).unwrap();
        assert_eq!(model.prim(), "/Coat/model");
        assert_eq!(model.facts().purpose, "guide");
        same(&read(&model).unwrap(), &input);
    }
}

#[test]
fn a_layer_over_the_input_is_small_and_says_what_it_must() {
    let at = Stages::new();
    let source = open(&at.usda("in/coat.usda", &rich())).unwrap();
    tailor(&source, &at.at("out.usda"), &FORCE).unwrap();
    let text = fs::read_to_string(at.at("out.usda")).unwrap();
    for part in [
        "subLayers = [@./in/coat.usda@]",
        "defaultPrim = \"Coat\"",
        "upAxis = \"Y\"",
        "over \"Coat\"",
        "over \"model\"",
        "Simulation mesh made by usd-tailor from </Coat/model>.",
        "float3[] extent = [(0.0, 0.0, 0.0), (2.0, 1.0, 0.0)]",
        "bindMaterialAs = \"strongerThanDescendants\"",
        "token visibility.timeSamples",
        "double3 xformOp:translate.timeSamples",
        "float primvars:moving.timeSamples",
        "colorSpace = \"lin_rec709_scene\"",
        "said",
        "left",
    ] {
        assert!(text.contains(part), "{part:?} in:\n{text}");
    }
    assert!(!text.contains(at.0.path().to_str().unwrap()), "no path of this machine");
    fs::create_dir(at.at("other")).unwrap();
    tailor(&source, &at.at("other/out.usda"), &FORCE).unwrap();
    assert!(fs::read_to_string(at.at("other/out.usda")).unwrap().contains("@../in/coat.usda@"));
    let keep = WriteOptions { model_guide: false, ..FORCE };
    tailor(&source, &at.at("out.usda"), &keep).unwrap();
    assert!(!fs::read_to_string(at.at("out.usda")).unwrap().contains("over \"model\""));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let at = Stages::new();
    let file = at.usda("coat.usda", &rich());
    for name in ["o.usda", "o.usdc", "o.usdz", "f.usda", "f.usdc"] {
        let options = if name.starts_with('f') { FLATTEN } else { FORCE };
        let bytes = || {
            tailor(&open(&file).unwrap(), &at.at(name), &options).unwrap();
            fs::read(at.at(name)).unwrap()
        };
        assert!(bytes() == bytes(), "{name}");
    }
}

/// The composed stage of a file as lines. It leaves out the empty text, which only files have.
fn flat(file: &Path) -> Vec<String> {
    let source = open_prim(file, "/Coat/sim").unwrap();
    let (text, _) = layer_bytes(&source, &[], Format::Usda, Surroundings::default(), &FLATTEN).unwrap();
    let text = String::from_utf8(text).unwrap();
    text.lines().filter(|line| line.trim() != "\"\"").map(str::to_owned).collect()
}

#[test]
fn a_layer_in_memory_is_the_layer_in_the_file() {
    let at = Stages::new();
    let source = open(&at.usda("coat.usda", &rich())).unwrap();
    let mesh = sound(&read(&source).unwrap());
    let products = [Product::new("sim", ProductRole::Sim, &mesh)];
    let nowhere = Surroundings::default();
    let here = Surroundings { folder: Some(at.0.path()), ..nowhere };
    for (format, name) in [(Format::Usda, "o.usda"), (Format::Usdc, "o.usdc")] {
        write(&source, &products, &at.at(name), &FORCE).unwrap();
        let (bytes, _) = layer_bytes(&source, &products, format, here, &FORCE).unwrap();
        let memory = at.at(&format!("memory-{name}"));
        fs::write(&memory, bytes).unwrap();
        assert!(flat(&memory) == flat(&at.at(name)), "{name}");
    }
    let (text, _) = layer_bytes(&source, &products, Format::Usda, nowhere, &FORCE).unwrap();
    let absolute = at.0.path().canonicalize().unwrap().join("coat.usda");
    assert!(String::from_utf8(text).unwrap().contains(&format!("@{}@", absolute.display())));
    let stated = Surroundings { source: Some("asset:coat"), ..here };
    let (text, _) = layer_bytes(&source, &products, Format::Usda, stated, &FORCE).unwrap();
    assert!(String::from_utf8(text).unwrap().contains("subLayers = [@asset:coat@]"));
}

#[test]
fn a_source_in_memory_is_the_source_in_the_file() {
    let at = Stages::new();
    let file = at.usda("coat.usda", &rich());
    write(&open(&file).unwrap(), &[], &at.at("flat.usdc"), &WriteOptions { flatten: true, ..FORCE }).unwrap();
    let flat = open(&at.at("flat.usdc")).unwrap();
    let content: std::sync::Arc<[u8]> = fs::read(at.at("flat.usdc")).unwrap().into();
    let memory = Source::from_layer(content, &at.at("flat.usdc"), &ReadOptions::default()).unwrap();
    assert_eq!(memory.recipe().unwrap(), flat.recipe().unwrap());
    assert_eq!(memory.prim(), flat.prim());
    let mesh = sound(&read(&flat).unwrap());
    let products = [Product::new("sim", ProductRole::Sim, &mesh)];
    let here = Surroundings { folder: Some(at.0.path()), source: None };
    let text = |source: &Source, flatten: bool| {
        let options = WriteOptions { flatten, ..FORCE };
        layer_bytes(source, &products, Format::Usda, here, &options).unwrap().0
    };
    for flatten in [false, true] {
        assert!(text(&memory, flatten) == text(&flat, flatten), "flatten: {flatten}");
    }
    let broken = Source::from_layer(b"no layer".as_slice().into(), &file, &ReadOptions::default());
    let message = broken.unwrap_err().to_string();
    assert!(message.contains("coat.usda") && message.contains("hint:"), "{message}");
}

#[test]
fn what_must_not_be_written_is_not() {
    let at = Stages::new();
    at.usda("part.usda", &coat(""));
    let file = at.usda("coat.usda", "def \"A\" (\n references = @./part.usda@\n) {}\n");
    let source = open(&file).unwrap();
    let before = (fs::read(&file).unwrap(), fs::read(at.at("part.usda")).unwrap());
    fs::write(at.at("there.usda"), "mine").unwrap();
    fs::create_dir(at.at("folder.usda")).unwrap();
    fs::hard_link(&file, at.at("hard.usda")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(at.at("part.usda"), at.at("soft.usda")).unwrap();
    let names = at.names();
    let attempt = |name: &str, options| tailor(&source, &at.at(name), &options);
    for name in ["coat.usda", "part.usda", "hard.usda", "soft.usda", "../x/coat.usda"] {
        let path = if name.starts_with("..") { at.at("./coat.usda") } else { at.at(name) };
        assert_fault(tailor(&source, &path, &FORCE), &["is the input, or a file that the input uses"]);
    }
    assert_fault(attempt("there.usda", WriteOptions::default()), &["there.usda exists already", "--force"]);
    assert_fault(attempt("folder.usda", FORCE), &["is not a file"]);
    assert_fault(attempt("no/such/out.usda", FORCE), &["there is no folder", "no/such"]);
    assert_fault(attempt("out.fbx", FORCE), &["out.fbx does not end in"]);
    assert_fault(attempt("out", FORCE), &["does not end in"]);
    assert_eq!(at.names(), names, "nothing is left behind");
    assert_eq!((fs::read(&file).unwrap(), fs::read(at.at("part.usda")).unwrap()), before);
    attempt("there.usda", FORCE).unwrap();
    assert_ne!(fs::read(at.at("there.usda")).unwrap(), b"mine");
}

#[test]
#[cfg(unix)]
fn a_folder_that_cannot_be_written_to_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let at = Stages::new();
    let source = open(&at.usda("coat.usda", &coat(""))).unwrap();
    fs::create_dir(at.at("locked")).unwrap();
    fs::set_permissions(at.at("locked"), fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(at.at("locked/probe"), "").is_ok() {
        println!("skipped: this user may write anywhere");
        return;
    }
    assert_fault(tailor(&source, &at.at("locked/o.usda"), &FORCE), &["locked/o.usda", "permission denied"]);
}

#[test]
fn names_that_are_taken_or_impossible_are_refused() {
    let at = Stages::new();
    let body = coat("").replace("def Mesh", "def Scope \"render\" {}\n def Mesh");
    let source = open(&at.usda("coat.usda", &body)).unwrap();
    let mesh = sound(&read(&source).unwrap());
    let attempt = |sim, render| -> Result<(), tailor_mesh::Error> {
        let product = |name, role| Product::new(name, role, &mesh);
        let products = [product(sim, ProductRole::Sim), product(render, ProductRole::Render)];
        write(&source, &products, &at.at("o.usda"), &FORCE).map(drop)
    };
    assert_fault(attempt("sim", "render"), &["/Coat/render is taken", "--render-name"]);
    assert_fault(attempt("model", "r"), &["/Coat/model is taken", "--sim-name"]);
    assert_fault(attempt("same", "same"), &["/Coat/same is taken"]);
    assert_fault(attempt("a b", "r"), &["--sim-name \"a b\" is not a name"]);
    assert_fault(attempt("", "r"), &["is not a name"]);
    attempt("sim", "r").unwrap();
}

#[test]
fn earlier_products_are_replaced_whole() {
    let at = Stages::new();
    let first = open(&at.usda("coat.usda", &rich())).unwrap();
    tailor(&first, &at.at("first.usda"), &FORCE).unwrap();
    // The model changes: it has fewer attributes now.
    fs::write(at.at("coat.usda"), format!("#usda 1.0\n{}", coat(""))).unwrap();
    for (name, options) in [("second.usda", FORCE), ("flat.usdc", FLATTEN)] {
        let again = open(&at.at("first.usda")).unwrap();
        assert_eq!(again.prim(), "/Coat/model", "products are not garments");
        tailor(&again, &at.at(name), &options).unwrap();
        let product = open_prim(&at.at(name), "/Coat/render").unwrap();
        let input = read(&product).unwrap();
        assert!(
            input.primvars.is_empty() && input.subsets.is_empty() && input.hole_indices.is_empty(),
            "{name}: {input:?}"
        );
        assert!(input.crease_indices.is_empty() && input.families.is_empty(), "{name}: {input:?}");
        assert_eq!((&product.facts().bindings, &product.facts().constant_primvars), (&vec![], &vec![]), "{name}");
        assert_eq!(product.facts().visibility, "inherited");
    }
    // Products alone are not a garment.
    let only = fs::read_to_string(at.at("first.usda"))
        .unwrap()
        .replace("subLayers = [@./coat.usda@]", "")
        .replace("over", "def");
    fs::write(at.at("only.usda"), only).unwrap();
    assert_fault(open(&at.at("only.usda")), &["no mesh but products"]);
}

#[test]
fn models_at_the_root_have_siblings_at_the_root() {
    let at = Stages::new();
    let source = open(&at.usda("m.usda", &format!("( defaultPrim = \"M\" )\ndef Mesh \"M\" {{\n{QUADS}}}\n"))).unwrap();
    for (name, options) in [("o.usda", FORCE), ("f.usdc", FLATTEN)] {
        tailor(&source, &at.at(name), &options).unwrap();
        same(&read(&open_prim(&at.at(name), "/render").unwrap()).unwrap(), &read(&source).unwrap());
    }
}

#[test]
fn files_in_use_go_along() {
    let at = Stages::new();
    fs::create_dir(at.at("tex")).unwrap();
    fs::write(at.at("tex/a.png"), "A").unwrap();
    fs::write(at.at("tex/t.1001.png"), "T").unwrap();
    let extra = "asset primvars:map = @../tex/a.png@\n asset primvars:tiles = @../tex/t.<UDIM>.png@\n\
                 asset primvars:gone = @./gone.png@\n\
                 asset[] primvars:maps = [@../tex/a.png@, @../tex/a.png@] ( interpolation = \"uniform\" )";
    at.usda("part/part.usda", &coat(extra));
    let file = at.usda("coat.usda", "( defaultPrim = \"A\" )\ndef \"A\" (\n references = @./part/part.usda@\n) {}\n");
    let source = open(&file).unwrap();
    fs::create_dir(at.at("out")).unwrap();
    for (name, options) in [("out/o.usda", FORCE), ("out/f.usda", FLATTEN)] {
        tailor(&source, &at.at(name), &options).unwrap();
        let text = fs::read_to_string(at.at(name)).unwrap();
        assert!(text.contains("asset primvars:map = @../tex/a.png@"), "{text}");
        assert!(text.contains("asset primvars:tiles = @../tex/t.<UDIM>.png@"), "{text}");
        assert!(text.contains("asset[] primvars:maps = [@../tex/a.png@, @../tex/a.png@]"), "{text}");
        assert!(!text.contains(at.0.path().to_str().unwrap()), "no path of this machine");
    }
    let warnings = tailor(&source, &at.at("o.usdz"), &FORCE).unwrap();
    assert!(warnings.iter().any(|w| w.contains("gone.png")), "{warnings:?}");
    assert!(!warnings.iter().any(|w| w.contains("a.png") || w.contains("<UDIM>")), "{warnings:?}");
    // The package stands alone, and is an input like any other.
    let elsewhere = Stages::new();
    fs::copy(at.at("o.usdz"), elsewhere.at("o.usdz")).unwrap();
    drop(at);
    let source = open(&elsewhere.at("o.usdz")).unwrap();
    tailor(&source, &elsewhere.at("o.usda"), &FORCE).unwrap();
    let text = fs::read_to_string(elsewhere.at("o.usda")).unwrap();
    assert!(text.contains("subLayers = [@./o.usdz@]") && text.contains("@./o.usdz[0/a.png]@"), "{text}");
    tailor(&source, &elsewhere.at("again.usdz"), &FORCE).unwrap();
    open(&elsewhere.at("again.usdz")).unwrap();
}

#[test]
fn expression_variables_reach_the_layer_that_needs_them() {
    let at = Stages::new();
    at.usda("part.usda", &coat(""));
    let file = at.usda(
        "coat.usda",
        "(\n expressionVariables = { string which = \"part\" }\n)\n\
         def \"A\" (\n references = @`\"./${which}.usda\"`@\n) {}\n",
    );
    tailor(&open(&file).unwrap(), &at.at("o.usda"), &FORCE).unwrap();
    assert_eq!(open(&at.at("o.usda")).unwrap().prim(), "/A/model");
}

/// The material of each face, by name. A face in no set with a material has that of the mesh.
fn materials(garment: &Garment) -> Vec<Option<&String>> {
    let mut all = vec![garment.materials.get(""); garment.face_vertex_counts.len()];
    for subset in garment.subsets.iter().filter(|s| s.element_type == "face") {
        if let Some(material) = garment.materials.get(&subset.name) {
            subset.indices.iter().for_each(|&f| all[f as usize] = Some(material));
        }
    }
    all
}

/// Without materials, and without the set of the faces that have the mesh's own on a product.
fn without_materials(mut garment: Garment) -> Garment {
    garment.materials.clear();
    garment.subsets.retain(|s| s.name != "tailorMaterial");
    garment
}

#[test]
fn garments_come_back() {
    let at = Stages::new();
    for file in garments() {
        let source = Source::open(&file, &ReadOptions::default()).unwrap();
        let input = read(&source).unwrap();
        for (name, options) in [("o.usdc", FORCE), ("f.usda", FLATTEN), ("o.usdz", FORCE)] {
            assert_eq!(tailor(&source, &at.at(name), &options).unwrap(), [""; 0]);
            let render = Path::new(source.prim()).with_file_name("render");
            let again = read(&open_prim(&at.at(name), render.to_str().unwrap()).unwrap()).unwrap();
            assert_eq!(materials(&again), materials(&input), "{}", file.display());
            same(&without_materials(again), &without_materials(input.clone()));
        }
    }
}
