//! The lines of seams: parallels of their edges, one pass after the other.
//!
//! Seams of one pass share a field of distances, in which their lines join at corners and at ends that meet, and never cross.
//! Those of the next pass are cut into what the last one made, so that their lines run through those of the seams which they
//! cross. A seam that ends at another one goes on under it, on the edges beyond, without height.

use super::chains::Network;
use super::order::Order;
use super::profile::{LINES, OUTER, basis_at};
use super::rings;
use super::{SeamOptions, Seams};
use crate::render::child::OperatorDerivation;
use crate::render::operator::OperatorInput;
use crate::render::parallels::{self, Chain, Fade, Field, LinePlace, ParallelRequest, Room, Surface};
use glam::Vec3;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Orientation;
use tailor_mesh::subdivide::carried_points;

/// Share of the width that is left at an end that tapers.
const TAPERED: f32 = 0.6;
/// The turn below which a chain is straight. \[radians\]
const TURN: f32 = 0.45;
/// Difference below which weights of a strand are none.
const NONE: f32 = 1e-5;

/// What a seam gives a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Strand {
    /// Index of the seam.
    pub seam: usize,
    /// Distance from its edges, as a share of its width on that side: 0 on the edges, and up to the outermost line.
    pub across: f32,
    /// Share of the profile: less than 1 near ends and where there is less room.
    pub share: f32,
    /// The shares of its offset and of its depth that its height is the sum of.
    pub basis: [f32; 2],
}

impl Strand {
    fn new(seam: usize, across: f32, share: f32) -> Self {
        Self { seam, across, share, basis: basis_at(across).map(|part| share * part) }
    }
}

/// A cage with the lines of seams.
pub struct Cut {
    /// The child.
    pub derivation: OperatorDerivation,
    /// What seams give each of its vertices, the lowest first.
    pub strands: Vec<Vec<Strand>>,
    /// The vertices of the parent where a seam has less width than asked, each with the seam and the share that is left.
    pub narrowed: Vec<(usize, VertexId, f32)>,
}

/// A chain of a seam on the child so far.
#[derive(Clone)]
struct SeamChain {
    seam: usize,
    chain: Chain,
}

/// Cuts the lines of all seams.
pub fn cut(seams: &Seams, cage: &OperatorInput, network: &Network) -> Cut {
    let order = Order::new(cage.topology(), network, seams.seams.len());
    let mut cutter = Cutter::new(seams, cage, network);
    for pass in &order.passes {
        cutter.pass(pass);
    }
    let Cutter { derivation, mut strands, narrowed, .. } = cutter;
    strands.iter_mut().for_each(|here| here.sort_by_key(|strand| order.rank[strand.seam]));
    Cut { derivation, strands, narrowed }
}

struct Cutter<'a> {
    seams: &'a Seams,
    network: &'a Network,
    parent: &'a Topology,
    is_left_handed: bool,
    room: Room,
    chains: Vec<SeamChain>,
    derivation: OperatorDerivation,
    topology: Topology,
    points: IdVec<VertexId, Vec3>,
    strands: Vec<Vec<Strand>>,
    narrowed: Vec<(usize, VertexId, f32)>,
}

impl<'a> Cutter<'a> {
    fn new(seams: &'a Seams, cage: &'a OperatorInput, network: &'a Network) -> Self {
        let t = cage.topology();
        let options = |seam: usize| &seams.seams[seam].1;
        let fade = |seam: usize| Fade { flat: 0.0, rise: options(seam).width };
        let of = |chain: Chain| SeamChain { seam: network.seam[chain.edges[0].0].unwrap_or(0), chain };
        let chains: Vec<SeamChain> = network.chains(t, fade).into_iter().map(of).collect();
        let is_left_handed = cage.garment.orientation == Orientation::LeftHanded;
        let mut cutter = Self {
            seams,
            network,
            parent: t,
            is_left_handed,
            room: Room::default(),
            chains,
            derivation: OperatorDerivation::unchanged(t),
            topology: t.clone(),
            points: carried_points(&&cage.level.limit_rows(), &cage.garment.points),
            strands: vec![Vec::new(); t.vertex_count()],
            narrowed: Vec::new(),
        };
        cutter.measure();
        let ringed = cutter.ringed();
        if !ringed.is_empty() {
            let rings = rings::insert(&cutter.topology, &cutter.points, &ringed, |edge| network.seam[edge].is_some());
            cutter.carry(&rings, BTreeMap::new());
        }
        cutter
    }

