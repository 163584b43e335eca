//! Elements in groups that grow together.
//!
//! Reference: Tarjan and van Leeuwen, *Worst-case Analysis of Set Union Algorithms* (JACM 1984), path halving.

use super::{Id, IdVec};

/// Disjoint sets of elements, each known by its first one.
pub struct Groups<I> {
    parent: IdVec<I, I>,
}

impl<I: Id> Groups<I> {
    /// Each of `count` elements on its own.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count).map(I::new).collect() }
    }

    /// The first element of the group that one is in.
    pub fn first(&mut self, mut element: I) -> I {
        while self.parent[element] != element {
            self.parent[element] = self.parent[self.parent[element]];
            element = self.parent[element];
        }
        element
    }

    /// Joins the groups of two elements; says whether they were two.
    pub fn join(&mut self, a: I, b: I) -> bool {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b)] = a.min(b);
        a != b
    }
}
