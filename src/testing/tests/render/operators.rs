//! Seams and stacks of operators: where the surface is, and that it is sound.

use super::cloth::{checked, limit, path, sheet, torus, tube, with_faces};
use crate::nearest::Nearest;
use crate::operators::{rendered, stack, try_rendered};
use glam::Vec3;
use std::collections::BTreeSet;
use tailor::codes;
use tailor_mesh::connectivity::{IdVec, Topology, VertexId};
use tailor_mesh::error::Warning;
use tailor_mesh::garment::{Elements, Garment, Mesh, Orientation, Scheme};
use tailor_testing::sheets::with_edges;

/// Heights are as asked to this share of the width or the amount.
pub const EXACT: f32 = 0.02;

/// The limit surface of a garment as a dense cloud of points with normals.
pub struct Surface {
    points: IdVec<VertexId, Vec3>,
    normals: IdVec<VertexId, Vec3>,
    tree: Nearest,
}

impl Surface {
    /// The surface of a garment with options.
    pub fn new<T: AsRef<str>>(garment: &Mesh, options: &[T]) -> Self {
        let (fine, _) = rendered(garment, options);
        Self::of(&limit(&fine), &fine)
    }

    /// The surface of a fine mesh at some points.
    pub fn of(points: &IdVec<VertexId, Vec3>, fine: &Mesh) -> Self {
        let points = points.clone();
        let mut normals = IdVec::filled(Vec3::ZERO, points.len());
        for corner in fine.faces.corners().ids() {
            let at = |c| points[fine.faces.vertex(c)];
            let normal = (at(fine.faces.next(corner)) - at(corner)).cross(at(fine.faces.prev(corner)) - at(corner));
            normals[fine.faces.vertex(corner)] += normal;
        }
        normals.iter_mut().for_each(|n| *n = n.normalize());
        let tree = Nearest::new(points.iter().map(|&p| [p; 3]).collect());
        Self { points, normals, tree }
    }

    /// Height over the surface along its normal, with the surface's curve from the nearest point on left out.
    pub fn height(&self, place: Vec3) -> f32 {
        let nearest = VertexId::new(self.tree.find(place).0);
        (place - self.points[nearest]).dot(self.normals[nearest])
    }
}

pub fn vertices_of(mesh: &Mesh, name: &str) -> BTreeSet<VertexId> {
    match &mesh.subset(name).unwrap_or_else(|| panic!("{name} is there")).elements {
        Elements::Edges(edges) => edges.iter().flatten().copied().collect(),
        Elements::Faces(faces) => faces.iter().flat_map(|&f| mesh.faces.vertices_of(f)).copied().collect(),
        Elements::Points(points) => points.iter().copied().collect(),
    }
}

pub fn shapes() -> Vec<(&'static str, Garment)> {
    let plane = with_edges(sheet(8), "ring", &path(&[36, 37, 38, 39, 40, 41, 42, 43, 44]));
    vec![("plane", plane), ("cylinder", tube()), ("torus", torus())]
}

#[test]
fn the_centre_line_is_at_the_offset() {
    for (name, input) in shapes() {
        let garment = checked(input);
        let surface = Surface::new(&garment, &["render.level=4"]);
        for (offset, more) in [
            (-0.06, "seam.s.depth=0"),
            (0.08, "seam.s.depth=0"),
            (-0.06, "seam.s.depth=0.03"),
            (0.06, "seam.s.asymmetry=0.5"),
            (-0.06, "seam.s.asymmetry=-1"),
        ] {
            let offset_key = format!("seam.s.normalOffset={offset}");
            let options = ["seam.s.edges=ring", "seam.s.width=0.3", &offset_key, more, "render.level=3"];
            let (mesh, _) = rendered(&garment, &options);
            let places = limit(&mesh);
            let heights: Vec<f32> = vertices_of(&mesh, "ring").iter().map(|&v| surface.height(places[v])).collect();
            let off = heights.iter().map(|h| (h - offset).abs()).fold(0.0, f32::max);
            assert!(off < EXACT * 0.3, "{name}, {options:?}: off by {} of the width", off / 0.3);
        }
    }
}

