//! The codes of USD.

use tailor_mesh::declare_codes;

declare_codes! {
    errors {
        /// A file cannot be opened.
        UNREADABLE_FILE = "unreadable-file";
        /// The content of a file is valid USD that this version cannot read.
        NOT_SUPPORTED = "not-supported";
        /// The layers of a stage do not compose.
        COMPOSITION_FAILED = "composition-failed";
        /// The output exists already.
        OUTPUT_EXISTS = "output-exists";
        /// The output is a file that the input uses.
        OUTPUT_IS_INPUT = "output-is-input";
        /// The output cannot be a file of this name.
        OUTPUT_PATH = "output-path";
        /// A file cannot be written.
        WRITE_FAILED = "write-failed";
        /// A layer cannot be written back unchanged.
        NOT_WRITTEN_BACK = "not-written-back";
        /// The stage holds no mesh to build from.
        NO_MESH = "no-mesh";
        /// The stage holds several meshes.
        SEVERAL_MESHES = "several-meshes";
        /// The mesh is inside an instance.
        INSIDE_INSTANCE = "inside-instance";
        /// An attribute has values at times only.
        NO_DEFAULT_VALUE = "no-default-value";
        /// An attribute is missing or of another type.
        ATTRIBUTE_TYPE = "attribute-type";
        /// A token has a value that USD does not know.
        UNKNOWN_TOKEN = "unknown-token";
        /// The target of the pins cannot hold them.
        PIN_TARGET = "pin-target";
        /// No mesh is bound to a simulation mesh.
        NOT_BOUND = "not-bound";
        /// A cache cannot be read.
        CACHE_FILE = "cache-file";
        /// A cache is of another mesh.
        CACHE_MISMATCH = "cache-mismatch";
        /// A cache lacks frames.
        CACHE_FRAMES = "cache-frames";
    }
    faults {
        /// The stage does not compose fully.
        COMPOSITION = "composition";
        /// A payload sets an invalid option, which is ignored.
        IGNORED_OPTION = "ignored-option";
        /// The points of a cache may be of another space.
        CACHE_SPACE = "cache-space";
        /// An option is where nothing reads it.
        MISPLACED_OPTION = "misplaced-option";
    }
    quality {
        /// A trim lies away from the cloth that it rides on.
        TRIM_OFF_CLOTH = "trim-off-cloth";
        /// A dialect of physics takes one value where the cloth has several.
        MEAN_FABRIC = "mean-fabric";
    }
    notes {
        /// Products keep what the selected variant has.
        FROZEN_VARIANT = "frozen-variant";
        /// A layer was read by OpenUSD, or a stage flattened by it.
        CONVERTED_LAYER = "converted-layer";
        /// A mesh lies on another and is not attached to it.
        UNATTACHED = "unattached";
    }
}
