"""Crates that the program writes can be opened, changed and saved in place by OpenUSD, and keep all that they had.

Frames of clips cannot (docs/limits.md)."""

import shutil

import pytest
from conftest import EXAMPLES
from pxr import Sdf
from runs import good
from test_drive import moved, write_cache

COAT = EXAMPLES / "sewn" / "coat.usda"


@pytest.fixture(scope="module")
def coat(built):
    return built(COAT, suffix=".usdc")


def specs(path):
    """The paths of a layer with the names of their fields."""
    layer, found = Sdf.Layer.OpenAsAnonymous(str(path)), {}
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda at: found.update({at: set(layer.GetObjectAtPath(at).ListInfoKeys()) if at.IsPrimPath() else None}))
    return found


def edit(path):
    before, layer = specs(path), Sdf.Layer.FindOrOpen(str(path))
    added = {Sdf.Path("/Added"), Sdf.Path("/Added.note")}
    Sdf.CreatePrimInLayer(layer, "/Added").specifier = Sdf.SpecifierDef
    note = Sdf.AttributeSpec(layer.GetPrimAtPath("/Added"), "note", Sdf.ValueTypeNames.Token)
    note.default = "fitted on Tuesday"
    assert layer.Save()
    after = specs(path)
    assert after.keys() - before.keys() == added and all(after[at] == fields for at, fields in before.items())
    again = Sdf.Layer.OpenAsAnonymous(str(path))
    assert again.GetAttributeAtPath("/Added.note").default == "fitted on Tuesday"


@pytest.mark.parametrize("options", [(), ("--flatten",), ("--lods", "2"), ("--sim-only",)], ids=lambda options: " ".join(options) or "plain")
def test_builds(usdtailor, tmp_path, options):
    out = tmp_path / "built.usdc"
    good(usdtailor, "build", COAT, "-o", out, *options)
    edit(out)


def test_a_build_of_a_layer_with_a_comment(usdtailor, tmp_path):
    source = tmp_path / "commented.usda"
    shutil.copy(EXAMPLES / "tshirt.usda", source)
    commented = Sdf.Layer.FindOrOpen(str(source))
    commented.comment, commented.documentation = "from the archive", "A shirt."
    commented.Save()
    out = tmp_path / "built.usdc"
    good(usdtailor, "build", source, "-o", out, "--flatten")
    written = Sdf.Layer.FindOrOpen(str(out))
    assert (written.comment, written.documentation) == ("from the archive", "A shirt.")
    edit(out)


@pytest.mark.parametrize("options", [(), ("--clips",)], ids=["one file", "clips"])
def test_shots(usdtailor, coat, tmp_path, options):
    cache, out = write_cache(tmp_path / "cache.usdc", coat, moved(coat)), tmp_path / "shot.usdc"
    good(usdtailor, "drive", coat.path, "--cache", cache, "-o", out, *options)
    edit(out)
