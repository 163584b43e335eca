//! Attributes of the garment on the simulation mesh, by where each of its elements lies on the baseline.
//!
//! Vertices and corners have their place there. Faces take what they cover most, or its mean, counted by samples
//! ([`Coverage`]). Edges that were no constraints are found again as paths of edges along their curves.

mod corner;
mod coverage;
mod curve;
mod edge;
mod face;
mod lay;
mod locate;
mod normals;
mod provenance;
mod region;
mod rows;
mod shell;
mod sides;
mod snap;
mod subset;
mod vertex;

pub use coverage::{Coverage, Share};
pub use provenance::{SOURCE_COORDS, SOURCE_FACE, corner_coordinates};

use crate::error::{Warning, Warnings};
use crate::garment::{Garment, Interpolation, Primvar, Scheme, SubdivisionRules, joints};
use crate::mesh::{CornerId, Csr, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::sim::{Location, SimOptions, SimProduct};
use crate::subdivide::to_unit_length;
use rayon::prelude::*;

/// A simulation mesh with attributes, and what is known of how they came there.
pub struct Transferred {
    /// The mesh.
    pub mesh: Garment,
    /// How its faces cover those of the garment.
    pub coverage: Coverage,
    /// The curves of its edge subsets.
    pub curves: Vec<SetCurve>,
    /// Faces that were given to a neighbour's set.
    pub islands: usize,
}

/// The curve of an edge subset on the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct SetCurve {
    /// Name of the subset.
    pub name: String,
    /// Its length. \[stage units\]
    pub length: f64,
    /// Largest distance of the subset on the simulation mesh from it, in local target lengths.
    pub farthest: f32,
    /// Length of the subset, too long a path of edges counted with the shortest one within reach. \[stage units\]
    pub shortest: f64,
}

/// The simulation mesh with the garment's attributes, and how its faces cover those of the garment.
///
/// `uv_set` is the primvar whose shells were constraints.
pub fn transfer(
    garment: &Garment,
    product: &SimProduct,
    options: &SimOptions,
    uv_set: Option<&Primvar>,
    warnings: &mut Warnings,
) -> Transferred {
    let net = Net::new(product, garment.faces.len());
    let (coverage, edge_sets) =
        rayon::join(|| Coverage::over(product, &net, options), || subset::EdgeSets::new(garment, product, &net));
    let sites = Sites::new(product, &net, &coverage);
    let target = Target { product, sites: &sites, coverage: &coverage };
    let (carried, (subsets, of_subsets)) = rayon::join(
        || target.carry_all(garment, uv_set),
        || subset::carry(garment, product, &coverage, &sites, options, edge_sets),
    );
    let (mut primvars, each) = carried;
    for (primvar, told) in each {
        primvars.extend(primvar);
        told.into_iter().for_each(|w| warnings.push(w));
    }
    primvars.extend(vertex::carry_influences(garment, product, &sites));
    primvars.iter_mut().for_each(to_unit_length);
    // In the garment's order, so that outputs compare.
    primvars.sort_by_key(|p| garment.primvars.iter().position(|q| q.name == p.name));
    if options.provenance {
        let own = provenance::primvars(product, &sites);
        primvars.retain(|p| own.iter().all(|o| o.name != p.name));
        primvars.extend(own);
    }
    of_subsets.iter().for_each(|w| warnings.push(w.clone()));
    let subset::Subsets { subsets, families, curves, islands } = subsets;
    let mesh = Garment {
        prim: garment.prim.clone(),
        points: product.points.clone(),
        faces: sites.net.topology.faces.clone(),
        orientation: garment.orientation,
        rules: SubdivisionRules { scheme: Scheme::None, ..SubdivisionRules::default() },
        holes: Vec::new(),
        creases: Vec::new(),
        corners: Vec::new(),
        primvars: primvars.into(),
        subsets: subsets.into(),
        families,
    };
    Transferred { mesh, coverage, curves, islands }
}

/// What attributes are carried to.
struct Target<'a> {
    product: &'a SimProduct,
    sites: &'a Sites<'a>,
    coverage: &'a Coverage,
}

/// A primvar, if it is carried by itself, and what is to be told of it.
type Told = (Option<Primvar>, Vec<Warning>);

