//! Subsets on the simulation mesh.

use super::Sites;
use crate::error::{Warning, Warnings};
use crate::garment::{Elements, Family, FamilyType, Garment, Subset};
use crate::mesh::{FaceId, IdVec, VertexId};
use crate::sim::{Chain, SimOptions, SimProduct};
use crate::spatial::PointGrid;
use std::collections::{BTreeMap, BTreeSet};

/// Family of the subsets that say which edges were constraints.
const CONSTRAINT_FAMILY: &str = "tailorConstraints";

/// The garment's subsets on the simulation mesh, those of its borders and seams, and the families.
pub(super) fn carry(
    garment: &Garment,
    product: &SimProduct,
    sites: &Sites,
    options: &SimOptions,
    warnings: &mut Warnings,
) -> (Vec<Subset>, Vec<Family>) {
    let by_face = Children::new(garment, sites);
    let points = OnceGrid::default();
    let mut subsets: Vec<Subset> = Vec::with_capacity(garment.subsets.len() + 2);
    for (i, subset) in garment.subsets.iter().enumerate() {
        let elements = match &subset.elements {
            Elements::Faces(faces) => Elements::Faces(by_face.of(faces)),
            Elements::Edges(edges) => Elements::Edges(edge_set(i, subset, edges, product, warnings)),
            Elements::Points(points_of) => Elements::Points(nearest_points(points_of, garment, product, &points)),
        };
        // An edge set that nothing could be carried of has its warning; an empty one would look like data.
        let is_gone = matches!(elements, Elements::Edges(_)) && elements.is_empty() && !subset.elements.is_empty();
        if !is_gone {
            subsets.push(Subset { elements, ..subset.clone() });
        }
    }
    subsets.extend(constraint_sets(garment, product, options));
    let mut families: Vec<Family> = garment.families.iter().map(|f| carried_family(garment, f)).collect();
    if subsets.iter().any(|s| s.family == CONSTRAINT_FAMILY) && families.iter().all(|f| f.name != CONSTRAINT_FAMILY) {
        families.push(Family { name: CONSTRAINT_FAMILY.into(), kind: FamilyType::Unrestricted });
    }
    (subsets, families)
}

/// A partition of edges or points covers no other edges or points, so it is none on another mesh.
fn carried_family(garment: &Garment, family: &Family) -> Family {
    let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
    let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
    let kind = if of_faces { family.kind } else { FamilyType::Unrestricted };
    Family { name: family.name.clone(), kind }
}

/// The simulation faces over each face of the garment.
struct Children(IdVec<FaceId, Vec<FaceId>>);

impl Children {
    fn new(garment: &Garment, sites: &Sites) -> Self {
        let mut children = IdVec::filled(Vec::new(), garment.faces.len());
        for (face, &source) in sites.source_faces.enumerated() {
            children[source].push(face);
        }
        Self(children)
    }

    fn of(&self, sources: &[FaceId]) -> Vec<FaceId> {
        let mut faces: Vec<FaceId> = sources.iter().flat_map(|&f| self.0[f].iter().copied()).collect();
        faces.sort_unstable();
        faces
    }
}

/// The edges of an edge subset: those of the chains that it holds.
fn edge_set(
    index: usize,
    subset: &Subset,
    edges: &[[VertexId; 2]],
    product: &SimProduct,
    warnings: &mut Warnings,
) -> Vec<[VertexId; 2]> {
    let chains: Vec<_> =
        product.baseline.chains.enumerated().filter(|(_, c)| c.marks.subsets.contains(&index)).collect();
    let carried: BTreeSet<[VertexId; 2]> =
        chains.iter().flat_map(|(_, c)| c.cage.windows(2).map(|p| [p[0].min(p[1]), p[0].max(p[1])])).collect();
    if carried.len() < edges.len() {
        warnings.push(Warning::NotCarried {
            what: format!(
                "{} of {} edges of subset {} on the simulation mesh",
                edges.len() - carried.len(),
                edges.len(),
                subset.name
            ),
            why: "they are no constraints; name the subset in tailor:sim:constraints to make them edges of the mesh"
                .into(),
        });
    }
    unique(chains.iter().flat_map(|(id, _)| product.chain_edges[*id].iter().copied()))
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
        let is_in = |c: &Chain| if of_seams { c.marks.seam } else { c.marks.border };
        let chains = product.baseline.chains.enumerated().filter(|(_, c)| is_in(c));
        let edges = unique(chains.flat_map(|(id, _)| product.chain_edges[id].iter().copied()));
        if wanted && !edges.is_empty() && garment.subset(name).is_none() {
            sets.push(Subset { name: name.into(), family: CONSTRAINT_FAMILY.into(), elements: Elements::Edges(edges) });
        }
    }
    sets
}

/// The grid of the simulation mesh's points, made when the first point subset asks.
#[derive(Default)]
struct OnceGrid(std::cell::OnceCell<PointGrid>);

/// The nearest point of the simulation mesh to each point of a subset.
fn nearest_points(points: &[VertexId], garment: &Garment, product: &SimProduct, grid: &OnceGrid) -> Vec<VertexId> {
    let grid = grid.0.get_or_init(|| PointGrid::new(&product.points));
    let baseline = &product.baseline;
    let mut on_baseline: BTreeMap<VertexId, VertexId> = BTreeMap::new();
    for (own, &source) in baseline.manifold.vertex_source.enumerated() {
        on_baseline.entry(source).or_insert(own);
    }
    let mut found: Vec<VertexId> = Vec::with_capacity(points.len());
    for point in points {
        let position = on_baseline.get(point).map_or(garment.points[*point], |&v| baseline.points[v]);
        found.extend(grid.nearest(&product.points, position));
    }
    found.sort_unstable();
    found.dedup();
    found
}
