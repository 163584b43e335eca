//! Subsets on the simulation mesh: those of the garment, and those that say where its creases, borders and seams are.

use super::coverage::Coverage;
use super::edge::{Carried, Edges};
use super::{Net, SetCurve, Sites, face};
use crate::error::{Warning, Warnings};
use crate::garment::{Elements, Family, FamilyType, Garment, Subset};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::sim::{Chain, SimOptions, SimProduct};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Family of the subsets that say which edges were constraints.
const CONSTRAINT_FAMILY: &str = "tailorConstraints";
/// The share of area by which a face set is to agree with its source.
const AGREEMENT: f64 = 0.97;
/// Families of the subsets that hold the garment's creases and corners.
const CREASE_FAMILY: &str = "tailorCreases";
const CORNER_FAMILY: &str = "tailorCorners";

/// The subsets of a simulation mesh.
pub(super) struct Subsets {
    pub subsets: Vec<Subset>,
    pub families: Vec<Family>,
    pub curves: Vec<SetCurve>,
    /// Faces that were given to a neighbour's set.
    pub islands: usize,
}

/// The edge sets on the simulation mesh, which need no samples.
pub(super) struct EdgeSets<'a> {
    edges: Edges<'a>,
    /// The subsets of the garment, and those of its creases and corners.
    sources: Vec<Subset>,
    carried: Vec<Carried>,
}

impl<'a> EdgeSets<'a> {
    pub fn new(garment: &Garment, product: &'a SimProduct, net: &'a Net) -> Self {
        let mut sources = garment.subsets.to_vec();
        sources.extend(sharp_sets(garment));
        let edges = Edges::new(product, &net.topology);
        let carried = edges.carry_all(&edges_of(&sources));
        Self { edges, sources, carried }
    }
}

/// The garment's subsets on the simulation mesh, those of its creases, borders and seams, and the families.
pub(super) fn carry(
    garment: &Garment,
    product: &SimProduct,
    coverage: &Coverage,
    sites: &Sites<'_>,
    options: &SimOptions,
    edge_sets: EdgeSets<'_>,
) -> (Subsets, Warnings) {
    let mut warnings = Warnings::default();
    let EdgeSets { edges, sources, carried: mut edge_sets } = edge_sets;
    let face::FaceSets { sets: mut face_sets, islands } = face::sets(garment, coverage, sites, options.clean_islands);
    warnings_of_small_sets(garment, &face_sets, coverage).into_iter().for_each(|w| warnings.push(w));
    face_sets.resize(sources.len(), None);
    let is_edges = |(s, _): &(&Subset, &Carried)| matches!(s.elements, Elements::Edges(_));
    let curves = sources.iter().zip(&edge_sets).filter(is_edges).map(|(s, carried)| SetCurve {
        name: s.name.clone(),
        length: carried.source_length,
        farthest: carried.farthest,
        shortest: carried.shortest,
    });
    let curves = curves.collect();
    let mut subsets: Vec<Subset> = Vec::with_capacity(sources.len() + 2);
    for (i, source) in sources.into_iter().enumerate() {
        let elements = match &source.elements {
            Elements::Faces(_) => Elements::Faces(face_sets[i].take().unwrap_or_default()),
            Elements::Edges(_) => Elements::Edges(told(&source, std::mem::take(&mut edge_sets[i]), &mut warnings)),
            Elements::Points(points) => Elements::Points(nearest_points(points, garment, &edges)),
        };
        if matches!(elements, Elements::Faces(_)) && elements.is_empty() && !source.elements.is_empty() {
            warnings.push(Warning::NotCarried {
                what: format!("all faces of subset {} on the simulation mesh", source.name),
                why: "the set covers most of no triangle; lower sim.maxEdgeLength".into(),
            });
        }
        subsets.push(Subset { elements, ..source });
    }
    subsets.extend(constraint_sets(garment, product, options));
    let families = families(garment, &subsets);
    (Subsets { subsets, families, curves, islands }, warnings)
}

