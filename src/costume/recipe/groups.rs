//! The groups of options that the whole recipe has: those of the two meshes and of each thing that is made beside them.

use super::LodOptions;
use crate::cloth::{ClothOptions, FabricOptions};
use crate::fit::BodyOptions;
use crate::stitch::StitchOptions;
use crate::trim::TrimOptions;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use tailor::recipe::{MeshRecipe, full_name};
use tailor::render::{FoldOptions, OperatorOptions, RenderOptions, SeamOptions};
use tailor::sim::SimOptions;
use tailor_mesh::options::{Group, Key};

/// Defines [`Recipe`], and the form of a `.tailor` file.
macro_rules! groups {
    (
        once { $($(#[doc = $about_once:literal])+ $once:ident: $Once:ty,)+ }
        operators { $($(#[doc = $about_operator:literal])+ $operator:ident: $Operator:ty,)+ }
        named { $($(#[doc = $about_named:literal])+ $named:ident: $Named:ty,)+ }
    ) => {
        tailor::recipe::recipe! {
            /// All options of a build.
            Recipe
            once { $($(#[doc = $about_once])+ $once: $Once,)+ }
            operators { $($(#[doc = $about_operator])+ $operator: $Operator,)+ }
            named { $($(#[doc = $about_named])+ $named: $Named,)+ }
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
        /// Options of each stitch, by name.
        stitch: StitchOptions,
        /// Options of each trim, by name.
        trim: TrimOptions,
    }
}

impl Recipe {
    /// The options of the two meshes.
    pub fn meshes(&self) -> MeshRecipe {
        let Self { sim, render, fold, seam, .. } = self;
        MeshRecipe { sim: sim.clone(), render: render.clone(), fold: fold.clone(), seam: seam.clone() }
    }

    /// The recipe of the simulation mesh alone: the render mesh is the garment's own mesh, and trims do not ride on what no shot moves.
    #[must_use]
    pub fn of_sim(self) -> Self {
        let render = RenderOptions { level: 0, ..RenderOptions::default() };
        Self {
            render,
            fold: BTreeMap::new(),
            seam: BTreeMap::new(),
            stitch: BTreeMap::new(),
            trim: BTreeMap::new(),
            ..self
        }
    }
}

/// Groups with instances.
pub fn named() -> impl Iterator<Item = &'static Group> {
    Recipe::OPERATORS.iter().chain(Recipe::OTHERS)
}

/// All groups, in schema order.
pub fn all() -> impl Iterator<Item = &'static Group> {
    Recipe::ONCE.iter().chain(Recipe::OTHERS).chain(Recipe::OPERATORS)
}

/// The group called `name` whose options have instances.
pub fn group_with_instances(name: &str) -> Option<&'static Group> {
    named().find(|group| group.name == name)
}

/// The key of an option with a placeholder for the name of its instance, such as `seam.<name>.width`.
pub fn pattern(group: &Group, key: &Key) -> String {
    match group_with_instances(group.name) {
        Some(group) => format!("{}.{}", full_name(group, "<name>"), key.key),
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
