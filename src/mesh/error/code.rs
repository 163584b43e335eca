//! Codes: the kinds of errors and warnings, which stay when their words change. `docs/diagnostics.md` has a section for each.
//!
//! Each crate declares its own.

use super::ErrorKind;
use crate::codes;
use serde::{Serialize, Serializer};
use std::fmt;

/// The kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct ErrorCode(&'static str);

impl ErrorCode {
    /// A code of this name.
    pub const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// The code as messages and reports have it, such as `no-mesh`.
    pub const fn name(self) -> &'static str {
        self.0
    }

    /// The code of faults that have none of their own.
    pub(super) fn of_kind(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::Usd => codes::DAMAGED_FILE,
            ErrorKind::Mesh => codes::EMPTY_MESH,
            ErrorKind::Recipe => codes::OPTION_VALUE,
            ErrorKind::Usage => codes::COMMAND_LINE,
            ErrorKind::Cancelled => codes::CANCELLED,
            ErrorKind::Internal => codes::INTERNAL,
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// How bad a warning is, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[non_exhaustive]
pub enum Severity {
    /// The garment or its recipe has a fault, or a product lacks what it should have.
    Fault,
    /// A product is less good at some places than was asked.
    Quality,
    /// The products are as they should be; it is good to know how.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// The kind of a warning, for programs that read reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WarningCode {
    name: &'static str,
    severity: Severity,
}

impl WarningCode {
    /// A code of this name.
    pub const fn new(name: &'static str, severity: Severity) -> Self {
        Self { name, severity }
    }

    /// The code as messages and reports have it, such as `flipped-uvs`.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// How bad warnings of this code are.
    pub const fn severity(self) -> Severity {
        self.severity
    }
}

impl fmt::Display for WarningCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Serialize for WarningCode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// The codes of one crate.
#[derive(Clone, Copy, Debug)]
pub struct Codes {
    /// Codes of errors.
    pub errors: &'static [ErrorCode],
    /// Codes of warnings.
    pub warnings: &'static [WarningCode],
}

/// Declares the codes of a crate: a constant for each, and `ALL`.
#[macro_export]
macro_rules! declare_codes {
    (
        errors { $($(#[doc = $of_error:literal])+ $Error:ident = $error:literal;)* }
        faults { $($(#[doc = $of_fault:literal])+ $Fault:ident = $fault:literal;)* }
        quality { $($(#[doc = $of_quality:literal])+ $Quality:ident = $quality:literal;)* }
        notes { $($(#[doc = $of_note:literal])+ $Note:ident = $note:literal;)* }
    ) => {
        use $crate::error::{Codes, ErrorCode};
        #[allow(unused_imports, reason = "a crate may have no warnings")]
        use $crate::error::{Severity, WarningCode};

        $($(#[doc = $of_error])+ pub const $Error: ErrorCode = ErrorCode::new($error);)*
        $($(#[doc = $of_fault])+ pub const $Fault: WarningCode = WarningCode::new($fault, Severity::Fault);)*
        $($(#[doc = $of_quality])+ pub const $Quality: WarningCode = WarningCode::new($quality, Severity::Quality);)*
        $($(#[doc = $of_note])+ pub const $Note: WarningCode = WarningCode::new($note, Severity::Note);)*

        /// All of them.
        pub const ALL: Codes = Codes { errors: &[$($Error),*], warnings: &[$($Fault,)* $($Quality,)* $($Note),*] };
    };
}
