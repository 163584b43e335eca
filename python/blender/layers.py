# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth that lies on cloth: doubled collars, pockets, plackets."""

import numpy as np
from mathutils.bvhtree import BVHTree

from .cage import column

# Cloth this near is a second layer. [m]
_NEAR = 0.01
_ENOUGH = 10
"""Vertices that make a layer."""


def are_near(sim, metre: float) -> bool:
    """Whether a part of the simulation mesh lies on another part; a metre is of so many units of the mesh."""
    points = column(sim.data.vertices, "co", 3)
    triangles = column(sim.data.loops, "vertex_index", kind=np.int32).reshape(-1, 3)
    edges = np.linalg.norm(points[triangles] - points[np.roll(triangles, 1, axis=1)], axis=2)
    # Within an edge, only the triangles around the vertex and its neighbours are found, unless cloth is folded.
    reach = min(_NEAR * metre, float(edges.mean()))
    tree = BVHTree.FromPolygons(points.tolist(), triangles.tolist(), all_triangles=True)
    around = _neighbours(len(points), triangles)
    found = 0
    for vertex, point in enumerate(points.tolist()):
        others = (triangles[face] for _, _, face, _ in tree.find_nearest_range(point, reach))
        found += any(around[vertex].isdisjoint(corners) for corners in map(np.ndarray.tolist, others))
        if found >= _ENOUGH:
            return True
    return False


def _neighbours(count: int, triangles) -> list[set[int]]:
    """Each vertex with those that it shares a triangle with."""
    found = [{vertex} for vertex in range(count)]
    for corners in triangles.tolist():
        for vertex in corners:
            found[vertex].update(corners)
    return found
