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
