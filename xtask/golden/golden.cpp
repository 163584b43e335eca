// Golden data for the subdivision tests, and a bench, both made with Pixar OpenSubdiv.
//
//   golden data DIR       writes DIR/{catmark,loop,bilinear,generated,nonmanifold}.bin
//   golden bench MESH     times OpenSubdiv on a text mesh (see bench() below)
//
// Every mesh is built here, by code. A case is (mesh, scheme, boundary rule, triangle rule); all six
// rules of face-varying linear interpolation are evaluated for it, at levels 1, 2 and 3.
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

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/version.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

static_assert(OPENSUBDIV_VERSION_NUMBER >= 30600, "OpenSubdiv 3.6 or later is needed");

namespace {

using namespace OpenSubdiv;
using Edge = std::pair<int, int>;

constexpr double kPi = 3.14159265358979323846;
constexpr int kLevels = 3;
constexpr int kModes = 6;
constexpr float kInfinite = 10.0f;
/// Sampled faces at levels 1, 2, 3.
constexpr std::array<int, kLevels> kSamples = {40, 20, 14};

/// Random numbers that are the same with every standard library.
class Random {
public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double unit() { return (engine_() >> 8) * (1.0 / 16777216.0); }
    double range(double low, double high) { return low + (high - low) * unit(); }
    int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(n)); }
    bool chance(double p) { return unit() < p; }

private:
    std::mt19937 engine_;
};

Edge key(int a, int b) { return a < b ? Edge(a, b) : Edge(b, a); }

// ------------------------------------------------------------------------------------- meshes

struct Crease {
    int a, b;
    float sharpness;
};
struct Corner {
    int vertex;
    float sharpness;
};

struct Mesh {
    std::vector<std::array<float, 3>> points;
    std::vector<std::array<float, 2>> varying;
    std::vector<int> counts, indices;
    std::vector<Crease> creases;
    std::vector<Corner> corners;
    std::vector<int> holes;
    std::vector<std::array<float, 2>> uvs;
    std::vector<int> uvIndices;

    int vertexCount() const { return static_cast<int>(points.size()); }
    int faceCount() const { return static_cast<int>(counts.size()); }

    int add(double x, double y, double z) {
        points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
        return vertexCount() - 1;
    }
    void face(std::initializer_list<int> vertices) { face(std::vector<int>(vertices)); }
    void face(std::vector<int> const& vertices) {
        counts.push_back(static_cast<int>(vertices.size()));
        indices.insert(indices.end(), vertices.begin(), vertices.end());
    }
    void crease(int a, int b, double s) { creases.push_back({a, b, static_cast<float>(s)}); }
    void creaseLoop(std::vector<int> const& loop, double s, bool closed = true) {
        for (std::size_t i = 0; i + 1 < loop.size(); ++i) crease(loop[i], loop[i + 1], s);
        if (closed) crease(loop.back(), loop.front(), s);
    }
    void corner(int v, double s) { corners.push_back({v, static_cast<float>(s)}); }

    std::vector<std::vector<int>> faces() const {
        std::vector<std::vector<int>> result;
        auto at = indices.begin();
        for (int n : counts) {
            result.emplace_back(at, at + n);
            at += n;
        }
        return result;
    }
    /// Undirected edges in order of first occurrence, with the faces that use them.
    std::vector<std::pair<Edge, std::vector<int>>> edges() const {
        std::vector<std::pair<Edge, std::vector<int>>> list;
        std::map<Edge, std::size_t> where;
        auto const all = faces();
        for (int f = 0; f < faceCount(); ++f) {
            auto const& face = all[f];
            for (std::size_t i = 0; i < face.size(); ++i) {
                Edge const e = key(face[i], face[(i + 1) % face.size()]);
                if (e.first == e.second) continue;
                auto const [it, fresh] = where.emplace(e, list.size());
                if (fresh) list.push_back({e, {}});
                list[it->second].second.push_back(f);
            }
        }
        return list;
    }
};

/// Breaks the symmetry of the shape and fills in the varying values.
void perturb(Mesh& mesh, Random& random, double amount) {
    for (auto& p : mesh.points) {
        for (float& c : p) c += static_cast<float>(random.range(-amount, amount));
        mesh.varying.push_back(
            {static_cast<float>(0.5 + p[0] * p[1] + 0.1 * random.unit()),
             static_cast<float>(p[2] * p[2] - p[0] + 0.1 * random.unit())});
    }
}

/// Merges the corners around each vertex across every edge that is not cut; each class of corners
/// becomes one face-varying value. A cut that ends inside the mesh is a dart.
void cutUv(Mesh& mesh, std::set<Edge> const& cuts, Random& random, double joins = 0) {
    int const corners = static_cast<int>(mesh.indices.size());
    std::vector<int> parent(corners);
    std::iota(parent.begin(), parent.end(), 0);
    std::function<int(int)> const root = [&](int i) {
        return parent[i] == i ? i : parent[i] = root(parent[i]);
    };
    auto const join = [&](int a, int b) {
        a = root(a), b = root(b);
        if (a != b) parent[std::max(a, b)] = std::min(a, b);
    };
    // For every edge, the corner at either end, per face.
    std::map<Edge, std::vector<std::array<int, 2>>> sides;
    int offset = 0;
    for (auto const& face : mesh.faces()) {
        int const n = static_cast<int>(face.size());
        for (int i = 0; i < n; ++i) {
            int const j = (i + 1) % n;
            Edge const e = key(face[i], face[j]);
            std::array<int, 2> side = {offset + i, offset + j};
            if (face[i] != e.first) std::swap(side[0], side[1]);
            sides[e].push_back(side);
        }
        offset += n;
    }
    for (auto const& [edge, list] : sides) {
        if (cuts.count(edge)) continue;
        for (std::size_t i = 1; i < list.size(); ++i) {
            join(list[0][0], list[i][0]);
            join(list[0][1], list[i][1]);
        }
    }
    // Two classes of one vertex made one: values which occur in separate runs of faces.
    if (joins > 0) {
        std::vector<int> last(mesh.points.size(), -1);
        for (int c = 0; c < corners; ++c) {
            int& before = last[mesh.indices[c]];
            if (before >= 0 && random.chance(joins)) join(before, c);
            before = c;
        }
    }
    std::map<int, int> number;
    mesh.uvs.clear();
    mesh.uvIndices.clear();
    for (int c = 0; c < corners; ++c) {
        auto const [it, fresh] = number.emplace(root(c), static_cast<int>(mesh.uvs.size()));
        if (fresh) {
            auto const& p = mesh.points[mesh.indices[c]];
            mesh.uvs.push_back(
                {static_cast<float>(0.4 * p[0] + 0.25 * p[2] + random.range(-0.15, 0.15)),
                 static_cast<float>(0.4 * p[1] - 0.2 * p[2] + random.range(-0.15, 0.15))});
        }
        mesh.uvIndices.push_back(it->second);
    }
}

