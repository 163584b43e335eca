//! Invariants of the products: of every garment, a zoo of small troubles, and random sheets.
//!
//! In debug builds the remesher checks its own invariants after each pass too.

use crate::checks::product::{Bounds, GARMENT, Subject};
use proptest::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use tailor_costume::recipe::Layers;
use tailor_mesh::garment::Garment;
use tailor_testing::cases::few;
use tailor_testing::{garments, sheets, zoo};
use tailor_usd::{ReadOptions, Source};

/// Those of tiny meshes, whose targets may be longer than their features.
const TINY: Bounds = Bounds { distance: 0.5, chain: 0.5, ..GARMENT };

/// The layers of a recipe given as on the command line, with all UV shells as constraints, however small, as the checks of UVs ask for.
fn layers(overrides: &[String]) -> Layers {
    let mut layers = Layers::default();
    layers.add_override("sim.smallestShell=0").expect("an option");
    overrides.iter().for_each(|o| layers.add_override(o).unwrap_or_else(|e| panic!("{e}")));
    layers
}

/// Builds and checks; a panic is a fault as any other.
fn complaint(name: &str, input: Garment, layers: &Layers, bounds: Bounds) -> Option<String> {
    let work = || Subject::build(name, input, layers).and_then(|s| s.check(bounds));
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.err(),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            Some(format!("{name}: panicked: {}", text.unwrap_or_default()))
        }
    }
}

#[track_caller]
fn none_of(complaints: &[String]) {
    assert!(complaints.is_empty(), "{} faults:\n{}", complaints.len(), complaints.join("\n"));
}

#[test]
fn of_garments() {
    none_of(&with_own_recipes(&[]));
}

#[test]
fn of_garments_with_symmetry() {
    none_of(&with_own_recipes(&["sim.symmetry=true".into()]));
}