#[test]
fn the_faces_of_a_seam_are_as_wide_as_asked() {
    let garment = checked(shapes().remove(0).1);
    for (asymmetry, depth) in [(0.0, 0.0), (0.5, 0.0), (-0.8, 0.0), (0.0, 0.03), (0.5, -0.02)] {
        let mut options: Vec<String> = [
            "seam.s.edges=ring",
            "seam.s.width=0.4",
            "seam.s.normalOffset=-0.1",
            "render.level=3",
            "render.faceSets=true",
        ]
        .map(str::to_owned)
        .into();
        options.extend([format!("seam.s.asymmetry={asymmetry}"), format!("seam.s.depth={depth}")]);
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let (mesh, _) = rendered(&garment, &options);
        let places = limit(&mesh);
        let Some(Elements::Faces(faces)) = mesh.subset("s_seam").map(|s| &s.elements) else { panic!("a set") };
        let within = faces.iter().flat_map(|&f| mesh.faces.vertices_of(f)).map(|&v| places[v]);
        // The line runs to the right of x at y = 4, so its left is above it.
        let across: Vec<f32> =
            within.filter(|p| (p.x - 4.5).abs() < 0.3 && (p.y - 4.0).abs() < 1.0).map(|p| p.y - 4.0).collect();
        let sides = [across.iter().copied().fold(0.0, f32::max), -across.iter().copied().fold(0.0, f32::min)];
        let asked = [0.2 * (1.0 - asymmetry), 0.2 * (1.0 + asymmetry)];
        for (side, asked) in sides.into_iter().zip(asked) {
            assert!((side - asked).abs() < EXACT * 0.4, "{options:?}: {sides:?}, asked for {asked}");
        }
    }
}

#[test]
fn a_seam_keeps_its_width() {
    // On a plane the surface is untouched from the width on, except for the shoulder's overshoot.
    let garment = checked(shapes().remove(0).1);
    for (asymmetry, sides) in [("0", [0.2, 0.2]), ("0.5", [0.1, 0.3])] {
        let asymmetry = format!("seam.s.asymmetry={asymmetry}");
        let options =
            ["seam.s.edges=ring", "seam.s.width=0.4", "seam.s.normalOffset=-0.1", &asymmetry, "render.level=4"];
        let (mesh, _) = rendered(&garment, &options);
        let places = limit(&mesh);
        // The line runs to the right of x, so its left is above it.
        for (side, width) in [(1.0, sides[0]), (-1.0, sides[1])] {
            let across = |p: &&Vec3| (p.x - 4.5).abs() < 0.3 && (0.0..1.0).contains(&(side * (p.y - 4.0)));
            let depth_at = |from: f32, to: f32| {
                let within = |p: &&Vec3| (from..to).contains(&(side * (p.y - 4.0)));
                places.iter().filter(across).filter(within).map(|p| p.z).fold(0.0, f32::min)
            };
            assert!(depth_at(1.05 * width, 1.0) > -0.005, "{options:?}: {}", depth_at(1.05 * width, 1.0));
            assert!(depth_at(0.0, 0.6 * width) < -0.06, "{options:?}: {}", depth_at(0.0, 0.6 * width));
        }
    }
}

#[test]
fn left_is_left_of_the_chain_with_normals_up() {
    let wide_side = |options: &[&str], change: fn(&mut Garment)| {
        let mut input = shapes().remove(0).1;
        change(&mut input);
        let garment = checked(input);
        let (mesh, _) = rendered(&garment, options);
        let low = mesh.points.iter().filter(|p| p.z.abs() > 0.01);
        low.map(|p| p.y - 4.0).sum::<f32>()
    };
    let options =
        ["seam.s.edges=ring", "seam.s.width=0.6", "seam.s.normalOffset=0.1", "seam.s.asymmetry=-0.8", "render.level=2"];
    // The line runs along x, so its left is at larger y.
    assert!(wide_side(&options, |_| ()) > 0.0);
    assert!(wide_side(&options, |input| input.subsets.iter_mut().for_each(|s| s.indices.reverse())) < 0.0);
    assert!(wide_side(&options, |input| input.orientation = Orientation::LeftHanded) < 0.0);
}

/// The edges of a render mesh have at most as many faces as those of its source, and its faces have areas and agree with
/// their neighbours.
pub fn sound(mesh: &Mesh, name: &str) {
    let t = Topology::new(mesh.faces.clone(), mesh.points.len());
    for edge in t.edges.ids() {
        let halves = t.edge_corners.row(edge);
        assert!(halves.len() <= 2, "{name}: edge {:?} has {} faces", t.edges[edge], halves.len());
        if let &[a, b] = halves {
            assert!(t.faces.vertex(a) != t.faces.vertex(b), "{name}: faces at {:?} disagree", t.edges[edge]);
        }
    }
    for face in t.faces.ids() {
        let p: Vec<Vec3> = t.faces.vertices_of(face).iter().map(|&v| mesh.points[v]).collect();
        let area = (2..p.len()).map(|i| (p[i - 1] - p[0]).cross(p[i] - p[0])).sum::<Vec3>().length();
        let longest = (0..p.len()).map(|i| p[i].distance_squared(p[(i + 1) % p.len()])).fold(0.0, f32::max);
        assert!(area > 1e-4 * longest, "{name}: {face:?} at {p:?} has no area");
    }
    assert!(mesh.points.iter().all(|p| p.is_finite()), "{name}");
}

