//! Options of the cloth that a solver simulates.

use super::fabric::{FABRICS, Fabric};
use crate::error::{Error, ErrorCode};
use crate::garment::{Garment, Subset};
use crate::render::{Domain, Key, Kind};
use serde::{Deserialize, Serialize};

/// The dialects of USD physics that can be written.
pub const DIALECTS: &[&str] = &["aousd", "omni", "chaos"];

/// The shape of cloth without strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum RestShape {
    /// The UV panels where they are patterns of the mesh, else the mesh.
    #[default]
    Auto,
    /// The mesh.
    Mesh,
    /// The UV panels.
    Panels,
}

/// Options of the cloth: the attributes of `TailorClothAPI`, with the same names and defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct ClothOptions {
    /// The dialects of physics to write; empty: none.
    pub physics: Vec<String>,
    /// The fabric of the garment: a preset of `FABRICS`, or the name of a [`FabricOptions`].
    pub fabric: String,
    /// The axis of the UV panels that the warp follows: `u` or `v`.
    pub warp: String,
    /// The shape without strain.
    pub rest: RestShape,
    /// Point and edge subsets that are held.
    pub pins: Vec<String>,
    /// Path of the prim that holds them; empty: the world.
    pub pin_target: String,
    /// Whether loose pieces are attached to the cloth below them.
    pub attach: bool,
    /// Whether the panels at rest are written as a mesh.
    pub panels: bool,
    /// Whether a `PhysicsScene` is written.
    pub scene: bool,
}

impl Default for ClothOptions {
    fn default() -> Self {
        Self {
            physics: vec!["aousd".into()],
            fabric: "cotton".into(),
            warp: "v".into(),
            rest: RestShape::Auto,
            pins: Vec::new(),
            pin_target: String::new(),
            attach: true,
            panels: false,
            scene: false,
        }
    }
}

impl ClothOptions {
    /// The family of the face subsets that the dialect `chaos` gets, and the start of their names.
    pub(crate) const PATTERN: &str = "pattern";

    /// Checks the values without a garment.
    ///
    /// # Errors
    /// A value out of its range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        for name in &self.physics {
            one_of("cloth.physics", name, DIALECTS)?;
        }
        one_of("cloth.warp", &self.warp, &["u", "v"])?;
        if !self.pin_target.is_empty() && !self.pin_target.starts_with('/') {
            let fault = format!("\"{}\" is no absolute prim path", self.pin_target);
            return Err(Error::recipe("cloth.pinTarget", fault)
                .code(ErrorCode::PinTarget)
                .remedy("write it as /Body/hips, or leave it empty"));
        }
        Ok(())
    }

    /// Checks the names against a garment.
    ///
    /// # Errors
    /// A subset that the garment lacks, or of faces; subsets that the dialect `chaos` would replace.
    pub(crate) fn bind(&self, garment: &Garment) -> Result<(), Error> {
        let pattern = Self::PATTERN;
        let is_taken = |set: &&Subset| set.family == pattern || set.name.starts_with(&format!("{pattern}_"));
        let taken = garment.subsets.iter().find(is_taken).filter(|_| self.physics.iter().any(|name| name == "chaos"));
        if let Some(set) = taken {
            let fault =
                format!("chaos writes panels as subsets {pattern}_0, {pattern}_1, ... of a family \"{pattern}\"");
            let fault = format!("{fault}, and {} has the subset {} there", garment.prim, set.name);
            return Err(Error::recipe("cloth.physics", fault)
                .code(ErrorCode::NameTaken)
                .remedy("rename the subset and its family"));
        }
        let fits = |name: &&String| garment.subset(name).is_some_and(|set| set.elements.kind() != "face");
        let Some(name) = self.pins.iter().find(|name| !fits(name)) else { return Ok(()) };
        let known = garment.subsets.iter().filter(|set| set.elements.kind() != "face");
        let known: Vec<&str> = known.map(|set| set.name.as_str()).collect();
        let fault = format!("\"{name}\" is no edge or point subset of {}", garment.prim);
        Err(Error::recipe("cloth.pins", fault)
            .code(ErrorCode::UnknownSubset)
            .remedy(format!("its edge and point subsets are: {}", known.join(", "))))
    }
}

