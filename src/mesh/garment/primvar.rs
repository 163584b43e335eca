//! Values on the elements of a mesh (`UsdGeomPrimvar`).

use crate::connectivity::{CornerId, Csr, Faces, IdVec, VertexId};
use serde::Serialize;
use std::sync::Arc;

/// The elements that carry a primvar's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Interpolation {
    /// One value for the mesh.
    Constant,
    /// One value a face.
    Uniform,
    /// One value a vertex, interpolated linearly.
    Varying,
    /// One value a vertex, interpolated by the subdivision rules.
    Vertex,
    /// One value a corner.
    FaceVarying,
}

impl Interpolation {
    /// Its name in USD.
    pub fn word(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Uniform => "uniform",
            Self::Varying => "varying",
            Self::Vertex => "vertex",
            Self::FaceVarying => "faceVarying",
        }
    }
}

/// The meaning of a primvar's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Meaning {
    /// Numbers, truth values or strings.
    #[default]
    Plain,
    /// UVs.
    TextureCoordinate,
    /// Colours.
    Color,
    /// Directions perpendicular to the surface.
    Normal,
    /// Positions.
    Point,
    /// Directions with a length.
    Vector,
    /// Rotations.
    Quaternion,
    /// Matrices, row by row.
    Matrix,
    /// Matrices that are coordinate frames.
    Frame,
    /// Matrices that are transforms.
    Transform,
    /// Times of the stage.
    TimeCode,
    /// Numbers of points.
    PointIndex,
    /// Numbers of edges.
    EdgeIndex,
    /// Numbers of faces.
    FaceIndex,
    /// Names.
    Token,
    /// Paths of files, as authored.
    AssetPath,
}

/// How the values of several source elements combine into one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mixing {
    /// Weighted sums.
    Linear,
    /// Weighted sums, scaled to unit length again (normals).
    Direction,
    /// Weighted sums on one hemisphere, scaled to unit length again (quaternions).
    Rotation,
    /// The value of the heaviest source.
    Discrete,
}

/// The values of a primvar, flat.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// half and float types.
    F32(Vec<f32>),
    /// double types and time codes.
    F64(Vec<f64>),
    /// bool.
    Bool(Vec<bool>),
    /// uchar.
    U8(Vec<u8>),
    /// int and its tuples.
    I32(Vec<i32>),
    /// uint.
    U32(Vec<u32>),
    /// int64.
    I64(Vec<i64>),
    /// uint64.
    U64(Vec<u64>),
    /// string, token, asset path.
    Text(Vec<String>),
}

/// Evaluates an expression for the vector of any variant; with `Values`, its result becomes the same variant.
macro_rules! each {
    ($values:expr, $v:ident => $($wrap:ident)? ($e:expr)) => {
        each!(@ $values, $v, $e, $($wrap)?; F32 F64 Bool U8 I32 U32 I64 U64 Text)
    };
    (@ $values:expr, $v:ident, $e:expr, Values; $($kind:ident)*) => {
        match $values { $(Values::$kind($v) => Values::$kind($e)),* }
    };
    (@ $values:expr, $v:ident, $e:expr, ; $($kind:ident)*) => {
        match $values { $(Values::$kind($v) => $e),* }
    };
}

impl Values {
    /// Number of numbers or texts.
    pub fn len(&self) -> usize {
        each!(self, v => (v.len()))
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// No values, of the same variant.
    fn none(&self) -> Self {
        each!(self, _v => Values(Vec::new()))
    }

    /// How values with this meaning combine: quaternions and normals stay of unit length, other real numbers are summed,
    /// and everything else is copied.
    pub(super) fn mixing(&self, meaning: Meaning) -> Mixing {
        match (self, meaning) {
            (Self::F32(_) | Self::F64(_), Meaning::Quaternion) => Mixing::Rotation,
            (Self::F32(_) | Self::F64(_), Meaning::Normal) => Mixing::Direction,
            (Self::F32(_) | Self::F64(_), _) => Mixing::Linear,
            _ => Mixing::Discrete,
        }
    }

    /// Whether two rows of `width` numbers are equal bit for bit.
    pub fn same_rows(&self, width: usize, a: usize, b: usize) -> bool {
        let (a, b) = (a * width..(a + 1) * width, b * width..(b + 1) * width);
        match self {
            Self::F32(v) => v[a].iter().zip(&v[b]).all(|(x, y)| x.to_bits() == y.to_bits()),
            Self::F64(v) => v[a].iter().zip(&v[b]).all(|(x, y)| x.to_bits() == y.to_bits()),
            others => each!(others, v => (v[a] == v[b])),
        }
    }

    /// The rows `rows` of `width` numbers each, in that order.
    pub fn gather(&self, width: usize, rows: impl Iterator<Item = usize> + Clone) -> Self {
        fn take<T: Clone>(v: &[T], width: usize, rows: impl Iterator<Item = usize>) -> Vec<T> {
            if width == 1 {
                return rows.map(|r| v[r].clone()).collect();
            }
            let mut out = Vec::with_capacity(rows.size_hint().0 * width);
            rows.for_each(|r| out.extend_from_slice(&v[r * width..(r + 1) * width]));
            out
        }
        each!(self, v => Values(take(v, width, rows)))
    }
}

/// The property of the file whose values a primvar holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum PrimvarRole {
    /// A primvar, `primvars:<name>`.
    #[default]
    Primvar,
    /// The attribute `normals` of the mesh.
    Normals,
    /// Offsets of the mesh's blend shape number `shape`: its property `property`.
    BlendShape {
        /// Number of the blend shape.
        shape: usize,
        /// `offsets`, `normalOffsets` or an inbetween.
        property: String,
    },
}