/// Networks on a sheet of 8 by 8 whose points are numbered by rows of 9.
fn networks() -> Vec<(&'static str, Vec<Vec<[i32; 2]>>)> {
    let row = |y: i32, from: i32, to: i32| path(&(from..=to).map(|x| 9 * y + x).collect::<Vec<_>>());
    let column = |x: i32, from: i32, to: i32| path(&(from..=to).map(|y| 9 * y + x).collect::<Vec<_>>());
    vec![
        ("through", vec![row(4, 0, 8)]),
        ("dart from the border", vec![row(4, 0, 3)]),
        ("ends inside", vec![row(4, 2, 6)]),
        ("cross", vec![[row(4, 0, 8), column(4, 0, 8)].concat()]),
        ("two seams that cross", vec![row(4, 0, 8), column(4, 0, 8)]),
        ("tee", vec![[row(4, 0, 8), column(4, 4, 8)].concat()]),
        ("two seams in a tee", vec![row(4, 1, 7), column(4, 4, 7)]),
        ("bend", vec![[row(4, 1, 4), column(4, 4, 7)].concat()]),
        ("bend of two edges", vec![[row(4, 3, 4), column(4, 4, 5)].concat()]),
        ("bend beside a bend", vec![path(&[40, 31, 32, 41])]),
        ("hook around a face", vec![path(&[40, 31, 32, 41, 50])]),
        ("closed", vec![[row(2, 2, 6), column(6, 2, 6), row(6, 2, 6), column(2, 2, 6)].concat()]),
        ("around one face", vec![[row(3, 3, 4), column(4, 3, 4), row(4, 3, 4), column(3, 3, 4)].concat()]),
        ("neighbours", vec![row(4, 0, 8), row(5, 0, 8)]),
        ("along the border", vec![row(0, 2, 6)]),
        ("around a corner", vec![[row(0, 2, 8), column(8, 0, 5)].concat()]),
        ("all the border", vec![[row(0, 0, 8), column(8, 0, 8), row(8, 0, 8), column(0, 0, 8)].concat()]),
        ("every edge", vec![(0..9).flat_map(|i| [row(i, 0, 8), column(i, 0, 8)].concat()).collect()]),
        ("stairs", vec![path(&[20, 21, 30, 31, 40, 41, 50, 51, 60])]),
        ("single edge", vec![row(4, 3, 4)]),
    ]
}

#[test]
fn networks_are_sound_and_flat_ones_stay_flat() {
    for (name, seams) in networks() {
        for (width, offset) in [(0.3, 0.1), (0.3, -0.1), (0.9, 0.1), (0.3, 0.0), (0.05, 0.0)] {
            let mut input = sheet(8);
            let mut options: Vec<String> = vec!["render.level=2".into()];
            for (i, edges) in seams.iter().enumerate() {
                let edge_set = format!("set{i}");
                input = with_edges(input, &edge_set, edges);
                options.push(format!("seam.s{i}.edges={edge_set}"));
                options.push(format!("seam.s{i}.width={width}"));
                options.push(format!("seam.s{i}.normalOffset={offset}"));
            }
            let options: Vec<&str> = options.iter().map(String::as_str).collect();
            let garment = checked(input);
            let (mesh, warnings) = rendered(&garment, &options);
            let name = format!("{name}, width {width}, offset {offset}");
            sound(&mesh, &name);
            assert!(mesh.faces.ids().all(|f| mesh.faces.valence(f) == 4), "{name}");
            let up = |p: &[Vec3]| (p[2] - p[0]).cross(p[3] - p[1]).z;
            for face in mesh.faces.ids() {
                let p: Vec<Vec3> = mesh.faces.vertices_of(face).iter().map(|&v| mesh.points[v]).collect();
                assert!(up(&p) > 0.0, "{name}: {face:?} at {p:?} is turned over");
            }
            if offset == 0.0 {
                assert!(mesh.points.iter().all(|p| p.z.abs() < 1e-5), "{name}");
            }
            let narrow = warnings.iter().any(|w| w.code == codes::NARROW_SEAM);
            let crowded = width > 0.5 || name.starts_with("every");
            assert!(!narrow || crowded, "{name}: {warnings:?}");
            assert!(
                narrow || width < 0.5 || !name.starts_with("neighbours"),
                "{name}: nothing is said of too little room"
            );
        }
    }
}

