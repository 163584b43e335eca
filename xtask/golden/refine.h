// Cases as OpenSubdiv refines them.

#pragma once

#include "cases.h"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/version.h>

#include <array>
#include <memory>
#include <vector>

static_assert(OPENSUBDIV_VERSION_NUMBER >= 30600, "OpenSubdiv 3.6 or later is needed");

namespace golden {

namespace Far = OpenSubdiv::Far;

constexpr int kLevels = 3;
/// Rules of face-varying linear interpolation.
constexpr int kModes = 6;

template <typename Real, int N>
struct Value {
    std::array<Real, N> x{};
    void Clear(void* = nullptr) { x.fill(0); }
    void AddWithWeight(Value const& other, Real weight) {
        for (int i = 0; i < N; ++i) x[i] += weight * other.x[i];
    }
};
using Point = Value<double, 3>;
using Pair = Value<double, 2>;

using Refiner = std::unique_ptr<Far::TopologyRefiner>;

/// The descriptor only borrows, so the arrays live here.
struct Description {
    explicit Description(Mesh const& mesh) {
        for (auto const& c : mesh.creases) {
            creasePairs.push_back(c.a);
            creasePairs.push_back(c.b);
            creaseWeights.push_back(c.sharpness);
        }
        for (auto const& c : mesh.corners) {
            cornerVertices.push_back(c.vertex);
            cornerWeights.push_back(c.sharpness);
        }
        d.numVertices = mesh.vertexCount();
        d.numFaces = mesh.faceCount();
        d.numVertsPerFace = mesh.counts.data();
        d.vertIndicesPerFace = mesh.indices.data();
        d.numCreases = static_cast<int>(mesh.creases.size());
        d.creaseVertexIndexPairs = creasePairs.data();
        d.creaseWeights = creaseWeights.data();
        d.numCorners = static_cast<int>(mesh.corners.size());
        d.cornerVertexIndices = cornerVertices.data();
        d.cornerWeights = cornerWeights.data();
        d.numHoles = static_cast<int>(mesh.holes.size());
        d.holeIndices = mesh.holes.data();
        if (!mesh.uvs.empty()) {
            channel.numValues = static_cast<int>(mesh.uvs.size());
            channel.valueIndices = mesh.uvIndices.data();
            d.numFVarChannels = 1;
            d.fvarChannels = &channel;
        }
    }
    Description(Description const&) = delete;

    Far::TopologyDescriptor d;
    Far::TopologyDescriptor::FVarChannel channel;
    std::vector<int> creasePairs, cornerVertices;
    std::vector<float> creaseWeights, cornerWeights;
};

Refiner makeRefiner(Description const& description, Scheme scheme, Boundary boundary, bool smooth, int mode);

struct Refined {
    Refiner refiner;
    std::vector<std::vector<Point>> points;  // per level, 0 included
    std::vector<std::vector<Pair>> varying;
    std::vector<std::vector<Pair>> uvs;
};

Refined refine(Case const& c, Description const& description, int mode);

}  // namespace golden
