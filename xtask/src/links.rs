//! Checks the links of the documents: each names a file of the project, and a heading of it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{Failure, Outcome};
use crate::project::Project;

/// Documents outside `docs/`.
const DOCUMENTS: [&str; 12] = [
    "README.md",
    "SECURITY.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "examples/README.md",
    "src/mesh/README.md",
    "src/tailor/README.md",
    "src/costume/README.md",
    "src/usd/README.md",
    "src/preview/README.md",
    "src/command/README.md",
    "src/testing/README.md",
];

/// Fails with all links that lead nowhere.
pub fn check(project: &Project) -> Outcome {
    let mut broken = Vec::new();
    for document in documents(project)? {
        let text = project.read(&document.to_string_lossy())?;
        for link in links(&text) {
            if let Some(fault) = fault(project, &document, &text, &link) {
                broken.push(format!("{}: {link}: {fault}", document.display()));
            }
        }
    }
    if broken.is_empty() { Ok(()) } else { Err(Failure::new(format!("broken links\n{}", broken.join("\n")))) }
}

/// The documents of the project.
pub fn documents(project: &Project) -> Outcome<Vec<PathBuf>> {
    let pages = fs::read_dir(project.root.join("docs"))
        .map_err(|error| Failure::new(format!("cannot list docs: {error}")))?
        .filter_map(|entry| Some(Path::new("docs").join(entry.ok()?.file_name())))
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    let mut documents: Vec<PathBuf> = DOCUMENTS.iter().map(PathBuf::from).chain(pages).collect();
    documents.sort();
    Ok(documents)
}

/// The reason that a link of a document leads nowhere.
fn fault(project: &Project, document: &Path, text: &str, link: &str) -> Option<String> {
    let (path, anchor) = link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
    let file = document.parent().unwrap_or(Path::new("")).join(path);
    let full = project.root.join(&file);
    if !path.is_empty() && !full.exists() {
        return Some("no such file".to_owned());
    }
    let anchor = anchor?;
    let headings = if path.is_empty() { anchors(text) } else { anchors(&fs::read_to_string(full).ok()?) };
    if headings.contains(anchor) { None } else { Some("no such heading".to_owned()) }
}

/// The targets of a text's links to files. Fenced blocks and code spans are left out.
fn links(text: &str) -> Vec<String> {
    let plain: String =
        prose(text).map(|line| line.split('`').step_by(2).collect::<Vec<_>>().join("`") + "\n").collect();
    let targets = plain.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    targets.filter(|target| is_file(target)).map(str::to_owned).collect()
}

/// Whether the target of a link is a file, or a heading of one.
fn is_file(target: &str) -> bool {
    !target.contains("://") && !target.starts_with("mailto:")
}

/// A text in Markdown whose links to files are their words alone, and whose pictures of files are left out: a package has no files
/// beside its README.
pub fn without_files(text: &str) -> String {
    let (mut kept, mut rest) = (String::new(), text);
    while let Some(middle) = rest.find("](") {
        let start = rest[..middle].rfind('[');
        let end = rest[middle..].find(')').map(|end| middle + end + 1);
        let (Some(start), Some(end)) = (start, end) else { break };
        let target = &rest[middle + 2..end - 1];
        let is_picture = rest[..start].ends_with('!');
        if !is_file(target) {
            kept += &rest[..end];
        } else if is_picture {
            kept += &rest[..start - 1];
        } else {
            kept += &rest[..start];
            kept += &rest[start + 1..middle];
        }
        rest = &rest[end..];
    }
    kept + rest
}

/// The anchors that GitHub and MkDocs give the headings of a text.
fn anchors(text: &str) -> BTreeSet<String> {
    prose(text).filter(|line| line.starts_with('#')).map(|line| slug(line.trim_start_matches('#').trim())).collect()
}

fn slug(heading: &str) -> String {
    let kept = heading.to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

/// The lines outside fenced blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        fenced ^= is_fence;
        !fenced && !is_fence
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_those_of_the_prose() {
        let text =
            "see [a](b.md#c) and [`code`](d.rs), not `[x](y)`\n```\n[p](q)\n```\n![i](i.png) [w](https://w.org)\n";
        assert_eq!(links(text), ["b.md#c", "d.rs", "i.png"]);
    }

    #[test]
    fn headings_have_the_anchors_of_github() {
        assert_eq!(slug("A `.tailor` file"), "a-tailor-file");
        assert!(
            anchors("# One Two\n```\n# no\n```\n").contains("one-two") && !anchors("```\n# no\n```\n").contains("no")
        );
    }

    #[test]
    fn links_to_files_become_words() {
        let text =
            "See [the docs](docs/a.md#b) and [USD](https://openusd.org), `a[0]`.\n\n![A coat](coat.png)\nEnd [x].";
        let expected = "See the docs and [USD](https://openusd.org), `a[0]`.\n\n\nEnd [x].";
        assert_eq!(without_files(text), expected);
    }
}
