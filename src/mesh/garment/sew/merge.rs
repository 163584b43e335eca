//! Panels as one mesh.

use super::primvars::merge_primvars;
use super::subsets::{merge_families, merge_subsets};
use crate::codes;
use crate::connectivity::Groups;
use crate::error::{Error, ErrorKind, Warnings};
use crate::garment::{
    Garment, Interpolation, Meaning, Orientation, PrimvarInput, SubsetInput, Units, Values, free_name,
};
use glam::{DMat3, DMat4, DVec3, Vec3};
use std::collections::BTreeMap;

/// A mesh that becomes part of one garment.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Name of the face set that it becomes, if that is free.
    pub name: String,
    /// The mesh, in the space of the garment.
    pub mesh: Garment,
}

/// Panels as one mesh.
#[derive(Clone, Debug)]
pub struct Sewn {
    /// The mesh.
    pub mesh: Garment,
    /// The face set of each panel.
    pub panels: Vec<String>,
    /// The point of the mesh behind each point of each panel.
    pub points: Vec<Vec<usize>>,
    /// The edge set of the seams between them.
    pub seams: String,
    /// Values of the panels that the mesh does not carry.
    pub warnings: Warnings,
}

/// The points of the panels and those of the garment.
pub struct Points {
    /// The point of the garment, for each point of each panel.
    pub of_panel: Vec<Vec<usize>>,
    /// The points of panels at each point of the garment.
    pub sources: Vec<Vec<(usize, usize)>>,
}

/// Takes a mesh to another space: its points, and what is a direction or a position among its primvars. A mirror changes the
/// winding of its faces.
pub fn place(mesh: &mut Garment, to_space: &DMat4) {
    if *to_space == DMat4::IDENTITY {
        return;
    }
    let linear = DMat3::from_mat4(*to_space);
    let normals = linear.inverse().transpose();
    mesh.points.iter_mut().for_each(|p| *p = to_space.transform_point3(p.as_dvec3()).as_vec3());
    for primvar in mesh.primvars.iter_mut().filter(|p| p.components == 3) {
        match primvar.meaning {
            Meaning::Normal => each_vector(&mut primvar.values, |v| (normals * v).normalize_or_zero()),
            Meaning::Vector => each_vector(&mut primvar.values, |v| linear * v),
            Meaning::Point => each_vector(&mut primvar.values, |v| to_space.transform_point3(v)),
            _ => {}
        }
    }
    if linear.determinant() < 0.0 {
        mesh.orientation = match mesh.orientation {
            Orientation::RightHanded => Orientation::LeftHanded,
            Orientation::LeftHanded => Orientation::RightHanded,
        };
    }
}

fn each_vector(values: &mut Values, change: impl Fn(DVec3) -> DVec3) {
    match values {
        Values::F32(v) => v.as_chunks_mut::<3>().0.iter_mut().for_each(|v| {
            *v = change(Vec3::from_array(*v).as_dvec3()).as_vec3().to_array();
        }),
        Values::F64(v) => v.as_chunks_mut::<3>().0.iter_mut().for_each(|v| *v = change((*v).into()).to_array()),
        _ => {}
    }
}

/// Joins checked panels to one mesh that messages call `prim`. `welds` are pairs of points, each as panel and point. Primvars that
/// panels do not share become warnings.
///
/// # Errors
/// Panels whose subdivision rules, UV scales or sets of one name differ, and welds that would close up a face.
pub fn merge(prim: String, units: Units, mut panels: Vec<Panel>, welds: &[[(usize, usize); 2]]) -> Result<Sewn, Error> {
    check_rules(&panels)?;
    let orientation = panels[0].mesh.orientation;
    panels.iter_mut().filter(|panel| panel.mesh.orientation != orientation).for_each(|panel| turn(&mut panel.mesh));
    let points = weld(&panels, welds);
    check_faces(&panels, &points)?;
    let mut mesh = Garment {
        prim,
        units,
        uv_scales: panels[0].mesh.uv_scales.clone(),
        points: positions(&panels, &points),
        orientation,
        rules: panels[0].mesh.rules,
        families: merge_families(&panels),
        ..Garment::default()
    };
    let (primvars, warnings) = merge_primvars(&mesh.prim, &panels, &points);
    mesh.primvars = primvars;
    mesh.left_out = panels.iter().flat_map(|panel| panel.mesh.left_out.iter().cloned()).collect();
    mesh.subsets = merge_subsets(&panels, &points)?;
    for (panel, of_panel) in panels.iter().zip(&points.of_panel) {
        add_topology(&mut mesh, &panel.mesh, of_panel);
    }
    merge_corners(&mut mesh, &panels, &points);
    let sets = panels.iter().scan(0, |first, panel| {
        let faces = *first..*first + panel.mesh.face_vertex_counts.len() as i32;
        *first = faces.end;
        Some(set(&mut mesh.subsets, &panel.name, "face", faces.collect()))
    });
    let sets: Vec<String> = if panels.len() > 1 { sets.collect() } else { Vec::new() };
    let seams = seam_edges(&panels, &points);
    let seams = set(&mut mesh.subsets, "sewn", "edge", seams);
    Ok(Sewn { mesh, panels: sets, points: points.of_panel, seams, warnings })
}

