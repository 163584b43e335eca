#include "write.h"

#include "refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace golden {

namespace {

class Writer {
public:
    void u8(int v) { bytes_.push_back(static_cast<char>(v)); }
    void u16(int v) {
        if (v < 0 || v > 0xffff) throw std::runtime_error("index too large for the format");
        u8(v & 255), u8(v >> 8);
    }
    void u32(std::uint64_t v) {
        for (int i = 0; i < 4; ++i) u8(static_cast<int>(v >> (8 * i) & 255));
    }
    void f32(double v) {
        float const f = static_cast<float>(v);
        std::uint32_t bits;
        std::memcpy(&bits, &f, 4);
        u32(bits);
    }
    void f64(double v) {
        std::uint64_t bits;
        std::memcpy(&bits, &v, 8);
        u32(bits & 0xffffffff), u32(bits >> 32);
    }
    void str(std::string const& s) {
        u16(static_cast<int>(s.size()));
        bytes_ += s;
    }
    std::string const& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

void writeLevel(Writer& out, std::array<Refined, kModes> const& modes, std::vector<int> const& slots, int level,
                int atMost) {
    Refined const& first = modes[0];
    auto const& topology = first.refiner->GetLevel(level);
    auto const uv = [&](int mode, int face, int corner) -> Pair const& {
        auto const& t = modes[mode].refiner->GetLevel(level);
        return modes[mode].uvs[level][t.GetFaceFVarValues(face, 0)[corner]];
    };
    int const faces = topology.GetNumFaces();
    out.u32(topology.GetNumVertices());
    out.u32(topology.GetNumEdges());
    out.u32(faces);
    out.u32(topology.GetNumFaceVertices());

    Point points;
    Pair varying;
    std::vector<Pair> uvs(slots.size());
    double sharp = 0;
    for (int f = 0; f < faces; ++f) {
        auto const vertices = topology.GetFaceVertices(f);
        for (int i = 0; i < vertices.size(); ++i) {
            points.AddWithWeight(first.points[level][vertices[i]], 1);
            varying.AddWithWeight(first.varying[level][vertices[i]], 1);
            for (std::size_t s = 0; s < slots.size(); ++s) uvs[s].AddWithWeight(uv(slots[s], f, i), 1);
            sharp += topology.GetEdgeSharpness(topology.GetFaceEdges(f)[i]);
        }
    }
    for (double x : points.x) out.f64(x);
    for (double x : varying.x) out.f64(x);
    for (auto const& sum : uvs)
        for (double x : sum.x) out.f64(x);
    out.f64(sharp);

    int const samples = std::min(faces, atMost);
    out.u32(samples);
    for (int n = 0; n < samples; ++n) {
        int const f = static_cast<int>(static_cast<long long>(n) * faces / samples);
        auto const vertices = topology.GetFaceVertices(f);
        auto const edges = topology.GetFaceEdges(f);
        int base = f;
        for (int l = level; l > 0; --l) base = first.refiner->GetLevel(l).GetFaceParentFace(base);
        out.u32(f);
        out.u16(base);
        out.u8(topology.IsFaceHole(f) ? 1 : 0);
        out.u8(vertices.size());
        for (int i = 0; i < vertices.size(); ++i) {
            float const edge = topology.GetEdgeSharpness(edges[i]);
            float const vertex = topology.GetVertexSharpness(vertices[i]);
            auto const floats = [](Pair const& p) {
                return std::array<float, 2>{static_cast<float>(p.x[0]), static_cast<float>(p.x[1])};
            };
            auto const uv0 = floats(uv(slots[0], f, i));
            int flags = (edge != 0 ? 1 : 0) | (vertex != 0 ? 2 : 0);
            for (std::size_t s = 1; s < slots.size(); ++s)
                if (floats(uv(slots[s], f, i)) != uv0) flags |= 2 << s;
            out.u32(vertices[i]);
            out.u8(flags);
            for (double x : first.points[level][vertices[i]].x) out.f32(x);
            for (double x : first.varying[level][vertices[i]].x) out.f32(x);
            for (float x : uv0) out.f32(x);
            if (flags & 1) out.f32(edge);
            if (flags & 2) out.f32(vertex);
            for (std::size_t s = 1; s < slots.size(); ++s)
                if (flags & (2 << s))
                    for (double x : uv(slots[s], f, i).x) out.f32(x);
        }
    }
}

/// True if the two rules give every corner of every level the same value.
bool sameUvs(Refined const& a, Refined const& b) {
    for (int level = 1; level <= kLevels; ++level) {
        auto const &ta = a.refiner->GetLevel(level), &tb = b.refiner->GetLevel(level);
        for (int f = 0; f < ta.GetNumFaces(); ++f) {
            auto const va = ta.GetFaceFVarValues(f, 0), vb = tb.GetFaceFVarValues(f, 0);
            for (int i = 0; i < va.size(); ++i)
                for (int k = 0; k < 2; ++k)
                    if (std::abs(a.uvs[level][va[i]].x[k] - b.uvs[level][vb[i]].x[k]) > 1e-7) return false;
        }
    }
    return true;
}

void writeCase(Writer& out, Case const& c) {
    Mesh const& m = c.mesh;
    Description const description(m);
    std::array<Refined, kModes> modes;
    for (int mode = 0; mode < kModes; ++mode) modes[mode] = refine(c, description, mode);
    std::vector<int> slots;  // the mode which stands for each slot
    std::array<int, kModes> slotOf{};
    for (int mode = 0; mode < kModes; ++mode) {
        std::size_t s = 0;
        while (s < slots.size() && !sameUvs(modes[slots[s]], modes[mode])) ++s;
        if (s == slots.size()) slots.push_back(mode);
        slotOf[mode] = static_cast<int>(s);
    }
    for (int level = 0; level <= kLevels; ++level) {
        for (auto const& p : modes[0].points[level])
            for (double x : p.x)
                if (!std::isfinite(x)) throw std::runtime_error("not finite: point");
        for (auto const& mode : modes)
            for (auto const& p : mode.uvs[level])
                for (double x : p.x)
                    if (!std::isfinite(x)) throw std::runtime_error("not finite: face-varying value");
    }

    out.str(c.name);
    out.u8(c.scheme), out.u8(c.boundary), out.u8(c.smoothTriangles);
    out.u8(static_cast<int>(slots.size()));
    for (int s : slotOf) out.u8(s);
    out.u32(m.points.size());
    for (std::size_t v = 0; v < m.points.size(); ++v) {
        for (float x : m.points[v]) out.f32(x);
        for (float x : m.varying[v]) out.f32(x);
    }
    out.u32(m.counts.size());
    for (int n : m.counts) out.u16(n);
    out.u32(m.indices.size());
    for (int v : m.indices) out.u16(v);
    out.u32(m.creases.size());
    for (auto const& e : m.creases) out.u16(e.a), out.u16(e.b), out.f32(e.sharpness);
    out.u32(m.corners.size());
    for (auto const& v : m.corners) out.u16(v.vertex), out.f32(v.sharpness);
    out.u32(m.holes.size());
    for (int f : m.holes) out.u16(f);
    out.u32(m.uvs.size());
    for (auto const& p : m.uvs)
        for (float x : p) out.f32(x);
    for (int i : m.uvIndices) out.u16(i);
    for (int level = 1; level <= kLevels; ++level) writeLevel(out, modes, slots, level, c.samples[level - 1]);
}

void writeFamily(std::filesystem::path const& dir, std::string const& name, Cases const& cases) {
    Writer out;
    for (char c : std::string("SUBDGOLD")) out.u8(c);
    out.u32(1);
    out.u32(cases.size());
    for (auto const& c : cases) {
        try {
            writeCase(out, c);
        } catch (std::exception const& e) {
            throw std::runtime_error(c.name + ": " + e.what());
        }
    }
    std::ofstream file(dir / (name + ".bin"), std::ios::binary);
    file.write(out.bytes().data(), static_cast<std::streamsize>(out.bytes().size()));
    if (!file) throw std::runtime_error("cannot write " + (dir / name).string());
    std::cout << name << ": " << cases.size() << " cases, " << out.bytes().size() << " bytes\n";
}

}  // namespace

void data(std::filesystem::path const& dir, std::filesystem::path const& garments) {
    std::filesystem::create_directories(dir);
    writeFamily(dir, "catmark", catmarkCases());
    writeFamily(dir, "loop", loopCases());
    writeFamily(dir, "bilinear", bilinearCases());
    writeFamily(dir, "generated", generatedCases());
    writeFamily(dir, "nonmanifold", nonManifoldCases());
    writeFamily(dir, "garments", garmentCases(garments));
}

}  // namespace golden
