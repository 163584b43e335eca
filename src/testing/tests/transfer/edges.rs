//! Edge sets that were not constraints: found again as the same chains, near their curves.

use super::sets::{FREE, edges, garment};
use super::sheet;
use crate::built::{Built, build};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::garment::Elements;
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
        for set in &built.products.sim_figures().edge_sets {
            assert!(set.farthest <= 1.0, "{file:?}: {} is {} targets away", set.name, set.farthest);
            // A path of edges across a lattice of equilateral triangles is at most 2 / sqrt 3 of a straight line; where a
            // curve's is beyond the twentieth that is asked, hardly a shorter one is there.
            assert!(set.length <= set.shortest_length + 0.006 * set.source_length, "{file:?}: {set:?}");
            assert!(set.length <= 2.0 / 3f64.sqrt() * set.source_length, "{file:?}: {set:?}");
            let Some(Elements::Edges(source)) = built.garment.subset(&set.name).map(|s| &s.elements) else { continue };
            let (wanted, own) = (chains(source), chains(&edges(&built.products.sim, &set.name)));
            let count = |c: &[(bool, usize)], is_loop: bool| c.iter().filter(|c| c.0 == is_loop).count();
            let meeting = told_meeting(&built, &set.name);
            assert!(20 * meeting <= wanted.len(), "{file:?}: {meeting} chains of {} meet", set.name);
            for is_loop in [true, false] {
                let (own, wanted) = (count(&own, is_loop), count(&wanted, is_loop));
                assert!(own.abs_diff(wanted) <= meeting, "{file:?}: {}, loops {is_loop}: {own}, {wanted}", set.name);
            }
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
