//! How many random cases a run looks at.

use proptest::test_runner::{Config, RngSeed};

/// The same few cases in each run, so that a failure is a change's own: a third of `all`, unless all tests run.
/// `PROPTEST_CASES` and `PROPTEST_RNG_SEED` look further.
pub fn few(all: u32, seed: u64) -> Config {
    let given = Config::default();
    let set = |name: &str| std::env::var_os(name).is_some();
    let own = if set("TAILOR_TEST_ALL") { all } else { all.div_ceil(3) };
    let cases = if set("PROPTEST_CASES") { given.cases } else { own };
    let rng_seed = if set("PROPTEST_RNG_SEED") { given.rng_seed } else { RngSeed::Fixed(seed) };
    Config { cases, rng_seed, failure_persistence: None, ..given }
}
