//! Each garment of `tests/garments` has the trouble that its name tells of, so that no change of the script loses it.

use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use tailor_costume::{Builder, Recipe};
use tailor_mesh::{Garment, Values, glam};
use tailor_testing::garments::named;
use tailor_usd::{ReadOptions, Source};

/// A cage of quads with UVs.
struct Cage {
    input: Garment,
    faces: Vec<[usize; 4]>,
    /// The index of the UVs of each corner.
    uv_indices: Vec<[i32; 4]>,
    uvs: Vec<Vec2>,
}

/// A side of an edge: the face, its first corner there, and whether the points come in descending order.
#[derive(Clone, Copy)]
struct EdgeSide {
    face: usize,
    corner: usize,
    descends: bool,
}

impl Cage {
    fn open(name: &str) -> Self {
        let source = Source::open(&named(name), &ReadOptions::default()).unwrap();
        let input = source.garment().unwrap().0;
        assert!(input.face_vertex_counts.iter().all(|&count| count == 4), "all faces are quads");
        let st = input.primvars.iter().find(|p| p.name == "st").expect("UVs");
        let Values::F32(values) = &st.values else { panic!("UVs are floats") };
        let (faces, _) = input.face_vertex_indices.as_chunks::<4>();
        let (uv_indices, _) = st.indices.as_ref().expect("UVs are indexed").as_chunks::<4>();
        Self {
            faces: faces.iter().map(|face| face.map(|v| v as usize)).collect(),
            uv_indices: uv_indices.to_vec(),
            uvs: values.chunks_exact(2).map(Vec2::from_slice).collect(),
            input,
        }
    }

    fn edges(&self) -> BTreeMap<[usize; 2], Vec<EdgeSide>> {
        let mut edges: BTreeMap<_, Vec<EdgeSide>> = BTreeMap::new();
        for (face, corners) in self.faces.iter().enumerate() {
            for corner in 0..4 {
                let [a, b] = [corners[corner], corners[(corner + 1) % 4]];
                edges.entry([a.min(b), a.max(b)]).or_default().push(EdgeSide { face, corner, descends: a > b });
            }
        }
        edges
    }

    /// The indices of the UVs at an edge on one side of it, in the order of the points.
    fn uv_indices_at(&self, side: EdgeSide) -> [i32; 2] {
        let ends = [side.corner, (side.corner + 1) % 4].map(|corner| self.uv_indices[side.face][corner]);
        if side.descends { [ends[1], ends[0]] } else { ends }
    }

    fn uvs_at(&self, side: EdgeSide) -> [Vec2; 2] {
        self.uv_indices_at(side).map(|index| self.uvs[index as usize])
    }

    /// A number for each face, the same for those that are joined by an edge whose sides agree.
    fn parts(&self, are_joined: impl Fn(EdgeSide, EdgeSide) -> bool) -> Vec<usize> {
        let mut first: Vec<usize> = (0..self.faces.len()).collect();
        let edges = self.edges();
        let pairs: Vec<[usize; 2]> = edges
            .values()
            .filter(|sides| sides.len() == 2 && are_joined(sides[0], sides[1]))
            .map(|sides| [sides[0].face, sides[1].face])
            .collect();
        let mut has_changed = true;
        while has_changed {
            has_changed = false;
            for &[a, b] in &pairs {
                let least = first[a].min(first[b]);
                has_changed |= first[a] != first[b];
                (first[a], first[b]) = (least, least);
            }
        }
        first
    }

    fn components(&self) -> Vec<usize> {
        self.parts(|_, _| true)
    }

    fn shells(&self) -> Vec<usize> {
        self.parts(|a, b| self.uvs_at(a) == self.uvs_at(b))
    }

    fn area(&self, face: usize) -> f32 {
        let [a, b, c, d] = self.faces[face].map(|v| self.input.points[v]);
        0.5 * (c - a).cross(d - b).length()
    }

    fn uv_area(&self, face: usize) -> f32 {
        let [a, b, c, d] = self.uv_indices[face].map(|index| self.uvs[index as usize]);
        0.5 * (c - a).perp_dot(d - b)
    }

    fn mean_edge(&self) -> f32 {
        Builder::new(self.input.clone()).unwrap().mean_edge_length()
    }

    /// The area of an equilateral triangle of the length that a recipe without options asks for.
    fn triangle(&self) -> f32 {
        let builder = Builder::new(self.input.clone()).unwrap();
        let length = builder.resolve(&Recipe::default()).unwrap().sim.max_edge_length;
        0.25 * 3f32.sqrt() * length * length
    }
}

fn count<T: Ord>(all: impl IntoIterator<Item = T>) -> usize {
    all.into_iter().collect::<BTreeSet<_>>().len()
}

/// The sum of a value over the faces of each part.
fn sums(parts: &[usize], of: impl Fn(usize) -> f32) -> BTreeMap<usize, f32> {
    let mut sums = BTreeMap::new();
    parts.iter().enumerate().for_each(|(face, part)| *sums.entry(*part).or_default() += of(face));
    sums
}

