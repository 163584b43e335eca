//! A small garment as text: four quads with something of everything.

/// `/Coat/model`. Points are numbered from the lower left, row by row:
///
/// ```text
/// 6 7 8
/// 3 4 5
/// 0 1 2
/// ```
pub const CLOTH: &str = r#"#usda 1.0
(
    defaultPrim = "Coat"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Xform "Coat"
{
    def Mesh "model" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0.25), (2, 1, 0), (0, 2, 0), (1, 2, 0), (2, 2, 0)]
        int[] faceVertexCounts = [4, 4, 4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7]
        int[] creaseIndices = [1, 4, 7, 4, 5]
        int[] creaseLengths = [3, 2]
        float[] creaseSharpnesses = [2, 3, 4]
        int[] cornerIndices = [8, 0]
        float[] cornerSharpnesses = [10, 4]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2), (2, 2)] (
            interpolation = "faceVarying"
        )
        int[] primvars:st:indices = [0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7]
        float[] primvars:density = [0, 0, 0, 0, 1, 0, 0.5, 0.5, 0.5] (
            interpolation = "vertex"
        )
        float[] primvars:tint = [0, 1, 2, 3, 4, 5, 6, 7, 8] (
            interpolation = "varying"
        )
        double[] primvars:ply = [1, 2, 3, 4] (
            interpolation = "uniform"
        )
        float[] primvars:gloss = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] (
            interpolation = "faceVarying"
        )
        int[] primvars:skel:jointIndices = [0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1] (
            elementSize = 2
            interpolation = "vertex"
        )
        float[] primvars:skel:jointWeights = [0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 1, 0, 0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 0.5, 0.5] (
            elementSize = 2
            interpolation = "vertex"
        )
        uniform token subsetFamily:panels:familyType = "partition"
        uniform token subsetFamily:seams:familyType = "nonOverlapping"

        def GeomSubset "left"
        {
            uniform token elementType = "face"
            uniform token familyName = "panels"
            int[] indices = [0, 2]
        }

        def GeomSubset "right"
        {
            uniform token elementType = "face"
            uniform token familyName = "panels"
            int[] indices = [3, 1]
        }

        def GeomSubset "placket"
        {
            uniform token elementType = "edge"
            uniform token familyName = "seams"
            int[] indices = [7, 4, 1, 4]
        }

        def GeomSubset "waist"
        {
            uniform token elementType = "edge"
            uniform token familyName = "seams"
            int[] indices = [4, 3]
        }

        def GeomSubset "pins"
        {
            uniform token elementType = "point"
            int[] indices = [8, 2]
        }
    }
}
"#;

/// The cloth with the one place that reads `old` replaced.
#[track_caller]
pub fn cloth_with(old: &str, new: &str) -> String {
    assert_eq!(CLOTH.matches(old).count(), 1, "{old:?} names one place of the cloth");
    CLOTH.replace(old, new)
}

/// The cloth with statements added to its mesh.
pub fn cloth_and(statements: &str) -> String {
    const PLACE: &str = "        int[] faceVertexCounts";
    cloth_with(PLACE, &format!("{statements}\n{PLACE}"))
}
