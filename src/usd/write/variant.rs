//! Products of a variant: opinions inside the variant, beside those of the other variants.

use crate::read::{Selection, joined};
use openusd::sdf::{self, AbstractData, CopyChildren, CopyValue, Data, FieldKey, Path, PrimSpec, Value};

/// Copies what `part` says of the prim of the last one of `selections`, and of all below it, into that variant in `data`, which is
/// within the variants before it. Prims above it have nothing to copy.
///
/// # Errors
/// Names that a variant cannot have.
pub fn copy_into_variant(data: &mut Data, part: &Data, selections: &[&Selection]) -> openusd::Result<()> {
    let (mut owner, mut prim) = (Path::abs_root(), Path::abs_root());
    for selection in selections {
        let path = Path::new(&selection.prim)?;
        let below = path.as_str().strip_prefix(prim.as_str()).unwrap_or_default();
        let place = joined(owner, below)?;
        if !data.has_spec(&place) {
            PrimSpec::over(data, &place)?;
        }
        if !data.has_spec(&place.append_variant_selection(&selection.set, "")?) {
            let names = sdf::StringListOp { prepended_items: vec![selection.set.clone()], ..Default::default() };
            AbstractData::set_field(data, &place, FieldKey::VariantSetNames.as_str(), Value::StringListOp(names));
        }
        (owner, prim) = (place.append_variant_selection(&selection.set, &selection.choice)?, path);
    }
    sdf::copy_spec_with(part, &prim, data, &owner, |_| CopyValue::Copy, |_| CopyChildren::All)?;
    Ok(())
}
