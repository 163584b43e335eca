"""The simulation mesh: a sound triangle mesh that lies on the baseline, with the panels, sets and values of its source."""

from dataclasses import replace

import numpy as np
import pytest
from mesh import Children, border_loops, components, own_material, recipe, starts
from pxr import UsdGeom
from sources import sheet, write
from surface import distance_to_segments, distance_to_triangles, ragged, triangles_of
from test_render import no_new_values

# Sine of the angle by which a triangle on a fold may lean over.
EDGE_ON = 0.1
# Shares of the diagonal of the source's box.
ON_SURFACE = 1e-4
ON_CURVE = 1e-3
# Chords of coarse triangles are shorter than the curves and smaller than the panels they stand for.
SET_AREA = 0.10
CURVE_LENGTH = 0.10


class Baseline:
    """The surface that the simulation mesh lies on: the render mesh of the same level."""

    def __init__(self, product, level=None):
        self.source = product.source
        self.level = recipe(self.source.prim, "sim.baselineLevel", 2) if level is None else level
        faces = len(self.source.indices) * 4 ** (self.level - 1) if self.level else len(self.source.counts)
        is_same = len(product.render.counts) == faces
        self.mesh = product.render if is_same else product.again("--set", f"render.level={self.level}").render
        self.children = Children(self.source, self.mesh, self.level)
        self.size = np.linalg.norm(np.ptp(self.source.points, axis=0))
        corners, _ = triangles_of(self.mesh.counts, self.mesh.indices)
        self.triangles = self.mesh.points[corners]

    @property
    def quads(self):
        """The corners of each face, from level 1 on."""
        return self.mesh.points[self.mesh.indices.reshape(-1, 4)]

    def curve(self, edges):
        """The segments that edges of the source become."""
        return self.mesh.points[self.mesh.topology.edges[self.children.edges(edges)]]

    def face_areas(self):
        """The area of each face of the source, subdivided."""
        return np.bincount(self.children.parent_face, weights=self.mesh.face_areas)


@pytest.fixture
def baseline(product):
    if not hasattr(product, "baseline"):
        product.baseline = Baseline(product)
    return product.baseline


def is_manifold(mesh):
    return not mesh.topology.non_manifold_edges().any() and (mesh.topology.fans() <= 1).all()


def edge_lengths(mesh):
    ends = mesh.points[mesh.topology.edges]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), np.finfo(float).tiny)


def length(segments):
    return np.linalg.norm(segments[:, 0] - segments[:, 1], axis=1).sum()


def test_is_a_plain_triangle_mesh(product):
    sim = product.sim
    assert set(sim.counts) == {3}
    assert sim.scheme == "none"
    assert sim.orientation == product.source.orientation
    assert UsdGeom.Imageable(sim.prim).GetPurposeAttr().Get() == "guide"
    assert np.isfinite(sim.points).all()
    assert len(np.unique(sim.indices)) == len(sim.points), "points without a triangle"
    assert (np.sort(sim.indices.reshape(-1, 3), axis=1)[:, 1:] > np.sort(sim.indices.reshape(-1, 3), axis=1)[:, :-1]).all()


def test_is_manifold_and_wound_one_way(product):
    sim = product.sim
    assert not sim.topology.non_manifold_edges().any()
    assert (sim.topology.fans() == 1).all(), "bow-tie vertices"
    assert len(np.unique(np.sort(sim.indices.reshape(-1, 3), axis=1), axis=0)) == len(sim.counts), "a triangle occurs twice"


def test_has_no_degenerate_triangle(product):
    corners = product.sim.points[product.sim.indices.reshape(-1, 3)]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert (2 * product.sim.face_areas / sides.max(axis=1) > 1e-4 * sides.mean()).all()


def fine_faces_at(baseline, faces, points):
    """The face of the baseline at each point: of the children of the source's face there, that of the nearest centre."""
    count = baseline.children.face_children[faces]
    owner, step = ragged(count)
    child = baseline.children.first_child[faces][owner] + step
    apart = np.linalg.norm(points[owner] - baseline.mesh.face_centres[child], axis=1)
    ranked = np.lexsort([apart, owner])
    return child[ranked[starts(count)]]


