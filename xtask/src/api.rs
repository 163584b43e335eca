//! The public API as text: the declarations that rustdoc draws, in the order of their names.
//!
//! It is what the roots of the crates and some of their modules have or re-export. Other modules are public for the crates that
//! build on them, and may change.

use std::collections::BTreeSet;
use std::fs;

use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::text::first_difference;

/// The stored API.
const FILE: &str = "docs/api.txt";

/// The pages that list the API, below `target/doc`: roots of crates, and modules.
const LISTS: [&str; 13] = [
    "tailor_mesh",
    "tailor_mesh/error",
    "tailor_mesh/garment/units",
    "tailor",
    "tailor/operator",
    "tailor/report",
    "tailor/sets",
    "tailor_costume",
    "tailor_costume/drive",
    "tailor_costume/fit",
    "tailor_costume/recipe",
    "tailor_usd",
    "tailor_usd/session",
];

/// What ends the part of a page that belongs to the item itself. Impls of traits follow it.
const ENDS: [&str; 4] = [
    "id=\"trait-implementations\"",
    "id=\"implementors\"",
    "id=\"synthetic-implementations\"",
    "id=\"blanket-implementations\"",
];

/// Writes [`FILE`] from the pages of rustdoc.
pub fn write(project: &Project) -> Outcome {
    let path = project.root.join(FILE);
    fs::write(&path, listing(project)?)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", path.display())))?;
    eprintln!("wrote {FILE}");
    Ok(())
}

/// Compares [`FILE`] with the pages of rustdoc.
pub fn check(project: &Project) -> Outcome {
    match first_difference(&project.read(FILE)?, &listing(project)?) {
        None => Ok(()),
        Some(line) => Err(Failure::new(format!("{FILE}, line {line}: the public API has changed"))
            .hint("run cargo xtask api, and note the change in CHANGELOG.md")),
    }
}

/// All items with their methods, from the pages in `target/doc`.
fn listing(project: &Project) -> Outcome<String> {
    let folder = project.target.join("doc");
    let read = |name: &str| {
        let path = folder.join(name);
        fs::read_to_string(&path).map_err(|error| Failure::new(format!("cannot read {}: {error}", path.display())))
    };
    let mut pages = BTreeSet::new();
    for list in LISTS {
        let index = read(&format!("{list}/index.html"))?;
        let items = index.split_once("id=\"main-content\"").map_or("", |(_, rest)| rest);
        pages.extend(between(items, "href=\"", "\"").into_iter().filter_map(|link| page(list, link)));
    }
    let texts: Outcome<Vec<String>> = pages.iter().map(|page| Ok(item(page, &read(page)?))).collect();
    Ok(texts?.join("\n"))
}

/// The page of an item that a list links to, such as `../tailor_mesh/garment/struct.Mesh.html`; none for other links.
fn page(list: &str, link: &str) -> Option<String> {
    if link.contains("://") {
        return None;
    }
    let mut path: Vec<&str> = list.split('/').collect();
    for part in link.split('/') {
        match part {
            ".." => _ = path.pop(),
            part => path.push(part),
        }
    }
    let kind = path.last()?.strip_suffix(".html")?.split_once('.')?.0;
    let is_item = ["constant", "enum", "fn", "macro", "struct", "trait", "type"].contains(&kind);
    is_item.then(|| path.join("/"))
}

/// One item of a page: its path, its declaration and its own methods, one on each line.
fn item(page: &str, html: &str) -> String {
    let end = ENDS.iter().filter_map(|end| html.find(end)).min().unwrap_or(html.len());
    let own = &html[..end];
    let path = page.trim_end_matches(".html").replace('/', "::");
    let mut text = format!("{path}\n");
    let mut declared = between(own, "<pre class=\"rust item-decl\">", "</pre>");
    // A trait declares its methods in its declaration.
    if !page.contains("trait.") {
        declared.extend(between(own, "<h4 class=\"code-header\">", "</h4>"));
    }
    for declaration in declared {
        text.push_str(&format!("    {}\n", plain(declaration)));
    }
    text
}

/// The parts of a text between two marks.
fn between<'a>(text: &'a str, open: &str, close: &str) -> Vec<&'a str> {
    text.split(open).skip(1).filter_map(|rest| Some(rest.split_once(close)?.0)).collect()
}

/// HTML without tags, in one line.
fn plain(html: &str) -> String {
    let mut parts = html.split('<');
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text.push_str(part.split_once('>').map_or(part, |(_, after)| after));
    }
    let text = [("&lt;", "<"), ("&gt;", ">"), ("&#39;", "'"), ("&quot;", "\""), ("&amp;", "&")]
        .iter()
        .fold(text, |text, (entity, character)| text.replace(entity, character));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_items_are_followed() {
        assert_eq!(page("tailor", "sim/struct.SimOptions.html").as_deref(), Some("tailor/sim/struct.SimOptions.html"));
        let other = page("tailor", "../tailor_mesh/garment/struct.Mesh.html");
        assert_eq!(other.as_deref(), Some("tailor_mesh/garment/struct.Mesh.html"));
        assert_eq!(page("tailor", "sim/index.html"), None);
        assert_eq!(page("tailor", "https://docs.rs/glam/struct.Vec3.html"), None);
    }

    #[test]
    fn an_item_is_its_declaration_and_its_own_methods() {
        let html = "<pre class=\"rust item-decl\"><code>pub struct <a>A</a> {\n    pub b: Vec&lt;u8&gt;,\n}</code></pre>\
                    <h4 class=\"code-header\">pub fn <a>c</a>(&amp;self)</h4><h2 id=\"trait-implementations\"></h2>\
                    <h4 class=\"code-header\">fn clone(&amp;self) -> Self</h4>";
        assert_eq!(
            item("m/struct.A.html", html),
            "m::struct.A\n    pub struct A { pub b: Vec<u8>, }\n    pub fn c(&self)\n"
        );
        let html = "<pre class=\"rust item-decl\">pub trait T { fn d(); }</pre><h4 class=\"code-header\">fn d()</h4>";
        assert_eq!(item("trait.T.html", html), "trait.T\n    pub trait T { fn d(); }\n");
    }
}
