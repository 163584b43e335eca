//! Products into layers, layers into files.

use super::assets::Place;
use super::crates::take_out_unwritable;
use super::flatten::flattened;
use super::long_arrays::encode_plainly;
use super::model::Model;
use super::product::{Author, beside};
use super::read::Source;
use super::save::Target;
use super::{UsdError, on_large_stack};
use crate::error::Warnings;
use crate::garment::Garment;
use openusd::sdf::{self, AbstractData, LayerOffset, SpecType};
use openusd::usda::TextWriter;
use std::path::Path;

pub use super::save::Format;

/// What a product is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProductRole {
    /// Cloth simulation: triangles, no subdivision, purpose `guide`.
    Sim,
    /// Rendering: a subdivision cage, purpose `default`.
    Render,
}

impl ProductRole {
    /// Its name in `customData`, and that of its prim unless another is chosen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sim => "sim",
            Self::Render => "render",
        }
    }

    /// Its `purpose`.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::Sim => "guide",
            Self::Render => "default",
        }
    }

    /// The flag that names it.
    fn name_flag(self) -> &'static str {
        match self {
            Self::Sim => "--sim-name",
            Self::Render => "--render-name",
        }
    }
}

/// A mesh to be written beside the model.
#[derive(Clone, Copy, Debug)]
pub struct Product<'a> {
    /// Name of its prim.
    pub name: &'a str,
    /// What it is for.
    pub role: ProductRole,
    /// The mesh.
    pub mesh: &'a Garment,
}

/// How products are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteOptions {
    /// One self-contained layer instead of one that sublayers the input. A `.usdz` package always is.
    pub flatten: bool,
    /// Overwrite a file that is there already.
    pub force: bool,
    /// Give the model the purpose `guide`, so that a viewer does not draw it on top of the render mesh.
    pub model_guide: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { flatten: false, force: false, model_guide: true }
    }
}

/// Writes `products` beside the model of `source` into the file `out`, whose name decides the format. The file is
/// complete or is not there; the input and its layers are never written to.
///
/// # Errors
/// A name that is taken, a file that may not or cannot be written.
pub fn write(
    source: &Source,
    products: &[Product],
    out: &Path,
    options: &WriteOptions,
    warnings: &mut Warnings,
) -> Result<(), UsdError> {
    let target = Target::find(out, &source.model.layers, options.force)?;
    on_large_stack(|| {
        if target.format == Format::Usdz {
            let layout = Layout { flatten: true, place: Place::Anywhere, sublayer: None };
            let data = compose(source, products, layout, options.model_guide, warnings)?;
            return target.save_package(&data, warnings);
        }
        let layout = Layout { flatten: options.flatten, place: Place::Folder(&target.folder), sublayer: None };
        let data = compose(source, products, layout, options.model_guide, warnings)?;
        target.save(data, warnings)
    })
}

/// Whether [`write()`] may write to `out`, before the work that leads there.
///
/// # Errors
/// A format that is unknown, an output that is there already or is part of the input, a folder that is missing.
pub fn check_target(source: &Source, out: &Path, force: bool) -> Result<(), UsdError> {
    Target::find(out, &source.model.layers, force).map(drop)
}

/// How a layer in memory states other files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings<'a> {
    /// The folder that the layer is read from: asset paths are relative to it; absolute without one.
    pub folder: Option<&'a Path>,
    /// The asset path of the source; that of its file when not given.
    pub source: Option<&'a str>,
}

/// The layer that [`write()`] would write, in memory: text (`Usda`) or crate (`Usdc`), which is quick to read and write but
/// larger than a file.
///
/// # Errors
/// As [`write()`]; and `Usdz`, which is a package and no layer.
pub fn layer_bytes(
    source: &Source,
    products: &[Product],
    format: Format,
    surroundings: Surroundings,
    options: &WriteOptions,
    warnings: &mut Warnings,
) -> Result<Vec<u8>, UsdError> {
    let folder = surroundings.folder.map(|f| f.canonicalize().unwrap_or_else(|_| f.to_path_buf()));
    on_large_stack(|| {
        let place = folder.as_deref().map_or(Place::Anywhere, Place::Folder);
        let layout = Layout { flatten: options.flatten, place, sublayer: surroundings.source };
        let mut data = compose(source, products, layout, options.model_guide, warnings)?;
        match format {
            Format::Usda => TextWriter::write_to_string(&data)
                .map(String::into_bytes)
                .map_err(|e| UsdError::new(format!("the layer cannot be written as text: {e}"))),
            Format::Usdc => {
                take_out_unwritable(&mut data, warnings);
                encode_plainly(&mut data)
            }
            Format::Usdz => Err(UsdError::new("a .usdz package is not a layer").hint("choose text or crate")),
        }
    })
}

