//! Rims: folds with two layers that are nearer to each other than the target length, as a turned hem, a collar or a piped edge.

use crate::garments::garments;
use crate::prepared::of_file;
use crate::sheets::{mesh, with_uvs};
use crate::{MAX_FACES, baseline, prepare};
use glam::Vec3;
use tailor::internals::garment::GarmentInput;
use tailor::internals::mesh::CornerId;
use tailor::internals::sim::{Baseline, SimProduct, simulate};

/// The target length of the made garments, in whose units they are made. \[mesh units\]
const LENGTH: &str = "sim.maxEdgeLength=1";

/// How the triangles of a mesh face the surface that they lie on.
#[derive(Debug, Default)]
struct Facing {
    /// Triangles beyond 90 degrees.
    against: usize,
    /// Triangles beyond 60 degrees.
    steep: usize,
    triangles: usize,
}

/// The angle between each triangle and the surface at the point nearest to its centre, from its own corners. \[degrees\]
fn angles(product: &SimProduct) -> Vec<f32> {
    let base = &product.baseline;
    let of = |(i, t): (usize, &[tailor::internals::mesh::VertexId; 3])| {
        let [a, b, c] = t.map(|v| product.points[v]);
        let centre = (a + b + c) / 3.0;
        let near = (0..3).map(|k| base.closest(product.places[CornerId::new(3 * i + k)].location.face, centre));
        let near = near.min_by(|p, q| p.distance_squared.total_cmp(&q.distance_squared)).unwrap();
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot(base.normal(near.location.face).normalize_or_zero()).clamp(-1.0, 1.0).acos().to_degrees()
    };
    product.triangles.iter().enumerate().map(of).collect()
}

fn facing(product: &SimProduct) -> Facing {
    let angles = angles(product);
    let beyond = |most: f32| angles.iter().filter(|&&a| a > most).count();
    Facing { against: beyond(90.0), steep: beyond(60.0), triangles: angles.len() }
}

fn product(input: GarmentInput, options: &[&str]) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), prepared.recipe.sim.iterations, MAX_FACES)
}

/// A surface of revolution around z through the points `(radius, height)` of a profile, cut into `around` faces.
fn revolved(profile: &[[f32; 2]], around: usize) -> GarmentInput {
    let n = around as i32;
    let rows = 0..profile.len() as i32 - 1;
    let quad = |y: i32, x: i32| vec![y * n + x, y * n + (x + 1) % n, (y + 1) * n + (x + 1) % n, (y + 1) * n + x];
    let faces: Vec<Vec<i32>> = rows.flat_map(|y| (0..n).map(move |x| quad(y, x))).collect();
    let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
    let points = profile.iter().flat_map(|&[radius, height]| {
        (0..around).map(move |x| {
            let angle = x as f32 / around as f32 * std::f32::consts::TAU;
            [radius * angle.cos(), radius * angle.sin(), height]
        })
    });
    with_uvs(mesh(points, &faces), move |face, v| {
        let (x, y) = (v % around, v / around);
        let wraps = face % around == around - 1 && x == 0;
        [if wraps { around as f32 } else { x as f32 }, y as f32]
    })
}

/// A tube with a hem that is turned to its inside, whose layers are `gap` target lengths apart.
fn hem(gap: f32) -> GarmentInput {
    let inner = 6.0 - gap;
    revolved(&[[inner, 3.0], [inner, 1.5], [inner, 0.0], [6.0, 0.0], [6.0, 1.5], [6.0, 3.0], [6.0, 6.0], [6.0, 9.0]], 24)
}

/// A tube that ends in a thin round bead, as piping does.
fn piping(radius: f32) -> GarmentInput {
    let bead = (0..7).map(|k| {
        let angle = (60.0 - 50.0 * k as f32).to_radians();
        [6.0 + radius * angle.cos(), radius * angle.sin()]
    });
    let profile: Vec<[f32; 2]> = [[6.0, 6.0], [6.0, 3.0], [6.0, 1.5]].into_iter().chain(bead).collect();
    revolved(&profile.into_iter().rev().collect::<Vec<_>>(), 24)
}

