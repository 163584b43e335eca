//! Products of a variant: opinions inside the variant, beside those of the other variants.

use crate::usd::read::Selection;
use openusd::sdf::{self, AbstractData, ChildrenKey, Data, FieldKey, Path, PrimSpec, SpecType, Specifier, Value};
use openusd::tf::Token;

/// Moves what `part` says of the prim of `selection`, and of all below it, into that variant in `data`. Prims above it have
/// nothing to move.
///
/// # Errors
/// Names that a variant cannot have.
pub fn move_into_variant(data: &mut Data, part: &Data, selection: &Selection) -> openusd::Result<()> {
    let prim = Path::new(&selection.prim)?;
    let variant = variant_at(data, &prim, selection)?;
    for (path, _) in part.iter().filter(|(path, _)| path.has_prefix(&prim)) {
        let Some(to) = path.replace_prefix(&prim, &variant) else { continue };
        if to != variant
            && let Some(kind) = part.spec_type(path)
        {
            AbstractData::create_spec(data, to.clone(), kind);
        }
        for field in part.list_fields(path).unwrap_or_default() {
            if let Some(value) = part.try_field(path, &field)? {
                let value = value.into_owned();
                AbstractData::set_field(data, &to, &field, value);
            }
        }
    }
    Ok(())
}

/// The path of a variant, which is created together with its set.
fn variant_at(data: &mut Data, prim: &Path, selection: &Selection) -> openusd::Result<Path> {
    PrimSpec::over(data, prim)?;
    let set = prim.append_variant_selection(&selection.set, "")?;
    if !data.has_spec(&set) {
        AbstractData::create_spec(data, set.clone(), SpecType::VariantSet);
        add_child(data, prim, ChildrenKey::VariantSetChildren, &selection.set)?;
        let names = sdf::StringListOp { prepended_items: vec![selection.set.clone()], ..sdf::StringListOp::default() };
        AbstractData::set_field(data, prim, FieldKey::VariantSetNames.as_str(), Value::StringListOp(names));
    }
    let variant = prim.append_variant_selection(&selection.set, &selection.choice)?;
    if !data.has_spec(&variant) {
        AbstractData::create_spec(data, variant.clone(), SpecType::Variant);
        AbstractData::set_field(data, &variant, FieldKey::Specifier.as_str(), Value::Specifier(Specifier::Over));
        add_child(data, &set, ChildrenKey::VariantChildren, &selection.choice)?;
    }
    Ok(variant)
}

fn add_child(data: &mut Data, parent: &Path, key: ChildrenKey, name: &str) -> openusd::Result<()> {
    let mut names = match data.try_field(parent, key.as_str())?.as_deref() {
        Some(Value::TokenVec(names)) => names.clone(),
        _ => Vec::new(),
    };
    names.push(Token::from(name));
    AbstractData::set_field(data, parent, key.as_str(), Value::TokenVec(names));
    Ok(())
}
