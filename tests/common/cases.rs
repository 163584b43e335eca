//! How many random cases a run looks at.

use proptest::test_runner::{Config, RngSeed};

/// The same few cases in each run, so that a failure is a change's own; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` look
/// further.
pub fn few(cases: u32, seed: u64) -> Config {
    let given = Config::default();
    let set = |name: &str| std::env::var_os(name).is_some();
    let cases = if set("PROPTEST_CASES") { given.cases } else { cases };
    let rng_seed = if set("PROPTEST_RNG_SEED") { given.rng_seed } else { RngSeed::Fixed(seed) };
    Config { cases, rng_seed, failure_persistence: None, ..given }
}
