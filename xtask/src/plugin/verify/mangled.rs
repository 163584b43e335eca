//! Parses mangled names of member functions (Itanium C++ ABI).

use std::fmt;

/// A member function without its class, so that an override equals the function it overrides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Member {
    Destructor,
    Function { name: String, parameters: String },
}

impl fmt::Display for Member {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Destructor => write!(f, "the destructor"),
            Self::Function { name, parameters } => write!(f, "{name}({parameters})"),
        }
    }
}

impl Member {
    /// Parses a symbol such as `_ZNK<namespace>13SdfFileFormat9IsPackageEv`.
    pub fn parse(symbol: &str, namespace: &str) -> Option<Self> {
        let rest = symbol.strip_prefix("_ZN")?;
        let rest = rest.strip_prefix('K').unwrap_or(rest);
        let mut rest = rest.strip_prefix(&format!("{}{namespace}", namespace.len()))?;
        let mut last = None;
        loop {
            if let Some((name, after)) = identifier(rest) {
                last = Some(name);
                rest = after;
            } else if rest.starts_with('I') {
                rest = after_template_arguments(rest)?;
            } else {
                break;
            }
        }
        if rest.starts_with('D') {
            return Some(Self::Destructor);
        }
        // The ABI tag of functions that return a C++11 string.
        let rest = rest.strip_prefix("B5cxx11").unwrap_or(rest);
        Some(Self::Function { name: last?.to_owned(), parameters: rest.strip_prefix('E')?.to_owned() })
    }
}

/// Splits `9IsPackage…` into `IsPackage` and the rest.
fn identifier(text: &str) -> Option<(&str, &str)> {
    let digits = text.find(|c: char| !c.is_ascii_digit())?;
    let length: usize = text[..digits].parse().ok()?;
    let name = text.get(digits..digits + length)?;
    Some((name, &text[digits + length..]))
}

/// Skips `I…E`, whose arguments are classes of the same namespace: `INS_17UsdUsdcFileFormatEE`.
fn after_template_arguments(text: &str) -> Option<&str> {
    let mut rest = text.strip_prefix('I')?;
    while let Some(argument) = rest.strip_prefix("NS_") {
        rest = identifier(argument)?.1.strip_prefix('E')?;
    }
    rest.strip_prefix('E')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(symbol: &str) -> Option<String> {
        Member::parse(symbol, "pxr").map(|member| member.to_string())
    }

    #[test]
    fn overrides_have_the_member_in_common() {
        let base = function("_ZNK3pxr13SdfFileFormat9IsPackageEv");
        assert_eq!(base.as_deref(), Some("IsPackage(v)"));
        assert_eq!(function("_ZNK3pxr17UsdUsdzFileFormat9IsPackageEv"), base);
        assert_ne!(function("_ZNK3pxr13SdfFileFormat9IsPackageEb"), base);
    }

    #[test]
    fn destructors_of_all_kinds_are_one() {
        assert_eq!(Member::parse("_ZN3pxr7ArAssetD0Ev", "pxr"), Some(Member::Destructor));
        assert_eq!(Member::parse("_ZN3pxr7ArAssetD2Ev", "pxr"), Some(Member::Destructor));
    }

    #[test]
    fn template_arguments_and_string_tags_are_no_part_of_it() {
        let new = "_ZNK3pxr21Sdf_FileFormatFactoryINS_17UsdUsdcFileFormatEE3NewEv";
        assert_eq!(function(new).as_deref(), Some("New(v)"));
        assert_eq!(function("_ZNK3pxr13SdfFileFormat4NameB5cxx11Ev").as_deref(), Some("Name(v)"));
    }

    #[test]
    fn other_symbols_are_not_understood() {
        assert_eq!(function("__cxa_pure_virtual"), None);
        assert_eq!(function("_ZN3tbb4task4waitEv"), None);
    }
}
