//! Subsets of faces, edges and points, and the rules of their families.

use super::mesh::{Count, Indices, Mesh, Place};
use super::problem::Problems;
use crate::garment::{Elements, Family, FamilyType, Subset, SubsetInput};
use crate::mesh::{Id, VertexId};
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

/// A subset and the numbers of its elements: of faces, points or edges.
struct Numbered {
    subset: Subset,
    /// None where an element is at fault.
    numbers: Option<Vec<usize>>,
}

/// The subsets, in namespace order.
pub(super) fn subsets(
    inputs: Vec<SubsetInput>,
    families: &[Family],
    mesh: &Mesh<'_>,
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

/// One subset; none if its elements are of no kind that a mesh has.
fn subset(input: SubsetInput, mesh: &Mesh<'_>, problems: &mut Problems) -> Option<Numbered> {
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
            let fault = format_args!("\"{other}\" is no element of a mesh");
            let remedy = format_args!("set elementType to face, edge or point");
            problems.add(&format!("{}.elementType", input.name), fault, remedy);
            return None;
        }
    };
    let clean = problems.count() == before && numbers.len() == elements.len();
    let subset = Subset { name: input.name, family: input.family, elements };
    Some(Numbered { subset, numbers: clean.then_some(numbers) })
}

/// Faces or points, each at most once.
fn plain<I: Id>(
    attribute: &str,
    kind: &'static str,
    count: Option<usize>,
    indices: &[i32],
    problems: &mut Problems,
) -> (Vec<I>, Vec<usize>) {
    let handles = Indices { attribute, kind, count }.handles::<I, _>(indices, |i| Place("entry", i), problems);
    let mut seen = HashMap::new();
    for (i, element) in handles.iter().enumerate().filter_map(|(i, h)| Some((i, (*h)?.index()))) {
        if let Some(first) = seen.insert(element, i) {
            let fault = format_args!("entry {i} names {kind} {element} again, after entry {first}");
            problems.add(attribute, fault, format_args!("remove one of the two entries"));
        }
    }
    let numbers = handles.iter().flatten().map(|h| h.index()).collect();
    (handles.into_iter().flatten().collect(), numbers)
}

/// Edges as authored, each at most once in either direction, and their numbers in the mesh.
fn edges(
    attribute: &str,
    indices: &[i32],
    mesh: &Mesh<'_>,
    problems: &mut Problems,
) -> (Vec<[VertexId; 2]>, Vec<usize>) {
    let (pairs, rest) = indices.as_chunks::<2>();
    if !rest.is_empty() {
        let fault = format_args!("holds {}, which do not pair up", Count(indices.len(), "index"));
        let remedy =
            format_args!("give the two end points of each edge: add the missing one, or remove the last index");
        problems.add(attribute, fault, remedy);
    }
    let points = Indices { attribute, kind: "point", count: mesh.points };
    let ends = points.handles(pairs.as_flattened(), |i| Place("pair", i / 2), problems);
    let mut found = Edges { attribute, mesh, seen: HashMap::new(), numbers: Vec::new() };
    let mut edges = Vec::with_capacity(pairs.len());
    for (pair, ends) in ends.as_chunks::<2>().0.iter().enumerate() {
        let &[Some(a), Some(b)] = ends else { continue };
        found.add(pair, [a, b], problems);
        edges.push([a, b]);
    }
    (edges, found.numbers)
}

/// The edges of one subset so far.
struct Edges<'a> {
    attribute: &'a str,
    mesh: &'a Mesh<'a>,
    /// The pair that named an edge first.
    seen: HashMap<[VertexId; 2], usize>,
    /// The number of each edge in the mesh.
    numbers: Vec<usize>,
}

impl Edges<'_> {
    /// Checks one pair.
    fn add(&mut self, pair: usize, [a, b]: [VertexId; 2], problems: &mut Problems) {
        let (from, to) = (a.index(), b.index());
        if a == b {
            let fault = format_args!("pair {pair} joins point {from} to itself");
            return problems.add(self.attribute, fault, format_args!("remove the pair"));
        }
        if let Some(first) = self.seen.insert([a.min(b), a.max(b)], pair) {
            let fault = format_args!("pair {pair}, points {from} and {to}, is the edge of pair {first} again");
            return problems.add(self.attribute, fault, format_args!("remove one of the two pairs"));
        }
        match self.mesh.edge([a, b]) {
            Some(Some(edge)) => self.numbers.push(edge.index()),
            Some(None) => {
                let fault = format_args!("pair {pair}, points {from} and {to}, is not an edge of the mesh");
                let remedy = format_args!("remove the pair, or replace it by one pair for each edge on the way");
                problems.add(self.attribute, fault, remedy);
            }
            None => {}
        }
    }
}

