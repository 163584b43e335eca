#![no_main]

#[path = "../bodies/mod.rs"]
mod bodies;

/// A panic of the USD library is an error of ours, and no find; any other ends the run.
fn abort_on_our_own_panics() {
    std::panic::set_hook(Box::new(|panic| {
        if !panic.location().is_some_and(|place| place.file().contains("openusd")) {
            eprintln!("{panic}");
            std::process::abort();
        }
    }));
}

libfuzzer_sys::fuzz_target!(init: abort_on_our_own_panics(), |data: &[u8]| bodies::layer(data));
