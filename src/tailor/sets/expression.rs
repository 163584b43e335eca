//! The grammar of set expressions, and their parser.
//!
//! ```text
//! list         = sum { "," sum }                              union
//! sum          = intersection { ( "+" | "-" ) intersection }  union and difference, from left to right
//! intersection = piece { "&" piece }
//! piece        = primary { "." ( number | word ) }
//! primary      = word [ "(" argument { "," argument } ")" ] | "quoted name" | "(" list ")"
//! argument     = sum | number [ unit ]
//! ```

use super::SetFault;
use tailor_mesh::garment::units::meters_of;

/// Parentheses and pieces that an expression may have inside one another. Evaluation recurses this far.
const DEEPEST: usize = 40;

/// A set of elements, as text describes it.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A set of the garment by its name, or a function without arguments.
    Name(String),
    /// A function with arguments.
    Call(String, Vec<Argument>),
    /// One connected piece of a set.
    Piece(Box<Self>, Choice),
    /// Sets that are combined from left to right.
    Combined(Box<Self>, Vec<(Operation, Self)>),
}

/// An argument of a function.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A set, or a name.
    Set(Expression),
    /// A number.
    Number(f64),
    /// A length with its unit. \[m\]
    Meters(f64),
}

/// How two sets are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// The elements of either.
    Union,
    /// The elements of the first that are not in the second.
    Difference,
    /// The elements of both.
    Intersection,
}

/// One of the pieces of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// By its number from 1, in the order of the mesh.
    Number(usize),
    /// By its place or size.
    Extreme(Extreme),
}

/// The piece that is farthest in a direction, or the largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extreme {
    /// Against the up axis of the stage.
    Lowest,
    /// Along the up axis of the stage.
    Highest,
    /// The least coordinate on an axis of the stage.
    Least(usize),
    /// The greatest coordinate on an axis of the stage.
    Greatest(usize),
    /// The greatest length, area, or number of points.
    Largest,
}

impl Extreme {
    /// All of them by their words, in the order in which places are named.
    pub const ALL: [(&'static str, Self); 9] = [
        ("lowest", Self::Lowest),
        ("highest", Self::Highest),
        ("minX", Self::Least(0)),
        ("maxX", Self::Greatest(0)),
        ("minY", Self::Least(1)),
        ("maxY", Self::Greatest(1)),
        ("minZ", Self::Least(2)),
        ("maxZ", Self::Greatest(2)),
        ("largest", Self::Largest),
    ];
}

impl Expression {
    /// Parses an expression, or several with commas between them, which are a union.
    ///
    /// # Errors
    /// A text that the grammar does not have, with the place in it.
    pub fn parse(text: &str) -> Result<Self, SetFault> {
        let mut parser = Parser { text, at: 0, depth: 0 };
        let expression = parser.list()?;
        match parser.peek() {
            None => Ok(expression),
            Some(letter) => Err(parser.fault(&format!("`{letter}` is unexpected"))),
        }
    }
}

/// Splits a list at the commas outside of parentheses and quotes. Empty parts are left out.
pub fn split_list(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quote) = (vec![String::new()], 0usize, None);
    for letter in text.chars() {
        match (quote, letter) {
            (None, ',') if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            (None, '(') => depth += 1,
            (None, ')') => depth = depth.saturating_sub(1),
            (None, '"' | '\'') => quote = Some(letter),
            (Some(open), _) if open == letter => quote = None,
            _ => {}
        }
        parts.last_mut().expect("there is a part").push(letter);
    }
    parts.iter().map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()
}

/// A name as expressions write it: quoted where it is not a word.
pub fn quoted(name: &str) -> String {
    let is_word = name.chars().next().is_some_and(starts_word) && name.chars().all(continues_word);
    match () {
        () if is_word => name.to_owned(),
        () if name.contains('"') => format!("'{name}'"),
        () => format!("\"{name}\""),
    }
}

fn starts_word(letter: char) -> bool {
    letter.is_alphabetic() || letter == '_'
}

fn continues_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_' || letter == ':'
}

