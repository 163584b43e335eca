#include "bench.h"

#include "refine.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <stdexcept>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace golden {

namespace {

constexpr int kRuns = 15;
/// The rules as UsdGeomMesh names them, in the order of the parameters of `makeRefiner`.
constexpr std::array<char const*, 3> kBoundaryRules = {"none", "edgeOnly", "edgeAndCorner"};
constexpr std::array<char const*, kModes> kLinearRules = {"none",         "cornersOnly", "cornersPlus1",
                                                          "cornersPlus2", "boundaries",  "all"};

struct Input {
    Mesh mesh;
    int boundary = EdgeAndCorner;
    int linear = 2;

    Refiner refiner(Description const& description) const {
        return makeRefiner(description, Catmark, static_cast<Boundary>(boundary), false, linear);
    }
};

template <std::size_t N>
int readRule(std::istream& in, std::array<char const*, N> const& rules) {
    std::string word;
    in >> word;
    auto const found = std::find(rules.begin(), rules.end(), word);
    if (found == rules.end()) throw std::runtime_error("unknown rule: " + word);
    return static_cast<int>(found - rules.begin());
}

Input readInput(char const* path) {
    std::ifstream in(path);
    std::size_t faces, corners, points, uvs, count;
    if (!(in >> faces >> corners >> points >> uvs)) throw std::runtime_error("no mesh in " + std::string(path));
    Input input;
    Mesh& m = input.mesh;
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
    for (std::string word; in >> word;) {
        if (word == "boundary") {
            input.boundary = readRule(in, kBoundaryRules);
        } else if (word == "linear") {
            input.linear = readRule(in, kLinearRules);
        } else if (word == "creases" && in >> count) {
            m.creases.resize(count);
            for (Crease& c : m.creases) in >> c.a >> c.b >> c.sharpness;
        } else if (word == "corners" && in >> count) {
            m.corners.resize(count);
            for (Corner& c : m.corners) in >> c.vertex >> c.sharpness;
        } else {
            throw std::runtime_error("unknown part of a text mesh: " + word);
        }
    }
    return input;
}

/// Has the allocator keep freed memory: the pages that glibc gives back are faulted in again by the next run.
bool keepHeap() {
#ifdef __GLIBC__
    return mallopt(M_MMAP_MAX, 0) && mallopt(M_TRIM_THRESHOLD, -1) && mallopt(M_TOP_PAD, 64 << 20);
#else
    return false;
#endif
}

/// Milliseconds since the last call.
class Clock {
public:
    double lap() {
        auto const now = std::chrono::steady_clock::now();
        std::chrono::duration<double, std::milli> const passed = now - last_;
        last_ = now;
        return passed.count();
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void print(char const* task, std::vector<double> ms) {
    std::sort(ms.begin(), ms.end());
    std::cout << "  " << std::left << std::setw(50) << task << std::right << std::fixed << std::setprecision(2)
              << std::setw(9) << ms[ms.size() / 2] << std::setw(9) << ms.front() << "\n";
}

/// A value that costs nothing to construct, as in OpenSubdiv's tutorials.
template <int N>
struct Vector {
    Vector() {}
    Vector(std::array<float, N> const& from) { std::copy(from.begin(), from.end(), x); }
    void Clear(void* = nullptr) { std::fill(x, x + N, 0.0f); }
    void AddWithWeight(Vector const& other, float weight) {
        for (int i = 0; i < N; ++i) x[i] += weight * other.x[i];
    }
    float x[N];
};

template <int N>
std::vector<Vector<N>> startOf(std::vector<std::array<float, N>> const& base, int total) {
    std::vector<Vector<N>> values(total);
    std::copy(base.begin(), base.end(), values.begin());
    return values;
}

/// The points and UVs of all levels, one after the other.
struct Primvars {
    std::vector<Vector<3>> points;
    std::vector<Vector<2>> uvs;
};

Primvars interpolate(Far::TopologyRefiner const& refiner, Mesh const& mesh) {
    Far::PrimvarRefinerReal<float> const primvars(refiner);
    Primvars values{startOf<3>(mesh.points, refiner.GetNumVerticesTotal()),
                    startOf<2>(mesh.uvs, refiner.GetNumFVarValuesTotal(0))};
    Vector<3>* point = values.points.data();
    Vector<2>* uv = values.uvs.data();
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        auto const& coarser = refiner.GetLevel(level - 1);
        Vector<3>* const nextPoint = point + coarser.GetNumVertices();
        Vector<2>* const nextUv = uv + coarser.GetNumFVarValues(0);
        primvars.Interpolate(level, point, nextPoint);
        primvars.InterpolateFaceVarying(level, uv, nextUv);
        point = nextPoint;
        uv = nextUv;
    }
    return values;
}

/// The cage's topology, its refinement, and the values of all levels.
void benchRefinement(Input const& input, Description const& description, int level, bool full) {
    std::vector<double> base, refinement, primvars, total;
    for (int run = 0; run <= kRuns; ++run) {
        Clock clock;
        Refiner const refiner = input.refiner(description);
        double const a = clock.lap();
        Far::TopologyRefiner::UniformOptions options(level);
        options.fullTopologyInLastLevel = full;
        refiner->RefineUniform(options);
        double const b = clock.lap();
        Primvars const values = interpolate(*refiner, input.mesh);
        double const c = clock.lap();
        if (run == 0) continue;
        base.push_back(a);
        refinement.push_back(b);
        primvars.push_back(c);
        total.push_back(a + b + c);
    }
    if (full) return print("refinement with the last level's full topology", refinement);
    print("base topology (TopologyRefinerFactory)", base);
    print("refinement (RefineUniform)", refinement);
    print("points and UVs of all levels (PrimvarRefiner)", primvars);
    print("sum: topology, points and UVs", total);
}

/// A deforming garment's tasks: stencils once, then the finest points as often as the cage moves.
void benchStencils(Input const& input, Description const& description, int level) {
    Refiner const refiner = input.refiner(description);
    refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
    std::vector<Vector<3>> const cage = startOf<3>(input.mesh.points, input.mesh.vertexCount());
    std::vector<double> factory, apply;
    Far::StencilTableFactory::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = false;
    for (int run = 0; run <= kRuns; ++run) {
        Clock clock;
        std::unique_ptr<Far::StencilTable const> const table(Far::StencilTableFactory::Create(*refiner, options));
        double const a = clock.lap();
        std::vector<Vector<3>> points(table->GetNumStencils());
        table->UpdateValues(cage, points);
        double const b = clock.lap();
        if (run == 0) continue;
        factory.push_back(a);
        apply.push_back(b);
    }
    print("stencils from the cage (StencilTableFactory)", factory);
    print("points by these stencils (UpdateValues)", apply);
}

}  // namespace

void bench(char const* path) {
    Input const input = readInput(path);
    Mesh const& mesh = input.mesh;
    Description const description(mesh);
    bool const kept = keepHeap();
    std::cout << "OpenSubdiv " << OPENSUBDIV_VERSION_MAJOR << '.' << OPENSUBDIV_VERSION_MINOR << '.'
              << OPENSUBDIV_VERSION_PATCH << ", Far, one thread, compiled with " << GOLDEN_COMPILER << '\n'
              << mesh.faceCount() << " faces, " << mesh.vertexCount() << " points, " << mesh.uvs.size() << " UVs, "
              << mesh.creases.size() << " creased edges; catmullClark, " << kBoundaryRules[input.boundary] << ", "
              << kLinearRules[input.linear] << "\n\n"
              << "Measured: all work from arrays of indices and values to the finest faces, points and UVs, with the\n"
              << "allocation of results. The finest level has face-vertices, vertex-faces and face-varying topology,\n"
              << "but edges only where a line says full topology.\n"
              << "Not measured: reading the file, and freeing refiners, tables and values.\n"
              << (kept ? "The heap is kept between runs, so runs do not pay for new memory pages.\n"
                       : "The heap is not kept between runs: here they may pay for new memory pages.\n")
              << "\nMilliseconds of " << kRuns << " runs after one that is not counted:" << std::setw(18) << "median"
              << std::setw(9) << "minimum" << '\n';
    for (int level = 1; level <= kLevels; ++level) {
        Refiner const refiner = input.refiner(description);
        refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
        std::cout << "level " << level << " (" << refiner->GetLevel(level).GetNumFaces() << " faces)\n";
        benchRefinement(input, description, level, false);
        benchRefinement(input, description, level, true);
        benchStencils(input, description, level);
    }
}

}  // namespace golden
