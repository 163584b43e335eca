//! Reader of `tests/golden/*.bin`: subdivided meshes, made with Pixar OpenSubdiv.
//!
//! The format is described in `xtask/src/golden.rs`; `cargo xtask golden` makes the files.

use std::path::Path;

/// Refinement scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// `bilinear`
    Bilinear,
    /// `catmullClark`
    CatmullClark,
    /// `loop`, on triangles only
    Loop,
}

/// Rule for the boundary of the mesh (`interpolateBoundary`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// `none`
    None,
    /// `edgeOnly`
    EdgeOnly,
    /// `edgeAndCorner`
    EdgeAndCorner,
}

/// The rules of `faceVaryingLinearInterpolation`, in the order of [`Case::slot_of_rule`].
pub const FACE_VARYING_RULES: [&str; 6] = ["none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"];

/// One mesh with one set of options, and what it refines to.
#[derive(Clone, Debug)]
pub struct Case {
    /// Scheme and shape; the options are not part of it.
    pub name: String,
    /// Refinement scheme.
    pub scheme: Scheme,
    /// Boundary rule.
    pub boundary: Boundary,
    /// `triangleSubdivisionRule` is `smooth` (of effect with catmullClark only).
    pub smooth_triangles: bool,
    /// The slot with the face-varying values of each of [`FACE_VARYING_RULES`].
    pub slot_of_rule: [usize; 6],
    /// Number of distinct slots.
    pub slots: usize,
    /// Points of the base mesh.
    pub points: Vec<[f32; 3]>,
    /// A varying value per point.
    pub varying: Vec<[f32; 2]>,
    /// Vertex count of each base face.
    pub face_vertex_counts: Vec<usize>,
    /// Vertices of the base faces.
    pub face_vertex_indices: Vec<usize>,
    /// Edge sharpness by end vertices; 10 and more is infinite. Later entries win.
    pub creases: Vec<(usize, usize, f32)>,
    /// Vertex sharpness.
    pub corners: Vec<(usize, f32)>,
    /// Hole faces.
    pub holes: Vec<usize>,
    /// Face-varying values of the base mesh.
    pub uvs: Vec<[f32; 2]>,
    /// One index into `uvs` per base face-vertex.
    pub uv_indices: Vec<usize>,
    /// Levels 1, 2 and 3.
    pub levels: Vec<Level>,
}

/// One level of refinement.
#[derive(Clone, Debug)]
pub struct Level {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces, holes included.
    pub faces: usize,
    /// Number of face-vertices.
    pub face_vertices: usize,
    /// Sum of the point over all corners of all faces.
    pub point_sum: [f64; 3],
    /// Sum of the varying value over all corners.
    pub varying_sum: [f64; 2],
    /// Per slot, sum of the face-varying value over all corners.
    pub uv_sums: Vec<[f64; 2]>,
    /// Sum over all corners of the sharpness of the edge to the next corner.
    pub sharpness_sum: f64,
    /// Evenly strided faces, in order.
    pub samples: Vec<Face>,
}

/// One face of a level.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its index in the level.
    pub index: usize,
    /// The face of the base mesh it stems from.
    pub base_face: usize,
    /// The base face is a hole, by itself or by the boundary rule.
    pub hole: bool,
    /// Corners in OpenSubdiv's order.
    pub corners: Vec<Corner>,
}

/// One corner of a face.
#[derive(Clone, Debug)]
pub struct Corner {
    /// Vertex of the level.
    pub vertex: usize,
    /// Refined point.
    pub point: [f32; 3],
    /// Refined varying value.
    pub varying: [f32; 2],
    /// Refined face-varying value of each slot.
    pub uvs: Vec<[f32; 2]>,
    /// Sharpness of the edge from this corner to the next.
    pub edge_sharpness: f32,
    /// Sharpness of the vertex.
    pub vertex_sharpness: f32,
}

