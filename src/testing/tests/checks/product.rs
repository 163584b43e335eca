//! The checker of products: every invariant that a simulation mesh and a render mesh must have, each by its name.
//!
//! Written against the input and the products alone, apart from the baseline, the surface that a simulation mesh is
//! held to.

use super::attributes::{family_faults, primvar_faults, subset_faults};
use super::refinement::refinement_faults;
use crate::prepared::baseline_of;
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use tailor::render::{RenderOptions, RenderSteps, Stack};
use tailor::sim::{SimProduct, simulate};
use tailor_costume::recipe::Layers;
use tailor_costume::{Builder, Products};
use tailor_mesh::connectivity::{ChainId, CornerId, EdgeId, Topology, VertexId};
use tailor_mesh::garment::{BoundaryInterpolation, Garment, Interpolation, Mesh, Values};

/// Distance of a vertex from where its corner says it is, and from its chain's curve, as a share of the target length.
const ON_SURFACE: f32 = 1e-3;
/// Refined positions agree with the independent rules to this share of the bounding box.
pub const REFINED: f32 = 1e-5;

/// The bounds that differ between subjects.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Largest distance between the simulation mesh and the baseline, as a share of the target length.
    pub distance: f32,
    /// Largest part of a chain's length that chords cut off.
    pub chain: f32,
    /// Area of each triangle, more than this share of its longest edge squared.
    pub area: f64,
}

/// Those of garments, whose edges are made to follow their folds.
pub const GARMENT: Bounds = Bounds { distance: 0.5, chain: 0.02, area: 5e-6 };

/// A bound that no garment here reaches.
const MAX_FACES: usize = 1_000_000;

/// A garment, its products, and all that was found wrong with them.
pub struct Subject {
    name: String,
    pub garment: Mesh,
    pub products: Products,
    pub product: SimProduct,
    faults: Vec<String>,
}

impl Subject {
    /// Builds a garment.
    ///
    /// # Errors
    /// An error of the pipeline.
    pub fn build(name: &str, input: Garment, layers: &Layers) -> Result<Self, String> {
        let said = |e: tailor_mesh::Error| format!("{name}: {e}");
        let mut builder = Builder::new(input).map_err(said)?.with_max_faces(MAX_FACES);
        let products = builder.update(&layers.recipe().map_err(said)?).map_err(said)?;
        let sim = &products.recipe.sim;
        let baseline = baseline_of(builder.garment(), sim).map_err(said)?;
        let product = simulate(baseline, sim, 4 * MAX_FACES);
        Ok(Self { name: name.into(), garment: (**builder.garment()).clone(), products, product, faults: Vec::new() })
    }

    /// Checks both products.
    pub fn check(mut self, bounds: Bounds) -> Result<(), String> {
        self.the_pipeline_gives_what_simulate_gives();
        self.sim_surface(bounds);
        self.sim_lies_on_the_baseline(bounds);
        self.sim_has_the_topology_of_the_garment();
        self.chains_are_kept(bounds);
        self.uvs_are_not_flipped();
        self.uvs_are_cut_at_seams_alone();
        self.attributes("sim", &self.products.sim.clone());
        self.render_levels();
        let (name, faults) = (self.name, self.faults);
        if faults.is_empty() { Ok(()) } else { Err(format!("{name}:\n  {}", faults.join("\n  "))) }
    }

    /// Notes a fault unless `holds`; only the first few of a check.
    fn expect(&mut self, check: &str, holds: bool, fault: impl FnOnce() -> String) {
        const TOLD: usize = 3;
        if !holds && self.faults.iter().filter(|f| f.starts_with(check)).count() < TOLD {
            self.faults.push(format!("{check}: {}", fault()));
        }
    }

    fn the_pipeline_gives_what_simulate_gives(&mut self) {
        let same = *self.products.sim.points == *self.product.points;
        self.expect("same", same, || "two runs give different points".into());
    }

