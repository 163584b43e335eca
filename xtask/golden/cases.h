// A case is (mesh, scheme, boundary rule, triangle rule); families of them.

#pragma once

#include "mesh.h"

#include <string>
#include <vector>

namespace golden {

enum Scheme { Bilinear = 0, Catmark = 1, Loop = 2 };
enum Boundary { BoundaryNone = 0, EdgeOnly = 1, EdgeAndCorner = 2 };

struct Case {
    std::string name;
    Mesh mesh;
    Scheme scheme;
    Boundary boundary;
    bool smoothTriangles;
};

using Cases = std::vector<Case>;

Cases catmarkCases();
Cases loopCases();
Cases bilinearCases();
Cases generatedCases();
Cases nonManifoldCases();

}  // namespace golden
