//! The codes of what a garment needs beyond its two meshes.

use tailor_mesh::declare_codes;

declare_codes! {
    errors {
        /// The name of a product is taken, or is not valid.
        NAME_TAKEN = "name-taken";
        /// A recipe cannot be read.
        RECIPE_FILE = "recipe-file";
        /// An attribute of the recipe cannot be an option.
        RECIPE_ATTRIBUTE = "recipe-attribute";
        /// There is no such option.
        UNKNOWN_OPTION = "unknown-option";
        /// UV shells are not patterns, and the cloth is to rest on them.
        UNUSABLE_PANELS = "unusable-panels";
        /// Two bodies of a fit do not correspond.
        BODIES_DIFFER = "bodies-differ";
        /// A stitch has no line to follow.
        STITCH_LINE = "stitch-line";
        /// A product of an earlier build is incomplete or was edited.
        STALE_BINDING = "stale-binding";
    }
    faults {
        /// No vertex of the simulation mesh is in a set that is held.
        NOTHING_PINNED = "nothing-pinned";
        /// There are no panels to write.
        NO_PANELS = "no-panels";
        /// A schema is applied, and the sets that it needs are not named.
        SCHEMA_WITHOUT_SETS = "schema-without-sets";
        /// A garment is not on the body that it was made for.
        OFF_BODY = "off-body";
        /// A fitted garment did not follow its body.
        FIT_LEFT_BEHIND = "fit-left-behind";
        /// Faces of a fitted garment cross the body or each other, and did not before.
        FIT_CROSSES = "fit-crosses";
    }
    quality {
        /// Parts of one body are turned over on the other.
        BODIES_FOLDED = "bodies-folded";
        /// Faces of a fitted garment have become slivers.
        FIT_SLIVERS = "fit-slivers";
    }
    notes {
        /// A level of detail has a mesh of the level before it.
        LEVEL_REPEATS = "level-repeats";
        /// UV shells are not patterns of the mesh.
        NO_PATTERN = "no-pattern";
    }
}
