//! Sets of elements as subsets of the model, in a layer over the stage.

use super::layer::{LayerContext, SetChoice, overlay};
use super::product::Author;
use super::save::OutputFile;
use crate::error::{Error, ErrorCode};
use crate::garment::{Mesh, Subset};
use crate::usd::assets::Anchor;
use crate::usd::on_large_stack;
use crate::usd::read::Source;
use openusd::sdf;
use std::path::Path;
use std::sync::Arc;

/// Writes `sets` as subsets of the model of `source` into a layer over its file.
///
/// # Errors
/// Panels that are sewn together, a name that is taken or not valid, a file that may not or cannot be written.
pub fn write_sets(source: &Source, sets: Vec<Subset>, out: &Path, force: bool) -> Result<(), Error> {
    let model = &source.model;
    let fault = |text: String| Error::usd(text).code(ErrorCode::NameTaken);
    if model.is_sewn() {
        let text = format!("{} is sewn of several meshes, and sets are of one", source.whole());
        return Err(fault(text).code(ErrorCode::SeveralMeshes).remedy("name one of the meshes by --prim"));
    }
    for set in &sets {
        if !sdf::Path::is_valid_identifier(&set.name) {
            let text = format!("{:?} is not a name that a prim can have", set.name);
            return Err(fault(text).remedy("use letters, digits and _, and no digit first"));
        }
        if model.subsets.contains_key(&set.name) {
            return Err(fault(format!("{} has a subset {}", model.path, set.name)).remedy("choose another name"));
        }
    }
    let file = OutputFile::find(out, |file| model.uses(file), force)?;
    on_large_stack(|| {
        let anchor = Anchor::Folder(&file.folder);
        let mut data = overlay(model, LayerContext { flatten: false, anchor, sublayer: None })?;
        let mesh = Mesh { subsets: Arc::new(sets), ..Mesh::default() };
        let fault = |e: openusd::Error| {
            Error::usd(format!("the layer cannot be composed: {e}")).code(ErrorCode::CompositionFailed)
        };
        sdf::PrimSpec::over(&mut data, &model.path).map_err(|e| fault(e.into()))?;
        let mut author = Author { data: &mut data, model, anchor, is_overlay: true, sets: SetChoice::All };
        author.subsets(&model.path, &mesh).map_err(fault)?;
        file.save(data).map(drop)
    })
}
