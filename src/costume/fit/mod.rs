//! A garment made for one body, fitted to another.
//!
//! The cage is as rigid as possible while the body changes in small steps (`path`). Its edges stretch as the body does around them
//! (`stretch`), and nothing that crosses nothing at the start may cross the body or another part of the garment
//! (`contacts`).

mod bodies;
mod bound;
mod cage;
mod clearance;
mod contacts;
mod crossings;
mod figures;
mod matching;
mod options;
mod path;
mod rigid;
mod spline;
mod stretch;
mod triangle;

pub use bodies::Bodies;
pub use figures::{BodyDistance, CrossingCount, FitFigures, SetLengths};
use figures::{OnBody, slivers};
pub use options::{BodyOptions, PanelRest};

use crate::codes;
use cage::Cage;
use crossings::{CrossingFaces, Crossings};
use glam::{DVec3, Vec3};
use path::Path;
use std::iter::once;
use tailor::contact::WorkLimit;
use tailor_mesh::connectivity::{Elements, FaceId, VertexId};
use tailor_mesh::error::{Error, ErrorKind, Warning, Warnings, counted};
use tailor_mesh::garment::Mesh;

/// Share of the points inside the body, or distance from it as a share of its size, from which a garment is not on the body.
const MOST_INSIDE: f64 = 0.5;
const MOST_DISTANCE: f64 = 0.25;
/// Distances of the nearest quarter of the points and of all on average beyond which it is not on the body either, as shares of its
/// size. Clothes are at 0.007 and 0.014.
const MOST_OF_QUARTER: f64 = 0.018;
const MOST_ON_AVERAGE: f64 = 0.035;
/// Share of the points from which a connected part counts alone, and how many times as far from the body it may be: a wide layer may
/// hang from another one.
const LARGE_PART: f64 = 0.25;
const PART_TIMES: f64 = 2.0;

/// Share of a body's area that is turned over on the other one from which a warning tells it.
const FOLDED: f64 = 0.02;

/// Share of edges that follow the body, and of points that go inside it, beyond which the garment did not follow.
const LEAST_KEPT: f64 = 0.5;
const MOST_SUNK: f64 = 0.2;

/// Work of a fit for each triangle of the garment and of the body, and of any fit: garments take a tenth. A search on one shape of the
/// body may take a part of it.
const WORK_PER_TRIANGLE: [usize; 2] = [25_000, 2_500];
const LEAST_WORK: usize = 500_000_000;
const SEARCH_PART: usize = 8;

/// How sets of the garment follow the body.
#[derive(Clone, Debug, Default)]
pub struct FitOptions {
    /// Sets whose connected parts move as wholes, such as buttons.
    pub rigid: Vec<Elements>,
    /// Sets whose edges keep their lengths, such as a hem.
    pub keep_length: Vec<Elements>,
    /// Distance that the garment gains from the body. \[mesh units\]
    pub ease: f32,
}

/// A garment on the way to another body.
#[derive(Clone, Debug)]
pub struct FitStep {
    /// Share of the way.
    pub share: f64,
    /// Its points. \[mesh units\]
    pub points: Vec<Vec3>,
}

/// A fitted garment.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The points of the garment on the other body. \[mesh units\]
    pub points: Vec<Vec3>,
    /// The garment on its way, from the start to where the way ends.
    pub steps: Vec<FitStep>,
    /// How well it fits.
    pub figures: FitFigures,
    /// What could not follow.
    pub warnings: Warnings,
}

