//! The steps from a garment to its simulation mesh.

use super::progress::Clock;
use crate::codes;
use crate::recipe::ResolvedSim;
use crate::report::{SimFigures, SubsetArea, subset_areas, uv_flips};
use crate::sim::{Baseline, CurveGap, Relaxation, SimOptions, SimProduct, as_made, baseline_level, simulate};
use crate::transfer::{Locator, LocatorTables, SetCurve, TransferResult, transfer};
use std::sync::Arc;
use tailor_mesh::connectivity::{CornerId, FaceId, Topology};
use tailor_mesh::error::{Error, Warning, Warnings, counted};
use tailor_mesh::garment::{Elements, Mesh, Subset, face_sets_warning};
use tailor_mesh::step::{Same, Step};

/// Distance of a curve from the edges that follow it above which a warning is given. \[target lengths\]
const CURVE_GAP: f32 = 0.1;
/// Change of a face subset's area above which a warning is given. Chords of a curved border stay below it. \[share\]
const AREA_CHANGE: f64 = 0.05;
/// The shortest target length: single precision has few digits for shorter edges. \[diagonals of the garment's box\]
const SHORTEST: f32 = 1e-5;
/// Triangles that a mesh may have beyond those that its target lengths ask for. Garments have up to 1.1. \[factor\]
const ROOM: f64 = 1.5;
/// Triangles that each edge of a chain may add to them: those around one of its ends.
const CHAIN_ROOM: f64 = 6.0;
/// A mesh of so few triangles needs no such bound: a form that is small beside the target length has more than it asks for.
const FEW_FACES: usize = 1000;

/// The steps from one garment to its simulation mesh.
pub struct SimSteps {
    garment: Arc<Mesh>,
    remeshed: Step<(ResolvedSim, usize), Arc<RemeshResult>>,
    simulated: Step<(Same<RemeshResult>, ResolvedSim), Arc<SimResult>>,
}

/// A simulation mesh before the transfer of attributes.
pub struct RemeshResult {
    /// The mesh.
    pub product: SimProduct,
    tables: LocatorTables,
    /// Warnings of it.
    pub warnings: Warnings,
}

impl RemeshResult {
    /// The locator of places on the mesh.
    pub fn locator(&self) -> Locator<'_> {
        Locator::new(&self.product, &self.tables)
    }

    /// The topology of the mesh.
    pub fn topology(&self) -> &Topology {
        self.tables.topology()
    }
}

/// A simulation mesh with attributes.
pub struct SimResult {
    /// The mesh without attributes.
    pub remeshed: Arc<RemeshResult>,
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// Warnings of the transfer.
    pub warnings: Warnings,
    curves: Vec<SetCurve>,
    areas: Vec<SubsetArea>,
    islands: usize,
}

impl SimResult {
    /// The quality figures.
    pub fn figures(&self) -> SimFigures {
        let (remeshed, areas) = (&self.remeshed, self.areas.clone());
        SimFigures::new(&remeshed.product, remeshed.topology(), &self.mesh, &self.curves, areas, self.islands)
    }
}

impl SimSteps {
    /// The steps of a garment.
    pub fn new(garment: Arc<Mesh>) -> Self {
        Self { garment, remeshed: Step::default(), simulated: Step::default() }
    }

    /// The garment.
    pub fn garment(&self) -> &Arc<Mesh> {
        &self.garment
    }

    /// The simulation mesh.
    pub fn update(
        &mut self,
        sim: &ResolvedSim,
        max_faces: usize,
        clock: &mut Clock<'_>,
    ) -> Result<Arc<SimResult>, Error> {
        let garment = &self.garment;
        let remeshed = self.remeshed.get((sim.without_transfer(), max_faces), |(sim, _)| {
            remesh(garment, sim, max_faces, clock).map(Arc::new)
        })?;
        self.simulated.get((Same::from(&remeshed), sim.clone()), |_| {
            clock.run("transfer", || simulated(garment, sim, &remeshed)).map(Arc::new)
        })
    }

