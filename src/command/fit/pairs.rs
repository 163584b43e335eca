//! The file of `--pairs`: places that correspond on two bodies.

use crate::usage;
use glam::{DMat4, DVec3};
use std::path::Path;
use tailor_costume::codes;
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_mesh::garment::Mesh;
use tailor_usd::Source;

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

/// The box of a body in the space of its stage.
pub fn bounds(body: &Mesh, to_stage: DMat4) -> [DVec3; 2] {
    let points = || body.faces.corners().iter().map(|v| to_stage.transform_point3(body.points[*v].as_dvec3()));
    [points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

/// Lengths of other units in that of a stage, the likeliest first.
const UNITS: [f64; 11] = [1.0, 0.01, 100.0, 0.001, 1000.0, 0.1, 10.0, 0.0254, 1.0 / 0.0254, 0.3048, 1.0 / 0.3048];
/// How far from the box of its body a point may be, and how small all of them may be at least, as shares of the body's size.
const REACH: f64 = 0.25;
const LEAST_SPREAD: f64 = 0.02;
/// Share of the points that may be farther away, and how much the spreads on the two bodies may differ.
const MOST_AWAY: f64 = 0.1;
const MOST_RATIO: f64 = 4.0;

/// Refuses pairs whose points are not at the bodies, in boxes of their stages, and tells the unit and the up axis in which they would be.
///
/// # Errors
/// Such pairs.
pub fn check(file: &Path, pairs: &[[DVec3; 2]], bodies: &[Source; 2], boxes: &[[DVec3; 2]; 2]) -> Result<(), Error> {
    let sides = [0, 1].map(|side| pairs.iter().map(|pair| pair[side]).collect::<Vec<_>>());
    if agree(&sides, boxes) {
        return Ok(());
    }
    let fault = |text: String, remedy: String| {
        let fault = Error::new(ErrorKind::Mesh, format!("--pairs {}", file.display()), text);
        Err(fault.code(codes::BODIES_DIFFER).remedy(remedy))
    };
    let is_z_up = |side: usize| bodies[side].facts().up_axis == "Z";
    let changed = |side: usize, turns: bool, unit: f64| {
        let turned = |p: DVec3| if is_z_up(side) { DVec3::new(p.x, -p.z, p.y) } else { DVec3::new(p.x, p.z, -p.y) };
        sides[side].iter().map(|&p| unit * if turns { turned(p) } else { p }).collect::<Vec<_>>()
    };
    let units = UNITS.into_iter().flat_map(|unit| [(false, unit), (true, unit)]);
    let mut changes = units.flat_map(|(turns, unit)| [[1].as_slice(), &[0], &[0, 1]].map(|of| (of, turns, unit)));
    let fits = |&(of, turns, unit): &(&[usize], bool, f64)| {
        let all = [0, 1].map(|side| if of.contains(&side) { changed(side, turns, unit) } else { sides[side].clone() });
        agree(&all, boxes)
    };
    if let Some((of, turns, unit)) = changes.find(fits) {
        let (side, body) = (of[0], &bodies[of[0]]);
        let space = |turns: bool, unit: f64| {
            let up = if is_z_up(side) != turns { "Z" } else { "Y" };
            format!("a unit of {} m and {up} up", unit * body.facts().meters_per_unit)
        };
        let which = ["first points are", "second points are", "points are"][if of.len() == 2 { 2 } else { side }];
        let text = format!("its {which} not at {}, whose stage has {}", body.file().display(), space(false, 1.0));
        return fault(text, format!("they fit in {}: convert them to the space of the stage", space(turns, unit)));
    }
    match (0..2).find(|&side| spread(&sides[side], boxes[side]).is_none()) {
        Some(side) => fault(
            format!("its {} points are not at {}", ["first", "second"][side], bodies[side].file().display()),
            "write each point in the space and unit of its body's stage".to_owned(),
        ),
        None => Ok(()),
    }
}

/// Whether points of two bodies are at these, and about as large beside each of them.
fn agree(sides: &[Vec<DVec3>; 2], boxes: &[[DVec3; 2]; 2]) -> bool {
    let [first, second] = [0, 1].map(|side| spread(&sides[side], boxes[side]).unwrap_or(0.0));
    first.min(second) >= LEAST_SPREAD && first.max(second) <= MOST_RATIO * first.min(second)
}

/// The size of points as a share of that of a body; none if they are not at it.
fn spread(points: &[DVec3], [low, high]: [DVec3; 2]) -> Option<f64> {
    let (size, middle) = (high.distance(low), (low + high) / 2.0);
    let reach = (high - low) / 2.0 + REACH * size;
    let away = points.iter().filter(|p| (**p - middle).abs().cmpgt(reach).any()).count();
    let [low, high] = [DVec3::min, DVec3::max].map(|f| points.iter().copied().reduce(f).unwrap_or_default());
    (away as f64 <= MOST_AWAY * points.len() as f64).then(|| high.distance(low) / size)
}