    fn options(&self, seam: usize) -> &'a SeamOptions {
        &self.seams.seams[seam].1
    }

    /// Measures the room beside all chains, and finds where it is less than asked.
    fn measure(&mut self) {
        let chains: Vec<Chain> = self.chains.iter().map(|chain| chain.chain.clone()).collect();
        let needs: Vec<[f32; 2]> =
            self.chains.iter().map(|chain| self.options(chain.seam).side_widths().map(|width| OUTER * width)).collect();
        let reach = needs.iter().flatten().fold(0.0, |most: f32, &need| most.max(need));
        let surface = Surface { topology: &self.topology, points: &self.points, is_left_handed: self.is_left_handed };
        let field = Field::new(&surface, &chains, [true; 2], reach);
        let mut room = Room::measured(&field, &chains, needs);
        for (number, SeamChain { seam, chain }) in self.chains.iter().enumerate() {
            for (vertex, along) in places(&self.topology, &field, chain) {
                let left = [along, field.lengths()[number] - along];
                if left.into_iter().zip(&chain.fades).any(|(left, fade)| left <= 0.0 && fade.is_some()) {
                    continue;
                }
                let share = room.share_at(number, along);
                if share < crate::render::operator::REPORTED {
                    self.narrowed.push((*seam, vertex, share));
                }
            }
        }
        for (number, SeamChain { chain, .. }) in self.chains.iter().enumerate() {
            for (fade, along) in chain.fades.iter().zip([0.0, field.lengths()[number]]) {
                if fade.is_some() {
                    room.narrow(number, along, TAPERED);
                }
            }
        }
        self.room = room;
    }

    /// Cuts the lines of some seams.
    fn pass(&mut self, seams: &[usize]) {
        let numbers: Vec<usize> =
            (0..self.chains.len()).filter(|&number| seams.contains(&self.chains[number].seam)).collect();
        let extended: Vec<(Chain, f32)> = numbers.iter().map(|&number| self.extended(&self.chains[number])).collect();
        let room = self.room.of(numbers.iter().copied().zip(extended.iter().map(|(_, before)| *before)));
        let chains: Vec<Chain> = extended.into_iter().map(|(chain, _)| chain).collect();
        let widths: Vec<[f32; 2]> =
            numbers.iter().map(|&number| self.options(self.chains[number].seam).side_widths()).collect();
        let reach = OUTER * widths.iter().flatten().fold(0.0, |most: f32, &width| most.max(width));
        let lines_of = |width: f32| LINES.iter().map(|share| share * width).collect::<Vec<f32>>();
        let surface = Surface { topology: &self.topology, points: &self.points, is_left_handed: self.is_left_handed };
        let request = ParallelRequest {
            field: Field::new(&surface, &chains, [true; 2], reach),
            chains: &chains,
            distances: widths.iter().map(|sides| sides.map(lines_of)).collect(),
            room,
            is_closed: true,
            fading: 0.0,
            blocks: Vec::new(),
        };
        let lines = parallels::insert(&request);
        let mut new: BTreeMap<VertexId, Strand> = BTreeMap::new();
        for &(vertex, LinePlace { chain, side, distance, share, .. }) in &lines.vertices {
            let across = distance / widths[chain][side];
            if across < OUTER + NONE {
                new.insert(vertex, Strand::new(self.chains[numbers[chain]].seam, across, share));
            }
        }
        for (number, chain) in chains.iter().enumerate() {
            for (vertex, along) in places(&self.topology, &request.field, chain) {
                let share = request.share_on(number, along);
                let strand = Strand::new(self.chains[numbers[number]].seam, 0.0, share);
                let known = new.entry(vertex).or_insert(strand);
                if known.share < strand.share {
                    *known = strand;
                }
            }
        }
        let step = lines.builder.finish();
        self.carry(&step, new);
    }

    /// The vertices that need rings, each with the distance of the lines there.
    fn ringed(&self) -> BTreeMap<VertexId, f32> {
        let mut ringed: BTreeMap<VertexId, f32> = BTreeMap::new();
        for (vertex, step) in self.chains.iter().flat_map(|chain| self.dense(chain)) {
            let known = ringed.entry(vertex).or_insert(step);
            *known = known.max(step);
        }
        ringed
    }

    /// The vertices of a chain beside which lines are near to each other along it, too: ends inside the surface, and where it
    /// turns or meets others end to end. Each has the distance of the lines.
    fn dense(&self, SeamChain { seam, chain }: &SeamChain) -> Vec<(VertexId, f32)> {
        let t = &self.topology;
        let step = LINES[0] * 0.5 * self.options(*seam).width;
        let [Some(&first), Some(&last)] = [chain.edges.first(), chain.edges.last()] else { return Vec::new() };
        let end = other_end(t, last.0, last.1);
        let is_closed = end == first.1;
        let pairs = chain.edges.windows(2).map(|pair| [pair[0], pair[1]]);
        let pairs = pairs.chain(is_closed.then_some([last, first]));
        let turns = pairs.filter(|[before, after]| self.turns(after.1, [before.0, after.0]));
        let ends = [first.1, end].into_iter().zip(&chain.fades).filter(|_| !is_closed);
        let ends = ends.filter_map(|(vertex, fade)| {
            // Lines of an only seam run over the border.
            let meets = self.network.counts_at(self.parent, vertex).iter().map(|here| here.1).sum::<usize>() > 1;
            let is_dense = (meets || !is_at_border(t, vertex)) && self.bar_at(*seam, vertex).is_none();
            let share = if fade.is_some() { TAPERED } else { 1.0 };
            (fade.is_some() || is_dense).then_some((vertex, share * step))
        });
        turns.map(|[_, after]| (after.1, step)).chain(ends).collect()
    }

    /// Whether a chain turns on the surface at a vertex between two edges.
    fn turns(&self, vertex: VertexId, [before, after]: [EdgeId; 2]) -> bool {
        let t = &self.topology;
        let angle = |corner: CornerId| {
            let ends = [t.faces.next(corner), t.faces.prev(corner)].map(|c| self.points[t.faces.vertex(c)]);
            let [a, b] = ends.map(|end| end - self.points[vertex]);
            a.angle_between(b)
        };
        let (mut sides, mut total) = ([0.0_f32; 2], 0.0);
        for &corner in t.vertex_corners.row(vertex) {
            total += angle(corner);
            // The side from each of the two edges on, up to the other one.
            for (side, (from, to)) in sides.iter_mut().zip([(before, after), (after, before)]) {
                if t.corner_edge[corner] == from {
                    let mut at = Some(corner);
                    for _ in 0..t.vertex_corners.row(vertex).len() {
                        let Some(here) = at else { break };
                        *side += angle(here);
                        let back = t.faces.prev(here);
                        at = (t.corner_edge[back] != to).then(|| t.twin(back)).flatten();
                    }
                }
            }
        }
        let half = if is_at_border(t, vertex) { std::f32::consts::PI } else { 0.5 * total };
        sides.into_iter().any(|side| side > 0.0 && (side - half).abs() > TURN)
    }

    /// Goes on to the child of a pass.
    fn carry(&mut self, step: &OperatorDerivation, mut new: BTreeMap<VertexId, Strand>) {
        self.strands = (0..step.vertices.len())
            .map(|row| {
                let mut here = blended(step.vertices.at(row), &self.strands);
                here.extend(new.remove(&VertexId::new(row)));
                here
            })
            .collect();
        self.points = carried_points(&&step.vertices, &self.points);
        let child = Topology::new(step.faces.clone(), step.vertices.len());
        for SeamChain { chain, .. } in &mut self.chains {
            let path = |&(edge, start): &(EdgeId, VertexId)| step.path([start, other_end(&self.topology, edge, start)]);
            let steps = chain.edges.iter().flat_map(path);
            chain.edges = steps.filter_map(|[from, to]| Some((child.find_edge(from, to)?, from))).collect();
        }
        self.topology = child;
        self.derivation = self.derivation.then(step);
    }

    /// A chain with the edges beyond its ends at other seams, and the length before its start. \[mesh units\]
    fn extended(&self, SeamChain { seam, chain }: &SeamChain) -> (Chain, f32) {
        let mut chain = chain.clone();
        let mut before = 0.0;
        for end in [0, 1] {
            let (vertex, edge) = if end == 0 {
                let (edge, start) = chain.edges[0];
                (start, edge)
            } else {
                let (edge, start) = chain.edges[chain.edges.len() - 1];
                (other_end(&self.topology, edge, start), edge)
            };
            let Some(bar) = self.bar_at(*seam, vertex) else { continue };
            let half = self.options(bar).side_widths().into_iter().fold(0.0, f32::max);
            // It is whole up to the flank of the other one, and ends below its crest.
            let beyond = self.beyond(vertex, edge, OUTER * half);
            let flat = beyond.iter().map(|&(edge, _)| self.length(edge)).sum();
            chain.fades[end] = Some(Fade { flat, rise: LINES[0] * half });
            if end == 0 {
                before = flat;
                let turned = beyond.iter().rev().map(|&(edge, from)| (edge, other_end(&self.topology, edge, from)));
                chain.edges = turned.chain(chain.edges.iter().copied()).collect();
            } else {
                chain.edges.extend(beyond);
            }
        }
        (chain, before)
    }

    fn length(&self, edge: EdgeId) -> f32 {
        let [a, b] = self.topology.edges[edge];
        self.points[a].distance(self.points[b])
    }

    /// The seam at which another one ends at a vertex.
    fn bar_at(&self, seam: usize, vertex: VertexId) -> Option<usize> {
        if vertex.index() >= self.parent.vertex_count() {
            return None;
        }
        let here = self.network.counts_at(self.parent, vertex);
        let is_end = here.iter().any(|&(other, count)| other == seam && count == 1);
        here.iter().find(|&&(other, count)| is_end && other != seam && count > 1).map(|bar| bar.0)
    }

    /// The edges straight on from an end of an edge, over a length, each with the vertex where it starts.
    fn beyond(&self, mut at: VertexId, mut edge: EdgeId, mut length: f32) -> Vec<(EdgeId, VertexId)> {
        let mut beyond = Vec::new();
        while length > 1e-3 * self.length(edge) {
            let Some(next) = opposite(&self.topology, at, edge) else { break };
            if self.chains.iter().any(|other| other.chain.edges.iter().any(|&(edge, _)| edge == next)) {
                break;
            }
            beyond.push((next, at));
            length -= self.length(next);
            (at, edge) = (other_end(&self.topology, next, at), next);
        }
        beyond
    }
}

