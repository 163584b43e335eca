// A case is (mesh, scheme, boundary rule, triangle rule); families of them.

#pragma once

#include "mesh.h"

#include <array>
#include <filesystem>
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
    /// Sampled faces at levels 1, 2, 3.
    std::array<int, 3> samples = {40, 20, 14};
};

using Cases = std::vector<Case>;

Cases catmarkCases();
Cases loopCases();
Cases bilinearCases();
Cases generatedCases();
Cases nonManifoldCases();
/// The cases in a file that garments.py wrote.
Cases garmentCases(std::filesystem::path const& path);

}  // namespace golden
