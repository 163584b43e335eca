//! The tables of docs/options.md.

use std::fmt::Write as _;

use super::{Generated, Group};
use crate::process::{Failure, Outcome};
use crate::project::Project;

/// The page with the tables.
const FILE: &str = "docs/options.md";

/// Marks in the page: `<!-- table sim -->`, the table, `<!-- end -->`.
const OPEN: &str = "<!-- table ";
const CLOSE: &str = "<!-- end -->";

/// The page with all its tables made anew.
pub fn generate(project: &Project, groups: &[Group]) -> Outcome<Generated> {
    Ok(Generated { path: FILE.to_owned(), text: filled(&project.read(FILE)?, groups)? })
}

/// Each group must have a table.
fn filled(page: &str, groups: &[Group]) -> Outcome<String> {
    let mut text = String::new();
    let mut rest = page;
    let mut missing: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    while let Some((before, after)) = rest.split_once(OPEN) {
        let (name, after) = after.split_once(" -->").unwrap_or((after, ""));
        let Some((_, after)) = after.split_once(CLOSE) else {
            return Err(Failure::new(format!("{FILE}: the table {name} has no {CLOSE}")));
        };
        let Some(group) = groups.iter().find(|group| group.name == name) else {
            return Err(Failure::new(format!("{FILE}: no options are called {name}")));
        };
        missing.retain(|&known| known != name);
        let _ = write!(text, "{before}{OPEN}{name} -->\n{}{CLOSE}", table(group));
        rest = after;
    }
    if let [name, ..] = missing[..] {
        let hint = format!("add `{OPEN}{name} -->` and `{CLOSE}`");
        return Err(Failure::new(format!("{FILE} has no table of the options {name}")).hint(hint));
    }
    Ok(text + rest)
}

fn table(group: &Group) -> String {
    let mut text = "| option | attribute | default | unit | meaning |\n|---|---|---|---|---|\n".to_owned();
    for row in &group.options {
        let instance = if group.has_instances { ".<name>" } else { "" };
        let key = format!("{}{instance}.{}", group.name, row.key);
        let attribute = key.replace('.', ":");
        let _ =
            writeln!(text, "| `{key}` | `tailor:{attribute}` | `{}` | {} | {} |", row.default, row.unit, row.meaning);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::example;

    #[test]
    fn tables_are_made_anew_and_the_rest_stays() {
        let page = "x\n<!-- table a -->\nold\n<!-- end -->\ny\n<!-- table b -->\n<!-- end -->\n";
        let text = filled(page, &example()).unwrap();
        assert!(text.starts_with("x\n<!-- table a -->\n| option") && text.contains("<!-- end -->\ny\n"));
        assert!(text.contains("| `a.sets` | `tailor:a:sets` | `[]` | names | Sets |"));
        assert!(text.contains("| `b.<name>.side` | `tailor:b:<name>:side` | `\"in\"` | side | Side |"));
        assert!(!text.contains("old"));
        assert_eq!(filled(&text, &example()).unwrap(), text);
    }

    #[test]
    fn a_group_without_a_table_is_a_failure() {
        let failure = filled("<!-- table a -->\n<!-- end -->\n", &example()).expect_err("a group without a table");
        assert!(failure.to_string().contains("options b"));
    }
}
