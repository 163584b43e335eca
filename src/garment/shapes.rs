//! Blend shapes: offsets of points are values of vertices, so they are carried as vertex primvars under names that no
//! primvar of a file can have.

/// What the names of such primvars begin with; a `/` is in no name of USD's.
const PREFIX: &str = "blendShape/";

/// The name of the primvar that holds property `property` of the blend shape numbered `shape`.
pub fn channel(shape: usize, property: &str) -> String {
    format!("{PREFIX}{shape}/{property}")
}

/// Whether a primvar holds offsets of a blend shape.
pub fn is_channel(name: &str) -> bool {
    name.starts_with(PREFIX)
}
