"""Crates that the program writes can be opened, changed and saved in place by OpenUSD, and keep all that they had."""

import shutil

import pytest
from conftest import EXAMPLES
from pxr import Sdf, Usd
from runs import good
from test_drive import moved, write_cache

COAT = EXAMPLES / "sewn" / "coat.usda"


@pytest.fixture(scope="module")
def coat(built):
    return built(COAT, suffix=".usdc")


def content(path):
    layer, found = Sdf.Layer.OpenAsAnonymous(str(path)), {}
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda at: found.update({at: str(layer.GetObjectAtPath(at).GetAsText() if at != Sdf.Path.absoluteRootPath and hasattr(layer.GetObjectAtPath(at), "GetAsText") else at)}))
    return found


def edit(path):
    before = content(path)
    stage = Usd.Stage.Open(str(path))
    prim = stage.GetDefaultPrim()
    prim.CreateAttribute("userProperties:note", Sdf.ValueTypeNames.Token).Set("fitted on Tuesday")
    stage.Save()
    after = content(path)
    added = {at for at in after if at not in before}
    assert added == {prim.GetPath().AppendProperty("userProperties:note")} and before.keys() <= after.keys()
    assert Usd.Stage.Open(str(path)).GetDefaultPrim().GetAttribute("userProperties:note").Get() == "fitted on Tuesday"


@pytest.mark.parametrize("options", [(), ("--flatten",), ("--lods", "2"), ("--sim-only",)], ids=lambda options: " ".join(options) or "plain")
def test_builds(usdtailor, tmp_path, options):
    out = tmp_path / "built.usdc"
    good(usdtailor, "build", COAT, "-o", out, *options)
    edit(out)


def test_a_build_of_a_layer_with_a_comment(usdtailor, tmp_path):
    layer = Sdf.Layer.FindOrOpen(str(COAT))
    source = tmp_path / "commented.usda"
    layer.Export(str(source))
    commented = Sdf.Layer.FindOrOpen(str(source))
    commented.comment, commented.documentation = "from the archive", "A coat."
    commented.Save()
    out = tmp_path / "built.usdc"
    good(usdtailor, "build", source, "-o", out, "--flatten")
    written = Sdf.Layer.FindOrOpen(str(out))
    assert (written.comment, written.documentation) == ("from the archive", "A coat.")
    edit(out)


@pytest.mark.parametrize("options", [(), ("--clips",)], ids=["one file", "clips"])
def test_shots(usdtailor, coat, tmp_path, options):
    cache, out = write_cache(tmp_path / "cache.usdc", coat, moved(coat)), tmp_path / "shot.usdc"
    good(usdtailor, "drive", coat.path, "--cache", cache, "-o", out, *options)
    for path in sorted(tmp_path.rglob("*.usdc")):
        if path != cache:
            copy = path.with_name(f"copy_{path.name}")
            shutil.copy(path, copy)
            edit(copy)