    /// An estimate of the memory of the kept results. \[bytes\]
    pub fn bytes(&self) -> usize {
        /// A baseline triangle's share of levels, adjacency and stencils, as measured on garments of 10 to 100 thousand.
        const BASELINE_TRIANGLE: usize = 400;
        /// A triangle's share of points, corners and chains.
        const TRIANGLE: usize = 150;
        let remeshed = self.remeshed.last().map_or(0, |remeshed| {
            let product = &remeshed.product;
            BASELINE_TRIANGLE * product.baseline.source_face.len() + TRIANGLE * product.triangles.len()
        });
        remeshed + self.simulated.last().map_or(0, |simulated| simulated.mesh.bytes())
    }
}

/// The surface that the simulation mesh of a garment lies on.
pub fn baseline(garment: &Mesh, sim: &ResolvedSim) -> Baseline {
    Baseline::new(garment, &sim.options, sim.lengths(), sim.uv_set(garment), surface_level(garment, sim))
}

/// The refinements that give that surface.
pub fn surface_level(garment: &Mesh, sim: &ResolvedSim) -> u32 {
    baseline_level(garment, &sim.options, sim.lengths())
}

/// The triangles that the target lengths ask for, all of them equilateral.
pub fn expected_faces(garment: &Mesh, sim: &ResolvedSim) -> usize {
    let lengths = sim.lengths();
    let wanted = garment.faces.ids().map(|face| {
        let vertices = garment.faces.vertices_of(face);
        let sum: f64 = vertices.iter().map(|&v| f64::from(lengths.at(v))).sum();
        let target = sum / vertices.len() as f64;
        0.5 * garment.doubled_normal(face).length() / (0.25 * 3f64.sqrt() * target * target)
    });
    // Saturates where the lengths are absurdly small.
    wanted.sum::<f64>().ceil() as usize
}

/// The number of triangles that no simulation mesh on a baseline should exceed: whatever asks for more is a fault.
fn most_faces(baseline: &Baseline) -> usize {
    // Saturates where the lengths are absurdly small.
    let most = (ROOM * baseline.expected_faces() + CHAIN_ROOM * baseline.chain_edges()).ceil() as usize;
    most.max(FEW_FACES)
}

/// Refuses lengths that ask for too many triangles.
pub fn check_size(garment: &Mesh, sim: &ResolvedSim, max_faces: usize) -> Result<(), Error> {
    let expected = expected_faces(garment, sim);
    if expected <= max_faces {
        return Ok(());
    }
    let fault = format!("the target lengths ask for about {expected} triangles, more than {max_faces}");
    let remedy = "raise sim.minEdgeLength or sim.maxEdgeLength, or --max-faces of the command";
    Err(Error::recipe("sim.maxEdgeLength", fault).code(codes::TOO_LARGE).remedy(remedy))
}

fn remesh(garment: &Mesh, sim: &ResolvedSim, max_faces: usize, clock: &mut Clock<'_>) -> Result<RemeshResult, Error> {
    let options = &sim.options;
    // A fitted garment may have the triangles of the one that was made.
    let (form, made) = (garment, as_made(garment, options));
    let garment = made.as_ref().unwrap_or(garment);
    let least = SHORTEST * garment.size();
    if options.min_edge_length < least {
        let fault =
            format!("{} is too short for {}, whose points have seven digits", options.min_edge_length, garment.prim);
        return Err(Error::recipe("sim.minEdgeLength", fault).remedy(format!("give {least} mesh units or more")));
    }
    let baseline = clock.run("baseline", || Ok(baseline(garment, sim)))?;
    if options.relax == Relaxation::Uv && !baseline.has_uvs {
        let (fault, remedy) = match options.constrain_uv_seams {
            true => (format!("{} has no UV set", garment.prim), "name a UV set in sim.uvSet"),
            false => ("sim.constrainUvSeams is false".to_owned(), "set sim.constrainUvSeams to true"),
        };
        let fault = Error::recipe("sim.relax", format!("uv needs panels, and {fault}"));
        return Err(fault.remedy(format!("{remedy}, or set sim.relax to surface")));
    }
    let confetti = uv_confetti(&baseline, options);
    // One side is half of the mesh.
    let limit = if baseline.mirror.is_empty() { max_faces } else { max_faces / 2 }.min(most_faces(&baseline));
    let mut product = clock.run("remesh", || Ok(simulate(baseline, options, limit)))?;
    if made.is_some() {
        let level = product.baseline.levels.len() as u32;
        product = product.on(Baseline::new(form, options, sim.lengths(), sim.uv_set(form), level));
    }
    let mut warnings = Warnings::default();
    warnings.extend(confetti);
    warnings.extend(small_shells(garment, options, &product.baseline));
    warnings.extend(closed_details(options, &product.baseline));
    warnings.extend(flipped_uvs(garment, options, &product.baseline));
    if product.report.full {
        let problem = format!("stopped at {} triangles, before its edges were short enough", product.triangles.len());
        let warning = Warning::new(codes::FACE_LIMIT, "simulation mesh", problem);
        warnings.push(warning.remedy("Raise sim.minEdgeLength or sim.maxEdgeLength, or --max-faces"));
    }
    warnings.extend(curves_cut(&product));
    warnings.extend(asymmetric(garment, &product.baseline));
    let tables = clock.run("places", || Ok(LocatorTables::new(&product, form.faces.len())))?;
    Ok(RemeshResult { product, tables, warnings })
}

