//! A recipe as opinions on the model, in a layer over the stage.

use super::layer::{LayerContext, overlay};
use super::product::fault;
use super::save::{Format, OutputFile, Unnamed, check_whole, text_of};
use crate::codes;
use crate::read::{Files, Model, ReadOptions, Selection, Source, select};
use crate::values::decimal;
use crate::{names, on_large_stack};
use openusd::sdf::{self, AbstractData, ChildrenKey, Data, FieldKey, LayerOffset, SpecType};
use openusd::sdf::{Value, ValueTypeName, Variability};
use openusd::tf::Token;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use tailor_mesh::error::Error;

/// Key in `customLayerData` by which layers of this program are known.
const RECIPE: &str = "recipe";

/// How names of primvars begin that hold the painted weights of a recipe: those of a garment begin otherwise.
pub const PAINTED: &str = "tailor:painted_";

/// The value of an option as a property.
#[derive(Clone, Debug, PartialEq)]
pub enum OptionValue {
    /// `bool`.
    Bool(bool),
    /// `float`.
    Float(f32),
    /// `int`.
    Int(i32),
    /// `token`.
    Token(String),
    /// `token[]`.
    Tokens(Vec<String>),
    /// `string`.
    Text(String),
    /// `asset`.
    Asset(String),
    /// A relationship to subsets of the model.
    Subsets(Vec<String>),
    /// `float[]`, a value for each point.
    Weights(Vec<f32>),
}

/// Opinions on the model.
#[derive(Clone, Debug, Default)]
pub struct RecipeOpinions {
    /// Names and values of properties, such as `tailor:render:level`.
    pub properties: Vec<(String, OptionValue)>,
    /// API schemas to apply, such as `TailorSeamAPI:side`.
    pub schemas: Vec<String>,
    /// Variants to select.
    pub variants: Vec<Selection>,
}

/// The opinions of an earlier recipe in an existing layer.
pub struct EarlierRecipe {
    /// True for properties that are options.
    pub is_option: fn(&str) -> bool,
    /// True for API schemas of options.
    pub is_schema: fn(&str) -> bool,
}

/// The text of a new layer with the opinions, as [`write_recipe`] writes it to `out`.
///
/// # Errors
/// A folder that does not exist; names that USD does not admit.
pub fn recipe_text(source: &Source, opinions: &RecipeOpinions, out: &Path) -> Result<String, Error> {
    let file = OutputFile::find(out, |file| source.model.uses(file), true)?;
    on_large_stack(|| {
        let data = new_layer(&source.model, opinions, &file)?;
        Ok(String::from_utf8_lossy(&text_of(&with_short_floats(data))?).into_owned())
    })
}

/// Writes the opinions to the layer `out`: a new one that sublayers the garment, or an existing one, which keeps
/// everything else. `verify` may refuse the finished layer, which it gets under a temporary name in the same folder; then
/// nothing is written.
///
/// # Errors
/// A layer of the garment itself; an existing layer that cannot be written back as it was; a refusal of `verify`.
pub fn write_recipe(
    source: &Source,
    opinions: &RecipeOpinions,
    out: &Path,
    force: bool,
    replaced: &EarlierRecipe,
    verify: impl FnOnce(&Path) -> Result<(), Error> + Send,
) -> Result<(), Error> {
    let file = OutputFile::find(out, |file| source.model.uses(file), force)?;
    if file.format == Format::Usdz {
        return Err(Error::usd(format!("{} is a package, which holds no recipe", out.display()))
            .code(codes::OUTPUT_PATH)
            .remedy("save to a .usda, .usdc or .usd file"));
    }
    on_large_stack(|| {
        let data = match file.exists() {
            false => new_layer(&source.model, opinions, &file)?,
            true => edited(&source.model, opinions, &file, replaced)?,
        };
        let written = if file.format == Format::Usda { with_short_floats(data.clone()) } else { data.clone() };
        let Unnamed { temporary, .. } = file.unnamed(written)?;
        check_whole(&data, temporary.path())?;
        verify(temporary.path())?;
        file.keep(temporary)
    })
}