/// What a layer holds besides the products, and how it states files.
#[derive(Clone, Copy)]
struct Layout<'a> {
    flatten: bool,
    place: Place<'a>,
    /// The source's asset path, where it is not that of its file.
    sublayer: Option<&'a str>,
}

/// The layer with the products.
fn compose(
    source: &Source,
    products: &[Product],
    layout: Layout,
    model_guide: bool,
    warnings: &mut Warnings,
) -> Result<sdf::Data, UsdError> {
    let Layout { flatten, place, .. } = layout;
    let model = &source.model;
    check_names(model, products)?;
    let fault = |e: openusd::Error| UsdError::new(format!("the layer cannot be composed: {e}"));
    let mut data = if flatten {
        let replaced = products.iter().filter_map(|p| beside(&model.path, p.name).ok()).collect::<Vec<_>>();
        flattened(model, &replaced, place, warnings)?
    } else {
        overlay(model, layout)?
    };
    // A flattened layer holds nothing of an earlier product any more.
    let mut alone = model.clone();
    if flatten {
        alone.siblings.clear();
    }
    let mut author = Author { data: &mut data, model: &alone, place };
    for product in products {
        author.product(product, warnings).map_err(fault)?;
    }
    if model_guide {
        author.model_purpose(ProductRole::Sim.purpose()).map_err(fault)?;
    }
    Ok(data)
}

fn check_names(model: &Model, products: &[Product]) -> Result<(), UsdError> {
    for (i, product) in products.iter().enumerate() {
        let flag = product.role.name_flag();
        if !sdf::Path::is_valid_identifier(product.name) {
            return Err(UsdError::new(format!("{flag} {:?} is not a name that a prim can have", product.name))
                .hint("use letters, digits and _, and no digit first"));
        }
        let taken = model.siblings.get(product.name).is_some_and(|s| !s.product)
            || model.path.name() == Some(product.name)
            || products[..i].iter().any(|p| p.name == product.name);
        if taken {
            let path = beside(&model.path, product.name).map_err(|e| UsdError::new(e.to_string()))?;
            return Err(UsdError::new(format!("{path} is taken by another prim"))
                .hint(format!("rename that prim, or choose another name by {flag}")));
        }
    }
    Ok(())
}

/// An empty layer over the input.
fn overlay(model: &Model, layout: Layout) -> Result<sdf::Data, UsdError> {
    let root = sdf::Path::abs_root();
    let mut data = sdf::Data::new();
    data.create_spec(root.clone(), SpecType::PseudoRoot);
    let sublayer = match layout.sublayer {
        Some(stated) => stated.to_owned(),
        None => layout.place.path_to(&absolute(&model.origin.file)?),
    };
    let mut holder = sdf::Layer::new_anonymous("overlay");
    holder
        .edit(|edit| {
            edit.pseudo_root_mut()?.insert_sublayer(0, sublayer, LayerOffset::IDENTITY);
            Ok(())
        })
        .map_err(|e| UsdError::new(e.to_string()))?;
    for key in holder.data().list_fields(&root).unwrap_or_default() {
        let value = holder.data().get_field(&root, &key).map_err(|e| UsdError::new(e.to_string()))?;
        AbstractData::set_field(&mut data, &root, &key, value.into_owned());
    }
    for (key, value) in &model.stage_metadata {
        AbstractData::set_field(&mut data, &root, key, layout.place.anchor(value.clone()));
    }
    Ok(data)
}

/// The input's own path without links in its folders; the file's name stays, though it may be a link.
fn absolute(file: &Path) -> Result<String, UsdError> {
    let fault = || UsdError::new(format!("cannot find the folder of {}", file.display()));
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().map_err(|_| fault())?;
    let path = folder.join(file.file_name().ok_or_else(fault)?);
    path.to_str().map(str::to_owned).ok_or_else(fault)
}
