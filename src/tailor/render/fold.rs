//! Folds: a second layer of face sets, folded over at the border of the mesh, as a hem, a cuff or a collar.
//!
//! ```text
//!   outer   --o-------o---v           v  border, now the fold       o  support loop of the fold
//!                         | hem       v' its copy
//!   inner   --o'------o'--v'          the distance of the layers is thickness × weight
//! ```
//!
//! A support loop beside the border keeps the fold tight. The faces are then copied with reversed winding, and hem
//! faces join each border edge to its copy. The winding is consistent across the hem. Faces without clearance are
//! omitted (`cover`).

mod cover;
mod ends;
mod halving;
mod layer;

use super::lines::{self, LineRequest, LineVertex, Lines};
use super::operator::{
    Control, ControlRole, LayerEnd, Operator, OperatorInput, OperatorOutput, REPORTED, is_lone_corner,
};
use super::options::OperatorOptions;
use crate::codes;
use crate::sets::weights_named;
use cover::{Cover, layer_ends};
use ends::{Ends, square_edges};
use glam::Vec3;
pub use halving::halving;
use layer::Layer;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings, counted};
use tailor_mesh::garment::{Elements, Mesh, Subset, Values};
use tailor_mesh::options::{Domain, OptionValue, options};
use tailor_mesh::subdivide::{Level, Stencils};

/// Distance of the support loop from the fold, as a share of the thickness. Smaller makes the fold tighter.
const SUPPORT_DISTANCE: f32 = 1.0;
/// Length over which the height of a fold goes to nothing at its end, as a multiple of the thickness.
const TAPER_LENGTH: f32 = 1.5;
/// Share of the height below which a place of the fold belongs to its taper, and holds none of its neighbours down.
const TAPERED: f32 = 0.9;
/// Length over which the second layer closes beside the end of a fold, as a multiple of the thickness.
const CLOSED_LENGTH: f32 = 3.0;
/// Weight of the second layer where it is closed. Smaller closes it more; the surfaces may then intersect where they bend.
const CLOSED_WEIGHT: f32 = 0.07;
/// Smallest radius of a turn, in half thicknesses: that of a pressed edge. Copies cannot follow a smaller one.
const MIN_TURN: f32 = 0.4;
/// Smallest weight, which separates the layers where 0 is painted.
const MIN_WEIGHT: f32 = 0.01;

/// The side of the surface on which the second layer is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Side {
    /// Behind the surface, against its normals.
    #[default]
    Inner,
    /// Before the surface, along its normals.
    Outer,
}

impl OptionValue for Side {}

options! {
    /// A second layer of the render mesh, folded over at the border of the mesh.
    "fold" => FoldOptions {
        /// False to leave the second layer out and keep its options
        "enabled" enabled: bool = true, Domain::Flag, "true or false";

        /// Face subsets of this mesh that get a second layer as one piece, folded over at the borders of the mesh among
        /// their edges
        "faces" faces: Vec<String> = Vec::new(), Domain::Sets { of: &["face"], required: true }, "names of subsets";

        /// Gap between the layers; it shrinks where space is tight, and faces that touch other cloth get no second layer; 0 is
        /// a tenth of the mesh's mean edge length
        "thickness" thickness: f32 = 0.0, Domain::length([0.0, 0.4], 0.1),
            "mesh units" via "tailor_mesh::garment::units::deserialize_length";

        /// Radius of the turn at the border, in half thicknesses; 1 is round, 0.4 and less is pressed, and more than 1 is a roll
        "turn" turn: f32 = 1.0,
            Domain::Number { least: 0.0, most: Some(1.5), or_zero: false, usual: [0.0, 1.5], step: 0.1 }, "half thicknesses";

        /// Painted vertex primvar, named without `primvars:`, or a set as in sim.density, that scales the thickness; 0 tucks the
        /// layer in, and empty is 1 everywhere
        "weights" weights: String = String::new(), Domain::Weights, "name of a primvar, or a set";

        /// Position of the second layer, inner behind the surface or outer in front of it
        "side" side: Side = Side::Inner, Domain::Choice { words: &["inner", "outer"] }, "inner or outer";

        /// Add a second layer also to faces without a border of the mesh
        "closed" closed: bool = false, Domain::Flag, "true or false";
    }
}

impl OperatorOptions for FoldOptions {
    fn is_enabled(&self) -> bool {
        self.enabled
    }

    fn operator(&self, name: &str) -> Arc<dyn Operator> {
        Arc::new(Fold { name: name.to_owned(), options: self.clone() })
    }
}

