# SPDX-License-Identifier: GPL-3.0-or-later
"""What builds and checks said about each garment, and where on it that is."""

import bpy
import numpy as np
from mathutils import Vector, kdtree

from . import names
from .cage import read_cage
from .job import Refused

_of: dict[int, dict] = {}


def set_report(garment, report: dict) -> None:
    """Keeps the figures and warnings of a build."""
    _of[garment.session_uid] = {"messages": report.get("warnings", []), "report": report, "failed": False}


def set_faults(garment, faults: list[dict]) -> None:
    """Keeps why a build or check was refused; the last products stay, and are marked as not of this garment."""
    _of[garment.session_uid] = {"messages": faults, "report": None, "failed": True}


def of(garment) -> dict:
    return _of.get(garment.session_uid, {"messages": [], "report": None, "failed": False})


# Remedies in Blender, in place of those for files.
REMEDIES = {
    "polygonal-cage": "Add a Subdivision modifier",
    "no-uv-set": "Unwrap the garment: seams of the UV map are the seams of its panels",
    "no-mesh": "Give the mesh faces",
    "empty-mesh": "Give the mesh faces",
    "empty-set": "Choose Assign Selected for edges or faces of your own",
    "unknown-subset": "Choose Assign Selected for edges or faces of your own",
    "unknown-primvar": "Choose one of the vertex groups of the garment",
    "no-pattern": "Lay the UV map out to scale, as a sewing pattern, or set Rest to mesh",
}


def shown(garment, message: dict) -> str:
    """A message in words for the panel."""
    text = message["message"]
    remedy = REMEDIES.get(message.get("code"))
    if remedy and message.get("problem"):
        words = [message["place"], message["problem"]]
        text = ": ".join(word for word in words if word).rstrip(".") + ". " + remedy
    return text.replace(f"/{names.usd_name(garment.name)}/model", garment.name)


def clear() -> None:
    _of.clear()


def elements(message: dict) -> tuple[str, list[int]]:
    """The kind and the numbers of the elements that a message names."""
    named = message.get("elements") or {}
    for kind in ("points", "edges", "faces"):
        if named.get(kind):
            return kind, named[kind]
    return "", []


def select(garment: bpy.types.Object, message: dict) -> tuple[int, int]:
    """Selects the elements of a message in Edit Mode. Returns how many are selected, and how many were not found.

    Messages count the elements of the mesh with its modifiers. Those that a modifier made are found by their place, also on the
    other side of a mirror.
    """
    if garment.data.library:
        raise Refused(f"{garment.data.name} is linked from another file. Make it local first")
    kind, numbers = elements(message)
    cage = read_cage(garment)
    if garment.mode == "EDIT":
        bpy.ops.object.mode_set(mode="OBJECT")
    mesh = garment.data
    find = _Places(garment)
    starts = np.concatenate([[0], np.cumsum(cage.counts)])
    if kind == "faces":
        named = [cage.corners[starts[face] : starts[face + 1]] for face in numbers if face < len(cage.counts)]
        rows = mesh.polygons
    elif kind == "edges":
        named, rows = np.asarray(numbers).reshape(-1, 2), mesh.edges
    else:
        named, rows = [[point] for point in numbers if point < len(cage.points)], mesh.vertices
    known = {frozenset(getattr(row, "vertices", [row.index])): row for row in rows}
    places = [known.get(frozenset(find(cage.points[point]) for point in points)) for points in named]
    lost = sum(place is None for place in places)
    found = {row.index: row for row in places if row}.values()
    for rows in (mesh.vertices, mesh.edges, mesh.polygons):
        rows.foreach_set("select", np.zeros(len(rows), np.bool_))
    for element in found:
        element.select = True
        for vertex in getattr(element, "vertices", ()):
            mesh.vertices[vertex].select = True
    bpy.context.view_layer.objects.active = garment
    # Before, as Edit Mode selects what the kind of selection makes of this.
    bpy.context.tool_settings.mesh_select_mode = (kind == "points", kind == "edges", kind == "faces")
    bpy.ops.object.mode_set(mode="EDIT")
    return len(found), lost


class _Places:
    """Finds the vertex of the edited mesh at a place, or across its mirrors."""

    def __init__(self, garment) -> None:
        vertices = garment.data.vertices
        self.tree = kdtree.KDTree(len(vertices))
        for vertex in vertices:
            self.tree.insert(vertex.co, vertex.index)
        self.tree.balance()
        self.near = 1e-4 * max(max(garment.dimensions), 1e-6) / max(max(abs(s) for s in garment.scale), 1e-6)
        self.flips = [Vector((1, 1, 1))]
        for modifier in garment.modifiers:
            if modifier.type == "MIRROR" and not modifier.mirror_object:
                for axis in range(3):
                    if modifier.use_axis[axis]:
                        flip = Vector((1, 1, 1))
                        flip[axis] = -1
                        self.flips += [known * flip for known in self.flips]

    def __call__(self, place) -> int | None:
        for flip in self.flips:
            _, index, distance = self.tree.find(Vector(place) * flip)
            if index is not None and distance <= self.near:
                return index
        return None

