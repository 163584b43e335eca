//! Options of the simulation mesh that change where its vertices lie: what each promises, with it and without it.

use super::{MAX_FACES, baseline, prepare};
use crate::built::build;
use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use tailor::codes;
use tailor::sim::{SimProduct, simulate};
use tailor_costume::Builder;
use tailor_costume::recipe::Layers;
use tailor_mesh::connectivity::{CornerId, VertexId};
use tailor_mesh::error::Warning;
use tailor_mesh::garment::{BoundaryInterpolation, Garment, SubsetInput, Values};
use tailor_testing::sheets;

/// A sheet whose density jumps from vertex to vertex.
fn uneven() -> Garment {
    sheets::grid(8, 8, |_, _| true)
}

fn product(input: Garment, options: &[&str]) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES)
}

/// The largest growth of target lengths along an edge of the baseline, per length.
fn growth(product: &SimProduct) -> f32 {
    let base = &product.baseline;
    let slope = |&[a, b]: &[tailor_mesh::connectivity::VertexId; 2]| {
        (base.target[a] - base.target[b]).abs() / base.points[a].distance(base.points[b])
    };
    base.topology.edges.iter().map(slope).fold(0.0, f32::max)
}

#[test]
fn graded_lengths_grow_no_faster_than_asked_for() {
    let sizes = ["sim.density=density", "sim.minEdgeLength=0.1", "sim.maxEdgeLength=1.6"];
    let free = product(uneven(), &sizes);
    assert_eq!(free.report.graded, 0, "off unless asked for");
    for factor in [1.1f32, 1.3, 1.6] {
        assert!(growth(&free) > factor - 1.0, "{factor} asks for something");
        let option = format!("sim.grading={factor}");
        let graded = product(uneven(), &[&sizes[..], &[option.as_str()]].concat());
        assert!(growth(&graded) <= factor - 1.0 + 1e-3, "{factor}: {}", growth(&graded));
        let pairs = || graded.baseline.target.iter().zip(free.baseline.target.iter());
        assert!(pairs().all(|(graded, free)| graded <= free), "{factor}: grading only shortens");
        assert_eq!(graded.report.graded, pairs().filter(|(graded, free)| graded < free).count(), "{factor}");
    }
}

#[test]
fn a_set_is_a_density_that_falls_by_rings_of_edges() {
    let mut input = sheets::grid(8, 1, |_, _| true);
    input.primvars.retain(|primvar| primvar.name != "density");
    input.subsets.clear();
    let cuff = |kind: &str, indices| SubsetInput {
        name: "cuff".into(),
        element_type: kind.into(),
        family: String::new(),
        indices,
    };
    let lengths = |kind: &str, indices: Vec<i32>, density: &str| -> Vec<f32> {
        let mut input = input.clone();
        input.subsets.push(cuff(kind, indices));
        let density = format!("sim.density={density}");
        let options = ["sim.minEdgeLength=0.1", "sim.maxEdgeLength=0.4", "sim.baselineLevel=0", &density];
        let made = baseline(&prepare(input, &options));
        let columns: BTreeMap<usize, BTreeSet<u32>> =
            made.points.enumerated().fold(BTreeMap::new(), |mut all, (v, p)| {
                all.entry(p.x as usize).or_default().insert((made.target[v] * 1e4).round() as u32);
                all
            });
        columns.into_values().flatten().map(|length| length as f32 / 1e4).collect()
    };
    let of_ends = [0.1, 0.2, 0.3, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4];
    let of_face = [0.1, 0.1, 0.2, 0.3, 0.4, 0.4, 0.4, 0.4, 0.4];
    assert_eq!(lengths("face", vec![0], "cuff"), of_face);
    assert_eq!(lengths("edge", vec![0, 9], "cuff"), of_ends);
    assert_eq!(lengths("point", vec![0, 9], "cuff"), of_ends);
}

