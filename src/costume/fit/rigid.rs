//! A cage as rigid as possible: each vertex turns with its edges, which have wanted lengths, and limits hold.
//!
//! Local and global steps of Sorkine and Alexa 2007, *As-Rigid-As-Possible Surface Modeling*, with equal weights, which suit the
//! long and uneven quads of garments. In the global step limits hold by the method of multipliers (Hestenes 1969) and Newton's
//! method, whose systems the method of conjugate gradients solves.

use super::FitOptions;
use super::cage::Cage;
use glam::{DMat3, DQuat, DVec3};
use tailor::contact::WorkLimit;

/// Weights of the edges of sets that keep their lengths, and of those that are rigid, against that of an edge.
const KEPT_WEIGHT: f64 = 10.0;
const RIGID_WEIGHT: f64 = 100.0;
/// Weight of a limit that pushes.
const LIMIT_WEIGHT: f64 = 100.0;
/// Steps of the multipliers, and Newton's steps in each.
const MULTIPLIER_STEPS: usize = 6;
const NEWTON_STEPS: usize = 8;
/// Steps of conjugate gradients at most, and the share of the first residual at which they end.
const MOST_STEPS: usize = 1000;
const RESIDUAL: f64 = 1e-4;
/// Terms of sums that take the work of a test of two boxes.
const TERMS: usize = 4;
/// Halvings of the interval of a line search.
const HALVINGS: usize = 20;
/// Iterations for a rotation at most, and the share of the matrix that keeps their steps finite.
const TURNS: usize = 20;
const LEAST_SHARE: f64 = 1e-9;

/// A cage at rest.
pub struct RigidCage<'a> {
    rest: &'a [DVec3],
    edges: &'a [[usize; 2]],
    /// Weight of each edge.
    weights: Vec<f64>,
    /// Weight of the pull of each vertex to its target.
    pull: Vec<f64>,
    /// Whether each edge keeps its length.
    is_kept: Vec<bool>,
    /// Vertices that move as wholes.
    parts: Vec<Vec<usize>>,
}

/// What a cage is drawn to at one time.
pub struct Goal<'a> {
    pub targets: &'a [DVec3],
    /// Each edge as it is wanted before its ends turn.
    pub edges: &'a [DVec3],
    pub limits: Vec<Limit>,
}

/// A gap that may not be less than zero: the product of a normal and a weighted sum of vertices of the cage, and a number.
#[derive(Clone, Debug)]
pub struct Limit {
    /// Those without a weight do not count.
    pub terms: [(usize, f64); 4],
    pub normal: DVec3,
    pub constant: f64,
}

impl Limit {
    fn sum(&self, points: &[DVec3]) -> f64 {
        self.normal.dot(self.terms.iter().map(|&(v, weight)| weight * points[v]).sum())
    }

    pub fn value(&self, points: &[DVec3]) -> f64 {
        self.sum(points) + self.constant
    }
}

impl<'a> RigidCage<'a> {
    pub fn new(cage: &'a Cage, rest: &'a [DVec3], pull: Vec<f64>, options: &FitOptions) -> Self {
        let mut weights = vec![1.0; cage.edges.len()];
        let mut is_kept = vec![false; cage.edges.len()];
        let sets = options.keep_length.iter().map(|set| (set, KEPT_WEIGHT));
        for (set, weight) in sets.chain(options.rigid.iter().map(|set| (set, RIGID_WEIGHT))) {
            for (e, _) in cage.edges_in(set).iter().enumerate().filter(|(_, is_in)| **is_in) {
                (weights[e], is_kept[e]) = (weight, true);
            }
        }
        let mut is_rigid = vec![false; cage.edges.len()];
        for set in &options.rigid {
            is_rigid.iter_mut().zip(cage.edges_in(set)).for_each(|(is, own)| *is |= own);
        }
        let parts = cage.parts_of(&is_rigid);
        Self { rest, edges: &cage.edges, weights, pull, is_kept, parts }
    }

    /// Wanted edges, of which some are as at rest.
    pub fn kept(&self, mut wanted: Vec<DVec3>) -> Vec<DVec3> {
        let kept = wanted.iter_mut().zip(self.edges).zip(&self.is_kept).filter(|(_, is_kept)| **is_kept);
        kept.for_each(|((edge, &[i, j]), _)| *edge = self.rest[i] - self.rest[j]);
        wanted
    }