/// The garment's file, if a layer is a new one of [`write_recipe`] and still holds nothing but opinions.
pub fn garment_below(layer: &Path) -> Option<PathBuf> {
    let path = layer.to_str()?.to_owned();
    let below = on_large_stack(|| {
        Ok(sdf::Layer::open_with(Files::default(), path).ok().and_then(|layer| only_sublayer(layer.data())))
    });
    Some(layer.parent()?.join(below.ok()??))
}

/// The only sublayer of a marked layer in which all prims are overs.
fn only_sublayer(data: &dyn AbstractData) -> Option<String> {
    let root = sdf::Path::abs_root();
    let mark = data.try_field(&root, FieldKey::CustomLayerData.as_str()).ok()??;
    let Value::Dictionary(mark) = mark.as_ref() else { return None };
    let Some(Value::Dictionary(mark)) = mark.get(names::PRODUCT_SPACE) else { return None };
    let Some(Value::Bool(true)) = mark.get(RECIPE) else { return None };
    let value = data.try_field(&root, FieldKey::SubLayers.as_str()).ok()??;
    let Value::StringVec(sublayers) = value.as_ref() else { return None };
    let defines = |path: &sdf::Path| {
        let specifier = data.try_field(path, FieldKey::Specifier.as_str()).ok().flatten();
        specifier.is_some_and(|specifier| *specifier != Value::Specifier(sdf::Specifier::Over))
    };
    let is_over = !data.spec_paths().iter().any(defines);
    match sublayers.as_slice() {
        [one] if is_over => Some(one.clone()),
        _ => None,
    }
}

/// The variants that a layer selects.
pub fn selections(layer: &Path) -> Vec<Selection> {
    let Some(path) = layer.to_str().map(str::to_owned) else { return Vec::new() };
    on_large_stack(|| {
        Ok(sdf::Layer::open_with(Files::default(), path).map(|layer| selected(layer.data())).unwrap_or_default())
    })
    .unwrap_or_default()
}

fn selected(data: &dyn AbstractData) -> Vec<Selection> {
    let mut found = Vec::new();
    for path in data.spec_paths() {
        let Ok(Some(value)) = data.try_field(&path, FieldKey::VariantSelection.as_str()) else { continue };
        let Value::VariantSelectionMap(all) = value.as_ref() else { continue };
        let prim = path.as_str();
        found.extend(all.iter().map(|(set, choice)| Selection {
            prim: prim.into(),
            set: set.clone(),
            choice: choice.clone(),
        }));
    }
    found.sort();
    found
}

/// A layer over the garment, without opinions.
fn over_garment(model: &Model, file: &OutputFile) -> Result<Data, Error> {
    overlay(model, LayerContext { flatten: false, anchor: file.anchor(), sublayer: None })
}

fn new_layer(model: &Model, opinions: &RecipeOpinions, file: &OutputFile) -> Result<Data, Error> {
    let mut data = over_garment(model, file)?;
    let mark = Value::Dictionary(HashMap::from([(RECIPE.to_owned(), Value::Bool(true))]));
    let mark = Value::Dictionary(HashMap::from([(names::PRODUCT_SPACE.to_owned(), mark)]));
    AbstractData::set_field(&mut data, &sdf::Path::abs_root(), FieldKey::CustomLayerData.as_str(), mark);
    author(&mut data, model, opinions).map_err(fault)?;
    Ok(data)
}

/// An existing layer with the opinions in place of the earlier ones.
fn edited(
    model: &Model,
    opinions: &RecipeOpinions,
    file: &OutputFile,
    replaced: &EarlierRecipe,
) -> Result<Data, Error> {
    let path = file.path().to_string_lossy();
    let mut layer = sdf::Layer::open_with(Files::default(), path.as_ref()).map_err(|e| {
        Error::usd(format!("{path} cannot be read as a USD layer: {e}"))
            .code(codes::NOT_WRITTEN_BACK)
            .remedy("save to a new file")
    })?;
    if let Some(what) = cannot_be_rewritten(layer.data()) {
        return Err(Error::usd(format!("{path} holds {what}, which cannot be written back unchanged"))
            .code(codes::NOT_WRITTEN_BACK)
            .remedy("save to a new file, and sublayer it there"));
    }
    let earlier = earlier(layer.data(), &model.path, replaced.is_option);
    layer.edit(|edit| earlier.iter().try_for_each(|property| edit.remove_spec(property).map(drop))).map_err(fault)?;
    let mut data = Data::from_abstract(layer.data()).map_err(fault)?;
    complete_specifiers(&mut data);
    keep_schemas(&mut data, &model.path, |schema| !(replaced.is_schema)(schema));
    if !is_over(model, file) {
        append_sublayer(&mut data, model, file)?;
    }
    author(&mut data, model, opinions).map_err(fault)?;
    Ok(data)
}

