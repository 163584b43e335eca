//! Where seams meet at any angle, and where they end: on flat sheets with arms from the middle, in millimetres.

use super::cloth::{checked, faces_in, limit, path, sheet, tube, with_faces};
use super::crossings::crossing_parents;
use super::operators::vertices_of;
use crate::operators::rendered;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use tailor::codes;
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::garment::Mesh;
use tailor_testing::sheets::{mesh, with_edges};

/// Length of an edge. \[mm\]
const EDGE: f32 = 25.0;
/// Edges of an arm.
const N: usize = 4;

/// A flat sheet of parallelograms between directions from the middle, with the edge sets "a" and "b" of some of its arms.
fn star(degrees: &[f32], [a, b]: [&[usize]; 2]) -> Mesh {
    let directions: Vec<Vec2> = degrees.iter().map(|d| EDGE * Vec2::from_angle(d.to_radians())).collect();
    let sectors = directions.len();
    let on_arm = |k: usize, i: usize| if i == 0 { 0 } else { 1 + (k % sectors * N + i - 1) as i32 };
    let at = |k: usize, i: usize, j: usize| match (i, j) {
        (i, 0) => on_arm(k, i),
        (0, j) => on_arm(k + 1, j),
        _ => (1 + sectors * N + (k * N + i - 1) * N + j - 1) as i32,
    };
    let mut points = vec![[0.0; 3]; 1 + sectors * N * (N + 1)];
    let mut faces = Vec::new();
    for k in 0..sectors {
        let [along, across] = [directions[k], directions[(k + 1) % sectors]];
        for (i, j) in (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j))) {
            points[at(k, i, j) as usize] = (i as f32 * along + j as f32 * across).extend(0.0).to_array();
            if i < N && j < N {
                faces.push([at(k, i, j), at(k, i + 1, j), at(k, i + 1, j + 1), at(k, i, j + 1)]);
            }
        }
    }
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 4]>::as_slice).collect();
    // Arms of a set that goes through have one direction.
    let edges = |arms: &[usize]| -> Vec<[i32; 2]> {
        let arm = |(number, &k): (usize, &usize)| {
            let steps = (0..N).map(move |i| [on_arm(k, i), on_arm(k, i + 1)]);
            steps.map(move |[from, to]| if number == 0 { [to, from] } else { [from, to] }).collect::<Vec<_>>()
        };
        arms.iter().enumerate().flat_map(arm).collect()
    };
    checked(with_edges(with_edges(mesh(points, &faces), "a", &edges(a)), "b", &edges(b)))
}

