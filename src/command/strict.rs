//! Which warnings are errors.

use super::codes::PARTS;
use super::usage;
use clap::Args;
use serde::{Deserialize, Serialize};
use tailor_mesh::error::{Error, Severity, Warning, Warnings};
use tailor_mesh::options::did_you_mean;

/// The warnings that are errors.
#[derive(Args, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Strictness {
    /// Fail where a warning is more than a note, and write nothing then
    #[arg(long, help_heading = "Output")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    strict: bool,
    /// Fail where there is a warning of this code, such as sets-blurred, and write nothing then; repeatable
    #[arg(long, value_name = "CODE", help_heading = "Output")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    deny: Vec<String>,
    /// Let warnings of this code pass --strict; repeatable
    #[arg(long, value_name = "CODE", help_heading = "Output")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    allow: Vec<String>,
}

impl Strictness {
    /// Whether any warning is an error.
    pub fn is_any(&self) -> bool {
        self.strict || !self.deny.is_empty()
    }

    /// Whether a warning is an error.
    pub fn refuses(&self, warning: &Warning) -> bool {
        let is_in = |codes: &[String]| codes.iter().any(|code| code == warning.code.name());
        is_in(&self.deny) || self.strict && warning.severity < Severity::Note && !is_in(&self.allow)
    }

    /// Makes warnings errors.
    ///
    /// # Errors
    /// Such a warning.
    pub fn check(&self, warnings: &Warnings) -> Result<(), Error> {
        warnings.refuse(|warning| self.refuses(warning))
    }

    /// Refuses codes that no warning has.
    ///
    /// # Errors
    /// Such a code.
    pub fn check_codes(&self) -> Result<(), Error> {
        let known: Vec<&str> = PARTS.iter().flat_map(|part| part.warnings).map(|code| code.name()).collect();
        let flags = [("--deny", &self.deny), ("--allow", &self.allow)];
        for (flag, code) in flags.into_iter().flat_map(|(flag, codes)| codes.iter().map(move |code| (flag, code))) {
            if !known.contains(&code.as_str()) {
                let likely = did_you_mean(code, &known);
                let fault = usage(format!("{flag} {code}"), "no warning has this code");
                return Err(fault.remedy(format!("{likely}`usdtailor explain` lists all codes")));
            }
        }
        Ok(())
    }
}
