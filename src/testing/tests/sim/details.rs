//! Details that the simulation mesh leaves out (`sim.smooth`).

use super::{baseline, prepare};
use crate::built::{Built, build};
use glam::Vec3;
use tailor::codes;
use tailor_mesh::garment::{Elements, Garment, PrimvarInput, SubsetInput};
use tailor_testing::sheets;
use tailor_testing::zoo;

/// Columns and rows of faces.
const SIZE: [usize; 2] = [16, 10];
/// The option that names the detail.
const SMOOTH: &str = "sim.smooth=detail";

fn with_detail(mut input: Garment, faces: impl Iterator<Item = usize>) -> Garment {
    let (element_type, indices) = ("face".into(), faces.map(|f| f as i32).collect());
    input.subsets.push(SubsetInput { name: "detail".into(), element_type, family: String::new(), indices });
    input
}

/// A slope with a bead of piping in the middle, whose flanks overhang. Its set has two rows of faces around it.
fn piped() -> Garment {
    let [nx, ny] = SIZE;
    let mut input = sheets::grid(nx, ny, |_, _| true);
    input.subsets.clear();
    input.families.clear();
    for (i, point) in input.points.iter_mut().enumerate() {
        let (column, row) = (i % (nx + 1), i / (nx + 1));
        let flat =
            if column <= 6 { column as f32 } else { (column as f32 - 3.2).max(6.0 + 0.2 * (column as f32 - 6.0)) };
        let bead = match column {
            7 => [-0.3, 0.5],
            8 => [0.0, 0.9],
            9 => [0.3, 0.5],
            _ => [0.0, 0.0],
        };
        let [aside, up] = if (3..=ny - 3).contains(&row) { bead } else { [0.0, 0.0] };
        *point = Vec3::new(flat + aside, row as f32, up + 0.5 * (flat + aside));
    }
    let is_in = move |f: &usize| (4..12).contains(&(f % nx)) && (1..ny - 1).contains(&(f / nx));
    with_detail(input, (0..nx * ny).filter(is_in))
}

/// The sheet without its set: a weight is painted on the points inside it.
fn painted(weight: f32) -> Garment {
    let [nx, ny] = SIZE;
    let mut input = piped();
    input.subsets.clear();
    let is_inside = |i: usize| (5..12).contains(&(i % (nx + 1))) && (2..ny - 1).contains(&(i / (nx + 1)));
    let weights = (0..input.points.len()).map(|i| if is_inside(i) { weight } else { 0.0 }).collect();
    input.primvars.push(PrimvarInput::weights("detail", weights));
    input
}

/// The largest height over the slope.
fn height(built: &Built) -> f32 {
    built.products.sim.points.iter().map(|p| p.z - 0.5 * p.x).fold(0.0, f32::max)
}

#[test]
fn a_detail_becomes_the_surface_around_it_and_the_render_mesh_keeps_it() {
    let options = ["sim.maxEdgeLength=0.4"];
    let (whole, smooth) = (build(piped(), &options), build(piped(), &[options[0], SMOOTH]));
    assert!(height(&whole) > 0.5, "{}", height(&whole));
    assert!(height(&smooth) < 0.01, "{}", height(&smooth));
    assert_eq!(whole.products.render.points, smooth.products.render.points);
    let figures = |built: &Built| built.products.sim_figures();
    assert!(figures(&smooth).faces < figures(&whole).faces);
    assert!(smooth.warnings.is_empty(), "{:?}", smooth.warnings);
}

