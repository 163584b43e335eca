//! Tiny garments, one trouble each, made in code.

use super::sheets::{grid, grid_faces, mesh, tube, with_edges, with_uvs};
use glam::Vec3;
use tailor_mesh::garment::{BoundaryInterpolation, Garment, Orientation, Scheme, Values};

/// A whole grid.
fn sheet(nx: usize, ny: usize) -> Garment {
    grid(nx, ny, |_, _| true)
}

fn cube() -> Garment {
    let points = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]);
    mesh(points, &[&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]])
}

/// Each face is a shell of its own.
fn islands(mut input: Garment) -> Garment {
    input.primvars.retain(|p| p.name != "st");
    let start: Vec<i32> = input
        .face_vertex_counts
        .iter()
        .scan(0, |at, &n| {
            *at += n;
            Some(*at - n)
        })
        .collect();
    let (indices, counts) = (input.face_vertex_indices.clone(), input.face_vertex_counts.clone());
    with_uvs(input, move |face, v| {
        let corners = &indices[start[face] as usize..][..counts[face] as usize];
        let k = corners.iter().position(|&c| c as usize == v).unwrap_or(0);
        let angle = k as f32 / corners.len() as f32 * std::f32::consts::TAU;
        [3.0 * face as f32 + angle.cos(), angle.sin()]
    })
}

