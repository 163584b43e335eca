"""The simulation mesh alone (`--sim-only`): what it holds, what stays drawn, and when it is refused."""

import json

import numpy as np
import pytest
from conftest import EXAMPLES, write
from pxr import Usd, UsdGeom, UsdValidation
from runs import good, refused

COAT = EXAMPLES / "sewn" / "coat.usda"


def values(stage, path):
    """The properties below a prim, as text."""
    found = {}
    for prim in Usd.PrimRange(stage.GetPrimAtPath(path)):
        for name in prim.GetPropertyNames():
            of = prim.GetProperty(name)
            value = of.Get() if isinstance(of, Usd.Attribute) else of.GetTargets()
            found[f"{prim.GetPath()}.{name}"] = str(list(value)) if hasattr(value, "__len__") else str(value)
    return found


@pytest.mark.parametrize("options", [(), ("--flatten",)], ids=["over the input", "flattened"])
def test_it_is_that_of_a_whole_build(usdtailor, tmp_path, options):
    whole, alone = tmp_path / "whole.usda", tmp_path / "alone.usda"
    write(usdtailor, COAT, whole, *options)
    write(usdtailor, COAT, alone, "--sim-only", *options)
    stages = [Usd.Stage.Open(str(path)) for path in (whole, alone)]
    for path in ("/Coat/sim", "/Coat/physics"):
        expected, found = [values(stage, path) for stage in stages]
        assert expected and found == expected, path
    assert not stages[1].GetPrimAtPath("/Coat/render")
    purposes = [UsdGeom.Imageable(stage.GetPrimAtPath("/Coat/model")).GetPurposeAttr().Get() for stage in stages]
    assert purposes == ["guide", "default"], "the model is what is drawn"
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not UsdValidation.ValidationContext(validators).Validate(stages[1])
    report = json.loads((tmp_path / "alone.usda.json").read_text())
    assert report["render"] is None and report["sim"]["faces"] > 0


def test_the_text_names_no_render_mesh_and_no_seam_is_made(usdtailor, tmp_path):
    alone = tmp_path / "alone.usda"
    planned = good(usdtailor, "build", COAT, "-o", alone, "--sim-only", "--dry-run").stdout
    told = good(usdtailor, "build", COAT, "-o", alone, "--sim-only").stdout
    for text in (planned, told):
        assert "render  " not in text and " faces to " not in text and "operator" not in text, text
    assert "  sim  " in told and "  cloth  " in told
    good(usdtailor, "build", COAT, "-o", alone, "--sim-only", "--skip-fresh")
    whole = refused(usdtailor, "build", COAT, "-o", alone, "--skip-fresh")
    assert "--force" in whole.stderr, "the output of one mesh is not fresh for both"


def test_what_would_be_stale_or_half_is_refused(usdtailor, tmp_path):
    whole = tmp_path / "whole.usda"
    write(usdtailor, COAT, whole)
    refused(usdtailor, "build", whole, "-o", tmp_path / "a.usda", "--sim-only", says=["--sim-only", "another build"])
    refused(usdtailor, "build", COAT, "-o", tmp_path / "b.usda", "--sim-only", "--lods", "2", says=["--sim-only", "lod.levels"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["whole.usda", "whole.usda.json"]


def test_nothing_of_it_is_driven(usdtailor, tmp_path):
    """A shot of the trims alone would leave the model, which is drawn, behind."""
    alone, cache = tmp_path / "alone.usda", tmp_path / "cache.npz"
    write(usdtailor, EXAMPLES / "trims" / "skirt.usda", alone, "--sim-only")
    assert json.loads((tmp_path / "alone.usda.json").read_text())["trims"] == []
    stage = Usd.Stage.Open(str(alone))
    points = np.array(UsdGeom.Mesh(stage.GetPrimAtPath("/Skirt/sim")).GetPointsAttr().Get())
    np.savez(cache, points=np.stack([points, points + 1]))
    refused(usdtailor, "drive", alone, "--cache", cache, "-o", tmp_path / "shot.usda", says=["not-bound", "build both meshes"])
    assert not (tmp_path / "shot.usda").exists()