/// Fits a garment to the second of two bodies.
///
/// ```
/// use tailor_costume::fit::{Bodies, FitOptions, fit};
/// use tailor::glam::Vec3;
/// # use std::sync::Arc;
/// # use tailor_costume::Builder;
/// # use tailor_mesh::Garment;
///
/// # fn main() -> Result<(), tailor::Error> {
/// // A sheet over a flat body that becomes twice as large.
/// let grid = |size: f32, height: f32| -> Vec<Vec3> {
///     (0..25).map(|i| Vec3::new(size * (i % 5) as f32, size * (i / 5) as f32, height)).collect()
/// };
/// let corners: Vec<i32> = (0..20).filter(|i| i % 5 < 4).flat_map(|i| [i, i + 1, i + 6, i + 5]).collect();
/// let mesh = |points: Vec<Vec3>| -> Result<Arc<tailor::Mesh>, tailor::Error> {
///     let mesh = Garment {
///         points,
///         face_vertex_counts: vec![4; 16],
///         face_vertex_indices: corners.clone(),
///         ..Garment::default()
///     };
///     Ok(Arc::clone(Builder::new(mesh)?.garment()))
/// };
/// let (small, large) = (mesh(grid(1.0, 0.0))?, mesh(grid(2.0, 0.0))?);
/// let sheet = mesh(grid(1.0, 0.1))?;
/// let fitted = fit(&sheet, &Bodies::new(&small, &large)?, &FitOptions::default())?;
/// assert!(fitted.points[24].distance(Vec3::new(8.0, 8.0, 0.1)) < 0.05, "{}", fitted.points[24]);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Points beyond the numbers of a file, and faces that lie beside very many others.
pub fn fit(mesh: &Mesh, bodies: &Bodies, options: &FitOptions) -> Result<Fitted, Error> {
    let rest: Vec<DVec3> = mesh.points.iter().map(|p| p.as_dvec3()).collect();
    let cage = Cage::new(mesh);
    let edges = cage.mean_edges(&rest);
    let on_body = |points, bodies, shape| OnBody::new(&cage, &edges, points, bodies, shape);
    let first = bodies.first();
    let start = on_body(rest.clone(), first, &first.from);
    check_crowd(mesh, &start.work)?;
    let mut warnings: Warnings = far_from_body(mesh, &cage, &start, bodies).into_iter().collect();
    warnings.extend(folded(mesh, bodies));
    let below = bodies.below(&cage, &rest, &start.crossings).into_owned().eased(f64::from(options.ease));
    let mut path = Path::new(&cage, &rest, &below, options);
    check_crowd(mesh, &path.start)?;
    let points = path.run();
    let end = on_body(points, bodies, &bodies.to);
    check_crowd(mesh, &end.work)?;
    let figures = FitFigures::new(mesh, &path, &start, &end);
    warnings.extend(new_crossings(mesh, &start, &end));
    warnings.extend(left_behind(mesh, &path, &start, &end, &figures));
    warnings.extend(thin_faces(mesh, &rest, &end.points));
    let single = |points: &[DVec3]| points.iter().map(|p| p.as_vec3()).collect::<Vec<Vec3>>();
    let points = single(&end.points);
    let step = |(share, points): &(f64, Vec<DVec3>)| FitStep { share: *share, points: single(points) };
    let steps = path.steps.iter().map(step).collect();
    if points.iter().any(|p| !p.is_finite()) {
        let fault = Error::new(ErrorKind::Mesh, &mesh.prim, "its points on the other body are not finite numbers");
        return Err(fault.code(tailor::codes::MESH_SIZE).remedy("give both bodies and the garment the same units"));
    }
    Ok(Fitted { points, steps, figures, warnings })
}

/// The faces of a mesh that cross a body, ascending.
pub fn faces_through(mesh: &Mesh, body: &Mesh) -> Result<Vec<FaceId>, Error> {
    let (bodies, cage) = (Bodies::new(body, body)?, Cage::new(mesh));
    let points: Vec<DVec3> = mesh.points.iter().map(|p| p.as_dvec3()).collect();
    let work = work_limit(&cage, &bodies, SEARCH_PART);
    let found = Crossings::of(&cage, &points, &bodies, &bodies.from, &work).faces(&cage);
    check_crowd(mesh, &work)?;
    Ok(found.body.into_iter().map(FaceId::new).collect())
}

/// The bound on the work of a fit, or on a part of it.
fn work_limit(cage: &Cage, bodies: &Bodies, part: usize) -> WorkLimit {
    let [own, of_body] = WORK_PER_TRIANGLE;
    WorkLimit::new((LEAST_WORK + own * cage.triangles.len() + of_body * bodies.triangles.len()) / part)
}

/// Refuses a garment of which a search has passed its bound.
fn check_crowd(mesh: &Mesh, search: &WorkLimit) -> Result<(), Error> {
    if !search.is_over() {
        return Ok(());
    }
    let text =
        "so many of its faces lie in the same places as others, or as faces of the body, that none can be kept apart";
    let remedy = "take out faces in disorder, and give the garment and both bodies the same place and unit";
    Err(Error::new(ErrorKind::Mesh, &mesh.prim, text).code(tailor::codes::TOO_LARGE).remedy(remedy))
}

