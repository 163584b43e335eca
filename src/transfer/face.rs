//! What faces carry: sets by majority, colours and numbers by mean, from the areas that faces have in common.

use super::Sites;
use super::coverage::{Coverage, Share};
use crate::garment::{Elements, FamilyType, Garment, Primvar, Subset, Values};
use crate::mesh::{CornerId, FaceId, IdVec};
use crate::subdivide::{Real, mix_into, scale_to_unit_length};
use rayon::prelude::*;
use std::sync::Arc;

/// The face subsets of a garment on the simulation mesh, by their place in the garment's list.
///
/// The sets of a family that do not overlap compete for each face, so that a partition stays one; all others are
/// counted each by itself.
pub(super) fn sets(garment: &Garment, coverage: &Coverage, sites: &Sites<'_>, clean: bool) -> FaceSets {
    let faces_of = |s: &Subset| match &s.elements {
        Elements::Faces(faces) => Some(faces.clone()),
        _ => None,
    };
    let sources: Vec<Option<Vec<FaceId>>> = garment.subsets.iter().map(faces_of).collect();
    let exclusive = |s: &Subset| {
        garment.families.iter().any(|f| f.name == s.family && f.kind != FamilyType::Unrestricted)
            && !s.family.is_empty()
    };
    let alone = |i: usize| match &sources[i] {
        Some(faces) if !exclusive(&garment.subsets[i]) => Some(alone(faces, coverage, sites)),
        _ => None,
    };
    let mut found: Vec<Option<Vec<FaceId>>> = (0..sources.len()).into_par_iter().map(alone).collect();
    let mut islands = 0;
    for set in found.iter_mut().flatten().filter(|_| clean) {
        let mut labels = IdVec::filled(None, sites.net.topology.faces.len());
        set.iter().for_each(|&f| labels[f] = Some(0));
        islands += clean_islands(&mut labels, sites);
        *set = labels.enumerated().filter(|(_, l)| l.is_some()).map(|(f, _)| f).collect();
    }
    for family in garment.families.iter().filter(|f| f.kind != FamilyType::Unrestricted && !f.name.is_empty()) {
        let members: Vec<usize> =
            (0..sources.len()).filter(|&i| garment.subsets[i].family == family.name && sources[i].is_some()).collect();
        let labels = Labels::new(members.iter().filter_map(|&i| sources[i].as_deref()), coverage);
        let mut of_faces = labels.of_faces(coverage, sites);
        islands += if clean { clean_islands(&mut of_faces, sites) } else { 0 };
        members.iter().for_each(|&i| found[i] = Some(Vec::new()));
        for (face, label) in of_faces.enumerated() {
            if let Some(set) = label.and_then(|l| found[members[l as usize]].as_mut()) {
                set.push(face);
            }
        }
    }
    FaceSets { sets: found, islands }
}

/// Face subsets on the simulation mesh.
pub(super) struct FaceSets {
    /// The faces of each of the garment's subsets; none of those that are of edges or points.
    pub sets: Vec<Option<Vec<FaceId>>>,
    /// Faces that were given to a neighbour's set.
    pub islands: usize,
}

/// Gives each face that touches no other of its label, though there are more, the label across its longest edge that is
/// on no chain. Returns how many.
fn clean_islands(labels: &mut IdVec<FaceId, Option<u32>>, sites: &Sites<'_>) -> usize {
    let t = &sites.net.topology;
    let mut members: std::collections::HashMap<Option<u32>, usize> = std::collections::HashMap::new();
    labels.iter().for_each(|&l| *members.entry(l).or_default() += 1);
    let length = |c: CornerId| {
        let [a, b] = t.faces.half_edge(c).map(|v| sites.product.points[v]);
        a.distance_squared(b)
    };
    let wanted = |face: FaceId| {
        let around = || t.faces.corners_of(face).filter_map(|c| Some((c, t.faces.face_of(t.twin(c)?))));
        if members[&labels[face]] == 1 || around().any(|(_, other)| labels[other] == labels[face]) {
            return None;
        }
        let open = around().filter(|(c, _)| !sites.net.is_chain[t.corner_edge[*c]]);
        open.reduce(|a, b| if length(b.0) > length(a.0) { b } else { a }).map(|(_, other)| (face, labels[other]))
    };
    let cleaned: Vec<(FaceId, Option<u32>)> = t.faces.ids().filter_map(wanted).collect();
    cleaned.iter().for_each(|&(face, label)| labels[face] = label);
    cleaned.len()
}

/// The faces of which a set covers the most.
fn alone(set: &[FaceId], coverage: &Coverage, sites: &Sites<'_>) -> Vec<FaceId> {
    let mut is_in = IdVec::<FaceId, bool>::filled(false, coverage.faces.rows());
    set.iter().for_each(|&f| is_in[f] = true);
    let mut shares: Vec<Share> = set.iter().flat_map(|&f| coverage.faces.row(f)).copied().collect();
    shares.sort_by_key(|s| s.face);
    let own: f64 = set.iter().map(|&f| coverage.source_area[f]).sum();
    let is_larger = || 2.0 * own >= coverage.source_area.iter().sum::<f64>();
    let most = |group: &[Share]| {
        let face = group[0].face;
        let (mut inside, mut outside) = (0.0, 0.0);
        for share in coverage.sources.row(face) {
            *(if is_in[share.face] { &mut inside } else { &mut outside }) += share.area;
        }
        (inside > outside || inside == outside && is_larger()).then_some(face)
    };
    let mut faces: Vec<FaceId> = shares.chunk_by(|a, b| a.face == b.face).filter_map(most).collect();
    faces.extend(sites.unsampled.iter().filter(|(_, source)| is_in[*source]).map(|(face, _)| *face));
    faces.sort_unstable();
    faces
}

