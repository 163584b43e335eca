# SPDX-License-Identifier: GPL-3.0-or-later
"""The elements of an expression, selected in Edit Mode."""

import tempfile
from pathlib import Path

import usd_tailor

from . import messages, names, recipe, stage
from .cage import read_cage
from .job import Refused


def select_set(garment, kind: str, name: str) -> tuple[int, int]:
    """Selects the set of a seam or fold. Returns how many elements are selected, and how many were not found."""
    expression = str(garment[names.key(kind, name, recipe.SETS[kind])])
    cage = read_cage(garment)
    with tempfile.TemporaryDirectory(prefix="tailor-") as folder:
        path = str(Path(folder, "garment.usdc"))
        stage.write_stage(garment, cage).Export(path)
        try:
            found = usd_tailor.sets(path, {"chosen": expression})["chosen"]
        except usd_tailor.TailorError as error:
            raise Refused(str(error).splitlines()[0]) from None
    return messages.select(garment, {"elements": {f"{found.element_type}s": list(found.indices)}})
