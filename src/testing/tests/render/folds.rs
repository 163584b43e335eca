//! Folds: where the layers are, and which faces have none.

use super::cloth::{checked, faces_in, limit, path, sheet, tube, with_faces};
use super::crossings::crossing_parents;
use super::operators::{EXACT, Surface, shapes, sound, vertices_of};
use crate::operators::rendered;
use glam::Vec3;
use std::collections::BTreeSet;
use tailor::codes;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::error::{Warning, Warnings};
use tailor_mesh::garment::Mesh;
use tailor_testing::sheets::{grid_faces, mesh, with_edges};

/// The thickness of the hem that covers seams.
const THICKNESS: f32 = 0.15;

#[test]
fn the_layers_are_the_amount_apart() {
    for (name, input) in shapes() {
        let garment = checked(input);
        let faces = if name == "plane" { "half" } else { "all" };
        let surface = Surface::new(&garment, &["render.level=4"]);
        for (side, sign) in [("inner", -1.0), ("outer", 1.0)] {
            let (faces, side) = (format!("fold.t.faces={faces}"), format!("fold.t.side={side}"));
            let options = [
                &faces,
                "fold.t.thickness=0.15",
                &side,
                "fold.t.closed=true",
                "render.faceSets=true",
                "render.level=2",
            ];
            let (mesh, warnings) = rendered(&garment, &options);
            assert!(warnings.is_empty(), "{name}: {warnings:?}");
            let places = limit(&mesh);
            let hem = vertices_of(&mesh, "t_hem");
            let inner = vertices_of(&mesh, "t_inner");
            let height = |v: &VertexId| surface.height(places[*v]);
            let off = |v: &&VertexId| (height(v) - sign * 0.15).abs();
            // Beside the hem the layers turn into each other; beside its ends on the plane the second one is closed.
            let is_closed = |p: Vec3| name == "plane" && p.x > 1.9 && (p.y - 4.0).abs() > 0.9;
            let near_hem =
                |v: &VertexId| is_closed(places[*v]) || hem.iter().any(|&h| places[h].distance(places[*v]) < 1.0);
            let away: Vec<&VertexId> = inner.iter().filter(|v| !near_hem(v)).collect();
            assert!(away.len() > 100, "{name}");
            let worst = away.iter().map(off).fold(0.0, f32::max);
            assert!(worst < EXACT * 0.15, "{name} {side}: off by {} of the amount", worst / 0.15);
        }
    }
}

/// The distance of the layers at the border and at the line behind it: the greatest of all places along the fold.
fn turned(turn: f32) -> [f32; 2] {
    let garment = checked(sheet(8));
    let turn = format!("fold.t.turn={turn}");
    let options = ["fold.t.faces=half", "fold.t.thickness=0.2", &turn, "render.faceSets=true", "render.level=0"];
    let (mesh, warnings) = rendered(&garment, &options);
    assert!(warnings.is_empty(), "{warnings:?}");
    let (places, hem) = (limit(&mesh), vertices_of(&mesh, "t_hem"));
    let inner = vertices_of(&mesh, "t_inner");
    // Beside the two ends of the fold, the layer is closed.
    let inside = inner.iter().filter(|v| places[**v].x < 2.9 && (places[**v].y - 4.0).abs() < 2.0);
    let (at, behind): (Vec<VertexId>, Vec<VertexId>) = inside.partition(|v| hem.contains(v));
    [at, behind].map(|of| of.iter().map(|&v| -places[v].z).fold(0.0, f32::max))
}

#[test]
fn a_turn_is_round_pressed_or_a_roll() {
    for (turn, at_border) in [(1.0, 0.2), (0.5, 0.1), (1.5, 0.3), (0.0, 0.08)] {
        let [at, behind] = turned(turn);
        assert!((at - at_border).abs() < EXACT * 0.2, "{at} at the border, turned by {turn}");
        assert!((behind - 0.2).abs() < EXACT * 0.2, "{behind} behind it, turned by {turn}");
    }
}

