//! A body in two shapes.

use super::triangle::{TriangleSearch, at};
use crate::codes;
use glam::DVec3;
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, VertexId};
use tailor_mesh::error::{Error, ErrorKind};
use tailor_mesh::garment::{Interpolation, Meaning, Mesh, Orientation, Primvar};

/// How far outside of all faces a UV may be. \[UV units\]
const UV_TOLERANCE: f64 = 0.01;
/// Share of the vertices that may be that far outside.
const MOST_WITHOUT_UV: f64 = 0.01;

/// Pairs of points of which a spline is made at most: its system is dense.
const MOST_PAIRS: usize = 1000;

/// A body before and after, with the same triangles.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// The vertices of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The ends of each edge.
    pub(super) edges: Vec<[usize; 2]>,
    /// Points of the body that the garment was made for. \[mesh units\]
    pub(super) from: Vec<DVec3>,
    /// Points of the body that it is to fit. \[mesh units\]
    pub(super) to: Vec<DVec3>,
}

impl Bodies {
    /// The points of the body after a share of the way. \[mesh units\]
    pub fn shape_at(&self, share: f64) -> Vec<glam::Vec3> {
        self.shape(share).iter().map(|p| p.as_vec3()).collect()
    }

    /// Two bodies with the same faces, or with UVs in which they correspond.
    ///
    /// # Errors
    /// Bodies that have neither.
    pub fn new(from: &Mesh, to: &Mesh) -> Result<Self, Error> {
        let is_same = from.points.len() == to.points.len() && from.faces == to.faces;
        let to_points = if is_same { as_doubles(to) } else { by_uvs(from, to)? };
        Ok(Self::of(from, to_points))
    }

    /// Two bodies of any faces, with pairs of places that correspond: on the first one, and on the second one. The thin-plate spline of
    /// the pairs takes the points of the first body near the second one, and then onto it.
    ///
    /// # Errors
    /// Too few pairs, or too many.
    pub fn by_pairs(from: &Mesh, to: &Mesh, pairs: &[[DVec3; 2]]) -> Result<Self, Error> {
        let spline = ThinPlate::new(pairs).map_err(|text| {
            let remedy =
                format!("give 4 to {MOST_PAIRS} pairs that are not all in one plane, such as one for each joint");
            Error::new(ErrorKind::Mesh, &to.prim, text).code(codes::BODIES_DIFFER).remedy(remedy)
        })?;
        let points = as_doubles(to);
        let search = TriangleSearch::new(fans(to).iter().map(|t| t.map(|v| points[v])).collect());
        let onto = |point: &DVec3| {
            let near = spline.at(*point);
            search.nearest(near).map_or(near, |(.., place)| place)
        };
        Ok(Self::of(from, as_doubles(from).par_iter().map(onto).collect()))
    }

    fn of(from: &Mesh, to: Vec<DVec3>) -> Self {
        let mut triangles = fans(from);
        if from.orientation == Orientation::LeftHanded {
            triangles.iter_mut().for_each(|triangle| triangle.reverse());
        }
        let sides = triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        let mut edges: Vec<[usize; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        Self { triangles, edges, from: as_doubles(from), to }
    }

    /// The points at a share of the way.
    pub(super) fn shape(&self, share: f64) -> Vec<DVec3> {
        self.from.iter().zip(&self.to).map(|(a, b)| a.lerp(*b, share)).collect()
    }

    /// The diagonal of the box of the first shape's triangles.
    pub(super) fn size(&self) -> f64 {
        let used = || self.triangles.iter().flatten().map(|&v| self.from[v]);
        let low = used().fold(DVec3::INFINITY, DVec3::min);
        used().fold(DVec3::NEG_INFINITY, DVec3::max).distance(low)
    }
}

fn as_doubles(mesh: &Mesh) -> Vec<DVec3> {
    mesh.points.iter().map(|p| p.as_dvec3()).collect()
}

/// A thin-plate spline in space: an affine map and a sum of distances to its centres (Duchon 1977, *Splines minimizing
/// rotation-invariant semi-norms in Sobolev spaces*).
struct ThinPlate {
    centres: Vec<DVec3>,
    weights: Vec<DVec3>,
    /// Of a constant and of the coordinates.
    affine: [DVec3; 4],
}

impl ThinPlate {
    /// The spline that takes the first place of each pair to the second one; or what is wrong with the pairs.
    fn new(pairs: &[[DVec3; 2]]) -> Result<Self, String> {
        let count = pairs.len();
        if !(4..=MOST_PAIRS).contains(&count) {
            return Err(format!("there are {count} pairs of points"));
        }
        let size = pairs.iter().map(|pair| pair[0].distance(pairs[0][0])).fold(0.0, f64::max);
        let linear = |p: DVec3| [size, p.x, p.y, p.z];
        let row = |i: usize| {
            let mut row = vec![0.0; count + 4];
            if i < count {
                (0..count).for_each(|j| row[j] = pairs[i][0].distance(pairs[j][0]));
                row[count..].copy_from_slice(&linear(pairs[i][0]));
            } else {
                (0..count).for_each(|j| row[j] = linear(pairs[j][0])[i - count]);
            }
            row
        };
        let right = pairs.iter().map(|pair| pair[1]).chain([DVec3::ZERO; 4]).collect();
        let solved = eliminated((0..count + 4).map(row).collect(), right, 1e-9 * size);
        let solved = solved.ok_or("the pairs of points are in one plane, or one is there twice")?;
        let affine = [solved[count] * size, solved[count + 1], solved[count + 2], solved[count + 3]];
        Ok(Self { centres: pairs.iter().map(|pair| pair[0]).collect(), weights: solved[..count].to_vec(), affine })
    }

