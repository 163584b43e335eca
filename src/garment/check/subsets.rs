//! Subsets of faces, edges and points, and the rules of their families.

use super::mesh::{Count, Entry, Indices, MeshCheck, Repeat, repeats};
use super::problem::Problems;
use crate::error::ErrorCode;
use crate::garment::{Elements, Family, FamilyType, Subset, SubsetInput};
use crate::mesh::{EdgeId, Id, VertexId};
use std::collections::{HashMap, HashSet};

/// A subset and the numbers of its elements: of faces, points or edges.
struct SubsetNumbers {
    subset: Subset,
    /// None where an element is at fault.
    numbers: Option<Vec<usize>>,
}

/// The subsets, in namespace order.
pub(super) fn subsets(
    inputs: Vec<SubsetInput>,
    families: &[Family],
    mesh: &MeshCheck<'_>,
    problems: &mut Problems,
) -> Vec<Subset> {
    let mut numbered = Vec::with_capacity(inputs.len());
    let mut incomplete = HashSet::new();
    for input in inputs {
        let family = input.family.clone();
        match subset(input, mesh, problems) {
            Some(subset) if subset.numbers.is_some() => numbered.push(subset),
            faulty => {
                incomplete.insert(family);
                numbered.extend(faulty);
            }
        }
    }
    for family in members(&numbered, families, &incomplete) {
        family.check(mesh, problems);
    }
    numbered.into_iter().map(|n| n.subset).collect()
}

/// One subset; none if a mesh has no such elements.
fn subset(input: SubsetInput, mesh: &MeshCheck<'_>, problems: &mut Problems) -> Option<SubsetNumbers> {
    let before = problems.count();
    let attribute = format!("{}.indices", input.name);
    let (elements, numbers) = match input.element_type.as_str() {
        "face" => {
            let (faces, numbers) = plain(&attribute, "face", mesh.faces, &input.indices, problems);
            (Elements::Faces(faces), numbers)
        }
        "point" => {
            let (points, numbers) = plain(&attribute, "point", mesh.points, &input.indices, problems);
            (Elements::Points(points), numbers)
        }
        "edge" => {
            let (edges, numbers) = edges(&attribute, &input.indices, mesh, problems);
            (Elements::Edges(edges), numbers)
        }
        other => {
            let fault = format_args!("\"{other}\" is not an element of a mesh");
            let remedy = format_args!("set elementType to face, edge or point");
            problems.add(ErrorCode::ElementList, &format!("{}.elementType", input.name), fault, remedy);
            return None;
        }
    };
    let clean = problems.count() == before && numbers.len() == elements.len();
    let subset = Subset { name: input.name, family: input.family, elements, sharpness: None };
    Some(SubsetNumbers { subset, numbers: clean.then_some(numbers) })
}

/// Faces or points, each at most once.
fn plain<I: Id>(
    attribute: &str,
    kind: &'static str,
    count: Option<usize>,
    indices: &[i32],
    problems: &mut Problems,
) -> (Vec<I>, Vec<usize>) {
    let handles = Indices { attribute, kind, count }.handles::<I, _>(indices, |i| Entry("entry", i), problems);
    let keys = handles.iter().enumerate().filter_map(|(i, h)| Some((i, (*h)?)));
    for Repeat { first, again } in repeats(keys) {
        let Some(element) = handles[again].map(I::index) else { continue };
        let fault = format_args!("entry {again} names {kind} {element} again, after entry {first}");
        problems.add(ErrorCode::ElementList, attribute, fault, format_args!("remove one of the two entries"));
    }
    let numbers = handles.iter().flatten().map(|h| h.index()).collect();
    (handles.into_iter().flatten().collect(), numbers)
}

