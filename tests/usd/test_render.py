"""The render mesh against its source: the values of an independent subdivision, and every set and property carried."""

import numpy as np
import pytest
from catmull_clark import INFINITE, Subdivision, match_vertices
from mesh import cut_edges, own_material, recipe
from pxr import UsdGeom

# OpenSubdiv and usdtailor work in float32 or better on values that are stored as float32.
RELATIVE = 2e-6


class Refined:
    """The source of a render mesh, subdivided here, and its vertices matched to the written ones."""

    def __init__(self, product, level):
        self.product, self.source, self.render = product, product.source, product.render
        self.made = Subdivision(self.source.cage, level)
        self.level = level
        assert set(self.render.counts) == {4} if level else True
        self.to_render = match_vertices(self.made.cage.verts, self.render.indices)

    def expected(self, ours):
        """Rows of our vertices in the order of the written ones."""
        out = np.full((len(self.render.points), ours.shape[1]), np.nan)
        used = self.to_render[: len(ours)] >= 0
        out[self.to_render[np.flatnonzero(used)]] = ours[: len(used)][used]
        return out

    def edge_ids(self, base_edges):
        """The written edges that edges of the source became."""
        ours = self.made.cage.edges[self.made.edge_children(base_edges)]
        return self.render.cage.edge_ids(self.to_render[ours])


@pytest.fixture(params=["recipe", 1])
def refined(request, garment, built):
    """At the level that the garment itself asks for, and at one that is asked for."""
    if request.param == "recipe":
        product = built(garment)
        return Refined(product, recipe(product.source.prim, "render.level", 2))
    return Refined(built(garment, "--set", f"render.level={request.param}"), request.param)


def close(actual, expected, what, scale=None):
    """Agreement to a share of the range of the values."""
    scale = max(np.abs(expected).max(initial=0), 1e-30) if scale is None else scale
    assert actual.shape == expected.shape, f"{what}: {actual.shape}, expected {expected.shape}"
    away = np.abs(actual - expected).max(axis=1, initial=0)
    assert np.isfinite(actual).all(), what
    assert away.max(initial=0) <= RELATIVE * scale, f"{what}: off by {away.max()} at {away.argmax()}, of {scale}"


def same_values(actual, expected, what):
    """Equality of copied values, numbers or not."""
    assert actual.shape == expected.shape, f"{what}: {actual.shape}, expected {expected.shape}"
    assert np.array_equal(actual, expected), f"{what} differs first at {np.flatnonzero((actual != expected).any(axis=1))[:1]}"


def box(points):
    return np.linalg.norm(np.ptp(points, axis=0))


def carried(refined, interpolation):
    """Pairs of source and written primvars of this interpolation, all of which must be there."""
    for name, primvar in refined.source.primvars.items():
        if primvar.interpolation == interpolation and not primvar.is_skinning:
            assert name in refined.render.primvars, f"primvar {name} is gone; warnings: {refined.product.warnings}"
            written = refined.render.primvars[name]
            assert written.interpolation == interpolation, name
            yield name, primvar, written


def test_topology_is_that_of_the_subdivided_cage(refined):
    assert np.array_equal(refined.render.counts, refined.made.cage.counts)
    assert (refined.to_render[np.unique(refined.made.cage.verts)] >= 0).all()
    loose = len(refined.source.points) - len(np.unique(refined.source.indices))
    if loose == 0:
        assert len(refined.render.points) == refined.made.cage.vertex_count


def test_points(refined):
    used = np.unique(refined.render.indices)
    expected = refined.expected(refined.made.vertex(refined.source.points))
    close(refined.render.points[used], expected[used], "points", box(refined.source.points))


def test_vertex_primvars(refined):
    used = np.unique(refined.render.indices)
    for name, primvar, written in carried(refined, "vertex"):
        assert written.element_size == primvar.element_size, name
        if primvar.is_discrete:
            no_new_values(written, primvar)
            continue
        if is_direction(primvar):
            close_directions(written.flat[used], refined.expected(refined.made.vertex(primvar.flat))[used], name)
            continue
        close(written.flat[used], refined.expected(refined.made.vertex(primvar.flat))[used], name, tolerance_scale(primvar))


def no_new_values(written, primvar):
    """Discrete values are copied from somewhere, never mixed."""
    assert {tuple(row) for row in written.flat} <= {tuple(row) for row in primvar.flat}, f"{primvar.name}: invented values"


def is_direction(primvar):
    """Quaternions and normals are scaled to unit length once they are mixed."""
    return primvar.element.startswith(("quat", "normal"))


