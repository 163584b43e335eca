//! Seams: grooves or ridges along edge sets.
//!
//! ```text
//!                     left                           height along the normal
//!  hold | width | flank | flank | centre | flank …
//!    o------o-------o-------o-------*-------o------  * = normalOffset, straight to 0 at the width; the first line
//!                                                    of the flank is higher by the depth
//! ```
//!
//! The centre has a height, and so has the first line beside it. The lines are evenly spaced up to a support loop (`hold`)
//! outside the width. By the masks of Catmull-Clark, the limits of evenly spaced lines are on the lines, so the surface
//! outside the width keeps its shape. Every seam has the same lines, so an edit of one moves nothing of the others.
//!
//! Consecutive seams of the stack form one network: they intersect, meet and share clearance as equals. Left is the
//! left-hand side of a walker along the chain with the normals up. The direction of a chain is that of most of its
//! authored edges.

mod chains;
mod heights;
mod room;

use super::lines::{self, LineVertex, Lines, Narrowed, Request};
use super::operator::{Control, Operator, OperatorInput, OperatorOutput, REPORTED, Role, Strand};
use super::options::{Domain, Key, OperatorOptions};
use crate::checks;
use crate::error::{Code, Error, Warning, Warnings};
use crate::garment::units::deserialize_length;
use crate::garment::{Elements, Garment, Orientation, Subset};
use crate::mesh::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use chains::Network;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Automatic width, as a share of the mean edge.
const AUTOMATIC_WIDTH: f32 = 0.25;
/// Smallest share of the width on one side. At full asymmetry it separates the lines and keeps the steep flank from
/// flipping.
const MIN_SIDE_SHARE: f32 = 0.05;

/// Options of a seam: the attributes of `TailorSeamAPI`, with the same names and defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct SeamOptions {
    /// False to leave the seam out and keep its options.
    pub enabled: bool,
    /// Names of the edge subsets of the seam.
    pub edges: Vec<String>,
    /// Width from side to side; 0: a quarter of the mean edge of the input. \[mesh units\]
    #[serde(deserialize_with = "deserialize_length")]
    pub width: f32,
    /// Height of the flanks over straight ones, along the normal: above 0 rounded, below 0 hollow. \[mesh units\]
    #[serde(deserialize_with = "deserialize_length")]
    pub depth: f32,
    /// Height of the centre along the normal: below 0 a groove, above 0 a ridge. \[mesh units\]
    #[serde(deserialize_with = "deserialize_length")]
    pub normal_offset: f32,
    /// Distribution of the width: -1 left, 0 even, 1 right. At least a twentieth stays on each side.
    pub asymmetry: f32,
}

impl Default for SeamOptions {
    fn default() -> Self {
        Self { enabled: true, edges: Vec::new(), width: 0.0, depth: 0.0, normal_offset: 0.0, asymmetry: 0.0 }
    }
}

impl SeamOptions {
    /// Widths of the left and right side. \[mesh units\]
    fn side_widths(&self) -> [f32; 2] {
        let left = (0.5 * (1.0 - self.asymmetry)).clamp(MIN_SIDE_SHARE, 1.0 - MIN_SIDE_SHARE);
        [self.width * left, self.width * (1.0 - left)]
    }
}

