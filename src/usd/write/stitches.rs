//! Stitches as curves below a scope beside the products, bound to the simulation mesh as trims are.
//!
//! ```text
//! /Coat
//!   /sim
//!   /render
//!   /stitches        Scope
//!     /hem …         BasisCurves, Catmull-Rom
//! ```

use super::product::{Author, extent};
use super::role::{Product, sims};
use super::scope::beside;
use crate::names::{self, UsdToken as _};
use glam::Vec3;
use openusd::gf::Vec2f;
use openusd::sdf::{AbstractData as _, Path, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use tailor_costume::Stitch;
use tailor_mesh::garment::Interpolation;

/// Name of the scope.
pub const STITCHES: &str = "stitches";

impl Author<'_> {
    /// Authors the stitches among `products`.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn stitches(&mut self, products: &[Product]) -> openusd::Result<()> {
        let Some(sim) = sims(products).next() else { return Ok(()) };
        let name = beside(STITCHES, sim.name);
        let Some(stitches) = sim.stitches.filter(|stitches| !stitches.is_empty()) else {
            return self.deactivate(&name);
        };
        let (scope, target) = (self.model.sibling_path(&name)?, self.model.sibling_path(sim.name)?);
        self.scope(&scope, STITCHES)?;
        for (name, stitch) in stitches {
            let path = self.in_scope(&scope, &name.replace(':', "_"), "BasisCurves")?;
            self.curves(&path, stitch)?;
            self.binding(&path, &stitch.binding, &target, sim.level)?;
        }
        Ok(())
    }

    fn curves(&mut self, path: &Path, stitch: &Stitch) -> openusd::Result<()> {
        let threads = &stitch.threads;
        for (name, word) in [("type", "cubic"), ("basis", "catmullRom"), ("wrap", "nonperiodic")] {
            self.token(path, name, word)?;
        }
        self.ints(path, names::CURVE_VERTEX_COUNTS, threads.counts.iter().map(|&count| count as i32).collect())?;
        self.vectors(path, names::POINTS, ValueTypeName::POINT3F_ARRAY, &threads.points)?;
        self.vectors(path, names::NORMALS, ValueTypeName::NORMAL3F_ARRAY, &threads.normals)?;
        self.floats(path, "widths", vec![stitch.thread])?;
        let st = Value::Vec2fVec(threads.along.iter().map(|&along| Vec2f { x: along, y: 0.0 }).collect());
        self.attribute(path, "primvars:st", ValueTypeName::TEX_COORD2F_ARRAY, Variability::Varying, st)?;
        for (name, interpolation) in [
            (names::NORMALS, Interpolation::Vertex),
            ("widths", Interpolation::Constant),
            ("primvars:st", Interpolation::Vertex),
        ] {
            let token = Value::Token(Token::from(interpolation.token()));
            self.data.set_field(&path.append_property(name)?, names::INTERPOLATION, token);
        }
        let half = 0.5 * stitch.thread;
        let reach: Vec<Vec3> = threads.points.iter().flat_map(|&p| [p - half, p + half]).collect();
        let bounds = Value::Vec3fVec(extent(&reach));
        self.attribute(path, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, bounds)?;
        let purpose = super::role::ProductRole::Render.purpose(self.model.purpose.as_deref());
        self.token(path, names::PURPOSE, purpose)?;
        if let Ok(material) = Path::new(&stitch.material) {
            if !stitch.material.is_empty() {
                self.schemas(path, &[Token::from(names::MATERIAL_BINDING_API)], false);
                self.target(path, names::MATERIAL_BINDING, &material)?;
            }
        }
        Ok(())
    }
}
