"""`.tailor` files in tests: how they are written, how they are used, and what is compared."""

import json
import os
import subprocess
import sys

import pytest
from conftest import PLUGIN, ROOT
from pxr import Gf, Sdf, Tf, Usd, UsdGeom

needs_plugin = pytest.mark.skipif(PLUGIN is None, reason="USDTAILOR_PLUGIN names no plugin: it is NOT tested (cargo xtask test python names it)")

# Small and quick.
QUICK = {"sim": {"iterations": 1}, "render": {"level": 1}}


def recipe(path, source, **options):
    """Writes a `.tailor` file; `source` is as the file shall name it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"source": str(source), **{**QUICK, **options}}))
    return path


def errors(work):
    """What OpenUSD's errors say that `work` raises."""
    with pytest.raises(Tf.ErrorException) as raised:
        work()
    return [error.commentary for error in raised.value.args]


def holder(stage, asset, path="/Shot/Coat", arc="payload", target=None):
    """A prim with a payload (or reference) of `asset`."""
    prim = stage.DefinePrim(path)
    arcs = prim.GetPayloads() if arc == "payload" else prim.GetReferences()
    add = arcs.AddPayload if arc == "payload" else arcs.AddReference
    assert add(str(asset), target) if target else add(str(asset))
    return prim


def mesh(prim, name="render"):
    return UsdGeom.Mesh(prim.GetStage().GetPrimAtPath(prim.GetPath().AppendChild(name)))


def faces(prim, name="render"):
    return len(mesh(prim, name).GetFaceVertexCountsAttr().Get() or [])


def contents(stage):
    """Everything that a composed stage says, by path: a dictionary of comparable values."""
    found = {}
    for prim in stage.TraverseAll():
        found[prim.GetPath()] = {"type": prim.GetTypeName(), "schemas": prim.GetAppliedSchemas(), **metadata(prim)}
        for attribute in prim.GetAttributes():
            if attribute.IsAuthored():
                values = {"default": attribute.Get(), "samples": attribute.GetTimeSamples(), "type": attribute.GetTypeName()}
                found[attribute.GetPath()] = {**values, **metadata(attribute)}
        for relationship in prim.GetRelationships():
            if relationship.IsAuthored():
                found[relationship.GetPath()] = {"targets": relationship.GetTargets(), **metadata(relationship)}
    root = stage.GetPseudoRoot()
    found[root.GetPath()] = without_record(metadata(root))
    return found


def without_record(fields):
    """Metadata of a stage without the record of what the command made the file of; a layer in memory has none."""
    data = {key: value for key, value in fields.pop("customLayerData", {}).items() if key != "tailor"}
    return {**fields, "customLayerData": data} if data else fields


def metadata(thing):
    return {key: value for key, value in thing.GetAllAuthoredMetadata().items() if key not in ("references", "payload", "subLayers")}


def differences(one, other):
    """The paths and keys at which two stages' contents differ."""
    faults = [f"{path} is only in one" for path in one.keys() ^ other.keys()]
    for path in one.keys() & other.keys():
        keys = one[path].keys() | other[path].keys()
        faults += [f"{path}: {key}" for key in keys if not same(one[path].get(key), other[path].get(key))]
    return sorted(faults)


def same(one, other):
    if isinstance(one, Sdf.AssetPath) and isinstance(other, Sdf.AssetPath):
        return (one.resolvedPath or one.path) == (other.resolvedPath or other.path)
    if isinstance(one, Gf.Matrix4d):
        return one == other
    return type(one) is type(other) and one == other


def script(text, *args, **environment):
    """Runs a script in an interpreter of its own, with the plugin; returns what it prints."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tests" / "usd"), **environment}
    command = [sys.executable, "-c", text, *map(str, args)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout
