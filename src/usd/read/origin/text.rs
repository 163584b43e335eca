//! Text layers in the words that the USD library reads.
//!
//! OpenUSD's text files may have numbers such as `.5` and `1.`, comments after `//`, the old word `config`, `yes` and `no`, `active = 1`,
//! and escaped quotes in long strings. The library calls such files damaged. Lines keep their numbers.

use super::letters::Letters;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// Versions of text layers begin with this.
const VERSION: &[u8] = b"#usda 1.";

/// Metadata that are true or false. OpenUSD takes numbers for them.
const FLAGS: [&[u8]; 4] = [b"active", b"instanceable", b"hidden", b"noLoadHint"];

/// The words that begin prims.
const PRIMS: [&[u8]; 3] = [b"def", b"over", b"class"];

/// Metadata of prims that the library does not read, and no program uses any more.
const LEFT_OUT: [&str; 4] = ["prefixSubstitutions", "suffixSubstitutions", "symmetryArguments", "symmetryFunction"];

/// Properties of a prim. Reading takes time that grows with their square.
const MOST_PROPERTIES: usize = 20_000;
/// The construct at which a text with more properties is refused.
pub const TOO_MANY: &str = "a property of a prim that has 20,000 before it";

/// A text in words that the library reads.
pub struct Readable<'a> {
    pub text: Cow<'a, [u8]>,
    /// Restores words that had letters beyond ASCII, if there were any.
    pub letters: Option<Letters>,
    /// The fields of [`LEFT_OUT`] that were there.
    pub left_out: Vec<&'static str>,
    /// What OpenUSD refuses in the text, where the library reads it: two numbers without a comma between them, a comma without a
    /// value, a path that a list has twice, a property of two types. And what the library takes too long to read.
    pub refused: Option<Refused>,
}

/// A part of a text that is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused {
    /// Its line, from 1.
    pub line: usize,
    /// What the line has.
    pub what: &'static str,
}

/// The text in words that the library reads.
pub fn readable(text: &[u8]) -> Readable<'_> {
    let mut scanner = Scanner {
        text,
        at: 0,
        copied: 0,
        out: Vec::new(),
        last: b'\n',
        begins: true,
        letters: None,
        left_out: Vec::new(),
        listed: None,
        refused: None,
        open: Vec::new(),
    };
    scanner.version();
    while let Some(&byte) = text.get(scanner.at) {
        scanner.step(byte);
    }
    let line_of = |at: usize| 1 + text[..at].iter().filter(|&&byte| byte == b'\n').count();
    let refused = scanner.refused.map(|(at, what)| Refused { line: line_of(at), what });
    if scanner.copied == 0 {
        return Readable { text: Cow::Borrowed(text), letters: None, left_out: Vec::new(), refused };
    }
    scanner.out.extend_from_slice(&text[scanner.copied..]);
    let Scanner { out, letters, left_out, .. } = scanner;
    Readable { text: Cow::Owned(out), letters, left_out, refused }
}

/// Reads a text once, and copies what changes.
struct Scanner<'a> {
    text: &'a [u8],
    at: usize,
    /// The text up to here is in `out`.
    copied: usize,
    out: Vec<u8>,
    /// The last byte that is neither a space nor in a comment.
    last: u8,
    /// Whether only spaces are before, on this line.
    begins: bool,
    /// Escapes letters beyond ASCII; none before the first of them.
    letters: Option<Letters>,
    left_out: Vec<&'static str>,
    /// The paths of the list so far, each with its file before it; none outside of a list.
    listed: Option<HashSet<&'a [u8]>>,
    /// The first part that is refused, and what it is.
    refused: Option<(usize, &'static str)>,
    /// The brackets around: the properties so far in those of a prim, none in others.
    open: Vec<Option<Properties<'a>>>,
}

/// The properties of a prim so far: their number, and the type of each name.
#[derive(Default)]
struct Properties<'a> {
    count: usize,
    types: HashMap<&'a [u8], &'a [u8]>,
}

