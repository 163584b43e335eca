//! Values on the simulation mesh: UV sets with cuts of their own, skinning, blend shapes, provenance, normals.

use super::sets::{FREE, garment};
use super::sheet;
use crate::built::{Built, build};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;
use std::path::Path;
use tailor::sim::BaselinePoint;
use tailor::transfer::{SOURCE_COORDS, SOURCE_FACE, corner_coordinates};
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::joints::{self, Influences};
use tailor_mesh::garment::{Garment, Interpolation, Meaning, Mesh, Primvar, PrimvarInput, PrimvarRole, Values};
use tailor_mesh::subdivide::Stencils;
use tailor_testing::garments::{garments, named};
use tailor_testing::sheets;
use tailor_usd::{ReadOptions, Source};

fn primvar(name: &str, interpolation: Interpolation, components: usize, values: Values) -> PrimvarInput {
    PrimvarInput { components, ..PrimvarInput::new(name, interpolation, values) }
}

/// Gives a grid of `nx` columns a second layout, whose shells `shell` numbers by column and row.
fn with_layout(input: Garment, name: &str, nx: usize, shell: impl Fn(usize, usize) -> usize) -> Garment {
    let kept: Vec<PrimvarInput> = input.primvars.clone();
    let mut input = sheets::with_uvs(input, |face, v| {
        let number = shell(face % nx, face / nx);
        // Every other shell is mirrored, and none touches another.
        let (x, y) = ((v % (nx + 1)) as f32, (v / (nx + 1)) as f32);
        let x = if number % 2 == 1 { -x } else { x };
        [0.1 * x + 5.0 * number as f32, 0.1 * y]
    });
    let mut layout = input.primvars.pop().expect("the layout");
    layout.name = name.into();
    input.primvars = kept;
    input.primvars.push(layout);
    input
}

fn floats<'a>(mesh: &'a Mesh, name: &str) -> (&'a Primvar, &'a [f32]) {
    let primvar = mesh.primvar(name).unwrap_or_else(|| panic!("no {name}"));
    match &primvar.values {
        Values::F32(v) => (primvar, v),
        _ => panic!("{name} holds no floats"),
    }
}

/// Shells of a layout with the number of faces that lie either way round.
fn shells(mesh: &Mesh, name: &str) -> Vec<(usize, usize)> {
    let (primvar, values) = floats(mesh, name);
    let t = Topology::new(mesh.faces.clone(), mesh.points.len());
    let row = |c: CornerId| primvar.row(c.index());
    let at = |c: CornerId| [values[2 * row(c)], values[2 * row(c) + 1]].map(f64::from);
    let mut seen = IdVec::<FaceId, bool>::filled(false, t.faces.len());
    let mut found = Vec::new();
    for seed in t.faces.ids() {
        let mut reached = vec![seed];
        let (mut up, mut down) = (0, 0);
        while let Some(face) = reached.pop() {
            if std::mem::replace(&mut seen[face], true) {
                continue;
            }
            let corners: Vec<CornerId> = t.faces.corners_of(face).collect();
            let [a, b, c] = [0, 1, 2].map(|k| at(corners[k]));
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            *(if area > 0.0 { &mut up } else { &mut down }) += 1;
            for corner in corners {
                let Some(twin) = t.twin(corner) else { continue };
                if row(corner) == row(t.faces.next(twin)) && row(t.faces.next(corner)) == row(twin) {
                    reached.push(t.faces.face_of(twin));
                }
            }
        }
        if up + down > 0 {
            found.push((up, down));
        }
    }
    found
}

#[test]
fn further_uv_sets_keep_their_shells_and_turn_nothing_over() {
    for length in ["0.3", "0.45", "0.8"] {
        let mut input = sheet(10, 8);
        input = with_layout(input, "halves", 10, |x, _| usize::from(x >= 5));
        input = with_layout(input, "blocks", 10, |x, y| x / 5 + 2 * (y / 4));
        input = with_layout(input, "steps", 10, |x, y| usize::from(x > y));
        let built = build(input, &[&format!("sim.maxEdgeLength={length}")]);
        assert!(built.warnings.is_empty(), "{:?}", built.warnings);
        for (name, count) in [("st", 1), ("halves", 2), ("blocks", 4), ("steps", 2)] {
            let own = shells(&built.products.sim, name);
            assert_eq!(own.len(), count, "{name} at {length}: {own:?}");
            assert!(own.iter().all(|&(up, down)| up == 0 || down == 0), "{name} at {length} turns over: {own:?}");
        }
    }
}

