//! Tests of the two meshes and of whole builds, on sheets made in code and on the project's garments.

mod built;
mod checks;
mod nearest;
mod operators;
mod peers;
mod pipeline;
mod prepared;
mod quality;
mod render;
mod sim;
mod transfer;
