//! Rows of a seam at distances from its edges, as topstitching has them.
//!
//! A row has the profile of the seam across, with its left and right. Its lines are `parallels` of the chains: they follow the
//! edges at constant distances along the surface, over faces of any size. Rows end where their chains end, and beside
//! other seams and the rows of earlier ones.

use super::chains::Network;
use super::options::{SeamEnd, SeamOptions, flat};
use super::profile::LINES as SHARES;
use super::{reports, room};
use crate::codes;
use crate::render::operator::{Control, ControlRole, Operator, OperatorInput, OperatorOutput, REPORTED};
use crate::render::parallels::{self, Block, Chain, Field, LinePlace, ParallelRequest, Parallels, Passage, Surface};
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use tailor_mesh::connectivity::{EdgeId, FaceId, Topology, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings, counted};
use tailor_mesh::garment::{Mesh, Orientation, Subset};
use tailor_mesh::subdivide::Derivation;

/// Lines of a row.
const LINES: usize = 2 * SHARES.len() + 1;
/// Index of the centre among them.
const CENTRE: usize = SHARES.len();
/// The outermost line, as a share of the width.
const OUTER: f32 = SHARES[SHARES.len() - 1];
/// Share of the distance to the edges, or of the gap between rows, that lines may use.
const MAX_SHARE: f32 = 0.9;
/// Share of the distance to the next line within which a line leads through a vertex: faces beside it are no slivers.
const SNAP: f32 = 0.3;
/// Share of the width below which rows are left out: their lines would be in one place.
const LEAST_ROOM: f32 = 0.01;
/// Share of an edge by which its middle may miss the part of the chain beside a row.
const SLACK: f32 = 0.25;
/// Length of a chain without a row, in distances of the row from it, that is more than a tight corner leaves out.
const CORNER: f32 = 2.5;

/// The rows of one of some consecutive seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// The seams, with their names.
    pub seams: Vec<(String, SeamOptions)>,
    /// Index of the seam.
    pub number: usize,
}

/// The part of a row's profile that a control has.
#[derive(Clone, Copy, Debug)]
struct RowPart {
    /// Distance from the centre, as a share of the width on its side.
    across: f32,
    /// Share of the height.
    share: f32,
}

/// The rows beside one seam.
struct Ladder {
    /// Distances of the centres. \[mesh units\]
    rows: Vec<f32>,
    /// On each side of the edges, the widths towards them and away from them. \[mesh units\]
    widths: [[f32; 2]; 2],
    /// Share of the width and height that there is room for.
    room: f32,
}

impl Ladder {
    fn new(options: &SeamOptions) -> Self {
        let [left, right] = options.side_widths();
        let mut rows = options.row_distances();
        // To the left of the edges, the left of a row is away from them.
        let widths = [[right, left], [left, right]];
        let mut room: f32 = 1.0;
        for [inward, outward] in widths {
            let first = if options.offset > 0.0 { inward } else { inward + outward };
            let before = rows.first().map(|row| row / first);
            let between = rows.windows(2).map(|pair| (pair[1] - pair[0]) / (inward + outward));
            room = before.into_iter().chain(between).map(|share| MAX_SHARE * share / OUTER).fold(room, f32::min);
        }
        if room < LEAST_ROOM {
            rows.clear();
        }
        Self { rows, widths: widths.map(|side| side.map(|width| room * width)), room }
    }

    /// Distances of all lines on a side, ascending. \[mesh units\]
    fn lines(&self, side: usize) -> Vec<f32> {
        let [inward, outward] = self.widths[side];
        let of = |&row: &f32| {
            let before = SHARES.iter().rev().map(move |share| row - share * inward);
            before.chain([row]).chain(SHARES.iter().map(move |share| row + share * outward))
        };
        self.rows.iter().flat_map(of).collect()
    }

    /// How far its lines reach from a centre. \[mesh units\]
    fn half(&self) -> f32 {
        OUTER * self.widths.iter().flatten().fold(0.0, |most: f32, &width| most.max(width))
    }

