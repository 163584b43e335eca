//! Small stages written as text, and a product that is the input itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor_mesh::error::Error;
use tailor_mesh::{Corner, Crease, Elements, Garment, Mesh, Primvar, Subset};
use tailor_mesh::{FaceId, Faces, VertexId};
use tailor_usd::{LodSchema, Product, ProductRole, ReadOptions, SetChoice, Source, WriteOptions, write};

/// The garment of an input that is known to be sound.
pub fn sound(input: &Garment) -> Mesh {
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
    Mesh {
        units: tailor_mesh::Units::default(),
        space: tailor_mesh::StageSpace::default(),
        materials: std::collections::BTreeMap::new(),
        uv_scales: std::collections::BTreeMap::default(),
        influences: None,
        left_out: Vec::new(),
        prim: input.prim.clone(),
        points: input.points.clone().into(),
        faces: Faces::mixed(input.face_vertex_counts.iter().map(|&n| n as usize), corners),
        orientation: input.orientation,
        rules: input.rules,
        holes: faces(&input.hole_indices),
        creases,
        corners: input.corner_indices.iter().zip(&input.corner_sharpnesses).map(corner).collect(),
        primvars: input.primvars.iter().map(primvar).collect::<Vec<_>>().into(),
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
                sharpness: None,
            })
            .collect::<Vec<_>>()
            .into(),
        families: input.families.clone(),
    }
}

pub fn primvar(p: &tailor_mesh::PrimvarInput) -> Primvar {
    Primvar {
        name: p.name.clone(),
        role: p.role.clone(),
        meaning: p.meaning,
        half: p.half,
        interpolation: p.interpolation,
        components: p.components,
        element_size: p.element_size as usize,
        values: p.values.clone(),
        indices: p.indices.as_ref().map(|i| Arc::new(i.iter().map(|&i| i as u32).collect())),
    }
}

/// A folder that goes away with the test, and files in it.
pub struct Stages(pub tempfile::TempDir);

impl Stages {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes `#usda 1.0` and `text`.
    pub fn usda(&self, name: &str, text: &str) -> PathBuf {
        let path = self.at(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, format!("#usda 1.0\n{text}")).unwrap();
        path
    }

    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// Two quads as statements of a mesh.
pub const QUADS: &str = "
    point3f[] points = [(0,0,0),(1,0,0),(2,0,0),(0,1,0),(1,1,0),(2,1,0)]
    int[] faceVertexCounts = [4,4]
    int[] faceVertexIndices = [0,1,4,3,1,2,5,4]
";

/// `/Coat/model`, two quads with `extra` statements.
pub fn coat(extra: &str) -> String {
    format!(
        "(\n defaultPrim = \"Coat\"\n metersPerUnit = 0.01\n upAxis = \"Y\"\n)\n\
         def Xform \"Coat\"\n{{\n def Mesh \"model\"\n {{\n{QUADS}\n{extra}\n }}\n}}\n"
    )
}

pub fn open(path: &Path) -> Result<Source, Error> {
    Source::open(path, &ReadOptions::default())
}

pub fn open_prim(path: &Path, prim: &str) -> Result<Source, Error> {
    Source::open(path, &ReadOptions { prim: Some(prim.into()), ..ReadOptions::default() })
}

pub fn read(source: &Source) -> Result<Garment, Error> {
    source.garment().map(|(mesh, _)| mesh)
}

/// Writes the input itself as both products; the warnings.
pub fn tailor(source: &Source, out: &Path, options: &WriteOptions) -> Result<Vec<String>, Error> {
    let mesh = sound(&read(source)?);
    let product = |name, role| Product::new(name, role, &mesh);
    let products = [product("sim", ProductRole::Sim), product("render", ProductRole::Render)];
    let (_, warnings) = write(source, &products, out, options)?;
    Ok(warnings.iter().map(ToString::to_string).collect())
}

pub const FORCE: WriteOptions = over_any_file(false);
pub const FLATTEN: WriteOptions = over_any_file(true);

const fn over_any_file(flatten: bool) -> WriteOptions {
    WriteOptions {
        flatten,
        force: true,
        model_guide: true,
        dry_run: false,
        sets: SetChoice::All,
        lod_schema: LodSchema::Variants,
        record: None,
        held: None,
    }
}

#[track_caller]
pub fn assert_fault<T>(result: Result<T, Error>, parts: &[&str]) {
    let text = result.err().expect("a fault").to_string();
    for part in parts {
        assert!(text.contains(part), "{part:?} in: {text}");
    }
}