/// Edges as authored, each at most once in either direction, and their numbers in the mesh.
fn edges(
    attribute: &str,
    indices: &[i32],
    mesh: &MeshCheck<'_>,
    problems: &mut Problems,
) -> (Vec<[VertexId; 2]>, Vec<usize>) {
    let (pairs, rest) = indices.as_chunks::<2>();
    if !rest.is_empty() {
        let fault = format_args!("holds {}, which do not pair up", Count(indices.len(), "index"));
        let remedy =
            format_args!("give the two end points of each edge: add the missing one, or remove the last index");
        problems.add(ErrorCode::ElementList, attribute, fault, remedy);
    }
    let points = Indices { attribute, kind: "point", count: mesh.points };
    let ends = points.handles(pairs.as_flattened(), |i| Entry("pair", i / 2), problems);
    let whole = ends.as_chunks::<2>().0.iter().enumerate();
    let edges: Vec<(usize, [VertexId; 2])> =
        whole.filter_map(|(pair, ends)| Some((pair, [ends[0]?, ends[1]?]))).collect();
    check_repeated_edges(attribute, &edges, problems);
    let numbers = edges.iter().filter_map(|&(pair, ends)| edge_number(attribute, pair, ends, mesh, problems)).collect();
    (edges.into_iter().map(|(_, ends)| ends).collect(), numbers)
}

/// Checks that no edge is listed twice, in either direction.
fn check_repeated_edges(attribute: &str, edges: &[(usize, [VertexId; 2])], problems: &mut Problems) {
    let undirected = edges.iter().enumerate().map(|(i, &(_, [a, b]))| (i, [a.min(b), a.max(b)]));
    for Repeat { first, again } in repeats(undirected) {
        let ((first, _), (pair, ends)) = (edges[first], edges[again]);
        let [a, b] = ends.map(VertexId::index);
        let fault = format_args!("pair {pair}, points {a} and {b}, is the edge of pair {first} again");
        problems.add(ErrorCode::ElementList, attribute, fault, format_args!("remove one of the two pairs"));
    }
}

/// The number of an edge in the mesh; none where the mesh has no such edge, or its topology is unknown.
fn edge_number(
    attribute: &str,
    pair: usize,
    ends: [VertexId; 2],
    mesh: &MeshCheck<'_>,
    problems: &mut Problems,
) -> Option<usize> {
    let [a, b] = ends.map(VertexId::index);
    if a == b {
        let fault = format_args!("pair {pair} joins point {a} to itself");
        problems.add(ErrorCode::ElementList, attribute, fault, format_args!("remove the pair"));
        return None;
    }
    let edge = mesh.edge(ends)?;
    if edge.is_none() {
        let fault = format_args!("pair {pair}, points {a} and {b}, is not an edge of the mesh");
        let remedy = format_args!("remove the pair, or replace it by one pair for each edge on the way");
        problems.add(ErrorCode::ElementList, attribute, fault, remedy);
    }
    edge.map(EdgeId::index)
}

/// A family with its subsets.
struct Members<'a> {
    family: &'a str,
    rule: FamilyType,
    subsets: Vec<&'a SubsetNumbers>,
    /// Whether all elements of all its subsets are known.
    complete: bool,
}

/// The families that have subsets, in the order of their first one.
fn members<'a>(subsets: &'a [SubsetNumbers], families: &[Family], incomplete: &HashSet<String>) -> Vec<Members<'a>> {
    let rules: HashMap<&str, FamilyType> = families.iter().map(|f| (f.name.as_str(), f.kind)).collect();
    let mut members: Vec<Members<'a>> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    for subset in subsets.iter().filter(|s| !s.subset.family.is_empty()) {
        let family = subset.subset.family.as_str();
        let place = *places.entry(family).or_insert(members.len());
        if place == members.len() {
            let rule = rules.get(family).copied().unwrap_or_default();
            members.push(Members { family, rule, subsets: Vec::new(), complete: !incomplete.contains(family) });
        }
        members[place].subsets.push(subset);
    }
    members
}