/// A warning of face sets that the triangles follow too roughly.
fn warnings_of_small_sets(garment: &Garment, sets: &[Option<Vec<FaceId>>], coverage: &Coverage) -> Option<Warning> {
    let agreement = |(subset, set): (&Subset, &Option<Vec<FaceId>>)| match (&subset.elements, set) {
        // A set that covers most of no triangle has a warning of its own.
        (Elements::Faces(source), Some(set)) if !set.is_empty() => {
            Some((subset.name.clone(), coverage.agreement(source, set)))
        }
        _ => None,
    };
    let found = garment.subsets.iter().zip(sets).filter_map(agreement);
    let (sets, agreements): (Vec<String>, Vec<f64>) = found.filter(|(_, own)| *own < AGREEMENT).unzip();
    let least = agreements.iter().copied().reduce(f64::min)?;
    Some(Warning::SetsBlurred { sets, least: least as f32 })
}

/// The edges of each subset; none of those of faces and points.
fn edges_of(subsets: &[Subset]) -> Vec<Vec<[VertexId; 2]>> {
    let edges = |s: &Subset| match &s.elements {
        Elements::Edges(edges) => edges.clone(),
        _ => Vec::new(),
    };
    subsets.iter().map(edges).collect()
}

/// The families of the garment, and our own as far as they have members.
fn families(garment: &Garment, subsets: &[Subset]) -> Vec<Family> {
    let mut families: Vec<Family> = garment.families.iter().map(|f| carried_family(garment, f)).collect();
    for name in [CREASE_FAMILY, CORNER_FAMILY, CONSTRAINT_FAMILY] {
        if subsets.iter().any(|s| s.family == name) && families.iter().all(|f| f.name != name) {
            families.push(Family { name: name.into(), kind: FamilyType::Unrestricted });
        }
    }
    families
}

/// A partition of edges or points covers no other edges or points, so it is none on another mesh.
fn carried_family(garment: &Garment, family: &Family) -> Family {
    let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
    let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
    let kind = if of_faces { family.kind } else { FamilyType::Unrestricted };
    Family { name: family.name.clone(), kind }
}

/// The edges of a set, with a warning of those that are lost.
fn told(source: &Subset, carried: Carried, warnings: &mut Warnings) -> Vec<[VertexId; 2]> {
    if carried.lost > 0 {
        warnings.push(Warning::NotCarried {
            what: format!(
                "{} of {} edges of subset {} on the simulation mesh",
                carried.lost,
                source.elements.len(),
                source.name
            ),
            why: "they lie between holes, or no edges of the mesh are near them; name the subset in \
                  tailor:sim:constraints, or lower sim.maxEdgeLength"
                .into(),
        });
    }
    if carried.merged > 0 {
        warnings.push(Warning::NotCarried {
            what: format!(
                "{} chains of subset {} as chains of their own on the simulation mesh",
                carried.merged, source.name
            ),
            why: "the mesh has too few vertices to keep them apart from others of the set; name the subset in \
                  tailor:sim:constraints, or lower sim.maxEdgeLength"
                .into(),
        });
    }
    carried.edges
}

/// The garment's creases and corners as subsets, one for each sharpness.
fn sharp_sets(garment: &Garment) -> Vec<Subset> {
    // Sharpness is not negative, so that its bits are in its order.
    let mut creases: BTreeMap<u32, BTreeSet<[VertexId; 2]>> = BTreeMap::new();
    for crease in &garment.creases {
        for (pair, sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            let edge = [pair[0].min(pair[1]), pair[0].max(pair[1])];
            creases.entry(sharpness.to_bits()).or_default().insert(edge);
        }
    }
    let mut corners: BTreeMap<u32, BTreeSet<VertexId>> = BTreeMap::new();
    for corner in &garment.corners {
        corners.entry(corner.sharpness.to_bits()).or_default().insert(corner.vertex);
    }
    let creases = creases.into_iter().map(|(s, e)| (CREASE_FAMILY, s, Elements::Edges(e.into_iter().collect())));
    let corners = corners.into_iter().map(|(s, p)| (CORNER_FAMILY, s, Elements::Points(p.into_iter().collect())));
    let mut sets: Vec<Subset> = Vec::new();
    for (family, bits, elements) in creases.chain(corners).filter(|(_, bits, _)| f32::from_bits(*bits) > 0.0) {
        let name = free_name(family, |name| garment.subset(name).is_some() || sets.iter().any(|s| s.name == name));
        sets.push(Subset { name, family: family.into(), elements, sharpness: Some(f32::from_bits(bits)) });
    }
    sets
}