impl OperatorOptions for SeamOptions {
    fn kind(&self) -> &'static str {
        "seam"
    }

    fn keys(&self) -> &'static [Key] {
        &[
            Key { key: "enabled", unit: "true or false", domain: Domain::Flag, meaning: "whether the seam is made" },
            Key { key: "edges", unit: "names", domain: Domain::EdgeSets, meaning: "edge subsets of the seam" },
            Key {
                key: "width",
                unit: "mesh units",
                domain: Domain::Length { least: 0.0, most: 1.0, automatic: AUTOMATIC_WIDTH },
                meaning: "from side to side; 0: a quarter of the mean edge",
            },
            Key {
                key: "depth",
                unit: "mesh units",
                domain: Domain::Length { least: -0.2, most: 0.2, automatic: 0.0 },
                meaning: "height of the flanks over straight ones",
            },
            Key {
                key: "normalOffset",
                unit: "mesh units",
                domain: Domain::Length { least: -0.2, most: 0.2, automatic: 0.0 },
                meaning: "height of the centre; below 0 a groove, above a ridge",
            },
            Key {
                key: "asymmetry",
                unit: "-1 to 1",
                domain: Domain::Number { least: -1.0, most: 1.0, step: 0.05 },
                meaning: "-1: most of the width on the left, 1: on the right",
            },
        ]
    }

    fn is_enabled(&self) -> bool {
        self.enabled
    }

    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), Error> {
        checks::named(&key("edges"), &self.edges, "edge")?;
        checks::length(&key("width"), self.width)?;
        checks::finite(&key("depth"), self.depth)?;
        checks::finite(&key("normalOffset"), self.normal_offset)?;
        if !(-1.0..=1.0).contains(&self.asymmetry) {
            let fault = Error::recipe(key("asymmetry"), format!("{} is not between -1 and 1", self.asymmetry));
            return Err(fault.remedy("give -1 for most of the width on the left, 1 for most on the right"));
        }
        Ok(())
    }

    fn bind(&self, key: &dyn Fn(&str) -> String, garment: &Garment) -> Result<(), Error> {
        for (field, value) in [("width", self.width), ("depth", self.depth), ("normalOffset", self.normal_offset)] {
            checks::within_size(&key(field), value, garment)?;
        }
        checks::subsets_are(garment, &key("edges"), &self.edges, "edge")
    }

    fn resolve_lengths(&mut self, mean_edge: f32) {
        if self.width == 0.0 {
            self.width = AUTOMATIC_WIDTH * mean_edge;
        }
    }

    fn operator(&self, name: &str) -> Arc<dyn Operator> {
        Arc::new(Seams { seams: vec![(name.to_owned(), self.clone())] })
    }

    /// Consecutive seams are one operator.
    fn joined(&self, name: &str, before: &dyn Operator) -> Option<Arc<dyn Operator>> {
        let before = (before as &dyn Any).downcast_ref::<Seams>()?;
        let seams = before.seams.iter().cloned().chain([(name.to_owned(), self.clone())]);
        Some(Arc::new(Seams { seams: seams.collect() }))
    }
}

/// Consecutive seams of the stack, with their names.
#[derive(Clone, Debug, PartialEq)]
struct Seams {
    seams: Vec<(String, SeamOptions)>,
}

impl Seams {
    /// The edges of a seam on the cage, in their authored direction.
    fn edges(garment: &Garment, options: &SeamOptions) -> Vec<[VertexId; 2]> {
        let sets = options.edges.iter().filter_map(|name| garment.subset(name));
        let edges = sets.filter_map(|set| if let Elements::Edges(edges) = &set.elements { Some(edges) } else { None });
        edges.flatten().copied().collect()
    }

    fn warn(&self, cage: &OperatorInput, network: &Network, narrowed: &[Narrowed]) -> Warnings {
        let mut warnings = Warnings::default();
        for (number, (name, _)) in self.seams.iter().enumerate() {
            let label = format!("seam.{name}");
            let edges = |code: Code, edges: Vec<EdgeId>, problem: &str, remedy: &str| {
                let ends = cage.input_edges(edges.iter().map(|&e| network.ends(e)));
                let warning = Warning::new(code, &label, format!("{} edges {problem}", ends.len()));
                (!edges.is_empty()).then(|| warning.at(ends).remedy(remedy))
            };
            let shared = network.shared.iter().filter(|s| s.1 == number).map(|s| s.0).collect();
            let problem = "already belong to an earlier seam, which keeps them";
            warnings.extend(edges(Code::SharedSeamEdges, shared, problem, "Remove them from one of the two edge sets"));
            let here = || narrowed.iter().filter(|n| network.seam[n.mark] == Some(number));
            let narrow: BTreeSet<VertexId> = here().map(|n| n.vertex).collect();
            if !narrow.is_empty() {
                let least = here().map(|n| n.share).fold(1.0, f32::min);
                let (count, left) = (narrow.len(), 100.0 * least);
                let problem =
                    format!("narrower than asked at {count} vertices, down to {left:.0} % of width and height");
                let points = cage.input_points(narrow);
                let remedy = format!("Lower `{label}.width`, or lengthen the edges that lead away from it");
                warnings.push(Warning::new(Code::NarrowSeam, label, problem).at(points).amount(least).remedy(remedy));
            }
        }
        warnings
    }

    fn controls(t: &Topology, network: &Network, lines: &Lines) -> Vec<Control> {
        // One ring more than the faces that are cut: its limit depends on the points that the fit moves.
        let near = |v: &VertexId| t.faces_at(*v).any(|f| t.faces.vertices_of(f).iter().any(|&v| lines.near[v]));
        let on_cage = lines.near.ids().filter(near).map(|vertex| {
            let seams = network.at(t, vertex);
            if seams.is_empty() {
                return Control { vertex, role: Role::Kept };
            }
            Control { vertex, role: Role::Centre { seams, share: lines.heights[vertex] } }
        });
        let on_lines = lines.vertices.iter().filter_map(|line| {
            let role = Self::line_role(t, network, line)?;
            Some(Control { vertex: line.vertex, role })
        });
        on_cage.chain(on_lines).collect()
    }