    /// Makes the parts that move as wholes exactly rigid.
    pub fn snap(&self, points: &mut [DVec3]) {
        for part in &self.parts {
            let mean = |points: &[DVec3]| part.iter().map(|&v| points[v]).sum::<DVec3>() / part.len() as f64;
            let (from, to) = (mean(self.rest), mean(points));
            let outer = part.iter().map(|&v| outer(points[v] - to, self.rest[v] - from));
            let turn = rotation(&outer.fold(DMat3::ZERO, |sum, own| sum + own), DQuat::IDENTITY);
            part.iter().for_each(|&v| points[v] = to + turn * (self.rest[v] - from));
        }
    }

    /// The rotation of each vertex from rest, from one before. A part that moves as a whole has one.
    pub fn turns(&self, edges: &[DVec3], points: &[DVec3], turns: &mut [DQuat]) {
        let mut sums = vec![DMat3::ZERO; self.rest.len()];
        for ((&[i, j], weight), &edge) in self.edges.iter().zip(&self.weights).zip(edges) {
            let own = outer(points[i] - points[j], edge) * *weight;
            sums[i] += own;
            sums[j] += own;
        }
        for part in &self.parts {
            let sum = part.iter().fold(DMat3::ZERO, |sum, &v| sum + sums[v]);
            part.iter().for_each(|&v| sums[v] = sum);
        }
        turns.iter_mut().zip(&sums).for_each(|(turn, sum)| *turn = rotation(sum, *turn));
    }

    /// Moves points to where the edges, the targets and the limits ask for, with limits that hold nearly. Not there yet beyond the
    /// bound of work.
    pub fn solve(&self, goal: &Goal, turns: &[DQuat], points: &mut [DVec3], work: &WorkLimit) {
        let mut right: Vec<DVec3> = self.pull.iter().zip(goal.targets).map(|(pull, target)| *pull * *target).collect();
        for (e, &[i, j]) in self.edges.iter().enumerate() {
            let wanted = 0.5 * self.weights[e] * (turns[i] * goal.edges[e] + turns[j] * goal.edges[e]);
            right[i] += wanted;
            right[j] -= wanted;
        }
        // Each multiplier as a length by which its limit is shifted.
        let mut shifts = vec![0.0; goal.limits.len()];
        for _ in 0..MULTIPLIER_STEPS {
            self.newton(goal, &shifts, &right, points, work);
            let mut most: f64 = 0.0;
            for (shift, limit) in shifts.iter_mut().zip(&goal.limits) {
                let value = limit.value(points);
                most = most.max(-value);
                *shift = (*shift - value).max(0.0);
            }
            if most <= 0.0 {
                break;
            }
        }
    }

    /// The points of least energy with multipliers, by Newton's steps with the limits that push.
    fn newton(&self, goal: &Goal, shifts: &[f64], right: &[DVec3], points: &mut [DVec3], work: &WorkLimit) {
        let mut before: Vec<usize> = vec![usize::MAX];
        for _ in 0..NEWTON_STEPS {
            let missing: Vec<f64> = goal.limits.iter().zip(shifts).map(|(l, s)| s - l.value(points)).collect();
            let pushing: Vec<usize> = (0..missing.len()).filter(|&c| missing[c] > 0.0).collect();
            if pushing == before || !work.take(HALVINGS * missing.len() / TERMS) {
                return;
            }
            let active: Vec<(&Limit, f64)> = pushing.iter().map(|&c| (&goal.limits[c], shifts[c])).collect();
            let mut next = points.to_vec();
            self.gradients(&active, right, &mut next, work);
            let along: Vec<DVec3> = next.iter().zip(points.iter()).map(|(n, p)| *n - *p).collect();
            let share = self.best_share(goal, &missing, right, points, &along);
            points.iter_mut().zip(&along).for_each(|(point, by)| *point += share * *by);
            before = pushing;
        }
    }

