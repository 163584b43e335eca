//! The garment that is shown, and what the page shows of it.

mod images;

use super::document::{Options, changed};
use super::messages::{
    FitMessage, GarmentMessage, LookInfo, MirrorInfo, PrimvarInfo, SaveTargets, ServerMessage, SetInfo, UpAxis,
    VariantSet,
};
use glam::Vec3;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use tailor::sets::{SetEvaluator, checksum};
use tailor_costume::cloth::{FABRICS, Fabric};
use tailor_costume::fit::faces_through;
use tailor_costume::pipeline::Builder;
use tailor_costume::recipe::{Layers, Recipe, table};
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::error::{Error, Warning, counted};
use tailor_mesh::garment::{DERIVED, Elements, Garment, Mesh, PrimvarRole, Subset};
use tailor_usd::session::{FitWay, Input, OpenGarment, is_usd};
use tailor_usd::{Look, ReadOptions, Source, body_of, decimal};

use images::Images;

/// A stage that was read.
pub struct Stage {
    /// The stage.
    pub source: Source,
    /// The mesh as authored.
    pub mesh: Garment,
    /// A builder that checks recipes and makes nothing.
    pub checks: Builder,
    /// The garment with the sets that it offers besides its own.
    pub shown: Arc<Mesh>,
    /// The options that the stage holds.
    pub upstream: Options,
    /// The options of the recipe files, where they differ.
    pub given: Options,
    /// The body under it.
    pub body: Option<Body>,
    /// Its way to that body, where the recipe fits it, and the faces that cross the body at the start.
    way: Option<(FitWay, BTreeSet<FaceId>)>,
    /// Images of its materials.
    pub images: Images,
    /// The message that describes the garment.
    pub message: String,
}

/// A body, in the space of the garment.
pub struct Body {
    pub mesh: Arc<Mesh>,
    files: Vec<PathBuf>,
}

impl Stage {
    /// Reads the stage and checks its mesh.
    ///
    /// # Errors
    /// A file that cannot be read, faults of the mesh.
    pub fn open(input: &Input) -> Result<Self, Error> {
        let garment = input.open_one()?;
        let body = body_under(&garment, input)?;
        let OpenGarment { source, mesh, authored, given, way, mut warnings } = garment;
        // A body that is named here may be another than that of the recipe.
        let way = way.filter(|_| input.body.is_none());
        let mut checks = Builder::new(mesh.clone())?;
        if let Some(body) = &body {
            warnings.extend(through_body(&checks, &body.mesh)?);
        }
        checks = checks.with_warnings(warnings);
        let with_start = |way: FitWay| {
            let (points, body) = way.at(0.0);
            let before = crossing_at(checks.garment(), &points, &body);
            (way, before)
        };
        let way = way.map(with_start);
        let upstream = authored.into_map();
        let given = changed(&given.into_map(), &upstream);
        let shown = with_listed_sets(&checks);
        let looks = source.looks();
        let images = Images::of(looks.values());
        let message = message(&source, &checks, &shown, (&looks, &images), input, body.as_ref());
        Ok(Self { source, mesh, checks, shown, upstream, given, body, way, images, message })
    }

    /// The end of the way, at which the garment is shown first; none without a way.
    pub fn at_end(&self) -> Option<FitMessage> {
        Some(self.on_way(1.0)?.0)
    }

    /// The points of the garment and of the body after a share of the way, with the message about them; none without a way.
    pub fn on_way(&self, share: f64) -> Option<(FitMessage, [Vec<Vec3>; 2])> {
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
        let (way, before) = self.way.as_ref()?;
        let (points, body) = way.at(share);
        let crossing = crossing_at(self.checks.garment(), &points, &body);
        let new = crossing.difference(before).count();
        let crossings = crossing.iter().map(|face| face.index()).collect();
        Some((FitMessage { share, crossings, new }, [points, body.points.into_vec()]))
    }