#[test]
fn a_painted_weight_blends_between_the_modelled_and_the_fair_surface() {
    let weights = "sim.smoothWeights=detail";
    let surface = |weight: f32| baseline(&prepare(painted(weight), &[weights]));
    let (modelled, half, fair) = (surface(0.0), surface(0.5), surface(1.0));
    assert_eq!(modelled.points, baseline(&prepare(piped(), &[])).points, "a weight of 0 changes nothing");
    let height = |points: &[Vec3]| points.iter().map(|p| p.z - 0.5 * p.x).fold(0.0, f32::max);
    let [whole, middle, none] = [&modelled, &half, &fair].map(|made| height(made.points.as_slice()));
    assert!(whole > 0.5 && none < 0.05, "{whole} {none}");
    assert!((middle - 0.5 * (whole + none)).abs() < 0.02, "{middle} is half way between {whole} and {none}");
    // Where the paint fades, the blend does.
    let between = modelled.points.iter().zip(half.points.iter()).zip(fair.points.iter());
    for ((&modelled, &half), &fair) in between {
        let far = modelled.distance(fair);
        assert!((modelled.distance(half) + half.distance(fair) - far).abs() < 1e-4, "{half} is between");
        assert!(modelled.distance(half) <= 0.5 * far + 1e-4, "{half}");
    }
    let built = build(painted(1.0), &["sim.maxEdgeLength=0.4", weights]);
    assert!(built.warnings.is_empty() && self::height(&built) < 0.1, "{:?}", built.warnings);
}

#[test]
fn the_surface_outside_and_constraints_stay() {
    let [nx, _] = SIZE;
    let at = |y: i32| (nx as i32 + 1) * y + 8;
    let ridge: Vec<[i32; 2]> = (3..7).map(|y| [at(y), at(y + 1)]).collect();
    let input = sheets::with_edges(piped(), "ridge", &ridge);
    let surface = |options: &[&str]| {
        let made = baseline(&prepare(input.clone(), options));
        let chains: Vec<Vec3> =
            made.chains.iter().filter(|c| !c.kind.feature).flat_map(|c| &c.vertices).map(|&v| made.points[v]).collect();
        (made, chains)
    };
    let (whole, _) = surface(&["sim.constraints=ridge"]);
    let (smooth, held) = surface(&["sim.constraints=ridge", SMOOTH]);
    let Some(Elements::Faces(detail)) = build(piped(), &[]).garment.subset("detail").map(|s| s.elements.clone()) else {
        panic!("no detail")
    };
    for (face, source) in smooth.source_face.enumerated() {
        if !detail.contains(source) {
            assert_eq!(smooth.triangle(face), whole.triangle(face), "{source:?} is outside");
        }
    }
    assert!(held.iter().all(|p| whole.points.iter().any(|q| p == q)), "curves of chains stay");
    assert!(held.iter().any(|p| p.z - 0.5 * p.x > 0.5), "the ridge is one");
}

#[test]
fn closed_details_stay_with_a_note() {
    let [nx, ny] = SIZE;
    let sheet = sheets::grid(nx, ny, |_, _| true);
    let first = sheet.points.len() as i32;
    let box_ = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, 1.0 + (i >> 2) as f32]);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut faces: Vec<Vec<i32>> = sheets::grid_faces(nx, ny, |_, _| true);
    faces.extend(sides.map(|side| side.map(|v| v + first).to_vec()));
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let input =
        with_detail(sheets::mesh(sheet.points.iter().map(|p| p.to_array()).chain(box_), &faces), nx * ny..nx * ny + 6);
    let (whole, smooth) = (build(input.clone(), &["sim.uvSet="]), build(input, &["sim.uvSet=", SMOOTH]));
    assert_eq!(whole.products.sim.points, smooth.products.sim.points);
    assert!(smooth.warnings.iter().any(|w| w.code == codes::CLOSED_DETAIL), "{:?}", smooth.warnings);
}

#[test]
fn surfaces_of_all_troubles_are_finite() {
    for (name, input) in zoo::all() {
        let Ok(mut builder) =
            tailor_costume::Builder::new(with_detail(input.clone(), 0..input.face_vertex_counts.len()))
        else {
            continue;
        };
        let mut recipe = tailor_costume::Recipe::default();
        recipe.sim.smooth = vec!["detail".into()];
        if let Ok(products) = builder.update(&recipe) {
            assert!(products.sim.points.iter().all(|p| p.is_finite()), "{name}");
        }
    }
}
