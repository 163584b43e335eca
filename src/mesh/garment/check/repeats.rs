//! Faces that name a point more than once, which OpenUSD admits and geometry code does not know.

use super::mesh::{MeshCheck, corner_sum};
use super::primvars::primvars;
use super::problem::Problems;
use crate::codes;
use crate::connectivity::{Elements, FaceId};
use crate::error::Warning;
use crate::garment::{FaceNumbers, Garment, Interpolation, PrimvarInput};
use std::collections::HashMap;

/// Takes the repeats out of faces that name a point more than once. Corners that follow each other become one, with the values
/// of the first. A face that meets itself at a point becomes several faces: the first stays in its place, others are added at
/// the end. Faces of fewer than three points are left out. Primvars, holes and face sets follow.
///
/// Faces around a hole, whose outer and inner border are joined by an edge, stay: [`check_garment`](super::check_garment)
/// refuses them. So does a mesh whose indices have other faults.
pub fn split_repeats(mesh: &mut Garment) -> Option<Warning> {
    let found = Split::of(mesh)?;
    // Values that do not fit the mesh could fit it afterwards, by chance.
    let mut problems = Problems::default();
    let fits = MeshCheck::new(mesh, None);
    let (_, left_out) = primvars(mesh.primvars.clone(), &fits, &mesh.prim, &mut problems);
    if !problems.is_empty() {
        return None;
    }
    mesh.primvars.retain(|primvar| left_out.iter().all(|fault| fault.name != primvar.name));
    mesh.left_out.extend(left_out);
    found.apply(mesh);
    Some(found.warning(&mesh.prim))
}

/// A face after the split: its number before, and the corners before that it keeps.
struct NewFace {
    face: usize,
    corners: Vec<usize>,
}

/// The faces of a mesh without repeats.
#[derive(Default)]
struct Split {
    faces: Vec<NewFace>,
    /// Faces with repeats.
    repeated: Vec<FaceId>,
    /// Faces with repeats that became several.
    split: Vec<FaceId>,
    /// Faces with repeats that are left out.
    left_out: Vec<FaceId>,
}

impl Split {
    /// None where there are no repeats, and where the indices have faults.
    fn of(mesh: &Garment) -> Option<Self> {
        let (counts, points) = (&mesh.face_vertex_counts, &mesh.face_vertex_indices);
        let is_in = |count: usize| move |&index: &i32| usize::try_from(index).is_ok_and(|index| index < count);
        let of_faces = mesh.subsets.iter().filter(|set| set.element_type == "face").flat_map(|set| &set.indices);
        let mut faces = of_faces.chain(&mesh.hole_indices);
        if corner_sum(counts) != Some(points.len()) || !points.iter().all(is_in(mesh.points.len())) {
            return None;
        }
        if counts.iter().any(|&count| count < 3) || !faces.all(is_in(counts.len())) {
            return None;
        }
        let repeated = repeated_faces(mesh);
        if !repeated.contains(&true) {
            return None;
        }
        let (mut found, mut added, mut first) = (Self::default(), Vec::new(), 0);
        for ((face, &count), is_repeated) in counts.iter().enumerate().zip(repeated) {
            let corners = first..first + count as usize;
            first = corners.end;
            let cycles = if is_repeated { cycles(corners.clone(), points) } else { None };
            let Some(cycles) = cycles else {
                found.faces.push(NewFace { face, corners: corners.collect() });
                continue;
            };
            found.note(FaceId::new(face), cycles.len());
            let mut parts = cycles.into_iter().map(|corners| NewFace { face, corners });
            found.faces.extend(parts.next());
            added.extend(parts);
        }
        found.faces.extend(added);
        (!found.repeated.is_empty()).then_some(found)
    }

    /// Notes that a face with repeats became so many.
    fn note(&mut self, face: FaceId, parts: usize) {
        self.repeated.push(face);
        match parts {
            0 => self.left_out.push(face),
            1 => {}
            _ => self.split.push(face),
        }
    }

