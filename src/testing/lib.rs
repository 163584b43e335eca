//! Garments, meshes and measurements that tests share.

#![allow(missing_docs, reason = "helpers of tests are named by what they give")]

pub mod cage;
pub mod cases;
pub mod garments;
pub mod sheets;
pub mod zoo;