def close_directions(actual, expected, name):
    """Of unit length, and equal except for the sign."""
    assert np.abs(np.linalg.norm(actual, axis=1) - 1).max(initial=0) < 1e-3, name
    expected = expected / np.linalg.norm(expected, axis=1, keepdims=True)
    assert np.abs(np.abs((actual * expected).sum(axis=1)) - 1).max(initial=0) < 1e-3, name


def tolerance_scale(primvar):
    """Half precision keeps eleven bits, and text six digits of a time code."""
    scale = max(np.abs(primvar.rows).max(initial=0), 1e-30)
    half = primvar.element.endswith("h") or primvar.element.startswith("half")
    return scale * (2.0**-11 / RELATIVE if half else 10 if primvar.element == "timecode" else 1)


def test_varying_primvars_are_linear(refined):
    used = np.unique(refined.render.indices)
    for name, primvar, written in carried(refined, "varying"):
        if primvar.is_discrete:
            no_new_values(written, primvar)
        elif is_direction(primvar):
            close_directions(written.flat[used], refined.expected(refined.made.varying(primvar.flat))[used], name)
        else:
            expected = refined.expected(refined.made.varying(primvar.flat))
            close(written.flat[used], expected[used], name, tolerance_scale(primvar))


def test_uniform_primvars_are_those_of_the_parent_face(refined):
    for name, primvar, written in carried(refined, "uniform"):
        same_values(written.flat, primvar.flat[refined.made.parent_face()], name)


def test_constant_primvars_are_equal(refined):
    for name, primvar, written in carried(refined, "constant"):
        same_values(written.flat, primvar.flat, name)
        assert (written.type_name, written.element_size) == (primvar.type_name, primvar.element_size), name


def test_face_varying_primvars(refined):
    for name, primvar, written in carried(refined, "faceVarying"):
        if primvar.is_discrete:
            no_new_values(written, primvar)
            continue
        expected, _ = refined.made.face_varying(primvar.rows, primvar.corner_indices(), refined.source.face_varying)
        if is_direction(primvar):
            close_directions(written.flat, expected, name)
        else:
            close(written.flat, expected, name, tolerance_scale(primvar))


def test_face_varying_cuts_are_where_the_source_has_them(refined):
    for name, primvar, written in carried(refined, "faceVarying"):
        if primvar.indices is None or primvar.is_discrete:
            continue
        assert written.indices is not None, f"{name} was indexed and is not now: its cuts are lost"
        _, channel = refined.made.face_varying(primvar.rows, primvar.indices, refined.source.face_varying)
        theirs, ours = cut_edges(refined.render.cage, written.indices), cut_edges(refined.made.cage, channel)
        matched = refined.render.cage.edge_ids(refined.to_render[refined.made.cage.edges])
        assert np.array_equal(theirs[matched], ours), f"{name}: {theirs.sum()} cut edges, expected {ours.sum()}"


def test_joint_influences(refined):
    """Compared as one weight for each joint and vertex, whatever the order; pruned to elementSize and adding to one."""
    source, render = refined.source, refined.render
    if "skel:jointIndices" not in source.primvars:
        pytest.skip("not skinned")
    before = [source.primvars[f"skel:joint{what}"] for what in ("Indices", "Weights")]
    after = [render.primvars[f"skel:joint{what}"] for what in ("Indices", "Weights")]
    if before[0].interpolation == "constant":
        for old, new in zip(before, after):
            same_values(new.flat, old.flat, new.name)
        return
    size = before[0].element_size
    assert [p.element_size for p in after] == [size, size]
    joints = int(before[0].rows.max()) + 1
    expected = refined.expected(refined.made.vertex(dense(*before, joints)))
    expected, rest = pruned(expected, size)
    actual = dense(*after, joints)
    assert np.allclose(actual.sum(axis=1), 1, atol=1e-5)
    assert (actual >= 0).all()
    away = np.abs(actual - expected).max(axis=1)
    # Where the first dropped influence equals the last kept one, either may stay.
    assert (away <= 1e-5)[~rest].all(), f"off by {away[~rest].max()}"


def dense(indices, weights, joints):
    """A column for each joint."""
    rows = np.zeros((len(weights.flat), joints))
    at = np.arange(len(rows))[:, None]
    np.add.at(rows, (at, indices.flat.astype(int)), weights.flat)
    return rows


