//! Attributes of the garment on the simulation mesh, by where each of its elements lies on the baseline.

mod corner;
mod subset;
mod vertex;

use crate::error::{Warning, Warnings};
use crate::garment::{Garment, Interpolation, Primvar, Scheme, SubdivisionRules, joints};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::sim::{Location, SimOptions, SimProduct};
use crate::subdivide::{taken, to_unit_length};

/// The simulation mesh with the garment's attributes.
///
/// `uv_set` is the primvar whose shells were constraints.
pub fn transfer(
    garment: &Garment,
    product: &SimProduct,
    options: &SimOptions,
    uv_set: Option<&Primvar>,
    warnings: &mut Warnings,
) -> Garment {
    let sites = Sites::new(product);
    let mut primvars = Vec::with_capacity(garment.primvars.len());
    for primvar in &garment.primvars {
        let carried = match primvar.interpolation {
            Interpolation::Constant => Some(primvar.clone()),
            Interpolation::Uniform => Some(taken(primvar, sites.source_faces.iter().map(|f| f.index()))),
            Interpolation::Vertex | Interpolation::Varying if joints::is_influence(garment, primvar) => None,
            Interpolation::Vertex | Interpolation::Varying => Some(vertex::carry(primvar, product, &sites)),
            Interpolation::FaceVarying => Some(corner::carry(garment, primvar, product, &sites, uv_set)),
        };
        primvars.extend(carried);
    }
    primvars.extend(vertex::carry_influences(garment, product, &sites));
    primvars.iter_mut().for_each(to_unit_length);
    // In the garment's order, so that outputs compare.
    primvars.sort_by_key(|p| garment.primvars.iter().position(|q| q.name == p.name));
    let (subsets, families) = subset::carry(garment, product, &sites, options, warnings);
    if !garment.creases.is_empty() || !garment.corners.is_empty() {
        warnings.push(Warning::NotCarried {
            what: "sharpness of creases and corners".into(),
            why: "the simulation mesh has no subdivision; the model and the render mesh keep it".into(),
        });
    }
    Garment {
        prim: garment.prim.clone(),
        points: product.points.clone(),
        faces: sites.topology.faces,
        orientation: garment.orientation,
        rules: SubdivisionRules { scheme: Scheme::None, ..SubdivisionRules::default() },
        holes: Vec::new(),
        creases: Vec::new(),
        corners: Vec::new(),
        primvars,
        subsets,
        families,
    }
}

/// Where the elements of the simulation mesh are on the baseline.
pub(crate) struct Sites {
    /// Each vertex; one on a seam as one of its sides sees it.
    pub vertices: IdVec<VertexId, Location>,
    /// The baseline triangle under the centre of each face, on the face's own panel.
    pub faces: IdVec<FaceId, FaceId>,
    /// The garment's face there.
    pub source_faces: IdVec<FaceId, FaceId>,
    /// The edges of the simulation mesh.
    pub topology: Topology,
    /// Which of them are seams of the constraint UVs.
    pub is_seam: IdVec<EdgeId, bool>,
}

impl Sites {
    fn new(product: &SimProduct) -> Self {
        let mut vertices = IdVec::<VertexId, Option<Location>>::filled(None, product.points.len());
        let mut faces = IdVec::new();
        for (i, triangle) in product.triangles.iter().enumerate() {
            let places = [0, 1, 2].map(|k| product.places[CornerId::new(3 * i + k)]);
            for (&v, place) in triangle.iter().zip(&places) {
                vertices[v].get_or_insert(place.location);
            }
            let [a, b, c] = triangle.map(|v| product.points[v]);
            let centre = (a + b + c) / 3.0;
            // From each corner's side of the seams; the nearest of the three.
            let nearest = places
                .map(|p| product.baseline.closest(p.location.face, centre))
                .into_iter()
                .reduce(|best, p| if p.distance_squared < best.distance_squared { p } else { best });
            faces.push(nearest.map_or(places[0].location.face, |p| p.location.face));
        }
        let source_faces = faces.iter().map(|&f| product.baseline.source_face[f]).collect();
        let vertices =
            vertices.iter().map(|l| l.unwrap_or(Location { face: FaceId::new(0), weights: glam::Vec3::X })).collect();
        let corners: Vec<VertexId> = product.triangles.iter().flatten().copied().collect();
        let topology = Topology::new(Faces::triangles(corners), product.points.len());
        let mut is_seam = IdVec::filled(false, topology.edges.len());
        for (id, _) in product.baseline.chains.enumerated().filter(|(_, c)| c.marks.seam) {
            for edge in product.chain_edges[id].iter().filter_map(|&[a, b]| topology.find_edge(a, b)) {
                is_seam[edge] = true;
            }
        }
        Self { vertices, faces, source_faces, topology, is_seam }
    }
}
