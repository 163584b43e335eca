//! Edge sets that were not constraints: found again as the same chains, near their curves.

use super::sets::{FREE, border_edges, edges, faces, garment, with_faces};
use super::sheet;
use crate::built::{Built, build};
use std::collections::{BTreeMap, BTreeSet};
use tailor::sim::distance_to_segment;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::garment::{Elements, Garment};
use tailor_testing::garments::garments;
use tailor_testing::sheets;

/// The chains of an edge set: for each whether it is a loop, and its number of edges.
fn chains(edges: &[[VertexId; 2]]) -> Vec<(bool, usize)> {
    let mut at: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
    for (i, edge) in edges.iter().enumerate() {
        edge.iter().for_each(|v| at.entry(*v).or_default().push(i));
    }
    let mut used = vec![false; edges.len()];
    let mut walk = |start: VertexId, first: usize| {
        let (mut vertex, mut edge, mut count) = (start, first, 0);
        while !std::mem::replace(&mut used[edge], true) {
            count += 1;
            vertex = if edges[edge][0] == vertex { edges[edge][1] } else { edges[edge][0] };
            if at[&vertex].len() != 2 || vertex == start {
                break;
            }
            edge = at[&vertex].iter().copied().find(|&e| !used[e]).unwrap_or(edge);
        }
        (count > 0).then_some((vertex == start && at[&start].len() == 2, count))
    };
    let ends = |is_end: bool| at.iter().filter(move |(_, e)| (e.len() != 2) == is_end);
    let mut found = Vec::new();
    for is_end in [true, false] {
        found.extend(ends(is_end).flat_map(|(&v, e)| e.iter().map(move |&e| (v, e))).filter_map(|(v, e)| walk(v, e)));
    }
    found
}

/// Lines on a sheet of 8 by 8 quads: name, pairs of points, and how many open chains and loops they are.
fn lines() -> Vec<(&'static str, Vec<[i32; 2]>, usize, usize)> {
    let at = |x: i32, y: i32| 9 * y + x;
    let line = |points: &[(i32, i32)]| -> Vec<[i32; 2]> {
        points.windows(2).map(|p| [at(p[0].0, p[0].1), at(p[1].0, p[1].1)]).collect()
    };
    let row = |y: i32, from: i32, to: i32| line(&(from..=to).map(|x| (x, y)).collect::<Vec<_>>());
    let column = |x: i32, from: i32, to: i32| line(&(from..=to).map(|y| (x, y)).collect::<Vec<_>>());
    let ring = line(&[(2, 2), (3, 2), (4, 2), (4, 3), (4, 4), (3, 4), (2, 4), (2, 3), (2, 2)]);
    let ring2 = line(&[(4, 4), (5, 4), (6, 4), (6, 5), (6, 6), (5, 6), (4, 6), (4, 5), (4, 4)]);
    vec![
        ("single", row(3, 2, 3), 1, 0),
        ("open", row(3, 1, 7), 1, 0),
        ("across", row(3, 0, 8), 1, 0),
        ("bent", [row(2, 1, 5), column(5, 2, 6)].concat(), 1, 0),
        ("ring", ring.clone(), 0, 1),
        ("touching", [ring, ring2].concat(), 2, 0),
        ("crossing", [row(4, 1, 7), column(4, 1, 7)].concat(), 4, 0),
        ("tee", [row(4, 1, 7), column(4, 4, 7)].concat(), 3, 0),
        ("two", [row(2, 1, 7), row(5, 1, 7)].concat(), 2, 0),
        ("border", row(0, 0, 8), 1, 0),
        ("beside", row(1, 0, 8), 1, 0),
        ("none", Vec::new(), 0, 0),
    ]
}

#[test]
fn free_edge_sets_are_found_as_the_same_chains() {
    for (uv, length) in [("sim.uvSet=st", "0.5"), ("sim.uvSet=", "0.5"), ("sim.uvSet=", "0.3"), ("sim.uvSet=", "0.8")] {
        let mut input = sheet(8, 8);
        for (name, pairs, ..) in lines() {
            input = sheets::with_edges(input, name, &pairs);
        }
        let built = build(input, &[uv, &format!("sim.maxEdgeLength={length}")]);
        assert!(built.warnings.is_empty(), "{:?}", built.warnings);
        for (name, _, open, loops) in lines() {
            let own = chains(&edges(&built.products.sim, name));
            let found = (own.iter().filter(|c| !c.0).count(), own.iter().filter(|c| c.0).count());
            assert_eq!(found, (open, loops), "{name} at {length}: open chains and loops, {own:?}");
            let figures = built.products.sim_figures();
            let figures = figures.edge_sets.iter().find(|e| e.name == name).expect("figures");
            assert!(figures.farthest <= 1.0, "{name} at {length} is {} targets away", figures.farthest);
        }
    }
}

