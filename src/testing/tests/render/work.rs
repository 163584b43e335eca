//! The work of repair, which has a bound.

use super::cloth::{checked, sheet};
use crate::operators::rendered;
use glam::Vec3;
use tailor::codes;
use tailor_mesh::connectivity::Topology;
use tailor_mesh::error::WarningCode;
use tailor_mesh::garment::Garment;
use tailor_testing::sheets::{mesh, with_edges};

/// A sheet of which every point is in a random place of a box, with all of its edges as a set.
fn crumpled(n: usize) -> Garment {
    let random = |i: usize, axis: usize| {
        ((3 * i + axis + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1 << 24) as f32
    };
    let mut input = sheet(n);
    input.points.iter_mut().enumerate().for_each(|(i, p)| *p = Vec3::from([0, 1, 2].map(|axis| random(i, axis))));
    with_all_edges(input)
}

fn with_all_edges(input: Garment) -> Garment {
    let t = checked(input.clone());
    let t = Topology::new(t.faces.clone(), t.points.len());
    let all: Vec<[i32; 2]> = t.edges.iter().map(|ends| ends.map(|v| v.index() as i32)).collect();
    with_edges(input, "all", &all)
}

/// A pole of `n` quads around one vertex, with all of its edges as a set.
fn pole(n: usize) -> Garment {
    let at = |i: usize| i as f32 / (2 * n) as f32 * std::f32::consts::TAU;
    let rim = (0..2 * n).map(|i| [at(i).cos(), at(i).sin(), 0.1 * (i % 3) as f32]);
    let faces: Vec<[i32; 4]> =
        (0..n as i32).map(|i| [0, 2 * i + 1, 2 * i + 2, (2 * i + 2) % (2 * n as i32) + 1]).collect();
    let faces: Vec<&[i32]> = faces.iter().map(<[i32; 4]>::as_slice).collect();
    with_all_edges(mesh(std::iter::once([0.0; 3]).chain(rim), &faces))
}

#[test]
fn repair_of_crumpled_cloth_and_poles_ends_at_its_bound() {
    for (name, input, is_cut_short) in
        [("flat", with_all_edges(sheet(17)), false), ("crumpled", crumpled(17), true), ("pole", pole(400), true)]
    {
        let garment = checked(input);
        let (made, warnings) = rendered(&garment, &["seam.s.edges=all", "seam.s.width=0.02", "render.level=1"]);
        assert!(made.points.iter().all(|p| p.is_finite()), "{name}");
        let is_told = |code: WarningCode| warnings.iter().any(|w| w.code == code && w.place == "seam.s");
        assert_eq!(is_told(codes::REPAIR_CUT_SHORT), is_cut_short, "{name}");
        assert!(!is_cut_short || is_told(codes::INTERSECTIONS), "{name}: what is not tested is reported");
    }
}
