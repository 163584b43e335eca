//! Recipes as lists of groups of options.

use crate::render::{FoldOptions, OperatorOptions, RenderOptions, SeamOptions};
use crate::sim::SimOptions;
use std::collections::BTreeMap;
use tailor_mesh::error::Error;
use tailor_mesh::options::Group;

/// Highest number of operators, and of fabrics. Each operator is a pass over the mesh, and garments have dozens.
const MAX_NAMES: usize = 1000;

/// Defines a recipe by its groups of options, and the lists of these. The first groups are there once, `sim` and `render` among
/// them. The others have instances by name: operators in the default order of execution, and what is not an operator.
#[doc(hidden)]
#[macro_export]
macro_rules! __recipe {
    (
        $(#[doc = $about:literal])+
        $Recipe:ident
        once { $($(#[doc = $about_once:literal])+ $once:ident: $Once:ty,)+ }
        operators { $($(#[doc = $about_operator:literal])+ $operator:ident: $Operator:ty,)+ }
        named { $($(#[doc = $about_named:literal])+ $named:ident: $Named:ty,)* }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Recipe {
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
            )*
        }

        impl $Recipe {
            /// Groups that are there once, in schema order.
            pub const ONCE: &[Group] = &[$(<$Once>::GROUP),+];
            /// Groups with instances that are operators, in the default order of execution.
            pub const OPERATORS: &[Group] = &[$(<$Operator>::GROUP),+];
            /// Other groups with instances.
            pub const OTHERS: &[Group] = &[$(<$Named>::GROUP),*];

            /// The options of all operators by name, in the default order of execution.
            pub fn operators(&self) -> Vec<(&str, &dyn OperatorOptions)> {
                let mut all: Vec<(&str, &dyn OperatorOptions)> = Vec::new();
                $(all.extend(self.$operator.iter().map(|(name, options)| (name.as_str(), options as _)));)+
                all
            }

            /// The options of each group. Operators that are left out are not among them.
            pub fn used(&self) -> Vec<$crate::recipe::UsedGroup<'_>> {
                let mut all: Vec<$crate::recipe::UsedGroup<'_>> = vec![$((<$Once>::GROUP.name.into(), &self.$once)),+];
                $(all.extend(self.$named.iter().map(|(name, options)| ($crate::recipe::full_name(&<$Named>::GROUP, name), options as _)));)*
                for (name, options) in self.operators().into_iter().filter(|(_, options)| options.is_enabled()) {
                    all.push((options.full_name(name), options));
                }
                all
            }

            /// Replaces automatic lengths (0) by those for a garment of this scale.
            pub fn resolve_lengths(&mut self, scale: tailor_mesh::options::Scale) {
                use tailor_mesh::options::OptionGroup as _;
                self.sim.resolve_targets(scale.mean_edge);
                $(self.$operator.values_mut().for_each(|options| options.resolve_lengths(scale));)+
            }

            /// Checks every value, without a garment.
            ///
            /// # Errors
            /// A value that its option does not take.
            pub fn check(&self) -> Result<(), tailor_mesh::Error> {
                self.used().into_iter().try_for_each(|(prefix, options)| options.check(&prefix))?;
                self.sim.check_targets()?;
                $crate::recipe::check_counts([
                    $((<$Operator>::GROUP.name, self.$operator.len()),)+
                    $((<$Named>::GROUP.name, self.$named.len()),)*
                    ("render.operators", self.render.operators.len()),
                ])
            }
        }
    };
}

__recipe! {
    /// The options of the two meshes.
    MeshRecipe
    once {
        /// Options of the simulation mesh.
        sim: SimOptions,
        /// Options of the render mesh.
        render: RenderOptions,
    }
    operators {
        /// Options of each fold, by name.
        fold: FoldOptions,
        /// Options of each seam, by name.
        seam: SeamOptions,
    }
    named {}
}

/// The kind and name of an instance, such as `seam.placket`: the start of its keys.
pub fn full_name(group: &Group, name: &str) -> String {
    format!("{}.{name}", group.name)
}

/// Checks that a recipe has not too many names.
///
/// # Errors
/// The first group that has.
pub fn check_counts(counts: impl IntoIterator<Item = (&'static str, usize)>) -> Result<(), Error> {
    match counts.into_iter().find(|&(_, count)| count > MAX_NAMES) {
        None => Ok(()),
        Some((key, count)) => {
            let fault = format!("there are {count}, and at most {MAX_NAMES} are built");
            Err(Error::recipe(key, fault).remedy("let one seam follow several edge subsets"))
        }
    }
}
