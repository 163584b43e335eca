//! The sets that a garment offers, in the words that a recipe takes.

use super::SetEvaluator;
use super::elements::ElementSet;
use super::expression::{Extreme, quoted};
use super::functions::faces::{text_at, tile_of, with_material};
use super::functions::points::{is_of_elements, is_weight};
use super::pieces::{Extent, face_pieces, pieces};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::Elements;
use tailor_mesh::garment::{Primvar, PrimvarRole, UvSeams};

/// Values of a primvar that are listed as sets.
const MOST_VALUES: usize = 32;
/// Part of the garment's size by which a piece is farther than all others if its place is named.
const MARGIN: f64 = 0.01;

/// A set that a garment offers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ListedSet {
    /// Its expression.
    pub expression: String,
    /// Its elements: faces, edges or points.
    pub kind: &'static str,
    /// The elements.
    #[serde(skip)]
    pub elements: Elements,
    /// Number of elements.
    pub count: usize,
    /// Its length \[m\] or area \[m²\]; none of points.
    pub size: Option<f64>,
    /// True for a closed loop of edges.
    pub is_closed: bool,
    /// The word of its place among the pieces of one set, such as lowest; empty where another piece is as far.
    pub place: &'static str,
    /// The least coordinates in the stage's directions, from the origin of the mesh. \[stage units\]
    pub low: [f32; 3],
    /// The greatest coordinates.
    pub high: [f32; 3],
}

impl ListedSet {
    /// The set of which it is a piece, or itself.
    pub fn stem(&self) -> &str {
        let piece = self.expression.rsplit_once('.');
        let numbered = piece.filter(|(_, number)| number.bytes().all(|digit| digit.is_ascii_digit()));
        numbered.map_or(self.expression.as_str(), |(stem, _)| stem)
    }
}

