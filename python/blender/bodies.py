# SPDX-License-Identifier: GPL-3.0-or-later
"""What the cloth collides with: the body that wears the garment, and other meshes beside it."""

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import recipe
from .links import OF, OWN

MODIFIER = OWN + "Collision"

LINKED = "{} is linked from another file. Give it a Collision modifier there, or make a library override"

# Of a body, so many points of the garment are at most so far. [share of the points, share of the garment's largest size]
_SHARE, _REACH = 0.05, 0.05
_SAMPLES = 400
# Distance that the body keeps the cloth, beside that of the cloth itself. [m]
_THICKNESS = 0.001


def around(sim: bpy.types.Object) -> list[bpy.types.Object]:
    """Meshes whose bounding boxes meet the garment's: bodies, floors and others. Garments and their products are left out."""
    low, high = _box(sim)
    found = []
    for ob in bpy.context.visible_objects:
        if ob.type == "MESH" and ob.data.polygons and not recipe.is_garment(ob) and OF not in ob and not _is_cloth(ob):
            lowest, highest = _box(ob)
            if (lowest <= high).all() and (highest >= low).all():
                found.append(ob)
    return found


def is_collider(ob: bpy.types.Object) -> bool:
    return ob.collision is not None and ob.collision.use and any(modifier.type == "COLLISION" for modifier in ob.modifiers)


def set_up(sim: bpy.types.Object) -> str:
    """Lets the cloth collide with the bodies that are near, and tells with which."""
    found = [ob for ob in around(sim) if is_collider(ob) or _is_near(sim, ob)]
    linked = [ob for ob in found if not is_collider(ob) and not is_editable(ob)]
    for ob in found:
        if ob not in linked and not is_collider(ob):
            collide(ob, True)
    told = [ob.name for ob in found if ob not in linked]
    text = f"collides with {', '.join(told)}" if told else "no body is near it"
    if linked:
        text += "; " + LINKED.format(linked[0].name)
    return text


def collide(ob: bpy.types.Object, is_on: bool) -> None:
    """Gives an object our Collision modifier, or takes it away. One of the user's own is switched."""
    if own := ob.modifiers.get(MODIFIER):
        ob.modifiers.remove(own)
    if ob.collision is not None and any(modifier.type == "COLLISION" for modifier in ob.modifiers):
        ob.collision.use = is_on
    elif is_on:
        ob.modifiers.new(MODIFIER, "COLLISION")
        ob.collision.use = True
        ob.collision.thickness_outer = _THICKNESS / bpy.context.scene.unit_settings.scale_length


def _is_cloth(ob) -> bool:
    return any(modifier.type == "CLOTH" for modifier in ob.modifiers)


def is_editable(ob) -> bool:
    return ob.library is None


def _box(ob) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([ob.matrix_world @ Vector(corner) for corner in ob.bound_box])
    return corners.min(axis=0), corners.max(axis=0)


def _is_near(sim, ob) -> bool:
    """Whether a part of the garment lies on the object, as clothes lie on a body."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    tree, below = BVHTree.FromObject(ob, depsgraph), ob.matrix_world.inverted_safe()
    vertices = sim.evaluated_get(depsgraph).data.vertices
    low, high = _box(sim)
    reach, near, count = _REACH * (high - low).max(), 0, 0
    for number in range(0, len(vertices), max(1, len(vertices) // _SAMPLES)):
        point = sim.matrix_world @ vertices[number].co
        place, *_ = tree.find_nearest(below @ point)
        count += 1
        near += place is not None and (ob.matrix_world @ place - point).length <= reach
    return near >= _SHARE * count
