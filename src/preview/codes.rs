//! The codes of the preview.

use tailor_mesh::declare_codes;

declare_codes! {
    errors {
        /// The page of the preview cannot be served.
        PREVIEW_SERVER = "preview-server";
    }
    faults {
    }
    quality {
    }
    notes {
    }
}
