//! The render mesh: its operators alone, in stacks, and on garments.

#[path = "../common/attributes.rs"]
mod attributes;
mod cloth;
mod crossings;
mod ends;
#[path = "../common/garments.rs"]
mod garments;
#[path = "../common/nearest.rs"]
mod nearest;
mod on_garments;
mod operators;
#[path = "../common/operators.rs"]
mod recipes;
#[path = "../common/sheets.rs"]
mod sheets;
mod stacks;
#[path = "../common/zoo.rs"]
mod zoo;
