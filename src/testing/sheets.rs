//! Grids, tubes and any faces as garments, made in code, with an attribute of each kind.

use glam::Vec3;
use tailor_mesh::garment::{Family, FamilyType, Garment, Interpolation, Meaning, PrimvarInput, SubsetInput, Values};

/// A mesh of the given faces.
pub fn mesh(points: impl IntoIterator<Item = [f32; 3]>, faces: &[&[i32]]) -> Garment {
    dressed(Garment {
        prim: "/Zoo/model".into(),
        points: points.into_iter().map(Vec3::from).collect(),
        face_vertex_counts: faces.iter().map(|f| f.len() as i32).collect(),
        face_vertex_indices: faces.concat(),
        ..Garment::default()
    })
}

/// A mesh with an attribute of each kind and a partition.
fn dressed(mut input: Garment) -> Garment {
    let (points, faces) = (input.points.len(), input.face_vertex_counts.len());
    let floats = |n: usize, f: fn(usize) -> f32| Values::F32((0..n).map(f).collect());
    input.primvars = vec![
        PrimvarInput::new("density", Interpolation::Vertex, floats(points, |i| (i % 3) as f32 / 2.0)),
        PrimvarInput::new("tint", Interpolation::Varying, floats(points, |i| (i % 5) as f32)),
        PrimvarInput::new("ply", Interpolation::Uniform, Values::I32((0..faces as i32).collect())),
        PrimvarInput {
            element_size: 2,
            ..PrimvarInput::new(
                "skel:jointIndices",
                Interpolation::Vertex,
                Values::I32((0..points as i32).flat_map(|i| [i % 4, 4 + i % 3]).collect()),
            )
        },
        PrimvarInput {
            element_size: 2,
            ..PrimvarInput::new("skel:jointWeights", Interpolation::Vertex, floats(2 * points, |i| [0.75, 0.25][i % 2]))
        },
    ];
    let set = |name: &str, rest: usize| SubsetInput {
        name: name.into(),
        element_type: "face".into(),
        family: "panels".into(),
        indices: (0..faces as i32).filter(|f| *f as usize % 2 == rest).collect(),
    };
    input.subsets = vec![set("even", 0), set("odd", 1)];
    input.families = vec![Family { name: "panels".into(), kind: FamilyType::Partition }];
    input
}

/// Gives a mesh UVs, one for each corner.
pub fn with_uvs(mut input: Garment, uv: impl Fn(usize, usize) -> [f32; 2]) -> Garment {
    let mut values = Vec::new();
    let mut corner = 0;
    for (face, &n) in input.face_vertex_counts.iter().enumerate() {
        for _ in 0..n {
            values.extend(uv(face, input.face_vertex_indices[corner] as usize));
            corner += 1;
        }
    }
    let st = PrimvarInput::new("st", Interpolation::FaceVarying, Values::F32(values));
    input.primvars.push(PrimvarInput { meaning: Meaning::TextureCoordinate, components: 2, ..st });
    input
}

/// Gives a mesh an edge subset.
pub fn with_edges(mut input: Garment, name: &str, pairs: &[[i32; 2]]) -> Garment {
    let (element_type, family, indices) = ("edge".into(), String::new(), pairs.concat());
    input.subsets.push(SubsetInput { name: name.into(), element_type, family, indices });
    input
}

/// The faces of a grid of `nx` by `ny` quads that `keep` keeps; points are numbered row by row.
pub fn grid_faces(nx: usize, ny: usize, keep: impl Fn(usize, usize) -> bool) -> Vec<Vec<i32>> {
    let at = |x: usize, y: usize| (y * (nx + 1) + x) as i32;
    let cells = (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y)));
    let quad = |(x, y): (usize, usize)| vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
    cells.filter(|&(x, y)| keep(x, y)).map(quad).collect()
}

/// A grid with UVs, slightly bent.
pub fn grid(nx: usize, ny: usize, keep: impl Fn(usize, usize) -> bool) -> Garment {
    let faces = grid_faces(nx, ny, keep);
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let at = move |i: usize| ((i % (nx + 1)) as f32, (i / (nx + 1)) as f32);
    let points = (0..(nx + 1) * (ny + 1)).map(|i| {
        let (x, y) = at(i);
        [x, y, 0.2 * (0.9 * x).sin() * (0.7 * y).cos()]
    });
    with_uvs(mesh(points, &faces), move |_, v| at(v).into())
}

/// A tube of `around` by `along` quads, its UVs cut along one line.
pub fn tube(around: usize, along: usize) -> Garment {
    let n = around as i32;
    let faces: Vec<Vec<i32>> = (0..along as i32)
        .flat_map(|y| {
            (0..n).map(move |x| vec![y * n + x, y * n + (x + 1) % n, (y + 1) * n + (x + 1) % n, (y + 1) * n + x])
        })
        .collect();
    let points = (0..around * (along + 1)).map(|i| {
        let angle = (i % around) as f32 / around as f32 * std::f32::consts::TAU;
        [angle.cos(), angle.sin(), (i / around) as f32 * 0.7]
    });
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    with_uvs(mesh(points, &faces), move |face, v| {
        let (x, y) = (v % around, v / around);
        let wraps = face % around == around - 1 && x == 0;
        [if wraps { around as f32 } else { x as f32 }, y as f32]
    })
}
