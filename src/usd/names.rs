//! Names that USD and this program give to properties, metadata and tokens, each written once.

use openusd::sdf::Value;
use tailor_mesh::garment::{
    BoundaryInterpolation, FaceVaryingInterpolation, FamilyType, Interpolation, Orientation, Scheme, TriangleRule,
};

/// Type of the prims that are read and written.
pub const MESH: &str = "Mesh";
/// Metadata of a stage: its up axis, and its unit of length.
pub const UP_AXIS: &str = "upAxis";
pub const METERS_PER_UNIT: &str = "metersPerUnit";
/// Type of the prims that hold face sets, edge sets and point sets.
pub const GEOM_SUBSET: &str = "GeomSubset";
/// Type of the prims that hold blend shapes.
pub const BLEND_SHAPE: &str = "BlendShape";
/// API schema of material bindings.
pub const MATERIAL_BINDING_API: &str = "MaterialBindingAPI";
/// API schema of skinning.
pub const SKEL_BINDING_API: &str = "SkelBindingAPI";

// Attributes and relationships of meshes, subsets and blend shapes.
pub const POINTS: &str = "points";
pub const CURVE_VERTEX_COUNTS: &str = "curveVertexCounts";
pub const FACE_VERTEX_COUNTS: &str = "faceVertexCounts";
pub const FACE_VERTEX_INDICES: &str = "faceVertexIndices";
pub const EXTENT: &str = "extent";
pub const ORIENTATION: &str = "orientation";
pub const SUBDIVISION_SCHEME: &str = "subdivisionScheme";
pub const INTERPOLATE_BOUNDARY: &str = "interpolateBoundary";
pub const FACE_VARYING_LINEAR_INTERPOLATION: &str = "faceVaryingLinearInterpolation";
pub const TRIANGLE_SUBDIVISION_RULE: &str = "triangleSubdivisionRule";
pub const HOLE_INDICES: &str = "holeIndices";
pub const CREASE_INDICES: &str = "creaseIndices";
pub const CREASE_LENGTHS: &str = "creaseLengths";
pub const CREASE_SHARPNESSES: &str = "creaseSharpnesses";
pub const CORNER_INDICES: &str = "cornerIndices";
pub const CORNER_SHARPNESSES: &str = "cornerSharpnesses";
pub const NORMALS: &str = "normals";
pub const VELOCITIES: &str = "velocities";
pub const TANGENTS: &str = "tangents";
pub const ACCELERATIONS: &str = "accelerations";
pub const DOUBLE_SIDED: &str = "doubleSided";
pub const PURPOSE: &str = "purpose";
pub const VISIBILITY: &str = "visibility";
pub const XFORM_OP_ORDER: &str = "xformOpOrder";
pub const ELEMENT_TYPE: &str = "elementType";
pub const FAMILY_NAME: &str = "familyName";
pub const INDICES: &str = "indices";

