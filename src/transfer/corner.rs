//! Values of corners: the constraint UVs as they were made, others at the corners' places on the baseline.

use super::shell::{Cuts, ROUNDS, Source};
use super::{Sites, Target};
use crate::error::Warning;
use crate::garment::{Garment, Mixing, Primvar, Values};
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::{Location, SimProduct};
use crate::subdivide::{Channel, ChannelChild, Real, mix, mix_rows, taken};
use rayon::prelude::*;

/// Values that differ by no more than this share of the largest are the same: they came to one place on two ways.
const SAME: f64 = 4e-6;
/// A triangle in UV with less than this share of the area that it has on the baseline counts as flipped.
const MIN_AREA: f64 = 0.02;

/// A face-varying primvar on the simulation mesh.
pub(super) fn carry(
    garment: &Garment,
    primvar: &Primvar,
    target: &Target<'_>,
    uv_set: Option<&Primvar>,
    warnings: &mut Vec<Warning>,
) -> Primvar {
    let Target { product, sites, .. } = *target;
    if uv_set.is_some_and(|uv| uv.name == primvar.name) {
        let values: Vec<f32> = product.places.iter().flat_map(|p| p.uv.to_array()).collect();
        let same = |a: CornerId, b: CornerId| values[2 * a.index()..][..2] == values[2 * b.index()..][..2];
        let rows = indexed(sites, true, same);
        return rows.primvar(primvar, &Values::F32(values));
    }
    let (carried, apart) = match &primvar.values {
        Values::F32(v) if primvar.is_mixed() => Field::new(garment, primvar, product, v).carry(target, Values::F32),
        Values::F64(v) if primvar.is_mixed() => Field::new(garment, primvar, product, v).carry(target, Values::F64),
        _ => {
            let source = |i| product.baseline.source_corner(sites.centre(FaceId::new(i))).index();
            let sources: Vec<usize> = (0..product.triangles.len()).into_par_iter().map(source).collect();
            (taken(primvar, sources.iter().flat_map(|&c| [c; 3])), 0)
        }
    };
    if apart > 0 {
        warnings.push(Warning::NotCarried {
            what: format!("the shells of {apart} triangles in primvars:{} on the simulation mesh", primvar.name),
            why: "next to others of their side they would lie the wrong way round, so that they are cut off; make the cuts \
                  of the layout edges of the mesh, or lower sim.maxEdgeLength"
                .into(),
        });
    }
    carried
}

/// A face-varying primvar refined to the baseline.
struct Field<'a, T> {
    product: &'a SimProduct,
    primvar: &'a Primvar,
    /// The primvar's topology on the finest level.
    channel: Channel,
    /// Its values there.
    values: Vec<T>,
    /// Values that differ by no more are the same.
    slack: f64,
}

/// What each face and corner near the cuts takes.
struct Sides<T> {
    homes: Vec<Option<FaceId>>,
    sources: IdVec<CornerId, Source>,
    values: Vec<T>,
}

/// A face of the simulation mesh, and the triangle of the baseline on whose side it is.
type Home = (FaceId, FaceId);

