//! The room beside chains: how far lines may lie from them.
//!
//! ```text
//!   ------.      .------    Lines keep to half the way to where fronts of two chains meet, or of two parts of one, or to the
//!          \____/           border. Where that is less than they need, they come nearer by a fixed slope along the chain
//!   ====================    and go away by the same one. Chains that meet at a steep angle, at a junction or at a corner,
//!           ^ room          do not limit each other there.
//! ```

use super::waves::Foot;
use super::{Chain, Field};
use tailor_mesh::connectivity::VertexId;

/// By how much the room beside a chain may change along it.
const SLOPE: f32 = 0.5;
/// Share of the way to a meeting that lines may take.
const MAX_SHARE: f32 = 0.9;
/// Distance of a meeting from the chains, as a share of that from their junction along them, above which they meet steeply:
/// at more than 20 degrees.
const STEEP: f32 = 0.17;
/// The least share of the distances that lines keep.
const LEAST: f32 = 0.05;

/// The room on one side of a chain.
#[derive(Clone, Debug, Default)]
struct Side {
    /// What lines need. \[mesh units\]
    need: f32,
    /// Places along the chain where there is less, each with the room there, ascending. \[mesh units\]
    limits: Vec<[f32; 2]>,
}

/// The room beside chains.
#[derive(Clone, Debug, Default)]
pub struct Room {
    sides: Vec<[Side; 2]>,
}

impl Room {
    /// Room for all that is asked, where lines need some distances on the left and right of each chain. \[mesh units\]
    pub fn full(needs: impl IntoIterator<Item = [f32; 2]>) -> Self {
        let side = |need: f32| Side { need, limits: Vec::new() };
        Self { sides: needs.into_iter().map(|sides| sides.map(side)).collect() }
    }

    /// The room that is left on a surface.
    pub fn measured(field: &Field, chains: &[Chain], needs: Vec<[f32; 2]>) -> Self {
        let mut room = Self::full(needs);
        let junctions = Junctions::new(field, chains);
        field.meetings(|[a, b], distance| {
            if !junctions.are_steep([a, b], distance) {
                room.limit(a, MAX_SHARE * distance);
                room.limit(b, MAX_SHARE * distance);
            }
        });
        field.borders(|foot| {
            if !junctions.is_at_border_end(field, foot) {
                room.limit(foot, MAX_SHARE * foot.distance);
            }
        });
        for (chain, sides) in room.sides.iter_mut().enumerate() {
            let around = junctions.closed[chain].then_some(field.lengths()[chain]);
            sides.iter_mut().for_each(|side| side.settle(around));
        }
        room
    }

    fn limit(&mut self, foot: &Foot, room: f32) {
        let side = &mut self.sides[foot.chain][foot.side];
        if room < side.need {
            side.limits.push([foot.along, room]);
        }
    }

    /// Lowers the room at a place of a chain to a share of the need.
    pub fn narrow(&mut self, chain: usize, along: f32, share: f32) {
        for side in &mut self.sides[chain] {
            side.limits.push([along, share * side.need]);
            side.settle(None);
        }
    }

    /// The room beside some of the chains, each with a length before its start.
    pub fn of(&self, chains: impl IntoIterator<Item = (usize, f32)>) -> Self {
        let shifted = |(chain, before): (usize, f32)| {
            let mut sides = self.sides[chain].clone();
            sides.iter_mut().flat_map(|side| &mut side.limits).for_each(|limit| limit[0] += before);
            sides
        };
        Self { sides: chains.into_iter().map(shifted).collect() }
    }

    /// The share of the distances of lines beside a place of a chain.
    pub fn share(&self, foot: &Foot) -> f32 {
        self.sides[foot.chain][foot.side].share(foot.along)
    }

    /// The lesser share of the two sides at a place of a chain.
    pub fn share_at(&self, chain: usize, along: f32) -> f32 {
        self.sides[chain].iter().map(|side| side.share(along)).fold(1.0, f32::min)
    }
}

