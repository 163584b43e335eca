//! Products into layers, and layers into files or bytes.

use super::crates::{encode, remove_unwritable};
use super::fit::author_fits;
use super::flatten::flattened;
use super::levels::{LevelPart, check_levels, copy_levels, level_variants};
use super::physics::{PANELS, SCOPE};
use super::product::{Author, fault};
use super::role::{GarmentProducts, Product, ProductRole, SetChoice, level_count};
use super::save::{Format, HeldOutput, OutputFile, text_of};
use super::scope::beside;
use super::stitches::STITCHES;
use super::trims::{BoundTrim, TrimBindings};
use super::variant::copy_into_variant;
use crate::assets::{Anchor, as_named, writable};
use crate::codes;
use crate::read::{LodSchema, Model, OrUnreadable, ProductNames, Source, flattened_variants};
use crate::{BuildRecord, on_large_stack};
use openusd::sdf::{self, AbstractData, FieldKey, LayerOffset, SpecType, Value};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, Warnings};

/// How products are written.
#[derive(Clone, Debug)]
pub struct WriteOptions {
    /// Write one self-contained layer instead of one that sublayers the input. A `.usdz` package always is.
    pub flatten: bool,
    /// Overwrite a file that is there already.
    pub force: bool,
    /// Give the model the purpose `guide`, so that a viewer does not draw it on top of the render mesh.
    pub model_guide: bool,
    /// Write no file, and find the errors and warnings of a write, except for a full disk and missing permissions.
    pub dry_run: bool,
    /// The sets that products have.
    pub sets: SetChoice,
    /// How levels of detail are written.
    pub lod_schema: LodSchema,
    /// The record of what the products were made of, written into the layer's own data.
    pub record: Option<BuildRecord>,
    /// Where the complete file waits for its name; by default it has it at once.
    pub held: Option<HeldOutput>,
}

impl WriteOptions {
    /// Saves a layer, or rehearses it.
    pub(super) fn save(&self, file: &OutputFile, data: sdf::Data) -> Result<(Vec<PathBuf>, Warnings), Error> {
        match &self.held {
            _ if self.dry_run => file.rehearse(data),
            Some(held) => file.hold(data, held),
            None => file.save(data),
        }
    }
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            flatten: false,
            force: false,
            model_guide: true,
            dry_run: false,
            sets: SetChoice::default(),
            lod_schema: LodSchema::default(),
            record: None,
            held: None,
        }
    }
}

/// A layer or package that was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// The files that a package has a copy of, sorted; entries of other packages as `package[entry]`.
    pub packed: Vec<PathBuf>,
    /// The trims that are bound.
    pub trims: Vec<BoundTrim>,
}

/// Writes `products` as siblings of the model of `source` into the file `out`, whose name decides the format. The file is
/// written completely or not at all; the input and its layers are never written to. Warns of what is not written.
///
/// # Errors
/// A name that is taken, a file that may not or cannot be written.
pub fn write(
    source: &Source,
    products: &[Product],
    out: &Path,
    options: &WriteOptions,
) -> Result<(Written, Warnings), Error> {
    write_all(&[GarmentProducts { source, products, variant: None }], out, options)
}

/// As [`write()`], the products of several garments of one stage, at least one.
///
/// # Errors
/// As [`write()`].
pub fn write_all(
    garments: &[GarmentProducts],
    out: &Path,
    options: &WriteOptions,
) -> Result<(Written, Warnings), Error> {
    let first = garments.first().ok_or_else(|| Error::internal("there is no garment to write"))?;
    let file = OutputFile::find(out, |file| first.source.model.uses(file), options.force)?;
    on_large_stack(|| {
        let is_package = file.format == Format::Usdz;
        let anchor = if is_package { Anchor::Root } else { file.anchor() };
        let frame = LayerContext { flatten: is_package || options.flatten, anchor, sublayer: None };
        let ((data, trims), mut warnings) = compose(garments, frame, options)?;
        let packed = warnings.absorb(options.save(&file, data)?);
        Ok((Written { packed, trims }, warnings))
    })
}

/// Checks that [`write()`] may write to `out`.
///
/// # Errors
/// An unknown format, an output that exists already or is part of the input, a missing folder.
pub fn check_target(source: &Source, out: &Path, force: bool) -> Result<(), Error> {
    OutputFile::find(out, |file| source.model.uses(file), force).map(drop)
}

