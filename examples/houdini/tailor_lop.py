"""A Python Script LOP that tailors the garment of its input: simulation mesh and render mesh come into the layer that it edits.

Put this file on Python's path, and this line into the node:

    import tailor_lop; tailor_lop.cook(hou.pwd())

Spare parameters of the node, all of them text: `garment`, the path of the mesh where there are several, and `options`, with
an option of the recipe on each line, such as seam.side.edges=uvSeams. What usd-tailor refuses is the node's error.
"""

import usd_tailor
from pxr import UsdUtils


def text(node, name):
    """The value of a spare parameter; nothing where the node has none."""
    parameter = node.parm(name)
    return parameter.evalAsString().strip() if parameter else ""


def options(node):
    """The options by their keys."""
    lines = (line.strip() for line in text(node, "options").splitlines())
    pairs = (line.partition("=") for line in lines if line and not line.startswith("#"))
    return {key.strip(): value.strip() for key, _, value in pairs}


def cook(node):
    """Builds from the input's stage, and adds what was made to the active layer, whose own opinions stay."""
    source = node.inputs()[0].stage()
    built = usd_tailor.build(source, prim=text(node, "garment") or None, options=options(node))
    UsdUtils.StitchLayers(node.editableStage().GetEditTarget().GetLayer(), built.layer)
    return built
