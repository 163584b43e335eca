//! Holds documents, messages and comments to plain English: phrases that a hurried reader stumbles over, and sentences that
//! are too long.

mod markdown;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

use crate::links;
use crate::process::{Failure, Outcome};
use crate::project::Project;

/// Folders with Rust sources.
const SOURCES: [&str; 3] = ["src", "usd_plugin/src", "xtask/src"];

/// The longest sentence of a document or a message. \[words\]
const MOST_WORDS: usize = 30;

/// Phrases, and what to write instead, one of them a line. A full stop stands for any punctuation after the word.
const PHRASES: &str = include_str!("phrases.txt");

/// A word before a phrase that makes it plain English.
const THERE: &str = "there";
/// A word after a phrase that does so.
const LONGER: &str = "longer";

/// A text of a file that people read.
#[derive(Debug, PartialEq)]
struct Passage {
    /// The line at which it begins, from 1.
    line: usize,
    text: String,
    /// True if its sentences have a limit.
    is_limited: bool,
}

/// Fails with all passages that break a rule.
pub fn check(project: &Project) -> Outcome {
    let mut faults = Vec::new();
    for document in links::documents(project)? {
        let file = document.to_string_lossy().into_owned();
        faults.extend(of_file(&file, &markdown::passages(&project.read(&file)?)));
    }
    for file in sources(project)? {
        faults.extend(of_file(&file, &source::passages(&project.read(&file)?)));
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::new(faults.join("\n"))) }
}

fn of_file(file: &str, passages: &[Passage]) -> Vec<String> {
    let of = |passage: &Passage| {
        let at = format!("{file}, line {}", passage.line);
        faults(passage).into_iter().map(move |fault| format!("{at}: {fault}")).collect::<Vec<_>>()
    };
    passages.iter().flat_map(of).collect()
}

/// The paths of all Rust sources.
fn sources(project: &Project) -> Outcome<Vec<String>> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = SOURCES.iter().map(PathBuf::from).collect();
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(project.root.join(&folder))
            .map_err(|error| Failure::new(format!("cannot list {}: {error}", folder.display())))?;
        for path in entries.filter_map(|entry| Some(folder.join(entry.ok()?.file_name()))) {
            let full = project.root.join(&path);
            if full.is_dir() && !is_foreign(&path) {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Folders of the page's tools, and of unit tests.
fn is_foreign(folder: &Path) -> bool {
    ["node_modules", "dist", "tests"].iter().any(|name| folder.ends_with(name))
}

/// What is wrong with a passage.
fn faults(passage: &Passage) -> Vec<String> {
    let words: Vec<String> = passage.text.split_whitespace().map(str::to_lowercase).collect();
    let mut found = Vec::new();
    for (phrase, instead) in PHRASES.lines().filter_map(|line| line.split_once(" -> ")) {
        if (0..words.len()).any(|at| has_phrase(&words, at, phrase)) {
            let said = phrase.trim_end_matches('.');
            found.push(format!("\"{said}\": write \"{instead}\""));
        }
    }
    let longest = sentences(&passage.text).max_by_key(|sentence| sentence.split_whitespace().count()).unwrap_or("");
    let count = longest.split_whitespace().count();
    if passage.is_limited && count > MOST_WORDS {
        let start: Vec<&str> = longest.split_whitespace().take(5).collect();
        found.push(format!("a sentence of {count} words, at most {MOST_WORDS}: \"{} ...\"", start.join(" ")));
    }
    found
}

fn has_phrase(words: &[String], at: usize, phrase: &str) -> bool {
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_owned();
    if let Some(adverb) = phrase.strip_suffix('.') {
        let word = &words[at];
        return word.strip_prefix(adverb).is_some_and(|rest| matches!(rest, "." | "," | ";" | ":" | ")" | ")."));
    }
    let wanted: Vec<&str> = phrase.split(' ').collect();
    let is_here = wanted.len() <= words.len() - at && wanted.iter().zip(&words[at..]).all(|(w, word)| *w == bare(word));
    let before = at.checked_sub(1).map(|i| bare(&words[i]));
    let after = words.get(at + wanted.len()).map(|word| bare(word));
    // Punctuation within the phrase separates it.
    let is_whole = || words[at..at + wanted.len() - 1].iter().all(|word| word.ends_with(char::is_alphanumeric));
    is_here && is_whole() && before.as_deref() != Some(THERE) && after.as_deref() != Some(LONGER)
}

/// The sentences of a text, which end at punctuation before a space.
fn sentences(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let ends = rest.char_indices().zip(rest.chars().skip(1));
        let end = ends.filter(|((_, c), next)| ".?!:;".contains(*c) && next.is_whitespace()).map(|((at, _), _)| at + 1);
        let (sentence, after) = rest.split_at(end.min().unwrap_or(rest.len()));
        rest = after;
        Some(sentence)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> usize {
        faults(&Passage { line: 1, text: text.to_owned(), is_limited: true }).len()
    }

    #[test]
    fn phrases_are_found_as_whole_words() {
        assert_eq!(found("A file that is no cache, or is none."), 2);
        assert_eq!(found("All but for one are told."), 2);
        assert_eq!(found("The points beside, and faces."), 1);
    }

    #[test]
    fn plain_uses_of_the_same_words_pass() {
        assert_eq!(found("There is no such option, and it is no longer read; points beside it stay."), 0);
        assert_eq!(found("This is what it is. No face is lost."), 0);
    }

    #[test]
    fn long_sentences_are_found_and_end_at_punctuation() {
        let words = |count: usize| vec!["word"; count].join(" ");
        assert_eq!(found(&words(MOST_WORDS)), 0);
        assert_eq!(found(&words(MOST_WORDS + 1)), 1);
        assert_eq!(found(&format!("{}: {}", words(20), words(20))), 0);
    }
}
