//! The OpenUSD plugin for the file format `.tailor`. A `.tailor` file opens as the layer that `usdtailor build` writes.
//!
//! The C++ in this folder implements OpenUSD's file-format interface: it finds the source, composes it and fills the
//! layer. This crate parses recipes and generates the layer with [`tailor`]. `cargo xtask plugin` builds both into one
//! library.

mod fields;
mod generate;

use ffi::{Argument, Field, Generated};
use generate::Document;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cxx::bridge(namespace = "tailor")]
mod ffi {
    /// A file-format argument.
    struct Argument {
        key: String,
        value: String,
    }

    /// An attribute that a dynamic payload reads, such as `tailor:sim:maxEdgeLength`, and its file-format argument.
    struct Field {
        attribute: String,
        argument: String,
    }

    /// A layer as crate (`.usdc`) bytes, with new warnings.
    struct Generated {
        layer: Vec<u8>,
        warnings: Vec<String>,
    }

    // C++ creates vectors of this type.
    impl Vec<Argument> {}

    extern "Rust" {
        type Document;

        /// Parses the text of a `.tailor` file (JSON) and the arguments that it was opened with.
        fn read_document(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Box<Document>>;

        /// The asset path of the source as written in the file, relative to it.
        fn source(self: &Document) -> &str;

        /// Generates the layer that `usdtailor build` writes. `flattened` is the composed source as crate bytes.
        fn generate(document: &Document, flattened: &[u8], metadata_only: bool) -> Result<Generated>;

        /// The attributes that a dynamic payload reads. Names of seams and folds come from the text of its
        /// `.tailor` file, the schemas of its prim as OpenUSD prints them, and its arguments.
        fn fields(recipe: &[u8], schemas: &str, arguments: &str) -> Vec<Field>;

        /// `true` if an attribute can be one of those.
        fn is_field(attribute: &str) -> bool;

        /// The shortest text that parses to the same number. The text is part of a layer's identity.
        fn float_text(number: f32) -> String;

        /// The shortest text that parses to the same number.
        fn double_text(number: f64) -> String;
    }
}

/// The command `usdtailor`, for the launcher of the Python package. It returns the exit code.
#[cfg(feature = "core")]
#[unsafe(no_mangle)]
pub extern "C" fn usdtailor_main() -> std::ffi::c_int {
    usdtailor::main().into()
}

fn read_document(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Box<Document>, String> {
    let read = || {
        let document = Document::read(path, text, arguments)?;
        if document.source().contains('\0') {
            return Err("\"source\" contains a null character\n  hint: remove \\u0000 from it".to_owned());
        }
        Ok(Box::new(document))
    };
    guarded(read).map_err(|message| named(path, message))
}

fn generate(document: &Document, flattened: &[u8], metadata_only: bool) -> Result<Generated, String> {
    guarded(|| document.generate(flattened, metadata_only)).map_err(|message| named(document.path(), message))
}

fn fields(recipe: &[u8], schemas: &str, arguments: &str) -> Vec<Field> {
    // OpenUSD's interface has no way to report an error here. Without fields, payloads are not dynamic.
    guarded(|| Ok(fields::fields(recipe, schemas, arguments))).unwrap_or_default()
}

fn is_field(attribute: &str) -> bool {
    guarded(|| Ok(fields::is_field(attribute))).unwrap_or_default()
}

fn float_text(number: f32) -> String {
    number.to_string()
}

fn double_text(number: f64) -> String {
    number.to_string()
}

/// Turns a panic of `work` into an error. A panic that left this library would abort the host program.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    // Unwind-safe: after a panic only documents are used again, and they are immutable.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(internal(panic.as_ref())))
}

fn internal(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("internal error: {}; please report it", text.unwrap_or("of unknown cause"))
}

/// Prefixes a message with its file, unless it already starts with it.
fn named(path: &str, message: String) -> String {
    if message.starts_with(path) { message } else { format!("{path}: {message}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_that_asks_for_a_report() {
        let text = "index out of range";
        let formatted: Result<(), String> = guarded(|| panic!("{text}"));
        let literal: Result<(), String> = guarded(|| panic!("index out of range"));
        let expected = Err("internal error: index out of range; please report it".to_owned());
        assert_eq!(formatted, expected);
        assert_eq!(literal, expected);
    }

    #[test]
    fn every_error_names_the_file_once() {
        assert_eq!(named("a.tailor", "no source".into()), "a.tailor: no source");
        assert_eq!(named("a.tailor", "a.tailor: no source".into()), "a.tailor: no source");
    }

    #[test]
    fn a_file_that_is_no_recipe_is_refused_with_its_name_and_place() {
        let fault = |text: &str| read_document("/shot/a.tailor", text.as_bytes(), &[]).expect_err("no recipe");
        for text in ["", "{", r#"{"sim": {"maxEdge": 2}}"#, r#"{"source": ""}"#, r#"{"source": "a\u0000b"}"#, "{}"] {
            let fault = fault(text);
            assert!(fault.starts_with("/shot/a.tailor: "), "{fault}");
            assert!(fault.contains("\n  hint: "), "{fault}");
            assert_eq!(fault.matches("a.tailor").count(), 1, "{fault}");
        }
        assert!(fault("{\n  \"sim\": {\"maxEdge\": 2}}").contains("line 2"));
    }

    #[test]
    fn an_argument_that_is_no_option_is_left_out() {
        let text = br#"{"source": "coat.usda"}"#;
        for (key, value) in [("sim.maxEdgeLength", "2.5"), ("sim.maxEdge", "2"), ("render.level", "two")] {
            let argument = Argument { key: key.into(), value: value.into() };
            assert!(read_document("a.tailor", text, &[argument]).is_ok(), "{key}={value}");
        }
    }

    #[test]
    fn the_source_is_as_the_file_names_it() {
        let document = read_document("a.tailor", br#"{"source": "../coat.usda"}"#, &[]).expect("a recipe");
        assert_eq!(document.source(), "../coat.usda");
    }
}
