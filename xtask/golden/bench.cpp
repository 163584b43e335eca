#include "bench.h"

#include "refine.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace golden {

namespace {

Mesh readMesh(char const* path) {
    std::ifstream in(path);
    std::size_t faces, corners, points, uvs;
    if (!(in >> faces >> corners >> points >> uvs)) throw std::runtime_error("no mesh in " + std::string(path));
    Mesh m;
    m.counts.resize(faces);
    m.indices.resize(corners);
    m.points.resize(points);
    m.uvIndices.resize(corners);
    m.uvs.resize(uvs);
    for (int& n : m.counts) in >> n;
    for (int& v : m.indices) in >> v;
    for (auto& p : m.points)
        for (float& x : p) in >> x;
    for (int& i : m.uvIndices) in >> i;
    for (auto& p : m.uvs)
        for (float& x : p) in >> x;
    if (!in) throw std::runtime_error("the mesh ends too early");
    return m;
}

struct Times {
    std::vector<double> ms;
    template <typename F>
    void measure(F const& f) {
        auto const start = std::chrono::steady_clock::now();
        f();
        std::chrono::duration<double, std::milli> const d = std::chrono::steady_clock::now() - start;
        ms.push_back(d.count());
    }
    std::string text() {
        std::sort(ms.begin(), ms.end());
        std::ostringstream s;
        s.setf(std::ios::fixed);
        s.precision(2);
        s << ms.front() << " / " << ms[ms.size() / 2];
        return s.str();
    }
};

Times sum(Times const& a, Times const& b, Times const& c) {
    Times t;
    for (std::size_t i = 0; i < a.ms.size(); ++i) t.ms.push_back(a.ms[i] + b.ms[i] + c.ms[i]);
    return t;
}

template <int N>
std::vector<Value<float, N>> copyOf(std::vector<std::array<float, N>> const& from) {
    std::vector<Value<float, N>> to(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) to[i].x = from[i];
    return to;
}

}  // namespace

void bench(char const* path, int runs) {
    Mesh const mesh = readMesh(path);
    Description const description(mesh);
    std::cout << mesh.faceCount() << " faces, " << mesh.vertexCount() << " points, " << mesh.uvs.size()
              << " UVs; catmullClark, edgeAndCorner, cornersPlus1, one thread; min / median ms of " << runs << " runs\n";
    for (int level = 1; level <= kLevels; ++level) {
        // One loop per task, so that each finds the allocator in the state it left it in itself.
        Times base, refinement, primvar, full, stencils;
        int faces = 0;
        for (int run = 0; run < runs; ++run) {
            Refiner refiner;
            base.measure([&] { refiner = makeRefiner(description, Catmark, EdgeAndCorner, false, 2); });
            refinement.measure([&] { refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level)); });
            faces = refiner->GetLevel(level).GetNumFaces();
            primvar.measure([&] {
                Far::PrimvarRefinerReal<float> const primvars(*refiner);
                auto points = copyOf<3>(mesh.points);
                auto uvs = copyOf<2>(mesh.uvs);
                for (int l = 1; l <= level; ++l) {
                    std::vector<Value<float, 3>> nextPoints(refiner->GetLevel(l).GetNumVertices());
                    std::vector<Value<float, 2>> nextUvs(refiner->GetLevel(l).GetNumFVarValues(0));
                    primvars.Interpolate(l, points, nextPoints);
                    primvars.InterpolateFaceVarying(l, uvs, nextUvs);
                    points.swap(nextPoints);
                    uvs.swap(nextUvs);
                }
            });
        }
        for (int run = 0; run < runs; ++run) {
            Refiner const refiner = makeRefiner(description, Catmark, EdgeAndCorner, false, 2);
            Far::TopologyRefiner::UniformOptions uniform(level);
            uniform.fullTopologyInLastLevel = true;
            full.measure([&] { refiner->RefineUniform(uniform); });
        }
        Refiner const refined = makeRefiner(description, Catmark, EdgeAndCorner, false, 2);
        refined->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
        for (int run = 0; run < runs; ++run) {
            std::unique_ptr<Far::StencilTable const> table;
            stencils.measure([&] {
                Far::StencilTableFactory::Options options;
                options.generateIntermediateLevels = false;
                options.generateOffsets = true;
                table.reset(Far::StencilTableFactory::Create(*refined, options));
            });
            if (!table) throw std::runtime_error("no stencils");
        }
        std::cout << "level " << level << " (" << faces << " faces)\n"
                  << "  base topology                    " << Times(base).text() << "\n"
                  << "  refinement                       " << Times(refinement).text() << "\n"
                  << "  refinement, full last level      " << Times(full).text() << "\n"
                  << "  points and UVs                   " << Times(primvar).text() << "\n"
                  << "  topology + points + one UV set   " << sum(base, refinement, primvar).text() << "\n"
                  << "  stencils of all vertices         " << stencils.text() << "\n";
    }
}

}  // namespace golden