#[test]
fn a_set_makes_triangles_smaller_where_it_is() {
    let mut input = sheets::grid(12, 6, |_, _| true);
    let (name, element_type) = ("cuff".into(), "face".into());
    let indices = (0..6).map(|row| 12 * row).collect();
    input.subsets.push(SubsetInput { name, element_type, family: String::new(), indices });
    let made = |density: &str| {
        let density = format!("sim.density={density}");
        build(input.clone(), &["sim.minEdgeLength=0.2", "sim.maxEdgeLength=0.6", &density]).products.sim
    };
    let sim = made("cuff");
    let mean = |within: Range<f32>| {
        let edges = sim.faces.corners().ids().map(|corner| sim.faces.half_edge(corner).map(|v| sim.points[v]));
        let within = edges.filter(|ends| ends.iter().all(|p| within.contains(&p.x)));
        let lengths: Vec<f32> = within.map(|[a, b]| a.distance(b)).collect();
        lengths.iter().sum::<f32>() / lengths.len() as f32
    };
    let [near, far] = [mean(-0.1..1.1), mean(6.0..12.1)];
    assert!((0.16..0.25).contains(&near) && (0.5..0.7).contains(&far), "{near} {far}");
    // A set that an expression describes is as good as one of the mesh.
    assert_eq!(made("points(cuff)").points, sim.points);
    assert_eq!(made("faces(points(cuff)) & cuff").points, sim.points);
}

#[test]
fn a_density_that_is_neither_painted_nor_a_set_is_refused() {
    let fault_of = |input: Garment, density: &str| {
        let mut layers = Layers::default();
        layers.add_override(&format!("sim.density={density}")).expect("a value");
        let mut builder = Builder::new(input).expect("a sheet");
        builder.update(&layers.recipe().expect("a recipe")).map(|_| ()).expect_err(density).to_string()
    };
    // A primvar of another kind is no density, though a set has its name.
    let mut input = uneven();
    let (name, element_type) = ("st".into(), "face".into());
    input.subsets.push(SubsetInput { name, element_type, family: String::new(), indices: vec![0] });
    assert!(fault_of(input, "st").contains("is not a float primvar per vertex"));
    let fault = |density: &str| fault_of(uneven(), density);
    let misspelt = fault("densty");
    assert!(misspelt.contains("did you mean density?") && misspelt.contains("sim.density"), "{misspelt}");
    assert!(fault("nearly(borders)").contains("nearly"));
}

#[test]
fn borders_keep_the_corners_that_turn_by_more_than_the_angle() {
    let corners = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(4.0, 4.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
    let kept = |angle: &str| {
        let mut input = sheets::grid(4, 4, |_, _| true);
        // Rounded corners are not corners by themselves, and level 0 has the sheet's own border.
        input.rules.boundary = BoundaryInterpolation::EdgeOnly;
        let angle = format!("sim.cornerAngle={angle}");
        let options = ["sim.baselineLevel=0", "sim.maxEdgeLength=0.7", "sim.uvSet=", &angle];
        let product = product(input, &options);
        let is_there = |corner: &&Vec3| product.points.iter().any(|p| p.truncate() == corner.truncate());
        (product.report.corners, corners.iter().filter(is_there).count())
    };
    assert_eq!(kept("50"), (4, 4));
    assert_eq!(kept("89"), (4, 4));
    assert_eq!(kept("91").0, 0, "a right angle turns by less");
    assert_eq!(kept("180").0, 0);
}

#[test]
fn curves_that_bend_within_an_edge_are_told() {
    // Edges cut off corners of a comb that keeps none: it has more than edges can slide onto.
    for (angle, is_cut) in [("50", false), ("180", true)] {
        let mut input = sheets::grid(7, 4, |x, y| y < 2 || x % 2 == 0);
        input.rules.boundary = BoundaryInterpolation::EdgeOnly;
        let angle = format!("sim.cornerAngle={angle}");
        let again = input.clone();
        let prepared = prepare(input, &["sim.maxEdgeLength=1.1", "sim.baselineLevel=0", "sim.uvSet=", &angle]);
        let product = simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES);
        let base = &product.baseline;
        let mut farthest = 0.0f32;
        for (id, chain) in base.chains.enumerated() {
            let off = |p: Vec3| {
                let ends = product.chain_edges[id].iter().map(|e| e.map(|v| product.points[v]));
                ends.map(|[a, b]| off_segment(p, a, b)).fold(f32::MAX, f32::min)
            };
            let own = chain.vertices.iter().map(|&v| off(base.points[v]) / base.target[v]).fold(0.0, f32::max);
            assert!((product.gaps[id].distance - own).abs() < 1e-4, "{own} is {:?}", product.gaps[id]);
            farthest = farthest.max(own);
        }
        assert_eq!(farthest > 0.1, is_cut, "{farthest} with {angle}");
        let mut builder = Builder::new(again).unwrap_or_else(|e| panic!("{e}"));
        let warnings = builder.update(&prepared.recipe).unwrap_or_else(|e| panic!("{e}")).warnings;
        let told = product.gaps.iter().map(|gap| gap.distance).fold(0.0, f32::max);
        let is_told = |w: &Warning| w.code == codes::CURVES_CUT && w.amount == Some(told);
        assert_eq!(warnings.iter().any(is_told), is_cut, "{warnings:?}");
    }
}