/// The strands of a vertex that is a sum of others. What a seam does not reach is on its outermost line.
fn blended(sources: &[(VertexId, f32)], strands: &[Vec<Strand>]) -> Vec<Strand> {
    if let &[(only, _)] = sources {
        return strands[only.index()].clone();
    }
    let mut here: Vec<Strand> = Vec::new();
    for &(source, weight) in sources {
        for strand in &strands[source.index()] {
            let parts = strand.basis.map(|part| weight * part);
            let inside = weight * (OUTER - strand.across);
            match here.iter_mut().find(|known| known.seam == strand.seam) {
                Some(known) => {
                    known.across -= inside;
                    known.share += weight * strand.share;
                    known.basis = [known.basis[0] + parts[0], known.basis[1] + parts[1]];
                }
                None => {
                    let share = weight * strand.share;
                    here.push(Strand { across: OUTER - inside, share, basis: parts, ..*strand });
                }
            }
        }
    }
    here
}

/// The vertices of a chain, with their places along it.
fn places<'a>(t: &'a Topology, field: &'a Field, chain: &'a Chain) -> impl Iterator<Item = (VertexId, f32)> + 'a {
    let starts = chain.edges.iter().map(|&(edge, start)| (start, field.span(edge)[0]));
    let end = chain.edges.last().map(|&(edge, start)| (other_end(t, edge, start), field.span(edge)[1]));
    starts.chain(end)
}

fn other_end(t: &Topology, edge: EdgeId, start: VertexId) -> VertexId {
    let [a, b] = t.edges[edge];
    if a == start { b } else { a }
}

/// The edge straight on from an edge at an inner vertex of four faces.
fn opposite(t: &Topology, vertex: VertexId, edge: EdgeId) -> Option<EdgeId> {
    let corners = t.vertex_corners.row(vertex);
    let edges = |c| [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]];
    let is_inner = corners.len() == 4 && corners.iter().all(|&c| edges(c).iter().all(|&e| !t.is_border(e)));
    let beside: Vec<EdgeId> = corners.iter().filter(|&&c| edges(c).contains(&edge)).flat_map(|&c| edges(c)).collect();
    let across = corners.iter().flat_map(|&c| edges(c)).find(|e| !beside.contains(e));
    across.filter(|_| is_inner)
}

fn is_at_border(t: &Topology, vertex: VertexId) -> bool {
    let corners = t.vertex_corners.row(vertex).iter();
    corners.flat_map(|&c| [c, t.faces.prev(c)]).any(|c| t.is_border(t.corner_edge[c]))
}
