//! The whole stage as one layer.

use super::crates::any;
use crate::assets::{Anchor, resolved, unwritable};
use crate::codes;
use crate::read::{COMPOSITION, Model, all_prims, prim_at};
use crate::record::{Content, Depth, NO_SPLINE, Record, metadata};
use openusd::sdf::{self, AbstractData, Data, FieldKey, Path, PrimSpec, SpecType, Specifier, Value};
use openusd::usd::{Prim, PrimPredicate, SpecSite, Stage};
use tailor_mesh::error::{Error, Warning, Warnings};

/// Metadata of the root layer that describes its composition.
const STACK: &[FieldKey] = &[
    FieldKey::SubLayers,
    FieldKey::SubLayerOffsets,
    FieldKey::LayerRelocates,
    FieldKey::ExpressionVariables,
    FieldKey::PrimOrder,
];

/// The stage of `model` as one self-contained layer, without the prims `left_out`. Instances become ordinary prims.
/// Properties that cannot be read become warnings.
///
/// # Errors
/// A stage that cannot be opened again.
pub fn flattened(model: &Model, left_out: &[Path], anchor: Anchor) -> Result<(Data, Warnings), Error> {
    let fault = |e: openusd::Error| {
        Error::usd(format!("{} cannot be flattened: {e}", model.origin.file.display())).code(codes::COMPOSITION_FAILED)
    };
    let stage = model.origin.open()?;
    let mut paths = all_prims(&stage, &model.origin.file, PrimPredicate::ALL, true)?;
    paths.retain(|path| !left_out.iter().any(|left| path.has_prefix(left)));
    let mut flat = Flat { data: Data::new(), anchor, warnings: Warnings::default() };
    flat.root(&stage).map_err(fault)?;
    for path in paths {
        flat.prim(&prim_at(&stage, &path)?).map_err(fault)?;
    }
    check_paths(&flat.data)?;
    // A layer that could not be read again is missing in what was composed.
    model.origin.check_unchanged()?;
    Ok((flat.data, flat.warnings))
}

/// Refuses files whose paths cannot be read back.
fn check_paths(data: &Data) -> Result<(), Error> {
    let is_bad = |value: &Value| match value {
        Value::AssetPath(path) => unwritable(path.as_str()).is_some(),
        Value::AssetPathVec(paths) => paths.iter().any(|path| unwritable(path.as_str()).is_some()),
        _ => false,
    };
    for (path, spec) in data.iter() {
        if let Some((key, _)) = spec.fields.iter().find(|(_, value)| any(value, &is_bad)) {
            let text = format!(
                "{key} of {path} names a file with a control character or @@@ in its path, which a USD file cannot refer to"
            );
            return Err(Error::usd(text).remedy("rename the file or its folder"));
        }
    }
    Ok(())
}

struct Flat<'a> {
    data: Data,
    anchor: Anchor<'a>,
    warnings: Warnings,
}

impl Flat<'_> {
    fn root(&mut self, stage: &Stage) -> openusd::Result<()> {
        let root = Path::abs_root();
        self.data.create_spec(root.clone(), SpecType::PseudoRoot);
        let site = |layer| SpecSite { layer, path: root.clone(), offset: sdf::LayerOffset::IDENTITY };
        let sites: Vec<_> = stage.layer_stack().into_iter().map(site).collect();
        let fields = metadata(stage, &root, &sites)?;
        self.metadata(stage, &root, &sites, fields, STACK);
        Ok(())
    }

    fn prim(&mut self, prim: &Prim) -> openusd::Result<()> {
        let path = prim.path();
        let specifier = prim.specifier()?.unwrap_or(Specifier::Over);
        PrimSpec::new(&mut self.data, path, specifier, prim.type_name()?.as_ref().map_or("", |t| t.as_str()))?;
        let sites = prim.prim_stack()?;
        let fields = metadata(prim.stage(), path, &sites)?;
        self.metadata(prim.stage(), path, &sites, fields, COMPOSITION);
        let schemas = prim.authored_api_schemas()?;
        if !schemas.is_empty() {
            let list = sdf::TokenListOp::explicit(schemas);
            AbstractData::set_field(&mut self.data, path, FieldKey::ApiSchemas.as_str(), list.into());
        }
        for name in prim.authored_property_names()? {
            match Record::take(prim, &name, Depth::Whole) {
                Ok(Some(record)) => {
                    self.report_missing(path, &record);
                    if record.has_spline {
                        self.not_carried(format!("{path}.{name}"), NO_SPLINE.to_owned());
                    }
                    record.author(&mut self.data, path, self.anchor)?;
                }
                Ok(None) => {}
                Err(e) => self.not_carried(format!("{path}.{name}"), format!("it cannot be read: {e}")),
            }
        }
        Ok(())
    }

    fn metadata(
        &mut self,
        stage: &Stage,
        path: &Path,
        sites: &[SpecSite],
        fields: Vec<(String, Value)>,
        left_out: &[FieldKey],
    ) {
        for (key, value) in fields {
            if !left_out.iter().any(|k| k.as_str() == key) {
                let value = resolved(value, stage, sites);
                self.report_unresolved(path, value.clone());
                AbstractData::set_field(&mut self.data, path, &key, self.anchor.restated(value));
            }
        }
    }

    fn report_missing(&mut self, prim: &Path, record: &Record) {
        if let Content::Attribute { default, samples, .. } = &record.content {
            let samples = samples.iter().flatten().map(|(_, value)| value);
            for value in default.iter().chain(samples).filter(|v| v.is_asset_valued()) {
                self.report_unresolved(prim, value.clone());
            }
        }
    }

    /// Reports asset paths of missing files, which keep their text.
    fn report_unresolved(&mut self, path: &Path, value: Value) {
        value.map_asset_paths(&mut |asset| {
            if asset.resolved_path().is_none() && !asset.is_empty() {
                let why = "the file was not found; its path is kept unchanged".to_owned();
                self.not_carried(format!("the file @{}@ of {path}", asset.asset_path()), why);
            }
            asset
        });
    }

    fn not_carried(&mut self, what: String, why: String) {
        self.warnings.push(Warning::not_carried(what, why));
    }
}
