//! The process: the memory and threads that a run may take, and the signals that end it.

pub mod folders;
pub mod interrupt;
pub mod memory;
pub mod threads;
