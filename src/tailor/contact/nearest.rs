//! The element nearest to a point, by a search through a hierarchy of boxes, the nearest boxes first. It takes n log n for all
//! elements, and about log n for each point, however far it is and however many elements coincide.

use super::bvh::{Aabb, Bvh, morton_sorted};
use super::pairs::{TEST, WorkLimit};
use super::simd::WIDTH;
use glam::{DVec3, Vec3, Vec3A};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use tailor_mesh::meter;

/// Radii of all elements to which farther points are pulled in: beyond, differences between distances are lost to rounding.
const FAR: f64 = 1e3;

/// How far a search goes.
#[derive(Clone, Copy)]
pub struct Range {
    /// The largest distance of an element that counts.
    pub reach: f64,
    /// Largest error of distances of elements, by which they may be nearer than their boxes.
    pub error: f64,
}

impl Range {
    const ALL: Self = Self { reach: f64::INFINITY, error: 0.0 };

    /// The least squared distance of elements in a box at a squared distance.
    fn least(self, squared: f64) -> f64 {
        if self.error == 0.0 { squared } else { (squared.sqrt() - self.error).max(0.0).powi(2) }
    }
}

/// A hierarchy of elements by their boxes.
pub struct NearestSearch {
    /// The element in each slot of the hierarchy.
    order: Vec<usize>,
    tree: Bvh,
    /// The lowest element of each node on each level.
    lowest: Vec<Vec<usize>>,
}

impl NearestSearch {
    /// A search among the elements with these boxes.
    pub fn new(boxes: &[Aabb]) -> Self {
        Self::grouped(boxes, |_| 0)
    }

    /// A search among the elements with these boxes, of which each group has nodes of its own.
    pub fn grouped(boxes: &[Aabb], group: impl Fn(usize) -> u64) -> Self {
        let centres: Vec<Vec3A> = boxes.iter().map(|b| 0.5 * b.low + 0.5 * b.high).collect();
        let mut order = morton_sorted(&centres);
        order.sort_by_key(|&i| group(i));
        let tree = Bvh::new(boxes.len(), |slot| boxes[order[slot]]);
        let mut lowest = vec![lowest_of_nodes(&order)];
        while let Some(below) = lowest.last().filter(|below| below.len() > 1) {
            lowest.push(lowest_of_nodes(below));
        }
        Self { order, tree, lowest }
    }

    /// A search among points.
    pub fn of_points(points: &[Vec3]) -> Self {
        let boxes: Vec<Aabb> = points.iter().map(|&p| Aabb::of([p.into()])).collect();
        Self::new(&boxes)
    }

    /// The nearest element to a point, the lowest of equals; none if there are none. `distance` is the squared distance of an
    /// element from a point in the direction of `point`.
    pub fn nearest(&self, point: Vec3, distance: impl FnMut(usize, DVec3) -> f64) -> Option<usize> {
        self.nearest_within(point, Range::ALL, |_, _| true, distance)
    }

    /// The elements whose boxes intersect one, ascending; some of them beyond the bound of `work`.
    pub fn intersecting(&self, aabb: &Aabb, work: &WorkLimit) -> Vec<usize> {
        meter::check();
        let (most, mut found) = (work.left() / TEST + 1, Vec::new());
        self.tree.visit_while(aabb, &mut |slot| {
            found.push(self.order[slot]);
            found.len() < most
        });
        work.take(TEST * found.len());
        found.sort_unstable();
        found
    }

    /// The largest value of the elements of each node, by the height of nodes less 1.
    pub fn largest(&self, value: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let of_nodes = |below: &[f64]| below.chunks(WIDTH).map(|own| own.iter().copied().fold(0.0, f64::max)).collect();
        let mut largest: Vec<Vec<f64>> = vec![of_nodes(&self.order.iter().map(|&i| value(i)).collect::<Vec<f64>>())];
        while let Some(below) = largest.last().filter(|below| below.len() > 1) {
            largest.push(of_nodes(below));
        }
        largest
    }