    /// The recipe of the stage with `edits`, with the lengths that replace 0.
    ///
    /// # Errors
    /// Faults of the recipe.
    pub fn recipe(&self, edits: &Options) -> Result<Recipe, Error> {
        self.layers(edits).recipe_for(self.checks.garment())
    }

    /// The options of the stage with `edits`.
    pub fn layers(&self, edits: &Options) -> Layers {
        let mut layers = Layers::default();
        layers.add(self.upstream.clone());
        layers.add(edits.clone());
        layers
    }

    /// The edits without a list of operators that says what holds without it.
    pub fn tidied(&self, mut edits: Options) -> Options {
        let has_list = self.upstream.get("render").is_some_and(|render| render.get("operators").is_some());
        if !has_list && self.layers(&edits).lists_default_order() {
            if let Some(render) = edits.get_mut("render").and_then(Value::as_object_mut) {
                render.remove("operators");
            }
            edits.retain(|_, group| group.as_object().is_none_or(|fields| !fields.is_empty()));
        }
        edits
    }

    /// Files of the stage.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let of_body = self.body.iter().flat_map(|body| body.files.iter().cloned());
        self.source.facts().layers.iter().map(PathBuf::from).chain(of_body)
    }
}

/// The body that the input names, or to which the recipe fits the garment.
fn body_under(garment: &OpenGarment, input: &Input) -> Result<Option<Body>, Error> {
    let of_recipe = || garment.layers().recipe().ok().map(|recipe| recipe.fit.to).filter(|to| !to.is_empty());
    let Some(file) = input.body.clone().or_else(|| of_recipe().map(PathBuf::from)) else { return Ok(None) };
    let body = Source::open(&file, &ReadOptions { time: input.read.time, unsewn: true, ..ReadOptions::default() })?;
    let mesh = body_of(&garment.source, &body)?;
    // Its faces stay as they are on the way.
    let mesh = match garment.way.as_ref().filter(|_| input.body.is_none()) {
        Some(way) => Arc::new(Mesh { prim: mesh.prim, ..way.at(1.0).1 }),
        None => Arc::new(mesh),
    };
    Ok(Some(Body { mesh, files: body.facts().layers.iter().map(PathBuf::from).collect() }))
}

/// The faces of a garment with other points that cross a body.
fn crossing_at(garment: &Mesh, points: &[Vec3], body: &Mesh) -> BTreeSet<FaceId> {
    let moved = Mesh { points: points.iter().copied().collect(), ..garment.clone() };
    // A body that has faces corresponds to itself.
    faces_through(&moved, body).unwrap_or_default().into_iter().collect()
}

/// The warning of faces that cross the body.
fn through_body(checks: &Builder, body: &Mesh) -> Result<Option<Warning>, Error> {
    let faces = faces_through(checks.garment(), body)?;
    if faces.is_empty() {
        return Ok(None);
    }
    let count = counted(faces.len(), "face crosses the body", "faces cross the body");
    let warning = Warning::new(tailor_costume::codes::FIT_CROSSES, &checks.garment().prim, count);
    let faces = checks.face_numbers().in_file(Elements::Faces(faces));
    Ok(Some(warning.at(faces).remedy("Move them out of it, or hide the skin below them")))
}

/// Pieces of one set that are shown, the largest.
const MOST_PIECES: usize = 40;

