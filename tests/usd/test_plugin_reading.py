"""A `.tailor` file as a layer: the same as the command's, by every way in which a layer is read and written."""

import shutil
from pathlib import Path

import pytest
import sources
from conftest import EXAMPLES, run
from pxr import Sdf, Usd, UsdGeom, UsdUtils
from tailor_file import contents, differences, faces, holder, needs_plugin, recipe

pytestmark = needs_plugin


@pytest.fixture
def coat(tmp_path):
    """A small garment and a `.tailor` file over it."""
    sources.write(tmp_path / "coat.usda", seam_column=2, primvars=[{"name": "weight", "type_name": "float", "interpolation": "vertex"}])
    return recipe(tmp_path / "coat.tailor", "coat.usda")


def test_is_what_the_command_builds(garment, usdtailor, tmp_path):
    """Attribute by attribute, on every garment; the default recipe, except for speed."""
    path = recipe(tmp_path / "in" / "garment.tailor", garment, sim={"iterations": 1}, render={"level": 1})
    built = tmp_path / "in" / "built.usda"
    done = run(usdtailor, "build", path, "-o", built)
    assert done.returncode == 0, done.stderr
    by_plugin, by_command = Usd.Stage.Open(str(path)), Usd.Stage.Open(str(built))
    assert differences(contents(by_plugin), contents(by_command)) == []
    layers = [{Path(layer.realPath).resolve() for layer in stage.GetUsedLayers() if layer.realPath} for stage in (by_plugin, by_command)]
    assert layers[0] - {path.resolve()} == layers[1] - {built.resolve()} == {garment.resolve()}


def test_trims_are_bound_in_a_payload(usdtailor, tmp_path):
    """The trims of the example: as the command writes them, and below the prim that has the payload."""
    shutil.copy(EXAMPLES / "trims/skirt.usda", tmp_path)
    path = recipe(tmp_path / "skirt.tailor", "skirt.usda", prim="/Skirt/body", render={"level": 0})
    done = run(usdtailor, "build", path, "-o", tmp_path / "built.usda")
    assert done.returncode == 0, done.stderr
    by_plugin, by_command = (Usd.Stage.Open(str(file)) for file in (path, tmp_path / "built.usda"))
    unlike = differences(contents(by_plugin), contents(by_command))
    # The plugin reads the source as it is composed: it knows no variants, and binds the material that is selected.
    assert [line for line in unlike if "material:binding" not in line] == []
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/Shot").GetPayloads().AddPayload(str(path))
    for trim in ("buttons", "loops", "zip_tape", "zip_teeth"):
        prim = stage.GetPrimAtPath(f"/Shot/{trim}")
        assert prim.GetRelationship("tailor:bindTarget").GetTargets() == [Sdf.Path("/Shot/sim")]


def test_is_what_the_command_builds_of_an_unusual_garment(usdtailor, tmp_path):
    """Skinning, assets, materials, subsets, creases, metadata: what a round trip through another reader could bend."""

    def finish(mesh):
        sources.add_skinning(mesh)
        prim = mesh.GetPrim()
        prim.CreateAttribute("userProperties:maker", Sdf.ValueTypeNames.String).Set("Änne")
        prim.SetDocumentation("a coat")
        UsdGeom.Xformable(mesh).AddTranslateOp().Set((1, 2, 3))
        stage = prim.GetStage()
        stage.SetStartTimeCode(1)
        stage.GetRootLayer().customLayerData = {"shot": "a1"}

    (tmp_path / "cloth0.png").write_bytes(b"a picture")
    sources.write(
        tmp_path / "coat.usda",
        seam_column=2,
        creases={(0, 1, 2): 3.0},
        primvars=[{"name": f"of_{kind}", "type_name": kind, "interpolation": "uniform"} for kind in ("int", "string", "asset", "half3", "quatf", "double")],
        subsets=[{"name": "left", "indices": [0, 1], "material": "wool"}, {"name": "hem", "indices": [0, 1, 1, 2], "element": "edge", "family": "edges"}],
        finish=finish,
    )
    path = recipe(tmp_path / "coat.tailor", "coat.usda", sim={"constraints": ["hem"]})
    done = run(usdtailor, "build", path, "-o", tmp_path / "built.usda")
    assert done.returncode == 0, done.stderr
    by_plugin, by_command = (Usd.Stage.Open(str(file)) for file in (path, tmp_path / "built.usda"))
    assert differences(contents(by_plugin), contents(by_command)) == []


