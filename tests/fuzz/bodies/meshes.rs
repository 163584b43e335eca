//! Meshes of up to 500 faces: a sound shape, and then some of all that can be wrong with one.

use super::choices::Choices;
use tailor_mesh::glam::Vec3;
use tailor_mesh::{
    BoundaryInterpolation, FaceVaryingInterpolation, Family, FamilyType, Garment, Orientation, PrimvarInput, Scheme,
    SubsetInput, TriangleRule,
};

/// Faces along a side of the largest sheet.
const MOST_ALONG: usize = 22;

/// Numbers that break what is not written with care.
const ODD: [f32; 16] = [
    0.0,
    -0.0,
    -1.0,
    1e-30,
    1e-6,
    0.5,
    10.0,
    1e3,
    1e5,
    1e7,
    1e12,
    1e30,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// A mesh as authored.
pub fn mesh(choices: &mut Choices) -> Garment {
    let mut mesh = Garment { prim: "/Coat/model".into(), ..Garment::default() };
    match choices.below(5) {
        0 => soup(&mut mesh, choices),
        1 => loose(&mut mesh, choices),
        wrap => sheet(&mut mesh, choices, wrap == 2),
    }
    rules(&mut mesh, choices);
    primvars(&mut mesh, choices);
    subsets(&mut mesh, choices);
    sharpness(&mut mesh, choices);
    for _ in 0..choices.below(6) {
        damage(&mut mesh, choices);
    }
    mesh
}

/// Another shape of a mesh, with a fault now and then.
pub fn moved(mesh: &Garment, choices: &mut Choices) -> Garment {
    let mut mesh = mesh.clone();
    let [scale, shift] = [1.0, 0.2].map(|size| Vec3::from_array([0; 3].map(|_| size * choices.signed())));
    mesh.points.iter_mut().for_each(|p| *p = *p * (Vec3::ONE + 0.3 * scale) + shift);
    if choices.once_in(4) {
        damage(&mut mesh, choices);
    }
    mesh
}

/// A sheet of quads, bent by chance; a tube if it is `wrapped`.
fn sheet(mesh: &mut Garment, choices: &mut Choices, wrapped: bool) {
    let (across, along) = (1 + choices.below(MOST_ALONG), 1 + choices.below(MOST_ALONG));
    let bend = choices.signed();
    for i in 0..(across + 1) * (along + 1) {
        let (x, y) = ((i % (across + 1)) as f32, (i / (across + 1)) as f32);
        let angle = x / across as f32 * std::f32::consts::TAU;
        mesh.points.push(if wrapped {
            Vec3::new(angle.cos(), angle.sin(), y)
        } else {
            Vec3::new(x, y, bend * (x - y).sin())
        });
    }
    // A wrapped sheet has its last column in the first.
    let point = |x: usize, y: usize| (y * (across + 1) + if wrapped { x % across } else { x }) as i32;
    for y in 0..along {
        for x in 0..across {
            face(mesh, &[point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)]);
        }
    }
}

/// Faces of any corners.
fn soup(mesh: &mut Garment, choices: &mut Choices) {
    let points = 3 + choices.below(40);
    mesh.points = (0..points).map(|_| Vec3::from_array([0; 3].map(|_| 4.0 * choices.signed()))).collect();
    for _ in 0..1 + choices.below(100) {
        let corners: Vec<i32> = (0..3 + choices.below(4)).map(|_| choices.below(points) as i32).collect();
        face(mesh, &corners);
    }
}

/// Quads without neighbours.
fn loose(mesh: &mut Garment, choices: &mut Choices) {
    for _ in 0..1 + choices.below(300) {
        let first = mesh.points.len() as i32;
        let at = Vec3::new(8.0 * choices.signed(), 8.0 * choices.signed(), choices.signed());
        mesh.points.extend([Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y].map(|corner| at + corner));
        face(mesh, &[first, first + 1, first + 2, first + 3]);
    }
}

fn face(mesh: &mut Garment, corners: &[i32]) {
    mesh.face_vertex_counts.push(corners.len() as i32);
    mesh.face_vertex_indices.extend(corners);
}

fn rules(mesh: &mut Garment, choices: &mut Choices) {
    let rules = &mut mesh.rules;
    rules.scheme =
        choices.one_of(&[Scheme::CatmullClark, Scheme::CatmullClark, Scheme::Loop, Scheme::Bilinear, Scheme::None]);
    rules.boundary = choices.one_of(&[
        BoundaryInterpolation::EdgeAndCorner,
        BoundaryInterpolation::EdgeOnly,
        BoundaryInterpolation::None,
    ]);
    rules.face_varying = choices.one_of(&[
        FaceVaryingInterpolation::CornersPlus1,
        FaceVaryingInterpolation::None,
        FaceVaryingInterpolation::CornersOnly,
        FaceVaryingInterpolation::CornersPlus2,
        FaceVaryingInterpolation::Boundaries,
        FaceVaryingInterpolation::All,
    ]);
    rules.triangles = choices.one_of(&[TriangleRule::CatmullClark, TriangleRule::Smooth]);
    mesh.orientation = choices.one_of(&[Orientation::RightHanded, Orientation::LeftHanded]);
    if rules.scheme == Scheme::Loop {
        in_triangles(mesh);
    }
}

