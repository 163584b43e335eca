//! Heights within the clearance to other cloth.

use super::Placement;
use crate::contact::Clearance;
use crate::render::operator::{Control, ControlRole, LayerEnd, OperatorOutput};
use crate::render::repair::LEAST_SHARE;
use glam::Vec3;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::subdivide::{Level, edges_at};

/// Share of the remaining clearance that an operator may use, so that later operators have some.
const CLEARANCE_SHARE: f32 = 0.5;
/// Share of the distance between two layers that is the clearance of later operators on each.
const LAYER_GAP_SHARE: f32 = 0.8;

impl Placement {
    /// The heights within the clearance, which is reduced by them. A copy that other cloth leaves too little room lifts its
    /// original to the other side by what it lacks.
    pub(super) fn within_clearance(
        &self,
        asked: &[f32],
        targets: &[(Vec3, Vec3)],
        clearance: &mut IdVec<VertexId, Clearance>,
        is_last: bool,
    ) -> Vec<f32> {
        let mut all = vec![0.0; asked.len()];
        for (i, (control, &asked)) in self.output().controls.iter().zip(asked).enumerate() {
            // A surface that doubles back on itself has no normal there.
            let asked = if targets[i].1 == Vec3::ZERO { 0.0 } else { asked };
            let origin = control.role.original().unwrap_or(control.vertex);
            let (side, height) = (usize::from(asked > 0.0), asked.abs());
            // The last operator may use all but what a layer and its original need between them.
            let is_layer = control.role.original().is_some();
            let share = if is_last && !is_layer { 1.0 } else { CLEARANCE_SHARE };
            let given = height.min((share * clearance[origin][side]).max(LEAST_SHARE * height));
            match control.role.original() {
                Some(over) => {
                    let lift = self.lifted[i].map_or(0.0, |original| {
                        // Where both sides are tight, a lift would only press the cloth there.
                        let (lacks, room) = (height - given, CLEARANCE_SHARE * clearance[over][1 - side]);
                        let lift = (room - lacks).min(lacks).max(0.0);
                        all[original] = lift.copysign(-asked);
                        lift
                    });
                    // Both layers share the gap between them. The normal of the second one is reversed.
                    let (between, rest) = (LAYER_GAP_SHARE * (given + lift), clearance[over][side] - given);
                    clearance[control.vertex][side] = between;
                    clearance[control.vertex][1 - side] = rest.max(0.0);
                    clearance[over][side] = between;
                    clearance[over][1 - side] -= lift;
                }
                None => clearance[origin][side] -= given,
            }
            all[i] = given.copysign(asked);
        }
        all
    }
}

/// For each control, that of its original if it is a copy away from the ends of its layer: the surface goes on beside those.
pub fn lifted(output: &OperatorOutput, level: &Level) -> Vec<Option<usize>> {
    let t = &level.topology;
    let is_end = |v: VertexId| edges_at(t, v).any(|e| t.is_border(e));
    let originals = output.index(|role| role.original().is_none());
    let of = |control: &Control| match control.role {
        ControlRole::Copy { of, closing: LayerEnd::Open, .. } if !is_end(control.vertex) => originals[of],
        _ => None,
    };
    output.controls.iter().map(of).collect()
}
