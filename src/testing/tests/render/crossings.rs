//! Triangles that pass through each other.

use glam::{DVec3, IVec3, Vec3};
use std::collections::{BTreeSet, HashMap};
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::garment::Mesh;

struct Triangle {
    face: FaceId,
    vertices: [VertexId; 3],
    points: [DVec3; 3],
}

/// Pairs of parent faces, the lower first, of which children cross that have no vertex in common.
pub fn crossing_parents(mesh: &Mesh, parents: &[usize]) -> BTreeSet<[usize; 2]> {
    let triangles: Vec<Triangle> = mesh.faces.ids().flat_map(|f| halves(mesh, f)).collect();
    let size = triangles.iter().map(|t| t.points[0].distance(t.points[1])).sum::<f64>() / triangles.len() as f64;
    let cell = |p: DVec3| (p / (2.0 * size)).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
    for (i, triangle) in triangles.iter().enumerate() {
        let [low, high] = bounds(triangle).map(cell);
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                (low.z..=high.z).for_each(|z| cells.entry(IVec3::new(x, y, z)).or_default().push(i));
            }
        }
    }
    let mut found = BTreeSet::new();
    for members in cells.values() {
        for (k, &i) in members.iter().enumerate() {
            for &j in &members[k + 1..] {
                let (a, b) = (&triangles[i], &triangles[j]);
                let mut pair = [parents[a.face.index()], parents[b.face.index()]];
                pair.sort_unstable();
                if !found.contains(&pair) && cross(a, b) {
                    found.insert(pair);
                }
            }
        }
    }
    found
}

fn halves(mesh: &Mesh, face: FaceId) -> [Triangle; 2] {
    let v = mesh.faces.vertices_of(face);
    [[v[0], v[1], v[2]], [v[0], v[2], v[3]]].map(|vertices| Triangle {
        face,
        vertices,
        points: vertices.map(|v| Vec3::as_dvec3(&mesh.points[v])),
    })
}

fn bounds(t: &Triangle) -> [DVec3; 2] {
    let [a, b, c] = t.points;
    [a.min(b).min(c), a.max(b).max(c)]
}

fn cross(a: &Triangle, b: &Triangle) -> bool {
    let ([al, ah], [bl, bh]) = (bounds(a), bounds(b));
    let apart = al.cmpgt(bh).any() || bl.cmpgt(ah).any();
    let joined = a.vertices.iter().any(|v| b.vertices.contains(v));
    !apart && !joined && (edges_pierce(a, b) || edges_pierce(b, a))
}

/// Whether an edge of `a` passes through the inside of `b`.
fn edges_pierce(a: &Triangle, b: &Triangle) -> bool {
    let [p, q, r] = b.points;
    let normal = (q - p).cross(r - p);
    let side = |x: DVec3| (x - p).dot(normal);
    (0..3).any(|i| {
        let (from, to) = (a.points[i], a.points[(i + 1) % 3]);
        let (s, t) = (side(from), side(to));
        if s * t >= 0.0 {
            return false;
        }
        let x = from + (to - from) * (s / (s - t));
        let inside = |u: DVec3, v: DVec3| (v - u).cross(x - u).dot(normal) > 1e-9 * normal.length_squared();
        inside(p, q) && inside(q, r) && inside(r, p)
    })
}