/// A family with its subsets.
struct Members<'a> {
    family: &'a str,
    rule: FamilyType,
    subsets: Vec<&'a Numbered>,
    /// Whether all elements of all its subsets are known.
    complete: bool,
}

/// The families that have subsets, in the order of their first one.
fn members<'a>(subsets: &'a [Numbered], families: &[Family], incomplete: &HashSet<String>) -> Vec<Members<'a>> {
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
    fn check(&self, mesh: &Mesh<'_>, problems: &mut Problems) {
        if !self.check_one_kind(problems) || self.rule == FamilyType::Unrestricted {
            return;
        }
        let owners = self.owners(problems);
        if self.complete && self.rule == FamilyType::Partition {
            self.check_cover(&owners, mesh, problems);
        }
    }

    /// Checks that the subsets are of one element type; says whether.
    fn check_one_kind(&self, problems: &mut Problems) -> bool {
        let before = problems.count();
        let (first, kind, family) = (&self.subsets[0].subset.name, self.kind(), self.family);
        for other in self.subsets.iter().map(|m| &m.subset).filter(|s| s.elements.kind() != kind) {
            let own = other.elements.kind();
            let fault = format_args!("is {own}, but subset {first} of the same family \"{family}\" is {kind}");
            let attribute = format!("{}.elementType", other.name);
            problems.add(&attribute, fault, format_args!("give the subset a familyName of its own"));
        }
        problems.count() == before
    }

    /// The elements that are in a subset; one that is in a second is a problem.
    fn owners(&self, problems: &mut Problems) -> HashMap<usize, &str> {
        let mut owners: HashMap<usize, &str> = HashMap::new();
        for (subset, numbers) in self.subsets.iter().filter_map(|m| Some((&m.subset, m.numbers.as_ref()?))) {
            for (i, &number) in numbers.iter().enumerate() {
                match owners.entry(number) {
                    Entry::Occupied(first) => self.add_overlap(subset, i, first.get(), problems),
                    Entry::Vacant(free) => {
                        free.insert(&subset.name);
                    }
                }
            }
        }
        owners
    }

    /// Adds the problem that element `i` of a subset is in another one too.
    fn add_overlap(&self, subset: &Subset, i: usize, first: &str, problems: &mut Problems) {
        let rule = if self.rule == FamilyType::Partition { "partition" } else { "nonOverlapping" };
        let name = authored_name(&subset.elements, i);
        let fault = format_args!("{name} is in subset {first} too, but the family \"{}\" is {rule}", self.family);
        let remedy = format_args!("remove it from one of the two, or set the family type to unrestricted");
        problems.add(&format!("{}.indices", subset.name), fault, remedy);
    }

    /// Checks that every element has an owner.
    fn check_cover(&self, owners: &HashMap<usize, &str>, mesh: &Mesh<'_>, problems: &mut Problems) {
        let kind = self.kind();
        let Some(count) = element_count(kind, mesh) else { return };
        let mut missing = (0..count).filter(|n| !owners.contains_key(n));
        let Some(first) = missing.next() else { return };
        let all = 1 + missing.count();
        let name = element_name(kind, first, mesh);
        let fault = format_args!("{name} is in no subset of this partition ({} in all)", Count(all, kind));
        let remedy = format_args!("add what is missing to a subset, or set the family type to nonOverlapping");
        problems.add(&format!("subsetFamily:{}:familyType", self.family), fault, remedy);
    }
}

/// How many elements of a kind the mesh has.
fn element_count(kind: &str, mesh: &Mesh<'_>) -> Option<usize> {
    match kind {
        "face" => mesh.faces,
        "point" => mesh.points,
        _ => mesh.topology.map(|t| t.edges.len()),
    }
}

/// Names an element of the mesh in the user's numbers.
fn element_name(kind: &str, number: usize, mesh: &Mesh<'_>) -> String {
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
