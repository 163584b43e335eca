"""The render mesh against its source: every set and property is carried to where its elements went.

test_golden compares the points, values and sharpness of subdivision with OpenSubdiv.
"""

import numpy as np
import pytest
from mesh import Children, cut_edges, kept_corners, own_material, recipe, starts
from pxr import UsdGeom
from sources import width

# OpenSubdiv and usdtailor work in float32 or better on values that are stored as float32.
RELATIVE = 2e-6
# Sharpness from here on does not decay.
INFINITE = 10.0


class Refined:
    """A render mesh, and where the elements of its source are in it."""

    def __init__(self, product, level):
        self.product, self.source, self.render, self.level = product, product.source, product.render, level
        self.children = Children(self.source, self.render, level)

    def centres(self, rows):
        """Up to level 1: the mean of the rows of each face of the source, and a corner at the centre, for each corner.

        At level 0 each corner stands for itself.
        """
        if self.level == 0:
            return rows, np.arange(len(rows))
        assert self.level == 1
        counts, kept = self.source.counts, kept_corners(self.source.counts)
        means = np.add.reduceat(rows, starts(counts)) / counts[:, None]
        return np.repeat(means, counts, axis=0), kept // 4 * 4 + (kept + 2) % 4


@pytest.fixture(params=["recipe", 1])
def refined(request, garment, built):
    """At the level that the garment itself asks for, and at one that is asked for."""
    if request.param == "recipe":
        product = built(garment)
        return Refined(product, recipe(product.source.prim, "render.level", 2))
    return Refined(built(garment, "--set", f"render.level={request.param}"), request.param)


@pytest.fixture
def coarse(garment, built):
    """At level 1, where the faces of the source are next to the values that they give."""
    return Refined(built(garment, "--set", "render.level=1"), 1)


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


MIXED = ("vertex", "varying", "faceVarying")


def carried(refined, *interpolations):
    """Pairs of source and written primvars of these interpolations, all of which must be there."""
    for name, primvar in refined.source.primvars.items():
        if primvar.interpolation in interpolations and not primvar.is_skinning:
            assert name in refined.render.primvars, f"primvar {name} is gone; warnings: {refined.product.warnings}"
            written = refined.render.primvars[name]
            for kind in ("type_name", "interpolation", "element_size"):
                assert getattr(written, kind) == getattr(primvar, kind), f"{kind} of {name}"
            yield name, primvar, written


def test_topology_is_that_of_the_subdivided_cage(refined):
    """Points and edges meet where they do in the source, and each level has the counts of Euler's rule."""
    source, render, children = refined.source.topology, refined.render.topology, refined.children
    assert np.array_equal(refined.render.counts, children.counts)
    used = np.unique(source.indices)
    same_partition(source.indices, render.indices[children.pieces[:, 0]])
    pieces = 2**refined.level
    same_partition((source.corner_edge[:, None] * pieces + along(source, pieces)).ravel(), render.corner_edge[children.pieces].ravel())
    vertices, edges, faces, corners = len(used), len(source.edges), len(source.counts), len(source.indices)
    for _ in range(refined.level):
        vertices, edges, faces, corners = vertices + edges + faces, 2 * edges + corners, corners, 4 * corners
    assert (len(np.unique(render.indices)), len(render.edges), len(render.counts)) == (vertices, edges, faces)
    if len(used) == len(refined.source.points):
        assert len(refined.render.points) == vertices


def along(topology, pieces):
    """Numbers the pieces of the edge of each corner from its lower vertex on."""
    steps = np.arange(pieces)
    return np.where(topology.forward[:, None], steps, steps[::-1])


def same_partition(ours, theirs):
    """Two numberings of corners join the same ones."""
    pairs = np.unique(np.stack([ours, theirs], axis=1), axis=0)
    assert len(pairs) == len(np.unique(ours)), "corners are cut from each other"
    assert len(pairs) == len(np.unique(theirs)), "corners are joined that were apart"


def test_points_at_the_centres_of_faces_are_means(coarse):
    means, at = coarse.centres(coarse.source.points[coarse.source.indices])
    close(coarse.render.points[coarse.render.indices][at], means, "points", box(coarse.source.points))


def at_corners(mesh, primvar):
    """A row for each corner, from values of points or corners."""
    return primvar.flat if primvar.interpolation == "faceVarying" else primvar.flat[mesh.indices]


def test_values_at_the_centres_of_faces_are_means(coarse):
    """So they are under every rule of subdivision."""
    for name, primvar, written in carried(coarse, *MIXED):
        if not primvar.is_discrete:
            means, at = coarse.centres(at_corners(coarse.source, primvar))
            values_agree(primvar, at_corners(coarse.render, written)[at], means, name)


def test_discrete_values_come_from_the_same_face(refined):
    """Each is copied from a corner of the source's face that it is in, never mixed."""
    parents = np.repeat(refined.children.parent_face, refined.children.counts)
    for name, primvar, written in carried(refined, *MIXED):
        if primvar.is_discrete:
            ours, theirs = at_corners(refined.source, primvar), at_corners(refined.render, written)
            known = {(face, *row) for face, row in zip(refined.source.topology.corner_face, ours)}
            assert {(face, *row) for face, row in zip(parents, theirs)} <= known, name


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


def values_agree(primvar, actual, expected, name):
    """Rows of values, each in the way of its type."""
    if is_direction(primvar):
        each = width(primvar.element)
        close_directions(actual.reshape(-1, each), expected.reshape(-1, each), name)
    else:
        close(actual, expected, name, tolerance_scale(primvar))


