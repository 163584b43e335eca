//! Rims: the turns of cloth with two layers that are nearer to each other than the target length, as a turned hem, a collar or a piped edge.

use super::{MAX_FACES, baseline, prepare};
use crate::prepared::of_file;
use crate::quality::{Reference, of_product};
use rayon::prelude::*;
use tailor::report::facing;
use tailor::sim::{ChainKind, SimProduct, simulate};
use tailor_mesh::garment::Garment;
use tailor_testing::garments::garments;
use tailor_testing::sheets::{mesh, with_uvs};

/// The target length of the made garments, in whose units they are made. \[mesh units\]
const LENGTH: &str = "sim.maxEdgeLength=1";

/// Shares of a mesh's triangles that may be more than 90 and more than 60 degrees from the surface that they lie on.
fn assert_faces_surface(product: &SimProduct, name: &str, [against, steep]: [f32; 2]) {
    let angles = facing(product);
    for (most, allowed) in [(90.0, against), (60.0, steep)] {
        let beyond = angles.iter().filter(|&&angle| angle > most).count();
        let share = beyond as f32 / angles.len() as f32;
        assert!(share <= allowed, "{name}: {beyond} of {} triangles are beyond {most} degrees", angles.len());
    }
}

fn product(input: Garment, options: &[&str]) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES)
}

/// A surface of revolution around z through the points `(radius, height)` of a profile, cut into `around` faces.
fn revolved(profile: &[[f32; 2]], around: usize) -> Garment {
    let n = around as i32;
    let rows = 0..profile.len() as i32 - 1;
    let quad = |y: i32, x: i32| vec![y * n + x, y * n + (x + 1) % n, (y + 1) * n + (x + 1) % n, (y + 1) * n + x];
    let faces: Vec<Vec<i32>> = rows.flat_map(|y| (0..n).map(move |x| quad(y, x))).collect();
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let points = profile.iter().flat_map(|&[radius, height]| {
        (0..around).map(move |x| {
            let angle = x as f32 / around as f32 * std::f32::consts::TAU;
            [radius * angle.cos(), radius * angle.sin(), height]
        })
    });
    with_uvs(mesh(points, &faces), move |face, v| {
        let (x, y) = (v % around, v / around);
        let wraps = face % around == around - 1 && x == 0;
        [if wraps { around as f32 } else { x as f32 }, y as f32]
    })
}

/// A garment with a rim whose layers are so far apart. \[target lengths\]
type Made = fn(f32) -> Garment;

/// A tube with a hem that is turned to its inside, whose layers are `gap` target lengths apart.
fn hem(gap: f32) -> Garment {
    let inner = 6.0 - gap;
    revolved(
        &[[inner, 3.0], [inner, 1.5], [inner, 0.0], [6.0, 0.0], [6.0, 1.5], [6.0, 3.0], [6.0, 6.0], [6.0, 9.0]],
        24,
    )
}

/// A tube that ends in a thin round bead, as piping does.
fn piping(radius: f32) -> Garment {
    let bead = (0..7).map(|k| {
        let angle = (60.0 - 50.0 * k as f32).to_radians();
        [6.0 + radius * angle.cos(), radius * angle.sin()]
    });
    let profile: Vec<[f32; 2]> = [[6.0, 6.0], [6.0, 3.0], [6.0, 1.5]].into_iter().chain(bead).collect();
    revolved(&profile.into_iter().rev().collect::<Vec<_>>(), 24)
}

/// A band that is folded along its upper edge, open at both ends, as a collar is.
fn collar(gap: f32) -> Garment {
    let profile = [[6.0 - gap, 0.0], [6.0 - gap, 1.5], [6.0 - gap, 3.0], [6.0, 3.0], [6.0, 1.5], [6.2, 0.0]];
    let mut input = revolved(&profile, 24);
    // All faces but those of a quarter.
    let keep = |face: usize| face % 24 < 18;
    let kept: Vec<[i32; 4]> = input
        .face_vertex_indices
        .chunks_exact(4)
        .enumerate()
        .filter(|(f, _)| keep(*f))
        .map(|(_, q)| [q[3], q[2], q[1], q[0]])
        .collect();
    input = mesh(input.points.iter().map(|p| p.to_array()), &kept.iter().map(|q| q.as_slice()).collect::<Vec<_>>());
    with_uvs(input, |_, v| [(v % 24) as f32, (v / 24) as f32])
}

/// Distances between the layers of rims. \[target lengths\]
const GAPS: [f32; 7] = [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0];

#[test]
fn triangles_face_the_surface_beside_rims() {
    let made = [("hem", hem as Made), ("collar", collar), ("piping", piping)];
    for (name, make) in made {
        for gap in GAPS {
            // A bead has a border inside, and is drawn flat beside it.
            let steep = if name == "piping" { 0.13 } else { 0.001 };
            assert_faces_surface(&product(make(gap), &[LENGTH]), &format!("{name} {gap}"), [0.0, steep]);
        }
    }
}

#[test]
fn triangles_of_garments_face_the_surface() {
    garments().into_par_iter().for_each(|file| {
        let prepared = of_file(&file, []);
        let product = simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES);
        // One triangle inside the collar of a suit does.
        let against = 1.0 / product.triangles.len() as f32;
        assert_faces_surface(&product, &file.display().to_string(), [against, 0.001]);
    });
}

#[test]
fn rims_are_feature_lines() {
    for (name, make) in [("hem", hem as Made), ("collar", collar)] {
        for gap in GAPS.into_iter().filter(|&gap| gap <= 0.35) {
            let product = product(make(gap), &[LENGTH]);
            // The surface is highest along the rim's middle; no point of it is far from the mesh.
            let quality = Reference::of(&product, |reference| of_product(&product, reference));
            assert!(quality.from_surface <= 0.11, "{name} {gap}: {}", quality.from_surface);
            let lines: Vec<_> =
                product.baseline.chains.enumerated().filter(|(_, c)| c.kind == ChainKind::FEATURE).collect();
            assert!(!lines.is_empty(), "{name} {gap}");
            for (id, chain) in lines {
                assert!(product.gaps[id].distance <= 0.05, "{name} {gap}: {}", product.gaps[id].distance);
                let on_mesh: f32 =
                    product.chain_edges[id].iter().map(|&[a, b]| product.points[a].distance(product.points[b])).sum();
                assert!(on_mesh >= 0.97 * chain.length(), "{name} {gap}: {on_mesh} of {}", chain.length());
            }
        }
    }
}

#[test]
fn folds_follow_the_option() {
    let lines = |angle: &str| {
        let product = product(hem(0.2), &[LENGTH, angle]);
        product.baseline.chains.iter().filter(|c| c.kind.feature).count()
    };
    assert!(lines("sim.featureAngle=90") > 0);
    assert_eq!(lines("sim.featureAngle=180"), 0);
}
