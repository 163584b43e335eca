# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated render mesh as shape keys, one for each frame."""

import bpy
import numpy as np

from .links import KIND, OWN, product

BAKED = "baked"
"""The kind of the copy that has the shape keys."""
_LINEAR = 1


def bake(garment: bpy.types.Object, render: bpy.types.Object, frames) -> bpy.types.Object:
    """Makes a copy of the render mesh with a shape key for each frame and its points, and hides the render mesh.

    The modifiers that move the render mesh are left out, and the user's own stay. An earlier copy is replaced.
    """
    if old := product(garment, BAKED):
        _remove(old)
    ob = render.copy()
    ob.data = render.data.copy()
    ob.name = ob.data.name = f"{garment.name}_{BAKED}"
    ob[KIND] = BAKED
    for collection in render.users_collection:
        collection.objects.link(ob)
    for modifier in [modifier for modifier in ob.modifiers if modifier.name.startswith(OWN) and modifier.type != "SUBSURF"]:
        ob.modifiers.remove(modifier)
    ob.shape_key_clear()
    ob.shape_key_add(name="Basis", from_mix=False)
    times = []
    for at, points in frames:
        key = ob.shape_key_add(name=f"Frame {at:.0f}", from_mix=False)
        key.data.foreach_set("co", np.asarray(points, np.float32).ravel())
        times.append(at)
    _animate(ob, times)
    render.hide_set(True)
    render.hide_render = True
    return ob


def _remove(ob) -> None:
    mesh, keys = ob.data, ob.data.shape_keys
    action = keys.animation_data.action if keys and keys.animation_data else None
    bpy.data.objects.remove(ob)
    for data, known in ((mesh, bpy.data.meshes), (action, bpy.data.actions)):
        if data and not data.users:
            known.remove(data)


def _animate(ob, times: list[float]) -> None:
    """Each shape is whole at its frame, and gone at those beside it. Between frames, and in motion blur, two are mixed."""
    keys = ob.data.shape_keys
    action = bpy.data.actions.new(ob.name)
    slot = action.slots.new("KEY", keys.name)
    curves = action.layers.new("Frames").strips.new(type="KEYFRAME").channelbag(slot, ensure=True).fcurves
    for number, key in enumerate(keys.key_blocks[1:]):
        near = range(max(number - 1, 0), min(number + 2, len(times)))
        curve = curves.new(f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value')
        curve.keyframe_points.add(len(near))
        curve.keyframe_points.foreach_set("co", np.array([(times[place], float(place == number)) for place in near]).ravel())
        curve.keyframe_points.foreach_set("interpolation", [_LINEAR] * len(near))
        curve.update()
    data = keys.animation_data_create()
    data.action, data.action_slot = action, slot