/// Namespace of transform ops.
pub const XFORM_OP: &str = "xformOp:";
/// Namespace of primvars.
pub const PRIMVARS: &str = "primvars:";
/// Suffix of the indices of a primvar.
pub const INDICES_SUFFIX: &str = ":indices";
/// Namespace of subset families.
pub const SUBSET_FAMILY: &str = "subsetFamily:";
/// Suffix of the rule of a family.
pub const FAMILY_TYPE_SUFFIX: &str = ":familyType";
/// Name and namespace of material bindings.
pub const MATERIAL_BINDING: &str = "material:binding";
pub const POINT_INSTANCER: &str = "PointInstancer";
// Attributes of PointInstancers.
pub const POSITIONS: &str = "positions";
pub const ORIENTATIONS: &str = "orientations";
/// The orientations in single precision, which newer versions of USD prefer.
pub const ORIENTATIONS_F: &str = "orientationsf";
/// The relationship of a PointInstancer to what it repeats.
pub const PROTOTYPES: &str = "prototypes";
/// How strong a binding is against those below its prim.
pub const BIND_MATERIAL_AS: &str = "bindMaterialAs";
/// The family of subsets with materials.
pub const MATERIAL_FAMILY: &str = "materialBind";
/// The binding of a physics material.
pub const PHYSICS_MATERIAL: &str = "material:binding:physics";
/// Namespace of material bindings by collection.
pub const MATERIAL_BINDING_COLLECTION: &str = "material:binding:collection";
pub const SKEL_SKELETON: &str = "skel:skeleton";
pub const SKEL_ANIMATION_SOURCE: &str = "skel:animationSource";
pub const SKEL_JOINTS: &str = "skel:joints";
pub const SKEL_SKINNING_METHOD: &str = "skel:skinningMethod";
/// The place of a skinned mesh in the bind pose.
pub const GEOM_BIND_TRANSFORM: &str = "primvars:skel:geomBindTransform";
pub const SKEL_BLEND_SHAPES: &str = "skel:blendShapes";
pub const SKEL_BLEND_SHAPE_TARGETS: &str = "skel:blendShapeTargets";
pub const OFFSETS: &str = "offsets";
pub const NORMAL_OFFSETS: &str = "normalOffsets";
pub const POINT_INDICES: &str = "pointIndices";
/// Namespace of a blend shape's inbetweens.
pub const INBETWEENS: &str = "inbetweens:";
/// The points of a fitted garment on the body that it was made for.
pub const FIT_FROM: &str = "primvars:tailor:fitFrom";
/// The sharpness that the edges or points of a subset had as creases or corners.
pub const SHARPNESS: &str = "tailor:sharpness";
/// Vertices of the simulation mesh that hold loose pieces.
pub const ATTACH_POINTS: &str = "tailor:attach:points";
/// The triangles that they are attached to.
pub const ATTACH_FACES: &str = "tailor:attach:faces";
/// Their coordinates on these triangles.
pub const ATTACH_COORDS: &str = "tailor:attach:coords";
/// On the render mesh: the triangle of the simulation mesh of each point, the coordinates there, and the simulation mesh. Those of
/// coarser levels of detail have the name of the level after them ([`binding`]).
pub const BINDING: [&str; 3] = ["primvars:tailor:bindFace", "primvars:tailor:bindCoords", "tailor:bindTarget"];
/// On the simulation mesh: the same of each point of the model, and the model.
pub const MODEL_BINDING: [&str; 3] = ["tailor:model:bindFace", "tailor:model:bindCoords", "tailor:model:source"];
/// The names of a product's roles, and of their prims unless others are chosen.
pub const SIM: &str = "sim";
pub const RENDER: &str = "render";
/// The variant set of levels of detail, and the start of their names.
pub const LOD: &str = "LOD";
/// Namespace of the recipe. A product has the bindings and attachments above in it.
pub const RECIPE: &str = "tailor:";

/// The names of a binding to the simulation mesh of a level of detail.
pub fn binding(level: u32) -> [String; 3] {
    let of_level = if level == 0 { String::new() } else { format!(":{LOD}{level}") };
    BINDING.map(|name| format!("{name}{of_level}"))
}

/// Whether a property is the option with the prims of a trim.
pub fn is_trim_prims(property: &str) -> bool {
    property.starts_with("tailor:trim:") && property.ends_with(":prims")
}

/// Whether a property is an option with the file of a body.
pub fn is_body(property: &str) -> bool {
    ["tailor:fit:from", "tailor:fit:to"].contains(&property)
}

/// Whether a build wrote this property on a product. A build of that product writes it anew: it is neither an option nor a
/// primvar of the model.
pub fn is_produced(property: &str) -> bool {
    let of_level = property.rfind(&format!(":{LOD}")).map_or(property, |at| &property[..at]);
    let mut written = [ATTACH_POINTS, ATTACH_FACES, ATTACH_COORDS].into_iter().chain(MODEL_BINDING);
    BINDING.contains(&of_level) || written.any(|name| name == property)
}

/// Metadata: the elements that a primvar lives on.
pub const INTERPOLATION: &str = "interpolation";
/// Metadata: values in one element of a primvar.
pub const ELEMENT_SIZE: &str = "elementSize";
/// Metadata: the row of a primvar's values that means "no value".
pub const UNAUTHORED_VALUES_INDEX: &str = "unauthoredValuesIndex";
/// Metadata: the dictionary that identifies products.
pub const CUSTOM_DATA: &str = "customData";
/// Key in `customData` of what this program writes.
pub const PRODUCT_SPACE: &str = "tailor";
/// Key, in that dictionary, of the name of the model that a product was made from.
pub const PRODUCT_OF: &str = "model";
/// Key, in that dictionary, of the paths of all panels that a product was made from, where there are several.
pub const PRODUCT_PANELS: &str = "panels";
/// Key in that dictionary of a product's role.
pub const PRODUCT: &str = "product";

