//! Values of corners near the cuts of a channel: isolated triangles join the shells around them.

use super::cuts::{ChannelCuts, Seeded, ShellSeeds};
use super::field::FaceVaryingField;
use super::sources::CornerSource;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec};
use tailor_mesh::subdivide::Real;

/// Rounds in which isolated triangles join other shells.
const ROUNDS: usize = 3;

/// The shell of each triangle and the value of each corner.
pub(super) struct ShellValues<'a, T> {
    pub field: &'a FaceVaryingField<'a, T>,
    pub cuts: &'a ChannelCuts<'a>,
    pub seeds: ShellSeeds,
    pub sources: IdVec<CornerId, CornerSource>,
    pub values: Vec<T>,
}

impl<'a, T: Real> ShellValues<'a, T> {
    pub fn new(field: &'a FaceVaryingField<'a, T>, cuts: &'a ChannelCuts<'a>) -> Self {
        let seeds = cuts.seeds();
        let places = cuts.map.product.places.iter();
        let mut sources = places.map(|p| CornerSource { location: p.location, moved: false }).collect();
        cuts.update_sources(near_cuts(&seeds), &seeds, &mut sources);
        let values = field.at_locations(sources.len(), |c| sources[c].location);
        Self { field, cuts, seeds, sources, values }
    }

    /// The value of each corner, and the triangles that are cut off from their shells, within which they would
    /// be flipped.
    pub fn resolved(mut self) -> (Vec<T>, Vec<FaceId>) {
        self.join_islands();
        if !self.field.is_layout() {
            return (self.values, Vec::new());
        }
        self.extrapolate_flipped();
        let flipped = self.flipped();
        flipped.iter().for_each(|&face| self.cut_off(face));
        (self.values, flipped)
    }

    /// Gives small isolated parts of a shell to the shells around them.
    fn join_islands(&mut self) {
        let mut faces: Vec<FaceId> = near_cuts(&self.seeds).collect();
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
        let faces = &self.cuts.map.mesh.topology.faces;
        let changed: BTreeSet<FaceId> = corners.iter().map(|&c| faces.face_of(c)).collect();
        changed.into_iter().filter(|&f| self.seeds[f].is_some()).collect()
    }
}

/// The triangles near the cuts.
pub(super) fn near_cuts(seeds: &ShellSeeds) -> impl Iterator<Item = FaceId> {
    seeds.enumerated().filter(|(_, seed)| seed.is_some()).map(|(face, _)| face)
}
