//! The indentation of dictionaries.
//!
//! The USD library writes the lines of a dictionary as if it were at the left border. Texts in a layer have no line breaks of their
//! own, so each line stands for itself.

use std::io::{self, Write};

/// Spaces of a level.
const STEP: usize = 4;
/// Longest begin of a line that is looked at. The name of a field of metadata is shorter.
const HEAD: usize = 256;

/// Indents dictionaries in metadata as OpenUSD does, as the text comes.
pub struct Indented<'a, W: Write> {
    out: &'a mut W,
    /// The begin of the line.
    head: Vec<u8>,
    /// The indentation of the dictionary around the line, and the dictionaries that are open in it.
    open: Option<(usize, usize)>,
    /// Whether the line has nothing but spaces so far.
    is_begin: bool,
}

impl<'a, W: Write> Indented<'a, W> {
    pub fn new(out: &'a mut W) -> Self {
        Self { out, head: Vec::new(), open: None, is_begin: true }
    }

    /// Writes a part of a line.
    fn part(&mut self, mut part: &[u8]) -> io::Result<()> {
        if let Some((base, levels)) = &mut self.open
            && self.is_begin
        {
            part = part.trim_ascii_start();
            let Some(first) = part.first() else { return Ok(()) };
            *levels -= usize::from(*first == b'}');
            write!(self.out, "{:1$}", "", *base + STEP * *levels)?;
            if *levels == 0 {
                self.open = None;
            }
        }
        self.is_begin &= part.is_empty();
        let room = HEAD.saturating_sub(self.head.len());
        self.head.extend_from_slice(&part[..part.len().min(room)]);
        self.out.write_all(part)
    }

    fn end_line(&mut self) -> io::Result<()> {
        let line = self.head.trim_ascii_start();
        let name = line.strip_suffix(b" = {").filter(|_| self.head.len() < HEAD);
        match (&mut self.open, name) {
            (Some((_, levels)), Some(_)) => *levels += 1,
            // A field of metadata. Others, such as variant sets, are more than one word.
            (None, Some(name)) if !name.contains(&b' ') => self.open = Some((self.head.len() - line.len(), 1)),
            _ => {}
        }
        self.head.clear();
        self.is_begin = true;
        self.out.write_all(b"\n")
    }
}

impl<W: Write> Write for Indented<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut lines = bytes.split(|&byte| byte == b'\n');
        self.part(lines.next().unwrap_or_default())?;
        for line in lines {
            self.end_line()?;
            self.part(line)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRITTEN: &str = "\
(
    customLayerData = {
    dictionary tailor = {
    string \"a = {\" = \"b = {\"
    dictionary empty = {
}
}
    int last = 1
}
    doc = \"x = {\"
)
def \"A\" (
    customData = {
    bool b = 1
}
)
{
    float a.timeSamples = {
        1: 2,
    }
    variantSet \"v\" = {
        \"one\" {
            over \"B\" (
                assetInfo = {
    string name = \"n\"
}
            )
            {
            }
        }
    }
}
";
    const EXPECTED: &str = "\
(
    customLayerData = {
        dictionary tailor = {
            string \"a = {\" = \"b = {\"
            dictionary empty = {
            }
        }
        int last = 1
    }
    doc = \"x = {\"
)
def \"A\" (
    customData = {
        bool b = 1
    }
)
{
    float a.timeSamples = {
        1: 2,
    }
    variantSet \"v\" = {
        \"one\" {
            over \"B\" (
                assetInfo = {
                    string name = \"n\"
                }
            )
            {
            }
        }
    }
}
";

    #[test]
    fn dictionaries_are_indented_however_the_text_is_cut() {
        for size in [1, 2, 3, 7, 64, WRITTEN.len()] {
            let mut text = Vec::new();
            let mut out = Indented::new(&mut text);
            WRITTEN.as_bytes().chunks(size).for_each(|part| out.write_all(part).expect("memory"));
            assert_eq!(String::from_utf8(text).expect("text"), EXPECTED, "parts of {size}");
        }
    }

    #[test]
    fn what_is_indented_stays() {
        let mut text = Vec::new();
        Indented::new(&mut text).write_all(EXPECTED.as_bytes()).expect("memory");
        assert_eq!(String::from_utf8(text).expect("text"), EXPECTED);
    }
}
