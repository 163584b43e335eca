//! Where hems end and seams end and meet: no step, no gap, no bead and no star.

use super::cloth::{checked, limit, path, sheet, with_faces};
use super::crossings::crossing_parents;
use super::operators::{Surface, vertices_of};
use crate::operators::rendered;
use glam::{Quat, Vec3};
use std::collections::BTreeSet;
use tailor::codes;
use tailor_mesh::connectivity::{Topology, VertexId};
use tailor_mesh::garment::{Garment, Mesh};
use tailor_testing::sheets::with_edges;

const AMOUNT: f32 = 0.15;

/// A sheet of 8 by 8, bent about y by `bend`, of which the lower border turns by `kink` degrees at its middle, with a hem
/// of one row on one side and a seam into its end.
fn hooded(bend: f32, kink: f32) -> Mesh {
    let mut input = sheet(8);
    for p in &mut input.points {
        p.y += kink.to_radians().tan() * (p.x - 4.0).max(0.0) * (1.0 - p.y / 8.0);
        if bend > 0.0 {
            let a = bend * (p.x / 8.0 - 0.5);
            *p = Vec3::new(8.0 / bend * a.sin(), p.y, 8.0 / bend * a.cos());
        }
    }
    let column: Vec<i32> = (0..=8).map(|y| 9 * y + 4).collect();
    checked(with_faces(with_edges(input, "seam", &path(&column)), "hem", 0..4))
}

/// Vertices on the border of a mesh.
fn border(mesh: &Mesh) -> BTreeSet<VertexId> {
    let t = Topology::new(mesh.faces.clone(), mesh.points.len());
    t.edges.ids().filter(|&e| t.is_border(e)).flat_map(|e| t.edges[e]).collect()
}

#[test]
fn a_hem_ends_on_the_surface_beside_a_border_without_one() {
    for (bend, kink, seam) in [
        (0.0, 0.0, None),
        (1.2, 0.0, None),
        (1.2, 50.0, None),
        (1.2, -50.0, None),
        (0.0, 40.0, None),
        (1.2, 0.0, Some("-0.06")),
        (1.2, 30.0, Some("0.06")),
    ] {
        let garment = hooded(bend, kink);
        let mut options: Vec<String> =
            ["render.level=3", "render.faceSets=true", "fold.h.faces=hem"].map(str::to_owned).into();
        options.push(format!("fold.h.thickness={AMOUNT}"));
        let seams = seam.map(|offset| {
            ["seam.s.edges=seam".to_owned(), "seam.s.width=0.4".into(), format!("seam.s.normalOffset={offset}")]
        });
        let plain_options: Vec<String> = seams.clone().into_iter().flatten().chain(["render.level=3".into()]).collect();
        options.extend(seams.into_iter().flatten().chain(seam.map(|_| "render.operators=s,h".to_owned())));
        let name = format!("bend {bend}, kink {kink}, seam {seam:?}");
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(kink < 0.0 || warnings.iter().all(|w| w.code != codes::INTERSECTIONS), "{name}: {warnings:?}");
        let surface = Surface::new(&garment, &plain_options);
        let end = limit(&rendered(&garment, &plain_options).0)[VertexId::new(4)];
        let places = limit(&mesh);
        // Nothing sticks out at the end: every border there lies on the surface.
        let near = |v: &&VertexId| places[**v].distance(end) < 3.0 * AMOUNT;
        let border = border(&mesh);
        let off = border.iter().filter(near).map(|&v| surface.height(places[v]).abs()).fold(0.0, f32::max);
        let most = if seam.is_some() { 0.3 } else { 0.12 };
        assert!(off < most * AMOUNT, "{name}: the border is {} of the amount off the surface", off / AMOUNT);
        // The outer layer is where it was, except for the fold itself, which is round.
        let hem: Vec<Vec3> = vertices_of(&mesh, "h_hem").iter().map(|&v| places[v]).collect();
        let is_fold = |p: Vec3| hem.iter().any(|h| h.distance(p) < 0.6 * AMOUNT);
        let layer: BTreeSet<VertexId> =
            vertices_of(&mesh, "h_inner").union(&vertices_of(&mesh, "h_hem")).copied().collect();
        let outer = mesh.points.ids().filter(|v| !layer.contains(v) && places[*v].distance(end) < 3.0 * AMOUNT);
        let dent = outer.filter(|&v| !is_fold(places[v])).map(|v| surface.height(places[v]).abs()).fold(0.0, f32::max);
        assert!(dent < 0.12 * AMOUNT, "{name}: a dent of {} of the amount", dent / AMOUNT);
        // The fold has its height again a few amounts from the end.
        let inner = vertices_of(&mesh, "h_inner");
        let away = inner.iter().map(|&v| places[v]).filter(|p| (1.5..4.0).contains(&(p.distance(end) / AMOUNT)));
        let deepest = away.map(|p| -surface.height(p)).fold(0.0, f32::max);
        assert!((deepest / AMOUNT - 1.0).abs() < 0.2, "{name}: {} of the amount", deepest / AMOUNT);
        // And narrows evenly up to there, a seam or none.
        let to_end = inner.iter().map(|&v| (places[v].distance(end) / AMOUNT, -surface.height(places[v]) / AMOUNT));
        let step = to_end.filter(|(far, _)| *far < 1.5).map(|(far, deep)| deep - far / 1.5).fold(0.0, f32::max);
        assert!(step < 0.1, "{name}: {step} of the amount deeper than an even taper");
        let (coarse, told) = rendered(&garment, &[&options[1..], &["render.level=1".to_owned()]].concat());
        let own: Vec<usize> = (0..coarse.faces.len()).collect();
        let crossing = crossing_parents(&coarse, &own);
        // Two small faces touch where the border turns back under the fold, and that is reported.
        assert!(crossing.is_empty() || kink < 0.0 && told.iter().any(|w| w.code == codes::INTERSECTIONS), "{name}");
    }
}

