//! The process: the memory and threads that a run may take, the signals that end it, and the programs beside it.

pub mod folders;
pub mod interrupt;
pub mod memory;
pub mod openusd;
pub mod threads;
