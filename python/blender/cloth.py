# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own cloth on the simulation mesh."""

import re

import bpy
import numpy as np

from . import recipe
from .cage import column

FACTS = "tailor_cloth"
"""Property of a simulation mesh, of what a solver needs beside it:

- ``sewing``: pairs of vertices, of a piece that is attached and of the triangle below it;
- ``pins``: the vertices that the recipe holds;
- ``mass`` and the stiffness of the fabric, in SI units.
"""
MODIFIER = "Tailor Cloth"
PIN_GROUP = "Tailor Pins"
WEIGHT = "weight({})"

# Cotton in our table, and the stiffness that Blender's preset has for it. Other fabrics are stiffer or softer in proportion.
_COTTON = {"surfaceStretchStiffness": 10500.0, "surfaceShearStiffness": 60.0, "surfaceBendStiffness": 6.5e-6}
_BLENDER = {"surfaceStretchStiffness": 15.0, "surfaceShearStiffness": 5.0, "surfaceBendStiffness": 0.5}
# Distance that cloth keeps from bodies. [m]
_DISTANCE = 0.003
# Real cloth is stiffer for its mass than Blender's solver follows within its steps.
_HEAVIER = 100.0


def is_set_up(sim: bpy.types.Object) -> bool:
    return MODIFIER in sim.modifiers


def set_up(garment: bpy.types.Object, sim: bpy.types.Object) -> str:
    """Gives the simulation mesh a Cloth modifier, or prepares the one that it has for a new mesh. Returns what was done."""
    is_new = not is_set_up(sim)
    modifier = sim.modifiers.new(MODIFIER, "CLOTH") if is_new else sim.modifiers[MODIFIER]
    sewn = _sew(sim)
    settings = modifier.settings
    held = _pin(garment, sim, settings)
    if is_new:
        # Settings of the user stay when the mesh is built again.
        settings.quality = 8
        modifier.collision_settings.distance_min = _DISTANCE / bpy.context.scene.unit_settings.scale_length
        _set_fabric(sim, settings)
        scene = bpy.context.scene
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = scene.frame_start, scene.frame_end
    return f"{held} vertices held, {sewn} edges hold pieces on the cloth"


def _set_fabric(sim, settings) -> None:
    figures = sim.get(FACTS, {})
    count = max(len(sim.data.vertices), 1)
    if "mass" in figures:
        settings.mass = _HEAVIER * figures["mass"] / count

    def stiffness(name: str) -> float:
        return _BLENDER[name] * figures.get(name, _COTTON[name]) / _COTTON[name]

    settings.tension_stiffness = settings.compression_stiffness = stiffness("surfaceStretchStiffness")
    settings.shear_stiffness = stiffness("surfaceShearStiffness")
    settings.bending_stiffness = stiffness("surfaceBendStiffness")


def _sew(sim) -> int:
    """Adds the edges that hold attached pieces. An edge without a face is a spring of its own length for the solver."""
    pairs = np.asarray(sim.get(FACTS, {}).get("sewing", []), np.int32).reshape(-1, 2)
    ends = column(sim.data.edges, "vertices", 2, np.int32)
    wanted, known = ({tuple(pair) for pair in np.sort(rows, axis=1).tolist()} for rows in (pairs, ends))
    if new := sorted(wanted - known):
        sim.data.edges.add(len(new))
        sim.data.edges.foreach_set("vertices", np.concatenate([ends, np.asarray(new, np.int32)]).ravel())
        sim.data.update()
    return len(wanted)


def pin_group(garment: bpy.types.Object) -> str:
    """The vertex group that holds the cloth; empty for none, or for sets that are no group."""
    found = re.fullmatch(r'weight\((?:"(.*)"|([^",]*))\)', str(garment.get("tailor:cloth:pins", "")))
    name = (found[1] or found[2]) if found else ""
    primvars = recipe.group_primvars([group.name for group in garment.vertex_groups])
    return next((group for group, primvar in primvars.items() if primvar == name), "")


def _pin(garment, sim, settings) -> int:
    """Makes the pin group, and returns how many vertices it holds at least in part.

    Of a vertex group of the garment, what weighs a half or more is held wholly, as in the recipe: a line of weights of 1 is lower on
    the smooth surface, which is between the points of the cage.
    """
    weights = _held(garment, sim)
    if (old := sim.vertex_groups.get(PIN_GROUP)) is not None:
        sim.vertex_groups.remove(old)
    if weights.any():
        fill_group(sim.vertex_groups.new(name=PIN_GROUP), weights)
        settings.vertex_group_mass = PIN_GROUP
    return int((weights > 0).sum())


def _held(garment, sim) -> np.ndarray:
    weights = np.zeros(len(sim.data.vertices), np.float32)
    name = pin_group(garment)
    if name and name in sim.vertex_groups:
        number = sim.vertex_groups[name].index
        for vertex in sim.data.vertices:
            for element in vertex.groups:
                if element.group == number:
                    weights[vertex.index] = min(1.0, 2 * element.weight)
    else:
        weights[[int(i) for i in sim.get(FACTS, {}).get("pins", [])]] = 1.0
    return weights


_WEIGHT_STEPS = 8192


def fill_group(group: bpy.types.VertexGroup, weights: np.ndarray) -> None:
    """Sets the weights of a new group, by one call for all vertices of a weight. A step moves no point by a tenth of a millimetre."""
    steps = np.round(weights * _WEIGHT_STEPS).astype(np.int32)
    order = np.argsort(steps, kind="stable")
    starts = np.flatnonzero(np.diff(steps[order], prepend=-1))
    for rows in np.split(order, starts[1:]):
        if step := int(steps[rows[0]]):
            group.add(rows.tolist(), step / _WEIGHT_STEPS, "REPLACE")