/// The garment with the sets that it offers: UV seams and borders as wholes and in pieces, materials, values and weights.
fn with_listed_sets(checks: &Builder) -> Arc<Mesh> {
    let garment = checks.garment();
    let Ok(recipe) = checks.resolve(&Recipe::default()) else { return Arc::clone(garment) };
    let listed = checks.listed_sets(&recipe);
    let mut subsets = garment.subsets.to_vec();
    let is_taken = |subsets: &[Subset], name: &str| subsets.iter().any(|set| set.name == name);
    for pieces in listed.chunk_by(|a, b| a.stem() == b.stem()) {
        let whole = pieces.iter().map(|piece| piece.elements.clone()).reduce(|mut all, piece| {
            all.merge(&piece);
            all
        });
        let stem = (pieces.len() > 1)
            .then(|| (pieces[0].stem().to_owned(), whole.unwrap_or_else(|| pieces[0].elements.clone())));
        let mut largest: Vec<_> = pieces.iter().collect();
        largest.sort_by(|a, b| b.size.unwrap_or_default().total_cmp(&a.size.unwrap_or_default()));
        let least = largest.get(MOST_PIECES).map_or(0.0, |piece| piece.size.unwrap_or_default());
        let shown = pieces.iter().filter(|piece| piece.size.is_none_or(|size| size > least || least == 0.0));
        let shown = shown.map(|piece| (piece.expression.clone(), piece.elements.clone()));
        for (name, elements) in stem.into_iter().chain(shown) {
            if !is_taken(&subsets, &name) {
                subsets.push(Subset { name, family: DERIVED.to_owned(), elements, sharpness: None });
            }
        }
    }
    Arc::new(Mesh { subsets: Arc::new(subsets), ..Mesh::clone(garment) })
}

fn message(
    source: &Source,
    checks: &Builder,
    shown: &Mesh,
    (looks, images): (&BTreeMap<String, Look>, &Images),
    input: &Input,
    body: Option<&Body>,
) -> String {
    let (facts, garment) = (source.facts(), checks.garment());
    let warnings = checks.face_numbers().warnings_in_mesh(checks.warnings().clone());
    let looks = looks.iter();
    let primvars = garment.primvars.iter().filter(|primvar| primvar.role == PrimvarRole::Primvar);
    ServerMessage::Garment(GarmentMessage {
        version: env!("CARGO_PKG_VERSION"),
        file: source.file().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        prim: &facts.prim,
        up_axis: UpAxis::named(&facts.up_axis),
        meters_per_unit: facts.meters_per_unit,
        points: garment.points.len(),
        faces: garment.faces.len(),
        mean_edge: decimal(checks.mean_edge_length()),
        checksum: checksum(&garment.faces),
        sets: shown.subsets.iter().map(SetInfo::from).collect(),
        mirror: mirror(shown),
        looks: looks.map(|(set, look)| LookInfo::new(set, look, images.address(look))).collect(),
        primvars: primvars.map(PrimvarInfo::from).collect(),
        variants: facts.variants.iter().map(VariantSet::from).collect(),
        groups: table(),
        fabrics: FABRICS.iter().filter_map(|&name| Some((name, Fabric::preset(name)?))).collect(),
        body: body.map(|body| body.mesh.prim.clone()),
        suggested: suggested(source, input),
        warnings: warnings.iter().collect(),
    })
    .to_text()
}

fn mirror(garment: &Mesh) -> Option<Box<MirrorInfo>> {
    let sets = SetEvaluator::new(garment, "");
    let twins = sets.twins(&garment.subsets);
    let found = sets.symmetry()?;
    let points = garment.points.ids().map(|point| found.vertex(point).unwrap_or(point).index()).collect();
    Some(Box::new(MirrorInfo { axis: found.axis_name(), share: found.share, twins, points }))
}

fn suggested(source: &Source, input: &Input) -> SaveTargets {
    let garment = source.file();
    let stem = garment.file_stem().unwrap_or_default().to_string_lossy();
    let beside = |name: String| garment.with_file_name(name).display().to_string();
    let (mut layer, mut recipe) = (beside(format!("{stem}_look.usda")), beside(format!("{stem}.tailor")));
    match &input.recipe {
        Some(path) if is_usd(path) => layer = path.display().to_string(),
        Some(path) => recipe = path.display().to_string(),
        None if !is_usd(&input.file) => recipe = input.file.display().to_string(),
        None => {}
    }
    SaveTargets { layer: (!source.is_sewn()).then_some(layer), recipe }
}