#[test]
fn uvs_that_do_not_constrain_keep_their_shells_and_turn_nothing_over() {
    for length in ["0.3", "0.45", "0.8"] {
        let mut input = sheet(10, 8);
        input.primvars.retain(|p| p.name != "st");
        input = with_layout(input, "st", 10, |x, y| x / 5 + 2 * (y / 4));
        let built = build(input, &["sim.constrainUvSeams=false", &format!("sim.maxEdgeLength={length}")]);
        assert!(built.warnings.is_empty(), "{:?}", built.warnings);
        assert!(built.product().baseline.chains.iter().all(|chain| chain.kind.border), "no seam is a constraint");
        let own = shells(&built.products.sim, "st");
        assert_eq!(own.len(), 4, "at {length}: {own:?}");
        assert!(own.iter().all(|&(up, down)| up == 0 || down == 0), "turned over at {length}: {own:?}");
        assert!(built.products.cloth.as_ref().expect("cloth").rest.is_none(), "it rests as modelled");
    }
    // A layout of one shell stays on corners too, where a later run looks for it.
    let whole = build(sheet(4, 4), &["sim.constrainUvSeams=false"]).products.sim;
    assert_eq!(whole.primvar("st").map(|st| st.interpolation), Some(Interpolation::FaceVarying));
}

#[test]
fn continuous_corner_values_move_to_vertices_and_cut_ones_stay() {
    let mut input = sheet(12, 12);
    let (corners, points) = (input.face_vertex_indices.clone(), input.points.clone());
    let smooth = |i: usize| {
        let p = points[corners[i] as usize];
        [(0.7 * p.x).sin() + 0.3 * p.y, p.x * p.y, p.z - 0.1 * p.x]
    };
    let whole: Vec<f32> = (0..corners.len()).flat_map(smooth).collect();
    let mut cut = whole.clone();
    // The last face is cut off from the others, so that all corners keep values of their own.
    cut[12 * 143..].iter_mut().for_each(|x| *x += 5.0);
    input.primvars.push(primvar("whole", Interpolation::FaceVarying, 3, Values::F32(whole)));
    input.primvars.push(primvar("cut", Interpolation::FaceVarying, 3, Values::F32(cut)));
    input.primvars.push(primvar(
        "same",
        Interpolation::FaceVarying,
        1,
        Values::Text(vec!["all".into(); corners.len()]),
    ));
    for uv in ["sim.uvSet=st", "sim.uvSet="] {
        let built = build(input.clone(), &[uv, "sim.maxEdgeLength=0.4"]);
        let sim = &built.products.sim;
        let ((whole, ours), (cut, theirs)) = (floats(sim, "whole"), floats(sim, "cut"));
        assert_eq!(
            (whole.interpolation, cut.interpolation),
            (Interpolation::Vertex, Interpolation::FaceVarying),
            "{uv}"
        );
        assert_eq!(sim.primvar("same").expect("a text").interpolation, Interpolation::Vertex);
        assert_eq!(whole.elements(), sim.points.len());
        let value = |values: &[f32], row: usize| glam::Vec3::from_slice(&values[3 * row..]);
        let mut compared = 0;
        for (corner, vertex) in sim.faces.corners().enumerated() {
            // The cut is felt as far as subdivision mixes.
            if sim.points[*vertex].truncate().max_element() < 8.0 {
                let (own, other) = (value(ours, whole.row(vertex.index())), value(theirs, cut.row(corner.index())));
                assert!(own.distance(other) < 1e-5, "{uv}: corner {corner:?} has {own} instead of {other}");
                compared += 1;
            }
        }
        assert!(compared > sim.faces.corners().len() / 3);
    }
}

#[test]
fn no_triangle_of_garments_is_cut_off_from_its_shell() {
    for file in garments() {
        for options in [&[][..], &FREE] {
            let built = garment(&file, options);
            let cut_off = built.warnings.iter().map(ToString::to_string).find(|w| w.contains("would flip"));
            // One or two of a garment where no seam is a constraint, at knots of cuts.
            let few = ["1 triangle would flip", "2 triangles would flip"];
            let is_known = |told: &String| options == FREE && few.iter().any(|few| told.contains(few));
            assert_eq!(cut_off.filter(|told| !is_known(told)), None, "{file:?} with {options:?}");
        }
    }
}