/// Adds a set with this name, or a free one like it.
fn set(subsets: &mut Vec<SubsetInput>, name: &str, element_type: &str, indices: Vec<i32>) -> String {
    let name = free_name(name, |name| subsets.iter().any(|subset| subset.name == name));
    let (element_type, family) = (element_type.to_owned(), String::new());
    subsets.push(SubsetInput { name: name.clone(), element_type, family, indices });
    name
}

/// An error about two panels.
pub fn differ(panels: [&Panel; 2], text: impl std::fmt::Display) -> Error {
    let place = format!("{}, {}", panels[0].mesh.prim, panels[1].mesh.prim);
    Error::new(ErrorKind::Mesh, place, format!("they are sewn together, and {text}")).code(codes::PANELS_DIFFER)
}

fn check_rules(panels: &[Panel]) -> Result<(), Error> {
    let first = &panels[0];
    for panel in &panels[1..] {
        let (a, b) = (first.mesh.rules, panel.mesh.rules);
        let rules = [
            ("subdivisionScheme", format!("{:?}", a.scheme), format!("{:?}", b.scheme)),
            ("interpolateBoundary", format!("{:?}", a.boundary), format!("{:?}", b.boundary)),
            ("faceVaryingLinearInterpolation", format!("{:?}", a.face_varying), format!("{:?}", b.face_varying)),
            ("triangleSubdivisionRule", format!("{:?}", a.triangles), format!("{:?}", b.triangles)),
        ];
        if let Some((rule, a, b)) = rules.iter().find(|(_, a, b)| a != b) {
            let text = format!("{rule} is {a} on one and {b} on the other");
            return Err(differ([first, panel], text).remedy("give both the same value, or leave one out by --exclude"));
        }
        if first.mesh.uv_scales != panel.mesh.uv_scales {
            let text = "the scales of their UV sets differ (constant primvars such as stScale)";
            return Err(differ([first, panel], text).remedy("give both the same scale"));
        }
    }
    Ok(())
}

/// Turns the winding of all faces. Each face keeps its first corner.
fn turn(mesh: &mut Garment) {
    let mut order = Vec::with_capacity(mesh.face_vertex_indices.len());
    for &count in &mesh.face_vertex_counts {
        let first = order.len();
        order.extend((0..count as usize).map(|i| first + (count as usize - i) % count as usize));
    }
    mesh.face_vertex_indices = order.iter().map(|&corner| mesh.face_vertex_indices[corner]).collect();
    for primvar in mesh.primvars.iter_mut().filter(|p| p.interpolation == Interpolation::FaceVarying) {
        turn_values(primvar, &order);
    }
}

fn turn_values(primvar: &mut PrimvarInput, order: &[usize]) {
    match &mut primvar.indices {
        Some(indices) => *indices = order.iter().map(|&corner| indices[corner]).collect(),
        None => {
            let width = primvar.components * primvar.element_size.max(1) as usize;
            primvar.values = primvar.values.gather(width, order.iter().copied());
        }
    }
}

/// Numbers the points of the garment in the order in which panels have them.
fn weld(panels: &[Panel], welds: &[[(usize, usize); 2]]) -> Points {
    let firsts: Vec<usize> = panels
        .iter()
        .scan(0, |next, panel| {
            let first = *next;
            *next += panel.mesh.points.len();
            Some(first)
        })
        .collect();
    let all: usize = panels.iter().map(|panel| panel.mesh.points.len()).sum();
    let mut sets = Groups::new(all);
    for [a, b] in welds.iter().map(|pair| pair.map(|(panel, point)| firsts[panel] + point)) {
        sets.join(a, b);
    }
    let mut numbers = vec![None; all];
    let (mut of_panel, mut sources) = (Vec::new(), Vec::<Vec<(usize, usize)>>::new());
    for (panel, Panel { mesh, .. }) in panels.iter().enumerate() {
        let number = |point: usize| {
            let first = sets.first(firsts[panel] + point);
            let number = *numbers[first].get_or_insert(sources.len());
            if number == sources.len() {
                sources.push(Vec::new());
            }
            sources[number].push((panel, point));
            number
        };
        of_panel.push((0..mesh.points.len()).map(number).collect());
    }
    Points { of_panel, sources }
}

