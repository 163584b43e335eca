"""The independent subdivision against values that are known otherwise."""

import numpy as np
import pytest
from catmull_clark import INFINITE, Subdivision, cage, match_vertices

CUBE_POINTS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
CUBE_FACES = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]
MODES = ["all", "none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries"]


def cube(**options):
    return cage([4] * 6, CUBE_FACES, 8, **options)


def grid(width, height, **options):
    """A regular grid of quads and its points in the unit square times its size."""
    points = np.array([[x, y] for y in range(height + 1) for x in range(width + 1)], dtype=float)
    corner = np.array([y * (width + 1) + x for y in range(height) for x in range(width)])
    faces = np.stack([corner, corner + 1, corner + width + 2, corner + width + 1], axis=1)
    return cage([4] * len(faces), faces.ravel(), len(points), **options), points


def seam(width=2, height=2, column=1):
    """Face-varying indices of a grid that is cut along a column of points: the right half has values of its own."""
    base, points = grid(width, height)
    right = np.repeat(np.tile(np.arange(width) >= column, height), 4)
    return base, points, base.verts + right * len(points)


def test_cube_first_level_has_the_published_values():
    values = Subdivision(cube(), 1).vertex(CUBE_POINTS)
    assert np.allclose(np.abs(values[:8]), 5 / 9)  # vertices
    assert np.allclose(np.sort(np.abs(values[8:20]), axis=1), [0, 0.75, 0.75])  # edges
    assert np.allclose(np.sort(np.abs(values[20:]), axis=1), [0, 0, 1])  # faces


def test_cube_converges_to_its_limit():
    """The limit of a vertex is (n² v + 4 Σ edge ends + Σ face corners) / (n (n + 5)): here 1/2 of it."""
    finest = Subdivision(cube(), 6).vertex(CUBE_POINTS)
    assert np.allclose(finest[:8], CUBE_POINTS / 2, atol=1e-3)


def test_infinitely_sharp_cube_stays_a_cube():
    edges = cube().edges
    made = Subdivision(cube(creases={tuple(edge): INFINITE for edge in edges}), 2)
    assert np.allclose(np.abs(made.vertex(CUBE_POINTS)).max(axis=1), 1)


def test_sharpness_one_is_one_sharp_level():
    sharp = cube(creases={tuple(edge): 1.0 for edge in cube().edges})
    once = Subdivision(sharp, 1)
    bilinear = Subdivision(cube(scheme="bilinear"), 1)
    assert np.allclose(once.vertex(CUBE_POINTS), bilinear.vertex(CUBE_POINTS))
    then = Subdivision(cage(once.cage.counts, once.cage.verts, once.cage.vertex_count), 1)
    assert np.allclose(Subdivision(sharp, 2).vertex(CUBE_POINTS), then.vertex(once.vertex(CUBE_POINTS)))


def test_fractional_sharpness_is_between_smooth_and_sharp():
    edges = [tuple(edge) for edge in cube().edges]
    level = {s: Subdivision(cube(creases=dict.fromkeys(edges, s)), 1).vertex(CUBE_POINTS) for s in (0.0, 0.25, 1.0)}
    assert np.allclose(level[0.25], 0.75 * level[0.0] + 0.25 * level[1.0])


def test_semi_sharp_corner_fades_like_a_crease():
    at = {s: Subdivision(cube(corners={7: s}), 1).vertex(CUBE_POINTS)[7] for s in (0.0, 0.5, 1.0, 3.0)}
    assert np.allclose(at[1.0], CUBE_POINTS[7])
    assert np.allclose(at[3.0], CUBE_POINTS[7])
    assert np.allclose(at[0.5], (at[0.0] + at[1.0]) / 2)


def test_a_dart_is_smooth_at_its_end():
    sharp = Subdivision(cube(creases={(0, 1): INFINITE}), 1).vertex(CUBE_POINTS)
    smooth = Subdivision(cube(), 1).vertex(CUBE_POINTS)
    assert np.allclose(sharp[:8], smooth[:8])
    assert not np.allclose(sharp[8:20], smooth[8:20])


