"""Dynamic payloads and the options of seams and folds, whose attributes hold the name of an instance."""

import numpy as np
import pytest
import sources
from pxr import Sdf, Usd, UsdGeom
from tailor_file import holder, mesh, needs_plugin, recipe
from test_plugin_composition import Resyncs, later, saved, setting

pytestmark = needs_plugin

FOLD = [2, 7, 7, 12, 12, 17]
OFFSET = "tailor:seam:{}:normalOffset"
FLOAT, TOKENS = Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.TokenArray


def sew(model):
    """A seam and a fold on the garment itself, as in a layer that an artist authors."""
    prim = model.GetPrim()
    prim.AddAppliedSchema("TailorSeamAPI:placket")
    prim.AddAppliedSchema("TailorFoldAPI:hem")
    for name, subset in (("seam:placket:edges", "fold"), ("fold:hem:faces", "low")):
        prim.CreateRelationship(f"tailor:{name}", False).AddTarget(prim.GetPath().AppendChild(subset))
    for name, value in (("seam:placket:width", 0.4), ("seam:placket:normalOffset", -0.05), ("fold:hem:thickness", 0.05)):
        prim.CreateAttribute(f"tailor:{name}", FLOAT, False).Set(value)


@pytest.fixture
def coat(tmp_path):
    """A `.tailor` file that names the seam and the fold of its source."""
    subsets = [{"name": "fold", "indices": FOLD, "element": "edge", "family": "edges"}, {"name": "low", "indices": [0, 1, 2, 3]}]
    sources.write(tmp_path / "coat.usda", subsets=subsets, finish=sew)
    return recipe(tmp_path / "coat.tailor", "coat.usda", render={"level": 0}, seam={"placket": {}}, fold={"hem": {}})


@pytest.fixture
def nameless(coat):
    """One that names neither."""
    return recipe(coat.with_name("nameless.tailor"), "coat.usda", render={"level": 0})


@pytest.fixture
def stage(tmp_path):
    return Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))


def points(prim):
    return np.array(mesh(prim).GetPointsAttr().Get())


def arguments(stage):
    [layer] = [layer for layer in stage.GetUsedLayers() if layer.fileExtension == "tailor"]
    return layer.GetFileFormatArguments()


def test_an_edit_of_an_offset_moves_the_points(stage, coat):
    prim = holder(stage, coat)
    groove = points(prim)
    setting(prim, OFFSET.format("placket"), 0.05, FLOAT)
    ridge = points(prim)
    assert ridge.shape == groove.shape
    assert np.abs(ridge - groove).max() > 0.05
    prim.GetAttribute(OFFSET.format("placket")).Set(-0.05)
    assert (points(prim) == groove).all()


def test_options_that_change_the_faces_are_read_too(stage, coat):
    prim = holder(stage, coat)
    straight = len(points(prim))
    setting(prim, "tailor:render:level", 3, Sdf.ValueTypeNames.Int)
    assert len(points(prim)) > straight
    setting(prim, "tailor:fold:hem:thickness", 0.1, FLOAT)
    assert arguments(stage) == {"render.level": "3", "fold.hem.thickness": "0.1"}


def test_every_attribute_of_the_schemas_is_read(stage, coat):
    prim = holder(stage, coat)
    schemas = ("TailorSeamAPI:placket", "TailorFoldAPI:hem")
    definition = Usd.SchemaRegistry().BuildComposedPrimDefinition("", list(schemas))
    attributes = [definition.GetAttributeDefinition(name) for name in definition.GetPropertyNames()]
    expected = {}
    for attribute in filter(None, attributes):
        setting(prim, attribute.GetName(), attribute.GetFallbackValue(), attribute.GetTypeName())
        expected[attribute.GetName().removeprefix("tailor:").replace(":", ".")] = attribute.GetFallbackValue()
    for name, sets in (("seam:placket:edges", ["fold"]), ("fold:hem:faces", ["low"])):
        setting(prim, f"tailor:{name}", sets, TOKENS)
        expected[name.replace(":", ".")] = sets
    assert arguments(stage).keys() == expected.keys() and len(expected) == 20
    assert arguments(stage)["seam.placket.edges"] == "fold"
    assert len(points(prim)) > 0


def test_instances_that_nothing_names_are_not_read(stage, nameless):
    prim = holder(stage, nameless)
    before = points(prim)
    setting(prim, OFFSET.format("placket"), 0.05, FLOAT)
    assert (points(prim) == before).all()