/// Triangles around one vertex, or two poles of a closed ball of them.
fn pole(n: i32, closed: bool) -> Garment {
    let ring = (0..n).map(|i| {
        let angle = i as f32 / n as f32 * std::f32::consts::TAU;
        [angle.cos(), angle.sin(), 0.0]
    });
    let points = ring.chain([[0.0, 0.0, 0.5]]).chain(closed.then_some([0.0, 0.0, -0.5]));
    let mut faces: Vec<Vec<i32>> = (0..n).map(|i| vec![i, (i + 1) % n, n]).collect();
    if closed {
        faces.extend((0..n).map(|i| vec![(i + 1) % n, i, n + 1]));
    }
    mesh(points, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

fn moebius(n: usize) -> Garment {
    let points = (0..2 * n).map(|i| {
        let (turn, side) = ((i / 2) as f32 / n as f32, if i % 2 == 0 { -0.4 } else { 0.4 });
        let (around, half) = (turn * std::f32::consts::TAU, turn * std::f32::consts::PI);
        let r = 1.5 + side * half.cos();
        [r * around.cos(), r * around.sin(), side * half.sin()]
    });
    let faces: Vec<Vec<i32>> = (0..n as i32)
        .map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 == n as i32 { (1, 0) } else { (2 * i + 2, 2 * i + 3) };
            vec![a, c, d, b]
        })
        .collect();
    mesh(points, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

fn triangles() -> Garment {
    let quads = grid_faces(3, 2, |_, _| true);
    let faces: Vec<Vec<i32>> = quads.iter().flat_map(|q| [vec![q[0], q[1], q[2]], vec![q[0], q[2], q[3]]]).collect();
    let points = (0..12).map(|i| [(i % 4) as f32, (i / 4) as f32, 0.1 * (i % 3) as f32]);
    let input = mesh(points, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>());
    with_uvs(input, |_, v| [(v % 4) as f32, (v / 4) as f32])
}

fn scaled(mut input: Garment, scale: f32, offset: Vec3) -> Garment {
    input.points.iter_mut().for_each(|p| *p = *p * scale + offset);
    input
}

fn change(mut input: Garment, edit: impl FnOnce(&mut Garment)) -> Garment {
    edit(&mut input);
    input
}

/// A sheet and the same again, on its own points.
fn doubled() -> Garment {
    let faces = grid_faces(2, 2, |_, _| true);
    let twin: Vec<Vec<i32>> = faces.iter().map(|f| f.iter().map(|v| v + 9).collect()).collect();
    let all: Vec<&[i32]> = faces.iter().chain(&twin).map(Vec::as_slice).collect();
    with_uvs(mesh((0..18).map(|i| [(i % 9 % 3) as f32, (i % 9 / 3) as f32, 0.0]), &all), |_, v| {
        [(v % 9 % 3) as f32, (v % 9 / 3) as f32]
    })
}

/// All of the zoo, by name.
pub fn all() -> Vec<(&'static str, Garment)> {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    vec![
        ("strip", sheet(6, 1)),
        ("long strip", sheet(40, 1)),
        ("sheet", sheet(3, 3)),
        ("tube", tube(6, 3)),
        ("tube of three", tube(3, 1)),
        ("closed cube", cube()),
        ("single quad", mesh(square, &[&[0, 1, 2, 3]])),
        ("single triangle", mesh(square, &[&[0, 1, 2]])),
        ("concave quad", mesh([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]], &[&[0, 1, 2, 3]])),
        ("bow-tie vertex", grid(2, 2, |x, y| x == y)),
        ("fin", {
            let points = [
                [0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [-1.0, 0.0, 0.0],
                [-1.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.0, 1.0, 1.0],
            ];
            mesh(points, &[&[0, 2, 3, 1], &[1, 5, 4, 0], &[0, 6, 7, 1]])
        }),
        (
            "flipped face",
            change(sheet(3, 3), |i| {
                i.face_vertex_indices[16..20].reverse();
                // The UVs of the face turn with it.
                if let Some(Values::F32(v)) = i.primvars.last_mut().map(|p| &mut p.values) {
                    let turned: Vec<f32> = v[32..40].chunks(2).rev().flatten().copied().collect();
                    v[32..40].copy_from_slice(&turned);
                }
            }),
        ),
        ("Moebius strip", moebius(12)),
        (
            "face on a line",
            mesh(
                [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
                &[&[0, 1, 4, 3], &[0, 2, 1]],
            ),
        ),
        ("quads squashed to a line", change(sheet(3, 3), |i| (0..4).for_each(|k| i.points[4 + k] = i.points[8 + k]))),
        (
            "face of one place",
            change(sheet(3, 3), |i| [5, 6, 9, 10].iter().for_each(|&k| i.points[k] = Vec3::new(1.5, 1.5, 0.0))),
        ),
        ("uv island", islands(sheet(3, 3))),
        ("cube of islands", islands(cube())),
        ("no area in UV", with_uvs(mesh(square, &[&[0, 1, 2, 3]]), |_, _| [0.5, 0.5])),
        ("left-handed", change(sheet(3, 2), |i| i.orientation = Orientation::LeftHanded)),
        ("n-gons", {
            let ring = |r: f32, n: usize| {
                (0..n).map(move |i| {
                    let a = i as f32 / n as f32 * std::f32::consts::TAU;
                    [r * a.cos(), r * a.sin(), 0.3 * r]
                })
            };
            mesh(
                ring(1.0, 5).chain(ring(2.0, 5)),
                &[&[0, 1, 2, 3, 4], &[0, 5, 6, 1], &[1, 6, 7, 2], &[2, 7, 8, 9, 4, 3]],
            )
        }),
        ("two components on one another", doubled()),
        ("duplicate face", mesh(square, &[&[0, 1, 2, 3], &[0, 1, 2, 3]])),
        ("back to back", mesh(square, &[&[0, 1, 2, 3], &[3, 2, 1, 0]])),
        ("tiny", scaled(sheet(3, 3), 1e-4, Vec3::ZERO)),
        ("huge", scaled(sheet(3, 3), 1e5, Vec3::ZERO)),
        ("pole of 64", pole(64, false)),
        ("ball of two poles", pole(64, true)),
        ("isolated point", change(sheet(2, 2), |i| i.points[8] = Vec3::new(9.0, 9.0, 9.0))),
        ("unused points", grid(3, 3, |x, y| x > 0 && y > 0)),
        ("no UVs", change(sheet(3, 2), |i| i.primvars.truncate(5))),
        ("loop", change(triangles(), |i| i.rules.scheme = Scheme::Loop)),
        ("triangles", triangles()),
        ("bilinear", change(sheet(3, 2), |i| i.rules.scheme = Scheme::Bilinear)),
        ("polygons", change(sheet(3, 2), |i| i.rules.scheme = Scheme::None)),
        ("hole", change(sheet(3, 3), |i| i.hole_indices = vec![4])),
        ("holes that touch", change(sheet(4, 4), |i| i.hole_indices = vec![5, 10])),
        ("hole at the border", change(sheet(3, 3), |i| i.hole_indices = vec![0, 1])),
        ("border faces not drawn", change(sheet(4, 4), |i| i.rules.boundary = BoundaryInterpolation::None)),
        ("annulus", grid(3, 3, |x, y| (x, y) != (1, 1))),
        (
            "creased",
            change(sheet(3, 3), |i| {
                i.crease_indices = vec![5, 6, 10, 9, 5];
                i.crease_lengths = vec![5];
                i.crease_sharpnesses = vec![10.0];
                i.corner_indices = vec![0];
                i.corner_sharpnesses = vec![3.0];
            }),
        ),
        ("dart", {
            // A constraint that begins at the border and ends inside.
            with_edges(sheet(4, 4), "line", &[[2, 7], [7, 12]])
        }),
        (
            "constraints that cross",
            with_edges(
                sheet(4, 4),
                "line",
                &[[2, 7], [7, 12], [12, 17], [17, 22], [10, 11], [11, 12], [12, 13], [13, 14]],
            ),
        ),
        (
            "constrained loop",
            with_edges(
                sheet(4, 4),
                "line",
                &[[6, 7], [7, 8], [8, 13], [13, 18], [18, 17], [17, 16], [16, 11], [11, 6]],
            ),
        ),
        ("every edge constrained", {
            let edges: Vec<[i32; 2]> = (0..3)
                .flat_map(|y| (0..2).map(move |x| [y * 3 + x, y * 3 + x + 1]))
                .chain((0..2).flat_map(|y| (0..3).map(move |x| [y * 3 + x, y * 3 + x + 3])))
                .collect();
            with_edges(sheet(2, 2), "line", &edges)
        }),
        (
            "folded flat",
            change(sheet(4, 2), |i| {
                i.points.iter_mut().for_each(|p| *p = Vec3::new(2.0 - (p.x - 2.0).abs(), p.y, 0.0));
            }),
        ),
        ("needle", change(sheet(3, 3), |i| i.points.iter_mut().for_each(|p| p.y *= 1e-3))),
    ]
}
