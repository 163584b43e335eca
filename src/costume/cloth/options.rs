//! Options of the cloth that a solver simulates.

use super::fabric::{FABRICS, Fabric};
use crate::codes;
use serde::{Deserialize, Serialize};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Subset};
use tailor_mesh::options::{Domain, OptionValue, options};

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

impl OptionValue for RestShape {}

options! {
    /// Options of this garment as simulated cloth.
    "cloth" => ClothOptions {
        /// Dialects of USD physics to write on the simulation mesh, of aousd, omni and chaos; empty writes none
        "physics" physics: Vec<String> = vec!["aousd".into()], Domain::Words { words: DIALECTS }, "names";

        /// Fabric of the garment: cotton, denim, wool, silk, leather or jersey, or the name of a fabric of the recipe
        "fabric" fabric: String = "cotton".into(), Domain::Fabric { words: FABRICS }, "name";

        /// Axis of the UV panels that the warp follows, u or v
        "warp" warp: String = "v".into(), Domain::Choice { words: &["u", "v"] }, "name of an axis";

        /// Shape without strain: panels are the UV shells as flat patterns, mesh is the simulation mesh, auto is panels
        /// if the shells are patterns of the mesh
        "rest" rest: RestShape = RestShape::Auto, Domain::Choice { words: &["auto", "mesh", "panels"] },
            "auto, mesh or panels";

        /// Edge and point subsets of this mesh that are held, or float primvars of points, held above 0.5
        "pins" pins: Vec<String> = Vec::new(), Domain::Sets { of: &["edge", "point"], required: false },
            "names of subsets";

        /// Prim that holds the pins; empty is the world
        "pinTarget" pin_target: String = String::new(), Domain::PrimPath, "path of a prim";

        /// Attach loose pieces, such as pockets, flaps and buttons, to the cloth below them
        "attach" attach: bool = true, Domain::Flag, "true or false";

        /// Write the flat panels of the shape at rest as the mesh `panels` beside the simulation mesh
        "panels" panels: bool = false, Domain::Flag, "true or false";

        /// Write a PhysicsScene with the gravity of the stage's units
        "scene" scene: bool = false, Domain::Flag, "true or false";
    }
}

impl ClothOptions {
    /// The family of the face subsets that the dialect `chaos` gets, and the start of their names.
    pub const PATTERN: &str = "pattern";

    /// Checks that no subset of a garment has a name that the dialect `chaos` needs.
    ///
    /// # Errors
    /// A subset that would be replaced.
    pub fn check_names(&self, garment: &Mesh) -> Result<(), Error> {
        let pattern = Self::PATTERN;
        let is_taken = |set: &&Subset| set.family == pattern || set.name.starts_with(&format!("{pattern}_"));
        let taken = garment.subsets.iter().find(is_taken).filter(|_| self.physics.iter().any(|name| name == "chaos"));
        if let Some(set) = taken {
            let fault =
                format!("chaos writes panels as subsets {pattern}_0, {pattern}_1, ... of a family \"{pattern}\"");
            let fault = format!("{fault}, and {} has the subset {} there", garment.prim, set.name);
            return Err(Error::recipe("cloth.physics", fault)
                .code(codes::NAME_TAKEN)
                .remedy("rename the subset and its family"));
        }
        Ok(())
    }
}

/// A number that is 0 for that of the preset.
const fn number(most: f32) -> Domain {
    Domain::Number { least: 0.0, most: None, or_zero: true, usual: [0.0, most], step: most / 100.0 }
}

options! {
    /// A fabric in SI units, of some face sets, or of the garment if cloth:fabric names it.
    "fabric" => FabricOptions {
        /// Face subsets of this mesh that are made of this fabric
        "faces" faces: Vec<String> = Vec::new(), Domain::Sets { of: &["face"], required: false }, "names of subsets";

        /// Preset that gives each value that is 0
        "preset" preset: String = "cotton".into(), Domain::Choice { words: FABRICS }, "name of a preset";

        /// Thickness; 0 is that of the preset
        "thickness" thickness: f32 = 0.0, number(0.005), "m";

        /// Mass of one square metre; 0 is that of the preset
        "density" density: f32 = 0.0, number(1.0), "kg/m2";

        /// Membrane stiffness along the warp; 0 is that of the preset
        "stretchWarp" stretch_warp: f32 = 0.0, number(50_000.0), "N/m";

        /// Membrane stiffness along the weft; 0 is that of the preset
        "stretchWeft" stretch_weft: f32 = 0.0, number(50_000.0), "N/m";

        /// Shear stiffness; 0 is that of the preset
        "shear" shear: f32 = 0.0, number(10_000.0), "N/m";

        /// Bending stiffness along the warp; 0 is that of the preset
        "bendWarp" bend_warp: f32 = 0.0, number(0.001), "N m";

        /// Bending stiffness along the weft; 0 is that of the preset
        "bendWeft" bend_weft: f32 = 0.0, number(0.001), "N m";

        /// Coefficient of friction, static and dynamic; 0 is that of the preset
        "friction" friction: f32 = 0.0, number(1.0), "coefficient";
    }
}

impl FabricOptions {
    /// The fabric.
    pub fn fabric(&self) -> Fabric {
        let preset = Fabric::preset(&self.preset).unwrap_or_default();
        preset.overridden([
            self.thickness,
            self.density,
            self.stretch_warp,
            self.stretch_weft,
            self.shear,
            self.bend_warp,
            self.bend_weft,
            self.friction,
        ])
    }
}
