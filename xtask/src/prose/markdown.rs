//! The passages of a document.

use super::Passage;

/// The paragraphs and list items of a document, without headings, tables, blocks of code and comments. A code span is one
/// word.
pub fn passages(text: &str) -> Vec<Passage> {
    let (mut found, mut is_code): (Vec<Passage>, bool) = (Vec::new(), false);
    let mut is_open = false;
    for (number, line) in text.lines().enumerate() {
        let trimmed = line.trim();
        let is_fence = trimmed.starts_with("```");
        is_code ^= is_fence;
        let is_indented = line.starts_with("    ") && !is_open;
        if is_code || is_fence || is_indented || trimmed.is_empty() || trimmed.starts_with(['#', '|', '<']) {
            is_open = false;
            continue;
        }
        let is_item =
            trimmed.starts_with("- ") || trimmed.split_once(". ").is_some_and(|(n, _)| n.parse::<u32>().is_ok());
        if !is_open || is_item {
            found.push(Passage { line: number + 1, text: String::new(), is_limited: true });
            is_open = true;
        }
        if let Some(passage) = found.last_mut() {
            passage.text.push_str(trimmed.trim_start_matches("- "));
            passage.text.push(' ');
        }
    }
    found.iter_mut().for_each(|passage| passage.text = without_code(&passage.text));
    found
}

/// The text with each code span as one word.
fn without_code(text: &str) -> String {
    let mut words = String::new();
    for (i, part) in text.split('`').enumerate() {
        words.push_str(if i % 2 == 0 { part } else { "code" });
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_and_items_are_passages() {
        let text = "# A\n\nOne `b c`\ntwo.\n- three\n- four\n  five\n\n```\ncode\n```\n| table |\nsix\n";
        let all: Vec<(usize, String)> =
            passages(text).into_iter().map(|p| (p.line, p.text.trim().to_owned())).collect();
        let expected = [(3, "One code two."), (5, "three"), (6, "four five"), (13, "six")];
        assert_eq!(all, expected.map(|(line, text)| (line, text.to_owned())));
    }
}