enum class Uv {
    Whole,    ///< one value per vertex
    Island,   ///< two islands of faces
    Islands,  ///< about four islands, so that some corners meet more than two values
    Darts,    ///< few cut edges, most of which end inside
    Cuts,     ///< a third of the edges cut
    Split,    ///< every face on its own
    Joined,   ///< islands, with values shared between separate runs
};

void makeUv(Mesh& mesh, Uv kind, Random& random) {
    std::set<Edge> cuts;
    auto const edges = mesh.edges();
    auto const cutSome = [&](double p) {
        for (auto const& [edge, faces] : edges)
            if (random.chance(p)) cuts.insert(edge);
    };
    auto const islands = [&](int n) {
        // Faces go to the nearest of n random ones, by centre.
        auto const all = mesh.faces();
        std::vector<std::array<double, 3>> centres;
        for (auto const& face : all) {
            std::array<double, 3> c{};
            for (int v : face)
                for (int k = 0; k < 3; ++k) c[k] += mesh.points[v][k] / face.size();
            centres.push_back(c);
        }
        std::vector<int> seeds;
        for (int i = 0; i < n; ++i) seeds.push_back(random.below(mesh.faceCount()));
        std::vector<int> group;
        for (auto const& c : centres) {
            double best = 1e30;
            int which = 0;
            for (int i = 0; i < n; ++i) {
                double d = 0;
                for (int k = 0; k < 3; ++k) d += std::pow(c[k] - centres[seeds[i]][k], 2);
                if (d < best) best = d, which = i;
            }
            group.push_back(which);
        }
        for (auto const& [edge, faces] : edges)
            for (int f : faces)
                if (group[f] != group[faces[0]]) cuts.insert(edge);
    };
    switch (kind) {
    case Uv::Whole: break;
    case Uv::Island: islands(2); break;
    case Uv::Islands: islands(5); break;
    case Uv::Darts: cutSome(0.08); if (cuts.empty()) cuts.insert(edges[edges.size() / 2].first); break;
    case Uv::Cuts: cutSome(0.33); break;
    case Uv::Split: cutSome(2); break;
    case Uv::Joined: islands(5); break;
    }
    cutUv(mesh, cuts, random, kind == Uv::Joined ? 0.08 : 0);
}

// ------------------------------------------------------------------------------------- shapes

Mesh cube(double size = 1) {
    Mesh m;
    for (int i = 0; i < 8; ++i)
        m.add((i & 1 ? 1 : -1) * size, (i & 2 ? 1 : -1) * size, (i & 4 ? 1 : -1) * size);
    m.face({0, 2, 3, 1});
    m.face({4, 5, 7, 6});
    m.face({0, 1, 5, 4});
    m.face({2, 6, 7, 3});
    m.face({0, 4, 6, 2});
    m.face({1, 3, 7, 5});
    return m;
}

/// nx * ny quads over [-1,1]^2, vertex (i,j) has index j*(nx+1)+i.
Mesh grid(int nx, int ny, double bump = 0.3) {
    Mesh m;
    for (int j = 0; j <= ny; ++j)
        for (int i = 0; i <= nx; ++i) {
            double const x = 2.0 * i / nx - 1, y = 2.0 * j / ny - 1;
            m.add(x, y, bump * (x * x - y * y + x * y));
        }
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
            int const a = j * (nx + 1) + i;
            m.face({a, a + 1, a + nx + 2, a + nx + 1});
        }
    return m;
}

Mesh torus(int nu, int nv) {
    Mesh m;
    for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
            double const a = 2 * kPi * i / nu, b = 2 * kPi * j / nv, r = 1.2 + 0.5 * std::cos(b);
            m.add(r * std::cos(a), r * std::sin(a), 0.5 * std::sin(b));
        }
    for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
            int const i1 = (i + 1) % nu, j1 = (j + 1) % nv;
            m.face({j * nu + i, j * nu + i1, j1 * nu + i1, j1 * nu + i});
        }
    return m;
}

/// An open cylinder; with caps, n-gons close it.
Mesh tube(int n, int rows, bool caps = false) {
    Mesh m;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i < n; ++i) {
            double const a = 2 * kPi * i / n, r = 0.8 + 0.2 * std::cos(2.0 * j);
            m.add(r * std::cos(a), r * std::sin(a), 2.0 * j / rows - 1);
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < n; ++i) {
            int const i1 = (i + 1) % n;
            m.face({j * n + i, j * n + i1, (j + 1) * n + i1, (j + 1) * n + i});
        }
    if (caps) {
        std::vector<int> bottom, top;
        for (int i = 0; i < n; ++i) {
            bottom.push_back(n - 1 - i);
            top.push_back(rows * n + i);
        }
        m.face(bottom);
        m.face(top);
    }
    return m;
}

/// A closed surface with two vertices of valence n; `open` leaves out the lower fan.
Mesh pole(int n, bool open = false) {
    Mesh m = tube(n, 1);
    int const top = m.add(0, 0, 1.5);
    for (int i = 0; i < n; ++i) m.face({n + i, n + (i + 1) % n, top});
    if (!open) {
        int const bottom = m.add(0, 0, -1.5);
        for (int i = 0; i < n; ++i) m.face({(i + 1) % n, i, bottom});
    }
    return m;
}