    fn line_role(t: &Topology, network: &Network, vertex: &LineVertex) -> Option<Role> {
        let (seam, share) = (network.seam[vertex.mark]?, vertex.height);
        let own = Strand { seam, line: vertex.line };
        let Some(crossing) = vertex.crossing else {
            return Some(match vertex.line {
                Some(line) => Role::Line { line, seam, share },
                None => Role::Centre { seams: vec![seam], share },
            });
        };
        let other = Strand { seam: network.seam[crossing.mark]?, line: Some(crossing.line) };
        let first = network.junction_of(t, vertex.mark, crossing.mark).and_then(|seams| seams.first().copied());
        let (through, other) =
            if seam != other.seam && first == Some(other.seam) { (other, own) } else { (own, other) };
        Some(Role::Crossing { through, other, share })
    }

    /// The faces within the width of each seam.
    fn subsets(&self, cage: &OperatorInput, network: &Network, lines: &Lines, warnings: &mut Warnings) -> Vec<Subset> {
        if !cage.names_sets {
            return Vec::new();
        }
        let width = Self::width_line();
        let of = |(number, (name, _)): (usize, &(String, SeamOptions))| {
            let within = lines.strips.iter().filter(|s| s.line <= width && network.seam[s.mark] == Some(number));
            (format!("{name}_seam"), within.map(|s| s.face).collect())
        };
        super::new_sets(cage.garment, self.seams.iter().enumerate().map(of).collect(), warnings)
    }

    /// The width of the seam beside each half-edge; 0 on other edges. \[mesh units\]
    fn distances(&self, cage: &OperatorInput, network: &Network) -> IdVec<CornerId, f32> {
        let t = &cage.level.topology;
        let is_left_handed = cage.garment.orientation == Orientation::LeftHanded;
        let distance = |corner: CornerId| {
            let edge = t.corner_edge[corner];
            let Some(seam) = network.seam[edge] else { return 0.0 };
            // A right-handed face is to the left of its half-edges.
            let is_left = (t.faces.vertex(corner) == network.start[edge]) != is_left_handed;
            self.seams[seam].1.side_widths()[usize::from(!is_left)]
        };
        t.corner_edge.ids().map(distance).collect()
    }
}