/// Reads one file; panics where it is missing or malformed, as tests want.
pub fn load(path: impl AsRef<Path>) -> Vec<Case> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut reader = Reader { bytes: &bytes };
    assert_eq!(&reader.take::<8>(), b"SUBDGOLD", "{}", path.display());
    assert_eq!(reader.u32(), 1, "version of {}", path.display());
    let count = reader.u32();
    let cases = reader.list(count, case);
    assert!(reader.bytes.is_empty(), "{}: too long", path.display());
    cases
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.bytes.split_first_chunk().expect("file is too short");
        self.bytes = rest;
        *head
    }
    fn u8(&mut self) -> usize {
        usize::from(self.take::<1>()[0])
    }
    fn u16(&mut self) -> usize {
        usize::from(u16::from_le_bytes(self.take()))
    }
    fn u32(&mut self) -> usize {
        u32::from_le_bytes(self.take()) as usize
    }
    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }
    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
    fn f32s<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.f32())
    }
    fn f64s<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.f64())
    }
    fn list<T>(&mut self, count: usize, mut item: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..count).map(|_| item(self)).collect()
    }
    /// A `u32` count and that many items.
    fn counted<T>(&mut self, item: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let count = self.u32();
        self.list(count, item)
    }
}

fn case(r: &mut Reader) -> Case {
    let length = r.u16();
    let name = String::from_utf8(r.list(length, |r| r.take::<1>()[0])).expect("name is UTF-8");
    let scheme = match r.u8() {
        0 => Scheme::Bilinear,
        1 => Scheme::CatmullClark,
        2 => Scheme::Loop,
        other => panic!("{name}: scheme {other}"),
    };
    let boundary = match r.u8() {
        0 => Boundary::None,
        1 => Boundary::EdgeOnly,
        2 => Boundary::EdgeAndCorner,
        other => panic!("{name}: boundary {other}"),
    };
    let smooth_triangles = r.u8() == 1;
    let slots = r.u8();
    let slot_of_rule = std::array::from_fn(|_| r.u8());
    let (points, varying) = r.counted(|r| (r.f32s(), r.f32s())).into_iter().unzip();
    let face_vertex_counts = r.counted(Reader::u16);
    let face_vertex_indices = r.counted(Reader::u16);
    let creases = r.counted(|r| (r.u16(), r.u16(), r.f32()));
    let corners = r.counted(|r| (r.u16(), r.f32()));
    let holes = r.counted(Reader::u16);
    let uvs = r.counted(Reader::f32s);
    let uv_indices = r.list(face_vertex_indices.len(), Reader::u16);
    let levels = r.list(3, |r| level(r, slots));
    Case {
        name,
        scheme,
        boundary,
        smooth_triangles,
        slot_of_rule,
        slots,
        points,
        varying,
        face_vertex_counts,
        face_vertex_indices,
        creases,
        corners,
        holes,
        uvs,
        uv_indices,
        levels,
    }
}

fn level(r: &mut Reader, slots: usize) -> Level {
    Level {
        vertices: r.u32(),
        edges: r.u32(),
        faces: r.u32(),
        face_vertices: r.u32(),
        point_sum: r.f64s(),
        varying_sum: r.f64s(),
        uv_sums: r.list(slots, Reader::f64s),
        sharpness_sum: r.f64(),
        samples: r.counted(|r| face(r, slots)),
    }
}

fn face(r: &mut Reader, slots: usize) -> Face {
    let index = r.u32();
    let base_face = r.u16();
    let hole = r.u8() & 1 == 1;
    let count = r.u8();
    Face { index, base_face, hole, corners: r.list(count, |r| corner(r, slots)) }
}

fn corner(r: &mut Reader, slots: usize) -> Corner {
    let vertex = r.u32();
    let flags = r.u8();
    let point = r.f32s();
    let varying = r.f32s();
    let uv = r.f32s();
    let edge_sharpness = if flags & 1 != 0 { r.f32() } else { 0.0 };
    let vertex_sharpness = if flags & 2 != 0 { r.f32() } else { 0.0 };
    let mut uvs = vec![uv];
    for slot in 1..slots {
        uvs.push(if flags & (2 << slot) != 0 { r.f32s() } else { uv });
    }
    Corner { vertex, point, varying, uvs, edge_sharpness, vertex_sharpness }
}