def one_way(mesh):
    """For each face whether those of its piece agree in winding: no two run along an edge the same way."""
    topology = mesh.topology
    ways, half = np.unique(np.stack([mesh.indices, mesh.indices[topology.next_corner]], axis=1), axis=0, return_inverse=True)
    doubled = (np.bincount(half.ravel(), minlength=len(ways)) > 1)[half.ravel()]
    pieces = components(topology, mesh.indices)
    return ~np.isin(pieces, pieces[topology.corner_face[doubled]])


def test_faces_the_way_its_source_does(product, baseline):
    """The normal of each face agrees with those of the source at the places where its corners came from."""
    sim = product.traced.sim
    faces = sim.primvars["tailor:sourceFace"].flat[:, 0].astype(int)
    quads = baseline.quads
    normals = unit(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]))
    corners = sim.indices.reshape(-1, 3)
    there = normals[fine_faces_at(baseline, faces, sim.points)][corners]
    points = sim.points[corners]
    agree = (there * unit(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]))[:, None]).sum(axis=2)
    # On a fold the corners see either side of it.
    is_smooth = (there * np.roll(there, 1, axis=1)).sum(axis=2).min(axis=1) > 0.5
    wound = one_way(product.source)[faces][corners].all(axis=1)
    assert not wound.any() or is_smooth[wound].mean() > 0.89
    assert (agree[wound & is_smooth] > 0).all()
    # One that bridges a fold may stand on edge.
    assert (agree[wound & ~is_smooth] > -EDGE_ON).any(axis=1).all()
    # Where the source's faces disagree, the few are turned to the side of the many.
    assert wound.all() or (agree[~wound] > 0).any(axis=1).mean() > 0.9


def test_source_coordinates_name_the_place(product, baseline):
    """On faces of four corners: which child, halving by halving, and where on it under one of its two splits."""
    sim = product.traced.sim
    faces = sim.primvars["tailor:sourceFace"].flat[:, 0].astype(int)
    (s, t), on_quads = sim.primvars["tailor:sourceCoords"].flat.T, baseline.source.counts[faces] == 4
    child = np.zeros(len(faces), int)
    for _ in range(baseline.level):
        right, up = s >= 0.5, t >= 0.5
        child = 4 * child + np.where(up, np.where(right, 2, 3), right)
        s, t = 2 * s - right, 2 * t - up
    a, b, c, d = np.moveaxis(baseline.quads[(baseline.children.first_child[faces] + child)[on_quads]], 1, 0)
    s, t = s[on_quads, None], t[on_quads, None]
    first = np.where(s >= t, a + s * (b - a) + t * (c - b), a + t * (d - a) + s * (c - d))
    second = np.where(s + t <= 1, a + s * (b - a) + t * (d - a), c + (1 - s) * (d - c) + (1 - t) * (b - c))
    away = np.minimum(*(np.linalg.norm(sim.points[on_quads] - place, axis=1) for place in (first, second)))
    assert away.max(initial=0) <= ON_SURFACE * baseline.size


def test_points_lie_on_the_baseline(product, baseline):
    away = distance_to_triangles(product.sim.points, baseline.triangles, reach=ON_SURFACE * baseline.size)
    assert np.isfinite(away).all(), f"{np.isinf(away).sum()} points are further than {ON_SURFACE} of the box, first {np.isinf(away).argmax()}"