/// n triangles about an apex and one n-gon below.
Mesh pyramid(int n) {
    Mesh m;
    std::vector<int> base;
    for (int i = 0; i < n; ++i) {
        double const a = 2 * kPi * i / n;
        base.insert(base.begin(), m.add(std::cos(a), std::sin(a), -0.5));
    }
    int const apex = m.add(0, 0, 1);
    for (int i = 0; i < n; ++i) m.face({i, (i + 1) % n, apex});
    m.face(base);
    return m;
}

/// n triangles (or quads) about vertex 0, open unless closed.
Mesh fan(int n, bool quads, bool closed) {
    Mesh m;
    m.add(0, 0, 0.4);
    int const ring = quads ? 2 * n : n;
    int const count = closed ? ring : ring + 1;
    double const angle = closed ? 2 * kPi : 1.5 * kPi;
    for (int i = 0; i < count; ++i) {
        double const a = angle * i / ring;
        m.add(std::cos(a), std::sin(a), 0.15 * (i % 3));
    }
    auto const at = [&](int i) { return 1 + i % count; };
    for (int i = 0; i < n; ++i) {
        if (quads) m.face({0, at(2 * i), at(2 * i + 1), at(2 * i + 2)});
        else m.face({0, at(i), at(i + 1)});
    }
    return m;
}

/// Two slopes which meet in a ridge (vertices 1, 4 and 7 of a 2 x 2 grid).
Mesh tent() {
    Mesh m = grid(2, 2, 0);
    for (int j = 0; j < 3; ++j) m.points[3 * j + 1][2] = 1;
    return m;
}

/// Triangles to octagons in one open sheet.
Mesh nonquads() {
    Mesh m;
    int const c = m.add(0, 0, 0.3);
    std::vector<int> ring, outer;
    for (int i = 0; i < 10; ++i) {
        double const a = 2 * kPi * i / 10;
        ring.push_back(m.add(0.6 * std::cos(a), 0.6 * std::sin(a), 0.1 * (i % 2)));
    }
    for (int i = 0; i < 10; ++i) {
        double const a = 2 * kPi * i / 10;
        outer.push_back(m.add(1.3 * std::cos(a), 1.3 * std::sin(a), 0.2 * (i % 3)));
    }
    m.face({c, ring[0], ring[1]});
    m.face({c, ring[1], ring[2], ring[3]});
    m.face({c, ring[3], ring[4], ring[5], ring[6]});
    m.face({c, ring[6], ring[7], ring[8], ring[9], ring[0]});
    m.face({ring[1], ring[0], outer[0], outer[1]});
    m.face({ring[3], ring[2], ring[1], outer[1], outer[2], outer[3]});
    m.face({ring[6], ring[5], ring[4], ring[3], outer[3], outer[4], outer[5], outer[6]});
    m.face({ring[7], ring[6], outer[6], outer[7]});
    m.face({outer[7], outer[8], ring[7]});
    m.face({outer[8], ring[8], ring[7]});
    m.face({ring[0], ring[9], ring[8], outer[8], outer[9], outer[0]});
    return m;
}

Mesh icosahedron() {
    Mesh m;
    double const g = (1 + std::sqrt(5.0)) / 2;
    for (int axis = 0; axis < 3; ++axis)
        for (int s = 0; s < 4; ++s) {
            std::array<double, 3> p{};
            p[(axis + 1) % 3] = (s & 1 ? 1 : -1) * 0.6;
            p[(axis + 2) % 3] = (s & 2 ? 1 : -1) * 0.6 * g;
            m.add(p[0], p[1], p[2]);
        }
    // Faces are the triples of points at mutual distance 1.2, wound outwards.
    auto const near = [&](int a, int b) {
        double d = 0;
        for (int k = 0; k < 3; ++k) d += std::pow(double(m.points[a][k]) - m.points[b][k], 2);
        return d < 1.5;
    };
    for (int a = 0; a < 12; ++a)
        for (int b = a + 1; b < 12; ++b)
            for (int c = b + 1; c < 12; ++c) {
                if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
                auto const &p = m.points[a], &q = m.points[b], &r = m.points[c];
                double const det = p[0] * (q[1] * r[2] - q[2] * r[1]) -
                                   p[1] * (q[0] * r[2] - q[2] * r[0]) +
                                   p[2] * (q[0] * r[1] - q[1] * r[0]);
                if (det > 0) m.face({a, b, c});
                else m.face({a, c, b});
            }
    return m;
}

/// Fans every face from its first vertex, quads alternately from the second.
Mesh triangulate(Mesh mesh) {
    auto const all = mesh.faces();
    auto const holes = mesh.holes;
    mesh.counts.clear();
    mesh.indices.clear();
    mesh.holes.clear();
    for (std::size_t f = 0; f < all.size(); ++f) {
        auto face = all[f];
        if (face.size() == 4 && f % 2) std::rotate(face.begin(), face.begin() + 1, face.end());
        for (std::size_t i = 1; i + 1 < face.size(); ++i) {
            if (std::find(holes.begin(), holes.end(), int(f)) != holes.end())
                mesh.holes.push_back(mesh.faceCount());
            mesh.face({face[0], face[i], face[i + 1]});
        }
    }
    return mesh;
}

Mesh reversed(Mesh mesh) {
    auto all = mesh.faces();
    mesh.counts.clear();
    mesh.indices.clear();
    for (auto& face : all) {
        std::reverse(face.begin() + 1, face.end());
        mesh.face(face);
    }
    return mesh;
}

Mesh append(Mesh a, Mesh const& b, double dx, double dy, double dz) {
    int const base = a.vertexCount();
    for (auto const& p : b.points) a.add(p[0] + dx, p[1] + dy, p[2] + dz);
    for (auto face : b.faces()) {
        for (int& v : face) v += base;
        a.face(face);
    }
    return a;
}