/// The paths that a layer in memory has for other files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings<'a> {
    /// The folder that asset paths are relative to; without one they are absolute.
    pub folder: Option<&'a Path>,
    /// The asset path of the source; by default that of its file.
    pub source: Option<&'a str>,
}

/// The layer that [`write()`] would write, in memory: text (`Usda`) or crate (`Usdc`).
///
/// # Errors
/// As [`write()`]; and `Usdz`, which is a package and no layer.
pub fn layer_bytes(
    source: &Source,
    products: &[Product],
    format: Format,
    surroundings: Surroundings,
    options: &WriteOptions,
) -> Result<(Vec<u8>, Warnings), Error> {
    let folder = surroundings.folder.map(|f| f.canonicalize().unwrap_or_else(|_| f.to_path_buf()));
    on_large_stack(|| {
        let anchor = folder.as_deref().map_or(Anchor::Root, Anchor::real);
        let frame = LayerContext { flatten: options.flatten, anchor, sublayer: surroundings.source };
        let all = [GarmentProducts { source, products, variant: None }];
        let ((mut data, _), mut warnings) = compose(&all, frame, options)?;
        let bytes = match format {
            Format::Usda => text_of(&data),
            Format::Usdc => {
                warnings.extend(remove_unwritable(&mut data));
                encode(&data)
            }
            Format::Usdz => Err(Error::usd("a .usdz package is not a layer")
                .code(codes::OUTPUT_PATH)
                .remedy("choose text or crate")),
        };
        Ok((bytes?, warnings))
    })
}

/// The content of a layer besides its products.
#[derive(Clone, Copy)]
pub struct LayerContext<'a> {
    /// Whether it is the whole stage; otherwise it sublayers the source.
    pub flatten: bool,
    /// The anchor of its asset paths.
    pub anchor: Anchor<'a>,
    /// The source's asset path, if it is not that of its file.
    pub sublayer: Option<&'a str>,
}

/// The layer with the products of all garments, which are of one stage, and the trims that it binds.
fn compose(
    garments: &[GarmentProducts],
    frame: LayerContext,
    options: &WriteOptions,
) -> Result<((sdf::Data, Vec<BoundTrim>), Warnings), Error> {
    let (mut data, mut warnings) = base(garments, frame, options)?;
    let mut trims = Vec::new();
    let mut before = 0;
    for of_variant in garments.chunk_by(|a, b| a.variant == b.variant) {
        let variant = of_variant[0].variant;
        let authored = match variant {
            None => author(&mut data, of_variant, frame, options)?,
            Some(variant) => {
                let mut part = overlay(&of_variant[0].source.model, frame)?;
                let authored = author(&mut part, of_variant, frame, options)?;
                copy_into_variant(&mut data, &part, &[variant]).map_err(fault)?;
                authored
            }
        };
        let Authored { trims: bound, levels } = warnings.absorb(authored);
        trims.extend(bound.into_iter().map(|trim| BoundTrim { garment: before + trim.garment, ..trim }));
        copy_levels(&mut data, variant, &levels)?;
        before += of_variant.len();
    }
    author_guides(&mut data, garments, frame, options)?;
    if let Some(record) = &options.record {
        let of =
            |garment: &GarmentProducts| level_variants(&garment.source.model, garment.products, options.lod_schema);
        record.with_variants(garments.iter().flat_map(of)).with_warnings(warnings.iter()).author(&mut data)?;
    }
    Ok(((data, trims), warnings))
}

/// The layer before its products: over the stage, or the whole stage without earlier products.
///
/// # Errors
/// Names that are taken, levels or variants that cannot be written.
fn base(
    garments: &[GarmentProducts],
    frame: LayerContext,
    options: &WriteOptions,
) -> Result<(sdf::Data, Warnings), Error> {
    let mut replaced = Vec::new();
    for garment in garments {
        let GarmentProducts { source, products, .. } = garment;
        check_names(&source.model, products)?;
        check_levels(garment, garments, options.lod_schema)?;
        let paths = products.iter().map(|p| source.model.sibling_path(p.name)).collect::<Result<Vec<_>, _>>();
        replaced.extend(paths.map_err(fault)?);
    }
    let stage = garments[0].source;
    if !frame.flatten {
        return Ok((overlay(&stage.model, frame)?, Warnings::default()));
    }
    if garments.iter().any(|garment| garment.variant.is_some()) {
        return Err(Error::usd("a flattened stage or package has no variants")
            .code(codes::OUTPUT_PATH)
            .remedy("write .usd, .usda or .usdc, over the input"));
    }
    let (data, mut warnings) = flattened(&stage.model, &replaced, frame.anchor)?;
    let facts = stage.facts();
    warnings.extend(flattened_variants(&facts.prim, &facts.variants));
    Ok((data, warnings))
}

