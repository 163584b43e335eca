//! Edge sets: exact where their edges are constraints, the border of a face set where they bound one, else paths of
//! edges along their curves on the baseline.

mod borders;
mod chains;
mod guide;
mod path;

use super::correspondence::Correspondence;
use super::coverage::Locator;
use super::faces::FaceSets;
use super::topology::edge_key;
use crate::sim::{SimOptions, distance_to_segment};
use borders::Borders;
use chains::{ChainEdges, ChainEnds, Chains};
use glam::Vec3;
use guide::{Guide, guides, refined_path};
use path::{EdgePath, PathSearch};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{Csr, EdgeId, FaceId, IdVec, VertexId};
use tailor_mesh::garment::Mesh;

/// Edges and vertices of the garment on the simulation mesh.
pub(super) struct EdgeTransfer<'a> {
    map: &'a Correspondence<'a>,
    locator: &'a Locator<'a>,
    chains: Chains<'a>,
    /// Which vertices are on chains.
    is_constrained: IdVec<VertexId, bool>,
    /// The cage edges of each edge of the garment that has a face on the surface; several where it is cut apart.
    cage_edges: FxHashMap<[VertexId; 2], Vec<EdgeId>>,
    /// The cage vertices of each vertex of the garment; several where it is cut apart.
    cage_vertices: Csr<VertexId, VertexId>,
    /// The turn above which a curve has a corner. \[radians\]
    corner: f32,
}

/// An edge set on the simulation mesh.
#[derive(Default)]
pub(super) struct CarriedEdges {
    /// Its edges; those of a chain in the chain's order.
    pub edges: Vec<[VertexId; 2]>,
    /// The garment's edges without a counterpart.
    pub lost: Vec<[VertexId; 2]>,
    /// The garment's edges of each path that meets others because the mesh has too few vertices.
    pub merged: Vec<Vec<[VertexId; 2]>>,
    /// Length of the source's curves on the baseline. \[mesh units\]
    pub source_length: f64,
    /// Largest distance of a vertex from its curve, in local target lengths.
    pub farthest: f32,
    /// Number of vertices that the searches for its paths visited.
    pub visited: usize,
}

/// The vertices of the simulation mesh that a path may have at each cage vertex where guides end.
type Ends = BTreeMap<VertexId, Vec<VertexId>>;

/// The cage edges of a set by how they are carried.
#[derive(Default)]
struct Parts {
    on_chains: ChainEdges,
    /// The edges that bound a face set, each with the group of that set.
    on_borders: Vec<(usize, EdgeId)>,
    /// For each cage vertex its neighbours by the other edges.
    free: BTreeMap<VertexId, Vec<VertexId>>,
}

impl<'a> EdgeTransfer<'a> {
    /// From a garment of `source_points` points.
    pub fn new(
        map: &'a Correspondence<'a>,
        locator: &'a Locator<'a>,
        source_points: usize,
        options: &SimOptions,
    ) -> Self {
        let product = map.product;
        let manifold = &product.baseline.manifold;
        let mut cage_edges: FxHashMap<[VertexId; 2], Vec<EdgeId>> = FxHashMap::default();
        for (edge, ends) in manifold.level.topology.edges.enumerated() {
            cage_edges.entry(edge_key(ends.map(|v| manifold.vertex_source[v]))).or_default().push(edge);
        }
        let pairs = manifold.vertex_source.enumerated().map(|(own, &source)| (source, own));
        let cage_vertices = Csr::group(source_points, pairs, VertexId::new(0));
        let mut is_constrained = IdVec::filled(false, product.points.len());
        product.chain_edges.iter().flatten().flatten().for_each(|&v| is_constrained[v] = true);
        let chains = Chains::new(product);
        Self { map, locator, chains, is_constrained, cage_edges, cage_vertices, corner: options.corner() }
    }

