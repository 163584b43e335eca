"""What is wrong is reported once, with the file, the cause and the remedy; nothing crashes, hangs or is half there."""

import json

import pytest
import sources
from pxr import Sdf, Usd, UsdGeom
from tailor_file import errors, needs_plugin, recipe, script

pytestmark = needs_plugin


def no_uv(folder):
    sources.write(folder / "coat.usda", uv=False)


def two_meshes(folder):
    stage = Usd.Stage.CreateNew(str(folder / "coat.usda"))
    for name in ("/A/model", "/B/model"):
        sources.define(stage, name, sources.sheet())
    stage.Save()


def no_mesh(folder):
    stage = Usd.Stage.CreateNew(str(folder / "coat.usda"))
    stage.DefinePrim("/Coat", "Xform")
    stage.Save()


def broken_mesh(folder):
    sources.write(folder / "coat.usda", uv=False, finish=lambda mesh: mesh.GetFaceVertexIndicesAttr().Set([0, 1, 2, 99] * 12))


def a_prim_in_the_way(folder):
    sources.write(folder / "coat.usda", finish=lambda mesh: UsdGeom.Xform.Define(mesh.GetPrim().GetStage(), "/Coat/sim"))


def damaged(folder):
    (folder / "coat.usda").write_bytes(b"PXR-USDC" + bytes(range(200)))


def text_of(text):
    return lambda folder: (folder / "coat.tailor").write_text(text)


def itself(folder):
    stage = Usd.Stage.CreateNew(str(folder / "coat.usda"))
    stage.DefinePrim("/Coat").GetPayloads().AddPayload("./coat.tailor")
    stage.Save()


def itself_by_a_long_way(folder):
    """coat.tailor -> coat.usda -> one.usda -> other.tailor -> other.usda -> coat.tailor"""
    one = Sdf.Layer.CreateNew(str(folder / "one.usda"))
    (folder / "other.tailor").write_text('{"source": "other.usda"}')
    one.subLayerPaths.append("./other.tailor")
    other = Usd.Stage.CreateNew(str(folder / "other.usda"))
    variants = other.DefinePrim("/Coat").GetVariantSets().AddVariantSet("unused")
    for name in ("plain", "cyclic"):
        variants.AddVariant(name)
    variants.SetVariantSelection("cyclic")
    with variants.GetVariantEditContext():
        other.GetPrimAtPath("/Coat").GetReferences().AddReference("./coat.tailor")
    variants.SetVariantSelection("plain")
    root = Usd.Stage.CreateNew(str(folder / "coat.usda"))
    root.GetRootLayer().subLayerPaths.append("./one.usda")
    for layer in (one, other.GetRootLayer(), root.GetRootLayer()):
        layer.Save()


# Name: what is done to a good folder, arguments, what must be said.
FAULTS = {
    "no text": (text_of(""), "", ["line 1"]),
    "no JSON": (text_of("source = coat.usda"), "", ["line 1", "JSON"]),
    "binary": (lambda folder: (folder / "coat.tailor").write_bytes(b"\xff\xfe\x00"), "", ["text"]),
    "unknown key": (text_of('{"source": "coat.usda",\n "simm": {}}'), "", ["simm", "line 2"]),
    "unknown option": (text_of('{"source": "coat.usda", "sim": {"maxEdge": 1}}'), "", ["maxEdge", "line 1"]),
    "option of another type": (text_of('{"source": "coat.usda", "render": {"level": "two"}}'), "", ["two", "line 1"]),
    "option out of range": (text_of('{"source": "coat.usda", "render": {"level": 60}}'), "", ["render.level", "60"]),
    "no source": (text_of("{}"), "", ["source"]),
    "source of a recipe": (text_of('{"source": "other.tailor"}'), "", ["recipe too"]),
    "missing source": (lambda folder: (folder / "coat.usda").unlink(), "", ["coat.usda cannot be found"]),
    "damaged source": (damaged, "", ["coat.usda cannot be opened"]),
    "source of another kind": (text_of('{"source": "coat.tailor.txt"}'), "", ["coat.tailor.txt"]),
    "a folder as source": (text_of('{"source": "."}'), "", ["cannot be"]),
    "no mesh": (no_mesh, "", ["[no-mesh]", "holds no mesh"]),
    "two meshes": (two_meshes, "", ["holds 2 meshes", "/A/model", "/B/model"]),
    "missing prim": (text_of('{"source": "coat.usda", "prim": "/Coat/shirt"}'), "", ["/Coat/shirt"]),
    "broken mesh": (broken_mesh, "", ["/Coat/model.faceVertexIndices", "99"]),
    "taken name": (a_prim_in_the_way, "", ["[name-taken]", "/Coat/sim is taken"]),
    "missing density": (text_of('{"source": "coat.usda", "sim": {"density": "paint"}}'), "", ["paint"]),
    "missing constraint": (text_of('{"source": "coat.usda", "sim": {"constraints": ["hem"]}}'), "", ["hem"]),
    "time that is none": (None, "time=noon", ["time", "noon"]),
    "time without end": (None, "time=inf", ["time"]),
    "itself": (itself, "", ["uses the file itself", "coat.usda -> "]),
    "itself by a long way": (itself_by_a_long_way, "", ["uses the file itself", "one.usda", "other.tailor", "other.usda"]),
}