impl<'a> Scanner<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.text[self.at..]
    }

    fn peek(&self, ahead: usize) -> u8 {
        self.text.get(self.at + ahead).copied().unwrap_or_default()
    }

    /// Replaces the next `len` bytes, and goes behind them.
    fn replace(&mut self, len: usize, by: &[u8]) {
        self.out.extend_from_slice(&self.text[self.copied..self.at]);
        self.out.extend_from_slice(by);
        self.at += len;
        self.copied = self.at;
    }

    /// Goes behind the next `end` after `skipped` bytes, or to the end of the text.
    fn skip_to(&mut self, skipped: usize, end: &[u8]) {
        let from = (self.at + skipped).min(self.text.len());
        let found = self.text[from..].windows(end.len()).position(|part| part == end);
        self.at = found.map_or(self.text.len(), |at| from + at + end.len());
    }

    /// Minor versions add values that are read, or refused, where they are.
    fn version(&mut self) {
        if self.rest().starts_with(VERSION) {
            self.at = VERSION.len();
            let digits = self.rest().iter().take_while(|byte| byte.is_ascii_digit()).count();
            if self.rest()[..digits] != *b"0" {
                self.replace(digits, b"0");
            }
        }
    }

    fn step(&mut self, byte: u8) {
        match byte {
            b' ' | b'\t' | b'\r' => self.at += 1,
            b'\n' => (self.at, self.begins) = (self.at + 1, true),
            b'#' => self.comment(),
            b'/' if self.peek(1) == b'/' => {
                self.replace(2, b"##");
                self.comment();
            }
            b'/' if self.peek(1) == b'*' => self.skip_to(2, b"*/"),
            _ => {
                let begins_number = self.begins_number(byte);
                if begins_number && self.last.is_ascii_digit() {
                    self.refuse(self.at, "two numbers without a comma between them");
                }
                if byte == b',' && matches!(self.last, b',' | b'[') {
                    self.refuse(self.at, "a comma without a value before it");
                }
                match byte {
                    b'{' if matches!(self.last, b'"' | b'\'' | b')') => self.open.push(Some(Properties::default())),
                    b'{' | b'[' | b'(' => self.open.push(None),
                    b'}' | b']' | b')' => drop(self.open.pop()),
                    _ => {}
                }
                match byte {
                    b'"' | b'\'' => self.string(byte),
                    b'@' => self.asset(),
                    b'<' => self.path(self.at),
                    b'[' => (self.at, self.listed) = (self.at + 1, Some(HashSet::new())),
                    b']' | b'{' => (self.at, self.listed) = (self.at + 1, None),
                    b'0'..=b'9' => self.number(),
                    b'.' if self.peek(1).is_ascii_digit() => {
                        self.replace(0, b"0");
                        self.at += 1;
                        self.digits();
                    }
                    b':' => self.at += 1,
                    _ if is_word(byte) => self.word(),
                    _ => self.at += 1,
                }
                self.last = if begins_number && byte == b'.' { b'0' } else { byte };
                self.begins = false;
            }
        }
    }

    fn refuse(&mut self, at: usize, what: &'static str) {
        self.refused = self.refused.or(Some((at, what)));
    }

    /// The name of a file, with the path in it if there is one.
    fn asset(&mut self) {
        let start = self.at;
        match self.rest().starts_with(b"@@@") {
            true => self.skip_to(3, b"@@@"),
            false => self.skip_to(1, b"@"),
        }
        if self.peek(0) == b'<' {
            self.path(start);
        }
    }

    /// A path, from where its file or itself begins. A list may not have one twice, unless an offset in parentheses follows.
    fn path(&mut self, start: usize) {
        self.skip_to(1, b">");
        let item = &self.text[start..self.at];
        let next = self.rest().iter().find(|byte| !byte.is_ascii_whitespace());
        // A file that is named before, and a space.
        let is_part = self.last == b'@';
        let is_again = |listed: &mut HashSet<_>| !is_part && next != Some(&b'(') && !listed.insert(item);
        if self.listed.as_mut().is_some_and(is_again) {
            self.refuse(start, "a path that its list has already");
        }
    }

    /// Goes to the end of the line.
    fn comment(&mut self) {
        self.at += self.rest().iter().take_while(|&&byte| byte != b'\n').count();
    }

    fn string(&mut self, quote: u8) {
        let three = [quote; 3];
        let is_long = self.rest().starts_with(&three);
        let end = if is_long { &three[..] } else { &three[..1] };
        self.at += end.len();
        while self.at < self.text.len() && !self.rest().starts_with(end) {
            match [self.peek(0), self.peek(1)] {
                // The library ends a long string at escaped quotes.
                [b'\\', next] if is_long && next == quote => self.replace(2, format!("\\x{quote:02x}").as_bytes()),
                [b'\\', _] => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at = (self.at + end.len()).min(self.text.len());
    }

    fn begins_number(&self, byte: u8) -> bool {
        byte.is_ascii_digit() || (matches!(byte, b'-' | b'.') && self.peek(1).is_ascii_digit())
    }

    fn digits(&mut self) {
        self.at += self.rest().iter().take_while(|byte| byte.is_ascii_digit()).count();
    }

    fn number(&mut self) {
        self.digits();
        if self.peek(0) == b'.' {
            self.at += 1;
            if !self.peek(0).is_ascii_digit() {
                self.replace(0, b"0");
            }
            self.digits();
        }
        if matches!(self.peek(0), b'e' | b'E') {
            self.at += 1 + usize::from(matches!(self.peek(1), b'+' | b'-'));
            self.digits();
        }
    }

    fn word(&mut self) {
        let len = self.rest().iter().take_while(|&&byte| is_word(byte)).count();
        let is_value = matches!(self.last, b'=' | b'[' | b',' | b'(' | b':');
        let begins = self.begins || matches!(self.last, b'{' | b'}' | b';');
        if begins {
            self.count(&self.rest()[..len]);
        }
        match &self.rest()[..len] {
            word if !word.is_ascii() => self.escape(word),
            b"yes" if is_value => self.replace(len, b"true"),
            b"no" if is_value => self.replace(len, b"false"),
            b"config" if begins && self.is_declaration(len) => self.replace(len, b"uniform"),
            word if begins && let Some(name) = LEFT_OUT.into_iter().find(|name| name.as_bytes() == word) => {
                self.leave_out(name);
            }
            word if (begins || self.last == b'(') && FLAGS.contains(&word) => self.flag(len),
            _ => self.at += len,
        }
        // After a property's name, digits are not a number of their own.
        if self.peek(0) == b'.' {
            self.at += 1;
        }
    }

    /// Counts a property of a prim by the word that begins it, and notes its type.
    fn count(&mut self, word: &[u8]) {
        let rest = self.rest();
        let Some(Some(properties)) = self.open.last_mut().filter(|_| !PRIMS.contains(&word)) else { return };
        properties.count += 1;
        let declaration = rest.split(|byte| b"=;({\n".contains(byte)).next().unwrap_or_default();
        let mut words = declaration.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).rev();
        let name = words.next().and_then(|name| name.split(|&byte| byte == b'.').next());
        let is_other = match (name, words.next()) {
            (Some(name), Some(kind)) => *properties.types.entry(name).or_insert(kind) != kind,
            _ => false,
        };
        if properties.count > MOST_PROPERTIES {
            self.refuse(self.at, TOO_MANY);
        } else if is_other {
            self.refuse(self.at, "a property that its prim has with another type");
        }
    }

    /// Goes behind a flag, and replaces a number that it is set to.
    fn flag(&mut self, len: usize) {
        self.at += len;
        let rest = self.rest();
        let gap = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t' | b'=')).count();
        let number = rest[gap..].iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
        if number > 0 && rest[..gap].contains(&b'=') {
            let is_set = rest[gap..gap + number].iter().any(|byte| matches!(byte, b'1'..=b'9'));
            self.at += gap;
            self.replace(number, if is_set { &b"true"[..] } else { b"false" });
        }
    }

    /// Replaces a field, whose value is a word or a dictionary, by the ends of its lines.
    fn leave_out(&mut self, name: &'static str) {
        let rest = &self.rest()[name.len()..];
        let (mut levels, mut is_text) = (0, false);
        let is_inside = |byte: &&u8| {
            is_text ^= **byte == b'"';
            levels += i32::from(!is_text && **byte == b'{') - i32::from(!is_text && **byte == b'}');
            levels > 0 || levels == 0 && !matches!(byte, b'\n' | b'}' | b';' | b')')
        };
        let len = rest.iter().take_while(is_inside).count();
        let len = len + usize::from(rest.get(len) == Some(&b'}'));
        let ends = rest[..len].iter().filter(|&&byte| byte == b'\n').count();
        self.replace(name.len() + len, &b"\n".repeat(ends));
        self.left_out.push(name);
    }

    /// Replaces a word that has letters beyond ASCII.
    fn escape(&mut self, word: &[u8]) {
        if self.letters.is_none() {
            self.letters = Letters::of(self.text);
        }
        match self.letters.as_ref().map(|letters| letters.escaped(word)) {
            Some(escaped) => self.replace(word.len(), &escaped),
            None => self.at += word.len(),
        }
    }

    /// Whether a type and a name come after the word.
    fn is_declaration(&self, len: usize) -> bool {
        let line = self.rest()[len..].split(|&byte| byte == b'\n').next().unwrap_or_default();
        let words = line.split(|&byte| byte == b'=').next().unwrap_or_default();
        words.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() == 2
    }
}

