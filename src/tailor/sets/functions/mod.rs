//! The functions of set expressions. A new one is a row of this table.

mod edges;
pub mod faces;
mod mirror;
mod paths;
pub mod picked;
pub mod points;

pub use picked::{checksum, painted_expression, painted_weights};

use super::evaluate::Function;

macro_rules! functions {
    ($($usage:literal $name:ident $arguments:expr => $gives:ident by $evaluate:path: $meaning:literal;)+) => {
        /// All functions, in the order of the documents.
        pub const FUNCTIONS: &[Function] = &[$(Function {
            name: stringify!($name),
            usage: $usage,
            gives: stringify!($gives),
            meaning: $meaning,
            arguments: $arguments,
            evaluate: $evaluate,
        }),+];
    };
}

functions! {
    "borders" borders [0, 0] => edges by edges::borders:
        "Edges of one face";
    "uvSeams, uvSeams(st)" uvSeams [0, 1] => edges by edges::uv_seams:
        "Edges at which a UV set is cut: that of sim.uvSet, or the one that is named";
    "creases, creases(sharpness)" creases [0, 1] => edges by edges::creases:
        "Creases, of a sharpness or more";
    "featureLines, featureLines(degrees)" featureLines [0, 1] => edges by edges::feature_lines:
        "Edges at which two faces turn by more than an angle, 45 degrees if none is given";
    "border(faces)" border [1, 1] => edges by edges::border:
        "The border of a set of faces, which is at its left";
    "between(faces, faces)" between [2, 2] => edges by edges::between:
        "Edges between two sets of faces, the first at their left";
    "regions(primvar)" regions [1, 1] => edges by edges::regions:
        "Edges between faces with other values of a uniform primvar";
    "edges, edges(set)" edges [0, 1] => edges by edges::edges:
        "All edges, the edges of a set of faces, or the edges with both ends in a set of points";
    "faces, faces(set)" faces [0, 1] => faces by faces::faces:
        "All faces, the faces with an edge in a set of edges, or the faces with all points in a set of points";
    "material(name)" material [1, 1] => faces by faces::material:
        "Faces with a material, by the name of its prim";
    "sameMaterial(faces)" sameMaterial [1, 1] => faces by faces::same_material:
        "A set of faces with all faces that have one of its materials";
    "value(primvar), value(primvar, value)" value [1, 2] => elements by faces::value:
        "Faces of a uniform primvar, or points of a vertex primvar, with a value; without one, those that are true or not 0";
    "weight(primvar), weight(primvar, number)" weight [1, 2] => elements by points::weight:
        "Points of a float vertex primvar, such as a vertex group, or faces of a uniform one, above a number; 0.5 if none is given";
    "rings(set), rings(set, count)" rings [1, 2] => faces by faces::rings:
        "Faces within so many rings around a set; a ring around faces is beside them and includes them";
    "within(edges, length)" within [2, 2] => faces by faces::within:
        "Faces around a set of edges whose centres are within a length of it, such as 2cm, across the surface";
    "uvShells, uvShells(st)" uvShells [0, 1] => faces by faces::uv_shells:
        "The faces of a UV set, whose pieces are its shells";
    "shell(faces), shell(faces, st)" shell [1, 2] => faces by faces::shell:
        "The UV shells that have a face of a set";
    "udim(tile), udim(tile, st)" udim [1, 2] => faces by faces::udim:
        "Faces whose UVs have their centre in a tile, such as 1001";
    "points, points(set)" points [0, 1] => points by points::points:
        "All points, or the points of a set of edges or faces";
    "loops(edges), loops(edges, st)" loops [1, 2] => edges by paths::loops:
        "The border, UV seam, crease or edge loop through each edge: seams and creases up to where three meet, edge loops through vertices of four quads";
    "onward(edges), onward(edges, st)" onward [1, 2] => edges by paths::onward:
        "A set of edges with what goes on straight at its ends, through junctions: the border, UV seam, crease or edge loop there";
    "path(set, set)" path [2, 2] => elements by paths::path:
        "The path between two sets of edges or of faces, with those that it begins and ends with; edges keep to borders, UV seams and creases, and go straight on, where that is up to twice as long";
    "mirror(set)" mirror [1, 1] => elements by mirror::mirror:
        "The elements on the other side of the plane of symmetry";
    "pickedEdges(checksum, numbers)" pickedEdges [2, 2] => edges by picked::edges:
        "Edges by the numbers of their points, such as \"4-5-6, 9-8\", of the mesh with this checksum; the preview writes them";
    "pickedFaces(checksum, numbers)" pickedFaces [2, 2] => faces by picked::faces:
        "Faces by their numbers, such as \"4-6, 9\", of the mesh with this checksum; the preview writes them";
    "painted(checksum, weights)" painted [2, 2] => points by picked::painted:
        "Points by their weights, two hexadecimal digits each, of the mesh with this checksum: those above 0; options that take weights have them. The preview writes them";
}
