// Remeshes an OBJ file by CGAL's isotropic_remeshing, for peers.py:
//
//     cgal IN.obj OUT.obj ROUNDS
//
// Edges of `l` lines and borders are constrained. The first line of OUT.obj is what remeshing alone took.

#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Vertex = Mesh::Vertex_index;
namespace remeshing = CGAL::Polygon_mesh_processing;

int main(int count, char** arguments)
{
    if (count != 4) {
        std::cerr << "usage: cgal IN.obj OUT.obj ROUNDS\n";
        return 2;
    }
    Mesh mesh;
    double length = 0.0;
    std::vector<std::array<std::size_t, 2>> lines;
    std::ifstream in(arguments[1]);
    for (std::string row; std::getline(in, row);) {
        std::istringstream words(row);
        std::string kind;
        words >> kind;
        if (kind == "#") {
            words >> kind >> length;
        } else if (kind == "v") {
            double x, y, z;
            words >> x >> y >> z;
            mesh.add_vertex(Point(x, y, z));
        } else if (kind == "f" || kind == "l") {
            std::array<std::size_t, 3> given = {1, 1, 1};
            for (std::size_t k = 0; k < (kind == "f" ? 3 : 2); ++k)
                words >> given[k];
            if (kind == "l")
                lines.push_back({given[0] - 1, given[1] - 1});
            else if (mesh.add_face(Vertex(given[0] - 1), Vertex(given[1] - 1), Vertex(given[2] - 1)) == Mesh::null_face())
                std::cerr << "a face that CGAL does not take: " << row << '\n';
        }
    }
    auto is_constrained = mesh.add_property_map<Mesh::Edge_index, bool>("e:is_constrained", false).first;
    for (const auto& [a, b] : lines) {
        const auto halfedge = mesh.halfedge(Vertex(a), Vertex(b));
        if (halfedge != Mesh::null_halfedge())
            is_constrained[mesh.edge(halfedge)] = true;
    }
    for (const auto edge : mesh.edges())
        if (mesh.is_border(edge))
            is_constrained[edge] = true;

    const auto start = std::chrono::steady_clock::now();
    // Constrained edges that are longer than 4/3 of the length must be split before, as its manual says.
    remeshing::split_long_edges(mesh.edges(), length, mesh, remeshing::parameters::edge_is_constrained_map(is_constrained));
    remeshing::isotropic_remeshing(mesh.faces(), length, mesh,
                                   remeshing::parameters::number_of_iterations(std::stoi(arguments[3]))
                                       .edge_is_constrained_map(is_constrained)
                                       .protect_constraints(false)
                                       .collapse_constraints(true));
    const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;

    mesh.collect_garbage();
    std::ofstream out(arguments[2]);
    out << "# milliseconds " << taken.count() << '\n';
    out.precision(9);
    for (const auto vertex : mesh.vertices())
        out << "v " << mesh.point(vertex) << '\n';
    for (const auto face : mesh.faces()) {
        out << 'f';
        for (const auto vertex : mesh.vertices_around_face(mesh.halfedge(face)))
            out << ' ' << vertex.idx() + 1;
        out << '\n';
    }
    return out ? 0 : 1;
}
