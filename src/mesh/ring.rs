//! A small set of vertices for searches around an edge.

use super::VertexId;

/// Neighbours that are looked up a few times: on the stack, for all but the largest fans.
#[derive(Default)]
pub(super) struct Ring {
    few: [Option<VertexId>; 16],
    count: usize,
    more: Vec<VertexId>,
}

impl Ring {
    pub(super) fn push(&mut self, v: VertexId) {
        match self.few.get_mut(self.count) {
            Some(slot) => *slot = Some(v),
            None => self.more.push(v),
        }
        self.count += 1;
    }

    pub(super) fn contains(&self, v: VertexId) -> bool {
        self.few[..self.count.min(self.few.len())].contains(&Some(v)) || self.more.contains(&v)
    }
}
