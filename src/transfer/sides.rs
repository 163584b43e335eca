//! Values of corners near the cuts of a channel: which side each triangle is on, found again until none is cut off or
//! turned over.

use super::Sites;
use super::corner::{Field, doubled_area};
use super::shell::{Cuts, Source};
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::Location;
use crate::subdivide::Real;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Times that sides are found again.
const ROUNDS: usize = 3;
/// A triangle in UV with less than this share of the area that it has on the baseline counts as flipped.
const MIN_AREA: f64 = 0.02;

/// Faces whose neighbours' sides are all tried, each of which takes time in proportion to the mesh.
const MAX_TRIED: usize = 16;

/// A face of the simulation mesh, and the triangle of the baseline on whose side it is.
type Home = (FaceId, FaceId);

/// What each face and corner takes.
#[derive(Clone)]
pub(super) struct Sides<'a, T> {
    field: &'a Field<'a, T>,
    cuts: &'a Cuts<'a>,
    sites: &'a Sites<'a>,
    /// For each face near the cuts its side.
    homes: Vec<Option<FaceId>>,
    sources: IdVec<CornerId, Source>,
    values: Vec<T>,
    /// Faces near the cuts whose values may have changed since they were looked at.
    stale: Vec<FaceId>,
    /// Faces that lie the wrong way round.
    flipped: BTreeSet<FaceId>,
}

/// Corners of one vertex and the value that they are to have.
struct Move<T> {
    value: [T; 2],
    corners: Vec<CornerId>,
}

impl<'a, T: Real> Sides<'a, T> {
    pub fn new(field: &'a Field<'a, T>, cuts: &'a Cuts<'a>, sites: &'a Sites<'a>) -> Self {
        let homes = cuts.homes();
        let sources = cuts.sources(&homes);
        let values = field.at_locations(|c| sources[c].location);
        let stale = (0..homes.len()).filter(|&i| homes[i].is_some()).map(FaceId::new).collect();
        Self { field, cuts, sites, homes, sources, values, stale, flipped: BTreeSet::new() }
    }

    /// The values of each corner on its side of the cuts, and how many triangles are cut off, as they would lie the wrong
    /// way round beside their neighbours.
    pub fn settle(mut self, is_layout: bool) -> (Vec<T>, usize) {
        let mut best: Option<Self> = None;
        for _ in 0..ROUNDS {
            self.join_islands();
            if is_layout {
                self.unflip();
            }
            if self.flipped.is_empty() {
                return (self.values, 0);
            }
            let other = |&face: &FaceId| Some((face, self.cuts.other_homes(face, &self.homes).next()?));
            let turned: Vec<Home> = self.flipped.iter().filter_map(other).collect();
            if best.as_ref().is_none_or(|b| self.flipped.len() < b.flipped.len()) {
                best = Some(self.clone());
            }
            if turned.is_empty() {
                break;
            }
            self.rehome(&turned);
        }
        let mut best = best.unwrap_or(self);
        best.try_homes();
        best.ease();
        best.cut_off();
        (best.values, best.flipped.len())
    }

    /// Tries the sides of all neighbours for each of a few faces that lie the wrong way round.
    fn try_homes(&mut self) {
        for face in self.flipped.iter().copied().take(MAX_TRIED).collect::<Vec<_>>() {
            for home in self.cuts.other_homes(face, &self.homes) {
                let mut tried = self.clone();
                tried.rehome(&[(face, home)]);
                tried.unflip();
                if tried.flipped.len() < self.flipped.len() {
                    *self = tried;
                    break;
                }
            }
        }
    }

    /// Moves values of faces that lie the wrong way round, where that turns more faces the right way than the wrong: one to
    /// the middle of those around it, or some to where their face's own side goes on.
    fn ease(&mut self) {
        for _ in 0..ROUNDS {
            for face in self.flipped.clone() {
                let corners = self.sites.net.topology.faces.corners_of(face);
                let moves: Vec<Move<T>> = corners.clone().filter_map(|c| self.continued(c)).collect();
                let is_better = corners.clone().any(|c| self.try_moves(&[self.to_middle(c)]))
                    || moves.iter().any(|m| self.try_moves(std::slice::from_ref(m)));
                if !is_better {
                    self.try_moves(&moves);
                }
            }
        }
    }

