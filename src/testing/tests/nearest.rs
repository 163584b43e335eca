//! The nearest of some triangles, segments or points, by a tree of boxes; independent of the code under test.

use glam::Vec3;
use tailor::sim::closest_weights;

/// Triangles below which a box is not divided further.
const LEAF: usize = 4;

struct Node {
    low: Vec3,
    high: Vec3,
    /// First triangle and their number in a leaf; the second child and 0 in others, whose first child follows them.
    first: u32,
    count: u32,
}

/// A tree over triangles; a segment has its last two corners in one place, a point all three.
pub struct Nearest {
    /// Each with its number.
    triangles: Vec<(usize, [Vec3; 3])>,
    nodes: Vec<Node>,
}

impl Nearest {
    pub fn new(triangles: Vec<[Vec3; 3]>) -> Self {
        let mut triangles: Vec<_> = triangles.into_iter().enumerate().collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        let count = triangles.len();
        build(&mut triangles, 0, count, &mut nodes);
        Self { triangles, nodes }
    }

    /// The nearest triangle, and its distance.
    pub fn find(&self, p: Vec3) -> (usize, f32) {
        let (mut found, mut best) = (0, f32::MAX);
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at) else { continue };
            if p.distance_squared(p.clamp(node.low, node.high)) >= best {
                continue;
            }
            if node.count > 0 {
                for &(number, [a, b, c]) in &self.triangles[node.first as usize..][..node.count as usize] {
                    let w = closest_weights(a, b, c, p);
                    let distance = p.distance_squared(a * w.x + b * w.y + c * w.z);
                    if distance < best {
                        (found, best) = (number, distance);
                    }
                }
                continue;
            }
            let (left, right) = (at + 1, node.first as usize);
            let far = |i: usize| p.distance_squared(p.clamp(self.nodes[i].low, self.nodes[i].high));
            let order = if far(left) <= far(right) { [right, left] } else { [left, right] };
            stack.extend(order);
        }
        (found, best.sqrt())
    }
}

fn build(triangles: &mut [(usize, [Vec3; 3])], start: usize, end: usize, nodes: &mut Vec<Node>) {
    let own = &mut triangles[start..end];
    let (low, high) =
        own.iter().flat_map(|t| t.1).fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(p), high.max(p)));
    let at = nodes.len();
    nodes.push(Node { low, high, first: start as u32, count: own.len() as u32 });
    if own.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let middle = own.len() / 2;
    let key = |(_, t): &(usize, [Vec3; 3])| t[0][axis] + t[1][axis] + t[2][axis];
    own.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    build(triangles, start, start + middle, nodes);
    let second = nodes.len() as u32;
    build(triangles, start + middle, end, nodes);
    nodes[at].first = second;
    nodes[at].count = 0;
}
