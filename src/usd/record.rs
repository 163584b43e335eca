//! A composed property, copied so that one layer can author it again.

use super::assets::{Anchor, resolved};
use openusd::sdf::{self, AbstractData, ChildrenKey, FieldKey, Path, TimeSampleMap, Value, ValueTypeName, Variability};
use openusd::usd::{Attribute, Prim, SpecSite, Stage, TimeCode};
use std::collections::BTreeSet;
use std::io;

/// Fields that are not metadata: a record holds them elsewhere.
const NOT_METADATA: &[FieldKey] = &[
    FieldKey::TypeName,
    FieldKey::Variability,
    FieldKey::Custom,
    FieldKey::Default,
    FieldKey::TimeSamples,
    FieldKey::ConnectionPaths,
    FieldKey::TargetPaths,
];

/// Words of text layers that OpenUSD takes for no name of metadata. The reader does, where a file is damaged.
const KEYWORDS: &[&str] = &[
    "add",
    "append",
    "attributes",
    "class",
    "config",
    "connect",
    "custom",
    "def",
    "default",
    "delete",
    "dictionary",
    "nameChildren",
    "None",
    "offset",
    "over",
    "prepend",
    "properties",
    "rel",
    "relationships",
    "reorder",
    "rootPrims",
    "scale",
    "timeSamples",
    "uniform",
    "variantSet",
    "varying",
];
/// Why no product has one.
pub const NO_SPLINE: &str = "its animation is a spline, and only values at times are copied";

/// A property as composed.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its name.
    pub name: String,
    /// Whether values may vary over time.
    pub variability: Variability,
    /// Whether no schema declares it.
    pub custom: bool,
    /// Metadata, sorted by key.
    pub metadata: Vec<(String, Value)>,
    /// Type and values, or targets.
    pub content: Content,
    /// Whether a spline animates it, which is not copied.
    pub has_spline: bool,
}

/// Type and values of an attribute, or targets of a relationship.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a model holds few, and nearly all are attributes")]
pub enum Content {
    /// An attribute.
    Attribute {
        /// The type as authored.
        type_name: ValueTypeName,
        /// The value without a time.
        default: Option<Value>,
        /// The values at times.
        samples: Option<TimeSampleMap>,
        /// Connected attributes.
        connections: Vec<Path>,
    },
    /// A relationship.
    Relationship {
        /// Paths of the targets.
        targets: Vec<Path>,
        /// The relationship of the model, where variants have its targets and products are to follow them.
        of_variant: Option<Path>,
    },
}

/// How much of an attribute is copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Type, metadata and values.
    Whole,
    /// Type and metadata.
    Declaration,
}

impl Record {
    /// Copies the property `name` of `prim`; none when no layer authors it.
    ///
    /// # Errors
    /// A field that cannot be read, a type that USD does not have.
    pub fn take(prim: &Prim, name: &str, depth: Depth) -> openusd::Result<Option<Self>> {
        match prim.prim_index().property_type(name)? {
            Some(sdf::SpecType::Attribute) => Self::take_attribute(&prim.attribute(name), depth).map(Some),
            Some(sdf::SpecType::Relationship) => {
                let relationship = prim.relationship(name);
                let variability = prim.stage().field(relationship.path(), FieldKey::Variability)?;
                Ok(Some(Self {
                    name: name.to_owned(),
                    variability: variability.unwrap_or_default(),
                    custom: relationship.is_custom()?,
                    metadata: metadata(prim.stage(), relationship.path(), &relationship.property_stack()?)?,
                    content: Content::Relationship { targets: relationship.targets()?, of_variant: None },
                    has_spline: false,
                }))
            }
            _ => Ok(None),
        }
    }

    fn take_attribute(attribute: &Attribute, depth: Depth) -> openusd::Result<Self> {
        let (stage, sites) = (attribute.stage(), attribute.property_stack()?);
        let (default, samples) = match depth {
            Depth::Declaration => (None, None),
            Depth::Whole => (default(attribute, &sites)?, samples(attribute, &sites)?),
        };
        Ok(Self {
            name: attribute.name().to_owned(),
            variability: attribute.variability()?.unwrap_or_default(),
            custom: attribute.is_custom()?,
            metadata: metadata(stage, attribute.path(), &sites)?,
            content: Content::Attribute {
                type_name: attribute
                    .type_name()?
                    .ok_or_else(|| openusd::Error::convert(io::Error::other("its type is not one of USD's")))?,
                default,
                samples,
                connections: attribute.connections()?,
            },
            has_spline: sites.iter().any(|site| states(stage, site, &["spline"])),
        })
    }

    /// The type of an attribute.
    pub fn type_name(&self) -> Option<&ValueTypeName> {
        match &self.content {
            Content::Attribute { type_name, .. } => Some(type_name),
            Content::Relationship { .. } => None,
        }
    }

    /// Metadata `key`.
    pub fn metadata(&self, key: &str) -> Option<&Value> {
        self.metadata.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }

    /// Whether it has a value at any time, a connection or a target.
    pub fn has_value(&self) -> bool {
        match &self.content {
            Content::Attribute { default, samples, connections, .. } => {
                default.as_ref().is_some_and(|v| !v.is_value_block()) || samples.is_some() || !connections.is_empty()
            }
            Content::Relationship { targets, .. } => !targets.is_empty(),
        }
    }

