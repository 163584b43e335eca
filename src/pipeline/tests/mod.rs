//! Products of whole builds.

mod folds;
mod products;