impl Side {
    fn share(&self, along: f32) -> f32 {
        let next = self.limits.partition_point(|limit| limit[0] <= along);
        let beside = [next.checked_sub(1), Some(next)].into_iter().flatten().filter_map(|i| self.limits.get(i));
        let room = beside.map(|&[at, room]| room + SLOPE * (at - along).abs()).fold(self.need, f32::min);
        if self.need > 0.0 { (room / self.need).clamp(LEAST, 1.0) } else { 1.0 }
    }

    /// Sorts the limits, and lowers each to what its neighbours leave. The ends of a closed chain of a length are one place.
    fn settle(&mut self, around: Option<f32>) {
        if let Some(length) = around {
            let again =
                [-length, length].into_iter().flat_map(|by| self.limits.iter().map(move |&[at, room]| [at + by, room]));
            self.limits = again.chain(self.limits.iter().copied()).collect();
        }
        self.limits.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let lower = |before: &mut Option<[f32; 2]>, limit: &mut [f32; 2]| {
            if let Some([at, room]) = *before {
                limit[1] = limit[1].min(room + SLOPE * (limit[0] - at).abs());
            }
            *before = Some(*limit);
        };
        let (mut before, mut after) = (None, None);
        self.limits.iter_mut().for_each(|limit| lower(&mut before, limit));
        self.limits.iter_mut().rev().for_each(|limit| lower(&mut after, limit));
    }
}

/// Where chains share vertices.
struct Junctions {
    /// The vertices of each chain that others have too, or where it ends, with their places along it.
    shared: Vec<Vec<(VertexId, f32)>>,
    closed: Vec<bool>,
    lengths: Vec<f32>,
    ends: Vec<Vec<(VertexId, f32)>>,
}

impl Junctions {
    fn new(field: &Field, chains: &[Chain]) -> Self {
        let mut places: Vec<Vec<(VertexId, f32)>> = Vec::new();
        let t = field.surface.topology;
        for chain in chains {
            let mut along: Vec<(VertexId, f32)> =
                chain.edges.iter().map(|&(e, start)| (start, field.span(e)[0])).collect();
            if let Some(&(edge, start)) = chain.edges.last() {
                let end = t.edges[edge].into_iter().find(|&v| v != start).unwrap_or(start);
                along.push((end, field.span(edge)[1]));
            }
            places.push(along);
        }
        let mut count = std::collections::BTreeMap::<VertexId, usize>::new();
        places.iter().flatten().for_each(|(v, _)| *count.entry(*v).or_default() += 1);
        let ends =
            places.iter().map(|along| along.first().into_iter().chain(along.last()).copied().collect()).collect();
        let closed = places.iter().map(|along| along.len() > 2 && along[0].0 == along[along.len() - 1].0).collect();
        for along in &mut places {
            along.retain(|(v, _)| count[v] > 1);
        }
        Self { shared: places, closed, lengths: field.lengths().to_vec(), ends }
    }

    /// Whether two chains meet at an angle at a junction near to their feet, or one at a corner of its own.
    fn are_steep(&self, [a, b]: [&Foot; 2], distance: f32) -> bool {
        let far = distance / STEEP;
        if a.chain == b.chain {
            let apart = (a.along - b.along).abs();
            let around = if self.closed[a.chain] { self.lengths[a.chain] - apart } else { f32::INFINITY };
            if apart.min(around) <= 2.0 * far {
                return true;
            }
        }
        let near = |foot: &Foot| {
            let along = foot.along;
            self.shared[foot.chain].iter().filter(move |(_, at)| (at - along).abs() <= far)
        };
        near(a).any(|(v, _)| near(b).any(|(w, _)| v == w))
    }

    /// Whether the foot of a place at the border is near an end of its chain at the border.
    fn is_at_border_end(&self, field: &Field, foot: &Foot) -> bool {
        let t = field.surface.topology;
        let is_border = |v: VertexId| {
            let corners = t.vertex_corners.row(v).iter();
            corners.flat_map(|&c| [c, t.faces.prev(c)]).any(|c| t.is_border(t.corner_edge[c]))
        };
        self.ends[foot.chain].iter().any(|&(v, at)| (at - foot.along).abs() <= foot.distance / STEEP && is_border(v))
    }
}