/// A tube of radius 1 and `n` by 3 quads, with a hem on half of the faces at its end.
fn cuff(n: i32) -> Mesh {
    let at = |x: i32, y: i32| y * n + x % n;
    let cells = (0..3).flat_map(|y| (0..n).map(move |x| (x, y)));
    let faces: Vec<[i32; 4]> = cells.map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]).collect();
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 4]>::as_slice).collect();
    let points = (0..4 * n).map(|i| {
        let a = (i % n) as f32 / n as f32 * std::f32::consts::TAU;
        [a.cos(), a.sin(), (i / n) as f32]
    });
    checked(with_faces(tailor_testing::sheets::mesh(points, &faces), "hem", 0..n / 2))
}

#[test]
fn a_cuff_of_few_faces_has_no_fins() {
    for n in [3, 4, 5, 6, 8] {
        let garment = cuff(n);
        let options = ["fold.h.faces=hem", "fold.h.thickness=0.12", "render.level=3", "render.faceSets=true"];
        let (mesh, warnings) = rendered(&garment, &options);
        // The layers of a cuff of four touch beside the vertex that they share, which is reported.
        assert!(n == 4 || warnings.iter().all(|w| w.code != codes::INTERSECTIONS), "{n}: {warnings:?}");
        let places = limit(&mesh);
        let layer = &vertices_of(&mesh, "h_inner") | &vertices_of(&mesh, "h_hem");
        let radius = |v: VertexId| places[v].truncate().length();
        let outer = mesh.points.ids().filter(|v| !layer.contains(v));
        let (plain, _) = rendered(&garment, &["render.level=3"]);
        let most = limit(&plain).iter().map(|p| p.truncate().length()).fold(0.0, f32::max);
        let fin = outer.map(radius).fold(0.0, f32::max) - most;
        assert!(fin < 0.06, "{n}: a fin of {fin}");
        assert!(mesh.faces.ids().all(|f| mesh.faces.valence(f) == 4), "{n}");
    }
}

/// Height and place of the points of an edge set on a flat sheet, in the order of x and then y.
fn line(mesh: &Mesh, name: &str) -> Vec<Vec3> {
    let places = limit(mesh);
    let mut line: Vec<Vec3> = vertices_of(mesh, name).iter().map(|&v| places[v]).collect();
    line.sort_by(|p, q| (p.x, p.y).partial_cmp(&(q.x, q.y)).expect("finite"));
    line
}

