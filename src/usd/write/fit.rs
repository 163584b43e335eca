//! A fitted garment as a layer over its stage.

use super::layer::{LayerContext, overlay};
use super::product::{Author, extent};
use super::role::SetChoice;
use super::save::OutputFile;
use crate::error::{Error, Warnings};
use crate::usd::read::{OrUnreadable, Source, prim_at, property_names, transforms, value};
use crate::usd::{BuildRecord, names, on_large_stack};
use glam::Vec3;
use openusd::sdf::{self, AbstractData, PrimSpec, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use openusd::usd::Stage;
use std::path::Path;

/// A garment with new points.
pub struct FittedGarment<'a> {
    /// The garment.
    pub source: &'a Source,
    /// Its points, in the order of [`Source::garment`].
    pub points: &'a [Vec3],
}

/// Writes the points of garments of one stage as a layer over it, with a record of what they were made of. Authored normals are
/// blocked, since they are of the old points.
///
/// # Errors
/// A file that may not or cannot be written.
pub fn write_fitted(
    garments: &[FittedGarment],
    record: &BuildRecord,
    out: &Path,
    force: bool,
) -> Result<Warnings, Error> {
    let first = garments.first().ok_or_else(|| Error::internal("there is no garment to write"))?;
    let model = &first.source.model;
    let file = OutputFile::find(out, |file| model.uses(file), force)?;
    on_large_stack(|| {
        let (stage, anchor) = (model.origin.open()?, file.anchor());
        let mut data = overlay(model, LayerContext { flatten: false, anchor, sublayer: None })?;
        for garment in garments {
            let model = &garment.source.model;
            let mut author = Author { data: &mut data, model, anchor, is_overlay: true, sets: SetChoice::None };
            garment.author(&stage, &mut author)?;
        }
        record.author(&mut data)?;
        let (_, warnings) = file.save(data)?;
        Ok(warnings)
    })
}

impl FittedGarment<'_> {
    fn author(&self, stage: &Stage, author: &mut Author) -> Result<(), Error> {
        let (model, mut next) = (&self.source.model, 0);
        for panel in &model.panels {
            let prim = prim_at(stage, panel)?;
            let from_garment = transforms(&prim, None)?.to_world.inverse() * model.transforms.to_world;
            let own: Vec<Vec3> = match value(&prim, names::POINTS, None)? {
                Some(Value::Vec3fVec(points)) => bytemuck::cast_slice(&points).to_vec(),
                _ => Vec::new(),
            };
            let count = own.len();
            let at = |i: usize| {
                let point = self.points[model.sewing.points.get(i).copied().unwrap_or(i)];
                // A lone mesh is in its own space, and keeps its numbers.
                if model.is_sewn() { from_garment.transform_point3(point.as_dvec3()).as_vec3() } else { point }
            };
            let points: Vec<Vec3> = (next..next + count).map(at).collect();
            next += count;
            let is_normals = |name: &String| [names::NORMALS, "primvars:normals"].contains(&name.as_str());
            let normals: Vec<String> = property_names(&prim)?.into_iter().filter(is_normals).collect();
            let made: Vec<Vec3> = match value(&prim, names::FIT_FROM, None)? {
                // It was fitted before.
                Some(Value::Vec3fVec(made)) if made.len() == count => bytemuck::cast_slice(&made).to_vec(),
                _ => own,
            };
            author.fitted(panel, &points, &made, &normals).or_unreadable(panel)?;
        }
        Ok(())
    }
}

impl Author<'_> {
    /// Authors other points of a mesh and those that it was made with, and blocks its normals.
    fn fitted(&mut self, prim: &sdf::Path, points: &[Vec3], made: &[Vec3], normals: &[String]) -> openusd::Result<()> {
        PrimSpec::over(self.data, prim)?;
        let extent = Value::Vec3fVec(extent(points));
        let [points, made] = [points, made].map(|points| Value::Vec3fVec(bytemuck::cast_slice(points).to_vec()));
        self.attribute(prim, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, extent)?;
        self.attribute(prim, names::POINTS, ValueTypeName::POINT3F_ARRAY, Variability::Varying, points)?;
        self.attribute(prim, names::FIT_FROM, ValueTypeName::POINT3F_ARRAY, Variability::Varying, made)?;
        let path = prim.append_property(names::FIT_FROM)?;
        self.data.set_field(&path, names::INTERPOLATION, Value::Token(Token::from("vertex")));
        for name in normals {
            let blocked = Value::ValueBlock;
            self.attribute(prim, name, ValueTypeName::NORMAL3F_ARRAY, Variability::Varying, blocked)?;
        }
        Ok(())
    }
}
