//! The edges of seams as directed chains.
//!
//! A chain is a maximal path of edges of one seam through vertices where exactly two seam edges meet. Its direction
//! gives a seam its left and right.

use crate::render::parallels::Chain;
use tailor_mesh::connectivity::{EdgeId, IdVec, Topology, VertexId};

/// The edges of all seams.
pub struct Network {
    /// The seam of each edge, if any.
    pub seam: IdVec<EdgeId, Option<usize>>,
    /// The first vertex of each seam edge, in the direction of its chain.
    pub start: IdVec<EdgeId, VertexId>,
    /// True for ends inside the surface, where a seam narrows to nothing.
    pub tapers: IdVec<VertexId, bool>,
    /// Edges of an earlier seam that also belong to a later one, with the later seam.
    pub shared: Vec<(EdgeId, usize)>,
    ends: IdVec<EdgeId, [VertexId; 2]>,
}

impl Network {
    /// The network of some seams, by the authored edges of each.
    pub fn new(t: &Topology, seams: &[Vec<[VertexId; 2]>]) -> Self {
        let mut network = Self {
            seam: IdVec::filled(None, t.edges.len()),
            start: t.edges.iter().map(|e| e[0]).collect(),
            tapers: IdVec::filled(false, t.vertex_count()),
            shared: Vec::new(),
            ends: t.edges.clone(),
        };
        for (seam, edges) in seams.iter().enumerate() {
            for &[a, b] in edges {
                let Some(edge) = t.find_edge(a, b) else { continue };
                match network.seam[edge] {
                    None => {
                        network.seam[edge] = Some(seam);
                        network.start[edge] = a;
                    }
                    Some(first) if first != seam && !network.shared.contains(&(edge, seam)) => {
                        network.shared.push((edge, seam));
                    }
                    Some(_) => {}
                }
            }
        }
        network.set_tapers(t);
        network.orient_chains(t);
        network
    }

    /// The end vertices of an edge.
    pub fn ends(&self, edge: EdgeId) -> [VertexId; 2] {
        self.ends[edge]
    }

    /// The seams at a vertex: those that go through before those that end there, then the later ones first.
    pub fn at(&self, t: &Topology, vertex: VertexId) -> Vec<usize> {
        let all: Vec<usize> = self.seam_edges_at(t, vertex).filter_map(|e| self.seam[e]).collect();
        let mut seams = all.clone();
        seams.sort_unstable_by(|a, b| b.cmp(a));
        seams.dedup();
        seams.sort_by_key(|seam| all.iter().filter(|other| *other == seam).count() < 2);
        seams
    }

    /// The seams at the vertex that two edges share, in the order of [`Network::at`].
    pub fn junction_of(&self, t: &Topology, edge: EdgeId, other: EdgeId) -> Option<Vec<usize>> {
        let vertex = t.edges[edge].into_iter().find(|v| t.edges[other].contains(v))?;
        Some(self.at(t, vertex))
    }

    /// The seam edges at a vertex, each once.
    fn seam_edges_at(&self, t: &Topology, vertex: VertexId) -> impl Iterator<Item = EdgeId> {
        let mut edges: Vec<EdgeId> = Vec::with_capacity(4);
        for &corner in t.vertex_corners.row(vertex) {
            for edge in [t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]] {
                if self.seam[edge].is_some() && !edges.contains(&edge) {
                    edges.push(edge);
                }
            }
        }
        edges.into_iter()
    }

    fn set_tapers(&mut self, t: &Topology) {
        for edge in t.edges.ids().filter(|&e| self.seam[e].is_some()) {
            let ends = t.edges[edge].map(|vertex| {
                let is_end = self.seam_edges_at(t, vertex).count() == 1;
                let corners = t.vertex_corners.row(vertex).iter();
                let at_border = corners.flat_map(|&c| [c, t.faces.prev(c)]).any(|c| t.is_border(t.corner_edge[c]));
                // A seam along a border tapers like one inside the surface. A seam across it runs off the border.
                is_end && (!at_border || t.is_border(edge))
            });
            for (vertex, tapers) in t.edges[edge].into_iter().zip(ends) {
                self.tapers[vertex] |= tapers;
            }
        }
    }

    /// Gives all edges of a chain the authored direction of most of them; a tie goes to the first edge.
    fn orient_chains(&mut self, t: &Topology) {
        let mut visited = IdVec::filled(false, t.edges.len());
        for first in t.edges.ids() {
            if self.seam[first].is_none() || visited[first] {
                continue;
            }
            let mut starts = vec![(first, self.start[first])];
            visited[first] = true;
            let [a, b] = t.edges[first];
            let tail = self.start[first];
            let head = if tail == a { b } else { a };
            self.walk(t, (first, head), true, &mut visited, &mut starts);
            self.walk(t, (first, tail), false, &mut visited, &mut starts);
            let agreeing = starts.iter().filter(|(edge, start)| self.start[*edge] == *start).count();
            let is_reversed = 2 * agreeing < starts.len();
            for (edge, start) in starts {
                let [a, b] = t.edges[edge];
                self.start[edge] = if is_reversed == (start == a) { b } else { a };
            }
        }
    }

    /// The chains, each with its edges in its direction.
    pub fn chains(&self, t: &Topology) -> Vec<Chain> {
        let mut visited = IdVec::filled(false, t.edges.len());
        let mut chains = Vec::new();
        // A closed chain begins at any edge, once all others have begun at their first one.
        for is_closed in [false, true] {
            for first in t.edges.ids().filter(|&e| self.seam[e].is_some()) {
                if visited[first] || !is_closed && self.neighbour(t, first, self.start[first]).is_some() {
                    continue;
                }
                let (mut edges, mut next) = (Vec::new(), Some(first));
                while let Some(edge) = next.filter(|&e| !std::mem::replace(&mut visited[e], true)) {
                    edges.push((edge, self.start[edge]));
                    next = self.neighbour(t, edge, self.head(edge));
                }
                let ends = [self.start[first], edges.last().map_or(self.start[first], |&(edge, _)| self.head(edge))];
                chains.push(Chain { edges, fades: ends.map(|end| !is_closed && self.tapers[end]) });
            }
        }
        chains
    }

    /// The vertex where an edge ends in the direction of its chain.
    fn head(&self, edge: EdgeId) -> VertexId {
        let [a, b] = self.ends[edge];
        if a == self.start[edge] { b } else { a }
    }

    /// The other edge of the chain at an end of an edge.
    fn neighbour(&self, t: &Topology, edge: EdgeId, at: VertexId) -> Option<EdgeId> {
        let here: Vec<EdgeId> = self.seam_edges_at(t, at).filter(|&e| self.seam[e] == self.seam[edge]).collect();
        match *here.as_slice() {
            [x, y] if x == edge => Some(y),
            [x, y] if y == edge => Some(x),
            _ => None,
        }
    }

    /// Follows a chain from the vertex `at` of an edge, forwards if `is_ahead` and else backwards.
    fn walk(
        &self,
        t: &Topology,
        (mut edge, mut at): (EdgeId, VertexId),
        is_ahead: bool,
        visited: &mut IdVec<EdgeId, bool>,
        starts: &mut Vec<(EdgeId, VertexId)>,
    ) {
        loop {
            let Some(next) = self.neighbour(t, edge, at) else { return };
            if std::mem::replace(&mut visited[next], true) {
                return;
            }
            let [a, b] = t.edges[next];
            let far = if a == at { b } else { a };
            starts.push((next, if is_ahead { at } else { far }));
            (edge, at) = (next, far);
        }
    }
}