/// A name that is not taken: `base`, or that with a number.
fn free_name(base: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut numbered = (1..).map(|n| if n == 1 { base.to_owned() } else { format!("{base}_{n}") });
    numbered.find(|name| !is_taken(name)).unwrap_or_default()
}

/// Each edge once, in order: a chain between two cut pieces may be there from both sides.
fn unique(edges: impl Iterator<Item = [VertexId; 2]>) -> Vec<[VertexId; 2]> {
    let mut seen = BTreeSet::new();
    edges.filter(|&[a, b]| seen.insert([a.min(b), a.max(b)])).collect()
}

/// The borders and seams of the simulation mesh as edge subsets of their own.
fn constraint_sets(garment: &Garment, product: &SimProduct, options: &SimOptions) -> Vec<Subset> {
    let mut sets = Vec::new();
    for (name, of_seams) in [("tailorBorders", false), ("tailorSeams", true)] {
        let wanted = !of_seams || options.constrain_uv_seams;
        let is_in = |c: &Chain| if of_seams { c.kind.seam } else { c.kind.border };
        let chains = product.baseline.chains.enumerated().filter(|(_, c)| is_in(c));
        let edges = unique(chains.flat_map(|(id, _)| product.chain_edges[id].iter().copied()));
        if wanted && !edges.is_empty() {
            let name = free_name(name, |name| garment.subset(name).is_some());
            let family = CONSTRAINT_FAMILY.into();
            sets.push(Subset { name, family, elements: Elements::Edges(edges), sharpness: None });
        }
    }
    sets
}

/// The nearest point of the simulation mesh to each point of a subset, on the same chain or part of the surface; to a
/// point that is cut apart, one on each side.
fn nearest_points(points: &[VertexId], garment: &Garment, edges: &Edges<'_>) -> Vec<VertexId> {
    let product = edges.surface.product;
    let mut found: Vec<VertexId> = Vec::with_capacity(points.len());
    for point in points {
        let before = found.len();
        found.extend(edges.vertices_of(*point).iter().filter_map(|&v| edges.surface.nearest(v, |_| true)));
        if found.len() == before {
            // Of no face, or of holes alone.
            found.extend(nearest(&product.points, garment.points[*point]));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The point nearest to a position, the lowest of equals; none if there are no points. Every point is tried: few positions
/// need this.
fn nearest(points: &IdVec<VertexId, Vec3>, position: Vec3) -> Option<VertexId> {
    let off = |v: VertexId| points[v].distance_squared(position);
    points.ids().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_the_lowest_of_equals_and_far_positions_find_one() {
        let points: IdVec<VertexId, Vec3> = [2.0, 1.0, -1.0, 1.0].map(|x| Vec3::new(x, 0.0, 0.0)).to_vec().into();
        let found = |x, y, z| nearest(&points, Vec3::new(x, y, z)).map(VertexId::index);
        assert_eq!(found(0.0, 0.0, 0.0), Some(1));
        assert_eq!(found(1.5, 0.0, 0.0), Some(0));
        assert_eq!(found(1e6, 1e6, -1e6), Some(0));
        assert_eq!(nearest(&IdVec::new(), Vec3::ZERO), None);
    }
}
