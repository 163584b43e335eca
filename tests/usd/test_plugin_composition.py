"""Dynamic payloads: attributes of the prim that holds one decide what it brings, in every layer, and nothing else does."""

import os
import time

import pytest
import sources
from conftest import ALL
from pxr import Ar, Sdf, Tf, Usd, UsdGeom, Vt
from tailor_file import errors, faces, holder, mesh, needs_plugin, recipe, script

pytestmark = needs_plugin

LEVEL, LENGTH = "tailor:render:level", "tailor:sim:maxEdgeLength"
CAGE = 12


def faces_at(level):
    return CAGE * 4**level


@pytest.fixture
def coat(tmp_path):
    sources.write(tmp_path / "coat.usda", seam_column=2)
    return recipe(tmp_path / "coat.tailor", "coat.usda")


@pytest.fixture
def stage(tmp_path):
    return Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))


def setting(prim, name, value, kind=Sdf.ValueTypeNames.Int):
    prim.CreateAttribute(name, kind, custom=False).Set(value)


class Resyncs:
    """The prims that were composed anew while it was listening."""

    def __init__(self, stage):
        self.paths = []
        self.key = Tf.Notice.Register(Usd.Notice.ObjectsChanged, lambda notice, _: self.paths.extend(notice.GetResyncedPaths()), stage)

    def __enter__(self):
        return self.paths

    def __exit__(self, *_):
        self.key.Revoke()


def test_an_edit_of_the_holder_makes_the_content_anew(stage, coat):
    prim = holder(stage, coat)
    for level in (0, 2, 1):
        setting(prim, LEVEL, level)
        assert faces(prim) == faces_at(level)
    prim.RemoveProperty(LEVEL)
    assert faces(prim) == faces_at(1), "the file's own level"


def test_a_blocked_attribute_says_nothing(stage, coat, capfd):
    prim = holder(stage, coat)
    setting(prim, LEVEL, 2)
    capfd.readouterr()
    prim.GetAttribute(LEVEL).Block()
    assert faces(prim) == faces_at(1), "the file's own level"
    assert capfd.readouterr().err == ""


def test_edits_of_both_products_are_seen_at_once(stage, coat):
    prim = holder(stage, coat)
    coarse = faces(prim, "sim")
    with Sdf.ChangeBlock():
        for name, kind, value in ((LENGTH, Sdf.ValueTypeNames.Float, 0.2), (LEVEL, Sdf.ValueTypeNames.Int, 2)):
            spec = Sdf.JustCreatePrimAttributeInLayer(stage.GetRootLayer(), prim.GetPath().AppendProperty(name), kind)
            stage.GetRootLayer().GetAttributeAtPath(prim.GetPath().AppendProperty(name)).default = value
            assert spec
    assert faces(prim, "sim") > 4 * coarse
    assert faces(prim, "render") == faces_at(2)


@pytest.mark.parametrize("kind, value", [("int", 2), ("uint", 2), ("int64", 2), ("token", "2"), ("string", "2")])
def test_the_type_of_an_attribute_need_not_be_that_of_the_schema(stage, coat, kind, value):
    prim = holder(stage, coat)
    setting(prim, LEVEL, value, Sdf.ValueTypeNames.Find(kind))
    assert faces(prim) == faces_at(2)


@pytest.mark.parametrize("kind", ["float", "double", "int"])
def test_lengths_are_numbers_of_any_type(stage, coat, kind):
    prim = holder(stage, coat)
    setting(prim, LENGTH, 2, Sdf.ValueTypeNames.Find(kind))
    coarse = faces(prim, "sim")
    setting(prim, LENGTH, 1, Sdf.ValueTypeNames.Find(kind))
    assert faces(prim, "sim") > coarse


def test_every_attribute_of_the_schemas_is_read(stage, coat):
    """Each option is an argument of the layer that the payload brings, with its value."""
    prim = holder(stage, coat)
    values = {}
    for schema in ("TailorSimAPI", "TailorRenderAPI"):
        definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema)
        for name in definition.GetPropertyNames():
            attribute = definition.GetAttributeDefinition(name)
            if attribute:
                setting(prim, name, attribute.GetFallbackValue(), attribute.GetTypeName())
                values[name.removeprefix("tailor:").replace(":", ".")] = attribute.GetFallbackValue()
    [layer] = [layer for layer in stage.GetUsedLayers() if layer.fileExtension == "tailor"]
    arguments = layer.GetFileFormatArguments()
    assert arguments.keys() == values.keys() and len(values) > 10
    assert arguments["sim.constrainUvSeams"] == "true" and arguments["sim.uvSet"] == "st" and arguments["sim.baselineLevel"] == "2"
    assert faces(prim) == faces_at(2)


