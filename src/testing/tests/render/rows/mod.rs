//! Rows of stitches beside seams: at their distance along the surface, around corners, to the end of the cloth.

use crate::operators::rendered;
use crate::render::cloth::{checked, faces_in, limit, path, sheet, tube};
use crate::render::crossings::crossing_parents;
use crate::render::on_garments::{load_named, parents};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use tailor::codes;
use tailor::pipeline::mean_edge_length;
use tailor_mesh::connectivity::{Topology, VertexId};
use tailor_mesh::garment::{Elements, Mesh};
use tailor_testing::sheets::with_edges;

/// Columns and rows of the sheet.
const N: i32 = 16;
/// Height of the ridges, and the height from which on a vertex is on one.
const HEIGHT: f32 = 0.05;
const CREST: f32 = 0.85 * HEIGHT;

type Corners = [[i32; 2]];

/// Edges through some corners of the sheet.
fn steps(corners: &Corners) -> Vec<[i32; 2]> {
    let mut points = vec![corners[0]];
    for &[x, y] in &corners[1..] {
        while let Some(&[u, v]) = points.last()
            && [u, v] != [x, y]
        {
            points.push([u + (x - u).signum(), v + (y - v).signum()]);
        }
    }
    path(&points.into_iter().map(|[x, y]| (N + 1) * y + x).collect::<Vec<_>>())
}

/// A flat sheet of unit quads with an edge set through some corners.
fn flat(corners: &Corners) -> Mesh {
    checked(with_edges(sheet(N as usize), "line", &steps(corners)))
}

fn options(more: &[&str]) -> Vec<String> {
    let height = format!("seam.s.normalOffset={HEIGHT}");
    let base = ["render.level=3", "seam.s.edges=line", "seam.s.width=0.24", &height];
    base.iter().chain(more).map(|&option| option.to_owned()).collect()
}

/// Places on the ridges over a flat sheet.
fn crest(mesh: &Mesh) -> Vec<Vec3> {
    mesh.points.iter().filter(|p| p.z > CREST).map(|p| Vec3::new(p.x, p.y, 0.0)).collect()
}

/// Distance from a point to the nearest of some lines of the flat sheet.
fn off_line(p: Vec3, corners: &Corners) -> f32 {
    let place = |[x, y]: [i32; 2]| Vec3::new(x as f32, y as f32, 0.0);
    let segment = |pair: &Corners| {
        let (a, b) = (place(pair[0]), place(pair[1]));
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + along * (b - a))
    };
    corners.windows(2).map(segment).fold(f32::INFINITY, f32::min)
}

/// Share of the ridge that is at one of some offsets within 10 %.
fn share_at(offsets: &[f32], off: impl Iterator<Item = f32>) -> f32 {
    let is_near = |off: f32| offsets.iter().any(|offset| (off / offset - 1.0).abs() < 0.1);
    let all: Vec<bool> = off.map(is_near).collect();
    all.iter().filter(|near| **near).count() as f32 / all.len().max(1) as f32
}

fn are_quads(mesh: &Mesh) -> bool {
    mesh.faces.ids().all(|f| mesh.faces.valence(f) == 4)
}

/// Whether every face of a flat sheet looks up.
fn all_look_up(mesh: &Mesh) -> bool {
    mesh.faces.ids().all(|f| {
        let p: Vec<Vec3> = mesh.faces.vertices_of(f).iter().map(|&v| mesh.points[v]).collect();
        (p[2] - p[0]).cross(p[3] - p[1]).z > 0.0
    })
}