/// The warning of a garment that is not on the body that it is said to be made for, or of a large part of it: where shoes are beside the
/// feet, one may be on the other foot.
fn far_from_body(mesh: &Mesh, cage: &Cage, start: &OnBody, bodies: &Bodies) -> Option<Warning> {
    let (size, distances) = (bodies.size(), start.bound.distances().collect::<Vec<f64>>());
    let count = distances.len().max(1) as f64;
    let inside = start.bound.heights().filter(|height| *height < 0.0).count() as f64 / count;
    let is_large = |part: &Vec<usize>| part.len() as f64 > LARGE_PART * count;
    let parts =
        cage.parts_of(&vec![true; cage.edges.len()]).into_iter().filter(is_large).map(|part| (part, PART_TIMES));
    let far = |(part, times): (Vec<usize>, f64)| {
        let mut of: Vec<f64> = part.iter().map(|v| distances[*v] / (times * size)).collect();
        of.sort_unstable_by(f64::total_cmp);
        let (mean, quarter) = (of.iter().sum::<f64>() / of.len().max(1) as f64, *of.get(of.len() / 4)?);
        let is_far = mean > MOST_DISTANCE || quarter > MOST_OF_QUARTER && mean > MOST_ON_AVERAGE;
        is_far.then_some((of.len(), mean * times * size))
    };
    let problem = if let Some((points, mean)) = once(((0..distances.len()).collect(), 1.0)).chain(parts).find_map(far) {
        format!("{points} of its {count} points are {mean:.3} away from the body on average, whose size is {size:.3}")
    } else if inside > MOST_INSIDE {
        format!("{:.0} % of its points are inside the body", 100.0 * inside)
    } else {
        return None;
    };
    Some(
        Warning::new(codes::OFF_BODY, &mesh.prim, problem)
            .remedy("Name the body that the garment was made for by --from, in the same place and unit, with faces that face outwards"),
    )
}

/// The warning of bodies that correspond badly.
fn folded(mesh: &Mesh, bodies: &Bodies) -> Option<Warning> {
    (bodies.folded > FOLDED).then(|| {
        let problem = format!("{:.0} % of the second body is flipped on the first", 100.0 * bodies.folded);
        Warning::new(codes::BODIES_FOLDED, &mesh.prim, problem)
            .remedy("Mend UVs that overlap, or give more pairs where the bodies differ most")
    })
}

/// The warning of a garment that did not follow its body.
fn left_behind(mesh: &Mesh, path: &Path, start: &OnBody, end: &OnBody, figures: &FitFigures) -> Option<Warning> {
    let heights = start.bound.heights().zip(end.bound.heights());
    let sunk: Vec<usize> = heights.enumerate().filter(|(_, (a, b))| *a > 0.0 && *b < 0.0).map(|(v, _)| v).collect();
    let problem = if path.share < 1.0 && path.work.is_over() {
        format!("its fit took too much work, and ended after {:.0} % of the way", 100.0 * path.share)
    } else if path.share < 1.0 {
        format!("it could not follow the body for more than {:.0} % of the way", 100.0 * path.share)
    } else if figures.edges_kept < LEAST_KEPT {
        format!("{:.0} % of its edges follow the body within 15 %", 100.0 * figures.edges_kept)
    } else if sunk.len() as f64 > MOST_SUNK * end.points.len() as f64 {
        format!("{} of {} points were outside of the body, and are inside it", sunk.len(), end.points.len())
    } else {
        return None;
    };
    let places = match path.stuck.elements() {
        stuck if path.share < 1.0 && !stuck.is_empty() => stuck,
        _ => Elements::Points(sunk.into_iter().map(VertexId::new).collect()),
    };
    Some(
        Warning::new(codes::FIT_LEFT_BEHIND, &mesh.prim, problem)
            .at(places)
            .remedy("Compare the bodies and the sets of --rigid and --keep-length, or mend faces in disorder"),
    )
}

/// The warning of faces that cross the body or each other and did not before.
fn new_crossings(mesh: &Mesh, start: &OnBody, end: &OnBody) -> Option<Warning> {
    let (start, found) = (&start.crossings, &end.crossings);
    let (body, own) = (&found.body - &start.body, &found.own - &start.own);
    let faces = CrossingFaces { body, own }.elements();
    (!faces.is_empty()).then(|| {
        let problem = format!("{} faces cross the body or the garment, and did not before", faces.len());
        Warning::new(codes::FIT_CROSSES, &mesh.prim, problem)
            .at(faces)
            .remedy("Raise fit.ease, or move these points by hand")
    })
}