/// Replaces vertex `from` by `to` in every face; `from` stays as a vertex of no face.
Mesh weld(Mesh mesh, int from, int to) {
    for (int& v : mesh.indices)
        if (v == from) v = to;
    return mesh;
}

/// Drops vertices of no face.
Mesh compact(Mesh mesh) {
    std::vector<int> map(mesh.points.size(), -1);
    for (int v : mesh.indices) map[v] = 0;
    std::vector<std::array<float, 3>> points;
    for (std::size_t v = 0; v < map.size(); ++v)
        if (map[v] == 0) {
            map[v] = static_cast<int>(points.size());
            points.push_back(mesh.points[v]);
        }
    mesh.points = points;
    for (int& v : mesh.indices) v = map[v];
    return mesh;
}

Mesh with(Mesh mesh, std::function<void(Mesh&)> const& change) {
    change(mesh);
    return mesh;
}

/// Random sharpness: mostly fractional, some infinite, some at the edges of the rules.
double sharpness(Random& random) {
    switch (random.below(8)) {
    case 0: return kInfinite;
    case 1: return 1 + random.below(3);
    case 2: return random.range(0.05, 0.95);
    default: return random.range(0.3, 5);
    }
}

/// A quad sheet, tube or torus; some quads are merged into n-gons or split into triangles.
Mesh generatedBase(Random& random, int kind, bool triangles) {
    int const n = 4 + random.below(3), k = 3 + random.below(3);
    Mesh m = kind == 0 ? grid(n, k) : kind == 1 ? tube(n, k) : kind == 2 ? torus(n, k + 1) : tube(n, k - 1, true);
    if (triangles) return triangulate(m);
    auto faces = m.faces();
    std::vector<std::vector<int>> out;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        auto& face = faces[f];
        int const roll = random.below(10);
        if (roll < 2 && face.size() == 4) {
            int const r = random.below(4);
            std::rotate(face.begin(), face.begin() + r, face.end());
            out.push_back({face[0], face[1], face[2]});
            out.push_back({face[0], face[2], face[3]});
        } else if (roll < 4 && f + 1 < faces.size() && face.size() == 4 && faces[f + 1].size() == 4 &&
                   face[1] == faces[f + 1][0] && face[2] == faces[f + 1][3]) {
            auto const& next = faces[f + 1];
            // A hexagon, or a pentagon and a triangle.
            if (random.chance(0.5)) {
                out.push_back({face[0], face[1], next[1], next[2], face[2], face[3]});
            } else {
                out.push_back({face[0], face[1], next[2], face[2], face[3]});
                out.push_back({face[1], next[1], next[2]});
            }
            ++f;
        } else {
            int const r = random.below(static_cast<int>(face.size()));
            std::rotate(face.begin(), face.begin() + r, face.end());
            out.push_back(face);
        }
    }
    m.counts.clear();
    m.indices.clear();
    for (auto const& face : out) m.face(face);
    return m;
}

Mesh generated(Random& random, int kind, bool triangles, bool creased) {
    Mesh m = generatedBase(random, kind, triangles);
    if (creased) {
        double const density = random.range(0.1, 0.35);
        for (auto const& [edge, faces] : m.edges())
            if (random.chance(density)) m.crease(edge.first, edge.second, sharpness(random));
        for (int v = 0; v < m.vertexCount(); ++v)
            if (random.chance(0.12)) m.corner(v, sharpness(random));
        for (int f = 0; f < m.faceCount(); ++f)
            if (random.chance(0.06)) m.holes.push_back(f);
    }
    return m;
}

// -------------------------------------------------------------------------------------- cases

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

class Builder {
public:
    explicit Builder(std::uint32_t seed) : seed_(seed) {}

    /// Adds one case for each boundary rule; they share points and face-varying values.
    Builder& add(std::string const& name, Mesh mesh, Scheme scheme, Uv uv,
                 std::vector<Boundary> const& boundaries = {EdgeAndCorner}, bool smooth = false) {
        return add(name, std::move(mesh), scheme, [&](Mesh& m, Random& r) { makeUv(m, uv, r); }, boundaries, smooth);
    }
    Builder& add(std::string const& name, Mesh mesh, Scheme scheme, std::function<void(Mesh&, Random&)> const& uv,
                 std::vector<Boundary> const& boundaries = {EdgeAndCorner}, bool smooth = false) {
        Random random(seed_++);
        perturb(mesh, random, 0.06);
        uv(mesh, random);
        static char const* const prefix[] = {"bilinear_", "catmark_", "loop_"};
        for (Boundary b : boundaries) cases.push_back({prefix[scheme] + name, mesh, scheme, b, smooth});
        return *this;
    }

    Cases cases;

private:
    std::uint32_t seed_;
};

std::vector<Boundary> const all = {BoundaryNone, EdgeOnly, EdgeAndCorner};
std::vector<Boundary> const both = {EdgeOnly, EdgeAndCorner};

