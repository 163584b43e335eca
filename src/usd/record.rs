//! A composed property in the form in which one layer can state it, so that it can be given back as it was.

use super::assets::{Place, settle};
use openusd::sdf::{self, AbstractData, ChildrenKey, FieldKey, Path, TimeSampleMap, Value, ValueTypeName, Variability};
use openusd::usd::{Attribute, Prim, SpecSite, Stage, TimeCode};
use std::collections::BTreeSet;

/// Fields that are not metadata: what a record holds elsewhere, and what says how a property composes.
const NOT_METADATA: &[FieldKey] = &[
    FieldKey::TypeName,
    FieldKey::Variability,
    FieldKey::Custom,
    FieldKey::Default,
    FieldKey::TimeSamples,
    FieldKey::ConnectionPaths,
    FieldKey::TargetPaths,
];

/// A property as composed.
#[derive(Clone, Debug)]
pub struct Record {
    /// Its name.
    pub name: String,
    /// Whether it is uniform or varying.
    pub variability: Variability,
    /// Whether no schema declares it.
    pub custom: bool,
    /// Metadata in the order of its names.
    pub metadata: Vec<(String, Value)>,
    /// What it holds.
    pub content: Content,
}

/// What a property holds.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a model holds few, and nearly all are attributes")]
pub enum Content {
    /// An attribute.
    Attribute {
        /// The type as it was spelled.
        type_name: ValueTypeName,
        /// The value that does not vary over time.
        default: Option<Value>,
        /// The values at times.
        samples: Option<TimeSampleMap>,
        /// The attributes that it is connected to.
        connections: Vec<Path>,
    },
    /// A relationship.
    Relationship {
        /// What it points at.
        targets: Vec<Path>,
    },
}

/// How much of an attribute is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Values too.
    Whole,
    /// Type and metadata alone.
    Declaration,
}

impl Record {
    /// Takes the property `name` of `prim`; none when no layer states it.
    ///
    /// # Errors
    /// A field that the file format's reader cannot read.
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
                    content: Content::Relationship { targets: relationship.targets()? },
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
                type_name: attribute.type_name()?.unwrap_or(ValueTypeName::TOKEN),
                default,
                samples,
                connections: attribute.connections()?,
            },
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

    /// Whether it holds a value, at any time.
    pub fn has_value(&self) -> bool {
        match &self.content {
            Content::Attribute { default, samples, connections, .. } => {
                default.as_ref().is_some_and(|v| !v.is_value_block()) || samples.is_some() || !connections.is_empty()
            }
            Content::Relationship { targets } => !targets.is_empty(),
        }
    }

    /// States the property on the prim `owner` of `data`, replacing what is there.
    ///
    /// # Errors
    /// A path or type that the layer does not admit.
    pub fn state(&self, data: &mut dyn AbstractData, owner: &Path, place: Place) -> openusd::Result<()> {
        let path = self.declare(data, owner)?;
        match &self.content {
            Content::Attribute { default, samples, connections, .. } => {
                if let Some(value) = default {
                    data.set_field(&path, FieldKey::Default.as_str(), place.anchor(value.clone()));
                }
                if let Some(samples) = samples {
                    let samples = place.anchor(Value::TimeSamples(samples.clone()));
                    data.set_field(&path, FieldKey::TimeSamples.as_str(), samples);
                }
                set_paths(data, &path, FieldKey::ConnectionPaths, connections);
            }
            Content::Relationship { targets } => set_paths(data, &path, FieldKey::TargetPaths, targets),
        }
        Ok(())
    }

    /// States type and metadata of the property, without a value.
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

/// The composed metadata at `path`, in the order of its names.
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
    let mut fields = Vec::with_capacity(keys.len());
    for key in keys {
        if let Some(value) = stage.field::<Value>(path, &key)? {
            fields.push((key, value));
        }
    }
    Ok(fields)
}

/// Whether a field lists the specs below one.
pub fn is_children(key: &str) -> bool {
    use ChildrenKey::{PrimChildren, PropertyChildren, VariantChildren, VariantSetChildren};
    [PrimChildren, PropertyChildren, VariantChildren, VariantSetChildren].iter().any(|k| k.as_str() == key)
}

/// The value that does not vary over time; a block is kept as such.
fn default(attribute: &Attribute, sites: &[SpecSite]) -> openusd::Result<Option<Value>> {
    let stage = attribute.stage();
    let stated = sites.iter().any(|site| {
        stage.layer(&site.layer).is_some_and(|l| l.data().has_field(&site.path, FieldKey::Default.as_str()))
    });
    if !stated {
        return Ok(None);
    }
    Ok(Some(attribute.get::<Value>()?.map_or(Value::ValueBlock, |v| settle(stage, sites, v))))
}

/// The samples that answer for an attribute; those of value clips are read one by one.
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
        samples.push((time, settle(attribute.stage(), sites, value)));
    }
    Ok(Some(samples))
}

fn set_paths(data: &mut dyn AbstractData, path: &Path, key: FieldKey, paths: &[Path]) {
    if !paths.is_empty() {
        data.set_field(path, key.as_str(), sdf::PathListOp::explicit(paths.iter().cloned()).into());
    }
}
