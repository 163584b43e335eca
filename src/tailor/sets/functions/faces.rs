//! The functions that give faces.

use super::points::{elements, is_of_elements};
use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation, among};
use crate::sets::expression::quoted;
use crate::sets::pieces::{edges_at, marked};
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{EdgeId, Elements, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Mesh, Primvar, Values};

type Found = Result<ElementSet, SetFault>;

pub fn faces(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    if !arguments.has(0) {
        return Ok(ElementSet::Faces(t.faces.ids().collect()));
    }
    Ok(match arguments.set(of, 0)? {
        faces @ ElementSet::Faces(_) => faces,
        ElementSet::Edges(edges) => ElementSet::Faces(edges.keys().flat_map(|&edge| faces_at(t, edge)).collect()),
        ElementSet::Points(points) => {
            let is_in = marked(&points, t.vertex_count());
            let is_whole = |face: &FaceId| t.faces.vertices_of(*face).iter().all(|&v| is_in[v]);
            ElementSet::Faces(t.faces.ids().filter(is_whole).collect())
        }
    })
}

/// The faces of an edge.
fn faces_at(t: &Topology, edge: EdgeId) -> impl Iterator<Item = FaceId> + '_ {
    t.edge_corners.row(edge).iter().map(|&corner| t.faces.face_of(corner))
}

pub fn material(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let (garment, name) = (of.sets.garment, arguments.name(0)?);
    let found = with_material(garment, name);
    if found.is_empty() {
        let names: BTreeSet<&String> = garment.materials.values().collect();
        of.note(among("the materials", names.into_iter().map(|name| quoted(name))));
    }
    Ok(ElementSet::Faces(found))
}

/// The faces with a material: those of subsets that have it, and the rest if the mesh has it.
pub fn with_material(garment: &Mesh, name: &str) -> BTreeSet<FaceId> {
    let of = |subset: &String| match garment.subset(subset).map(|set| &set.elements) {
        Some(Elements::Faces(faces)) => faces.clone(),
        _ => Vec::new(),
    };
    let bound = garment.materials.iter().filter(|(subset, _)| !subset.is_empty());
    let mut found: BTreeSet<FaceId> =
        bound.clone().filter(|(_, material)| *material == name).flat_map(|(subset, _)| of(subset)).collect();
    if garment.materials.get("").is_some_and(|material| material == name) {
        let others: BTreeSet<FaceId> = bound.flat_map(|(subset, _)| of(subset)).collect();
        found.extend(garment.faces.ids().filter(|face| !others.contains(face)));
    }
    found
}

pub fn same_material(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let (garment, wanted) = (of.sets.garment, arguments.faces(of, 0)?);
    let names: BTreeSet<&String> = garment.materials.values().collect();
    let with = names.into_iter().map(|name| with_material(garment, name));
    let found: BTreeSet<FaceId> = with.filter(|faces| !faces.is_disjoint(&wanted)).flatten().collect();
    // Faces without a material stay as they are.
    Ok(ElementSet::Faces(found.union(&wanted).copied().collect()))
}

pub fn value(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let wanted = arguments.value(1)?;
    let fits = |primvar: &Primvar| primvar.width() == 1 && is_of_elements(primvar) && !primvar.is_mixed();
    let Some(primvar) = of.primvar(arguments, "the primvars of one number or text for each face or point", fits)?
    else {
        return Ok(ElementSet::Faces(BTreeSet::new()));
    };
    let found = elements(primvar, |element| {
        let value = text_at(primvar, element);
        wanted.as_ref().map_or_else(|| !matches!(value.as_str(), "" | "0" | "false"), |wanted| *wanted == value)
    });
    if found.is_empty() {
        let values: BTreeSet<String> = (0..primvar.elements()).map(|element| text_at(primvar, element)).collect();
        of.note(among("its first values", values.into_iter().take(10)));
    }
    Ok(found)
}

/// The value of a discrete primvar as text.
pub fn text_at(primvar: &Primvar, element: usize) -> String {
    let row = primvar.row(element);
    match &primvar.values {
        Values::Bool(values) => values[row].to_string(),
        Values::U8(values) => values[row].to_string(),
        Values::I32(values) => values[row].to_string(),
        Values::U32(values) => values[row].to_string(),
        Values::I64(values) => values[row].to_string(),
        Values::U64(values) => values[row].to_string(),
        Values::Text(values) => values[row].clone(),
        Values::F32(_) | Values::F64(_) => String::new(),
    }
}

pub fn rings(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let count = arguments.number(1, 1.0)?;
    if count < 1.0 || count.fract() != 0.0 {
        return Err(SetFault::new(format!("rings has the count {count}"), "give a whole number from 1"));
    }
    let mut front = match arguments.set(of, 0)? {
        ElementSet::Edges(edges) => Front { edges: edges.into_keys().collect(), faces: BTreeSet::new() },
        ElementSet::Faces(faces) => Front::around(t, faces),
        ElementSet::Points(points) => {
            let touched = points.iter().flat_map(|&v| t.faces_at(v)).collect();
            if count <= 1.0 {
                return Ok(ElementSet::Faces(touched));
            }
            let mut front = Front::around(t, touched);
            (1..count as usize).take_while(|_| front.advance(t)).count();
            return Ok(ElementSet::Faces(front.faces));
        }
    };
    // No mesh has more rings than faces.
    (0..count as usize).take_while(|_| front.advance(t)).count();
    Ok(ElementSet::Faces(front.faces))
}

/// Faces that grow ring by ring, and the edges across which they do.
struct Front {
    edges: BTreeSet<EdgeId>,
    faces: BTreeSet<FaceId>,
}

