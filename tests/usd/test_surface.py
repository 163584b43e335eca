"""The distances that other tests rely on."""

import numpy as np
from surface import distance_to_segments, distance_to_triangles, triangles_of


def test_distances_to_one_triangle():
    triangle = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], dtype=float)
    points = np.array([[0.2, 0.2, 0], [0.2, 0.2, 0.3], [-3, 0, 4], [1, 1, 0], [0.5, -0.25, 0]])
    found = distance_to_triangles(points, triangle, reach=10)
    assert np.allclose(found, [0, 0.3, 5, np.sqrt(0.5), 0.25])
    assert np.isinf(distance_to_triangles(points, triangle, reach=0.5)[2])


def test_grid_finds_the_same_as_all_pairs():
    random = np.random.default_rng(1)
    triangles = random.random((200, 1, 3)) + 0.2 * random.random((200, 3, 3))
    points = random.random((50, 3)) * 1.4
    near = distance_to_triangles(points, triangles, reach=0.1)
    far = distance_to_triangles(points, triangles, reach=5.0)
    assert np.allclose(near[np.isfinite(near)], far[np.isfinite(near)])
    assert (far[np.isinf(near)] > 0.1).all()


def test_quads_are_split_both_ways():
    triangles, faces = triangles_of(np.array([4, 3]), np.array([0, 1, 2, 3, 3, 2, 4]))
    assert sorted(map(sorted, triangles.tolist())) == [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3], [2, 3, 4]]
    assert sorted(faces) == [0, 0, 0, 0, 1]


def test_distance_to_segments():
    segments = np.array([[[0, 0, 0], [1, 0, 0]], [[5, 0, 0], [5, 0, 0]]], dtype=float)
    assert np.allclose(distance_to_segments(np.array([[0.5, 2, 0], [4, 0, 0]], dtype=float), segments), [2, 1])
