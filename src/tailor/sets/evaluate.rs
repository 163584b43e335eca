//! From an expression to the elements of a garment.

use super::elements::ElementSet;
use super::expression::{Argument, Expression, quoted};
use super::pieces::{chosen, face_pieces, pieces};
use super::{SetEvaluator, SetFault};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{EdgeId, FaceId, VertexId};
use tailor_mesh::garment::{LeftOut, Primvar, UvSeams};
use tailor_mesh::options::did_you_mean;

/// Different calls of functions that an expression may have. Their sets are kept.
const MOST_CALLS: usize = 200;

/// A function that gives a set.
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// How it is written, with all arguments.
    pub usage: &'static str,
    /// The kind of its elements, in the plural.
    pub gives: &'static str,
    /// Its elements, in one sentence.
    pub meaning: &'static str,
    /// The least and the greatest number of arguments.
    pub(super) arguments: [usize; 2],
    pub(super) evaluate: fn(&Evaluation<'_>, &Arguments<'_>) -> Result<ElementSet, SetFault>,
}

/// An evaluation under way.
pub struct Evaluation<'a> {
    /// The garment.
    pub sets: &'a SetEvaluator<'a>,
    /// The functions that expressions may call.
    pub functions: &'static [Function],
    /// Alternatives of the garment for what was not found.
    pub notes: RefCell<Vec<String>>,
    /// The sets of calls so far, by their texts: equal ones are evaluated once.
    pub known: RefCell<BTreeMap<String, ElementSet>>,
}

/// The arguments of a function.
pub struct Arguments<'a> {
    function: &'static Function,
    given: &'a [Argument],
}

impl<'a> Evaluation<'a> {
    /// The elements of an expression.
    pub fn evaluate(&self, expression: &Expression) -> Result<ElementSet, SetFault> {
        match expression {
            Expression::Name(name) => self.named(name),
            Expression::Call(name, arguments) => self.call(name, arguments),
            Expression::Piece(of, choice) => {
                let pieces = self.pieces(of)?;
                let (count, nothing) = (pieces.len(), pieces.first().map(empty_of));
                if let Some(piece) = chosen(self.sets, pieces, *choice) {
                    return Ok(piece);
                }
                self.note(format!("the set has {count} pieces"));
                nothing.map_or_else(|| self.evaluate(of), Ok)
            }
            Expression::Combined(first, rest) => {
                rest.iter().try_fold(self.evaluate(first)?, |set, (operation, other)| {
                    set.combine(*operation, self.evaluate(other)?)
                })
            }
        }
    }

    /// The pieces of a set; the shells of UV shells, which are connected in the UV set.
    fn pieces(&self, of: &Expression) -> Result<Vec<ElementSet>, SetFault> {
        let arguments: &[Argument] = match of {
            Expression::Call(name, arguments) if name == UV_SHELLS => arguments,
            Expression::Name(name) if name == UV_SHELLS && self.sets.garment.subset(name).is_none() => &[],
            _ => return Ok(pieces(&self.sets.topology, &self.evaluate(of)?)),
        };
        let function = self.function(UV_SHELLS).expect("a function of the table");
        let seams = self.uv_seams(&Arguments { function, given: arguments }, 0)?;
        Ok(seams.map_or_else(Vec::new, |seams| self.shells(&seams)))
    }

    /// The shells of a UV set.
    pub fn shells(&self, seams: &UvSeams<'_>) -> Vec<ElementSet> {
        let t = &self.sets.topology;
        face_pieces(t, &t.faces.ids().collect(), |edge| seams.is_cut(t, edge))
    }

    /// Notes the alternatives for what was not found.
    pub fn note(&self, note: String) {
        self.notes.borrow_mut().push(note);
    }

