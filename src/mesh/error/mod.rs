//! Errors and warnings: what is wrong, where it is, and what cures it.
//!
//! Whoever finds a fault writes its words; this file only holds and prints them.

mod code;

pub use code::{Codes, ErrorCode, Severity, WarningCode};

use crate::codes;
use crate::connectivity::Elements;
use serde::Serialize;
use std::fmt;
use std::io;
use std::sync::Arc;

/// Elements of a warning that are printed. All of them are in the report.
const PRINTED: usize = 3;

/// Where a fault comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A USD file cannot be opened, understood or written.
    Usd,
    /// The mesh breaks a rule that every garment must keep.
    Mesh,
    /// The recipe (file, flag, attribute or option) is wrong.
    Recipe,
    /// The command line is wrong.
    Usage,
    /// The build was cancelled.
    Cancelled,
    /// This program is at fault.
    Internal,
}

/// One fault, in words for the person at the terminal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Fault {
    /// Its kind, for programs and for `usdtailor explain`.
    #[cfg_attr(feature = "typescript", ts(type = "string"))]
    pub code: ErrorCode,
    /// The prim, attribute, option or file; empty where the text names it.
    pub place: String,
    /// The problem.
    pub text: String,
    /// The cure; empty where there is none.
    pub remedy: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        f.write_str(&self.text)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "\n  hint: {}", self.remedy) }
    }
}

/// The faults that ended a build.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Error {
    /// Where they come from.
    pub kind: ErrorKind,
    /// The faults, at least one. A mesh may have several.
    pub faults: Vec<Fault>,
    /// Faults beyond those that are listed.
    pub more: usize,
    source: Option<Arc<dyn std::error::Error + Send + Sync>>,
}

impl Error {
    /// An error of one fault, without a remedy.
    pub fn new(kind: ErrorKind, place: impl fmt::Display, text: impl Into<String>) -> Self {
        let code = ErrorCode::of_kind(kind);
        let fault = Fault { code, place: place.to_string(), text: text.into(), remedy: String::new() };
        Self { kind, faults: vec![fault], more: 0, source: None }
    }

    /// A fault of the recipe.
    pub fn recipe(place: impl fmt::Display, text: impl Into<String>) -> Self {
        Self::new(ErrorKind::Recipe, place, text)
    }

    /// A USD file that cannot be opened, understood or written. The text names the place.
    pub fn usd(text: impl Into<String>) -> Self {
        Self::new(ErrorKind::Usd, "", text)
    }

    /// A thread that the system does not start.
    pub fn no_thread(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::new(ErrorKind::Usage, "", format!("the system starts no more threads: {error}"))
            .code(codes::NO_THREAD)
            .remedy("lower --jobs and --threads, or raise the limits of memory and processes (ulimit -v and -u)")
            .caused_by(error)
    }

    /// A fault of this program.
    pub fn internal(text: impl Into<String>) -> Self {
        Self::new(ErrorKind::Internal, "", text)
    }

    /// Adds the cure of the last fault.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        if let Some(fault) = self.faults.last_mut() {
            fault.remedy = remedy.into();
        }
        self
    }

    /// Sets the code of the last fault, which is otherwise that of the error's kind.
    #[must_use]
    pub fn code(mut self, code: ErrorCode) -> Self {
        if let Some(fault) = self.faults.last_mut() {
            fault.code = code;
        }
        self
    }

    /// Adds the error that this one follows from.
    #[must_use]
    pub fn caused_by(self, source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { source: Some(Arc::new(source)), ..self }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.kind == ErrorKind::Internal {
            f.write_str("internal error: ")?;
        }
        for (i, fault) in self.faults.iter().enumerate() {
            let line = if i > 0 { "\n" } else { "" };
            write!(f, "{line}{fault}")?;
        }
        match (self.kind, self.more) {
            (ErrorKind::Internal, _) => f.write_str("; please report it with the input"),
            (_, 0) => Ok(()),
            (_, more) => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_deref().map(|source| source as _)
    }
}

/// A problem that does not stop the work.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[non_exhaustive]
pub struct Warning {
    /// Its kind.
    #[cfg_attr(feature = "typescript", ts(type = "string"))]
    pub code: WarningCode,
    /// How bad it is: that of its code.
    pub severity: Severity,
    /// The prim, set, option or file to select.
    pub place: String,
    /// The loss or change.
    pub problem: String,
    /// The option or edit that cures it; empty where there is none.
    pub remedy: String,
    /// The face sets or operators that it is about, all of them, where it is about several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "typescript", ts(as = "Option<Vec<String>>", optional))]
    pub names: Vec<String>,
    /// The elements of the input there, all of them.
    pub elements: Elements,
    /// How much of what was asked is left at the worst place, or how far off it is. \[share\]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "typescript", ts(optional))]
    pub amount: Option<f32>,
}

impl Warning {
    /// A warning without elements and without a remedy.
    pub fn new(code: WarningCode, place: impl fmt::Display, problem: impl Into<String>) -> Self {
        Self {
            code,
            severity: code.severity(),
            place: place.to_string(),
            problem: problem.into(),
            remedy: String::new(),
            names: Vec::new(),
            elements: Elements::Points(Vec::new()),
            amount: None,
        }
    }