    /// The nearest vertices to a vertex of the garment, one for each part of the surface that it is on.
    pub fn nearest_vertices(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> {
        self.cage_vertices.row(vertex).iter().filter_map(|&v| match self.chains.of_vertex(v) {
            Some((chain, k)) => self.chains.nearest(chain, k),
            None => self.near(v).first().copied(),
        })
    }

    /// Several sets of the garment's edges, independent of each other.
    pub fn carry_all(&self, garment: &Mesh, face_sets: &FaceSets, sets: &[&[[VertexId; 2]]]) -> Vec<CarriedEdges> {
        let cage = &self.map.product.baseline.manifold.level.topology;
        let all = sets.iter().flat_map(|set| set.iter()).flat_map(|&edge| self.cage_edges_of(edge));
        let free: FxHashSet<EdgeId> = all.filter(|&e| self.chains.of_edge(cage.edges[e]).is_none()).collect();
        let borders = Borders::new(garment, self.map, face_sets, &self.chains, &free);
        sets.par_iter().map(|set| self.carry(set, &borders)).collect()
    }

    fn cage_edges_of(&self, edge: [VertexId; 2]) -> impl Iterator<Item = EdgeId> {
        self.cage_edges.get(&edge_key(edge)).into_iter().flatten().copied()
    }

    fn carry(&self, set: &[[VertexId; 2]], borders: &Borders) -> CarriedEdges {
        let mut carried = CarriedEdges::default();
        let parts = self.divide(set, borders, &mut carried);
        let at_border = self.carry_borders(&parts, borders, &mut carried);
        let is_end = |v: &VertexId| {
            parts.free[v].len() != 2
                || self.chains.of_vertex(*v).is_some()
                || at_border.contains(v)
                || self.is_corner(*v, &parts.free[v])
        };
        let guides = guides(&self.map.product.baseline, &parts.free, is_end);
        let chain_ends = ChainEnds::new(&self.chains, &parts.on_chains, &guides);
        let on_chains = chain_ends.edges(&self.chains, &parts.on_chains);
        let ends = self.snapped_ends(&guides, &chain_ends, &at_border, &carried.edges);
        carried.edges.extend(on_chains.into_iter().flatten());
        self.carry_along(&guides, &ends, &mut carried);
        let mut seen = BTreeSet::new();
        carried.edges.retain(|&edge| seen.insert(edge_key(edge)));
        carried
    }

    /// Divides a set, and adds its length and the edges that have no cage edge.
    fn divide(&self, set: &[[VertexId; 2]], borders: &Borders, carried: &mut CarriedEdges) -> Parts {
        let baseline = &self.map.product.baseline;
        let cage = &baseline.manifold.level.topology;
        let mut found = Vec::with_capacity(set.len());
        for &edge in set {
            let before = found.len();
            for own in self.cage_edges_of(edge) {
                let path = refined_path(baseline, &cage.edges[own]);
                // Between two holes there is none.
                if baseline.topology.find_edge(path[0], path[1]).is_some() {
                    carried.source_length += length(path.windows(2).map(|p| [p[0], p[1]]), &baseline.points);
                    found.push((own, self.chains.of_edge(cage.edges[own])));
                }
            }
            carried.lost.extend((found.len() == before).then_some(edge));
        }
        let free: Vec<EdgeId> = found.iter().filter(|f| f.1.is_none()).map(|f| f.0).collect();
        let ranked = borders.ranked(&free);
        let mut parts = Parts::default();
        for (edge, on_chains) in found {
            if let Some(&group) = ranked.iter().find(|&&group| borders.along(group, edge).is_some()) {
                parts.on_borders.push((group, edge));
            } else if let Some(places) = on_chains {
                places.into_iter().for_each(|(chain, k)| _ = parts.on_chains.entry(chain).or_default().insert(k));
            } else {
                let [a, b] = cage.edges[edge];
                parts.free.entry(a).or_default().push(b);
                parts.free.entry(b).or_default().push(a);
            }
        }
        parts
    }

    /// Adds the edges on borders of face sets. Returns the cage vertices there.
    fn carry_borders(&self, parts: &Parts, borders: &Borders, carried: &mut CarriedEdges) -> FxHashSet<VertexId> {
        let product = self.map.product;
        let cage = &product.baseline.manifold.level.topology;
        for &(group, edge) in &parts.on_borders {
            let curve = refined_path(&product.baseline, &cage.edges[edge]);
            let off = |v: VertexId| {
                let segments = curve.windows(2).map(|p| [p[0], p[1]].map(|v| product.baseline.points[v]));
                let distances = segments.map(|[a, b]| distance_to_segment(product.points[v], a, b));
                distances.fold(f32::MAX, f32::min) / product.target[v]
            };
            for ends in borders.along(group, edge).unwrap_or_default().iter().map(|&e| self.map.mesh.topology.edges[e])
            {
                carried.edges.push(ends);
                carried.farthest = ends.map(off).into_iter().fold(carried.farthest, f32::max);
            }
        }
        parts.on_borders.iter().flat_map(|&(_, edge)| cage.edges[edge]).collect()
    }

    /// Adds the paths of guides.
    fn carry_along(&self, guides: &[Guide], ends: &Ends, carried: &mut CarriedEdges) {
        let used = carried.edges.iter().flatten().chain(ends.values().flatten()).copied().collect();
        let mut search = PathSearch { edges: self, used, visited: 0 };
        let mut paths: Vec<(&Guide, EdgePath)> = Vec::new();
        for guide in guides {
            let own = guide.ends().map(|end| ends.get(&end).map_or(&[][..], Vec::as_slice));
            match search.find(guide, own) {
                Some(path) => paths.push((guide, path)),
                None => carried.lost.extend(guide.edges(&self.map.product.baseline.manifold.vertex_source)),
            }
        }
        carried.visited = search.visited;
        self.count_meeting(&paths, ends, carried);
        for (_, path) in paths {
            carried.farthest = carried.farthest.max(path.farthest);
            carried.edges.extend(path.vertices.windows(2).map(|p| [p[0], p[1]]));
        }
    }

    /// Adds the guides whose paths have a vertex in common with others or with edges before them, except where guides end.
    fn count_meeting(&self, paths: &[(&Guide, EdgePath)], ends: &Ends, carried: &mut CarriedEdges) {
        let mut users: FxHashMap<VertexId, usize> = carried.edges.iter().flatten().map(|&v| (v, 1)).collect();
        let mut edges: FxHashMap<[VertexId; 2], usize> = carried.edges.iter().map(|&e| (edge_key(e), 1)).collect();
        let mut distinct = BTreeMap::<VertexId, usize>::new();
        // Ends on a border share vertices with it.
        ends.values().filter(|v| v.len() == 1).for_each(|v| *distinct.entry(v[0]).or_default() += 1);
        for (_, path) in paths {
            path.vertices[1..path.vertices.len() - 1].iter().for_each(|&v| *users.entry(v).or_default() += 1);
            path.vertices.windows(2).for_each(|p| *edges.entry(edge_key([p[0], p[1]])).or_default() += 1);
        }
        let is_alone = |path: &EdgePath| {
            let [first, inner @ .., last] = path.vertices.as_slice() else { return true };
            inner.iter().all(|v| users[v] == 1 && !distinct.contains_key(v))
                && [first, last].iter().all(|v| distinct.get(v).is_none_or(|ends| *ends == 1))
                && path.vertices.windows(2).all(|p| edges[&edge_key([p[0], p[1]])] == 1)
        };
        let sources = &self.map.product.baseline.manifold.vertex_source;
        let meeting = paths.iter().filter(|(_, path)| !is_alone(path));
        carried.merged.extend(meeting.map(|(guide, _)| guide.edges(sources).collect()));
    }

    /// Whether the curve through a cage vertex between two neighbours has a corner there.
    fn is_corner(&self, vertex: VertexId, neighbours: &[VertexId]) -> bool {
        let baseline = &self.map.product.baseline;
        let &[from, to] = neighbours else { return true };
        let at = baseline.points[vertex];
        let way = |other| baseline.points[refined_path(baseline, &[vertex, other])[1]] - at;
        crate::sim::angle(-way(from), way(to)) > self.corner
    }

    /// The vertex of the simulation mesh at each end of guides: distinct ones as far as there are enough. Ends on the
    /// set's `borders` may be at any of the vertices there.
    fn snapped_ends(
        &self,
        guides: &[Guide],
        chain_ends: &ChainEnds,
        at_border: &FxHashSet<VertexId>,
        borders: &[[VertexId; 2]],
    ) -> Ends {
        let mut on_border: FxHashMap<VertexId, usize> = FxHashMap::default();
        borders.iter().flatten().for_each(|&v| *on_border.entry(v).or_default() += 1);
        let ends: BTreeSet<VertexId> = guides.iter().flat_map(Guide::ends).collect();
        let fixed = |&end: &VertexId| {
            let near = if at_border.contains(&end) { self.near(end) } else { Vec::new() };
            let with = |found: &dyn Fn(usize) -> bool| -> Option<Vec<VertexId>> {
                let own = near.iter().copied().filter(|v| on_border.get(v).is_some_and(|&edges| found(edges)));
                Some(own.collect::<Vec<_>>()).filter(|own| !own.is_empty())
            };
            // A path goes on where a border ends, and else comes to any of its vertices.
            let of_border = with(&|edges| edges == 1).or_else(|| with(&|_| true));
            Some((end, of_border.or_else(|| Some(vec![chain_ends.vertex(&self.chains, end)?]))?))
        };
        // Ends on borders and chains come first, because they have no choice.
        let mut snapped: Ends = ends.iter().filter_map(fixed).collect();
        let mut taken: FxHashSet<VertexId> = snapped.values().flatten().chain(on_border.keys()).copied().collect();
        for end in ends {
            if snapped.contains_key(&end) {
                continue;
            }
            let near = self.near(end);
            if let Some(&vertex) = near.iter().find(|v| !taken.contains(v)).or(near.first()) {
                snapped.insert(end, vec![vertex]);
                taken.insert(vertex);
            }
        }
        snapped
    }

    /// The vertices of a face and of its neighbours on the same part of the surface.
    fn around(&self, face: FaceId) -> impl Iterator<Item = VertexId> {
        let (mesh, faces) = (self.map.mesh, &self.map.mesh.topology.faces);
        let across = faces
            .corners_of(face)
            .filter_map(|c| mesh.twin[c].filter(|_| !mesh.is_chain[mesh.topology.corner_edge[c]]));
        let beyond = across.map(|twin| faces.vertex(faces.prev(twin)));
        faces.vertices_of(face).iter().copied().chain(beyond)
    }

    /// The vertices around a cage vertex, the nearest first.
    fn near(&self, vertex: VertexId) -> Vec<VertexId> {
        let product = self.map.product;
        let corners = product.baseline.topology.vertex_corners.row(vertex).iter();
        let places = corners.filter_map(|&corner| {
            let at = product.baseline.corner_location(corner);
            Some(self.locator.place(at.face, at.weights)?.0)
        });
        let faces: BTreeSet<FaceId> = places.collect();
        let point = product.baseline.points[vertex];
        // The bits of distances, which are not negative, sort as the distances do.
        let key = |v: VertexId| (product.points[v].distance_squared(point).to_bits(), v);
        let mut found: Vec<(u32, VertexId)> = faces.into_iter().flat_map(|f| self.around(f)).map(key).collect();
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|f| f.1).collect()
    }
}

/// \[mesh units\]
fn length(edges: impl Iterator<Item = [VertexId; 2]>, points: &IdVec<VertexId, Vec3>) -> f64 {
    edges.map(|[a, b]| f64::from(points[a].distance(points[b]))).sum()
}
