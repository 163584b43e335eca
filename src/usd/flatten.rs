//! The whole stage as one layer.

use super::UsdError;
use super::assets::{Place, settle};
use super::model::Model;
use super::open::open_stage;
use crate::error::{Warning, Warnings};
use openusd::sdf::{AbstractData, ChildrenKey, Data, Path, Value};
use openusd::usd::Stage;

/// The stage of `model` as one layer that stands alone, without the prims `left_out`.
///
/// # Errors
/// A stage that cannot be read any more.
pub fn flattened(model: &Model, left_out: &[Path], place: Place, warnings: &mut Warnings) -> Result<Data, UsdError> {
    let fault = |e: &dyn std::fmt::Display| UsdError::new(format!("{} cannot be flattened: {e}", model.file.display()));
    let stage = open_stage(&model.file)?;
    let layer = stage.flatten().map_err(|e| fault(&e))?;
    let mut data = Data::new();
    for path in layer.data().spec_paths() {
        if left_out.iter().any(|p| path.has_prefix(p)) {
            continue;
        }
        let Some(kind) = layer.data().spec_type(&path) else { continue };
        data.create_spec(path.clone(), kind);
        for key in layer.data().list_fields(&path).unwrap_or_default() {
            let value = layer.data().get_field(&path, &key).map_err(|e| fault(&e))?.into_owned();
            let value = if is_asset(&value) { place.anchor(found(&stage, &path, value, warnings)) } else { value };
            AbstractData::set_field(&mut data, &path, &key, value);
        }
    }
    left_out.iter().for_each(|path| forget(&mut data, path));
    Ok(data)
}

fn is_asset(value: &Value) -> bool {
    match value {
        Value::TimeSamples(samples) => samples.iter().any(|(_, v)| v.is_asset_valued()),
        Value::Dictionary(entries) => entries.values().any(is_asset),
        other => other.is_asset_valued(),
    }
}

/// The value with its asset paths resolved as far as can be; what cannot be found is reported.
fn found(stage: &Stage, path: &Path, value: Value, warnings: &mut Warnings) -> Value {
    let sites = match path.is_property_path() {
        true => stage.attribute(path).map_or_else(|_| Vec::new(), |a| a.property_stack().unwrap_or_default()),
        false => Vec::new(),
    };
    settle(stage, &sites, value).map_asset_paths(&mut |asset| {
        if asset.resolved_path().is_none() && !asset.is_empty() {
            warnings.push(Warning::NotCarried {
                what: format!("the file @{}@ of {path}", asset.asset_path()),
                why: "it was not found; its path stays as it is".into(),
            });
        }
        asset
    })
}

/// Takes `path` from its parent's list of children.
fn forget(data: &mut Data, path: &Path) {
    let (Some(parent), Some(name)) = (path.parent(), path.name()) else { return };
    let key = ChildrenKey::PrimChildren.as_str();
    if let Ok(Some(Value::TokenVec(children))) = data.try_field(&parent, key).map(|v| v.map(|v| v.into_owned())) {
        let children = children.into_iter().filter(|c| c.as_str() != name).collect();
        AbstractData::set_field(data, &parent, key, Value::TokenVec(children));
    }
}
