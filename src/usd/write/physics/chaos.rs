//! Chaos Cloth of Unreal Engine, which also reads what CLO and Marvelous Designer export: a mesh with panels as face subsets, and a
//! fabric for each.

use super::{BoundRender, Physics};
use crate::names;
use crate::write::product::Author;
use openusd::sdf::{Path, PrimSpec, Specifier, Value, ValueTypeName, Variability};
use tailor_costume::cloth::ClothOptions;
use tailor_mesh::connectivity::FaceId;

/// Family of the panels.
const PATTERN: &str = ClothOptions::PATTERN;
/// Schemas of the prim above both meshes.
pub const BODY: [&str; 1] = ["ClothRootAPI"];

impl Author<'_> {
    /// Authors the panels of both meshes.
    pub(super) fn chaos(&mut self, physics: &Physics<'_>) -> openusd::Result<()> {
        let root = Some(self.model.parent.clone()).filter(|root| *root != Path::abs_root());
        self.apply(root.as_ref().unwrap_or(&physics.sim_path), &BODY)?;
        self.apply(&physics.sim_path, &["SimMeshDataAPI"])?;
        let scale = physics.uv_centimetres();
        let scale = Value::Vec2f([scale, scale].into());
        let kind = ValueTypeName::FLOAT2;
        self.attribute(&physics.sim_path, "restPositionScale", kind, Variability::Varying, scale)?;
        let count = physics.cloth.shells.iter().max().map_or(0, |last| *last as usize + 1);
        let mut faces: Vec<Vec<usize>> = vec![Vec::new(); count];
        physics.cloth.shells.iter().enumerate().for_each(|(face, &shell)| faces[shell as usize].push(face));
        self.token(&physics.sim_path, &family_type(), "partition")?;
        for (number, faces) in faces.iter().enumerate() {
            let path = self.pattern(&physics.sim_path, number, faces)?;
            self.apply(&path, &["SimPatternAPI", "CloFabricAPI"])?;
            self.fabric(physics, &path, faces)?;
        }
        physics.renders.iter().try_for_each(|render| self.render_patterns(physics, render, count))
    }

    /// A panel as a face subset.
    fn pattern(&mut self, mesh: &Path, number: usize, faces: &[usize]) -> openusd::Result<Path> {
        let path = mesh.append_path(format!("{PATTERN}_{number}").as_str())?;
        PrimSpec::new(self.data, &path, Specifier::Def, names::GEOM_SUBSET)?;
        self.token(&path, names::ELEMENT_TYPE, "face")?;
        self.token(&path, names::FAMILY_NAME, PATTERN)?;
        self.ints(&path, names::INDICES, faces.iter().map(|face| *face as i32).collect())?;
        Ok(path)
    }

    /// The fabric of most of a panel's faces, in the units of CLO: g, mm and s.
    fn fabric(&mut self, physics: &Physics<'_>, path: &Path, faces: &[usize]) -> openusd::Result<()> {
        let mut counts = vec![0usize; physics.cloth.fabrics.len()];
        faces.iter().for_each(|&face| counts[physics.cloth.fabric_of[face] as usize] += 1);
        let most = (0..counts.len()).rev().max_by_key(|&i| counts[i]).unwrap_or(0);
        let fabric = physics.cloth.fabrics[most].fabric;
        // A newton per metre is 1000 g/s², a newton metre 1e9 g mm²/s², a kilogram per square metre 1e-3 g/mm².
        let stretch = [fabric.stretch_warp, fabric.stretch_weft].map(|k| f64::from(k) * 1e3);
        let bend = [fabric.bend_warp, fabric.bend_weft].map(|k| f64::from(k) * 1e9);
        let turned = |pair: [f64; 2]| if physics.cloth.warp_is_u { [pair[1], pair[0]] } else { pair };
        let ([warp, weft], [bend_warp, bend_weft]) = (turned(stretch), turned(bend));
        let shear = f64::from(fabric.shear) * 1e3;
        for (name, value) in [
            ("stretchWarp", warp),
            ("stretchWeft", weft),
            ("shearLeft", shear),
            ("shearRight", shear),
            ("bendingWarp", bend_warp),
            ("bendingWeft", bend_weft),
            ("density", f64::from(fabric.density) * 1e-3),
            ("friction", f64::from(fabric.friction)),
            ("thickness", f64::from(fabric.thickness) * 1e3),
        ] {
            self.float(path, &format!("primvars:clo:{name}"), value)?;
        }
        Ok(())
    }

    /// The panels of the render mesh: those of the triangles that most of each face's points are bound to.
    fn render_patterns(
        &mut self,
        physics: &Physics<'_>,
        render: &BoundRender<'_>,
        count: usize,
    ) -> openusd::Result<()> {
        let BoundRender { path: render, mesh, binding: Some(binding) } = render else { return Ok(()) };
        let is_part = physics.renders.len() > 1;
        let shell = |face: FaceId| {
            let mut shells: Vec<u32> = mesh
                .faces
                .vertices_of(face)
                .iter()
                .map(|v| physics.cloth.shells[binding.faces[v.index()] as usize])
                .collect();
            shells.sort_unstable();
            let groups = shells.chunk_by(|a, b| a == b);
            groups.rev().max_by_key(|group| group.len()).map_or(0, |group| group[0])
        };
        let mut faces: Vec<Vec<usize>> = vec![Vec::new(); count];
        mesh.faces.ids().for_each(|face| faces[shell(face) as usize].push(face.index()));
        self.token(render, &family_type(), "partition")?;
        for (number, faces) in faces.iter().enumerate().filter(|(_, faces)| !is_part || !faces.is_empty()) {
            let path = self.pattern(render, number, faces)?;
            self.apply(&path, &["RenderPatternAPI"])?;
            let sim = physics.sim_path.append_path(format!("{PATTERN}_{number}").as_str())?;
            self.target(&path, "simPattern", &sim)?;
        }
        Ok(())
    }
}

fn family_type() -> String {
    format!("{}{PATTERN}{}", names::SUBSET_FAMILY, names::FAMILY_TYPE_SUFFIX)
}

impl Physics<'_> {
    /// The length of one UV unit, from UV areas. \[cm\]
    fn uv_centimetres(&self) -> f32 {
        let meters = self.sim.units.meters();
        (f64::from(self.cloth.uv_length) * meters * 100.0) as f32
    }
}
