# SPDX-License-Identifier: GPL-3.0-or-later
"""The elements of an expression, selected in Edit Mode."""

import tempfile
from pathlib import Path

import usd_tailor

from . import messages, names, recipe, stage
from .cage import read_cage


def select_set(operator, garment, kind: str, name: str) -> tuple[int, int] | None:
    """Selects the set of a seam or fold, and returns the number of its elements; None where it has none, which is reported."""
    expression = str(garment[names.key(kind, name, recipe.SETS[kind])])
    cage = read_cage(garment)
    with tempfile.TemporaryDirectory(prefix="tailor-") as folder:
        path = str(Path(folder, "garment.usdc"))
        stage.write_stage(garment, cage).Export(path)
        try:
            found = usd_tailor.sets(path, {"chosen": expression})["chosen"]
        except usd_tailor.TailorError as error:
            operator.report({"ERROR"}, str(error).splitlines()[0])
            return None
    return messages.select(garment, {"elements": {f"{found.element_type}s": list(found.indices)}})
