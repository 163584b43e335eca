# SPDX-License-Identifier: GPL-3.0-or-later
"""The place of each point of the render mesh on the simulation mesh, and what turns it, as attributes of both meshes.

Names that begin with a dot are hidden in Blender, and are not exported.
"""

import numpy as np
from mathutils import Matrix

from .cage import column

FACE, COORDS = "tailor:bindFace", "tailor:bindCoords"
"""Attributes of the render mesh, as in USD: a triangle, and the weights of its first and second corner."""
REST = ".tailor_rest"
"""The points of both meshes when they were made."""
UNTURN = ".tailor_unturn"
"""The rotation of each vertex of the simulation mesh from its frame at bind to the axes."""
SHARES = ".tailor_share_x", ".tailor_share_y"
"""Of each corner: how much its next and its previous edge count in the first and the second direction of its vertex."""

# A vertex whose edges are nearly on one line has no directions in its plane.
_LEAST_DETERMINANT = 1e-6


def fill(sim, render, prim) -> None:
    """Notes the binding that a build wrote on the prim of the render mesh."""
    faces, coords = (prim.GetAttribute(f"primvars:{name}").Get() for name in (FACE, COORDS))
    if faces is None or coords is None:
        return
    _put(render.data, FACE, "INT", "POINT", "value", np.asarray(faces, np.int32))
    _put(render.data, COORDS, "FLOAT_VECTOR", "POINT", "vector", np.asarray(coords, np.float32))
    for mesh in (sim.data, render.data):
        _put(mesh, REST, "FLOAT_VECTOR", "POINT", "vector", column(mesh.vertices, "co", 3))
    frames, shares = _frames(column(sim.data.vertices, "co", 3), column(sim.data.loops, "vertex_index", kind=np.int32).reshape(-1, 3))
    _put(sim.data, UNTURN, "QUATERNION", "POINT", "value", np.array([Matrix(frame).to_quaternion() for frame in frames]))
    for name, share in zip(SHARES, shares):
        _put(sim.data, name, "FLOAT_VECTOR", "CORNER", "vector", np.c_[share, np.zeros(len(share))])


def is_filled(ob) -> bool:
    return FACE in ob.data.attributes


def _put(mesh, name: str, kind: str, domain: str, member: str, values) -> None:
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
    attribute.data.foreach_set(member, np.ascontiguousarray(values).ravel())


def _frames(points, triangles):
    """The frame of each vertex as rows x, y and normal, of shape (n, 3, 3); and for both directions the shares of corners, (corners, 2).

    Sums of edges by their shares are the directions. The same sums on a moved mesh are where the directions went.
    """
    points = points.astype(np.float64)
    at = points[triangles]
    edges = np.stack([np.roll(at, -step, axis=1) - at for step in (1, 2)], axis=2).reshape(-1, 2, 3)
    vertices = triangles.ravel()

    def summed(values):
        return np.bincount(vertices, values, len(points))

    across = np.cross(edges[:, 0], edges[:, 1])
    normals = _unit(np.stack([summed(across[:, axis]) for axis in range(3)], axis=1), (0, 0, 1))
    # Any direction but the normal's: its smallest number is the furthest from it.
    x = np.cross(np.eye(3)[np.abs(normals).argmin(axis=1)], normals)
    frames = np.stack([_unit(x, (1, 0, 0)), np.cross(normals, _unit(x, (1, 0, 0))), normals], axis=1)
    flat = np.einsum("cij,cej->cei", frames[vertices][:, :2], edges)
    xx, xy, yy = (summed(product.sum(axis=1))[vertices, None] for product in (flat[..., 0] ** 2, flat[..., 0] * flat[..., 1], flat[..., 1] ** 2))
    determinant = xx * yy - xy * xy
    scale = np.divide(1, determinant, out=np.zeros_like(determinant), where=determinant > _LEAST_DETERMINANT * xx * yy)
    return frames, (scale * (yy * flat[..., 0] - xy * flat[..., 1]), scale * (xx * flat[..., 1] - xy * flat[..., 0]))


def _unit(vectors, otherwise):
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1), otherwise)
