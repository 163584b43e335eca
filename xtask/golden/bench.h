// Times of OpenSubdiv on a text mesh, which is numbers between blanks:
//
//   FACES FACE-VERTICES POINTS UVS
//   vertex count of each face, then the vertex indices, then the points (x y z each),
//   then a UV index per face-vertex, then the UVs (u v each)

#pragma once

namespace golden {

/// Prints the times of this many runs.
void bench(char const* path, int runs);

}  // namespace golden
