//! Threads along paths: stitches of equal length from corner to corner, each with the points of its pattern.

use super::ground::Ground;
use super::path::SurfacePath;
use super::pattern::{PatternPoint, StitchPattern};
use glam::Vec3;

/// Curves that are threads: Catmull-Rom splines whose first and last points are not on the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Threads {
    /// The number of points of each curve.
    pub counts: Vec<u32>,
    /// The points.
    pub points: Vec<Vec3>,
    /// The normal of the surface below each point.
    pub normals: Vec<Vec3>,
    /// The place of each point along its thread. \[stitches\]
    pub along: Vec<f32>,
    /// The number of stitches, without those that are sewn back and forth again.
    pub stitches: usize,
    /// The length of the lines that have them. \[mesh units\]
    pub length: f32,
}

/// The sizes of stitches.
#[derive(Clone, Copy, Debug)]
pub struct StitchSizes {
    /// Length of a stitch. \[mesh units\]
    pub stitch: f32,
    /// Width across the line. \[mesh units\]
    pub width: f32,
    /// Diameter of the thread. \[mesh units\]
    pub thread: f32,
    /// How deep it sinks, from 0 to 1.
    pub tension: f32,
    /// Stitches that are sewn back and forth again at open ends.
    pub back_tack: u32,
}

impl Threads {
    /// Adds the threads along a path.
    pub fn sew(&mut self, path: &SurfacePath, pattern: &StitchPattern, sizes: StitchSizes, ground: &Ground) {
        let holes = holes(path, sizes.stitch, pattern.period);
        if holes.len() < 2 {
            return;
        }
        let count = holes.len() - 1;
        self.stitches += count;
        self.length += path.length();
        let tack = if path.is_closed { 0 } else { sizes.back_tack.min(count as u32) as usize };
        let line = SewnLine { path, holes: &holes, sizes, ground, flip: flip(path, pattern, sizes, ground) };
        for thread in pattern.threads {
            let periods = count as f32 / pattern.period;
            let forth = (0..periods.ceil() as usize).flat_map(|period| {
                let start = period as f32 * pattern.period;
                thread.iter().map(move |&[u, v, h]| [start + u, v, h])
            });
            let last = [count as f32, thread[0][1], thread[0][2]];
            let forth: Vec<PatternPoint> =
                forth.filter(|point| point[0] < count as f32).chain((!path.is_closed).then_some(last)).collect();
            let back = |from: f32, to: f32| {
                let beside = sizes.thread / sizes.width.max(sizes.thread);
                let among = forth.iter().filter(move |point| (from..=to).contains(&point[0]));
                among.rev().map(move |&[u, v, h]| [u, v + 0.5 * beside, h])
            };
            let (tack, end) = (tack as f32, count as f32);
            let before = (tack > 0.0).then(|| back(0.5, tack)).into_iter().flatten();
            let after = (tack > 0.0).then(|| back(end - tack, end - 0.5)).into_iter().flatten();
            let walked: Vec<PatternPoint> = before.chain(forth.iter().copied()).chain(after).collect();
            self.add(&line, &walked);
        }
    }

    /// Adds a curve through the points of a thread.
    fn add(&mut self, line: &SewnLine, walked: &[PatternPoint]) {
        let (Some(first), Some(last)) = (walked.first(), walked.last()) else { return };
        let is_closed = line.path.is_closed;
        let (before, after) = if is_closed { (last, first) } else { (first, last) };
        let closing = walked.get(1).filter(|_| is_closed);
        let all = std::iter::once(before).chain(walked).chain([after]).chain(closing);
        let start = self.points.len();
        for point in all {
            let (at, normal) = line.place(*point);
            self.points.push(at);
            self.normals.push(normal);
            self.along.push(point[0]);
        }
        self.counts.push((self.points.len() - start) as u32);
    }
}

/// The lengths up to the holes of the needle: at the ends and corners of a path, and evenly between them. A closed path has whole periods.
fn holes(path: &SurfacePath, stitch: f32, period: f32) -> Vec<f32> {
    let mut ends = vec![0.0];
    ends.extend(path.corners());
    ends.push(path.length());
    let mut holes = vec![0.0];
    for pair in ends.windows(2) {
        let length = pair[1] - pair[0];
        let per = if path.is_closed && ends.len() == 2 { period } else { 1.0 };
        let count = per * (length / (per * stitch)).round().max(1.0);
        holes.extend((1..=count as usize).map(|hole| pair[0] + length * hole as f32 / count));
    }
    if path.length() > 0.0 { holes } else { Vec::new() }
}

/// Whether a pattern is turned over, so that its left is on the cloth: at borders the cloth may be on the right alone.
fn flip(path: &SurfacePath, pattern: &StitchPattern, sizes: StitchSizes, ground: &Ground) -> bool {
    let off = |side: f32| {
        let reach = 0.5 * sizes.width;
        let shares = [0.25, 0.5, 0.75].map(|share| path.frame(share * path.length(), sizes.stitch));
        let points = shares.map(|frame| frame.point + side * reach * frame.left);
        points.into_iter().filter_map(|point| Some(ground.below(point)?.0.distance(point))).sum::<f32>()
    };
    let is_wide = pattern.threads.iter().flat_map(|thread| *thread).any(|point| point[1] != 0.0);
    is_wide && off(1.0) > off(-1.0) + 0.1 * sizes.width
}

/// A path with its holes.
struct SewnLine<'a> {
    path: &'a SurfacePath,
    holes: &'a [f32],
    sizes: StitchSizes,
    ground: &'a Ground,
    flip: bool,
}

impl SewnLine<'_> {
    /// The position of a point of a thread, and the normal of the surface below it.
    fn place(&self, [along, across, above]: PatternPoint) -> (Vec3, Vec3) {
        let stitch = (along.max(0.0) as usize).min(self.holes.len() - 2);
        let [from, to] = [self.holes[stitch], self.holes[stitch + 1]];
        let frame = self.path.frame(from + (along - stitch as f32) * (to - from), to - from);
        let across = if self.flip { -across } else { across };
        let off = across * self.sizes.width.max(self.sizes.thread);
        let on_line = (frame.point, frame.normal);
        let beside = || self.ground.below(frame.point + off * frame.left).unwrap_or(on_line);
        let (point, normal) = if off == 0.0 { on_line } else { beside() };
        let above = if above > 0.0 { above * (1.0 - self.sizes.tension) } else { above };
        (point + above * self.sizes.thread * normal, normal)
    }
}