impl Front {
    fn around(t: &Topology, faces: BTreeSet<FaceId>) -> Self {
        let is_in = marked(&faces, t.faces.len());
        let of_faces = faces.iter().flat_map(|&face| t.faces.corners_of(face)).map(|corner| t.corner_edge[corner]);
        let edges = of_faces.filter(|&edge| faces_at(t, edge).any(|face| !is_in[face])).collect();
        Self { edges, faces }
    }

    /// Adds the faces that have one of the edges, or a vertex between two of them. Returns whether there are some.
    fn advance(&mut self, t: &Topology) -> bool {
        let before = self.faces.len();
        let edges = std::mem::take(&mut self.edges);
        let inner = edges_at(t, edges.iter()).into_iter().filter(|(_, edges)| edges.len() > 1);
        let mut faces = std::mem::take(&mut self.faces);
        faces.extend(inner.flat_map(|(vertex, _)| t.faces_at(vertex)));
        faces.extend(edges.iter().flat_map(|&edge| faces_at(t, edge)));
        *self = Self::around(t, faces);
        self.faces.len() > before
    }
}

/// Faces that `within` may visit, each once for each edge, so that it ends soon.
const MOST_VISITS: usize = 100_000_000;

pub fn within(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let (garment, t) = (of.sets.garment, &of.sets.topology);
    let most = arguments.length(1, garment.units.meters())?;
    let edges = arguments.edges(of, 0)?;
    let mut search = Surroundings { garment, t, most, seen: IdVec::filled(None, t.faces.len()), visits: 0 };
    let mut found = BTreeSet::new();
    for &edge in edges.keys() {
        search.add(edge, &mut found);
        if search.visits > MOST_VISITS {
            let text = format!("within reaches too many faces from {} edges", edges.len());
            return Err(SetFault::new(text, "give a smaller length, or rings(...)"));
        }
    }
    Ok(ElementSet::Faces(found))
}

/// A search for the faces around edges. Faces that only other parts of the garment connect to an edge are not around it,
/// however near in space.
struct Surroundings<'a> {
    garment: &'a Mesh,
    t: &'a Topology,
    /// The greatest distance of a centre. \[mesh units\]
    most: f64,
    /// The last edge from which each face was visited.
    seen: IdVec<FaceId, Option<EdgeId>>,
    visits: usize,
}

impl Surroundings<'_> {
    /// Adds the faces around an edge.
    fn add(&mut self, edge: EdgeId, found: &mut BTreeSet<FaceId>) {
        let mut waiting: Vec<FaceId> = faces_at(self.t, edge).collect();
        while let Some(face) = waiting.pop() {
            if self.seen[face].replace(edge) == Some(edge) {
                continue;
            }
            self.visits += 1;
            if self.distance(face, edge) > self.most {
                continue;
            }
            found.insert(face);
            waiting
                .extend(self.t.faces.corners_of(face).flat_map(|corner| faces_at(self.t, self.t.corner_edge[corner])));
        }
    }

    /// The distance of a face's centre from an edge. \[mesh units\]
    fn distance(&self, face: FaceId, edge: EdgeId) -> f64 {
        let at = |v: VertexId| self.garment.points[v].as_dvec3();
        let vertices = self.t.faces.vertices_of(face);
        let centre = vertices.iter().map(|&v| at(v)).sum::<DVec3>() / vertices.len() as f64;
        let [a, b] = self.t.edges[edge].map(at);
        let along = b - a;
        let share = (along.dot(centre - a) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        centre.distance(a + share * along)
    }
}

pub fn uv_shells(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let seams = of.uv_seams(arguments, 0)?;
    Ok(ElementSet::Faces(seams.map_or_else(BTreeSet::new, |_| of.sets.topology.faces.ids().collect())))
}

pub fn shell(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let wanted = arguments.faces(of, 0)?;
    let Some(seams) = of.uv_seams(arguments, 1)? else { return Ok(ElementSet::Faces(BTreeSet::new())) };
    let shells = of.shells(&seams).into_iter();
    let with = shells.filter_map(|shell| if let ElementSet::Faces(faces) = shell { Some(faces) } else { None });
    Ok(ElementSet::Faces(with.filter(|faces| !faces.is_disjoint(&wanted)).flatten().collect()))
}

pub fn udim(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let tile = arguments.number(0, 0.0)?;
    let Some(seams) = of.uv_seams(arguments, 1)? else { return Ok(ElementSet::Faces(BTreeSet::new())) };
    let tiles: IdVec<FaceId, f64> = t.faces.ids().map(|face| f64::from(tile_of(&seams.uvs_of(t, face)))).collect();
    let found: BTreeSet<FaceId> = t.faces.ids().filter(|&face| tiles[face] == tile).collect();
    if found.is_empty() {
        let known: BTreeSet<u32> = tiles.iter().map(|&tile| tile as u32).collect();
        of.note(among("the tiles", known.into_iter().take(10).map(|tile| tile.to_string())));
    }
    Ok(ElementSet::Faces(found))
}

/// The UDIM tile of the centre of some UVs; 0 outside of all tiles.
pub fn tile_of(uvs: &[DVec2]) -> u32 {
    let centre = uvs.iter().sum::<DVec2>() / uvs.len().max(1) as f64;
    let is_tiled = (0.0..10.0).contains(&centre.x) && (0.0..900.0).contains(&centre.y);
    if is_tiled { 1001 + centre.x as u32 + 10 * centre.y as u32 } else { 0 }
}