/// Replaces faces by fans of triangles.
fn in_triangles(mesh: &mut Garment) {
    let (counts, corners) =
        (std::mem::take(&mut mesh.face_vertex_counts), std::mem::take(&mut mesh.face_vertex_indices));
    let mut start = 0;
    for count in counts {
        let of_face = &corners[start..start + count as usize];
        for i in 1..of_face.len() - 1 {
            face(mesh, &[of_face[0], of_face[i], of_face[i + 1]]);
        }
        start += of_face.len();
    }
}

/// UVs that follow the points, with cuts between faces and odd values; and painted weights.
fn primvars(mesh: &mut Garment, choices: &mut Choices) {
    let uvs: Vec<[f32; 2]> = mesh.points.iter().map(|p| [p.x / 8.0, (p.y + p.z) / 8.0]).collect();
    if !choices.once_in(4) {
        let (mut uvs, mut indices) = (uvs, mesh.face_vertex_indices.clone());
        for _ in 0..choices.below(5) {
            match choices.below(3) {
                0 => {
                    let (at, odd) = (choices.below(uvs.len()), choices.one_of(&ODD));
                    uvs[at][choices.below(2)] = odd;
                }
                // All corners from here on are cut off.
                1 => {
                    let (from, first) = (choices.below(indices.len()), uvs.len() as i32);
                    uvs.extend(uvs.clone().iter().map(|[u, v]| [u + 2.0, *v]));
                    indices[from..].iter_mut().for_each(|i| *i += first);
                }
                // A face each for itself.
                _ => {
                    uvs = indices
                        .iter()
                        .enumerate()
                        .map(|(i, &at)| [uvs[at as usize][0] + (i / 4) as f32, uvs[at as usize][1]])
                        .collect();
                    indices = (0..indices.len() as i32).collect();
                }
            }
            if uvs.len() > 10_000 {
                break;
            }
        }
        mesh.primvars.push(PrimvarInput::uvs("st", &uvs, indices));
    }
    if choices.once_in(2) {
        let weights = mesh.points.iter().map(|_| 0.5 + 0.5 * choices.signed()).collect();
        mesh.primvars.push(PrimvarInput::weights("paint", weights));
    }
}

/// The sets `faces`, `edges` and `points`, of any elements in a row.
fn subsets(mesh: &mut Garment, choices: &mut Choices) {
    let (faces, corners) = (mesh.face_vertex_counts.len(), mesh.face_vertex_indices.len());
    for kind in ["face", "edge", "point"] {
        let (from, count) = (choices.below(corners), 1 + choices.below(60));
        let indices = match kind {
            "face" => (from % faces..faces).take(count).map(|f| f as i32).collect(),
            "point" => (from % mesh.points.len()..mesh.points.len()).take(count).map(|p| p as i32).collect(),
            _ => mesh.face_vertex_indices[from..]
                .windows(2)
                .take(count)
                .step_by(1 + choices.below(5))
                .flatten()
                .copied()
                .collect(),
        };
        let family = if choices.once_in(3) { "cut".to_owned() } else { String::new() };
        mesh.subsets.push(SubsetInput { name: format!("{kind}s"), element_type: kind.into(), family, indices });
    }
    let kind = choices.one_of(&[FamilyType::Unrestricted, FamilyType::NonOverlapping, FamilyType::Partition]);
    mesh.families.push(Family { name: "cut".into(), kind });
}

/// Creases along edges of faces, corners and holes.
fn sharpness(mesh: &mut Garment, choices: &mut Choices) {
    let corners = mesh.face_vertex_indices.clone();
    for _ in 0..choices.below(4) {
        let at = choices.below(corners.len() - 1);
        mesh.crease_indices.extend([corners[at], corners[at + 1]]);
        mesh.crease_lengths.push(2);
        mesh.crease_sharpnesses.push(choices.one_of(&[10.0, 2.5, 1.0, 0.3, -1.0, f32::NAN]));
    }
    for _ in 0..choices.below(3) {
        mesh.corner_indices.push(corners[choices.below(corners.len())]);
        mesh.corner_sharpnesses.push(choices.one_of(&[10.0, 3.0, 0.2]));
    }
    for _ in 0..choices.below(3) {
        mesh.hole_indices.push(choices.below(mesh.face_vertex_counts.len()) as i32);
    }
}

/// One thing that goes wrong in a file.
fn damage(mesh: &mut Garment, choices: &mut Choices) {
    let (points, corners) = (mesh.points.len(), mesh.face_vertex_indices.len());
    let odd = choices.one_of(&ODD);
    match choices.below(9) {
        0 => mesh.points[choices.below(points)][choices.below(3)] = odd,
        1 => mesh.points.iter_mut().for_each(|p| *p *= odd),
        2 => mesh.points.iter_mut().for_each(|p| *p += odd),
        3 => mesh.points.iter_mut().for_each(|p| p[0] = odd),
        4 => mesh.points[choices.below(points)] = mesh.points[choices.below(points)],
        5 => mesh.face_vertex_indices[choices.below(corners)] = choices.below(points) as i32,
        6 => {
            mesh.face_vertex_indices[choices.below(corners)] = choices.one_of(&[-1, points as i32, i32::MAX, i32::MIN]);
        }
        7 => mesh.points.push(Vec3::splat(odd)),
        _ => mesh.units.meters_per_unit = f64::from(odd),
    }
}
