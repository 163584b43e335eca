//! The names of products.

use crate::garment::free_name;
use crate::usd::read::Source;
use std::collections::HashSet;

/// The names of the prims of one garment's products.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductNames {
    /// The simulation mesh.
    pub sim: String,
    /// The render mesh, or those of the panels in their order.
    pub render: Vec<String>,
}

impl ProductNames {
    /// Of a garment with one render mesh.
    pub fn new(sim: impl Into<String>, render: impl Into<String>) -> Self {
        Self { sim: sim.into(), render: vec![render.into()] }
    }

    /// With a render mesh for each panel of a garment: `render_front` for the face set `front`.
    fn per_panel(self, source: &Source) -> Self {
        let sets = &source.model.sewing.sets;
        if sets.is_empty() {
            return self;
        }
        let name = |set: &String| format!("{}_{set}", self.render[0]);
        Self { render: sets.iter().map(name).collect(), ..self }
    }

    /// All of them, the simulation mesh first.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.sim).chain(&self.render).map(String::as_str)
    }
}

/// The names of the products of each garment: those given for the two meshes, or, where several garments are beside each other,
/// names with that of the garment before them.
pub fn product_names<'a>(
    sources: impl IntoIterator<Item = &'a Source>,
    given: [&str; 2],
    per_panel: bool,
) -> Vec<ProductNames> {
    let sources: Vec<&Source> = sources.into_iter().collect();
    let mut taken = HashSet::new();
    let names = sources.iter().map(|source| {
        let [sim, render] = two_names(source, &sources, given, &mut taken);
        let names = ProductNames::new(sim, render);
        if per_panel { names.per_panel(source) } else { names }
    });
    names.collect()
}

fn two_names<'a>(
    source: &'a Source,
    sources: &[&'a Source],
    given: [&str; 2],
    taken: &mut HashSet<(&'a openusd::sdf::Path, String)>,
) -> [String; 2] {
    let parent = &source.model.parent;
    if sources.iter().filter(|other| other.model.parent == *parent).count() == 1 {
        return given.map(str::to_owned);
    }
    let name = source.model.name().replace('/', "_");
    let name = free_name(&name, |name| taken.contains(&(parent, name.to_owned())));
    taken.insert((parent, name.clone()));
    given.map(|product| format!("{name}_{product}"))
}
