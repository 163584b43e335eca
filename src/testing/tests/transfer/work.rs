//! How the work of searches grows with a garment: as n log n, whatever its edge sets and targets are.

use crate::built::{Built, build};
use tailor_mesh::Garment;
use tailor_mesh::garment::{Elements, SubsetInput};
use tailor_testing::sheets::{grid_faces, mesh, with_edges};

/// The growth that n log n allows from one size to one four times as large, with room for small sizes.
const GROWTH: f64 = 4.0 * 1.4;

/// A flat grid without attributes.
fn grid(nx: usize, ny: usize) -> Garment {
    let faces = grid_faces(nx, ny, |_, _| true);
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let points = (0..(nx + 1) * (ny + 1)).map(|i| [(i % (nx + 1)) as f32, (i / (nx + 1)) as f32, 0.0]);
    bare(mesh(points, &faces))
}

/// A fan of `n` triangles, with its spokes as an edge set.
fn star(n: usize) -> Garment {
    let rim = (0..n).map(|i| std::f32::consts::TAU * i as f32 / n as f32).map(|a| [a.cos(), a.sin(), 0.0]);
    let faces: Vec<[i32; 3]> = (0..n as i32).map(|i| [0, i + 1, (i + 1) % n as i32 + 1]).collect();
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 3]>::as_slice).collect();
    let spokes: Vec<[i32; 2]> = (1..=n as i32).map(|i| [0, i]).collect();
    with_edges(bare(mesh(std::iter::once([0.0; 3]).chain(rim), &faces)), "set", &spokes)
}

fn bare(mut input: Garment) -> Garment {
    input.primvars.clear();
    input.subsets.clear();
    input.families.clear();
    input
}

/// A mesh with all of its edges as one set.
fn with_all_edges(input: Garment) -> Garment {
    let (mut all, mut first) = (Vec::new(), 0);
    for &n in &input.face_vertex_counts {
        let face = &input.face_vertex_indices[first..first + n as usize];
        all.extend((0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()])).map(|(a, b)| [a.min(b), a.max(b)]));
        first += n as usize;
    }
    all.sort_unstable();
    all.dedup();
    with_edges(input, "set", &all)
}

/// A spine with teeth, on a grid.
fn comb(n: usize) -> Garment {
    let at = |x: usize, y: usize| (y * (n + 1) + x) as i32;
    let spine = (0..n).map(|x| [at(x, 1), at(x + 1, 1)]);
    let teeth = (0..=n).flat_map(|x| (1..n).map(move |y| [at(x, y), at(x, y + 1)]));
    with_edges(grid(n, n), "set", &spine.chain(teeth).collect::<Vec<_>>())
}

/// The triangles and vertices that searches for the paths of the sets visited.
fn visited(built: &Built) -> usize {
    let product = built.product();
    built.transferred(&product, built.options()).curves.iter().map(|curve| curve.visited).sum()
}

/// A name, and the garments of a size and of one four times as large.
fn cases() -> Vec<(&'static str, [Garment; 2])> {
    vec![
        ("line", [40, 160].map(|n| with_all_edges(grid(n, 1)))),
        ("grid", [8, 16].map(|n| with_all_edges(grid(n, n)))),
        ("comb", [8, 16].map(comb)),
        ("star", [40, 160].map(star)),
    ]
}

#[test]
fn searches_for_paths_grow_as_n_log_n() {
    for (name, inputs) in cases() {
        // Targets shorter and longer than the edges of the set, which cannot be laid apart then.
        for length in [0.5, 3.0] {
            let length = if name == "star" { 0.1 * length } else { length };
            let [small, large] = inputs.clone().map(|input| {
                let built = build(input, &[&format!("sim.maxEdgeLength={length}"), "cloth.physics="]);
                visited(&built) as f64
            });
            // What is allowed to a set however small it is.
            let least = 1.0e6;
            assert!(large < GROWTH * small.max(least), "{name} at {length}: {small} grows to {large}");
        }
    }
}

#[test]
fn searches_of_a_path_end_where_targets_are_much_longer_than_edges() {
    // The corridor of each edge would hold the whole sheet.
    let input = with_all_edges(grid(24, 24));
    let edges = input.subsets[0].indices.len() / 2;
    let built = build(input, &["sim.maxEdgeLength=12", "cloth.physics="]);
    let of_an_edge = visited(&built) / edges;
    assert!(of_an_edge < 50_000, "{of_an_edge} for each of {edges} edges");
    assert!(built.warnings.iter().any(|w| w.place == "subset set"), "what cannot be laid apart is reported");
}

#[test]
fn far_points_without_a_face_get_the_nearest_vertex() {
    let (n, count) = (20, 10_000);
    for far in [1e7 * n as f32, 1e30] {
        let mut input = grid(n, n);
        let first = input.points.len() as i32;
        input.points.extend((0..count).map(|_| glam::Vec3::new(far, 0.5 * far, 0.1 * far)));
        let indices = (first..first + count).collect();
        let (element_type, family) = ("point".into(), String::new());
        input.subsets.push(SubsetInput { name: "far".into(), element_type, family, indices });
        let built = build(input, &["cloth.physics="]);
        let mesh = &built.products.sim;
        let Some(Elements::Points(found)) = mesh.subset("far").map(|s| &s.elements) else { panic!("no points") };
        let last = mesh.points.ids().max_by(|&a, &b| {
            let along = |v| mesh.points[v].dot(glam::Vec3::new(1.0, 0.5, 0.1));
            along(a).total_cmp(&along(b))
        });
        assert_eq!(found.first().copied(), last, "{far}");
        assert_eq!(found.len(), 1, "all are in one direction");
    }
}