/// Two seams that cross, meet in a T, turn a corner, and meet with a third arm, at an angle. Wide sectors are halved.
fn networks(angle: f32) -> [(&'static str, Mesh); 4] {
    let half = 90.0 + 0.5 * angle;
    let rest = (360.0 - angle) / 3.0;
    [
        ("X", star(&[0.0, angle, half, 180.0, 180.0 + angle, 180.0 + half], [&[0, 3], &[1, 4]])),
        ("T", star(&[0.0, angle, half, 180.0, 270.0], [&[0, 3], &[1]])),
        ("L", star(&[0.0, angle, angle + rest, angle + 2.0 * rest], [&[0], &[1]])),
        ("Y", star(&[0.0, angle, half, 180.0, 270.0], [&[0, 1], &[3]])),
    ]
}

type Preset = BTreeMap<String, serde_json::Value>;

/// The presets of seams or folds, as the preview has them, by name.
fn presets(kind: &str) -> BTreeMap<String, Preset> {
    let text = include_str!("../../../preview/presets.json");
    let mut all: BTreeMap<String, BTreeMap<String, Preset>> = serde_json::from_str(text).expect("presets");
    all.remove(kind).expect("presets of this kind")
}

/// The options of an operator by a preset, with lengths in mm.
fn options(operator: &str, preset: &Preset) -> Vec<String> {
    let value = |value: &serde_json::Value| match value.as_str() {
        Some(text) => text.trim_end_matches("mm").to_owned(),
        None => value.to_string(),
    };
    preset.iter().map(|(key, of)| format!("{operator}.{key}={}", value(of))).collect()
}

/// Faces that look down, and pairs of faces that cross. A steep flank may lean over by a few degrees.
fn faults(mesh: &Mesh) -> [usize; 2] {
    let leans = |v: &[VertexId]| {
        let p = |i: usize| mesh.points[v[i]];
        (p(2) - p(0)).cross(p(3) - p(1)).normalize_or_zero().z
    };
    let turned = mesh.faces.ids().filter(|&f| leans(mesh.faces.vertices_of(f)) < -0.1).count();
    let own: Vec<usize> = (0..mesh.faces.len()).collect();
    [turned, crossing_parents(mesh, &own).len()]
}

/// Each preset where it meets itself, with its other side, and a seam of another height.
fn meetings() -> Vec<(String, Vec<String>)> {
    let presets = presets("seam");
    let of = |(name, preset): (&String, &Preset)| {
        let mirrored = options("seam.b", preset).into_iter().map(|o| o.replace("asymmetry=", "asymmetry=-"));
        [("its mirror", mirrored.collect()), ("Plain", options("seam.b", &presets["Plain"]))].map(|(other, b)| {
            let sets = ["seam.a.edges=a", "seam.b.edges=b"].map(str::to_owned).to_vec();
            (format!("{name} and {other}"), [sets, options("seam.a", preset), b].concat())
        })
    };
    presets.iter().flat_map(of).collect()
}

#[test]
fn presets_are_sound_where_they_meet() {
    let (mut silent, mut known) = (Vec::new(), Vec::new());
    for (angle, level) in [90.0, 45.0, 20.0].into_iter().flat_map(|angle| (1..=3).map(move |level| (angle, level))) {
        for ((shape, garment), (name, options)) in
            networks(angle).iter().flat_map(|network| meetings().into_iter().map(move |meeting| (network, meeting)))
        {
            let (mesh, warnings) = rendered(garment, &[options, vec![format!("render.level={level}")]].concat());
            let faults = faults(&mesh);
            let place = format!("{shape} at {angle}, level {level}, {name}: {faults:?}");
            let is_told = warnings.iter().any(|w| w.code == codes::INTERSECTIONS);
            if faults[1] > 0 && !is_told {
                silent.push(place.clone());
            }
            if faults != [0, 0] {
                known.push(place);
            }
        }
    }
    assert!(silent.is_empty(), "pairs that cross without a word:\n{}", silent.join("\n"));
    // Rows squeeze where they end beside others, and at level 1 the steep side of a felled seam is thinner than its lines are apart.
    known.retain(|place| !place.contains("Topstitch") && !place.contains("level 1, Flat-felled"));
    assert!(known.is_empty(), "faces turned, pairs that cross:\n{}", known.join("\n"));
}

/// Options of a seam, with a length in mm.
fn seam(name: &str, width: f32, height: f32, more: &[&str]) -> Vec<String> {
    let own = [format!("edges={name}"), format!("width={width}"), format!("normalOffset={height}")];
    own.iter().map(String::as_str).chain(more.iter().copied()).map(|o| format!("seam.{name}.{o}")).collect()
}

/// Heights of the points of an edge set within two edges of the middle, by their distance from it.
fn crest(mesh: &Mesh, name: &str) -> Vec<(f32, f32)> {
    let places = limit(mesh);
    let here = vertices_of(mesh, name).into_iter().map(|v| (places[v].truncate().length(), places[v].z));
    let mut crest: Vec<(f32, f32)> = here.filter(|(distance, _)| *distance < 2.0 * EDGE).collect();
    crest.sort_by(|p, q| p.0.total_cmp(&q.0));
    crest
}

#[test]
fn seams_cross_at_any_angle_with_their_whole_height() {
    let level = vec!["render.level=3".to_owned()];
    for (angle, width, [a, b]) in [
        (90.0, 12.0, [2.0, 2.0]),
        (45.0, 12.0, [2.0, 2.0]),
        (45.0, 12.0, [1.5, -2.0]),
        (45.0, 12.0, [1.0, 2.0]),
        (30.0, 8.0, [2.0, 2.0]),
        (20.0, 5.0, [1.0, 1.0]),
        (20.0, 12.0, [2.0, 2.0]),
    ] {
        let garment = star(&[0.0, angle, 180.0, 180.0 + angle], [&[0, 2], &[1, 3]]);
        let (mesh, warnings) =
            rendered(&garment, &[seam("a", width, a, &[]), seam("b", width, b, &[]), level.clone()].concat());
        assert!(warnings.is_empty(), "{angle}, {width}, {a}, {b}: {warnings:?}");
        // The later one lies on top.
        let crest = crest(&mesh, "b");
        assert!(crest.len() > 8, "{angle}, {width}: {} points", crest.len());
        for (distance, z) in crest {
            assert!((z / b - 1.0).abs() < 0.05, "{angle}, {width}, {a}, {b}: {z} at {distance}");
        }
        let ways = [0.0, angle].map(|degrees: f32| Vec2::from_angle(degrees.to_radians()));
        let near = |p: &&Vec3| p.truncate().length() < 3.0 * EDGE;
        let is_beside = |p: &&Vec3| ways.iter().all(|way| way.perp_dot(p.truncate()).abs() > 0.51 * width);
        for p in limit(&mesh).iter().filter(near).filter(is_beside) {
            assert!(p.z.abs() < 0.05 * a.abs().max(b.abs()), "{angle}, {width}, {a}, {b}: {p} is raised");
        }
    }
}

#[test]
fn a_seam_ends_tapered_round_or_square() {
    let garment = star(&[0.0, 90.0, 180.0, 270.0], [&[0], &[2]]);
    let (width, height) = (10.0, 2.0);
    let made = |end: &str, more: &[&str]| {
        let options = [&[end], more].concat();
        rendered(&garment, &[seam("a", width, height, &options), vec!["render.level=4".into()]].concat()).0
    };
    let ahead = |mesh: &Mesh, from: f32| {
        let beyond = limit(mesh).iter().filter(|p| p.x < -from).map(|p| p.z).fold(0.0, f32::max);
        beyond / height
    };
    let taper = crest(&made("end=taper", &[]), "a");
    assert!(taper[0].1 < 0.05 * height && taper.windows(2).take_while(|p| p[1].0 < width).all(|p| p[0].1 < p[1].1));
    assert!(taper.iter().filter(|p| p.0 > 1.3 * width).all(|p| (p.1 / height - 1.0).abs() < 0.05), "{taper:?}");
    for (end, over, reach) in [("end=round", 0.05, 0.5), ("end=square", 0.1, 0.25)] {
        let mesh = made(end, &[]);
        let crest = crest(&mesh, "a");
        assert!(crest.iter().all(|p| (0.95..1.0 + over).contains(&(p.1 / height))), "{end}: {crest:?}");
        let beyond = ahead(&mesh, reach * width);
        assert!(beyond < 0.05, "{end}: {beyond} of the height ahead of the end");
    }
    assert!(ahead(&made("end=round", &[]), 0.25 * width) > 0.35, "a round end has its profile ahead");
    // Rows end beside the seam, or lead around its end.
    for (end, least, most) in [("end=taper", 0.0, 0.05), ("end=square", 0.0, 0.05), ("end=round", 0.9, 1.05)] {
        let beyond = ahead(&made(end, &["offset=12"]), 0.5 * width);
        assert!((least..most).contains(&beyond), "{end}: a row of {beyond} around the end");
    }
}

#[test]
fn rows_that_end_at_a_seam_leave_it_whole() {
    for (angle, offset) in [(90.0, 5.0), (90.0, 9.0), (90.0, 12.5), (90.0, 17.0), (60.0, 9.0)] {
        let garment = star(&[0.0, angle, 180.0, 270.0], [&[0, 2], &[1]]);
        let row = format!("offset={offset}");
        let options = [seam("a", 7.5, 2.0, &[]), seam("b", 2.5, -0.5, &[&row]), vec!["render.level=3".into()]].concat();
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(angle < 90.0 || warnings.is_empty(), "{angle}, {offset}: {warnings:?}");
        for (distance, z) in crest(&mesh, "a") {
            assert!((z / 2.0 - 1.0).abs() < 0.05, "{angle}, {offset}: {z} at {distance}");
        }
    }
}

/// Where the seam is on the sheet, and how far from its rim a seam may round off. \[mm\]
const SEAM: f32 = 4.0 * EDGE;
const RIM: f32 = 1.2;

/// The way that a surface looks, and the distance from its rim.
type Frame = fn(Vec3) -> (Vec3, f32);

/// A sheet and a tube, each with a seam "a" that runs over the lower row of faces, "hem", and its frame.
fn folded_shapes() -> [(&'static str, Mesh, Frame); 2] {
    let column: Vec<i32> = (0..=8).map(|y| 9 * y + 4).collect();
    let mut sheet = with_edges(with_faces(sheet(8), "hem", 0..8), "a", &path(&column));
    sheet.points.iter_mut().for_each(|p| *p *= EDGE);
    let line: Vec<i32> = (0..=8).map(|y| 16 * y + 3).collect();
    let mut tube = with_edges(with_faces(tube(), "hem", 0..16), "a", &path(&line));
    tube.points.iter_mut().for_each(|p| *p *= EDGE / 0.78);
    [("hem", checked(sheet), |p| (Vec3::Z, p.y)), ("cuff", checked(tube), |p| (p.with_z(0.0).normalize_or_zero(), p.z))]
}

#[test]
fn presets_of_seams_are_sound_over_those_of_folds() {
    let (seams, folds) = (presets("seam"), presets("fold"));
    let mut known = Vec::new();
    for (shape, garment, frame) in folded_shapes() {
        for ((seam, fold), level) in seams
            .iter()
            .flat_map(|s| folds.iter().map(move |f| (s, f)))
            .flat_map(|pair| (1..=3).map(move |l| (pair, l)))
        {
            let sets = ["seam.a.edges=a", "fold.h.faces=hem", "render.faceSets=true"].map(str::to_owned).to_vec();
            let own = [options("seam.a", seam.1), options("fold.h", fold.1), vec![format!("render.level={level}")]];
            let (mesh, _) = rendered(&garment, &[sets, own.concat()].concat());
            let (inner, turn) = (faces_in(&mesh, "h_inner"), faces_in(&mesh, "h_hem"));
            let middle = |f: FaceId| mesh.faces.vertices_of(f).iter().map(|&v| mesh.points[v]).sum::<Vec3>() / 4.0;
            let is_turned = |f: &FaceId| {
                let p: Vec<Vec3> = mesh.faces.vertices_of(*f).iter().map(|&v| mesh.points[v]).collect();
                let leans = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero().dot(frame(p[0]).0);
                (if inner.contains(f) { -leans } else { leans }) < -0.1
            };
            // The end of a seam looks ahead at the rim, and the fold itself ends at the sides of the sheet.
            let is_looked_at = |f: &FaceId| !turn.contains(f) && frame(middle(*f)).1 > RIM;
            let turned = mesh.faces.ids().filter(is_looked_at).filter(is_turned).count();
            let own: Vec<usize> = (0..mesh.faces.len()).collect();
            let is_by_seam = |pair: &&[usize; 2]| pair.iter().all(|&f| (middle(FaceId::new(f)).x - SEAM).abs() < EDGE);
            let pairs = crossing_parents(&mesh, &own);
            let pairs = if shape == "hem" { pairs.iter().filter(is_by_seam).count() } else { pairs.len() };
            if [turned, pairs] != [0, 0] {
                known
                    .push(format!("{shape}, level {level}, {} and {}: {turned} turned, {pairs} pairs", seam.0, fold.0));
            }
        }
    }
    assert!(known.is_empty(), "faces turned, pairs that cross:\n{}", known.join("\n"));
}