/// All garments, each with its own recipe and some options.
fn with_own_recipes(options: &[String]) -> Vec<String> {
    let mut complaints = Vec::new();
    for file in garments::garments() {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let source = Source::open(&file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (input, mut warnings) = source.garment().unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut layers = layers(options);
        warnings.extend(layers.add_attributes(source.recipe().unwrap_or_else(|e| panic!("{name}: {e}"))));
        // Those without a recipe get lengths near those of their faces, at which chains are cut unevenly, more so where a
        // corner of a small detail keeps a vertex.
        let chain = if layers.recipe().is_ok_and(|r| r.sim.max_edge_length > 0.0) { GARMENT.chain } else { 0.09 };
        complaints.extend(complaint(&name, input, &layers, Bounds { chain, ..GARMENT }));
    }
    complaints
}

/// The mean edge of a mesh in its own units, roughly: what targets are a multiple of.
fn size(input: &Garment) -> f32 {
    let mut start = 0;
    let (mut sum, mut count) = (0.0, 0);
    for &n in &input.face_vertex_counts {
        let face = &input.face_vertex_indices[start..start + n as usize];
        for k in 0..face.len() {
            sum += input.points[face[k] as usize].distance(input.points[face[(k + 1) % face.len()] as usize]);
            count += 1;
        }
        start += n as usize;
    }
    sum / count as f32
}

/// The zoo at one target length, as a multiple of the mean edge.
fn zoo_at(multiple: f32, more: &[&str]) -> Vec<String> {
    let mut complaints = Vec::new();
    for (name, input) in zoo::all() {
        let mut overrides = vec![format!("sim.maxEdgeLength={}", multiple * size(&input))];
        overrides.extend(more.iter().map(|&s| s.to_owned()));
        if input.subsets.iter().any(|s| s.name == "line") {
            overrides.push("sim.constraints=line".into());
        }
        let label = format!("{name} at {multiple} {more:?}");
        complaints.extend(complaint(&label, input, &layers(&overrides), TINY));
    }
    complaints
}

#[test]
fn of_the_zoo() {
    none_of(&zoo_at(0.5, &[]));
}

#[test]
fn of_the_zoo_with_symmetry() {
    none_of(&zoo_at(0.5, &["sim.symmetry=true"]));
}

#[test]
fn of_the_zoo_with_density() {
    none_of(&zoo_at(0.8, &["sim.density=density", "render.level=2"]));
}

#[test]
fn of_the_zoo_far_finer_than_its_baseline() {
    none_of(&zoo_at(0.15, &["sim.baselineLevel=0", "render.level=0"]));
}

#[test]
fn of_the_zoo_far_coarser_than_its_faces() {
    none_of(&zoo_at(5.0, &["sim.baselineLevel=1"]));
}

/// A random sheet: some cells missing, some holes, some cuts in the UVs, some constraints, bent at random.
#[derive(Clone, Debug)]
struct Sheet {
    nx: usize,
    ny: usize,
    cells: Vec<u8>,
    heights: Vec<f32>,
    cut: usize,
    line: usize,
    target: f32,
    level: u32,
    dense: bool,
}

fn sheets() -> impl Strategy<Value = Sheet> {
    (1usize..6, 1usize..6).prop_flat_map(|(nx, ny)| {
        let cells = prop::collection::vec(prop_oneof![8 => Just(0u8), 1 => Just(1u8), 1 => Just(2u8)], nx * ny);
        let heights = prop::collection::vec(-0.3f32..0.3, (nx + 1) * (ny + 1));
        let rest = (0..=nx, 0..=nx, 0.2f32..3.0, 0u32..3, any::<bool>());
        (cells, heights, rest).prop_map(move |(cells, heights, (cut, line, target, level, dense))| Sheet {
            nx,
            ny,
            cells,
            heights,
            cut,
            line,
            target,
            level,
            dense,
        })
    })
}

impl Sheet {
    /// The sheet with its mirror image beside it. If `is_odd`, both share the faces of their last column.
    fn mirrored(&self, is_odd: bool) -> Self {
        let nx = 2 * self.nx - usize::from(is_odd);
        let of = |values: usize, x: usize| x.min(values - 1 - x);
        let rows = 0..self.ny;
        let cells = rows.flat_map(|y| (0..nx).map(move |x| y * self.nx + of(nx, x))).map(|i| self.cells[i]);
        let heights = (0..=self.ny).flat_map(|y| (0..=nx).map(move |x| y * (self.nx + 1) + of(nx + 1, x)));
        let heights = heights.map(|i| self.heights[i]);
        Self { nx, cells: cells.collect(), heights: heights.collect(), ..self.clone() }
    }

    /// None where no face is left to be drawn.
    fn input(&self) -> Option<Garment> {
        let kind = |x: usize, y: usize| self.cells[y * self.nx + x];
        let mut kept = Vec::new();
        (0..self.ny).for_each(|y| kept.extend((0..self.nx).filter(|&x| kind(x, y) != 1).map(|x| (x, y))));
        let holes: Vec<i32> = (0..kept.len()).filter(|&i| kind(kept[i].0, kept[i].1) == 2).map(|i| i as i32).collect();
        if holes.len() == kept.len() {
            return None;
        }
        let mut input = sheets::grid(self.nx, self.ny, |x, y| kind(x, y) != 1);
        input.primvars.retain(|p| p.name != "st");
        let (cut, nx) = (self.cut, self.nx);
        let mut input = sheets::with_uvs(input, move |face, v| {
            let shift = if kept[face].0 >= cut { 10.0 } else { 0.0 };
            [(v % (nx + 1)) as f32 + shift, (v / (nx + 1)) as f32]
        });
        input.hole_indices = holes;
        input.points.iter_mut().zip(&self.heights).for_each(|(p, h)| p.z = *h);
        let row = |y: usize| (y * (nx + 1) + self.line) as i32;
        let edge =
            |y: usize| (self.line > 0 && kind(self.line - 1, y) != 1) || (self.line < nx && kind(self.line, y) != 1);
        let line: Vec<[i32; 2]> = (0..self.ny).filter(|&y| edge(y)).map(|y| [row(y), row(y + 1)]).collect();
        Some(if line.is_empty() { input } else { sheets::with_edges(input, "line", &line) })
    }

    fn layers(&self, input: &Garment) -> Layers {
        let mut overrides = vec![
            format!("sim.maxEdgeLength={}", self.target),
            format!("sim.baselineLevel={}", self.level),
            format!("render.level={}", self.level),
        ];
        if self.dense {
            overrides.push("sim.density=density".into());
        }
        if input.subsets.iter().any(|s| s.name == "line") {
            overrides.push("sim.constraints=line".into());
        }
        layers(&overrides)
    }
}

proptest! {
    #![proptest_config(few(48, 20_220_808))]

    #[test]
    fn of_random_sheets(sheet in sheets()) {
        if let Some(input) = sheet.input() {
            let layers = sheet.layers(&input);
            // Rough sheets at coarse targets: edges cut across their bumps.
            let bounds = Bounds { distance: 1.0, ..TINY };
            prop_assert_eq!(complaint("sheet", input, &layers, bounds), None);
        }
    }

    #[test]
    fn of_random_mirrored_sheets(sheet in sheets(), is_odd in any::<bool>()) {
        let sheet = sheet.mirrored(is_odd);
        if let Some(input) = sheet.input() {
            let mut layers = sheet.layers(&input);
            layers.add_override("sim.symmetry=true").expect("an option");
            let bounds = Bounds { distance: 1.0, ..TINY };
            prop_assert_eq!(complaint("mirrored sheet", input, &layers, bounds), None);
        }
    }

    /// Any faces over a few points: crossing, doubled, joined at edges and vertices in every way.
    #[test]
    fn of_random_heaps(
        shifts in prop::collection::vec(prop::array::uniform3(-0.4f32..0.4), 8),
        faces in prop::collection::vec(prop::sample::subsequence((0..8).collect::<Vec<i32>>(), 3..5).prop_shuffle(), 1..8),
        target in 0.2f32..2.0,
    ) {
        let faces: Vec<&[i32]> = faces.iter().map(Vec::as_slice).collect();
        // The corners of a box, each moved a little, so that no two are in one place.
        let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|k| k as f32);
        let points = shifts.iter().enumerate().map(|(i, s)| [0, 1, 2].map(|k| corner(i)[k] + s[k]));
        let input = sheets::mesh(points, &faces);
        let layers = layers(&[format!("sim.maxEdgeLength={target}")]);
        // Such a surface folds back on itself: what is asked for is a sound mesh, not a good one.
        let bounds = Bounds { distance: f32::MAX, chain: 1.0, area: -1.0 };
        let fault = complaint("heap", input, &layers, bounds);
        // Shrinking leads to heaps without area, which are refused.
        prop_assert!(fault.as_ref().is_none_or(|f| f.contains("hint: ")), "{}", fault.unwrap_or_default());
    }
}

/// A flip during a drift once put the seam in the place of a free edge, and the next flip took it away.
#[test]
fn a_drift_flips_no_seam() {
    let heights = vec![-0.136_955_74, 0.228_554_43, 0.0, -0.079_730_24, 0.167_435_2, 0.0];
    let (nx, ny, cells, target) = (2, 1, vec![0, 0], 1.446_625_8);
    let sheet = Sheet { nx, ny, cells, heights, cut: 1, line: 0, target, level: 0, dense: false }.mirrored(true);
    let input = sheet.input().unwrap();
    let fault = complaint("sheet", input.clone(), &sheet.layers(&input), Bounds { distance: 1.0, ..TINY });
    assert_eq!(fault, None);
}