# Values of options that no recipe can have: attribute of the payload's prim, type, value, what must be said.
BAD_VALUES = {
    "missing UV set": ("sim:uvSet", "Token", "map1", ["map1"]),
    "value of another type": ("render:level", "Token", "two", ["render.level", "two"]),
    "a number out of range": ("sim:grading", "Float", 1.01, ["sim.grading"]),
    "far too fine": ("sim:maxEdgeLength", "Float", 0.0001, ["triangles", "sim.maxEdgeLength"]),
    "far too many samples": ("sim:transferSamples", "Int", 1000000000, ["sim.transferSamples", "give 0 to 1024"]),
    "far too many levels": ("render:level", "Int", 99, ["render.level"]),
    "a negative length": ("sim:maxEdgeLength", "Float", -1.0, ["sim.maxEdgeLength"]),
    "missing set": ("sim:constraints", "TokenArray", ["hem"], ["hem"]),
}


@pytest.fixture
def folder(tmp_path):
    sources.write(tmp_path / "coat.usda")
    recipe(tmp_path / "coat.tailor", "coat.usda")
    return tmp_path


@pytest.mark.parametrize("name", FAULTS)
def test_one_error_names_file_cause_and_remedy(folder, name):
    damage, arguments, said = FAULTS[name]
    if damage:
        for file in folder.glob("coat.usda") if damage in (no_uv, two_meshes, no_mesh, broken_mesh, a_prim_in_the_way, itself, itself_by_a_long_way) else ():
            file.unlink()
        damage(folder)
    path = str(folder / "coat.tailor")
    identifier = f"{path}:SDF_FORMAT_ARGS:{arguments}" if arguments else path
    found = errors(lambda: Sdf.Layer.FindOrOpen(identifier))
    assert len(found) == 1, found
    assert found[0].startswith(f"{path}: "), found
    assert all(words in found[0] for words in said), found
    assert "\n  hint: " in found[0] or "internal" not in found[0], found
    assert not [layer for layer in Sdf.Layer.GetLoadedLayers() if layer and layer.realPath == path], "nothing half-filled stays open"