@pytest.mark.parametrize("first", ["schema", "value"])
def test_an_applied_schema_names_its_instance(stage, nameless, first):
    prim = holder(stage, nameless)
    before = points(prim)
    steps = [lambda: prim.AddAppliedSchema("TailorSeamAPI:placket"), lambda: setting(prim, OFFSET.format("placket"), 0.05, FLOAT)]
    for step in steps if first == "schema" else steps[::-1]:
        step()
    after = points(prim)
    assert np.abs(after - before).max() > 0.05
    prim.RemoveAppliedSchema("TailorSeamAPI:placket")
    prim.RemoveProperty(OFFSET.format("placket"))
    assert (points(prim) == before).all()


def test_schemas_of_all_layers_count(stage, nameless, tmp_path):
    """One seam is named where the payload is, the other where that is referenced."""
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    inner = holder(asset, "./nameless.tailor", path="/Asset")
    inner.AddAppliedSchema("TailorSeamAPI:placket")
    asset.SetDefaultPrim(inner)
    asset.Save()
    outer = holder(stage, "./asset.usda", path="/Shot/One", arc="reference")
    outer.AddAppliedSchema("TailorFoldAPI:hem")
    setting(outer, OFFSET.format("placket"), 0.05, FLOAT)
    setting(outer, "tailor:fold:hem:thickness", 0.1, FLOAT)
    assert arguments(stage) == {"seam.placket.normalOffset": "0.05", "fold.hem.thickness": "0.1"}


def test_a_seam_of_the_holder_alone(stage, nameless):
    prim = holder(stage, nameless)
    setting(prim, "tailor:render:level", 2, Sdf.ValueTypeNames.Int)
    before = len(points(prim))
    prim.AddAppliedSchema("TailorSeamAPI:cross")
    with Sdf.ChangeBlock():
        layer, path = stage.GetRootLayer(), prim.GetPath()
        for name, kind, value in (("edges", TOKENS, ["across"]), ("width", FLOAT, 0.3), ("normalOffset", FLOAT, -0.03)):
            attribute = path.AppendProperty(f"tailor:seam:cross:{name}")
            assert Sdf.JustCreatePrimAttributeInLayer(layer, attribute, kind)
            layer.GetAttributeAtPath(attribute).default = value
    assert len(points(prim)) == before, "the source has no such edge set, and the other options stay"
    source = Usd.Stage.Open(str(nameless.with_name("coat.usda")))
    sources.add_subset(UsdGeom.Mesh.Get(source, "/Coat/model"), name="across", indices=[5, 6, 6, 7, 7, 8, 8, 9], element="edge", family="edges")
    source.Save()
    stage.Unload(prim.GetPath())
    stage.Load(prim.GetPath())
    assert len(points(prim)) > before


def test_arguments_of_the_asset_path_name_instances(stage, nameless):
    prim = holder(stage, f"{nameless}:SDF_FORMAT_ARGS:seam.placket.width=0.3&render.level=0")
    before = points(prim)
    setting(prim, OFFSET.format("placket"), 0.05, FLOAT)
    assert np.abs(points(prim) - before).max() > 0.05
    assert arguments(stage)["seam.placket.width"] == "0.3"


def test_names_that_the_file_gains_count_when_the_payload_is_loaded_again(stage, nameless):
    prim = holder(stage, nameless)
    setting(prim, OFFSET.format("placket"), 0.05, FLOAT)
    before = points(saved(prim))
    recipe(nameless, "coat.usda", render={"level": 0}, seam={"placket": {}})
    later(nameless)
    stage.Reload()
    stage.Unload(prim.GetPath())
    stage.Load(prim.GetPath())
    assert np.abs(points(prim) - before).max() > 0.05


def test_unrelated_edits_do_not_compose_anew(stage, coat):
    prim = holder(stage, coat)
    setting(prim, OFFSET.format("placket"), 0.05, FLOAT)
    with Resyncs(stage) as paths:
        setting(prim, OFFSET.format("other"), 0.05, FLOAT)
        prim.GetAttribute(OFFSET.format("other")).Set(0.1)
        prim.GetAttribute(OFFSET.format("placket")).Set(0.05)
    assert prim.GetPath() not in paths
    with Resyncs(stage) as paths:
        prim.GetAttribute(OFFSET.format("placket")).Set(0.06)
    assert prim.GetPath() in paths
