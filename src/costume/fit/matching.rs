//! Where the vertices of one body are on another.

use super::bodies::{as_doubles, fans};
use super::spline::{MOST_PAIRS, ThinPlate};
use super::triangle::{TriangleSearch, at};
use crate::codes;
use glam::DVec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, VertexId};
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::garment::{Interpolation, Meaning, Mesh, Primvar};

/// How far outside of all faces a UV may be. \[UV units\]
const UV_TOLERANCE: f64 = 0.01;
/// Share of the vertices that may be that far outside.
const MOST_WITHOUT_UV: f64 = 0.01;
/// How much farther than the nearest face another one may be from a UV, where UVs overlap. \[UV units\]
const UV_REACH: f64 = 1e-3;
/// Weight of a distance in UVs, beside a distance on the body as a share of its size.
const UV_WEIGHT: f64 = 10.0;
/// Faces at one UV that are compared at most.
const MOST_CHOICES: usize = 64;
/// How often vertices follow their neighbours.
const VOTES: usize = 8;

/// A place on a body.
#[derive(Clone, Debug)]
pub struct Place {
    pub triangle: usize,
    pub point: DVec3,
}

/// Where the vertices of `to` are on `from`, if these have the same faces. Points that no face has do not count.
pub fn same_faces(from: &Mesh, to: &Mesh) -> Option<Vec<DVec3>> {
    let (a, b) = (&from.faces, &to.faces);
    let has_counts = a.len() == b.len() && a.ids().all(|face| a.valence(face) == b.valence(face));
    let mut partners = [vec![None; from.points.len()], vec![None; to.points.len()]];
    let is_partner = |(&v, &w): (&VertexId, &VertexId)| {
        let [of_from, of_to] = &mut partners;
        *of_from[v.index()].get_or_insert(w) == w && *of_to[w.index()].get_or_insert(v) == v
    };
    let is_same = has_counts && a.corners().iter().zip(b.corners().iter()).all(is_partner);
    let point = |(v, own): (&Option<VertexId>, &glam::Vec3)| v.map_or(*own, |v| from.points[v]).as_dvec3();
    is_same.then(|| partners[1].iter().zip(to.points.iter()).map(point).collect())
}

/// The vertices of `to` on `from`. A spline of pairs of places takes `from` near `to`, and then onto it; a vertex is on the triangle
/// that is nearest to it then.
pub fn by_pairs(from: &Mesh, to: &Mesh, pairs: &[[DVec3; 2]]) -> Result<Vec<Option<Place>>, Error> {
    let spline = ThinPlate::new(pairs).map_err(|text| {
        let remedy = format!("give 4 to {MOST_PAIRS} pairs that are not all in one plane, such as one for each joint");
        Error::new(ErrorKind::Mesh, &to.prim, text).code(codes::BODIES_DIFFER).remedy(remedy)
    })?;
    let search = TriangleSearch::new(corners(to, &as_doubles(to)));
    let onto = |point: &DVec3| {
        let near = spline.at(*point);
        search.nearest(near).map_or(near, |(.., place)| place)
    };
    let (points, laid) = (as_doubles(from), as_doubles(from).par_iter().map(onto).collect::<Vec<_>>());
    let (search, corners) = (TriangleSearch::new(corners(from, &laid)), corners(from, &points));
    let back = |point: &DVec3| {
        let (triangle, weights, _) = search.nearest(*point)?;
        Some(Place { triangle, point: at(corners[triangle], weights) })
    };
    Ok(as_doubles(to).par_iter().map(back).collect())
}

/// The corners of each triangle of a mesh with some points.
fn corners(mesh: &Mesh, points: &[DVec3]) -> Vec<[DVec3; 3]> {
    fans(mesh).iter().map(|t| t.map(|v| points[v])).collect()
}

/// The vertices of `to` on `from`, by their UVs. Where several faces of `from` have the UV of a vertex, [`Choices`] takes one.
pub fn by_uvs(from: &Mesh, to: &Mesh) -> Result<Vec<Option<Place>>, Error> {
    let fault = |text: String| {
        let text = format!(
            "it has other faces than {} ({} points, not {}), and {text}",
            from.prim,
            to.points.len(),
            from.points.len()
        );
        let remedy = "name bodies of the same faces, or with a common UV set of texCoord2f[], faceVarying or vertex";
        Error::new(ErrorKind::Mesh, &to.prim, text).code(codes::BODIES_DIFFER).remedy(remedy)
    };
    let Some((name, uvs)) = uv_sets(from).find(|(name, _)| uv_sets(to).any(|(other, _)| other == *name)) else {
        return Err(fault("no UV set in common".to_owned()));
    };
    let of_to = uv_sets(to).find(|(other, _)| *other == name).map(|(_, uvs)| uvs).unwrap_or_default();
    let (of_from, of_to) = (UvMap::new(from, &uvs), UvMap::new(to, &of_to));
    // One of the bodies may have parts that the other lacks.
    let [missing, of_first] = [(&of_to, &of_from), (&of_from, &of_to)].map(|(own, other)| own.missing_on(other));
    if missing.is_some() && of_first.is_some() {
        let count = missing.unwrap_or_default();
        return Err(fault(format!("{count} of its places in the UV set \"{name}\" are on no face")));
    }
    let corners = corners(from, &as_doubles(from));
    let places = |uv: &Option<DVec3>| {
        let found = uv.map(|uv| of_from.within(uv)).unwrap_or_default();
        let place = |(triangle, weights, apart)| (Place { triangle, point: at(corners[triangle], weights) }, apart);
        found.into_iter().map(place).collect()
    };
    Ok(Choices { of: of_to.vertices.par_iter().map(places).collect() }.taken(from, to))
}

