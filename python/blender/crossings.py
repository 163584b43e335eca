# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth that passes through itself: pairs of triangles of the simulation mesh that cross."""

import numpy as np
from mathutils.bvhtree import BVHTree

from .cage import column
from .cloth import FACTS

_NOTE = "crossings"
"""The last frame that was simulated, and the pairs of triangles that cross there and in the first; beside the facts of the mesh."""


def count(points: np.ndarray, triangles: np.ndarray) -> int:
    """Pairs of triangles that cross. Those that share a vertex do not count."""
    tree = BVHTree.FromPolygons(points.tolist(), triangles.tolist(), all_triangles=True)
    pairs = np.array(tree.overlap(tree), np.int64).reshape(-1, 2)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    corners = triangles[pairs]
    is_shared = (corners[:, 0, :, None] == corners[:, 1, None, :]).any(axis=(1, 2))
    return int((~is_shared).sum())


def note(sim, frames: list[int], points: list[np.ndarray]) -> None:
    """Notes the crossings of the first and the last frame on the simulation mesh."""
    triangles = column(sim.data.loops, "vertex_index", kind=np.int32).reshape(-1, 3)
    if FACTS not in sim:
        sim[FACTS] = {}
    sim[FACTS][_NOTE] = [frames[-1], count(points[-1], triangles), count(points[0], triangles)]


def told(sim) -> tuple[str, bool]:
    """The crossings in words, and whether the simulation made any; an empty text before it has run."""
    noted = sim.get(FACTS, {}).get(_NOTE) if sim else None
    if not noted:
        return "", False
    frame, last, first = noted
    return f"{last or 'No'} crossings at frame {frame}, {first or 'none'} at the first", last > first
