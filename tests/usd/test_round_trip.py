"""The same content in every format, flat or layered, and after OpenUSD has written it again."""

import os

import pytest
from conftest import EXAMPLES, write
from mesh import find_model
from pxr import Sdf, Usd, Vt

FLAT = {suffix: ("--flatten",) for suffix in (".usda", ".usdc", ".usdz")}


def content(stage):
    """Every prim, attribute and relationship of the composed stage: what it is and what it holds."""
    found = {}
    for prim in stage.TraverseAll():
        found[str(prim.GetPath())] = (str(prim.GetTypeName()), tuple(prim.GetPrimTypeInfo().GetAppliedAPISchemas()), plain(prim.GetAllMetadata()))
        for attribute in prim.GetAuthoredAttributes():
            times = attribute.GetTimeSamples()
            found[str(attribute.GetPath())] = (
                str(attribute.GetTypeName()),
                attribute.GetVariability(),
                plain(attribute.GetAllMetadata()),
                plain(attribute.Get()),
                {time: plain(attribute.Get(time)) for time in times},
            )
        for relationship in prim.GetAuthoredRelationships():
            found[str(relationship.GetPath())] = [str(target) for target in relationship.GetTargets()]
    return found


# Where a prim comes from, not what it is; applied schemas are compared as they compose.
ORIGIN = set(
    "active apiSchemas assetInfo clipSets customLayerData inheritPaths payload references specializes specifier typeName "
    "variantSelection variantSetNames default timeSamples colorSpace".split()
)


def plain(value):
    """Values that compare by what they hold: an asset by the name of its file, since packages rename folders."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items() if key not in ORIGIN}
    if isinstance(value, Sdf.AssetPath):
        return os.path.basename(value.path)
    if isinstance(value, Sdf.AssetPathArray):
        return [plain(item) for item in value]
    return value


def assert_same(actual, expected, text=""):
    missing, new = sorted(expected.keys() - actual.keys()), sorted(actual.keys() - expected.keys())
    assert (missing, new) == ([], []), text
    different = [path for path in expected if actual[path] != expected[path]]
    assert different == [], "\n".join(f"{path}: {actual[path]!s:.300}\n  expected {expected[path]!s:.300}" for path in different[:5]) + text


@pytest.mark.parametrize("suffix", FLAT)
def test_flat_file_holds_what_the_layered_one_composes_to(garment, built, suffix):
    layered, flat = built(garment), built(garment, *FLAT[suffix], suffix=suffix)
    assert_same(content(flat.stage), content(layered.stage))


def test_layer_is_the_same_in_text_and_in_binary(garment, built):
    text, binary = built(garment), built(garment, suffix=".usdc")
    assert_same(content(binary.stage), content(text.stage))


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
@pytest.mark.parametrize("written", [".usda", ".usdc"])
def test_open_usd_writes_the_same_again(garment, built, tmp_path, written, suffix):
    product = built(garment, *FLAT[written], suffix=written)
    again = tmp_path / f"again{suffix}"
    assert product.stage.GetRootLayer().Export(str(again))
    assert_same(content(Usd.Stage.Open(str(again))), content(product.stage))


def test_text_parses_and_prints_the_same(product):
    layer = product.stage.GetRootLayer()
    text = layer.ExportToString()
    again = Sdf.Layer.CreateAnonymous(".usda")
    assert again.ImportFromString(text), text[:2000]
    assert again.ExportToString() == text


def test_what_open_usd_writes_of_an_output_is_built_again(usdtailor, garment, built, tmp_path):
    exported = tmp_path / "exported.usdc"
    assert built(garment, "--flatten", suffix=".usdc").stage.GetRootLayer().Export(str(exported))
    write(usdtailor, exported, tmp_path / "again.usda", "--flatten")


EMPTY = {"strings": Vt.StringArray(), "inner": {"assets": Sdf.AssetPathArray(), "tokens": Vt.TokenArray(), "numbers": Vt.Int64Array()}}


@pytest.mark.parametrize("suffix", FLAT)
def test_properties_with_empty_lists_are_read_and_written(usdtailor, tmp_path, suffix):
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(EXAMPLES / "tshirt.usda")))
    model, kinds = find_model(stage), (Sdf.ValueTypeNames.StringArray, Sdf.ValueTypeNames.AssetArray, Sdf.ValueTypeNames.PathExpressionArray)
    for kind in kinds:
        name = str(kind).removesuffix("[]")
        model.CreateAttribute(f"empty:{name}", kind).Set(kind.defaultValue)
    source, flat = tmp_path / "source.usdc", tmp_path / f"flat{suffix}"
    stage.Export(str(source))
    assert "empty" not in write(usdtailor, source, flat, "--flatten"), "nothing is left out"
    product = Usd.Stage.Open(str(flat))
    found = product.GetPrimAtPath(model.GetPath())
    for attribute in model.GetPropertiesInNamespace("empty"):
        value = found.GetAttribute(attribute.GetName()).Get()
        assert value is not None and len(value) == 0 and type(value) is type(attribute.Get())
    assert found.GetAttribute("points").Get() == model.GetAttribute("points").Get(), "the rest of the crate is as it was"


@pytest.mark.parametrize("suffix", FLAT)
def test_empty_lists_in_dictionaries_are_read_and_written(usdtailor, tmp_path, suffix):
    # Other tests of this process have the layer of the file.
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(EXAMPLES / "tshirt.usda")))
    stage.GetRootLayer().customLayerData = EMPTY
    model = find_model(stage)
    model.SetCustomData(EMPTY)
    source, flat = tmp_path / "source.usdc", tmp_path / f"flat{suffix}"
    stage.Export(str(source))
    write(usdtailor, source, flat, "--flatten")
    found = Usd.Stage.Open(str(flat))
    of_prim, data = found.GetPrimAtPath(model.GetPath()).GetCustomData(), found.GetRootLayer().customLayerData
    assert {key: of_prim[key] for key in EMPTY} == EMPTY == {key: data[key] for key in EMPTY}
    texts = [value for value in data["tailor"]["build"].values() if isinstance(value, Vt.StringArray)]
    assert texts and all(len(text) > 0 for text in texts), "no reader has to know empty lists of our own"
