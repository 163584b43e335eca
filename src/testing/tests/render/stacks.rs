//! Attributes through stacks of operators: every kind of attribute, through any stack of up to four.

use super::cloth::{checked, path, sheet, with_faces};
use crate::checks::attributes::{family_faults, primvar_faults, subset_faults};
use crate::operators::{rendered, stack, try_rendered};
use glam::Vec2;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor::codes;
use tailor::render::{RenderResult, RenderSteps};
use tailor_mesh::connectivity::Topology;
use tailor_mesh::garment::{
    Elements, Family, FamilyType, Garment, Interpolation, Meaning, Mesh, PrimvarInput, PrimvarRole, SubsetInput, Values,
};
use tailor_testing::sheets::with_edges;

const N: usize = 6;
/// Name of the offsets of a blend shape.
const OFFSETS: &str = "/Coat/model/wide.offsets";

fn primvar(name: &str, interpolation: Interpolation, components: usize, values: Values) -> PrimvarInput {
    PrimvarInput { components, ..PrimvarInput::new(name, interpolation, values) }
}

/// A sheet whose attributes say where on it they are: `rest` by vertices, `st` by corners with shells 100 apart, `face`
/// and the partition `cells` by faces, a blend shape, a crease, skinning, and texts at corners.
fn sample() -> Garment {
    let mut input = sheet(N);
    let at = |v: usize| [(v % (N + 1)) as f32, (v / (N + 1)) as f32];
    let every = 0..(N + 1) * (N + 1);
    let rest: Vec<f32> = every.clone().flat_map(at).collect();
    let moved: Vec<f32> = every.flat_map(|v| [at(v)[0], 2.0 * at(v)[1], 0.0]).collect();
    input.primvars.push(primvar("rest", Interpolation::Vertex, 2, Values::F32(rest.clone())));
    input.primvars.push(primvar("flat", Interpolation::Varying, 2, Values::F32(rest)));
    let role = PrimvarRole::BlendShape { shape: 0, property: "offsets".into() };
    let offsets = primvar(OFFSETS, Interpolation::Vertex, 3, Values::F32(moved));
    input.primvars.push(PrimvarInput { role, meaning: Meaning::Vector, ..offsets });
    let faces: Vec<i32> = (0..(N * N) as i32).collect();
    let corners: Vec<String> = (0..4 * N * N).map(|c| format!("{}", c / 4)).collect();
    input.primvars.push(primvar("face", Interpolation::Uniform, 1, Values::I32(faces.clone())));
    input.primvars.push(primvar("note", Interpolation::FaceVarying, 1, Values::Text(corners)));
    let cell = |name: &str, rest: i32| SubsetInput {
        name: name.into(),
        element_type: "face".into(),
        family: "cells".into(),
        indices: faces.iter().copied().filter(|f| f % 3 == rest).collect(),
    };
    input.subsets.extend([cell("a", 0), cell("b", 1), cell("c", 2)]);
    input.families.push(Family { name: "cells".into(), kind: FamilyType::Partition });
    let (element_type, family, indices) = ("point".into(), String::new(), vec![8, 9, 24]);
    input.subsets.push(SubsetInput { name: "pins".into(), element_type, family, indices });
    input.crease_indices = vec![21, 22, 23, 24];
    input.crease_lengths = vec![4];
    input.crease_sharpnesses = vec![2.0];
    let row: Vec<i32> = (21..=27).collect();
    let column: Vec<i32> = (0..=6).map(|y| 7 * y + 3).collect();
    input = with_edges(with_edges(input, "row", &path(&row)), "column", &path(&column));
    input = with_edges(with_edges(input, "short", &path(&[8, 9, 10])), "edge", &path(&[0, 1, 2, 3]));
    with_faces(input, "left", (0..(N * N) as i32).filter(|f| f % N as i32 == 0))
}

