//! Subsets on the simulation mesh: the garment's, and those that name its creases, corners, borders and seams.

mod named;
mod warnings;

use super::correspondence::Correspondence;
use super::coverage::Locator;
use super::edges::{CarriedEdges, EdgeTransfer};
use super::faces::carry_sets;
use crate::contact::NearestSearch;
use crate::sim::SimOptions;
use glam::{DVec3, Vec3};
use std::sync::LazyLock;
use tailor_mesh::connectivity::{IdVec, VertexId};
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::{Elements, Family, FamilyType, Mesh, Primvar, Subset};

/// The subsets of a simulation mesh.
pub(super) struct CarriedSubsets {
    pub subsets: Vec<Subset>,
    pub curves: Vec<SetCurve>,
    /// Number of isolated faces that were moved to a neighbour's set.
    pub islands: usize,
}

/// The curve of an edge subset on the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct SetCurve {
    /// Name of the subset.
    pub name: String,
    /// Its length. \[mesh units\]
    pub length: f64,
    /// Largest distance from it of the subset on the simulation mesh, in local target lengths.
    pub farthest: f32,
    /// Number of vertices that the searches for its edges visited.
    pub visited: usize,
}

impl SetCurve {
    fn new(source: &Subset, carried: &CarriedEdges) -> Self {
        Self {
            name: source.name.clone(),
            length: carried.source_length,
            farthest: carried.farthest,
            visited: carried.visited,
        }
    }
}

/// The subsets and families of the simulation mesh.
pub(super) fn carry_all(
    garment: &Mesh,
    map: &Correspondence<'_>,
    locator: &Locator<'_>,
    options: &SimOptions,
) -> (CarriedSubsets, Warnings) {
    let mut face_sets = carry_sets(garment, map, options.clean_islands);
    let mut warnings = Warnings::from_iter(warnings::of_small_sets(garment, &face_sets.sets, map.coverage));
    let mut sources = garment.subsets.to_vec();
    sources.extend(named::sharp_sets(garment));
    let sets = sources.iter().map(|s| match &s.elements {
        Elements::Edges(edges) => edges.as_slice(),
        _ => &[],
    });
    let edges = EdgeTransfer::new(map, locator, garment.points.len(), options);
    let carried = edges.carry_all(garment, &face_sets, &sets.collect::<Vec<_>>());
    let nearest = LazyLock::new(|| NearestPoint::new(&map.product.points));
    let (mut subsets, mut curves) = (Vec::with_capacity(sources.len() + 2), Vec::new());
    for (i, (source, carried)) in sources.into_iter().zip(carried).enumerate() {
        let elements = match &source.elements {
            Elements::Faces(faces) => {
                let set = std::mem::take(&mut face_sets.sets[i]);
                warnings.extend((set.is_empty() && !faces.is_empty()).then(|| warnings::of_lost_set(&source)));
                Elements::Faces(set)
            }
            Elements::Edges(_) => {
                warnings.extend(warnings::of_edges(&source, &carried));
                curves.push(SetCurve::new(&source, &carried));
                Elements::Edges(carried.edges)
            }
            Elements::Points(points) => Elements::Points(nearest_points(points, garment, &edges, &nearest)),
        };
        subsets.push(Subset { elements, ..source });
    }
    (CarriedSubsets { subsets, curves, islands: face_sets.islands }, warnings)
}

/// Adds the sets of borders and of the seams of `uvs`, which are on the simulation mesh. Returns the families of all sets.
pub(super) fn add_constraints(
    garment: &Mesh,
    map: &Correspondence<'_>,
    uvs: Option<&Primvar>,
    subsets: &mut Vec<Subset>,
) -> Vec<Family> {
    subsets.extend(named::constraint_sets(garment, map, uvs));
    families(garment, subsets)
}

/// The families of the garment, then those of our own subsets. A family of edges or points is unrestricted, because a
/// partition of them leaves out the new ones.
fn families(garment: &Mesh, subsets: &[Subset]) -> Vec<Family> {
    let carried = |family: &Family| {
        let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
        let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
        Family { name: family.name.clone(), kind: if of_faces { family.kind } else { FamilyType::Unrestricted } }
    };
    let mut families: Vec<Family> = garment.families.iter().map(carried).collect();
    for name in named::FAMILIES {
        if subsets.iter().any(|s| s.family == name) && families.iter().all(|f| f.name != name) {
            families.push(Family { name: name.into(), kind: FamilyType::Unrestricted });
        }
    }
    families
}

/// The vertex of the simulation mesh nearest to each point of a subset, on the same chain or part of the surface. A
/// point that is cut apart has one on each side.
fn nearest_points(
    points: &[VertexId],
    garment: &Mesh,
    edges: &EdgeTransfer<'_>,
    nearest: &NearestPoint<'_>,
) -> Vec<VertexId> {
    let mut found: Vec<VertexId> = Vec::with_capacity(points.len());
    for &point in points {
        let before = found.len();
        found.extend(edges.nearest_vertices(point));
        if found.len() == before {
            // The point has no face, or only holes.
            found.extend(nearest.to(garment.points[point]));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The nearest point of all, for points without a face.
struct NearestPoint<'a> {
    points: &'a IdVec<VertexId, Vec3>,
    search: NearestSearch,
}

impl<'a> NearestPoint<'a> {
    fn new(points: &'a IdVec<VertexId, Vec3>) -> Self {
        Self { points, search: NearestSearch::of_points(points.as_slice()) }
    }

    /// The point nearest to a position, the lowest of equals.
    fn to(&self, position: Vec3) -> Option<VertexId> {
        let squared = |i, from: DVec3| self.points[VertexId::new(i)].as_dvec3().distance_squared(from);
        self.search.nearest(position, squared).map(VertexId::new)
    }
}
