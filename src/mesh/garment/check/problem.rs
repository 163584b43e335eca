//! Faults of an input as messages.

use crate::error::{Error, ErrorCode, ErrorKind, Fault};
use std::fmt;

/// Problems that are listed for a mesh; larger fills more than a screen.
const MAX_PROBLEMS: usize = 20;
/// Problems that are listed for one attribute, so that a broken one does not hide the others.
const MAX_PER_ATTRIBUTE: usize = 5;

/// The faults of one mesh so far, each with the attribute that is at fault: a name such as `primvars:st:indices` for one of
/// the mesh, `collar.indices` for one of its subset `collar`.
#[derive(Debug, Default)]
pub(super) struct Problems {
    listed: Vec<Fault>,
    more: usize,
}

impl Problems {
    /// Adds a fault of `attribute`; beyond the limits it is only counted, and nothing is formatted.
    pub fn add(&mut self, code: ErrorCode, attribute: &str, fault: fmt::Arguments<'_>, remedy: fmt::Arguments<'_>) {
        let of_attribute = self.listed.iter().filter(|p| p.place == attribute).count();
        if self.listed.len() >= MAX_PROBLEMS || of_attribute >= MAX_PER_ATTRIBUTE {
            self.more += 1;
            return;
        }
        let (place, text, remedy) = (attribute.to_owned(), fault.to_string(), remedy.to_string());
        self.listed.push(Fault { code, place, text, remedy });
    }

    /// Number of faults, listed or not.
    pub fn count(&self) -> usize {
        self.listed.len() + self.more
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// The error of all faults, with the paths of their attributes.
    pub fn into_error(self, prim: &str) -> Error {
        debug_assert!(!self.is_empty(), "an error needs a fault");
        let path = |attribute: &str| match attribute {
            path if path.starts_with('/') => path.to_owned(),
            // Names of properties have no dot; this one begins with the name of a child.
            of_child if of_child.contains('.') => format!("{prim}/{of_child}"),
            name => format!("{prim}.{name}"),
        };
        let faults = self.listed.into_iter().map(|f| Fault { place: path(&f.place), ..f }).collect();
        let mut error = Error::new(ErrorKind::Mesh, "", "");
        (error.faults, error.more) = (faults, self.more);
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes;

    fn problem(problems: &mut Problems, attribute: &str, i: usize) {
        problems.add(codes::EMPTY_MESH, attribute, format_args!("fault {i}"), format_args!("remedy {i}"));
    }

    #[test]
    fn the_path_of_a_subset_goes_through_its_prim() {
        let mut problems = Problems::default();
        problem(&mut problems, "faceVertexIndices", 1);
        problem(&mut problems, "collar.indices", 2);
        let text = problems.into_error("/Coat/model").to_string();
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
        let error = problems.into_error("/m");
        assert_eq!(error.faults.len(), MAX_PER_ATTRIBUTE + 1);
        assert_eq!(error.faults[MAX_PER_ATTRIBUTE].place, "/m.holeIndices");
        assert!(error.to_string().ends_with("\nand 995 more"));
    }

    #[test]
    fn the_faults_of_a_broken_mesh_fit_on_a_screen() {
        let mut problems = Problems::default();
        (0..100).for_each(|i| problem(&mut problems, &format!("primvars:p{i}"), i));
        let error = problems.into_error("/m");
        assert_eq!((error.faults.len(), error.more), (MAX_PROBLEMS, 100 - MAX_PROBLEMS));
    }
}