#[test]
fn painted_weights_scale_the_layer_and_tuck_it_in() {
    let garment = checked(sheet(8));
    let options = [
        "fold.t.faces=half",
        "fold.t.thickness=0.2",
        "fold.t.weights=density",
        "render.faceSets=true",
        "render.level=0",
    ];
    let (mesh, _) = rendered(&garment, &options);
    let places = limit(&mesh);
    let tailor_mesh::garment::Values::F32(painted) = &mesh.primvar("density").expect("weights").values else {
        panic!("real")
    };
    let painted = limit(&Mesh { points: painted.iter().map(|&w| Vec3::splat(w)).collect(), ..mesh.clone() });
    let hem = vertices_of(&mesh, "t_hem");
    // At the end of the half, the layer is closed beside the two ends of its fold.
    let is_closed = |p: Vec3| p.x > 3.9 && (p.y - 4.0).abs() > 2.9;
    for &v in vertices_of(&mesh, "t_inner").difference(&hem).filter(|v| !is_closed(places[**v])) {
        let (depth, weight) = (-places[v].z, painted[v].x);
        // Vertices of the line that holds the fold lie between those of the input, where weights are linear.
        assert!((depth - 0.2 * weight).abs() < 0.03, "{depth} at weight {weight}");
    }
    let inner = vertices_of(&mesh, "t_inner");
    let depths: Vec<f32> = inner.iter().filter(|v| !is_closed(places[**v])).map(|&v| -places[v].z).collect();
    assert!(depths.iter().all(|&d| d > 0.0015 && d < 0.2), "{depths:?}");
}

#[test]
fn tight_folds_are_thinner_and_say_so() {
    // A gutter of radius 0.3 whose inner side would cross itself at 0.5.
    let mut input = sheet(8);
    for p in &mut input.points {
        let a = (p.x / 8.0 - 0.5) * 3.0;
        *p = Vec3::new(0.3 * a.sin(), p.y, 0.3 * a.cos());
    }
    let garment = checked(with_faces(input, "all", 0..64));
    let options = ["fold.t.faces=all", "fold.t.thickness=0.5", "render.level=2"];
    let (mesh, warnings) = rendered(&garment, &options);
    assert!(warnings.iter().any(|w| w.code == codes::THIN_LAYER), "{warnings:?}");
    sound(&mesh, "gutter");
}

/// A sheet folded back over itself, the halves `gap(y)` apart, with their fronts to each other.
fn folded_back(gap: impl Fn(f32) -> f32) -> Mesh {
    let mut input = sheet(8);
    for p in input.points.iter_mut().filter(|p| p.x > 4.0) {
        *p = Vec3::new(8.0 - p.x, p.y, gap(p.y));
    }
    checked(with_faces(input, "all", 0..64))
}

/// How many faces have no second layer for want of room.
fn without_room(warnings: &Warnings) -> usize {
    let tight = warnings.iter().filter(|w| w.code == codes::BARE_FACES && w.problem.contains("other cloth lies"));
    let count = |w: &Warning| w.problem.split(' ').find_map(|word| word.parse::<usize>().ok()).expect("a count");
    tight.map(count).sum()
}

#[test]
fn what_lies_on_a_face_leaves_it_one_layer() {
    let garment = folded_back(|y| 0.001 + 0.4 * (y - 3.0).max(0.0));
    let options = |side: &str| {
        let side = format!("fold.t.side={side}");
        ["fold.t.faces=all", "fold.t.thickness=0.2", "render.faceSets=true", "render.level=1", &side].map(String::from)
    };
    let (mesh, warnings) = rendered(&garment, &options("outer"));
    assert!((8..56).contains(&without_room(&warnings)), "{warnings:?}");
    let layer = faces_in(&mesh, "t_inner");
    let lowest =
        layer.iter().flat_map(|&f| mesh.faces.vertices_of(f)).map(|&v| mesh.points[v].y).fold(f32::MAX, f32::min);
    assert!(!layer.is_empty() && lowest > 3.0, "{lowest}");
    let own: Vec<usize> = (0..mesh.faces.len()).collect();
    assert_eq!(crossing_parents(&mesh, &own), BTreeSet::new());
    sound(&mesh, "half a layer");
    // On the other side there is nothing.
    let (mesh, warnings) = rendered(&garment, &options("inner"));
    assert_eq!(without_room(&warnings), 0, "{warnings:?}");
    assert_eq!(faces_in(&mesh, "t_inner").len(), (mesh.faces.len() - faces_in(&mesh, "t_hem").len()) / 2);
}