def test_a_relationship_of_the_holder_is_not_read_and_an_argument_is(stage, coat):
    """OpenUSD composes attributes for payloads, no relationships; the list can be an argument."""
    source = Usd.Stage.Open(str(coat.with_name("coat.usda")))
    sources.add_subset(UsdGeom.Mesh.Get(source, "/Coat/model"), name="hem", indices=[1, 6, 6, 11, 11, 16], element="edge")
    source.Save()
    prim = holder(stage, f"{coat}:SDF_FORMAT_ARGS:sim.constraints=hem")
    subsets = UsdGeom.Subset.GetAllGeomSubsets(mesh(prim, "sim"))
    assert "hem" in [subset.GetPrim().GetName() for subset in subsets]


def test_the_holder_is_stronger_than_the_arguments_of_the_asset_path(stage, coat):
    prim = holder(stage, f"{coat}:SDF_FORMAT_ARGS:render.level=2")
    assert faces(prim) == faces_at(2)
    setting(prim, LEVEL, 0)
    assert faces(prim) == faces_at(0)


def test_unrelated_edits_do_not_compose_anew(stage, coat):
    prim = holder(stage, coat)
    setting(prim, LEVEL, 1)
    with Resyncs(stage) as paths:
        prim.CreateAttribute("userProperties:note", Sdf.ValueTypeNames.String, custom=True).Set("new")
        prim.GetAttribute("userProperties:note").Set("other")
        prim.GetAttribute(LEVEL).SetMetadata("documentation", "words")
        prim.GetAttribute(LEVEL).Set(1)
        UsdGeom.Xformable(prim).AddTranslateOp().Set((1, 2, 3))
    assert prim.GetPath() not in paths
    with Resyncs(stage) as paths:
        prim.GetAttribute(LEVEL).Set(2)
    assert prim.GetPath() in paths


def test_a_session_layer_overrides(stage, coat):
    prim = holder(stage, coat)
    setting(prim, LEVEL, 0)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        setting(prim, LEVEL, 2)
    assert faces(prim) == faces_at(2)
    stage.GetSessionLayer().Clear()
    assert faces(prim) == faces_at(0)


