"""Text layers with names of properties beyond ASCII, wherever in a stage they are."""

import numpy as np
import pytest
from conftest import run
from pxr import Sdf
from sources import add_primvar, add_uv, sheet, write

WEIGHTS, UVS = "größe", "UVマップ"


def lettered(path):
    """A garment whose UVs and painted weights have names beyond ASCII, and targets at them."""

    def finish(mesh):
        add_uv(mesh, 2, UVS)
        add_primvar(mesh, name=WEIGHTS, type_name="float", interpolation="vertex", values=[i / 19 for i in range(20)])
        prim = mesh.GetPrim()
        prim.CreateRelationship("ziele:äußere").SetTargets([prim.GetPath().AppendProperty(f"primvars:{WEIGHTS}")])
        prim.SetCustomDataByKey("Maß", 3)

    return write(path, shape=sheet, uv=False, finish=finish)


def layer(path, suffix, prim, metadata=""):
    path = path.with_suffix(suffix)
    path.write_text(f'#usda 1.0\n(\n    defaultPrim = "Coat"\n{metadata})\n{prim}\n')
    return path


def referenced(path, inner, suffix):
    return layer(path, suffix, f'def "Coat" (prepend references = @./{inner.name}@) {{ }}')


def sublayered(path, inner, suffix):
    return layer(path, suffix, 'over "Coat" { }', f"    subLayers = [@./{inner.name}@]\n")


def in_variant(path, inner, suffix):
    variants = 'variants = { string größe = "klein" }\n    prepend variantSets = "größe"'
    return layer(path, suffix, f'def "Coat" (\n    {variants}\n)\n{{\n    variantSet "größe" = {{\n        "klein" (references = @./{inner.name}@) {{ }}\n    }}\n}}')


def packed(path, inner, suffix):
    with Sdf.ZipFileWriter.CreateNew(str(path.with_suffix(".usdz"))) as package:
        package.AddFile(str(inner), inner.name)
    return path.with_suffix(".usdz")


def pack_of_two(path, inner, suffix):
    root = sublayered(path.with_name("root"), inner, ".usda")
    with Sdf.ZipFileWriter.CreateNew(str(path.with_suffix(".usdz"))) as package:
        package.AddFile(str(root), root.name)
        package.AddFile(str(inner), inner.name)
    return path.with_suffix(".usdz")


@pytest.mark.parametrize("suffix", [".usda", ".usd"])
@pytest.mark.parametrize("stage", [None, referenced, sublayered, in_variant, packed, pack_of_two], ids=lambda s: s.__name__ if s else "alone")
def test_names_of_properties_beyond_ascii_are_read_from_text(build, usdtailor, tmp_path, suffix, stage):
    args = ("--set", f"sim.density={WEIGHTS}", "--set", "render.level=0", "--set", "sim.maxEdgeLength=0.5")
    wanted = build(lettered(tmp_path / "crate.usdc"), *args, stem="wanted")
    path = lettered(tmp_path / "text.usda").rename(tmp_path / f"in{suffix}")
    path = stage(tmp_path / "stage", path, suffix) if stage else path
    product = build(path, *args, stem="product")
    assert product.report["recipe"]["sim"]["uvSet"] == UVS
    for name in ("sim", "render"):
        found, expected = product.mesh(name), wanted.mesh(name)
        assert np.array_equal(found.points, expected.points) and found.primvars.keys() == expected.primvars.keys(), name
        for one in (UVS, WEIGHTS):
            assert np.array_equal(found.primvars[one].flat, expected.primvars[one].flat), (name, one)
    render = product.prim("render")
    assert render.GetRelationship("ziele:äußere").GetTargets() == wanted.prim("render").GetRelationship("ziele:äußere").GetTargets()
    done = run(usdtailor, "check", product.path)
    assert done.returncode == 0, done.stderr
    flat = build(path, *args, "--flatten", stem="flat")
    assert "SDF_FORMAT_ARGS" not in flat.path.read_text() + product.path.read_text()
    assert run(usdtailor, "info", flat.path).returncode == 0