@pytest.mark.parametrize("arguments", ["sim.maxEdgeLength=0.3", "render.level=2&sim.uvSet=st", "sim.constrainUvSeams=false", "time=3"])
def test_arguments_are_the_flags(coat, usdtailor, arguments):
    flags = [flag for text in arguments.split("&") for flag in (("--time", text[5:]) if text.startswith("time") else ("--set", text))]
    done = run(usdtailor, "build", coat, "-o", coat.with_name("built.usda"), *flags)
    assert done.returncode == 0, done.stderr
    by_plugin = Usd.Stage.Open(f"{coat}:SDF_FORMAT_ARGS:{arguments}")
    assert differences(contents(by_plugin), contents(Usd.Stage.Open(str(coat.with_name("built.usda"))))) == []


def test_the_prim_is_chosen_by_file_and_argument(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "two.usda"))
    for name in ("/Coat/model", "/Shirt/model"):
        sources.define(stage, name, sources.sheet())
    stage.SetDefaultPrim(stage.GetPrimAtPath("/Coat"))
    stage.Save()
    path = recipe(tmp_path / "two.tailor", "two.usda", prim="/Coat/model")
    assert Usd.Stage.Open(str(path)).GetPrimAtPath("/Coat/sim")
    assert Usd.Stage.Open(f"{path}:SDF_FORMAT_ARGS:prim=/Shirt/model").GetPrimAtPath("/Shirt/sim")


def test_the_source_is_composed_by_openusd(tmp_path):
    """References, variants and attributes of a layer stack are seen as the stage composes them."""
    sources.write(tmp_path / "mesh.usda", seam_column=2)
    stage = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    root = stage.DefinePrim("/Asset", "Xform")
    stage.SetDefaultPrim(root)
    root.GetReferences().AddReference("./mesh.usda")
    variants = root.GetVariantSets().AddVariantSet("detail")
    for name, level in (("low", 0), ("high", 2)):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            stage.OverridePrim("/Asset/model").CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(level)
    stage.Save()
    path = tmp_path / "asset.tailor"
    path.write_text('{"source": "asset.usda", "sim": {"iterations": 1}}')
    stage = Usd.Stage.Open(str(path))
    assert faces(stage.GetPrimAtPath("/Asset")) == 12 * 16


@pytest.mark.parametrize("arc", ["payload", "reference", "sublayer"])
def test_every_arc_brings_the_products(coat, arc):
    stage = Usd.Stage.CreateInMemory()
    if arc == "sublayer":
        stage.GetRootLayer().subLayerPaths.append(str(coat))
        prim = stage.GetPrimAtPath("/Coat")
    else:
        prim = holder(stage, coat, arc=arc)
    assert faces(prim, "render") == 12 * 4
    assert faces(prim, "sim") > 12
    assert UsdGeom.Imageable(stage.GetPrimAtPath(prim.GetPath().AppendChild("model"))).GetPurposeAttr().Get() == "guide"


def test_the_layer_states_the_source_as_the_file_does(coat):
    layer = Sdf.Layer.FindOrOpen(str(coat))
    assert list(layer.subLayerPaths) == ["coat.usda"]
    assert layer.GetExternalAssetDependencies() == [str(coat.with_name("coat.usda"))]
    assert not layer.permissionToSave or not layer.GetFileFormat().SupportsWriting()


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
@pytest.mark.parametrize("flat", [False, True], ids=["layer", "flat"])
def test_exports_through_the_plugin(coat, suffix, flat):
    """What `usdcat coat.tailor -o coat.usdc` does, with --flatten or without."""
    out = coat.with_name("out" + suffix)
    assert Usd.Stage.Open(str(coat)).Export(str(out)) if flat else Sdf.Layer.FindOrOpen(str(coat)).Export(str(out))
    assert differences(contents(Usd.Stage.Open(str(coat))), {k: v for k, v in contents(Usd.Stage.Open(str(out))).items()}) in (
        [],
        ["/: documentation"],
    )


