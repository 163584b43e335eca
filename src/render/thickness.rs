//! Thickness: face sets beside a border, folded over into a second layer.
//!
//! ```text
//!   outer   --o-------o---v           v  border, now the fold       o  line that holds the fold
//!                         | hem       v' its copy
//!   inner   --o'------o'--v'          the layers are amount × weight apart, and wound as one
//!                                        closed surface: away from each other, on the outer side to each other
//! ```

mod cover;

use super::REPORTED;
use super::kind::{Context, Instance, Key, Options};
use super::lines::{self, Lines, Request};
use super::placed::Room;
use super::shape::{Held, Operator, Role, Shape, is_lone_corner};
use crate::checks;
use crate::error::{Bare, Error, Warning, Warnings};
use crate::garment::{Elements, Garment, Orientation, Subset, Values};
use crate::mesh::{CornerId, Csr, EdgeId, FaceId, IdVec, Topology, VertexId};
use crate::subdivide::{Cage, Stencils};
use cover::{Cover, layer_ends};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Distance of the line that holds the fold from it, as a share of the amount. Smaller makes the fold tighter.
const HOLD: f32 = 1.0;
/// Amount of a thickness that says none, as a share of the mean edge.
const AUTOMATIC_AMOUNT: f32 = 0.1;
/// Least weight, so that the layers stay apart where it is painted 0.
const LEAST_WEIGHT: f32 = 0.01;

/// On which side of the surface the second layer is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Side {
    /// Behind it.
    #[default]
    Inner,
    /// Before it.
    Outer,
}

/// Options of a thickness: the attributes of `TailorThicknessAPI`, with the same names and defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct ThicknessOptions {
    /// Names of the face subsets that get a second layer, as one piece.
    pub faces: Vec<String>,
    /// Distance of the layers; 0: a tenth of the input's mean edge. \[stage units\]
    pub amount: f32,
    /// Painted float primvar that scales the amount; empty: 1 everywhere.
    pub weights: String,
    /// The side of the second layer.
    pub side: Side,
    /// Whether faces without a border get a second layer too.
    pub closed: bool,
}

impl Options for ThicknessOptions {
    const KIND: &'static str = "thickness";
    const KEYS: &'static [Key] = &[
        Key { field: "faces", unit: "names", meaning: "face subsets that are folded over at their border" },
        Key { field: "amount", unit: "stage units", meaning: "distance of the layers; 0: a tenth of the mean edge" },
        Key { field: "weights", unit: "name", meaning: "painted float primvar that scales the amount; empty: 1" },
        Key { field: "side", unit: "inner or outer", meaning: "the side of the second layer" },
        Key {
            field: "closed",
            unit: "true or false",
            meaning: "whether faces without a border get a second layer too",
        },
    ];
}

impl Instance for ThicknessOptions {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), Error> {
        checks::named(&key("faces"), &self.faces, "face")?;
        checks::length(&key("amount"), self.amount)
    }

    fn bind(&self, key: &dyn Fn(&str) -> String, garment: &Garment) -> Result<(), Error> {
        checks::subsets_are(garment, &key("faces"), &self.faces, "face")?;
        checks::weights(garment, &key("weights"), &self.weights).map(|_| ())
    }

    fn settle(&mut self, mean_edge: f32) {
        if self.amount == 0.0 {
            self.amount = AUTOMATIC_AMOUNT * mean_edge;
        }
    }

    fn stack(&self, name: &str, context: Context, operators: &mut Vec<Box<dyn Operator>>) {
        operators.push(Box::new(Thickness::new(name.to_owned(), self.clone(), context)));
    }
}

/// One thickness.
pub struct Thickness {
    name: String,
    options: ThicknessOptions,
    /// Points of the input, whose numbers are the user's.
    own_points: usize,
    names_sets: bool,
}

/// The second layer while it is made.
struct Layer {
    /// The copy of each vertex that has one.
    copy: Vec<Option<VertexId>>,
    hem: Vec<FaceId>,
    inner: Vec<FaceId>,
}

impl Thickness {
    /// A thickness by name.
    pub fn new(name: String, options: ThicknessOptions, context: Context) -> Self {
        Self { name, options, own_points: context.points, names_sets: context.names_sets }
    }

