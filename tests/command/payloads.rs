//! Options below a payload of a `.tailor` file, which no part of OpenUSD shows to the file format.

use crate::cloth::CLOTH;
use crate::folder::Folder;

/// A stage with a payload, and options on it and below it.
const SHOT: &str = r#"#usda 1.0

def Xform "Shot"
{
    def Xform "Coat" (
        payload = @coat.tailor:SDF_FORMAT_ARGS:sim.iterations=2@
    )
    {
        int tailor:render:level = 2

        over "model"
        {
            int tailor:render:level = 3
            rel tailor:seam:side:edges = </Shot/Coat/model/placket>
            float tailor:seam:side:width = 0.1

            over "placket"
            {
                float tailor:sharpness = 2
            }
        }
    }

    def Xform "Other"
    {
        int tailor:render:level = 3
    }
}
"#;

fn shot() -> Folder {
    let folder = Folder::new();
    folder.file("coat.usda", CLOTH);
    folder.file("coat.tailor", "{\"source\": \"coat.usda\"}");
    folder.file("shot.usda", SHOT);
    folder
}

#[test]
fn options_below_a_payload_are_named_with_their_place() {
    let folder = shot();
    for command in ["check", "info"] {
        let run = folder.run(&format!("{command} shot.usda -v"));
        run.says(&[
            "warning[misplaced-option]: /Shot/Coat/model.tailor:render:level: not read: it is below /Shot/Coat, whose payload is \
             coat.tailor (fault)\n  hint: Author it on /Shot/Coat\n",
            "/Shot/Coat/model.tailor:seam:side:edges: not read",
            "Author it on /Shot/Coat as token[] with the names of the sets, with the schema TailorSeamAPI:side\n",
            "/Shot/Coat/model.tailor:seam:side:width: not read",
            "Author it on /Shot/Coat, with the schema TailorSeamAPI:side\n",
        ]);
        assert_eq!(run.stderr.matches("misplaced-option").count(), 3, "{run}");
    }
    // The garment itself is in the `.tailor` file.
    folder.good("info shot.usda").prints(&["coat.usda /Coat/model", "payload  of /Shot/Coat", "  sim  ", "  render  "]);
    assert!(folder.good("info shot.usda --json").stdout.contains("\"payload\": \"/Shot/Coat\""));
}

#[test]
fn a_garment_that_comes_by_a_payload_is_checked() {
    let folder = shot();
    let run = folder.good("check shot.usda");
    assert!(
        run.stdout.contains("shot.usda: good\n  /Shot/Coat from ") && run.stdout.contains("coat.tailor: good; "),
        "{run}"
    );
    // In a folder of its own, below a layer that names it.
    std::fs::create_dir(folder.at("parts")).expect("a folder");
    folder.file("parts/shot.usda", SHOT.replace("@coat.tailor", "@../coat.tailor"));
    folder.file("top.usda", "#usda 1.0\n(\n    subLayers = [@parts/shot.usda@]\n)\n");
    folder.good("check top.usda");

    folder.file("coat.tailor", "{\"source\": \"coat.usda\", \"sim\": {\"iterations\": -1}}");
    let run = folder.run("check shot.usda");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["coat.tailor: invalid value"]);
    folder.file("coat.tailor", "{\"source\": \"coat.usda\"}");
    folder.file(
        "torn.usda",
        SHOT.replace("def Xform \"Other\"", "def Xform \"Other\" (\n        references = @gone.usda@\n    )"),
    );
    let run = folder.run("check torn.usda");
    assert_eq!(run.code, Some(1), "{run}");
    run.says(&["gone.usda"]);
}

#[test]
fn a_garment_beside_a_payload_is_checked_with_the_warning() {
    let folder = shot();
    folder.file("both.usda", "#usda 1.0\n(\n subLayers = [@shot.usda@, @coat.usda@]\n)\n");
    folder.good("check both.usda").says(&["warning[misplaced-option]: /Shot/Coat/model.tailor:render:level"]);
    let run = folder.good("check coat.usda coat.tailor");
    assert!(!run.stderr.contains("misplaced-option"), "{run}");
}