#[test]
fn rows_keep_their_distance_on_a_sheet() {
    let lines: [(&str, &Corners); 6] = [
        ("zigzag", &[[2, 3], [5, 3], [5, 5], [6, 5], [6, 7], [8, 7], [8, 9], [10, 9], [10, 11]]),
        ("straight", &[[3, 8], [13, 8]]),
        ("across", &[[0, 8], [16, 8]]),
        ("turned", &[[3, 4], [11, 4], [11, 13]]),
        ("closed", &[[4, 4], [12, 4], [12, 12], [4, 12], [4, 4]]),
        ("stairs", &[[1, 3], [6, 3], [6, 7], [11, 7], [11, 11], [15, 11]]),
    ];
    for (name, corners) in lines {
        let garment = flat(corners);
        for offset in [0.3, 1.0, 1.7, 3.0] {
            let (mesh, warnings) = rendered(&garment, &options(&[&format!("seam.s.offset={offset}")]));
            let crest = crest(&mesh);
            let share = share_at(&[offset], crest.iter().map(|&p| off_line(p, corners)));
            assert!(share > 0.95, "{name}, {offset}: {share} of {}", crest.len());
            assert!(are_quads(&mesh) && all_look_up(&mesh), "{name}, {offset}");
            assert!(warnings.is_empty(), "{name}, {offset}: {warnings:?}");
            // No place of it is farther off, in corners either.
            let worst = crest.iter().map(|&p| (off_line(p, corners) / offset - 1.0).abs()).fold(0.0, f32::max);
            assert!(worst < 0.14, "{name}, {offset}: {worst} off");
            // Both rows run all along the first edges, up to where heights fall.
            for side in [-1.0, 1.0] {
                let [[x, y], [end, _], ..] = *corners else { panic!("a line") };
                let reach = end as f32 - if corners.len() > 2 { 3.5 } else { 0.6 };
                let mut along = x as f32 + 0.6 + if name == "closed" { 3.0 } else { 0.0 };
                while along < reach {
                    let place = Vec3::new(along, y as f32 + side * offset, 0.0);
                    let off = crest.iter().map(|p| p.distance(place)).fold(f32::INFINITY, f32::min);
                    assert!(off < 0.15, "{name}, {offset}: no row at {place}");
                    along += 0.1;
                }
            }
        }
    }
}

#[test]
fn rows_nearer_than_half_a_face_are_there() {
    let garment = flat(&[[0, 8], [16, 8]]);
    for offset in [0.3, 0.06, 0.02] {
        let sizes = [format!("seam.s.offset={offset}"), format!("seam.s.width={}", 0.7 * offset)];
        let options =
            ["render.level=0".into(), "seam.s.edges=line".into(), format!("seam.s.normalOffset={}", 0.1 * offset)];
        let (mesh, warnings) = rendered(&garment, &[&options[..], &sizes].concat());
        assert!(warnings.is_empty(), "{offset}: {warnings:?}");
        for x in 0..=N {
            for side in [-1.0, 1.0] {
                let is_on_row =
                    |p: &&Vec3| (p.x - x as f32).abs() < 0.01 && (p.y - 8.0 - side * offset).abs() < 0.1 * offset;
                assert!(mesh.points.iter().any(|p| is_on_row(&p) && p.z > 0.05 * offset), "{offset}: no row at {x}");
            }
        }
    }
}

#[test]
fn rows_keep_their_distance_over_uneven_faces() {
    // The rows of points beside the edges are near them at every third column.
    let mut garment = flat(&[[0, 8], [16, 8]]);
    for p in garment.points.iter_mut().filter(|p| p.x % 3.0 == 1.0 && (p.y == 7.0 || p.y == 9.0)) {
        p.y = 8.0 + 0.4 * (p.y - 8.0);
    }
    let offset = 0.5;
    let (mesh, _) = rendered(&garment, &options(&[&format!("seam.s.offset={offset}"), "render.level=4"]));
    // The highest place of each column of points.
    for x in (10..150).step_by(5).map(|x| 0.1 * x as f32) {
        let column = mesh.points.iter().filter(|p| (p.x - x).abs() < 0.05 && p.y > 8.0);
        let Some(top) = column.max_by(|a, b| a.z.total_cmp(&b.z)) else { panic!("no points at {x}") };
        assert!(((top.y - 8.0) / offset - 1.0).abs() < 0.04, "{} from the edges at {x}", top.y - 8.0);
    }
}