    /// The faces that are folded over.
    fn chosen(&self, garment: &Garment) -> IdVec<FaceId, bool> {
        let mut chosen = IdVec::filled(false, garment.faces.len());
        for subset in self.options.faces.iter().filter_map(|name| garment.subset(name)) {
            if let Elements::Faces(faces) = &subset.elements {
                faces.iter().for_each(|&f| chosen[f] = true);
            }
        }
        chosen
    }

    /// What is said of faces that get no second layer.
    fn warn(&self, cover: &Cover) -> Warnings {
        let mut warnings = Warnings::default();
        for (left, why) in [(&cover.turned, Bare::Turned), (&cover.tight, Bare::NoRoom), (&cover.cut_off, Bare::CutOff)]
        {
            if !left.faces.is_empty() {
                let (count, examples) = (left.faces.len(), super::examples(self.own_points, left.at.iter().copied()));
                warnings.push(Warning::BareFaces { thickness: self.name.clone(), count, examples, why });
            }
        }
        warnings
    }

    fn no_border(&self, garment: &Garment) -> Error {
        let (prim, name, faces) = (&garment.prim, &self.name, self.options.faces.join(", "));
        Error::Recipe(format!(
            "{prim}: thickness.{name}.faces names {faces}, which is not next to a border of the mesh, so that there is \
             nothing to fold over\n  hint: name a face subset at a border, or set thickness.{name}.closed"
        ))
    }

    fn sign(&self) -> f32 {
        if self.options.side == Side::Outer { 1.0 } else { -1.0 }
    }

    fn copy_faces(&self, t: &Topology, chosen: &IdVec<FaceId, bool>, lines: &mut Lines) -> Layer {
        let mut layer = Layer { copy: vec![None; lines.builder.vertex_count()], hem: Vec::new(), inner: Vec::new() };
        for face in t.faces.ids().filter(|&f| chosen[f]) {
            for child in lines.first_child[face.index()]..lines.first_child[face.index() + 1] {
                let corners = lines.builder.corners_of(child);
                let mut copied: Vec<VertexId> = Vec::with_capacity(corners.len());
                for &corner in &corners {
                    copied.push(copy_of(&mut layer.copy, corner, lines));
                }
                // The other way around, from the same corner on.
                copied[1..].reverse();
                layer.inner.push(lines.builder.face(face, &copied));
            }
        }
        layer
    }

    /// The strip between the border and its copy.
    fn add_hem(&self, t: &Topology, border: &[CornerId], layer: &mut Layer, lines: &mut Lines) {
        for &half in border {
            let [a, b] = t.faces.half_edge(half);
            let [copy_a, copy_b] = [a, b].map(|v| copy_of(&mut layer.copy, v, lines));
            layer.hem.push(lines.builder.face(t.faces.face_of(half), &[b, a, copy_a, copy_b]));
        }
    }

