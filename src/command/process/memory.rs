//! How much memory a run may take: as much as an option says, or a share of what the machine leaves.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use tailor_mesh::error::Error;
use tailor_mesh::meter;

/// Part of the memory that is left for a run by default.
const SHARE: (u64, u64) = (3, 4);

/// Part of the memory of a run that nothing counts: the program itself, and blocks that are free and not given back.
const UNCOUNTED: usize = 8;

/// The bytes that a text such as `8G`, `8GiB` or `500MB` stands for.
///
/// # Errors
/// Text of another form.
pub fn parse(text: &str) -> Result<u64, String> {
    let at = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(at);
    let unit = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kib" => 1024.0,
        "m" | "mib" => 1024f64.powi(2),
        "g" | "gib" => 1024f64.powi(3),
        "t" | "tib" => 1024f64.powi(4),
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        other => return Err(format!("{other:?} is not a unit of memory; give a size such as 8G or 500M")),
    };
    let number: f64 = number.parse().map_err(|_| "give a size such as 8G or 500M".to_owned())?;
    let bytes = number * unit;
    if bytes >= 1.0 { Ok(bytes as u64) } else { Err("give at least 1 byte".into()) }
}

/// The bytes that a run may take: `given`, or three quarters of what the machine, the control groups of this process and
/// its limit of address space leave. Without a limit where none of them can be read.
pub fn limit(given: Option<u64>) -> usize {
    let limit = given.or_else(|| left().map(|left| left / SHARE.1 * SHARE.0));
    limit.map_or(usize::MAX, |limit| usize::try_from(limit).unwrap_or(usize::MAX))
}

/// The bytes that a run may take, as [`limit`], held from now on: work that takes more ends by unwinding.
pub fn hold(given: Option<u64>) -> usize {
    let limit = limit(given);
    give_back();
    meter::set_limit(limit - limit / UNCOUNTED);
    limit
}

/// Has the system take back each freed block from this size on. By default, glibc keeps blocks of up to 32 MB: half of a build.
fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const BLOCK: libc::c_int = 128 << 10;
        // SAFETY: it sets a number of the allocator.
        unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, BLOCK) };
    }
}

/// The step of a build that runs; empty before the first.
pub type RunningStep = Arc<Mutex<String>>;

/// The error of a build that has passed the limit in a step.
pub fn passed(limit: usize, step: &RunningStep) -> Error {
    let step = step.lock().unwrap_or_else(PoisonError::into_inner);
    let (place, remedy) = match step.as_str() {
        "render" | "binding" => ("render.level", "lower it, shorten the sets of seams and folds"),
        "" => ("", "give fewer or smaller meshes at once"),
        _ => ("sim.maxEdgeLength", "raise it, and sim.minEdgeLength"),
    };
    let at = if step.is_empty() { String::new() } else { format!(" in the step {step}") };
    let fault = format!("the build has taken all of the {:.2} GB of memory that it may take{at}", limit as f64 / 1e9);
    let remedy = format!("{remedy}, or allow more memory (--max-memory)");
    Error::recipe(place, fault).code(tailor::codes::TOO_LARGE).remedy(remedy)
}

fn left() -> Option<u64> {
    [machine(), control_groups(), address_space()].into_iter().flatten().min()
}

/// The memory that the kernel gives without swapping. \[bytes\]
fn machine() -> Option<u64> {
    let info = fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()?.saturating_mul(1024))
}

/// The memory that is left in the control group of this process, and in those above it: the least. \[bytes\]
fn control_groups() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let left = |folder: &Path, [limit, used]: [&str; 2]| {
        let number = |name| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
        Some(number(limit)?.saturating_sub(number(used)?))
    };
    let of_group = |line: &str| {
        let (_, line) = line.split_once(':')?;
        let (controllers, path) = line.split_once(':')?;
        let (root, files) = match controllers {
            "" => ("/sys/fs/cgroup", ["memory.max", "memory.current"]),
            c if c.split(',').any(|c| c == "memory") => {
                ("/sys/fs/cgroup/memory", ["memory.limit_in_bytes", "memory.usage_in_bytes"])
            }
            _ => return None,
        };
        let group = Path::new(path.trim_start_matches('/'));
        group.ancestors().filter_map(|group| left(&Path::new(root).join(group), files)).min()
    };
    groups.lines().filter_map(of_group).min()
}

/// The address space that is left below `ulimit -v`. \[bytes\]
fn address_space() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    let pages = fs::read_to_string("/proc/self/statm").ok()?;
    let used: u64 = pages.split_whitespace().next()?.parse().ok()?;
    /// The least that a page has on systems in use. \[bytes\]
    const PAGE: u64 = 4096;
    Some(limit.saturating_sub(used * PAGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        for (text, bytes) in [("1024", 1024), ("8G", 8 << 30), ("1.5 MiB", 3 << 19), ("2gb", 2_000_000_000)] {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "8X", "-1G", "0", "1..2G"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_size_that_was_given_is_the_limit() {
        assert_eq!(limit(Some(1 << 20)), 1 << 20);
        assert!(limit(None) > 1 << 20);
    }
}