    /// An attribute, property or subset of the model that a product lacks.
    pub fn not_carried(place: impl fmt::Display, why: impl fmt::Display) -> Self {
        Self::new(codes::NOT_CARRIED, place, format!("not carried: {why}"))
    }

    /// An attribute, property or subset that is not carried because it cannot be read.
    pub fn unread(place: impl fmt::Display, error: &Error) -> Self {
        let texts: Vec<&str> = error.faults.iter().map(|fault| fault.text.as_str()).collect();
        let remedy = error.faults.iter().map(|fault| &fault.remedy).find(|remedy| !remedy.is_empty());
        Self::not_carried(place, texts.join("; ")).remedy(remedy.cloned().unwrap_or_default())
    }

    /// A warning of face sets.
    pub fn of_sets(code: WarningCode, sets: Vec<String>, problem: impl Into<String>) -> Self {
        let place = format!("face sets {}", names(&sets));
        Self { names: sets, ..Self::new(code, place, problem) }
    }

    /// The problem with the first of its elements, unless its sets are named.
    fn with_elements(&self) -> String {
        if self.elements.is_empty() || !self.names.is_empty() {
            return self.problem.clone();
        }
        format!("{} ({})", self.problem, self.elements.in_words(PRINTED))
    }

    /// Place and problem, without the remedy.
    pub fn headline(&self) -> String {
        let place = if self.place.is_empty() { String::new() } else { format!("{}: ", self.place) };
        place + &self.with_elements()
    }

    /// Adds the elements.
    #[must_use]
    pub fn at(self, elements: Elements) -> Self {
        Self { elements, ..self }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn remedy(self, remedy: impl Into<String>) -> Self {
        Self { remedy: remedy.into(), ..self }
    }

    /// Adds the amount.
    #[must_use]
    pub fn amount(self, amount: f32) -> Self {
        Self { amount: Some(amount), ..self }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.headline())?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, ". {}", self.remedy) }
    }
}

/// The warnings of one build in the order in which they arose, each once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// Adds a warning, unless it is there already.
    pub fn push(&mut self, warning: Warning) {
        if !self.0.contains(&warning) {
            self.0.push(warning);
        }
    }

    /// Adds all of `others`.
    pub fn extend(&mut self, others: impl IntoIterator<Item = Warning>) {
        others.into_iter().for_each(|warning| self.push(warning));
    }

    /// Adds the warnings of a value, and gives the value.
    pub fn absorb<T>(&mut self, (value, warnings): (T, Self)) -> T {
        self.extend(warnings);
        value
    }

    /// The warnings so far.
    pub fn iter(&self) -> std::slice::Iter<'_, Warning> {
        self.0.iter()
    }

    /// The warnings, the worst first, and those of one severity in the order in which they arose.
    pub fn worst_first(&self) -> Vec<&Warning> {
        let mut all: Vec<&Warning> = self.0.iter().collect();
        all.sort_by_key(|warning| warning.severity);
        all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Makes each warning that `is_refused` a fault of an error.
    ///
    /// # Errors
    /// If there is one.
    pub fn refuse(&self, is_refused: impl Fn(&Warning) -> bool) -> Result<(), Error> {
        let fault = |warning: &Warning| Fault {
            code: codes::STRICT_WARNING,
            place: warning.place.clone(),
            text: format!("{}: {}", warning.code, warning.with_elements()),
            remedy: warning.remedy.clone(),
        };
        let worse = self.worst_first().into_iter().filter(|warning| is_refused(warning));
        let faults: Vec<Fault> = worse.map(fault).collect();
        if faults.is_empty() { Ok(()) } else { Err(Error { faults, ..Error::new(ErrorKind::Mesh, "", "") }) }
    }
}

impl FromIterator<Warning> for Warnings {
    fn from_iter<I: IntoIterator<Item = Warning>>(all: I) -> Self {
        let mut warnings = Self::default();
        warnings.extend(all);
        warnings
    }
}

impl IntoIterator for Warnings {
    type Item = Warning;
    type IntoIter = std::vec::IntoIter<Warning>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

/// The system's words for a failure, without its number.
pub fn plain(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::FileTooLarge => "the file is larger than is allowed here".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        _ => e.to_string(),
    }
}

/// A number with the words for one or for several.
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// The first names of a list in backquotes, and how many more there are.
pub fn names<T: AsRef<str>>(all: &[T]) -> String {
    let shown: Vec<String> = all.iter().take(PRINTED).map(|name| format!("`{}`", name.as_ref())).collect();
    let more = all.len().saturating_sub(PRINTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    shown.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_warnings_come_first_and_others_keep_their_order() {
        use Severity::{Fault, Note, Quality};
        let codes = [("a", Note), ("b", Quality), ("c", Fault), ("d", Quality), ("e", Fault)]
            .map(|(name, severity)| WarningCode::new(name, severity));
        let warnings: Warnings = codes.map(|code| Warning::new(code, "", "")).into_iter().collect();
        let order: Vec<WarningCode> = warnings.worst_first().iter().map(|warning| warning.code).collect();
        assert_eq!(order, [2, 4, 1, 3, 0].map(|i| codes[i]));
    }
}
