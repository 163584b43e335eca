//! Our own reader opens each output once, before it replaces anything.

use crate::codes;
use crate::read::Files;
use openusd::sdf::{Data, FieldKey, Layer, Specifier, Value};
use std::path::Path;
use tailor_mesh::error::Error;

/// The fields that are compared: those that define prims, and values.
const COMPARED: [FieldKey; 4] = [FieldKey::Specifier, FieldKey::TypeName, FieldKey::Default, FieldKey::TimeSamples];

/// Checks that a file shows the prims and properties of `data`, with the same points and as many values.
///
/// # Errors
/// A file that cannot be opened, or shows something else.
pub fn check(data: &Data, file: &Path) -> Result<(), Error> {
    compare(data, file, |key| COMPARED.iter().any(|compared| compared.as_str() == key), is_as_written)
}

/// As [`check`], with all fields and values.
///
/// # Errors
/// As [`check`].
pub fn check_whole(data: &Data, file: &Path) -> Result<(), Error> {
    compare(data, file, |_| true, |own, read| own == read)
}

fn compare(
    data: &Data,
    file: &Path,
    is_compared: impl Fn(&str) -> bool,
    is_same: impl Fn(&Value, &Value) -> bool,
) -> Result<(), Error> {
    let fault = |text: String| {
        let remedy = "check the disk, or write to a new file and sublayer it; nothing was replaced";
        Error::usd(text).code(codes::NOT_WRITTEN_BACK).remedy(remedy)
    };
    let layer = Layer::open_with(Files::default(), file.to_string_lossy());
    let layer = layer.map_err(|e| fault(format!("what was written cannot be opened: {e}")))?;
    let read = layer.data();
    let differs = |path, key: &str, own: &Value| {
        let is_read = || matches!(read.try_field(path, key), Ok(Some(read)) if is_same(own, &read));
        is_compared(key) && !is_implied(own) && !is_read()
    };
    let other = data.iter().find(|(path, spec)| {
        read.spec_type(path) != Some(spec.ty) || spec.fields.iter().any(|(key, own)| differs(path, key, own))
    });
    match other {
        Some((path, _)) => Err(fault(format!("{path} does not read back as it was written"))),
        None => Ok(()),
    }
}

/// True for a specifier that crate files leave out.
fn is_implied(value: &Value) -> bool {
    *value == Value::Specifier(Specifier::Over)
}

fn is_as_written(own: &Value, read: &Value) -> bool {
    match (own, read) {
        (Value::Vec3fVec(own), Value::Vec3fVec(read)) => {
            let [own, read] = [own, read].map(|points| bytemuck::cast_slice::<_, f32>(points));
            let is_same = |(own, read): (&f32, &f32)| own == read || own.is_nan() && read.is_nan();
            own.len() == read.len() && own.iter().zip(read).all(is_same)
        }
        (Value::TimeSamples(own), Value::TimeSamples(read)) => {
            let is_same =
                |((time, own), (at, read)): (&(f64, Value), &(f64, Value))| time == at && is_as_written(own, read);
            own.len() == read.len() && own.iter().zip(read).all(is_same)
        }
        (Value::Specifier(_) | Value::Token(_), _) => own == read,
        _ => own.array_len() == read.array_len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write::OutputFile;
    use openusd::sdf::{self, AbstractData, AttributeSpec, PrimSpec, SpecType, ValueTypeName, Variability};

    fn data() -> Data {
        let mut data = Data::new();
        let mesh = sdf::Path::new("/coat").expect("a path");
        data.create_spec(sdf::Path::abs_root(), SpecType::PseudoRoot);
        PrimSpec::new(&mut data, &mesh, Specifier::Def, "Mesh").expect("a prim");
        let points = Value::Vec3fVec(vec![[0.5, f32::NAN, 2.0].into(), [1e20, -0.1, 3.0].into()]);
        let counts = Value::IntVec(vec![3, 4]);
        for (name, kind, value) in
            [("points", ValueTypeName::POINT3F_ARRAY, points), ("counts", ValueTypeName::INT_ARRAY, counts)]
        {
            let path = mesh.append_property(name).expect("a path");
            AttributeSpec::new(&mut data, &path, kind, Variability::Varying, false).expect("an attribute");
            AbstractData::set_field(&mut data, &path, FieldKey::Default.as_str(), value);
        }
        data
    }

    #[test]
    fn a_layer_that_reads_back_is_good_and_another_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.usda", "a.usdc", "a.usdz"] {
            let file = folder.path().join(name);
            OutputFile::find(&file, |_| Ok(false), false).and_then(|to| to.save(data())).expect(name);
            check(&data(), &file).expect(name);
        }
        let (file, text) = (folder.path().join("a.usda"), std::fs::read_to_string(folder.path().join("a.usda")));
        let text = text.expect("text");
        for (old, new) in [
            ("def Mesh", "over Mesh"),
            ("def Mesh", "def Xform"),
            ("def Mesh \"coat\"", "def Mesh \"hat\""),
            ("[3, 4]", "[3, 4, 5]"),
            ("(0.5, ", "(0.25, "),
            ("counts", "others"),
            ("}", ""),
        ] {
            assert!(text.contains(old), "{text}");
            std::fs::write(&file, text.replacen(old, new, 1)).expect("a file");
            let fault = check(&data(), &file).expect_err(new);
            assert_eq!(fault.faults[0].code, codes::NOT_WRITTEN_BACK, "{new}");
        }
    }
}
