//! Operators on garments: every face a quad, none without area, few turned over, and few crossings
//! that the garment itself does not have.

#![allow(clippy::print_stdout)]

use super::cloth::faces_in;
use super::crossings::crossing_parents;
use crate::operators::{border_panels, rendered};
use glam::Vec3;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use tailor::codes;
use tailor::pipeline::mean_edge_length;
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::garment::{Interpolation, Meaning, Mesh, Primvar, PrimvarRole, Values, check_garment};
use tailor_testing::garments::{garments, named};
use tailor_usd::{ReadOptions, Source};

/// Name of the primvar that says which face of the input each face is part of.
const PARENT: &str = "parentFace";
/// Name of the primvar that says where the front of the input is.
const FRONT: &str = "front";

/// Sizes of operators as multiples of those of [`STACKS`].
const MULTIPLES: [f32; 3] = [0.7, 1.0, 1.3];

/// Pairs of faces of the garment whose children cross on the render mesh, for seams, hems and both at each of
/// [`MULTIPLES`]. A garment that is not here has none. The aim is none; a number here may only be lowered.
const CROSSING: &[(&str, [[usize; 3]; 3])] =
    &[("coat.usda", [[0, 0, 1], [0, 0, 1], [0, 0, 3]]), ("male_worksuit01.usdc", [[0, 0, 0], [2, 0, 2], [3, 0, 3]])];

/// Faces that look to the other side than the garment there, for seams, hems and both. As above.
const TURNED: &[(&str, [usize; 3])] = &[("coat.usda", [4, 2, 25]), ("male_worksuit01.usdc", [0, 0, 16])];

/// Every garment with the name of its file.
pub fn load() -> Vec<(String, Mesh)> {
    let name = |file: &Path| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    garments().into_iter().map(|file| (name(&file), open(&file))).collect()
}

/// A garment of the project, by the name of its file.
pub fn load_named(name: &str) -> Mesh {
    open(&named(name))
}

/// A garment with what says where its faces are from.
fn open(file: &Path) -> Mesh {
    let name = file.display();
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (input, _) = source.garment().unwrap_or_else(|e| panic!("{name}: {e}"));
    let (mut garment, _) = check_garment(input).unwrap_or_else(|e| panic!("{name}: {e}"));
    Arc::make_mut(&mut garment.primvars).push(Primvar {
        name: PARENT.into(),
        role: PrimvarRole::Primvar,
        meaning: Meaning::Plain,
        half: false,
        interpolation: Interpolation::Uniform,
        components: 1,
        element_size: 1,
        values: Values::I32((0..garment.faces.len() as i32).collect()),
        indices: None,
    });
    let fronts = vertex_normals(&garment).iter().flat_map(|n| n.to_array()).collect();
    Arc::make_mut(&mut garment.primvars).push(Primvar {
        name: FRONT.into(),
        role: PrimvarRole::Primvar,
        meaning: Meaning::Plain,
        half: false,
        interpolation: Interpolation::Vertex,
        components: 3,
        element_size: 1,
        values: Values::F32(fronts),
        indices: None,
    });
    garment
}

/// Normals of the garment's vertices, each the mean of those of the faces around it.
fn vertex_normals(garment: &Mesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; garment.points.len()];
    for face in garment.faces.ids() {
        let corners = garment.faces.vertices_of(face);
        let at = |v: VertexId| garment.points[v] - garment.points[corners[0]];
        let area: Vec3 = corners.windows(2).map(|pair| at(pair[0]).cross(at(pair[1]))).sum();
        corners.iter().for_each(|v| normals[v.index()] += area.normalize_or_zero());
    }
    normals.iter().map(|n| n.normalize_or_zero()).collect()
}

/// The edges at which the UVs are cut.
pub fn uv_seams(garment: &Mesh) -> String {
    if garment.subset("uvSeams").is_some() {
        return "uvSeams".into();
    }
    let seams = ["side_seams", "shoulder_seams", "armholes", "inseam", "placket", "neck_seam", "sleeve_seams"];
    seams.into_iter().filter(|s| garment.subset(s).is_some()).collect::<Vec<_>>().join(",")
}

/// The face of the input that each face is part of.
pub fn parents(mesh: &Mesh) -> Vec<usize> {
    match mesh.primvar(PARENT).map(|p| (&p.values, &p.indices)) {
        Some((Values::I32(values), None)) => values.iter().map(|&v| v as usize).collect(),
        _ => panic!("parents are carried"),
    }
}

fn area(mesh: &Mesh, face: FaceId) -> Vec3 {
    let p: Vec<Vec3> = mesh.faces.vertices_of(face).iter().map(|&v| mesh.points[v]).collect();
    0.5 * (p[2] - p[0]).cross(p[3] - p[1])
}

/// How much each face looks to the front of the input at its place: the cosine between the two.
fn facing(mesh: &Mesh) -> Vec<f32> {
    let Some(Values::F32(front)) = mesh.primvar(FRONT).map(|p| &p.values) else { panic!("fronts are carried") };
    let at = |v: &VertexId| Vec3::from_slice(&front[3 * v.index()..]);
    let of = |f| {
        let there: Vec3 = mesh.faces.vertices_of(f).iter().map(at).sum();
        area(mesh, f).normalize_or_zero().dot(there.normalize_or_zero())
    };
    mesh.faces.ids().map(of).collect()
}

/// Sizes as shares of the mean edge.
fn recipe(garment: &Mesh, level: u32, seam: Option<f32>, hem: Option<f32>) -> Vec<String> {
    let size = mean_edge_length(garment);
    let mut options = vec![format!("render.level={level}"), "render.faceSets=true".to_owned()];
    if let Some(width) = seam {
        options.push(format!("seam.s.edges={}", uv_seams(garment)));
        options.push(format!("seam.s.width={}", width * size));
        options.push(format!("seam.s.normalOffset={}", -0.15 * width * size));
    }
    if let Some(amount) = hem {
        options.push(format!("fold.t.faces={}", border_panels(garment)));
        options.push(format!("fold.t.thickness={}", amount * size));
    }
    options
}

