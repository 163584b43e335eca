#include "shapes.h"

#include <algorithm>
#include <cmath>

namespace golden {

Mesh cube(double size) {
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

Mesh grid(int nx, int ny, double bump) {
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

Mesh tube(int n, int rows, bool caps) {
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

Mesh pole(int n, bool open) {
    Mesh m = tube(n, 1);
    int const top = m.add(0, 0, 1.5);
    for (int i = 0; i < n; ++i) m.face({n + i, n + (i + 1) % n, top});
    if (!open) {
        int const bottom = m.add(0, 0, -1.5);
        for (int i = 0; i < n; ++i) m.face({(i + 1) % n, i, bottom});
    }
    return m;
}

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

Mesh tent() {
    Mesh m = grid(2, 2, 0);
    for (int j = 0; j < 3; ++j) m.points[3 * j + 1][2] = 1;
    return m;
}

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

Mesh weld(Mesh mesh, int from, int to) {
    for (int& v : mesh.indices)
        if (v == from) v = to;
    return mesh;
}

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

namespace {

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

}  // namespace

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

}  // namespace golden
