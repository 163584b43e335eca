//! Scopes beside products, with prims of a build that later builds replace.

use super::product::Author;
use super::role::ProductRole;
use crate::names;
use openusd::sdf::{AbstractData as _, FieldKey, Path, PrimSpec, Specifier, Value};

/// The name of a prim beside the meshes: `name` itself, or of its own for a simulation mesh of another name than `sim`, so that
/// several garments can be beside each other.
pub fn beside(name: &str, sim: &str) -> String {
    if sim == ProductRole::Sim.name() { name.to_owned() } else { format!("{sim}_{name}") }
}

impl Author<'_> {
    /// A scope that later builds know as a product. What an earlier build wrote into it is not active.
    pub(super) fn scope(&mut self, path: &Path, role: &str) -> openusd::Result<()> {
        PrimSpec::new(self.data, path, Specifier::Def, "Scope")?;
        let mark = self.mark(role);
        self.data.set_field(path, names::CUSTOM_DATA, mark);
        if let Some(before) = path.name().and_then(|name| self.model.siblings.get(name)).filter(|_| self.is_overlay) {
            self.data.set_field(path, FieldKey::Active.as_str(), Value::Bool(true));
            for child in &before.children {
                PrimSpec::over(self.data, &path.append_path(child.as_str())?)?.set_active(false);
            }
        }
        Ok(())
    }

    /// A new prim of a scope, active even if an earlier build had one of this name.
    pub(super) fn in_scope(&mut self, scope: &Path, name: &str, type_name: &str) -> openusd::Result<Path> {
        let path = scope.append_path(name)?;
        self.data.erase_field(&path, FieldKey::Active.as_str());
        PrimSpec::new(self.data, &path, Specifier::Def, type_name)?;
        if scope.name().is_some_and(|name| self.model.siblings.contains_key(name)) && self.is_overlay {
            self.data.set_field(&path, FieldKey::Active.as_str(), Value::Bool(true));
        }
        Ok(path)
    }

    /// Deactivates a prim that an earlier build wrote.
    pub(super) fn deactivate(&mut self, name: &str) -> openusd::Result<()> {
        if self.is_overlay && self.model.siblings.get(name).is_some_and(|sibling| sibling.product) {
            PrimSpec::over(self.data, &self.model.sibling_path(name)?)?.set_active(false);
        }
        Ok(())
    }
}
