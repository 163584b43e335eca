//! The shape at rest: UV panels in the triangles of the simulation mesh.
//!
//! A pattern is flat, and its panels have the lengths of the cloth. The simulation mesh is smoothed across seams and its UVs
//! are not, so its raw UVs are not a good rest shape: edges along seams come out too short. Each triangle therefore rests as
//! long as it is on the mesh, less the stretch that the *cage* has against its UVs there, which is what the modeller made. The
//! panels are then solved for ([`flatten`]).
//!
//! The idea of tailoring on flat panels is that of Edna Design, the predecessor of the pipeline of Waggoner and de Goes, *Revamping
//! the Cloth Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022).

mod cholesky;
mod flatten;
mod stretch;

use super::options::RestShape;
use super::surface::{Surface, area, shares_uvs, twins};
use crate::codes;
use flatten::{Panel, Seam, flatten};
use glam::{DMat2, DVec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
pub use stretch::{CageStretch, Pattern};
use stretch::{root_mean_square, target_edges};
use tailor::sim::SimProduct;
use tailor_mesh::connectivity::{CornerId, FaceId, VertexId, edit};
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::{Elements, Mesh};

/// Root mean square of the cage's stretch against its UVs up to which a shell is a pattern.
const PATTERN_STRETCH: f64 = 0.06;

/// The shape at rest, in the order of the simulation mesh's triangles. Flat panels lie in the plane z = 0, face up, where their
/// UVs are; other shells lie where they are modelled. Shells share no point.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Points. \[mesh units\]
    pub points: Vec<Vec3>,
    /// The points of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Whether each triangle is on a flat panel.
    pub is_flat: Vec<bool>,
    /// Adjacent triangles of which one alone is on a flat panel. No angle between their places has a meaning; their edge rests
    /// flat, as all seams of panels do.
    pub flat_seams: Vec<[FaceId; 2]>,
    /// Its figures.
    pub figures: RestFigures,
}

/// How well flat panels rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RestFigures {
    /// Shells that rest as flat panels.
    pub panels: usize,
    /// Shells that rest as modelled.
    pub modelled: usize,
    /// Root mean square of the stretch of the panels' triangles against their targets.
    pub stretch_rms: f64,
    /// Largest stretch, or inverse of the smallest one.
    pub stretch_max: f64,
    /// Triangles that are turned over.
    pub flipped: usize,
    /// Largest difference of the lengths of the two sides of a seam's edge, as a share of their mean.
    pub seam_difference: f64,
}

/// The shape at rest; none for that of the mesh. `cage` is the stretch of the garment against `uv_set`, if the mesh has its
/// shells. The warning names shells that are not patterns, beside others that are.
///
/// # Errors
/// `panels` without UVs, or with shells that are not patterns.
pub fn rest(
    wanted: RestShape,
    garment: &Mesh,
    product: &SimProduct,
    surface: &Surface<'_>,
    cage: Option<&CageStretch>,
    uv_set: &str,
) -> Result<(Option<Rest>, Option<Warning>), Error> {
    let cage = match (wanted, cage) {
        (RestShape::Mesh, _) | (RestShape::Auto, None) => return Ok((None, None)),
        (RestShape::Panels, None) => {
            let (fault, remedy) = match garment.primvar(uv_set) {
                Some(_) => ("sim.constrainUvSeams is false".to_owned(), "set sim.constrainUvSeams to true"),
                None => (format!("{} has no UV set \"{uv_set}\"", garment.prim), "name its UV set in sim.uvSet"),
            };
            let fault = Error::recipe("cloth.rest", fault).code(codes::UNUSABLE_PANELS);
            return Err(fault.remedy(format!("{remedy}, or rest on the mesh")));
        }
        (_, Some(cage)) => cage,
    };
    let mut shells = Shells::new(product, surface, cage);
    let free = shells.solved(None, &BTreeMap::new());
    shells.note_stretch(&free);
    let others = shells.not_patterns();
    if !others.is_empty() && wanted == RestShape::Panels {
        return Err(Error::recipe("cloth.rest", shells.fault(&others))
            .code(codes::UNUSABLE_PANELS)
            .remedy("use auto, or mend the UVs"));
    }
    // UVs of which no shell is a pattern are a layout for textures, and say nothing of the cloth.
    if others.len() == shells.stretch.len() {
        return Ok((None, None));
    }
    let warning = (!others.is_empty()).then(|| {
        let problem = format!("{}; they rest as modelled", shells.fault(&others));
        let faces = others.iter().map(|&shell| shells.first_source[shell]).collect();
        Warning::new(codes::NO_PATTERN, &garment.prim, problem)
            .at(Elements::Faces(faces))
            .remedy("Lay the UVs out to scale, as a sewing pattern, or set cloth.rest to mesh")
    });
    Ok((Some(shells.at_rest(&free)), warning))
}