Cases catmarkCases() {
    Builder b(100);
    b.add("cube", cube(), Catmark, Uv::Whole);
    b.add("cube_creases0", with(cube(), [](Mesh& m) { m.creaseLoop({4, 5, 7, 6}, kInfinite); }), Catmark, Uv::Island);
    b.add("cube_creases1", with(cube(), [](Mesh& m) {
              m.creaseLoop({4, 5, 7, 6}, 2.4);
              m.crease(0, 1, 0.7);
          }), Catmark, Uv::Cuts);
    b.add("cube_creases2", with(cube(), [](Mesh& m) {
              // Three and more sharp edges about a vertex that decay at different levels.
              m.crease(0, 1, 0.4), m.crease(0, 2, 1.0), m.crease(0, 4, 2.2);
              m.crease(7, 6, 3.5), m.crease(7, 5, 1.5), m.crease(7, 3, 1.5);
          }), Catmark, Uv::Islands);
    for (int i = 0; i < 5; ++i) {
        double const s[] = {kInfinite, 3.3, 1.0, 0.5, 1.7};
        b.add("cube_corner" + std::to_string(i), with(cube(), [&](Mesh& m) {
                  m.corner(0, s[i]), m.corner(7, s[(i + 2) % 5]);
                  if (i > 2) m.crease(0, 1, 1.2), m.crease(7, 3, 0.8), m.crease(7, 5, 2.5);
              }), Catmark, std::array{Uv::Whole, Uv::Island, Uv::Cuts, Uv::Darts, Uv::Islands}[i]);
    }
    b.add("dart", with(grid(4, 4), [](Mesh& m) {
              m.creaseLoop({2, 7, 12}, kInfinite, false);
              m.creaseLoop({22, 17}, 1.6, false);
          }), Catmark, Uv::Darts, both);
    b.add("edge", grid(3, 2), Catmark, Uv::Whole, all);
    b.add("edge_sharp_boundary", with(grid(3, 3), [](Mesh& m) {
              // Boundary edges made infinite by hand keep their faces when the rule is "none".
              m.creaseLoop({0, 1, 2, 3}, kInfinite, false);
              m.creaseLoop({12, 13, 14}, 2, false);
          }), Catmark, Uv::Island, {BoundaryNone, EdgeOnly});
    b.add("fan", fan(5, false, false), Catmark, Uv::Whole, all);
    b.add("fan_closed", fan(5, true, true), Catmark, Uv::Islands, both);
    b.add("flap", grid(2, 1), Catmark, Uv::Whole, both);
    b.add("flap2", with(tent(), [](Mesh& m) { m.crease(3, 4, 2.5); }), Catmark, Uv::Island);
    for (int i = 0; i < 5; ++i)
        b.add("fvar_bound" + std::to_string(i), grid(3 + i % 2, 3), Catmark,
              std::array{Uv::Whole, Uv::Island, Uv::Islands, Uv::Darts, Uv::Split}[i],
              i == 2 ? all : both);
    b.add("fvar_joined", grid(5, 4), Catmark, Uv::Joined, both);
    b.add("fvar_project0", torus(6, 4), Catmark, Uv::Cuts);
    b.add("gregory_test", with(append(cube(0.7), pyramid(5), 2.2, 0, 0), [](Mesh& m) { m.corner(4, 2); }), Catmark, Uv::Islands);
    b.add("hole_test1", with(grid(4, 3), [](Mesh& m) { m.holes = {5}; }), Catmark, Uv::Whole);
    b.add("hole_test2", with(grid(4, 4), [](Mesh& m) { m.holes = {5, 6, 9}; }), Catmark, Uv::Island, both);
    b.add("hole_test3", with(cube(), [](Mesh& m) { m.holes = {0, 3}, m.crease(4, 5, 1.5); }), Catmark, Uv::Cuts);
    b.add("hole_test4", with(nonquads(), [](Mesh& m) { m.holes = {1, 6, 8}; }), Catmark, Uv::Islands);
    b.add("lefthanded", reversed(with(grid(3, 3), [](Mesh& m) { m.crease(5, 6, 1.4); })), Catmark, Uv::Islands);
    b.add("righthanded", with(grid(3, 3), [](Mesh& m) { m.crease(5, 6, 1.4); }), Catmark, Uv::Islands);
    b.add("nonquads", nonquads(), Catmark, Uv::Islands, all);
    b.add("nonquads", nonquads(), Catmark, Uv::Cuts, {EdgeAndCorner}, true);
    b.add("pole8", pole(8), Catmark, Uv::Cuts);
    b.add("pole8", pole(8), Catmark, Uv::Island, {EdgeOnly}, true);
    b.add("pole32", pole(32, true), Catmark, Uv::Island);
    b.add("pyramid", pyramid(4), Catmark, Uv::Split);
    b.add("pyramid", pyramid(4), Catmark, Uv::Darts, {EdgeAndCorner}, true);
    b.add("pyramid_creases0", with(pyramid(4), [](Mesh& m) { m.creaseLoop({0, 1, 2, 3}, kInfinite); }), Catmark, Uv::Island);
    b.add("pyramid_creases1", with(pyramid(5), [](Mesh& m) { m.creaseLoop({0, 1, 2, 3, 4}, 2.3); }), Catmark, Uv::Islands);
    b.add("pyramid_creases2", with(pyramid(4), [](Mesh& m) {
              for (int i = 0; i < 4; ++i) m.crease(i, 4, 0.6 + 0.7 * i);
          }), Catmark, Uv::Cuts, {EdgeAndCorner}, true);
    b.add("single_crease", with(grid(4, 4), [](Mesh& m) { m.creaseLoop({10, 11, 12, 13, 14}, 3.4, false); }), Catmark, Uv::Island);
    b.add("square_hedit", grid(2, 2, 0.6), Catmark, Uv::Split);
    b.add("tent", tent(), Catmark, Uv::Whole, both);
    b.add("tent_creases0", with(tent(), [](Mesh& m) { m.creaseLoop({1, 4, 7}, kInfinite, false); }), Catmark, Uv::Island, both);
    b.add("tent_creases1", with(tent(), [](Mesh& m) { m.creaseLoop({1, 4, 7}, 1.8, false); }), Catmark, Uv::Cuts, both);
    b.add("torus", torus(4, 4), Catmark, Uv::Islands);
    b.add("torus_creases0", with(torus(5, 4), [](Mesh& m) {
              m.creaseLoop({0, 1, 2, 3, 4}, 2.6);
              m.creaseLoop({10, 11, 12}, 1.3, false);
          }), Catmark, Uv::Cuts);
    b.add("smoothtris0", triangulate(grid(3, 3)), Catmark, Uv::Island, both, true);
    b.add("smoothtris1", with(icosahedron(), [](Mesh& m) { m.crease(m.indices[0], m.indices[1], 0.5); }), Catmark, Uv::Islands, {EdgeAndCorner}, true);
    b.add("icosahedron", icosahedron(), Catmark, Uv::Islands);
    // Semi-sharp creases across two values of one vertex: the sharpness of one depends on the other.
    b.add("fvar_dependent0", with(grid(4, 4), [](Mesh& m) {
              m.creaseLoop({10, 11, 12, 13, 14}, 1.7, false), m.crease(7, 12, 0.8), m.crease(12, 17, 2.4);
          }), Catmark, Uv::Island, both);
    b.add("fvar_dependent1", with(grid(4, 4), [](Mesh& m) {
              for (int j = 1; j < 4; ++j) m.crease(5 * j + 2, 5 * j + 3, 0.6 * j);
              for (int j = 1; j < 4; ++j) m.corner(5 * j + 1, 0.8 * j);
          }), Catmark, Uv::Island);
    // Fan of quads about a vertex with one sharp edge inside a seam.
    b.add("fvar_dependent2", with(fan(6, true, true), [](Mesh& m) { m.crease(0, 1, 1.4), m.crease(0, 5, 0.7); }), Catmark, Uv::Island);
    // At a boundary vertex, one of two values in two separate runs of faces.
    b.add("fvar_disjoint", fan(5, true, false), Catmark, [](Mesh& m, Random& r) {
        cutUv(m, {{0, 3}, {0, 7}}, r);
        m.uvIndices[4 * 3] = m.uvIndices[4 * 4] = m.uvIndices[0];
    }, both);
    // A seam through vertex 12 of a sheet; the cut to vertex 13 leaves the value at 12 whole.
    b.add("fvar_inner_cut", grid(4, 4), Catmark, [](Mesh& m, Random& r) {
        cutUv(m, {{2, 7}, {7, 12}, {12, 17}, {17, 22}, {12, 13}, {13, 14}}, r);
        m.uvIndices[4 * 6 + 3] = m.uvIndices[4 * 10];
    }, both);
    for (int i = 0; i < 3; ++i) {
        Mesh m = grid(3, 3);
        m.crease(5, 6, 2.2), m.corner(10, 1.3), m.corner(0, 0.7), m.corner(3, 2.5), m.crease(1, 5, 1.1), m.crease(0, 1, 0.5);
        b.add("xord_interpolateboundary" + std::to_string(i), std::move(m), Catmark, Uv::Islands, {all[i]});
    }
    return std::move(b.cases);
}