/// The faults of an unrefined product of the sample.
fn faults(mesh: &Mesh, source: &Mesh) -> Vec<String> {
    let t = Topology::new(mesh.faces.clone(), mesh.points.len());
    let mut faults = [subset_faults(mesh, &t), family_faults(mesh), primvar_faults(mesh, source)].concat();
    if mesh.primvars.len() != source.primvars.len() {
        faults.push("a primvar was lost or added".into());
    }
    let floats = |name: &str| match &mesh.primvar(name).expect(name).values {
        Values::F32(v) => v.clone(),
        _ => Vec::new(),
    };
    let (rest, flat, uv) = (floats("rest"), floats("flat"), floats("st"));
    let shape = floats(OFFSETS);
    let st = mesh.primvar("st").expect("UVs");
    let Values::I32(parents) = &mesh.primvar("face").expect("faces").values else { return vec!["no faces".into()] };
    let note = mesh.primvar("note").expect("notes");
    let Values::Text(notes) = &note.values else { return vec!["no notes".into()] };
    for v in 0..mesh.points.len() {
        if (rest[2 * v] - flat[2 * v]).abs() > 1e-5 || (rest[2 * v + 1] * 2.0 - shape[3 * v + 1]).abs() > 1e-4 {
            faults.push(format!("vertex {v} has values of different places"));
        }
    }
    for face in mesh.faces.ids() {
        let parent = parents[face.index()] as usize;
        let shell = if parent % N < N / 2 { 0.0 } else { 100.0 };
        let (x, y) = ((parent % N) as f32, (parent / N) as f32);
        for corner in mesh.faces.corners_of(face) {
            let v = mesh.faces.vertex(corner).index();
            let (place, row) = (Vec2::new(rest[2 * v], rest[2 * v + 1]), st.row(corner.index()));
            if place.clamp(Vec2::new(x, y), Vec2::new(x + 1.0, y + 1.0)).distance(place) > 1e-4 {
                faults.push(format!("{face:?} is not within its parent {parent}: {place}"));
            }
            let value = Vec2::new(uv[2 * row] - shell, uv[2 * row + 1]);
            if value.distance(place) > 2e-4 {
                faults.push(format!("{corner:?} has UV {value} of shell {shell} at {place}"));
            }
            if notes[note.row(corner.index())] != format!("{parent}") {
                faults.push(format!("{corner:?} has the note of another face"));
            }
        }
    }
    faults.extend(uv_faults(mesh, &t));
    faults.extend(edge_faults(mesh, source));
    faults
}

/// Edges at which the UVs are cut: those of the middle column and no other.
fn uv_faults(mesh: &Mesh, t: &Topology) -> Vec<String> {
    let st = mesh.primvar("st").expect("UVs");
    let Values::F32(rest) = &mesh.primvar("rest").expect("rest").values else { return Vec::new() };
    let mut faults = Vec::new();
    for edge in t.edges.ids() {
        let &[a, b] = t.edge_corners.row(edge) else { continue };
        let row = |c| st.row(tailor_mesh::connectivity::CornerId::index(c));
        let cut = row(a) != row(t.faces.next(b)) || row(t.faces.next(a)) != row(b);
        let on_column = t.edges[edge].iter().all(|v| (rest[2 * v.index()] - (N / 2) as f32).abs() < 1e-5);
        if cut && !on_column {
            faults.push(format!("{:?} cuts the UVs", t.edges[edge]));
        }
    }
    faults
}

/// Edge subsets lie on the lines they are called after, creases on theirs, and points stay.
fn edge_faults(mesh: &Mesh, source: &Mesh) -> Vec<String> {
    let Values::F32(rest) = &mesh.primvar("rest").expect("rest").values else { return Vec::new() };
    let at = |v: tailor_mesh::connectivity::VertexId| Vec2::new(rest[2 * v.index()], rest[2 * v.index() + 1]);
    let mut faults = Vec::new();
    for subset in mesh.subsets.iter() {
        let Elements::Edges(edges) = &subset.elements else { continue };
        let fits = |p: Vec2| match subset.name.as_str() {
            "row" => p.y == 3.0,
            "column" => p.x == 3.0,
            "short" => p.y == 1.0 && (1.0..=3.0).contains(&p.x),
            _ => p.y == 0.0 && p.x <= 3.0,
        };
        faults.extend(edges.iter().flatten().filter(|v| !fits(at(**v))).map(|v| format!("{}: {v:?}", subset.name)));
        // All of the line is there, however often it was cut.
        let length: f32 = edges.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        let Some(Elements::Edges(before)) = source.subset(&subset.name).map(|s| &s.elements) else { continue };
        if length < before.len() as f32 - 1e-3 {
            faults.push(format!("{} is {length} long", subset.name));
        }
    }
    let steps: Vec<_> = mesh.creases.iter().flat_map(|c| c.vertices.windows(2).zip(&c.sharpnesses)).collect();
    let creased: Vec<_> = steps.iter().filter(|(_, s)| **s == 2.0).map(|(p, _)| (at(p[0]), at(p[1]))).collect();
    let length: f32 = creased.iter().map(|(a, b)| a.distance(*b)).sum();
    if length < 3.0 - 1e-3 || creased.iter().any(|(a, b)| a.y != 3.0 || b.y != 3.0 || a.x.max(b.x) > 3.0) {
        faults.push(format!("the crease is {length} long"));
    }
    if mesh.subset("pins").map(|s| &s.elements) != source.subset("pins").map(|s| &s.elements) {
        faults.push("points of a subset moved".into());
    }
    faults
}