/// A band that is folded along its upper edge, open at both ends, as a collar is.
fn collar(gap: f32) -> GarmentInput {
    let profile = [[6.0 - gap, 0.0], [6.0 - gap, 1.5], [6.0 - gap, 3.0], [6.0, 3.0], [6.0, 1.5], [6.2, 0.0]];
    let mut input = revolved(&profile, 24);
    // All faces but those of a quarter.
    let keep = |face: usize| face % 24 < 18;
    let kept: Vec<[i32; 4]> = input.face_vertex_indices.chunks_exact(4).enumerate().filter(|(f, _)| keep(*f))
        .map(|(_, q)| [q[3], q[2], q[1], q[0]]).collect();
    input = mesh(input.points.iter().map(|p| p.to_array()), &kept.iter().map(|q| q.as_slice()).collect::<Vec<_>>());
    with_uvs(input, |_, v| [(v % 24) as f32, (v / 24) as f32])
}

fn dump(name: &str, product: &SimProduct) {
    use std::fmt::Write;
    let mut t = String::from("#usda 1.0\n(\n defaultPrim = \"g\"\n)\ndef Xform \"g\" {\n def Mesh \"sim\" {\n");
    let points: Vec<String> = product.points.iter().map(|p| format!("({},{},{})", p.x, p.z, -p.y)).collect();
    let _ = writeln!(t, "point3f[] points = [{}]", points.join(","));
    let tri: Vec<String> = product.triangles.iter().flatten().map(|v| v.index().to_string()).collect();
    let _ = writeln!(t, "int[] faceVertexCounts = [{}]", vec!["3"; product.triangles.len()].join(","));
    let _ = writeln!(t, "int[] faceVertexIndices = [{}]\nuniform token subdivisionScheme = \"none\"", tri.join(","));
    for (kind, want) in [("ridges", true), ("others", false)] {
        let e: Vec<String> = product.chain_edges.enumerated().filter(|(c, _)| product.baseline.chains[*c].kind.ridge == want)
            .flat_map(|(_, e)| e.iter().map(|[a, b]| format!("({},{})", a.index(), b.index()))).collect();
        let _ = writeln!(t, "def GeomSubset \"{kind}\" {{ uniform token elementType = \"edge\"\nint[] indices = [{}]\n}}",
            e.join(",").replace(['(', ')'], ""));
    }
    t += "}\n}\n";
    std::fs::create_dir_all("/tmp/rim/d").unwrap();
    std::fs::write(format!("/tmp/rim/d/{name}.usda"), t).unwrap();
    let bad = angles(product).iter().enumerate().filter(|a| *a.1 > 60.0).map(|a| a.0.to_string()).collect::<Vec<_>>();
    std::fs::write(format!("/tmp/rim/d/{name}.bad"), bad.join(" ")).unwrap();
}

fn shown(name: &str, product: &SimProduct) {
    let q = crate::quality::Reference::of(product, |r| crate::quality::of_product(product, r));
    let ridges: usize = product.baseline.chains.iter().filter(|c| c.kind.ridge).map(|c| c.cage.len() - 1).sum();
    println!("{name:>22} {q} {:?} ridge edges {ridges} {:?}", facing(product), product.baseline.narrow.iter().map(|n| (n.edges, n.width)).collect::<Vec<_>>());
    dump(name, product);
}

#[test]
fn show() {
    println!("{:22} {}", "", crate::quality::Quality::HEAD);
    for gap in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0] {
        shown(&format!("hem-{gap}"), &product(hem(gap), &[LENGTH]));
    }
    for gap in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0] {
        shown(&format!("collar-{gap}"), &product(collar(gap), &[LENGTH]));
    }
    for gap in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0] {
        shown(&format!("piping-{gap}"), &product(piping(gap), &[LENGTH]));
    }
    for file in garments() {
        let prepared = of_file(&file, []);
        let product = simulate(baseline(&prepared), prepared.recipe.sim.iterations, MAX_FACES);
        shown(&file.file_stem().unwrap().to_string_lossy(), &product);
    }
}
