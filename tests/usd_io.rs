//! Stages in, layers out: `usd::Source` and `usd::write` on small stages written as text, and on real garments.

use glam::Vec3;
use std::fs;
use std::path::{Path, PathBuf};
use tailor::error::Warnings;
use tailor::garment::{Corner, Crease, Elements, Garment, GarmentInput, Primvar, Subset};
use tailor::mesh::{FaceId, Faces, VertexId};
use tailor::usd::{Product, ReadOptions, Role, Source, UsdError, WriteOptions, write};

/// The garment of an input that is known to be sound.
pub fn sound(input: &GarmentInput) -> Garment {
    let vertex = |i: &i32| VertexId::new(*i as usize);
    let faces = |indices: &[i32]| indices.iter().map(|i| FaceId::new(*i as usize)).collect::<Vec<_>>();
    let corners: Vec<_> = input.face_vertex_indices.iter().map(vertex).collect();
    let mut creases = Vec::new();
    let (mut start, mut edge) = (0, 0);
    let per_edge = input.crease_sharpnesses.len() != input.crease_lengths.len();
    for (i, &length) in input.crease_lengths.iter().enumerate() {
        let length = length as usize;
        let vertices = input.crease_indices[start..start + length].iter().map(vertex).collect();
        let sharpness = |k: usize| input.crease_sharpnesses[if per_edge { edge + k } else { i }];
        creases.push(Crease { vertices, sharpnesses: (0..length - 1).map(sharpness).collect() });
        (start, edge) = (start + length, edge + length - 1);
    }
    let corner = |(v, s): (&i32, &f32)| Corner { vertex: vertex(v), sharpness: *s };
    Garment {
        prim: input.prim.clone(),
        points: input.points.clone().into(),
        faces: Faces::mixed(input.face_vertex_counts.iter().map(|&n| n as usize), corners),
        orientation: input.orientation,
        rules: input.rules,
        holes: faces(&input.hole_indices),
        creases,
        corners: input.corner_indices.iter().zip(&input.corner_sharpnesses).map(corner).collect(),
        primvars: input.primvars.iter().map(primvar).collect(),
        subsets: input
            .subsets
            .iter()
            .map(|s| Subset {
                name: s.name.clone(),
                family: s.family.clone(),
                elements: match s.element_type.as_str() {
                    "face" => Elements::Faces(faces(&s.indices)),
                    "edge" => Elements::Edges(s.indices.chunks(2).map(|e| [vertex(&e[0]), vertex(&e[1])]).collect()),
                    _ => Elements::Points(s.indices.iter().map(vertex).collect()),
                },
            })
            .collect(),
        families: input.families.clone(),
    }
}

pub fn primvar(p: &tailor::garment::PrimvarInput) -> Primvar {
    Primvar {
        name: p.name.clone(),
        type_name: p.type_name.clone(),
        interpolation: p.interpolation,
        components: p.components,
        element_size: p.element_size as usize,
        mixing: p.mixing,
        values: p.values.clone(),
        indices: p.indices.as_ref().map(|i| i.iter().map(|&i| i as u32).collect()),
    }
}