impl Rest {
    /// Its points if the mesh is moved: flat panels stay in their plane.
    pub fn moved(&self, by: Vec3) -> Vec<Vec3> {
        let mut points = self.points.clone();
        let modelled = self.triangles.iter().zip(&self.is_flat).filter(|(_, is_flat)| !**is_flat);
        let mut moving: Vec<u32> = modelled.flat_map(|(triangle, _)| *triangle).collect();
        moving.sort_unstable();
        moving.dedup();
        moving.into_iter().for_each(|i| points[i as usize] += by);
        points
    }

    /// The length of the half-edge at a corner of the simulation mesh.
    fn length(&self, corner: CornerId) -> f64 {
        f64::from(self.point(corner).distance(self.point(edit::next(corner))))
    }

    /// The triangles of a shell, and their points.
    fn shell(&self, faces: &[usize]) -> (Vec<[usize; 3]>, Vec<Vec3>) {
        let of = || faces.iter().flat_map(|&face| self.triangles[face]).map(|v| v as usize);
        let (first, last) = (of().min().unwrap_or(0), of().max().unwrap_or(0));
        let triangles = faces.iter().map(|&face| self.triangles[face].map(|v| v as usize - first));
        (triangles.collect(), self.points[first..=last].to_vec())
    }

    /// The point at a corner of the simulation mesh.
    fn point(&self, corner: CornerId) -> Vec3 {
        self.points[self.triangles[corner.index() / 3][corner.index() % 3] as usize]
    }
}

/// A triangle of a flat panel against its wanted shape.
struct FlatTriangle {
    face: usize,
    /// Symmetric.
    stretch: DMat2,
    is_flipped: bool,
    /// The area of the wanted shape.
    area: f64,
}

/// The UV shells of a simulation mesh, and the wanted shape of each triangle.
struct Shells<'a> {
    product: &'a SimProduct,
    surface: &'a Surface<'a>,
    /// Length of one UV unit. \[mesh units\]
    scale: f64,
    /// Root mean square of the cage's stretch in each shell.
    stretch: Vec<f64>,
    /// A face of the garment in each shell.
    first_source: Vec<FaceId>,
    /// Edges of each triangle in the plane, from corner k to the next, without strain.
    edges: Vec<[DVec2; 3]>,
    /// -1 for shells whose UVs are mirrored.
    side: Vec<f64>,
}

