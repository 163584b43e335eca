//! The render mesh: its operators alone, in stacks, and on garments.

mod cloth;
mod crossings;
mod ends;
mod on_garments;
mod operators;
mod stacks;