/// The warning of faces that are not mirrored though the options ask for it.
fn asymmetric(garment: &Mesh, baseline: &Baseline) -> Option<Warning> {
    let faces: Vec<FaceId> = baseline.mirror.alone().iter().copied().collect();
    let count = counted(faces.len(), "face has", "faces have");
    let problem = format!("{count} no twin across a plane of symmetry, and triangles of their own");
    let warning = Warning::new(codes::ASYMMETRIC, format!("{}, sim.symmetry", garment.prim), problem);
    let remedy = "Model both sides with the same faces and with edges on the plane, which `usdtailor info` finds";
    (!faces.is_empty()).then(|| warning.at(Elements::Faces(faces)).remedy(remedy))
}

/// The warning of UV shells whose seams the mesh does not follow.
fn small_shells(garment: &Mesh, options: &SimOptions, baseline: &Baseline) -> Option<Warning> {
    let shells = &baseline.small_shells;
    if shells.is_empty() {
        return None;
    }
    let mut faces: Vec<FaceId> = baseline.source_face.iter().copied().filter(|&face| shells.holds(face)).collect();
    faces.sort_unstable();
    faces.dedup();
    let problem = format!(
        "{} smaller than {} target triangles: their borders are not kept as edges, and UVs there are approximate",
        counted(shells.count(), "UV shell is", "UV shells are"),
        options.smallest_shell
    );
    let place = format!("{}.primvars:{}", garment.prim, options.uv_set);
    let warning = Warning::new(codes::SMALL_SHELLS, place, problem).at(Elements::Faces(faces));
    Some(warning.remedy("Set sim.smallestShell to 0 to keep all borders, or lower sim.maxEdgeLength"))
}

/// The warning of details that no surface could take the place of.
fn closed_details(options: &SimOptions, baseline: &Baseline) -> Option<Warning> {
    let count = baseline.closed_details;
    let problem = format!(
        "{} closed, without faces around it: the simulation mesh keeps it",
        counted(count, "detail is", "details are")
    );
    let option = if options.smooth.is_empty() { "sim.smoothWeights" } else { "sim.smooth" };
    let warning = Warning::new(codes::CLOSED_DETAIL, option, problem);
    (count > 0).then(|| warning.remedy(format!("Make the detail a trim, or leave it out of {option}")))
}

/// The warning of UVs that are cut at nearly every edge, as scanned and automatically unwrapped garments have them.
fn uv_confetti(baseline: &Baseline, options: &SimOptions) -> Option<Warning> {
    let topology = &baseline.manifold.level.topology;
    let channel = baseline.manifold.uv_channel.as_ref()?;
    let inner = || topology.edges.ids().filter(|&e| !topology.is_border(e));
    let cut = inner().filter(|&e| channel.is_cut(e) && !baseline.small_shells.is_released(e)).count();
    if 2 * cut <= inner().count() {
        return None;
    }
    let problem = format!("{cut} of {} edges are UV seams, and the mesh has to follow them", inner().count());
    let warning = Warning::new(codes::UV_CONFETTI, format!("UV set {}", options.uv_set), problem);
    Some(warning.remedy("Unwrap the garment in panels, or set sim.constrainUvSeams to false"))
}

