# SPDX-License-Identifier: GPL-3.0-or-later
"""The garment as USD for other programs, by Blender's own exporter."""

import bpy

from .cage import NOT_OF_CAGE
from .products import stand_in


def write(garment: bpy.types.Object, path: str) -> set[str]:
    """Writes one garment with its skin, shape keys, materials, sets and recipe. The selection and the garment stay as they are."""
    selected, active = list(bpy.context.selected_objects), bpy.context.view_layer.objects.active
    made = stand_in(garment) if _loses_modifiers(garment) else None
    names = (garment.name, garment.data.name)
    try:
        for ob in selected:
            ob.select_set(False)
        if made:
            # The stand-in is exported under the garment's name.
            garment.name, garment.data.name = (name + " (garment)" for name in names)
            made.name, made.data.name = names
        for ob in _exported(made or garment):
            ob.select_set(True)
        return bpy.ops.wm.usd_export(
            filepath=path, selected_objects_only=True, export_custom_properties=True, author_blender_name=True, allow_unicode=True
        )
    finally:
        if made:
            mesh = made.data
            bpy.data.objects.remove(made)
            bpy.data.meshes.remove(mesh)
            garment.name, garment.data.name = names
        for ob in bpy.context.selected_objects:
            ob.select_set(False)
        for ob in selected:
            ob.select_set(True)
        bpy.context.view_layer.objects.active = active


def _loses_modifiers(garment) -> bool:
    """Whether Blender would leave out modifiers such as Mirror: it does where it writes a skin or shape keys."""
    is_moved = garment.data.shape_keys or any(modifier.type == "ARMATURE" for modifier in garment.modifiers)
    return bool(is_moved) and any(modifier.type not in NOT_OF_CAGE and modifier.show_viewport for modifier in garment.modifiers)


def _exported(garment) -> list[bpy.types.Object]:
    """The garment, and the armatures without which it has no skin."""
    return [garment, *(modifier.object for modifier in garment.modifiers if modifier.type == "ARMATURE" and modifier.object)]