/// The number of chains of a set that meet others, as the warning says.
fn told_meeting(built: &Built, set: &str) -> usize {
    let of_set = built.warnings.iter().filter(|w| w.place == format!("subset {set}"));
    let number = of_set.filter_map(|w| w.problem.split_once(" chains meet others")?.0.parse::<usize>().ok());
    number.sum()
}

#[test]
fn free_edge_sets_of_garments_stay_by_their_curves() {
    for file in garments() {
        let built = garment(&file, &FREE);
        let face_sets = built.garment.subsets.iter().filter_map(|s| match &s.elements {
            Elements::Faces(faces) => Some(border_edges(&built.garment, faces)),
            _ => None,
        });
        let borders: BTreeSet<[VertexId; 2]> = face_sets.flatten().collect();
        for set in &built.products.sim_figures().edge_sets {
            let Some(Elements::Edges(source)) = built.garment.subset(&set.name).map(|s| &s.elements) else { continue };
            // A path of edges across a lattice of equilateral triangles is at most 2 / sqrt 3 of a straight line, and more
            // where a curve bends. A border of face sets goes around each triangle.
            let bounds = source.iter().any(|&[a, b]| borders.contains(&[a.min(b), a.max(b)]));
            let (most, reach) = if bounds { (1.5, 1.1) } else { (1.2, 1.0) };
            assert!(set.farthest <= reach, "{file:?}: {} is {} targets away", set.name, set.farthest);
            assert!(set.length <= most * set.source_length, "{file:?}: {set:?}");
            let (wanted, own) = (chains(source), chains(&edges(&built.products.sim, &set.name)));
            let count = |c: &[(bool, usize)], is_loop: bool| c.iter().filter(|c| c.0 == is_loop).count();
            let meeting = told_meeting(&built, &set.name);
            assert!(15 * meeting <= wanted.len(), "{file:?}: {meeting} chains of {} meet", set.name);
            for is_loop in [true, false] {
                let (own, wanted) = (count(&own, is_loop), count(&wanted, is_loop));
                // Borders of face sets of about a triangle are cut and joined as these are.
                let slack = meeting + if bounds { wanted / 8 } else { 0 };
                assert!(own.abs_diff(wanted) <= slack, "{file:?}: {}, loops {is_loop}: {own}, {wanted}", set.name);
            }
        }
    }
}

/// A square of 3 by 3 faces on a sheet of 8 by 8, with a finger one face wide and three long: its faces and its outline.
fn finger() -> (Vec<i32>, Vec<[i32; 2]>) {
    let (at, face) = (|x: i32, y: i32| 9 * y + x, |x: i32, y: i32| 8 * y + x);
    let square = (1..4).flat_map(|y| (1..4).map(move |x| (x, y)));
    let is_in: BTreeSet<(i32, i32)> = square.chain((4..7).map(|x| (x, 2))).collect();
    let around = |&(x, y): &(i32, i32)| {
        let sides = [(0, -1, [at(x, y), at(x + 1, y)]), (1, 0, [at(x + 1, y), at(x + 1, y + 1)])];
        let others = [(0, 1, [at(x, y + 1), at(x + 1, y + 1)]), (-1, 0, [at(x, y), at(x, y + 1)])];
        sides.into_iter().chain(others).map(move |(dx, dy, edge)| ((x + dx, y + dy), edge))
    };
    let outline = is_in.iter().flat_map(around).filter(|(beyond, _)| !is_in.contains(beyond)).map(|o| o.1).collect();
    (is_in.iter().map(|&(x, y)| face(x, y)).collect(), outline)
}

/// Meshes whose edges have no direction in common with the sheet's.
const TARGETS: [(&str, &str); 4] =
    [("sim.uvSet=st", "0.5"), ("sim.uvSet=", "0.5"), ("sim.uvSet=", "0.3"), ("sim.uvSet=", "0.7")];

#[test]
fn an_edge_set_that_bounds_a_face_set_is_its_border() {
    let (shape, outline) = finger();
    let input = with_faces(sheets::with_edges(sheet(8, 8), "outline", &outline), "shape", "", shape);
    let input = sheets::with_edges(input, "part", &outline[..outline.len() / 2]);
    for (uv, length) in TARGETS {
        let built = build(input.clone(), &[uv, &format!("sim.maxEdgeLength={length}")]);
        let mesh = &built.products.sim;
        let border = border_edges(mesh, &faces(mesh, "shape"));
        let own = |name: &str| -> BTreeSet<[VertexId; 2]> {
            edges(mesh, name).iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect()
        };
        assert_eq!(own("outline"), border, "{uv} {length}");
        assert!(own("part").is_subset(&border), "{uv} {length}");
        let share = own("part").len() as f64 / border.len() as f64;
        assert!((share - 0.5).abs() < 0.1, "{uv} {length}: {share} of the border");
    }
}