impl<'a> Shells<'a> {
    fn new(product: &'a SimProduct, surface: &'a Surface<'a>, cage: &CageStretch) -> Self {
        let count = surface.shells.iter().max().map_or(0, |last| *last as usize + 1);
        let source = |corner: usize| product.baseline.source_face[product.places[CornerId::new(corner)].location.face];
        let uvs =
            |face: usize| [0, 1, 2].map(|k| product.places[CornerId::new(3 * face + k)].uv.as_dvec2() * cage.scale);
        let mut signed = vec![0.0; count];
        for (face, &shell) in surface.shells.iter().enumerate() {
            let [a, b, c] = uvs(face);
            signed[shell as usize] += (b - a).perp_dot(c - a);
        }
        let side: Vec<f64> = signed.iter().map(|area| if *area < 0.0 { -1.0 } else { 1.0 }).collect();
        let mut parts: Vec<Vec<(DMat2, f64)>> = vec![Vec::new(); count];
        let mut first_source = vec![FaceId::new(0); count];
        let mut edges = Vec::with_capacity(surface.shells.len());
        for (face, &shell) in surface.shells.iter().enumerate() {
            let shell = shell as usize;
            let triangle = surface.triangle(FaceId::new(face));
            let [made, undone] = [&cage.made, &cage.undone].map(|of| [0, 1, 2].map(|k| of[source(3 * face + k)]));
            if parts[shell].is_empty() {
                first_source[shell] = source(3 * face);
            }
            parts[shell].extend(made.map(|stretch| (stretch, area(triangle))));
            let mean = (undone[0] + undone[1] + undone[2]) * (1.0 / 3.0);
            let flip = DVec2::new(side[shell], 1.0);
            edges.push(target_edges(triangle, uvs(face), mean, side[shell]).map(|edge| edge * flip));
        }
        let stretch = parts.iter().map(|parts| root_mean_square(parts)).collect();
        Self { product, surface, scale: cage.scale, stretch, first_source, edges, side }
    }

    fn is_pattern(&self, shell: usize) -> bool {
        self.stretch[shell] <= PATTERN_STRETCH
    }

    fn not_patterns(&self) -> Vec<usize> {
        (0..self.stretch.len()).filter(|&shell| !self.is_pattern(shell)).collect()
    }

    fn fault(&self, others: &[usize]) -> String {
        let most = 100.0 * others.iter().map(|&shell| self.stretch[shell]).fold(0.0, f64::max);
        format!(
            "{} of {} UV shells do not fit the mesh: its edges differ by up to {most:.0} % (RMS), and {:.0} % is the limit",
            others.len(),
            self.stretch.len(),
            100.0 * PATTERN_STRETCH
        )
    }

    /// The common rest length of the two sides of each seam, by the half-edges of patterns. A shell that rests as modelled
    /// keeps its own. `free` has the panels without common lengths.
    fn seams(&self, free: &Rest) -> BTreeMap<CornerId, f64> {
        let topology = self.surface.topology;
        let mut lengths = BTreeMap::new();
        let is_seam = |&[corner, twin]: &[CornerId; 2]| !shares_uvs(self.product, &topology.faces, corner, twin);
        for [corner, twin] in twins(topology).filter(is_seam) {
            let pattern = [corner, twin].map(|c| self.is_pattern(self.surface.shells[c.index() / 3] as usize));
            let [a, b] = [corner, twin].map(|c| free.length(c));
            let common = match pattern {
                [true, true] => 0.5 * (a + b),
                [true, false] => b,
                [false, true] => a,
                [false, false] => continue,
            };
            [corner, twin].into_iter().zip(pattern).filter(|(_, is)| *is).for_each(|(c, _)| {
                lengths.insert(c, common);
            });
        }
        lengths
    }

    /// Notes the stretch of free panels where it is more than the cage's: such a shell does not lie flat.
    fn note_stretch(&mut self, free: &Rest) {
        let mut parts = vec![Vec::new(); self.stretch.len()];
        for flat in self.stretches(free) {
            parts[self.surface.shells[flat.face] as usize].push((flat.stretch, flat.area));
        }
        let solved = parts.iter().map(|parts| root_mean_square(parts));
        self.stretch.iter_mut().zip(solved).for_each(|(own, solved)| *own = own.max(solved));
    }

    /// The flat triangles against their wanted shapes.
    fn stretches(&self, rest: &Rest) -> impl Iterator<Item = FlatTriangle> {
        (0..rest.triangles.len()).filter(|&face| rest.is_flat[face]).map(|face| {
            let [a, b, c] = rest.triangles[face].map(|v| rest.points[v as usize].truncate().as_dvec2());
            let target = DMat2::from_cols(self.edges[face][0], -self.edges[face][2]);
            let map = DMat2::from_cols(b - a, c - a) * target.inverse();
            FlatTriangle {
                face,
                stretch: stretch::root(map.transpose() * map),
                is_flipped: map.determinant() <= 0.0,
                area: 0.5 * target.determinant(),
            }
        })
    }