    /// The part of the profile at a place.
    fn part(&self, place: &LinePlace) -> RowPart {
        let share = self.room * place.share;
        if let Some(line) = place.line {
            let from_centre = (line % LINES).abs_diff(CENTRE);
            let across = from_centre.checked_sub(1).map_or(0.0, |line| SHARES[line]);
            return RowPart { across, share };
        }
        let [inward, outward] = self.widths[place.side];
        let across = self.rows.iter().map(|&row| {
            let over = place.distance - row;
            over.abs() / if over < 0.0 { inward } else { outward }
        });
        RowPart { across: across.fold(f32::INFINITY, f32::min), share }
    }
}

/// The parts of a chain beside which a line is, by their start, each with the furthest end so far.
#[derive(Default)]
struct Covered(Vec<[f32; 2]>);

impl Covered {
    /// Those of each line, chain and side.
    fn all(passages: &[Passage]) -> BTreeMap<(usize, usize, usize), Self> {
        let mut all: BTreeMap<(usize, usize, usize), Self> = BTreeMap::new();
        for &Passage { line, chain, side, along: [a, b] } in passages {
            all.entry((line, chain, side)).or_default().0.push([a.min(b), a.max(b)]);
        }
        for Self(parts) in all.values_mut() {
            parts.sort_by(|x, y| x[0].total_cmp(&y[0]));
            let mut furthest = f32::NEG_INFINITY;
            for part in parts {
                furthest = furthest.max(part[1]);
                part[1] = furthest;
            }
        }
        all
    }

    /// Whether a place of the chain is among them, with some slack.
    fn contains(&self, place: f32, slack: f32) -> bool {
        let before = self.0.partition_point(|part| part[0] <= place + slack);
        before.checked_sub(1).is_some_and(|last| self.0[last][1] >= place - slack)
    }
}

impl Rows {
    fn name(&self) -> &str {
        &self.seams[self.number].0
    }

    fn options(&self) -> &SeamOptions {
        &self.seams[self.number].1
    }

    /// The chains of one of the seams, without the edges of another.
    fn chains(&self, cage: &OperatorInput, number: usize, without: Option<&Network>) -> (Network, Vec<Chain>) {
        let t = cage.topology();
        let mut edges = self.seams[number].1.edges_of(cage.garment);
        if let Some(network) = without {
            edges.retain(|&[a, b]| t.find_edge(a, b).is_none_or(|edge| network.seam[edge].is_none()));
        }
        let network = Network::new(t, &[edges]);
        let mut chains = network.chains(t);
        if self.seams[number].1.end == SeamEnd::Round {
            chains.iter_mut().for_each(|chain| chain.fades = [false; 2]);
        }
        (network, chains)
    }