struct Parser<'a> {
    text: &'a str,
    /// The next byte.
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// The next letter after spaces.
    fn peek(&mut self) -> Option<char> {
        self.at += self.rest().len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    fn take(&mut self, letter: char) -> bool {
        let is_next = self.peek() == Some(letter);
        self.at += if is_next { letter.len_utf8() } else { 0 };
        is_next
    }

    fn expect(&mut self, letter: char) -> Result<(), SetFault> {
        if self.take(letter) { Ok(()) } else { Err(self.fault(&format!("`{letter}` is missing"))) }
    }

    fn fault(&self, problem: &str) -> SetFault {
        let before = self.text[..self.at].chars().count();
        let text = format!("\"{}\" is not a set: {problem} after {before} characters", self.text);
        SetFault::new(text, "write a set such as uvSeams, borders.lowest or border(collar) - borders")
    }

    /// Counts what is inside one another.
    fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Result<T, SetFault>) -> Result<T, SetFault> {
        if self.depth == DEEPEST {
            return Err(self.fault(&format!("more than {DEEPEST} parentheses are inside one another")));
        }
        self.depth += 1;
        let result = parse(self);
        self.depth -= 1;
        result
    }

    fn list(&mut self) -> Result<Expression, SetFault> {
        self.chain(&[(',', Operation::Union)], Self::sum)
    }

    fn sum(&mut self) -> Result<Expression, SetFault> {
        self.chain(&[('+', Operation::Union), ('-', Operation::Difference)], Self::intersection)
    }

    fn intersection(&mut self) -> Result<Expression, SetFault> {
        self.chain(&[('&', Operation::Intersection)], Self::piece)
    }

    /// Parts with operations of one rank between them.
    fn chain(
        &mut self,
        operations: &[(char, Operation)],
        part: fn(&mut Self) -> Result<Expression, SetFault>,
    ) -> Result<Expression, SetFault> {
        let first = part(self)?;
        let mut rest = Vec::new();
        while let Some((_, operation)) = operations.iter().find(|(sign, _)| self.take(*sign)) {
            rest.push((*operation, part(self)?));
        }
        Ok(combined(first, rest))
    }

    fn piece(&mut self) -> Result<Expression, SetFault> {
        let mut of = self.primary()?;
        let mut pieces = 0;
        while self.take('.') {
            pieces += 1;
            if pieces > DEEPEST {
                return Err(self.fault(&format!("more than {DEEPEST} pieces are taken of one another")));
            }
            of = Expression::Piece(Box::new(of), self.choice()?);
        }
        Ok(of)
    }

    fn choice(&mut self) -> Result<Choice, SetFault> {
        let word = self.word();
        if let Some((_, extreme)) = Extreme::ALL.iter().find(|(known, _)| *known == word) {
            return Ok(Choice::Extreme(*extreme));
        }
        match word.parse() {
            Ok(number) if number > 0 => Ok(Choice::Number(number)),
            _ => {
                let words: Vec<&str> = Extreme::ALL.iter().map(|(word, _)| *word).collect();
                Err(self.fault(&format!("a piece is a number from 1, or {}, and `{word}` is read", words.join(", "))))
            }
        }
    }

    /// Letters, digits and colons; empty if none is next.
    fn word(&mut self) -> String {
        self.peek();
        let end = self.rest().find(|letter| !continues_word(letter)).unwrap_or(self.rest().len());
        let word = self.rest()[..end].to_owned();
        self.at += end;
        word
    }

    fn primary(&mut self) -> Result<Expression, SetFault> {
        match self.peek() {
            Some('(') => self.deeper(|parser| {
                parser.expect('(')?;
                let inner = parser.list()?;
                parser.expect(')')?;
                Ok(inner)
            }),
            Some(quote @ ('"' | '\'')) => {
                let inner = self.rest()[1..].split(quote).next().unwrap_or_default().to_owned();
                self.at += 1 + inner.len();
                self.expect(quote)?;
                Ok(Expression::Name(inner))
            }
            Some(letter) if starts_word(letter) => {
                let word = self.word();
                if self.peek() != Some('(') {
                    return Ok(Expression::Name(word));
                }
                let arguments = self.deeper(Self::arguments)?;
                Ok(Expression::Call(word, arguments))
            }
            _ => Err(self.fault("the name of a set is missing")),
        }
    }

    fn arguments(&mut self) -> Result<Vec<Argument>, SetFault> {
        self.expect('(')?;
        let mut arguments = Vec::new();
        if self.take(')') {
            return Ok(arguments);
        }
        loop {
            arguments.push(self.argument()?);
            if !self.take(',') {
                self.expect(')')?;
                return Ok(arguments);
            }
        }
    }

    fn argument(&mut self) -> Result<Argument, SetFault> {
        let is_number = |letter: char| letter.is_ascii_digit() || letter == '-' || letter == '.';
        if !self.peek().is_some_and(is_number) {
            return Ok(Argument::Set(self.sum()?));
        }
        let end = self.rest().find([',', ')']).unwrap_or(self.rest().len());
        let text = self.rest()[..end].trim().to_owned();
        let argument = match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Argument::Number(number),
            _ => match meters_of(&text) {
                Some(meters) => Argument::Meters(meters),
                None => return Err(self.fault(&format!("`{text}` is not a number or a length such as 8mm"))),
            },
        };
        self.at += end;
        Ok(argument)
    }
}