    fn function(&self, name: &str) -> Option<&'static Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    fn named(&self, name: &str) -> Result<ElementSet, SetFault> {
        if let Some(set) = self.sets.garment.subset(name) {
            return Ok(ElementSet::of(&self.sets.topology, &set.elements));
        }
        match self.function(name) {
            Some(_) => self.call(name, &[]),
            None => Err(self.unknown(name)),
        }
    }

    fn call(&self, name: &str, given: &[Argument]) -> Result<ElementSet, SetFault> {
        let text = format!("{name}{given:?}");
        if let Some(set) = self.known.borrow().get(&text) {
            return Ok(set.clone());
        }
        let function = self.function(name).ok_or_else(|| self.unknown(name))?;
        let [least, most] = function.arguments;
        if !(least..=most).contains(&given.len()) {
            let text = format!("{name} has {} arguments", given.len());
            return Err(SetFault::new(text, format!("write {}", function.usage)));
        }
        let set = (function.evaluate)(self, &Arguments { function, given })?;
        let mut known = self.known.borrow_mut();
        if known.len() == MOST_CALLS {
            let text = format!("the expression has more than {MOST_CALLS} different calls of functions");
            return Err(SetFault::new(text, "write parts of it as subsets by `usdtailor sets --bake`, and name these"));
        }
        known.insert(text, set.clone());
        Ok(set)
    }

    fn unknown(&self, name: &str) -> SetFault {
        let subsets = self.sets.garment.subsets.iter().map(|set| set.name.as_str());
        let known: Vec<&str> = subsets.clone().chain(self.functions.iter().map(|function| function.name)).collect();
        let own: Vec<String> = subsets.map(quoted).collect();
        let own = if own.is_empty() { "none".to_owned() } else { own.join(", ") };
        let prim = &self.sets.garment.prim;
        let text = format!("\"{name}\" is not a subset of {prim} or the name of a derived set");
        let remedy = format!(
            "{}its subsets are: {own}; derived sets are such as borders, uvSeams or material(...)",
            did_you_mean(name, &known)
        );
        SetFault { code: tailor_mesh::codes::UNKNOWN_SUBSET, ..SetFault::new(text, remedy) }
    }

    /// The seams of the UV set that an argument names, or else of that of the recipe; none with a note if there is none.
    pub fn uv_seams(&self, arguments: &Arguments<'_>, number: usize) -> Result<Option<UvSeams<'a>>, SetFault> {
        let garment = self.sets.garment;
        let name = if arguments.has(number) { arguments.name(number)? } else { self.sets.uv_set };
        let found = garment.primvar(name).filter(|primvar| primvar.is_uv_set());
        if found.is_none() {
            let known =
                garment.primvars.iter().filter(|primvar| primvar.is_uv_set()).map(|primvar| quoted(&primvar.name));
            self.note(among("the face-varying UV sets", known));
        }
        Ok(found.map(|primvar| UvSeams::new(primvar, &self.sets.topology)))
    }

    /// The primvar that an argument names; none with a note where no primvar of that name `fits`.
    pub fn primvar(
        &self,
        arguments: &Arguments<'_>,
        what: &str,
        fits: impl Fn(&Primvar) -> bool,
    ) -> Result<Option<&'a Primvar>, SetFault> {
        let (garment, name) = (self.sets.garment, arguments.name(0)?);
        if let Some(LeftOut { fault, .. }) = garment.left_out(name) {
            let text = format!("{} cannot be used: {} {}", quoted(name), fault.place, fault.text);
            return Err(SetFault { code: fault.code, ..SetFault::new(text, &fault.remedy) });
        }
        let found = garment.primvar(name).filter(|primvar| fits(primvar));
        if found.is_none() {
            let known = garment.primvars.iter().filter(|primvar| fits(primvar)).map(|primvar| quoted(&primvar.name));
            self.note(among(what, known));
        }
        Ok(found)
    }
}

/// The function whose pieces are connected in the UV set.
const UV_SHELLS: &str = "uvShells";

/// A set of the same kind without elements.
fn empty_of(set: &ElementSet) -> ElementSet {
    match set {
        ElementSet::Faces(_) => ElementSet::Faces(Default::default()),
        ElementSet::Edges(_) => ElementSet::Edges(Default::default()),
        ElementSet::Points(_) => ElementSet::Points(Default::default()),
    }
}

/// A list of alternatives, as a note.
pub fn among(what: &str, known: impl Iterator<Item = String>) -> String {
    let known: Vec<String> = known.collect();
    format!("{what} are: {}", if known.is_empty() { "none".to_owned() } else { known.join(", ") })
}

impl Arguments<'_> {
    /// True if an argument is given.
    pub fn has(&self, number: usize) -> bool {
        number < self.given.len()
    }

    fn fault(&self, number: usize, expected: &str) -> SetFault {
        let text = format!("argument {} of {} is not {expected}", number + 1, self.function.name);
        SetFault::new(text, format!("write {}", self.function.usage))
    }

    /// A set.
    pub fn set(&self, of: &Evaluation<'_>, number: usize) -> Result<ElementSet, SetFault> {
        match self.given.get(number) {
            Some(Argument::Set(expression)) => of.evaluate(expression),
            _ => Err(self.fault(number, "a set")),
        }
    }

    /// A name.
    pub fn name(&self, number: usize) -> Result<&str, SetFault> {
        match self.given.get(number) {
            Some(Argument::Set(Expression::Name(name))) => Ok(name),
            _ => Err(self.fault(number, "a name")),
        }
    }

    /// A number, or `default` if it is not given.
    pub fn number(&self, number: usize, default: f64) -> Result<f64, SetFault> {
        match self.given.get(number) {
            None => Ok(default),
            Some(Argument::Number(value)) => Ok(*value),
            _ => Err(self.fault(number, "a number")),
        }
    }

    /// A length. \[mesh units\]
    pub fn length(&self, number: usize, mesh_unit: f64) -> Result<f64, SetFault> {
        match self.given.get(number) {
            Some(Argument::Number(value)) => Ok(*value),
            Some(Argument::Meters(meters)) => Ok(meters / mesh_unit),
            _ => Err(self.fault(number, "a length")),
        }
    }

    /// A value as its text; none if it is not given.
    pub fn value(&self, number: usize) -> Result<Option<String>, SetFault> {
        match self.given.get(number) {
            None => Ok(None),
            Some(Argument::Number(value)) => Ok(Some(value.to_string())),
            _ => Ok(Some(self.name(number)?.to_owned())),
        }
    }

    /// A set that has to be of faces.
    pub fn faces(&self, of: &Evaluation<'_>, number: usize) -> Result<BTreeSet<FaceId>, SetFault> {
        match self.set(of, number)? {
            ElementSet::Faces(faces) => Ok(faces),
            other => Err(self.fault(number, &format!("a set of faces, and {} are given", other.kind()))),
        }
    }

    /// A set that has to be of edges.
    pub fn edges(&self, of: &Evaluation<'_>, number: usize) -> Result<BTreeMap<EdgeId, [VertexId; 2]>, SetFault> {
        match self.set(of, number)? {
            ElementSet::Edges(edges) => Ok(edges),
            other => Err(self.fault(number, &format!("a set of edges, and {} are given", other.kind()))),
        }
    }
}
