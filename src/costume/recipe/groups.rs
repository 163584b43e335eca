//! The groups of options that a recipe has. A new operator is a row here.

use super::LodOptions;
use crate::cloth::{ClothOptions, FabricOptions};
use crate::fit::BodyOptions;
use crate::trim::TrimOptions;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use tailor::render::{FoldOptions, OperatorOptions, RenderOptions, SeamOptions};
use tailor::sim::SimOptions;
use tailor_mesh::options::{Group, Key, OptionGroup};

/// Defines [`Recipe`], the form of a `.tailor` file, and the lists of groups. The first groups are there once. The others
/// have instances by name: operators in the default order of execution, and what is not an operator.
macro_rules! groups {
    (
        once { $($(#[doc = $about_once:literal])+ $once:ident: $Once:ty,)+ }
        operators { $($(#[doc = $about_operator:literal])+ $operator:ident: $Operator:ty,)+ }
        named { $($(#[doc = $about_named:literal])+ $named:ident: $Named:ty,)+ }
    ) => {
        /// All options of a build.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Recipe {
            $($(#[doc = $about_once])+ pub $once: $Once,)+
            $(
                $(#[doc = $about_operator])+
                #[serde(skip_serializing_if = "BTreeMap::is_empty")]
                pub $operator: BTreeMap<String, $Operator>,
            )+
            $(
                $(#[doc = $about_named])+
                #[serde(skip_serializing_if = "BTreeMap::is_empty")]
                pub $named: BTreeMap<String, $Named>,
            )+
        }

        /// The allowed keys of a `.tailor` file and their types.
        #[derive(Default, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub(super) struct Form {
            source: Option<String>,
            prim: Option<String>,
            $($once: $Once,)+
            $($operator: Unique<$Operator>,)+
            $($named: Unique<$Named>,)+
        }

        /// Groups that a recipe has once, in schema order.
        pub const ONCE: &[Group] = &[$(<$Once>::GROUP),+];
        /// Groups with instances that are operators, in the default order of execution.
        pub const OPERATORS: &[Group] = &[$(<$Operator>::GROUP),+];
        /// Other groups with instances.
        const OTHERS: &[Group] = &[$(<$Named>::GROUP),+];

        impl Recipe {
            /// The options of all operators by name, in the default order of execution.
            pub fn operators(&self) -> Vec<(&str, &dyn OperatorOptions)> {
                let mut all: Vec<(&str, &dyn OperatorOptions)> = Vec::new();
                $(all.extend(self.$operator.iter().map(|(name, options)| (name.as_str(), options as _)));)+
                all
            }

            /// The options of each group, with the start of their keys, such as `sim` or `seam.placket`. Operators that are
            /// left out are not among them.
            pub(super) fn used(&self) -> Vec<(String, &dyn OptionGroup)> {
                let mut all: Vec<(String, &dyn OptionGroup)> = vec![$((<$Once>::GROUP.name.into(), &self.$once)),+];
                $(all.extend(self.$named.iter().map(|(name, options)| (instance(&<$Named>::GROUP, name), options as _)));)+
                let operators = self.operators().into_iter().filter(|(_, options)| options.is_enabled());
                all.extend(operators.map(|(name, options)| (options.full_name(name), options as &dyn OptionGroup)));
                all
            }

            /// Replaces automatic lengths (0) by multiples of the garment's mean edge length. \[mesh units\]
            pub(super) fn resolve_lengths(&mut self, mean_edge: f32) {
                self.sim.resolve_targets(mean_edge);
                $(self.$operator.values_mut().for_each(|options| options.resolve_lengths(mean_edge));)+
            }

            /// The number of instances in each group that has them.
            pub(super) fn counts(&self) -> Vec<(&'static str, usize)> {
                vec![$((<$Operator>::GROUP.name, self.$operator.len()),)+ $((<$Named>::GROUP.name, self.$named.len()),)+]
            }
        }
    };
}

groups! {
    once {
        /// Options of the simulation mesh.
        sim: SimOptions,
        /// Options of the render mesh.
        render: RenderOptions,
        /// Options of the cloth.
        cloth: ClothOptions,
        /// Levels of detail.
        lod: LodOptions,
        /// The body that the garment fits.
        fit: BodyOptions,
    }
    operators {
        /// Options of each fold, by name.
        fold: FoldOptions,
        /// Options of each seam, by name.
        seam: SeamOptions,
    }
    named {
        /// Options of each fabric, by name.
        fabric: FabricOptions,
        /// Options of each trim, by name.
        trim: TrimOptions,
    }
}

/// Groups with instances.
pub fn named() -> impl Iterator<Item = &'static Group> {
    OPERATORS.iter().chain(OTHERS)
}

/// All groups, in schema order.
pub fn all() -> impl Iterator<Item = &'static Group> {
    ONCE.iter().chain(OTHERS).chain(OPERATORS)
}

/// The group called `name` whose options have instances.
pub fn group_with_instances(name: &str) -> Option<&'static Group> {
    named().find(|group| group.name == name)
}

/// The start of the keys of an instance, such as `seam.placket`.
fn instance(group: &Group, name: &str) -> String {
    format!("{}.{name}", group.name)
}

/// The key of an option with a placeholder for the name of its instance, such as `seam.<name>.width`.
pub fn pattern(group: &Group, key: &Key) -> String {
    match group_with_instances(group.name) {
        Some(group) => format!("{}.{}", instance(group, "<name>"), key.key),
        None => format!("{}.{}", group.name, key.key),
    }
}

/// Splits the rest of a key, after its group, into the name of an instance and a field. The name is empty if it is missing.
pub fn split<'a>(group: &str, rest: &'a str) -> Option<(&'a str, &'a str)> {
    group_with_instances(group)?;
    Some(rest.rsplit_once('.').unwrap_or(("", rest)))
}

/// The group and declaration of an option by its key, such as `sim.maxEdgeLength` or `seam.placket.width`.
pub fn find(key: &str) -> Option<(&'static Group, &'static Key)> {
    let (name, rest) = key.split_once('.')?;
    let field = split(name, rest).map_or(rest, |(_, field)| field);
    let group = all().find(|group| group.name == name)?;
    Some((group, group.key(field)?))
}

/// Options by name. A name that is given twice is an error, as the first options under it would be lost.
struct Unique<T>(PhantomData<T>);

impl<T> Default for Unique<T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Unique<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Self::default())
    }
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for Unique<T> {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self, A::Error> {
        let mut names = std::collections::BTreeSet::new();
        while let Some(name) = map.next_key::<String>()? {
            if names.contains(&name) {
                return Err(A::Error::custom(format!("the name `{name}` is given twice")));
            }
            names.insert(name);
            map.next_value::<T>()?;
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_and_split() {
        assert_eq!(split("seam", "placket.width"), Some(("placket", "width")));
        assert_eq!(split("sim", "uvSet"), None);
        assert!(find("seam.left:hip.width").is_some_and(|(group, key)| (group.name, key.key) == ("seam", "width")));
        assert!(find("sim.uvSet").is_some() && find("sim.a.uvSet").is_none() && find("seam.uvSet").is_none());
    }

    #[test]
    fn every_option_is_one_sentence_with_a_default() {
        for group in all() {
            let defaults = (group.defaults)();
            assert_eq!(group.keys.len(), defaults.as_object().map_or(0, serde_json::Map::len), "{}", group.name);
            for key in group.keys {
                assert!(defaults.get(key.key).is_some(), "{}.{}", group.name, key.key);
                let text = key.meaning;
                let is_sentence = text.starts_with(char::is_uppercase) && !text.contains(". ") && !text.ends_with('.');
                assert!(is_sentence, "usdGenSchema keeps the first sentence: {text}");
            }
        }
    }
}
