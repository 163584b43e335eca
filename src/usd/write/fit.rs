//! A fitted garment as a layer over its stage.

use super::beside::{left_beside, stale_skin};
use super::layer::{LayerContext, WriteOptions, name_fault, overlay};
use super::product::{Author, extent};
use super::role::{GarmentProducts, SetChoice};
use super::save::OutputFile;
use super::trims::{BoundTrim, FittedTrims, TrimBindings, fitted_trims};
use super::variant::copy_into_variant;
use crate::read::{
    FittedPoints, FittedTrim, Model, OrUnreadable, Selection, Source, dependent_attributes, frozen_trim, points_name,
    prim_at, transforms, vectors,
};
use crate::{codes, names, on_large_stack};
use glam::Vec3;
use openusd::sdf::{self, AbstractData, FieldKey, PrimSpec, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use openusd::usd::{Prim, Stage, TimeCode};
use std::path::Path;
use tailor_mesh::error::{Error, Warning, Warnings};

/// Authors the points of the garments that are on another body, and of their trims.
///
/// # Errors
/// Such a garment in a variant, and a stage that cannot be read again.
pub fn author_fits(
    data: &mut sdf::Data,
    garments: &[GarmentProducts],
    trims: &TrimBindings,
    frame: LayerContext,
) -> Result<Warnings, Error> {
    let fitted: Vec<&Source> = garments.iter().map(|of| of.source).filter(|source| source.fitted.is_some()).collect();
    let Some(Source { model, .. }) = fitted.first() else { return Ok(Warnings::default()) };
    garments.iter().try_for_each(refuse_variant)?;
    let is_overlay = !frame.flatten;
    let mut author = Author { data, model, anchor: frame.anchor, is_overlay, sets: SetChoice::None };
    author.fitted(&model.origin.open()?, &fitted, trims.fitted())
}

/// Refuses new points of a garment in a variant, as those of the stage are stronger.
fn refuse_variant(garment: &GarmentProducts) -> Result<(), Error> {
    let is_fitted = garment.source.fitted.is_some();
    let Some(Selection { set, choice, .. }) = garment.variant.filter(|_| is_fitted) else { return Ok(()) };
    let model = &garment.source.model.path;
    let text = format!("fit.to cannot be combined with variants: its points of {model} would override {set}={choice}");
    let remedy = "write its bodies as variants with `usdtailor fit --variant-set`, and build that, or build each alone";
    Err(Error::usd(text).code(codes::OUTPUT_PATH).remedy(remedy))
}

/// Writes the new points of garments of one stage, and those of their trims, as a layer over it. Normals and velocities of garments
/// are blocked, since they are of the old points. Of the options, `force`, `dry_run` and `record` count. Returns the trims. See
/// [`Source::set_fitted`].
///
/// # Errors
/// A file that may not or cannot be written.
pub fn write_fitted(
    garments: &[&Source],
    out: &Path,
    options: &WriteOptions,
) -> Result<(Vec<BoundTrim>, Warnings), Error> {
    let first = garments.first().ok_or_else(|| Error::internal("there is no garment to write"))?;
    let model = &first.model;
    let file = OutputFile::find(out, |file| model.uses(file), options.force)?;
    on_large_stack(|| {
        let (stage, anchor) = (model.origin.open()?, file.anchor());
        let mut data = overlay(model, LayerContext { flatten: false, anchor, sublayer: None })?;
        let mut author = Author { data: &mut data, model, anchor, is_overlay: true, sets: SetChoice::None };
        let (trims, mut warnings) = author.fitted_alone(&stage, garments)?;
        warnings.extend(save(&file, data, options)?);
        Ok((trims, warnings))
    })
}

/// Writes a layer with the record of what it was made of.
fn save(file: &OutputFile, mut data: sdf::Data, options: &WriteOptions) -> Result<Warnings, Error> {
    if let Some(record) = &options.record {
        record.author(&mut data)?;
    }
    Ok(options.save(file, data)?.1)
}

/// A body of a variant set, and the garments on it.
pub struct BodyChoice<'a> {
    /// The name of the variant.
    pub name: &'a str,
    /// The garments of one stage, the same for each body; none for the body on which they stay as they are.
    pub garments: Vec<&'a Source>,
}