#[test]
fn a_layer_that_has_no_room_at_all_is_told_and_left_out() {
    let garment = folded_back(|_| 0.001);
    let options = ["fold.t.faces=all", "fold.t.thickness=0.2", "fold.t.side=outer", "render.level=1"];
    let (mesh, warnings) = rendered(&garment, &options);
    assert_eq!(without_room(&warnings), 64, "{warnings:?}");
    let (plain, _) = rendered(&garment, &["render.level=1"]);
    assert_eq!((&mesh.faces, mesh.points.as_slice()), (&plain.faces, plain.points.as_slice()));
}

/// A sheet folded over along its lower rows, with other sheets at these heights in thicknesses, the least distance of its
/// two layers in thicknesses, and the warnings.
fn beside_cloth(others: &[f32]) -> (Mesh, f32, Warnings) {
    const THICK: f32 = 0.2;
    let faces = grid_faces(8, 8, |_, _| true);
    let heights = || std::iter::once(0.0).chain(others.iter().map(|other| other * THICK));
    let points = heights().flat_map(|z| (0..81).map(move |i| [(i % 9) as f32, (i / 9) as f32, z]));
    let own = |sheet: usize| faces.iter().map(move |f| f.iter().map(|v| v + 81 * sheet as i32).collect());
    let all: Vec<Vec<i32>> = (0..=others.len()).flat_map(own).collect();
    let input = mesh(points, &all.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let garment = checked(with_faces(with_faces(input, "hem", 0..16), "own", 0..64));
    let options = ["fold.h.faces=hem", "fold.h.thickness=0.2", "render.faceSets=true", "render.level=1"];
    let (mesh, warnings) = rendered(&garment, &options);
    let (places, inner, turn) = (limit(&mesh), vertices_of(&mesh, "h_inner"), vertices_of(&mesh, "h_hem"));
    let is_inside = |p: Vec3| p.x > 1.0 && p.x < 7.0 && p.y > 0.3 && p.y < 1.3;
    let below: Vec<Vec3> = inner.difference(&turn).map(|&v| places[v]).filter(|p| is_inside(*p)).collect();
    let own = vertices_of(&mesh, "own");
    let above = || own.difference(&inner).map(|&v| places[v]);
    let beside = |p: Vec3, q: Vec3| (p - q).truncate().length();
    let over = |p: Vec3| above().min_by(|q, r| beside(p, *q).total_cmp(&beside(p, *r))).map_or(f32::NAN, |q| q.z - p.z);
    let least = below.iter().map(|p| over(*p)).fold(f32::INFINITY, f32::min);
    (mesh, least / THICK, warnings)
}

#[test]
fn a_layer_beside_cloth_lifts_the_surface_where_that_is_free() {
    let (mesh, apart, _) = beside_cloth(&[-0.9]);
    assert!((0.95..1.05).contains(&apart), "{apart} of the thickness is left");
    // Pressed from both sides, it is as thin as the gap allows.
    let (_, between, told) = beside_cloth(&[-0.9, 0.9]);
    assert!((0.15..0.5).contains(&between), "{between} of the thickness is left between two sheets");
    assert!(told.iter().any(|w| w.code == codes::THIN_LAYER), "{told:?}");
    let own: Vec<usize> = (0..mesh.faces.len()).collect();
    assert_eq!(crossing_parents(&mesh, &own), BTreeSet::new());
}

#[test]
fn a_layer_goes_along_with_a_groove_that_is_narrower_than_it_is_thick() {
    let garment = checked(tube());
    for (width, thickness) in [("0.4", 0.3), ("0.2", 0.15), ("0.5", 0.2)] {
        let (wide, thick) = (format!("seam.s.width={width}"), format!("fold.t.thickness={thickness}"));
        let options = [
            "seam.s.edges=ring",
            &wide,
            "seam.s.normalOffset=-0.1",
            "fold.t.faces=all",
            &thick,
            "render.operators=seam.s,fold.t",
            "render.faceSets=true",
            "render.level=2",
        ];
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(warnings.is_empty(), "{width}, {thickness}: {warnings:?}");
        let (inner, hem) = (vertices_of(&mesh, "t_inner"), vertices_of(&mesh, "t_hem"));
        let outer: Vec<Vec3> =
            mesh.points.enumerated().filter(|(v, _)| !inner.contains(v) && !hem.contains(v)).map(|(_, p)| *p).collect();
        for &v in inner.difference(&hem) {
            let p = mesh.points[v];
            let near = outer.iter().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min);
            assert!((0.7 * thickness..1.15 * thickness).contains(&near), "{width}, {thickness}: {near} at {p}");
        }
    }
}

