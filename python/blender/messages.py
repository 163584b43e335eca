# SPDX-License-Identifier: GPL-3.0-or-later
"""What builds and checks said about each garment, and where on it that is."""

import re

import bpy
import numpy as np
from mathutils import Vector, kdtree

from . import names, recipe
from .cage import read_cage
from .job import Refused

_of: dict[int, dict] = {}


def set_report(garment, report: dict) -> None:
    """Keeps the figures and warnings of a build."""
    report["warnings"] = _together(garment, report.get("warnings", []))
    _of[garment.session_uid] = {"messages": report["warnings"], "report": report, "failed": False}


# Of solvers that take one fabric for a mesh, which the cloth here does not.
_ELSEWHERE = {"mean-fabric"}
# What happens to sets where the triangles are larger.
_OF_SETS = {"not-carried", "sets-blurred", "area-changed", "empty-set"}


def _together(garment, warnings: list[dict]) -> list[dict]:
    """One message for all sets that no option names, as of a file that was imported; the others as they are."""
    options = " ".join(str(value) for value in recipe.properties(garment).values())
    sets = {names.usd_name(attribute.name) for attribute in garment.data.attributes if attribute.data_type == "BOOLEAN"}
    unused = {name for name in sets if not re.search(rf"\b{re.escape(name)}\b(?!\()", options)}
    kept, lost = [], {}
    for warning in warnings:
        named = warning.get("names") or [warning.get("place", "").removeprefix("subset ")]
        if warning["code"] in _OF_SETS and unused.issuperset(named):
            lost |= dict.fromkeys(named)
        elif warning["code"] not in _ELSEWHERE:
            kept.append(warning)
    if lost:
        first, more = ", ".join(list(lost)[:3]), f" and {len(lost) - 3} more" if len(lost) > 3 else ""
        place, problem = f"attributes {first}{more}", "they lose elements where triangles are larger, and no option names them"
        remedy = "Remove those that you do not need, or lower Max edge length"
        kept.append({"code": "unused-sets", "message": f"{place}: {problem}. {remedy}", "place": place, "problem": problem, "remedy": remedy, "elements": {}})
    return kept


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
    text = _BARE.sub(lambda found: _labels().get(found[0], found[0]), _KEY.sub(_in_words, text))
    return _MAP.sub(f"UV map {_main_map(garment)}", text).replace("`", "").replace(f"/{names.usd_name(garment.name)}/model", garment.name)


# An option as the command names it: `seam.side.width`, or sim.maxEdgeLength=2; and a seam: `seam.side`.
_KEY = re.compile(r"`?\b([a-z]+)(?:\.([^\s.`=,]+))?\.(\w+)(?:`|\b)(\s*=)?")


# An option without its group, and the primvar of the main UV map.
_BARE = re.compile(r"\b[a-z]+[A-Z]\w*\b")
_MAP = re.compile(rf"([\w/]+\.)?primvars:{names.UV_SET}\b")


def _labels() -> dict[str, str]:
    return {of.key: of.label.lower() for options in recipe.table().values() for of in options}


def _main_map(garment) -> str:
    return next((layer.name for layer in garment.data.uv_layers if layer.active_render), names.UV_SET)


def _in_words(found: re.Match) -> str:
    group, instance, key, equals = found.groups()
    name = names.key(group, *filter(None, (instance,)), key)
    if recipe.option_of(name):
        return recipe.told(name) + (" = " if equals else "")
    return f"{group} {key}" if group in recipe.SETS and not instance else found[0]


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