#[test]
fn seams_that_are_too_wide_shrink_in_width_and_depth_and_say_where() {
    let edges = path(&[37, 38, 39, 40]);
    let garment = checked(with_edges(with_edges(sheet(8), "a", &edges), "b", &path(&[46, 47, 48, 49])));
    // Parts of the depth that the two inner vertices of the chain have; they keep their numbers.
    let of = |options: &[&str]| {
        let (mesh, warnings) = rendered(&garment, &[options, &["render.level=4"]].concat());
        ([38, 39].map(|v| mesh.points[VertexId::new(v)].z / -0.1), warnings)
    };
    let (deep, warnings) = of(&["seam.a.edges=a", "seam.a.width=0.5", "seam.a.normalOffset=-0.1"]);
    assert!(warnings.is_empty() && deep.iter().all(|d| (d - 1.0).abs() < 0.02), "{deep:?}, {warnings:?}");
    let wide = ["seam.a.edges=a", "seam.b.edges=b", "seam.a.width=1", "seam.b.width=1"];
    let (shallow, warnings) = of(&[&wide[..], &["seam.a.normalOffset=-0.1", "seam.b.normalOffset=-0.1"]].concat());
    let narrow: Vec<&Warning> = warnings.iter().filter(|w| w.code == codes::NARROW_SEAM).collect();
    assert_eq!(narrow.len(), 2, "{warnings:?}");
    for warning in narrow {
        let (seam, least) = (warning.place.as_str(), warning.amount.expect("a share"));
        let Elements::Points(examples) = &warning.elements else { panic!("{warning}") };
        assert!(!examples.is_empty());
        assert!((0.4..0.95).contains(&least), "{seam}: {least}");
        let own = if seam == "seam.a" { 38..40 } else { 47..49 };
        assert!(examples.iter().all(|v| own.contains(&v.index())), "{seam}: {examples:?}");
        assert!(seam != "seam.a" || shallow.iter().all(|d| (d - least).abs() < 0.02), "{shallow:?}, {least}");
    }
}

#[test]
fn both_orders_are_sound_and_differ() {
    let garment = checked(with_edges(sheet(8), "line", &path(&[36, 37, 38, 39, 40, 41, 42, 43, 44])));
    let options = |order| {
        vec![
            "seam.s.edges=line",
            "seam.s.width=0.3",
            "seam.s.normalOffset=-0.05",
            "fold.t.faces=half",
            "fold.t.thickness=0.2",
            "render.level=2",
            order,
        ]
    };
    let (seam_first, _) = rendered(&garment, &options("render.operators=s,t"));
    let (hem_first, warnings) = rendered(&garment, &options("render.operators=fold.t,seam:s"));
    assert!(warnings.is_empty(), "{warnings:?}");
    sound(&seam_first, "seam first");
    sound(&hem_first, "hem first");
    assert!(seam_first.points != hem_first.points);
    // Through a fold the seam goes around; under a hem the second layer follows the groove.
    let lowest = |mesh: &Mesh| limit(mesh).iter().map(|p| p.z).fold(0.0, f32::min);
    let (through, under) = (lowest(&hem_first), lowest(&seam_first));
    assert!((under + 0.25).abs() < 0.02 && (through + 0.2).abs() < 0.02, "{under} {through}");
    let (deep, warnings) =
        rendered(&garment, &[&options("render.operators=t,s")[..], &["seam.s.normalOffset=-0.2"]].concat());
    assert!(warnings.iter().any(|w| w.code == codes::SHALLOW_SEAM), "{warnings:?}");
    sound(&deep, "deep");
}