/// Limits of a bent sheet of 8 by 8 with a hem along its lower border and a seam down to it, and the vertices of the hem's layer.
fn hemmed(options: &[&str]) -> (Mesh, IdVec<VertexId, Vec3>, BTreeSet<VertexId>) {
    let mut input = sheet(8);
    for p in &mut input.points {
        let a = 0.6 * (p.x / 8.0 - 0.5);
        *p = Vec3::new(8.0 / 0.6 * a.sin(), p.y, 8.0 / 0.6 * a.cos());
    }
    let column: Vec<i32> = (0..=8).map(|y| 9 * y + 4).collect();
    let garment = checked(with_faces(with_edges(input, "seam", &path(&column)), "hem", 0..8));
    let amount = format!("fold.h.thickness={THICKNESS}");
    let fold = ["fold.h.faces=hem", &amount, "render.faceSets=true", "render.level=3"];
    let (mesh, _) = rendered(&garment, &[&fold, options].concat());
    let (places, layer) = (limit(&mesh), &vertices_of(&mesh, "h_inner") | &vertices_of(&mesh, "h_hem"));
    (mesh, places, layer)
}

#[test]
fn hems_cover_the_seams_and_rows_that_cross_them() {
    for (height, rows) in [(-0.06, "0"), (0.06, "0"), (-0.06, "0.6"), (0.06, "0.6")] {
        let offset = format!("seam.s.offset={rows}");
        let seam = |height: f32, through: bool| {
            let own = [format!("seam.s.normalOffset={height}"), format!("seam.s.through={through}")];
            hemmed(&["seam.s.edges=seam", "seam.s.width=0.4", &offset, &own[0], &own[1]])
        };
        let ((_, plain, layer), (_, covered, _), (_, through, _)) =
            (seam(0.0, false), seam(height, false), seam(height, true));
        let moved = |of: &IdVec<VertexId, Vec3>, v: VertexId| of[v].distance(plain[v]) / height.abs();
        let most = |of: &IdVec<VertexId, Vec3>, among: &dyn Fn(VertexId) -> bool| {
            plain.ids().filter(|&v| among(v)).map(|v| moved(of, v)).fold(0.0, f32::max)
        };
        let name = format!("height {height}, rows at {rows}");
        let on_layer = |v: VertexId| layer.contains(&v);
        let inside = |v: VertexId| layer.contains(&v) && plain[v].y > 0.5 * THICKNESS;
        let (inside, rim) = (most(&covered, &inside), most(&covered, &on_layer));
        assert!(inside < 0.02 && rim < 0.25, "{name}: the layer moves by {inside}, its rim by {rim}");
        assert!(most(&through, &on_layer) > 0.5, "{name}: nothing goes through");
        // Above the hem's thickness, the seam is what it is without.
        let above = |v: VertexId| !layer.contains(&v) && plain[v].y > 1.5 * THICKNESS && plain[v].y < 4.0;
        let crest = |from: f32| most(&covered, &|v| above(v) && (plain[v].y - from).abs() < 0.05);
        assert!(
            crest(1.7 * THICKNESS) > 0.8 && crest(3.0) > 0.9,
            "{name}: {} and {}",
            crest(1.7 * THICKNESS),
            crest(3.0)
        );
    }
}