#[test]
fn a_short_seam_tapers_over_its_width() {
    for (count, width) in [(1, 0.2), (1, 0.5), (2, 0.4), (3, 0.5), (4, 0.9)] {
        let row: Vec<i32> = (0..=count).map(|x| 9 * 4 + 2 + x).collect();
        let garment = checked(with_edges(sheet(8), "a", &path(&row)));
        let width_option = format!("seam.a.width={width}");
        let options = ["seam.a.edges=a", &width_option, "seam.a.normalOffset=-0.1", "render.level=4"];
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(warnings.is_empty(), "{warnings:?}");
        let length = count as f32;
        let taper = f32::min(width, length / 3.0);
        for p in line(&mesh, "a") {
            let along = (p.x - 2.0).min(length + 2.0 - p.x);
            let share = -p.z / 0.1;
            let name = format!("{count} edges, width {width}, at {along}: {share}");
            if along > 1.2 * taper {
                assert!((share - 1.0).abs() < 0.13, "{name}");
            } else if along > 0.2 * taper && along < 0.8 * taper {
                assert!((share - along / taper).abs() < 0.3, "{name}");
            }
        }
    }
}

/// A sheet of which the rows beside the middle one are near it at every third point.
fn uneven() -> Garment {
    let mut input = sheet(8);
    for (i, p) in input.points.iter_mut().enumerate() {
        if i % 9 % 3 == 1 && (i / 9 == 3 || i / 9 == 5) {
            p.y = 4.0 + 0.55 * (p.y - 4.0);
        }
    }
    input
}

#[test]
fn a_seam_over_uneven_quads_keeps_its_width_from_edge_to_edge() {
    let garment = checked(with_edges(uneven(), "a", &path(&(36..=44).collect::<Vec<_>>())));
    for offset in ["-0.1", "0.1"] {
        let offset_option = format!("seam.a.normalOffset={offset}");
        let options = ["seam.a.edges=a", "seam.a.width=0.9", &offset_option, "render.level=4"];
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(warnings.is_empty(), "{warnings:?}");
        let heights: Vec<f32> = (36..=44).map(|v| limit(&mesh)[VertexId::new(v)].z.abs()).collect();
        assert!(heights.iter().all(|height| (height / 0.1 - 1.0).abs() < 0.02), "{heights:?}");
        // Half of the width at half of the height, in columns between the ends.
        let at = |x: f32| {
            let column = mesh.points.iter().filter(|p| (p.x - x).abs() < 0.04 && p.z.abs() > 0.05);
            column.map(|p| (p.y - 4.0).abs()).fold(0.0, f32::max)
        };
        let mut widths: Vec<f32> = (4..=60).map(|x| at(0.125 * x as f32)).filter(|&width| width > 0.0).collect();
        widths.sort_by(f32::total_cmp);
        let (least, median, most) = (widths[0], widths[widths.len() / 2], widths[widths.len() - 1]);
        assert!(least > 0.93 * median && most < 1.07 * median, "{least} {median} {most}");
        // The height follows the vertices; there are no beads between them.
        let all = line(&mesh, "a");
        let (low, high) =
            all.iter().map(|p| p.z.abs()).fold((f32::MAX, 0.0), |(l, h), z| (f32::min(l, z), f32::max(h, z)));
        assert!(high / low < 1.05, "{low} to {high}");
    }
}

/// A sheet with a seam along the middle row, "a", and one along the middle column, "b", from `from` on.
fn crossed(from: i32) -> Mesh {
    let column: Vec<i32> = (from..=8).map(|y| 9 * y + 4).collect();
    checked(with_edges(with_edges(sheet(8), "a", &path(&(36..=44).collect::<Vec<_>>())), "b", &path(&column)))
}

