//! The codes of the command.

use tailor_mesh::declare_codes;

declare_codes! {
    errors {
        /// No garment is named.
        NO_INPUT = "no-input";
        /// The output is not what a build would make of the files as they are now.
        STALE_OUTPUT = "stale-output";
    }
    faults {
    }
    quality {
    }
    notes {
        /// Fewer threads are started than asked for.
        THREADS_CAPPED = "threads-capped";
    }
}

/// The codes of the whole program, by crate.
pub const PARTS: [Codes; 6] = [
    tailor_mesh::codes::ALL,
    tailor::codes::ALL,
    tailor_costume::codes::ALL,
    tailor_usd::codes::ALL,
    tailor_preview::codes::ALL,
    ALL,
];