    /// Triangles, manifold, of one winding, of some area, all numbers finite. Where the surface has parts without area,
    /// so may the mesh: they are kept, with a warning.
    fn sim_surface(&mut self, bounds: Bounds) {
        let base = &self.product.baseline;
        let flat = base.topology.faces.ids().any(|f| area(&base.triangle(f).map(|p| p.as_dvec3())) <= GARMENT.area);
        let mesh = &self.products.sim;
        let t = Topology::new(mesh.faces.clone(), mesh.points.len());
        let points = mesh.points.clone();
        for face in t.faces.ids() {
            let vertices = t.faces.vertices_of(face).to_vec();
            self.expect("triangles", vertices.len() == 3, || format!("{face:?} has {} corners", vertices.len()));
            let p: Vec<_> = vertices.iter().map(|&v| points[v].as_dvec3()).collect();
            self.expect("area", flat || area(&p) > bounds.area, || format!("{face:?} at {p:?} has no area"));
        }
        for (vertex, p) in points.enumerated() {
            self.expect("finite", p.is_finite(), || format!("{vertex:?} is at {p}"));
        }
        for edge in t.edges.ids() {
            let corners = t.edge_corners.row(edge).to_vec();
            let ends = t.edges[edge];
            self.expect("manifold", corners.len() <= 2, || format!("edge {ends:?} has {} faces", corners.len()));
            if let &[a, b] = corners.as_slice() {
                let opposed = t.faces.vertex(a) != t.faces.vertex(b);
                self.expect("winding", opposed, || format!("the faces at edge {ends:?} disagree"));
            }
        }
        for (vertex, fans) in fans(&t) {
            self.expect("one fan", fans == 1, || format!("{vertex:?} has {fans} fans"));
        }
    }

