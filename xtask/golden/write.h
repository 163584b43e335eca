// The golden data.
//
// File format, little endian, no padding; str is u16 length + UTF-8 bytes:
//
//   file    8 bytes "SUBDGOLD", u32 version (1), u32 case count, cases
//   case    str name
//           u8  scheme (0 bilinear, 1 catmullClark, 2 loop)
//           u8  boundary (0 none, 1 edgeOnly, 2 edgeAndCorner)
//           u8  triangle rule (0 catmullClark, 1 smooth)
//           u8  number of face-varying slots S
//           u8  slot of each of the six rules, in the order none, cornersOnly, cornersPlus1,
//               cornersPlus2, boundaries, all (rules with equal samples share a slot)
//           u32 V, V * (f32[3] point, f32[2] varying value)
//           u32 F, F * u16 vertex count; u32 C (their sum), C * u16 vertex
//           u32 n, n * (u16, u16, f32) edge sharpness
//           u32 n, n * (u16, f32) vertex sharpness
//           u32 n, n * u16 hole face
//           u32 n, n * f32[2] face-varying values, C * u16 value index
//           3 * level
//   level   u32 vertices, edges, faces, face-vertices
//           f64[3] sum of the points, f64[2] of the varying values, S * f64[2] of the face-varying
//               values, f64 of the edge sharpness (edge i from corner i to i+1): each over every
//               corner of every face of the level, holes included
//           u32 number of sampled faces, samples
//   sample  u32 face, u16 base face, u8 (bit 0: hole), u8 corners, corners * corner
//   corner  u32 vertex, u8 flags, f32[3] point, f32[2] varying value, f32[2] value of slot 0,
//           then per flag: bit 0 f32 edge sharpness to the next corner (else 0), bit 1 f32 vertex
//           sharpness (else 0), bit 1+k f32[2] value of slot k (else that of slot 0)
//
// Corners come in OpenSubdiv's order; vertex, edge and face numbers are OpenSubdiv's.

#pragma once

#include <filesystem>

namespace golden {

/// Writes DIR/{catmark,loop,bilinear,generated,nonmanifold,garments}.bin; the last from the file `garments`.
void data(std::filesystem::path const& dir, std::filesystem::path const& garments);

}  // namespace golden
