//! Disjoint sets (union-find).
//!
//! Reference: Tarjan and van Leeuwen, *Worst-case Analysis of Set Union Algorithms* (JACM 1984), path halving.

use super::{Id, IdVec};

/// Disjoint sets of elements, each identified by its first one.
pub struct Groups<I> {
    parent: IdVec<I, I>,
}

impl<I: Id> Groups<I> {
    /// `count` sets of one element each.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count).map(I::new).collect() }
    }

    /// The first element of an element's set.
    pub fn first(&mut self, mut element: I) -> I {
        while self.parent[element] != element {
            self.parent[element] = self.parent[self.parent[element]];
            element = self.parent[element];
        }
        element
    }

    /// Joins the sets of two elements. Returns whether they were different.
    pub fn join(&mut self, a: I, b: I) -> bool {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b)] = a.min(b);
        a != b
    }
}
