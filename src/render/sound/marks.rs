//! Which elements were met.

use crate::mesh::{Id, IdVec};

/// Elements in the order in which they were met, each once.
pub struct Marks<I> {
    is_marked: IdVec<I, bool>,
    /// The elements.
    pub list: Vec<I>,
}

impl<I: Id> Marks<I> {
    /// None yet, of so many.
    pub fn new(count: usize) -> Self {
        Self { is_marked: IdVec::filled(false, count), list: Vec::new() }
    }

    /// Adds an element.
    pub fn add(&mut self, id: I) {
        if !std::mem::replace(&mut self.is_marked[id], true) {
            self.list.push(id);
        }
    }
}
