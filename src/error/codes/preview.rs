//! The codes of the preview.

use super::declare;

declare! {
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
