//! The shipped examples, and the layer that the documents print.

use crate::cloth::CLOTH;
use crate::folder::Folder;
use std::path::Path;

/// The text of a file of the project.
fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn examples_are_listed_and_written_with_their_recipe() {
    let folder = Folder::new();
    folder.good("example").prints(&["tshirt ", "trousers ", "coat ", "picture "]);
    let run = folder.good("example tshirt");
    assert_eq!(run.stdout, "tshirt.tailor\ntshirt.usda\n");
    for file in ["tshirt.tailor", "tshirt.usda"] {
        assert_eq!(folder.text(file), shipped(&format!("examples/{file}")));
    }
    folder.good("info tshirt.tailor").prints(&["seam     side: side_seams", "fold     neck_hem: neckband"]);
    folder.good("example trousers -o new/folder");
    folder.good("info new/folder/trousers.tailor").prints(&["seam     inseam: inseam", "fold     waist: waistband"]);
    // The layer finds the coat that it is over.
    folder.good("example coat -o coat");
    folder.good("info coat/sewn/coat.usda").prints(&["/Coat/model", "seam     placket"]);
}

#[test]
fn recipes_of_examples_build_without_a_warning_of_sets() {
    let folder = Folder::new();
    folder.good("example trousers");
    let run = folder.good("build trousers.tailor -o out/trousers.usdc");
    run.prints(&["3 operators: fold.waist, seam.inseam, seam.side"]);
    for code in ["bare-faces", "intersections", "operators-left-out"] {
        assert!(!run.stderr.contains(code), "{run}");
    }
}

#[test]
fn an_example_replaces_no_other_file() {
    let folder = Folder::new();
    folder.good("example tshirt -o out");
    folder.good("example tshirt -o out");
    folder.file("out/tshirt.tailor", "{}");
    let run = folder.run("example tshirt -o out");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["error[output-exists]: out/tshirt.tailor exists already", "--force"]);
    assert_eq!(folder.text("out/tshirt.tailor"), "{}");
    folder.good("example tshirt -o out --force");
    assert_eq!(folder.text("out/tshirt.tailor"), shipped("examples/tshirt.tailor"));
    #[cfg(unix)]
    {
        std::fs::remove_file(folder.at("out/tshirt.tailor")).expect("a file");
        folder.file("precious.tailor", "{}");
        std::os::unix::fs::symlink("../precious.tailor", folder.at("out/tshirt.tailor")).expect("a link");
        let run = folder.run("example tshirt -o out --force");
        assert_eq!((run.code, folder.text("precious.tailor").as_str()), (Some(1), "{}"), "{run}");
        run.says(&["out/tshirt.tailor is a link to another file", "remove the link"]);
    }
    let run = folder.run("example thsirt");
    assert_eq!(run.code, Some(2), "{run}");
    run.says(&["there is no example \"thsirt\"", "did you mean tshirt?"]);
}

#[test]
fn the_layer_of_the_documents_gives_an_edge_set() {
    let folder = Folder::new();
    folder.file("coat.usda", CLOTH);
    let page = shipped("docs/sets.md");
    let layer = page.split("```usda\n").nth(1).and_then(|rest| rest.split("```").next()).expect("the layer");
    folder.file("coat_sets.usda", layer);
    folder.good("info coat_sets.usda").prints(&["subset   side_seam of 2 edges, family edges"]);
    let (_, after) = page.split_once("Then build the layer: `usdtailor ").expect("the command");
    let command = after.split('`').next().expect("its end").replace('\n', " ");
    folder.good(&command).prints(&["1 operator: seam.side"]);
}
