"""Runs every part of the plugin on a garment of two faces.

`cargo xtask plugin` runs it before it installs a plugin. It is small enough for valgrind (see README.md)."""

import tempfile
from pathlib import Path

from pxr import Sdf, Tf, Usd

QUADS = """#usda 1.0
(
    defaultPrim = "Asset"
)
def Xform "Asset"
{
    def Mesh "model"
    {
        int[] faceVertexCounts = [4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
    }
}
"""


# How OpenUSD 24.8 says `broken.usda:2`.
OLD_PLACE = "on line 2 in file"


def refused(work, *causes):
    """True if `work` raises exactly one error whose commentary contains one of `causes`."""
    try:
        work()
    except Tf.ErrorException as exception:
        [error] = exception.args
        return any(cause in error.commentary for cause in causes)
    return False


with tempfile.TemporaryDirectory() as folder:
    recipe, broken, cycle = (Path(folder, name) for name in ("quads.tailor", "broken.tailor", "cycle.tailor"))
    Path(folder, "quads.usda").write_text(QUADS)
    recipe.write_text('{"source": "quads.usda"}')
    broken.write_text('{"source": "broken.usda"}')
    Path(folder, "broken.usda").write_text("#usda 1.0\ndef Mesh { oops }\n")
    cycle.write_text('{"source": "cycle.usda"}')
    Path(folder, "cycle.usda").write_text("#usda 1.0\n(\nsubLayers = [@cycle.tailor@]\n)\n")

    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/A")
    prim.GetPayloads().AddPayload(str(recipe))
    prim.CreateAttribute("tailor:sim:constraints", Sdf.ValueTypeNames.TokenArray).Set([])
    length = prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float)
    counts = []
    for value in (0.5, 0.3):
        length.Set(value)
        counts.append(len(stage.GetPrimAtPath("/A/sim").GetAttribute("points").Get()))
    assert counts[0] < counts[1], counts

    layer = next(layer for layer in stage.GetUsedLayers() if ".tailor" in layer.identifier)
    assert layer.Reload(force=True)
    assert layer.ExportToString()
    assert Sdf.Layer.OpenAsAnonymous(str(recipe), metadataOnly=True).defaultPrim == "Asset"
    assert refused(lambda: Sdf.Layer.FindOrOpen(str(recipe), {"time": "noon"}), "not a number")
    assert refused(lambda: Sdf.Layer.FindOrOpen(str(broken)), "broken.usda:2", OLD_PLACE)
    assert refused(lambda: Sdf.Layer.FindOrOpen(str(cycle)), "uses the file itself")