/// An operator of a random stack: its name and options.
fn operator() -> impl Strategy<Value = (bool, &'static str, f32, f32, f32)> {
    let set = prop::sample::select(vec![
        "row",
        "column",
        "short",
        "edge",
        "row,column",
        "row,short",
        "left",
        "half",
        "left,half",
    ]);
    (set, 0.05f32..0.7, -0.1f32..0.1, -1.0f32..1.0).prop_map(|(set, size, offset, more)| {
        let thickness = set.contains("left") || set.contains("half");
        (thickness, set, size, offset, more)
    })
}

fn options_of(operators: &[(bool, &str, f32, f32, f32)]) -> Vec<String> {
    let mut options = vec!["render.level=0".to_owned()];
    let mut order = Vec::new();
    for (i, (thickness, set, size, offset, more)) in operators.iter().enumerate() {
        if *thickness {
            let weights = if *more > 0.5 { "density" } else { "" };
            let side = if *more > 0.0 { "outer" } else { "inner" };
            options.push(format!("fold.o{i}.faces={set}"));
            options.push(format!("fold.o{i}.thickness={}", 0.3 * size));
            options.push(format!("fold.o{i}.weights={weights}"));
            options.push(format!("fold.o{i}.side={side}"));
        } else {
            options.push(format!("seam.o{i}.edges={set}"));
            options.push(format!("seam.o{i}.width={size}"));
            options.push(format!("seam.o{i}.normalOffset={offset}"));
            options.push(format!("seam.o{i}.asymmetry={more}"));
            options.push(format!("seam.o{i}.depth={}", if *more > 0.0 { 0.02 } else { 0.0 }));
            if *more > 0.3 || *size > 0.5 {
                options.push(format!("seam.o{i}.rows={}", if *more > 0.0 { 2 } else { 1 }));
                options.push(format!("seam.o{i}.offset={}", if *size > 0.3 { 1.7 * size } else { 0.0 }));
                options.push(format!("seam.o{i}.side={}", if *offset > 0.0 { "both" } else { "left" }));
            }
        }
        order.push(format!("o{i}"));
    }
    options.push(format!("render.operators={}", order.join(",")));
    options
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, rng_seed: RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn attributes_follow_any_stack(operators in prop::collection::vec(operator(), 1..=4)) {
        let garment = checked(sample());
        let options = options_of(&operators);
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        // A second fold of faces whose border is folded already has none left, which is an error.
        let found = match try_rendered(&garment, &options) {
            Ok((mesh, _)) => faults(&mesh, &garment),
            Err(e) if e.to_string().contains("not next to a border") => Vec::new(),
            Err(e) => vec![e.to_string()],
        };
        prop_assert!(found.is_empty(), "{options:?}:\n  {}", found[..found.len().min(8)].join("\n  "));
    }
}

#[test]
fn faces_of_a_set_are_those_whose_source_is_in_it() {
    let garment = checked(sample());
    let in_left = |mesh: &Mesh| match mesh.subset("left").map(|s| &s.elements) {
        Some(Elements::Faces(faces)) => faces.iter().copied().collect::<BTreeSet<_>>(),
        other => panic!("{other:?}"),
    };
    let left = in_left(&garment);
    for level in ["render.level=0", "render.level=2"] {
        for operators in
            [&[][..], &["fold.t.faces=left"], &["fold.t.faces=left", "seam.s.edges=row", "seam.s.width=0.3"]]
        {
            let stack = stack(&[operators, &[level]].concat());
            let mut steps = RenderSteps::new(Arc::new(garment.clone()));
            let RenderResult { mesh, sources, .. } = steps.update(&stack).expect("a mesh");
            assert_eq!(sources.len(), mesh.faces.len(), "{operators:?} {level}");
            let found: BTreeSet<_> =
                sources.enumerated().filter(|(_, s)| left.contains(s)).map(|(face, _)| face).collect();
            assert_eq!(found, in_left(&mesh), "{operators:?} {level}");
        }
    }
}