#[test]
fn sides_are_those_of_the_asymmetry() {
    for (corners, up) in [([[3, 8], [13, 8]], 1.0), ([[13, 8], [3, 8]], -1.0)] {
        let garment = flat(&corners);
        for (side, sign) in [("left", up), ("right", -up)] {
            let (mesh, _) = rendered(&garment, &options(&["seam.s.offset=0.7", &format!("seam.s.side={side}")]));
            let crest = crest(&mesh);
            assert!(!crest.is_empty() && crest.iter().all(|p| (p.y - 8.0) * sign > 0.6), "{corners:?}, {side}");
        }
        // All of the width is on the left of the row as on the left of the seam.
        let wide = |more: &[&str]| {
            let all = [&["seam.s.side=left", "seam.s.asymmetry=-1", "seam.s.width=0.3"], more].concat();
            let mesh = rendered(&garment, &options(&all)).0;
            let raised = mesh.points.iter().filter(|p| p.z > 0.4 * HEIGHT && (p.x - 8.0).abs() < 3.0);
            let up: Vec<f32> = raised.map(|p| up * (p.y - 8.0)).collect();
            let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max].map(|f| up.iter().copied().reduce(f));
            (low.expect("a ridge"), high.expect("a ridge"))
        };
        let ((low, high), (row_low, row_high)) = (wide(&[]), wide(&["seam.s.offset=0.7"]));
        assert!((row_low - low - 0.7).abs() < 0.03 && (row_high - high - 0.7).abs() < 0.03);
    }
}

#[test]
fn several_rows_lie_beside_the_seam() {
    let corners = [[0, 8], [16, 8]];
    let more = ["seam.s.rows=3", "seam.s.rowGap=0.5", "render.faceSets=true"];
    let (mesh, warnings) = rendered(&flat(&corners), &options(&more));
    assert!(warnings.is_empty(), "{warnings:?}");
    for row in [0.0, 0.5, 1.0, -0.5, -1.0] {
        let beside = crest(&mesh).iter().filter(|p| (p.y - 8.0 - row).abs() < 0.05).count();
        assert!(beside > 64, "{beside} at {row}");
    }
    assert_eq!(
        share_at(&[0.5, 1.0], crest(&mesh).iter().map(|&p| off_line(p, &corners)).filter(|off| *off > 0.1)),
        1.0
    );
    assert!(faces_in(&mesh, "s_rows").len() > faces_in(&mesh, "s_seam").len());

    // Rows closer than their width share the room.
    let (mesh, warnings) = rendered(&flat(&corners), &options(&["seam.s.rows=3", "seam.s.rowGap=0.2"]));
    assert!(
        warnings.iter().any(|w| w.code == codes::NARROW_SEAM && w.problem.contains("its rows have")),
        "{warnings:?}"
    );
    assert!(are_quads(&mesh) && all_look_up(&mesh));
}

#[test]
fn rows_follow_a_border_on_the_side_with_cloth() {
    let around = [[0, 0], [16, 0], [16, 16], [0, 16], [0, 0]];
    for offset in [0.3, 1.0, 3.0] {
        let (mesh, warnings) = rendered(&flat(&around), &options(&[&format!("seam.s.offset={offset}")]));
        let crest = crest(&mesh);
        let share = share_at(&[offset], crest.iter().map(|&p| off_line(p, &around)));
        assert!(share > 0.95 && crest.len() > 500, "{offset}: {share} of {}", crest.len());
        assert!(warnings.iter().all(|w| w.code != codes::NARROW_SEAM), "{offset}: {warnings:?}");
        assert!(are_quads(&mesh) && all_look_up(&mesh));
    }
}

