# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment as arrays: the mesh before its Subdivision modifier, with all that is painted, marked and named on it."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import names

# Modifiers that subdivide or move the cage. The products have these of their own.
NOT_OF_CAGE = {"SUBSURF", "MULTIRES", "ARMATURE", "CLOTH", "COLLISION", "MESH_SEQUENCE_CACHE", "MESH_CACHE", "LATTICE", "MESH_DEFORM",
               "SURFACE_DEFORM", "SOFT_BODY"}  # fmt: skip

# The member of a value and its numbers, of each type of attribute that USD has too.
TYPES = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
}

# The domain of an attribute for the interpolation of a primvar.
DOMAINS = {"vertex": "POINT", "varying": "POINT", "uniform": "FACE", "faceVarying": "CORNER"}

# Attributes that are read from where Blender's own functions have them.
KNOWN = {"position", "material_index", "crease_edge", "crease_vert", "sharp_face", names.SEAMS, ".uv_seam", "bevel_weight_edge",
         "bevel_weight_vert"}  # fmt: skip


@dataclass
class Values:
    """An attribute of points, faces or corners."""

    domain: str
    type: str
    array: np.ndarray


@dataclass
class Cage:
    """Rows are in the order of the mesh. Shapes: points (n, 3), edges (n, 2), UVs (corners, 2)."""

    points: np.ndarray
    corners: np.ndarray
    counts: np.ndarray
    edges: np.ndarray
    uv: dict[str, np.ndarray] = field(default_factory=dict)
    active_uv: str = ""
    """The UV map that is active for rendering."""
    edge_sets: dict[str, np.ndarray] = field(default_factory=dict)
    """Numbers of edges."""
    face_sets: dict[str, np.ndarray] = field(default_factory=dict)
    point_sets: dict[str, np.ndarray] = field(default_factory=dict)
    edge_creases: np.ndarray | None = None
    point_creases: np.ndarray | None = None
    values: dict[str, Values] = field(default_factory=dict)
    groups: dict[str, np.ndarray] = field(default_factory=dict)
    """The weights of each vertex group, by its name."""
    shapes: dict[str, np.ndarray] = field(default_factory=dict)
    """Offsets of each shape key but the first, by its name."""
    material_index: np.ndarray | None = None
    smooth_faces: np.ndarray | None = None
    notes: list[str] = field(default_factory=list)
    """What could not be read, in words for the user."""


def column(rows, member: str, width: int = 1, kind=np.float32) -> np.ndarray:
    """One member of all elements."""
    found = np.empty(len(rows) * width, kind)
    rows.foreach_get(member, found)
    return found if width == 1 else found.reshape(-1, width)


def read_cage(ob: bpy.types.Object) -> Cage:
    """The cage of a garment as it is now, in Edit Mode too. Nothing of the object changes."""
    if ob.mode == "EDIT":
        ob.update_from_editmode()
    with _copied(ob) as (copy, evaluated):
        mesh = evaluated()
        cage = _read_mesh(mesh, ob)
        cage.shapes, cage.notes = _shapes(copy, evaluated, len(mesh.vertices))
    return cage


@contextmanager
def _copied(ob):
    """A copy of the object with the modifiers of the cage alone, in a scene of its own; and its mesh, once evaluated.

    The user's object and scene are not touched, so that neither undo nor a change of the view shows the copy.
    """
    copy, data = ob.copy(), ob.data.copy()
    copy.data = data
    for modifier in list(copy.modifiers):
        if modifier.type in NOT_OF_CAGE or not modifier.show_viewport:
            copy.modifiers.remove(modifier)
    for constraint in list(copy.constraints):
        copy.constraints.remove(constraint)
    copy.animation_data_clear()
    scene = bpy.data.scenes.new(".tailor")
    scene.collection.objects.link(copy)
    copy.hide_viewport = False

    def evaluated():
        if not copy.modifiers and not data.shape_keys:
            return data
        layer = scene.view_layers[0]
        layer.update()
        return copy.evaluated_get(layer.depsgraph).data

    try:
        if data.shape_keys:
            if data.shape_keys.animation_data:
                data.shape_keys.animation_data_clear()
            # The first shape is the cage, whatever the others are set to.
            copy.show_only_shape_key = True
            copy.active_shape_key_index = 0
        yield copy, evaluated
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(data)


