//! The garment that is shown, and what the page shows of it.

mod images;

use super::document::{Options, changed};
use super::messages::{
    FitMessage, GarmentMessage, LookInfo, MirrorInfo, PrimvarInfo, SaveTargets, ServerMessage, SetInfo, VariantSet,
};
use glam::Vec3;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use tailor::sets::{SetEvaluator, checksum};
use tailor_costume::cloth::{FABRICS, Fabric};
use tailor_costume::fit::{BodyOptions, faces_through};
use tailor_costume::pipeline::Builder;
use tailor_costume::recipe::{Layers, Recipe, map_files, table};
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::error::{Error, Warning, counted};
use tailor_mesh::files::folder_of;
use tailor_mesh::garment::{
    DERIVED, Elements, Garment, Interpolation, Mesh, PrimvarInput, PrimvarRole, Subset, Values,
};
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
    /// The bodies by which it is fitted.
    pub fit: BodyOptions,
    /// The body under it, in the space of the garment.
    pub body: Option<Arc<Mesh>>,
    /// The files of the garment and of the body.
    pub files: Vec<PathBuf>,
    /// Its way to that body, where the recipe fits it, and the faces that cross the body at the start.
    way: Option<(FitWay, BTreeSet<FaceId>)>,
    /// Images of its materials.
    pub images: Images,
    /// The message that describes the garment.
    pub message: String,
}

impl Stage {
    /// Reads the stage, fits its garment by `fit` or else by its recipe, and checks its mesh.
    ///
    /// # Errors
    /// A file that cannot be read, bodies that do not fit, faults of the mesh.
    pub fn open(input: &Input, fit: Option<&BodyOptions>) -> Result<Self, Error> {
        let opened = Input { overrides: overrides(input, fit), ..input.clone() }.open_one()?;
        let OpenGarment { source, mesh, authored, given, way, mut warnings } = opened;
        let upstream = authored.into_map();
        let mut given = changed(&given.into_map(), &upstream);
        map_files(&mut given, |path| std::path::absolute(path).unwrap_or_else(|_| path.into()));
        let of_recipe = || merged(&upstream, &given).recipe().unwrap_or_default().fit;
        let fit = fit.cloned().unwrap_or_else(of_recipe);
        // A body that is named here may be another than that of the recipe.
        let way = way.filter(|_| input.body.is_none());
        let (body, of_body) = body_under(&source, way.as_ref(), input, &fit.to)?.unzip();
        let mut on_way = mesh.clone();
        on_way.primvars.extend(way.iter().flat_map(stations));
        let mut checks = Builder::new(on_way)?;
        // On a way, crossings are those of the place on it.
        if let Some(body) = body.as_ref().filter(|_| way.is_none()) {
            let faces = checks.face_numbers().in_file(Elements::Faces(faces_through(checks.garment(), body)?));
            warnings.extend(crossing(&checks.garment().prim, faces));
        }
        checks = checks.with_warnings(warnings);
        let way = way.map(|way| {
            let before = crossing_at(checks.garment(), 0.0, &way.at(0.0).1);
            (way, before)
        });
        let shown = with_listed_sets(&checks);
        let looks = source.looks();
        let images = Images::of(looks.values());
        let message = message(&source, &checks, &shown, (&looks, &images), input, body.as_deref());
        let files = source.facts().layers.iter().chain(of_body.iter().flatten()).map(PathBuf::from).collect();
        Ok(Self { source, mesh, checks, shown, upstream, given, fit, body, files, way, images, message })
    }

    /// The message about a share of the way, and the points of the body there; none without a way.
    pub fn on_way(&self, share: f64) -> Option<(FitMessage, Vec<Vec3>)> {
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
        let (way, before) = self.way.as_ref()?;
        let body = way.at(share).1;
        let faces = crossing_at(self.checks.garment(), share, &body);
        let new = faces.difference(before).count();
        let warning = crossing(&self.checks.garment().prim, Elements::Faces(faces.into_iter().collect()));
        Some((FitMessage { share, new, warning }, body.points.into_vec()))
    }

    /// True if the garment is fitted as a recipe wants it.
    pub fn is_fitted_by(&self, fit: &BodyOptions) -> bool {
        BodyOptions { rest: self.fit.rest, ..fit.clone() } == self.fit
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
        merged(&self.upstream, edits)
    }

    /// The edits without a list of operators that says what holds without it, with relative paths as those beside the garment.
    pub fn tidied(&self, mut edits: Options) -> Options {
        map_files(&mut edits, |path| folder(&self.source).join(path));
        let has_list = self.upstream.get("render").is_some_and(|render| render.get("operators").is_some());
        if !has_list && self.layers(&edits).lists_default_order() {
            if let Some(render) = edits.get_mut("render").and_then(Value::as_object_mut) {
                render.remove("operators");
            }
            edits.retain(|_, group| group.as_object().is_none_or(|fields| !fields.is_empty()));
        }
        edits
    }
}

/// The folder of a garment.
pub fn folder(source: &Source) -> PathBuf {
    std::path::absolute(folder_of(source.file())).unwrap_or_default()
}