    /// The corners of a vertex that have a corner's value.
    fn sharing(&self, corner: CornerId) -> Vec<CornerId> {
        let t = &self.sites.net.topology;
        let around = t.vertex_corners.row(t.faces.vertex(corner)).iter().copied();
        around.filter(|&c| self.field.same(&self.values, c, corner)).collect()
    }

    fn to_middle(&self, corner: CornerId) -> Move<T> {
        let faces = &self.sites.net.topology.faces;
        let corners = self.sharing(corner);
        let ring = corners.iter().flat_map(|&c| [faces.next(c), faces.prev(c)]);
        let at = |c: CornerId| [0, 1].map(|k| self.values[2 * c.index() + k].to_f64());
        let sum = ring.map(at).fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
        Move { value: sum.map(|x| T::from_f64(x / (2 * corners.len()) as f64)), corners }
    }

    fn continued(&self, corner: CornerId) -> Option<Move<T>> {
        let home = self.homes[self.sites.net.topology.faces.face_of(corner).index()]?;
        let inside = Location { face: home, weights: Vec3::splat(1.0 / 3.0) };
        let mut value = [T::from_f64(0.0); 2];
        self.field
            .value_at(&self.cuts.continued(corner, Source { location: inside, moved: true }).location, &mut value);
        Some(Move { value, corners: self.sharing(corner) })
    }

    /// Makes moves, unless no fewer faces lie the wrong way round than before. Returns whether they are made.
    fn try_moves(&mut self, moves: &[Move<T>]) -> bool {
        let face = |c: &CornerId| self.sites.net.topology.faces.face_of(*c);
        let faces: BTreeSet<FaceId> = moves.iter().flat_map(|m| &m.corners).map(face).collect();
        let flipped = |sides: &Self| faces.iter().filter(|&&f| sides.is_flipped(f)).count();
        let worse = flipped(self);
        let corners = || moves.iter().flat_map(|m| m.corners.iter().map(|c| (2 * c.index(), m.value)));
        let before: Vec<[T; 2]> = corners().map(|(at, _)| [self.values[at], self.values[at + 1]]).collect();
        corners().for_each(|(at, value)| self.values[at..][..2].copy_from_slice(&value));
        if flipped(self) >= worse {
            // Backwards, so that a corner that was moved twice is where it was.
            let places: Vec<usize> = corners().map(|(at, _)| at).collect();
            places.iter().zip(&before).rev().for_each(|(&at, own)| self.values[at..][..2].copy_from_slice(own));
            return false;
        }
        for face in faces {
            match self.is_flipped(face) {
                true => self.flipped.insert(face),
                false => self.flipped.remove(&face),
            };
        }
        true
    }

    /// Gives each face that lies the wrong way round values of its own, apart from its neighbours'.
    fn cut_off(&mut self) {
        for &face in &self.flipped {
            for corner in self.sites.net.topology.faces.corners_of(face) {
                if let Some(Move { value, .. }) = self.continued(corner) {
                    self.values[2 * corner.index()..][..2].copy_from_slice(&value);
                }
            }
        }
    }

    /// Gives small parts of a side to their neighbours.
    fn join_islands(&mut self) {
        let mut seeds = self.stale.clone();
        for _ in 0..ROUNDS {
            let islands = self.cuts.islands(&seeds, &self.homes, |a, b| self.field.same(&self.values, a, b));
            if islands.is_empty() {
                break;
            }
            seeds = self.rehome(&islands);
        }
    }