#[test]
fn the_seam_that_goes_through_stays_at_its_height() {
    for (heights, from) in
        [([0.1f32, 0.1f32], 0), ([0.1, 0.1], 4), ([0.08, 0.16], 0), ([0.08, 0.16], 4), ([0.1, -0.1], 0)]
    {
        let options = |order: &str, [a, b]: [f32; 2]| -> Vec<String> {
            let width = ["seam.a.width=0.4", "seam.b.width=0.4", "seam.a.edges=a", "seam.b.edges=b", "render.level=4"];
            let offsets = [format!("seam.a.normalOffset={a}"), format!("seam.b.normalOffset={b}")];
            width.map(str::to_owned).into_iter().chain(offsets).chain([format!("render.operators={order}")]).collect()
        };
        // The later one goes through, and so does the one that does not end.
        let (mesh, warnings) = rendered(&crossed(from), &options("b,a", heights));
        assert!(warnings.is_empty(), "{warnings:?}");
        for p in line(&mesh, "a") {
            assert!((p.z / heights[0] - 1.0).abs() < 0.05, "{heights:?} from {from}: {p}");
        }
        // Away from the other seam it has its own profile: that of the seam alone.
        let (alone, _) = rendered(&crossed(from), &options("a", heights));
        let (places, alone) = (limit(&mesh), Surface::of(&limit(&alone), &alone));
        let beside = places.iter().filter(|p| (0.3..0.8).contains(&(p.x - 4.0).abs()) && (p.y - 4.0).abs() < 0.3);
        for &p in beside {
            let off = alone.height(p).abs();
            assert!(off < 0.08 * heights[0], "{heights:?} from {from}: {p} is {off} off");
        }
        // Neither is the junction wider: the surface between the two is flat from their width on.
        for p in
            places.iter().filter(|p| (0.2..1.0).contains(&(p.x - 4.0).abs()) && (0.2..1.0).contains(&(p.y - 4.0).abs()))
        {
            assert!(p.z.abs() < 0.12 * heights[0], "{heights:?} from {from}: {p} is raised");
        }
    }
}

#[test]
fn seams_too_wide_for_their_crossing_narrow_there() {
    for (width, height) in [(0.5f32, 0.1f32), (0.6, 0.1), (0.6, -0.1)] {
        let of = |seam: &str| {
            [
                format!("seam.{seam}.edges={seam}"),
                format!("seam.{seam}.width={width}"),
                format!("seam.{seam}.normalOffset={height}"),
            ]
        };
        let options = [&of("a")[..], &of("b"), &["render.level=4".to_owned()]].concat();
        let (mesh, warnings) = rendered(&crossed(0), &options);
        assert!(warnings.is_empty(), "{warnings:?}");
        // The crests go through, a little lower.
        for p in line(&mesh, "a").into_iter().chain(line(&mesh, "b")) {
            assert!((0.65..1.05).contains(&(p.z / height)), "width {width}: {p}");
        }
        // No star: the surface between them is as flat as elsewhere.
        let between = |d: f32| (0.6 * width..1.0).contains(&(d - 4.0).abs());
        for p in limit(&mesh).iter().filter(|p| between(p.x) && between(p.y)) {
            assert!(p.z.abs() < 0.12 * height.abs(), "width {width}: {p} is raised");
        }
    }
}

#[test]
fn grooves_meet_at_their_depth() {
    for from in [0, 4] {
        let options = ["seam.a.edges=a", "seam.b.edges=b", "seam.a.width=0.4", "seam.b.width=0.4", "render.level=4"];
        let depths = ["seam.a.normalOffset=-0.1", "seam.b.normalOffset=-0.05"];
        let (mesh, warnings) = rendered(&crossed(from), &[&options[..], &depths].concat());
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(line(&mesh, "a").iter().all(|p| (p.z / -0.1 - 1.0).abs() < 0.05), "{from}");
        let least = line(&mesh, "b").iter().map(|p| p.z).fold(f32::MIN, f32::max);
        assert!(least < -0.0425, "{from}: the shallow groove rises to {least}");
    }
}

#[test]
fn a_seam_that_ends_at_another_leaves_the_far_side_as_it_was() {
    // A T on a sheet that is bent along the seam which goes through.
    let mut input = sheet(8);
    for p in &mut input.points {
        let a = 1.2 * (p.x / 8.0 - 0.5);
        *p = Vec3::new(8.0 / 1.2 * a.sin(), p.y, 8.0 / 1.2 * a.cos());
    }
    let column: Vec<i32> = (4..=8).map(|y| 9 * y + 4).collect();
    let input = with_edges(with_edges(input, "a", &path(&(36..=44).collect::<Vec<_>>())), "b", &path(&column));
    let garment = checked(input);
    for [a, b] in [[0.1f32, 0.1], [0.08, 0.16]] {
        let offsets = [format!("seam.a.normalOffset={a}"), format!("seam.b.normalOffset={b}")];
        let common = ["seam.a.edges=a", "seam.b.edges=b", "seam.a.width=0.4", "seam.b.width=0.4", "render.level=4"];
        let options: Vec<&str> = common.into_iter().chain(offsets.iter().map(String::as_str)).collect();
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(warnings.is_empty(), "{warnings:?}");
        // What the seam adds to the other one there.
        let (alone, _) = rendered(&garment, &[&options[..], &["render.operators=a"]].concat());
        let (places, alone) = (limit(&mesh), Surface::of(&limit(&alone), &alone));
        let far = places.iter().filter(|p| (3.0..3.9).contains(&p.y) && p.x.abs() < 1.0);
        let far = far.map(|&p| alone.height(p).abs() / a).fold(0.0, f32::max);
        assert!(far < 0.04, "{a}, {b}: {far} of the height on the far side");
    }
}

