"""Measures the latency of edits through a dynamic payload: from setting an attribute until the new points are read.

    PXR_PLUGINPATH_NAME=$PWD/target/usd_plugin target/venv/bin/python usd_plugin/latency.py [GARMENT LENGTH]

LENGTH is a target edge length that suits the garment. One seam and one fold of the model are edited too, if
present. The default garment is examples/sewn/coat.usda. USDTAILOR_DEBUG=1 prints the time of each stage.
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
# Successive values of a seam's or fold's attribute, as shares of its authored value.
SHARES = (0.9, 0.8, 0.7)
EDITED = {"TailorSeamAPI": ("seam", ("normalOffset", "width")), "TailorFoldAPI": ("fold", ("thickness",))}


def operators(stage):
    """The edited attributes of the model's first seam and first fold: name and authored value."""
    found, left = {}, dict(EDITED)
    for prim in stage.Traverse():
        for schema, _, name in (applied.partition(":") for applied in prim.GetAppliedSchemas()):
            space, fields = left.pop(schema, ("", ()))
            for field in fields:
                found[f"{space}:{name}:{field}"] = prim.GetAttribute(f"tailor:{space}:{name}:{field}").Get()
    return found


def garments(flat, names, folder):
    """Yields recipes of copies that differ in metadata, so that each is opened uncached.

    `names` are the attributes of seams and folds that the payload must follow."""
    instances = defaultdict(dict)
    for name in names:
        space, instance, _ = name.split(":")
        instances[space][instance] = {}
    for i in range(SAMPLES):
        flat.customLayerData = {"copy": i}
        flat.Export(str(Path(folder, f"copy{i}.usdc")))
        recipe = Path(folder, f"copy{i}.tailor")
        recipe.write_text(json.dumps({"source": f"copy{i}.usdc", **instances}))
        yield recipe


def edit(prim, name, kind, value, product):
    """The time to set an attribute and read a product. [milliseconds]"""
    start = time.perf_counter()
    prim.GetAttribute(name).Set(value) if prim.HasAttribute(name) else prim.CreateAttribute(name, kind).Set(value)
    assert prim.GetChild(product).GetAttribute("points").Get()
    return (time.perf_counter() - start) * 1e3


def measure(recipe, length, values, times):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Garment")
    start = time.perf_counter()
    prim.GetPayloads().AddPayload(str(recipe))
    assert prim.GetChild("sim")
    times["open"].append((time.perf_counter() - start) * 1e3)
    for name, level in (("0", 0), ("2", 2), ("1, cached", 1), ("2, cached", 2), ("1, cached", 1)):
        times[f"render:level {name}"].append(edit(prim, "tailor:render:level", Sdf.ValueTypeNames.Int, level, "render"))
    for factor in (1.0, 1.01, 1.02):
        times["sim:maxEdgeLength"].append(
            edit(prim, "tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float, length * factor, "sim")
        )
    for name, value in values.items():
        for share in SHARES:
            times[name].append(edit(prim, f"tailor:{name}", Sdf.ValueTypeNames.Float, share * value, "render"))


def main():
    source, length = sys.argv[1:3] if len(sys.argv) > 2 else ("examples/sewn/coat.usda", 2.7)
    stage = Usd.Stage.Open(source)
    values, flat = operators(stage), stage.Flatten(addSourceFileComment=False)
    times = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        for recipe in garments(flat, values, folder):
            measure(recipe, float(length), values, times)
    for name, all_times in times.items():
        middle, least, most = statistics.median(all_times), min(all_times), max(all_times)
        print(f"{name:<30} median {middle:6.1f} ms   least {least:6.1f} ms   most {most:6.1f} ms")


main()