#[test]
fn the_layered_suit_is_large_and_lies_in_layers() {
    let cage = Cage::open("layered_suit.usdc");
    assert!(cage.faces.len() > 2500, "{} faces", cage.faces.len());
    let components = cage.components();
    let [parts, shells] = [count(components.iter()), count(cage.shells())];
    assert!(parts >= 6 && shells >= 12, "{parts} components, {shells} shells");
    let centre = |face: usize| cage.faces[face].map(|v| cage.input.points[v]).iter().sum::<Vec3>() / 4.0;
    let centres: Vec<Vec3> = (0..cage.faces.len()).map(centre).collect();
    let edge = cage.mean_edge();
    let is_near = |a: usize, b: usize| components[a] != components[b] && centres[a].distance(centres[b]) < 0.6 * edge;
    let near = (0..centres.len()).filter(|&a| (0..centres.len()).any(|b| is_near(a, b))).count();
    assert!(near > 400, "{near} faces are beside another layer");
}

#[test]
fn narrow_sets_are_about_one_triangle_wide() {
    let cage = Cage::open("narrow_sets.usdc");
    let triangle = cage.triangle();
    let trims = cage.input.subsets.iter().filter(|s| s.family == "trims");
    let widths = trims.map(|set| {
        let faces: BTreeSet<usize> = set.indices.iter().map(|&f| f as usize).collect();
        let area: f32 = faces.iter().map(|&f| cage.area(f)).sum();
        let edges = cage.edges();
        let borders = edges.iter().filter(|(_, sides)| sides.iter().filter(|s| faces.contains(&s.face)).count() == 1);
        let border: f32 = borders.map(|([a, b], _)| cage.input.points[*a].distance(cage.input.points[*b])).sum();
        2.0 * area / border / (4.0 * triangle / 3f32.sqrt()).sqrt()
    });
    let narrow = widths.filter(|width| (0.25..2.0).contains(width)).count();
    assert!(narrow >= 5, "{narrow} sets");
}

#[test]
fn split_uv_indices_have_equal_values() {
    let cage = Cage::open("split_uv_indices.usdc");
    let edges = cage.edges();
    let inner = || edges.values().filter(|sides| sides.len() == 2).map(|sides| [sides[0], sides[1]]);
    let split = |[a, b]: [EdgeSide; 2]| cage.uv_indices_at(a) != cage.uv_indices_at(b);
    let cut = |[a, b]: [EdgeSide; 2]| cage.uvs_at(a) != cage.uvs_at(b);
    let [both, equal] = [true, false].map(|is_cut| inner().filter(|&pair| split(pair) && cut(pair) == is_cut).count());
    assert!(both >= 20 && equal >= 30, "{both} edges are cut, {equal} are split alone");
}

#[test]
fn tiny_shells_are_smaller_than_a_triangle() {
    let cage = Cage::open("tiny_shells.usdc");
    let areas = sums(&cage.shells(), |face| cage.area(face));
    let tiny = areas.values().filter(|area| **area < cage.triangle()).count();
    let large = areas.values().filter(|area| **area > 100.0 * cage.triangle()).count();
    assert!(tiny >= 30 && large >= 2, "{tiny} tiny shells, {large} large ones");
}

#[test]
fn doubled_points_are_two_borders_in_one_place() {
    let source = Source::open(&named("doubled_points.usdc"), &ReadOptions::default()).unwrap();
    let [seam] = source.seams() else { panic!("{} seams", source.seams().len()) };
    assert!(seam.gap == 0.0 && seam.edges >= 20, "{seam:?}");
    assert_eq!(count(Cage::open("doubled_points.usdc").components()), 1, "they are sewn");
}

#[test]
fn closed_pockets_have_no_border() {
    let cage = Cage::open("closed_pockets.usdc");
    let components = cage.components();
    let open: BTreeSet<usize> =
        cage.edges().values().filter(|sides| sides.len() == 1).map(|sides| components[sides[0].face]).collect();
    let closed = count(components.iter().filter(|part| !open.contains(part)));
    assert!(closed >= 6 && open.len() == 1, "{closed} closed components, {} open ones", open.len());
}

#[test]
fn shared_uvs_are_mirrored() {
    let cage = Cage::open("shared_uvs.usdc");
    let sorted = |face: &[i32; 4]| {
        let mut all = *face;
        all.sort_unstable();
        all
    };
    let faces = |sign: f32| {
        let own = (0..cage.faces.len()).filter(|&f| cage.uv_area(f).signum() == sign);
        own.map(|f| sorted(&cage.uv_indices[f])).collect::<BTreeSet<_>>()
    };
    let [left, right] = [1.0, -1.0].map(faces);
    assert!(left.len() > 150 && left == right, "{} faces, {} mirrored ones", left.len(), right.len());
}

#[test]
fn turned_faces_disagree_with_their_neighbours() {
    let cage = Cage::open("turned_faces.usdc");
    let edges = cage.edges();
    let disagree = edges.values().filter(|sides| sides.len() == 2 && sides[0].descends == sides[1].descends).count();
    assert!((20..edges.len() / 10).contains(&disagree), "{disagree} of {} edges", edges.len());
}
