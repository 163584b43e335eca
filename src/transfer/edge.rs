//! Edge sets: exact where their edges are chains, else paths of edges along the curves that they are on the baseline.

use super::Sites;
use super::curve::{Corridor, Curve, Found, Scratch};
use super::hash::{IdMap, IdSet};
use super::snap::{Surface, sorted};
use crate::mesh::{ChainId, VertexId};
use crate::sim::SimProduct;
use crate::subdivide::Numbering;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// How far from its curve a path may be, in target lengths: wider only where there is no narrower one.
const REACHES: [f32; 4] = [1.0, 1.5, 2.5, 4.0];
/// Times that the paths of a set are found again where some run into others.
const RETRIES: usize = 4;

/// Vertices that are tried for an end of a run that meets another: more hardly help, and take time.
const MAX_ENDS: usize = 6;

/// Where edges of the garment are on the simulation mesh.
pub(super) struct Edges<'a> {
    pub surface: Surface<'a>,
    sites: &'a Sites<'a>,
    /// The edges of the cage's pieces on each edge of the garment, where the surface has a face.
    pieces: IdMap<[VertexId; 2], Vec<[VertexId; 2]>>,
    /// The vertices of the cage's pieces at each vertex of the garment.
    copies: IdMap<VertexId, Vec<VertexId>>,
}

/// An edge set on the simulation mesh.
#[derive(Default)]
pub(super) struct Carried {
    /// Its edges; those of a chain in their order.
    pub edges: Vec<[VertexId; 2]>,
    /// Edges of the source that are not on the simulation mesh.
    pub lost: usize,
    /// Length of the source's curves on the baseline. \[stage units\]
    pub source_length: f64,
    /// Largest distance of a vertex from its curve, in local target lengths.
    pub farthest: f32,
    /// Length of its edges, those of too long a path counted with the shortest one there is. \[stage units\]
    pub shortest: f64,
}

/// A path of cage edges without a branch, none of them a constraint.
struct Run {
    path: Vec<VertexId>,
    is_loop: bool,
}

impl Run {
    fn ends(&self) -> [VertexId; 2] {
        [self.path[0], self.path[self.path.len() - 1]]
    }
}

/// The runs of a set with their curves on the baseline.
struct Runs {
    runs: Vec<Run>,
    /// The vertices of the baseline along each run.
    paths: Vec<Vec<VertexId>>,
    curves: Vec<Curve>,
    /// The vertex of the simulation mesh at each end of a run.
    snapped: BTreeMap<VertexId, VertexId>,
    /// What the set has on chains.
    on_chains: Vec<[VertexId; 2]>,
}

/// Where a set's ends on chains are: the place among the edges of the chain, and the vertex there.
struct Places {
    of: BTreeMap<(ChainId, usize), (usize, VertexId)>,
}

impl Places {
    /// The ends of what a set has on chains, each chain's edges by their places, and those of its runs.
    fn new(surface: &Surface<'_>, on_chains: &BTreeMap<ChainId, BTreeSet<usize>>, runs: &[Run]) -> Self {
        let mut wanted: BTreeMap<ChainId, BTreeSet<usize>> = BTreeMap::new();
        for (&chain, ks) in on_chains {
            wanted.entry(chain).or_default().extend(intervals(ks).into_iter().flatten());
        }
        for (chain, k) in runs.iter().flat_map(Run::ends).filter_map(|end| surface.on_chain(end)) {
            wanted.entry(chain).or_default().insert(k);
        }
        let mut of = BTreeMap::new();
        for (chain, ks) in wanted {
            let ks: Vec<usize> = ks.into_iter().collect();
            let places = surface.places_on_chain(chain, &ks);
            of.extend(ks.into_iter().map(|k| (chain, k)).zip(places));
        }
        Self { of }
    }
}

impl Laid {
    /// Changes the counts of what a run passes.
    fn count(&mut self, runs: &Runs, i: usize, change: impl Fn(&mut u32)) {
        let Some(found) = &self.found[i] else { return };
        for &vertex in found.inner(runs.runs[i].is_loop) {
            change(self.passed.entry(vertex).or_default());
        }
        if let [a, b] = found.vertices[..] {
            change(self.direct.entry(sorted(a, b)).or_default());
        }
    }

    /// Takes away the paths of some runs.
    fn take_up(&mut self, runs: &Runs, which: &[usize]) {
        for &i in which {
            self.count(runs, i, |n| *n -= 1);
            self.found[i] = None;
        }
    }

    fn is_crowded(&self, runs: &Runs, i: usize) -> bool {
        let Some(found) = &self.found[i] else { return true };
        let is_shared = |[a, b]: [VertexId; 2]| self.direct.get(&sorted(a, b)) != Some(&1);
        let meets = found.inner(runs.runs[i].is_loop).iter().any(|v| self.passed.get(v) != Some(&1));
        meets || found.vertices[..].try_into().is_ok_and(is_shared)
    }

