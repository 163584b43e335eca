# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipe of a garment: custom properties of its object, which any USD export carries.

The properties themselves are what the panels show. A file that is opened without the extension keeps them.
"""

from dataclasses import dataclass
from functools import lru_cache

import bpy
import numpy as np
import usd_tailor
from mathutils import Matrix

from . import names
from .cage import column

OPERATORS = names.key("render", "operators")
GARMENT = names.key("sim", "maxEdgeLength")
"""The property that every garment has."""
SETS = {"seam": "edges", "fold": "faces"}
"""The option of each kind of operator that names its sets."""
_GROOVE = 0.2
"""Depth of a new seam, as a share of its width."""


@dataclass(frozen=True)
class Option:
    """A row of the one table of options, which ``usdtailor options`` prints."""

    group: str
    key: str
    unit: str
    meaning: str
    domain: dict
    default: object

    @property
    def label(self) -> str:
        """``Max edge length`` of ``maxEdgeLength``."""
        words = "".join(" " + letter.lower() if letter.isupper() else letter for letter in self.key).strip()
        return words[0].upper() + words[1:].replace(" uv", " UV")


@lru_cache(maxsize=1)
def table() -> dict[str, tuple[Option, ...]]:
    """The options of each group."""
    return {
        group["name"]: tuple(Option(group["name"], o["key"], o["unit"], o["meaning"], o["domain"], o["default"]) for o in group["options"])
        for group in usd_tailor.options()
    }


def option(group: str, key: str) -> Option:
    return next(o for o in table()[group] if o.key == key)


def option_of(key: str) -> Option | None:
    """The option of a custom property: ``tailor:seam:side:width`` is the width of seams."""
    group, *_, name = key.removeprefix(names.PREFIX).split(":")
    return next((of for of in table().get(group, ()) if of.key == name), None)


def told(key: str) -> str:
    """A custom property of an option in the words of the panel: *Width of seam side*."""
    group, *instance, _ = key.removeprefix(names.PREFIX).split(":")
    label = option_of(key).label
    return f"{label} of {group} {instance[0]}" if instance else label


def is_garment(ob) -> bool:
    return ob is not None and ob.type == "MESH" and GARMENT in ob


def properties(ob) -> dict[str, object]:
    """The options of an object, by their custom properties."""
    return {key: ob[key] for key in ob.keys() if key.startswith(names.PREFIX)}


def usd_value(ob, key: str, value):
    """A value as USD has it: an option that names a vertex group has the name of its primvar."""
    is_group = isinstance(value, str) and key.rpartition(":")[2] in ("density", "weights", "smoothWeights") and value in ob.vertex_groups
    return group_primvars([group.name for group in ob.vertex_groups])[value] if is_group else value


def group_primvars(groups) -> dict[str, str]:
    """The primvar of each vertex group. Names that differ in signs alone get a number."""
    return names.uniquely(groups, {names.UV_SET})


# The recipe of a new garment.


def set_up(ob) -> None:
    """Makes an object a garment: its lengths are chosen by its edges, and both sides of a mirrored one have the same triangles."""
    edge = mean_edge_length(ob)
    put(ob, option("sim", "maxEdgeLength"), _rounded(edge / 2))
    put(ob, option("sim", "minEdgeLength"), 0.0)
    put(ob, option("sim", "density"), "")
    if any(modifier.type == "MIRROR" for modifier in ob.modifiers):
        put(ob, option("sim", "symmetry"), True)
    put(ob, option("render", "level"), 2)
    put(ob, option("cloth", "fabric"), "cotton")
    put(ob, option("cloth", "pins"), "")
    ob[OPERATORS] = ""


def clear(ob) -> None:
    """Removes all options."""
    for key in properties(ob):
        del ob[key]


def mean_edge_length(ob) -> float:
    """Of the mesh without its modifiers. [mesh units]"""
    points, ends = column(ob.data.vertices, "co", 3), column(ob.data.edges, "vertices", 2, np.int32)
    return float(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1).mean()) if len(ends) else 0.0


def _automatic(ob, of: Option) -> float:
    """The length that 0 stands for. [mesh units]"""
    scale = abs(ob.matrix_world.to_3x3().determinant()) ** (1 / 3)
    meters = bpy.context.scene.unit_settings.scale_length * scale or 1.0
    return min(mean_edge_length(ob) * of.domain["automatic"], (of.domain["automaticMost"] or np.inf) / meters)


def _rounded(length: float) -> float:
    """Two digits, as a person would type them."""
    return float(f"{length:.2g}")


def put(ob, of: Option, value, *instance: str) -> None:
    """Authors an option, with its range and its meaning for the user interface."""
    key = names.key(of.group, *instance, of.key)
    ob[key] = value
    ui = ob.id_properties_ui(key)
    meaning = of.meaning.replace("`", "")
    if isinstance(value, bool) or isinstance(value, str):
        ui.update(description=meaning)
        return
    ui.update(description=f"{meaning} [{of.unit}]", **_range(ob, of))
    if isinstance(value, float):
        is_length = of.domain["type"] == "length"
        ui.update(subtype="DISTANCE" if is_length else "NONE", precision=4 if is_length else 3)


def _range(ob, of: Option) -> dict[str, float]:
    domain = of.domain
    if domain["type"] == "whole":
        # Blender keeps whole numbers in 32 bits.
        return {"min": 0, "max": min(domain["most"], 2**31 - 1), "soft_max": domain["usual"]}
    if domain["type"] == "length":
        edge = mean_edge_length(ob)
        low, high = (share * edge for share in domain["usual"])
        least = {"min": 0.0} if domain["usual"][0] >= 0 else {}
        return {"soft_min": low, "soft_max": high, **least}
    least = {} if domain["least"] is None else {"min": 0.0 if domain["orZero"] and domain["least"] > 0 else domain["least"]}
    most = {} if domain["most"] is None else {"max": domain["most"]}
    low, high = domain["usual"]
    return {**least, **most, "soft_min": low, "soft_max": high}


def apply_scale(ob) -> float | None:
    """Applies an even scale of the object to its mesh and to all lengths; None where it cannot be."""
    scale = ob.scale[0]
    if scale <= 0 or max(abs(other - scale) for other in ob.scale) > 1e-6 * scale or ob.data.users > 1 or ob.mode != "OBJECT":
        return None
    ob.data.transform(Matrix.Scale(scale, 4), shape_keys=True)
    ob.scale = (1, 1, 1)
    for key, value in properties(ob).items():
        of, parts = option_of(key), key.split(":")[1:]
        if of and of.domain["type"] == "length" and isinstance(value, float):
            put(ob, of, value * scale, *parts[1:-1])
    return scale


# Seams and folds.


def operators(ob) -> list[tuple[str, str]]:
    """Kind and name of the seams and folds, in the order in which they run."""
    found = {}
    for key in properties(ob):
        parts = key.split(":")
        if len(parts) == 4 and parts[1] in SETS:
            found.setdefault((parts[1], parts[2]))
    listed = [tuple(entry.strip().split(".", 1)) for entry in str(ob.get(OPERATORS, "")).split(",") if "." in entry]
    order = [entry for entry in listed if entry in found]
    return order + sorted(entry for entry in found if entry not in order)


def _list(ob, order: list[tuple[str, str]]) -> None:
    ob[OPERATORS] = ", ".join(f"{kind}.{name}" for kind, name in order)


def add_operator(ob, kind: str, name: str, sets: str) -> str:
    """Adds a seam or fold with all its options, and returns its name."""
    order = operators(ob)
    name = names.unique(names.usd_name(name), {other for _, other in order})
    for of in table()[kind]:
        value = of.default
        if of.key == SETS[kind]:
            value = sets
        elif of.domain["type"] == "length":
            value = _rounded(_automatic(ob, of))
        put(ob, of, value, name)
    if kind == "seam":
        # A seam without a depth is not seen.
        put(ob, option("seam", "normalOffset"), -_rounded(_GROOVE * _automatic(ob, option("seam", "width"))), name)
    _list(ob, [*order, (kind, name)])
    return name


def remove_operator(ob, kind: str, name: str) -> None:
    order = operators(ob)
    for key in _keys(ob, kind, name):
        del ob[key]
    _list(ob, [entry for entry in order if entry != (kind, name)])


def rename_operator(ob, kind: str, name: str, new: str) -> str:
    """Renames a seam or fold, and returns the name that it has then."""
    order = operators(ob)
    new = names.unique(names.usd_name(new), {other for _, other in order if other != name})
    if new == name:
        return name
    for key in _keys(ob, kind, name):
        value, row = ob[key], option_of(key)
        del ob[key]
        if row:
            put(ob, row, value, new)
    _list(ob, [(kind, new) if entry == (kind, name) else entry for entry in order])
    return new


def move_operator(ob, kind: str, name: str, by: int) -> None:
    order = operators(ob)
    at = order.index((kind, name))
    order.insert(max(0, min(len(order) - 1, at + by)), order.pop(at))
    _list(ob, order)


def _keys(ob, kind: str, name: str) -> list[str]:
    start = names.key(kind, name, "")
    return [key for key in properties(ob) if key.startswith(start)]
