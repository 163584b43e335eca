//! Typed 32-bit handles of mesh elements, and vectors indexed by them.

use std::fmt;
use std::marker::PhantomData;
use std::num::NonZeroU32;
use std::ops::{Deref, DerefMut, Index, IndexMut};

/// A handle of one kind of element: its index as a distinct type.
pub trait Id: Copy + Eq + Ord + std::hash::Hash + fmt::Debug + Send + Sync + 'static {
    /// The handle of element `index`; panics above `u32::MAX - 1`, which no mesh in memory reaches.
    fn new(index: usize) -> Self;
    /// The index of the element.
    fn index(self) -> usize;
}

/// A plain number is its own handle.
impl Id for usize {
    fn new(index: usize) -> Self {
        index
    }
    fn index(self) -> usize {
        self
    }
}

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => { $(
        $(#[$doc])*
        // The bits are inverted so that index 0 is nonzero and `Option` takes four bytes.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, bytemuck::NoUninit)]
        #[repr(transparent)]
        pub struct $name(NonZeroU32);

        impl Id for $name {
            #[inline]
            fn new(index: usize) -> Self {
                debug_assert!(index < u32::MAX as usize, "mesh element {index} does not fit 32 bits");
                Self(NonZeroU32::new(!(index as u32)).expect("mesh element fits 32 bits"))
            }
            #[inline]
            fn index(self) -> usize {
                !self.0.get() as usize
            }
        }

        impl $name {
            /// The handle of element `index`.
            #[inline]
            pub fn new(index: usize) -> Self {
                Id::new(index)
            }
            /// The index of the element.
            #[inline]
            pub fn index(self) -> usize {
                Id::index(self)
            }
        }

        impl PartialOrd for $name {
            #[inline]
            fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
                Some(self.cmp(other))
            }
        }

        impl Ord for $name {
            #[inline]
            fn cmp(&self, other: &Self) -> std::cmp::Ordering {
                self.index().cmp(&other.index())
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self.index())
            }
        }
    )* };
}

ids! {
    /// A vertex: an element of `points`.
    VertexId
    /// An undirected edge.
    EdgeId
    /// A face.
    FaceId
    /// A corner of a face, and the half-edge from it to the next corner.
    CornerId
    /// A value of a face-varying primvar, such as a point of a UV layout.
    ValueId
    /// A chain of constrained edges.
    ChainId
    /// A wedge: the corners of a vertex between two constrained edges.
    WedgeId
    /// A span: the part of a chain that one constrained edge follows.
    SpanId
}

/// A vector indexed by one type of handle.
#[derive(Clone, PartialEq, Eq)]
pub struct IdVec<I, T> {
    items: Vec<T>,
    id: PhantomData<fn(I)>,
}

impl<I: Id, T> IdVec<I, T> {
    /// An empty vector.
    pub const fn new() -> Self {
        Self { items: Vec::new(), id: PhantomData }
    }

    /// An empty vector with capacity for `capacity` values.
    pub fn with_capacity(capacity: usize) -> Self {
        Vec::with_capacity(capacity).into()
    }

    /// `len` copies of `value`.
    pub fn filled(value: T, len: usize) -> Self
    where
        T: Clone,
    {
        vec![value; len].into()
    }

    /// Appends a value and returns its handle.
    pub fn push(&mut self, value: T) -> I {
        self.items.push(value);
        I::new(self.items.len() - 1)
    }

    /// All handles, ascending.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = I> + ExactSizeIterator + Clone + use<I, T> {
        (0..self.items.len()).map(I::new)
    }

    /// Handles and values, ascending.
    pub fn enumerated(&self) -> impl DoubleEndedIterator<Item = (I, &T)> + ExactSizeIterator + Clone {
        self.items.iter().enumerate().map(|(i, t)| (I::new(i), t))
    }

    /// `true` if `id` is in range.
    pub fn contains_id(&self, id: I) -> bool {
        id.index() < self.items.len()
    }

    /// The untyped vector.
    pub fn into_vec(self) -> Vec<T> {
        self.items
    }
}

impl<I: Id, T> Default for IdVec<I, T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<I, T: fmt::Debug> fmt::Debug for IdVec<I, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.items.fmt(f)
    }
}

impl<I, T> From<Vec<T>> for IdVec<I, T> {
    fn from(items: Vec<T>) -> Self {
        Self { items, id: PhantomData }
    }
}

impl<I: Id, T> FromIterator<T> for IdVec<I, T> {
    fn from_iter<It: IntoIterator<Item = T>>(iter: It) -> Self {
        Vec::from_iter(iter).into()
    }
}

impl<I, T> Deref for IdVec<I, T> {
    type Target = Vec<T>;
    fn deref(&self) -> &Vec<T> {
        &self.items
    }
}

impl<I, T> DerefMut for IdVec<I, T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.items
    }
}

impl<I: Id, T> Index<I> for IdVec<I, T> {
    type Output = T;
    #[inline]
    fn index(&self, id: I) -> &T {
        &self.items[id.index()]
    }
}

impl<I: Id, T> IndexMut<I> for IdVec<I, T> {
    #[inline]
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.items[id.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_optional_handle_takes_four_bytes() {
        assert_eq!(size_of::<Option<VertexId>>(), 4);
        assert_eq!(VertexId::new(0).index(), 0);
        assert_eq!(VertexId::new(77).index(), 77);
        assert!(VertexId::new(3) < VertexId::new(4));
    }
}
