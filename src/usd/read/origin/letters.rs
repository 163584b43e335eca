//! Letters beyond ASCII in the words of a text layer, such as the names of properties.
//!
//! OpenUSD reads them. The library has them in layers and in crate files, but its reader of text has words of ASCII alone.
//! Such a text is read with ASCII in their place. The layer with its own letters then goes to the library as a crate.

use openusd::sdf::{AbstractData, Data, Path, SpecData, Value};
use openusd::tf::Token;
use openusd::usda;
use openusd::usdc::CrateWriter;
use std::collections::HashMap;
use std::io::{self, Cursor, Write};

/// Beginnings of escapes that are tried. A text that has all of them is made to have them.
const MOST_MARKERS: usize = 1000;

/// Writes letters beyond ASCII as a marker, the hexadecimal digits of their bytes, and `_`.
pub struct Letters {
    /// The text has it nowhere.
    marker: String,
}

impl Letters {
    /// With a marker that `text` does not have; none if it has all of them.
    pub fn of(text: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(text).ok()?;
        let marker =
            (0..MOST_MARKERS).map(|number| format!("letters{number}_")).find(|marker| !text.contains(marker))?;
        Some(Self { marker })
    }

    /// A word in ASCII.
    pub fn escaped(&self, word: &[u8]) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.marker.len() + 3 * word.len());
        for run in word.chunk_by(|a, b| a.is_ascii() == b.is_ascii()) {
            if run.is_ascii() {
                out.extend_from_slice(run);
                continue;
            }
            out.extend_from_slice(self.marker.as_bytes());
            run.iter().for_each(|byte| write!(out, "{byte:02x}").expect("memory takes all that is written"));
            out.push(b'_');
        }
        out
    }

    /// A text with its letters; none if it has no escape.
    fn restored(&self, text: &str) -> Option<String> {
        let (first, rest) = text.split_once(&self.marker)?;
        let mut out = first.to_owned();
        for part in rest.split(&self.marker) {
            let (digits, rest) = part.split_once('_')?;
            let bytes =
                digits.as_bytes().chunks(2).map(|two| u8::from_str_radix(std::str::from_utf8(two).ok()?, 16).ok());
            out.push_str(&String::from_utf8(bytes.collect::<Option<Vec<u8>>>()?).ok()?);
            out.push_str(rest);
        }
        Some(out)
    }

    /// The layer of an escaped text, as a crate with the letters of the text.
    ///
    /// # Errors
    /// A text that cannot be parsed, a name that layers cannot have, a value that crates cannot have.
    pub fn encode(&self, text: &[u8]) -> io::Result<Vec<u8>> {
        let text = std::str::from_utf8(text).map_err(io::Error::other)?;
        let data = usda::parse(text).map_err(|e| io::Error::other(self.in_words(&e.to_string())))?;
        let mut out = Cursor::new(Vec::new());
        CrateWriter::write(&self.restore(data)?, &mut out)
            .map_err(|e| io::Error::other(self.in_words(&e.to_string())))?;
        Ok(out.into_inner())
    }

    fn in_words(&self, words: &str) -> String {
        self.restored(words).unwrap_or_else(|| words.to_owned())
    }

    /// A layer with the names that its text has.
    fn restore(&self, mut data: Data) -> io::Result<Data> {
        let mut specs = HashMap::with_capacity(data.len());
        for path in data.spec_paths() {
            let Some(mut spec) = data.erase_spec(&path) else { continue };
            self.restore_fields(&mut spec);
            let path = match self.restored(path.as_str()) {
                Some(path) => Path::new(&path).map_err(io::Error::other)?,
                None => path,
            };
            specs.insert(path, spec);
        }
        Ok(Data::from_specs(specs))
    }

    fn restore_fields(&self, spec: &mut SpecData) {
        for (key, _) in &mut spec.fields {
            self.restore_name(key);
        }
        // Dictionaries may be in dictionaries to any depth.
        let mut open: Vec<&mut Value> = spec.fields.iter_mut().map(|(_, value)| value).collect();
        while let Some(value) = open.pop() {
            match value {
                Value::Dictionary(entries) | Value::UnregisteredDictionary(entries) => {
                    self.restore_keys(entries);
                    open.extend(entries.values_mut());
                }
                Value::VariantSelectionMap(selections) => self.restore_keys(selections),
                Value::Token(name) => self.restore_token(name),
                Value::TokenVec(names) => names.iter_mut().for_each(|name| self.restore_token(name)),
                Value::StringVec(words) => words.iter_mut().for_each(|word| self.restore_name(word)),
                Value::UnregisteredValue(text) => self.restore_name(text),
                Value::UnregisteredValueListOp(all) => {
                    let lists = [&mut all.explicit_items, &mut all.added_items, &mut all.prepended_items];
                    let more = [&mut all.appended_items, &mut all.deleted_items, &mut all.ordered_items];
                    lists.into_iter().chain(more).flatten().for_each(|text| self.restore_name(text));
                }
                _ => {}
            }
        }
    }

    fn restore_name(&self, name: &mut String) {
        if let Some(restored) = self.restored(name) {
            *name = restored;
        }
    }

    fn restore_token(&self, name: &mut Token) {
        if let Some(restored) = self.restored(name.as_str()) {
            *name = restored.into();
        }
    }

    fn restore_keys<V>(&self, entries: &mut HashMap<String, V>) {
        let escaped: Vec<(String, String)> =
            entries.keys().filter_map(|key| Some((key.clone(), self.restored(key)?))).collect();
        for (key, restored) in escaped {
            if let Some(value) = entries.remove(&key) {
                entries.insert(restored, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::text::readable;
    use super::*;
    use openusd::sdf::{ChildrenKey, FileFormat, LayerData};
    use openusd::usdc::UsdcFileFormat;

    fn escaped(text: &str) -> (Vec<u8>, Letters) {
        let read = readable(text.as_bytes());
        (read.text.into_owned(), read.letters.expect("letters beyond ASCII"))
    }

    fn layer(text: &str) -> LayerData {
        let (text, letters) = escaped(text);
        let bytes = letters.encode(&text).expect("a layer");
        UsdcFileFormat.read_bytes(bytes.into(), "test").expect("a crate")
    }

    fn field(layer: &LayerData, path: &str, name: &str) -> Value {
        layer.get_field(&Path::new(path).expect("a path"), name).expect(name).into_owned()
    }

    #[test]
    fn names_have_their_letters() {
        let layer = layer(
            r#"#usda 1.0
def Mesh "Hülle" (
    variants = { string größe = "klein" }
    customData = { dictionary äußere = { int[] "日本" = [1, 2] } }
    eigenes_maß = 3
)
{
    float[] primvars:größe = [0.5] ( interpolation = "constant" )
    int[] primvars:größe:indices = [0]
    half2 a = (1, 2)
    rel ziele = [</Hülle.primvars:größe>, <../Hülle.naïve>]
    float naïve.connect = </Hülle.primvars:größe>
    float naïve.timeSamples = { 1: 0.5, 2: 1 }
}
"#,
        );
        let names = ["primvars:größe", "primvars:größe:indices", "a", "ziele", "naïve"].map(Token::from);
        assert_eq!(field(&layer, "/Hülle", ChildrenKey::PropertyChildren.as_str()), Value::TokenVec(names.to_vec()));
        assert_eq!(field(&layer, "/Hülle.primvars:größe", "default"), Value::FloatVec(vec![0.5]));
        assert_eq!(field(&layer, "/Hülle.primvars:größe:indices", "default"), Value::IntVec(vec![0]));
        assert!(
            matches!(field(&layer, "/Hülle.naïve", "timeSamples"), Value::TimeSamples(samples) if samples.len() == 2)
        );
        assert_eq!(field(&layer, "/Hülle", "eigenes_maß"), Value::UnregisteredValue("3".into()));
        let Value::VariantSelectionMap(variants) = field(&layer, "/Hülle", "variantSelection") else { panic!() };
        assert_eq!(variants["größe"], "klein");
        let Value::Dictionary(outer) = field(&layer, "/Hülle", "customData") else { panic!() };
        let Value::Dictionary(inner) = &outer["äußere"] else { panic!() };
        assert_eq!(inner["日本"], Value::IntVec(vec![1, 2]));
        let Value::Vec2h(half) = field(&layer, "/Hülle.a", "default") else { panic!() };
        assert_eq!((half.x.to_f32(), half.y.to_f32()), (1.0, 2.0));
    }

    #[test]
    fn targets_are_those_of_the_text() {
        let layer = layer("#usda 1.0\ndef \"A\" { rel ö = [</A.ö>, <../A.ü>]\nfloat ü.connect = </A.ö> }");
        for (property, key, expected) in
            [("/A.ö", "targetPaths", &["/A.ö", "/A.ü"][..]), ("/A.ü", "connectionPaths", &["/A.ö"])]
        {
            let Value::PathListOp(targets) = field(&layer, property, key) else { panic!("{key}") };
            let targets = targets.flatten();
            assert_eq!(targets.iter().map(Path::as_str).collect::<Vec<_>>(), expected, "{property}");
        }
    }

    #[test]
    fn faults_have_the_words_of_the_text() {
        for (text, expected) in
            [("#usda 1.0\ndef \"A\" { größe }", "größe"), ("#usda 1.0\ndef \"A\" { float a\u{a0} = 1 }", "/A.a")]
        {
            let (text, letters) = escaped(text);
            let fault = letters.encode(&text).expect_err("no layer");
            assert!(fault.to_string().contains(expected), "{fault}");
        }
    }

    #[test]
    fn dictionaries_are_read_as_deep_as_crates_have_them() {
        let nested = |levels: usize| {
            let (open, close) = ("dictionary ö = { ".repeat(levels), " }".repeat(levels));
            format!("#usda 1.0\n( customLayerData = {{ {open}int ä = 1{close} }} )")
        };
        let Value::Dictionary(mut entries) = field(&layer(&nested(20)), "/", "customLayerData") else { panic!() };
        for _ in 0..20 {
            let Some(Value::Dictionary(inner)) = entries.remove("ö") else { panic!("{entries:?}") };
            entries = inner;
        }
        assert_eq!(entries["ä"], Value::Int(1));
        let (text, letters) = escaped(&nested(900));
        let fault = letters.encode(&text).expect_err("too deep");
        assert!(fault.to_string().contains("nested"), "{fault}");
    }
}
