# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own cloth on the simulation mesh."""

import re

import bpy
import numpy as np

from . import layers, recipe
from .cage import column
from .links import OWN

FACTS = "tailor_cloth"
"""Property of a simulation mesh, of what a solver needs beside it:

- ``sewing``: pairs of vertices, of a piece that is attached and of the triangle below it;
- ``pins``: the vertices that the recipe holds;
- ``mass`` and the stiffness of the fabric, in SI units.
"""
MODIFIER = OWN + "Cloth"
PIN_GROUP = OWN + "Pins"
WEIGHT = "weight({})"

STIFFNESS = {"surfaceStretchStiffness": ".tailor_stretch", "surfaceShearStiffness": ".tailor_shear", "surfaceBendStiffness": ".tailor_bend"}
"""Attributes of the points of a simulation mesh of several fabrics: the stiffness of each, in SI units."""

# Cotton in our table, and the stiffness that Blender's preset has for it. Other fabrics are stiffer or softer in proportion.
_COTTON = {"surfaceStretchStiffness": 10500.0, "surfaceShearStiffness": 60.0, "surfaceBendStiffness": 6.5e-6}
_BLENDER = {"surfaceStretchStiffness": 15.0, "surfaceShearStiffness": 5.0, "surfaceBendStiffness": 0.5}
# The settings of each, those of the stiffest fabric, and the vertex group between both.
_SETTINGS = {
    "surfaceStretchStiffness": (("tension_stiffness", "compression_stiffness"), "vertex_group_structural_stiffness"),
    "surfaceShearStiffness": (("shear_stiffness",), "vertex_group_shear_stiffness"),
    "surfaceBendStiffness": (("bending_stiffness",), "vertex_group_bending"),
}
# Distances that cloth keeps from bodies and from itself. [m]
_DISTANCE, _SELF_DISTANCE = 0.003, 0.002
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
    fabrics = _group_fabrics(sim)
    done = f"{held} vertices held, {sewn} edges hold pieces on the cloth"
    if is_new:
        # Settings of the user stay when the mesh is built again.
        settings.quality = 8
        _set_fabric(sim, settings, fabrics)
        scene = bpy.context.scene
        modifier.point_cache.frame_start, modifier.point_cache.frame_end = scene.frame_start, scene.frame_end
        done += _set_collisions(sim, modifier.collision_settings, scene.unit_settings.scale_length)
    return done


def _set_collisions(sim, settings, metres: float) -> str:
    """Distances from bodies, and of layers from each other. Cloth that nowhere lies on cloth is simulated without the latter, sooner."""
    settings.distance_min, settings.self_distance_min = _DISTANCE / metres, _SELF_DISTANCE / metres
    scale = abs(sim.matrix_world.to_3x3().determinant()) ** (1 / 3) or 1.0
    settings.use_self_collision = layers.are_near(sim, 1 / (metres * scale))
    return "; its layers collide with each other" if settings.use_self_collision else ""


def _group_fabrics(sim) -> dict[str, tuple[float, float]]:
    """Makes the vertex groups of several fabrics. Returns the least and the largest stiffness of each kind. [SI units]"""
    found = {}
    for name, attribute in STIFFNESS.items():
        values = sim.data.attributes.get(attribute)
        values = column(values.data, "value") if values else np.zeros(0)
        if len(values) and values.max() > values.min():
            found[name] = float(values.min()), float(values.max())
            # Settings forget a group that is removed, so it is emptied.
            group = sim.vertex_groups.get(_group_name(name)) or sim.vertex_groups.new(name=_group_name(name))
            group.remove(range(len(values)))
            fill_group(group, (values - values.min()) / np.ptp(values))
    return found


def _group_name(stiffness: str) -> str:
    """``Tailor Bend`` of ``surfaceBendStiffness``."""
    return OWN + stiffness.removeprefix("surface").removesuffix("Stiffness")


def _set_fabric(sim, settings, fabrics) -> None:
    figures = sim.get(FACTS, {})
    count = max(len(sim.data.vertices), 1)
    if "mass" in figures:
        settings.mass = _HEAVIER * figures["mass"] / count
    for name, (keys, group) in _SETTINGS.items():
        mean = figures.get(name, _COTTON[name])
        least, most = (_BLENDER[name] * value / _COTTON[name] for value in fabrics.get(name, (mean, mean)))
        for key in keys:
            setattr(settings, key, least)
            setattr(settings, f"{key}_max", most)
        setattr(settings, group, _group_name(name) if name in fabrics else "")


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
    """Sets the weights of an empty group, by one call for all vertices of a weight. A step moves no point by a tenth of a millimetre."""
    steps = np.round(weights * _WEIGHT_STEPS).astype(np.int32)
    order = np.argsort(steps, kind="stable")
    starts = np.flatnonzero(np.diff(steps[order], prepend=-1))
    for rows in np.split(order, starts[1:]):
        if step := int(steps[rows[0]]):
            group.add(rows.tolist(), step / _WEIGHT_STEPS, "REPLACE")