#[test]
fn a_seam_reaches_its_height_beside_another_without_a_step() {
    for [a, b] in [[0.08f32, 0.16], [0.1, -0.1]] {
        let common = ["seam.a.edges=a", "seam.b.edges=b", "seam.a.width=0.4", "seam.b.width=0.4", "render.level=5"];
        let offsets = [format!("seam.a.normalOffset={a}"), format!("seam.b.normalOffset={b}")];
        let options: Vec<&str> = common.into_iter().chain(offsets.iter().map(String::as_str)).collect();
        let (mesh, _) = rendered(&crossed(4), &options);
        let mut along: Vec<Vec3> = line(&mesh, "b").into_iter().filter(|p| (4.0..4.6).contains(&p.y)).collect();
        along.sort_by(|p, q| p.y.total_cmp(&q.y));
        let steepest = along.windows(2).map(|w| ((w[1].z - w[0].z) / (w[1].y - w[0].y)).abs()).fold(0.0, f32::max);
        // The mean over the half width and the support loop.
        let ratio = steepest / ((b - a).abs() / 0.3);
        assert!(ratio < 3.5, "{a}, {b}: {ratio} of the mean slope");
    }
}

/// Height over the surface of the vertices of the second layer near a place, and how far the border there is off it.
fn beside_end(mesh: &Mesh, surface: &Surface, end: Vec3) -> (f32, f32) {
    let places = limit(mesh);
    let inner = &vertices_of(mesh, "h_inner") | &vertices_of(mesh, "h_hem");
    let near = |v: &&VertexId| places[**v].distance(end) < 1.6 * AMOUNT;
    let deepest = inner.iter().filter(near).map(|&v| surface.height(places[v]).abs()).fold(0.0, f32::max);
    let near = |v: &&VertexId| places[**v].distance(end) < 3.0 * AMOUNT;
    let off = border(mesh).iter().filter(near).map(|&v| surface.height(places[v]).abs()).fold(0.0, f32::max);
    (deepest / AMOUNT, off / AMOUNT)
}

#[test]
fn a_hem_ends_square_where_its_end_is_marked() {
    let marked = |is_crease: bool, bend: f32| {
        let mut input = super::cloth::sheet(8);
        if bend > 0.0 {
            for p in &mut input.points {
                let a = bend * (p.x / 8.0 - 0.5);
                *p = Vec3::new(8.0 / bend * a.sin(), p.y, 8.0 / bend * a.cos());
            }
        }
        let mut input = with_faces(input, "hem", 0..4);
        if is_crease {
            (input.crease_indices, input.crease_lengths, input.crease_sharpnesses) = (vec![4, 13], vec![2], vec![2.0]);
        } else {
            input = with_edges(input, "end", &path(&[4, 13]));
        }
        checked(input)
    };
    for (is_crease, bend) in [(false, 0.0), (true, 0.0), (false, 1.2), (true, 1.2)] {
        let garment = marked(is_crease, bend);
        let amount = format!("fold.h.thickness={AMOUNT}");
        let options = ["fold.h.faces=hem", &amount, "render.faceSets=true", "render.level=3"];
        let (mesh, warnings) = rendered(&garment, &options);
        assert!(warnings.is_empty(), "{warnings:?}");
        let surface = Surface::new(&garment, &["render.level=3"]);
        let end = limit(&rendered(&garment, &["render.level=3"]).0)[VertexId::new(4)];
        let (deepest, off) = beside_end(&mesh, &surface, end);
        // The fold has its height up to the end, and a wall closes it.
        assert!((0.85..1.15).contains(&deepest), "crease {is_crease}, bend {bend}: {deepest} of the amount at the end");
        assert!(off < 0.15, "crease {is_crease}, bend {bend}: the border is {off} of the amount off the surface");
        let (coarse, _) = rendered(&garment, &[&options[..3], &["render.level=1"]].concat());
        let own: Vec<usize> = (0..coarse.faces.len()).collect();
        assert!(crossing_parents(&coarse, &own).is_empty(), "crease {is_crease}, bend {bend}");
    }
}

