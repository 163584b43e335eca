//! The command as its users meet it: the built binary, its exit codes, what it prints and what it writes.

mod bytes;
mod cloth;
mod examples;
mod faults;
mod fit;
mod folder;
mod outputs;
mod payloads;
mod printing;
mod recipes;
mod recorded;
mod schemas;