/// Properties of the model in a layer that hold options.
fn earlier(data: &dyn AbstractData, model: &sdf::Path, is_option: fn(&str) -> bool) -> Vec<sdf::Path> {
    let Ok(Some(names)) = data.try_field(model, ChildrenKey::PropertyChildren.as_str()) else { return Vec::new() };
    let Value::TokenVec(names) = names.as_ref() else { return Vec::new() };
    let options = names.iter().filter(|name| is_option(name.as_str()));
    options.filter_map(|name| model.append_property(name.as_str()).ok()).collect()
}

/// The content that the USD library is known to write wrongly.
fn cannot_be_rewritten(data: &dyn AbstractData) -> Option<String> {
    data.spec_paths().into_iter().find_map(|path| {
        let has = |key: FieldKey| data.has_field(&path, key.as_str());
        let is_uniform = has(FieldKey::Variability);
        let nested = path.as_str().matches('{').count() > 1;
        let what = match () {
            () if has(FieldKey::InheritPaths) => "an inherit arc",
            () if has(FieldKey::ConnectionPaths) && is_uniform => "a connected uniform attribute",
            () if nested => "a variant set inside a variant",
            () => return None,
        };
        Some(format!("{what} at {path}"))
    })
}

/// The crate reader leaves out the specifier of prims that are only opinions.
fn complete_specifiers(data: &mut Data) {
    let is_bare = |data: &Data, path: &sdf::Path| {
        data.spec_type(path) == Some(SpecType::Prim) && !data.has_field(path, FieldKey::Specifier.as_str())
    };
    let bare: Vec<sdf::Path> = data.spec_paths().into_iter().filter(|path| is_bare(data, path)).collect();
    for path in bare {
        let over = Value::Specifier(sdf::Specifier::Over);
        AbstractData::set_field(data, &path, FieldKey::Specifier.as_str(), over);
    }
}

fn applied(data: &Data, prim: &sdf::Path) -> sdf::TokenListOp {
    match data.try_field(prim, FieldKey::ApiSchemas.as_str()) {
        Ok(Some(value)) => match value.as_ref() {
            Value::TokenListOp(list) => list.clone(),
            _ => sdf::TokenListOp::default(),
        },
        _ => sdf::TokenListOp::default(),
    }
}

fn keep_schemas(data: &mut Data, prim: &sdf::Path, keeps: impl Fn(&str) -> bool) {
    let mut list = applied(data, prim);
    let items = [&mut list.explicit_items, &mut list.added_items, &mut list.prepended_items, &mut list.appended_items];
    items.into_iter().for_each(|items| items.retain(|schema| keeps(schema.as_str())));
    if data.has_field(prim, FieldKey::ApiSchemas.as_str()) {
        AbstractData::set_field(data, prim, FieldKey::ApiSchemas.as_str(), list.into());
    }
}

/// True if the stage of an existing layer has the garment's file among its layers.
fn is_over(model: &Model, file: &OutputFile) -> bool {
    let options = ReadOptions { prim: Some(model.path.as_str().to_owned()), ..ReadOptions::default() };
    let Ok(garment) = model.origin.file.canonicalize() else { return false };
    let is_garment = |layer: &PathBuf| layer.canonicalize().is_ok_and(|layer| layer == garment);
    Source::open(file.path(), &options).is_ok_and(|stage| stage.model.layers.iter().any(is_garment))
}