#[test]
fn a_tube_that_is_one_shell_is_cut_once_along_itself() {
    // Around the tube once, so that one shell lies on both sides of its cut.
    let mut input = sheets::tube(12, 6);
    input.subsets.clear();
    input.families.clear();
    for uv in ["sim.uvSet=st", "sim.uvSet="] {
        let built = build(input.clone(), &[uv, "sim.maxEdgeLength=0.2", "cloth.rest=mesh"]);
        let own = shells(&built.products.sim, "st");
        assert_eq!(own.len(), 1, "{uv}: {own:?}");
        assert!(own[0].0 == 0 || own[0].1 == 0, "{uv}: {own:?}");
        assert!(built.warnings.is_empty(), "{:?}", built.warnings);
    }
}

/// Influences of the garment's vertices at a location, merged by the weights of subdivision, one at a time.
fn influences_at(built: &Built, product: &tailor::sim::SimProduct, at: &BaselinePoint) -> BTreeMap<i32, f64> {
    let base = &product.baseline;
    let mut weights: BTreeMap<VertexId, f64> = BTreeMap::new();
    for (k, corner) in base.topology.faces.corners_of(at.face).enumerate() {
        *weights.entry(base.level_vertex[base.topology.faces.vertex(corner)]).or_default() += f64::from(at.weights[k]);
    }
    for parent in base.parents().collect::<Vec<_>>().into_iter().rev() {
        let stencils = parent.vertex_stencils();
        let mut coarse: BTreeMap<VertexId, f64> = BTreeMap::new();
        for (vertex, weight) in weights {
            stencils.row(vertex.index(), &mut |v, w| *coarse.entry(v).or_default() += weight * f64::from(w));
        }
        weights = coarse;
    }
    let (indices, amounts) = joints::pair(&built.garment).expect("skinning");
    let all = joints::influences(indices, amounts);
    let mut merged = BTreeMap::new();
    for (vertex, weight) in weights {
        for &(joint, amount) in &all[base.manifold.vertex_source[vertex].index()] {
            *merged.entry(joint).or_default() += weight * f64::from(amount);
        }
    }
    merged
}

/// A turn and a shift for each joint, from nowhere in particular.
fn pose(joint: i32) -> (DMat3, DVec3) {
    let f = f64::from(joint);
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.7 * (1.3 * f).sin(), 0.9 * (2.1 * f).cos(), 0.4 * f.sin());
    (turn, DVec3::new((0.7 * f).cos(), (1.9 * f).sin(), (0.3 * f).sin()))
}

fn posed(point: DVec3, influences: impl Iterator<Item = (i32, f64)>) -> DVec3 {
    influences
        .map(|(joint, weight)| {
            let (turn, shift) = pose(joint);
            weight * (turn * point + shift)
        })
        .sum()
}

/// The number of vertices that skinning poses as the garment at their places, of those whose influences fit; 0 without skinning.
fn posed_alike(input: Garment) -> usize {
    let built = build(input, &[]);
    let Some((indices, amounts)) = joints::pair(&built.products.sim) else { return 0 };
    let own: Vec<Influences> = joints::influences(indices, amounts);
    let product = built.product();
    let points = &product.points;
    let (low, high) =
        points.iter().fold((points[VertexId::new(0)], points[VertexId::new(0)]), |b, p| (b.0.min(*p), b.1.max(*p)));
    let size = f64::from(low.distance(high));
    let mut place: BTreeMap<VertexId, BaselinePoint> = BTreeMap::new();
    for (v, p) in product.triangles.iter().flatten().zip(product.places.iter()) {
        place.entry(*v).or_insert(p.location);
    }
    let mut checked = 0;
    for (vertex, at) in place {
        let wanted = influences_at(&built, &product, &at);
        if wanted.values().filter(|w| w.abs() > 1e-9).count() > indices.width() {
            continue;
        }
        let point = points[vertex].as_dvec3();
        let sum: f64 = wanted.values().sum();
        let a = posed(point, own[vertex.index()].iter().map(|&(j, w)| (j, f64::from(w))));
        let b = posed(point, wanted.into_iter());
        assert!((sum - 1.0).abs() < 1e-3 && a.distance(b) <= 1e-5 * size, "{vertex:?}: {a} instead of {b}");
        checked += 1;
    }
    checked
}

fn input_of(file: &Path) -> Garment {
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    source.garment().unwrap_or_else(|e| panic!("{e}")).0
}

#[test]
fn skinning_poses_the_mesh_as_the_input_at_its_places() {
    let examples = ["coat.usda", "trousers.usda", "tshirt.usda"].map(|name| input_of(&named(name)));
    let checked: usize = examples.into_iter().chain([sheet(6, 6)]).map(posed_alike).sum();
    assert!(checked > 1000, "{checked} vertices whose influences fit");
}

