//! The passages of a Rust source.

use super::Passage;

/// The comments of a source, lines in a row as one, and its texts. Unit tests at its end are left out.
pub fn passages(source: &str) -> Vec<Passage> {
    let source = source.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or(source);
    let mut found: Vec<Passage> = Vec::new();
    let mut last_comment = 0;
    let mut scan = Scan { rest: source, line: 1 };
    while let Some(token) = scan.next() {
        match token {
            Token::Comment(line, text) => match found.last_mut() {
                // An empty comment ends a paragraph.
                Some(passage) if last_comment + 1 == line && !text.is_empty() && !passage.is_limited => {
                    passage.text = format!("{} {text}", passage.text);
                    last_comment = line;
                }
                _ => {
                    found.push(Passage { line, text: text.to_owned(), is_limited: false });
                    last_comment = line;
                }
            },
            Token::Text(line, text) => found.push(Passage { line, text: joined(text), is_limited: true }),
        }
    }
    found
}

enum Token<'a> {
    /// A line of comment without its slashes.
    Comment(usize, &'a str),
    /// The text between quotes.
    Text(usize, &'a str),
}

/// A walk over a source.
struct Scan<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Scan<'a> {
    fn next(&mut self) -> Option<Token<'a>> {
        while let Some(c) = self.rest.chars().next() {
            let line = self.line;
            if self.rest.starts_with("//") {
                let text = self.take(self.rest.find('\n').unwrap_or(self.rest.len()));
                return Some(Token::Comment(line, text.trim_start_matches(['/', '!']).trim()));
            }
            if let Some(hashes) = raw(self.rest) {
                let end = format!("\"{}", "#".repeat(hashes));
                self.take(hashes + 2);
                let text = self.take(self.rest.find(&end).unwrap_or(self.rest.len()));
                self.take(end.len().min(self.rest.len()));
                return Some(Token::Text(line, text));
            }
            match c {
                '"' => {
                    self.take(1);
                    let text = self.take(quoted(self.rest));
                    self.take(1.min(self.rest.len()));
                    return Some(Token::Text(line, text));
                }
                // A character, which may be a quote; else the name of a lifetime.
                '\'' => {
                    let is_escape = self.rest[1..].starts_with('\\');
                    let character: usize = self.rest.chars().take(3).map(char::len_utf8).sum();
                    let is_character = self.rest[..character].ends_with('\'');
                    self.take(if is_escape {
                        4.min(self.rest.len())
                    } else if is_character {
                        character
                    } else {
                        1
                    });
                }
                c => _ = self.take(c.len_utf8()),
            }
        }
        None
    }

    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        self.line += taken.matches('\n').count();
        taken
    }
}

/// The number of hashes of a raw text that begins here.
fn raw(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    after[hashes..].starts_with('"').then_some(hashes)
}

/// The length of a text up to the quote that ends it.
fn quoted(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices() {
        match c {
            '"' if !is_escaped => return at,
            '\\' => is_escaped = !is_escaped,
            _ => is_escaped = false,
        }
    }
    text.len()
}

/// A text in one line. Breaks that it has when it is read end a sentence.
fn joined(text: &str) -> String {
    text.replace("\\\n", " ").replace("\\n", ". ").replace('\n', ". ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_texts_are_passages() {
        let source = "//! One\n//! two.\n//!\n//! Three.\nlet a = \"four \\\n  five \\\"\"; // six\nlet b = '\"'; let c: &'a str = r#\"raw \"x\"\"#;\n\
                      \n#[cfg(test)]\nmod tests {\n// seven\n}\n";
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let all: Vec<(usize, String)> = passages(source).iter().map(|p| (p.line, words(&p.text))).collect();
        let expected = [(1, "One two."), (3, "Three."), (5, "four five \\\""), (6, "six"), (7, "raw \"x\"")];
        assert_eq!(all, expected.map(|(line, text)| (line, text.to_owned())));
    }
}
