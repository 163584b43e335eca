#include "cases.h"

#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace golden {

namespace {

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

}  // namespace

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

}  // namespace golden