/// Makes models guides, outside of variants, where that is stronger than what the input says.
fn author_guides(
    data: &mut sdf::Data,
    garments: &[GarmentProducts],
    frame: LayerContext,
    options: &WriteOptions,
) -> Result<(), Error> {
    // A guide that a PointInstancer repeats would take all instances along.
    for garment in garments.iter().filter(|g| options.model_guide && g.source.model.instancer.is_none()) {
        let model = &garment.source.model;
        let mut author = Author { data, model, anchor: frame.anchor, is_overlay: !frame.flatten, sets: options.sets };
        author.model_purpose(ProductRole::Sim.purpose(None)).map_err(fault)?;
    }
    Ok(())
}

/// The trims that are bound to some garments, and the variants of their levels of detail.
struct Authored {
    trims: Vec<BoundTrim>,
    /// The content of each variant of levels of detail.
    levels: Vec<LevelPart>,
}

/// Authors the products of garments, and the places of their trims.
fn author(
    data: &mut sdf::Data,
    garments: &[GarmentProducts],
    frame: LayerContext,
    options: &WriteOptions,
) -> Result<(Authored, Warnings), Error> {
    let (sets, mut levels) = (options.sets, Vec::new());
    let (trims, mut warnings) = TrimBindings::read(garments)?;
    warnings.extend(author_fits(data, garments, &trims, frame)?);
    for garment in garments {
        let GarmentProducts { source, products, .. } = garment;
        let mut author = Author { data, model: &source.model, anchor: frame.anchor, is_overlay: !frame.flatten, sets };
        if level_count(products) > 1 {
            levels.extend(warnings.absorb(author.levels(products, options.lod_schema)?));
            continue;
        }
        for product in *products {
            warnings.extend(author.product(product).map_err(fault)?);
            match product.role {
                ProductRole::Sim => author.model_binding(product).map_err(fault)?,
                ProductRole::Render => author.render_bindings(product, products).map_err(fault)?,
            }
        }
        warnings.extend(author.physics(products)?);
        author.stitches(products).map_err(fault)?;
    }
    let product = |of: &GarmentProducts| of.products.iter().map(|p| of.source.model.sibling_path(p.name)).collect();
    let paths: Vec<Result<Vec<_>, _>> = garments.iter().map(product).collect();
    let model = &garments[0].source.model;
    let mut author = Author { data, model, anchor: frame.anchor, is_overlay: !frame.flatten, sets };
    let bound = trims.author(&mut author, &mut warnings).map_err(fault)?;
    let paths = paths.into_iter().flatten().flatten().collect();
    [&*data].into_iter().chain(levels.iter().map(|(_, part)| part)).try_for_each(|data| check_finite(data, &paths))?;
    Ok((Authored { trims: bound, levels }, warnings))
}

/// Refuses arrays of products with a number that is not finite, as programs fail on these far from their cause. Inputs have none.
fn check_finite(data: &sdf::Data, products: &HashSet<sdf::Path>) -> Result<(), Error> {
    for (path, spec) in data.iter().filter(|(path, _)| products.contains(&path.prim_path())) {
        let values = spec.fields.iter().find(|(key, _)| *key == FieldKey::Default.as_str()).map(|(_, value)| value);
        let floats: &[f32] = match values {
            Some(Value::FloatVec(values)) => values,
            Some(Value::Vec2fVec(values)) => bytemuck::cast_slice(values),
            Some(Value::Vec3fVec(values)) => bytemuck::cast_slice(values),
            _ => continue,
        };
        if let Some(at) = floats.iter().position(|number| !number.is_finite()) {
            return Err(Error::internal(format!("{path} would have {} as its number {at}", floats[at])));
        }
    }
    Ok(())
}