    /// The shape at rest. `free` has panels without common lengths along their seams.
    fn at_rest(&self, free: &Rest) -> Rest {
        let seams = self.seams(free);
        let mut rest = self.solved(Some(free), &seams);
        rest.figures = self.figures(&rest, &seams);
        rest.flat_seams = self.flat_seams(&rest);
        rest
    }

    fn flat_seams(&self, rest: &Rest) -> Vec<[FaceId; 2]> {
        let topology = self.surface.topology;
        let pairs = twins(topology).map(|pair| pair.map(|corner| topology.faces.face_of(corner)));
        pairs.filter(|[a, b]| rest.is_flat[a.index()] != rest.is_flat[b.index()]).collect()
    }

    /// All shells at rest. `free` are the panels without common lengths, from which those with some begin.
    fn solved(&self, free: Option<&Rest>, seams: &BTreeMap<CornerId, f64>) -> Rest {
        let mut faces_of: Vec<Vec<usize>> = vec![Vec::new(); self.stretch.len()];
        self.surface.shells.iter().enumerate().for_each(|(face, &shell)| faces_of[shell as usize].push(face));
        let solved: Vec<(Vec<[usize; 3]>, Vec<Vec3>)> = faces_of
            .par_iter()
            .enumerate()
            .map(|(shell, faces)| {
                let has_seam = |face: &usize| (0..3).any(|k| seams.contains_key(&CornerId::new(3 * face + k)));
                match free {
                    _ if !self.is_pattern(shell) => self.modelled(faces),
                    Some(free) if !faces.iter().any(has_seam) => free.shell(faces),
                    _ => self.panel(shell, faces, free, seams),
                }
            })
            .collect();
        let mut rest = Rest {
            points: Vec::new(),
            triangles: vec![[0; 3]; self.surface.shells.len()],
            is_flat: self.surface.shells.iter().map(|&shell| self.is_pattern(shell as usize)).collect(),
            flat_seams: Vec::new(),
            figures: RestFigures::default(),
        };
        for (faces, (triangles, points)) in faces_of.iter().zip(solved) {
            let first = rest.points.len();
            faces.iter().zip(triangles).for_each(|(&face, t)| rest.triangles[face] = t.map(|v| (first + v) as u32));
            rest.points.extend(points);
        }
        rest
    }

    /// A flat panel: one point for each vertex and UV.
    fn panel(
        &self,
        shell: usize,
        faces: &[usize],
        free: Option<&Rest>,
        seams: &BTreeMap<CornerId, f64>,
    ) -> (Vec<[usize; 3]>, Vec<Vec3>) {
        let mut points = Vec::new();
        let mut known = BTreeMap::new();
        let mut triangles = Vec::with_capacity(faces.len());
        for &face in faces {
            triangles.push([0, 1, 2].map(|k| {
                let corner = CornerId::new(3 * face + k);
                let uv = self.product.places[corner].uv;
                let key = (self.surface.mesh.faces.vertex(corner), uv.x.to_bits(), uv.y.to_bits());
                *known.entry(key).or_insert_with(|| {
                    let laid_out = || uv.as_dvec2() * self.scale * DVec2::new(self.side[shell], 1.0);
                    points.push(free.map_or_else(laid_out, |free| free.point(corner).truncate().as_dvec2()));
                    points.len() - 1
                })
            }));
        }
        let own = |(i, face): (usize, &usize)| {
            let triangle: [usize; 3] = triangles[i];
            let of = |k: usize| Some((k, *seams.get(&CornerId::new(3 * face + k))?));
            let seams = [0, 1, 2].into_iter().filter_map(of);
            seams.map(|(k, length)| Seam { ends: [triangle[k], triangle[(k + 1) % 3]], length }).collect::<Vec<_>>()
        };
        let seams: Vec<Seam> = faces.iter().enumerate().flat_map(own).collect();
        let edges = faces.iter().map(|&face| self.edges[face]).collect();
        let flat = flatten(&Panel { points, triangles: triangles.clone(), edges, seams });
        (triangles, flat.iter().map(|p| Vec3::new(p.x as f32, p.y as f32, 0.0)).collect())
    }