/// Writes garments on several bodies as a variant set of the prim above them. The layer refers to that prim of the garment's file: what a
/// sublayer says of points would be stronger than any variant. Returns the trims of each choice.
///
/// # Errors
/// Names that no variant can have, and as [`write_fitted`].
pub fn write_bodies(
    set: &str,
    choices: &[BodyChoice],
    out: &Path,
    options: &WriteOptions,
) -> Result<(Vec<Vec<BoundTrim>>, Warnings), Error> {
    let garments = choices.iter().flat_map(|choice| &choice.garments);
    let first = garments.into_iter().next().ok_or_else(|| Error::internal("there is no garment to write"))?;
    let model = &first.model;
    let file = OutputFile::find(out, |file| model.uses(file), options.force)?;
    on_large_stack(|| {
        let (stage, anchor) = (model.origin.open()?, file.anchor());
        let context = LayerContext { flatten: false, anchor, sublayer: None };
        let above = model.path.strict_ancestors_below_root().last().unwrap_or_else(|| model.path.clone());
        let mut data = overlay(model, context)?;
        refer(&mut data, &above).or_unreadable(&above)?;
        let why = format!("the variants refer to {above} alone; move it below that prim, or fit to a folder");
        let (mut trims, mut warnings) = (Vec::with_capacity(choices.len()), Warnings::default());
        for choice in choices {
            let mut part = overlay(model, context)?;
            PrimSpec::over(&mut part, &above).or_unreadable(&above)?;
            let mut author = Author { data: &mut part, model, anchor, is_overlay: true, sets: SetChoice::None };
            let (within, without): (Vec<_>, Vec<_>) = warnings
                .absorb(author.fitted_alone(&stage, &choice.garments)?)
                .into_iter()
                .partition(|trim| sdf::Path::new(&trim.prim).is_ok_and(|path| path.has_prefix(&above)));
            trims.push(within);
            warnings.extend(without.into_iter().map(|trim| Warning::not_carried(trim.prim, &why)));
            let selection =
                Selection { prim: above.as_str().to_owned(), set: set.to_owned(), choice: choice.name.to_owned() };
            copy_into_variant(&mut data, &part, &[&selection]).map_err(|e| bad_name(&selection, &e))?;
        }
        let chosen = choices.first().map(|choice| choice.name.to_owned()).unwrap_or_default();
        let selected = Value::VariantSelectionMap([(set.to_owned(), chosen)].into());
        data.set_field(&above, FieldKey::VariantSelection.as_str(), selected);
        warnings.extend(save(&file, data, options)?);
        let others = prim_at(&stage, &sdf::Path::abs_root())?.child_names().or_unreadable(&above)?;
        for name in others.iter().filter(|name| above.name() != Some(name.as_str())) {
            warnings.push(Warning::not_carried(format!("/{name}"), &why));
        }
        Ok((trims, warnings))
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
    name_fault(text, "give the files of bodies names of letters, digits and _")
}

impl Author<'_> {
    /// As [`Author::fitted`], with all trims that these garments take along. Warns of those that ride on others.
    fn fitted_alone(&mut self, stage: &Stage, garments: &[&Source]) -> Result<(Vec<BoundTrim>, Warnings), Error> {
        let trims = fitted_trims(garments.iter().copied());
        let mut warnings = self.fitted(stage, garments, &trims)?;
        for (root, on) in garments.iter().filter_map(|source| source.fitted.as_deref()).flat_map(|of| &of.elsewhere) {
            if !trims.keys().any(|path| path.has_prefix(root)) {
                let why = format!("it stays where it is, as {on}, on which it rides, is not fitted");
                warnings.push(Warning::not_carried(root, why).remedy("Name the mesh of a garment that is, or none"));
            }
        }
        let bound = |(path, (garment, trim)): (&&sdf::Path, &(usize, &FittedTrim))| BoundTrim {
            prim: path.to_string(),
            name: trim.name.clone(),
            garment: *garment,
            ride: trim.ride.clone(),
        };
        Ok((trims.iter().map(bound).collect(), warnings))
    }

    /// Authors the new points of garments and of trims. Warns of points that move, which those of one time hide, and of what other
    /// variants have.
    pub(super) fn fitted(
        &mut self,
        stage: &Stage,
        garments: &[&Source],
        trims: &FittedTrims,
    ) -> Result<Warnings, Error> {
        let mut warnings = Warnings::default();
        for source in garments {
            if let Some(fitted) = source.fitted.as_deref() {
                warnings.extend(self.fitted_panels(stage, &source.model, fitted)?);
            }
        }
        warnings.extend(left_beside(stage, garments, trims)?);
        for (_, trim) in trims.values() {
            let path = &trim.path;
            PrimSpec::over(self.data, path).or_unreadable(path)?;
            for (name, kind, value) in &trim.values {
                self.at_all_times(path, name, kind.clone(), value.clone()).or_unreadable(path)?;
            }
            let prim = prim_at(stage, path)?;
            warnings.extend(motion(&prim, points_name(&prim)?)?.into_iter().chain(trim.off_cloth.clone()));
            let changed = trim.values.iter().map(|(name, ..)| name.as_str()).collect();
            warnings.extend(frozen_trim(&prim, &changed)?);
        }
        Ok(warnings)
    }

    fn fitted_panels(&mut self, stage: &Stage, model: &Model, fitted: &FittedPoints) -> Result<Warnings, Error> {
        let (mut next, mut warnings) = (0, Warnings::default());
        let time = fitted.time.map(TimeCode::new);
        for panel in &model.panels {
            let prim = prim_at(stage, panel)?;
            let from_garment = transforms(&prim, time)?.to_world.inverse() * model.transforms.to_world;
            let own = vectors(&prim, names::POINTS, time)?.unwrap_or_default();
            let count = own.len();
            let at = |i: usize| {
                let point = fitted.points[model.sewing.points.get(i).copied().unwrap_or(i)];
                // A lone mesh is in its own space, and keeps its numbers.
                if model.is_sewn() { from_garment.transform_point3(point.as_dvec3()).as_vec3() } else { point }
            };
            let points: Vec<Vec3> = (next..next + count).map(at).collect();
            next += count;
            // Where it was fitted before.
            let made = vectors(&prim, names::FIT_FROM, time)?.filter(|made| made.len() == count).unwrap_or(own);
            self.moved(panel, &points, &made, &dependent_attributes(&prim)?).or_unreadable(panel)?;
            warnings.extend(motion(&prim, names::POINTS)?);
            warnings.extend(stale_skin(&prim, time)?);
        }
        Ok(warnings)
    }

    /// Authors other points of a mesh and those that it was made with, and blocks what is of its old points.
    fn moved(
        &mut self,
        prim: &sdf::Path,
        points: &[Vec3],
        made: &[Vec3],
        stale: &[(String, ValueTypeName)],
    ) -> openusd::Result<()> {
        PrimSpec::over(self.data, prim)?;
        let extent = Value::Vec3fVec(extent(points));
        let [points, made] = [points, made].map(|points| Value::Vec3fVec(bytemuck::cast_slice(points).to_vec()));
        self.at_all_times(prim, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, extent)?;
        self.at_all_times(prim, names::POINTS, ValueTypeName::POINT3F_ARRAY, points)?;
        self.at_all_times(prim, names::FIT_FROM, ValueTypeName::POINT3F_ARRAY, made)?;
        let path = prim.append_property(names::FIT_FROM)?;
        self.data.set_field(&path, names::INTERPOLATION, Value::Token(Token::from("vertex")));
        for (name, kind) in stale {
            self.at_all_times(prim, name, kind.clone(), Value::ValueBlock)?;
        }
        Ok(())
    }

    /// Authors a value without a time. Samples of a flattened stage would be stronger.
    fn at_all_times(&mut self, prim: &sdf::Path, name: &str, kind: ValueTypeName, value: Value) -> openusd::Result<()> {
        self.attribute(prim, name, kind, Variability::Varying, value)?;
        self.data.erase_field(&prim.append_property(name)?, FieldKey::TimeSamples.as_str());
        Ok(())
    }
}

/// The warning of points that move, if they do.
fn motion(prim: &Prim, name: &str) -> Result<Option<Warning>, Error> {
    let times = prim.attribute(name).time_sample_times().or_unreadable(prim.path())?.len();
    let place = format!("the motion of {}.{name} over {times} times", prim.path());
    let warning = || Warning::not_carried(place, "the fitted points have one time, and hide it");
    Ok((times > 1).then(warning))
}
