#include "mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

namespace golden {

void perturb(Mesh& mesh, Random& random, double amount) {
    for (auto& p : mesh.points) {
        for (float& c : p) c += static_cast<float>(random.range(-amount, amount));
        mesh.varying.push_back(
            {static_cast<float>(0.5 + p[0] * p[1] + 0.1 * random.unit()),
             static_cast<float>(p[2] * p[2] - p[0] + 0.1 * random.unit())});
    }
}

void cutUv(Mesh& mesh, std::set<Edge> const& cuts, Random& random, double joins) {
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

}  // namespace golden