#[test]
fn sources_are_kept_while_the_faces_are() {
    let garment = checked(sample());
    let mut steps = RenderSteps::new(Arc::new(garment));
    let mut made = |options: &[&str]| steps.update(&stack(options)).expect("a mesh");
    let raised = made(&["seam.s.edges=row", "seam.s.normalOffset=0.1", "render.level=1"]);
    let sunk = made(&["seam.s.edges=row", "seam.s.normalOffset=-0.1", "render.level=1"]);
    assert_ne!(raised.mesh.points, sunk.mesh.points);
    assert!(Arc::ptr_eq(&raised.sources, &sunk.sources));
    let plain = made(&["render.level=1"]);
    assert_ne!(sunk.sources, plain.sources);
}

#[test]
fn new_faces_are_in_sets_of_their_own_when_asked() {
    let garment = checked(with_faces(sample(), "s_seam", [0]));
    let base = ["seam.s.edges=row", "fold.t.faces=left", "seam.s.width=0.3", "render.level=0"];
    let (mesh, _) = rendered(&garment, &base);
    assert_eq!(mesh.subsets.len(), garment.subsets.len());
    let (mesh, warnings) = rendered(&garment, &[&base[..], &["render.faceSets=true"]].concat());
    assert!(warnings.iter().all(|w| w.code != codes::SET_RENAMED), "{warnings:?}");
    let new: BTreeSet<&str> = mesh.subsets[garment.subsets.len()..].iter().map(|s| s.name.as_str()).collect();
    assert_eq!(new, BTreeSet::from(["s_seam_faces", "t_hem", "t_inner"]));
    let faces = |name: &str| mesh.subset(name).map_or(0, |s| s.elements.len());
    // Two rows of quads along six edges, cut from the second layer by nothing yet: the seam runs first.
    assert!(faces("s_seam_faces") >= 12 && faces("t_hem") >= 8 && faces("t_inner") >= 12);

    let both = checked(with_faces(with_faces(sample(), "s_seam", [0]), "s_seam_faces", [0]));
    let (_, warnings) = rendered(&both, &[&base[..], &["render.faceSets=true"]].concat());
    let renamed: Vec<_> = warnings.iter().filter(|w| w.code == codes::SET_RENAMED).collect();
    assert!(matches!(renamed[..], [w] if w.place == "s_seam_faces_2" && w.problem.contains("`s_seam`")), "{renamed:?}");
}

#[test]
fn the_same_bytes_at_every_thread_count() {
    // Enough faces for several tasks of every parallel pass.
    let n = 60;
    let (row, column): (Vec<i32>, Vec<i32>) = (0..=n).map(|i| ((n + 1) * 30 + i, (n + 1) * i + 30)).unzip();
    let mut input = with_edges(with_edges(sheet(n as usize), "row", &path(&row)), "column", &path(&column));
    for p in &mut input.points {
        p.z = (0.7 * p.x).sin() * (0.9 * p.y).cos();
    }
    let garment = checked(input);
    let options = [
        "seam.s.edges=row,column",
        "seam.s.normalOffset=-0.05",
        "seam.s.width=1.6",
        "seam.s.rows=2",
        "seam.s.rowGap=2.7",
        "fold.t.faces=half",
        "fold.t.thickness=1.5",
        "render.level=1",
    ];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| rendered(&garment, &options))
    };
    let (one, said) = with(1);
    assert!(!said.is_empty());
    // Outside of a pool, the points are made while the rest is.
    for (other, said_by_other) in [with(8), rendered(&garment, &options)] {
        assert_eq!(*one.points, *other.points);
        assert_eq!((&one.faces, &one.primvars, &one.subsets), (&other.faces, &other.primvars, &other.subsets));
        assert_eq!(format!("{said:?}"), format!("{said_by_other:?}"));
    }
}