    fn at(&self, p: DVec3) -> DVec3 {
        let [origin, x, y, z] = self.affine;
        let bent = self.centres.iter().zip(&self.weights).map(|(centre, weight)| *weight * centre.distance(p));
        origin + x * p.x + y * p.y + z * p.z + bent.sum::<DVec3>()
    }
}

/// The solution of a linear system by elimination with row pivots; none where a pivot is not larger than `least`.
fn eliminated(mut rows: Vec<Vec<f64>>, mut right: Vec<DVec3>, least: f64) -> Option<Vec<DVec3>> {
    let count = rows.len();
    for k in 0..count {
        let pivot = (k..count).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        right.swap(k, pivot);
        if rows[k][k].is_nan() || rows[k][k].abs() <= least {
            return None;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        let (own, value) = (&above[k], right[k]);
        for (row, right) in below.iter_mut().zip(&mut right[k + 1..]) {
            let share = row[k] / own[k];
            row[k..].iter_mut().zip(&own[k..]).for_each(|(entry, own)| *entry -= share * own);
            *right -= share * value;
        }
    }
    for k in (0..count).rev() {
        let known: DVec3 = (k + 1..count).map(|j| rows[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / rows[k][k];
    }
    Some(right)
}

/// The faces of a mesh as fans of triangles.
pub(super) fn fans(mesh: &Mesh) -> Vec<[usize; 3]> {
    mesh.faces.fans().map(|triangle| triangle.map(|v| v.index())).collect()
}

/// The points of `to` at the UVs of the vertices of `from`.
fn by_uvs(from: &Mesh, to: &Mesh) -> Result<Vec<DVec3>, Error> {
    let fault = |text: String| {
        let remedy = "name bodies of the same faces, or with a common UV set of texCoord2f[], faceVarying or vertex";
        Error::new(ErrorKind::Mesh, &to.prim, text).code(codes::BODIES_DIFFER).remedy(remedy)
    };
    let (a, b) = (from.points.len(), to.points.len());
    let other = format!("it has other faces than {} ({b} points, not {a})", from.prim);
    let Some((name, own)) = uv_sets(from).find(|(name, _)| uv_sets(to).any(|(other, _)| other == *name)) else {
        return Err(fault(format!("{other}, and no UV set in common")));
    };
    let of_to = uv_sets(to).find(|(other, _)| *other == name).map(|(_, uvs)| uvs).unwrap_or_default();
    let mut uv_of = vec![None; a];
    from.faces.corners().enumerated().for_each(|(corner, v)| {
        uv_of[v.index()].get_or_insert(own[corner.index()]);
    });
    let (triangles, points) = (fans(to), as_doubles(to));
    let search = TriangleSearch::new(uv_fans(to, &of_to));
    let found: Vec<Option<(DVec3, f64)>> = uv_of
        .par_iter()
        .map(|uv| {
            let uv: DVec3 = (*uv)?;
            let (triangle, weights, place) = search.nearest(uv)?;
            Some((at(triangles[triangle].map(|v| points[v]), weights), place.distance(uv)))
        })
        .collect();
    let missing = found.iter().flatten().filter(|(_, distance)| *distance > UV_TOLERANCE).count();
    if missing as f64 > MOST_WITHOUT_UV * a as f64 {
        return Err(fault(format!("{other}, and {missing} of its places in the UV set \"{name}\" are on no face")));
    }
    // Points without a face do not matter.
    Ok(found.iter().zip(from.points.iter()).map(|(found, p)| found.map_or(p.as_dvec3(), |(place, _)| place)).collect())
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

/// The UVs of the corners of each triangle.
fn uv_fans(mesh: &Mesh, uvs: &[DVec3]) -> Vec<[DVec3; 3]> {
    let of_face = |face| {
        let corners = mesh.faces.range(face);
        (corners.start + 1..corners.end - 1).map(move |c| [corners.start, c, c + 1].map(|c| uvs[c]))
    };
    mesh.faces.ids().flat_map(of_face).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_meets_its_pairs_and_keeps_affine_maps() {
        let place = |i: usize| DVec3::new((i * 7 % 5) as f64, (i * 3 % 7) as f64, (i * 5 % 3) as f64);
        let moved = |p: DVec3| DVec3::new(2.0 * p.x + 1.0, p.z - p.y, 0.5 * p.y);
        let mut pairs: Vec<[DVec3; 2]> = (0..20).map(|i| [place(i), moved(place(i))]).collect();
        let spline = ThinPlate::new(&pairs).expect("places that are not in a plane");
        let elsewhere = DVec3::new(3.3, -8.0, 1.2);
        assert!(spline.at(elsewhere).distance(moved(elsewhere)) < 1e-9);
        pairs[4][1] += DVec3::new(0.3, -0.2, 1.0);
        let spline = ThinPlate::new(&pairs).expect("places that are not in a plane");
        assert!(pairs.iter().all(|[from, to]| spline.at(*from).distance(*to) < 1e-9));
    }

    #[test]
    fn pairs_that_say_too_little_are_refused() {
        let flat: Vec<[DVec3; 2]> = (0..9).map(|i| [DVec3::new((i % 3) as f64, (i / 3) as f64, 2.0); 2]).collect();
        assert!(ThinPlate::new(&flat).is_err() && ThinPlate::new(&flat[..3]).is_err());
    }
}
