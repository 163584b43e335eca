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
//!
//! A seam may have rows at a distance from its edges (`rows`). They are made before the seams on edges, one operator for each
//! seam. A seam may be a crease, which has no lines (`creases`).

mod chains;
mod creases;
mod heights;
mod options;
mod profile;
mod reports;
mod room;
mod rows;

use super::lines::{self, LineRequest, LineVertex, Lines, NarrowVertex};
use super::operator::{Control, ControlRole, Operator, OperatorInput, OperatorOutput, REPORTED};
use super::options::OperatorOptions;
use crate::codes;
pub use chains::Network;
use creases::Creases;
use heights::{Part, SeamLine};
pub use options::{RowSide, SeamEnd, SeamOptions};
use reports::shallow_seam;
use rows::Rows;
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings, counted};
use tailor_mesh::garment::{Mesh, Orientation, Subset};

impl OperatorOptions for SeamOptions {
    fn is_enabled(&self) -> bool {
        self.enabled
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
    fn warn(&self, cage: &OperatorInput, network: &Network, narrowed: &[NarrowVertex]) -> Warnings {
        let mut warnings = Warnings::default();
        for (number, (name, _)) in self.seams.iter().enumerate() {
            let label = format!("seam.{name}");
            let shared = network.shared.iter().filter(|s| s.1 == number).map(|s| network.ends(s.0));
            let shared = cage.input_edges(shared);
            if !shared.is_empty() {
                let count = counted(shared.len(), "edge", "edges");
                let problem = format!("{count} in an earlier seam too, which keeps them");
                let warning = Warning::new(codes::SHARED_SEAM_EDGES, &label, problem).at(shared);
                warnings.push(warning.remedy("Remove them from one of the two edge sets"));
            }
            let here = || narrowed.iter().filter(|n| network.seam[n.mark] == Some(number));
            let narrow: BTreeSet<VertexId> = here().map(|n| n.vertex).collect();
            if !narrow.is_empty() {
                let least = here().map(|n| n.share).fold(1.0, f32::min);
                let (at, left) = (counted(narrow.len(), "vertex", "vertices"), 100.0 * least);
                let problem = format!("narrower than asked at {at}, down to {left:.0} % of width and height");
                let points = cage.input_points(narrow);
                let remedy = format!(
                    "Lower `{label}.width`, move rows of stitches away from it, or lengthen the edges that lead away"
                );
                warnings.push(Warning::new(codes::NARROW_SEAM, label, problem).at(points).amount(least).remedy(remedy));
            }
        }
        warnings
    }

    /// The controls, and the part of the profile that each of them has.
    fn controls(t: &Topology, network: &Network, lines: &Lines) -> (Vec<Control>, Vec<Option<Part>>) {
        // One ring more than the faces that are cut: its limit depends on the points that the fit moves.
        let near = |v: &VertexId| t.faces_at(*v).any(|f| t.faces.vertices_of(f).iter().any(|&v| lines.near[v]));
        let on_cage = lines.near.ids().filter(near).map(|vertex| {
            let seams = network.at(t, vertex);
            let part = (!seams.is_empty()).then(|| Part::Centre { seams, share: lines.heights[vertex] });
            let role = part.as_ref().map_or(ControlRole::Kept, Part::role);
            (Control { vertex, role }, part)
        });
        let on_lines = lines.vertices.iter().filter_map(|line| {
            let part = Self::line_part(t, network, line)?;
            Some((Control { vertex: line.vertex, role: part.role() }, Some(part)))
        });
        on_cage.chain(on_lines).unzip()
    }

    fn line_part(t: &Topology, network: &Network, vertex: &LineVertex) -> Option<Part> {
        let (seam, share) = (network.seam[vertex.mark]?, vertex.height);
        let own = SeamLine { seam, line: vertex.line };
        let Some(crossing) = vertex.crossing else {
            return Some(match vertex.line {
                Some(_) => Part::Line { strand: own, share },
                None => Part::Centre { seams: vec![seam], share },
            });
        };
        let other = SeamLine { seam: network.seam[crossing.mark]?, line: Some(crossing.line) };
        let first = network.junction_of(t, vertex.mark, crossing.mark).and_then(|seams| seams.first().copied());
        let (through, other) =
            if seam != other.seam && first == Some(other.seam) { (other, own) } else { (own, other) };
        Some(Part::Crossing { through, other, share })
    }

    /// The faces within the width of each seam.
    fn subsets(&self, cage: &OperatorInput, network: &Network, lines: &Lines) -> (Vec<Subset>, Warnings) {
        if !cage.names_sets {
            return (Vec::new(), Warnings::default());
        }
        let width = profile::WIDTH_LINE;
        let of = |(number, (name, _)): (usize, &(String, SeamOptions))| {
            let within = lines.strips.iter().filter(|s| s.line <= width && network.seam[s.mark] == Some(number));
            (format!("{name}_seam"), within.map(|s| s.face).collect())
        };
        super::new_sets(cage.garment, self.seams.iter().enumerate().map(of).collect())
    }

    /// True for vertices of edges on hems and inner layers, which cover seams that are not to go through.
    fn flat(&self, cage: &OperatorInput, network: &Network) -> IdVec<VertexId, bool> {
        let t = &cage.level.topology;
        let is_covered = |edge: &EdgeId| {
            network.seam[*edge].is_some_and(|seam| !self.seams[seam].1.through)
                && t.edge_corners.row(*edge).iter().all(|&c| cage.covers[t.faces.face_of(c)])
        };
        let mut flat = IdVec::filled(false, t.vertex_count());
        t.edges.ids().filter(is_covered).flat_map(|edge| t.edges[edge]).for_each(|v| flat[v] = true);
        flat
    }

    /// True for the ends of edges of seams whose profile leads around an end.
    fn round(&self, network: &Network) -> IdVec<VertexId, bool> {
        let mut round = IdVec::filled(false, network.tapers.len());
        let seams = network.seam.enumerated().filter_map(|(edge, seam)| Some((edge, (*seam)?)));
        let edges = seams.filter(|&(_, seam)| self.seams[seam].1.end == SeamEnd::Round).map(|(edge, _)| edge);
        edges.flat_map(|edge| network.ends(edge)).for_each(|vertex| round[vertex] = true);
        round
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
        label(&self.seams)
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    /// Heights move points alone.
    fn has_same_output(&self, other: &dyn Operator) -> bool {
        let other = (other as &dyn Any).downcast_ref::<Self>();
        other.is_some_and(|other| self.seams.iter().map(options::flat).eq(other.seams.iter().map(options::flat)))
    }

    /// The creases, the rows of each seam, then the seams on edges.
    fn parts(&self) -> Vec<Arc<dyn Operator>> {
        let (creases, others): (Vec<_>, Vec<_>) = self.seams.iter().cloned().partition(|(_, options)| options.crease);
        let of = |number: usize| Rows { seams: others.clone(), number };
        let with_rows = (0..others.len()).filter(|&i| !others[i].1.row_distances().is_empty());
        let mut parts: Vec<Arc<dyn Operator>> = with_rows.map(|i| Arc::new(of(i)) as Arc<dyn Operator>).collect();
        if !creases.is_empty() {
            parts.insert(0, Arc::new(Creases { seams: creases }));
        }
        let on_edges: Vec<_> = others.iter().filter(|(_, options)| options.offset == 0.0).cloned().collect();
        if !parts.is_empty() && !on_edges.is_empty() {
            parts.push(Arc::new(Self { seams: on_edges }));
        }
        parts
    }

    fn reach(&self, _: &Mesh) -> f32 {
        self.seams.iter().map(|(_, o)| o.normal_offset.abs() + o.depth.abs()).fold(0.0, f32::max)
    }

    fn levels_with_room(&self, garment: &Mesh, t: &Topology) -> Option<u32> {
        self.seams.iter().map(|(_, options)| room::levels(garment, t, options)).min()
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        super::refuse_loop(cage, &self.label())?;
        let edges = self.seams.iter().map(|(_, options)| options.edges_of(cage.garment)).collect::<Vec<_>>();
        let t = &cage.level.topology;
        let network = Network::new(t, &edges);
        let request = LineRequest {
            topology: t,
            points: &cage.garment.points,
            on_surface: &cage.on_surface(),
            marked: network.seam.iter().map(Option::is_some).collect(),
            distance: self.distances(cage, &network),
            tapers: network.tapers.clone(),
            ends: IdVec::filled(false, t.vertex_count()),
            flat: self.flat(cage, &network),
            taper_length: network.seam.iter().map(|seam| seam.map_or(0.0, |seam| self.seams[seam].1.taper())).collect(),
            round: self.round(&network),
            cuttable: IdVec::filled(true, t.faces.len()),
            shares: &profile::LINES,
            kept_line: profile::WIDTH_LINE,
            is_even: true,
        };
        let lines = lines::insert(&request);
        let (controls, parts) = Self::controls(t, &network, &lines);
        let mut warnings = self.warn(cage, &network, &lines.narrowed);
        let (subsets, renamed) = self.subsets(cage, &network, &lines);
        warnings.extend(renamed);
        let details = Arc::new(parts);
        Ok(OperatorOutput { controls, details, subsets, warnings, ..OperatorOutput::new(lines.builder.finish(), cage) })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        parts(output).iter().map(|part| part.as_ref().map_or(0.0, |part| self.height(part).0)).collect()
    }

    fn intersections(&self, output: &OperatorOutput, faces: &[FaceId]) -> Warning {
        let seams = seams_at(output, faces);
        let label: Vec<String> = seams.iter().map(|&i| format!("seam.{}", self.seams[i].0)).collect();
        super::operator::intersections(label.join(", "), output, faces)
    }

    fn reduced(&self, output: &OperatorOutput, given: &[f32]) -> Warnings {
        let mut warnings = Warnings::default();
        let mut shallow: Vec<(usize, VertexId, f32)> = Vec::new();
        for ((control, given), part) in output.controls.iter().zip(given).zip(parts(output)) {
            let (asked, seam) = part.as_ref().map_or((0.0, 0), |part| self.height(part));
            if control.role == ControlRole::Crest && given.abs() < REPORTED * asked.abs() {
                shallow.push((seam, control.vertex, given.abs() / asked.abs()));
            }
        }
        for (number, (name, _)) in self.seams.iter().enumerate() {
            let here = shallow.iter().filter(|s| s.0 == number).map(|s| (s.1, s.2));
            warnings.extend(shallow_seam(name, output, here));
        }
        warnings
    }
}

/// The names of some seams for messages.
fn label(seams: &[(String, SeamOptions)]) -> String {
    let names: Vec<String> = seams.iter().map(|(name, _)| format!("seam.{name}")).collect();
    names.join(", ")
}

/// The part of the profile that each control has; none away from the lines of seams.
fn parts(output: &OperatorOutput) -> &[Option<Part>] {
    output.details.downcast_ref::<Vec<Option<Part>>>().map_or(&[], Vec::as_slice)
}

/// Indices of the seams at some faces, or else of the nearest ones by a search over rings of faces.
fn seams_at(output: &OperatorOutput, faces: &[FaceId]) -> BTreeSet<usize> {
    let all = &output.derivation.faces;
    let mut near: BTreeSet<VertexId> = faces.iter().flat_map(|&f| all.vertices_of(f)).copied().collect();
    loop {
        let here = output.controls.iter().zip(parts(output)).filter(|(control, _)| near.contains(&control.vertex));
        let found: BTreeSet<usize> = here.filter_map(|(_, part)| part.as_ref()).flat_map(Part::seams).collect();
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
    use glam::Vec3;
    use tailor_mesh::connectivity::Elements;
    use tailor_mesh::connectivity::Faces;
    use tailor_mesh::subdivide::{Derivation, Level};

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
        let garment = Mesh {
            points: points.collect(),
            faces: Faces::quads(quads.collect::<Vec<_>>()),
            subsets: vec![subset("first", 2), subset("second", 10)].into(),
            ..Mesh::default()
        };
        let seam = |name: &str| {
            (name.to_owned(), SeamOptions { edges: vec![name.to_owned()], width: 0.3, ..SeamOptions::default() })
        };
        let seams = Seams { seams: vec![seam("first"), seam("second")] };
        let (inputs, level) = (Arc::new(garment.points.ids().collect::<IdVec<_, _>>()), Level::base(&garment));
        let clearance = &IdVec::filled(UNBOUNDED, inputs.len());
        let cage = OperatorInput {
            garment: &garment,
            level: &level,
            clearance,
            inputs: &inputs,
            covers: &IdVec::filled(false, garment.faces.len()),
            names_sets: false,
        };
        let output = seams.apply(&cage).expect("an output");
        // New vertices have the input vertex of one that they come from, so that warnings of later operators name it.
        assert_eq!(output.inputs.len(), output.derivation.vertices.len());
        for (v, &input) in output.inputs.enumerated() {
            let sources = output.derivation.vertices.at(v.index());
            assert!(sources.iter().any(|s| s.0 == input), "{v:?} {input:?}");
        }
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
