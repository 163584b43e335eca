//! `usdtailor explain`.

use super::{Output, usage};
use clap::Args;
use std::fmt::Write as _;
use tailor_mesh::error::Error;
use tailor_mesh::options::did_you_mean;

/// The page with a section for each code.
const PAGE: &str = include_str!("../../docs/diagnostics.md");

#[derive(Args)]
pub struct Explain {
    /// A code, as in `error[no-mesh]` [default: list all]
    #[arg(value_name = "CODE")]
    code: Option<String>,
}

/// The section of a code: its heading's text, and the lines below it.
struct Section {
    code: &'static str,
    text: &'static str,
}

/// Explains a code.
pub fn run(args: &Explain) -> Result<Output, Error> {
    let text = match &args.code {
        Some(code) => explained(code)?,
        None => list(),
    };
    Ok(Output { text, code: 0 })
}

/// The section of a code; the brackets that messages have around it may be there.
fn explained(code: &str) -> Result<String, Error> {
    let wanted = code.trim_start_matches("error").trim_start_matches("warning").trim_matches(['[', ']', ':']);
    let found = sections().find(|section| section.code.eq_ignore_ascii_case(wanted));
    if let Some(Section { code, text }) = found {
        return Ok(format!("{code}\n\n{text}\n"));
    }
    let codes: Vec<&str> = sections().map(|section| section.code).collect();
    let likely = did_you_mean(wanted, &codes);
    let fault = usage("", format!("there is no code \"{code}\""));
    Err(fault.remedy(format!("{likely}`usdtailor explain` lists all codes")))
}

/// All codes, each with the first sentence of its section.
fn list() -> String {
    let width = sections().map(|section| section.code.len()).max().unwrap_or(0);
    sections().fold(String::new(), |mut all, Section { code, text }| {
        let meaning = text.lines().next().unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = writeln!(all, "{code:width$}  {meaning}");
        all
    })
}

fn sections() -> impl Iterator<Item = Section> {
    // A heading of a higher level ends the section before it.
    PAGE.split("\n### ").skip(1).filter_map(|part| {
        let (code, text) = part.split_once('\n')?;
        let text = text.split("\n## ").next().unwrap_or_default();
        Some(Section { code: code.trim(), text: text.trim() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes::PARTS;
    use std::collections::BTreeSet;

    /// The codes of the sections below a heading.
    fn told(heading: &str) -> Vec<String> {
        let part = PAGE.split("\n## ").find(|part| part.starts_with(heading)).expect("the heading");
        part.split("\n### ").skip(1).filter_map(|section| Some(section.lines().next()?.to_owned())).collect()
    }

    #[test]
    fn every_code_has_a_section_and_every_section_a_code() {
        let errors: Vec<&str> = PARTS.iter().flat_map(|part| part.errors).map(|code| code.name()).collect();
        let warnings: Vec<&str> = PARTS.iter().flat_map(|part| part.warnings).map(|code| code.name()).collect();
        for (heading, codes) in [("Errors", errors), ("Warnings", warnings)] {
            let count = codes.len();
            let (told, codes) =
                (BTreeSet::from_iter(told(heading)), BTreeSet::from_iter(codes.into_iter().map(str::to_owned)));
            assert_eq!(codes.len(), count, "{heading}: a code is declared twice");
            let lacks: Vec<_> = codes.difference(&told).collect();
            let surplus: Vec<_> = told.difference(&codes).collect();
            assert!(lacks.is_empty() && surplus.is_empty(), "{heading} lack {lacks:?} and have {surplus:?}");
        }
        let all: BTreeSet<_> = sections().map(|section| section.code).collect();
        assert_eq!(all.len(), sections().count(), "each code is unique");
    }

    #[test]
    fn sections_of_warnings_name_the_severity_of_their_code() {
        for known in PARTS.iter().flat_map(|part| part.warnings) {
            let text = explained(known.name()).expect("a section");
            assert!(text.contains(&format!("\n\nSeverity: {}.\n", known.severity())), "{text}");
        }
    }

    #[test]
    fn every_section_has_meaning_cause_and_remedy() {
        for Section { code, text } in sections() {
            let first = text.lines().next().unwrap_or_default();
            assert!(first.ends_with('.') && first.len() < 100, "{code}: a short first sentence");
            for part in ["\n\nCause: ", "\n\nRemedy: "] {
                assert_eq!(text.matches(part).count(), 1, "{code}: {part:?}");
            }
        }
    }

    #[test]
    fn a_code_is_found_as_messages_print_it() {
        for code in ["no-mesh", "error[no-mesh]", "NO-MESH", "[no-mesh]:"] {
            assert!(explained(code).is_ok_and(|text| text.starts_with("no-mesh\n\n")), "{code}");
        }
    }

    #[test]
    fn an_unknown_code_suggests_a_near_one_alone() {
        let message = |code| explained(code).expect_err("unknown").to_string();
        assert!(message("no-mseh").contains("did you mean no-mesh?"), "{}", message("no-mseh"));
        for far in ["foo", "x", "", "garment"] {
            let message = message(far);
            assert!(!message.contains("did you mean") && message.contains("lists all codes"), "{message}");
        }
    }
}
