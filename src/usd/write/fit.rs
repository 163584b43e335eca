//! A fitted garment as a layer over its stage.

use super::layer::{LayerContext, overlay};
use super::product::{Author, extent};
use super::role::SetChoice;
use super::save::OutputFile;
use super::variant::copy_into_variant;
use crate::error::{Error, ErrorCode, Warning, Warnings};
use crate::usd::read::{OrUnreadable, Selection, Source, prim_at, property_names, transforms, value};
use crate::usd::{BuildRecord, names, on_large_stack};
use glam::Vec3;
use openusd::sdf::{self, AbstractData, FieldKey, PrimSpec, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use openusd::usd::{Stage, TimeCode};
use std::path::Path;

/// A garment with new points.
pub struct FittedGarment<'a> {
    /// The garment.
    pub source: &'a Source,
    /// Its points, in the order of [`Source::garment`].
    pub points: &'a [Vec3],
    /// The time at which it was read. \[time codes\]
    pub time: Option<f64>,
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
        let mut motions = Warnings::default();
        for garment in garments {
            let model = &garment.source.model;
            let mut author = Author { data: &mut data, model, anchor, is_overlay: true, sets: SetChoice::None };
            motions.extend(garment.author(&stage, &mut author)?);
        }
        record.author(&mut data)?;
        let (_, mut warnings) = file.save(data)?;
        warnings.extend(motions);
        Ok(warnings)
    })
}

/// A body of a variant set, and the garments on it.
pub struct BodyChoice<'a> {
    /// The name of the variant.
    pub name: &'a str,
    /// The garments of one stage, the same for each body; none for the body on which they stay as they are.
    pub garments: Vec<FittedGarment<'a>>,
}

/// Writes garments on several bodies as a variant set of the prim above them. The layer refers to that prim of the garment's file: what a
/// sublayer says of points would be stronger than any variant.
///
/// # Errors
/// Names that no variant can have, and as [`write_fitted`].
pub fn write_bodies(
    set: &str,
    choices: &[BodyChoice],
    record: &BuildRecord,
    out: &Path,
    force: bool,
) -> Result<Warnings, Error> {
    let garments = choices.iter().flat_map(|choice| &choice.garments);
    let first = garments.into_iter().next().ok_or_else(|| Error::internal("there is no garment to write"))?;
    let model = &first.source.model;
    let file = OutputFile::find(out, |file| model.uses(file), force)?;
    on_large_stack(|| {
        let (stage, anchor) = (model.origin.open()?, file.anchor());
        let context = LayerContext { flatten: false, anchor, sublayer: None };
        let above = model.path.strict_ancestors_below_root().last().unwrap_or_else(|| model.path.clone());
        let mut data = overlay(model, context)?;
        refer(&mut data, &above).or_unreadable(&above)?;
        let mut motions = Warnings::default();
        for choice in choices {
            let mut part = overlay(model, context)?;
            PrimSpec::over(&mut part, &above).or_unreadable(&above)?;
            for garment in &choice.garments {
                let model = &garment.source.model;
                let mut author = Author { data: &mut part, model, anchor, is_overlay: true, sets: SetChoice::None };
                motions.extend(garment.author(&stage, &mut author)?);
            }
            let selection =
                Selection { prim: above.as_str().to_owned(), set: set.to_owned(), choice: choice.name.to_owned() };
            copy_into_variant(&mut data, &part, &[&selection]).map_err(|e| bad_name(&selection, &e))?;
        }
        let chosen = choices.first().map(|choice| choice.name.to_owned()).unwrap_or_default();
        let selected = Value::VariantSelectionMap([(set.to_owned(), chosen)].into());
        data.set_field(&above, FieldKey::VariantSelection.as_str(), selected);
        record.author(&mut data)?;
        let (_, mut warnings) = file.save(data)?;
        let others = prim_at(&stage, &sdf::Path::abs_root())?.child_names().or_unreadable(&above)?;
        for name in others.iter().filter(|name| above.name() != Some(name.as_str())) {
            let why = format!("the variants refer to {above} alone; move it below that prim, or fit to a folder");
            warnings.push(Warning::not_carried(format!("/{name}"), why));
        }
        warnings.extend(motions);
        Ok(warnings)
    })
}

/// Makes the sublayer of a layer a reference of a prim.
fn refer(data: &mut sdf::Data, prim: &sdf::Path) -> openusd::Result<()> {
    let (root, key) = (sdf::Path::abs_root(), FieldKey::SubLayers.as_str());
    let asset_path = match AbstractData::try_field(data, &root, key)?.as_deref() {
        Some(Value::StringVec(layers)) => layers.first().cloned().unwrap_or_default(),
        _ => String::new(),
    };
    [key, FieldKey::SubLayerOffsets.as_str()].into_iter().for_each(|key| data.erase_field(&root, key));
    PrimSpec::over(data, prim)?;
    let reference = sdf::Reference { asset_path, prim_path: prim.clone(), ..sdf::Reference::default() };
    let all = sdf::ReferenceListOp { prepended_items: vec![reference], ..sdf::ReferenceListOp::default() };
    data.set_field(prim, FieldKey::References.as_str(), Value::ReferenceListOp(all));
    Ok(())
}

fn bad_name(selection: &Selection, error: &openusd::Error) -> Error {
    let text = format!("{}{{{}={}}} cannot be a variant: {error}", selection.prim, selection.set, selection.choice);
    Error::usd(text).code(ErrorCode::NameTaken).remedy("give the files of bodies names of letters, digits and _")
}

impl FittedGarment<'_> {
    /// Authors the points of each mesh. Warns of points that move, which those of one time hide.
    pub(super) fn author(&self, stage: &Stage, author: &mut Author) -> Result<Warnings, Error> {
        let (model, mut next, mut warnings) = (&self.source.model, 0, Warnings::default());
        let time = self.time.map(TimeCode::new);
        for panel in &model.panels {
            let prim = prim_at(stage, panel)?;
            let from_garment = transforms(&prim, time)?.to_world.inverse() * model.transforms.to_world;
            let own: Vec<Vec3> = match value(&prim, names::POINTS, time)? {
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
            let made: Vec<Vec3> = match value(&prim, names::FIT_FROM, time)? {
                // It was fitted before.
                Some(Value::Vec3fVec(made)) if made.len() == count => bytemuck::cast_slice(&made).to_vec(),
                _ => own,
            };
            author.fitted(panel, &points, &made, &normals).or_unreadable(panel)?;
            let times = prim.attribute(names::POINTS).time_sample_times().or_unreadable(panel)?.len();
            if times > 1 {
                let place = format!("the motion of {panel}.{} over {times} times", names::POINTS);
                warnings.push(Warning::not_carried(place, "the fitted points are of one time, and hide it"));
            }
        }
        Ok(warnings)
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
