//! Edge sets: exact where their edges are chains, else paths of edges along the curves that they are on the baseline.

use super::Sites;
use super::curve::{Corridor, Curve, Found};
use super::snap::{Surface, sorted};
use crate::mesh::{ChainId, VertexId};
use crate::sim::SimProduct;
use crate::subdivide::Numbering;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// How far from its curve a path may be, in target lengths: wider only where there is no narrower one.
const REACHES: [f32; 4] = [1.0, 1.5, 2.5, 4.0];

/// Where edges of the garment are on the simulation mesh.
pub(super) struct Edges<'a> {
    pub surface: Surface<'a>,
    sites: &'a Sites<'a>,
    /// The edges of the cage's pieces on each edge of the garment, where the surface has a face.
    pieces: HashMap<[VertexId; 2], Vec<[VertexId; 2]>>,
    /// The vertices of the cage's pieces at each vertex of the garment.
    copies: HashMap<VertexId, Vec<VertexId>>,
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

impl<'a> Edges<'a> {
    pub fn new(product: &'a SimProduct, sites: &'a Sites<'a>) -> Self {
        let manifold = &product.baseline.manifold;
        let mut pieces: HashMap<[VertexId; 2], Vec<[VertexId; 2]>> = HashMap::new();
        for &[a, b] in manifold.refiner.level.topology.edges.iter() {
            let source = sorted(manifold.vertex_source[a], manifold.vertex_source[b]);
            pieces.entry(source).or_default().push([a, b]);
        }
        let mut copies: HashMap<VertexId, Vec<VertexId>> = HashMap::new();
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
        sets.par_iter().map(|set| self.carry(set)).collect()
    }

    /// A set of edges of the garment.
    fn carry(&self, set: &[[VertexId; 2]]) -> Carried {
        let mut on_chains: BTreeMap<ChainId, Vec<usize>> = BTreeMap::new();
        let mut free: BTreeMap<VertexId, Vec<VertexId>> = BTreeMap::new();
        let mut carried = Carried::default();
        for &[a, b] in set {
            let mut is_there = false;
            for &[a, b] in self.pieces.get(&sorted(a, b)).into_iter().flatten() {
                if let Some(&(chain, k)) = self.surface.chain_edge.get(&sorted(a, b)) {
                    on_chains.entry(chain).or_default().push(k);
                    carried.source_length += self.length(&[a, b]);
                    is_there = true;
                } else if self.is_on_surface(a, b) {
                    free.entry(a).or_default().push(b);
                    free.entry(b).or_default().push(a);
                    carried.source_length += self.length(&[a, b]);
                    is_there = true;
                }
            }
            carried.lost += usize::from(!is_there);
        }
        for (chain, mut places) in on_chains {
            places.sort_unstable();
            for interval in places.chunk_by(|a, b| a + 1 == *b) {
                let edges = self.part_of_chain(chain, interval[0], interval[interval.len() - 1] + 1);
                let points = &self.surface.product.points;
                carried.shortest += edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum::<f64>();
                carried.edges.extend(edges);
            }
        }
        let ends_on_chains = |v: &VertexId| self.surface.is_on_chain(*v);
        let is_end = |v: &VertexId| free[v].len() != 2 || ends_on_chains(v);
        let runs = runs(&free, is_end);
        self.lay(&runs, &mut carried);
        let mut seen = BTreeSet::new();
        carried.edges.retain(|&[a, b]| seen.insert(sorted(a, b)));
        carried
    }

    /// Whether an edge of the cage, no constraint, has a face; between two holes there is none.
    fn is_on_surface(&self, a: VertexId, b: VertexId) -> bool {
        let path = self.curve(&[a, b]);
        let t = &self.surface.product.baseline.topology;
        t.find_edge(path[0], path[1]).is_some()
    }

    /// Length on the baseline of a path of the cage. \[stage units\]
    fn length(&self, path: &[VertexId]) -> f64 {
        let points = &self.surface.product.baseline.points;
        self.curve(path).windows(2).map(|p| f64::from(points[p[0]].distance(points[p[1]]))).sum()
    }

    /// The edges of a chain between two places in its cage.
    fn part_of_chain(&self, chain: ChainId, from: usize, to: usize) -> Vec<[VertexId; 2]> {
        let edges = &self.surface.product.chain_edges[chain];
        if edges.is_empty() || to - from + 1 >= self.surface.product.baseline.chains[chain].cage.len() {
            return edges.clone();
        }
        let [from, to] = [from, to].map(|k| self.surface.place_on_chain(chain, k));
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

    /// Finds a path for each run. Runs that share an end share its vertex, and keep apart elsewhere.
    fn lay(&self, runs: &[Run], carried: &mut Carried) {
        let ends: BTreeSet<VertexId> =
            runs.iter().filter(|r| !r.is_loop).flat_map(|r| [r.path[0], r.path[r.path.len() - 1]]).collect();
        let mut snapped: BTreeMap<VertexId, VertexId> = BTreeMap::new();
        let mut passed: BTreeSet<VertexId> = BTreeSet::new();
        // Ends on chains have less choice.
        for on_chain in [true, false] {
            for &end in ends.iter().filter(|&&e| self.surface.is_on_chain(e) == on_chain) {
                if let Some(vertex) = self.surface.nearest(end, |v| !passed.contains(&v)) {
                    snapped.insert(end, vertex);
                    passed.insert(vertex);
                }
            }
        }
        for run in runs {
            match self.path(run, &snapped, &passed) {
                Some(found) => {
                    carried.farthest = carried.farthest.max(found.farthest);
                    carried.shortest += found.shortest;
                    passed.extend(&found.vertices);
                    carried.edges.extend(found.vertices.windows(2).map(|p| [p[0], p[1]]));
                }
                None => carried.lost += run.path.len() - 1,
            }
        }
    }

    fn path(&self, run: &Run, snapped: &BTreeMap<VertexId, VertexId>, passed: &BTreeSet<VertexId>) -> Option<Found> {
        let vertices = self.curve(&run.path);
        let is_closed = run.path[0] == run.path[run.path.len() - 1];
        let curve = Curve::new(&vertices, &self.surface.product.baseline.points, is_closed);
        REACHES.iter().find_map(|&reach| {
            let corridor = Corridor::new(&self.surface, self.sites, &curve, &vertices, reach, passed);
            let ends = [run.path[0], run.path[run.path.len() - 1]];
            let [from, to] = match run.is_loop {
                true => [corridor.nearest()?; 2],
                false => [*snapped.get(&ends[0])?, *snapped.get(&ends[1])?],
            };
            corridor.best_path(from, to, if is_closed { 4 } else { 2 })
        })
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
