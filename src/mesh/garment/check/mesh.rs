//! The elements that indices and lengths must fit, and their names in messages.

use super::Problems;
use crate::codes;
use crate::connectivity::{EdgeId, Id, Topology, VertexId};
use crate::garment::{Garment, Interpolation};
use std::fmt;

/// The element counts of the mesh while its attributes are checked. A count is none where it is itself at fault.
#[derive(Clone, Copy)]
pub(super) struct MeshCheck<'a> {
    /// `faceVertexCounts`, to name corners by their face.
    pub counts: &'a [i32],
    /// Number of points.
    pub points: Option<usize>,
    /// Number of faces.
    pub faces: Option<usize>,
    /// Number of corners.
    pub corners: Option<usize>,
    /// Edges and adjacency.
    pub topology: Option<&'a Topology>,
}

impl<'a> MeshCheck<'a> {
    /// The counts on which `input` is consistent.
    pub fn new(input: &'a Garment, topology: Option<&'a Topology>) -> Self {
        let counts = &input.face_vertex_counts;
        let corners = input.face_vertex_indices.len();
        let some = |n: usize| (n > 0).then_some(n);
        Self {
            counts,
            points: some(input.points.len()),
            faces: some(counts.len()),
            corners: some(corners).filter(|&n| corner_sum(counts) == Some(n)),
            topology,
        }
    }

    /// Number of elements that carry a primvar's values; none where it is unknown, or the primvar constant.
    pub fn elements(&self, interpolation: Interpolation) -> Option<usize> {
        match interpolation {
            Interpolation::Constant => None,
            Interpolation::Uniform => self.faces,
            Interpolation::Varying | Interpolation::Vertex => self.points,
            Interpolation::FaceVarying => self.corners,
        }
    }

    /// The edge between two vertices; the outer none means that the topology is unknown.
    pub fn edge(&self, [a, b]: [VertexId; 2]) -> Option<Option<EdgeId>> {
        self.topology.map(|t| t.find_edge(a, b))
    }

    /// Names a corner by its face.
    pub fn corner(&self, corner: usize) -> CornerName<'a> {
        CornerName { counts: self.counts, corner }
    }

    /// Names the element of a primvar.
    pub fn element(&self, interpolation: Interpolation, element: usize) -> ElementName<'a> {
        ElementName { mesh: *self, interpolation, element }
    }
}

/// The sum of `faceVertexCounts`, unless one of them is negative.
pub(super) fn corner_sum(counts: &[i32]) -> Option<usize> {
    counts.iter().map(|&n| usize::try_from(n).ok()).sum()
}

/// A corner as messages name it. Its face is searched only when it is printed.
pub(super) struct CornerName<'a> {
    counts: &'a [i32],
    corner: usize,
}

impl CornerName<'_> {
    /// The face, and the number of the corner in it; none where `faceVertexCounts` is at fault.
    fn in_face(&self) -> Option<(usize, usize)> {
        let mut start = 0;
        for (face, &count) in self.counts.iter().enumerate() {
            let count = usize::try_from(count).ok()?;
            if self.corner < start + count {
                return Some((face, self.corner - start));
            }
            start += count;
        }
        None
    }
}

impl fmt::Display for CornerName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.in_face() {
            Some((face, corner)) => write!(f, "corner {corner} of face {face}"),
            None => write!(f, "entry {}", self.corner),
        }
    }
}

/// The element of a primvar as messages name it.
pub(super) struct ElementName<'a> {
    mesh: MeshCheck<'a>,
    interpolation: Interpolation,
    element: usize,
}

impl fmt::Display for ElementName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.interpolation {
            Interpolation::Constant => write!(f, "value {}", self.element),
            Interpolation::Uniform => write!(f, "face {}", self.element),
            Interpolation::Varying | Interpolation::Vertex => write!(f, "point {}", self.element),
            Interpolation::FaceVarying => self.mesh.corner(self.element).fmt(f),
        }
    }
}

/// A number of things: "1 point", "9 points".
pub(super) struct Count(pub usize, pub &'static str);

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.0, self.1) {
            (1, "index") => write!(f, "1 index"),
            (n, "index") => write!(f, "{n} indices"),
            (1, kind) => write!(f, "1 {kind}"),
            (n, kind) => write!(f, "{n} {kind}s"),
        }
    }
}

/// An attribute whose numbers are indices of elements of one kind.
pub(super) struct Indices<'a> {
    /// The attribute.
    pub attribute: &'a str,
    /// The kind of element: `point`, `face`, `value`.
    pub kind: &'static str,
    /// Number of such elements; none where it is unknown.
    pub count: Option<usize>,
}

impl Indices<'_> {
    /// The handles of `indices`, none for those out of range; `place` names an entry by its position.
    pub fn handles<I: Id, N: fmt::Display>(
        &self,
        indices: &[i32],
        place: impl Fn(usize) -> N,
        problems: &mut Problems,
    ) -> Vec<Option<I>> {
        let Some(count) = self.count else { return vec![None; indices.len()] };
        let handle = |(entry, &index): (usize, &i32)| match usize::try_from(index) {
            Ok(index) if index < count => Some(I::new(index)),
            _ => {
                self.add_out_of_range(&place(entry), index, count, problems);
                None
            }
        };
        indices.iter().enumerate().map(handle).collect()
    }

    /// Adds the problem of an index out of range.
    fn add_out_of_range(&self, place: &dyn fmt::Display, index: i32, count: usize, problems: &mut Problems) {
        let (attribute, kind) = (self.attribute, self.kind);
        let Some(last) = count.checked_sub(1) else {
            let fault = format_args!("{place} names {kind} {index}, but there are no {kind}s");
            return problems.add(
                codes::INDEX_OUT_OF_RANGE,
                attribute,
                fault,
                format_args!("add the {kind}s, or remove the indices"),
            );
        };
        let fault = format_args!("{place} names {kind} {index}, but there are {}, 0 to {last}", Count(count, kind));
        problems.add(
            codes::INDEX_OUT_OF_RANGE,
            attribute,
            fault,
            format_args!("use an index from 0 to {last}, or add the missing {kind}s"),
        );
    }
}

/// A numbered part of an array as messages name it: "entry 4", "pair 2".
pub(super) struct Entry(pub &'static str, pub usize);

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, self.1)
    }
}

/// A repeated key: its position, and that of the first.
pub(super) struct Repeat {
    pub first: usize,
    pub again: usize,
}

/// The repeated keys, in their order. Sorting is faster than hashing here and has no seed.
pub(super) fn repeats<K: Ord + Copy>(keys: impl Iterator<Item = (usize, K)>) -> Vec<Repeat> {
    let mut sorted: Vec<(K, usize)> = keys.map(|(position, key)| (key, position)).collect();
    sorted.sort_unstable();
    let runs = sorted.chunk_by(|a, b| a.0 == b.0);
    let repeat = |run: &[(K, usize)], again: &(K, usize)| Repeat { first: run[0].1, again: again.1 };
    let mut repeats: Vec<Repeat> = runs.flat_map(|run| run[1..].iter().map(move |again| repeat(run, again))).collect();
    repeats.sort_unstable_by_key(|r| r.again);
    repeats
}
