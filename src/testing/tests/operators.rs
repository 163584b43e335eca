//! Stacks of operators as recipes make them, and what real garments have for them to work on.

use std::sync::Arc;
use tailor::render::{RenderSteps, Stack};
use tailor_costume::recipe::Layers;
use tailor_mesh::Error;
use tailor_mesh::connectivity::Topology;
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::{Elements, Mesh};

/// The stack of a recipe with options as on the command line.
pub fn stack<T: AsRef<str>>(options: &[T]) -> Stack {
    let mut layers = Layers::default();
    options.iter().for_each(|o| layers.add_override(o.as_ref()).unwrap_or_else(|e| panic!("{e}")));
    let recipe = layers.recipe().unwrap_or_else(|e| panic!("{e}"));
    Stack::new(&recipe.render, &recipe.operators()).unwrap_or_else(|e| panic!("{e}"))
}

/// The render mesh and what was said of it.
pub fn rendered<T: AsRef<str>>(garment: &Mesh, options: &[T]) -> (Mesh, Warnings) {
    try_rendered(garment, options).unwrap_or_else(|e| panic!("{e}"))
}

/// The same, or the error.
pub fn try_rendered<T: AsRef<str>>(garment: &Mesh, options: &[T]) -> Result<(Mesh, Warnings), Error> {
    let made = RenderSteps::new(Arc::new(garment.clone())).update(&stack(options))?;
    Ok(((*made.mesh).clone(), made.warnings))
}

/// Panels with a border of the mesh among their edges, as a list of an option.
pub fn border_panels(garment: &Mesh) -> String {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let panels = garment.subsets.iter().filter(|s| s.family == "panels");
    let at_border = panels.filter(|s| match &s.elements {
        Elements::Faces(faces) => faces.iter().any(|&f| t.faces.corners_of(f).any(|c| t.is_border(t.corner_edge[c]))),
        _ => false,
    });
    at_border.map(|s| s.name.clone()).collect::<Vec<_>>().join(",")
}