fn merged(upstream: &Options, edits: &Options) -> Layers {
    let mut layers = Layers::default();
    layers.add(upstream.clone());
    layers.add(edits.clone());
    layers
}

/// The overrides of an input, and those by which its garment is fitted.
fn overrides(input: &Input, fit: Option<&BodyOptions>) -> Vec<String> {
    let of_fit = fit.into_iter().flat_map(|BodyOptions { from, to, rigid, keep_length, ease, .. }| {
        let [rigid, keep_length] = [rigid, keep_length].map(|sets| sets.join(", "));
        [("from", from), ("to", to), ("rigid", &rigid), ("keepLength", &keep_length), ("ease", &ease.to_string())]
            .map(|(key, value)| format!("fit.{key}={value}"))
    });
    input.overrides.iter().cloned().chain(of_fit).collect()
}

/// A body and the files that it is in.
type BodyFiles = (Arc<Mesh>, Vec<String>);

/// The body that the input names, or else the one to which the garment is fitted.
fn body_under(garment: &Source, way: Option<&FitWay>, input: &Input, to: &str) -> Result<Option<BodyFiles>, Error> {
    let of_recipe = || (!to.is_empty()).then(|| PathBuf::from(to));
    let Some(file) = input.body.clone().or_else(of_recipe) else { return Ok(None) };
    let body = Source::open(&file, &ReadOptions { time: input.read.time, unsewn: true, ..ReadOptions::default() })?;
    let mesh = body_of(garment, &body)?;
    // Its faces stay as they are on the way.
    let on_way = way.map(|way| Mesh { prim: mesh.prim.clone(), ..way.at(1.0).1 });
    Ok(Some((Arc::new(on_way.unwrap_or(mesh)), body.facts().layers.clone())))
}

/// Stations of the way whose points are primvars of the garment. Its products carry them as they carry any primvar, and
/// go by them to any place on the way.
const STATIONS: usize = 8;

fn station(at: usize) -> String {
    format!("tailor:way{at}")
}

fn stations(way: &FitWay) -> impl Iterator<Item = PrimvarInput> + '_ {
    (0..=STATIONS).map(|at| {
        let points = way.at(at as f64 / STATIONS as f64).0.iter().flat_map(Vec3::to_array).collect();
        let primvar = PrimvarInput::new(&station(at), Interpolation::Vertex, Values::F32(points));
        PrimvarInput { components: 3, ..primvar }
    })
}

/// The points of the garment or of a product after a share of the way, which is one without an end at it.
pub fn points_on_way(mesh: &Mesh, share: f64) -> Vec<Vec3> {
    let place = share * STATIONS as f64;
    let (at, along) = (place as usize, place.fract() as f32);
    let values = |at: usize| match mesh.primvar(&station(at)).map(|primvar| &primvar.values) {
        Some(Values::F32(values)) => values.get(..3 * mesh.points.len()),
        _ => None,
    };
    let [Some(a), Some(b), Some(end)] = [at, (at + 1).min(STATIONS), STATIONS].map(values) else {
        return mesh.points.as_slice().to_vec();
    };
    let value = |values: &[f32], i: usize| Vec3::from_slice(&values[3 * i..3 * i + 3]);
    // Exact for the garment itself, whose points are those of the end.
    let moved = |(i, point): (usize, &Vec3)| value(a, i).lerp(value(b, i), along) + (*point - value(end, i));
    mesh.points.iter().enumerate().map(moved).collect()
}

/// The faces of a garment at a share of its way that cross the body there.
fn crossing_at(garment: &Mesh, share: f64, body: &Mesh) -> BTreeSet<FaceId> {
    let moved = Mesh { points: points_on_way(garment, share).into(), ..garment.clone() };
    // A body that has faces corresponds to itself.
    faces_through(&moved, body).unwrap_or_default().into_iter().collect()
}

/// The warning of faces that cross the body.
fn crossing(prim: &str, faces: Elements) -> Option<Warning> {
    let count = counted(faces.len(), "face crosses the body", "faces cross the body");
    let warning = Warning::new(tailor_costume::codes::FIT_CROSSES, prim, count).at(faces);
    let remedy = "Move them out of it, or hide the skin below them";
    (!warning.elements.is_empty()).then(|| warning.remedy(remedy))
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
    body: Option<&Mesh>,
) -> String {
    let (facts, garment) = (source.facts(), checks.garment());
    let warnings = checks.face_numbers().warnings_in_mesh(checks.warnings().clone());
    let looks = looks.iter();
    let primvars = garment.primvars.iter().filter(|primvar| primvar.role == PrimvarRole::Primvar);
    ServerMessage::Garment(Box::new(GarmentMessage {
        version: env!("CARGO_PKG_VERSION"),
        folder: folder(source),
        file: source.file().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        prim: &facts.prim,
        up_axis: if facts.up_axis == "Z" { "Z" } else { "Y" },
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
        body: body.map(|body| body.prim.clone()),
        suggested: suggested(source, input),
        warnings: warnings.iter().collect(),
    }))
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
