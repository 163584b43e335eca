//! The results of a fit as text and as JSON.

use super::{Done, Fit, Task};
use crate::report::trim_json;
use serde_json::{Value, json};
use tailor_costume::fit::{CrossingCount, FitFigures};
use tailor_usd::{BoundTrim, warning_json};

/// The figures of the garments of one task.
pub fn summary(task: &Task, garments: &[Done]) -> String {
    let mut text = format!("{} -> {}\n", task.input.display(), task.output.display());
    for Done { source, figures, trims, .. } in garments {
        let FitFigures { body_crossings, own_crossings, distance, lengths, angles, .. } = figures;
        let least = distance.least.map(|least| least.map_or_else(|| "far".to_owned(), |least| format!("{least:.4}")));
        let crossings =
            |count: &CrossingCount| format!("{} before, {} after, {} new", count.before, count.after, count.new);
        let rows = [
            ("body", format!("{}, by {}", task.to.display(), source.whole())),
            ("faces through body", crossings(body_crossings)),
            ("faces through faces", crossings(own_crossings)),
            (
                "distance",
                format!(
                    "{} to {} at least, {:.3} to {:.3} on average",
                    least[0], least[1], distance.mean[0], distance.mean[1]
                ),
            ),
            (
                "edges",
                format!(
                    "{:.1} % follow the body within 15 %; {:.2} to {:.2} of their lengths, {:.2} on average",
                    100.0 * figures.edges_kept,
                    lengths[0],
                    lengths[2],
                    lengths[1]
                ),
            ),
            ("angles", format!("{:.1} degrees of change on average, 95 % below {:.1}", angles[0], angles[1])),
        ];
        for (name, value) in rows {
            text += &format!("  {name:<20} {value}\n");
        }
        for BoundTrim { prim, ride, .. } in trims {
            text += &format!("  {:<20} {prim}: {}\n", "trim", ride.in_words());
        }
    }
    text
}

/// Their report.
pub fn in_report(command: &Fit, task: &Task, garments: &[Done]) -> Value {
    let of_garment = |done: &Done| {
        let mut json = json!(done.figures);
        json["prim"] = json!(done.source.whole());
        json["trims"] = done.trims.iter().map(trim_json).collect();
        json["warnings"] = done.warnings.iter().map(warning_json).collect();
        json
    };
    let all: Vec<Value> = garments.iter().map(of_garment).collect();
    with_files(command, task, json!({ "status": "fitted", "garments": all }))
}

/// A report with the files that it is of.
pub fn with_files(command: &Fit, task: &Task, mut report: Value) -> Value {
    for (name, file) in [("input", &task.input), ("from", &command.from), ("to", &task.to), ("output", &task.output)] {
        report[name] = json!(file.display().to_string());
    }
    report
}