    fn is_taken(&self, a: VertexId, b: VertexId) -> bool {
        self.direct.get(&sorted(a, b)).is_some_and(|n| *n > 0)
    }
}

/// The first place and the end of each run of places that follow each other.
fn intervals(places: &BTreeSet<usize>) -> Vec<[usize; 2]> {
    let places: Vec<usize> = places.iter().copied().collect();
    places.chunk_by(|a, b| a + 1 == *b).map(|own| [own[0], own[own.len() - 1] + 1]).collect()
}

/// What was found of each run of a set.
#[derive(Clone)]
struct Laid {
    found: Vec<Option<Found>>,
    /// How many runs pass each vertex or, for one of them all, end there.
    passed: IdMap<VertexId, u32>,
    /// How many go along each edge whose ends are theirs.
    direct: IdMap<[VertexId; 2], u32>,
    /// Runs without a path, or whose path meets another's elsewhere than at an end that both have.
    crowded: Vec<usize>,
}

impl<'a> Edges<'a> {
    pub fn new(product: &'a SimProduct, sites: &'a Sites<'a>) -> Self {
        let manifold = &product.baseline.manifold;
        let mut pieces: IdMap<[VertexId; 2], Vec<[VertexId; 2]>> = IdMap::default();
        for &[a, b] in manifold.refiner.level.topology.edges.iter() {
            let source = sorted(manifold.vertex_source[a], manifold.vertex_source[b]);
            pieces.entry(source).or_default().push([a, b]);
        }
        let mut copies: IdMap<VertexId, Vec<VertexId>> = IdMap::default();
        for (own, &source) in manifold.vertex_source.enumerated() {
            copies.entry(source).or_default().push(own);
        }
        Self { surface: Surface::new(product), sites, pieces, copies }
    }

    /// The vertices of the cage's pieces at a vertex of the garment; several where it is cut apart.
    pub fn vertices_of(&self, vertex: VertexId) -> &[VertexId] {
        self.copies.get(&vertex).map_or(&[], Vec::as_slice)
    }

    /// Several sets, each by itself.
    pub fn carry_all(&self, sets: &[Vec<[VertexId; 2]>]) -> Vec<Carried> {
        let scratch = || Scratch::new(&self.surface);
        sets.par_iter().map_init(scratch, |scratch, set| self.carry(set, scratch)).collect()
    }

    /// A set of edges of the garment.
    fn carry(&self, set: &[[VertexId; 2]], scratch: &mut Scratch) -> Carried {
        let mut on_chains: BTreeMap<ChainId, BTreeSet<usize>> = BTreeMap::new();
        let mut free: BTreeMap<VertexId, Vec<VertexId>> = BTreeMap::new();
        let mut carried = Carried::default();
        for &[a, b] in set {
            let mut is_there = false;
            for &[a, b] in self.pieces.get(&sorted(a, b)).into_iter().flatten() {
                if let Some(&(chain, k)) = self.surface.chain_edge.get(&sorted(a, b)) {
                    on_chains.entry(chain).or_default().insert(k);
                    carried.source_length += self.length(&[a, b]);
                    is_there = true;
                } else if let Some(length) = self.length_on_surface(a, b) {
                    free.entry(a).or_default().push(b);
                    free.entry(b).or_default().push(a);
                    carried.source_length += length;
                    is_there = true;
                }
            }
            carried.lost += usize::from(!is_there);
        }
        let is_end = |v: &VertexId| free[v].len() != 2 || self.surface.is_on_chain(*v);
        let runs = runs(&free, is_end);
        let places = Places::new(&self.surface, &on_chains, &runs);
        for (chain, ks) in on_chains {
            for interval in intervals(&ks) {
                let edges = self.part_of_chain(chain, interval, &places);
                let points = &self.surface.product.points;
                carried.shortest += edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum::<f64>();
                carried.edges.extend(edges);
            }
        }
        let on_chains = carried.edges.clone();
        let runs = Runs { on_chains, ..self.with_curves(runs, &places) };
        self.lay(runs, scratch, &mut carried);
        let mut seen = BTreeSet::new();
        carried.edges.retain(|&[a, b]| seen.insert(sorted(a, b)));
        carried
    }

    /// Length on the baseline of an edge of the cage, no constraint; none of one without a face, between two holes.
    /// \[stage units\]
    fn length_on_surface(&self, a: VertexId, b: VertexId) -> Option<f64> {
        let path = self.curve(&[a, b]);
        let t = &self.surface.product.baseline.topology;
        t.find_edge(path[0], path[1]).map(|_| self.length_of(&path))
    }

