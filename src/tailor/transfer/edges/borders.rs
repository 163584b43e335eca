//! The part of an edge set that bounds face sets: the border of these on the simulation mesh, edge for edge.

use super::chains::Chains;
use crate::sim::distance_to_segment;
use crate::transfer::correspondence::Correspondence;
use crate::transfer::faces::FaceSets;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology};
use tailor_mesh::garment::{Elements, Mesh};

/// For each face the set that it is in; none outside of all.
type Labels = IdVec<FaceId, Option<usize>>;
/// The labels on both sides of an edge, the lower first.
type Sides = [Option<usize>; 2];
/// The edges of the simulation mesh along each cage edge that bounds a set.
type BorderEdges = BTreeMap<EdgeId, Vec<EdgeId>>;

/// The borders of groups of face sets, whose sets do not overlap.
pub(super) struct Borders(Vec<BorderEdges>);

impl Borders {
    /// The borders of the groups that have a cage edge of `wanted` on them; others are empty.
    pub fn new(
        garment: &Mesh,
        map: &Correspondence<'_>,
        sets: &FaceSets,
        chains: &Chains<'_>,
        wanted: &FxHashSet<EdgeId>,
    ) -> Self {
        let border = |group: &Vec<usize>| {
            let cage = map.coverage.source_area.len();
            let of_source = labels(cage, group.iter().map(|&i| (i, source_faces(garment, i))));
            let border = Border { map, chains, of_source };
            match wanted.iter().any(|&edge| border.cage_sides(edge).is_some()) {
                true => border.edges(group.iter().map(|&i| (i, sets.sets[i].as_slice()))),
                false => BorderEdges::new(),
            }
        };
        Self(sets.groups.par_iter().map(border).collect())
    }

    /// The groups with one of some cage edges on their border, those with the most first.
    pub fn ranked(&self, edges: &[EdgeId]) -> Vec<usize> {
        let count = |group: &BorderEdges| edges.iter().filter(|edge| group.contains_key(edge)).count();
        let mut counts: Vec<(usize, usize)> = self.0.iter().map(count).enumerate().filter(|c| c.1 > 0).collect();
        counts.sort_by_key(|&(group, count)| (std::cmp::Reverse(count), group));
        counts.into_iter().map(|c| c.0).collect()
    }

    /// The edges of the simulation mesh along a cage edge on the border of a group; none if it is on no border of it.
    pub fn along(&self, group: usize, edge: EdgeId) -> Option<&[EdgeId]> {
        self.0[group].get(&edge).map(Vec::as_slice)
    }
}

/// The border of one group.
struct Border<'a> {
    map: &'a Correspondence<'a>,
    chains: &'a Chains<'a>,
    of_source: Labels,
}

impl Border<'_> {
    /// The edges of the simulation mesh between two sets, along the nearest cage edge between sets: where there is
    /// one, on a chain as they are, and between the same sets.
    fn edges<'s>(&self, sets: impl Iterator<Item = (usize, &'s [FaceId])>) -> BorderEdges {
        let cage = &self.map.product.baseline.manifold.level.topology;
        let bounds = |edge: &EdgeId| self.cage_sides(*edge).is_some();
        let mut edges: BorderEdges = cage.edges.ids().filter(bounds).map(|edge| (edge, Vec::new())).collect();
        let t = &self.map.mesh.topology;
        let of_sim = labels(t.faces.len(), sets);
        let mut is_chain: FxHashMap<EdgeId, bool> = FxHashMap::default();
        for edge in t.edges.ids() {
            let Some(own) = sides(t, edge, &of_sim) else { continue };
            let mut is_chain =
                |e: EdgeId| *is_chain.entry(e).or_insert_with(|| self.chains.of_edge(cage.edges[e]).is_some());
            let near = self.near(edge).into_iter().filter_map(|e| Some((e, self.cage_sides(e)?)));
            let mut key = |(e, other): (EdgeId, Sides)| {
                // The bits of distances, which are not negative, sort as the distances do.
                let distance = self.distance(edge, e).to_bits();
                (is_chain(e) != self.map.mesh.is_chain[edge], other != own, distance, e)
            };
            if let Some(along) = near.map(&mut key).min().and_then(|key| edges.get_mut(&key.3)) {
                along.push(edge);
            }
        }
        edges
    }

    /// The labels on the sides of a cage edge that bounds a set. A border has one side.
    fn cage_sides(&self, edge: EdgeId) -> Option<Sides> {
        sides(&self.map.product.baseline.manifold.level.topology, edge, &self.of_source)
    }

    /// The edges of the garment's faces under the faces beside an edge.
    fn near(&self, edge: EdgeId) -> Vec<EdgeId> {
        let (t, cage) = (&self.map.mesh.topology, &self.map.product.baseline.manifold.level.topology);
        let mut found: Vec<EdgeId> = Vec::with_capacity(16);
        for face in faces(t, edge) {
            let covered = self.map.coverage.sources.row(face).iter().map(|c| c.face);
            let covered = covered.chain([self.map.source_under(face)]);
            found.extend(covered.flat_map(|f| cage.faces.corners_of(f)).map(|c| cage.corner_edge[c]));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Distance of the middle of an edge from a cage edge. \[mesh units\]
    fn distance(&self, edge: EdgeId, cage_edge: EdgeId) -> f32 {
        let product = self.map.product;
        let [a, b] = self.map.mesh.topology.edges[edge].map(|v| product.points[v]);
        let ends = product.baseline.manifold.level.topology.edges[cage_edge];
        let [from, to] = ends.map(|v| product.baseline.points[v]);
        distance_to_segment(a.midpoint(b), from, to)
    }
}

/// The labels of `count` faces.
fn labels<'s>(count: usize, sets: impl Iterator<Item = (usize, &'s [FaceId])>) -> Labels {
    let mut labels = Labels::filled(None, count);
    sets.for_each(|(label, set)| set.iter().for_each(|&face| labels[face] = Some(label)));
    labels
}

fn source_faces(garment: &Mesh, subset: usize) -> &[FaceId] {
    match &garment.subsets[subset].elements {
        Elements::Faces(faces) => faces,
        _ => &[],
    }
}

fn faces(t: &Topology, edge: EdgeId) -> impl Iterator<Item = FaceId> {
    t.edge_corners.row(edge).iter().map(|&c: &CornerId| t.faces.face_of(c))
}

/// The labels on the sides of an edge; none if they are equal.
fn sides(t: &Topology, edge: EdgeId, labels: &Labels) -> Option<Sides> {
    let mut sides = [None; 2];
    faces(t, edge).zip(&mut sides).for_each(|(face, side)| *side = labels[face]);
    sides.sort_unstable();
    (sides[0] != sides[1]).then_some(sides)
}