    fn apply(&self, mesh: &mut Garment) {
        let before = mesh.face_vertex_counts.len();
        let corners = || self.faces.iter().flat_map(|face| face.corners.iter().copied());
        mesh.face_vertex_counts = self.faces.iter().map(|face| face.corners.len() as i32).collect();
        mesh.face_vertex_indices = corners().map(|corner| mesh.face_vertex_indices[corner]).collect();
        let mut parts = vec![Vec::new(); before];
        self.faces.iter().enumerate().for_each(|(new, face)| parts[face.face].push(new as i32));
        let follow = |faces: &mut Vec<i32>| {
            *faces = faces.iter().flat_map(|&face| parts[face as usize].iter().copied()).collect();
        };
        follow(&mut mesh.hole_indices);
        mesh.subsets.iter_mut().filter(|set| set.element_type == "face").for_each(|set| follow(&mut set.indices));
        for primvar in &mut mesh.primvars {
            match primvar.interpolation {
                Interpolation::FaceVarying => gather(primvar, corners()),
                Interpolation::Uniform => gather(primvar, self.faces.iter().map(|face| face.face)),
                _ => {}
            }
        }
        mesh.face_numbers = FaceNumbers::new(self.faces.iter().map(|face| FaceId::new(face.face)).collect());
    }

    fn warning(self, prim: &str) -> Warning {
        let mut problem =
            "faces name a point more than once: each keeps one corner of those that follow each other".to_owned();
        for (faces, what) in [
            (self.split, "split where they meet themselves"),
            (self.left_out, "left out, with fewer than three points"),
        ] {
            if !faces.is_empty() {
                problem += &format!("; {what}: {}", Elements::Faces(faces).in_words(usize::MAX));
            }
        }
        let remedy = "Remove the repeated corners in the modelling program, if the faces are to have other corners";
        Warning::new(codes::REPEATED_POINTS, prim, problem).at(Elements::Faces(self.repeated)).remedy(remedy)
    }
}

/// True for each face that names a point more than once.
fn repeated_faces(mesh: &Garment) -> Vec<bool> {
    // The last face at each point, plus one.
    let (mut last, mut first) = (vec![0; mesh.points.len()], 0);
    let is_repeated = |(face, &count): (usize, &i32)| {
        let corners = &mesh.face_vertex_indices[first..first + count as usize];
        first += corners.len();
        let is_repeat = |&&point: &&i32| std::mem::replace(&mut last[point as usize], face + 1) > face;
        corners.iter().filter(is_repeat).count() > 0
    };
    mesh.face_vertex_counts.iter().enumerate().map(is_repeated).collect()
}

/// The parts of a face between its repeats, each with three corners or more; none where it goes around a hole.
fn cycles(corners: impl Iterator<Item = usize>, points: &[i32]) -> Option<Vec<Vec<usize>>> {
    let (mut found, mut bridges) = (Vec::new(), 0);
    // The corners since the last repeat, and the place of each point among them.
    let (mut open, mut places) = (Vec::<usize>::new(), HashMap::new());
    let mut close = |part: Vec<usize>| {
        bridges += usize::from(part.len() == 2);
        if part.len() > 2 {
            found.push(part);
        }
    };
    for corner in corners {
        let Some(&at) = places.get(&points[corner]) else {
            places.insert(points[corner], open.len());
            open.push(corner);
            continue;
        };
        let part = open.split_off(at);
        for &corner in &part[1..] {
            places.remove(&points[corner]);
        }
        // The first corner stands for its point in what follows, unless the part needs it.
        open.push(if part.len() > 2 { corner } else { part[0] });
        close(part);
    }
    close(open);
    let is_around_hole = bridges > 0 && found.len() > 1;
    (!is_around_hole).then_some(found)
}

/// The rows of a primvar for new elements, by those before.
fn gather(primvar: &mut PrimvarInput, elements: impl Iterator<Item = usize> + Clone) {
    match &mut primvar.indices {
        Some(indices) => *indices = elements.map(|element| indices[element]).collect(),
        None => {
            let width = primvar.components * usize::try_from(primvar.element_size).unwrap_or(1);
            primvar.values = primvar.values.gather(width, elements);
        }
    }
}
