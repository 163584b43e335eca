//! The stages of a render mesh in their order. Who runs them decides whether results are kept.
//!
//! An operator and a refinement are two stages each: what the mesh is made of, and where its points are. A stage is known
//! by its name and by what it depends on beside the garment: the connectivity on `structure`, the points on `options`.

use super::placed::{Placed, Room};
use super::shape::{Formed, Operator};
use super::{Stack, check_size, first_cage};
use crate::error::{Error, Warnings};
use crate::garment::Garment;
use crate::memo::{Footprint, Made};
use crate::mesh::{IdVec, VertexId};
use crate::subdivide::Cage;
use serde::Serialize;
use std::sync::Arc;

/// Where results of stages come from.
pub trait Stages {
    /// The result of a stage, which depends on the garment and on `options` alone.
    ///
    /// # Errors
    /// What `make` reports.
    fn get<V: Footprint + Send + Sync + 'static>(
        &self,
        name: &'static str,
        options: &impl Serialize,
        make: impl FnOnce() -> Result<V, Error> + Send,
    ) -> Result<Arc<V>, Error>;
}

/// Every stage is made, and none is kept.
pub struct Afresh;

impl Stages for Afresh {
    fn get<V: Footprint + Send + Sync + 'static>(
        &self,
        _: &'static str,
        _: &impl Serialize,
        make: impl FnOnce() -> Result<V, Error> + Send,
    ) -> Result<Arc<V>, Error> {
        make().map(Arc::new)
    }
}

/// A render mesh.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The mesh.
    pub mesh: Garment,
    /// Names of the face sets that operators made.
    pub sets: Vec<String>,
    /// What was met on the way.
    pub warnings: Warnings,
}

/// The cage after operators.
struct Operated {
    cage: Arc<dyn AsCage>,
    clearance: Arc<IdVec<VertexId, Room>>,
    placed: Arc<Made<Placed>>,
    structure: Vec<String>,
    options: Vec<String>,
    sets: Vec<String>,
    warnings: Warnings,
}

/// The render mesh of a checked garment.
///
/// A polygonal mesh (`subdivisionScheme = "none"`) is refined as if bilinear and stays polygonal.
///
/// # Errors
/// Operators that do not fit the garment; a mesh that would be too large.
pub fn render(garment: &Garment, stack: &Stack, stages: &impl Stages) -> Result<Rendered, Error> {
    if stack.level == 0 && stack.operators.is_empty() {
        return Ok(Rendered { mesh: garment.clone(), sets: Vec::new(), warnings: stack.warnings.clone() });
    }
    let operated = operate(garment, stack, stages)?;
    check_size(operated.cage.cage().garment(), stack.level)?;
    let mesh = refine(&operated, stack.level, stages)?;
    Ok(Rendered { mesh, sets: operated.sets, warnings: operated.warnings })
}

fn operate(garment: &Garment, stack: &Stack, stages: &impl Stages) -> Result<Operated, Error> {
    let cage: Arc<dyn AsCage> = stages.get("cage", &(), || Ok(first_cage(garment)))?;
    // All heights depend on how far gaps were looked for.
    let reach = stack.reach(garment);
    let placed = stages.get("first", &reach, || Ok(Made::from(Placed::first(cage.cage(), reach))))?;
    let (structure, options, sets) = (Vec::new(), vec![reach.to_string()], Vec::new());
    let clearance = Arc::new(placed.value.rooms.clone());
    let warnings = stack.warnings.clone();
    let mut operated = Operated { cage, clearance, placed, structure, options, sets, warnings };
    for operator in &stack.operators {
        operated.apply(operator.as_ref(), stages)?;
    }
    Ok(operated)
}

impl Operated {
    fn apply(&mut self, operator: &dyn Operator, stages: &impl Stages) -> Result<(), Error> {
        self.structure.push(operator.structure());
        // The same for every reach, as operators ask for no clearance beyond their own.
        let formed =
            stages.get("form", &self.structure, || Formed::new(operator, self.cage.cage(), &self.clearance))?;
        let ground =
            stages.get("ground", &(&self.structure, &self.options), || Ok(formed.ground(&self.placed.value)))?;
        self.options.push(operator.options());
        self.placed = stages.get("points", &self.options, || {
            let (value, warnings) = formed.raised(operator, &ground);
            Ok(Made { value, warnings })
        })?;
        self.sets.extend(formed.shape.subsets.iter().map(|set| set.name.clone()));
        self.warnings.extend(&formed.shape.warnings);
        self.warnings.extend(&self.placed.warnings);
        self.clearance = Arc::clone(&formed.clearance);
        self.cage = formed;
        Ok(())
    }
}

fn refine(operated: &Operated, level: u32, stages: &impl Stages) -> Result<Garment, Error> {
    let Operated { structure, options, placed, .. } = operated;
    let mut cage = Arc::clone(&operated.cage);
    let mut points = Arc::new(placed.value.points.clone());
    for step in 1..=level {
        points = stages.get("level points", &(options, step), || Ok(cage.cage().refined_points(&points)))?;
        if step < level {
            cage = stages.get("level", &(structure, step), || Ok(cage.cage().refined()))?;
        }
    }
    let finished = stages.get("attributes", &(structure, level), || {
        Ok(if level == 0 { cage.cage().clone().into_garment() } else { cage.cage().refined_garment() })
    })?;
    // Attributes are shared with those of other points.
    Ok(Garment { points: Arc::unwrap_or_clone(points), ..Garment::clone(&finished) })
}

/// A stage that has a cage.
trait AsCage: Send + Sync {
    fn cage(&self) -> &Cage;
}

impl AsCage for Cage {
    fn cage(&self) -> &Cage {
        self
    }
}

impl AsCage for Formed {
    fn cage(&self) -> &Cage {
        &self.cage
    }
}