    /// The share of a step at which the energy is least.
    fn best_share(&self, goal: &Goal, missing: &[f64], right: &[DVec3], points: &[DVec3], along: &[DVec3]) -> f64 {
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let slope = dot(&self.product(&[], points), along) - dot(right, along);
        let curve = dot(&self.product(&[], along), along);
        let changes: Vec<(f64, f64)> = goal.limits.iter().zip(missing).map(|(l, m)| (*m, l.sum(along))).collect();
        let slope_at = |share: f64| {
            let pushes = changes.iter().map(|&(missing, change)| (missing - share * change).max(0.0) * -change);
            slope + share * curve + LIMIT_WEIGHT * pushes.sum::<f64>()
        };
        let (mut low, mut high) = (0.0, 1.0);
        if slope_at(high) <= 0.0 {
            return high;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if slope_at(middle) > 0.0 { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    }

    /// The points of least energy with some limits as springs, by conjugate gradients from the points before.
    fn gradients(&self, active: &[(&Limit, f64)], right: &[DVec3], points: &mut [DVec3], work: &WorkLimit) {
        let (right, inverse) = self.system(active, right);
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let preconditioned = |r: &[DVec3]| r.iter().zip(&inverse).map(|(r, m)| *m * *r).collect::<Vec<_>>();
        let product = self.product(active, points);
        let mut residual: Vec<DVec3> = right.iter().zip(&product).map(|(r, p)| *r - *p).collect();
        let mut z = preconditioned(&residual);
        let mut along = z.clone();
        let mut rz = dot(&residual, &z);
        let enough = RESIDUAL * RESIDUAL * rz;
        for _ in 0..MOST_STEPS {
            let terms = points.len() + self.edges.len() + 4 * active.len();
            if rz <= enough || rz.is_nan() || rz <= 0.0 || !work.take(terms / TERMS) {
                break;
            }
            let product = self.product(active, &along);
            let step = rz / dot(&along, &product);
            for i in 0..points.len() {
                points[i] += step * along[i];
                residual[i] -= step * product[i];
            }
            z = preconditioned(&residual);
            let next = dot(&residual, &z);
            let share = next / rz;
            along.iter_mut().zip(&z).for_each(|(a, z)| *a = *z + share * *a);
            rz = next;
        }
    }

    /// The right side with the limits, and the inverses of the blocks of the system's diagonal.
    fn system(&self, active: &[(&Limit, f64)], right: &[DVec3]) -> (Vec<DVec3>, Vec<DMat3>) {
        let mut right = right.to_vec();
        let mut blocks: Vec<DMat3> = self.pull.iter().map(|&pull| DMat3::from_diagonal(DVec3::splat(pull))).collect();
        for (&[i, j], &weight) in self.edges.iter().zip(&self.weights) {
            [i, j].into_iter().for_each(|v| blocks[v] += DMat3::from_diagonal(DVec3::splat(weight)));
        }
        for (limit, shift) in active {
            for &(v, weight) in limit.terms.iter().filter(|term| term.1 != 0.0) {
                let along = weight * limit.normal;
                right[v] += LIMIT_WEIGHT * (shift - limit.constant) * along;
                blocks[v] += outer(along, along) * LIMIT_WEIGHT;
            }
        }
        (right, blocks.iter().map(DMat3::inverse).collect())
    }

    /// The product of the system with a vector.
    fn product(&self, active: &[(&Limit, f64)], vector: &[DVec3]) -> Vec<DVec3> {
        let mut product: Vec<DVec3> = self.pull.iter().zip(vector).map(|(pull, x)| *pull * *x).collect();
        for (&[i, j], &weight) in self.edges.iter().zip(&self.weights) {
            let force = weight * (vector[i] - vector[j]);
            product[i] += force;
            product[j] -= force;
        }
        for (limit, _) in active {
            let force = LIMIT_WEIGHT * limit.sum(vector) * limit.normal;
            limit.terms.iter().filter(|term| term.1 != 0.0).for_each(|&(v, weight)| product[v] += weight * force);
        }
        product
    }
}

/// The rotation nearest to a matrix, from one before (Müller et al. 2016, *A Robust Method to Extract the Rotational Part of
/// Deformations*).
pub fn rotation(matrix: &DMat3, mut turn: DQuat) -> DQuat {
    let least = LEAST_SHARE * (matrix.x_axis.length() + matrix.y_axis.length() + matrix.z_axis.length());
    for _ in 0..TURNS {
        let own = DMat3::from_quat(turn);
        let pairs = [(own.x_axis, matrix.x_axis), (own.y_axis, matrix.y_axis), (own.z_axis, matrix.z_axis)];
        let moment: DVec3 = pairs.iter().map(|(a, b)| a.cross(*b)).sum();
        let length: f64 = pairs.iter().map(|(a, b)| a.dot(*b)).sum::<f64>().abs();
        let by = moment / (length + least).max(f64::MIN_POSITIVE);
        let angle = by.length();
        if angle.is_nan() || angle <= 1e-9 {
            break;
        }
        turn = (DQuat::from_axis_angle(by / angle, angle) * turn).normalize();
    }
    turn
}

/// The matrix of the products of two vectors.
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use tailor_mesh::connectivity::{Elements, FaceId, Faces, VertexId};
    use tailor_mesh::garment::Mesh;

    /// A flat sheet of n by n quads.
    fn sheet(n: usize) -> Mesh {
        let corner = |i: usize| (i / n) * (n + 1) + i % n;
        let quads = (0..n * n).flat_map(|i| [0, 1, n + 2, n + 1].map(|k| VertexId::new(corner(i) + k)));
        let points = (0..(n + 1) * (n + 1)).map(|i| Vec3::new((i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0));
        Mesh { points: points.collect(), faces: Faces::quads(quads.collect::<Vec<_>>()), ..Mesh::default() }
    }

    /// The sheet after some rounds with its targets at `targets` and with `limits`.
    fn solved(mesh: &Mesh, options: &FitOptions, target: impl Fn(DVec3) -> DVec3, limits: Vec<Limit>) -> Vec<DVec3> {
        let (cage, rest) = (Cage::new(mesh), mesh.points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>());
        let rigid = RigidCage::new(&cage, &rest, vec![0.1; rest.len()], options);
        let edges = rigid.kept(cage.edges.iter().map(|&[a, b]| target(rest[a]) - target(rest[b])).collect());
        let targets: Vec<DVec3> = rest.iter().map(|&p| target(p)).collect();
        let goal = Goal { targets: &targets, edges: &edges, limits };
        let (mut points, mut turns) = (rest.clone(), vec![DQuat::IDENTITY; rest.len()]);
        for _ in 0..20 {
            rigid.turns(&edges, &points, &mut turns);
            rigid.solve(&goal, &turns, &mut points, &WorkLimit::default());
        }
        rigid.snap(&mut points);
        points
    }

    #[test]
    fn limits_that_contradict_nothing_hold() {
        let mesh = sheet(6);
        // A floor under every vertex that is above their targets at one end, and across the sheet at the other.
        let floor = |v: usize| Limit {
            terms: [(v, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
            normal: DVec3::Z,
            constant: 2.0 - 0.5 * (v % 7) as f64,
        };
        let points = solved(&mesh, &FitOptions::default(), |p| p - 3.0 * DVec3::Z, (0..49).map(floor).collect());
        for (v, point) in points.iter().enumerate() {
            assert!(floor(v).value(&points) > -1e-3, "vertex {v} at {point}");
        }
        // It is no higher than it has to be.
        assert!(points.iter().all(|p| p.z < 1.2), "{points:?}");
    }

    #[test]
    fn rigid_parts_keep_their_shape_and_the_others_grow() {
        let mesh = sheet(6);
        let button = [7, 8, 13].map(FaceId::new).to_vec();
        let options = FitOptions { rigid: vec![Elements::Faces(button.clone())], ..FitOptions::default() };
        let turn = DQuat::from_rotation_y(0.7);
        let points = solved(&mesh, &options, |p| turn * (p * 1.5), Vec::new());
        let of_button: Vec<usize> = button.iter().flat_map(|&f| mesh.faces.vertices_of(f)).map(|v| v.index()).collect();
        let rest: Vec<DVec3> = mesh.points.iter().map(|p| p.as_dvec3()).collect();
        for &a in &of_button {
            let gap = |points: &[DVec3]| points[a].distance(points[of_button[0]]);
            assert!((gap(&points) - gap(&rest)).abs() < 1e-9);
        }
        assert!((points[47].distance(points[48]) - 1.5).abs() < 0.05);
    }

    #[test]
    fn a_rotation_is_found_at_any_scale() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.0);
        for scale in [1e-14, 1.0, 1e14] {
            let stretch = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.3) * scale);
            let found = rotation(&(DMat3::from_quat(turn) * stretch), DQuat::IDENTITY);
            assert!(found.dot(turn).abs() > 1.0 - 1e-9, "{found} at {scale}");
        }
    }
}
