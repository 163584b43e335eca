//! The bodies of the fuzz targets on stable Rust: a stored corpus, and cases of a seeded generator.
//!
//! A run without `TAILOR_TEST_ALL` tries a tenth of the cases. `FUZZ_RUNS` and `FUZZ_SEED` look further, as in `FUZZ_RUNS=100000 FUZZ_SEED=7 cargo test --test stages fuzz_replay`.
//! A case that fails is kept in `target/tmp`; as a file in `tests/fuzz/corpus/<target>` it is tried first from then on.

#[path = "../fuzz/bodies/mod.rs"]
mod bodies;

use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Longest time of a case, on a slow machine without optimisation.
const LONGEST: Duration = Duration::from_secs(60);
/// Texts that mean something to a reader of recipes, layers or numbers.
const WORDS: [&str; 20] = [
    "0",
    "-1",
    "1e30",
    "nan",
    "inf",
    "4294967296",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\0sim.maxEdgeLength=1e-30",
    "\0time=nan",
    "seam",
    "a.b:c",
    "\\u0000",
    "[0, 1, 99999999]",
    "None",
    "over",
    "\n",
];

/// A small generator of random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn range(&mut self, length: usize) -> Range<usize> {
        let start = self.below(length + 1);
        start..(start + self.below(16)).min(length)
    }
}

/// A text of random bytes, or a file of the corpus with some changes.
fn case(random: &mut Random, corpus: &[Vec<u8>]) -> Vec<u8> {
    if corpus.is_empty() || random.below(4) == 0 {
        return (0..random.below(600)).map(|_| random.next() as u8).collect();
    }
    let mut data = corpus[random.below(corpus.len())].clone();
    for _ in 0..1 + random.below(6) {
        let (place, from) = (random.range(data.len()), random.range(data.len()));
        let word = WORDS[random.below(WORDS.len())].as_bytes().to_vec();
        let new = match random.below(5) {
            0 => vec![],
            1 => word,
            2 => data[from].to_vec(),
            3 => data[place.clone()].iter().map(|byte| byte ^ 1 << (random.next() % 8)).collect(),
            _ => (0..random.below(8)).map(|_| random.next() as u8).collect(),
        };
        data.splice(place, new);
    }
    data
}

/// The files of a target's corpus, by name.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target);
    let entries = fs::read_dir(&folder).expect("a corpus");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files.into_iter().map(|file| (file.clone(), fs::read(&file).expect("a file of the corpus"))).collect()
}

/// The case that runs, where it is kept if it fails.
struct Running {
    data: Mutex<Vec<u8>>,
    kept: PathBuf,
}

impl Running {
    /// Stores the case.
    fn keep(&self, fault: &str) {
        fs::write(&self.kept, &*self.data.lock().expect("the case")).expect("a place for the case");
        eprintln!("{fault}, kept as {}", self.kept.display());
    }
}

/// Ends the program if no case is done for too long. The sender reports cases.
fn watch(running: Arc<Running>) -> Sender<()> {
    let (done, waiting) = channel();
    thread::spawn(move || {
        loop {
            match waiting.recv_timeout(LONGEST) {
                Ok(()) => {}
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    running.keep(&format!("a case takes longer than {LONGEST:?}"));
                    std::process::abort();
                }
            }
        }
    });
    done
}

/// A number of the environment.
fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Runs the corpus of a target and random cases: as many as given in a run of all tests.
fn replay(target: &str, all: u64) {
    let (_, body) = bodies::TARGETS.into_iter().find(|(name, _)| *name == target).expect("a target");
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz_{target}"));
    let running = Arc::new(Running { data: Mutex::default(), kept });
    let done = watch(Arc::clone(&running));
    let run = |data: &[u8], name: &dyn std::fmt::Display| {
        data.clone_into(&mut running.data.lock().expect("the case"));
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| body(data))) {
            running.keep(&format!("{target} fails on {name}"));
            resume_unwind(panic);
        }
        let _ = done.send(());
    };
    let corpus = corpus(target);
    corpus.iter().for_each(|(file, data)| run(data, &file.display()));
    let texts: Vec<Vec<u8>> = corpus.into_iter().map(|(_, data)| data).collect();
    let seed = number("FUZZ_SEED", 1);
    let runs = if std::env::var_os("TAILOR_TEST_ALL").is_some() { all } else { all / 10 };
    for i in 0..number("FUZZ_RUNS", runs) {
        let data = case(&mut Random(seed << 32 | i), &texts);
        run(&data, &format_args!("case {i} of seed {seed}"));
    }
}

#[test]
fn recipes() {
    replay("recipe", 20_000);
}

#[test]
fn documents() {
    replay("document", 20_000);
}

#[test]
fn layers() {
    replay("layer", 2_000);
}

#[test]
fn pipelines() {
    replay("pipeline", 200);
}

#[test]
fn expressions() {
    replay("sets", 10_000);
}

#[test]
fn fits() {
    replay("fit", 400);
}