    /// Edges go on around the fold and back along the second layer.
    fn add_edges(
        &self,
        t: &Topology,
        chosen: &IdVec<FaceId, bool>,
        folds: &IdVec<VertexId, bool>,
        layer: &Layer,
        lines: &mut Lines,
    ) {
        let children: Csr<EdgeId, [VertexId; 2]> = lines.builder.edges();
        let copy = |v: VertexId| layer.copy[v.index()].unwrap_or(v);
        for edge in t.edges.ids() {
            let mut faces = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c));
            if !faces.any(|f| chosen[f]) {
                continue;
            }
            let ([a, b], inner) = (t.edges[edge], !t.is_border(edge));
            if inner && folds[b] {
                lines.builder.edge(edge, [b, copy(b)]);
            }
            for &[from, to] in children.row(edge).iter().rev() {
                lines.builder.edge(edge, [copy(to), copy(from)]);
            }
            if inner && folds[a] {
                lines.builder.edge(edge, [copy(a), a]);
            }
        }
    }

    /// The painted weights in the limit, where the surface is.
    fn weights(&self, cage: &Cage) -> Option<Vec<f32>> {
        let painted = cage.garment().primvar(&self.options.weights)?;
        let Values::F32(values) = &painted.values else { return None };
        let values: Vec<[f32; 1]> = (0..cage.garment().points.len()).map(|v| [values[painted.row(v)]]).collect();
        Some((&cage.level().limit_rows()).apply(&values).into_iter().flatten().collect())
    }

    fn weight(&self, weights: Option<&[f32]>, sources: &[(VertexId, f32)]) -> f32 {
        let weight = weights.map_or(1.0, |all| sources.iter().map(|&(v, w)| w * all[v.index()]).sum());
        weight.max(LEAST_WEIGHT)
    }

    fn held(
        &self,
        weights: Option<&[f32]>,
        (folds, ends): (&IdVec<VertexId, bool>, &IdVec<VertexId, bool>),
        layer: &Layer,
        lines: &Lines,
    ) -> Vec<Held> {
        let near = lines.near.enumerated().filter(|(v, near)| **near || ends[*v]).map(|(v, _)| v);
        let on_surface = |vertex: VertexId| {
            let is_fold = folds.contains_id(vertex) && folds[vertex];
            Held { vertex, role: if is_fold { Role::Fold } else { Role::Surface } }
        };
        let mut held: Vec<Held> = near.map(on_surface).collect();
        held.extend(lines.vertices.iter().map(|l| on_surface(l.vertex)));
        let copies = layer.copy.iter().enumerate().filter_map(|(v, copy)| Some((VertexId::new(v), (*copy)?)));
        held.extend(copies.map(|(over, vertex)| {
            let weight = self.weight(weights, &lines.builder.sources(over));
            Held { vertex, role: Role::Layer { over, weight, side: self.sign() } }
        }));
        held
    }

    /// Where the copies are until their surface is fitted.
    fn apart(&self, cage: &Cage, held: &[Held], lines: &Lines) -> Vec<(VertexId, Vec3)> {
        let normals = vertex_normals(cage);
        let offset = |h: &Held| {
            let Role::Layer { over, weight, .. } = h.role else { return None };
            let normal: Vec3 = lines.builder.sources(over).iter().map(|&(v, w)| w * normals[v]).sum();
            Some((h.vertex, self.sign() * self.options.amount * weight * normal.normalize_or_zero()))
        };
        held.iter().filter_map(offset).collect()
    }

    fn subsets(&self, garment: &Garment, layer: &Layer, warnings: &mut Warnings) -> Vec<Subset> {
        if !self.names_sets {
            return Vec::new();
        }
        let set = |(end, faces): (&str, &Vec<FaceId>)| (format!("{}_{end}", self.name), faces.clone());
        let sets = [("hem", &layer.hem), ("inner", &layer.inner)].map(set);
        super::new_sets(garment, sets.into(), warnings)
    }
}

/// The half-edges of chosen faces along the border of the mesh.
fn border<'a>(t: &'a Topology, chosen: &'a IdVec<FaceId, bool>) -> impl Iterator<Item = CornerId> + 'a {
    t.faces.corners().ids().filter(|&c| t.is_border(t.corner_edge[c]) && chosen[t.faces.face_of(c)])
}

/// The copy of a vertex, made when it is first asked for.
fn copy_of(copies: &mut [Option<VertexId>], vertex: VertexId, lines: &mut Lines) -> VertexId {
    *copies[vertex.index()].get_or_insert_with(|| {
        let sources = lines.builder.sources(vertex);
        lines.builder.vertex(&sources)
    })
}

/// What becomes sharp: the corners of single faces are corners of both layers with an edge between, and where the fold
/// ends along a border the border turns aside.
fn sharpness(
    cage: &Cage,
    folds: &IdVec<VertexId, bool>,
    marked: &IdVec<EdgeId, bool>,
    layer: &Layer,
) -> (Vec<VertexId>, Vec<[VertexId; 2]>) {
    let t = &cage.level().topology;
    let (mut corners, mut creases) = (Vec::new(), Vec::new());
    for vertex in folds.ids().filter(|&v| folds[v]) {
        let Some(copy) = layer.copy[vertex.index()] else { continue };
        let around = t.vertex_corners.row(vertex).iter().flat_map(|&c| [c, t.faces.prev(c)]);
        let goes_on = around.map(|c| t.corner_edge[c]).any(|e| t.is_border(e) && !marked[e]);
        if is_lone_corner(cage, vertex) {
            corners.push(copy);
            creases.push([vertex, copy]);
        } else if goes_on {
            corners.extend([vertex, copy]);
        }
    }
    (corners, creases)
}

