//! Seams along bends: no welt beside them.

use crate::cloth::{checked, path, sheet};
use crate::operators::{Surface, vertices_of};
use crate::recipes::rendered;
use crate::sheets::with_edges;
use glam::Vec3;
use tailor::internals::garment::Garment;

/// A sheet of 8 by 8 that turns by `turn` degrees along its middle row, with a seam "ridge" there.
fn roof(turn: f32) -> Garment {
    let mut input = sheet(8);
    let slope = (0.5 * turn).to_radians();
    for p in &mut input.points {
        let across = p.y - 4.0;
        *p = Vec3::new(p.x, across * slope.cos(), -across.abs() * slope.sin());
    }
    checked(with_edges(input, "ridge", &path(&(36..=44).collect::<Vec<_>>())))
}

/// Heights of the seam's middle and the largest one beside it, over the roof without a seam.
fn seam_on_roof(turn: f32, width: f32, offset: f32) -> (f32, f32) {
    let garment = roof(turn);
    let surface = Surface::new(&garment, &["render.level=5"]);
    let [width_option, offset_option] = [format!("seam.s.width={width}"), format!("seam.s.normalOffset={offset}")];
    let options = ["seam.s.edges=ridge", &width_option, &offset_option, "render.level=4"];
    let (mesh, warnings) = rendered(&garment, &options);
    assert!(warnings.is_empty(), "{turn}, {offset}: {warnings:?}");
    let places = crate::cloth::limit(&mesh);
    let inside = |p: Vec3| (2.0..=6.0).contains(&p.x);
    let ridge = vertices_of(&mesh, "ridge");
    let middle = ridge.iter().filter(|&&v| inside(places[v])).map(|&v| surface.height(places[v]));
    let middle = middle.fold(offset, |most, h| if (h - offset).abs() > (most - offset).abs() { h } else { most });
    let beside = |p: &&Vec3| inside(**p) && p.y.abs() > 0.6 * width && p.y.abs() < 0.8;
    let off = places.iter().filter(beside).map(|&p| surface.height(p).abs()).fold(0.0, f32::max);
    (middle, off)
}

#[test]
fn a_narrow_seam_along_a_bend_leaves_no_welt() {
    // The largest error beside the seam, as a share of an edge; 0.078 and 0.043 where each line is limited by itself.
    for (turn, width, most) in
        [(20.0, 1.0 / 12.0, 0.015), (40.0, 1.0 / 12.0, 0.03), (40.0, 0.2, 0.02), (40.0, 0.4, 0.01)]
    {
        for offset in [-0.03, 0.03] {
            let (middle, beside) = seam_on_roof(turn, width, offset);
            assert!(beside < most, "{turn} degrees, {width} wide: {beside} beside the seam");
            assert!(
                (middle - offset).abs() < 0.1 * offset.abs(),
                "{turn} degrees, {width} wide: {middle}, not {offset}"
            );
        }
    }
}
