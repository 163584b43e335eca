//! The attribute `normals`, which a primvar of that name replaces: it is carried as a primvar under a name that no
//! primvar of a file can have.

/// That name; a `/` is in no name of USD's.
pub const ATTRIBUTE: &str = "/normals";

/// Whether a primvar holds the normals of a mesh.
pub fn are_normals(name: &str) -> bool {
    name == ATTRIBUTE || name == "normals"
}