#[test]
fn faults_name_what_is_wrong() {
    let message = |input: Garment, options: &[&str]| {
        let garment = checked(input);
        try_rendered(&garment, options).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let inside = || with_faces(sheet(8), "inside", [18, 19, 26, 27]);
    let fault = message(inside(), &["fold.t.faces=inside"]);
    assert!(fault.contains("inside") && fault.contains("border") && fault.contains("hint:"), "{fault}");
    assert_eq!(message(inside(), &["fold.t.faces=inside", "fold.t.closed=true"]), "");
    let (_, triangles) = tailor_testing::zoo::all().into_iter().find(|(name, _)| *name == "loop").expect("in the zoo");
    assert_eq!(triangles.rules.scheme, Scheme::Loop);
    let fault = message(with_edges(triangles, "line", &path(&[4, 5, 6])), &["seam.s.edges=line"]);
    assert!(fault.contains("seam.s") && fault.contains("loop"), "{fault}");
}

#[test]
fn operators_run_as_they_are_named() {
    let garment = checked(with_edges(sheet(8), "line", &path(&[36, 37, 38])));
    let base = ["seam.s.edges=line", "fold.t.faces=half", "seam.s.width=0.2", "fold.t.thickness=0.1"];
    let (_, warnings) = rendered(&garment, &[&base[..], &["render.operators=t"]].concat());
    assert!(warnings.iter().any(|w| w.code == codes::OPERATORS_LEFT_OUT && w.problem.contains("`seam.s`")));
    assert_eq!(stack(&base).operators.len(), 2);
}

/// An operator that is not enabled leaves no trace and no warning, whatever its other options and the order say.
#[test]
fn an_operator_that_is_not_enabled_is_as_if_it_were_not_there() {
    let garment = checked(with_edges(sheet(8), "line", &path(&[36, 37, 38, 39, 40])));
    let seam = ["seam.s.edges=line", "seam.s.normalOffset=-0.05"];
    let (with, warnings_with) = rendered(&garment, &seam);
    let (without, _) = rendered(&garment, &[&seam[..], &["seam.s.enabled=false"]].concat());
    let (plain, _) = rendered(&garment, &["render.level=2"]);
    assert!(with.faces != plain.faces && without.faces == plain.faces && without.points == plain.points);
    let missing = ["fold.t.faces=none", "fold.t.enabled=false", "render.operators=t,s"];
    let (same, warnings) = rendered(&garment, &[&seam[..], &missing].concat());
    assert!(same.points == with.points && warnings == warnings_with, "{warnings:?}");
    let off = ["seam.s.enabled=false", "fold.t.faces=half", "render.operators=t"];
    let (_, warnings) = rendered(&garment, &[&seam[..], &off].concat());
    assert!(warnings.iter().all(|w| w.code != codes::OPERATORS_LEFT_OUT), "{warnings:?}");
}

#[test]
fn the_zoo_survives_every_operator() {
    for (name, input) in tailor_testing::zoo::all().into_iter().filter(|(_, i)| i.rules.scheme != Scheme::Loop) {
        let mut edges: Vec<[i32; 2]> = Vec::new();
        let mut start = 0;
        for (f, &n) in input.face_vertex_counts.iter().enumerate() {
            let face = &input.face_vertex_indices[start..start + n as usize];
            edges.extend((0..face.len()).filter(|k| (f + k) % 3 == 0).map(|k| [face[k], face[(k + 1) % face.len()]]));
            start += n as usize;
        }
        let mut seen = BTreeSet::new();
        edges.retain(|e| seen.insert([e[0].min(e[1]), e[0].max(e[1])]));
        let faces = 0..input.face_vertex_counts.len() as i32;
        let garment = checked(with_faces(with_edges(input, "some", &edges), "all", faces));
        for order in ["s,t", "t,s"] {
            let order = format!("render.operators={order}");
            let options = [
                "seam.s.edges=some",
                "seam.s.width=0.1",
                "seam.s.normalOffset=-0.02",
                "seam.s.depth=0.01",
                "fold.t.faces=all",
                "fold.t.thickness=0.05",
                "fold.t.closed=true",
                "render.faceSets=true",
                "render.level=1",
                &order,
            ];
            let (mesh, _) = rendered(&garment, &options);
            assert!(mesh.points.iter().all(|p| p.is_finite()), "{name}, {order}");
            assert!(mesh.faces.ids().all(|f| mesh.faces.valence(f) == 4), "{name}, {order}");
        }
    }
}

#[test]
fn an_edge_of_no_length_beside_a_seam_makes_no_point_of_no_place() {
    let mut input = sheet(8);
    // The first vertex of an edge that leads away from the seam comes upon its second.
    input.points[9 * 4 + 4] = input.points[9 * 5 + 4];
    let garment = checked(with_edges(input, "row", &path(&(36..=44).collect::<Vec<_>>())));
    for width in ["0.3", "5"] {
        let width = format!("seam.s.width={width}");
        let (mesh, _) = rendered(&garment, &["seam.s.edges=row", &width, "seam.s.normalOffset=0.1", "render.level=2"]);
        assert!(mesh.points.iter().all(|p| p.is_finite()), "{width}");
    }
}
