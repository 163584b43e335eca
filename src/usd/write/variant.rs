//! Products of a variant: opinions inside the variant, beside those of the other variants.

use crate::usd::read::Selection;
use openusd::sdf::{self, AbstractData, CopyChildren, CopyValue, Data, FieldKey, Path, PrimSpec, Value};

/// Copies what `part` says of the prim of `selection`, and of all below it, into that variant in `data`. Prims above it have
/// nothing to copy.
///
/// # Errors
/// Names that a variant cannot have.
pub fn copy_into_variant(data: &mut Data, part: &Data, selection: &Selection) -> openusd::Result<()> {
    let prim = Path::new(&selection.prim)?;
    PrimSpec::over(data, &prim)?;
    let is_new = !data.has_spec(&prim.append_variant_selection(&selection.set, "")?);
    let variant = prim.append_variant_selection(&selection.set, &selection.choice)?;
    sdf::copy_spec_with(part, &prim, data, &variant, |_| CopyValue::Copy, |_| CopyChildren::All)?;
    if is_new {
        let names = sdf::StringListOp { prepended_items: vec![selection.set.clone()], ..sdf::StringListOp::default() };
        AbstractData::set_field(data, &prim, FieldKey::VariantSetNames.as_str(), Value::StringListOp(names));
    }
    Ok(())
}
