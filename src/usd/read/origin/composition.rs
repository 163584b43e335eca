//! Bounds the arcs of a prim (references, payloads, inherits, specializes) before a stage is composed: where each of two
//! references leads to a prim with two references, and so on, they double with each level.

use super::content::ReadFiles;
use super::resolver::{Files, package_file};
use crate::assets::ARGUMENTS;
use crate::codes;
use openusd::ar::{ResolvedPath, Resolver};
use openusd::sdf::{self, FieldKey, Layer, Value, default_prim_path};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use tailor_mesh::error::Error;

/// Arcs of one prim, with those of the prims that they lead to. The USD library takes time that grows with their square.
const MOST_ARCS: usize = 2000;
/// Bytes of a file that is read. Larger ones hold points, and are too slow to read twice.
const MOST_BYTES: u64 = 8 << 20;
/// Files that are read.
const MOST_FILES: usize = 1000;
/// Arcs that are followed. Sets of a film have fewer.
const MOST_FOLLOWED: usize = 1_000_000;
/// Levels of a prim that is counted: a prim that refers to one below it has no end of them.
const MOST_LEVELS: usize = 256;
/// The fields of a prim with arcs, as text has them. A file without any of these words has no arcs.
const WORDS: [&str; 5] = ["references", "payload", "inherits", "specializes", "subLayers"];

/// Refuses a stage with a prim of too many arcs. Those of all variants of a set count as those of the one with the most.
///
/// # Errors
/// Such a prim, by its place. A layer that cannot be read has no arcs here.
pub fn check_arcs(file: &str, read: &Arc<ReadFiles>) -> Result<(), Error> {
    let mut arcs = Arcs { files: Files::of(read), known: Arc::clone(read), ..Arcs::default() };
    arcs.stack(file.to_owned());
    // More stacks are found as arcs are followed to them.
    for stack in 0.. {
        let Some(of_stack) = arcs.stacks.get(stack) else { break };
        let authored: Vec<sdf::Path> = of_stack.authored.keys().cloned().collect();
        for path in authored {
            if arcs.count(&(stack, path.clone())) > MOST_ARCS {
                return Err(too_many(&arcs.stacks[stack].file, &path));
            }
        }
    }
    Ok(())
}

fn too_many(file: &str, path: &sdf::Path) -> Error {
    Error::usd(format!("{path} in {file} has more than {MOST_ARCS} references, with those of the prims behind them"))
        .code(codes::COMPOSITION_FAILED)
        .remedy("nested references multiply the prims: reference each prim once, or flatten the file")
}

/// A prim of a stack of layers.
type Site = (usize, sdf::Path);

/// A variant set with the names of one of its variants; none outside of variants.
type Variant = Option<(String, String)>;

/// A layer with its sublayers.
struct Stack {
    file: String,
    default_prim: Option<sdf::Path>,
    /// The arcs of each prim.
    authored: BTreeMap<sdf::Path, Vec<CompositionArc>>,
}

/// An arc as a layer has it.
#[derive(Clone)]
struct CompositionArc {
    variant: Variant,
    /// The layer that it leads to; none for its own stack.
    file: Option<String>,
    /// The prim there; empty for the default one.
    prim: sdf::Path,
}

/// The layers and arcs that are read and counted so far.
#[derive(Default)]
struct Arcs {
    files: Files,
    known: Arc<ReadFiles>,
    stacks: Vec<Stack>,
    /// The stack of each layer; none for one that is not read.
    numbers: HashMap<String, Option<usize>>,
    /// Files that were read.
    read: usize,
    /// Arcs that were followed.
    followed: usize,
    counts: HashMap<Site, usize>,
}

impl Arcs {
    /// The number of arcs of a prim.
    fn count(&mut self, site: &Site) -> usize {
        let (mut open, mut begun) = (vec![site.clone()], HashSet::new());
        while let Some(site) = open.last().cloned() {
            if self.counts.contains_key(&site) || self.followed > MOST_FOLLOWED {
                open.pop();
                continue;
            }
            let arcs = self.arcs(&site);
            if begun.insert(site.clone()) {
                let unknown = arcs.into_iter().map(|(_, site)| site);
                open.extend(unknown.filter(|site| !self.counts.contains_key(site) && !begun.contains(site)));
                continue;
            }
            // Those in a circle are not followed again, and have no count yet.
            let mut of_variants: HashMap<Variant, usize> = HashMap::new();
            for (variant, to) in arcs {
                let more = 1 + self.counts.get(&to).copied().unwrap_or(0);
                let sum = of_variants.entry(variant).or_default();
                *sum = sum.saturating_add(more);
            }
            self.counts.insert(site, largest(of_variants));
            open.pop();
        }
        self.counts.get(site).copied().unwrap_or(0)
    }

