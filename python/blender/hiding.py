# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets of a garment that hide a function of their name: a bare ``borders`` is the attribute ``borders`` where there is one."""

import re

from . import names, recipe
from .cage import Cage

# Functions of expressions that may stand without parentheses.
_FUNCTIONS = {"borders", "uvSeams", "creases", "featureLines", "edges", "faces", "uvShells", "points"}
# Texts in quotes, and arguments that are names of other things.
_NAMES = re.compile(r'"(?:\\.|[^"\\])*"|\b(?:material|value|weight|regions)\([^)]*\)')
_WORDS = re.compile(r"(?<![\w.])([A-Za-z]\w*)(?!\w|\s*\()")


def notes(garment, cage: Cage) -> list[str]:
    """What the options of a garment name, and how to name the other."""
    sets = {names.usd_name(slot.material.name): "material" for slot in garment.material_slots if slot.material}
    for kind, found in (("edge", cage.edge_sets), ("face", cage.face_sets), ("point", cage.point_sets)):
        sets |= dict.fromkeys(found, f"{kind} attribute")
    groups = dict.fromkeys(recipe.group_primvars(cage.groups).values(), "vertex group")
    found = []
    for key, value in recipe.properties(garment).items():
        of = recipe.option_of(key)
        if of is None or of.domain["type"] not in ("sets", "weights") or not isinstance(value, str):
            continue
        known = sets | groups if of.domain["type"] == "weights" or "point" in of.domain.get("of", ()) else sets
        for word in dict.fromkeys(_WORDS.findall(_NAMES.sub("", value))):
            if word in _FUNCTIONS and word in known:
                place = recipe.told(key)
                found.append(f"{place}: {word} is the {known[word]} of that name, and hides the function. For the function, write {word}()")
    return found