/// Letters, digits and signs of names.
fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':') || byte >= 0x80
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_spellings_become_those_that_are_read() {
        for (text, expected) in [
            ("#usda 1.1\n(\n)", "#usda 1.0\n(\n)"),
            ("a = .5", "a = 0.5"),
            ("a = -.5e-3", "a = -0.5e-3"),
            ("(0., 1., 2.e5)", "(0.0, 1.0, 2.0e5)"),
            ("0.:.5", "0.0:0.5"),
            ("a = 1 // half", "a = 1 ## half"),
            ("instanceable = yes", "instanceable = true"),
            ("bool[] a = [\n    yes, no, true]", "bool[] a = [\n    true, false, true]"),
            ("{\n    config float a = 1.", "{\n    uniform float a = 1.0"),
            ("(\n    active = 1\n    instanceable=0\n)", "(\n    active = true\n    instanceable=false\n)"),
            ("int a = 1 (hidden = 1.0)", "int a = 1 (hidden = true)"),
            ("(\n    symmetryFunction = mirror\n    active = true\n)", "(\n    \n    active = true\n)"),
            ("(\n    prefixSubstitutions = {\n    \"$}\": \"b\"\n    }\n)", "(\n    \n\n\n)"),
            ("doc = '''a\\''' b'''", "doc = '''a\\x27'' b'''"),
            ("doc = \"\"\"\\\"\"\"\"", "doc = \"\"\"\\x22\"\"\""),
        ] {
            let read = readable(text.as_bytes());
            assert_eq!(String::from_utf8_lossy(&read.text), expected, "{text}");
            assert!(read.letters.is_none(), "{text}");
        }
    }

    #[test]
    fn two_numbers_need_one_comma() {
        for (text, expected) in [
            ("int[] a = [1, 2,\n 3\n 4]", Some(3)),
            ("float3 a = (1 -2, 3)", Some(1)),
            ("float2 a = (.5 .5)", Some(1)),
            ("int[] a = [1,\n , 2]", Some(2)),
            ("string[] a = [, \"b\"]", Some(1)),
            ("string[] a = [\",,\", \"b\", # ,,\n]", None),
            ("#usda 1.0\n(\n    start = 1\n    end = 2\n)", None),
            ("a2 = { 1: 1e-5, # 2 3\n5: [1, -2], 6: \"7 8\" }", None),
            ("over \"a\" { float b2.timeSamples = { 1: 2, 3: 4 } }", None),
        ] {
            let refused = readable(text.as_bytes()).refused;
            assert_eq!(refused.map(|refused| refused.line), expected, "{text}");
        }
    }

    #[test]
    fn a_list_has_a_path_once() {
        for (text, expected) in [
            ("rel a = [\n    </A>,\n    </A>\n]", Some(3)),
            ("prepend rel a = [</A>, </B>, </A>,]", Some(1)),
            ("float a.connect = [</A.b>, </A.b>]", Some(1)),
            ("references = [@a.usda@</A>, @a.usda@</A>]", Some(1)),
            ("rel a = [</A>, </B>]\nrel b = [</A>, </B>]", None),
            ("references = [@a.usda@</A>, @b.usda@</A>, </A>]", None),
            ("references = [</A>, </A> (offset = 1)]", None),
            ("references = [@a.usda@ </A>, @b.usda@ </A>]", None),
            ("asset[] a = [@a.usda@, @a.usda@]", None),
            ("inherits = [</A>]\nrelocates = { </B>: </C>, </A>: </D> }", None),
        ] {
            let refused = readable(text.as_bytes()).refused;
            assert_eq!(refused.map(|refused| refused.line), expected, "{text}");
        }
    }

    #[test]
    fn a_property_has_one_type() {
        for (text, expected) in [
            ("def \"a\" {\n    int[] b = [1]\n    uniform token b = \"none\"\n}", Some(3)),
            ("over \"a\" {\n    float b\n    rel b = </A>\n}", Some(3)),
            ("def \"a\" {\n    float b = 1; double b.timeSamples = { 1: 2 }\n}", Some(2)),
            (
                "def \"a\" {\n    custom float b\n    float b.timeSamples = { 1: 2 }\n    float b.connect = </A.b>\n}",
                None,
            ),
            ("def \"a\" {\n    prepend rel b = </A>\n    delete rel b = </B>\n}", None),
            ("def \"a\" {\n    float b\n    def \"b\" {\n        double b\n    }\n    float b = 1\n}", None),
            (
                "def \"a\" {\n    variantSet \"v\" = {\n        \"x\" { float b }\n        \"y\" { int b }\n    }\n}",
                None,
            ),
            ("over \"a\" {\n    dictionary b = {\n        int c = 1\n        string c = \"d\"\n    }\n}", None),
        ] {
            let refused = readable(text.as_bytes()).refused;
            assert_eq!(refused.map(|refused| refused.line), expected, "{text}");
        }
    }

    #[test]
    fn properties_of_one_prim_are_bounded() {
        let of = |line: &str, count: usize| format!("def \"a\" {{\n    {}}}\n", format!("{line}\n").repeat(count));
        let refused = |text: String| readable(text.as_bytes()).refused;
        for property in
            ["float a", "custom rel b = </A> (\n    doc = \"c\"\n)", "bool[] d = [\n    true,\n    false\n]"]
        {
            assert_eq!(refused(of(property, MOST_PROPERTIES)), None, "{property}");
            assert_eq!(refused(of(property, MOST_PROPERTIES + 1)).map(|of| of.what), Some(TOO_MANY), "{property}");
        }
        let half = of("float a; double b", MOST_PROPERTIES / 2);
        for line in ["def \"b\" {}".to_owned(), half.clone(), format!("variantSet \"v\" = {{ \"w\" {} }}", &half[8..])]
        {
            assert_eq!(refused(of(&line, 3)), None, "{}", &line[..12]);
        }
        assert_eq!(
            refused(format!(
                "over \"a\" {{ int b.timeSamples = {{\n{}}}\n}}",
                "none: 1,\n".repeat(2 * MOST_PROPERTIES)
            )),
            None
        );
    }

    #[test]
    fn what_is_read_stays() {
        for text in [
            "#usda 1.0\n(\n    doc = \"\"\"a .5 // \"quoted\" 1. \"\"\"\n)",
            "asset a = @//host/x1.usd@",
            "asset a = @@@./a//b.usd@@@",
            "rel a = </A//B1.out>",
            "a.connect = </A/B1.x>",
            "float xformOp:translate:x2.timeSamples = { 1: 0.5 }",
            "string a = 'it\\'s .5'",
            "/* // .5 */ float a = 1.5",
            "# // .5 1.",
            "float config = 1",
            "int active = 1",
            "token symmetryFunction = \"a\"",
            "active = true",
            "token yes = \"no\"",
            "string a = \"not closed .5",
        ] {
            assert!(matches!(readable(text.as_bytes()).text, Cow::Borrowed(_)), "{text}");
        }
    }

    #[test]
    fn letters_beyond_ascii_are_escaped_in_words_alone() {
        for (text, expected) in [
            ("float primvars:größe.connect = </A.größe>", "float primvars:grletters0_c3b6c39f_e.connect = </A.größe>"),
            ("rel ö = </ö>", "rel letters0_c3b6_ = </ö>"),
            ("letters0_ ä", "letters0_ letters1_c3a4_"),
            ("string a = \"größe\" # größe", "string a = \"größe\" # größe"),
            ("def Mesh \"Größe\" { asset a = @größe.png@ }", "def Mesh \"Größe\" { asset a = @größe.png@ }"),
        ] {
            let read = readable(text.as_bytes());
            assert_eq!(String::from_utf8_lossy(&read.text), expected, "{text}");
            assert_eq!(read.letters.is_some(), text != expected, "{text}");
        }
    }
}