impl Operator for Seams {
    fn label(&self) -> String {
        let names: Vec<String> = self.seams.iter().map(|(name, _)| format!("seam.{name}")).collect();
        names.join(", ")
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    /// Heights move points alone.
    fn has_same_output(&self, other: &dyn Operator) -> bool {
        let flat = |(name, o): &(String, SeamOptions)| {
            (name.clone(), SeamOptions { depth: 0.0, normal_offset: 0.0, ..o.clone() })
        };
        let other = (other as &dyn Any).downcast_ref::<Self>();
        other.is_some_and(|other| self.seams.iter().map(flat).eq(other.seams.iter().map(flat)))
    }

    fn reach(&self, _: &Garment) -> f32 {
        self.seams.iter().map(|(_, o)| o.normal_offset.abs() + o.depth.abs()).fold(0.0, f32::max)
    }

    fn levels_with_room(&self, garment: &Garment, t: &Topology) -> Option<u32> {
        self.seams.iter().map(|(_, options)| room::levels(garment, t, options)).min()
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        super::refuse_loop(cage, &self.label())?;
        let edges = self.seams.iter().map(|(_, options)| Self::edges(cage.garment, options)).collect::<Vec<_>>();
        let t = &cage.level.topology;
        let network = Network::new(t, &edges);
        let request = Request {
            topology: t,
            points: &cage.garment.points,
            marked: network.seam.iter().map(Option::is_some).collect(),
            distance: self.distances(cage, &network),
            tapers: network.tapers.clone(),
            ends: IdVec::filled(false, t.vertex_count()),
            taper_length: network.seam.iter().map(|seam| seam.map_or(0.0, |seam| self.seams[seam].1.width)).collect(),
            cuttable: IdVec::filled(true, t.faces.len()),
            shares: Self::shares(),
            kept_line: Self::width_line(),
            is_even: true,
        };
        let lines = lines::insert(&request);
        let controls = Self::controls(t, &network, &lines);
        let mut warnings = self.warn(cage, &network, &lines.narrowed);
        let subsets = self.subsets(cage, &network, &lines, &mut warnings);
        Ok(OperatorOutput { controls, subsets, warnings, ..OperatorOutput::new(lines.builder.finish(), cage) })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        output.controls.iter().map(|control| self.height(&control.role).0).collect()
    }

    fn intersections(&self, output: &OperatorOutput, faces: &[FaceId]) -> Warning {
        let seams = seams_at(output, faces);
        let label: Vec<String> = seams.iter().map(|&i| format!("seam.{}", self.seams[i].0)).collect();
        super::operator::intersections(label.join(", "), output, faces)
    }

    fn reduced(&self, output: &OperatorOutput, given: &[f32]) -> Warnings {
        let mut warnings = Warnings::default();
        let mut shallow: Vec<(usize, VertexId, f32)> = Vec::new();
        for (control, given) in output.controls.iter().zip(given) {
            let (asked, seam) = self.height(&control.role);
            if control.role.is_centre() && given.abs() < REPORTED * asked.abs() {
                shallow.push((seam, control.vertex, given.abs() / asked.abs()));
            }
        }
        for (number, (name, _)) in self.seams.iter().enumerate() {
            let here = shallow.iter().filter(|s| s.0 == number);
            let (count, least) = (here.clone().count(), here.clone().map(|s| s.2).fold(1.0, f32::min));
            if count > 0 {
                let problem = format!(
                    "its normalOffset is reduced at {count} vertices, down to {:.0} %, to clear another layer",
                    100.0 * least
                );
                let warning = Warning::new(Code::ShallowSeam, format!("seam.{name}"), problem);
                let warning = warning.at(output.input_points(here.map(|s| s.1))).amount(least);
                let remedy = format!("Lower `seam.{name}.normalOffset`, or run thicknesses after the seam");
                warnings.push(warning.remedy(remedy));
            }
        }
        warnings
    }
}

/// Indices of the seams at some faces, or else of the nearest ones by a search over rings of faces.
fn seams_at(output: &OperatorOutput, faces: &[FaceId]) -> BTreeSet<usize> {
    let seams = |control: &Control| match &control.role {
        Role::Centre { seams, .. } => seams.clone(),
        Role::Line { seam, .. } => vec![*seam],
        Role::Crossing { through, other, .. } => vec![through.seam, other.seam],
        _ => Vec::new(),
    };
    let all = &output.derivation.faces;
    let mut near: BTreeSet<VertexId> = faces.iter().flat_map(|&f| all.vertices_of(f)).copied().collect();
    loop {
        let found: BTreeSet<usize> =
            output.controls.iter().filter(|c| near.contains(&c.vertex)).flat_map(seams).collect();
        let touches = |f: &FaceId| all.vertices_of(*f).iter().any(|v| near.contains(v));
        let wider: BTreeSet<VertexId> = all.ids().filter(touches).flat_map(|f| all.vertices_of(f)).copied().collect();
        if !found.is_empty() || wider.len() == near.len() {
            return found;
        }
        near = wider;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::UNBOUNDED;
    use crate::mesh::Faces;
    use crate::subdivide::{Derivation, Level};
    use glam::Vec3;

    #[test]
    fn intersections_name_the_nearest_seam() {
        // A strip of quads with a seam across it near each end.
        let (length, at) = (12, |x: usize, y: usize| VertexId::new(2 * x + y));
        let quads = (0..length).flat_map(|x| [at(x, 0), at(x + 1, 0), at(x + 1, 1), at(x, 1)]);
        let subset = |name: &str, x: usize| Subset {
            name: name.into(),
            family: String::new(),
            elements: Elements::Edges(vec![[at(x, 0), at(x, 1)]]),
            sharpness: None,
        };
        let points = (0..=length).flat_map(|x| [0.0, 1.0].map(|y| Vec3::new(x as f32, y, 0.0)));
        let garment = Garment {
            points: points.collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            subsets: vec![subset("first", 2), subset("second", 10)].into(),
            ..Garment::default()
        };
        let seam = |name: &str| {
            (name.to_owned(), SeamOptions { edges: vec![name.to_owned()], width: 0.3, ..SeamOptions::default() })
        };
        let seams = Seams { seams: vec![seam("first"), seam("second")] };
        let (inputs, level) = (Arc::new(garment.points.ids().collect::<IdVec<_, _>>()), Level::base(&garment));
        let clearance = &IdVec::filled(UNBOUNDED, inputs.len());
        let cage = OperatorInput { garment: &garment, level: &level, clearance, inputs: &inputs, names_sets: false };
        let output = seams.apply(&cage).expect("an output");
        let name = |face: FaceId| seams.intersections(&output, &[face]).place;
        let middle = |f: FaceId| {
            let parent = output.derivation.parent_face(f).index();
            (parent as f32 + 0.5) / length as f32
        };
        for face in output.derivation.faces.ids() {
            if middle(face) < 0.4 {
                assert_eq!(name(face), "seam.first");
            } else if middle(face) > 0.6 {
                assert_eq!(name(face), "seam.second");
            } else {
                assert!(!name(face).is_empty());
            }
        }
    }
}