def _read_mesh(mesh, ob) -> Cage:
    cage = Cage(
        points=column(mesh.vertices, "co", 3),
        corners=column(mesh.loops, "vertex_index", kind=np.int32),
        counts=column(mesh.polygons, "loop_total", kind=np.int32),
        edges=column(mesh.edges, "vertices", 2, np.int32),
    )
    for layer in mesh.uv_layers:
        cage.uv[layer.name] = column(layer.uv, "vector", 2)
        if layer.active_render:
            cage.active_uv = layer.name
    if (seams := column(mesh.edges, "use_seam", kind=np.bool_)).any():
        cage.edge_sets[names.SEAMS] = np.flatnonzero(seams)
    for attribute in mesh.attributes:
        if not attribute.name.startswith(".") and attribute.name not in KNOWN and attribute.name not in mesh.uv_layers:
            _read_attribute(attribute, cage)
    cage.edge_creases = _floats(mesh, "crease_edge")
    cage.point_creases = _floats(mesh, "crease_vert")
    cage.material_index = column(mesh.polygons, "material_index", kind=np.int32)
    cage.smooth_faces = column(mesh.polygons, "use_smooth", kind=np.bool_)
    cage.groups = _groups(mesh, ob)
    return cage


def _read_attribute(attribute, cage: Cage) -> None:
    if attribute.data_type not in TYPES:
        cage.notes.append(f"Attribute {attribute.name}: values of the type {attribute.data_type} are left out")
        return
    member, width, kind = TYPES[attribute.data_type]
    array = column(attribute.data, member, width, kind)
    sets = {"EDGE": cage.edge_sets, "FACE": cage.face_sets, "POINT": cage.point_sets}
    if attribute.data_type == "BOOLEAN" and attribute.domain in sets:
        found = sets[attribute.domain]
        found[names.unique(names.usd_name(attribute.name), found)] = np.flatnonzero(array)
    elif attribute.domain == "EDGE":
        cage.notes.append(f"Attribute {attribute.name}: only true-or-false values of edges are carried")
    else:
        cage.values[attribute.name] = Values(attribute.domain, attribute.data_type, array)


def _floats(mesh, name: str) -> np.ndarray | None:
    attribute = mesh.attributes.get(name)
    return column(attribute.data, "value") if attribute else None


def _groups(mesh, ob) -> dict[str, np.ndarray]:
    weights = np.zeros((len(ob.vertex_groups), len(mesh.vertices)), np.float32)
    if len(weights):
        for vertex in mesh.vertices:
            for element in vertex.groups:
                if element.group < len(weights):
                    weights[element.group, vertex.index] = element.weight
    return {group.name: weights[group.index] for group in ob.vertex_groups}


def _shapes(copy, evaluated, count: int) -> tuple[dict[str, np.ndarray], list[str]]:
    """Offsets of the shape keys through the modifiers of the cage."""
    found, notes = {}, []
    keys = copy.data.shape_keys
    if not keys or len(keys.key_blocks) < 2:
        return found, notes
    base = column(evaluated().vertices, "co", 3)
    for number, shape in enumerate(keys.key_blocks[1:], 1):
        copy.active_shape_key_index = number
        mesh = evaluated()
        if len(mesh.vertices) == count:
            found[shape.name] = column(mesh.vertices, "co", 3) - base
        else:
            notes.append(f"Shape key {shape.name}: a modifier gives it {len(mesh.vertices)} vertices, and the first {count}; it is left out")
    return found, notes
