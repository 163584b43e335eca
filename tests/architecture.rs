//! The imports of `src` are those that `docs/architecture.md` draws: modules in data-flow order, without circles.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Files that a folder may have.
const MOST_FILES: usize = 12;
/// Files of a folder that may import each other in one circle.
const MOST_IN_CIRCLE: usize = 3;

/// A module by its path in the crate: `["render", "lines", "ribs"]`; the crate root is empty.
type Module = Vec<String>;

type Graph = BTreeMap<Module, BTreeSet<Module>>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// All source files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The module of a file; none for the programs beside the library and for tests.
fn module(file: &Path) -> Option<Module> {
    let path = file.strip_prefix(root()).expect("a source file").with_extension("");
    let mut parts: Module = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if matches!(parts[0].as_str(), "main" | "cli" | "testing") || parts.contains(&"tests".to_owned()) {
        return None;
    }
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib")) {
        parts.pop();
    }
    Some(parts)
}

/// The text of a file without comments and without its unit tests.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).expect("a source file");
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The paths of a `use` tree, with braces expanded.
fn paths(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((before, rest)) = tree.split_once('{') else { return vec![tree.to_owned()] };
    let inner = &rest[..rest.rfind('}').expect("braces are closed")];
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[start..]);
    let parts = parts.into_iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(paths).map(|part| format!("{before}{part}")).collect()
}

/// Every path of a file that may name a module: those of `use`, and those that begin with `crate::` or `super::`.
fn mentions(code: &str) -> Vec<String> {
    let uses = code.split("use ").skip(1).filter_map(|rest| Some(rest.split_once(';')?.0));
    let is_path = |text: &&str| text.starts_with("crate::") || text.starts_with("super::") || !text.contains(' ');
    let mut all: Vec<String> = uses.filter(is_path).flat_map(paths).collect();
    let words = code.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    all.extend(words.filter(|w| w.starts_with("crate::") || w.starts_with("super::")).map(str::to_owned));
    all
}

/// The module that a path names, seen from another: the longest part of it that is one.
fn resolve(path: &str, from: &Module, known: &BTreeSet<Module>) -> Option<Module> {
    let mut parts: Vec<&str> = path.split("::").map(|p| p.split(" as ").next().unwrap_or_default().trim()).collect();
    let mut base: Module = match parts.first().copied() {
        Some("crate") => Module::new(),
        Some("super") => from[..from.len().saturating_sub(1)].to_vec(),
        Some("self") => from.clone(),
        Some(first) => {
            let child = [from.as_slice(), &[first.to_owned()]].concat();
            if !known.contains(&child) {
                return None;
            }
            parts.insert(0, "self");
            from.clone()
        }
        None => return None,
    };
    for part in &parts[1..] {
        match *part {
            "super" => _ = base.pop(),
            part => {
                let next = [base.as_slice(), &[part.to_owned()]].concat();
                if !known.contains(&next) {
                    break;
                }
                base = next;
            }
        }
    }
    (base != *from).then_some(base)
}

fn imports() -> Graph {
    let all: Vec<(Module, PathBuf)> = files(&root()).into_iter().filter_map(|f| Some((module(&f)?, f))).collect();
    let known: BTreeSet<Module> = all.iter().map(|(module, _)| module.clone()).collect();
    let of = |(module, file): &(Module, PathBuf)| {
        let named = mentions(&code(file));
        (module.clone(), named.iter().filter_map(|path| resolve(path, module, &known)).collect())
    };
    all.iter().map(of).collect()
}

/// The same between the first `depth` parts of the modules' paths, without the crate root.
fn between(graph: &Graph, depth: usize) -> Graph {
    let cut = |module: &Module| module.iter().take(depth).cloned().collect::<Module>();
    let mut found = Graph::new();
    for (from, all) in graph.iter().filter(|(from, _)| !from.is_empty()) {
        let from = cut(from);
        let to = all.iter().filter(|to| !to.is_empty()).map(cut).filter(|to| *to != from);
        let to: Vec<Module> = to.collect();
        found.entry(from).or_default().extend(to);
    }
    found
}

/// The modules that can be reached from each.
fn reached(graph: &Graph, from: &Module) -> BTreeSet<Module> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from.clone()]);
    while let Some(module) = open.pop() {
        for next in graph.get(&module).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

/// The largest sets of modules that all reach each other, of more than one.
fn circles(graph: &Graph) -> BTreeSet<BTreeSet<Module>> {
    let reach: BTreeMap<&Module, BTreeSet<Module>> = graph.keys().map(|m| (m, reached(graph, m))).collect();
    let circle = |module: &Module| -> BTreeSet<Module> {
        let both = reach[module].iter().filter(|other| reach.get(other).is_some_and(|back| back.contains(module)));
        both.cloned().collect()
    };
    graph.keys().map(circle).filter(|circle| circle.len() > 1).collect()
}

/// The arrows of the page: `module -> module, module` in its blocks of text.
fn drawn() -> Graph {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/architecture.md");
    let text = fs::read_to_string(page).expect("docs/architecture.md");
    let lines = text.lines().filter_map(|line| line.split_once(" -> "));
    let arrows = lines.map(|(from, to)| {
        let to = to.split(',').map(|name| vec![name.trim().to_owned()]).filter(|name| name[0] != "-");
        (vec![from.trim().to_owned()], to.collect())
    });
    arrows.collect()
}

#[test]
fn modules_import_what_the_page_draws() {
    let found = between(&imports(), 1);
    let drawn = drawn();
    for (module, imports) in &found {
        let expected = drawn.get(module).unwrap_or_else(|| panic!("docs/architecture.md lacks {module:?}"));
        assert_eq!(imports, expected, "{module:?} imports other modules than docs/architecture.md draws");
    }
    assert_eq!(found.keys().collect::<Vec<_>>(), drawn.keys().collect::<Vec<_>>());
}

#[test]
fn no_modules_import_each_other() {
    let graph = imports();
    for depth in [1, 2] {
        // Below the first level, folders alone count: files may be in a small circle.
        let folders: BTreeSet<Module> = graph.keys().filter(|m| m.len() > depth).map(|m| m[..depth].to_vec()).collect();
        let mut between = between(&graph, depth);
        between.retain(|module, _| depth == 1 || folders.contains(module));
        between.values_mut().for_each(|to| to.retain(|m| depth == 1 || folders.contains(m)));
        let circles = circles(&between);
        assert!(circles.is_empty(), "folders import each other: {circles:?}");
    }
}

#[test]
fn few_files_are_in_a_circle() {
    let mut graph = imports();
    // The head of a folder names its files; that alone is not a circle.
    for (module, to) in &mut graph {
        to.retain(|other| !(other.len() == module.len() + 1 && other.starts_with(module)));
    }
    let large: Vec<_> = circles(&graph).into_iter().filter(|circle| circle.len() > MOST_IN_CIRCLE).collect();
    assert!(large.is_empty(), "{large:#?}");
}

#[test]
fn folders_are_small() {
    let mut counts: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for file in files(&root()) {
        *counts.entry(file.parent().expect("a folder").to_owned()).or_default() += 1;
    }
    for (folder, count) in counts {
        assert!(count <= MOST_FILES, "{} has {count} files", folder.display());
    }
}
