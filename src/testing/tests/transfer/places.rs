//! Places of points on a baseline.

use super::sets::garment;
use glam::Vec3;
use tailor::transfer::{Locator, LocatorTables};
use tailor_mesh::connectivity::{FaceId, IdVec};
use tailor_testing::garments::garments;

#[test]
fn the_closest_point_is_that_of_a_search_of_all_triangles() {
    for path in garments() {
        let built = garment(&path, &[]);
        let (product, faces) = (built.product(), &built.garment.faces);
        let tables = LocatorTables::new(&product, faces.len());
        let locator = Locator::new(&product, &tables);
        let baseline = &product.baseline;
        let mut of_face: IdVec<FaceId, Vec<FaceId>> = IdVec::filled(Vec::new(), faces.len());
        baseline.source_face.enumerated().for_each(|(triangle, &source)| of_face[source].push(triangle));
        let edge = built.garment.size() / 50.0;
        for (i, face) in faces.ids().enumerate().step_by(5) {
            // On the surface, near it and far from it; a second face may be anywhere.
            let away = edge * [0.0, 0.1, 3.0][i % 3] * Vec3::new(0.3, -0.2, 0.9);
            let beside = [face, FaceId::new((i * 37) % faces.len())];
            for &vertex in faces.vertices_of(face) {
                let point = built.garment.points[vertex] + away;
                let distance = |&triangle: &FaceId| baseline.on_triangle(triangle, point).distance_squared;
                let all = beside.iter().flat_map(|&face| &of_face[face]).map(distance).reduce(f32::min);
                let found = locator.closest(point, &beside).map(|(triangle, _)| distance(&triangle));
                assert_eq!(found, all, "{}: {face:?} at {point}", path.display());
            }
        }
    }
}