/// The operator of a fold.
#[derive(Clone, Debug, PartialEq)]
struct Fold {
    name: String,
    options: FoldOptions,
}

impl Fold {
    /// True for faces of the named subsets.
    fn chosen(&self, garment: &Mesh) -> IdVec<FaceId, bool> {
        let mut chosen = IdVec::filled(false, garment.faces.len());
        for subset in self.options.faces.iter().filter_map(|name| garment.subset(name)) {
            if let Elements::Faces(faces) = &subset.elements {
                faces.iter().for_each(|&f| chosen[f] = true);
            }
        }
        chosen
    }

    /// Warnings of faces without a second layer.
    fn warn(&self, cage: &OperatorInput, cover: &Cover) -> Warnings {
        let mut warnings = Warnings::default();
        let label = self.label();
        let close = format!("Give those a second layer, or set `{label}.closed`");
        for (omitted, problem, remedy) in [
            (&cover.turned, "faces beside them have the opposite winding", "Give both the same winding"),
            (
                &cover.tight,
                "other cloth lies against them",
                "Move the cloth away, choose the other side, or remove the faces from its subsets",
            ),
            (&cover.cut_off, "faces without one lie between them and the border", &close),
        ] {
            if !omitted.faces.is_empty() {
                let faces = counted(omitted.faces.len(), "face has", "faces have");
                let problem = format!("{faces} no second layer: {problem}");
                let warning =
                    Warning::new(codes::BARE_FACES, &label, problem).at(cage.input_points(omitted.at.iter().copied()));
                warnings.push(warning.remedy(remedy));
            }
        }
        warnings
    }

    fn no_border(&self, garment: &Mesh) -> Error {
        let (label, faces) = (self.label(), self.options.faces.join(", "));
        let fault = format!("{faces} is not next to a border of {}, and cannot be folded", garment.prim);
        Error::recipe(format!("{label}.faces"), fault)
            .code(codes::NO_BORDER)
            .remedy(format!("name a face subset at a border, or set {label}.closed"))
    }

    fn sign(&self) -> f32 {
        if self.options.side == Side::Outer { 1.0 } else { -1.0 }
    }

    /// The painted weights on the limit surface.
    fn weights(&self, cage: &OperatorInput) -> Option<Vec<f32>> {
        let painted = weights_named(cage.garment, &self.options.weights)?;
        let Values::F32(values) = &painted.values else { return None };
        let values: Vec<[f32; 1]> = (0..cage.garment.points.len()).map(|v| [values[painted.row(v)]]).collect();
        Some((&cage.level.limit_rows()).apply(&values).into_iter().flatten().collect())
    }

    fn weight(&self, weights: Option<&[f32]>, sources: &[(VertexId, f32)]) -> f32 {
        weights.map_or(1.0, |all| sources.iter().map(|&(v, w)| w * all[v.index()]).sum::<f32>()).max(MIN_WEIGHT)
    }

    fn controls(
        &self,
        (t, points): (&Topology, &IdVec<VertexId, Vec3>),
        weights: Option<&[f32]>,
        (folds, layer_ends, ends): (&IdVec<VertexId, bool>, &IdVec<VertexId, bool>, &Ends),
        layer: &Layer,
        lines: &Lines,
    ) -> Vec<(Control, f32)> {
        let on_cage = lines.near.enumerated().filter(|(v, near)| **near || layer_ends[*v]).map(|(v, _)| v);
        let on_surface = |vertex: VertexId, is_fold: bool| {
            let role = if is_fold { ControlRole::Kept } else { ControlRole::Surface };
            (Control { vertex, role }, 0.0)
        };
        let mut controls: Vec<(Control, f32)> = on_cage.map(|v| on_surface(v, folds[v])).collect();
        controls.extend(lines.vertices.iter().map(|l| on_surface(l.vertex, l.line.is_none())));
        let copy_of = |of: VertexId, vertex: VertexId, weight: f32, closing: LayerEnd| {
            (Control { vertex, role: ControlRole::Copy { of, side: self.sign(), closing } }, weight)
        };
        let ends_of = |l: &&LineVertex| t.edges[l.mark].iter().any(|&v| ends.joined[v]);
        let beside: BTreeSet<VertexId> = lines.vertices.iter().filter(ends_of).map(|l| l.vertex).collect();
        let copies = layer.copy.iter().enumerate().filter_map(|(v, copy)| Some((VertexId::new(v), (*copy)?)));
        let tapers = ends.tapers(points, TAPER_LENGTH * self.options.thickness);
        controls.extend(copies.filter(|(over, copy)| over != copy).map(|(over, vertex)| {
            let sources = lines.builder.sources(over);
            let is_closed = sources.iter().all(|(v, _)| ends.closed[*v]);
            let is_turn = sources.iter().all(|(v, _)| folds[*v]);
            let [turn, taper] = if is_turn { [self.options.turn.max(MIN_TURN), tapers(&sources)] } else { [1.0; 2] };
            let closing = match (is_closed || turn.min(taper) < TAPERED, beside.contains(&over)) {
                (true, _) => LayerEnd::Closed,
                (_, true) => LayerEnd::Beside,
                _ => LayerEnd::Open,
            };
            let weight = if is_closed { CLOSED_WEIGHT } else { turn * taper * self.weight(weights, &sources) };
            copy_of(over, vertex, weight.max(MIN_WEIGHT), closing)
        }));
        // After the copies that they are below, which take the clearance.
        let feet = layer.feet.iter();
        controls.extend(feet.map(|&[over, vertex]| copy_of(over, vertex, CLOSED_WEIGHT, LayerEnd::Closed)));
        controls
    }