/// Sets of faces that do not overlap: a number for each face.
pub(super) struct Labels {
    /// The label of each face of the garment; none where it is in no set.
    of: IdVec<FaceId, Option<u32>>,
    /// Area of each label, and of what has none. \[square stage units\]
    area: Vec<f64>,
    bare: f64,
}

impl Labels {
    pub fn new<'a>(sets: impl Iterator<Item = &'a [FaceId]>, coverage: &Coverage) -> Self {
        let mut of = IdVec::filled(None, coverage.faces.rows());
        let mut area = Vec::new();
        for (label, set) in sets.enumerate() {
            set.iter().for_each(|&f| of[f] = Some(label as u32));
            area.push(set.iter().map(|&f| coverage.source_area[f]).sum());
        }
        let none = |(f, label): (FaceId, &Option<u32>)| label.is_none().then(|| coverage.source_area[f]);
        let bare = of.enumerated().filter_map(none).sum();
        Self { of, area, bare }
    }

    /// The label of each face of the simulation mesh.
    pub fn of_faces(&self, coverage: &Coverage, sites: &Sites<'_>) -> IdVec<FaceId, Option<u32>> {
        let label = |face: usize| {
            let mut counts: Vec<(Option<u32>, f32)> = Vec::with_capacity(4);
            for share in coverage.sources.row(FaceId::new(face)) {
                let label = self.of[share.face];
                match counts.iter_mut().find(|c| c.0 == label) {
                    Some(count) => count.1 += share.area,
                    None => counts.push((label, share.area)),
                }
            }
            let better = |a: &(Option<u32>, f32), b: &(Option<u32>, f32)| {
                b.1.total_cmp(&a.1).then_with(|| self.area_of(b.0).total_cmp(&self.area_of(a.0))).then(a.0.cmp(&b.0))
            };
            counts.sort_by(better);
            counts.first().map(|c| c.0)
        };
        let labels = (0..coverage.sources.rows()).into_par_iter().map(label).collect::<Vec<_>>();
        let mut labels: IdVec<FaceId, Option<u32>> = labels.into_iter().map(Option::flatten).collect();
        sites.unsampled.iter().for_each(|&(face, source)| labels[face] = self.of[source]);
        labels
    }

    fn area_of(&self, label: Option<u32>) -> f64 {
        label.map_or(self.bare, |l| self.area[l as usize])
    }
}

/// A uniform primvar on the simulation mesh: the mean of real values, the most frequent of others. What is the same all
/// over a face stays as it is, bit for bit.
pub(super) fn carry(primvar: &Primvar, coverage: &Coverage, sites: &Sites<'_>) -> Primvar {
    let shares = Shares { primvar, coverage, sites };
    let count = coverage.sources.rows();
    let row = |parts: &mut Vec<(usize, f32)>, f: usize| shares.row(FaceId::new(f), parts);
    let single: Option<Vec<usize>> = (0..count).into_par_iter().map_init(Vec::new, row).collect();
    if let Some(taken) = single {
        let taken = taken.into_iter();
        return match &primvar.indices {
            Some(_) => Primvar { indices: Some(Arc::new(taken.map(|r| r as u32).collect())), ..primvar.clone() },
            None => Primvar { values: primvar.values.gather(primvar.width(), taken), ..primvar.clone() },
        };
    }
    let values = match &primvar.values {
        Values::F32(v) => Values::F32(shares.means(v, count)),
        Values::F64(v) => Values::F64(shares.means(v, count)),
        // Only real values are mixed.
        discrete => discrete.clone(),
    };
    Primvar { values, indices: None, ..primvar.clone() }
}

struct Shares<'a> {
    primvar: &'a Primvar,
    coverage: &'a Coverage,
    sites: &'a Sites<'a>,
}

impl Shares<'_> {
    /// The row that a face takes; none where that is the mean of `parts`, which are rows with their weights.
    fn row(&self, face: FaceId, parts: &mut Vec<(usize, f32)>) -> Option<usize> {
        let primvar = self.primvar;
        let (values, width) = (&primvar.values, primvar.width());
        parts.clear();
        for share in self.coverage.sources.row(face) {
            let row = primvar.row(share.face.index());
            let same = |other: usize| other == row || values.same_rows(width, other, row);
            match parts.iter_mut().find(|r| same(r.0)) {
                Some(own) => own.1 += share.area,
                None => parts.push((row, share.area)),
            }
        }
        match parts.as_slice() {
            [] => Some(primvar.row(self.sites.source_of(face).index())),
            [(row, _)] => Some(*row),
            _ if primvar.is_mixed() => {
                let sum: f32 = parts.iter().map(|r| r.1).sum();
                parts.iter_mut().for_each(|r| r.1 /= sum);
                None
            }
            // The first of equals: rows come in the order of the garment's faces.
            _ => Some(parts.iter().fold(parts[0], |best, r| if r.1 > best.1 { *r } else { best }).0),
        }
    }

    fn means<T: Real>(&self, source: &[T], count: usize) -> Vec<T> {
        let (primvar, width) = (self.primvar, self.primvar.width().max(1));
        let of = |row: usize| &source[row * width..][..width];
        let mut means = vec![T::from_f64(0.0); count * width];
        means.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |parts, (face, mean)| {
            match self.row(FaceId::new(face), parts) {
                Some(row) => mean.copy_from_slice(of(row)),
                None => {
                    mix_into(&parts.iter().map(|&(row, weight)| (of(row), weight)), primvar, mean);
                    scale_to_unit_length(mean, primvar.components, primvar.mixing);
                }
            }
        });
        means
    }
}
