//! The marked edges of seams as chains with a direction.

use crate::mesh::{EdgeId, IdVec, Topology, VertexId};

/// The marked edges of all seams.
pub struct Network {
    /// The seam of each marked edge.
    pub seam: IdVec<EdgeId, Option<usize>>,
    /// The vertex at which each marked edge begins, in the direction of its chain.
    pub start: IdVec<EdgeId, VertexId>,
    /// Ends inside the surface, where a seam narrows to nothing.
    pub tapers: IdVec<VertexId, bool>,
    /// Edges of an earlier seam that another seam has too, with the other.
    pub shared: Vec<(EdgeId, usize)>,
    /// Chains of one edge with both ends inside, which cannot narrow on both.
    pub lone: Vec<EdgeId>,
    ends: IdVec<EdgeId, [VertexId; 2]>,
}

impl Network {
    /// The network of the edges of each seam, as they were authored.
    pub fn new(t: &Topology, seams: &[Vec<[VertexId; 2]>]) -> Self {
        let mut network = Self {
            seam: IdVec::filled(None, t.edges.len()),
            start: t.edges.iter().map(|e| e[0]).collect(),
            tapers: IdVec::filled(false, t.vertex_count()),
            shared: Vec::new(),
            lone: Vec::new(),
            ends: t.edges.clone(),
        };
        for (instance, edges) in seams.iter().enumerate() {
            for &[a, b] in edges {
                let Some(edge) = t.find_edge(a, b) else { continue };
                match network.seam[edge] {
                    None => {
                        network.seam[edge] = Some(instance);
                        network.start[edge] = a;
                    }
                    Some(first) if first != instance && !network.shared.contains(&(edge, instance)) => {
                        network.shared.push((edge, instance));
                    }
                    Some(_) => {}
                }
            }
        }
        network.set_tapers(t);
        network.direct(t);
        network
    }

    /// The vertices of an edge.
    pub fn ends(&self, edge: EdgeId) -> [VertexId; 2] {
        self.ends[edge]
    }

    /// The seams that pass a vertex.
    pub fn at(&self, t: &Topology, vertex: VertexId) -> Vec<usize> {
        let mut instances: Vec<usize> = self.marked_at(t, vertex).filter_map(|e| self.seam[e]).collect();
        instances.sort_unstable();
        instances.dedup();
        instances
    }

    /// The marked edges at a vertex, each once.
    fn marked_at(&self, t: &Topology, vertex: VertexId) -> impl Iterator<Item = EdgeId> {
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
                let is_end = self.marked_at(t, vertex).count() == 1;
                let corners = t.vertex_corners.row(vertex).iter();
                let at_border = corners.flat_map(|&c| [c, t.faces.prev(c)]).any(|c| t.is_border(t.corner_edge[c]));
                // Along a border a seam ends as inside the surface; across it, it runs off.
                is_end && (!at_border || t.is_border(edge))
            });
            if ends == [true; 2] {
                self.lone.push(edge);
            }
            for (vertex, tapers) in t.edges[edge].into_iter().zip(ends) {
                self.tapers[vertex] |= tapers;
            }
        }
    }

    /// Turns the edges of each chain into the direction that most of them have, of two equal ones that of the first.
    fn direct(&mut self, t: &Topology) {
        let mut done = IdVec::filled(false, t.edges.len());
        for first in t.edges.ids() {
            if self.seam[first].is_none() || done[first] {
                continue;
            }
            let mut starts = vec![(first, self.start[first])];
            done[first] = true;
            let [a, b] = t.edges[first];
            let from = self.start[first];
            let to = if from == a { b } else { a };
            self.walk(t, (first, to), true, &mut done, &mut starts);
            self.walk(t, (first, from), false, &mut done, &mut starts);
            let agree = starts.iter().filter(|(edge, start)| self.start[*edge] == *start).count();
            let turned = 2 * agree < starts.len();
            for (edge, start) in starts {
                let [a, b] = t.edges[edge];
                self.start[edge] = if turned == (start == a) { b } else { a };
            }
        }
    }

    /// Follows a chain from the end of an edge; `ahead` along its direction, else against it.
    fn walk(
        &self,
        t: &Topology,
        (mut edge, mut at): (EdgeId, VertexId),
        ahead: bool,
        done: &mut IdVec<EdgeId, bool>,
        starts: &mut Vec<(EdgeId, VertexId)>,
    ) {
        loop {
            let here: Vec<EdgeId> = self.marked_at(t, at).filter(|&e| self.seam[e] == self.seam[edge]).collect();
            let next = match *here.as_slice() {
                [x, y] if x == edge => y,
                [x, y] if y == edge => x,
                _ => return,
            };
            if std::mem::replace(&mut done[next], true) {
                return;
            }
            let [a, b] = t.edges[next];
            let far = if a == at { b } else { a };
            starts.push((next, if ahead { at } else { far }));
            (edge, at) = (next, far);
        }
    }
}