/// The UVs of a mesh.
struct UvMap {
    triangles: TriangleSearch,
    /// The UV of a corner of each vertex; none without a face.
    vertices: Vec<Option<DVec3>>,
}

impl UvMap {
    fn new(mesh: &Mesh, uvs: &[DVec3]) -> Self {
        let mut vertices = vec![None; mesh.points.len()];
        mesh.faces.corners().enumerated().for_each(|(corner, v)| {
            vertices[v.index()].get_or_insert(uvs[corner.index()]);
        });
        let of_face = |face| {
            let corners = mesh.faces.range(face);
            (corners.start + 1..corners.end - 1).map(move |c| [corners.start, c, c + 1].map(|c| uvs[c]))
        };
        Self { triangles: TriangleSearch::new(mesh.faces.ids().flat_map(of_face).collect()), vertices }
    }

    /// The triangles at a UV with the weights of their corners and their distance from it: the nearest one, and those that are
    /// hardly farther away. None if all are too far.
    fn within(&self, uv: DVec3) -> Vec<(usize, DVec3, f64)> {
        let with_distance = |(triangle, weights, place): (usize, DVec3, DVec3)| (triangle, weights, place.distance(uv));
        let Some(nearest) = self.triangles.nearest(uv).map(with_distance).filter(|found| found.2 <= UV_TOLERANCE)
        else {
            return Vec::new();
        };
        let reach = nearest.2 + UV_REACH;
        let others = self.triangles.near(uv, reach, MOST_CHOICES).map(with_distance);
        std::iter::once(nearest).chain(others.filter(|other| other.0 != nearest.0 && other.2 <= reach)).collect()
    }

    /// The number of vertices that are on no face of another map, if they are too many.
    fn missing_on(&self, other: &Self) -> Option<usize> {
        let count = self.vertices.par_iter().flatten().filter(|uv| other.within(**uv).is_empty()).count();
        (count as f64 > MOST_WITHOUT_UV * self.vertices.len() as f64).then_some(count)
    }
}

/// The places at which each vertex may be, with the distances of their UVs. Sides of a body may share their UVs, and shells may
/// overlap.
struct Choices {
    of: Vec<Vec<(Place, f64)>>,
}

impl Choices {
    /// The place of each vertex: first that on its side of the body, then that beside the places of its neighbours.
    fn taken(self, from: &Mesh, to: &Mesh) -> Vec<Option<Place>> {
        let [own, first] = [to, from].map(|mesh| bounds(&fans(mesh), &as_doubles(mesh)));
        let size = first[1].distance(first[0]).max(f64::MIN_POSITIVE);
        let scale = (first[1] - first[0]) / (own[1] - own[0]).max(DVec3::splat(f64::MIN_POSITIVE));
        let on_first = |p: &glam::Vec3| first[0] + (p.as_dvec3() - own[0]) * scale;
        let mut expected: Vec<DVec3> = to.points.iter().map(on_first).collect();
        let neighbours = neighbours(to);
        let mut taken = Vec::new();
        for _ in 0..VOTES {
            let place = |(all, expected): (&Vec<(Place, f64)>, &DVec3)| {
                let cost = |(place, apart): &(Place, f64)| place.point.distance(*expected) / size + UV_WEIGHT * apart;
                all.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).map(|(place, _)| place.clone())
            };
            taken = self.of.par_iter().zip(&expected).map(place).collect::<Vec<Option<Place>>>();
            for (expected, around) in expected.iter_mut().zip(&neighbours) {
                let places = || around.iter().filter_map(|&v| taken[v].as_ref());
                let count = places().count();
                if count > 0 {
                    *expected = places().map(|place| place.point).sum::<DVec3>() / count as f64;
                }
            }
        }
        taken
    }
}

/// The vertices beside each.
fn neighbours(mesh: &Mesh) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new(); mesh.points.len()];
    for corner in mesh.faces.corners().ids() {
        let [a, b] = mesh.faces.half_edge(corner).map(|v| v.index());
        all[a].push(b);
        all[b].push(a);
    }
    all
}

/// The box of the points that triangles have.
pub fn bounds(triangles: &[[usize; 3]], points: &[DVec3]) -> [DVec3; 2] {
    let used = || triangles.iter().flatten().map(|&v| points[v]);
    [used().fold(DVec3::INFINITY, DVec3::min), used().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

/// The UV sets of a mesh: their names, and the UV of each corner. A body without seams may have its UVs at its points.
fn uv_sets(mesh: &Mesh) -> impl Iterator<Item = (&str, Vec<DVec3>)> {
    let is_at_points = |p: &Primvar| matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying);
    let has_uvs = |p: &Primvar| p.meaning == Meaning::TextureCoordinate && p.has_uvs();
    mesh.primvars.iter().filter(move |p| p.is_uv_set() || is_at_points(p) && has_uvs(p)).map(move |primvar| {
        let uv = |(corner, vertex): (CornerId, &VertexId)| {
            let element = if is_at_points(primvar) { vertex.index() } else { corner.index() };
            primvar.uv(primvar.row(element) as u32).extend(0.0)
        };
        (primvar.name.as_str(), mesh.faces.corners().enumerated().map(uv).collect())
    })
}