@pytest.mark.parametrize("boundary", ["none", "edgeOnly", "edgeAndCorner"])
def test_flat_grid_stays_flat_and_keeps_its_corners_as_told(boundary):
    base, points = grid(3, 3, boundary=boundary)
    made = Subdivision(base, 2)
    values = made.vertex(points)
    kept = np.allclose(values[[0, 3, 12, 15]], points[[0, 3, 12, 15]])
    assert kept == (boundary == "edgeAndCorner")
    inner = [5, 6, 9, 10]
    assert np.allclose(values[inner], points[inner])


def test_children_are_in_the_order_of_corners():
    base = cage([4, 3, 5], [0, 1, 2, 3, 3, 2, 4, 0, 3, 4, 5, 6], 7)
    child = Subdivision(base, 1).cage.verts.reshape(-1, 4)
    assert [list(child[j]).index(v) for j, v in enumerate([0, 1, 2, 3])] == [0, 1, 2, 3]
    assert list(child[4:, 0]) == [3, 2, 4, 0, 3, 4, 5, 6]
    made = Subdivision(base, 1)
    assert list(made.parent_face()) == [0] * 4 + [1] * 3 + [2] * 5
    face_points = made.cage.vertex_count - 3
    assert [list(child[j]).index(face_points) for j in range(4)] == [2, 3, 0, 1]


def test_triangles_under_the_smooth_rule_weigh_faces_more():
    base = {rule: cage([3, 3], [0, 1, 2, 2, 1, 3], 4, triangles=rule) for rule in ("catmullClark", "smooth")}
    points = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0], [1, 1, 1.0]])
    middle = {rule: Subdivision(made, 1).vertex(points)[4 + int(made.edge_ids([(1, 2)])[0])] for rule, made in base.items()}
    assert np.allclose(middle["catmullClark"], [0.5, 0.5, 1 / 6])
    assert np.allclose(middle["smooth"], [0.5, 0.5, 0.47 * 2 / 3])


def test_bow_tie_and_fin_are_held():
    bow = cage([4, 4], [0, 1, 2, 3, 2, 4, 5, 6], 7)
    assert bow.vertex_sharpness[2] == INFINITE
    fin = cage([4, 4, 4], [0, 1, 2, 3, 1, 0, 4, 5, 0, 1, 6, 7], 8)
    assert fin.edge_sharpness[fin.edge_ids([(0, 1)])[0]] == INFINITE
    turned = cage([4, 4], [0, 1, 2, 3, 0, 1, 4, 5], 6)
    assert turned.edge_sharpness[turned.edge_ids([(0, 1)])[0]] == INFINITE


def test_edges_and_creases_are_followed():
    base, _ = grid(2, 2)
    made = Subdivision(base, 2)
    edge = base.edge_ids([(1, 4)])
    children = made.edge_children(edge)
    assert len(children) == 4
    assert np.array_equal(np.sort(children), np.flatnonzero(made.parent_edge() == edge[0]))
    assert [made.remaining(s) for s in (0.5, 2.0, 2.5, 9.5, 10.0)] == [0, 0, 0.5, 7.5, 10.0]


def test_constants_and_varying_values():
    base, points = grid(3, 2, creases={(1, 5): 1.5}, corners={5: 0.5})
    made = Subdivision(base, 3)
    assert np.allclose(made.vertex(np.full((len(points), 2), 7.0)), 7.0)
    assert np.allclose(made.varying(points), Subdivision(grid(3, 2, scheme="bilinear")[0], 3).vertex(points))


