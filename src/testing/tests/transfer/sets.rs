//! Face and edge sets on the simulation mesh: where they are constraints and where they are not.

use super::sheet;
use crate::built::{Built, build, build_with};
use crate::nearest::Nearest;
use std::collections::BTreeSet;
use tailor::codes;
use tailor::sim::SimOptions;
use tailor::transfer::{Coverage, Locator, LocatorTables};
use tailor_costume::recipe::Layers;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Elements, Family, FamilyType, Garment, Mesh, SubsetInput, Values};
use tailor_testing::garments::{garments, named};
use tailor_usd::{ReadOptions, Source};

/// Without UVs, so that no border of a set is a constraint.
pub const FREE: [&str; 2] = ["sim.uvSet=", "sim.constraints="];

pub fn with_faces(mut input: Garment, name: &str, family: &str, indices: Vec<i32>) -> Garment {
    let (element_type, family) = ("face".into(), family.into());
    input.subsets.push(SubsetInput { name: name.into(), element_type, family, indices });
    input
}

pub fn faces(mesh: &Mesh, name: &str) -> Vec<FaceId> {
    match mesh.subset(name).map(|s| &s.elements) {
        Some(Elements::Faces(faces)) => faces.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

pub fn edges(mesh: &Mesh, name: &str) -> Vec<[VertexId; 2]> {
    match mesh.subset(name).map(|s| &s.elements) {
        Some(Elements::Edges(edges)) => edges.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

/// Samples of their own: ten times as many, from elsewhere.
fn independent(built: &Built) -> Coverage {
    let options = SimOptions { transfer_samples: 320, seed: 77, ..built.options().clone() };
    let product = built.product();
    let tables = LocatorTables::new(&product, built.garment.faces.len());
    Coverage::new(&Locator::new(&product, &tables), &options)
}

/// A garment as the command builds it, with more options.
pub fn garment(file: &std::path::Path, more: &[&str]) -> Built {
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let (input, mut warnings) = source.garment().unwrap_or_else(|e| panic!("{e}"));
    let mut layers = Layers::default();
    warnings.extend(layers.add_attributes(source.recipe().unwrap_or_else(|e| panic!("{e}"))));
    more.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    build_with(input, &layers)
}

/// The connected pieces of a garment: a number for each face.
fn pieces(garment: &Mesh) -> IdVec<FaceId, usize> {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let mut piece = IdVec::<FaceId, Option<usize>>::filled(None, t.faces.len());
    for (number, seed) in t.faces.ids().enumerate() {
        let mut reached = vec![seed];
        while let Some(face) = reached.pop() {
            if piece[face].is_none() {
                piece[face] = Some(number);
                let corners = t.faces.corners_of(face).map(|c| t.corner_edge[c]);
                reached.extend(corners.flat_map(|e| t.edge_corners.row(e).iter().map(|&c| t.faces.face_of(c))));
            }
        }
    }
    piece.iter().map(|p| p.unwrap_or(0)).collect()
}

/// Faces of sets that lie on another piece of cloth than the set has there, or over none of its faces.
fn on_another_layer(built: &Built, coverage: &Coverage) -> usize {
    let piece = pieces(&built.garment);
    let mut wrong = 0;
    for subset in built.garment.subsets.iter() {
        let Elements::Faces(source) = &subset.elements else { continue };
        let own: BTreeSet<FaceId> = source.iter().copied().collect();
        let own_pieces: BTreeSet<usize> = source.iter().map(|&f| piece[f]).collect();
        for face in faces(&built.products.sim, &subset.name) {
            let row = coverage.sources.row(face);
            let is_over = row.is_empty() || row.iter().any(|s| own.contains(&s.face));
            let is_on = row.iter().all(|s| own_pieces.contains(&piece[s.face]));
            wrong += usize::from(!(is_over && is_on));
        }
    }
    wrong
}

/// Whether the UVs are cut at all edges between the faces of a set and others.
fn is_between_seams(built: &Built, set: &[FaceId]) -> bool {
    let garment = &built.garment;
    let Some(uvs) = garment.primvar(&built.options().uv_set) else { return false };
    let Values::F32(values) = &uvs.values else { return false };
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let own: BTreeSet<FaceId> = set.iter().copied().collect();
    let uv = |corner: CornerId| &values[2 * uvs.row(corner.index())..][..2];
    // The UVs at both ends of an edge on one side of it, by vertex.
    let ends = |corner: &CornerId| {
        let mut ends = [*corner, t.faces.next(*corner)].map(|c| (t.faces.vertex(c), uv(c)));
        ends.sort_by_key(|end| end.0);
        ends
    };
    let is_joined = |edge: EdgeId| {
        let is_own = |c: &&CornerId| own.contains(&t.faces.face_of(**c));
        let (inside, outside): (Vec<_>, Vec<_>) = t.edge_corners.row(edge).iter().partition(is_own);
        inside.iter().any(|a| outside.iter().any(|b| ends(a) == ends(b)))
    };
    !t.edges.ids().any(is_joined)
}

#[test]
fn sets_between_seams_are_exact_on_garments() {
    for file in garments() {
        let built = garment(&file, &["sim.smallestShell=0"]);
        let coverage = independent(&built);
        for subset in built.garment.subsets.iter() {
            let Elements::Faces(source) = &subset.elements else { continue };
            if !is_between_seams(&built, source) {
                continue;
            }
            let own = coverage.overlap(source, &faces(&built.products.sim, &subset.name));
            assert!(own > 0.9999, "{file:?}: {} has {own} in common with its source", subset.name);
        }
        assert_eq!(on_another_layer(&built, &coverage), 0, "{file:?}: faces with a label of another layer");
    }
}

/// Sets of more than a hundredth of a garment that agree by less than 97 %, by how their names start, with the least that they may;
/// a number here may only be raised.
const BELOW: [(&str, &str, f64); 9] = [
    ("coat.usda", "sleeve_under_left", 0.9688),
    // Triangles cut across the rims of thin boxes.
    ("closed_pockets.usdc", "panel04", 0.9528),
    ("closed_pockets.usdc", "panel06", 0.9562),
    // About one triangle wide.
    ("narrow_sets.usdc", "panel02", 0.9469),
    ("narrow_sets.usdc", "placket", 0.8201),
    ("narrow_sets.usdc", "stripe", 0.8478),
    // Two to four triangles, less than a hundredth of the garment.
    ("female_elegantsuit01.usdc", "panel10", 0.6304),
    ("male_worksuit01.usdc", "panel12", 0.4219),
    ("tiny_shells.usdc", "panel", 0.5328),
];

/// Area that whole triangles may leave on the wrong side of a border, for each edge length of it, in squares of that length.
/// A line crosses some 2.3 triangles of 0.43 there, and leaves an eighth of each on its other side.
const MOST_BESIDE: f64 = 0.12;

/// The edges between the faces of a set and others, the lower vertex first.
pub fn border_edges(garment: &Mesh, set: &[FaceId]) -> BTreeSet<[VertexId; 2]> {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let own: BTreeSet<FaceId> = set.iter().copied().collect();
    let is_between = |e: &EdgeId| {
        let mut faces = t.edge_corners.row(*e).iter().map(|&c| own.contains(&t.faces.face_of(c)));
        let first = faces.next();
        faces.any(|is_own| Some(is_own) != first)
    };
    t.edges.ids().filter(is_between).map(|e| t.edges[e]).map(|[a, b]| [a.min(b), a.max(b)]).collect()
}

/// Number and length of the edges between the faces of a set and others.
fn border(garment: &Mesh, set: &[FaceId]) -> (usize, f64) {
    let length = |[a, b]: [VertexId; 2]| f64::from(garment.points[a].distance(garment.points[b]));
    border_edges(garment, set).into_iter().fold((0, 0.0), |(count, sum), edge| (count + 1, sum + length(edge)))
}

#[test]
fn sets_without_chains_follow_their_borders_on_garments() {
    let mut worse = Vec::new();
    for file in garments() {
        let built = garment(&file, &FREE);
        let coverage = independent(&built);
        let whole: f64 = coverage.source_area.iter().sum();
        let (mut met, mut missed) = (0.0, Vec::new());
        for subset in built.garment.subsets.iter() {
            let Elements::Faces(source) = &subset.elements else { continue };
            let own = faces(&built.products.sim, &subset.name);
            let agreement = coverage.agreement(source, &own);
            let area: f64 = source.iter().map(|&f| coverage.source_area[f]).sum();
            if agreement >= 0.97 {
                met += area;
            } else {
                // Whole triangles cannot follow a border more closely.
                let (count, sum) = border(&built.products.sim, &own);
                let beside = MOST_BESIDE * border(&built.garment, source).1 * sum / count.max(1) as f64;
                let least = 1.0 - beside / area;
                let known = BELOW.iter().find(|k| file.ends_with(k.0) && subset.name.starts_with(k.1)).map(|k| k.2);
                let least = match known {
                    known if area >= 0.01 * whole => least.max(known.unwrap_or(0.97)),
                    Some(known) => least.min(known),
                    None => least,
                };
                missed.push((subset.name.clone(), agreement, least));
            }
        }
        missed.retain(|(_, agreement, least)| agreement < least);
        worse.extend(
            missed.iter().map(|(name, own, least)| format!("{file:?}: {name} agrees by {own}, less than {least}")),
        );
        assert!(met > 0.5 * whole);
        assert_eq!(on_another_layer(&built, &coverage), 0, "{file:?}: faces with a label of another layer");
    }
    assert!(worse.is_empty(), "{}", worse.join("\n"));
}

/// The faces of a set and the area of its source in each of them and of the rest.
fn parts(source: &[FaceId], coverage: &Coverage) -> Vec<(FaceId, f64, f64)> {
    let own: BTreeSet<FaceId> = source.iter().copied().collect();
    let part = |f: usize| {
        let face = FaceId::new(f);
        let (mut inside, mut outside) = (0.0, 0.0);
        for share in coverage.sources.row(face) {
            *(if own.contains(&share.face) { &mut inside } else { &mut outside }) += f64::from(share.area);
        }
        (face, inside, outside)
    };
    (0..coverage.sources.rows()).map(part).filter(|p| p.1 > 0.0).collect()
}

/// The sets that a warning calls too narrow.
fn told_blurred(built: &Built) -> Vec<&String> {
    built.warnings.iter().filter(|w| w.code == codes::SETS_BLURRED).flat_map(|w| &w.names).collect()
}

#[test]
fn labels_on_garments_are_the_best_that_whole_triangles_allow() {
    for file in garments() {
        for length in [None, Some(0.5)] {
            let whole = garment(&file, &FREE);
            let built = match length {
                None => whole,
                Some(scale) => {
                    let (min, max) = (whole.options().min_edge_length, whole.options().max_edge_length);
                    let lengths = [("min", min), ("max", max)].map(|(k, l)| format!("sim.{k}EdgeLength={}", scale * l));
                    garment(&file, &[FREE[0], FREE[1], &lengths[0], &lengths[1]])
                }
            };
            let coverage = independent(&built);
            let told = told_blurred(&built);
            for subset in built.garment.subsets.iter() {
                let Elements::Faces(source) = &subset.elements else { continue };
                let set = faces(&built.products.sim, &subset.name);
                let is_in: BTreeSet<FaceId> = set.iter().copied().collect();
                let parts = parts(source, &coverage);
                let area: f64 = parts.iter().map(|p| p.1).sum();
                let wrong: f64 = parts.iter().map(|(f, i, o)| if is_in.contains(f) { *o } else { *i }).sum();
                let least: f64 = parts.iter().map(|(_, i, o)| i.min(*o)).sum();
                // Faces on the border take the wrong side where the count of samples is close.
                let both: f64 = parts.iter().filter(|p| p.2 > 0.0).map(|p| p.1 + p.2).sum();
                assert!(
                    wrong <= least + 0.1 * both,
                    "{file:?}: {} is off by {wrong} of {area}, {least} would do",
                    subset.name
                );
                let agreement = coverage.agreement(source, &set);
                let is_told = told.contains(&&subset.name);
                assert!(
                    agreement > 0.96 || is_told || set.is_empty(),
                    "{file:?}: {} agrees by {agreement}",
                    subset.name
                );
                assert!(agreement < 0.98 || !is_told, "{file:?}: {} agrees by {agreement}", subset.name);
            }
        }
    }
}

#[test]
fn sets_about_one_triangle_wide_are_told() {
    let built = garment(&named("narrow_sets.usdc"), &FREE);
    let told = told_blurred(&built);
    for name in ["stripe_2", "stripe_6", "stripe_10", "placket_0", "placket_10", "placket_20"] {
        assert!(told.iter().any(|told| *told == name), "{name} is not told: {told:?}");
    }
    for name in ["panel00", "panel01"] {
        assert!(told.iter().all(|told| *told != name), "{name} is large");
    }
}

/// Share of a triangle's area that makes no difference.
const SLIVER: f32 = 0.02;

#[test]
fn what_differs_on_garments_lies_within_an_edge_of_the_border() {
    for file in garments() {
        let built = garment(&file, &FREE);
        let (coverage, product) = (independent(&built), built.product());
        let base = &product.baseline;
        let t = &base.topology;
        for subset in built.garment.subsets.iter() {
            let Elements::Faces(source) = &subset.elements else { continue };
            let own: BTreeSet<FaceId> = source.iter().copied().collect();
            let sides = |e| t.edge_corners.row(e).iter().map(|&c| own.contains(&base.source_face[t.faces.face_of(c)]));
            let is_border = |e: &EdgeId| sides(*e).collect::<BTreeSet<_>>().len() == 2;
            let segment = |e: EdgeId| t.edges[e].map(|v| base.points[v]);
            let border: Vec<_> = t.edges.ids().filter(is_border).map(segment).map(|[a, b]| [a, b, b]).collect();
            let border = Nearest::new(border);
            let set: BTreeSet<FaceId> = faces(&built.products.sim, &subset.name).into_iter().collect();
            for (face, row) in (0..product.triangles.len()).map(FaceId::new).map(|f| (f, coverage.sources.row(f))) {
                // The mesh cuts off a fold that is thinner than its edges, and then a sliver of the other side is over it.
                let area = |of: &dyn Fn(FaceId) -> bool| row.iter().filter(|s| of(s.face)).map(|s| s.area).sum::<f32>();
                if area(&|f| own.contains(&f) != set.contains(&face)) <= SLIVER * area(&|_| true) {
                    continue;
                }
                let [a, b, c] = product.triangles[face.index()].map(|v| product.points[v]);
                let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let off = [a, b, c].map(|p| border.find(p).1).into_iter().fold(0.0, f32::max);
                assert!(
                    off <= edge,
                    "{file:?}: {face:?} of {} is {off} from its border, its edges are {edge}",
                    subset.name
                );
            }
        }
    }
}

#[test]
fn a_partition_stays_one_and_overlapping_sets_are_counted_apart() {
    let mut input = sheet(12, 12);
    let third = |k: usize| (0..144).filter(|i| (i % 12) / 4 == k).map(|i| i as i32).collect::<Vec<_>>();
    for k in 0..3 {
        input = with_faces(input, &format!("third{k}"), "thirds", third(k));
    }
    input.families = vec![Family { name: "thirds".into(), kind: FamilyType::Partition }];
    input = with_faces(input, "half", "", (0..72).collect());
    input = with_faces(input, "middle", "", (36..108).collect());
    input = with_faces(input, "none", "", Vec::new());
    input = with_faces(input, "all", "", (0..144).collect());
    input = with_faces(input, "one", "", vec![77]);
    input = with_faces(input, "along the border", "", (0..12).collect());
    for length in ["0.3", "0.8"] {
        let built = build(input.clone(), &["sim.uvSet=", &format!("sim.maxEdgeLength={length}")]);
        let mesh = &built.products.sim;
        let mut uses = vec![0; mesh.faces.len()];
        (0..3).flat_map(|k| faces(mesh, &format!("third{k}"))).for_each(|f| uses[f.index()] += 1);
        assert!(uses.iter().all(|&n| n == 1), "the thirds are a partition");
        assert_eq!(faces(mesh, "none"), []);
        assert_eq!(faces(mesh, "all").len(), mesh.faces.len());
        assert!(!faces(mesh, "one").is_empty(), "a set of one face, larger than the triangles");
        let coverage = independent(&built);
        for subset in built.garment.subsets.iter() {
            let Elements::Faces(source) = &subset.elements else { continue };
            // At the longer length the set is of some three triangles, and most of those that meet it cross its border.
            let least = match (subset.name.as_str(), length) {
                ("one", "0.8") => 0.1,
                ("one", _) => 0.6,
                ("along the border", "0.8") => 0.5,
                ("along the border", _) => 0.8,
                _ => 0.9,
            };
            let own = coverage.overlap(source, &faces(mesh, &subset.name));
            assert!(own > least, "{} at {length}: {own}", subset.name);
        }
    }
}

#[test]
fn five_hundred_sets_and_sets_named_like_ours() {
    let mut input = sheet(25, 20);
    for i in 0..500 {
        input = with_faces(input, &format!("set{i}"), "", vec![i, (i + 1) % 500]);
    }
    for name in ["sim", "render", "model"] {
        input = with_faces(input, name, "", vec![7, 8]);
    }
    input = with_faces(input, "tailorBorders", "", vec![3]);
    input = with_faces(input, "tailorCreases", "", vec![4]);
    input.crease_indices = vec![30, 31, 32];
    input.crease_lengths = vec![3];
    input.crease_sharpnesses = vec![2.5];
    let built = build(input, &["sim.maxEdgeLength=0.5"]);
    let mesh = &built.products.sim;
    assert!((0..500).all(|i| !faces(mesh, &format!("set{i}")).is_empty()));
    assert!(["sim", "render", "model"].iter().all(|name| !faces(mesh, name).is_empty()));
    let names: BTreeSet<&str> = mesh.subsets.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names.len(), mesh.subsets.len(), "each name once");
    assert!(!edges(mesh, "tailorBorders_2").is_empty());
    let creases = mesh.subset("tailorCreases_2").expect("the creases under a free name");
    assert_eq!((creases.sharpness, creases.family.as_str()), (Some(2.5), "tailorCreases"));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let built = garment(&named("coat.usda"), &["sim.constraints="]);
    let product = built.product();
    let at = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| built.transferred(&product, built.options()).mesh)
    };
    let (one, four) = (at(1), at(4));
    assert_eq!(one.primvars, four.primvars);
    assert_eq!(one.subsets, four.subsets);
}

#[test]
fn an_unused_point_far_away_is_at_the_nearest_vertex() {
    let mut input = sheet(4, 4);
    input.primvars.clear();
    input.points.push(glam::Vec3::new(1e6, -1e6, 0.0));
    let (name, element_type, family) = ("far".into(), "point".into(), String::new());
    input.subsets.push(SubsetInput { name, element_type, family, indices: vec![25] });
    let built = build(input, &["sim.uvSet=", "sim.maxEdgeLength=0.5"]);
    let mesh = &built.products.sim;
    let Some(Elements::Points(found)) = mesh.subset("far").map(|s| &s.elements) else { panic!("a set of points") };
    let corner = mesh
        .points
        .ids()
        .max_by(|&a, &b| (mesh.points[a].x - mesh.points[a].y).total_cmp(&(mesh.points[b].x - mesh.points[b].y)));
    assert_eq!(found.as_slice(), [corner.expect("points")]);
}