fn check_names(model: &Model, products: &[Product]) -> Result<(), Error> {
    products.iter().try_for_each(|product| refuse_other(model, product.sibling()))?;
    let sim = products.iter().find(|product| product.role == ProductRole::Sim);
    let cloth = sim.and_then(|sim| Some((sim.name, sim.cloth?)));
    let written = cloth.into_iter().flat_map(|(sim, cloth)| {
        let panels = cloth.panels.then(|| beside(PANELS, sim));
        std::iter::once(beside(SCOPE, sim)).chain(panels)
    });
    let is_sewn = |sim: &&Product| sim.stitches.is_some_and(|stitches| !stitches.is_empty());
    let written = written.chain(sim.filter(is_sewn).map(|sim| beside(STITCHES, sim.name)));
    for name in written {
        refuse_other(model, &name)?;
        let is_ours = model.siblings.get(&name).is_none_or(|sibling| sibling.product);
        if !is_ours || model.has_panel(&name) || products.iter().any(|product| product.name == name) {
            let path = model.sibling_path(&name).or_unreadable(&model.path)?;
            let text = format!("{path} is taken by another prim, and cloth is written there");
            return Err(name_fault(text, "rename that prim, or write no physics by --physics none"));
        }
    }
    for (i, product) in products.iter().enumerate() {
        product.name.split('/').try_for_each(|name| check_name(product.role.name_flag(), name))?;
        if is_taken(model, product.sibling()) || products[..i].iter().any(|p| p.name == product.name) {
            return Err(taken(model, product.sibling(), product.role)?);
        }
    }
    Ok(())
}

/// Refuses a name of something that no prim can have.
///
/// # Errors
/// Such a name.
pub fn check_name(of: &str, name: &str) -> Result<(), Error> {
    let text = || format!("{of} {name:?} is not a name that a prim can have");
    let is_name = sdf::Path::is_valid_identifier(name).then_some(());
    is_name.ok_or_else(|| name_fault(text(), "use letters, digits and _, and no digit first"))
}

/// Refuses names of products that other prims have.
///
/// # Errors
/// Such a name.
pub fn check_product_names(source: &Source, names: &ProductNames) -> Result<(), Error> {
    let found = names.all().enumerate().find(|(_, name)| is_taken(&source.model, name));
    let Some((number, name)) = found else { return Ok(()) };
    let role = if number == 0 { ProductRole::Sim } else { ProductRole::Render };
    Err(taken(&source.model, name, role)?)
}

/// Whether a prim that is not a product has the name.
fn is_taken(model: &Model, name: &str) -> bool {
    model.siblings.get(name).is_some_and(|sibling| !sibling.product) || model.has_panel(name)
}

fn taken(model: &Model, name: &str, role: ProductRole) -> Result<Error, Error> {
    let path = model.sibling_path(name).or_unreadable(&model.path)?;
    let remedy = format!("rename that prim, or choose another name by {}", role.name_flag());
    Ok(name_fault(format!("{path} is taken by another prim"), &remedy))
}

/// A fault of a name, with its remedy.
pub fn name_fault(text: String, remedy: &str) -> Error {
    Error::usd(text).code(tailor_costume::codes::NAME_TAKEN).remedy(remedy)
}

/// Refuses a name that the product of another model has.
fn refuse_other(model: &Model, name: &str) -> Result<(), Error> {
    let Some(other) = model.siblings.get(name).and_then(|sibling| sibling.of_other.as_deref()) else { return Ok(()) };
    let [path, other] = [name, other].map(|name| model.sibling_path(name).or_unreadable(&model.path));
    let own = model.name().replace('/', "_");
    let text = format!("{} was made from {}, which it would hide", path?, other?);
    Err(name_fault(text, &format!("give it names of its own, such as --sim-name {own}_sim --render-name {own}_render")))
}

/// A layer over the input, without products.
pub fn overlay(model: &Model, frame: LayerContext) -> Result<sdf::Data, Error> {
    let root = sdf::Path::abs_root();
    let mut data = sdf::Data::new();
    data.create_spec(root.clone(), SpecType::PseudoRoot);
    let sublayer = match frame.sublayer {
        Some(path) => path.to_owned(),
        None => writable(frame.anchor.path_to(&as_named(&model.origin.file)?))?,
    };
    let offsets = Value::LayerOffsetVec(vec![LayerOffset::IDENTITY]);
    AbstractData::set_field(&mut data, &root, FieldKey::SubLayers.as_str(), Value::StringVec(vec![sublayer]));
    AbstractData::set_field(&mut data, &root, FieldKey::SubLayerOffsets.as_str(), offsets);
    for (key, value) in &model.stage_metadata {
        AbstractData::set_field(&mut data, &root, key, frame.anchor.restated(value.clone()));
    }
    Ok(data)
}
