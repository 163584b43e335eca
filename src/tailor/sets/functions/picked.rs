//! Elements by their numbers, with a checksum of the mesh that has them.

use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};
use crate::sets::expression::{Argument, Expression};
use crate::sets::pieces::{edges_at, oriented, pieces};
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{EdgeId, FaceId, Faces, Topology, VertexId};

type Found = Result<ElementSet, SetFault>;

const EDGES: &str = "pickedEdges";
const FACES: &str = "pickedFaces";

/// A checksum of the faces of a mesh, so that numbers are not taken for those of another mesh. FNV-1a, 32 bits.
pub fn checksum(faces: &Faces) -> String {
    let numbers = faces.ids().flat_map(|face| {
        let vertices = faces.vertices_of(face);
        std::iter::once(vertices.len()).chain(vertices.iter().map(|v| v.index()))
    });
    let hash = numbers
        .flat_map(|number| (number as u32).to_le_bytes())
        .fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    format!("{hash:08x}")
}

/// True if an expression has elements by their numbers.
pub fn is_picked(expression: &Expression) -> bool {
    match expression {
        Expression::Name(_) => false,
        Expression::Call(name, arguments) => {
            let in_argument = |argument: &Argument| matches!(argument, Argument::Set(set) if is_picked(set));
            name == EDGES || name == FACES || arguments.iter().any(in_argument)
        }
        Expression::Piece(of, _) => is_picked(of),
        Expression::Combined(first, rest) => is_picked(first) || rest.iter().any(|(_, set)| is_picked(set)),
    }
}

/// The expression of edges or faces by their numbers; none of points.
pub fn expression(t: &Topology, set: &ElementSet) -> Option<String> {
    let (name, numbers) = match set {
        ElementSet::Edges(edges) => (EDGES, edge_runs(t, &along_chains(t, edges))),
        ElementSet::Faces(faces) => (FACES, face_runs(faces)),
        ElementSet::Points(_) => return None,
    };
    Some(format!("{name}(\"{}\", \"{}\")", checksum(&t.faces), numbers.join(", ")))
}

/// Faces in ascending order, as ranges.
fn face_runs(faces: &BTreeSet<FaceId>) -> Vec<String> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for face in faces.iter().map(|face| face.index()) {
        match runs.last_mut() {
            Some([_, end]) if *end + 1 == face => *end = face,
            _ => runs.push([face, face]),
        }
    }
    runs.iter().map(|[a, b]| if a == b { a.to_string() } else { format!("{a}-{b}") }).collect()
}

/// Edges with one direction along each chain: that of most of its edges.
fn along_chains(t: &Topology, edges: &BTreeMap<EdgeId, [VertexId; 2]>) -> BTreeMap<EdgeId, [VertexId; 2]> {
    let chains = pieces(t, &oriented(t, &edges.keys().copied().collect()));
    let chains =
        chains.into_iter().filter_map(|chain| if let ElementSet::Edges(chain) = chain { Some(chain) } else { None });
    let turned = chains.flat_map(|chain| {
        let agree = chain.iter().filter(|(edge, ends)| edges[edge] == **ends).count();
        let is_against = 2 * agree < chain.len();
        chain.into_iter().map(move |(edge, [a, b])| (edge, if is_against { [b, a] } else { [a, b] }))
    });
    turned.collect()
}

/// Edges as runs of points, each edge in its direction.
fn edge_runs(t: &Topology, edges: &BTreeMap<EdgeId, [VertexId; 2]>) -> Vec<String> {
    let at = edges_at(t, edges.keys());
    let go_on = |edge: EdgeId, end: usize| match at[&edges[&edge][end]][..] {
        [a, b] => Some(if a == edge { b } else { a }).filter(|other| edges[other][1 - end] == edges[&edge][end]),
        _ => None,
    };
    let starts = edges.keys().copied().filter(|&edge| go_on(edge, 0).is_none());
    let mut is_written = BTreeSet::new();
    let mut runs = Vec::new();
    // Edges that are left when all starts are written are in closed loops.
    for start in starts.chain(edges.keys().copied()) {
        let mut next = Some(start).filter(|edge| !is_written.contains(edge));
        let mut run: Vec<String> = next.iter().map(|edge| edges[edge][0].index().to_string()).collect();
        while let Some(edge) = next.filter(|&edge| is_written.insert(edge)) {
            run.push(edges[&edge][1].index().to_string());
            next = go_on(edge, 1);
        }
        runs.extend((!run.is_empty()).then(|| run.join("-")));
    }
    runs
}

