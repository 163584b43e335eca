//! Intersections of small cages.

use crate::contact::{RefinedFaces, WorkLimit};
use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, Faces, IdVec, VertexId};
use tailor_mesh::garment::{Mesh, Scheme, SubdivisionRules};
use tailor_testing::cage::Cage;

/// The intersecting pairs of a quad on the ground and one that stands on its first vertex and goes there by `run` and `rise`.
fn intersecting(run: f32, rise: f32) -> Vec<[FaceId; 2]> {
    let at = |along: f32, z: f32| Vec3::new(run * along, 0.8 * run * along, z + rise * along);
    let standing = [at(0.5, -0.6), at(1.0, -0.1), at(0.5, 0.4)];
    let points = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y].into_iter().chain(standing);
    let corners: Vec<VertexId> = [0, 1, 2, 3, 0, 4, 5, 6].map(VertexId::new).to_vec();
    let cage = Cage::new(Mesh {
        points: points.collect(),
        faces: Faces::quads(corners),
        rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
        ..Mesh::default()
    });
    let all = [0, 1].map(FaceId::new);
    RefinedFaces::new(cage.level(), cage.level().vertex_rows(), &cage.garment().points, &all, None)
        .intersecting_pairs(&all, &WorkLimit::default())
}

#[test]
fn a_sliver_may_overlap_a_flat_neighbour() {
    let pentagon = [[0.0, 0.0], [2.0, -1.0], [3.0, 0.5], [2.0, 2.0], [0.5, 1.5]];
    let points = pentagon.map(|[x, y]| Vec3::new(x, y, 0.0));
    let across = |rise: f32| [Vec3::new(1.0, 0.2, rise), Vec3::new(1.0, 0.35, -0.6 * rise)];
    let intersecting = |rise: f32| {
        let cage = Cage::new(Mesh {
            points: points.into_iter().chain(across(rise)).collect(),
            faces: Faces::mixed([5, 3], [0, 1, 2, 3, 4, 0, 5, 6].map(VertexId::new).to_vec()),
            rules: SubdivisionRules { scheme: Scheme::Bilinear, ..SubdivisionRules::default() },
            ..Mesh::default()
        });
        let all = [0, 1].map(FaceId::new);
        let rest_normals = IdVec::filled(Vec3::Z, 2);
        let faces = RefinedFaces::new(
            cage.level(),
            cage.level().vertex_rows(),
            &cage.garment().points,
            &all,
            Some(&rest_normals),
        );
        let slivers = all.into_iter().filter(|&face| !faces.is_smooth(face)).collect::<Vec<_>>();
        (faces.intersecting_pairs(&slivers, &WorkLimit::default()), slivers)
    };
    let [pentagon, triangle] = [0, 1].map(FaceId::new);
    assert_eq!(intersecting(0.02), (vec![[pentagon, triangle]], vec![triangle]));
}

/// Two quads with a common edge, almost in one plane.
fn neighbours(random: &mut impl FnMut() -> f32, scheme: Scheme) -> Cage {
    let mut at = |x: f32, y: f32| {
        let z = 0.1 * random();
        Vec3::new(x + 1.4 * random(), y + 1.4 * random(), z)
    };
    let first = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
    let others = [at(0.0, -1.0), at(1.0, -1.0)];
    Cage::new(Mesh {
        points: first.into_iter().chain(others).collect(),
        faces: Faces::quads([0, 1, 2, 3, 1, 0, 4, 5].map(VertexId::new).to_vec()),
        rules: SubdivisionRules { scheme, ..SubdivisionRules::default() },
        ..Mesh::default()
    })
}

#[test]
fn neighbours_intersect_where_their_children_do() {
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1u32 << 24) as f32 - 0.5
    };
    let (mut found, mut missed) = (0, Vec::new());
    for number in 0..40_000 {
        let scheme = [Scheme::CatmullClark, Scheme::Bilinear][number % 2];
        let cage = neighbours(&mut random, scheme);
        let all = [0, 1].map(FaceId::new);
        let points = &cage.garment().points;
        let faces = RefinedFaces::new(cage.level(), cage.level().vertex_rows(), points, &all, None);
        let intersect = !faces.intersecting_children(all[0], all[1]).is_empty();
        found += usize::from(intersect);
        if intersect && !faces.intersecting_pairs(&all, &WorkLimit::default()).contains(&all) {
            missed.push(number);
        }
    }
    assert!(found > 100, "{found}");
    assert!(missed.is_empty(), "{} of {found}: {:?}", missed.len(), &missed[..missed.len().min(9)]);
}

#[test]
fn faces_may_intersect_at_a_common_vertex() {
    let both = [0, 1].map(FaceId::new);
    assert_eq!(intersecting(1.0, 0.0), [both]);
    assert_eq!(intersecting(1.0, -0.2), [both]);
    assert!(intersecting(-1.0, 0.0).is_empty());
    assert!(intersecting(1.0, 2.0).is_empty());
}