    /// Where other seams, and rows of earlier ones, leave no room.
    fn blocks<'a>(
        &self,
        cage: &OperatorInput,
        surface: &'a Surface<'a>,
        network: &Network,
        ladder: &Ladder,
    ) -> Vec<Block<'a>> {
        let mut blocks = Vec::new();
        for (number, (_, options)) in self.seams.iter().enumerate().filter(|(number, _)| *number != self.number) {
            let beyond = options.width.max(self.options().width);
            if options.offset == 0.0 {
                let (_, chains) = self.chains(cage, number, Some(network));
                let width = ladder.half() + options.width;
                let field = Field::new(surface, &chains, [true; 2], width + beyond);
                blocks.push(Block { field, at: [vec![0.0], vec![0.0]], width });
            }
            if number < self.number && !options.row_distances().is_empty() {
                let (other, (_, chains)) = (Ladder::new(options), self.chains(cage, number, None));
                let width = ladder.half() + other.half();
                let furthest = other.rows.last().copied().unwrap_or(0.0);
                let field = Field::new(surface, &chains, options.side.sides(), furthest + width + beyond);
                blocks.push(Block { field, at: [other.rows.clone(), other.rows], width });
            }
        }
        blocks
    }

    fn controls(t: &Topology, ladder: &Ladder, lines: &Parallels) -> (Vec<Control>, Vec<RowPart>) {
        let parts: BTreeMap<VertexId, RowPart> =
            lines.vertices.iter().map(|(vertex, place)| (*vertex, ladder.part(place))).collect();
        let near = |v: &VertexId| t.faces_at(*v).any(|f| t.faces.vertices_of(f).iter().any(|&v| lines.near[v]));
        let on_cage = lines.near.ids().filter(near);
        let on_lines = lines.vertices.iter().map(|(vertex, _)| *vertex).filter(|v| v.index() >= t.vertex_count());
        let control = |vertex: VertexId| {
            let part = parts.get(&vertex).copied().unwrap_or(RowPart { across: f32::INFINITY, share: 0.0 });
            let is_parent = vertex.index() < t.vertex_count();
            let role = match part.across {
                0.0 => ControlRole::Crest,
                across if is_parent && across >= 1.0 => ControlRole::Kept,
                _ => ControlRole::Raised,
            };
            (Control { vertex, role }, part)
        };
        on_cage.chain(on_lines).map(control).unzip()
    }

    /// The faces within the width of rows.
    fn subsets(&self, cage: &OperatorInput, ladder: &Ladder, lines: &Parallels) -> (Vec<Subset>, Warnings) {
        if !cage.names_sets {
            return (Vec::new(), Warnings::default());
        }
        let within = lines.vertices.iter().filter(|(_, place)| ladder.part(place).across <= 1.0 && place.share > 0.0);
        let within: BTreeSet<VertexId> = within.map(|(vertex, _)| *vertex).collect();
        let is_within =
            |face: &FaceId| lines.builder.corners_of(face.index()).iter().all(|vertex| within.contains(vertex));
        let faces = lines.faces.iter().copied().filter(is_within).collect();
        crate::render::new_sets(cage.garment, vec![(format!("{}_rows", self.name()), faces)])
    }

    fn warn(
        &self,
        cage: &OperatorInput,
        (request, network): (&ParallelRequest, &Network),
        ladder: &Ladder,
        lines: &Parallels,
    ) -> Warnings {
        let mut warnings = Warnings::default();
        let label = self.label();
        let at = |edges: Vec<EdgeId>| cage.input_edges(edges.into_iter().map(|e| network.ends(e)));
        let all = || request.chains.iter().flat_map(|chain| chain.edges.iter().map(|(edge, _)| *edge)).collect();
        if ladder.room < REPORTED {
            let left = 100.0 * ladder.room;
            let problem =
                format!("its rows have {left:.0} % of width and height: they are close to each other or to the edges");
            let remedy = format!("Lower `{label}.width`, or raise `{label}.rowGap` or `{label}.offset`");
            let warning = Warning::new(codes::NARROW_SEAM, &label, problem).at(at(all())).amount(ladder.room);
            warnings.push(warning.remedy(remedy));
        }
        let missing = at(self.missing(request, ladder, lines));
        if !missing.is_empty() {
            let edges = counted(missing.len(), "edge", "edges");
            let problem = format!("no row beside {edges}: the cloth ends, or another seam is in the way");
            let remedy = format!("Change `{label}.offset`, `{label}.rows` or `{label}.side`");
            warnings.push(Warning::new(codes::NARROW_SEAM, &label, problem).at(missing).remedy(remedy));
        }
        warnings
    }

    /// The edges beside which a row is left out, except around corners that are tighter than its distance.
    fn missing(&self, request: &ParallelRequest, ladder: &Ladder, lines: &Parallels) -> Vec<EdgeId> {
        let (mut missing, wanted, width) = (BTreeSet::new(), self.options().side.sides(), self.options().width);
        let covered = Covered::all(&lines.passages);
        for (chain, Chain { edges, fades }) in request.chains.iter().enumerate() {
            let length = request.field.lengths()[chain];
            let is_faded = |middle: f32| fades[0] && middle < width || fades[1] && length - middle < width;
            let rows =
                ladder.rows.iter().enumerate().flat_map(|(row, &distance)| [0, 1].map(|side| (row, distance, side)));
            for (row, distance, side) in rows.filter(|&(.., side)| wanted[side]) {
                let beside = covered.get(&(row * LINES + CENTRE, chain, side));
                let lacks = |&(edge, _): &(EdgeId, VertexId)| {
                    let [from, to] = request.field.span(edge);
                    let is_covered =
                        beside.is_some_and(|beside| beside.contains(0.5 * (from + to), SLACK * (to - from)));
                    request.field.has_side(edge, side) && !is_faded(0.5 * (from + to)) && !is_covered
                };
                for run in edges.chunk_by(|a, b| lacks(a) == lacks(b)).filter(|run| lacks(&run[0])) {
                    let [[from, _], [_, to]] = [run[0], run[run.len() - 1]].map(|(edge, _)| request.field.span(edge));
                    let is_at_end = fades[0] && from < 2.0 * width || fades[1] && length - to < 2.0 * width;
                    // Before another seam a row ends up to a face early, and fades over one more.
                    let is_long = to - from > CORNER * distance && !(is_at_end && run.len() <= 2);
                    let is_blocked = || !is_at_end && is_near_block(request, distance, run[run.len() / 2].1);
                    if beside.is_none() || is_long || is_blocked() {
                        missing.extend(run.iter().map(|(edge, _)| *edge));
                    }
                }
            }
        }
        missing.into_iter().collect()
    }
}

