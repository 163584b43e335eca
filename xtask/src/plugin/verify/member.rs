//! The member functions that symbols name.

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
    /// The member that a symbol such as `_ZNK<namespace>13SdfFileFormat9IsPackageEv` names.
    pub fn parse(symbol: &str, namespace: &str) -> Option<Self> {
        let text = cpp_demangle::Symbol::new(symbol).ok()?.demangle().ok()?;
        let (path, parameters) =
            text.strip_prefix(namespace)?.strip_prefix("::")?.rsplit_once(')')?.0.split_once('(')?;
        let name = path.rsplit("::").next()?;
        if name.starts_with('~') {
            return Some(Self::Destructor);
        }
        // The ABI tag of functions that return a C++11 string.
        let name = name.trim_end_matches("[abi:cxx11]").to_owned();
        Some(Self::Function { name, parameters: parameters.to_owned() })
    }
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
        assert_eq!(base.as_deref(), Some("IsPackage()"));
        assert_eq!(function("_ZNK3pxr17UsdUsdzFileFormat9IsPackageEv"), base);
        assert_ne!(function("_ZNK3pxr13SdfFileFormat9IsPackageEb"), base);
    }

    #[test]
    fn a_parameter_is_the_same_in_its_own_class_and_in_another() {
        let own = function("_ZN3pxr4Base3useERKS0_");
        assert_eq!(own.as_deref(), Some("use(pxr::Base const&)"));
        assert_eq!(function("_ZN3pxr7Derived3useERKNS_4BaseE"), own);
    }

    #[test]
    fn destructors_of_all_kinds_are_one() {
        assert_eq!(Member::parse("_ZN3pxr7ArAssetD0Ev", "pxr"), Some(Member::Destructor));
        assert_eq!(Member::parse("_ZN3pxr7ArAssetD2Ev", "pxr"), Some(Member::Destructor));
    }

    #[test]
    fn template_arguments_and_string_tags_are_no_part_of_it() {
        let new = "_ZNK3pxr21Sdf_FileFormatFactoryINS_17UsdUsdcFileFormatEE3NewEv";
        assert_eq!(function(new).as_deref(), Some("New()"));
        assert_eq!(function("_ZNK3pxr13SdfFileFormat4NameB5cxx11Ev").as_deref(), Some("Name()"));
    }

    #[test]
    fn other_symbols_are_not_understood() {
        assert_eq!(function("__cxa_pure_virtual"), None);
        assert_eq!(function("_ZN3tbb4task4waitEv"), None);
    }
}
