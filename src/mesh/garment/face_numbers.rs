//! The numbers of faces in the file of a garment.

use crate::connectivity::{Elements, FaceId};
use crate::error::{Warning, Warnings};
use std::collections::HashSet;

/// The face of the file behind each face of a mesh, where faces of the file were left out or split; nothing where they are the
/// same.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaceNumbers(Option<Vec<FaceId>>);

impl FaceNumbers {
    /// Numbers for each face of the mesh.
    pub(super) fn new(in_file: Vec<FaceId>) -> Self {
        Self(Some(in_file))
    }

    /// Elements of the mesh as those of the file.
    pub fn in_file(&self, elements: Elements) -> Elements {
        match (&self.0, elements) {
            (Some(numbers), Elements::Faces(faces)) => {
                let mut seen = HashSet::new();
                let numbers = faces.into_iter().filter_map(|face| numbers.get(face.index()).copied());
                Elements::Faces(numbers.filter(|&number| seen.insert(number)).collect())
            }
            (_, elements) => elements,
        }
    }

    /// Elements of the file as those of the mesh.
    fn in_mesh(&self, elements: Elements) -> Elements {
        match (&self.0, elements) {
            (Some(numbers), Elements::Faces(faces)) => {
                let wanted: HashSet<FaceId> = faces.into_iter().collect();
                let own = numbers.iter().enumerate().filter(|(_, number)| wanted.contains(number));
                Elements::Faces(own.map(|(own, _)| FaceId::new(own)).collect())
            }
            (_, elements) => elements,
        }
    }

    /// Warnings of the mesh with the elements of the file.
    pub fn warnings_in_file(&self, warnings: Warnings) -> Warnings {
        each(warnings, |elements| self.in_file(elements))
    }

    /// Warnings of the file with the elements of the mesh.
    pub fn warnings_in_mesh(&self, warnings: Warnings) -> Warnings {
        each(warnings, |elements| self.in_mesh(elements))
    }
}

fn each(warnings: Warnings, number: impl Fn(Elements) -> Elements) -> Warnings {
    warnings.into_iter().map(|w| Warning { elements: number(w.elements), ..w }).collect()
}
