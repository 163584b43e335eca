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
mod cut;
mod heights;
mod options;
mod order;
mod profile;
mod reports;
mod rings;
mod room;
mod rows;

use super::operator::{Control, ControlRole, Operator, OperatorInput, OperatorOutput, REPORTED};
use super::options::OperatorOptions;
use crate::codes;
use chains::Network;
use creases::Creases;
use cut::{Cut, Strand, cut};
pub use options::{RowSide, SeamOptions};
use reports::shallow_seam;
use rows::Rows;
use std::any::Any;
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor_mesh::connectivity::{EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::error::{Error, Warning, WarningCode, Warnings, counted};
use tailor_mesh::garment::{Mesh, Subset};
use tailor_mesh::subdivide::Derivation;

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
    fn warn(&self, cage: &OperatorInput, network: &Network, narrowed: &[(usize, VertexId, f32)]) -> Warnings {
        let mut warnings = Warnings::default();
        for (number, (name, _)) in self.seams.iter().enumerate() {
            let label = format!("seam.{name}");
            let edges = |code: WarningCode, edges: Vec<EdgeId>, problem: &str, remedy: &str| {
                let ends = cage.input_edges(edges.iter().map(|&e| network.ends(e)));
                let warning = Warning::new(code, &label, format!("{} {problem}", counted(ends.len(), "edge", "edges")));
                (!edges.is_empty()).then(|| warning.at(ends).remedy(remedy))
            };
            let shared = network.shared.iter().filter(|s| s.1 == number).map(|s| s.0).collect();
            let problem = "in an earlier seam too, which keeps them";
            warnings.extend(edges(
                codes::SHARED_SEAM_EDGES,
                shared,
                problem,
                "Remove them from one of the two edge sets",
            ));
            let here = || narrowed.iter().filter(|narrow| narrow.0 == number);
            let narrow: BTreeSet<VertexId> = here().map(|narrow| narrow.1).collect();
            if !narrow.is_empty() {
                let least = here().map(|narrow| narrow.2).fold(1.0, f32::min);
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

    /// The controls, and what seams give each of them.
    fn controls(t: &Topology, cut: &Cut) -> (Vec<Control>, Vec<Vec<Strand>>) {
        let is_cut = |face: FaceId| {
            let mut children = cut.derivation.child_faces(face);
            let first = children.next().map_or(0, |child| cut.derivation.faces.valence(child));
            children.next().is_some() || first != t.faces.valence(face)
        };
        let mut near = IdVec::filled(false, t.vertex_count());
        let faces = t.faces.ids().filter(|&face| is_cut(face));
        faces.flat_map(|face| t.faces.vertices_of(face)).for_each(|&v| near[v] = true);
        // One ring more than the faces that are cut: its limit depends on the points that the fit moves.
        let is_near = |v: &VertexId| t.faces_at(*v).any(|f| t.faces.vertices_of(f).iter().any(|&v| near[v]));
        let on_cage = near.ids().filter(is_near);
        let on_lines = (t.vertex_count()..cut.strands.len()).map(VertexId::new);
        let control = |vertex: VertexId| {
            let strands = cut.strands[vertex.index()].clone();
            (Control { vertex, role: heights::role(vertex, t.vertex_count(), &strands) }, strands)
        };
        on_cage.chain(on_lines).map(control).unzip()
    }

    /// The faces within the width of each seam.
    fn subsets(&self, cage: &OperatorInput, cut: &Cut) -> (Vec<Subset>, Warnings) {
        if !cage.names_sets {
            return (Vec::new(), Warnings::default());
        }
        let faces = &cut.derivation.faces;
        let is_within = |seam: usize, vertex: &VertexId| {
            cut.strands[vertex.index()].iter().any(|s| s.seam == seam && s.across <= 1.0 + 1e-3 && s.share > 0.0)
        };
        let of = |(seam, (name, _)): (usize, &(String, SeamOptions))| {
            let within = faces.ids().filter(|&face| faces.vertices_of(face).iter().all(|v| is_within(seam, v)));
            (format!("{name}_seam"), within.collect())
        };
        super::new_sets(cage.garment, self.seams.iter().enumerate().map(of).collect())
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
        let cut = cut(self, cage, &network);
        let (controls, parts) = Self::controls(t, &cut);
        let mut warnings = self.warn(cage, &network, &cut.narrowed);
        let (subsets, renamed) = self.subsets(cage, &cut);
        warnings.extend(renamed);
        let details = Arc::new(parts);
        Ok(OperatorOutput { controls, details, subsets, warnings, ..OperatorOutput::new(cut.derivation, cage) })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        parts(output).iter().map(|strands| self.height(strands).0).collect()
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
            let (asked, seam) = self.height(part);
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

/// What seams give each control.
fn parts(output: &OperatorOutput) -> &[Vec<Strand>] {
    output.details.downcast_ref::<Vec<Vec<Strand>>>().map_or(&[], Vec::as_slice)
}

/// Indices of the seams at some faces, or else of the nearest ones by a search over rings of faces.
fn seams_at(output: &OperatorOutput, faces: &[FaceId]) -> BTreeSet<usize> {
    let all = &output.derivation.faces;
    let mut near: BTreeSet<VertexId> = faces.iter().flat_map(|&f| all.vertices_of(f)).copied().collect();
    loop {
        let here = output.controls.iter().zip(parts(output)).filter(|(control, _)| near.contains(&control.vertex));
        let found: BTreeSet<usize> = here.flat_map(|(_, strands)| strands).map(|strand| strand.seam).collect();
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
    use tailor_mesh::subdivide::Level;

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
        let cage = OperatorInput { garment: &garment, level: &level, clearance, inputs: &inputs, names_sets: false };
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
