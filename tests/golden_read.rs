//! The golden data of the subdivision tests parse and are consistent in themselves.

#[path = "common/golden.rs"]
mod golden;

use golden::{Boundary, FACE_VARYING_RULES, Scheme, load};
use std::path::Path;

#[test]
fn every_file_parses_and_indices_are_in_range() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let mut seen = std::collections::BTreeSet::new();
    for family in ["catmark", "loop", "bilinear", "generated", "nonmanifold"] {
        let cases = load(dir.join(family).with_extension("bin"));
        assert!(!cases.is_empty(), "{family}");
        for case in &cases {
            let name = &case.name;
            seen.insert(format!(
                "{:?} {:?} {}",
                case.scheme, case.boundary, case.smooth_triangles
            ));
            let faces = case.face_vertex_counts.len();
            assert_eq!(
                case.face_vertex_counts.iter().sum::<usize>(),
                case.face_vertex_indices.len(),
                "{name}"
            );
            assert_eq!(
                case.uv_indices.len(),
                case.face_vertex_indices.len(),
                "{name}"
            );
            assert_eq!(case.varying.len(), case.points.len(), "{name}");
            assert!(
                case.face_vertex_indices
                    .iter()
                    .all(|&v| v < case.points.len()),
                "{name}"
            );
            assert!(
                case.uv_indices.iter().all(|&i| i < case.uvs.len()),
                "{name}"
            );
            assert!(
                case.creases
                    .iter()
                    .all(|c| c.0.max(c.1) < case.points.len() && c.2 > 0.0),
                "{name}"
            );
            assert!(
                case.corners
                    .iter()
                    .all(|c| c.0 < case.points.len() && c.1 > 0.0),
                "{name}"
            );
            assert!(case.holes.iter().all(|&f| f < faces), "{name}");
            assert_eq!(case.slot_of_rule.len(), FACE_VARYING_RULES.len());
            assert!(case.slot_of_rule.iter().all(|&s| s < case.slots), "{name}");
            let side = if case.scheme == Scheme::Loop { 3 } else { 4 };
            for level in &case.levels {
                assert_eq!(level.face_vertices, side * level.faces, "{name}");
                assert!(level.edges > 0 && !level.samples.is_empty(), "{name}");
                let sums = level
                    .point_sum
                    .iter()
                    .chain(&level.varying_sum)
                    .chain(level.uv_sums.iter().flatten());
                assert!(
                    sums.chain([&level.sharpness_sum]).all(|x| x.is_finite()),
                    "{name}"
                );
                for face in &level.samples {
                    assert!(face.index < level.faces && face.base_face < faces, "{name}");
                    assert!(!case.holes.contains(&face.base_face) || face.hole, "{name}");
                    assert!(
                        face.hole == case.holes.contains(&face.base_face)
                            || case.boundary == Boundary::None,
                        "{name}"
                    );
                    assert_eq!(face.corners.len(), side, "{name}");
                    for corner in &face.corners {
                        assert!(corner.vertex < level.vertices, "{name}");
                        assert_eq!(corner.uvs.len(), case.slots, "{name}");
                        let values = corner
                            .point
                            .iter()
                            .chain(&corner.varying)
                            .chain(corner.uvs.iter().flatten());
                        assert!(
                            values
                                .chain([&corner.edge_sharpness, &corner.vertex_sharpness])
                                .all(|x| x.is_finite()),
                            "{name}"
                        );
                    }
                }
            }
        }
    }
    for scheme in ["Bilinear", "CatmullClark", "Loop"] {
        for boundary in ["None", "EdgeOnly", "EdgeAndCorner"] {
            assert!(
                seen.contains(&format!("{scheme} {boundary} false")),
                "{scheme} {boundary}"
            );
        }
    }
    assert!(
        seen.iter()
            .any(|s| s.starts_with("CatmullClark") && s.ends_with("true"))
    );
}