#[test]
fn skinning_poses_the_meshes_of_garments() {
    let is_skinned = |input: &Garment| input.primvars.iter().any(|p| p.name == joints::JOINT_INDICES);
    let inputs = garments().into_iter().map(|file| input_of(&file));
    inputs.filter(is_skinned).for_each(|input| assert!(posed_alike(input) > 0, "no influences fit"));
}

#[test]
fn blend_shapes_move_both_products_as_the_garment() {
    let input = sheet(5, 5);
    let offset = |i: usize| [0.1 * i as f32, (i as f32).sin(), -0.02 * (i * i) as f32];
    let values: Vec<f32> = (0..input.points.len()).flat_map(offset).collect();
    let mut moved = input.clone();
    moved.points.iter_mut().enumerate().for_each(|(i, p)| *p += glam::Vec3::from(offset(i)));
    let mut input = input;
    let name = "/Coat/model/bent.offsets";
    let role = PrimvarRole::BlendShape { shape: 0, property: "offsets".into() };
    input.primvars.push(PrimvarInput { role, ..primvar(name, Interpolation::Vertex, 3, Values::F32(values)) });
    let (built, other) = (build(input, &["render.level=2"]), build(moved, &["render.level=2"]));
    let (_, offsets) = floats(&built.products.render, name);
    for (i, (p, q)) in built.products.render.points.iter().zip(other.products.render.points.iter()).enumerate() {
        let moved = *p + glam::Vec3::new(offsets[3 * i], offsets[3 * i + 1], offsets[3 * i + 2]);
        assert!(moved.distance(*q) < 1e-4, "render point {i}: {moved} instead of {q}");
    }
    // On the simulation mesh: the moved baseline at the same locations.
    let (_, offsets) = floats(&built.products.sim, name);
    let (here, there) = (built.product(), other.product());
    for (v, place) in here.triangles.iter().flatten().zip(here.places.iter()) {
        let i = v.index();
        let moved = here.points[*v] + glam::Vec3::new(offsets[3 * i], offsets[3 * i + 1], offsets[3 * i + 2]);
        let triangle = here.baseline.topology.faces.vertices_of(place.location.face);
        let wanted = triangle
            .iter()
            .zip(place.location.weights.to_array())
            .map(|(&v, w)| there.baseline.points[v] * w)
            .sum::<glam::Vec3>();
        assert!(moved.distance(wanted) < 1e-3, "{v:?}: {moved} instead of {wanted}");
    }
}

#[test]
fn provenance_leads_back_to_the_garment() {
    let built = build(sheet(6, 4), &["sim.provenance=true", "sim.maxEdgeLength=0.4"]);
    let (garment, sim) = (&built.garment, &built.products.sim);
    let Values::I32(faces) = &sim.primvar(SOURCE_FACE).expect("faces").values else { panic!("faces are integers") };
    let (_, coordinates) = floats(sim, SOURCE_COORDS);
    for (i, point) in sim.points.iter().enumerate() {
        let face = FaceId::new(faces[i] as usize);
        let (u, v) = (coordinates[2 * i], coordinates[2 * i + 1]);
        assert!((-1e-5..=1.00001).contains(&u) && (-1e-5..=1.00001).contains(&v));
        // x and y of the sheet are those of its points, and subdivision keeps them except for its border.
        let corner = |k: usize| garment.points[garment.faces.vertices_of(face)[k]];
        let weight = |k: usize| {
            let [x, y] = corner_coordinates(4, k);
            (1.0 - (u - x).abs()) * (1.0 - (v - y).abs())
        };
        let linear: glam::Vec3 = (0..4).map(|k| corner(k) * weight(k)).sum();
        assert!((linear - *point).truncate().length() < 0.2, "vertex {i} at {point}, its face says {linear}");
    }
    assert!(build(sheet(2, 2), &[]).products.sim.primvar(SOURCE_FACE).is_none());
}

