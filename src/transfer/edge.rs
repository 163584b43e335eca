//! Edge sets: exact where their edges are chains, else paths of edges along the curves that they are on the baseline.

use super::curve::{Curve, Scratch};
use super::lay::Laid;
use super::snap::{Surface, sorted};
use crate::mesh::{ChainId, Topology, VertexId};
use crate::sim::SimProduct;
use crate::subdivide::Numbering;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};

/// Where edges of the garment are on the simulation mesh.
pub(super) struct Edges<'a> {
    pub surface: Surface<'a>,
    topology: &'a Topology,
    /// The edges of the cage's pieces on each edge of the garment, where the surface has a face.
    pieces: FxHashMap<[VertexId; 2], Vec<[VertexId; 2]>>,
    /// The vertices of the cage's pieces at each vertex of the garment.
    copies: FxHashMap<VertexId, Vec<VertexId>>,
}

/// An edge set on the simulation mesh.
#[derive(Default)]
pub(super) struct Carried {
    /// Its edges; those of a chain in their order.
    pub edges: Vec<[VertexId; 2]>,
    /// Edges of the source that are not on the simulation mesh.
    pub lost: usize,
    /// Chains that run into others, where the mesh has too few vertices to keep them apart.
    pub merged: usize,
    /// Length of the source's curves on the baseline. \[stage units\]
    pub source_length: f64,
    /// Largest distance of a vertex from its curve, in local target lengths.
    pub farthest: f32,
    /// Length of its edges, those of too long a path counted with the shortest one there is. \[stage units\]
    pub shortest: f64,
}

impl Carried {
    /// Adds the paths of runs.
    fn lay(&mut self, laid: Laid<'_>) {
        self.merged = laid.crowded.iter().filter(|&&i| laid.found[i].is_some()).count();
        for (run, found) in laid.runs.runs.iter().zip(laid.found) {
            match found {
                Some(found) => {
                    self.farthest = self.farthest.max(found.farthest);
                    self.shortest += found.shortest;
                    self.edges.extend(found.vertices.windows(2).map(|p| [p[0], p[1]]));
                }
                None => self.lost += run.path.len() - 1,
            }
        }
    }
}

/// A path of cage edges without a branch, none of them a constraint.
pub(super) struct Run {
    path: Vec<VertexId>,
    pub is_loop: bool,
}

impl Run {
    pub fn ends(&self) -> [VertexId; 2] {
        [self.path[0], self.path[self.path.len() - 1]]
    }
}

/// The runs of a set with their curves on the baseline.
pub(super) struct Runs {
    pub runs: Vec<Run>,
    /// The vertices of the baseline along each run.
    pub paths: Vec<Vec<VertexId>>,
    pub curves: Vec<Curve>,
    /// The vertex of the simulation mesh at each end of a run.
    pub snapped: BTreeMap<VertexId, VertexId>,
    /// What the set has on chains.
    pub on_chains: Vec<[VertexId; 2]>,
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
            let places = surface.places_on_chain(chain, &ks, on_chains.contains_key(&chain));
            of.extend(ks.into_iter().map(|k| (chain, k)).zip(places));
        }
        Self { of }
    }
}

/// The first place and the end of each run of places that follow each other.
fn intervals(places: &BTreeSet<usize>) -> Vec<[usize; 2]> {
    let places: Vec<usize> = places.iter().copied().collect();
    places.chunk_by(|a, b| a + 1 == *b).map(|own| [own[0], own[own.len() - 1] + 1]).collect()
}

impl<'a> Edges<'a> {
    /// On the simulation mesh, whose `topology` is at hand.
    pub fn new(product: &'a SimProduct, topology: &'a Topology) -> Self {
        let manifold = &product.baseline.manifold;
        let mut pieces: FxHashMap<[VertexId; 2], Vec<[VertexId; 2]>> = FxHashMap::default();
        for &[a, b] in manifold.refiner.level.topology.edges.iter() {
            let source = sorted(manifold.vertex_source[a], manifold.vertex_source[b]);
            pieces.entry(source).or_default().push([a, b]);
        }
        let mut copies: FxHashMap<VertexId, Vec<VertexId>> = FxHashMap::default();
        for (own, &source) in manifold.vertex_source.enumerated() {
            copies.entry(source).or_default().push(own);
        }
        Self { surface: Surface::new(product, topology), topology, pieces, copies }
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
        carried.lay(Laid::new(&self.surface, self.topology, runs, scratch));
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
        let mut taken: FxHashSet<VertexId> = FxHashSet::default();
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
