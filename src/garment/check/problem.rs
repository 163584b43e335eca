//! Faults of an input as messages.

use std::fmt;

/// Problems that are listed for a mesh; larger fills more than a screen.
const MAX_PROBLEMS: usize = 20;
/// Problems that are listed for one attribute, so that a broken one does not hide the others.
const MAX_PER_ATTRIBUTE: usize = 5;

/// One fault of the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The faulty attribute: `primvars:st:indices` for one of the mesh, `collar.indices` for one of its subset `collar`, or
    /// a path.
    pub attribute: String,
    /// The fault, with the element in the user's own numbers.
    pub fault: String,
    /// The remedy.
    pub remedy: String,
}

impl Problem {
    /// The path of the attribute, given the path of the mesh.
    pub fn path(&self, prim: &str) -> String {
        match &self.attribute {
            path if path.starts_with('/') => path.clone(),
            // Names of properties have no dot; this one begins with the name of a child.
            of_child if of_child.contains('.') => format!("{prim}/{of_child}"),
            name => format!("{prim}.{name}"),
        }
    }
}

/// The faults that were found in one mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GarmentError {
    /// Path of the mesh.
    pub prim: String,
    /// The faults; at least one.
    pub problems: Vec<Problem>,
    /// Number of faults beyond those listed.
    pub more: usize,
}

impl fmt::Display for GarmentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, p) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{}: {}\n  hint: {}", p.path(&self.prim), p.fault, p.remedy)?;
        }
        match self.more {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for GarmentError {}

/// The problems of one mesh so far.
#[derive(Debug, Default)]
pub(super) struct Problems {
    listed: Vec<Problem>,
    more: usize,
}

impl Problems {
    /// Adds a problem of `attribute`; beyond the limits it is counted without formatting it.
    pub fn add(&mut self, attribute: &str, fault: fmt::Arguments<'_>, remedy: fmt::Arguments<'_>) {
        let of_attribute = self.listed.iter().filter(|p| p.attribute == attribute).count();
        if self.listed.len() >= MAX_PROBLEMS || of_attribute >= MAX_PER_ATTRIBUTE {
            self.more += 1;
            return;
        }
        let attribute = attribute.to_owned();
        self.listed.push(Problem { attribute, fault: fault.to_string(), remedy: remedy.to_string() });
    }

    /// Number of problems, listed or not.
    pub fn count(&self) -> usize {
        self.listed.len() + self.more
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// The error that lists them.
    pub fn into_error(self, prim: String) -> GarmentError {
        debug_assert!(!self.is_empty(), "an error needs a problem");
        GarmentError { prim, problems: self.listed, more: self.more }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(problems: &mut Problems, attribute: &str, i: usize) {
        problems.add(attribute, format_args!("fault {i}"), format_args!("remedy {i}"));
    }

    #[test]
    fn the_path_of_a_subset_goes_through_its_prim() {
        let mut problems = Problems::default();
        problem(&mut problems, "faceVertexIndices", 1);
        problem(&mut problems, "collar.indices", 2);
        let text = problems.into_error("/Coat/model".into()).to_string();
        let expected = "/Coat/model.faceVertexIndices: fault 1\n  hint: remedy 1\n\
                        /Coat/model/collar.indices: fault 2\n  hint: remedy 2";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_broken_attribute_leaves_room_for_the_others() {
        let mut problems = Problems::default();
        (0..1000).for_each(|i| problem(&mut problems, "points", i));
        problem(&mut problems, "holeIndices", 0);
        assert_eq!(problems.count(), 1001);
        let error = problems.into_error("/m".into());
        assert_eq!(error.problems.len(), MAX_PER_ATTRIBUTE + 1);
        assert_eq!(error.problems[MAX_PER_ATTRIBUTE].attribute, "holeIndices");
        assert!(error.to_string().ends_with("\nand 995 more"));
    }

    #[test]
    fn the_faults_of_a_broken_mesh_fit_on_a_screen() {
        let mut problems = Problems::default();
        (0..100).for_each(|i| problem(&mut problems, &format!("primvars:p{i}"), i));
        let error = problems.into_error("/m".into());
        assert_eq!((error.problems.len(), error.more), (MAX_PROBLEMS, 100 - MAX_PROBLEMS));
    }
}
