//! Subdivision against stored OpenSubdiv levels: its regression shapes and generated meshes under every option.

use crate::connectivity::{CornerId, FaceId, Faces, VertexId};
use crate::garment::{
    BoundaryInterpolation, Corner, Crease, FaceVaryingInterpolation, Mesh, Scheme, SubdivisionRules, TriangleRule,
};
use crate::subdivide::{Channel, ChannelChild, Level, Numbering, Stencils};
use golden::{Boundary, Case, FACE_VARYING_RULES, load};
use std::path::Path;

mod golden;

/// Allowed difference, as a share of the bounding box.
const TOLERANCE: f64 = 1e-6;

fn cases(family: &str) -> Vec<Case> {
    let cases =
        load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden").join(family).with_extension("bin"));
    assert!(!cases.is_empty(), "{family} has cases");
    cases
}

/// Such faces are errors of `check_garment`, so the subdivision need not know them.
fn repeats_a_vertex(case: &Case) -> bool {
    let mut at = 0;
    case.face_vertex_counts.iter().any(|&n| {
        let face = &case.face_vertex_indices[at..at + n];
        at += n;
        (0..n).any(|i| face[..i].contains(&face[i]))
    })
}

fn garment(case: &Case, face_varying: FaceVaryingInterpolation) -> Mesh {
    let v = |i: usize| VertexId::new(i);
    let corners: Vec<VertexId> = case.face_vertex_indices.iter().map(|&i| v(i)).collect();
    Mesh {
        points: case.points.iter().map(|&p| p.into()).collect(),
        faces: Faces::mixed(case.face_vertex_counts.iter().copied(), corners),
        rules: SubdivisionRules {
            scheme: match case.scheme {
                golden::Scheme::Bilinear => Scheme::Bilinear,
                golden::Scheme::CatmullClark => Scheme::CatmullClark,
                golden::Scheme::Loop => Scheme::Loop,
            },
            boundary: match case.boundary {
                Boundary::None => BoundaryInterpolation::None,
                Boundary::EdgeOnly => BoundaryInterpolation::EdgeOnly,
                Boundary::EdgeAndCorner => BoundaryInterpolation::EdgeAndCorner,
            },
            face_varying,
            triangles: if case.smooth_triangles { TriangleRule::Smooth } else { TriangleRule::CatmullClark },
        },
        creases: case
            .creases
            .iter()
            .map(|&(a, b, s)| Crease { vertices: vec![v(a), v(b)], sharpnesses: vec![s] })
            .collect(),
        corners: case.corners.iter().map(|&(i, sharpness)| Corner { vertex: v(i), sharpness }).collect(),
        holes: case.holes.iter().map(|&f| FaceId::new(f)).collect(),
        ..Mesh::default()
    }
}

const RULES: [FaceVaryingInterpolation; 6] = [
    FaceVaryingInterpolation::None,
    FaceVaryingInterpolation::CornersOnly,
    FaceVaryingInterpolation::CornersPlus1,
    FaceVaryingInterpolation::CornersPlus2,
    FaceVaryingInterpolation::Boundaries,
    FaceVaryingInterpolation::All,
];