/// Attributes that a product authors from its own mesh.
pub const REWRITTEN: &[&str] = &[
    POINTS,
    FACE_VERTEX_COUNTS,
    FACE_VERTEX_INDICES,
    EXTENT,
    ORIENTATION,
    SUBDIVISION_SCHEME,
    INTERPOLATE_BOUNDARY,
    FACE_VARYING_LINEAR_INTERPOLATION,
    TRIANGLE_SUBDIVISION_RULE,
    HOLE_INDICES,
    CREASE_INDICES,
    CREASE_LENGTHS,
    CREASE_SHARPNESSES,
    CORNER_INDICES,
    CORNER_SHARPNESSES,
    PURPOSE,
    SKEL_BLEND_SHAPES,
    SKEL_BLEND_SHAPE_TARGETS,
];

/// Properties that are copied to products, besides transform ops, material bindings and constant primvars.
pub const COPIED: &[&str] = &[
    VISIBILITY,
    XFORM_OP_ORDER,
    DOUBLE_SIDED,
    SKEL_SKELETON,
    SKEL_ANIMATION_SOURCE,
    SKEL_JOINTS,
    SKEL_SKINNING_METHOD,
];

/// Properties that are dropped with a warning, which gives the reason.
pub const NOT_CARRIED: &[(&str, &str)] = &[
    (NORMALS, "its points are new ones; consumers compute normals, and subdivision surfaces ignore authored ones"),
    (VELOCITIES, "its points are new ones; the attribute stays on the model"),
    (ACCELERATIONS, "its points are new ones; the attribute stays on the model"),
];

/// A type whose values are tokens in USD.
pub trait UsdToken: Copy + 'static {
    /// Every value with its token.
    const TOKENS: &'static [(&'static str, Self)];

    /// The token of the value.
    fn token(self) -> &'static str;

    /// The value of a token.
    fn from_token(token: &str) -> Option<Self> {
        Self::TOKENS.iter().find(|(t, _)| *t == token).map(|(_, v)| *v)
    }

    /// All tokens, for a message.
    fn allowed() -> String {
        Self::TOKENS.iter().map(|(t, _)| *t).collect::<Vec<_>>().join(", ")
    }
}

macro_rules! tokens {
    ($($type:ty { $($token:literal = $value:ident),* $(,)? })*) => { $(
        impl UsdToken for $type {
            const TOKENS: &'static [(&'static str, Self)] = &[$(($token, Self::$value)),*];
            fn token(self) -> &'static str {
                match self { $(Self::$value => $token),* }
            }
        }
    )* };
}

tokens! {
    Orientation { "rightHanded" = RightHanded, "leftHanded" = LeftHanded }
    Scheme { "catmullClark" = CatmullClark, "loop" = Loop, "bilinear" = Bilinear, "none" = None }
    BoundaryInterpolation { "none" = None, "edgeOnly" = EdgeOnly, "edgeAndCorner" = EdgeAndCorner }
    FaceVaryingInterpolation {
        "none" = None, "cornersOnly" = CornersOnly, "cornersPlus1" = CornersPlus1, "cornersPlus2" = CornersPlus2,
        "boundaries" = Boundaries, "all" = All,
    }
    TriangleRule { "catmullClark" = CatmullClark, "smooth" = Smooth }
    Interpolation {
        "constant" = Constant, "uniform" = Uniform, "varying" = Varying, "vertex" = Vertex,
        "faceVarying" = FaceVarying,
    }
    FamilyType { "partition" = Partition, "nonOverlapping" = NonOverlapping, "unrestricted" = Unrestricted }
}

/// Whether a property binds a material.
pub fn is_material(name: &str) -> bool {
    name.starts_with(MATERIAL_BINDING)
}

/// Whether a value of [`BIND_MATERIAL_AS`] lets a binding win over those below its prim.
pub fn is_stronger(strength: &Value) -> bool {
    matches!(strength, Value::Token(strength) if strength.as_str() == "strongerThanDescendants")
}

/// Whether a property binds a material that is drawn: not that of physics.
pub fn is_drawn_material(name: &str) -> bool {
    is_material(name) && name != PHYSICS_MATERIAL
}