    /// The provisional offsets of the copies.
    fn offsets(&self, cage: &OperatorInput, controls: &[(Control, f32)], lines: &Lines) -> Vec<(VertexId, Vec3)> {
        let normals = super::limit::vertex_normals(cage.garment, &cage.garment.points);
        let offset = |(control, weight): &(Control, f32)| {
            let normal: Vec3 =
                lines.builder.sources(control.role.original()?).iter().map(|&(v, w)| w * normals[v]).sum();
            Some((control.vertex, self.sign() * self.options.thickness * weight * normal.normalize_or_zero()))
        };
        controls.iter().filter_map(offset).collect()
    }

    fn subsets(&self, cage: &OperatorInput, layer: &Layer) -> (Vec<Subset>, Warnings) {
        if !cage.names_sets {
            return (Vec::new(), Warnings::default());
        }
        let set = |(suffix, faces): (&str, &Vec<FaceId>)| (format!("{}_{suffix}", self.name), faces.clone());
        let sets = [("hem", &layer.hem), ("inner", &layer.inner)].map(set);
        super::new_sets(cage.garment, sets.into())
    }
}

/// The half-edges of the chosen faces along the border of the mesh.
fn border<'a>(t: &'a Topology, chosen: &'a IdVec<FaceId, bool>) -> impl Iterator<Item = CornerId> + 'a {
    t.faces.corners().ids().filter(|&c| t.is_border(t.corner_edge[c]) && chosen[t.faces.face_of(c)])
}

/// Infinitely sharp vertices and edges: sharp corners of single faces stay sharp on both layers, with a crease between
/// them, and a fold that ends along a border has a corner there.
fn sharpness(
    level: &Level,
    folds: &IdVec<VertexId, bool>,
    marked: &IdVec<EdgeId, bool>,
    layer: &Layer,
) -> (Vec<VertexId>, Vec<[VertexId; 2]>) {
    let t = &level.topology;
    let (mut corners, mut creases) = (Vec::new(), Vec::new());
    for vertex in folds.ids().filter(|&v| folds[v]) {
        let Some(copy) = layer.copy[vertex.index()] else { continue };
        let around = t.vertex_corners.row(vertex).iter().flat_map(|&c| [c, t.faces.prev(c)]);
        let ends_here = around.map(|c| t.corner_edge[c]).any(|e| t.is_border(e) && !marked[e]);
        if is_lone_corner(level, vertex) {
            corners.push(copy);
            creases.push([vertex, copy]);
        } else if ends_here {
            corners.extend([vertex, copy]);
        }
    }
    (corners, creases)
}

/// The weight of each control, 0 on the surface.
fn weights(output: &OperatorOutput) -> &[f32] {
    output.details.downcast_ref::<Vec<f32>>().map_or(&[], Vec::as_slice)
}

