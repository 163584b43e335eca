//! Stages in, layers out: `usd::Source` and `usd::write` on small stages written as text, and on real garments.

// A test that cannot run here says so.
#![allow(clippy::print_stdout)]

mod common;
mod reading;
mod writing;
