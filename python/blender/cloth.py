# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own cloth on the simulation mesh."""

import re

import bpy
import numpy as np

from . import recipe

SEWING = "tailor_sewing"
"""Property of a simulation mesh: pairs of vertices, of a piece that is attached and of the triangle below it."""
PINS = "tailor_pins"
"""Property of a simulation mesh: the vertices that the recipe holds."""
PHYSICS = "tailor_physics"
"""Property of a simulation mesh: its fabric as numbers, in SI units."""
MODIFIER = "Tailor Cloth"
PIN_GROUP = "Tailor Pins"
WEIGHT = "weight({})"

# Cotton in our table, and the stiffness that Blender's preset has for it. Other fabrics are stiffer or softer in proportion.
_COTTON = {"surfaceStretchStiffness": 10500.0, "surfaceShearStiffness": 60.0, "surfaceBendStiffness": 6.5e-6}
_BLENDER = {"surfaceStretchStiffness": 15.0, "surfaceShearStiffness": 5.0, "surfaceBendStiffness": 0.5}
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
        # What the user has changed since stays when the mesh is built again.
        settings.quality = 8
        modifier.collision_settings.distance_min = 0.003
        _set_fabric(sim, settings)
        scene = bpy.context.scene
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = scene.frame_start, scene.frame_end
    return f"{held} vertices held, {sewn} edges hold pieces on the cloth"


def _set_fabric(sim, settings) -> None:
    figures = sim.get(PHYSICS, {})
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
    pairs = np.asarray(sim.get(SEWING, []), np.int32).reshape(-1, 2)
    mesh = sim.data
    ends = np.empty(len(mesh.edges) * 2, np.int32)
    mesh.edges.foreach_get("vertices", ends)
    known = set(map(tuple, np.sort(ends.reshape(-1, 2), axis=1).tolist()))
    new = sorted(set(map(tuple, np.sort(pairs, axis=1).tolist())) - known)
    if new:
        mesh.edges.add(len(new))
        mesh.edges.foreach_set("vertices", np.concatenate([ends, np.asarray(new, np.int32).ravel()]))
        mesh.update()
    return len(set(map(tuple, np.sort(pairs, axis=1).tolist())))


def pin_group(garment: bpy.types.Object) -> str:
    """The vertex group that holds the cloth; empty for none, or for sets that are no group."""
    found = re.fullmatch(r'weight\((?:"(.*)"|([^",]*))\)', str(garment.get("tailor:cloth:pins", "")))
    name = (found[1] or found[2]) if found else ""
    return next((group.name for group in garment.vertex_groups if recipe.names.usd_name(group.name) == name), "")


def _pin(garment, sim, settings) -> int:
    """Sets the pin group: the garment's own with its weights, or one of the vertices of the sets that the recipe names."""
    name = pin_group(garment)
    if name and name in sim.vertex_groups:
        settings.vertex_group_mass = name
        number = sim.vertex_groups[name].index
        return sum(any(e.group == number and e.weight > 0 for e in vertex.groups) for vertex in sim.data.vertices)
    pins = [int(i) for i in sim.get(PINS, [])]
    if pins:
        group = sim.vertex_groups.get(PIN_GROUP) or sim.vertex_groups.new(name=PIN_GROUP)
        group.add(pins, 1.0, "REPLACE")
        settings.vertex_group_mass = PIN_GROUP
    return len(pins)