impl<'a, T: Real> Field<'a, T> {
    fn new(garment: &Garment, primvar: &'a Primvar, product: &'a SimProduct, source: &[T]) -> Self {
        let baseline = &product.baseline;
        let own = primvar.corner_rows(&garment.faces, garment.points.len());
        let row = |c: CornerId| own[baseline.manifold.corner_source[c]] as usize;
        let rules = garment.rules;
        let cage = &baseline.manifold.refiner.level;
        let (mut channel, rows) = Channel::base(cage, row, rules.face_varying, rules.boundary);
        let width = primvar.width();
        let mut values: Vec<T> =
            rows.iter().flat_map(|&r| source[r as usize * width..][..width].iter().copied()).collect();
        // Along the levels that the baseline has, so that only the channel itself is refined.
        for (parent, child) in baseline.parents().zip(&baseline.levels) {
            let refined = ChannelChild::new(&parent.level, &channel);
            values = mix_rows(&refined, &values, primvar);
            let next = refined.into_channel(&child.level);
            channel = next;
        }
        let largest = values.iter().map(|v| v.to_f64().abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
        Self { product, primvar, channel, values, slack: SAME * largest }
    }

    /// The cuts of this channel with the barriers of the baseline; none where it has no other cuts than those.
    fn barrier(&self) -> Option<IdVec<CornerId, bool>> {
        let baseline = &self.product.baseline;
        let value = |c: CornerId| self.channel.corner_value[baseline.level_corner[c]];
        let t = &baseline.topology;
        let is_cut = |c: CornerId| {
            let Some(twin) = t.twin(c) else { return false };
            value(c) != value(t.faces.next(twin)) || value(t.faces.next(c)) != value(twin)
        };
        let cut: IdVec<CornerId, bool> = t.faces.corners().ids().map(is_cut).collect();
        let has_own = cut.enumerated().any(|(c, &cut)| cut && !baseline.barrier[c]);
        has_own.then(|| cut.iter().zip(baseline.barrier.iter()).map(|(&cut, &barrier)| cut || barrier).collect())
    }

    /// The primvar, and how many of its triangles had to be cut off.
    fn carry(&self, target: &Target<'_>, wrap: impl Fn(Vec<T>) -> Values) -> (Primvar, usize) {
        let sites = target.sites;
        let (values, apart) = match self.barrier() {
            Some(barrier) => self.on_sides(&Cuts::new(self.product, sites, target.coverage, barrier), sites),
            None => (self.product.places.par_iter().flat_map_iter(|p| self.at_location(&p.location)).collect(), 0),
        };
        let rows = indexed(sites, false, |a, b| self.same(&values, a, b));
        (rows.primvar(self.primvar, &wrap(values)), apart)
    }

    fn corner(&self, corner: CornerId) -> &[T] {
        let value = self.channel.corner_value[self.product.baseline.level_corner[corner]];
        let width = self.primvar.width();
        &self.values[value.index() * width..][..width]
    }

    fn at_location(&self, at: &Location) -> Vec<T> {
        let first = at.face.index() * 3;
        let parts = [0, 1, 2].map(|k| (self.corner(CornerId::new(first + k)), at.weights[k]));
        mix(parts.into_iter(), self.primvar)
    }

    fn same(&self, values: &[T], a: CornerId, b: CornerId) -> bool {
        let width = self.primvar.width();
        let row = |c: CornerId| &values[c.index() * width..][..width];
        row(a).iter().zip(row(b)).all(|(a, b)| (a.to_f64() - b.to_f64()).abs() <= self.slack)
    }

    /// The values of each corner on its side of the cuts, and how many triangles are cut off, as they would lie the wrong
    /// way round beside their neighbours.
    fn on_sides(&self, cuts: &Cuts<'_>, sites: &Sites<'_>) -> (Vec<T>, usize) {
        let is_layout = self.primvar.width() == 2 && self.primvar.mixing == Mixing::Linear;
        let homes = cuts.homes();
        let sources = cuts.sources(&homes);
        let values = sources.par_iter().flat_map_iter(|s| self.at_location(&s.location)).collect();
        let mut sides = Sides { homes, sources, values };
        let mut best: Option<(Vec<T>, Vec<Home>)> = None;
        for _ in 0..ROUNDS {
            self.join_islands(cuts, &mut sides);
            let flipped = if is_layout { self.unflip(cuts, sites, &mut sides) } else { Vec::new() };
            let other = |&(face, _): &Home| Some((face, cuts.other_home(face, &sides.homes)?));
            let turned: Vec<Home> = flipped.iter().filter_map(other).collect();
            if best.as_ref().is_none_or(|b| flipped.len() < b.1.len()) {
                best = Some((sides.values.clone(), flipped));
            }
            if turned.is_empty() {
                break;
            }
            self.rehome(cuts, &turned, &mut sides);
        }
        let (mut values, apart) = best.unwrap_or_default();
        for &(face, home) in &apart {
            for corner in sites.topology.faces.corners_of(face) {
                let inside = Location { face: home, weights: glam::Vec3::splat(1.0 / 3.0) };
                let source = cuts.continued(corner, Source { location: inside, moved: true });
                values[2 * corner.index()..][..2].copy_from_slice(&self.at_location(&source.location));
            }
        }
        (values, apart.len())
    }

    fn join_islands(&self, cuts: &Cuts<'_>, sides: &mut Sides<T>) {
        for _ in 0..ROUNDS {
            let islands = cuts.islands(&sides.homes, |a, b| self.same(&sides.values, a, b));
            if islands.is_empty() {
                break;
            }
            self.rehome(cuts, &islands, sides);
        }
    }

    /// Gives faces other homes.
    fn rehome(&self, cuts: &Cuts<'_>, faces: &[Home], sides: &mut Sides<T>) {
        faces.iter().for_each(|&(face, home)| sides.homes[face.index()] = Some(home));
        let width = self.primvar.width();
        for corner in cuts.renew(faces, &sides.homes, &mut sides.sources) {
            let value = self.at_location(&sides.sources[corner].location);
            sides.values[corner.index() * width..][..width].copy_from_slice(&value);
        }
    }

    /// Continues the values beyond the cuts where keeping them inside turns a triangle over. Returns those that stay so.
    fn unflip(&self, cuts: &Cuts<'_>, sites: &Sites<'_>, sides: &mut Sides<T>) -> Vec<Home> {
        let homes = sides.homes.iter().enumerate();
        let near: Vec<Home> = homes.filter_map(|(i, h)| Some((FaceId::new(i), (*h)?))).collect();
        for _ in 0..ROUNDS {
            let mut changed = false;
            for &(face, home) in &near {
                if !self.is_flipped(face, home, sides) {
                    continue;
                }
                for corner in sites.topology.faces.corners_of(face) {
                    if sides.sources[corner].moved {
                        self.go_on(cuts, sites, corner, sides);
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        near.into_iter().filter(|(face, home)| self.is_flipped(*face, *home, sides)).collect()
    }

    /// Continues the value of a corner, and of those that share it, beyond their side to where the vertex is.
    fn go_on(&self, cuts: &Cuts<'_>, sites: &Sites<'_>, corner: CornerId, sides: &mut Sides<T>) {
        let before = [0, 1].map(|k| sides.values[2 * corner.index() + k].to_f64());
        let source = Source { moved: false, ..cuts.continued(corner, sides.sources[corner]) };
        let value = self.at_location(&source.location);
        let t = &sites.topology;
        for &other in t.vertex_corners.row(t.faces.vertex(corner)) {
            let own = &mut sides.values[2 * other.index()..][..2];
            if own.iter().zip(&before).all(|(a, b)| (a.to_f64() - b).abs() <= self.slack) {
                own.copy_from_slice(&value);
                sides.sources[other] = source;
            }
        }
    }

    /// Whether a triangle has too little area in UV for what it has in space, or lies the other way round than its home.
    /// Not where the layout itself folds over.
    fn is_flipped(&self, face: FaceId, home: FaceId, sides: &Sides<T>) -> bool {
        let product = self.product;
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * face.index() + k));
        let of_home = self.doubled_area(home);
        let folds = |c: CornerId| self.doubled_area(sides.sources[c].location.face) * of_home <= 0.0;
        if corners.into_iter().any(folds) {
            return false;
        }
        let own = doubled_area(corners.map(|c| &sides.values[2 * c.index()..][..2]));
        let [a, b, c] = product.triangles[face.index()].map(|v| product.points[v]);
        let in_space = f64::from((b - a).cross(c - a).length()) / f64::from(product.baseline.normal(home).length());
        in_space.is_finite() && own * of_home.signum() <= MIN_AREA * of_home.abs() * in_space
    }

    /// Twice the signed area in UV of a triangle of the baseline.
    fn doubled_area(&self, face: FaceId) -> f64 {
        doubled_area([0, 1, 2].map(|k| self.corner(CornerId::new(3 * face.index() + k))))
    }
}

fn doubled_area<T: Real>([a, b, c]: [&[T]; 3]) -> f64 {
    let side = |p: &[T]| [0, 1].map(|k| p[k].to_f64() - a[k].to_f64());
    let (u, v) = (side(b), side(c));
    u[0] * v[1] - u[1] * v[0]
}

/// The corners that have a value each, and for every corner the one whose value it shares.
struct Rows {
    rows: Vec<usize>,
    indices: Vec<u32>,
}

impl Rows {
    fn primvar(self, primvar: &Primvar, values: &Values) -> Primvar {
        let values = values.gather(primvar.width(), self.rows.into_iter());
        Primvar { values, indices: Some(self.indices), ..primvar.clone() }
    }
}

/// Corners of a vertex share a value where neither a difference nor, for the constraint UVs, a seam is between them.
fn indexed(sites: &Sites<'_>, keep_seams: bool, same: impl Fn(CornerId, CornerId) -> bool) -> Rows {
    let t = &sites.topology;
    let mut row: IdVec<CornerId, Option<u32>> = IdVec::filled(None, t.faces.corners().len());
    let mut rows = Vec::new();
    for seed in t.faces.corners().ids() {
        if row[seed].is_some() {
            continue;
        }
        let own = rows.len() as u32;
        rows.push(seed.index());
        row[seed] = Some(own);
        let mut reached = vec![seed];
        while let Some(corner) = reached.pop() {
            // The neighbours around the vertex: across the edge that leaves and across the one that arrives.
            let before = t.twin(corner).map(|twin| (t.corner_edge[corner], t.faces.next(twin)));
            let arriving = t.faces.prev(corner);
            let after = t.twin(arriving).map(|twin| (t.corner_edge[arriving], twin));
            for (edge, other) in before.into_iter().chain(after) {
                let is_cut = keep_seams && sites.is_seam[edge];
                // By the value that is kept, so that small differences do not add up around a vertex.
                if !is_cut && row[other].is_none() && same(seed, other) {
                    row[other] = Some(own);
                    reached.push(other);
                }
            }
        }
    }
    Rows { rows, indices: row.iter().map(|r| r.unwrap_or(0)).collect() }
}