/// Adds the garment as the weakest sublayer.
fn append_sublayer(data: &mut Data, model: &Model, file: &OutputFile) -> Result<(), Error> {
    let root = sdf::Path::abs_root();
    let field = |data: &Data, key: FieldKey| data.try_field(&root, key.as_str()).ok().flatten().map(Cow::into_owned);
    let sublayers_of =
        |data: &Data| field(data, FieldKey::SubLayers).and_then(Value::try_as_string_vec).unwrap_or_default();
    let offsets = field(data, FieldKey::SubLayerOffsets).and_then(Value::try_as_layer_offset_vec);
    let mut offsets = offsets.unwrap_or_default();
    let own = sublayers_of(data);
    offsets.resize(own.len(), LayerOffset::IDENTITY);
    let sublayers = [own, sublayers_of(&over_garment(model, file)?)].concat();
    offsets.resize(sublayers.len(), LayerOffset::IDENTITY);
    AbstractData::set_field(data, &root, FieldKey::SubLayers.as_str(), Value::StringVec(sublayers));
    AbstractData::set_field(data, &root, FieldKey::SubLayerOffsets.as_str(), Value::LayerOffsetVec(offsets));
    Ok(())
}

fn author(data: &mut Data, model: &Model, opinions: &RecipeOpinions) -> openusd::Result<()> {
    select(data, &opinions.variants)?;
    sdf::PrimSpec::over(data, &model.path)?;
    let mut list = applied(data, &model.path);
    let ours = opinions.schemas.iter().map(|schema| Token::from(schema.as_str()));
    if list.explicit {
        list.explicit_items.extend(ours);
    } else {
        list.prepended_items.extend(ours);
    }
    if !opinions.schemas.is_empty() {
        AbstractData::set_field(data, &model.path, FieldKey::ApiSchemas.as_str(), list.into());
    }
    for (name, value) in &opinions.properties {
        property(data, &model.path, name, value)?;
    }
    Ok(())
}

fn property(data: &mut Data, prim: &sdf::Path, name: &str, value: &OptionValue) -> openusd::Result<()> {
    let path = prim.append_property(name)?;
    let are_weights = matches!(value, OptionValue::Weights(_));
    let variability = if are_weights { Variability::Varying } else { Variability::Uniform };
    let (type_name, value) = match value {
        OptionValue::Weights(v) => (ValueTypeName::FLOAT_ARRAY, Value::FloatVec(v.clone())),
        OptionValue::Bool(v) => (ValueTypeName::BOOL, Value::Bool(*v)),
        OptionValue::Float(v) => (ValueTypeName::FLOAT, Value::Float(*v)),
        OptionValue::Int(v) => (ValueTypeName::INT, Value::Int(*v)),
        OptionValue::Token(v) => (ValueTypeName::TOKEN, Value::Token(Token::from(v.as_str()))),
        OptionValue::Text(v) => (ValueTypeName::STRING, Value::String(v.clone())),
        OptionValue::Asset(v) => (ValueTypeName::ASSET, Value::AssetPath(sdf::AssetPath::new(v.as_str()))),
        OptionValue::Tokens(v) => {
            let tokens = v.iter().map(|v| Token::from(v.as_str())).collect();
            (ValueTypeName::TOKEN_ARRAY, Value::TokenVec(tokens))
        }
        OptionValue::Subsets(names) => {
            let targets: Result<Vec<_>, _> = names.iter().map(|name| prim.append_path(name.as_str())).collect();
            let targets = Value::PathListOp(sdf::PathListOp::explicit(targets?));
            sdf::RelationshipSpec::new(data, &path, Variability::Uniform, false)?;
            AbstractData::set_field(data, &path, FieldKey::TargetPaths.as_str(), targets);
            return Ok(());
        }
    };
    sdf::AttributeSpec::new(data, &path, type_name, variability, false)?;
    if are_weights {
        AbstractData::set_field(data, &path, names::INTERPOLATION, Value::Token(Token::from("vertex")));
    }
    AbstractData::set_field(data, &path, FieldKey::Default.as_str(), value);
    Ok(())
}

/// Floats as the doubles of their shortest decimals, which is how the text writer prints them. They read back the same.
fn with_short_floats(mut data: Data) -> Data {
    let key = FieldKey::Default.as_str();
    for path in data.spec_paths() {
        let Ok(Some(value)) = data.try_field(&path, key) else { continue };
        if let Value::Float(float) = *value.as_ref() {
            AbstractData::set_field(&mut data, &path, key, Value::Double(decimal(float)));
        }
    }
    data
}