    /// Gives faces other homes. Returns the faces near the cuts whose values may have changed.
    fn rehome(&mut self, faces: &[Home]) -> Vec<FaceId> {
        faces.iter().for_each(|&(face, home)| self.homes[face.index()] = Some(home));
        let width = self.field.width();
        let corners = self.cuts.renew(faces, &self.homes, &mut self.sources);
        for &corner in &corners {
            let value = &mut self.values[corner.index() * width..][..width];
            self.field.value_at(&self.sources[corner].location, value);
        }
        let face = |c: &CornerId| self.sites.net.topology.faces.face_of(*c);
        let changed: BTreeSet<FaceId> = corners.iter().map(face).filter(|f| self.homes[f.index()].is_some()).collect();
        self.stale.extend(&changed);
        changed.into_iter().collect()
    }

    /// Continues the values beyond the cuts where keeping them inside turns a triangle over. Afterwards those that stay so
    /// are known.
    fn unflip(&mut self) {
        let stale = std::mem::take(&mut self.stale);
        let (turned, upright): (Vec<FaceId>, Vec<FaceId>) = stale.into_par_iter().partition(|&f| self.is_flipped(f));
        upright.iter().for_each(|f| {
            self.flipped.remove(f);
        });
        self.flipped.extend(&turned);
        let mut round = self.flipped.clone();
        for _ in 0..ROUNDS {
            let mut next = BTreeSet::new();
            while let Some(face) = round.pop_first() {
                if !self.is_flipped(face) {
                    self.flipped.remove(&face);
                    continue;
                }
                self.flipped.insert(face);
                for other in self.continue_corners(face) {
                    (if other > face { &mut round } else { &mut next }).insert(other);
                }
            }
            round = next;
        }
        for face in round {
            match self.is_flipped(face) {
                true => self.flipped.insert(face),
                false => self.flipped.remove(&face),
            };
        }
    }

    /// Continues the values of a face's corners that were moved. Returns the faces near the cuts that have them too.
    fn continue_corners(&mut self, face: FaceId) -> BTreeSet<FaceId> {
        let mut changed = BTreeSet::new();
        for corner in self.sites.net.topology.faces.corners_of(face) {
            if self.sources[corner].moved {
                self.go_on(corner, &mut changed);
            }
        }
        changed
    }

    /// Continues the value of a corner, and of those that share it, beyond their side to where the vertex is.
    fn go_on(&mut self, corner: CornerId, changed: &mut BTreeSet<FaceId>) {
        let before = [0, 1].map(|k| self.values[2 * corner.index() + k]);
        let source = Source { moved: false, ..self.cuts.continued(corner, self.sources[corner]) };
        let mut value = before;
        self.field.value_at(&source.location, &mut value);
        let t = &self.sites.net.topology;
        for &other in t.vertex_corners.row(t.faces.vertex(corner)) {
            let own = &mut self.values[2 * other.index()..][..2];
            if self.field.same_values(own, &before) {
                own.copy_from_slice(&value);
                self.sources[other] = source;
                changed.extend(Some(t.faces.face_of(other)).filter(|f| self.homes[f.index()].is_some()));
            }
        }
    }

    /// Whether a triangle has too little area in UV for what it has in space, or lies the other way round than its home.
    /// Not where the layout itself folds over.
    fn is_flipped(&self, face: FaceId) -> bool {
        let product = self.sites.product;
        let corners = [0, 1, 2].map(|k| CornerId::new(3 * face.index() + k));
        let home = self.homes[face.index()].unwrap_or(product.places[corners[0]].location.face);
        let of_home = self.field.doubled_area(home);
        let own = doubled_area(corners.map(|c| &self.values[2 * c.index()..][..2]));
        let [a, b, c] = product.triangles[face.index()].map(|v| product.points[v]);
        let in_space = f64::from((b - a).cross(c - a).length()) / f64::from(product.baseline.normal(home).length());
        let is_turned = in_space.is_finite() && own * of_home.signum() <= MIN_AREA * of_home.abs() * in_space;
        let folds = |c: CornerId| self.field.doubled_area(self.sources[c].location.face) * of_home <= 0.0;
        is_turned && !corners.into_iter().any(folds)
    }
}
