//! Writing blend shapes.

use super::product::Author;
use crate::names;
use crate::read::BlendShape;
use crate::record::Record;
use openusd::gf::Vec3f;
use openusd::sdf::{self, AbstractData, FieldKey, Path, PrimSpec, Specifier, Value};
use openusd::tf::Token;
use std::collections::BTreeSet;
use tailor_mesh::garment::{Mesh, PrimvarRole, Values, free_name};

impl Author<'_> {
    /// Authors the blend shapes below a product, and binds it to them.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn shapes(&mut self, prim: &Path, mesh: &Mesh) -> openusd::Result<()> {
        let mut taken: BTreeSet<String> = mesh.subsets.iter().map(|s| s.name.clone()).collect();
        let (mut tokens, mut targets) = (Vec::new(), Vec::new());
        for (number, shape) in self.model.declarations.shapes.iter().enumerate() {
            let name = free_name(&shape.name, |name| taken.contains(name));
            let path = prim.append_path(name.as_str())?;
            taken.insert(name);
            self.shape(&path, number, shape, mesh)?;
            if let Some(binding) = &shape.binding {
                tokens.push(Token::from(binding.as_str()));
                targets.push(path);
            }
        }
        if !targets.is_empty() {
            let (name, value) = (names::SKEL_BLEND_SHAPES, Value::TokenVec(tokens));
            let (type_name, uniform) = (sdf::ValueTypeName::TOKEN_ARRAY, sdf::Variability::Uniform);
            self.attribute(prim, name, type_name, uniform, value)?;
            let path = prim.append_property(names::SKEL_BLEND_SHAPE_TARGETS)?;
            sdf::RelationshipSpec::new(self.data, &path, uniform, false)?;
            let targets = sdf::PathListOp::explicit(targets);
            AbstractData::set_field(self.data, &path, FieldKey::TargetPaths.as_str(), targets.into());
        }
        Ok(())
    }

    /// Authors one blend shape: the points that it moves, and their offsets.
    fn shape(&mut self, path: &Path, number: usize, shape: &BlendShape, mesh: &Mesh) -> openusd::Result<()> {
        PrimSpec::new(self.data, path, Specifier::Def, names::BLEND_SHAPE)?;
        let moving: Vec<(&Record, &[f32])> = shape
            .properties
            .iter()
            .filter_map(|record| {
                let role = PrimvarRole::BlendShape { shape: number, property: record.name.clone() };
                match &mesh.primvars.iter().find(|p| p.role == role)?.values {
                    Values::F32(values) => Some((record, values.as_slice())),
                    _ => None,
                }
            })
            .collect();
        let moves = |point: &usize| moving.iter().any(|(_, v)| v[3 * point..3 * point + 3].iter().any(|x| *x != 0.0));
        let moved: Vec<usize> = (0..mesh.points.len()).filter(moves).collect();
        self.ints(path, names::POINT_INDICES, moved.iter().map(|&p| p as i32).collect())?;
        for (record, values) in moving {
            let offset = |&p: &usize| Vec3f::from([values[3 * p], values[3 * p + 1], values[3 * p + 2]]);
            let offsets = moved.iter().map(offset).collect();
            let property = record.declare(self.data, path)?;
            AbstractData::set_field(self.data, &property, FieldKey::Default.as_str(), Value::Vec3fVec(offsets));
        }
        Ok(())
    }
}