impl Target<'_> {
    /// The primvars that are carried together, and each of the others.
    fn carry_all(&self, garment: &Garment, uv_set: Option<&Primvar>) -> (Vec<Primvar>, Vec<Told>) {
        rayon::join(
            || vertex::carry_together(garment, self.product, self.sites),
            || garment.primvars.par_iter().map(|p| self.carry(garment, p, uv_set)).collect(),
        )
    }

    /// A primvar on the simulation mesh, with what is to be told; none of those that are carried together.
    fn carry(&self, garment: &Garment, primvar: &Primvar, uv_set: Option<&Primvar>) -> Told {
        let mut warnings = Vec::new();
        if let Some(normals) = normals::rebuilt(garment, primvar, self.product, self.sites) {
            return (Some(normals), warnings);
        }
        let carried = match primvar.interpolation {
            Interpolation::Constant => Some(primvar.clone()),
            Interpolation::Uniform => Some(face::carry(primvar, self.coverage, self.sites)),
            Interpolation::Vertex | Interpolation::Varying
                if joints::is_influence(garment, primvar) || vertex::is_together(garment, primvar) =>
            {
                None
            }
            Interpolation::Vertex | Interpolation::Varying => Some(vertex::carry(primvar, self.product, self.sites)),
            Interpolation::FaceVarying => Some(corner::carry(garment, primvar, self, uv_set, &mut warnings)),
        };
        (carried, warnings)
    }
}

/// What does not depend on where the samples are: the edges of the simulation mesh, and the parts of the garment's faces.
pub(crate) struct Net {
    pub topology: Topology,
    /// Which of them are seams of the constraint UVs.
    pub is_seam: IdVec<EdgeId, bool>,
    /// Which of them are on chains.
    pub is_chain: IdVec<EdgeId, bool>,
    /// The other half-edge of each; none at borders.
    pub twin: IdVec<CornerId, Option<CornerId>>,
    /// The triangles of the baseline in each face of the garment.
    pub children: Csr<FaceId, FaceId>,
}

impl Net {
    fn new(product: &SimProduct, source_faces: usize) -> Self {
        let corners: Vec<VertexId> = product.triangles.iter().flatten().copied().collect();
        let topology = Topology::new(Faces::triangles(corners), product.points.len());
        let mut is_seam = IdVec::filled(false, topology.edges.len());
        let mut is_chain = is_seam.clone();
        for (id, chain) in product.baseline.chains.enumerated() {
            for edge in product.chain_edges[id].iter().filter_map(|&[a, b]| topology.find_edge(a, b)) {
                is_seam[edge] |= chain.kind.seam;
                is_chain[edge] = true;
            }
        }
        let twin = topology.faces.corners().ids().map(|c| topology.twin(c)).collect();
        let pairs = product.baseline.source_face.enumerated().map(|(face, &source)| (source, face));
        let children = Csr::group(source_faces, pairs, FaceId::new(0));
        Self { topology, is_seam, is_chain, twin, children }
    }
}

/// Where the elements of the simulation mesh are on the baseline.
pub(crate) struct Sites<'a> {
    product: &'a SimProduct,
    /// Each vertex; one on a seam as one of its sides sees it.
    pub vertices: IdVec<VertexId, Location>,
    /// Faces without a sample, each with the garment's face under its centre.
    pub unsampled: Vec<(FaceId, FaceId)>,
    /// The edges of the simulation mesh.
    pub net: &'a Net,
}

impl<'a> Sites<'a> {
    fn new(product: &'a SimProduct, net: &'a Net, coverage: &Coverage) -> Self {
        let mut vertices = IdVec::<VertexId, Option<Location>>::filled(None, product.points.len());
        for (&v, place) in product.triangles.iter().flatten().zip(product.places.iter()) {
            vertices[v].get_or_insert(place.location);
        }
        let vertices =
            vertices.iter().map(|l| l.unwrap_or(Location { face: FaceId::new(0), weights: glam::Vec3::X })).collect();
        let bare = net.topology.faces.ids().filter(|&f| coverage.sources.row(f).is_empty());
        let unsampled = bare.map(|f| (f, product.baseline.source_face[centre(product, f)])).collect();
        Self { product, vertices, unsampled, net }
    }

    /// The baseline's triangle under the centre of a face, on the face's own panel.
    pub fn centre(&self, face: FaceId) -> FaceId {
        centre(self.product, face)
    }

    /// The garment's face under the centre of a face without a sample.
    pub fn source_of(&self, face: FaceId) -> FaceId {
        let found = self.unsampled.binary_search_by_key(&face, |u| u.0);
        found.map_or(FaceId::new(0), |at| self.unsampled[at].1)
    }
}

/// The baseline's triangle under the centre of a face, as its corners' sides of the seams see it: the nearest of three.
fn centre(product: &SimProduct, face: FaceId) -> FaceId {
    let centre = product.triangles[face.index()].iter().map(|&v| product.points[v]).sum::<glam::Vec3>() / 3.0;
    let places = [0, 1, 2].map(|k| product.places[CornerId::new(3 * face.index() + k)]);
    let nearest = places
        .map(|p| product.baseline.closest(p.location.face, centre))
        .into_iter()
        .reduce(|best, p| if p.distance_squared < best.distance_squared { p } else { best });
    nearest.map_or(places[0].location.face, |p| p.location.face)
}
