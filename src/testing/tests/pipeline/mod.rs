//! Products of whole builds.

mod folds;
mod levels;
mod products;