    /// The nearest element in a range, the lowest of equals, of the nodes that `admits` by their height and number.
    pub fn nearest_within(
        &self,
        point: Vec3,
        range: Range,
        mut admits: impl FnMut(usize, usize) -> bool,
        mut distance: impl FnMut(usize, DVec3) -> f64,
    ) -> Option<usize> {
        let most = range.reach * range.reach;
        let point = self.pulled_in(point.as_dvec3());
        // The bits of distances, which are not negative, sort as the distances do. Elements are on height 0, leaves on 1.
        let mut queue = BinaryHeap::new();
        if !self.order.is_empty() {
            queue.push(Reverse((0, 0, self.lowest.len(), 0)));
        }
        while let Some(Reverse((_, lowest, height, index))) = queue.pop() {
            if height == 0 {
                return Some(lowest);
            }
            let children = if height == 1 { &self.order } else { &self.lowest[height - 2] };
            if !admits(height, index) {
                continue;
            }
            let first = WIDTH * index;
            for (child, &lowest) in children.iter().enumerate().take(first + WIDTH).skip(first) {
                let squared = match height {
                    1 => distance(lowest, point),
                    _ => range.least(squared_distance(&self.tree.box_of(height - 1, child), point)),
                };
                if squared <= most {
                    queue.push(Reverse((squared.to_bits(), lowest, height - 1, child)));
                }
            }
        }
        None
    }

    /// A point in the same direction that is not too far for differences between distances.
    fn pulled_in(&self, point: DVec3) -> DVec3 {
        let bounds = self.tree.bounds();
        let [low, high] = [bounds.low, bounds.high].map(|p| Vec3::from(p).as_dvec3());
        let (middle, most) = (0.5 * (low + high), FAR * 0.5 * low.distance(high));
        let distance = middle.distance(point);
        if distance > most { middle + (point - middle) * (most / distance) } else { point }
    }
}

/// The lowest element of each node over children with these.
fn lowest_of_nodes(children: &[usize]) -> Vec<usize> {
    children.chunks(WIDTH).map(|own| own.iter().copied().fold(usize::MAX, usize::min)).collect()
}

fn squared_distance(aabb: &Aabb, point: DVec3) -> f64 {
    let [low, high] = [aabb.low, aabb.high].map(|p| Vec3::from(p).as_dvec3());
    point.distance_squared(point.clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest of points, and the number of points that were looked at.
    fn search(points: &[Vec3], position: Vec3) -> (Option<usize>, usize) {
        let mut looked_at = 0;
        let found = NearestSearch::of_points(points).nearest(position, |i, from| {
            looked_at += 1;
            points[i].as_dvec3().distance_squared(from)
        });
        (found, looked_at)
    }

    fn sheet(n: usize) -> Vec<Vec3> {
        (0..n * n).map(|i| Vec3::new((i % n) as f32, (i / n) as f32, 0.1 * (i * 7 % 5) as f32)).collect()
    }

    #[test]
    fn it_is_that_of_a_search_of_all_the_lowest_of_equals() {
        let mut points = sheet(30);
        points.extend_from_within(100..300);
        for i in 0..200 {
            let at = Vec3::new((i * 37 % 50) as f32 - 10.0, (i * 17 % 45) as f32 * 0.7, (i % 9) as f32 * 0.3);
            let distance = |p: &Vec3| p.as_dvec3().distance_squared(at.as_dvec3());
            let all = (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
            assert_eq!(search(&points, at).0, all, "{at}");
        }
        assert_eq!(search(&[], Vec3::ZERO).0, None);
    }

    #[test]
    fn few_points_are_looked_at_near_far_and_where_all_coincide() {
        for n in [30, 60, 120] {
            let points = sheet(n);
            for far in [1.0, 1e7 * n as f32, 1e30] {
                let (found, looked_at) = search(&points, Vec3::new(far, 0.3 * far, 0.1 * far));
                assert!(looked_at < 200, "{looked_at} of {} at {far}", points.len());
                let last = (far > n as f32).then_some(n * n - 1);
                assert!(found.is_some() && last.is_none_or(|last| found == Some(last)), "{found:?} at {far}");
            }
            for far in [0.0, 1.0, 1e30] {
                let (found, looked_at) = search(&vec![Vec3::ONE; n * n], Vec3::splat(far));
                assert!(looked_at <= WIDTH && found == Some(0), "{looked_at} at {far}: {found:?}");
            }
        }
    }
}
