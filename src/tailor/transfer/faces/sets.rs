//! Face subsets: each face belongs to the set that covers most of it.

use super::teeth::join_teeth;
use crate::transfer::correspondence::Correspondence;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec};
use tailor_mesh::garment::{Elements, Family, FamilyType, Mesh, Subset};

/// Face subsets on the simulation mesh.
pub(in crate::transfer) struct FaceSets {
    /// The faces of each of the garment's subsets, ascending; empty for subsets of edges or points.
    pub sets: Vec<Vec<FaceId>>,
    /// The subsets of faces by their indices, in groups of sets that do not overlap.
    pub groups: Vec<Vec<usize>>,
    /// Number of isolated faces that were moved to a neighbour's set.
    pub islands: usize,
}

/// For each face the set that it is in; none outside of all.
pub(super) type Labels = IdVec<FaceId, Option<u32>>;

/// The face subsets of a garment on the simulation mesh, without isolated faces if `clean`.
///
/// The sets of a family that may not overlap compete for each face, so that a partition stays one. Other sets are
/// independent.
pub(in crate::transfer) fn carry_sets(garment: &Mesh, map: &Correspondence<'_>, clean: bool) -> FaceSets {
    let is_exclusive = |f: &&Family| f.kind != FamilyType::Unrestricted && !f.name.is_empty();
    let exclusive: Vec<_> = garment.families.iter().filter(is_exclusive).collect();
    let is_alone = |subset: &Subset| exclusive.iter().all(|f| f.name != subset.family);
    let carry = |subset: &Subset| match &subset.elements {
        Elements::Faces(source) if is_alone(subset) => independent_set(source, map, clean),
        _ => (Vec::new(), 0),
    };
    let (mut sets, islands): (Vec<_>, Vec<usize>) = garment.subsets.par_iter().map(carry).unzip();
    let mut islands = islands.iter().sum();
    let alone = garment.subsets.iter().enumerate().filter(|(_, subset)| is_alone(subset));
    let mut groups: Vec<Vec<usize>> = alone.map(|(i, _)| vec![i]).collect();
    for family in exclusive {
        let members = garment.subsets.iter().enumerate().filter_map(|(i, s)| match &s.elements {
            Elements::Faces(faces) if s.family == family.name => Some((i, faces.as_slice())),
            _ => None,
        });
        let (members, sources): (Vec<usize>, Vec<&[FaceId]>) = members.unzip();
        let mut labels = LabelledSource::new(&sources, map).without_teeth();
        islands += if clean { clean_islands(&mut labels, map) } else { 0 };
        members.iter().for_each(|&i| sets[i] = Vec::new());
        for (face, label) in labels.enumerated() {
            label.iter().for_each(|&l| sets[members[l as usize]].push(face));
        }
        groups.push(members);
    }
    FaceSets { sets, groups, islands }
}

/// The faces of which a set covers the most, without teeth, and the number of isolated ones among them that were moved.
fn independent_set(source: &[FaceId], map: &Correspondence<'_>, clean: bool) -> (Vec<FaceId>, usize) {
    let coverage = map.coverage;
    let mut is_in = IdVec::<FaceId, bool>::filled(false, coverage.faces.rows());
    source.iter().for_each(|&f| is_in[f] = true);
    let own: f64 = source.iter().map(|&f| coverage.source_area[f]).sum();
    let is_larger = || 2.0 * own >= coverage.source_area.iter().sum::<f64>();
    // The areas inside and outside of the set.
    let areas = |face: FaceId| {
        let mut areas = [0.0; 2];
        coverage.sources.row(face).iter().for_each(|covered| areas[usize::from(!is_in[covered.face])] += covered.area);
        areas
    };
    let is_covered = |face: &FaceId| {
        let [inside, outside] = areas(*face);
        inside > outside || inside == outside && is_larger()
    };
    let mut touched: Vec<FaceId> = source.iter().flat_map(|&f| coverage.faces.row(f)).map(|c| c.face).collect();
    touched.sort_unstable();
    touched.dedup();
    let mut labels = Labels::filled(None, map.mesh.topology.faces.len());
    let unsampled = map.unsampled.iter().filter(|(_, source)| is_in[*source]).map(|(face, _)| *face);
    touched.iter().copied().filter(is_covered).chain(unsampled).for_each(|face| labels[face] = Some(0));
    let share = |face: FaceId, label: Option<u32>| {
        let [inside, outside] = areas(face);
        (if label.is_some() { inside } else { outside }) / (inside + outside)
    };
    join_teeth(&mut labels, map, &touched, share);
    let islands = if clean { clean_islands(&mut labels, map) } else { 0 };
    (labels.enumerated().filter(|(_, l)| l.is_some()).map(|(f, _)| f).collect(), islands)
}

