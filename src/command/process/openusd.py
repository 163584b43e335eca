"""Writes a layer, or the stage of a file flattened, as a crate: `openusd.py SOURCE OUT layer|stage`.

Prints the version, and the files of the stage. Stages with faults or variants are left to the program, which tells them.
"""

import sys

# Modules in the current folder are not imported, as this is the text of an option.
sys.path = [path for path in sys.path if path]

try:
    import resource

    resource.setrlimit(resource.RLIMIT_DATA, (8 << 30, 8 << 30))
except (ImportError, ValueError, OSError):
    pass

from pxr import Sdf, Usd  # noqa: E402


def flattened(stage, files):
    """The layer of a whole stage, whose files are added; None of one with faults or variants."""
    prims = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    sets = (prim.GetVariantSets() for prim in prims)
    has_variants = any(len(of.GetVariantSet(name).GetVariantNames()) > 1 for of in sets for name in of.GetNames())
    if has_variants or stage.GetCompositionErrors():
        return None
    files += [layer.realPath.split("[")[0] for layer in stage.GetUsedLayers()]
    return stage.Flatten()


source, out, kind = sys.argv[1:]
files = []
layer = flattened(Usd.Stage.Open(source), files) if kind == "stage" else Sdf.Layer.FindOrOpen(source)
written = layer and layer.Export(out)
print("OpenUSD", ".".join(str(part) for part in Usd.GetVersion()[1:]))
for file in filter(None, files):
    print(file)
sys.exit(not written)
