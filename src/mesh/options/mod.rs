//! The table of options: one declaration of each option gives its field, default, checks, help, schema, documents and the
//! control of the preview.
//!
//! [`options!`] declares a group of options, such as those of a seam. `recipe` puts the groups together.

mod bind;
mod domain;

pub use bind::{LARGEST, did_you_mean, float_primvar, nearest, primvar, subset_of, within_size_in_meters};
pub use domain::{Domain, Scale};

use crate::error::Error;
use crate::garment::Mesh;
use serde::Serialize;
use serde_json::Value;

/// The declaration of an option.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Key {
    /// Name within its group, such as `width`.
    pub key: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// The values that it takes.
    pub domain: Domain,
    /// Meaning, in one sentence.
    pub meaning: &'static str,
}

/// The declaration of a group of options.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The first part of the keys, such as `sim` or `seam`.
    pub name: &'static str,
    /// Description, in a few sentences.
    pub about: &'static str,
    /// Its options, in the order of the schema.
    pub keys: &'static [Key],
    /// The default values, as an object.
    pub defaults: fn() -> Value,
}

impl Group {
    /// The option `key`.
    pub fn key(&self, key: &str) -> Option<&'static Key> {
        self.keys.iter().find(|known| known.key == key)
    }

    /// The API schema of these options, such as `TailorSimAPI`, or of an instance, such as `TailorSeamAPI:side`.
    pub fn schema(&self, instance: Option<&str>) -> String {
        let (first, rest) = self.name.split_at(1);
        let instance = instance.map_or(String::new(), |name| format!(":{name}"));
        format!("Tailor{}{rest}API{instance}", first.to_ascii_uppercase())
    }
}

/// A value of an option.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a> {
    /// True or false, or one of the words of an enumeration.
    Known,
    /// A number.
    Number(f32),
    /// A whole number.
    Whole(u32),
    /// A word or free text.
    Text(&'a str),
    /// Words.
    Names(&'a [String]),
}

/// A type that options have.
pub trait OptionValue {
    /// The value; by default one that needs no check.
    fn given(&self) -> Given<'_> {
        Given::Known
    }

    /// Replaces a length of 0.
    fn replace_zero(&mut self, _length: f32) {}
}

impl OptionValue for bool {}

impl OptionValue for f32 {
    fn given(&self) -> Given<'_> {
        Given::Number(*self)
    }

    fn replace_zero(&mut self, length: f32) {
        if *self == 0.0 {
            *self = length;
        }
    }
}

impl OptionValue for u32 {
    fn given(&self) -> Given<'_> {
        Given::Whole(*self)
    }
}

impl OptionValue for String {
    fn given(&self) -> Given<'_> {
        Given::Text(self)
    }
}

impl OptionValue for Vec<String> {
    fn given(&self) -> Given<'_> {
        Given::Names(self)
    }
}

/// The values of a group of options. [`options!`] implements it.
pub trait OptionGroup {
    /// The declaration.
    fn group(&self) -> &'static Group;

    /// The values, in the order of the keys.
    fn given(&self) -> Vec<Given<'_>>;

    /// Replaces automatic lengths by those for a garment of this scale.
    fn resolve_lengths(&mut self, scale: Scale);
}

impl dyn OptionGroup + '_ {
    /// Checks that each value is one that its option takes. `prefix` starts the keys in messages, such as `seam.placket`.
    ///
    /// # Errors
    /// The first value that is not.
    pub fn check(&self, prefix: &str) -> Result<(), Error> {
        let mut values = self.group().keys.iter().zip(self.given());
        values.try_for_each(|(key, given)| key.domain.check(&format!("{prefix}.{}", key.key), given))
    }

    /// Checks lengths and names against a garment.
    ///
    /// # Errors
    /// The first length that is too large for it, or name that it lacks.
    pub fn bind(&self, prefix: &str, garment: &Mesh) -> Result<(), Error> {
        let mut values = self.group().keys.iter().zip(self.given());
        values.try_for_each(|(key, given)| key.domain.bind(&format!("{prefix}.{}", key.key), given, garment))
    }
}

/// Declares a group of options. The documentation of a field is one sentence, which the help, the schema, docs/options.md and
/// the preview show too; then its key, field, type, default, domain and unit. A field that takes lengths with units names
/// the function that reads them.
#[doc(hidden)]
#[macro_export]
macro_rules! __options {
    (
        $(#[doc = $about:literal])+
        $name:literal => $Options:ident {
            $(
                $(#[doc = $meaning:literal])+
                $key:literal $field:ident: $type:ty = $default:expr, $domain:expr, $unit:literal $(via $with:literal)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Options {
            $(
                $(#[doc = $meaning])+
                #[doc = concat!(" \\[", $unit, "\\]")]
                #[serde(rename = $key $(, deserialize_with = $with)?)]
                pub $field: $type,
            )+
        }

        impl Default for $Options {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $Options {
            /// The declaration of these options.
            pub const GROUP: $crate::options::Group = $crate::options::Group {
                name: $name,
                about: concat!($($about),+).trim_ascii(),
                keys: &[$(
                    $crate::options::Key {
                        key: $key,
                        unit: $unit,
                        domain: $domain,
                        meaning: concat!($($meaning),+).trim_ascii(),
                    },
                )+],
                defaults: || serde_json::to_value(Self::default()).unwrap_or_default(),
            };
        }

        impl $crate::options::OptionGroup for $Options {
            fn group(&self) -> &'static $crate::options::Group {
                &Self::GROUP
            }

            fn given(&self) -> Vec<$crate::options::Given<'_>> {
                use $crate::options::OptionValue as _;
                vec![$(self.$field.given(),)+]
            }

            fn resolve_lengths(&mut self, scale: $crate::options::Scale) {
                use $crate::options::OptionValue as _;
                $(
                    if let Some(length) = $domain.automatic_length(scale) {
                        self.$field.replace_zero(length);
                    }
                )+
            }
        }
    };
}
#[doc(inline)]
pub use __options as options;