    /// Length on the baseline of a path of the cage. \[stage units\]
    fn length(&self, path: &[VertexId]) -> f64 {
        self.length_of(&self.curve(path))
    }

    /// Length of a path of vertices of the baseline. \[stage units\]
    fn length_of(&self, path: &[VertexId]) -> f64 {
        let points = &self.surface.product.baseline.points;
        path.windows(2).map(|p| f64::from(points[p[0]].distance(points[p[1]]))).sum()
    }

    /// The edges of a chain between two places in its cage.
    fn part_of_chain(&self, chain: ChainId, [from, to]: [usize; 2], places: &Places) -> Vec<[VertexId; 2]> {
        let edges = &self.surface.product.chain_edges[chain];
        if edges.is_empty() || to - from + 1 >= self.surface.product.baseline.chains[chain].cage.len() {
            return edges.clone();
        }
        let [from, to] = [from, to].map(|k| places.of.get(&(chain, k)).map_or(0, |p| p.0));
        let from = from.min(edges.len() - 1);
        edges[from..to.clamp(from + 1, edges.len())].to_vec()
    }

    /// The vertices of the baseline along a path of the cage.
    fn curve(&self, path: &[VertexId]) -> Vec<VertexId> {
        let mut path = path.to_vec();
        for parent in self.surface.product.baseline.parents() {
            let numbering = Numbering::new(&parent.level);
            let mut fine = Vec::with_capacity(2 * path.len());
            for pair in path.windows(2) {
                fine.push(pair[0]);
                fine.extend(parent.level.topology.find_edge(pair[0], pair[1]).map(|e| numbering.of_edge(e)));
            }
            fine.extend(path.last());
            path = fine;
        }
        path
    }

    fn with_curves(&self, runs: Vec<Run>, places: &Places) -> Runs {
        let paths: Vec<Vec<VertexId>> = runs.iter().map(|run| self.curve(&run.path)).collect();
        let points = &self.surface.product.baseline.points;
        let is_closed = |run: &Run| run.ends()[0] == run.ends()[1];
        let curves = runs.iter().zip(&paths).map(|(run, path)| Curve::new(path, points, is_closed(run))).collect();
        let snapped = self.snap(&runs, places);
        Runs { runs, paths, curves, snapped, on_chains: Vec::new() }
    }

    /// The vertex of the simulation mesh at each end of runs; as far as there are enough, one for each.
    fn snap(&self, runs: &[Run], places: &Places) -> BTreeMap<VertexId, VertexId> {
        let ends: BTreeSet<VertexId> = runs.iter().filter(|r| !r.is_loop).flat_map(Run::ends).collect();
        let mut snapped = BTreeMap::new();
        let mut taken: IdSet<VertexId> = IdSet::default();
        // Ends on chains have no choice.
        for &end in &ends {
            let place = self.surface.on_chain(end).and_then(|at| places.of.get(&at));
            if let Some(&(_, vertex)) = place {
                snapped.insert(end, vertex);
                taken.insert(vertex);
            }
        }
        for &end in ends.iter().filter(|e| !self.surface.is_on_chain(**e)) {
            if let Some(vertex) = self.surface.nearest(end, |v| !taken.contains(&v)) {
                snapped.insert(end, vertex);
                taken.insert(vertex);
            }
        }
        snapped
    }

    /// Finds a path for each run. Runs that share an end share its vertex, and keep apart elsewhere as far as they can:
    /// those that run into others are found again before them.
    fn lay(&self, mut runs: Runs, scratch: &mut Scratch, carried: &mut Carried) {
        let order: Vec<usize> = (0..runs.runs.len()).collect();
        let mut best = self.lay_in_order(&runs, &order, scratch);
        for _ in 0..RETRIES {
            if best.crowded.is_empty() {
                break;
            }
            // Only these, the last first: the others are in nobody's way.
            let again: Vec<usize> = best.crowded.iter().rev().copied().collect();
            let mut next = best.clone();
            next.take_up(&runs, &again);
            self.lay_again(&runs, &again, &mut next, scratch);
            if next.crowded.len() >= best.crowded.len() {
                break;
            }
            best = next;
        }
        self.move_ends(&mut runs, &mut best, scratch);
        for (run, found) in runs.runs.iter().zip(best.found) {
            match found {
                Some(found) => {
                    carried.farthest = carried.farthest.max(found.farthest);
                    carried.shortest += found.shortest;
                    carried.edges.extend(found.vertices.windows(2).map(|p| [p[0], p[1]]));
                }
                None => carried.lost += run.path.len() - 1,
            }
        }
    }

