//! Elements by their numbers, with a checksum of the mesh that has them.

use super::Fault;
use super::elements::ElementSet;
use super::evaluate::{Arguments, Evaluation};
use crate::mesh::{EdgeId, FaceId, Faces, Topology, VertexId};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

type Found = Result<ElementSet, Fault>;

/// A checksum of the faces of a mesh: another mesh has another one, so that numbers are not taken for those of other
/// elements. FNV-1a, 32 bits.
pub fn checksum(faces: &Faces) -> String {
    let mut hash = 0x811c_9dc5_u32;
    let mut take = |number: usize| {
        (number as u32)
            .to_le_bytes()
            .iter()
            .for_each(|&byte| hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    };
    for face in faces.ids() {
        take(faces.valence(face));
        faces.vertices_of(face).iter().for_each(|v| take(v.index()));
    }
    format!("{hash:08x}")
}

/// The expression of some elements by their numbers.
pub fn expression(t: &Topology, set: &ElementSet) -> String {
    let (name, numbers) = match set {
        ElementSet::Edges(edges) => ("pickedEdges", edge_numbers(edges)),
        ElementSet::Faces(faces) => ("pickedFaces", ranges(faces.iter().map(|face| face.index()))),
        ElementSet::Points(points) => ("pickedPoints", ranges(points.iter().map(|point| point.index()))),
    };
    format!("{name}(\"{}\", \"{numbers}\")", checksum(&t.faces))
}

/// Numbers in ascending order, as ranges.
fn ranges(numbers: impl Iterator<Item = usize>) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some([_, end]) if *end + 1 == number => *end = number,
            _ => runs.push([number, number]),
        }
    }
    let texts = runs.iter().map(|[a, b]| if a == b { a.to_string() } else { format!("{a}-{b}") });
    texts.collect::<Vec<_>>().join(", ")
}

/// Edges as runs of points, each edge in its direction.
fn edge_numbers(edges: &BTreeMap<EdgeId, [VertexId; 2]>) -> String {
    let mut after: BTreeMap<VertexId, Vec<EdgeId>> = BTreeMap::new();
    let mut before: BTreeMap<VertexId, usize> = BTreeMap::new();
    for (&edge, [a, b]) in edges {
        after.entry(*a).or_default().push(edge);
        *before.entry(*b).or_default() += 1;
    }
    let is_start = |edge: &EdgeId| before.get(&edges[edge][0]) != Some(&1) || after[&edges[edge][0]].len() != 1;
    let starts = edges.keys().filter(|edge| is_start(edge));
    let mut is_written: BTreeSet<EdgeId> = BTreeSet::new();
    let mut text = String::new();
    for &start in starts.chain(edges.keys()) {
        let mut next = Some(start).filter(|edge| !is_written.contains(edge));
        if next.is_some() {
            let comma = if text.is_empty() { "" } else { ", " };
            let _ = write!(text, "{comma}{}", edges[&start][0].index());
        }
        while let Some(edge) = next {
            is_written.insert(edge);
            let end = edges[&edge][1];
            let _ = write!(text, "-{}", end.index());
            let leaving = after.get(&end).map(Vec::as_slice).unwrap_or_default();
            next = leaving.iter().copied().find(|edge| !is_written.contains(edge)).filter(|_| leaving.len() == 1);
        }
    }
    text
}

/// The runs of numbers of a pick, of the mesh as it is.
fn numbers(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Result<Vec<Vec<usize>>, Fault> {
    let (picked, own) = (arguments.name(0)?, checksum(&of.sets.topology.faces));
    if picked != own {
        let text = format!(
            "the elements were picked on a mesh with the checksum {picked}, and {} has {own}",
            of.sets.garment.prim
        );
        return Err(Fault::new(text, "pick them again, or name them by a set that holds for both meshes"));
    }
    let text = arguments.name(1)?;
    let run = |run: &str| run.split('-').map(|number| number.trim().parse().ok()).collect::<Option<Vec<usize>>>();
    let runs = text.split(',').filter(|run| !run.trim().is_empty()).map(run).collect::<Option<Vec<_>>>();
    runs.ok_or_else(|| {
        Fault::new(format!("\"{text}\" are not numbers of elements"), "write numbers such as \"4-6, 9\"")
    })
}

pub fn edges(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let mut found = BTreeMap::new();
    for run in numbers(of, arguments)? {
        for ends in run.windows(2) {
            let is_known = ends.iter().all(|&number| number < t.vertex_count());
            let edge = is_known.then(|| [ends[0], ends[1]].map(VertexId::new));
            match edge.and_then(|[a, b]| Some((t.find_edge(a, b)?, [a, b]))) {
                Some((edge, ends)) => drop(found.insert(edge, ends)),
                None => return Err(missing(of, &format!("edge {}-{}", ends[0], ends[1]))),
            }
        }
    }
    Ok(ElementSet::Edges(found))
}

pub fn faces(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let found = elements(of, arguments, of.sets.topology.faces.len(), "face")?;
    Ok(ElementSet::Faces(found.into_iter().map(FaceId::new).collect()))
}

pub fn points(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let found = elements(of, arguments, of.sets.topology.vertex_count(), "point")?;
    Ok(ElementSet::Points(found.into_iter().map(VertexId::new).collect()))
}

/// The elements of ranges of numbers below `count`.
fn elements(
    of: &Evaluation<'_>,
    arguments: &Arguments<'_>,
    count: usize,
    kind: &str,
) -> Result<BTreeSet<usize>, Fault> {
    let mut found = BTreeSet::new();
    for run in numbers(of, arguments)? {
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else { continue };
        if last >= count {
            return Err(missing(of, &format!("{kind} {last}")));
        }
        found.extend(first..=last);
    }
    Ok(found)
}

fn missing(of: &Evaluation<'_>, element: &str) -> Fault {
    Fault::new(format!("{} has no {element}", of.sets.garment.prim), "pick the elements again")
}