#[test]
fn rows_join_where_they_meet_and_are_left_out_beyond() {
    let narrow = [[3, 6], [13, 6], [13, 8], [3, 8], [3, 6]];
    let inside = |p: &&Vec3| p.x > 3.2 && p.x < 12.8 && p.y > 6.2 && p.y < 7.8;
    for (offset, is_inside) in [(0.6, true), (0.9, true), (1.4, false)] {
        let (mesh, warnings) = rendered(&flat(&narrow), &options(&[&format!("seam.s.offset={offset}")]));
        assert!(are_quads(&mesh) && all_look_up(&mesh), "{offset}");
        assert_eq!(crest(&mesh).iter().any(|p| inside(&p)), is_inside, "{offset}");
        let left_out = warnings.iter().find(|w| w.problem.contains("no row beside"));
        assert_eq!(left_out.is_none(), is_inside, "{offset}: {warnings:?}");
        assert!(left_out.is_none_or(|w| w.elements.len() == 24), "{left_out:?}");
        assert!(warnings.iter().all(|w| w.code != codes::INTERSECTIONS), "{offset}: {warnings:?}");
    }
}

#[test]
fn a_row_beyond_the_cloth_of_a_short_seam_is_told() {
    let (_, warnings) = rendered(&flat(&[[7, 8], [9, 8]]), &options(&["seam.s.offset=9"]));
    assert!(warnings.iter().any(|w| w.problem.contains("no row beside")), "{warnings:?}");
}

#[test]
fn rows_stop_beside_another_seam() {
    let garment = with_edges(sheet(N as usize), "line", &steps(&[[1, 8], [15, 8]]));
    let garment = checked(with_edges(garment, "other", &steps(&[[8, 0], [8, 16]])));
    let other = ["seam.t.edges=other", "seam.t.width=0.3", "seam.t.normalOffset=-0.05", "seam.s.offset=1.7"];
    let (mesh, warnings) = rendered(&garment, &options(&other));
    let crest = crest(&mesh);
    assert!(crest.iter().all(|p| (p.x - 8.0).abs() > 0.4));
    assert!([7.0, 9.0].iter().all(|x| crest.iter().any(|p| (p.x - x).abs() < 0.1)), "the row goes on beside it");
    assert!(warnings.iter().any(|w| w.problem.contains("no row beside") && w.place == "seam.s"), "{warnings:?}");
    let depth = mesh.points.iter().filter(|p| (p.x - 8.0).abs() < 0.02).map(|p| p.z).fold(f32::NEG_INFINITY, f32::max);
    assert!(depth < -0.04, "the other seam has its depth all along: {depth}");

    // A second seam of the same edges is a row of the first one.
    let twin = ["seam.t.edges=line", "seam.t.width=0.24", "seam.t.normalOffset=0.05", "seam.s.offset=1.7"];
    let (mesh, warnings) = rendered(&garment, &options(&twin));
    assert!(warnings.is_empty(), "{warnings:?}");
    let rows: BTreeSet<i32> = self::crest(&mesh).iter().map(|p| (10.0 * (p.y - 8.0)).round() as i32).collect();
    assert!([-17, 0, 17].iter().all(|row| rows.contains(row)), "{rows:?}");
}

#[test]
fn rows_keep_their_distance_on_a_tube() {
    let garment = checked(tube());
    let face = std::f32::consts::TAU * 2.0 / 16.0;
    let plain = limit(&rendered(&garment, &["render.level=3"]).0);
    let radius = plain[VertexId::new(3)].truncate().length();
    for share in [0.3, 1.0, 3.0] {
        for set in ["line", "ring"] {
            let offset = share * face;
            let more = [format!("seam.s.edges={set}"), format!("seam.s.offset={offset}"), "seam.s.width=0.2".into()];
            let more: Vec<&str> = more.iter().map(String::as_str).collect();
            let (mesh, _) = rendered(&garment, &options(&more));
            let places = limit(&mesh);
            let crest: Vec<Vec3> = places.iter().copied().filter(|p| p.truncate().length() > radius + CREST).collect();
            let line = 3.0 / 16.0 * std::f32::consts::TAU;
            let off = |p: &Vec3| match set {
                "ring" => (p.z - 3.0).abs(),
                _ => radius * (p.y.atan2(p.x) - line).abs(),
            };
            let share = share_at(&[offset], crest.iter().map(off));
            assert!(share > 0.95 && crest.len() > 100, "{set}, {offset}: {share} of {}", crest.len());
            assert!(are_quads(&mesh));
        }
    }
}

