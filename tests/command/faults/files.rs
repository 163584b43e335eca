//! Faults of the input file, and of the choice of a mesh in it.

use super::{each_is_told, fault};
use crate::cloth::CLOTH;
use crate::folder::Folder;

/// The cloth as a crate, as the command itself writes it.
fn crate_file(folder: &Folder) -> Vec<u8> {
    folder.file("cloth.usda", CLOTH);
    folder.good("build cloth.usda -o cloth.usdc --flatten --keep-model-purpose -q");
    let bytes = folder.read("cloth.usdc");
    for made in ["cloth.usda", "cloth.usdc"] {
        std::fs::remove_file(folder.at(made)).expect("a file that was just written");
    }
    bytes
}

/// A stage of two prims.
fn two(first: &str, second: &str) -> String {
    let mesh =
        CLOTH.split_once("    def Mesh").and_then(|(_, rest)| rest.rsplit_once('}')).expect("the cloth has a mesh");
    let body = |name: &str| format!("    def {name}{}", &mesh.0[" \"model\"".len()..]);
    format!("#usda 1.0\ndef Xform \"Coat\"\n{{\n{}\n{}\n}}\n", body(first), body(second))
}

#[test]
fn of_the_file() {
    each_is_told(&[
        fault("build in.usda -o out/coat.usda", |_| {}, &["cannot read in.usda: no such file", "check the path"]),
        fault("check in.usda", |_| {}, &["cannot read in.usda: no such file"]),
        fault("info nowhere/in.usda", |_| {}, &["cannot read nowhere/in.usda: no such file"]),
        fault(
            "build folder.usda -o out/coat.usda",
            |f| std::fs::create_dir(f.at("folder.usda")).expect("a folder"),
            &["folder.usda is a folder", "name a file inside it"],
        ),
        fault(
            "build in.usda -o out/coat.usda",
            |f| f.file("in.usda", ""),
            &["in.usda is empty", "export the garment again"],
        ),
        fault("build in.usdc -o out/coat.usda", |f| f.file("in.usdc", ""), &["in.usdc is empty"]),
        fault(
            "build in.usda -o out/coat.usda",
            |f| f.file("in.usda", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
            &["in.usda cannot be read as USD", "export it again"],
        ),
        fault(
            "build in.obj -o out/coat.usda",
            |f| f.file("in.obj", "v 0 0 0\n"),
            &["in.obj is not a USD file", "export the garment as USD"],
        ),
        fault(
            "build in.usdc -o out/coat.usda",
            |f| {
                f.file(
                    "in.usdc",
                    (0..4096u32).flat_map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect::<Vec<u8>>(),
                );
            },
            &["in.usdc cannot be read as USD", "damaged"],
        ),
        fault(
            "build in.usdz -o out/coat.usda",
            |f| f.file("in.usdz", b"PK\x03\x04 and no more"),
            &["in.usdz cannot be read as USD"],
        ),
        fault(
            "build in.usda -o out/coat.usda",
            |f| f.file("in.usda", CLOTH.replacen("4, 4]", "4, 4", 1)),
            &["in.usda cannot be read as USD", "in.usda:16:9", "export it again"],
        ),
        fault(
            "build in.usda -o out/coat.usda",
            |f| f.file("in.usda", &CLOTH[..CLOTH.len() / 2]),
            &["in.usda cannot be read as USD"],
        ),
        fault(
            "build in.usda -o out/coat.usda",
            |f| f.file("in.usda", [CLOTH.as_bytes(), b"\xff\xfe"].concat()),
            &["in.usda cannot be read as USD"],
        ),
    ]);
}

#[test]
fn of_a_truncated_crate() {
    // The header, the table of contents, and everything between.
    for share in [1, 10, 30, 50, 70, 90, 99] {
        let make = move |folder: &Folder| {
            let whole = crate_file(folder);
            folder.file("in.usdc", &whole[..whole.len() * share / 100]);
        };
        each_is_told(&[fault(
            "build in.usdc -o out/coat.usda",
            make,
            &["in.usdc cannot be read as USD", "export it again"],
        )]);
    }
}

#[test]
fn of_the_choice_of_a_mesh() {
    let meshes = |f: &Folder| f.file("in.usda", two("Mesh \"shirt\"", "Mesh \"tie\""));
    let cloth = |f: &Folder| f.file("in.usda", CLOTH);
    const ARGS: &str = "build in.usda -o out/coat.usda";
    each_is_told(&[
        fault(
            ARGS,
            |f| f.file("in.usda", "#usda 1.0\ndef Xform \"Coat\" {}\n"),
            &["in.usda holds no mesh", "of type Mesh"],
        ),
        fault(ARGS, |f| f.file("in.usda", "#usda 1.0\n"), &["in.usda holds no mesh"]),
        fault(
            ARGS,
            |f| f.file("in.usda", CLOTH.replace("def Mesh", "over \"x\" {} class Mesh")),
            &["in.usda holds no mesh"],
        ),
        fault(ARGS, meshes, &["in.usda holds 2 meshes", ".tailor file: /Coat/shirt, /Coat/tie"]),
        fault(
            "build in.usda -o out/coat.usda --prim /Coat/hat",
            cloth,
            &["in.usda has no prim /Coat/hat", "/Coat/model"],
        ),
        fault(
            "build in.usda -o out/coat.usda --prim /Rail",
            |f| f.file("in.usda", CLOTH.replacen("def Xform", "def Xform \"Rail\" {}\n\ndef Xform", 1)),
            &["/Rail is Xform, not a Mesh", "/Coat/model"],
        ),
        fault(
            "build in.usda -o out/coat.usda --prim Coat//model",
            cloth,
            &["prim \"Coat//model\" is not the path of a prim", "/Coat/model"],
        ),
        fault("check in.usda --prim /", cloth, &["prim \"/\" is not the path of a prim"]),
        fault("info in.usda --prim /Coat/model.points", cloth, &["is not the path of a prim"]),
        fault(
            ARGS,
            |f| {
                f.file(
                    "in.usda",
                    CLOTH
                        .replace("point3f[] points = [", "point3f[] points.timeSamples = { 3: [")
                        .replace("(2, 2, 0)]", "(2, 2, 0)], 4: [(0, 0, 0)] }"),
                );
            },
            &["/Coat/model.points has values at 2 times and no default", "--time 3"],
        ),
        fault("build in.usda -o out/coat.usda --time nan", cloth, &["the time is not a number", "24.5"]),
        fault(
            ARGS,
            |f| f.file("in.usda", "#usda 1.0\ndef Xform \"Coat\" (\n references = @gone.usda@\n)\n{\n}\n"),
            &["in.usda holds no mesh", "gone.usda"],
        ),
    ]);
}