Cases loopCases() {
    Builder b(300);
    b.add("cube", triangulate(cube()), Loop, Uv::Whole);
    b.add("cube_creases0", triangulate(with(cube(), [](Mesh& m) { m.creaseLoop({4, 5, 7, 6}, kInfinite); })), Loop, Uv::Island);
    b.add("cube_creases1", triangulate(with(cube(), [](Mesh& m) {
              m.creaseLoop({4, 5, 7, 6}, 2.4), m.crease(0, 1, 0.7), m.corner(3, 1.6);
          })), Loop, Uv::Cuts);
    b.add("icosahedron", icosahedron(), Loop, Uv::Islands);
    b.add("icos_infsharp", with(icosahedron(), [](Mesh& m) {
              m.creaseLoop({m.indices[0], m.indices[1], m.indices[2]}, kInfinite);
          }), Loop, Uv::Darts);
    b.add("icos_semisharp", with(icosahedron(), [](Mesh& m) {
              m.creaseLoop({m.indices[0], m.indices[1], m.indices[2]}, 1.4);
              m.crease(m.indices[30], m.indices[31], 0.6), m.corner(m.indices[32], 2.3);
          }), Loop, Uv::Cuts);
    b.add("pole8", triangulate(pole(8)), Loop, Uv::Cuts);
    b.add("pole32", triangulate(pole(32, true)), Loop, Uv::Island);
    b.add("saddle", triangulate(grid(4, 4, 0.8)), Loop, Uv::Islands, all);
    b.add("saddle_joined", triangulate(grid(4, 4, 0.8)), Loop, Uv::Joined, both);
    b.add("triangle", fan(1, false, false), Loop, Uv::Whole, all);
    b.add("fan", fan(5, false, false), Loop, Uv::Darts, both);
    b.add("tent_creases", triangulate(with(tent(), [](Mesh& m) { m.creaseLoop({1, 4, 7}, 1.8, false); })), Loop, Uv::Island, both);
    b.add("hole", triangulate(with(grid(3, 3), [](Mesh& m) { m.holes = {4}; })), Loop, Uv::Island);
    b.add("torus_creases", triangulate(with(torus(5, 4), [](Mesh& m) {
              m.creaseLoop({0, 1, 2, 3, 4}, 2.6), m.creaseLoop({10, 11, 12}, 1.3, false);
          })), Loop, Uv::Cuts);
    b.add("chaikin_shape", triangulate(with(grid(3, 3), [](Mesh& m) {
              m.crease(5, 6, 3), m.crease(6, 10, 2), m.crease(10, 9, 1), m.crease(9, 5, 0.5), m.corner(0, 2);
          })), Loop, Uv::Split, {EdgeOnly});
    return std::move(b.cases);
}

Cases bilinearCases() {
    Builder b(400);
    b.add("cube", cube(), Bilinear, Uv::Island);
    b.add("cube_creases", with(cube(), [](Mesh& m) { m.creaseLoop({4, 5, 7, 6}, 2.4), m.corner(0, 1.5); }), Bilinear, Uv::Cuts);
    b.add("nonquads", nonquads(), Bilinear, Uv::Islands, all);
    b.add("hole", with(grid(3, 3), [](Mesh& m) { m.holes = {4}; }), Bilinear, Uv::Darts, {BoundaryNone, EdgeAndCorner});
    b.add("pyramid", pyramid(5), Bilinear, Uv::Split, {EdgeAndCorner}, true);
    b.add("torus", torus(4, 3), Bilinear, Uv::Joined);
    return std::move(b.cases);
}

Cases generatedCases() {
    Builder b(500);
    Random random(20240607);
    std::array<Uv, 7> const uv = {Uv::Islands, Uv::Cuts, Uv::Darts, Uv::Joined, Uv::Island, Uv::Split, Uv::Whole};
    int n = 0;
    for (int i = 0; i < 20; ++i, ++n)
        b.add("generated" + std::to_string(n), generated(random, i % 4, false, i % 5 != 4), Catmark, uv[i % 7],
              {all[(i + 1) % 3]}, i % 3 == 1);
    for (int i = 0; i < 10; ++i, ++n)
        b.add("generated" + std::to_string(n), generated(random, i % 4, true, i % 5 != 4), Loop, uv[i % 7], {all[i % 3]});
    for (int i = 0; i < 3; ++i, ++n)
        b.add("generated" + std::to_string(n), generated(random, i, false, true), Bilinear, uv[i], {all[i]});
    return std::move(b.cases);
}