/// The warning of faces whose UVs no triangle can follow.
fn flipped_uvs(garment: &Mesh, options: &SimOptions, baseline: &Baseline) -> Option<Warning> {
    let mut faces: Vec<FaceId> = baseline.flipped.iter().map(|&f| baseline.source_face[f]).collect();
    faces.sort_unstable();
    faces.dedup();
    let place = format!("{}.primvars:{}", garment.prim, options.uv_set);
    let problem = format!(
        "UVs are flipped or have no area in {}; the simulation mesh ignores them there",
        counted(faces.len(), "face", "faces")
    );
    let warning = Warning::new(codes::FLIPPED_UVS, place, problem).at(Elements::Faces(faces));
    (!baseline.flipped.is_empty()).then(|| warning.remedy("Correct the UVs, or name another UV set in sim.uvSet"))
}

/// The warning of borders, seams and constraints that the mesh's edges leave.
fn curves_cut(product: &SimProduct) -> Option<Warning> {
    let given = product.gaps.iter().zip(product.baseline.chains.iter()).filter(|(_, chain)| !chain.kind.feature);
    let mut gaps: Vec<&CurveGap> = given.map(|(gap, _)| gap).filter(|gap| gap.distance > CURVE_GAP).collect();
    gaps.sort_by(|a, b| b.distance.total_cmp(&a.distance).then(a.near.cmp(&b.near)));
    let farthest = gaps.first()?.distance;
    let problem = format!(
        "{} within an edge: {farthest:.2} edge lengths off at most",
        counted(gaps.len(), "border, seam or constraint bends", "borders, seams or constraints bend")
    );
    let near = Elements::Points(gaps.iter().map(|gap| gap.near).collect());
    let warning = Warning::new(codes::CURVES_CUT, "simulation mesh", problem).at(near).amount(farthest);
    Some(warning.remedy("Lower sim.maxEdgeLength, or sim.cornerAngle"))
}

fn simulated(garment: &Mesh, sim: &ResolvedSim, remeshed: &Arc<RemeshResult>) -> Result<SimResult, Error> {
    let product = &remeshed.product;
    let (transferred, mut warnings) = transfer(garment, &remeshed.locator(), &sim.options);
    let areas = subset_areas(product, &transferred, garment);
    warnings.extend(area_changed(garment, &areas, &warnings));
    warnings.extend(uvs_flipped(product));
    let TransferResult { mesh, curves, islands, .. } = transferred;
    Ok(SimResult { remeshed: Arc::clone(remeshed), mesh: Arc::new(mesh), warnings, curves, areas, islands })
}

/// The warning of triangles that are flipped in the UVs.
fn uvs_flipped(product: &SimProduct) -> Option<Warning> {
    let flipped = uv_flips(product);
    if flipped.is_empty() {
        return None;
    }
    let source =
        |&triangle: &usize| product.baseline.source_face[product.places[CornerId::new(3 * triangle)].location.face];
    let near = Elements::Faces(flipped.iter().map(source).collect());
    let problem = format!("{} triangles are flipped in the UVs", flipped.len());
    let warning = Warning::new(codes::UV_FLIPS, "simulation mesh", problem);
    Some(warning.at(near).remedy("Mend the UVs there, or lower sim.maxEdgeLength"))
}

/// The warning of face subsets that have another area than on the surface, and are not blurred, which says so already.
fn area_changed(garment: &Mesh, areas: &[SubsetArea], told: &Warnings) -> Option<Warning> {
    let change = |s: &&SubsetArea| (s.area - s.source_area).abs() / s.source_area;
    let is_blurred = |s: &SubsetArea| told.iter().any(|w| w.code == codes::SETS_BLURRED && w.names.contains(&s.name));
    let is_changed = |s: &&SubsetArea| s.source_area > 0.0 && change(s) > AREA_CHANGE && !is_blurred(s);
    let changed: Vec<&SubsetArea> = areas.iter().filter(is_changed).collect();
    let largest = changed.iter().map(change).reduce(f64::max)?;
    let is_named = |set: &&Subset| changed.iter().any(|s| s.name == set.name);
    let sets: Vec<&Subset> = garment.subsets.iter().filter(is_named).collect();
    let problem = format!("their area on the simulation mesh differs by up to {:.0} %", 100.0 * largest);
    let warning = face_sets_warning(codes::AREA_CHANGED, &sets, problem);
    let remedy = "Lower sim.maxEdgeLength, or name edge sets along folds in sim.constraints";
    Some(warning.amount(largest as f32).remedy(remedy))
}