impl Operator for Fold {
    fn label(&self) -> String {
        format!("fold.{}", self.name)
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    fn reach(&self, garment: &Mesh) -> f32 {
        let most = match garment.primvar(&self.options.weights).map(|painted| &painted.values) {
            Some(Values::F32(weights)) => weights.iter().copied().fold(0.0, f32::max),
            _ => 1.0,
        };
        self.options.thickness.abs() * self.options.turn.max(1.0) * most.max(MIN_WEIGHT)
    }

    fn folded_sets(&self) -> Vec<String> {
        self.options.faces.clone()
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        super::refuse_loop(cage, &self.label())?;
        let (garment, t) = (cage.garment, &cage.level.topology);
        let asked = self.chosen(garment);
        if !self.options.closed && border(t, &asked).next().is_none() {
            return Err(self.no_border(garment));
        }
        let weights = self.weights(cage);
        let weights = weights.as_deref();
        let side = usize::from(self.sign() > 0.0);
        let clearance =
            |v: VertexId| cage.clearance[v][side] / (self.options.thickness * self.weight(weights, &[(v, 1.0)]));
        let cover = Cover::new(t, &asked, self.options.closed, clearance);
        let mut warnings = self.warn(cage, &cover);
        let chosen = cover.chosen;
        let border: Vec<CornerId> = border(t, &chosen).collect();
        let mut marked = IdVec::filled(false, t.edges.len());
        let mut folds = IdVec::filled(false, t.vertex_count());
        for &half in &border {
            marked[t.corner_edge[half]] = true;
            t.faces.half_edge(half).iter().for_each(|&v| folds[v] = true);
        }
        let square = square_edges(garment, cage.level, &chosen);
        let length = CLOSED_LENGTH * self.options.thickness;
        let ends = Ends::new(t, &garment.points, &chosen, [&marked, &square], length);
        let request = LineRequest {
            topology: t,
            points: &garment.points,
            // The line of a hem is near the border, where a line that is nearer still makes its layer cross itself.
            on_surface: &garment.points,
            marked,
            distance: IdVec::filled(SUPPORT_DISTANCE * self.options.thickness, t.faces.corners().len()),
            tapers: IdVec::filled(false, t.vertex_count()),
            ends: ends.joined.clone(),
            flat: IdVec::filled(false, t.vertex_count()),
            taper_length: IdVec::filled(TAPER_LENGTH * self.options.thickness, t.edges.len()),
            round: IdVec::filled(false, t.vertex_count()),
            cuttable: chosen.clone(),
            shares: &[1.0],
            kept_line: 0,
            is_even: false,
        };
        // A closer support loop is harmless, so `lines.narrowed` gives no warning.
        let mut lines = lines::insert(&request);
        let mut layer = Layer::new(t, &chosen, &ends, &mut lines);
        layer.add_hem(t, &border, &mut lines);
        layer.add_walls(t, &chosen, &ends, &mut lines);
        layer.add_edges(t, &chosen, &folds, &mut lines);
        let controls =
            self.controls((t, &garment.points), weights, (&folds, &layer_ends(t, &chosen), &ends), &layer, &lines);
        let offsets = self.offsets(cage, &controls, &lines);
        let (subsets, renamed) = self.subsets(cage, &layer);
        warnings.extend(renamed);
        let (controls, weights): (Vec<Control>, Vec<f32>) = controls.into_iter().unzip();
        let details = Arc::new(weights);
        let (mut corners, mut creases) = sharpness(cage.level, &folds, &request.marked, &layer);
        creases.extend_from_slice(&layer.wall_edges);
        corners.extend(ends.corners.iter().filter_map(|v| layer.copy[v.index()]));
        let output = OperatorOutput::new(lines.builder.finish(), cage);
        Ok(OperatorOutput { controls, details, subsets, corners, creases, offsets, warnings, ..output })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        weights(output).iter().map(|weight| self.sign() * self.options.thickness * weight).collect()
    }

    fn reduced(&self, output: &OperatorOutput, given: &[f32]) -> Warnings {
        let mut warnings = Warnings::default();
        let mut thin: Vec<VertexId> = Vec::new();
        let mut least = 1.0f32;
        let index = output.index(|role| role.original().is_none());
        for ((control, own), weight) in output.controls.iter().zip(given).zip(weights(output)) {
            let Some(over) = control.role.original() else { continue };
            let apart = index[over].map_or(0.0, |original| given[original]) - own;
            let share = apart.abs() / (self.options.thickness * weight);
            if share < REPORTED {
                thin.push(over);
                least = least.min(share);
            }
        }
        if !thin.is_empty() {
            let (at, left) = (counted(thin.len(), "vertex", "vertices"), 100.0 * least);
            let problem = format!("thinner than asked at {at}, down to {left:.0} %, to clear itself or other cloth");
            let warning = Warning::new(codes::THIN_LAYER, self.label(), problem).at(output.input_points(thin));
            warnings.push(
                warning
                    .amount(least)
                    .remedy(format!("Lower `{}.thickness`, or paint lower weights there", self.label())),
            );
        }
        warnings
    }
}