fn off_segment(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let t = (p - a).dot(b - a) / a.distance_squared(b);
    p.distance(a.lerp(b, t.clamp(0.0, 1.0)))
}

/// How far each vertex inside the mesh is from the centroid of its triangles in UV, on the mean. \[edge lengths in UV\]
fn off_centroid(product: &SimProduct) -> f32 {
    let mut around: BTreeMap<VertexId, Vec<[Vec2; 3]>> = BTreeMap::new();
    for (i, triangle) in product.triangles.iter().enumerate() {
        let uvs = [0, 1, 2].map(|k| product.places[CornerId::new(3 * i + k)].uv);
        (0..3).for_each(|k| around.entry(triangle[k]).or_default().push([uvs[k], uvs[(k + 1) % 3], uvs[(k + 2) % 3]]));
    }
    product.chain_edges.iter().flatten().flatten().for_each(|v| _ = around.remove(v));
    let off = |triangles: &Vec<[Vec2; 3]>| {
        let area = |[a, b, c]: [Vec2; 3]| (b - a).perp_dot(c - a).abs();
        let whole: f32 = triangles.iter().map(|&t| area(t)).sum();
        let centroid: Vec2 = triangles.iter().map(|t| area(*t) / whole * (t[0] + t[1] + t[2]) / 3.0).sum();
        centroid.distance(triangles[0][0]) / (whole / triangles.len() as f32).sqrt()
    };
    around.values().map(off).sum::<f32>() / around.len() as f32
}

#[test]
fn relaxation_in_uvs_brings_vertices_to_centroids_there() {
    // A sheet whose panel is stretched by up to nine along one side.
    let mut input = sheets::grid(12, 12, |_, _| true);
    let uvs = input.primvars.iter_mut().find(|p| p.name == "st").expect("UVs");
    let Values::F32(values) = &mut uvs.values else { panic!("UVs are floats") };
    values.chunks_exact_mut(2).for_each(|uv| uv[1] += 4.0 * uv[1] * uv[1] / 12.0);
    let off = |relax: &str| {
        let relax = format!("sim.relax={relax}");
        let product = product(input.clone(), &["sim.maxEdgeLength=0.4", "sim.uvSet=st", "sim.cornerAngle=50", &relax]);
        off_centroid(&product)
    };
    let [surface, uv] = ["surface", "uv"].map(off);
    assert!(uv < 0.9 * surface, "{surface} by the surface, {uv} by UVs");
}

#[test]
fn relaxation_in_uvs_needs_some() {
    for (without, why) in [("sim.uvSet=", "no UV set"), ("sim.constrainUvSeams=false", "sim.constrainUvSeams to true")]
    {
        let prepared = prepare(sheets::grid(4, 4, |_, _| true), &["sim.relax=uv", without]);
        let error = Builder::new(sheets::grid(4, 4, |_, _| true)).and_then(|mut b| b.update(&prepared.recipe)).err();
        let told = error.expect("an error").to_string();
        assert!(told.contains("sim.relax") && told.contains(why), "{told}");
    }
}