impl SetEvaluator<'_> {
    /// The sets that the garment offers: pieces of its borders, UV seams and UV shells, its creases, materials, discrete primvars
    /// by value, painted weights and UDIM tiles. None of them is empty.
    pub fn list(&self) -> Vec<ListedSet> {
        let mut found = self.pieces_of("borders");
        let t = &self.topology;
        let uvs = self.garment.primvar(self.uv_set).filter(|primvar| primvar.is_uv_set());
        let seams = uvs.map(|primvar| UvSeams::new(primvar, t));
        found.extend(self.pieces_of("uvSeams"));
        found.extend(self.whole("creases"));
        let materials: BTreeSet<&String> = self.garment.materials.values().collect();
        let of_material = |name: &&String| {
            self.listed(
                format!("material({})", quoted(name)),
                &ElementSet::Faces(with_material(self.garment, name)),
                "",
            )
        };
        found.extend(materials.iter().filter_map(of_material));
        let primvars = self.garment.primvars.iter().filter(|primvar| primvar.role == PrimvarRole::Primvar);
        primvars.for_each(|primvar| found.extend(self.of_primvar(primvar)));
        if let Some(seams) = &seams {
            let shells = face_pieces(t, &t.faces.ids().collect(), |edge| seams.is_cut(t, edge));
            found.extend(self.listed_pieces("uvShells", &shells));
            found.extend(self.tiles(seams));
        }
        found
    }

    fn pieces_of(&self, name: &str) -> Vec<ListedSet> {
        let Ok(derived) = self.evaluate(name) else { return Vec::new() };
        let set = ElementSet::of(&self.topology, &derived.elements);
        self.listed_pieces(name, &pieces(&self.topology, &set))
    }

    fn whole(&self, expression: &str) -> Option<ListedSet> {
        let derived = self.evaluate(expression).ok()?;
        self.listed(expression.to_owned(), &ElementSet::of(&self.topology, &derived.elements), "")
    }

    /// Pieces by their numbers, with the words of those whose place is their own.
    fn listed_pieces(&self, name: &str, pieces: &[ElementSet]) -> Vec<ListedSet> {
        let extents: Vec<Extent> = pieces.iter().map(|piece| Extent::of(self.garment, &self.topology, piece)).collect();
        let [low, high] = self.garment.bounds().map(|p| self.garment.space.to_stage * p);
        let margin = MARGIN * f64::from(low.distance(high));
        let mut words = vec![""; pieces.len()];
        for (word, extreme) in Extreme::ALL.into_iter().rev().filter(|_| pieces.len() > 1) {
            let up = self.garment.space.up_axis();
            let along: Vec<f64> = extents.iter().map(|extent| extent.along(extreme, up)).collect();
            let (mut order, least) =
                ((0..along.len()).collect::<Vec<_>>(), if extreme == Extreme::Largest { 0.0 } else { margin });
            order.sort_by(|&a, &b| along[b].total_cmp(&along[a]));
            if along[order[0]] > along[order[1]] + least {
                words[order[0]] = word;
            }
        }
        let numbered = pieces.iter().zip(words).enumerate();
        numbered.filter_map(|(i, (piece, word))| self.listed(format!("{name}.{}", i + 1), piece, word)).collect()
    }

    pub(super) fn listed(&self, expression: String, set: &ElementSet, place: &'static str) -> Option<ListedSet> {
        if set.is_empty() {
            return None;
        }
        let Extent { low, high, size } = Extent::of(self.garment, &self.topology, set);
        let meters = self.garment.units.meters();
        let (size, is_closed) = match set {
            ElementSet::Edges(edges) => (Some(size * meters), is_closed(edges.values())),
            ElementSet::Faces(_) => (Some(size * meters * meters), false),
            ElementSet::Points(_) => (None, false),
        };
        let (kind, count, low, high) = (set.kind(), set.len(), low.to_array(), high.to_array());
        let elements = set.clone().into_elements();
        Some(ListedSet { expression, kind, elements, count, size, is_closed, place, low, high })
    }

    fn of_primvar(&self, primvar: &Primvar) -> Vec<ListedSet> {
        let name = quoted(&primvar.name);
        if is_weight(primvar) {
            return self.whole(&format!("weight({name})")).into_iter().collect();
        }
        if primvar.width() != 1 || primvar.is_mixed() || !is_of_elements(primvar) {
            return Vec::new();
        }
        let values: BTreeSet<String> = (0..primvar.elements()).map(|element| text_at(primvar, element)).collect();
        if values.len() > MOST_VALUES {
            return Vec::new();
        }
        // A text such as 01 is not the number that it reads as.
        let is_number = |value: &str| value.parse::<f64>().is_ok_and(|number| number.to_string() == value);
        let argument = |value: &String| if is_number(value) { value.clone() } else { quoted(value) };
        values.iter().filter_map(|value| self.whole(&format!("value({name}, {})", argument(value)))).collect()
    }

    /// The UDIM tiles, if there are several.
    fn tiles(&self, seams: &UvSeams<'_>) -> Vec<ListedSet> {
        let t = &self.topology;
        let mut tiles = BTreeMap::<u32, BTreeSet<_>>::new();
        for face in t.faces.ids() {
            tiles.entry(tile_of(&seams.uvs_of(t, face))).or_default().insert(face);
        }
        let is_used = tiles.len() > 1;
        let tiles = tiles.into_iter().filter(|(tile, _)| is_used && *tile > 0);
        tiles.filter_map(|(tile, faces)| self.listed(format!("udim({tile})"), &ElementSet::Faces(faces), "")).collect()
    }
}

/// Whether every vertex has two of the edges.
fn is_closed<'e>(edges: impl Iterator<Item = &'e [tailor_mesh::connectivity::VertexId; 2]>) -> bool {
    let mut counts = BTreeMap::<_, usize>::new();
    edges.flatten().for_each(|&v| *counts.entry(v).or_default() += 1);
    counts.values().all(|&count| count == 2)
}