/// The largest difference of any value of a case from OpenSubdiv's, as a share of the bounding box, and where.
fn compare(case: &Case, rule: usize) -> (f64, String) {
    let garment = garment(case, RULES[rule]);
    let slot = case.slot_of_rule[rule];
    assert!(slot < case.slots);
    let (low, high) = garment.points.iter().fold((glam::Vec3::MAX, glam::Vec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let size = f64::from((high - low).max_element());
    let mut worst = (0.0, String::new());
    let mut note = |difference: f64, what: &dyn Fn() -> String| {
        if difference > worst.0 {
            worst = (difference, what());
        }
    };

    let mut parent = Level::base(&garment);
    let rules = garment.rules;
    let (mut channel, rows) =
        Channel::base(&parent, |c| case.uv_indices[c.index()], rules.face_varying, rules.boundary);
    let mut points: Vec<[f32; 3]> = case.points.clone();
    let mut varying = case.varying.clone();
    let mut uvs: Vec<[f32; 2]> = rows.iter().map(|&r| case.uvs[r as usize]).collect();
    let holes = match case.boundary {
        Boundary::None if garment.rules.scheme != Scheme::Bilinear => parent.border_holes(&garment),
        _ => Vec::new(),
    };
    let mut base_face: Vec<FaceId> = garment.faces.ids().collect();

    for (depth, level) in case.levels.iter().enumerate() {
        let child = parent.refined();
        points = parent.vertex_stencils().apply(&points);
        varying = parent.varying_stencils().apply(&varying);
        let refined_uvs = ChannelChild::new(&parent, &channel);
        uvs = refined_uvs.apply(&uvs);
        let faces = child.topology.faces.clone();
        let numbering = Numbering::new(&parent);
        base_face = faces.ids().map(|f| base_face[numbering.parent_face(&parent.topology.faces, f).index()]).collect();
        let corner_values = refined_uvs.corner_values();
        channel = refined_uvs.into_channel(&child);
        parent = child;

        let counts = [points.len(), parent.topology.edges.len(), faces.len(), faces.corners().len()];
        assert_eq!(
            counts,
            [level.vertices, level.edges, level.faces, level.face_vertices],
            "counts of level {}",
            depth + 1
        );
        let value = |c: CornerId| uvs[corner_values[c].index()];
        let mut sum = [0.0f64; 7];
        for c in faces.corners().ids() {
            let vertex = faces.vertex(c).index();
            let own = points[vertex].iter().chain(&varying[vertex]).copied().chain(value(c));
            sum.iter_mut().zip(own).for_each(|(s, v)| *s += f64::from(v));
        }
        let sharpness: f64 = parent.topology.corner_edge.iter().map(|&e| f64::from(parent.edge_sharpness[e])).sum();
        note((sharpness - level.sharpness_sum).abs() / faces.corners().len() as f64, &|| {
            format!("sharpness of level {}", depth + 1)
        });
        let expected = level.point_sum.iter().chain(&level.varying_sum).chain(&level.uv_sums[slot]);
        for (k, (a, b)) in sum.iter().zip(expected).enumerate() {
            note((a - b).abs() / faces.corners().len() as f64 / size, &|| format!("mean {k} of level {}", depth + 1));
        }
        for face in &level.samples {
            let id = FaceId::new(face.index);
            assert_eq!(base_face[face.index].index(), face.base_face);
            let hole = case.holes.contains(&face.base_face) || holes.contains(&base_face[face.index]);
            assert_eq!(hole, face.hole, "hole of face {} of level {}", face.index, depth + 1);
            for (k, (corner, c)) in face.corners.iter().zip(faces.corners_of(id)).enumerate() {
                let at = || format!("level {} face {} corner {k}", depth + 1, face.index);
                let vertex = faces.vertex(c);
                if garment.rules.scheme != Scheme::Loop {
                    assert_eq!(vertex.index(), corner.vertex, "{}", at());
                }
                let pairs = |a: &[f32], b: &[f32]| {
                    a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max) / size
                };
                note(pairs(&points[vertex.index()], &corner.point), &|| format!("{} point", at()));
                note(pairs(&varying[vertex.index()], &corner.varying), &|| format!("{} varying", at()));
                note(pairs(&value(c), &corner.uvs[slot]), &|| format!("{} face-varying", at()));
                let edge = parent.topology.corner_edge[c];
                note(pairs(&[parent.edge_sharpness[edge]], &[corner.edge_sharpness]), &|| {
                    format!("{} edge sharpness", at())
                });
                note(pairs(&[parent.vertex_sharpness[vertex]], &[corner.vertex_sharpness]), &|| {
                    format!("{} vertex sharpness", at())
                });
            }
        }
    }
    worst
}

fn check_family(family: &str) {
    let mut failures = Vec::new();
    for case in cases(family).iter().filter(|c| !repeats_a_vertex(c)) {
        for (rule, name) in FACE_VARYING_RULES.iter().enumerate() {
            let (difference, at) = compare(case, rule);
            if difference > TOLERANCE {
                let options = format!("{:?}, smooth triangles {}, {name}", case.boundary, case.smooth_triangles);
                failures.push(format!("{} ({options}): {difference:.2e} at {at}", case.name));
            }
        }
    }
    assert!(failures.is_empty(), "{} of {family} differ:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn catmull_clark_agrees_with_opensubdiv() {
    check_family("catmark");
}

#[test]
fn loop_agrees_with_opensubdiv() {
    check_family("loop");
}

#[test]
fn bilinear_agrees_with_opensubdiv() {
    check_family("bilinear");
}

#[test]
fn generated_meshes_agree_with_opensubdiv() {
    check_family("generated");
}

#[test]
fn non_manifold_meshes_agree_with_opensubdiv() {
    check_family("nonmanifold");
}
