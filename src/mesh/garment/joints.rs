//! Skinning: joint influences are merged by joint, as slots of neighbours may hold different joints.

use super::{Interpolation, Mesh, Primvar, Values};
use rayon::prelude::*;
use std::sync::Arc;

/// Names of the primvars that hold a mesh's influences (`UsdSkelBindingAPI`).
pub const JOINT_INDICES: &str = "skel:jointIndices";
/// See [`JOINT_INDICES`].
pub const JOINT_WEIGHTS: &str = "skel:jointWeights";

/// The influences of one element: joints, ascending, with their weights.
pub type Influences = Vec<(i32, f32)>;

/// Whether a primvar holds the joints or the weights of the influences, which are carried together.
pub fn is_influence(garment: &Mesh, primvar: &Primvar) -> bool {
    [JOINT_INDICES, JOINT_WEIGHTS].contains(&primvar.name.as_str()) && pair(garment).is_some()
}

/// The joints and weights of a mesh with influences per vertex.
pub fn pair(garment: &Mesh) -> Option<(&Primvar, &Primvar)> {
    let indices = garment.primvar(JOINT_INDICES)?;
    let weights = garment.primvar(JOINT_WEIGHTS)?;
    let fits = indices.interpolation == Interpolation::Vertex
        && weights.interpolation == Interpolation::Vertex
        && indices.width() == weights.width()
        && matches!((&indices.values, &weights.values), (Values::I32(_), Values::F32(_)));
    fits.then_some((indices, weights))
}

/// The influences of each vertex.
pub fn influences(indices: &Primvar, weights: &Primvar) -> Vec<Influences> {
    let (Values::I32(joints), Values::F32(amounts)) = (&indices.values, &weights.values) else {
        unreachable!("`pair` gives integer joints and real weights")
    };
    let width = indices.width();
    let of = |vertex: usize| {
        let (j, w) = (indices.row(vertex) * width, weights.row(vertex) * width);
        merge(joints[j..j + width].iter().copied().zip(amounts[w..w + width].iter().copied()))
    };
    (0..indices.elements()).map(of).collect()
}

/// Sums weights joint by joint.
pub fn merge(parts: impl Iterator<Item = (i32, f32)>) -> Influences {
    let mut merged: Influences = Vec::with_capacity(8);
    for (joint, weight) in parts.filter(|(_, w)| *w != 0.0) {
        match merged.binary_search_by_key(&joint, |m| m.0) {
            Ok(at) => merged[at].1 += weight,
            Err(at) => merged.insert(at, (joint, weight)),
        }
    }
    merged
}

/// The weighted sum of several elements' influences.
pub fn blend<'a>(parts: impl Iterator<Item = (&'a Influences, f32)>) -> Influences {
    merge(parts.flat_map(|(influences, share)| influences.iter().map(move |&(j, w)| (j, w * share))))
}

/// Joints and weights as primvars: the `elementSize` heaviest influences of each element, scaled to the sum of all.
pub fn to_primvars(all: &[Influences], indices: &Primvar, weights: &Primvar) -> [Primvar; 2] {
    let width = indices.width();
    let pruned = all.par_iter().flat_map_iter(|influences| pruned(influences, width));
    let (joints, amounts) = pruned.unzip();
    [
        Primvar { values: Values::I32(joints), indices: None, ..indices.clone() },
        Primvar { values: Values::F32(amounts), indices: None, ..weights.clone() },
    ]
}

/// The `width` heaviest influences, scaled to the sum of all and padded with zeros.
fn pruned(influences: &Influences, width: usize) -> Influences {
    let mut kept = influences.clone();
    // Heaviest first; of equal weights, the lowest joint.
    kept.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    kept.truncate(width);
    let sum: f32 = influences.iter().map(|i| i.1).sum();
    let left: f32 = kept.iter().map(|i| i.1).sum();
    let scale = if kept.len() < influences.len() && left != 0.0 { sum / left } else { 1.0 };
    kept.iter_mut().for_each(|i| i.1 *= scale);
    kept.resize(width, (0, 0.0));
    kept
}

impl Mesh {
    /// Makes the influences of the two primvars a list for each vertex, which operators and refinements blend.
    pub fn unpack_influences(&mut self) {
        self.influences = pair(self).map(|(indices, weights)| Arc::new(influences(indices, weights)));
    }

    /// Puts the influences back in their primvars.
    pub fn pack_influences(&mut self) {
        let Some(all) = self.influences.take() else { return };
        let Some((indices, weights)) = pair(self) else { return };
        for primvar in to_primvars(&all, indices, weights) {
            if let Some(own) = Arc::make_mut(&mut self.primvars).iter_mut().find(|p| p.name == primvar.name) {
                *own = primvar;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pruned_influences_keep_their_sum() {
        let template = Primvar {
            name: String::new(),
            role: super::super::PrimvarRole::Primvar,
            meaning: super::super::Meaning::Plain,
            half: false,
            interpolation: Interpolation::Vertex,
            components: 1,
            element_size: 2,
            values: Values::I32(vec![]),
            indices: None,
        };
        let [joints, weights] = to_primvars(&[vec![(0, 0.2), (3, 0.5), (7, 0.3)]], &template, &template);
        assert_eq!(joints.values, Values::I32(vec![3, 7]));
        let Values::F32(w) = weights.values else { panic!("weights are real") };
        assert!((w[0] + w[1] - 1.0).abs() < 1e-6 && (w[0] / w[1] - 5.0 / 3.0).abs() < 1e-5);
    }
}