pub fn edges(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let mut found = BTreeMap::new();
    for run in runs(of, arguments)? {
        for ends in run.windows(2) {
            let known =
                ends.iter().all(|&number| number < t.vertex_count()).then(|| [ends[0], ends[1]].map(VertexId::new));
            let edge = known.and_then(|[a, b]| Some((t.find_edge(a, b)?, [a, b])));
            found.extend([edge.ok_or_else(|| missing(of, &format!("edge {}-{}", ends[0], ends[1])))?]);
        }
    }
    Ok(ElementSet::Edges(found))
}

pub fn faces(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let count = of.sets.topology.faces.len();
    let mut found = BTreeSet::new();
    for run in runs(of, arguments)? {
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else { continue };
        if last >= count {
            return Err(missing(of, &format!("face {last}")));
        }
        found.extend((first..=last).map(FaceId::new));
    }
    Ok(ElementSet::Faces(found))
}

pub fn painted(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let count = of.sets.topology.vertex_count();
    let fault =
        || SetFault::new("the painted weights are not two hexadecimal digits for each point", "paint them again");
    let weights = weights(numbers(of, arguments)?).filter(|weights| weights.len() == count).ok_or_else(fault)?;
    Ok(ElementSet::Points((0..count).filter(|&point| weights[point] > 0.0).map(VertexId::new).collect()))
}

/// Weights of two hexadecimal digits each, `ff` for 1.
fn weights(text: &str) -> Option<Vec<f32>> {
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    text.as_bytes().chunks(2).map(|pair| Some(f32::from(byte(pair)?) / 255.0)).collect()
}

/// The weights of the points, if the expression is `painted` alone.
pub fn painted_weights(expression: &str) -> Option<Vec<f32>> {
    let ["painted(", _, ", ", text, ")"] = expression.split('"').collect::<Vec<_>>()[..] else { return None };
    weights(text)
}

/// The expression of painted weights of the points of a mesh.
pub fn painted_expression(faces: &Faces, weights: &[f32]) -> String {
    let digits: String = weights.iter().map(|weight| format!("{:02x}", (255.0 * weight).round() as u8)).collect();
    format!("painted(\"{}\", \"{digits}\")", checksum(faces))
}

/// The numbers of a pick, if it is of the mesh as it is.
fn numbers<'a>(of: &Evaluation<'_>, arguments: &'a Arguments<'_>) -> Result<&'a str, SetFault> {
    let (picked, own) = (arguments.name(0)?, checksum(&of.sets.topology.faces));
    if picked != own {
        let prim = &of.sets.garment.prim;
        let text =
            format!("the elements were picked on other faces than those of {prim}: checksum {picked}, now {own}");
        return Err(SetFault::new(text, "pick them again, or name a set that both meshes have, such as borders.1"));
    }
    arguments.name(1)
}

/// The runs of numbers of a pick.
fn runs(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Result<Vec<Vec<usize>>, SetFault> {
    let text = numbers(of, arguments)?;
    let run = |run: &str| run.split('-').map(|number| number.trim().parse().ok()).collect::<Option<Vec<usize>>>();
    let runs = text.split(',').filter(|run| !run.trim().is_empty()).map(run).collect::<Option<Vec<_>>>();
    runs.ok_or_else(|| {
        SetFault::new(format!("\"{text}\" has words that are not numbers"), "write numbers such as \"4-6, 9\"")
    })
}

fn missing(of: &Evaluation<'_>, element: &str) -> SetFault {
    SetFault::new(format!("{} has no {element}", of.sets.garment.prim), "pick the elements again")
}