/// Options of a fabric, for the faces of some sets or as the fabric of the garment: the attributes of `TailorFabricAPI`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct FabricOptions {
    /// Face subsets of this fabric.
    pub faces: Vec<String>,
    /// The preset, one of `FABRICS`, that gives the values which are 0 below.
    pub preset: String,
    /// Thickness. \[m\] 0: that of the preset, as for all numbers here.
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
    /// Coefficient of friction.
    pub friction: f32,
}

impl Default for FabricOptions {
    fn default() -> Self {
        Self {
            faces: Vec::new(),
            preset: "cotton".into(),
            thickness: 0.0,
            density: 0.0,
            stretch_warp: 0.0,
            stretch_weft: 0.0,
            shear: 0.0,
            bend_warp: 0.0,
            bend_weft: 0.0,
            friction: 0.0,
        }
    }
}

impl FabricOptions {
    /// The descriptions of the options, in the order of the schema.
    pub const KEYS: &[Key] = &[
        Key { key: "faces", unit: "names", domain: Domain::FaceSets, meaning: "face subsets of this fabric" },
        Key {
            key: "preset",
            unit: "name",
            domain: Domain::Choice(FABRICS),
            meaning: "fabric that gives the values which are 0",
        },
        number("thickness", "m", 0.005, "thickness"),
        number("density", "kg/m2", 1.0, "mass of one square metre"),
        number("stretchWarp", "N/m", 50_000.0, "membrane stiffness along the warp"),
        number("stretchWeft", "N/m", 50_000.0, "membrane stiffness along the weft"),
        number("shear", "N/m", 10_000.0, "shear stiffness"),
        number("bendWarp", "N m", 0.001, "bending stiffness along the warp"),
        number("bendWeft", "N m", 0.001, "bending stiffness along the weft"),
        number("friction", "coefficient", 1.0, "friction, static and dynamic"),
    ];

    /// The kind of these options in a recipe.
    pub fn kind() -> Kind {
        let defaults = || serde_json::to_value(Self::default()).unwrap_or_default();
        Kind { name: "fabric", keys: Self::KEYS, defaults, is_operator: false }
    }

    fn numbers(&self) -> [(&'static str, f32); 8] {
        [
            ("thickness", self.thickness),
            ("density", self.density),
            ("stretchWarp", self.stretch_warp),
            ("stretchWeft", self.stretch_weft),
            ("shear", self.shear),
            ("bendWarp", self.bend_warp),
            ("bendWeft", self.bend_weft),
            ("friction", self.friction),
        ]
    }

    /// The fabric.
    pub fn fabric(&self) -> Fabric {
        let preset = Fabric::preset(&self.preset).unwrap_or_default();
        preset.overridden(self.numbers().map(|(_, value)| value))
    }

    /// Checks the values of the fabric `name` without a garment.
    ///
    /// # Errors
    /// A value out of its range.
    pub(crate) fn check(&self, name: &str) -> Result<(), Error> {
        one_of(&format!("fabric.{name}.preset"), &self.preset, FABRICS)?;
        for (field, value) in self.numbers() {
            if !(value.is_finite() && value >= 0.0) {
                let fault = Error::recipe(format!("fabric.{name}.{field}"), format!("{value} is out of range"));
                return Err(fault.remedy("give a positive number, or 0 for that of the preset"));
            }
        }
        Ok(())
    }
}

const fn number(key: &'static str, unit: &'static str, most: f32, meaning: &'static str) -> Key {
    Key { key, unit, domain: Domain::Number { least: 0.0, most, step: most / 100.0 }, meaning }
}

fn one_of(key: &str, value: &str, allowed: &[&str]) -> Result<(), Error> {
    if allowed.contains(&value) {
        return Ok(());
    }
    Err(Error::recipe(key, format!("\"{value}\" is not known")).remedy(format!("use one of: {}", allowed.join(", "))))
}
