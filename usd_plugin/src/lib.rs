//! The OpenUSD file format `.tailor`: what a program that reads USD loads, so that a `.tailor` file opens as the layer
//! which `usdtailor build` would write.
//!
//! The C++ beside this crate is the file format as OpenUSD knows it: it finds the source, composes it and fills the
//! layer. Everything else is decided here and in [`tailor`]. `cargo xtask plugin` builds both into one library.

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

    /// An attribute that a dynamic payload reads, such as `tailor:sim:maxEdgeLength`, and the argument that it becomes.
    struct Field {
        attribute: String,
        argument: String,
    }

    /// A layer as crate bytes, and what the user should know about it.
    struct Generated {
        layer: Vec<u8>,
        warnings: Vec<String>,
    }

    // C++ makes these vectors.
    impl Vec<Argument> {}

    extern "Rust" {
        type Document;

        /// Reads a `.tailor` file (JSON) and the arguments it was opened with.
        fn read_document(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Box<Document>>;

        /// The source as the file names it (asset path, relative to the file).
        fn source(self: &Document) -> &str;

        /// The layer: what `usdtailor build` writes. `flattened` is the composed source as crate bytes.
        fn generate(document: &Document, flattened: &[u8], metadata_only: bool) -> Result<Generated>;

        /// The attributes that a dynamic payload reads. The text of its `.tailor` file, the schemas of its prim as OpenUSD
        /// prints them and its arguments name the seams and thicknesses among them.
        fn fields(recipe: &[u8], schemas: &str, arguments: &str) -> Vec<Field>;

        /// Whether an attribute can be one of those.
        fn is_field(attribute: &str) -> bool;
    }
}

fn read_document(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Box<Document>, String> {
    let read = || {
        let document = Document::read(path, text, arguments)?;
        if document.source().contains('\0') {
            return Err("\"source\" has a character that no path has\n  hint: take \\u0000 out of it".to_owned());
        }
        Ok(Box::new(document))
    };
    guarded(read).map_err(|message| named(path, message))
}

fn generate(document: &Document, flattened: &[u8], metadata_only: bool) -> Result<Generated, String> {
    guarded(|| document.generate(flattened, metadata_only)).map_err(|message| named(document.path(), message))
}

fn fields(recipe: &[u8], schemas: &str, arguments: &str) -> Vec<Field> {
    // There is no way to report a fault from here; without fields, payloads are not dynamic.
    guarded(|| Ok(fields::fields(recipe, schemas, arguments))).unwrap_or_default()
}

fn is_field(attribute: &str) -> bool {
    guarded(|| Ok(fields::is_field(attribute))).unwrap_or_default()
}

/// Runs `work` so that a panic becomes an error: one that left this library would abort the program that loaded it.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    // Nothing that `work` borrowed is used again after a panic, except documents, which do not change.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(internal(panic.as_ref())))
}

fn internal(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("internal error: {}; please report it", text.unwrap_or("of unknown cause"))
}

/// A message that begins with the file it is about.
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
    fn an_argument_must_be_an_option_with_a_value_of_its_type() {
        let text = br#"{"source": "coat.usda"}"#;
        let fault = |key: &str, value: &str| {
            let argument = Argument { key: key.into(), value: value.into() };
            read_document("a.tailor", text, &[argument]).err()
        };
        assert_eq!(fault("sim.maxEdgeLength", "2.5"), None);
        assert_eq!(fault("sim.constraints", "placket,hem"), None);
        assert!(fault("sim.maxEdge", "2").expect("unknown").contains("sim.maxEdge"));
        assert!(fault("render.level", "two").expect("no number").contains("\"two\""));
    }

    #[test]
    fn the_source_is_as_the_file_names_it() {
        let document = read_document("a.tailor", br#"{"source": "../coat.usda"}"#, &[]).expect("a recipe");
        assert_eq!(document.source(), "../coat.usda");
    }
}
