//! The cost of constraints: the thin triangles beside them.

use super::min_angle;
use crate::sim::{ChainKind, SimProduct};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::garment::Mesh;

/// Smallest angle below which a triangle is thin. \[degrees\]
const THIN: f32 = 30.0;

/// The triangles beside the chains of one constraint. One that touches several counts for each.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ConstraintCost {
    /// `borders`, `uvSeams`, `creases`, `featureLines`, or the name of an edge set of `sim.constraints`.
    pub constraint: String,
    /// Triangles beside it with an angle below 30 degrees.
    pub thin: usize,
    /// All triangles beside it.
    pub triangles: usize,
}

/// The constraints of a simulation mesh, those with the most thin triangles first.
pub(super) fn constraint_costs(product: &SimProduct, mesh: &Mesh) -> Vec<ConstraintCost> {
    let names = product.baseline.chains.iter().map(|chain| names(&chain.kind, mesh));
    let mut at = BTreeMap::<VertexId, BTreeSet<&str>>::new();
    for (edges, names) in product.chain_edges.iter().zip(names) {
        edges.iter().flatten().for_each(|&v| at.entry(v).or_default().extend(&names));
    }
    let mut costs = BTreeMap::<&str, [usize; 2]>::new();
    for t in &product.triangles {
        let beside: BTreeSet<&str> = t.iter().filter_map(|v| at.get(v)).flatten().copied().collect();
        if beside.is_empty() {
            continue;
        }
        let is_thin = min_angle(t.map(|v| product.points[v])) < THIN;
        for name in beside {
            let [thin, all] = costs.entry(name).or_default();
            *thin += usize::from(is_thin);
            *all += 1;
        }
    }
    let cost =
        |(name, [thin, triangles]): (&str, [usize; 2])| ConstraintCost { constraint: name.into(), thin, triangles };
    let mut costs: Vec<ConstraintCost> = costs.into_iter().map(cost).collect();
    costs.sort_by(|a, b| b.thin.cmp(&a.thin).then_with(|| a.constraint.cmp(&b.constraint)));
    costs
}

/// The constraints of a chain. Its edge sets count where it has no other one: without them, the others would hold it.
fn names<'a>(kind: &ChainKind, mesh: &'a Mesh) -> Vec<&'a str> {
    let kinds =
        [(kind.border, "borders"), (kind.seam, "uvSeams"), (kind.sharp, "creases"), (kind.feature, "featureLines")];
    let names: Vec<&str> = kinds.into_iter().filter(|(is, _)| *is).map(|(_, name)| name).collect();
    if names.is_empty() {
        return kind.subsets.iter().filter_map(|&i| mesh.subsets.get(i)).map(|set| set.name.as_str()).collect();
    }
    names
}