def test_exports_as_a_package(coat):
    Usd.Stage.Open(str(coat)).Export(str(coat.with_name("flat.usdc")))
    package = coat.with_name("coat.usdz")
    assert UsdUtils.CreateNewUsdzPackage(str(coat.with_name("flat.usdc")), str(package))
    stage = Usd.Stage.Open(str(package))
    assert faces(stage.GetPrimAtPath("/Coat")) == 12 * 4


def test_is_opened_inside_a_package(coat, tmp_path):
    """The source is the one in the package, whatever lies beside the package."""
    outside = tmp_path / "outside"
    outside.mkdir()
    sources.write(outside / "coat.usda", shape=lambda: sources.sheet(width=9), seam_column=2)
    for name in ("", "shots/"):
        package = outside / f"packed{len(name)}.usdz"
        with Sdf.ZipFileWriter.CreateNew(str(package)) as writer:
            root = tmp_path / "root.usda"
            root.write_text(f'#usda 1.0\ndef "A" (payload = @./{name}coat.tailor@)\n{{\n}}\n')
            writer.AddFile(str(root), "root.usda")
            writer.AddFile(str(coat), f"{name}coat.tailor")
            writer.AddFile(str(coat.with_name("coat.usda")), f"{name}coat.usda")
        stage = Usd.Stage.Open(str(package))
        prim = stage.GetPrimAtPath("/A")
        assert faces(prim, "model") == 12 and faces(prim, "render") == 12 * 4


def test_is_printed_as_text(coat):
    text = Sdf.Layer.FindOrOpen(str(coat)).ExportToString()
    assert text.startswith("#usda 1.0") and 'def Mesh "sim"' in text
    assert 'def Mesh "render"' in Sdf.Layer.FindOrOpen(str(coat)).GetPrimAtPath("/Coat").GetAsText()


def test_metadata_alone_is_read_without_the_meshes(coat):
    layer = Sdf.Layer.OpenAsAnonymous(str(coat), metadataOnly=True)
    assert layer.defaultPrim == "Coat"
    assert list(layer.subLayerPaths) == ["coat.usda"]
    assert not layer.GetPrimAtPath("/Coat/sim") and not layer.GetPrimAtPath("/Coat/render")


def test_all_dependencies_of_a_package_are_found(coat):
    (coat.parent / "cloth0.png").write_bytes(b"a picture")
    source = Usd.Stage.Open(str(coat.with_name("coat.usda")))
    source.GetPrimAtPath("/Coat/model").CreateAttribute("userProperties:swatch", Sdf.ValueTypeNames.Asset).Set("./cloth0.png")
    source.Save()
    layers, assets, missing = UsdUtils.ComputeAllDependencies(str(coat))
    assert {Path(layer.realPath).name for layer in layers} == {"coat.tailor", "coat.usda"}
    assert [Path(asset).name for asset in assets] == ["cloth0.png"]
    assert missing == []


def test_the_source_may_be_usdz_or_hold_the_products_already(usdtailor, tmp_path):
    shutil.copy(EXAMPLES / "tshirt.usda", tmp_path / "shirt.usda")
    for suffix in (".usda", ".usdz"):
        done = run(usdtailor, "build", tmp_path / "shirt.usda", "-o", tmp_path / f"built{suffix}", "--set", "sim.iterations=1")
        assert done.returncode == 0, done.stderr
        path = recipe(tmp_path / f"again{suffix[1:]}.tailor", f"built{suffix}", render={"level": 0}, prim="/Tshirt/model")
        stage = Usd.Stage.Open(str(path))
        root = stage.GetDefaultPrim()
        cage = len(UsdGeom.Mesh(root.GetChild("model")).GetFaceVertexCountsAttr().Get())
        assert faces(root, "render") == cage