#[test]
fn operators_make_sound_quads() {
    let mut complaints: Vec<String> = Vec::new();
    for (name, garment) in load() {
        let plain = rendered(&garment, &["render.level=2".to_owned()]).0;
        let folded = already_turned(&plain);
        let sizes = [(Some(0.25), None), (None, Some(0.08)), (Some(0.25), Some(0.08))];
        for (number, (seam, hem)) in sizes.into_iter().enumerate() {
            let mesh = rendered(&garment, &recipe(&garment, 2, seam, hem)).0;
            let (inner, hems) = (faces_in(&mesh, "t_inner"), faces_in(&mesh, "t_hem"));
            let (mut turned, mut flat) = (Vec::new(), Vec::new());
            for ((face, parent), facing) in mesh.faces.ids().zip(parents(&mesh)).zip(facing(&mesh)) {
                assert_eq!(mesh.faces.valence(face), 4, "{name}");
                let vector = area(&mesh, face);
                let corners = mesh.faces.vertices_of(face);
                let longest =
                    (0..4).map(|i| mesh.points[corners[i]].distance_squared(mesh.points[corners[(i + 1) % 4]]));
                if vector.length() < 1e-4 * longest.fold(0.0, f32::max) {
                    flat.push(face);
                }
                let sign = if inner.contains(&face) { -1.0 } else { 1.0 };
                if !hems.contains(&face) && sign * facing < -0.2 {
                    turned.push((face, parent));
                }
            }
            turned.retain(|(_, parent)| !folded.contains(parent));
            let known = TURNED.iter().find(|(file, _)| *file == name).map_or([0; 3], |(_, n)| *n);
            if turned.len() > known[number] || !flat.is_empty() {
                let (n, m) = (turned.len(), flat.len());
                complaints.push(format!(
                    "{name}, {seam:?}, {hem:?}: {n} turned {:?}, {m} flat {flat:?}",
                    &turned[..n.min(9)]
                ));
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Faces of the input whose own children do not all look to its front.
fn already_turned(plain: &Mesh) -> BTreeSet<usize> {
    parents(plain)
        .into_iter()
        .zip(facing(plain))
        .filter(|(_, facing)| *facing < 0.3)
        .map(|(parent, _)| parent)
        .collect()
}

/// Seams alone, hems alone, and both.
const STACKS: [(Option<f32>, Option<f32>); 3] = [(Some(0.25), None), (None, Some(0.05)), (Some(0.25), Some(0.05))];

/// Pairs of faces of the garment whose children cross by operators.
type Pairs = Vec<[usize; 2]>;

/// The crossings of a stack.
struct Crossings {
    new: Pairs,
    /// Whether a warning tells of them.
    are_told: bool,
}

/// The crossings of each stack on a refinement, at a multiple of its sizes.
fn crossings(garment: &Mesh, level: u32, multiple: f32) -> [Crossings; 3] {
    let plain = rendered(garment, &[format!("render.level={level}")]).0;
    let before = crossing_parents(&plain, &parents(&plain));
    STACKS.map(|(seam, hem)| {
        let sized = |share: Option<f32>| share.map(|share| multiple * share);
        let (mesh, warnings) = rendered(garment, &recipe(garment, level, sized(seam), sized(hem)));
        let after = crossing_parents(&mesh, &parents(&mesh));
        let new: Pairs = after.difference(&before).copied().collect();
        Crossings { new, are_told: warnings.iter().any(|w| w.code == codes::INTERSECTIONS) }
    })
}

/// New crossings on a refinement, at a multiple of the sizes, that no warning tells or that are more than known.
fn complaints(level: u32, multiple: f32, known: impl Fn(&str) -> [usize; 3]) -> String {
    let mut complaints: Vec<String> = Vec::new();
    println!("{:28} level sizes  seams   hems   both", "new crossings");
    for (name, garment) in load() {
        let all = crossings(&garment, level, multiple);
        let counts: Vec<String> = all.iter().map(|found| format!("{:7}", found.new.len())).collect();
        println!("{name:28} {level:5} {multiple:5} {}", counts.concat());
        let all = all.into_iter().zip(STACKS).zip(known(&name));
        for ((found, stack), known) in all.filter(|((found, _), _)| !found.new.is_empty()) {
            let Crossings { new, are_told } = &found;
            if new.len() > known || !are_told {
                let (count, some) = (new.len(), &new[..new.len().min(12)]);
                complaints.push(format!("{name}, {stack:?} times {multiple}: {count} new {some:?}, told: {are_told}"));
            }
        }
    }
    complaints.join("\n")
}

#[test]
fn few_crossings_are_introduced_and_all_are_told() {
    let of = |(number, multiple): (usize, f32)| {
        let known = |name: &str| CROSSING.iter().find(|(file, _)| *file == name).map_or([0; 3], |(_, n)| n[number]);
        complaints(2, multiple, known)
    };
    let complaints: Vec<String> = MULTIPLES.into_iter().enumerate().map(of).collect();
    assert!(complaints.iter().all(String::is_empty), "{}", complaints.join("\n"));
}

#[test]
fn crossings_are_told_at_other_sizes() {
    for (level, multiple) in [(1, 1.0), (2, 0.5), (2, 1.5)] {
        let complaints = complaints(level, multiple, |_| [usize::MAX; 3]);
        assert!(complaints.is_empty(), "level {level}: {complaints}");
    }
}
