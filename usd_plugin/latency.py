"""Time of one edit through a dynamic payload: from the attribute's new value until the recomposed points are read.

    PXR_PLUGINPATH_NAME=target/usd_plugin target/venv/bin/python usd_plugin/latency.py [GARMENT LENGTH]

LENGTH is an edge length that fits the garment. USDTAILOR_DEBUG=1 adds where the time goes.
"""

import json
import statistics
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

from pxr import Sdf, Usd

SAMPLES = 9


def garments(source, folder):
    """Copies that differ in a word, so that nothing of one is known when the next is opened."""
    flat = Usd.Stage.Open(source).Flatten(addSourceFileComment=False)
    for i in range(SAMPLES):
        flat.customLayerData = {"copy": i}
        flat.Export(str(Path(folder, f"copy{i}.usdc")))
        recipe = Path(folder, f"copy{i}.tailor")
        recipe.write_text(json.dumps({"source": f"copy{i}.usdc"}))
        yield recipe


def edit(prim, name, kind, value, product):
    """Sets an attribute and reads a product; milliseconds."""
    start = time.perf_counter()
    prim.GetAttribute(name).Set(value) if prim.HasAttribute(name) else prim.CreateAttribute(name, kind).Set(value)
    assert prim.GetChild(product).GetAttribute("points").Get()
    return (time.perf_counter() - start) * 1e3


def measure(recipe, length, times):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Garment")
    start = time.perf_counter()
    prim.GetPayloads().AddPayload(str(recipe))
    assert prim.GetChild("sim")
    times["open"].append((time.perf_counter() - start) * 1e3)
    for name, level in (("0", 0), ("2", 2), ("1, made before", 1), ("2, made before", 2), ("1, made before", 1)):
        times[f"render:level {name}"].append(edit(prim, "tailor:render:level", Sdf.ValueTypeNames.Int, level, "render"))
    for factor in (1.0, 1.01, 1.02):
        times["sim:maxEdgeLength"].append(
            edit(prim, "tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float, length * factor, "sim")
        )


def main():
    source, length = sys.argv[1:3] if len(sys.argv) > 2 else ("examples/coat.usda", 2.7)
    times = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        for recipe in garments(source, folder):
            measure(recipe, float(length), times)
    for name, all_times in times.items():
        middle, least, most = statistics.median(all_times), min(all_times), max(all_times)
        print(f"{name:<30} median {middle:6.1f} ms   least {least:6.1f} ms   most {most:6.1f} ms")


main()