def test_a_referencing_layer_overrides(stage, coat, tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    inner = holder(asset, "./coat.tailor", path="/Asset")
    setting(inner, LEVEL, 0)
    asset.SetDefaultPrim(inner)
    asset.Save()
    outer = holder(stage, "./asset.usda", path="/Shot/One", arc="reference")
    assert faces(outer) == faces_at(0)
    setting(outer, LEVEL, 2)
    assert faces(outer) == faces_at(2)
    assert faces(inner) == faces_at(0)


def test_variants_switch_the_recipe(stage, coat):
    prim = holder(stage, coat)
    variants = prim.GetVariantSets().AddVariantSet("detail")
    for name, level in (("low", 0), ("high", 2)):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            setting(prim, LEVEL, level)
    for name, level in (("low", 0), ("high", 2), ("low", 0)):
        variants.SetVariantSelection(name)
        assert faces(prim) == faces_at(level)


def test_instances_with_one_recipe_share_and_others_do_not(stage, coat):
    levels = [0, 0, 2]
    prims = [holder(stage, coat, path=f"/Shot/Coat{i}") for i in range(len(levels))]
    for prim, level in zip(prims, levels, strict=True):
        setting(prim, LEVEL, level)
        prim.SetInstanceable(True)
    prototypes = [prim.GetPrototype() for prim in prims]
    assert prototypes[0] == prototypes[1] != prototypes[2]
    found = [len(UsdGeom.Mesh(prototype.GetChild("render")).GetFaceVertexCountsAttr().Get()) for prototype in prototypes]
    assert found == [faces_at(level) for level in levels]
    layers = {layer.identifier for layer in stage.GetUsedLayers() if layer.fileExtension == "tailor"}
    assert len(layers) == 2


def test_the_source_is_found_as_the_composing_stage_finds_files(coat, tmp_path):
    """By the search path of the stage's resolver context, where it is not beside the `.tailor` file."""
    (tmp_path / "library" / "cloth").mkdir(parents=True)
    coat.with_name("coat.usda").rename(tmp_path / "library" / "cloth" / "coat.usda")
    recipe(tmp_path / "library" / "found.tailor", "cloth/coat.usda")
    (tmp_path / "elsewhere").mkdir()
    shot = tmp_path / "elsewhere" / "shot.usda"
    shot.write_text('#usda 1.0\ndef "Coat" (payload = @found.tailor@)\n{\n}\n')
    context = Ar.ResolverContext(Ar.DefaultResolverContext([str(tmp_path / "library")]))
    stage = Usd.Stage.Open(str(shot), context)
    assert faces(stage.GetPrimAtPath("/Coat")) == faces_at(1)
    assert not Usd.Stage.Open(str(shot)).GetPrimAtPath("/Coat/render")


def test_a_payload_that_is_not_loaded_makes_nothing(coat):
    outside = Usd.Stage.CreateInMemory()
    outside.DefinePrim("/Shot")
    holder(outside, coat)
    stage = Usd.Stage.Open(outside.GetRootLayer(), Usd.Stage.LoadNone)
    assert not stage.GetPrimAtPath("/Shot/Coat/render")
    stage.Load("/Shot/Coat")
    assert faces(stage.GetPrimAtPath("/Shot/Coat")) == faces_at(1)


def saved(prim):
    """The layers of the prim's stage are as on disk, so that reloading takes nothing of them away."""
    prim.GetStage().Save()
    return prim


def later(path):
    """Moves a file's time on: clocks of file systems are coarse."""
    os.utime(path, ns=(time.time_ns() + 2_000_000_000,) * 2)


def test_reload_sees_edits_of_source_and_recipe(stage, coat):
    prim = saved(holder(stage, coat))
    source = coat.with_name("coat.usda")
    before = mesh(prim, "sim").GetPointsAttr().Get()
    text = source.read_text()
    edited = Sdf.Layer.CreateAnonymous(".usda")
    assert edited.ImportFromString(text)
    points = edited.GetAttributeAtPath("/Coat/model.points")
    points.default = Vt.Vec3fArray([point * 2 for point in points.default])
    source.write_text(edited.ExportToString())
    later(source)
    stage.Reload()
    assert max(p[0] for p in mesh(prim, "sim").GetPointsAttr().Get()) == pytest.approx(2 * max(p[0] for p in before), rel=0.01)
    assert faces(prim) == faces_at(1)
    recipe(coat, "coat.usda", render={"level": 2})
    later(coat)
    stage.Reload()
    assert faces(prim) == faces_at(2)


def test_a_source_that_goes_is_told_and_one_that_comes_back_recovers(stage, coat):
    prim = saved(holder(stage, coat))
    assert faces(prim) == faces_at(1)
    source = coat.with_name("coat.usda")
    text = source.read_text()
    source.unlink()
    assert any(f"{coat}: its source coat.usda cannot be found" in text for text in errors(stage.Reload))
    source.write_text(text)
    later(source)
    stage.Reload()
    assert faces(prim) == faces_at(1)


def test_a_bad_value_is_told_and_mended(stage, coat, capfd):
    """The content stays as the recipe without the value makes it, and follows when the value is corrected."""
    prim = holder(stage, coat)
    capfd.readouterr()
    setting(prim, LEVEL, 99)
    said = capfd.readouterr().err
    assert said.count("99 is out of range") == 1, said
    assert "render.level" in said and "give 0 to 6" in said and str(coat) in said
    assert faces(prim) == faces_at(1)
    setting(prim, LEVEL, 2)
    assert faces(prim) == faces_at(2)


def test_muting_and_unmuting(stage, coat):
    prim = holder(stage, coat)
    stage.MuteLayer(str(coat))
    assert not mesh(prim)
    stage.UnmuteLayer(str(coat))
    assert faces(prim) == faces_at(1)


def test_many_edits_do_not_grow_the_memory(coat):
    """Edits of three attributes; after the first third the process is as large as it will be."""
    edits = 3000 if ALL else 900
    said = script(
        f"edits = {edits}"
        """
import resource, sys
from pxr import Sdf, Usd
stage = Usd.Stage.CreateInMemory()
prim = stage.DefinePrim("/Coat")
prim.GetPayloads().AddPayload(sys.argv[1])
level = prim.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int)
length = prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float)
uv = prim.CreateAttribute("tailor:sim:uvSet", Sdf.ValueTypeNames.Token)
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()
for i in range(edits):
    [lambda: level.Set(i % 7 // 3), lambda: length.Set(0.5 + i / edits), lambda: uv.Set("" if i % 2 else "st")][i % 3]()
    assert stage.GetPrimAtPath("/Coat/sim").GetAttribute("points").Get()
    if i % (edits // 6) == edits // 6 - 1:
        print(resident())
assert len([l for l in Sdf.Layer.GetLoadedLayers() if l.fileExtension == "tailor"]) == 1
""",
        coat,
        USDTAILOR_CACHE_MB="4",
    )
    sizes = [int(line) for line in said.split()]
    assert len(sizes) == 6
    assert sizes[-1] - sizes[1] < 8 << 20, sizes
