# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects are the products of which garment."""

import bpy

OF = "tailor_of"
"""Property of a product: its garment."""
KIND = "tailor_kind"
"""Property of a product: which it is."""
KINDS = ("sim", "render")
OWN = "Tailor "
"""Modifiers that begin so are ours."""


def product(garment: bpy.types.Object, kind: str) -> bpy.types.Object | None:
    """The object that a build made of the garment."""
    return next((ob for ob in bpy.data.objects if ob.get(OF) == garment and ob.get(KIND) == kind), None)


def garment_of(ob: bpy.types.Object | None) -> bpy.types.Object | None:
    """The garment, of itself or of one of its products."""
    return (ob.get(OF) or ob) if ob else None


_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


def set_rendered(ob: bpy.types.Object, is_rendered: bool) -> None:
    """Leaves an object out of pictures. It stays in exports, which leave out what is disabled in renders."""
    for ray in _RAYS:
        setattr(ob, f"visible_{ray}", is_rendered)