/// `n` quads on the edge 0-1.
Mesh edgeFan(int n) {
    Mesh m;
    m.add(0, 0, -0.5), m.add(0, 0, 0.5);
    for (int i = 0; i < n; ++i) {
        double const a = 2 * kPi * i / n;
        int const p = m.add(std::cos(a), std::sin(a), -0.5), q = m.add(std::cos(a), std::sin(a), 0.5);
        // Alternately wound, as a manifold pair would be.
        if (i % 2) m.face({0, 1, q, p});
        else m.face({1, 0, p, q});
    }
    return m;
}

/// A sheet with a fin along its middle row, over its whole length or the inner part of it.
Mesh finned(bool whole, int fins) {
    Mesh m = grid(4, 4, 0.2);
    int const first = whole ? 10 : 11, last = whole ? 14 : 13;
    for (int k = 0; k < fins; ++k) {
        int before = -1;
        for (int v = first; v <= last; ++v) {
            auto const p = m.points[v];
            int const top = m.add(p[0], p[1] + 0.3 * k, p[2] + 0.8);
            if (v > first) m.face({v - 1, v, top, before});
            before = top;
        }
    }
    return m;
}

/// A torus with a closed fin: every vertex of the row lies on an interior non-manifold crease.
Mesh finnedTorus() {
    Mesh m = torus(6, 4);
    for (int i = 0; i < 6; ++i) {
        auto const p = m.points[i];
        m.add(1.4 * p[0], 1.4 * p[1], p[2] + 0.3);
    }
    for (int i = 0; i < 6; ++i) m.face({i, (i + 1) % 6, 24 + (i + 1) % 6, 24 + i});
    return m;
}

/// Two closed fans, each welded along one edge to a sheet, opposite one another: two non-manifold
/// edges meet at a vertex without boundary, yet form no crease.
Mesh coned() {
    Mesh m = grid(2, 2, 0.2);
    for (int end : {1, 7}) {
        std::vector<int> rim = {end};
        for (int i = 1; i < 6; ++i) {
            auto const p = m.points[end];
            double const a = 2 * kPi * i / 6;
            rim.push_back(m.add(0.6 * std::sin(a), p[1] * (0.4 + 0.6 * std::cos(a)), 0.9 - 0.9 * std::cos(a)));
        }
        for (int i = 0; i < 6; i += 2) m.face({4, rim[i], rim[i + 1], rim[(i + 2) % 6]});
    }
    return m;
}

/// Quads about two poles which repeat the pole, so that each has an edge of no length.
Mesh quadPole(int n) {
    Mesh m = tube(n, 2);
    int const top = m.add(0, 0, 1.5), bottom = m.add(0, 0, -1.5);
    for (int i = 0; i < n; ++i) m.face({2 * n + i, 2 * n + (i + 1) % n, top, top});
    for (int i = 0; i < n; ++i) m.face({(i + 1) % n, i, bottom, bottom});
    return m;
}

Cases nonManifoldCases() {
    Builder b(700);
    b.add("nonman_edge3", edgeFan(3), Catmark, Uv::Whole, all);
    b.add("nonman_edge5", edgeFan(5), Catmark, Uv::Cuts, both);
    b.add("nonman_edge12", edgeFan(12), Catmark, Uv::Island);
    b.add("nonman_edge_creases", with(edgeFan(4), [](Mesh& m) { m.crease(0, 1, 1.5), m.corner(0, 0.5), m.crease(0, 2, 2.5); }), Catmark, Uv::Islands, both);
    b.add("nonman_bareverts", with(grid(2, 2), [](Mesh& m) { m.add(0, 0, 2), m.add(1, 0, 2); }), Catmark, Uv::Island);
    b.add("nonman_bowtie", compact(weld(append(grid(1, 1), grid(2, 1), 2, 2, 0), 4, 3)), Catmark, Uv::Whole, all);
    b.add("nonman_bowtie_fvar", compact(weld(append(grid(2, 2), grid(2, 2), 2, 2, 0), 9, 8)), Catmark, Uv::Split, both);
    b.add("nonman_cubes_vertex", compact(weld(append(cube(0.5), cube(0.5), 1, 1, 1), 8, 7)), Catmark, Uv::Cuts);
    b.add("nonman_cubes_edge", compact(weld(weld(append(cube(0.5), cube(0.5), 1, 0, 1), 8, 5), 10, 7)), Catmark, Uv::Islands);
    b.add("nonman_fans", compact(weld(append(fan(4, true, true), fan(3, true, false), 0, 0, 1.5), 9, 0)), Catmark, Uv::Islands, both);
    b.add("nonman_flipped", with(grid(2, 1), [](Mesh& m) { std::reverse(m.indices.begin() + 4, m.indices.end()); }), Catmark, Uv::Whole, both);
    b.add("nonman_double", with(grid(1, 1), [](Mesh& m) { m.face({3, 1, 0, 2}), m.face({0, 1, 3, 2}); }), Catmark, Uv::Whole);
    b.add("nonman_repeated", with(grid(2, 1), [](Mesh& m) {
              int const a = m.add(1.5, 0, 0.3);
              m.face({2, a, 2, 5});
          }), Catmark, Uv::Whole);
    b.add("nonman_fin", finned(true, 1), Catmark, Uv::Island, all);
    b.add("nonman_fin_inside", finned(false, 1), Catmark, Uv::Islands, both);
    b.add("nonman_fins", finned(true, 2), Catmark, Uv::Cuts);
    b.add("nonman_fin_torus", finnedTorus(), Catmark, Uv::Islands);
    b.add("nonman_fin_torus_creases", with(finnedTorus(), [](Mesh& m) { m.crease(1, 7, 1.5), m.corner(3, 0.8), m.corner(5, 2.5); }), Catmark, Uv::Darts);
    b.add("nonman_cones", coned(), Catmark, Uv::Island, both);
    b.add("nonman_quadpole8", quadPole(8), Catmark, Uv::Island);
    b.add("nonman_quadpole16", quadPole(16), Catmark, Uv::Whole);
    b.add("nonman_edge3", triangulate(edgeFan(3)), Loop, Uv::Whole, both);
    b.add("nonman_fin", triangulate(finned(true, 1)), Loop, Uv::Islands, {BoundaryNone, EdgeAndCorner});
    b.add("nonman_fin_torus", triangulate(finnedTorus()), Loop, Uv::Cuts);
    b.add("nonman_bowtie", compact(weld(append(fan(3, false, false), fan(4, false, true), 0, 0, 1), 5, 0)), Loop, Uv::Whole);
    b.add("nonman_edge5", edgeFan(5), Bilinear, Uv::Cuts);
    b.add("nonman_quadpole8", quadPole(8), Bilinear, Uv::Island);
    b.add("nonman_fin_inside", finned(false, 1), Bilinear, Uv::Islands);
    return std::move(b.cases);
}

