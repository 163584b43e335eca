// Times of OpenSubdiv on a text mesh, which is numbers and words between blanks:
//
//   FACES FACE-VERTICES POINTS UVS
//   vertex count of each face, then the vertex indices, then the points (x y z each),
//   then a UV index per face-vertex, then the UVs (u v each)
//
// followed by any of these, with the names of UsdGeomMesh:
//
//   creases N     N * (vertex vertex sharpness)
//   corners N     N * (vertex sharpness)
//   boundary RULE interpolateBoundary, edgeAndCorner without it
//   linear RULE   faceVaryingLinearInterpolation, cornersPlus1 without it

#pragma once

namespace golden {

/// Prints the times of each level's refinement, and which work they include.
void bench(char const* path);

}  // namespace golden