#[test]
fn uniform_values_are_means_and_majorities() {
    let mut input = sheet(8, 8);
    let n = 64;
    let colours = (0..n).flat_map(|i| if (i % 8 + i / 8) % 2 == 0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
    input.primvars.push(primvar("colour", Interpolation::Uniform, 3, Values::F32(colours.collect())));
    input.primvars.push(primvar(
        "name",
        Interpolation::Uniform,
        1,
        Values::Text((0..n).map(|i| format!("f{i}")).collect()),
    ));
    // Ten million values.
    let wide = Values::F32((0..10_000_000).map(|i| (i / 156_250) as f32).collect());
    input.primvars.push(PrimvarInput { element_size: 156_250, ..primvar("wide", Interpolation::Uniform, 1, wide) });
    let built = build(input, &["sim.uvSet=", "sim.maxEdgeLength=1.2"]);
    let sim = &built.products.sim;
    let (_, colours) = floats(sim, "colour");
    for colour in colours.chunks(3) {
        assert!((colour[0] + colour[2] - 1.0).abs() < 1e-5 && colour[1] == 0.0, "{colour:?}");
    }
    let Values::Text(names) = &sim.primvar("name").expect("names").values else { panic!("names are text") };
    assert!(names.iter().all(|n| n.starts_with('f')) && names.len() == sim.faces.len());
    let (wide, values) = floats(sim, "wide");
    assert_eq!(values.len(), 156_250 * sim.faces.len());
    assert_eq!(wide.width(), 156_250);
    assert!(values.chunks(156_250).all(|row| row.iter().all(|x| *x == row[0] && (0.0..64.0).contains(x))));
}

/// Normals of a polygonal sheet, as the attribute that they are: those of its faces, or turned from them.
fn with_normals(turn: f32) -> Garment {
    let mut input = sheet(6, 6);
    input.rules.scheme = tailor_mesh::garment::Scheme::None;
    let product = build(input.clone(), &["sim.baselineLevel=0"]);
    let t = Topology::new(product.garment.faces.clone(), product.garment.points.len());
    let mut all = vec![glam::Vec3::ZERO; input.points.len()];
    for corner in t.faces.corners().ids() {
        let at = |c: CornerId| product.garment.points[t.faces.vertex(c)];
        let (a, b) = (at(t.faces.next(corner)) - at(corner), at(t.faces.prev(corner)) - at(corner));
        all[t.faces.vertex(corner).index()] += a.cross(b);
    }
    let turned = all.iter().map(|n| glam::Quat::from_rotation_x(turn) * n.normalize());
    let values = Values::F32(turned.flat_map(|n| n.to_array()).collect());
    let normals = primvar("normals", Interpolation::Vertex, 3, values);
    input.primvars.push(PrimvarInput { role: PrimvarRole::Normals, meaning: Meaning::Normal, ..normals });
    input
}

#[test]
fn normals_of_the_faces_are_made_again_and_others_carried() {
    for (turn, made) in [(0.0, true), (0.5, false)] {
        let built = build(with_normals(turn), &["sim.maxEdgeLength=0.4"]);
        let sim = &built.products.sim;
        let (_, values) = floats(sim, "normals");
        let normal = |i: usize| glam::Vec3::from_slice(&values[3 * i..]);
        assert!((0..sim.points.len()).all(|i| (normal(i).length() - 1.0).abs() < 1e-5), "of unit length");
        let t = Topology::new(sim.faces.clone(), sim.points.len());
        let off = t.faces.corners().ids().map(|c| {
            let at = |c: CornerId| sim.points[t.faces.vertex(c)];
            let face = (at(t.faces.next(c)) - at(c)).cross(at(t.faces.prev(c)) - at(c)).normalize();
            face.angle_between(normal(t.faces.vertex(c).index()))
        });
        let mean = off.sum::<f32>() / t.faces.corners().len() as f32;
        assert_eq!(mean < 0.1, made, "turned by {turn}: {mean} from the faces");
    }
}

#[test]
fn values_of_corners_that_are_no_numbers_are_taken_as_they_are() {
    let mut input = sheet(4, 4);
    let names = Values::Text((0..64).map(|i| format!("corner {i}")).collect());
    input.primvars.push(primvar("names", Interpolation::FaceVarying, 1, names));
    let flags = Values::Bool((0..25).map(|i| i % 2 == 0).collect());
    input.primvars.push(primvar("flags", Interpolation::Vertex, 1, flags));
    let built = build(input, &["sim.maxEdgeLength=0.4"]);
    let sim = &built.products.sim;
    let of = |name: &str| sim.primvar(name).unwrap_or_else(|| panic!("no {name}"));
    assert_eq!(of("names").elements(), sim.faces.corners().len());
    assert_eq!(of("flags").elements(), sim.points.len());
    let (Values::Text(names), Values::Bool(_)) = (&of("names").values, &of("flags").values) else { panic!("types") };
    assert!(names.iter().all(|n| n.starts_with("corner ")));
}
