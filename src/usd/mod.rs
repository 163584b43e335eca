//! The door to USD: stages in, layers out. No other folder knows a USD type.

use std::fmt;

/// A fault while reading or writing USD.
#[derive(Debug)]
pub struct UsdError {
    /// What is wrong, naming file, prim and attribute.
    pub message: String,
    /// What the user can do, where there is something.
    pub hint: Option<String>,
}

impl fmt::Display for UsdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for UsdError {}
