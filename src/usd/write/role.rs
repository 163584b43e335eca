//! The meshes that are written, and their purposes.

use crate::names;
use crate::read::{Selection, Source};
use openusd::sdf::Path;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor_costume::Stitch;
use tailor_costume::binding::Binding;
use tailor_costume::cloth::Cloth;
use tailor_costume::trim::TrimOptions;
use tailor_mesh::garment::Mesh;

/// The purpose of a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProductRole {
    /// Cloth simulation: triangles, no subdivision, purpose `guide`.
    Sim,
    /// Rendering: a subdivision cage, purpose `default`.
    Render,
}

impl ProductRole {
    /// Its name in `customData`, and that of its prim unless another is chosen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sim => names::SIM,
            Self::Render => names::RENDER,
        }
    }

    /// Its `purpose`, where the model has one. A mesh of the purpose `render` has a proxy that is drawn in its place.
    pub fn purpose(self, of_model: Option<&str>) -> &'static str {
        match (self, of_model) {
            (Self::Sim, _) => "guide",
            (Self::Render, Some("render")) => "render",
            (Self::Render, _) => "default",
        }
    }

    /// The flag that names it.
    pub fn name_flag(self) -> &'static str {
        match self {
            Self::Sim => "--sim-name",
            Self::Render => "--render-name",
        }
    }
}

/// The sets that products have. Programs that read subsets for materials alone warn of others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum SetChoice {
    /// Sets with a material.
    None,
    /// Sets of the model, its creases and its corners.
    #[default]
    Authored,
    /// Also sets of the simulation mesh's borders and seams, and sets that the recipe derives.
    All,
}

/// A mesh to be written as a sibling of the model.
#[derive(Clone, Copy, Debug)]
pub struct Product<'a> {
    /// Name of its prim, or the path of it from the prim above all products.
    pub name: &'a str,
    /// Its level of detail.
    pub level: u32,
    /// How much longer edges are than at the first level. \[factor\]
    pub scale: f32,
    /// The panel whose part it is, by number; none for the product of all.
    pub panel: Option<usize>,
    /// Its purpose.
    pub role: ProductRole,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The simulation mesh as cloth; none for no physics.
    pub cloth: Option<&'a Cloth>,
    /// The places of the render mesh's points on the simulation mesh of its level.
    pub binding: Option<&'a Binding>,
    /// Their places on the simulation mesh of each level; empty for one level.
    pub level_bindings: &'a [Arc<Binding>],
    /// The places of the model's points on this simulation mesh.
    pub cage_binding: Option<&'a Binding>,
    /// The trims that ride on this simulation mesh, by name.
    pub trims: Option<&'a BTreeMap<String, TrimOptions>>,
    /// The stitches that are bound to this simulation mesh, by name.
    pub stitches: Option<&'a BTreeMap<String, Stitch>>,
}

impl<'a> Product<'a> {
    /// A mesh without physics.
    pub fn new(name: &'a str, role: ProductRole, mesh: &'a Mesh) -> Self {
        Self {
            name,
            level: 0,
            scale: 1.0,
            panel: None,
            role,
            mesh,
            cloth: None,
            binding: None,
            level_bindings: &[],
            cage_binding: None,
            trims: None,
            stitches: None,
        }
    }

    /// The documentation of its prim, made of a model of `panels`.
    pub(super) fn doc(&self, panels: &[Path]) -> String {
        let panels = self.panel.and_then(|panel| panels.get(panel..=panel)).unwrap_or(panels);
        let what = match self.role {
            ProductRole::Sim => "Simulation mesh",
            ProductRole::Render => "Render mesh",
        };
        let panels: Vec<String> = panels.iter().map(|panel| format!("<{panel}>")).collect();
        let level = if self.level > 0 { format!(", level of detail {}", self.level) } else { String::new() };
        format!("{what} made by usd-tailor from {}{level}.", panels.join(", "))
    }

    /// The name of its prim, or of that above it, beside the model.
    pub fn sibling(&self) -> &'a str {
        self.name.split('/').next().unwrap_or(self.name)
    }
}

/// A garment with its products.
#[derive(Clone, Copy, Debug)]
pub struct GarmentProducts<'a> {
    /// The garment.
    pub source: &'a Source,
    /// Its products.
    pub products: &'a [Product<'a>],
    /// The variant that they are for and become a part of. The garment was read with it.
    pub variant: Option<&'a Selection>,
}

/// The simulation meshes, level by level.
pub fn sims<'a>(products: &'a [Product<'a>]) -> impl Iterator<Item = &'a Product<'a>> {
    products.iter().filter(|product| product.role == ProductRole::Sim)
}

/// The number of levels of detail of some products.
pub fn level_count(products: &[Product]) -> u32 {
    products.iter().map(|product| product.level + 1).max().unwrap_or(1)
}
