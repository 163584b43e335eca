//! The build that made an output, as the output records it: `info` and `check` speak of that build.

use super::super::Inputs;
use super::super::build::Request;
use serde_json::{Value, json};
use std::path::Path;
use tailor_costume::DEFAULT_MAX_FACES;
use tailor_mesh::error::Error;
use tailor_usd::session::{Input, is_usd};
use tailor_usd::{BuildRecord, Stale};

/// A build with its options, over which those of the command line are stronger.
pub struct RecordedBuild {
    /// The output, to be opened with the options of the build.
    pub input: Input,
    request: Request,
    record: BuildRecord,
}

impl RecordedBuild {
    /// The build that made `file`; none of a file without a record, and where the command line names another prim.
    pub fn of(inputs: &Inputs, file: &Path) -> Option<Self> {
        let record = Some(file).filter(|file| is_usd(file)).and_then(BuildRecord::of)?;
        let request: Request = serde_json::from_str(record.request()).ok()?;
        let is_other = |prim: &String| request.prim.as_ref() != Some(prim) && record.prim() != prim;
        if inputs.prim.as_ref().is_some_and(is_other) {
            return None;
        }
        // A recipe that is gone makes the output stale, which `check` tells.
        let there = |name: &String| BuildRecord::file_of(name, file).ok().filter(|recipe| recipe.exists());
        let mut input = inputs.input(file);
        let read = &mut input.read;
        read.prim = read.prim.take().or_else(|| request.prim.clone());
        read.time = read.time.or(request.time);
        read.all |= request.all;
        read.exclude.extend(request.exclude.iter().filter(|_| inputs.several.exclude.is_empty()).cloned());
        read.sew_tolerance = read.sew_tolerance.or(request.sew_tolerance);
        input.base = there(&request.input).filter(|source| !is_usd(source));
        input.recipe = input.recipe.take().or_else(|| request.recipe.as_ref().and_then(there));
        input.overrides = request.overrides(file).ok()?.into_iter().chain(input.overrides).collect();
        Some(Self { input, request, record })
    }

    /// The set for each variant of which the build made products.
    pub fn variants(&self) -> Option<&str> {
        self.request.variants.as_deref()
    }

    /// The largest simulation mesh of the build.
    pub fn max_faces(&self) -> usize {
        self.request.max_faces.unwrap_or(DEFAULT_MAX_FACES)
    }

    /// The input and the options as on the command line, and whether the output is fresh.
    pub fn in_words(&self, file: &Path) -> Result<String, Error> {
        let state = match self.record.stale(file)? {
            None => "fresh".to_owned(),
            Some(Stale { output, changes }) if output == file => format!("stale: {}", changes.join("; ")),
            Some(Stale { output, changes }) => format!("stale, as {} is: {}", output.display(), changes.join("; ")),
        };
        Ok(format!("of {}; {state}", self.request.in_words()))
    }

    /// The options.
    pub fn json(&self) -> Value {
        serde_json::from_str(self.record.request()).unwrap_or_else(|_| json!({}))
    }
}
