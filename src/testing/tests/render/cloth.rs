//! Sheets, tubes and rings with named lines and patches, and their render meshes.

use glam::Vec3;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::garment::{Elements, Garment, Mesh, SubsetInput, check_garment};
use tailor_mesh::subdivide::{Level, carried_points};
use tailor_testing::sheets::{grid_faces, mesh, with_edges, with_uvs};

/// Adds a face subset.
pub fn with_faces(mut input: Garment, name: &str, faces: impl IntoIterator<Item = i32>) -> Garment {
    let (element_type, family, indices) = ("face".into(), String::new(), faces.into_iter().collect());
    input.subsets.push(SubsetInput { name: name.into(), element_type, family, indices });
    input
}

/// The faces of a subset, none where there is no such.
pub fn faces_in(mesh: &Mesh, name: &str) -> BTreeSet<FaceId> {
    match mesh.subset(name).map(|s| &s.elements) {
        Some(Elements::Faces(faces)) => faces.iter().copied().collect(),
        _ => BTreeSet::new(),
    }
}

/// The steps of a path of points.
pub fn path(points: &[i32]) -> Vec<[i32; 2]> {
    points.windows(2).map(|p| [p[0], p[1]]).collect()
}

/// A flat sheet of `n` by `n` unit quads in two panels of UVs, split at column `n / 2`, with the face subset "half".
pub fn sheet(n: usize) -> Garment {
    let faces = grid_faces(n, n, |_, _| true);
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let at = move |i: usize| ((i % (n + 1)) as f32, (i / (n + 1)) as f32);
    let points = (0..(n + 1) * (n + 1)).map(|i| [at(i).0, at(i).1, 0.0]);
    let shell = move |face: usize| if face % n < n / 2 { 0.0 } else { 100.0 };
    let input = with_uvs(mesh(points, &faces), move |f, v| [at(v).0 + shell(f), at(v).1]);
    with_faces(input, "half", (0..n * n).filter(|f| f % n < n / 2).map(|f| f as i32))
}

/// Points and faces of a surface over a grid that closes around, and also along where `closed`.
fn wrapped(around: usize, along: usize, closed: bool, place: impl Fn(f32, f32) -> [f32; 3]) -> Garment {
    let (n, rows) = (around as i32, if closed { along as i32 } else { along as i32 + 1 });
    let at = |x: i32, y: i32| (y % rows) * n + x % n;
    let cells = (0..along as i32).flat_map(|y| (0..n).map(move |x| (x, y)));
    let faces: Vec<[i32; 4]> = cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect();
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 4]>::as_slice).collect();
    let points = (0..rows * n).map(|i| place((i % n) as f32 / n as f32, (i / n) as f32 / along as f32));
    mesh(points, &faces)
}

/// A tube of radius 2 about z with the ring "ring", the line "line" along it and all faces in "all".
pub fn tube() -> Garment {
    let (n, rows) = (16, 8);
    let input = wrapped(n, rows, false, |u, v| {
        let a = u * std::f32::consts::TAU;
        [2.0 * a.cos(), 2.0 * a.sin(), 6.0 * v]
    });
    let ring: Vec<i32> = (0..=n as i32).map(|x| 4 * n as i32 + x % n as i32).collect();
    let line: Vec<i32> = (0..=rows as i32).map(|y| y * n as i32 + 3).collect();
    let input = with_edges(with_edges(input, "ring", &path(&ring)), "line", &path(&line));
    with_faces(input, "all", 0..(n * rows) as i32)
}

/// A ring of radii 3 and 1 with a circle either way, "ring" and "line", and all faces in "all".
pub fn torus() -> Garment {
    let (n, rows) = (24, 12);
    let input = wrapped(n, rows, true, |u, v| {
        let (a, b) = (u * std::f32::consts::TAU, v * std::f32::consts::TAU);
        let r = 3.0 + b.cos();
        [r * a.cos(), r * a.sin(), b.sin()]
    });
    let ring: Vec<i32> = (0..=n as i32).map(|x| 2 * n as i32 + x % n as i32).collect();
    let line: Vec<i32> = (0..=rows as i32).map(|y| (y % rows as i32) * n as i32 + 5).collect();
    let input = with_edges(with_edges(input, "ring", &path(&ring)), "line", &path(&line));
    with_faces(input, "all", 0..(n * rows) as i32)
}

/// The checked garment.
pub fn checked(input: Garment) -> Mesh {
    check_garment(input).unwrap_or_else(|e| panic!("{e}")).0
}

/// Limit positions of a mesh's vertices.
pub fn limit(garment: &Mesh) -> IdVec<VertexId, Vec3> {
    carried_points(&&Level::base(garment).limit_rows(), &garment.points)
}