def tolerance_scale(primvar):
    """Half precision keeps eleven bits, and text six digits of a time code."""
    scale = max(np.abs(primvar.rows).max(initial=0), 1e-30)
    half = primvar.element.endswith("h") or primvar.element.startswith("half")
    return scale * (2.0**-11 / RELATIVE if half else 10 if primvar.element == "timecode" else 1)


def test_uniform_primvars_are_those_of_the_parent_face(refined):
    for name, primvar, written in carried(refined, "uniform"):
        same_values(written.flat, primvar.flat[refined.children.parent_face], name)


def test_constant_primvars_are_equal(refined):
    for name, primvar, written in carried(refined, "constant"):
        same_values(written.flat, primvar.flat, name)


def test_face_varying_cuts_are_where_the_source_has_them(refined):
    for name, primvar, written in carried(refined, "faceVarying"):
        if primvar.indices is None or primvar.is_discrete:
            continue
        assert written.indices is not None, f"{name} was indexed and is not now: its cuts are lost"
        cuts = np.flatnonzero(cut_edges(refined.render.topology, written.indices))
        expected = refined.children.edges(np.flatnonzero(cut_edges(refined.source.topology, primvar.indices)))
        assert np.array_equal(cuts, expected), f"{name}: {len(cuts)} cut edges, expected {len(expected)}"


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
    actual = dense(*after, joints)
    assert np.allclose(actual.sum(axis=1), 1, atol=1e-5)
    assert (actual >= 0).all()
    if all(f"joint{j}" in source.primvars for j in range(joints)):
        # The source has the same weights as plain primvars, none of which is dropped.
        unpruned = np.concatenate([render.primvars[f"joint{j}"].flat for j in range(joints)], axis=1)
    elif refined.level == 1:
        unpruned, at = refined.centres(dense(*before, joints)[source.indices])
        actual = actual[render.indices[at]]
    else:
        return
    expected, rest = pruned(unpruned, size)
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
    parents = refined.children.parent_face
    for name, subset, written in subsets(refined, "face"):
        assert sorted(written.indices) == list(np.flatnonzero(np.isin(parents, subset.indices))), name


def test_edge_subsets_are_the_children_of_their_edges(refined):
    for name, subset, written in subsets(refined, "edge"):
        expected = refined.children.edges(refined.source.topology.edge_ids(subset.pairs))
        actual = refined.render.topology.edge_ids(written.pairs)
        assert (actual >= 0).all(), f"{name} has pairs that are not edges"
        assert sorted(actual) == sorted(expected), name


def test_point_subsets_are_the_children_of_their_points(refined):
    for name, subset, written in subsets(refined, "point"):
        assert sorted(written.indices) == sorted(refined.children.vertices[subset.indices]), name


def subsets(refined, element_type):
    for name, subset in refined.source.subsets.items():
        if subset.element_type == element_type:
            assert name in refined.render.subsets, f"subset {name} is gone; warnings: {refined.product.warnings}"
            written = refined.render.subsets[name]
            assert (written.element_type, written.family) == (subset.element_type, subset.family), name
            yield name, subset, written


def test_subset_families_keep_their_types(refined):
    assert refined.render.families == refined.source.families


def remaining(sharpness, level):
    """One less at each level, unless it is infinite."""
    return INFINITE if sharpness >= INFINITE else max(sharpness - level, 0)


def test_creases_keep_what_is_left_of_their_sharpness(refined):
    expected = {}
    for pair, sharpness in refined.source.creases.items():
        left = remaining(sharpness, refined.level)
        if left > 0:
            expected.update(dict.fromkeys(refined.children.edges(refined.source.topology.edge_ids([pair])).tolist(), left))
    pairs = np.array(list(refined.render.creases), dtype=int).reshape(-1, 2)
    actual = dict(zip(refined.render.topology.edge_ids(pairs).tolist(), (min(s, INFINITE) for s in refined.render.creases.values())))
    assert actual == pytest.approx(expected, abs=1e-5)


def test_corners_keep_what_is_left_of_their_sharpness(refined):
    left = {int(refined.children.vertices[v]): remaining(s, refined.level) for v, s in refined.source.corners.items()}
    actual = {v: min(s, INFINITE) for v, s in refined.render.corners.items()}
    assert actual == pytest.approx({v: s for v, s in left.items() if s > 0}, abs=1e-5)


def test_holes_are_the_children_of_holes(refined):
    """Under interpolateBoundary none, faces at the border are not drawn either; their children would be."""
    holes = np.zeros(len(refined.source.counts), bool)
    holes[refined.source.holes] = True
    if refined.source.boundary == "none":
        topology = refined.source.topology
        border = np.zeros(topology.vertex_count, bool)
        border[topology.edges[topology.edge_faces == 1].ravel()] = True
        holes |= np.bincount(topology.corner_face, weights=border[topology.indices]) > 0
    assert sorted(refined.render.holes) == list(np.flatnonzero(holes[refined.children.parent_face]))


def test_subdivision_options_are_copied(refined):
    source, render = refined.source, refined.render
    assert render.scheme == "catmullClark"
    for option in ("boundary", "face_varying", "triangles", "orientation"):
        assert getattr(render, option) == getattr(source, option), option


def test_materials_are_bound_as_before(refined):
    assert own_material(refined.render) == refined.source.material
    for name, subset in refined.source.subsets.items():
        assert refined.render.subsets[name].material == subset.material, name


def test_visibility_and_doc_are_kept(refined):
    before, after = (UsdGeom.Imageable(mesh.prim).GetVisibilityAttr().Get() for mesh in (refined.source, refined.render))
    assert after == before
