//! The face-varying channels of a cage's primvars. They depend on its connectivity and on which corners share a value
//! alone, so that cages with other values may have them in common.

use super::carry::{is_channel, mixed_channel};
use super::connectivity::{Fingerprint, Hasher};
use super::fvar::ChildValues;
use super::{Cage, Channel, ChannelChild, Level};
use crate::garment::{Garment, Primvar};
use rayon::prelude::*;
use std::sync::Arc;

/// The channels of a level's primvars, in their order, and which values their refinements have.
pub struct Channels(Vec<Option<PrimvarChannel>>);

/// The channel of a face-varying primvar.
struct PrimvarChannel {
    channel: Channel,
    /// The row of each value, where they are not the primvar's rows in their order.
    rows: Option<Vec<u32>>,
    children: Arc<ChildValues>,
    /// The number of the value of each child corner.
    indices: Arc<Vec<u32>>,
}

impl Channels {
    /// The channels of a cage that is not refined.
    pub fn new(cage: &Cage) -> Self {
        let (garment, level) = (cage.garment(), cage.level());
        let channel = |primvar: &Primvar| {
            let rows = primvar.corner_rows(&garment.faces, garment.points.len());
            let rules = garment.rules;
            let (channel, rows) = Channel::base(level, |c| rows[c] as usize, rules.face_varying, rules.boundary);
            PrimvarChannel::new(level, channel, Some(rows))
        };
        Self(garment.primvars.par_iter().map(|primvar| is_channel(primvar).then(|| channel(primvar))).collect())
    }

    /// The channels of a level's refinement.
    pub fn refined(&self, level: &Level, refined: &Level) -> Self {
        // Values of a refined channel are in the order of the primvar's rows.
        let channel = |c: &PrimvarChannel| PrimvarChannel::new(refined, c.child(level).into_channel(refined), None);
        Self(self.0.par_iter().map(|c| c.as_ref().map(channel)).collect())
    }

    /// The fingerprint of all that the channels of a garment depend on beside its level.
    pub fn fingerprint(garment: &Garment) -> Fingerprint {
        let mut hasher = Hasher::default();
        hasher.add(garment.rules.face_varying);
        for primvar in garment.primvars.iter() {
            hasher.add(is_channel(primvar));
            if is_channel(primvar) {
                hasher.add_all(primvar.corner_rows(&garment.faces, garment.points.len()).as_slice());
            }
        }
        hasher.finish()
    }

    /// A primvar that has a channel, on the refinement of the channels' level; others as they are.
    pub(super) fn refined_primvar(&self, level: &Level, place: usize, primvar: &Primvar) -> Primvar {
        match &self.0[place] {
            Some(c) => mixed_channel(&c.child(level), Arc::clone(&c.indices), c.rows.as_deref(), primvar),
            None => primvar.clone(),
        }
    }

    /// An estimate of the memory that they hold. \[bytes\]
    pub fn bytes(&self) -> usize {
        self.0.iter().flatten().map(PrimvarChannel::bytes).sum()
    }
}

impl PrimvarChannel {
    fn new(level: &Level, channel: Channel, rows: Option<Vec<u32>>) -> Self {
        let children = Arc::new(ChildValues::new(&channel, level));
        let indices = ChannelChild::of(level, &channel, Arc::clone(&children)).indices();
        Self { channel, rows, children, indices: Arc::new(indices) }
    }

    fn child<'a>(&'a self, level: &'a Level) -> ChannelChild<'a> {
        ChannelChild::of(level, &self.channel, Arc::clone(&self.children))
    }

    fn bytes(&self) -> usize {
        let rows = self.rows.as_ref().map_or(0, |rows| size_of_val(rows.as_slice()));
        self.channel.bytes() + self.children.bytes() + rows + size_of_val(self.indices.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{FaceVaryingInterpolation, Values};
    use crate::mesh::{Faces, IdVec, VertexId};
    use glam::Vec3;

    /// Two quads side by side, with a value for each corner.
    fn garment(indices: Option<Vec<u32>>, values: Vec<f32>) -> Garment {
        Garment {
            points: IdVec::filled(Vec3::ZERO, 6),
            faces: Faces::quads([0, 1, 4, 3, 1, 2, 5, 4].map(VertexId::new).to_vec()),
            primvars: vec![Primvar::of_corners(values, indices)].into(),
            ..Garment::default()
        }
    }

    #[test]
    fn a_fingerprint_is_that_of_which_corners_share_a_value() {
        let joined = || Some(vec![0, 1, 2, 3, 1, 4, 5, 2]);
        let first = Channels::fingerprint(&garment(joined(), vec![0.0; 6]));
        assert_eq!(first, Channels::fingerprint(&garment(joined(), (0..6).map(|i| i as f32).collect())), "values");
        let mut linear = garment(joined(), vec![0.0; 6]);
        linear.rules.face_varying = FaceVaryingInterpolation::All;
        let mut without = garment(joined(), vec![0.0; 6]);
        without.primvars = Vec::new().into();
        let apart = garment(Some((0..8).collect()), vec![0.0; 8]);
        let flat = garment(None, (0..8).map(|i| i as f32).collect());
        assert_eq!(Channels::fingerprint(&apart), Channels::fingerprint(&flat), "where no corners share a value");
        let joined_flat = garment(None, vec![0.0, 1.0, 2.0, 3.0, 1.0, 4.0, 5.0, 2.0]);
        let mut known = [&linear, &without, &apart, &joined_flat].map(Channels::fingerprint).to_vec();
        known.push(first);
        known.sort_unstable();
        known.dedup();
        assert_eq!(known.len(), 5);
    }

    #[test]
    fn a_primvar_takes_what_is_shared_and_its_own_values() {
        let indices = || Some(vec![0, 1, 2, 3, 6, 4, 5, 7]);
        let cages = [1.0, 2.0].map(|scale| Cage::new(garment(indices(), (0..8).map(|i| scale * i as f32).collect())));
        let channels = Channels::new(&cages[0]);
        let refined = |cage: &Cage, channels: &Channels| {
            let refinement = cage.refinement(cage.level().refined_faces(), channels);
            refinement.garment(refinement.subsets())
        };
        let [own, other] = cages.each_ref().map(|cage| refined(cage, &channels).primvars[0].clone());
        assert!(Arc::ptr_eq(own.indices.as_ref().expect("indices"), other.indices.as_ref().expect("indices")));
        let of = |primvar: &Primvar| match &primvar.values {
            Values::F32(values) => values.iter().map(|value| 2.0 * value).collect::<Vec<_>>(),
            _ => Vec::new(),
        };
        assert_eq!(Values::F32(of(&own)), other.values);
        let afresh = Channels::new(&cages[1]);
        assert_eq!(refined(&cages[1], &afresh).primvars[0], other);
    }
}
