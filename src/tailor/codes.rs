//! The codes of the two meshes.

use tailor_mesh::declare_codes;

declare_codes! {
    errors {
        /// The mesh is too small or too large for single precision.
        MESH_SIZE = "mesh-size";
        /// An expression does not describe a set.
        SET_EXPRESSION = "set-expression";
        /// `render.operators` names no operator, or one twice.
        UNKNOWN_OPERATOR = "unknown-operator";
        /// Operators need a mesh that is not of Loop's scheme.
        LOOP_OPERATORS = "loop-operators";
        /// A fold is not at a border.
        NO_BORDER = "no-border";
        /// The products would be too large.
        TOO_LARGE = "too-large";
    }
    faults {
        /// UVs are flipped or degenerate, and the simulation mesh ignores them there.
        FLIPPED_UVS = "flipped-uvs";
        /// Faces intersect others or are flipped.
        INTERSECTIONS = "intersections";
        /// The garment is modelled with a thickness.
        THICK_CLOTH = "thick-cloth";
        /// A reference to the asset cannot reach the products.
        ROOT_MESH = "root-mesh";
        /// An expression of a recipe gives a set without elements.
        EMPTY_SET = "empty-set";
    }
    quality {
        /// The garment is so far from the origin that points of the products are rounded.
        FAR_FROM_ORIGIN = "far-from-origin";
        /// The simulation mesh has reached the limit of its size.
        FACE_LIMIT = "face-limit";
        /// Faces are not mirrored: they have no twin across a plane of symmetry.
        ASYMMETRIC = "asymmetric";
        /// Edges of the simulation mesh leave a border, seam or constraint.
        CURVES_CUT = "curves-cut";
        /// A face subset has another area on the simulation mesh.
        AREA_CHANGED = "area-changed";
        /// Face subsets are too small for the triangles of the simulation mesh.
        SETS_BLURRED = "sets-blurred";
        /// A seam is narrower than its width, or lacks a row.
        NARROW_SEAM = "narrow-seam";
        /// A seam is pushed less than its offset.
        SHALLOW_SEAM = "shallow-seam";
        /// The heights of an operator are less than it asks.
        REDUCED_HEIGHT = "reduced-height";
        /// Two seams have the same edges.
        SHARED_SEAM_EDGES = "shared-seam-edges";
        /// A second layer is nearer than its thickness.
        THIN_LAYER = "thin-layer";
        /// Faces have no second layer.
        BARE_FACES = "bare-faces";
        /// Repair has ended before all faces were tested.
        REPAIR_CUT_SHORT = "repair-cut-short";
        /// The mesh has no UV set with seams, or several without a known name.
        NO_UV_SET = "no-uv-set";
        /// UV shells are too small for the triangles of the simulation mesh.
        SMALL_SHELLS = "small-shells";
        /// Nearly every edge is a UV seam.
        UV_CONFETTI = "uv-confetti";
        /// Triangles of the simulation mesh are flipped in the UVs.
        UV_FLIPS = "uv-flips";
    }
    notes {
        /// A detail to leave out of the simulation mesh is closed.
        CLOSED_DETAIL = "closed-detail";
        /// The mesh has no subdivision surface.
        POLYGONAL_CAGE = "polygonal-cage";
        /// A face set of an operator has another name than asked.
        SET_RENAMED = "set-renamed";
        /// `render.operators` leaves operators out.
        OPERATORS_LEFT_OUT = "operators-left-out";
    }
}