def pruned(rows, size):
    """The `size` largest of each row, adding to one; and which rows had a tie at the cut."""
    rows = np.maximum(rows, 0)
    order = np.sort(rows, axis=1)[:, ::-1]
    if rows.shape[1] <= size:
        return rows / rows.sum(axis=1, keepdims=True), np.zeros(len(rows), bool)
    last, first_dropped = order[:, size - 1], order[:, size]
    tie = (first_dropped > 0) & (last - first_dropped <= 1e-6)
    kept = np.where(rows >= last[:, None], rows, 0)
    return kept / kept.sum(axis=1, keepdims=True), tie


def test_face_subsets_are_the_children_of_their_faces(refined):
    parents = refined.made.parent_face()
    for name, subset, written in subsets(refined, "face"):
        assert sorted(written.indices) == list(np.flatnonzero(np.isin(parents, subset.indices))), name


def test_edge_subsets_are_the_children_of_their_edges(refined):
    for name, subset, written in subsets(refined, "edge"):
        expected = refined.edge_ids(refined.source.cage.edge_ids(subset.pairs))
        actual = refined.render.cage.edge_ids(written.pairs)
        assert (actual >= 0).all(), f"{name} has pairs that are not edges"
        assert sorted(actual) == sorted(expected), name


def test_point_subsets_are_the_children_of_their_points(refined):
    for name, subset, written in subsets(refined, "point"):
        assert sorted(written.indices) == sorted(refined.to_render[subset.indices]), name


def subsets(refined, element_type):
    for name, subset in refined.source.subsets.items():
        if subset.element_type == element_type:
            assert name in refined.render.subsets, f"subset {name} is gone; warnings: {refined.product.warnings}"
            written = refined.render.subsets[name]
            assert (written.element_type, written.family) == (subset.element_type, subset.family), name
            yield name, subset, written


def test_subset_families_keep_their_types(refined):
    assert refined.render.families == refined.source.families


def test_creases_keep_what_is_left_of_their_sharpness(refined):
    expected = {}
    for pair, sharpness in refined.source.creases.items():
        left = refined.made.remaining(min(sharpness, INFINITE))
        if left > 0:
            expected.update(dict.fromkeys(refined.edge_ids(refined.source.cage.edge_ids([pair])).tolist(), left))
    pairs = np.array(list(refined.render.creases), dtype=int).reshape(-1, 2)
    actual = dict(zip(refined.render.cage.edge_ids(pairs).tolist(), (min(s, INFINITE) for s in refined.render.creases.values())))
    assert actual == pytest.approx(expected, abs=1e-5)


def test_corners_keep_what_is_left_of_their_sharpness(refined):
    left = {int(refined.to_render[v]): refined.made.remaining(min(s, INFINITE)) for v, s in refined.source.corners.items()}
    actual = {v: min(s, INFINITE) for v, s in refined.render.corners.items()}
    assert actual == pytest.approx({v: s for v, s in left.items() if s > 0}, abs=1e-5)


def test_holes_are_the_children_of_holes(refined):
    """Under interpolateBoundary none, faces at the border are not drawn either; their children would be."""
    holes = np.zeros(len(refined.source.counts), bool)
    holes[refined.source.holes] = True
    if refined.source.boundary == "none":
        cage = refined.source.cage
        border = np.zeros(cage.vertex_count, bool)
        border[cage.edges[cage.edge_faces == 1].ravel()] = True
        holes |= np.bincount(cage.corner_face, weights=border[cage.verts]) > 0
    assert sorted(refined.render.holes) == list(np.flatnonzero(holes[refined.made.parent_face()]))


def test_subdivision_options_are_copied(refined):
    source, render = refined.source, refined.render
    assert render.scheme == "catmullClark"
    for option in ("boundary", "face_varying", "triangles", "orientation"):
        assert getattr(render, option) == getattr(source, option), option


def test_render_mesh_refined_further_is_the_source_refined_further(refined):
    """What is written means the same surface: creases, corners and borders included."""
    further = Subdivision(refined.render.cage, 1)
    direct = Subdivision(refined.source.cage, refined.level + 1)
    matched = match_vertices(direct.cage.verts, further.cage.verts)
    used = np.unique(direct.cage.verts)
    points = further.vertex(refined.render.points)[matched[used]]
    close(points, direct.vertex(refined.source.points)[used], "points one level on", box(refined.source.points))


def test_materials_are_bound_as_before(refined):
    assert own_material(refined.render) == refined.source.material
    for name, subset in refined.source.subsets.items():
        assert refined.render.subsets[name].material == subset.material, name


def test_visibility_and_doc_are_kept(refined):
    before, after = (UsdGeom.Imageable(mesh.prim).GetVisibilityAttr().Get() for mesh in (refined.source, refined.render))
    assert after == before
