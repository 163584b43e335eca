// Meshes that are made by code, and their face-varying values.

#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace golden {

using Edge = std::pair<int, int>;

constexpr float kInfinite = 10.0f;

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

inline Edge key(int a, int b) { return a < b ? Edge(a, b) : Edge(b, a); }

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
void perturb(Mesh& mesh, Random& random, double amount);

/// Merges the corners around each vertex across every edge that is not cut; each class of corners
/// becomes one face-varying value. A cut that ends inside the mesh is a dart.
void cutUv(Mesh& mesh, std::set<Edge> const& cuts, Random& random, double joins = 0);

enum class Uv {
    Whole,    ///< one value per vertex
    Island,   ///< two islands of faces
    Islands,  ///< about four islands, so that some corners meet more than two values
    Darts,    ///< few cut edges, most of which end inside
    Cuts,     ///< a third of the edges cut
    Split,    ///< every face on its own
    Joined,   ///< islands, with values shared between separate runs
};

/// Cuts the mesh in a way and gives its corners face-varying values.
void makeUv(Mesh& mesh, Uv kind, Random& random);


}  // namespace golden
