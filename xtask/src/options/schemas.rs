//! The codeless schemas: `schema.usda`, and the two files that OpenUSD's usdGenSchema makes of it.

use serde_json::Value;
use std::fmt::Write as _;
use std::fs;

use super::{Generated, Group, Row};
use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::venv;

const FOLDER: &str = "schemas";

/// The start of `schema.usda`.
const HEAD: &str = r#"#usda 1.0
(
    """The options of usd-tailor as attributes of a garment. `cargo xtask options` writes this file, generatedSchema.usda and
    plugInfo.json. usdGenSchema keeps only the first sentence of a doc, so each attribute has one sentence on one line,
    which ends in the unit."""
    subLayers = [
        @usd/schema.usda@
    ]
)

over "GLOBAL" (
    customData = {
        # Must differ from the name of the file-format plugin (usdTailor), which is registered too.
        string libraryName = "usdTailorSchemas"
        string libraryPath = "."
        # OpenUSD 24.08 finds the classes by this prefix, though no code is generated.
        string libraryPrefix = "UsdTailor"
        bool skipCodeGeneration = true
    }
)
{
}
"#;

/// Values of usdGenSchema's placeholders: the resources are beside plugInfo.json, and there is no library.
const PLACEHOLDERS: [(&str, &str); 3] =
    [("@PLUG_INFO_LIBRARY_PATH@", ""), ("@PLUG_INFO_RESOURCE_PATH@", "."), ("@PLUG_INFO_ROOT@", ".")];

/// `schema.usda`.
pub fn source(groups: &[Group]) -> Generated {
    let text = groups.iter().fold(HEAD.to_owned(), |text, group| text + &class(group));
    Generated { path: format!("{FOLDER}/schema.usda"), text }
}

/// The class of a group of options.
fn class(group: &Group) -> String {
    let Group { name, about, schema, has_instances, options } = group;
    let class = schema.trim_start_matches("Tailor");
    let (kind, prefix) = if *has_instances {
        ("multipleApply", format!("\n        token propertyNamespacePrefix = \"tailor:{name}\""))
    } else {
        ("singleApply", String::new())
    };
    let is_float = |row: &&Row| row.default.is_f64();
    let key = options.iter().find(is_float).or(options.first()).map_or("", |row| &row.key);
    let example = if *has_instances { format!("{name}.side.{key}") } else { format!("{name}.{key}") };
    let mut text = format!(
        r#"
class "{schema}" (
    inherits = </APISchemaBase>
    customData = {{
        token apiSchemaType = "{kind}"{prefix}
        token[] apiSchemaCanOnlyApplyTo = ["Mesh"]
        string className = "{class}"
    }}
    doc = """{about} Each attribute is a command-line key: `tailor:{}` is `--set {example}=...`."""
)
{{
"#,
        example.replace('.', ":")
    );
    let properties: Vec<String> = options.iter().map(|row| property(group, row)).collect();
    text.push_str(&properties.join("\n"));
    text.push_str("}\n");
    text
}

/// The attribute or relationship of an option.
fn property(group: &Group, Row { key, unit, meaning, default, domain }: &Row) -> String {
    let name = if group.has_instances { key.clone() } else { format!("tailor:{}:{key}", group.name) };
    let declaration = match (domain.r#type.as_str(), default) {
        ("sets" | "prims", _) => format!("rel {name}"),
        ("file", _) => format!("uniform asset {name} = @@"),
        (_, Value::Bool(_)) => format!("uniform bool {name} = {default}"),
        (_, Value::Number(n)) if n.is_f64() => format!("uniform float {name} = {}", n.as_f64().unwrap_or_default()),
        (_, Value::Number(_)) => format!("uniform int {name} = {default}"),
        (_, Value::Array(_)) => format!("uniform token[] {name} = {default}"),
        _ => format!("uniform token {name} = {default}"),
    };
    let mut text = format!("    {declaration} (\n");
    if domain.r#type == "choice" {
        let words: Vec<String> = domain.words.iter().map(|word| format!("\"{word}\"")).collect();
        let _ = writeln!(text, "        allowedTokens = [{}]", words.join(", "));
    }
    let unit = if domain.r#type == "sets" { "paths of GeomSubsets" } else { unit };
    let _ = writeln!(text, "        doc = \"{meaning} [{unit}]\"\n    )");
    text
}

/// The output of usdGenSchema for the `schema.usda` of the project.
pub fn generate(project: &Project) -> Outcome<[Generated; 2]> {
    let python = venv::ensure(project)?;
    // usdGenSchema merges into an existing plugInfo.json, so the folder must be empty.
    let folder = project.scratch("schemas")?;
    let mut command = project.command(python);
    command.args(["-m", "pxr.Usd.usdGenSchema", "schemas/schema.usda"]).arg(&folder);
    process::run_quietly(&mut command)?;
    let read = |name: &str| -> Outcome<Generated> {
        let text = fs::read_to_string(folder.join(name))
            .map_err(|error| Failure::new(format!("usdGenSchema wrote no {name}: {error}")))?;
        Ok(Generated { path: format!("{FOLDER}/{name}"), text: tidy(&text) })
    };
    Ok([read("generatedSchema.usda")?, read("plugInfo.json")?])
}

/// Replaces the placeholders and removes trailing spaces.
fn tidy(text: &str) -> String {
    let filled = PLACEHOLDERS.iter().fold(text.to_owned(), |text, (name, value)| text.replace(name, value));
    let mut lines = filled.trim_end().lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    lines.push('\n');
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::example;

    #[test]
    fn classes_have_the_type_and_default_of_each_option() {
        let text = source(&example()).text;
        assert!(text.contains("    uniform float tailor:a:length = 0.5 (\n        doc = \"Length [mesh units]\"\n"));
        assert!(text.contains("    rel tailor:a:sets (\n        doc = \"Sets [paths of GeomSubsets]\"\n"));
        assert!(text.contains("class \"TailorBAPI\"") && text.contains("propertyNamespacePrefix = \"tailor:b\""));
        assert!(text.contains("    uniform token side = \"in\" (\n        allowedTokens = [\"in\", \"out\"]\n"));
    }

    #[test]
    fn tidy_fills_places_and_trims_lines() {
        assert_eq!(tidy("{ \n  \"Root\": \"@PLUG_INFO_ROOT@\", \n}\n\n"), "{\n  \"Root\": \".\",\n}\n");
    }
}