def test_covers_the_baseline(product, baseline):
    triangles = product.sim.points[product.sim.indices.reshape(-1, 3)]
    reach = edge_lengths(product.sim).max()
    away = distance_to_triangles(baseline.mesh.points[:: max(1, len(baseline.mesh.points) // 3000)], triangles, reach)
    assert np.isfinite(away).all(), f"{np.isinf(away).sum()} samples of the baseline are not covered"


def test_has_the_pieces_and_borders_of_its_source(product):
    """Cutting what is not manifold may add borders, and says so."""
    source, sim = product.source, product.sim
    pieces = [components(mesh.topology, mesh.indices).max() + 1 for mesh in (source, sim)]
    loops = [border_loops(mesh.topology) for mesh in (source, sim)]
    if is_manifold(source):
        assert pieces[1] == pieces[0]
        assert loops[1] == loops[0]
    else:
        assert pieces[1] >= pieces[0]
        assert product.warnings, "the source is not manifold and nothing was said"


def test_borders_lie_on_the_borders_of_the_baseline(product, baseline):
    source, sim = product.source.topology, product.sim.topology
    if not is_manifold(product.source):
        pytest.skip("cuts of what is not manifold are borders too")
    segments = baseline.curve(np.flatnonzero(source.edge_faces == 1))
    points = np.unique(sim.edges[sim.edge_faces == 1])
    if len(segments) == 0:
        assert len(points) == 0
        return
    assert distance_to_segments(product.sim.points[points], segments).max() <= ON_CURVE * baseline.size
    assert length(product.sim.points[sim.edges[sim.edge_faces == 1]]) == pytest.approx(length(segments), rel=CURVE_LENGTH)


def uv_set(product):
    """The name of the UV set whose shells are panels, which must be on the simulation mesh."""
    name = recipe(product.source.prim, "sim.uvSet", "st")
    if name not in product.source.primvars:
        pytest.skip(f"no UV set {name}")
    assert name in product.sim.primvars, f"{name} is gone; warnings: {product.warnings}"
    assert product.sim.primvars[name].interpolation == "faceVarying"
    assert np.isfinite(product.sim.primvars[name].rows).all()
    return name


def joined(mesh, name):
    """A mesh with one index for each value of its UVs: where indices alone differ, the simulation mesh has no cut."""
    primvar = mesh.primvars[name]
    values, indices = np.unique(primvar.rows, axis=0, return_inverse=True)
    return replace(mesh, primvars=mesh.primvars | {name: replace(primvar, values=values, indices=indices.ravel()[primvar.corner_indices()])})


def shell_signs(mesh, name):
    """For each shell the sign of its area in UV space, and its area."""
    shells = mesh.uv_shells(name)
    areas = np.bincount(shells, weights=mesh.uv_areas(name))
    return shells, np.sign(areas), np.abs(areas)


def test_uv_triangles_are_not_flipped(product):
    name = uv_set(product)
    shells, signs, _ = shell_signs(product.sim, name)
    flipped = np.flatnonzero(np.sign(product.sim.uv_areas(name)) != signs[shells])
    assert len(flipped) == 0, f"{len(flipped)} triangles, first {flipped[0]}"


@pytest.fixture
def all_shells(garment, built):
    """A build in which UV shells of any size constrain the mesh."""
    return built(garment, "--set", "sim.smallestShell=0")


def test_shells_that_do_not_constrain_are_told(product, all_shells):
    told = [warning for warning in product.report["warnings"] if warning["code"] == "small-shells"]
    count = product.report["remesh"]["smallShells"]
    assert len(told) == (count > 0) and all_shells.report["remesh"]["smallShells"] == 0
    if told:
        assert told[0]["elements"]["faces"] and told[0]["problem"].startswith(f"{count} UV shell")
    else:
        assert np.array_equal(product.sim.points, all_shells.sim.points)


def test_uv_shells_are_those_of_the_source(all_shells):
    """As many as before, as many of them mirrored, and of the same areas."""
    name = uv_set(all_shells)
    meshes = joined(all_shells.source, name), all_shells.sim
    (_, before, areas_before), (_, after, areas_after) = (shell_signs(mesh, name) for mesh in meshes)
    if is_manifold(all_shells.source):
        assert sorted(after) == sorted(before)
        assert np.allclose(np.sort(areas_after), np.sort(areas_before), rtol=0.1, atol=0.002 * areas_before.sum())
    else:
        assert areas_after.sum() == pytest.approx(areas_before.sum(), rel=0.05)


def test_uv_cuts_are_where_the_source_has_them(all_shells, baseline):
    name = uv_set(all_shells)
    cuts = joined(all_shells.source, name).uv_cuts(name)
    segments = baseline.curve(np.flatnonzero(cuts))
    edges = all_shells.sim.topology.edges[all_shells.sim.uv_cuts(name)]
    assert (len(edges) > 0) == (len(segments) > 0)
    if len(edges) == 0:
        return
    assert distance_to_segments(all_shells.sim.points[np.unique(edges)], segments).max() <= ON_CURVE * baseline.size
    if is_manifold(all_shells.source):
        assert length(all_shells.sim.points[edges]) == pytest.approx(length(segments), rel=CURVE_LENGTH)


def test_vertex_primvars_stay_in_range(product):
    for name, primvar in product.source.primvars.items():
        if primvar.interpolation not in ("vertex", "varying") or primvar.is_skinning or name not in product.sim.primvars:
            continue
        written = product.sim.primvars[name]
        assert len(written.flat) == len(product.sim.points), name
        if primvar.is_discrete:
            no_new_values(written, primvar)
        elif not primvar.element.startswith(("quat", "normal")):  # those are scaled to unit length
            slack = 1e-5 * max(np.abs(primvar.rows).max(), 1e-30)
            assert (written.rows >= primvar.rows.min(axis=0) - slack).all(), name
            assert (written.rows <= primvar.rows.max(axis=0) + slack).all(), name


def test_joint_influences_add_to_one(product):
    if "skel:jointWeights" not in product.source.primvars:
        pytest.skip("not skinned")
    source, weights = product.source.primvars["skel:jointWeights"], product.sim.primvars["skel:jointWeights"]
    joints = product.sim.primvars["skel:jointIndices"]
    assert weights.element_size == joints.element_size == source.element_size
    assert (weights.rows >= 0).all()
    assert np.allclose(weights.rows.sum(axis=1), 1, atol=1e-5)
    assert set(np.unique(joints.rows)) <= set(np.unique(product.source.primvars["skel:jointIndices"].rows)) | {0.0}


def test_partitions_stay_partitions(product):
    assert {name: kind for name, kind in product.sim.families.items() if kind == "partition"} == {
        name: kind for name, kind in product.source.families.items() if kind == "partition"
    }
    for family, kind in product.sim.families.items():
        sets = [subset for subset in product.sim.subsets.values() if subset.family == family and subset.element_type == "face"]
        if kind == "partition" and sets:
            times = np.bincount(np.concatenate([subset.indices for subset in sets]), minlength=len(product.sim.counts))
            assert (times == 1).all(), f"{family}: {(times == 0).sum()} faces in no set, {(times > 1).sum()} in more than one"


def test_subset_indices_are_elements_of_the_mesh(product):
    sizes = {"face": len(product.sim.counts), "point": len(product.sim.points)}
    for name, subset in product.sim.subsets.items():
        if subset.element_type == "edge":
            assert (product.sim.topology.edge_ids(subset.pairs) >= 0).all(), f"{name} has pairs that are not edges"
        else:
            assert len(np.unique(subset.indices)) == len(subset.indices), name
            assert ((subset.indices >= 0) & (subset.indices < sizes[subset.element_type])).all(), name


def test_face_subsets_keep_their_share_of_the_area(product, baseline):
    before, after = baseline.face_areas(), product.sim.face_areas
    told = {code: [w for w in product.report["warnings"] if w["code"] == code] for code in ("sets-blurred", "area-changed")}
    blurred = {name for warning in told["sets-blurred"] for name in warning["names"]}
    changed = {name: warning["amount"] for warning in told["area-changed"] for name in warning["names"]}
    for name, subset in product.source.subsets.items():
        if subset.element_type != "face":
            continue
        assert name in product.sim.subsets, f"{name} is gone; warnings: {product.warnings}"
        expected = before[subset.indices].sum() / before.sum()
        actual = after[product.sim.subsets[name].indices].sum() / after.sum()
        # A set no wider than a few triangles cannot be met better than by whole triangles, nor thin forms by long edges: warnings say so.
        grain = 3 * after.max() / after.sum()
        most = max(grain if name in blurred else min(grain, 0.5 * expected), 1.05 * changed.get(name, 0) * expected)
        assert abs(actual - expected) <= max(SET_AREA * expected, most), f"{name}: {actual:.4f}, was {expected:.4f}"


def test_edge_subsets_on_chains_keep_their_curves(all_shells, baseline):
    """Sets of borders and UV seams are constraints, so they are carried exactly."""
    source, name = all_shells.source, recipe(all_shells.source.prim, "sim.uvSet", "st")
    chains = (source.topology.edge_faces == 1) | (joined(source, name).uv_cuts(name) if name in source.primvars else False)
    for name, subset in source.subsets.items():
        if subset.element_type != "edge" or len(subset.indices) == 0:
            continue
        edges = source.topology.edge_ids(subset.pairs)
        if not chains[edges].all() or not is_manifold(source):
            continue
        assert name in all_shells.sim.subsets, f"{name} is gone; warnings: {all_shells.warnings}"
        segments, pairs = baseline.curve(edges), all_shells.sim.subsets[name].pairs
        assert distance_to_segments(all_shells.sim.points[np.unique(pairs)], segments).max() <= ON_CURVE * baseline.size, name
        assert length(all_shells.sim.points[pairs]) == pytest.approx(length(segments), rel=CURVE_LENGTH), name


def test_materials_are_bound_as_before(product):
    assert own_material(product.sim) == product.source.material
    for name, subset in product.source.subsets.items():
        if subset.material:
            assert product.sim.subsets[name].material == subset.material, name


def test_edge_lengths_follow_the_target(garment, built):
    """Half the triangles' edges or more are near a target that is even all over."""
    source = built(garment).source
    target = 0.7 * np.median(edge_lengths(source))
    sim = built(garment, "--set", f"sim.minEdgeLength={target:g}", "--set", f"sim.maxEdgeLength={target:g}").sim
    assert 0.75 <= np.median(edge_lengths(sim)) / target <= 1.3


def test_density_makes_triangles_small_where_it_is_painted(garment, built):
    product = built(garment)
    if "simDensity" not in product.source.primvars:
        pytest.skip("no simDensity")
    middle = np.median(edge_lengths(product.source))
    sizes = ("--set", f"sim.minEdgeLength={0.5 * middle:g}", "--set", f"sim.maxEdgeLength={2 * middle:g}")
    sim = built(garment, *sizes, "--set", "sim.density=simDensity").sim
    weight = sim.primvars["simDensity"].rows[:, 0][sim.topology.edges].mean(axis=1)
    lengths = edge_lengths(sim)
    dense, sparse = weight > 0.8, weight < 0.4
    if dense.sum() < 20 or sparse.sum() < 20:
        pytest.skip("painted almost evenly")
    assert np.median(lengths[dense]) < 0.7 * np.median(lengths[sparse])


@pytest.mark.parametrize("level", [0, 1])
def test_baseline_level_is_followed(garment, built, level):
    product = built(garment, "--set", f"sim.baselineLevel={level}")
    baseline = Baseline(product, level)
    away = distance_to_triangles(product.sim.points, baseline.triangles, reach=ON_SURFACE * baseline.size)
    assert np.isfinite(away).all(), f"{np.isinf(away).sum()} points are off the baseline"


def test_a_sharp_corner_inside_the_cloth_is_a_vertex(build, tmp_path):
    """A peak that remeshing would cut off."""
    corner = 4 * 9 + 4

    def peak(mesh):
        points = list(mesh.GetPointsAttr().Get())
        points[corner] = (4, 4, points[corner][2] + 2)
        mesh.GetPointsAttr().Set(points)

    path = write(tmp_path / "peak.usda", shape=lambda: sheet(8, 8), corners={corner: 10.0}, finish=peak)
    product = build(path, "--set", "sim.maxEdgeLength=1.3")
    distances = np.linalg.norm(product.mesh("sim").points - product.source.points[corner], axis=1)
    assert distances.min() == 0
    assert product.mesh("sim").subsets["tailorCorners"].indices.tolist() == [int(distances.argmin())]
