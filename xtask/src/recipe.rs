//! The tables of docs/recipe.md, from what `usdtailor help build` prints.

use std::fmt::Write as _;
use std::fs;

use crate::cargo::Profile;
use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::text::first_difference;

/// The page with the tables.
const FILE: &str = "docs/recipe.md";

/// What the help prints above the options.
const HEADING: &str = "Options of the recipe";

/// Marks in the page: `<!-- table sim -->`, the table, `<!-- end -->`.
const OPEN: &str = "<!-- table ";
const CLOSE: &str = "<!-- end -->";

/// One option, as the help has it.
#[derive(Debug, PartialEq)]
struct Row {
    key: String,
    default: String,
    meaning: String,
    unit: String,
}

/// Writes the tables into [`FILE`]. The program of tests is built already.
pub fn write(project: &Project) -> Outcome {
    let page = filled(&project.read(FILE)?, &rows(project)?)?;
    let path = project.root.join(FILE);
    fs::write(&path, page).map_err(|error| Failure::new(format!("cannot write {}: {error}", path.display())))?;
    eprintln!("wrote {FILE}");
    Ok(())
}

/// Compares the tables of [`FILE`] with the help of the program of tests.
pub fn check(project: &Project) -> Outcome {
    let page = project.read(FILE)?;
    match first_difference(&page, &filled(&page, &rows(project)?)?) {
        None => Ok(()),
        Some(line) => Err(Failure::new(format!("{FILE}, line {line}: an option has changed"))
            .hint("run cargo xtask recipe, and read the notes below the table")),
    }
}

fn rows(project: &Project) -> Outcome<Vec<Row>> {
    let program = Profile::Tested.program(project);
    let output = project
        .command(&program)
        .args(["help", "build"])
        .output()
        .map_err(|error| Failure::new(format!("cannot run {}: {error}", program.display())))?;
    let rows = parsed(&String::from_utf8_lossy(&output.stdout));
    if rows.is_empty() { Err(Failure::new("`usdtailor help build` lists no options")) } else { Ok(rows) }
}

/// The options in a help text, whose lines are wrapped. An option ends with its unit in brackets.
fn parsed(help: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut words: Vec<&str> = Vec::new();
    for line in help.lines().skip_while(|line| !line.starts_with(HEADING)).skip(1) {
        words.extend(line.split_whitespace());
        // The default of a list also ends with a bracket.
        if words.len() < 3 || !words[words.len() - 1].ends_with(']') {
            continue;
        }
        let text = words[2..].join(" ");
        if let Some((meaning, unit)) = text.rsplit_once(" [") {
            rows.push(Row {
                key: words[0].to_owned(),
                default: words[1].to_owned(),
                meaning: meaning.to_owned(),
                unit: unit.trim_end_matches(']').to_owned(),
            });
            words.clear();
        }
    }
    rows
}

/// The page with all its tables made anew. Each option must have a table.
fn filled(page: &str, rows: &[Row]) -> Outcome<String> {
    let mut text = String::new();
    let mut rest = page;
    let mut count = 0;
    while let Some((before, after)) = rest.split_once(OPEN) {
        let (name, after) = after.split_once(" -->").unwrap_or((after, ""));
        let Some((_, after)) = after.split_once(CLOSE) else {
            return Err(Failure::new(format!("{FILE}: the table {name} has no {CLOSE}")));
        };
        let of_table: Vec<&Row> = rows.iter().filter(|row| row.key.split('.').next() == Some(name)).collect();
        count += of_table.len();
        let _ = write!(text, "{before}{OPEN}{name} -->\n{}{CLOSE}", table(&of_table));
        rest = after;
    }
    if count != rows.len() {
        return Err(Failure::new(format!("{FILE} has tables for {count} of {} options", rows.len()))
            .hint(format!("add `{OPEN}NAME -->` and `{CLOSE}` for the options NAME.*")));
    }
    Ok(text + rest)
}

fn table(rows: &[&Row]) -> String {
    let mut text = "| option | attribute | default | unit | meaning |\n|---|---|---|---|---|\n".to_owned();
    for Row { key, default, meaning, unit } in rows {
        let attribute = key.replace('.', ":");
        let _ = writeln!(text, "| `{key}` | `tailor:{attribute}` | `{default}` | {unit} | {meaning} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const HELP: &str = "Usage\n\nOptions of the recipe, each with its default:\n  \
                        a.length 0.5    a long\n  text [mesh\n  units]\n  b.names  []     edge subsets [names]\n";

    #[test]
    fn an_option_may_span_lines() {
        let rows = parsed(HELP);
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[0].meaning.as_str(), rows[0].unit.as_str()), ("a long text", "mesh units"));
        assert_eq!((rows[1].key.as_str(), rows[1].default.as_str()), ("b.names", "[]"));
    }

    #[test]
    fn tables_are_made_anew_and_the_rest_stays() {
        let page = "x\n<!-- table a -->\nold\n<!-- end -->\ny\n<!-- table b -->\n<!-- end -->\n";
        let text = filled(page, &parsed(HELP)).unwrap();
        assert!(text.starts_with("x\n<!-- table a -->\n| option") && text.contains("<!-- end -->\ny\n"));
        assert!(text.contains("| `b.names` | `tailor:b:names` | `[]` | names | edge subsets |"));
        assert!(!text.contains("old"));
        assert_eq!(filled(&text, &parsed(HELP)).unwrap(), text);
    }

    #[test]
    fn an_option_without_a_table_is_a_failure() {
        let failure = filled("<!-- table a -->\n<!-- end -->\n", &parsed(HELP)).expect_err("an option without a table");
        assert!(failure.to_string().contains("1 of 2 options"));
    }
}