    /// Authors the property on the prim `owner` of `data`.
    ///
    /// # Errors
    /// A path or type that the layer does not admit.
    pub fn author(&self, data: &mut dyn AbstractData, owner: &Path, anchor: Anchor) -> openusd::Result<()> {
        let path = self.declare(data, owner)?;
        match &self.content {
            Content::Attribute { default, samples, connections, .. } => {
                if let Some(value) = default {
                    data.set_field(&path, FieldKey::Default.as_str(), anchor.restated(value.clone()));
                }
                if let Some(samples) = samples {
                    let samples = anchor.restated(Value::TimeSamples(samples.clone()));
                    data.set_field(&path, FieldKey::TimeSamples.as_str(), samples);
                }
                set_paths(data, &path, FieldKey::ConnectionPaths, connections);
            }
            Content::Relationship { targets, .. } => set_paths(data, &path, FieldKey::TargetPaths, targets),
        }
        Ok(())
    }

    /// As [`Record::author`], for a product in a layer over the stage. A material that a variant binds is that of the model, so that
    /// another variant still changes it: USD follows a target that is a relationship.
    ///
    /// # Errors
    /// A path or type that the layer does not admit.
    pub fn author_over(&self, data: &mut dyn AbstractData, owner: &Path, anchor: Anchor) -> openusd::Result<()> {
        match &self.content {
            Content::Relationship { of_variant: Some(model), .. } => {
                let path = self.declare(data, owner)?;
                set_paths(data, &path, FieldKey::TargetPaths, std::slice::from_ref(model));
                Ok(())
            }
            _ => self.author(data, owner, anchor),
        }
    }

    /// Authors type and metadata of the property, without a value.
    ///
    /// # Errors
    /// A path or type that the layer does not admit.
    pub fn declare(&self, data: &mut dyn AbstractData, owner: &Path) -> openusd::Result<Path> {
        let path = owner.append_property(self.name.as_str())?;
        match &self.content {
            Content::Attribute { type_name, .. } => {
                sdf::AttributeSpec::new(data, &path, type_name.clone(), self.variability, self.custom)?;
            }
            Content::Relationship { .. } => {
                sdf::RelationshipSpec::new(data, &path, self.variability, self.custom)?;
            }
        }
        for (key, value) in &self.metadata {
            data.set_field(&path, key, value.clone());
        }
        Ok(path)
    }
}

/// The composed metadata at `path`, sorted by key.
///
/// # Errors
/// A field that cannot be read.
pub fn metadata(stage: &Stage, path: &Path, sites: &[SpecSite]) -> openusd::Result<Vec<(String, Value)>> {
    let mut keys = BTreeSet::new();
    for site in sites {
        if let Some(layer) = stage.layer(&site.layer) {
            keys.extend(layer.data().list_fields(&site.path).unwrap_or_default());
        }
    }
    keys.retain(|key| !is_children(key) && !NOT_METADATA.iter().any(|k| k.as_str() == key));
    keys.retain(|key| key != "spline" && !KEYWORDS.contains(&key.as_str()));
    let mut fields = Vec::with_capacity(keys.len());
    for key in keys {
        if let Some(value) = stage.field::<Value>(path, &key)? {
            fields.push((key, value));
        }
    }
    Ok(fields)
}

/// Whether a layer states one of some fields of a property.
pub fn states(stage: &Stage, site: &SpecSite, keys: &[&str]) -> bool {
    stage.layer(&site.layer).is_some_and(|layer| keys.iter().any(|key| layer.data().has_field(&site.path, key)))
}

/// Whether a field lists the specs below one.
pub fn is_children(key: &str) -> bool {
    use ChildrenKey::{PrimChildren, PropertyChildren, VariantChildren, VariantSetChildren};
    [PrimChildren, PropertyChildren, VariantChildren, VariantSetChildren].iter().any(|k| k.as_str() == key)
}

/// The value without a time; a block is kept as such.
fn default(attribute: &Attribute, sites: &[SpecSite]) -> openusd::Result<Option<Value>> {
    let stage = attribute.stage();
    if !sites.iter().any(|site| states(stage, site, &["default"])) {
        return Ok(None);
    }
    Ok(Some(attribute.get::<Value>()?.map_or(Value::ValueBlock, |v| resolved(v, stage, sites))))
}

/// The time samples; those of value clips and of asset paths are resolved one by one.
fn samples(attribute: &Attribute, sites: &[SpecSite]) -> openusd::Result<Option<TimeSampleMap>> {
    let raw = attribute.time_samples()?;
    let resolved_one_by_one = match &raw {
        Some(samples) => samples.iter().any(|(_, v)| v.is_asset_valued()),
        None => attribute.num_time_samples()? > 0,
    };
    if !resolved_one_by_one {
        return Ok(raw);
    }
    let query = attribute.query();
    let mut samples = TimeSampleMap::new();
    for time in attribute.time_sample_times()? {
        let value = query.get_at::<Value>(TimeCode::new(time))?.unwrap_or(Value::ValueBlock);
        samples.push((time, resolved(value, attribute.stage(), sites)));
    }
    Ok(Some(samples))
}

fn set_paths(data: &mut dyn AbstractData, path: &Path, key: FieldKey, paths: &[Path]) {
    if !paths.is_empty() {
        data.set_field(path, key.as_str(), sdf::PathListOp::explicit(paths.iter().cloned()).into());
    }
}