@pytest.mark.parametrize("mode", MODES)
def test_uncut_channel_follows_the_points(mode):
    base, points = grid(4, 4)
    made = Subdivision(base, 2)
    values, _ = made.face_varying(points, base.verts, mode)
    expected = made.varying(points) if mode == "all" else made.vertex(points)
    # Pinned borders differ from smooth ones only where the border bends or is uneven: nowhere here.
    assert np.allclose(values, expected[made.cage.verts])


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode != "none"])  # which lets the ends of the seam bend
def test_seam_stays_cut_and_affine_values_stay_affine(mode):
    base, points, indices = seam(4, 4, column=2)
    right = np.concatenate([points, points + [10, 0]])
    made = Subdivision(base, 2)
    values, cut = made.face_varying(right, indices, mode)
    flat = made.vertex(points)[made.cage.verts]
    side = np.repeat(base.verts.reshape(-1, 4)[:, 0] % 5 >= 2, 16 * 4) * 10.0
    assert np.allclose(values - flat, np.stack([side, 0 * side], axis=1))
    assert len(np.unique(cut)) == made.cage.vertex_count + 2 * 4 * 2 + 1
    with pytest.raises(AssertionError, match="cut from their vertex"):
        match_vertices(made.cage.verts, cut)


@pytest.mark.parametrize("mode, still", [("all", True), ("boundaries", True), ("none", False), ("cornersOnly", False), ("cornersPlus1", False)])
def test_seam_end_at_a_bend_moves_unless_linear(mode, still):
    """A seam value in the middle of a bent seam: kept by linear boundaries only."""
    base, points, indices = seam(2, 2, column=1)
    values = np.concatenate([points, points + [10, 0]])
    values[4] += [0.3, 0]  # bend the left side in the middle of the seam
    after, _ = Subdivision(base, 1).face_varying(values, indices, mode)
    corner = [c for c in range(len(base.verts)) if base.verts[c] == 4 and indices[c] == 4][0]
    face, at = divmod(corner, 4)
    kept = np.allclose(after.reshape(-1, 4, 2)[face * 4 + at, at], values[4])
    assert kept == still


@pytest.mark.parametrize("mode, still", [("none", False), ("cornersOnly", True), ("cornersPlus1", True), ("boundaries", True)])
def test_one_face_shell_keeps_its_corners(mode, still):
    """The middle face of a 3x3 grid is a shell of its own."""
    base, points = grid(3, 3)
    indices = base.verts.copy()
    indices[16:20] += len(points)
    values = np.concatenate([points, points])
    after, _ = Subdivision(base, 1).face_varying(values, indices, mode)
    kept = np.allclose(after.reshape(-1, 4, 2)[16, 0], points[5])
    assert kept == still


@pytest.mark.parametrize("mode, still", [("cornersOnly", False), ("cornersPlus1", True), ("cornersPlus2", True)])
def test_three_shells_at_a_vertex(mode, still):
    """Two faces of one shell and two of single faces meet in the middle of a 2x2 grid."""
    base, points = grid(2, 2)
    indices = base.verts + np.repeat([0, 0, 1, 2], 4) * len(points)
    values = np.concatenate([points] * 3)
    values[4] += [0, 0.2]
    after, _ = Subdivision(base, 1).face_varying(values, indices, mode)
    kept = np.allclose(after.reshape(-1, 4, 2)[2, 2], values[4])
    assert kept == still


@pytest.mark.parametrize("mode, still", [("cornersPlus1", False), ("cornersPlus2", True)])
def test_dart_of_a_channel(mode, still):
    """The value at the end of a cut that stops inside the grid."""
    base, points = grid(2, 2)
    indices = base.verts.copy()
    indices[4 + 0] = len(points)  # point 1 seen from the right face of the lower row
    values = np.concatenate([points, points[[1]] + [0.4, 0]])
    after, _ = Subdivision(base, 1).face_varying(values, indices, mode)
    kept = np.allclose(after.reshape(-1, 4, 2)[2, 2], values[4])
    assert kept == still


def test_match_vertices_sees_a_join():
    with pytest.raises(AssertionError, match="joined to another vertex"):
        match_vertices([0, 1, 2, 3], [0, 1, 1, 3])
    assert list(match_vertices([2, 0, 1], [0, 1, 2])) == [1, 2, 0]
