//! The same bytes, whatever the number of threads and however often.

use crate::folder::Folder;
use serde_json::Value;
use std::path::Path;
use tailor_testing::garments::garments;

/// The output and the report, without what differs by nature: times.
fn build(garment: &Path, threads: u32) -> (Vec<u8>, Value) {
    let folder = Folder::new();
    let mut command = folder.command("build -o out/coat.usdc --flatten --report out/report.json -q");
    let done = command.args(["--threads", &threads.to_string()]).arg(garment).output().expect("the command starts");
    assert!(done.status.success(), "{}: {}", garment.display(), String::from_utf8_lossy(&done.stderr));
    let mut report: Value = serde_json::from_slice(&folder.read("out/report.json")).expect("JSON");
    for stage in report["stages"].as_array_mut().expect("stages") {
        stage["seconds"] = Value::Null;
    }
    (folder.read("out/coat.usdc"), report)
}

#[test]
fn any_number_of_threads_gives_the_same_bytes_on_garments() {
    for garment in garments() {
        let (bytes, report) = build(&garment, 1);
        // Twice with one thread: a second run is the same too.
        for threads in [1, 2, 8] {
            let (others, other_report) = build(&garment, threads);
            assert!(bytes == others, "{}: other bytes at {threads} threads", garment.display());
            assert_eq!(report, other_report, "{}: another report at {threads} threads", garment.display());
        }
    }
}