/// The mean of the points that are one.
fn positions(panels: &[Panel], points: &Points) -> Vec<Vec3> {
    let mean = |sources: &Vec<(usize, usize)>| match sources.as_slice() {
        &[(panel, point)] => panels[panel].mesh.points[point],
        several => {
            let sum: DVec3 = several.iter().map(|&(panel, point)| panels[panel].mesh.points[point].as_dvec3()).sum();
            (sum / several.len() as f64).as_vec3()
        }
    };
    points.sources.iter().map(mean).collect()
}

/// Refuses welds of two corners of a face, which a tolerance that is larger than a slit has.
fn check_faces(panels: &[Panel], points: &Points) -> Result<(), Error> {
    for (panel, of_panel) in panels.iter().zip(&points.of_panel) {
        let mut corners = panel.mesh.face_vertex_indices.as_slice();
        for (face, &count) in panel.mesh.face_vertex_counts.iter().enumerate() {
            let (own, rest) = corners.split_at(count as usize);
            corners = rest;
            let mut own: Vec<[usize; 2]> = own.iter().map(|&p| [of_panel[p as usize], p as usize]).collect();
            own.sort_unstable();
            if let Some(two) = own.windows(2).find(|two| two[0][0] == two[1][0] && two[0][1] != two[1][1]) {
                let text =
                    format!("sewing it would make one point of points {} and {} of face {face}", two[0][1], two[1][1]);
                let fault = Error::new(ErrorKind::Mesh, &panel.mesh.prim, text).code(codes::PANELS_DIFFER);
                return Err(fault.remedy("lower --sew-tolerance, or join the points of the mesh there"));
            }
        }
    }
    Ok(())
}

/// Adds the faces of a panel, its holes and its creases.
fn add_topology(mesh: &mut Garment, panel: &Garment, of_panel: &[usize]) {
    let first_face = mesh.face_vertex_counts.len() as i32;
    let point = |&p: &i32| of_panel[p as usize] as i32;
    mesh.face_vertex_counts.extend(&panel.face_vertex_counts);
    mesh.face_vertex_indices.extend(panel.face_vertex_indices.iter().map(point));
    mesh.hole_indices.extend(panel.hole_indices.iter().map(|face| first_face + face));
    mesh.crease_indices.extend(panel.crease_indices.iter().map(point));
    let is_per_edge = panel.crease_sharpnesses.len() != panel.crease_lengths.len();
    if is_per_edge {
        mesh.crease_sharpnesses.extend(&panel.crease_sharpnesses);
    } else {
        let of_crease = panel.crease_lengths.iter().zip(&panel.crease_sharpnesses);
        mesh.crease_sharpnesses.extend(of_crease.flat_map(|(&n, &s)| std::iter::repeat_n(s, n as usize - 1)));
    }
    mesh.crease_lengths.extend(&panel.crease_lengths);
}

/// The corners of all panels. A point that several panels make a corner has the largest sharpness.
fn merge_corners(mesh: &mut Garment, panels: &[Panel], points: &Points) {
    let mut sharp = BTreeMap::<i32, f32>::new();
    for (panel, of_panel) in panels.iter().zip(&points.of_panel) {
        for (&point, &sharpness) in panel.mesh.corner_indices.iter().zip(&panel.mesh.corner_sharpnesses) {
            let known = sharp.entry(of_panel[point as usize] as i32).or_insert(sharpness);
            *known = known.max(sharpness);
        }
    }
    (mesh.corner_indices, mesh.corner_sharpnesses) = sharp.into_iter().unzip();
}

/// The edges whose faces have other points there on their panels, or other panels, as pairs of points.
fn seam_edges(panels: &[Panel], points: &Points) -> Vec<i32> {
    let mut edges = Vec::new();
    for (i, (panel, of_panel)) in panels.iter().zip(&points.of_panel).enumerate() {
        let mut corners = panel.mesh.face_vertex_indices.as_slice();
        for &count in &panel.mesh.face_vertex_counts {
            let (face, rest) = corners.split_at(count as usize);
            corners = rest;
            let steps = face.iter().zip(face.iter().cycle().skip(1)).map(|(&a, &b)| [a as usize, b as usize]);
            for own in steps {
                let [a, b] = own.map(|p| of_panel[p]);
                if points.sources[a].len() > 1 || points.sources[b].len() > 1 {
                    edges.push(([a.min(b), a.max(b)], (i, [own[0].min(own[1]), own[0].max(own[1])])));
                }
            }
        }
    }
    edges.sort_unstable();
    let of_several = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.iter().any(|e| e.1 != same[0].1));
    of_several.flat_map(|same| same[0].0.map(|p| p as i32)).collect()
}
