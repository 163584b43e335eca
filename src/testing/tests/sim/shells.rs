//! UV shells that are smaller than triangles of the target length.

use super::{MAX_FACES, baseline, prepare};
use crate::built::build;
use tailor::sim::{SimProduct, simulate};
use tailor_mesh::connectivity::{CornerId, VertexId};
use tailor_mesh::garment::{Garment, Primvar};
use tailor_testing::sheets;

/// A sheet with a shell of its own for each face that `is_alone`, far from the others in UV.
fn sheet(n: usize, is_alone: impl Fn(usize) -> bool) -> Garment {
    let mut input = sheets::grid(n, n, |_, _| true);
    input.primvars.retain(|p| p.name != "st");
    let at = move |v: usize| ((v % (n + 1)) as f32, (v / (n + 1)) as f32);
    sheets::with_uvs(input, move |face, v| {
        let (x, y) = at(v);
        let away = if is_alone(face) { 100.0 * (1 + face) as f32 } else { 0.0 };
        [x + away, y]
    })
}

fn product(input: Garment, options: &[&str]) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES)
}

/// The shortest edge as a share of its target.
fn shortest(product: &SimProduct) -> f32 {
    let share = |a: VertexId, b: VertexId| product.points[a].distance(product.points[b]) / product.target[a];
    product.triangles.iter().flat_map(|&[a, b, c]| [share(a, b), share(b, c), share(c, a)]).fold(f32::MAX, f32::min)
}

/// The extent of a triangle in UV.
fn uv_extent(product: &SimProduct, triangle: usize) -> f32 {
    let uv = |k: usize| product.places[CornerId::new(3 * triangle + k)].uv;
    uv(0).distance(uv(1)).max(uv(1).distance(uv(2)))
}

#[test]
fn tiny_shells_do_not_shorten_edges_unless_asked() {
    // Single faces of a fifth of the target's length.
    let tiny = || sheet(20, |face| face % 4 == 1 && face / 20 % 4 == 1);
    let options = |smallest: &'static str| ["sim.maxEdgeLength=5", smallest];
    let whole = product(sheet(20, |_| false), &options("sim.smallestShell=0"));
    let free = product(tiny(), &options("sim.smallestShell=4"));
    let held = product(tiny(), &options("sim.smallestShell=0"));
    assert_eq!((free.report.small_shells, held.report.small_shells), (25, 0));
    assert!(shortest(&free) > 0.9 * shortest(&whole), "{} of {}", shortest(&free), shortest(&whole));
    assert!(shortest(&held) < 0.3, "{}", shortest(&held));
    assert!(free.baseline.chains.iter().all(|chain| chain.kind.border), "the sheet's border remains");
}

#[test]
fn large_shells_and_named_constraints_stay() {
    // A shell of 100 faces, and a tiny one whose border is a constraint.
    let two = || sheet(20, |face| face % 20 == 3 && face / 20 == 3);
    let border = [[66, 67], [67, 88], [88, 87], [87, 66]];
    let input = sheets::with_edges(two(), "named", &border);
    let kept = product(input, &["sim.maxEdgeLength=2", "sim.constraints=named"]);
    assert_eq!(kept.report.small_shells, 1);
    let chains = kept.baseline.chains.iter().filter(|chain| chain.kind.seam && !chain.kind.border).count();
    assert!(chains > 0, "a named border is a chain");
    let free = product(two(), &["sim.maxEdgeLength=2"]);
    assert!(free.baseline.chains.iter().all(|chain| !chain.kind.seam));
    let large = product(two(), &["sim.maxEdgeLength=0.2"]);
    assert_eq!(large.report.small_shells, 0);
    assert!(large.baseline.chains.iter().any(|chain| chain.kind.seam), "of 57 target triangles");
}

#[test]
fn triangles_across_released_seams_have_the_uvs_of_one_shell() {
    let is_alone = |face: usize| face % 4 == 1 && face / 12 % 4 == 1;
    let free = product(sheet(12, is_alone), &["sim.maxEdgeLength=0.8"]);
    assert!(free.report.small_shells > 0);
    for i in 0..free.triangles.len() {
        // UVs of two shells are 100 apart or more.
        assert!(uv_extent(&free, i) < 10.0, "triangle {i} spans {}", uv_extent(&free, i));
    }
    let away = |i: usize| free.places[CornerId::new(3 * i)].uv.x > 50.0;
    assert!((0..free.triangles.len()).any(away) && !(0..free.triangles.len()).all(away), "both kinds are there");
}

#[test]
fn indices_that_split_equal_uvs_are_no_seams() {
    // Two panels, and indices that each corner has for itself.
    let panels = || sheet(8, |face| face % 8 >= 4 && face < 8);
    let mut split = panels();
    let uvs = split.primvars.iter_mut().find(|p| p.name == "st").expect("UVs");
    uvs.indices = Some((0..4 * 64).collect());
    let options = ["sim.maxEdgeLength=0.5", "sim.smallestShell=0"];
    let [joined, split] = [panels(), split].map(|input| build(input, &options));
    let seams = |product: SimProduct| product.baseline.chains.iter().filter(|chain| chain.kind.seam).count();
    assert_eq!(seams(split.product()), seams(joined.product()));
    assert!(seams(split.product()) > 0, "values that differ are cut");
    let [own, whole] = [&split, &joined].map(|built| &built.products.sim);
    assert_eq!((&own.points, &own.faces, own.primvar("st")), (&whole.points, &whole.faces, whole.primvar("st")));
    // OpenSubdiv refines indices, so each face of the input is a shell of the render mesh.
    let rows = |built: &crate::built::Built| built.products.render.primvar("st").map_or(0, Primvar::rows);
    assert_eq!(rows(&split), 64 * 25);
    assert!(rows(&joined) < 33 * 33 + 100);
}