/// The largest distance of a set from its curve and of the curve from the set, along both, in target lengths.
fn distances(input: &Garment, built: &Built, name: &str, curve: &[[i32; 2]], target: f32) -> [f32; 2] {
    let mesh = &built.products.sim;
    let own: Vec<[glam::Vec3; 2]> = edges(mesh, name).iter().map(|e| e.map(|v| mesh.points[v])).collect();
    let curve: Vec<[glam::Vec3; 2]> = curve.iter().map(|e| e.map(|v| input.points[v as usize])).collect();
    let off = |from: &[[glam::Vec3; 2]], to: &[[glam::Vec3; 2]]| {
        let points = from.iter().flat_map(|&[a, b]| (0..=8).map(move |k| a.lerp(b, k as f32 / 8.0)));
        let nearest = |p| to.iter().map(|&[a, b]| distance_to_segment(p, a, b)).fold(f32::MAX, f32::min);
        points.map(nearest).fold(0.0, f32::max) / target
    };
    [off(&own, &curve), off(&curve, &own)]
}

#[test]
fn free_curves_keep_their_corners_and_fingers() {
    let at = |x: i32, y: i32| 9 * y + x;
    let (mut stairs, mut here) = (Vec::new(), (1, 1));
    for k in 0..10 {
        let next = if k % 4 < 2 { (here.0 + 1, here.1) } else { (here.0, here.1 + 1) };
        stairs.push([at(here.0, here.1), at(next.0, next.1)]);
        here = next;
    }
    for (name, curve) in [("outline", finger().1), ("stairs", stairs)] {
        let mut input = sheets::with_edges(sheet(8, 8), name, &curve);
        input.rules.scheme = tailor_mesh::garment::Scheme::Bilinear;
        for (uv, length) in TARGETS {
            let built = build(input.clone(), &[uv, &format!("sim.maxEdgeLength={length}")]);
            let target = length.parse().unwrap_or(1.0);
            let [path, back] = distances(&input, &built, name, &curve, target);
            assert!(path <= 0.75 && back <= 0.6, "{name}, {uv} {length}: {path} from the curve, {back} back");
            let figures = built.products.sim_figures();
            let set = figures.edge_sets.iter().find(|e| e.name == name).expect("figures");
            let share = set.length / set.source_length;
            assert!((0.9..1.25).contains(&share), "{name}, {uv} {length}: {share} of the length");
        }
    }
}

#[test]
fn chains_that_a_coarse_mesh_cannot_keep_apart_are_told() {
    // Seven lines, and hardly as many vertices as they have ends.
    let line = |x: i32| (1..7).map(move |y| [9 * y + x, 9 * (y + 1) + x]);
    let input = sheets::with_edges(sheet(8, 8), "lines", &(1..8).flat_map(line).collect::<Vec<_>>());
    let told = |length: &str| {
        let built = build(input.clone(), &["sim.uvSet=", length]);
        let is_told =
            built.warnings.iter().any(|w| w.place == "subset lines" && w.problem.contains("chains meet others"));
        (is_told, chains(&edges(&built.products.sim, "lines")).len())
    };
    assert_eq!(told("sim.maxEdgeLength=0.5"), (false, 7));
    let (is_told, found) = told("sim.maxEdgeLength=6");
    // Those that meet are cut or joined there.
    assert!(is_told && found != 7, "{found} chains, told: {is_told}");
}

#[test]
fn creases_are_sets_with_their_sharpness() {
    let mut input = sheet(8, 8);
    input.crease_indices = vec![20, 21, 22, 23, 40, 41, 42, 0, 1, 2];
    input.crease_lengths = vec![4, 3, 3];
    input.crease_sharpnesses = vec![2.0, 10.0, 2.0];
    input.corner_indices = vec![50];
    input.corner_sharpnesses = vec![4.0];
    let built = build(input, &["sim.maxEdgeLength=0.4"]);
    let mesh = &built.products.sim;
    let of = |name: &str| mesh.subset(name).unwrap_or_else(|| panic!("no {name}"));
    assert_eq!(of("tailorCreases").sharpness, Some(2.0));
    assert_eq!(of("tailorCreases_2").sharpness, Some(10.0));
    assert_eq!(of("tailorCorners").sharpness, Some(4.0));
    assert_eq!(chains(&edges(mesh, "tailorCreases")).len(), 2);
    assert_eq!(chains(&edges(mesh, "tailorCreases_2")).len(), 1);
    assert!(built.warnings.is_empty(), "{:?}", built.warnings);
}