/// Normals of a cage, to the front.
fn vertex_normals(cage: &Cage) -> IdVec<VertexId, Vec3> {
    let (garment, faces) = (cage.garment(), &cage.level().topology.faces);
    let sign = if garment.orientation == Orientation::LeftHanded { -1.0 } else { 1.0 };
    let mut normals = IdVec::filled(Vec3::ZERO, garment.points.len());
    for corner in faces.corners().ids() {
        let [here, next, prev] = [corner, faces.next(corner), faces.prev(corner)].map(|c| faces.vertex(c));
        let at = garment.points[here];
        normals[here] += sign * (garment.points[next] - at).cross(garment.points[prev] - at);
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    normals
}

impl Operator for Thickness {
    fn structure(&self) -> String {
        format!("thickness {:?} {:?} {}", self.name, self.options, self.names_sets)
    }

    fn reach(&self, garment: &Garment) -> f32 {
        let most = match garment.primvar(&self.options.weights).map(|painted| &painted.values) {
            Some(Values::F32(weights)) => weights.iter().copied().fold(0.0, f32::max),
            _ => 1.0,
        };
        self.options.amount.abs() * most.max(LEAST_WEIGHT)
    }

    fn options(&self) -> String {
        self.structure()
    }

    fn shape(&self, cage: &Cage, clearance: &IdVec<VertexId, Room>) -> Result<Shape, Error> {
        super::refuse_loop(cage, &format!("thickness.{}", self.name))?;
        let (garment, t) = (cage.garment(), &cage.level().topology);
        let chosen = self.chosen(garment);
        if !self.options.closed && border(t, &chosen).next().is_none() {
            return Err(self.no_border(garment));
        }
        let weights = self.weights(cage);
        let weights = weights.as_deref();
        let side = usize::from(self.sign() > 0.0);
        let room = |v: VertexId| clearance[v][side] / (self.options.amount * self.weight(weights, &[(v, 1.0)]));
        let cover = Cover::new(t, &chosen, self.options.closed, room);
        let mut warnings = self.warn(&cover);
        let chosen = cover.chosen;
        let border: Vec<CornerId> = border(t, &chosen).collect();
        let mut marked = IdVec::filled(false, t.edges.len());
        let mut folds = IdVec::filled(false, t.vertex_count());
        for &half in &border {
            marked[t.corner_edge[half]] = true;
            t.faces.half_edge(half).iter().for_each(|&v| folds[v] = true);
        }
        let request = Request {
            topology: t,
            points: &garment.points,
            marked,
            distance: IdVec::filled(HOLD * self.options.amount, t.faces.corners().len()),
            tapers: IdVec::filled(false, t.vertex_count()),
            cuttable: chosen.clone(),
            shares: &[1.0],
            kept_line: 0,
        };
        // The line that holds the fold may be nearer to it than asked without harm.
        let mut lines = lines::insert(&request);
        let mut layer = self.copy_faces(t, &chosen, &mut lines);
        self.add_hem(t, &border, &mut layer, &mut lines);
        self.add_edges(t, &chosen, &folds, &layer, &mut lines);
        let held = self.held(weights, (&folds, &layer_ends(t, &chosen)), &layer, &lines);
        let apart = self.apart(cage, &held, &lines);
        let subsets = self.subsets(garment, &layer, &mut warnings);
        let (corners, creases) = sharpness(cage, &folds, &request.marked, &layer);
        Ok(Shape { derivation: lines.builder.finish(), held, subsets, corners, creases, apart, warnings })
    }

    fn heights(&self, shape: &Shape) -> Vec<f32> {
        let of = |held: &Held| match held.role {
            Role::Layer { weight, .. } => self.sign() * self.options.amount * weight,
            _ => 0.0,
        };
        shape.held.iter().map(of).collect()
    }

    fn unsound(&self, shape: &Shape, faces: &[FaceId]) -> Warning {
        let examples = super::examples(self.own_points, shape.sources(faces));
        Warning::Unsound { operator: format!("thickness.{}", self.name), count: faces.len(), examples }
    }

    fn reduced(&self, shape: &Shape, given: &[f32]) -> Warnings {
        let mut warnings = Warnings::default();
        let mut thin: Vec<VertexId> = Vec::new();
        let mut least = 1.0f32;
        for (held, given) in shape.held.iter().zip(given) {
            let Role::Layer { over, weight, .. } = held.role else { continue };
            let share = given.abs() / (self.options.amount * weight);
            if share < REPORTED {
                thin.push(over);
                least = least.min(share);
            }
        }
        if !thin.is_empty() {
            let examples = super::examples(self.own_points, thin.iter().copied());
            warnings.push(Warning::ThinLayer { thickness: self.name.clone(), count: thin.len(), examples, least });
        }
        warnings
    }
}
