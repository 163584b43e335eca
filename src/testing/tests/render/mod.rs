//! The render mesh: its operators alone, in stacks, and on garments.

mod cloth;
mod crossings;
mod ends;
mod folds;
mod junctions;
mod locality;
mod on_garments;
mod operators;
mod referee;
mod rows;
mod stacks;
mod surface;
mod work;
