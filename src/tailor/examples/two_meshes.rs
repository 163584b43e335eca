//! Both meshes of a garment, from arrays: a sheet of 8 by 8 quads with a seam across it.

#![allow(clippy::print_stdout)]

use tailor::glam::Vec3;
use tailor::{Error, Garment, MeshRecipe, PrimvarInput, SeamOptions, SubsetInput};

fn main() -> Result<(), Error> {
    let n = 8;
    let at = |x: i32, y: i32| y * (n + 1) + x;
    let mut sheet = Garment { prim: "/Sheet/model".into(), ..Garment::default() };
    sheet.points = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(x as f32, y as f32, 0.0))).collect();
    sheet.face_vertex_counts = vec![4; (n * n) as usize];
    let quads = (0..n).flat_map(|y| (0..n).map(move |x| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]));
    sheet.face_vertex_indices = quads.flatten().collect();
    let uvs: Vec<[f32; 2]> = sheet.points.iter().map(|p| [p.x, p.y]).collect();
    sheet.primvars = vec![PrimvarInput::uvs("st", &uvs, sheet.face_vertex_indices.clone())];
    let indices = (0..n).flat_map(|x| [at(x, 4), at(x + 1, 4)]).collect();
    let (element_type, family) = ("edge".into(), String::new());
    sheet.subsets = vec![SubsetInput { name: "waist".into(), element_type, family, indices }];

    let mut recipe = MeshRecipe::default();
    recipe.sim.max_edge_length = 0.5;
    let seam = SeamOptions { edges: vec!["waist".into()], width: 0.2, normal_offset: -0.05, ..SeamOptions::default() };
    recipe.seam.insert("waist".into(), seam);
    let meshes = tailor::build(&sheet, &recipe)?;
    let figures = meshes.sim_figures();
    println!("simulation mesh: {} triangles, smallest angle {:.1} degrees", figures.faces, figures.min_angle);
    println!("render mesh: {} faces", meshes.render.faces.len());
    meshes.warnings.iter().for_each(|warning| println!("{warning}"));
    Ok(())
}