    /// A shell as it is on the mesh.
    fn modelled(&self, faces: &[usize]) -> (Vec<[usize; 3]>, Vec<Vec3>) {
        let mesh = self.surface.mesh;
        let vertices = faces.iter().flat_map(|&face| mesh.faces.vertices_of(FaceId::new(face)));
        let mut corners: Vec<(VertexId, usize)> = vertices.copied().zip(0..).collect();
        corners.sort_unstable();
        let (mut triangles, mut points) = (vec![[0; 3]; faces.len()], Vec::new());
        for around in corners.chunk_by(|a, b| a.0 == b.0) {
            around.iter().for_each(|&(_, corner)| triangles[corner / 3][corner % 3] = points.len());
            points.push(mesh.points[around[0].0]);
        }
        (triangles, points)
    }

    fn figures(&self, rest: &Rest, seams: &BTreeMap<CornerId, f64>) -> RestFigures {
        let panels = (0..self.stretch.len()).filter(|&shell| self.is_pattern(shell)).count();
        let mut figures =
            RestFigures { panels, modelled: self.stretch.len() - panels, stretch_max: 1.0, ..RestFigures::default() };
        let mut parts = Vec::new();
        for flat in self.stretches(rest) {
            figures.flipped += usize::from(flat.is_flipped);
            let [least, most] = stretch::eigenvalues(flat.stretch);
            figures.stretch_max = figures.stretch_max.max(most).max(1.0 / least);
            parts.push((flat.stretch, flat.area));
        }
        figures.stretch_rms = root_mean_square(&parts);
        let difference = |(&corner, common): (&CornerId, &f64)| (rest.length(corner) - common).abs() / common;
        // Each side is off by half of their difference.
        figures.seam_difference = 2.0 * seams.iter().map(difference).fold(0.0, f64::max);
        figures
    }
}

#[cfg(test)]
mod tests {
    use crate::pipeline::build;
    use crate::recipe::Recipe;
    use tailor_testing::sheets::{grid, with_uvs};

    /// Two sheets: a bent one, and a dome whose UVs are 45 times too long one way and 30 times too short the other (as large as it, in
    /// all), so that nothing is known of its stretch before it is laid flat.
    #[test]
    fn a_shell_that_does_not_lie_flat_rests_as_modelled() {
        let mut garment = grid(9, 4, |x, _| x != 4);
        garment.primvars.clear();
        let mut garment = with_uvs(garment, |_, v| match ((v % 10) as f32, (v / 10) as f32) {
            (x, y) if x < 4.5 => [x, y],
            (x, y) => [45.0 * x, y / 30.0],
        });
        for (i, point) in garment.points.iter_mut().enumerate().filter(|(i, _)| i % 10 > 4) {
            let [x, y] = [(i % 10) as f32 - 5.0, (i / 10) as f32].map(|at| (std::f32::consts::PI * at / 4.0).sin());
            point.z = 2.0 * x * y;
        }
        let products = build(&garment, &Recipe::default()).expect("two sheets");
        let rest = products.cloth.as_ref().and_then(|cloth| cloth.rest.clone()).expect("a shape at rest");
        let modelled: Vec<usize> = (0..rest.is_flat.len()).filter(|&face| !rest.is_flat[face]).collect();
        assert!(
            (10..rest.is_flat.len() - 10).contains(&modelled.len()),
            "{} of {}",
            modelled.len(),
            rest.is_flat.len()
        );
        for (face, id) in products.sim.faces.ids().enumerate().filter(|(face, _)| !rest.is_flat[*face]) {
            let corners = products.sim.faces.vertices_of(id);
            for (&v, &at) in corners.iter().zip(&rest.triangles[face]) {
                assert_eq!(rest.points[at as usize], products.sim.points[v], "{face}");
            }
        }
    }
}