/// Distances along a mesh from some vertices up to a limit: shortest paths over edges and across the faces around them.
fn distances(mesh: &Mesh, from: &BTreeSet<VertexId>, most: f32) -> BTreeMap<VertexId, f32> {
    let t = Topology::new(mesh.faces.clone(), mesh.points.len());
    let ring = |v: VertexId| t.faces_at(v).flat_map(|f| t.faces.vertices_of(f).to_vec());
    let mut open: BinaryHeap<_> = from.iter().map(|&v| (Reverse(0u32), v.index())).collect();
    let mut done = BTreeMap::new();
    while let Some((Reverse(bits), v)) = open.pop() {
        let (v, distance) = (VertexId::new(v), f32::from_bits(bits));
        if distance > most {
            break;
        }
        if done.contains_key(&v) {
            continue;
        }
        done.insert(v, distance);
        let near: BTreeSet<VertexId> = ring(v).flat_map(ring).filter(|w| !done.contains_key(w)).collect();
        let next = near.into_iter().map(|w| (distance + mesh.points[v].distance(mesh.points[w]), w));
        open.extend(next.map(|(distance, w)| (Reverse(distance.to_bits()), w.index())));
    }
    done
}

fn edge_vertices(mesh: &Mesh, name: &str) -> BTreeSet<VertexId> {
    match mesh.subset(name).map(|set| &set.elements) {
        Some(Elements::Edges(edges)) => edges.iter().flatten().copied().collect(),
        _ => BTreeSet::new(),
    }
}

/// The places of a ridge on the surface: those of the same mesh without heights.
fn ridge(raised: &Mesh, flat: &Mesh, height: f32) -> Vec<Vec3> {
    assert_eq!(raised.faces, flat.faces);
    let lift = |v: VertexId| raised.points[v].distance(flat.points[v]);
    flat.points.ids().filter(|&v| lift(v) > 0.85 * height).map(|v| flat.points[v]).collect()
}

#[test]
fn rows_keep_their_distance_on_a_coat_and_a_shirt() {
    let wanted = [("coat.usda", &["side_seams", "placket"][..]), ("tshirt.usda", &["side_seams"])];
    for (name, sets) in wanted {
        let garment = load_named(name);
        let edge = mean_edge_length(&garment);
        for set in sets {
            let plain = rendered(&garment, &["render.level=3"]).0;
            let before = crossing_parents(&plain, &parents(&plain));
            let from = edge_vertices(&plain, set);
            for share in [0.3, 1.0, 3.0] {
                let (offset, height) = (share * edge, 0.02 * edge);
                let with = |height: f32| {
                    let options = [
                        "render.level=3".to_owned(),
                        format!("seam.s.edges={set}"),
                        format!("seam.s.offset={offset}"),
                        format!("seam.s.width={}", 0.15 * edge),
                        format!("seam.s.normalOffset={height}"),
                    ];
                    rendered(&garment, &options)
                };
                let (mesh, warnings) = with(height);
                let ridge = ridge(&mesh, &with(0.0).0, height);
                let known = distances(&plain, &from, 1.5 * offset + edge);
                let at = &plain.points;
                let off =
                    |p: &Vec3| known.iter().map(|(&v, off)| off + at[v].distance(*p)).fold(f32::INFINITY, f32::min);
                let found = share_at(&[offset], ridge.iter().step_by(37).map(off));
                let after = crossing_parents(&mesh, &parents(&mesh));
                let new = after.difference(&before).count();
                assert!(found > 0.95 && !ridge.is_empty(), "{name}, {set}, {share}: {found} of {}", ridge.len());
                assert!(new == 0, "{name}, {set}, {share}: {new} crossings, {warnings:?}");
                assert!(are_quads(&mesh));
            }
        }
    }
}
