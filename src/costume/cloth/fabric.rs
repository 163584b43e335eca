//! Fabrics: their mechanical properties in SI units, and the presets.
//!
//! The presets are rounded readings of the Kawabata evaluation system (KES-F), as textile laboratories report them, and
//! stand for a typical cloth of their kind. KES-F units convert as follows: a bending rigidity of 1 gf cm²/cm is 9.81e-5 N m,
//! a shear stiffness of 1 gf/(cm degree) is 56.2 N/m, and an extension of e at 500 gf/cm is a stiffness of 490 / e N/m.
//!
//! Sources: denim, *Journal of Textiles* 2016, article 4614168, table 5 (extension 5 %, bending 0.15 to 0.23, shear 1.5 to 3.4,
//! thickness 0.8 to 1.2 mm); the ranges of the others, Luible and Magnenat-Thalmann 2008, *The Simulation of Cloth Using
//! Accurate Physical Parameters*, and Ngo Ngoc and Boivin 2004, *Nonlinear Cloth Simulation* (INRIA RR-5099). Leather, which
//! KES-F does not measure, has a Young's modulus of 15 MPa.

use serde::Serialize;

/// Mechanical properties of a fabric. Warp is the direction of the panel's grain, weft lies across it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Fabric {
    /// Thickness. \[m\]
    pub thickness: f32,
    /// Mass of one square metre. \[kg/m²\]
    pub density: f32,
    /// Membrane stiffness along the warp. \[N/m\]
    pub stretch_warp: f32,
    /// Membrane stiffness along the weft. \[N/m\]
    pub stretch_weft: f32,
    /// Shear stiffness. \[N/m\]
    pub shear: f32,
    /// Bending stiffness along the warp. \[N m\]
    pub bend_warp: f32,
    /// Bending stiffness along the weft. \[N m\]
    pub bend_weft: f32,
    /// Coefficient of friction, static and dynamic.
    pub friction: f32,
}

/// Names of the presets.
pub const FABRICS: &[&str] = &["cotton", "denim", "wool", "silk", "leather", "jersey"];

impl Fabric {
    /// The preset called `name`, one of `FABRICS`.
    pub fn preset(name: &str) -> Option<Self> {
        Some(Self::of(match name {
            "cotton" => return Some(Self::default()),
            "denim" => [0.9e-3, 0.36, 11e3, 8e3, 110.0, 20e-6, 14e-6, 0.45],
            "wool" => [0.6e-3, 0.24, 8e3, 6e3, 35.0, 10e-6, 7e-6, 0.35],
            "silk" => [0.2e-3, 0.07, 14e3, 9e3, 20.0, 3e-6, 2e-6, 0.25],
            "leather" => [1.0e-3, 0.65, 15e3, 15e3, 5e3, 400e-6, 400e-6, 0.5],
            "jersey" => [0.6e-3, 0.17, 2e3, 1.2e3, 40.0, 3e-6, 2e-6, 0.4],
            _ => return None,
        }))
    }

    /// This fabric with the values that are not 0, in the order of their declaration.
    #[must_use]
    pub fn overridden(&self, values: [f32; 8]) -> Self {
        let mut all = self.values();
        all.iter_mut().zip(values).filter(|(_, value)| *value > 0.0).for_each(|(own, value)| *own = value);
        Self::of(all)
    }

    fn of([thickness, density, stretch_warp, stretch_weft, shear, bend_warp, bend_weft, friction]: [f32; 8]) -> Self {
        Self { thickness, density, stretch_warp, stretch_weft, shear, bend_warp, bend_weft, friction }
    }

    /// The properties as an array, in the order of their declaration.
    fn values(&self) -> [f32; 8] {
        let Self { thickness, density, stretch_warp, stretch_weft, shear, bend_warp, bend_weft, friction } = *self;
        [thickness, density, stretch_warp, stretch_weft, shear, bend_warp, bend_weft, friction]
    }

    /// The weighted mean of some fabrics, property by property; `None` without weight.
    pub fn mean(parts: impl Iterator<Item = (Self, f64)>) -> Option<Self> {
        let (mut sums, mut weight) = ([0.0; 8], 0.0);
        for (fabric, w) in parts {
            weight += w;
            sums.iter_mut().zip(fabric.values()).for_each(|(sum, value)| *sum += w * f64::from(value));
        }
        (weight > 0.0).then(|| Self::of(sums.map(|sum| (sum / weight) as f32)))
    }

    /// Membrane stiffness of an isotropic solver: the mean of warp and weft. \[N/m\]
    pub fn stretch(&self) -> f32 {
        0.5 * (self.stretch_warp + self.stretch_weft)
    }

    /// Bending stiffness of an isotropic solver: the mean of warp and weft. \[N m\]
    pub fn bend(&self) -> f32 {
        0.5 * (self.bend_warp + self.bend_weft)
    }
}

impl Default for Fabric {
    /// Cotton.
    fn default() -> Self {
        Self::of([0.4e-3, 0.14, 12e3, 9e3, 60.0, 8e-6, 5e-6, 0.4])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_complete_and_their_mean_lies_between() {
        let all: Vec<Fabric> = FABRICS.iter().filter_map(|name| Fabric::preset(name)).collect();
        assert_eq!(all.len(), FABRICS.len());
        assert!(all.iter().all(|fabric| fabric.values().iter().all(|v| *v > 0.0)));
        let mean = Fabric::mean([(all[0], 1.0), (all[1], 3.0)].into_iter()).expect("a weight");
        assert!((mean.density - 0.305).abs() < 1e-6);
        assert_eq!(Fabric::mean(std::iter::empty()), None);
    }
}