#[test]
fn a_hem_that_other_cloth_cuts_short_closes() {
    // A patch lies behind the border from x = 4.6 on.
    let mut input = sheet(8);
    let first = input.points.len() as i32;
    input.points.extend([4.6, 8.0].into_iter().flat_map(|x| [0.1, 0.9].map(|y| Vec3::new(x, y, -0.0005))));
    input.face_vertex_counts.push(4);
    input.face_vertex_indices.extend([first, first + 2, first + 3, first + 1]);
    input.primvars.clear();
    input.subsets.clear();
    let garment = checked(with_faces(input, "hem", 0..8));
    let amount = format!("fold.h.thickness={AMOUNT}");
    let options = ["fold.h.faces=hem", &amount, "render.faceSets=true", "render.level=3"];
    let (mesh, warnings) = rendered(&garment, &options);
    assert!(warnings.iter().any(|w| w.code == codes::BARE_FACES), "{warnings:?}");
    let surface = Surface::new(&garment, &["render.level=3"]);
    let places = limit(&mesh);
    let hem = vertices_of(&mesh, "h_hem");
    let end = hem.iter().map(|&v| places[v]).fold(Vec3::ZERO, |end, p| if p.x > end.x { p } else { end });
    let (_, off) = beside_end(&mesh, &surface, end);
    assert!(end.x > 1.5 && off < 0.15, "at {end} the border is {off} of the amount off the surface");
}

/// A surface of revolution about z of `n` by 8 quads, with a seam around it and a hem at its end.
fn revolved(n: i32) -> Mesh {
    let faces: Vec<[i32; 4]> = (0..8 * n)
        .map(|i| {
            let (x, y) = (i % n, i / n);
            let at = |x: i32, y: i32| y * n + x % n;
            [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
        })
        .collect();
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 4]>::as_slice).collect();
    let points = (0..9 * n).map(|i| {
        let (a, y) = ((i % n) as f32 / n as f32 * std::f32::consts::TAU, (i / n) as f32);
        let r = 2.0 + 0.3 * (0.8 * y).sin();
        [r * a.cos(), r * a.sin(), 0.7 * y]
    });
    let ring: Vec<i32> = (0..=n).map(|x| 4 * n + x % n).collect();
    let input = with_edges(tailor_testing::sheets::mesh(points, &faces), "ring", &path(&ring));
    checked(with_faces(input, "rim", 0..2 * n))
}

#[test]
fn closed_seams_and_hems_are_symmetric() {
    for n in [5, 8, 12, 17] {
        for (size, options) in [
            (0.3, vec!["seam.s.edges=ring", "seam.s.width=0.3", "seam.s.normalOffset=-0.1"]),
            (0.8, vec!["seam.s.edges=ring", "seam.s.width=0.8", "seam.s.normalOffset=0.2", "seam.s.depth=0.05"]),
            (0.15, vec!["fold.t.faces=rim", "fold.t.thickness=0.15"]),
            (0.6, vec!["fold.t.faces=rim", "fold.t.thickness=0.6"]),
            (0.6, vec!["fold.t.faces=rim", "fold.t.thickness=0.6", "fold.t.side=outer"]),
        ] {
            let (mesh, _) = rendered(&revolved(n), &[&["render.level=2"][..], &options].concat());
            let points: Vec<Vec3> = mesh.points.iter().copied().collect();
            let tree = crate::nearest::Nearest::new(points.iter().map(|&p| [p; 3]).collect());
            let turn = Quat::from_rotation_z(std::f32::consts::TAU / n as f32);
            let mirror = |p: Vec3| Vec3::new(p.x, -p.y, p.z);
            let off = |q: Vec3| points[tree.find(q).0].distance(q);
            let most = points.iter().map(|&p| off(turn * p).max(off(mirror(p)))).fold(0.0, f32::max);
            assert!(most < 1e-4 * size, "{n}, {options:?}: {} of the size", most / size);
        }
    }
}