/// Values that vary over the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Primvar {
    /// Name, unique in the mesh: without `primvars:`; the path of the property for offsets of a blend shape.
    pub name: String,
    /// The property that holds the values.
    pub role: PrimvarRole,
    /// The meaning of the values.
    pub meaning: Meaning,
    /// Whether a file stores the numbers in half precision.
    pub half: bool,
    /// The elements that carry the values.
    pub interpolation: Interpolation,
    /// Numbers in one value of the type: 2 for `float2[]`.
    pub components: usize,
    /// Values in one element (`elementSize`).
    pub element_size: usize,
    /// The values; rows of [`Primvar::width`] numbers.
    pub values: Values,
    /// The row of each element; none when the rows are in element order. Copies share them.
    pub indices: Option<Arc<Vec<u32>>>,
}

impl Primvar {
    /// A copy without values and indices.
    pub fn headed(&self) -> Self {
        Self { name: self.name.clone(), role: self.role.clone(), values: self.values.none(), indices: None, ..*self }
    }

    /// How values combine.
    pub fn mixing(&self) -> Mixing {
        self.values.mixing(self.meaning)
    }

    /// Whether it holds the normals of the mesh: the attribute, or the primvar that replaces it.
    pub fn is_normals(&self) -> bool {
        self.name == "normals"
    }

    /// An estimate of its memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        let values = match &self.values {
            Values::Bool(_) | Values::U8(_) => self.values.len(),
            Values::F64(_) | Values::I64(_) | Values::U64(_) => 8 * self.values.len(),
            Values::Text(texts) => texts.iter().map(|t| t.len() + size_of::<String>()).sum(),
            Values::F32(_) | Values::I32(_) | Values::U32(_) => 4 * self.values.len(),
        };
        4 * self.indices.as_ref().map_or(0, |indices| indices.len()) + values
    }

    /// Numbers in the row of one element.
    pub fn width(&self) -> usize {
        self.components * self.element_size
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.width().max(1)
    }

    /// Whether values are combined by weighted sums.
    pub fn is_mixed(&self) -> bool {
        self.mixing() != Mixing::Discrete
    }

    /// The row of each corner of a face-varying primvar: its index. Without indices, [`Primvar::joined_rows`].
    pub fn corner_rows(&self, faces: &Faces, vertices: usize) -> IdVec<CornerId, u32> {
        self.indices.as_ref().map_or_else(|| self.joined_rows(faces, vertices), |indices| indices.to_vec().into())
    }

    /// The row of each corner of a face-varying primvar, where corners of one vertex share a row if their values are equal bit
    /// for bit. Layouts without indices, and with more of them than values, keep their shells whole.
    pub fn joined_rows(&self, faces: &Faces, vertices: usize) -> IdVec<CornerId, u32> {
        let mut rows: IdVec<CornerId, u32> = (0..faces.corners().len()).map(|c| self.row(c) as u32).collect();
        let at_vertex = Csr::group(vertices, faces.corners().enumerated().map(|(c, &v)| (v, c)), CornerId::new(0));
        for vertex in (0..vertices).map(VertexId::new) {
            let corners = at_vertex.row(vertex);
            for (i, &c) in corners.iter().enumerate() {
                let same = |&&d: &&CornerId| self.values.same_rows(self.width(), rows[c] as usize, rows[d] as usize);
                if let Some(&first) = corners[..i].iter().find(same) {
                    rows[c] = rows[first];
                }
            }
        }
        rows
    }

    /// Number of elements that have a value.
    pub fn elements(&self) -> usize {
        self.indices.as_ref().map_or_else(|| self.rows(), |indices| indices.len())
    }

    /// The row of an element.
    #[inline]
    pub fn row(&self, element: usize) -> usize {
        self.indices.as_ref().map_or(element, |i| i[element] as usize)
    }
}

impl Primvar {
    /// A number at each corner, under no name.
    pub fn of_corners(values: Vec<f32>, indices: Option<Vec<u32>>) -> Self {
        Self {
            name: "x".to_owned(),
            role: PrimvarRole::Primvar,
            meaning: Meaning::Plain,
            half: false,
            interpolation: Interpolation::FaceVarying,
            components: 1,
            element_size: 1,
            values: Values::F32(values),
            indices: indices.map(Arc::new),
        }
    }
}