@pytest.mark.parametrize("name", BAD_VALUES)
def test_a_bad_value_keeps_the_garment_and_is_told(folder, name):
    """The content stays as the recipe without the value makes it, and follows when the value is corrected."""
    attribute, kind, value, said = BAD_VALUES[name]
    printed = script(
        """
import os, sys, json
os.dup2(1, 2)
from pxr import Sdf, Usd, UsdGeom
path, attribute, kind, value = sys.argv[1:]
stage = Usd.Stage.CreateInMemory()
prim = stage.DefinePrim("/Coat")
assert prim.GetPayloads().AddPayload(path)

def points(name):
    return list(UsdGeom.Mesh(stage.GetPrimAtPath(f"/Coat/{name}")).GetPointsAttr().Get())

rounds = prim.CreateAttribute("tailor:sim:iterations", Sdf.ValueTypeNames.Int)
rounds.Set(2)
before = points("sim"), points("render")
assert before[0] and before[1]
bad = prim.CreateAttribute("tailor:" + attribute, getattr(Sdf.ValueTypeNames, kind))
bad.Set(json.loads(value))
assert (points("sim"), points("render")) == before, "changed by a value that no recipe can have"
rounds.Set(1)
assert points("render") == before[1], "gone with the next edit"
bad.Clear()
rounds.Set(2)
assert (points("sim"), points("render")) == before, "not mended"
""",
        folder / "coat.tailor",
        attribute,
        kind,
        json.dumps(value),
    )
    assert all(words in printed for words in said), printed
    assert "left out" in printed


def test_an_argument_that_is_no_option_is_told(folder):
    printed = script(
        """
import os, sys
os.dup2(1, 2)
from pxr import Sdf
layer = Sdf.Layer.FindOrOpen(sys.argv[1] + ":SDF_FORMAT_ARGS:sim.maxEdge=1")
assert layer.GetPrimAtPath("/Coat/sim")
""",
        folder / "coat.tailor",
    )
    assert "argument sim.maxEdge" in printed and "sim.maxEdgeLength" in printed, printed


def test_a_fault_that_is_mended_is_gone(folder):
    path = folder / "coat.tailor"
    good = path.read_text()
    path.write_text("{")
    assert errors(lambda: Sdf.Layer.FindOrOpen(str(path)))
    path.write_text(good)
    assert Sdf.Layer.FindOrOpen(str(path)).GetPrimAtPath("/Coat/sim")


def test_a_reload_that_fails_leaves_what_was_there(folder):
    layer = Sdf.Layer.FindOrOpen(str(folder / "coat.tailor"))
    before = layer.ExportToString()
    (folder / "coat.tailor").write_text('{"source": "coat.usda", "render": {"level": 60}}')
    assert any("60" in text for text in errors(lambda: layer.Reload(force=True)))
    assert layer.ExportToString() == before


def test_a_warning_is_told_once_for_a_file(folder):
    """Not with each edit; another file tells it again."""
    sources.add_primvar(UsdGeom.Mesh.Get(stage := Usd.Stage.Open(str(folder / "coat.usda")), "/Coat/model"), name="w", type_name="float", interpolation="vertex")
    UsdGeom.Mesh.Get(stage, "/Coat/model").CreateCreaseIndicesAttr([0, 1, 2])
    UsdGeom.Mesh.Get(stage, "/Coat/model").CreateCreaseLengthsAttr([3])
    UsdGeom.Mesh.Get(stage, "/Coat/model").CreateCreaseSharpnessesAttr([2.0])
    stage.GetPrimAtPath("/Coat/model").CreateAttribute("tailor:sim:stretch", Sdf.ValueTypeNames.Float).Set(2)
    stage.Save()
    (folder / "other.tailor").write_text((folder / "coat.tailor").read_text())
    said = script(
        """
import os, sys
os.dup2(1, 2)
from pxr import Sdf
held = [Sdf.Layer.FindOrOpen(f"{path}:SDF_FORMAT_ARGS:render.level={level}") for path in sys.argv[1:] for level in (0, 1, 2)]
assert all(held)
""",
        folder / "coat.tailor",
        folder / "other.tailor",
    )
    assert said.count("[not-carried] tailor:sim:stretch") == 2, said


def test_writing_is_refused_and_leaves_the_file_alone(folder):
    path = folder / "coat.tailor"
    before = path.read_text()
    layer = Sdf.Layer.FindOrOpen(str(path))
    stage = Usd.Stage.Open(layer)
    with pytest.raises(Exception, match="."):
        stage.DefinePrim("/New")
        assert layer.Save(force=True), "not saved"
    with pytest.raises(Exception, match="."):
        assert layer.Export(str(folder / "new.tailor")), "not exported"
    assert path.read_text() == before and not (folder / "new.tailor").exists()
    assert json.loads(before)["source"] == "coat.usda"
