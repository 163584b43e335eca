"""Simulation meshes with the same triangles on both sides of a plane, seen from usd-core."""

import numpy as np
import pytest
from conftest import EXAMPLES

OPTION = ("--set", "sim.symmetry=true")


def twins(mesh):
    """The vertex at the mirror image of each, and how far away it is, in mean edges."""
    points = mesh.points
    nearest = []
    for places in np.array_split(points * [-1, 1, 1], max(1, len(points) // 500)):
        squares = (places**2).sum(axis=1)[:, None] + (points**2).sum(axis=1) - 2 * places @ points.T
        nearest.extend(squares.argmin(axis=1))
    nearest = np.array(nearest)
    edges = points[mesh.topology.edges]
    mean = np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).mean()
    return nearest, np.linalg.norm(points[nearest] - points * [-1, 1, 1], axis=1) / mean


def share_of_twin_triangles(mesh):
    nearest, _ = twins(mesh)
    triangles = {tuple(sorted(triangle)) for triangle in mesh.indices.reshape(-1, 3).tolist()}
    return np.mean([tuple(sorted(nearest[list(triangle)].tolist())) in triangles for triangle in triangles])


@pytest.mark.parametrize("name, asymmetric", [("coat", {2202, 2203, 2204}), ("trousers", set(range(756, 766)))])
def test_both_sides_have_the_same_triangles(name, asymmetric, build):
    even, plain = (build(EXAMPLES / f"{name}.usda", *options, stem=stem) for stem, options in (("even", OPTION), ("plain", ())))
    _, off = twins(even.sim)
    assert np.median(off) < 1e-4 < 0.05 < np.median(twins(plain.sim)[1])
    assert share_of_twin_triangles(even.sim) > 0.99 > 0.9 > share_of_twin_triangles(plain.sim)
    (told,) = [warning for warning in even.report["warnings"] if warning["code"] == "asymmetric"]
    assert asymmetric <= set(told["elements"]["faces"]) and "asymmetric" not in {w["code"] for w in plain.report["warnings"]}
    # One piece as before, with the borders that it had.
    loops = [len(mesh.topology.edges) - len(mesh.points) - len(mesh.counts) for mesh in (even.sim, plain.sim)]
    assert loops[0] == loops[1] and not even.sim.topology.non_manifold_edges().any()