impl Members<'_> {
    /// The element type of the first subset.
    fn kind(&self) -> &'static str {
        self.subsets[0].subset.elements.kind()
    }

    /// Checks the family's rule.
    fn check(&self, mesh: &MeshCheck<'_>, problems: &mut Problems) {
        if !self.check_one_kind(problems) || self.rule == FamilyType::Unrestricted {
            return;
        }
        self.check_overlaps(problems);
        if self.complete && self.rule == FamilyType::Partition {
            self.check_cover(mesh, problems);
        }
    }

    /// Checks that the subsets have one element type; returns whether they do.
    fn check_one_kind(&self, problems: &mut Problems) -> bool {
        let before = problems.count();
        let (first, kind, family) = (&self.subsets[0].subset.name, self.kind(), self.family);
        for other in self.subsets.iter().map(|m| &m.subset).filter(|s| s.elements.kind() != kind) {
            let own = other.elements.kind();
            let fault = format_args!("is {own}, but subset {first} of the same family \"{family}\" is {kind}");
            let attribute = format!("{}.elementType", other.name);
            problems.add(
                ErrorCode::SubsetFamily,
                &attribute,
                fault,
                format_args!("give the subset a familyName of its own"),
            );
        }
        problems.count() == before
    }

    /// The subsets whose elements are known, and their numbers.
    fn numbered(&self) -> impl Iterator<Item = (&Subset, &[usize])> {
        self.subsets.iter().filter_map(|s| Some((&s.subset, s.numbers.as_deref()?)))
    }

    /// Checks that no element is in two subsets.
    fn check_overlaps(&self, problems: &mut Problems) {
        let rule = if self.rule == FamilyType::Partition { "partition" } else { "nonOverlapping" };
        // A position counts the elements of all subsets in a row; only those of repeats are located.
        let repeats = repeats(self.numbered().flat_map(|(_, numbers)| numbers).copied().enumerate());
        for Repeat { first, again } in repeats {
            let (Some((first, _)), Some((subset, i))) = (self.locate(first), self.locate(again)) else { continue };
            let (name, first) = (authored_name(&subset.elements, i), &first.name);
            let fault = format_args!("{name} is in subset {first} too, but the family \"{}\" is {rule}", self.family);
            let remedy = format_args!("remove it from one of the two, or set the family type to unrestricted");
            problems.add(ErrorCode::SubsetFamily, &format!("{}.indices", subset.name), fault, remedy);
        }
    }

    /// The subset, and the entry in it, of a position in the elements of all subsets in a row.
    fn locate(&self, mut position: usize) -> Option<(&Subset, usize)> {
        self.numbered().find_map(|(subset, numbers)| match position.checked_sub(numbers.len()) {
            Some(rest) => {
                position = rest;
                None
            }
            None => Some((subset, position)),
        })
    }

    /// Checks that every element is in a subset.
    fn check_cover(&self, mesh: &MeshCheck<'_>, problems: &mut Problems) {
        let kind = self.kind();
        let Some(count) = element_count(kind, mesh) else { return };
        let mut covered = vec![false; count];
        self.numbered().flat_map(|(_, numbers)| numbers).for_each(|&n| covered[n] = true);
        let Some(first) = covered.iter().position(|&c| !c) else { return };
        let all = covered.iter().filter(|&&c| !c).count();
        let name = element_name(kind, first, mesh);
        let fault = format_args!("{name} is in no subset of this partition ({} in all)", Count(all, kind));
        let remedy = format_args!("add what is missing to a subset, or set the family type to nonOverlapping");
        problems.add(ErrorCode::SubsetFamily, &format!("subsetFamily:{}:familyType", self.family), fault, remedy);
    }
}

/// Number of elements of a kind in the mesh.
fn element_count(kind: &str, mesh: &MeshCheck<'_>) -> Option<usize> {
    match kind {
        "face" => mesh.faces,
        "point" => mesh.points,
        _ => mesh.topology.map(|t| t.edges.len()),
    }
}

/// Names an element of the mesh in the user's numbers.
fn element_name(kind: &str, number: usize, mesh: &MeshCheck<'_>) -> String {
    match mesh.topology {
        Some(t) if kind == "edge" => edge_name(t.edges.as_slice()[number]),
        _ => format!("{kind} {number}"),
    }
}

/// Names element `i` of a subset.
fn authored_name(elements: &Elements, i: usize) -> String {
    match elements {
        Elements::Faces(faces) => format!("face {}", faces[i].index()),
        Elements::Edges(edges) => edge_name(edges[i]),
        Elements::Points(points) => format!("point {}", points[i].index()),
    }
}

/// Names an edge by its end points.
fn edge_name([a, b]: [VertexId; 2]) -> String {
    format!("the edge of points {} and {}", a.index(), b.index())
}
