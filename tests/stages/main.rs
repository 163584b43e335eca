//! Stages in, layers out: reading and writing, sessions of the OpenUSD plugin, and the bodies of the fuzz targets.

// A test that cannot run here says so.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod fuzz_replay;
mod reading;
mod session;
mod stage;
mod troubles;
mod writing;
