//! Values of corners near the cuts of a channel: shells are reassigned until no triangle is isolated or flipped.

use super::cuts::{ChannelCuts, Seeded, ShellSeeds};
use super::field::FaceVaryingField;
use super::sources::CornerSource;
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::subdivide::Real;
use std::collections::BTreeSet;

/// Rounds of each repair.
pub(super) const ROUNDS: usize = 3;
/// Flipped triangles for which all other shells are tried: a trial takes time in proportion to the mesh.
const MAX_TRIED: usize = 16;

/// The shell of each triangle and the value of each corner.
#[derive(Clone)]
pub(super) struct ShellValues<'a, T> {
    pub field: &'a FaceVaryingField<'a, T>,
    pub cuts: &'a ChannelCuts<'a>,
    pub seeds: ShellSeeds,
    pub sources: IdVec<CornerId, CornerSource>,
    pub values: Vec<T>,
    /// Triangles near the cuts whose values may have changed since their last check.
    pub stale: Vec<FaceId>,
    /// Flipped triangles.
    pub flipped: BTreeSet<FaceId>,
}

impl<'a, T: Real> ShellValues<'a, T> {
    pub fn new(field: &'a FaceVaryingField<'a, T>, cuts: &'a ChannelCuts<'a>) -> Self {
        let seeds = cuts.seeds();
        let stale: Vec<FaceId> = seeds.enumerated().filter(|(_, seed)| seed.is_some()).map(|(face, _)| face).collect();
        let places = cuts.map.product.places.iter();
        let mut sources = places.map(|p| CornerSource { location: p.location, moved: false }).collect();
        cuts.update_sources(stale.iter().copied(), &seeds, &mut sources);
        let values = field.at_locations(sources.len(), |c| sources[c].location);
        Self { field, cuts, seeds, sources, values, stale, flipped: BTreeSet::new() }
    }

    /// The value of each corner, and the number of triangles that are cut off because they would be flipped in any
    /// shell.
    pub fn resolved(mut self) -> (Vec<T>, usize) {
        let mut best: Option<Self> = None;
        for _ in 0..ROUNDS {
            self.join_islands();
            if self.field.is_layout() {
                self.unflip();
            }
            if self.flipped.is_empty() {
                return (self.values, 0);
            }
            let other = |&face: &FaceId| Some((face, *self.cuts.other_seeds(face, &self.seeds).first()?));
            let reassigned: Vec<Seeded> = self.flipped.iter().filter_map(other).collect();
            if best.as_ref().is_none_or(|b| self.flipped.len() < b.flipped.len()) {
                best = Some(self.clone());
            }
            if reassigned.is_empty() {
                break;
            }
            self.reassign(&reassigned);
        }
        let mut best = best.unwrap_or(self);
        best.try_other_shells();
        best.relax_flipped();
        best.cut_off_flipped();
        (best.values, best.flipped.len())
    }

    /// Gives small isolated parts of a shell to the shells around them.
    fn join_islands(&mut self) {
        let mut faces = self.stale.clone();
        for _ in 0..ROUNDS {
            let islands = self.cuts.islands(&faces, &self.seeds, |a, b| self.field.same(&self.values, a, b));
            if islands.is_empty() {
                break;
            }
            faces = self.reassign(&islands);
        }
    }

    /// Gives triangles other shells. Returns the triangles near the cuts whose values may have changed.
    fn reassign(&mut self, faces: &[Seeded]) -> Vec<FaceId> {
        faces.iter().for_each(|&(face, seed)| self.seeds[face] = Some(seed));
        let width = self.field.width();
        let corners = self.cuts.update_sources(faces.iter().map(|f| f.0), &self.seeds, &mut self.sources);
        for &corner in &corners {
            let value = &mut self.values[corner.index() * width..][..width];
            self.field.value_at(&self.sources[corner].location, value);
        }
        let changed: BTreeSet<FaceId> = self.faces_of(&corners).filter(|&f| self.seeds[f].is_some()).collect();
        self.stale.extend(&changed);
        changed.into_iter().collect()
    }

    /// Tries the shells of all neighbours for each of a few flipped triangles.
    fn try_other_shells(&mut self) {
        for face in self.flipped.iter().copied().take(MAX_TRIED).collect::<Vec<_>>() {
            for seed in self.cuts.other_seeds(face, &self.seeds) {
                let mut tried = self.clone();
                tried.reassign(&[(face, seed)]);
                tried.unflip();
                if tried.flipped.len() < self.flipped.len() {
                    *self = tried;
                    break;
                }
            }
        }
    }

    /// The triangles of corners.
    pub fn faces_of(&self, corners: &[CornerId]) -> impl Iterator<Item = FaceId> {
        corners.iter().map(|&c| self.cuts.map.mesh.topology.faces.face_of(c))
    }
}
