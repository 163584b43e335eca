//! The file of `--pairs`: places that correspond on two bodies.

use crate::usage;
use glam::DVec3;
use std::path::Path;
use tailor_mesh::error::{Error, plain};

/// The pairs of points in a file: six numbers to a line, of each body in the space of its stage.
///
/// # Errors
/// A file that cannot be read, and a line of other content.
pub fn read(file: &Path) -> Result<Vec<[DVec3; 2]>, Error> {
    let place = || format!("--pairs {}", file.display());
    let text = std::fs::read_to_string(file).map_err(|e| {
        let fault =
            usage(place(), format!("it cannot be read: {}", plain(&e))).code(tailor_usd::codes::UNREADABLE_FILE);
        fault.remedy("name a text file that you may read").caused_by(e)
    })?;
    let is_data = |(_, line): &(usize, &str)| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let pair = |(number, line): (usize, &str)| {
        let words = line.split(|letter: char| letter.is_whitespace() || letter == ',').filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok().filter(|n: &f64| n.is_finite())).collect();
        let Some(&[a, b, c, d, e, f]) = numbers.as_deref() else {
            let fault = usage(place(), format!("line {} has not six numbers", number + 1))
                .code(tailor_mesh::codes::COMMAND_LINE);
            return Err(fault.remedy("write a point of each body on each line: x y z x y z"));
        };
        Ok([DVec3::new(a, b, c), DVec3::new(d, e, f)])
    };
    text.lines().enumerate().filter(is_data).map(pair).collect()
}
