//! Unsaved edits after the end of the program.

use super::*;
use crate::hub::keep::{Keeper, Kept};
use crate::messages::SaveStatus;
use crate::save::save;

/// What a program that opens the garment finds.
fn opened(folder: &Path, file: &Path) -> (Keeper, Arc<Hub>) {
    let stage = Stage::open(&input(file), None).expect("a good garment");
    let (keeper, kept) = Keeper::new(folder, &input(file), &stage);
    let hub = Hub::new(input(file), stage);
    hub.offer(kept);
    (keeper, hub)
}

/// As the end of the program.
fn end(keeper: &Keeper, hub: &Hub) {
    let (revision, unsaved) = hub.unsaved();
    keeper.write(revision, unsaved).expect("it is kept");
}

fn edit(hub: &Hub, level: u32) -> Options {
    let edits = options(&json!({"render": {"level": level}}));
    hub.edit(|document| document.edit(edits.clone(), String::new()));
    edits
}

fn files(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

#[test]
fn unsaved_edits_are_offered_again_until_they_are_answered() {
    let folder = TempDir::new().expect("a folder");
    let (state, file) = (folder.path().join("state/unsaved"), folder.path().join("a.usda"));
    fs::write(&file, sheet(3, "fold")).expect("a file");
    let (keeper, hub) = opened(&state, &file);
    end(&keeper, &hub);
    assert_eq!(files(&state), 0, "nothing to keep");
    let first = edit(&hub, 2);
    end(&keeper, &hub);

    // The next one makes edits of its own before it answers.
    let (keeper, hub) = opened(&state, &file);
    assert!(hub.snapshot().state.edits.is_empty(), "they are offered, and not applied");
    let second = edit(&hub, 1);
    end(&keeper, &hub);

    let (keeper, hub) = opened(&state, &file);
    let (_, unsaved) = hub.unsaved();
    let kept: Vec<&Options> = unsaved.iter().map(|kept| &kept.edits).collect();
    assert_eq!(kept, [&first, &second]);
    hub.answer(unsaved[1].time, false);
    hub.answer(unsaved[0].time, true);
    let now = hub.snapshot();
    assert_eq!(now.state.edits, first);
    assert!(now.state.kept.is_none());
    hub.edit(|document| document.undo());
    assert!(hub.snapshot().state.edits.is_empty(), "the answer is a step of undo");
    hub.edit(|document| document.redo());
    end(&keeper, &hub);
    assert_eq!(files(&state), 1, "they are unsaved still");

    let saved = save(&hub, &folder.path().join("a.tailor").display().to_string(), false);
    assert_eq!(saved.status, SaveStatus::Saved, "{:?}", saved.fault);
    end(&keeper, &hub);
    assert_eq!(files(&state), 0);
}

#[test]
fn an_offer_says_whether_the_options_below_have_changed() {
    let folder = TempDir::new().expect("a folder");
    let (state, file) = (folder.path().join("unsaved"), folder.path().join("a.usda"));
    let text = sheet(3, "fold");
    fs::write(&file, &text).expect("a file");
    let (keeper, hub) = opened(&state, &file);
    edit(&hub, 2);
    end(&keeper, &hub);
    let offer = |hub: &Hub| {
        let now = hub.snapshot();
        now.state.kept.expect("an offer").is_current
    };
    assert!(offer(&opened(&state, &file).1));
    let quads = "        int[] faceVertexCounts";
    let changed = text.replacen(quads, &format!("        uniform int tailor:sim:seed = 7\n{quads}"), 1);
    fs::write(&file, changed).expect("a file");
    assert!(!offer(&opened(&state, &file).1));
}

#[test]
fn a_file_has_the_latest_edits_and_is_of_one_garment_and_recipe() {
    let folder = TempDir::new().expect("a folder");
    let files_of = ["a.usda", "b.usda"].map(|name| folder.path().join(name));
    files_of.iter().for_each(|file| fs::write(file, sheet(3, "fold")).expect("a file"));
    let state = folder.path().join("unsaved");
    let (keeper, hub) = opened(&state, &files_of[0]);
    edit(&hub, 2);
    let (revision, unsaved) = hub.unsaved();
    keeper.write(revision, unsaved.clone()).expect("it is kept");
    let earlier = vec![Kept { edits: Options::new(), ..unsaved[0].clone() }];
    keeper.write(revision - 1, earlier).expect("it is left out");
    assert_eq!(opened(&state, &files_of[0]).1.unsaved().1, unsaved);
    assert_eq!(opened(&state, &files_of[1]).1.unsaved().1, []);
    let recipe = Input { recipe: Some(folder.path().join("c.tailor")), ..input(&files_of[0]) };
    let stage = Stage::open(&input(&files_of[0]), None).expect("a good garment");
    assert_eq!(Keeper::new(&state, &recipe, &stage).1, []);
}

/// A pipe or a device in the place of the file stays, and is not read.
#[cfg(unix)]
#[test]
fn a_pipe_or_a_device_in_the_place_of_the_file_is_left() {
    for make in ["mkfifo", "ln -s /dev/zero"] {
        let folder = TempDir::new().expect("a folder");
        let (state, file) = (folder.path().join("unsaved"), folder.path().join("a.usda"));
        fs::write(&file, sheet(3, "fold")).expect("a file");
        let (keeper, hub) = opened(&state, &file);
        edit(&hub, 2);
        end(&keeper, &hub);
        let kept = fs::read_dir(&state).expect("a folder").next().expect("a file").expect("a file").path();
        fs::remove_file(&kept).expect("a file");
        let script = format!("{make} '{}'", kept.display());
        assert!(std::process::Command::new("sh").args(["-c", &script]).status().expect("a shell").success());
        let (keeper, hub) = opened(&state, &file);
        assert_eq!(hub.unsaved().1, []);
        edit(&hub, 1);
        let (revision, unsaved) = hub.unsaved();
        assert!(keeper.write(revision, unsaved).is_err_and(|e| e.to_string().contains("not a regular file")));
    }
}