    fn lay_in_order(&self, runs: &Runs, order: &[usize], scratch: &mut Scratch) -> Laid {
        let passed = runs.snapped.values().chain(runs.on_chains.iter().flatten()).map(|&v| (v, 1)).collect();
        let direct = runs.on_chains.iter().map(|&[a, b]| (sorted(a, b), 1)).collect();
        let mut laid = Laid { found: runs.runs.iter().map(|_| None).collect(), passed, direct, crowded: Vec::new() };
        self.lay_again(runs, order, &mut laid, scratch);
        laid
    }

    /// Finds the paths of some runs, which have none, in their order.
    fn lay_again(&self, runs: &Runs, order: &[usize], laid: &mut Laid, scratch: &mut Scratch) {
        for &i in order {
            laid.found[i] = self.path(runs, i, laid, scratch);
            laid.count(runs, i, |n| *n += 1);
        }
        let is_crowded = |&i: &usize| laid.is_crowded(runs, i);
        laid.crowded = (0..laid.found.len()).filter(is_crowded).collect();
    }

    /// Gives ends of runs that still run into others other vertices near by, where fewer do with those.
    fn move_ends(&self, runs: &mut Runs, laid: &mut Laid, scratch: &mut Scratch) {
        for i in laid.crowded.clone() {
            for end in runs.runs[i].ends() {
                if laid.crowded.contains(&i) && !runs.runs[i].is_loop && !self.surface.is_on_chain(end) {
                    self.move_end(end, runs, laid, scratch);
                }
            }
        }
    }

    fn move_end(&self, end: VertexId, runs: &mut Runs, laid: &mut Laid, scratch: &mut Scratch) {
        let Some(&own) = runs.snapped.get(&end) else { return };
        let ends_here = |i: &usize| !runs.runs[*i].is_loop && runs.runs[*i].ends().contains(&end);
        let mut again: Vec<usize> = (0..runs.runs.len()).filter(ends_here).collect();
        again.extend(laid.crowded.iter().filter(|i| !ends_here(i)));
        let mut bare = laid.clone();
        bare.take_up(runs, &again);
        bare.passed.remove(&own);
        bare.passed.retain(|_, n| *n > 0);
        for vertex in self.surface.vertices_near(end).into_iter().filter(|&v| v != own).take(MAX_ENDS) {
            if bare.passed.contains_key(&vertex) {
                continue;
            }
            let mut tried = bare.clone();
            tried.passed.insert(vertex, 1);
            runs.snapped.insert(end, vertex);
            self.lay_again(runs, &again, &mut tried, scratch);
            if tried.crowded.len() < laid.crowded.len() {
                *laid = tried;
                return;
            }
        }
        runs.snapped.insert(end, own);
    }

    fn path(&self, runs: &Runs, i: usize, laid: &Laid, scratch: &mut Scratch) -> Option<Found> {
        let (run, curve) = (&runs.runs[i], &runs.curves[i]);
        let ends = run.ends().map(|end| runs.snapped.get(&end).copied());
        let mut at_reach = |reach: f32, least: usize| {
            let is_passed = |v: VertexId| laid.passed.get(&v).is_some_and(|n| *n > 0);
            let corridor = Corridor::new(&self.surface, self.sites, (curve, &runs.paths[i]), reach, is_passed, scratch);
            let [from, to] = match run.is_loop {
                true => [corridor.nearest()?; 2],
                false => [ends[0]?, ends[1]?],
            };
            corridor.best_path(from, to, least)
        };
        let least = if curve.is_loop { 4 } else { 2 };
        // Not along an edge that is another run's, as long as there is another way near by.
        let apart = match ends {
            [Some(a), Some(b)] if !curve.is_loop && laid.is_taken(a, b) => at_reach(REACHES[0], 3),
            _ => None,
        };
        apart.or_else(|| REACHES.iter().find_map(|&reach| at_reach(reach, least)))
    }
}

/// Joins edges into paths between ends, and loops.
fn runs(neighbours: &BTreeMap<VertexId, Vec<VertexId>>, is_end: impl Fn(&VertexId) -> bool) -> Vec<Run> {
    let mut used: BTreeSet<[VertexId; 2]> = BTreeSet::new();
    let mut walk = |start: VertexId, second: VertexId| -> Option<Run> {
        let mut path = vec![start, second];
        if !used.insert(sorted(start, second)) {
            return None;
        }
        while !is_end(&path[path.len() - 1]) && path[path.len() - 1] != start {
            let here = path[path.len() - 1];
            let Some(&next) = neighbours[&here].iter().find(|&&n| used.insert(sorted(here, n))) else { break };
            path.push(next);
        }
        let is_loop = path[path.len() - 1] == start && !is_end(&start);
        Some(Run { path, is_loop })
    };
    let mut runs = Vec::new();
    for from_ends in [true, false] {
        for (&vertex, others) in neighbours.iter().filter(|(v, _)| is_end(v) == from_ends) {
            runs.extend(others.iter().filter_map(|&other| walk(vertex, other)));
        }
    }
    runs
}