/// Moves each isolated face to the set across its longest edge that is on no chain. An isolated face touches no other
/// of its set, which has more faces. Returns their number.
fn clean_islands(labels: &mut Labels, map: &Correspondence<'_>) -> usize {
    let (mesh, faces) = (map.mesh, &map.mesh.topology.faces);
    let mut members: FxHashMap<Option<u32>, usize> = FxHashMap::default();
    labels.iter().for_each(|&l| *members.entry(l).or_default() += 1);
    let longer = |a: (CornerId, FaceId), b: (CornerId, FaceId)| {
        if map.length_squared(b.0) > map.length_squared(a.0) { b } else { a }
    };
    let is_isolated = |face: FaceId| {
        let mut around = faces.corners_of(face).filter_map(|c| mesh.twin[c]).map(|twin| faces.face_of(twin));
        members[&labels[face]] > 1 && around.all(|other| labels[other] != labels[face])
    };
    let moved = |face| mesh.open_neighbours(face).reduce(longer).map(|(_, other)| (face, labels[other]));
    let moved: Vec<(FaceId, Option<u32>)> = faces.ids().filter(|&f| is_isolated(f)).filter_map(moved).collect();
    moved.iter().for_each(|&(face, label)| labels[face] = label);
    moved.len()
}

/// Sets of the garment's faces that do not overlap.
struct LabelledSource<'a> {
    map: &'a Correspondence<'a>,
    labels: Labels,
    /// Area of each set. \[square mesh units\]
    area: Vec<f64>,
    /// Area outside of all sets. \[square mesh units\]
    unlabelled_area: f64,
}

impl<'a> LabelledSource<'a> {
    fn new(sets: &[&[FaceId]], map: &'a Correspondence<'a>) -> Self {
        let areas = &map.coverage.source_area;
        let mut labels = Labels::filled(None, areas.len());
        for (label, set) in sets.iter().enumerate() {
            set.iter().for_each(|&f| labels[f] = Some(label as u32));
        }
        let area = sets.iter().map(|set| set.iter().map(|&f| areas[f]).sum()).collect();
        let unlabelled_area = labels.iter().zip(areas.iter()).filter(|(l, _)| l.is_none()).map(|(_, area)| area).sum();
        Self { map, labels, area, unlabelled_area }
    }

    /// The area of a face of the simulation mesh in each set that covers a part of it.
    fn areas(&self, face: FaceId) -> Vec<(Option<u32>, f32)> {
        let mut areas: Vec<(Option<u32>, f32)> = Vec::with_capacity(4);
        for covered in self.map.coverage.sources.row(face) {
            let label = self.labels[covered.face];
            match areas.iter_mut().find(|a| a.0 == label) {
                Some(sum) => sum.1 += covered.area,
                None => areas.push((label, covered.area)),
            }
        }
        areas
    }

    /// The labels of [`LabelledSource::of_faces`], without teeth.
    fn without_teeth(&self) -> Labels {
        let mut labels = self.of_faces();
        let faces: Vec<FaceId> = labels.ids().collect();
        let share = |face: FaceId, label: Option<u32>| {
            let areas = self.areas(face);
            let of_label = areas.iter().find(|area| area.0 == label).map_or(0.0, |area| area.1);
            of_label / areas.iter().map(|area| area.1).sum::<f32>()
        };
        join_teeth(&mut labels, self.map, &faces, share);
        labels
    }

    /// The label that covers most of each face of the simulation mesh; of equals, that of the larger set.
    fn of_faces(&self) -> Labels {
        let sources = &self.map.coverage.sources;
        let label = |face: usize| {
            let most = |a: &(Option<u32>, f32), b: &(Option<u32>, f32)| {
                b.1.total_cmp(&a.1).then_with(|| self.area_of(b.0).total_cmp(&self.area_of(a.0))).then(a.0.cmp(&b.0))
            };
            self.areas(FaceId::new(face)).into_iter().min_by(most).and_then(|a| a.0)
        };
        let mut labels = Labels::from((0..sources.rows()).into_par_iter().map(label).collect::<Vec<_>>());
        self.map.unsampled.iter().for_each(|&(face, source)| labels[face] = self.labels[source]);
        labels
    }

    fn area_of(&self, label: Option<u32>) -> f64 {
        label.map_or(self.unlabelled_area, |l| self.area[l as usize])
    }
}
