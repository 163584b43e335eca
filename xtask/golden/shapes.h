// Shapes for the cases.

#pragma once

#include "mesh.h"

#include <functional>

namespace golden {

constexpr double kPi = 3.14159265358979323846;

Mesh cube(double size = 1);
/// nx * ny quads over [-1,1]^2, vertex (i,j) has index j*(nx+1)+i.
Mesh grid(int nx, int ny, double bump = 0.3);
Mesh torus(int nu, int nv);
/// An open cylinder; with caps, n-gons close it.
Mesh tube(int n, int rows, bool caps = false);
/// A closed surface with two vertices of valence n; `open` leaves out the lower fan.
Mesh pole(int n, bool open = false);
/// n triangles about an apex and one n-gon below.
Mesh pyramid(int n);
/// n triangles (or quads) about vertex 0, open unless closed.
Mesh fan(int n, bool quads, bool closed);
/// Two slopes which meet in a ridge (vertices 1, 4 and 7 of a 2 x 2 grid).
Mesh tent();
/// Triangles to octagons in one open sheet.
Mesh nonquads();
Mesh icosahedron();
/// Fans every face from its first vertex, quads alternately from the second.
Mesh triangulate(Mesh mesh);
Mesh reversed(Mesh mesh);
Mesh append(Mesh a, Mesh const& b, double dx, double dy, double dz);
/// Replaces vertex `from` by `to` in every face; `from` stays as a vertex of no face.
Mesh weld(Mesh mesh, int from, int to);
/// Drops vertices of no face.
Mesh compact(Mesh mesh);
Mesh with(Mesh mesh, std::function<void(Mesh&)> const& change);
Mesh generated(Random& random, int kind, bool triangles, bool creased);

}  // namespace golden
