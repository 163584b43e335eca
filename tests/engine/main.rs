//! The engine on plain data: subdivision, the simulation mesh, the render mesh, transfer, and what holds for all products.

mod architecture;
#[path = "../common/mod.rs"]
mod common;
mod folds;
mod products;
mod render;
mod sim;
mod subdivision;
mod transfer;