    /// All rules of subdivision that are in use average, so that nothing leaves the box of the garment.
    fn in_the_box(&mut self, which: &str, mesh: &Mesh) {
        let all = self.garment.points.iter();
        let (low, high) = all.fold((Vec3::MAX, Vec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
        let slack = Vec3::splat(1e-5 * (low.distance(high) + high.abs().max_element()));
        for (vertex, &p) in mesh.points.enumerated() {
            let inside = p.cmpge(low - slack).all() && p.cmple(high + slack).all();
            self.expect(&format!("{which} in the box"), inside, || format!("{vertex:?} is at {p}"));
        }
    }

    fn sim_lies_on_the_baseline(&mut self, bounds: Bounds) {
        let Self { product, .. } = self;
        let mut off = Vec::new();
        for (i, triangle) in product.triangles.iter().enumerate() {
            for (k, &vertex) in triangle.iter().enumerate() {
                let location = product.places[CornerId::new(3 * i + k)].location;
                let weights = location.weights.to_array();
                let inside = weights.iter().all(|w| (-1e-5..=1.0 + 1e-5).contains(w));
                let sums = (weights.iter().sum::<f32>() - 1.0).abs() < 1e-4;
                let distance = product.baseline.position(location).distance(product.points[vertex]);
                let near = distance <= ON_SURFACE * product.target[vertex];
                if !(inside && sums && near) {
                    off.push(format!("{vertex:?} is {distance} from its place {location:?}"));
                }
            }
        }
        off.into_iter().for_each(|fault| self.expect("on the baseline", false, || fault));
        let farthest = self.products.sim_figures().distance_max;
        self.expect("distance", farthest <= bounds.distance, || {
            format!("the mesh is {farthest} of the target length from the baseline")
        });
    }

    /// Components with their Euler characteristic and border loops: those of the baseline, and, where the garment is
    /// manifold as it is, those of the garment.
    fn sim_has_the_topology_of_the_garment(&mut self) {
        let own = pieces(&Topology::new(self.products.sim.faces.clone(), self.products.sim.points.len()));
        let baseline = pieces(&self.product.baseline.topology);
        self.expect("pieces of the baseline", own == baseline, || format!("{own:?} instead of {baseline:?}"));
        let g = &self.garment;
        let t = Topology::new(g.faces.clone(), g.points.len());
        let plain = g.holes.is_empty() && g.rules.boundary != BoundaryInterpolation::None;
        let manifold = t.edges.ids().all(|e| agrees(&t, e)) && fans(&t).values().all(|&n| n == 1);
        if plain && manifold && !has_flat_faces(g) {
            let garment = pieces(&t);
            self.expect("pieces of the garment", own == garment, || format!("{own:?} instead of {garment:?}"));
        }
    }

    /// Each chain is a path or loop of edges of the mesh, on its curve and as long.
    fn chains_are_kept(&mut self, bounds: Bounds) {
        let mesh = Topology::new(self.products.sim.faces.clone(), self.products.sim.points.len());
        let chains: Vec<ChainId> = self.product.baseline.chains.ids().collect();
        for id in chains {
            let faults = chain_faults(&self.product, &mesh, id, bounds);
            faults.into_iter().for_each(|(check, fault)| self.expect(check, false, || format!("{id:?} {fault}")));
        }
    }

    /// No triangle lies the wrong way round in UV space, if none of the baseline does.
    fn uvs_are_not_flipped(&mut self) {
        let base = &self.product.baseline;
        let flipped = base.topology.faces.ids().filter(|&f| base.uv_area(f) * base.facets[f].sense <= 0.0).count();
        let (own, all) = (self.products.sim_figures().uv_flips, self.product.triangles.len());
        if base.has_uvs && flipped == 0 {
            self.expect("UV flips", own == 0, || format!("{own} of {all} triangles"));
        }
    }

    /// Across an edge that is not a seam both faces have the same UVs, bit for bit.
    fn uvs_are_cut_at_seams_alone(&mut self) {
        let recipe = &self.products.recipe.sim;
        let mesh = &self.products.sim;
        let Some(uv) = mesh.primvar(&recipe.uv_set).filter(|p| p.interpolation == Interpolation::FaceVarying) else {
            return;
        };
        let Values::F32(values) = &uv.values else { return };
        let at = |c: CornerId| (uv.row(c.index()), values[uv.row(c.index()) * 2..][..2].to_vec());
        let t = Topology::new(mesh.faces.clone(), mesh.points.len());
        let seams: BTreeSet<[VertexId; 2]> = self
            .product
            .baseline
            .chains
            .enumerated()
            .filter(|(_, c)| c.kind.seam)
            .flat_map(|(id, _)| self.product.chain_edges[id].iter().map(|&[a, b]| [a.min(b), a.max(b)]))
            .collect();
        let mut faults = Vec::new();
        for edge in t.edges.ids() {
            let &[a, b] = t.edge_corners.row(edge) else { continue };
            let [x, y] = t.edges[edge];
            let same = at(a) == at(t.faces.next(b)) && at(t.faces.next(a)) == at(b);
            if !same && !seams.contains(&[x.min(y), x.max(y)]) {
                faults.push(format!("at edge {x:?} {y:?}, which is not a seam"));
            }
        }
        faults.into_iter().for_each(|fault| self.expect("UVs cut", false, || fault));
    }

    /// Subsets, families and primvars of a product.
    fn attributes(&mut self, which: &str, mesh: &Mesh) {
        self.in_the_box(which, mesh);
        let t = Topology::new(mesh.faces.clone(), mesh.points.len());
        for fault in subset_faults(mesh, &t) {
            self.expect(&format!("{which} subsets"), false, || fault);
        }
        for fault in family_faults(mesh) {
            self.expect(&format!("{which} families"), false, || fault);
        }
        for fault in primvar_faults(mesh, &self.garment) {
            self.expect(&format!("{which} primvars"), false, || fault);
        }
        for crease in &mesh.creases {
            let steps = crease.vertices.windows(2).all(|p| t.find_edge(p[0], p[1]).is_some());
            let fits = crease.sharpnesses.len() + 1 == crease.vertices.len();
            self.expect(&format!("{which} creases"), steps && fits, || format!("{crease:?}"));
        }
        for subset in self.garment.subsets.clone().iter() {
            let kept = mesh.subset(&subset.name).is_some_and(|s| s.elements.kind() == subset.elements.kind());
            self.expect(&format!("{which} subsets"), kept, || format!("{} is lost", subset.name));
        }
    }

    /// The levels 0, 1 and 2 of the render mesh, each from the one before.
    fn render_levels(&mut self) {
        let recipe = self.products.recipe.clone();
        let level = |level| {
            let options = RenderOptions { level, ..recipe.render.clone() };
            let stack = Stack::new(&options, &recipe.operators());
            let garment = Arc::new(self.garment.clone());
            let made =
                stack.and_then(|stack| RenderSteps::new(Arc::clone(&garment)).update(&stack)).map(|made| made.mesh);
            made.unwrap_or_else(|e| panic!("render level {level}: {e}"))
        };
        let levels = [0, 1, 2].map(level);
        let cage = &levels[0];
        let same = *cage.points == *self.garment.points && cage.faces.corners() == self.garment.faces.corners();
        let plain = recipe.operators().is_empty();
        self.expect("render level 0", same || !plain, || "it is not the garment as it is".into());
        let built = &self.products.render;
        let wanted = levels.get(self.products.recipe.render.level as usize);
        self.expect("same", wanted.is_none_or(|w| *w.points == *built.points), || "render differs from build".into());
        for (i, mesh) in levels.iter().enumerate() {
            self.attributes(&format!("render level {i}"), mesh);
        }
        for (i, pair) in levels.windows(2).enumerate() {
            for fault in refinement_faults(&pair[0], &pair[1]) {
                self.expect(&format!("render level {}", i + 1), false, || fault);
            }
        }
    }
}

/// Area of a triangle as a share of its longest edge squared.
fn area(p: &[DVec3]) -> f64 {
    let longest = (0..3).map(|k| p[k].distance_squared(p[(k + 1) % 3])).fold(f64::MIN_POSITIVE, f64::max);
    0.5 * (p[1] - p[0]).cross(p[2] - p[0]).length() / longest
}

/// Whether an edge has one face, or two that agree in winding.
pub fn agrees(t: &Topology, edge: EdgeId) -> bool {
    match *t.edge_corners.row(edge) {
        [_] => true,
        [a, b] => t.faces.vertex(a) != t.faces.vertex(b),
        _ => false,
    }
}

/// Whether a face of the garment has no area, and is dropped.
fn has_flat_faces(g: &Mesh) -> bool {
    g.faces.ids().any(|f| {
        let p: Vec<_> = g.faces.vertices_of(f).iter().map(|&v| g.points[v].as_dvec3()).collect();
        let doubled: DVec3 = (1..p.len() - 1).map(|k| (p[k] - p[0]).cross(p[k + 1] - p[0])).sum();
        let longest = p.iter().map(|a| a.distance_squared(p[0])).fold(0.0, f64::max);
        doubled.length() <= 1e-6 * longest
    })
}

/// For each vertex the number of groups of corners that are joined through edges of two faces; none without corners.
pub fn fans(t: &Topology) -> BTreeMap<VertexId, usize> {
    let mut fans = BTreeMap::new();
    for vertex in (0..t.vertex_count()).map(VertexId::new) {
        let corners = t.vertex_corners.row(vertex);
        let mut group: Vec<usize> = (0..corners.len()).collect();
        let edge_of = |c: CornerId| [t.corner_edge[c], t.corner_edge[t.faces.prev(c)]];
        for i in 0..corners.len() {
            for j in 0..i {
                let shared = edge_of(corners[i])
                    .iter()
                    .any(|e| edge_of(corners[j]).contains(e) && t.edge_corners.row(*e).len() == 2);
                if shared && group[i] != group[j] {
                    let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                    group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
                }
            }
        }
        fans.insert(vertex, group.iter().collect::<BTreeSet<_>>().len());
    }
    fans
}

/// Euler characteristic and number of border loops of each component, sorted. Vertices without a face do not count.
fn pieces(t: &Topology) -> Vec<(i64, usize)> {
    let mut parent: Vec<usize> = (0..t.vertex_count()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    for &[a, b] in t.edges.iter() {
        let (a, b) = (root(&mut parent, a.index()), root(&mut parent, b.index()));
        parent[a.max(b)] = a.min(b);
    }
    let mut counts: BTreeMap<usize, (i64, usize)> = BTreeMap::new();
    for v in (0..t.vertex_count()).filter(|&v| !t.vertex_corners.row(VertexId::new(v)).is_empty()) {
        counts.entry(root(&mut parent, v)).or_default().0 += 1;
    }
    let mut border: BTreeMap<VertexId, VertexId> = BTreeMap::new();
    for (edge, &[a, _]) in t.edges.enumerated() {
        counts.entry(root(&mut parent, a.index())).or_default().0 -= 1;
        if let &[corner] = t.edge_corners.row(edge) {
            border.insert(t.faces.vertex(corner), t.faces.vertex(t.faces.next(corner)));
        }
    }
    for face in t.faces.ids() {
        counts.entry(root(&mut parent, t.faces.vertices_of(face)[0].index())).or_default().0 += 1;
    }
    while let Some((start, mut at)) = border.pop_first() {
        counts.entry(root(&mut parent, start.index())).or_default().1 += 1;
        while let Some(next) = border.remove(&at) {
            at = next;
        }
    }
    let mut all: Vec<(i64, usize)> = counts.into_values().collect();
    all.sort_unstable();
    all
}

/// The faults of one chain on the simulation mesh.
fn chain_faults(product: &SimProduct, mesh: &Topology, id: ChainId, bounds: Bounds) -> Vec<(&'static str, String)> {
    let (chain, edges) = (&product.baseline.chains[id], &product.chain_edges[id]);
    let mut faults = Vec::new();
    let (Some(first), Some(last)) = (edges.first(), edges.last()) else {
        return vec![("chain path", "has no edge".into())];
    };
    if let Some(gap) = edges.windows(2).position(|p| p[0][1] != p[1][0]) {
        faults.push((
            "chain path",
            format!("is broken after edge {gap} of {}: {:?}", edges.len(), &edges[gap..=gap + 1]),
        ));
    }
    let point = |v: VertexId| product.baseline.points[v];
    if chain.is_loop {
        if last[1] != first[0] {
            faults.push(("chain path", "does not close".into()));
        }
    } else {
        let ends = [(first[0], chain.vertices[0]), (last[1], chain.vertices[chain.vertices.len() - 1])];
        for (own, anchor) in ends {
            if product.points[own] != point(anchor) {
                faults.push(("anchors", format!("ends at {} instead of {}", product.points[own], point(anchor))));
            }
        }
    }
    if let Some([a, b]) = edges.iter().find(|[a, b]| mesh.find_edge(*a, *b).is_none()) {
        faults.push(("chain path", format!("goes from {a:?} to {b:?}, which is not an edge")));
    }
    for &[v, _] in edges {
        let p = product.points[v];
        let to_segment = |pair: &[VertexId]| {
            let (a, b) = (point(pair[0]), point(pair[1]));
            let t = ((p - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            p.distance(a.lerp(b, t))
        };
        let off = chain.vertices.windows(2).map(to_segment).fold(f32::MAX, f32::min);
        // Far from the origin a place is not finer than the numbers there.
        if off > ON_SURFACE * product.target[v] + 4.0 * f32::EPSILON * p.abs().max_element() {
            faults.push(("chain curve", format!("has {v:?} {off} off its curve")));
        }
    }
    let own: f64 = edges.iter().map(|&[a, b]| f64::from(product.points[a].distance(product.points[b]))).sum();
    // Chords cut corners: what can be asked for is the length of as many edges, evenly spaced on the curve.
    let curve: Vec<_> = chain.vertices.iter().map(|&v| point(v).as_dvec3()).collect();
    let (whole, even) = (length(&curve), length(&resampled(&curve, edges.len())));
    if own > 1.001 * whole || own < (1.0 - f64::from(bounds.chain)) * even {
        let n = edges.len();
        faults.push(("chain length", format!("is {own} long instead of {whole}, or {even} in {n} even edges")));
    }
    faults
}

/// Length of a path.
fn length(path: &[DVec3]) -> f64 {
    path.windows(2).map(|p| p[0].distance(p[1])).sum()
}

/// A path with `n` edges whose ends lie evenly along another.
fn resampled(path: &[DVec3], n: usize) -> Vec<DVec3> {
    let step = length(path) / n as f64;
    let (mut out, mut passed) = (vec![path[0]], 0.0);
    for pair in path.windows(2) {
        let own = pair[0].distance(pair[1]);
        while out.len() < n && passed + own >= step * out.len() as f64 && own > 0.0 {
            out.push(pair[0].lerp(pair[1], (step * out.len() as f64 - passed) / own));
        }
        passed += own;
    }
    out.push(path[path.len() - 1]);
    out
}