/// Whether another seam leads by a vertex, so that a row at a distance ends there.
fn is_near_block(request: &ParallelRequest, distance: f32, vertex: VertexId) -> bool {
    let is_near = |block: &Block| {
        block.field.around_vertex(vertex).is_some_and(|foot| foot.distance < block.width + 0.5 * distance)
    };
    request.blocks.iter().any(is_near)
}

impl Operator for Rows {
    fn label(&self) -> String {
        format!("seam.{}", self.name())
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    fn has_same_output(&self, other: &dyn Operator) -> bool {
        let other = (other as &dyn Any).downcast_ref::<Self>();
        other.is_some_and(|other| {
            self.number == other.number && self.seams.iter().map(flat).eq(other.seams.iter().map(flat))
        })
    }

    fn reach(&self, _: &Mesh) -> f32 {
        self.options().normal_offset.abs() + self.options().depth.abs()
    }

    fn levels_with_room(&self, garment: &Mesh, t: &Topology) -> Option<u32> {
        Some(room::levels(garment, t, self.options()))
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        crate::render::refuse_loop(cage, &self.label())?;
        let (t, ladder) = (cage.topology(), Ladder::new(self.options()));
        let is_left_handed = cage.garment.orientation == Orientation::LeftHanded;
        let surface = Surface { topology: t, points: &cage.on_surface(), is_left_handed };
        let (network, chains) = self.chains(cage, self.number, None);
        let distances = [0, 1].map(|side| ladder.lines(side));
        let furthest = distances.iter().flatten().fold(0.0, |most: f32, &line| most.max(line));
        let request = ParallelRequest {
            field: Field::new(&surface, &chains, self.options().side.sides(), furthest),
            chains: &chains,
            distances,
            snap: SNAP,
            fading: self.options().taper(),
            blocks: self.blocks(cage, &surface, &network, &ladder),
        };
        let lines = parallels::insert(&request);
        let (controls, mut parts) = Self::controls(t, &ladder, &lines);
        let mut warnings = self.warn(cage, (&request, &network), &ladder, &lines);
        let (subsets, renamed) = self.subsets(cage, &ladder, &lines);
        warnings.extend(renamed);
        let derivation = lines.builder.finish();
        if !self.options().through {
            let covered = derivation.faces.ids().filter(|&face| cage.covers[derivation.parent_face(face)]);
            let flat: BTreeSet<VertexId> =
                covered.flat_map(|face| derivation.faces.vertices_of(face)).copied().collect();
            let covered = controls.iter().zip(&mut parts).filter(|(control, _)| flat.contains(&control.vertex));
            covered.for_each(|(_, part)| part.share = 0.0);
        }
        let details = Arc::new(parts);
        Ok(OperatorOutput { controls, details, subsets, warnings, ..OperatorOutput::new(derivation, cage) })
    }

    fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
        let height = |part: &RowPart| part.share * self.options().profile_at(part.across);
        output.details.downcast_ref::<Vec<RowPart>>().map_or_else(Vec::new, |parts| parts.iter().map(height).collect())
    }

    fn reduced(&self, output: &OperatorOutput, given: &[f32]) -> Warnings {
        let asked = self.heights(output);
        let all = output.controls.iter().zip(given.iter().zip(&asked));
        let crests = all.filter(|(control, _)| control.role == ControlRole::Crest);
        // The place of a new vertex is that of the vertex of the cage which it is made of first.
        let place = |vertex: VertexId| output.derivation.vertices.at(vertex.index()).first().map_or(vertex, |s| s.0);
        let shares = crests.map(|(control, (given, asked))| (place(control.vertex), given.abs() / asked.abs()));
        reports::shallow_seam(self.name(), output, shares.filter(|(_, share)| *share < REPORTED)).into_iter().collect()
    }
}