/// Sets that are combined; the first alone if there is no other.
fn combined(first: Expression, rest: Vec<(Operation, Expression)>) -> Expression {
    if rest.is_empty() { first } else { Expression::Combined(Box::new(first), rest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(name: &str) -> Expression {
        Expression::Name(name.to_owned())
    }

    #[test]
    fn intersections_bind_before_sums_and_lists() {
        let of = |text: &str| Expression::parse(text).expect(text);
        let and = Expression::Combined(Box::new(name("b")), vec![(Operation::Intersection, name("c"))]);
        let rest = vec![(Operation::Difference, and), (Operation::Union, name("d"))];
        assert_eq!(of("a - b & c + d"), Expression::Combined(Box::new(name("a")), rest));
        assert_eq!(of("(a)"), name("a"));
        assert_eq!(of("a, b"), of("a + b"));
        let piece = Expression::Piece(Box::new(name("borders")), Choice::Number(2));
        assert_eq!(of(" borders . 2 "), piece);
        assert_eq!(of("borders.2.lowest"), Expression::Piece(Box::new(piece), Choice::Extreme(Extreme::Lowest)));
        assert_eq!(of("\"a b\""), name("a b"));
        let arguments = vec![Argument::Set(name("pin:a")), Argument::Number(0.5), Argument::Meters(0.02)];
        assert_eq!(of("f(pin:a, 0.5, 2cm)"), Expression::Call("f".to_owned(), arguments));
    }

    #[test]
    fn faults_say_where_they_are() {
        for (text, problem) in [
            ("", "missing after 0"),
            ("a +", "missing after 3"),
            ("a b", "`b` is unexpected after 2"),
            ("f(a", "`)` is missing"),
            ("borders.0", "a piece is a number from 1"),
            ("f(2 km)", "is not a number or a length"),
            ("\"a", "`\"` is missing"),
        ] {
            let fault = Expression::parse(text).expect_err(text);
            assert!(fault.text.contains(problem), "{text}: {}", fault.text);
        }
        for deep in ["(".repeat(100_000), "f(".repeat(100_000), format!("a{}", ".1".repeat(100_000))] {
            assert!(Expression::parse(&deep).is_err_and(|fault| fault.text.contains("more than 40")));
        }
    }

    #[test]
    fn lists_are_split_outside_of_parentheses_and_quotes() {
        assert_eq!(split_list("a, border(b, c), \"d,e\",, "), ["a", "border(b, c)", "\"d,e\""]);
        assert!(split_list(" ").is_empty());
        assert_eq!([quoted("a:b_2"), quoted("2a"), quoted("a \"b\"")], ["a:b_2", "\"2a\"", "'a \"b\"'"]);
    }
}
