//! scratch
#![allow(missing_docs)]
use std::sync::OnceLock;
pub fn exp(i: usize, default: f32) -> f32 {
    static ALL: OnceLock<Vec<Option<f32>>> = OnceLock::new();
    let all = ALL.get_or_init(|| (0..40).map(|i| std::env::var(format!("X{i}")).ok().and_then(|s| s.parse().ok())).collect());
    all[i].unwrap_or(default)
}