    /// Where the arcs of a prim and of those above it lead.
    fn arcs(&mut self, (stack, path): &Site) -> Vec<(Variant, Site)> {
        let mut all = Vec::new();
        for above in path.ancestors_below_root() {
            let own = self.stacks[*stack].authored.get(&above).cloned().unwrap_or_default();
            self.followed += own.len();
            for arc in own {
                let to = match arc.file {
                    Some(file) => self.stack(file),
                    None => Some(*stack),
                };
                let Some(to) = to else { continue };
                let prim = if arc.prim.is_empty() { self.stacks[to].default_prim.clone() } else { Some(arc.prim) };
                let prim = prim.and_then(|prim| path.replace_prefix(&above, &prim));
                all.extend(prim.filter(|p| p.prim_element_count() <= MOST_LEVELS).map(|p| (arc.variant, (to, p))));
            }
        }
        all
    }

    /// The stack of a layer, read if it is new; none for one that is too large or cannot be read.
    fn stack(&mut self, file: String) -> Option<usize> {
        if let Some(known) = self.numbers.get(&file) {
            return *known;
        }
        let mut stack = Stack { file: file.clone(), default_prim: None, authored: BTreeMap::new() };
        let (mut layers, mut seen) = (vec![file.clone()], HashSet::new());
        while let Some(layer) = layers.pop().filter(|_| self.read < MOST_FILES) {
            if seen.insert(layer.clone()) {
                self.read += 1;
                layers.extend(self.read_layer(&layer, &mut stack));
            }
        }
        self.stacks.push(stack);
        let number = Some(self.stacks.len() - 1);
        self.numbers.insert(file, number);
        number
    }

    /// Adds the arcs of a layer to its stack; its sublayers.
    fn read_layer(&self, identifier: &str, stack: &mut Stack) -> Vec<String> {
        if !may_have_arcs(&package_file(Path::new(identifier))) {
            return Vec::new();
        }
        let Ok(layer) = Layer::open_with(Files::of(&self.known), identifier) else { return Vec::new() };
        let anchor = ResolvedPath::new(layer.resolved_path().unwrap_or(identifier));
        let (data, root) = (layer.data(), sdf::Path::abs_root());
        let field = |path: &sdf::Path, key: FieldKey| data.try_field(path, key.as_str()).ok().flatten();
        if stack.file == identifier {
            let token =
                field(&root, FieldKey::DefaultPrim).and_then(|value| crate::values::text(&value).map(str::to_owned));
            stack.default_prim = token.and_then(|token| default_prim_path(&token));
        }
        for path in data.spec_paths() {
            if path.is_property_path() {
                continue;
            }
            let variant = variant(&path);
            let mut add = |asset: &str, prim: &sdf::Path| {
                let asset = asset.split(ARGUMENTS).next().unwrap_or_default();
                let file = (!asset.is_empty()).then(|| self.files.create_identifier(asset, Some(&anchor)));
                let arc = CompositionArc { variant: variant.clone(), file, prim: prim.strip_all_variant_selections() };
                stack.authored.entry(path.strip_all_variant_selections()).or_default().push(arc);
            };
            for key in [FieldKey::References, FieldKey::Payload, FieldKey::InheritPaths, FieldKey::Specializes] {
                match field(&path, key).as_deref() {
                    Some(Value::ReferenceListOp(all)) => {
                        all.flatten().iter().for_each(|one| add(&one.asset_path, &one.prim_path));
                    }
                    Some(Value::PayloadListOp(all)) => {
                        all.flatten().iter().for_each(|one| add(&one.asset_path, &one.prim_path));
                    }
                    Some(Value::Payload(one)) => add(&one.asset_path, &one.prim_path),
                    Some(Value::PathListOp(all)) => all.flatten().iter().for_each(|prim| add("", prim)),
                    _ => {}
                }
            }
        }
        match field(&root, FieldKey::SubLayers).as_deref() {
            Some(Value::StringVec(layers)) => {
                layers.iter().map(|layer| self.files.create_identifier(layer, Some(&anchor))).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// Whether a file is small enough to be read, and no text without arcs.
fn may_have_arcs(file: &Path) -> bool {
    let is_small = fs::metadata(file).is_ok_and(|of| of.is_file() && of.len() <= MOST_BYTES);
    is_small
        && fs::read(file).is_ok_and(|bytes| match std::str::from_utf8(&bytes) {
            Ok(text) => WORDS.iter().any(|word| text.contains(word)),
            Err(_) => true,
        })
}

/// The first variant that a path goes through.
fn variant(path: &sdf::Path) -> Variant {
    let (_, rest) = path.as_str().split_once('{')?;
    let (set, rest) = rest.split_once('=')?;
    let (name, _) = rest.split_once('}')?;
    Some((set.to_owned(), name.to_owned()))
}

/// The largest sum that some variants may have, one of each set.
fn largest(of_variants: HashMap<Variant, usize>) -> usize {
    let mut of_sets: HashMap<Option<String>, usize> = HashMap::new();
    for (variant, sum) in of_variants {
        let most = of_sets.entry(variant.map(|(set, _)| set)).or_default();
        *most = sum.max(*most);
    }
    of_sets.into_values().fold(0, usize::saturating_add)
}