// ----------------------------------------------------------------------------------- refining

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

template <int N>
std::vector<Value<double, N>> widen(std::vector<std::array<float, N>> const& from) {
    std::vector<Value<double, N>> to(from.size());
    for (std::size_t i = 0; i < from.size(); ++i)
        for (int k = 0; k < N; ++k) to[i].x[k] = from[i][k];
    return to;
}

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

Refiner makeRefiner(Description const& description, Scheme scheme, Boundary boundary, bool smooth, int mode) {
    static Sdc::SchemeType const schemes[] = {Sdc::SCHEME_BILINEAR, Sdc::SCHEME_CATMARK, Sdc::SCHEME_LOOP};
    static Sdc::Options::VtxBoundaryInterpolation const boundaries[] = {
        Sdc::Options::VTX_BOUNDARY_NONE, Sdc::Options::VTX_BOUNDARY_EDGE_ONLY,
        Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER};
    static Sdc::Options::FVarLinearInterpolation const modes[] = {
        Sdc::Options::FVAR_LINEAR_NONE,          Sdc::Options::FVAR_LINEAR_CORNERS_ONLY,
        Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1, Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2,
        Sdc::Options::FVAR_LINEAR_BOUNDARIES,    Sdc::Options::FVAR_LINEAR_ALL};
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(boundaries[boundary]);
    options.SetFVarLinearInterpolation(modes[mode]);
    options.SetTriangleSubdivision(smooth ? Sdc::Options::TRI_SUB_SMOOTH : Sdc::Options::TRI_SUB_CATMARK);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Refiner refiner(Factory::Create(description.d, Factory::Options(schemes[scheme], options)));
    if (!refiner) throw std::runtime_error("OpenSubdiv rejects the mesh");
    return refiner;
}

struct Refined {
    Refiner refiner;
    std::vector<std::vector<Point>> points;  // per level, 0 included
    std::vector<std::vector<Pair>> varying;
    std::vector<std::vector<Pair>> uvs;
};

Refined refine(Case const& c, Description const& description, int mode) {
    Refined r;
    r.refiner = makeRefiner(description, c.scheme, c.boundary, c.smoothTriangles, mode);
    Far::TopologyRefiner::UniformOptions uniform(kLevels);
    uniform.fullTopologyInLastLevel = true;
    uniform.orderVerticesFromFacesFirst = false;
    r.refiner->RefineUniform(uniform);
    Far::PrimvarRefinerReal<double> const primvars(*r.refiner);
    r.points.push_back(widen<3>(c.mesh.points));
    r.varying.push_back(widen<2>(c.mesh.varying));
    r.uvs.push_back(widen<2>(c.mesh.uvs));
    for (int level = 1; level <= kLevels; ++level) {
        auto const& topology = r.refiner->GetLevel(level);
        std::vector<Point> points(topology.GetNumVertices());
        std::vector<Pair> varying(topology.GetNumVertices()), uvs(topology.GetNumFVarValues(0));
        primvars.Interpolate(level, r.points.back(), points);
        primvars.InterpolateVarying(level, r.varying.back(), varying);
        primvars.InterpolateFaceVarying(level, r.uvs.back(), uvs);
        r.points.push_back(std::move(points));
        r.varying.push_back(std::move(varying));
        r.uvs.push_back(std::move(uvs));
    }
    return r;
}

// ------------------------------------------------------------------------------------ writing

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

void writeLevel(Writer& out, std::array<Refined, kModes> const& modes, std::vector<int> const& slots, int level) {
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

    int const samples = std::min(faces, kSamples[level - 1]);
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
    for (int level = 1; level <= kLevels; ++level) writeLevel(out, modes, slots, level);
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

void data(std::filesystem::path const& dir) {
    std::filesystem::create_directories(dir);
    writeFamily(dir, "catmark", catmarkCases());
    writeFamily(dir, "loop", loopCases());
    writeFamily(dir, "bilinear", bilinearCases());
    writeFamily(dir, "generated", generatedCases());
    writeFamily(dir, "nonmanifold", nonManifoldCases());
}

// -------------------------------------------------------------------------------------- bench

// The mesh is a text of numbers between blanks:
//
//   FACES FACE-VERTICES POINTS UVS
//   vertex count of each face, then the vertex indices, then the points (x y z each),
//   then a UV index per face-vertex, then the UVs (u v each)

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

}  // namespace

int main(int argc, char** argv) {
    try {
        std::string const mode = argc > 2 ? argv[1] : "";
        if (mode == "data") data(argv[2]);
        else if (mode == "bench") bench(argv[2], 15);
        else throw std::runtime_error("usage: golden data DIR | golden bench MESH");
    } catch (std::exception const& e) {
        std::cerr << "golden: " << e.what() << "\n";
        return 1;
    }
    return 0;
}
