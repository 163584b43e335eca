//! Subsets of faces, edges and points, and the rules of their families.

use super::mesh::{Count, Entry, Indices, MeshCheck, Repeat, repeats};
use super::problem::Problems;
use crate::codes;
use crate::connectivity::{EdgeId, FaceId, Id, VertexId};
use crate::error::Warning;
use crate::garment::{Elements, Family, FamilyType, Subset, SubsetInput};
use std::collections::{HashMap, HashSet};

/// A subset and the numbers of its elements: of faces, points or edges.
struct SubsetNumbers {
    subset: Subset,
    /// None where an element is at fault.
    numbers: Option<Vec<usize>>,
}

/// The subsets, in namespace order. A family whose subsets break its rule gets a weaker one, with a warning.
pub(super) fn subsets(
    inputs: Vec<SubsetInput>,
    families: &mut [Family],
    (mesh, prim): (&MeshCheck<'_>, &str),
    problems: &mut Problems,
) -> (Vec<Subset>, Vec<Warning>) {
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
    let mut warnings = Vec::new();
    for members in members(&numbered, families, &incomplete) {
        let Some(Broken { rule, problem, elements, remedy }) = members.check(mesh, problems) else { continue };
        let name = members.family;
        let place = format!("{prim}.subsetFamily:{name}:familyType");
        warnings.push(Warning::new(codes::FAMILY_RULE, place, problem).at(elements).remedy(remedy));
        families.iter_mut().filter(|family| family.name == name).for_each(|family| family.kind = rule);
    }
    (numbered.into_iter().map(|n| n.subset).collect(), warnings)
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
            problems.add(codes::ELEMENT_LIST, &format!("{}.elementType", input.name), fault, remedy);
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
        problems.add(codes::ELEMENT_LIST, attribute, fault, format_args!("remove one of the two entries"));
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
        problems.add(codes::ELEMENT_LIST, attribute, fault, remedy);
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
        problems.add(codes::ELEMENT_LIST, attribute, fault, format_args!("remove one of the two pairs"));
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
        problems.add(codes::ELEMENT_LIST, attribute, fault, format_args!("remove the pair"));
        return None;
    }
    let edge = mesh.edge(ends)?;
    if edge.is_none() {
        let fault = format_args!("pair {pair}, points {a} and {b}, is not an edge of the mesh");
        let remedy = format_args!("remove the pair, or replace it by one pair for each edge on the way");
        problems.add(codes::ELEMENT_LIST, attribute, fault, remedy);
    }
    edge.map(EdgeId::index)
}

/// How subsets break the rule of their family.
struct Broken {
    /// The strongest rule that they keep.
    rule: FamilyType,
    problem: String,
    /// Elements in several subsets, or in none.
    elements: Elements,
    remedy: &'static str,
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

    /// Checks the family's rule. Subsets of several element types are a problem.
    fn check(&self, mesh: &MeshCheck<'_>, problems: &mut Problems) -> Option<Broken> {
        if !self.check_one_kind(problems) || self.rule == FamilyType::Unrestricted {
            return None;
        }
        let is_whole = self.complete && self.rule == FamilyType::Partition;
        self.overlaps(mesh).or_else(|| if is_whole { self.gaps(mesh) } else { None })
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
                codes::SUBSET_FAMILY,
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

    /// The elements that are in several subsets.
    fn overlaps(&self, mesh: &MeshCheck<'_>) -> Option<Broken> {
        let rule = if self.rule == FamilyType::Partition { "a partition" } else { "nonOverlapping" };
        // Positions count the elements of all subsets in a row.
        let all: Vec<usize> = self.numbered().flat_map(|(_, numbers)| numbers).copied().collect();
        let repeats = repeats(all.iter().copied().enumerate());
        let Repeat { first, again } = *repeats.first()?;
        let (set, other, family) = (self.subset_at(first)?, self.subset_at(again)?, self.family);
        let problem = format!(
            "subsets {set} and {other} have elements in common, but the family \"{family}\" is {rule}; products have it as unrestricted"
        );
        let elements = elements(self.kind(), repeats.iter().map(|repeat| all[repeat.again]).collect(), mesh)?;
        let remedy = "Remove the elements from one of the two, or set the family type to unrestricted";
        Some(Broken { rule: FamilyType::Unrestricted, problem, elements, remedy })
    }

    /// The name of the subset of a position in the elements of all subsets in a row.
    fn subset_at(&self, mut position: usize) -> Option<&str> {
        self.numbered().find_map(|(subset, numbers)| match position.checked_sub(numbers.len()) {
            Some(rest) => {
                position = rest;
                None
            }
            None => Some(subset.name.as_str()),
        })
    }

    /// The elements that are in no subset.
    fn gaps(&self, mesh: &MeshCheck<'_>) -> Option<Broken> {
        let mut is_covered = vec![false; element_count(self.kind(), mesh)?];
        self.numbered().flat_map(|(_, numbers)| numbers).for_each(|&n| is_covered[n] = true);
        let left: Vec<usize> = (0..is_covered.len()).filter(|&n| !is_covered[n]).collect();
        if left.is_empty() {
            return None;
        }
        let elements = elements(self.kind(), left, mesh)?;
        let family = self.family;
        let problem = format!(
            "{} of the mesh are in no subset of the partition \"{family}\"; products have it as nonOverlapping",
            Count(elements.len(), self.kind())
        );
        let remedy = "Add what is missing to a subset, or set the family type to nonOverlapping";
        Some(Broken { rule: FamilyType::NonOverlapping, problem, elements, remedy })
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

/// Elements of a kind by their numbers in the mesh, ascending.
fn elements(kind: &str, mut numbers: Vec<usize>, mesh: &MeshCheck<'_>) -> Option<Elements> {
    numbers.sort_unstable();
    numbers.dedup();
    Some(match kind {
        "face" => Elements::Faces(numbers.into_iter().map(FaceId::new).collect()),
        "point" => Elements::Points(numbers.into_iter().map(VertexId::new).collect()),
        _ => {
            let edges = &mesh.topology?.edges;
            Elements::Edges(numbers.into_iter().map(|n| edges[EdgeId::new(n)]).collect())
        }
    })
}
