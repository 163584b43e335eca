//! The codes of the mesh, its options and its errors.

use crate::declare_codes;

declare_codes! {
    errors {
        /// An argument of the command is wrong.
        COMMAND_LINE = "command-line";
        /// The content of a file cannot be read.
        DAMAGED_FILE = "damaged-file";
        /// A warning, where none is wanted.
        STRICT_WARNING = "strict-warning";
        /// The prim that is named is not a mesh to build from.
        WRONG_PRIM = "wrong-prim";
        /// Panels that are sewn together contradict each other.
        PANELS_DIFFER = "panels-differ";
        /// The mesh has nothing to build from.
        EMPTY_MESH = "empty-mesh";
        /// Counts and corners of faces disagree.
        FACE_CORNERS = "face-corners";
        /// A Loop mesh has faces that are not triangles.
        LOOP_FACES = "loop-faces";
        /// An index names an element that is not there.
        INDEX_OUT_OF_RANGE = "index-out-of-range";
        /// A value is not a finite number.
        NOT_FINITE = "not-finite";
        /// A primvar has too many or too few values.
        VALUE_COUNT = "value-count";
        /// Two primvars have one name.
        DUPLICATE_PRIMVAR = "duplicate-primvar";
        /// Creases or corners disagree with the mesh.
        CREASE_DATA = "crease-data";
        /// A list of elements names one twice, or edges that the mesh lacks.
        ELEMENT_LIST = "element-list";
        /// Subsets of one family have elements of several types.
        SUBSET_FAMILY = "subset-family";
        /// An option has a value that it cannot have.
        OPTION_VALUE = "option-value";
        /// An option names a subset that the mesh lacks.
        UNKNOWN_SUBSET = "unknown-subset";
        /// An option names a primvar that the mesh lacks.
        UNKNOWN_PRIMVAR = "unknown-primvar";
        /// The system starts no more threads.
        NO_THREAD = "no-thread";
        /// The build was cancelled.
        CANCELLED = "cancelled";
        /// This program is at fault.
        INTERNAL = "internal";
    }
    faults {
        /// Neighbouring faces disagree in winding.
        WINDING_DISAGREEMENTS = "winding-disagreements";
        /// Faces have no area.
        DEGENERATE_FACES = "degenerate-faces";
        /// Faces have the points of an earlier face.
        DUPLICATE_FACES = "duplicate-faces";
        /// A product lacks an attribute of the model.
        NOT_CARRIED = "not-carried";
    }
    quality {
        /// Borders of two meshes lie along each other and are not sewn.
        UNSEWN_BORDERS = "unsewn-borders";
    }
    notes {
        /// Edges have more than two faces.
        NON_MANIFOLD_EDGES = "non-manifold-edges";
        /// Several fans of faces meet at one vertex.
        BOW_TIE_VERTICES = "bow-tie-vertices";
        /// No face uses a point.
        UNUSED_POINTS = "unused-points";
        /// Faces name a point more than once.
        REPEATED_POINTS = "repeated-points";
        /// Subsets break the rule of their family, and products have a weaker one.
        FAMILY_RULE = "family-rule";
    }
}
