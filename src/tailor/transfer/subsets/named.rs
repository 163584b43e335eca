//! Subsets that name creases and corners of the garment, and the constraints of the simulation mesh.

use crate::sim::{Chain, SimProduct};
use crate::transfer::correspondence::Correspondence;
use crate::transfer::topology::edge_key;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{Topology, VertexId};
use tailor_mesh::garment::{CONSTRAINTS, Elements, Mesh, Primvar, Subset, UvSeams, free_name};

/// Families of the subsets of creases, corners and constraints.
pub(super) const FAMILIES: [&str; 3] = ["tailorCreases", "tailorCorners", CONSTRAINTS];

/// The garment's creases and corners as subsets, one for each sharpness.
pub(super) fn sharp_sets(garment: &Mesh) -> Vec<Subset> {
    // The bits of sharpnesses, which are not negative, sort as the sharpnesses do.
    let mut creases: BTreeMap<u32, BTreeSet<[VertexId; 2]>> = BTreeMap::new();
    for crease in &garment.creases {
        for (pair, sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            creases.entry(sharpness.to_bits()).or_default().insert(edge_key([pair[0], pair[1]]));
        }
    }
    let mut corners: BTreeMap<u32, BTreeSet<VertexId>> = BTreeMap::new();
    for corner in &garment.corners {
        corners.entry(corner.sharpness.to_bits()).or_default().insert(corner.vertex);
    }
    let [of_creases, of_corners, _] = FAMILIES;
    let creases = creases.into_iter().map(|(s, e)| (of_creases, s, Elements::Edges(e.into_iter().collect())));
    let corners = corners.into_iter().map(|(s, p)| (of_corners, s, Elements::Points(p.into_iter().collect())));
    let mut sets: Vec<Subset> = Vec::new();
    for (family, bits, elements) in creases.chain(corners).filter(|(_, bits, _)| f32::from_bits(*bits) > 0.0) {
        let name = free_name(family, |name| garment.subset(name).is_some() || sets.iter().any(|s| s.name == name));
        sets.push(Subset { name, family: family.into(), elements, sharpness: Some(f32::from_bits(bits)) });
    }
    sets
}

/// The borders and seams of the simulation mesh as edge subsets. Where seams do not constrain, they are the cuts of `uvs`.
pub(super) fn constraint_sets(garment: &Mesh, map: &Correspondence<'_>, uvs: Option<&Primvar>) -> Vec<Subset> {
    let product = map.product;
    let borders = constrained_edges(product, |chain| chain.kind.border);
    let seams = match uvs {
        Some(uvs) if !product.baseline.has_uvs => cut_edges(uvs, &map.mesh.topology),
        _ => constrained_edges(product, |chain| chain.kind.seam),
    };
    let sets = [("tailorBorders", borders), ("tailorSeams", seams)].into_iter().filter(|(_, edges)| !edges.is_empty());
    let set = |(name, edges)| Subset {
        name: free_name(name, |name| garment.subset(name).is_some()),
        family: FAMILIES[2].into(),
        elements: Elements::Edges(edges),
        sharpness: None,
    };
    sets.map(set).collect()
}

/// The edges across which UVs differ.
fn cut_edges(uvs: &Primvar, t: &Topology) -> Vec<[VertexId; 2]> {
    let seams = UvSeams::new(uvs, t);
    t.edges.enumerated().filter(|(edge, _)| seams.is_cut(t, *edge)).map(|(_, &ends)| ends).collect()
}

/// The edges of some chains, each once: a chain between two pieces that were cut apart is there for both.
fn constrained_edges(product: &SimProduct, is_in: impl Fn(&Chain) -> bool) -> Vec<[VertexId; 2]> {
    let chains = product.baseline.chains.enumerated().filter(|(_, chain)| is_in(chain));
    let mut seen = BTreeSet::new();
    let edges = chains.flat_map(|(id, _)| product.chain_edges[id].iter().copied());
    edges.filter(|&edge| seen.insert(edge_key(edge))).collect()
}