/// The warning of faces that have become slivers.
fn thin_faces(mesh: &Mesh, before: &[DVec3], after: &[DVec3]) -> Option<Warning> {
    let faces = slivers(mesh, before, after);
    (!faces.is_empty()).then(|| {
        let count = counted(faces.len(), "face has an angle", "faces have angles");
        Warning::new(codes::FIT_SLIVERS, &mesh.prim, format!("{count} below 5 degrees, and had none before"))
            .at(Elements::Faces(faces))
            .remedy("Move these points by hand, or raise fit.ease")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_mesh::connectivity::Faces;

    /// A sheet of n by n quads of the size 1, `height` above the plane.
    fn sheet(n: usize, height: f32) -> Mesh {
        let corner = |i: usize| (i / n) * (n + 1) + i % n;
        let quads = (0..n * n).flat_map(|i| [0, 1, n + 2, n + 1].map(|k| VertexId::new(corner(i) + k)));
        let at = |i: usize| Vec3::new((i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0) / n as f32 + height * Vec3::Z;
        let points = (0..(n + 1) * (n + 1)).map(at).collect();
        Mesh { points, faces: Faces::quads(quads.collect::<Vec<_>>()), ..Mesh::default() }
    }

    /// Rings of 24 vertices about y, by their heights and radii.
    fn rings(rings: usize, ring: impl Fn(usize) -> [f32; 2], bulge: impl Fn(usize, f32) -> f32) -> Mesh {
        let quads = (0..24 * (rings - 1)).flat_map(|i| {
            let (row, next) = (24 * (i / 24), (i + 1) % 24);
            [i, i + 24, row + 24 + next, row + next].map(VertexId::new)
        });
        let at = |i: usize| {
            let ([y, radius], angle) = (ring(i / 24), std::f32::consts::TAU * (i % 24) as f32 / 24.0);
            let radius = radius * bulge(i / 24, angle);
            Vec3::new(radius * angle.sin(), y, radius * angle.cos())
        };
        Mesh {
            points: (0..24 * rings).map(at).collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_hem_that_hangs_stays_level_over_a_body_with_knees() {
        let height = |row: usize| [0.25 * row as f32, 1.0];
        // Two knees as thick as the body, below the hips.
        let knees = |row: usize, angle: f32| {
            let below = (1.0 - ((row as f32 - 10.0) / 6.0).powi(2)).max(0.0);
            1.0 + below * angle.sin().abs().powi(4)
        };
        let (from, to) = (rings(41, height, |_, _| 1.0), rings(41, height, knees));
        let skirt = rings(13, |row| [8.5 - 0.5 * row as f32, 1.03 + 0.25 * row as f32], |_, _| 1.0);
        let bodies = Bodies::new(&from, &to).expect("the same faces");
        let fitted = fit(&skirt, &bodies, &FitOptions::default()).expect("a fit");
        let hem = &fitted.points[12 * 24..];
        let range = |of: &dyn Fn(&Vec3) -> f32| {
            let (least, most) = hem.iter().map(of).fold((f32::MAX, f32::MIN), |(l, m), x| (l.min(x), m.max(x)));
            most - least
        };
        let (up, out) = (range(&|p| p.y), range(&|p| Vec3::new(p.x, 0.0, p.z).length()));
        assert!(up < 0.3 && out < 0.3, "the hem is {up} uneven up and {out} around");
    }

    #[test]
    fn a_part_that_is_beside_its_body_is_told() {
        // Legs, and stockings that are moved by their distance: one of them is on the other leg.
        let pair = |rows: usize, radius: f32, along: f32| {
            let one = rings(rows, |row| [0.4 * row as f32, radius], |_, _| 1.0);
            let points = [0.0, 4.0].map(|x| one.points.iter().map(move |p| *p + (x + along) * Vec3::X));
            let corners: Vec<usize> =
                one.faces.ids().flat_map(|face| one.faces.vertices_of(face).to_vec()).map(|v| v.index()).collect();
            let both = [0, one.points.len()].map(|from| corners.iter().map(move |v| VertexId::new(v + from)));
            let faces = Faces::quads(both.into_iter().flatten().collect::<Vec<_>>());
            Mesh { points: points.into_iter().flatten().collect(), faces, ..Mesh::default() }
        };
        let legs = pair(20, 1.0, 0.0);
        let bodies = Bodies::new(&legs, &legs).expect("the same faces");
        let told = |along: f32| {
            let garment = pair(6, 1.1, along);
            let (cage, rest) = (Cage::new(&garment), garment.points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>());
            let start = OnBody::new(&cage, &cage.mean_edges(&rest), rest.clone(), &bodies, &bodies.from);
            far_from_body(&garment, &cage, &start, &bodies).map(|warning| warning.problem)
        };
        assert_eq!(told(0.0), None);
        assert!(
            told(4.0).is_some_and(|problem| problem.starts_with("144 of its 288 points are 3.")),
            "{:?}",
            told(4.0)
        );
    }

    #[test]
    fn ease_lifts_a_garment_off_its_body() {
        let (garment, body) = (
            rings(9, |row| [2.0 + 0.25 * row as f32, 1.05], |_, _| 1.0),
            rings(25, |row| [0.25 * row as f32, 1.0], |_, _| 1.0),
        );
        let bodies = Bodies::new(&body, &body).expect("a body corresponds to itself");
        let mean = |ease: f32| {
            let fitted = fit(&garment, &bodies, &FitOptions { ease, ..FitOptions::default() }).expect("a fit");
            fitted.points.iter().map(|p| Vec3::new(p.x, 0.0, p.z).length()).sum::<f32>() / fitted.points.len() as f32
        };
        let [tight, loose] = [0.0, 0.2].map(mean);
        assert!((tight - 1.05).abs() < 0.01 && (loose - 1.25).abs() < 0.02, "{tight} {loose}");
    }

    #[test]
    fn faces_that_become_slivers_are_named() {
        let (before, mut after) = (sheet(3, 0.0), sheet(3, 0.0));
        let single = |mesh: &Mesh| mesh.points.iter().map(|p| p.as_dvec3()).collect::<Vec<DVec3>>();
        assert!(thin_faces(&before, &single(&before), &single(&before)).is_none());
        after.points[VertexId::new(5)] = Vec3::new(0.02, 0.005, 0.0);
        let warning = thin_faces(&before, &single(&before), &single(&after)).expect("slivers");
        assert!(matches!(&warning.elements, Elements::Faces(faces) if faces.contains(&FaceId::new(0))), "{warning:?}");
    }

    /// A number from 0 to 1 that looks random.
    fn random(i: usize) -> f32 {
        (i as u32).wrapping_mul(2_654_435_761).wrapping_add(12_345).wrapping_mul(2_246_822_519) as f32 / u32::MAX as f32
    }

    #[test]
    fn faces_in_disorder_are_refused_in_time() {
        let mut soup = sheet(60, 0.0);
        soup.points = (0..soup.points.len()).map(|i| Vec3::from([0, 1, 2].map(|k| random(3 * i + k)))).collect();
        let body = sheet(8, 0.0);
        let bodies = Bodies::new(&body, &body).expect("a body corresponds to itself");
        let fault = fit(&soup, &bodies, &FitOptions::default()).expect_err("nothing can be kept apart");
        assert_eq!(fault.faults[0].code, tailor::codes::TOO_LARGE, "{fault}");
        assert!(faces_through(&soup, &body).is_err());
    }

    #[test]
    fn beyond_the_bound_of_work_a_fit_is_as_good_as_it_has_become() {
        let (garment, from) = (sheet(12, 0.02), sheet(20, 0.0));
        let points = from.points.iter().map(|p| 2.0 * *p + 0.3 * (6.0 * p.x).sin() * Vec3::Z).collect();
        let bodies = Bodies::new(&from, &Mesh { points, ..from.clone() }).expect("the same faces");
        let rest: Vec<DVec3> = garment.points.iter().map(|p| p.as_dvec3()).collect();
        let cage = Cage::new(&garment);
        let run = |most: usize| {
            let mut path = Path::new(&cage, &rest, &bodies, &FitOptions::default());
            path.work = WorkLimit::new(most);
            let points = path.run();
            let over = path.work.spent().saturating_sub(most);
            let edges = cage.mean_edges(&rest);
            let start = OnBody::new(&cage, &edges, rest.clone(), &bodies, &bodies.from);
            let end = OnBody::new(&cage, &edges, points, &bodies, &bodies.to);
            let figures = FitFigures::new(&garment, &path, &start, &end);
            (path.share, path.work.spent(), over, left_behind(&garment, &path, &start, &end, &figures))
        };
        let (share, spent, _, warning) = run(usize::MAX);
        assert!(share == 1.0 && warning.is_none());
        for part in [2, 3, 10, 1000] {
            let (share, _, over, warning) = run(spent / part);
            assert!(share < 1.0 && over < spent / 8, "{share} {over} of {spent}");
            assert!(warning.is_some_and(|warning| warning.problem.contains("too much work")), "{part}");
        }
    }
}
