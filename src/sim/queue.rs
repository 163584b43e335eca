//! A priority queue of edges with a total order, so that equal lengths come out in the same order on every run.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

struct Entry<T> {
    key: f32,
    item: T,
}

impl<T: Ord> Ord for Entry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then_with(|| other.item.cmp(&self.item))
    }
}

impl<T: Ord> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T: Ord> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T: Ord> Eq for Entry<T> {}

/// Largest key first; of equal keys the lowest item.
pub struct Queue<T>(BinaryHeap<Entry<T>>);

impl<T: Ord> Queue<T> {
    /// An empty queue.
    pub fn new() -> Self {
        Self(BinaryHeap::new())
    }

    /// Adds an item; items may be in the queue more than once.
    pub fn push(&mut self, key: f32, item: T) {
        self.0.push(Entry { key, item });
    }

    /// The item with the largest key.
    pub fn pop(&mut self) -> Option<T> {
        self.0.pop().map(|e| e.item)
    }
}
