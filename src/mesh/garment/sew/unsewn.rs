//! Borders that lie along each other and do not match edge by edge.

use super::borders::{Border, Edge};
use glam::DVec3;

/// How near the borders are. A border that is split otherwise leaves the other by the sagitta of its edges.
/// \[share of the mean edge length\]
const NEAR: f64 = 0.05;
/// Edges of a leaf of the tree.
const LEAF: usize = 4;

/// Two borders that lie along each other and are not sewn there.
#[derive(Clone, Debug, PartialEq)]
pub struct Unsewn {
    /// The meshes by number, the lower one first.
    pub panels: [usize; 2],
    /// The edges of each of them there, as pairs of points.
    pub edges: [Vec<[usize; 2]>; 2],
    /// A place there. \[units of the common space\]
    pub place: [f64; 3],
}

/// Finds them among the edges that are not sewn.
pub fn find(borders: &[Border], sewn: &[Vec<bool>], tolerance: f64) -> Vec<Unsewn> {
    let trees: Vec<Tree> = borders.iter().zip(sewn).map(|(border, sewn)| Tree::new(border, sewn)).collect();
    let mut found = Vec::new();
    for (a, of_a) in trees.iter().enumerate() {
        for (b, of_b) in trees.iter().enumerate().skip(a + 1) {
            let within = tolerance.max(NEAR) * borders[a].mean_edge.min(borders[b].mean_edge);
            let any = |_: &Edge, _: &Edge| true;
            let edges = [of_a.along(of_b, within, any), of_b.along(of_a, within, any)];
            let Some(first) = edges.iter().find_map(|edges| edges.first()) else { continue };
            let (place, points) = (first.middle().to_array(), |edge: &&Edge| edge.points);
            let edges = edges.each_ref().map(|edges| edges.iter().map(points).collect());
            found.push(Unsewn { panels: [a, b], edges, place });
        }
    }
    found
}

/// The edges of one border that lie along others of it, with which they share no point. Shorter ones than twice the distance are
/// near their neighbours' neighbours, and do not count.
pub fn find_own(border: &Border, sewn: &[bool], tolerance: f64) -> Vec<[usize; 2]> {
    let tree = Tree::new(border, sewn);
    let within = tolerance.max(NEAR) * border.mean_edge;
    let are_apart = |a: &Edge, b: &Edge| a.points.iter().all(|p| !b.points.contains(p));
    let along = tree.along(&tree, within, are_apart);
    along.into_iter().filter(|edge| edge.length() > 2.0 * within).map(|edge| edge.points).collect()
}

/// The edges of a border in halves of halves, with the box of each half.
struct Tree {
    edges: Vec<Edge>,
    /// Boxes in the order in which halves are visited.
    boxes: Vec<[DVec3; 2]>,
}

impl Tree {
    fn new(border: &Border, sewn: &[bool]) -> Self {
        let open = border.edges.iter().zip(sewn).filter(|(_, sewn)| !**sewn).map(|(edge, _)| *edge);
        let mut tree = Self { edges: open.collect(), boxes: Vec::new() };
        let mut edges = std::mem::take(&mut tree.edges);
        tree.halve(&mut edges, 0);
        tree.edges = edges;
        tree
    }

    fn halve(&mut self, edges: &mut [Edge], node: usize) {
        let [low, high] = bounds(edges);
        if self.boxes.len() <= node {
            self.boxes.resize(node + 1, [DVec3::INFINITY, DVec3::NEG_INFINITY]);
        }
        self.boxes[node] = [low, high];
        if edges.len() <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        edges.sort_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.points.cmp(&b.points)));
        let (left, right) = edges.split_at_mut(edges.len() / 2);
        self.halve(left, 2 * node + 1);
        self.halve(right, 2 * node + 2);
    }

    /// The edges that lie along edges of `other` with both ends and the middle, by their points. `counts` says of two edges
    /// whether the second can be that other one.
    fn along(&self, other: &Self, within: f64, counts: impl Fn(&Edge, &Edge) -> bool) -> Vec<&Edge> {
        let ([low, high], [other_low, other_high]) = (self.boxes[0], other.boxes[0]);
        if (other_low - within).cmpgt(high).any() || (low - within).cmpgt(other_high).any() {
            return Vec::new();
        }
        let along = |edge: &&Edge| {
            let is_near = |p: DVec3| other.has_near(p, within, 0, &other.edges, &|found| counts(edge, found));
            [edge.middle(), edge.ends[0], edge.ends[1]].into_iter().all(is_near)
        };
        let mut found: Vec<&Edge> = self.edges.iter().filter(along).collect();
        found.sort_by_key(|edge| edge.points);
        found
    }

    fn has_near(&self, p: DVec3, within: f64, node: usize, edges: &[Edge], counts: &impl Fn(&Edge) -> bool) -> bool {
        let [low, high] = self.boxes[node];
        if p.max(low).min(high).distance(p) > within {
            return false;
        }
        if edges.len() <= LEAF {
            return edges.iter().any(|edge| counts(edge) && distance(edge, p) <= within);
        }
        let (left, right) = edges.split_at(edges.len() / 2);
        self.has_near(p, within, 2 * node + 1, left, counts) || self.has_near(p, within, 2 * node + 2, right, counts)
    }
}

/// The box of some edges; empty for none.
fn bounds(edges: &[Edge]) -> [DVec3; 2] {
    let ends = edges.iter().flat_map(|edge| edge.ends);
    ends.fold([DVec3::MAX, DVec3::MIN], |[low, high], p| [low.min(p), high.max(p)])
}

fn distance(edge: &Edge, p: DVec3) -> f64 {
    let [a, b] = edge.ends;
    let along = (b - a).length_squared();
    let t = if along > 0.0 { ((p - a).dot(b - a) / along).clamp(0.0, 1.0) } else { 0.0 };
    a.lerp(b, t).distance(p)
}
