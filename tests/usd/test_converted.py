"""Layers that only OpenUSD reads: it writes them anew for the run, and outputs refer to the layers themselves."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from conftest import run
from fitting import tube, write_tube
from pxr import Sdf, Usd, UsdGeom, UsdShade
from runs import good, refused, sim_points
from sources import write

# OpenUSD takes any number for true or false, and the library takes 0 and 1.
NUMBER = "doubleSided = 2"


@pytest.fixture
def openusd(monkeypatch):
    """The OpenUSD of these tests is beside the program."""
    monkeypatch.setenv("USDTAILOR_PYTHON", sys.executable)


def foreign(path):
    """Makes a layer of text one that only OpenUSD reads."""
    text = path.read_text()
    assert "uniform bool doubleSided = 1" in text
    path.write_text(text.replace("doubleSided = 1", NUMBER))
    assert Sdf.Layer.FindOrOpen(str(path)), "OpenUSD reads it"
    return path


def garment(path, finish=None):
    def change(mesh):
        mesh.CreateDoubleSidedAttr(True)
        if finish:
            finish(mesh)

    return foreign(write(path, finish=change))


def points(path, prim="/Coat/model"):
    stage = Usd.Stage.Open(str(path))
    return np.array(UsdGeom.Mesh(stage.GetPrimAtPath(prim)).GetPointsAttr().Get())


def test_a_layer_that_only_openusd_reads_is_built_over_itself(usdtailor, openusd, tmp_path):
    source, out, report = garment(tmp_path / "coat.usda"), tmp_path / "out.usda", tmp_path / "out.json"
    before = source.read_bytes()
    done = good(usdtailor, "build", source, "-o", out, "--report", report, "--strict", "--allow", "no-pattern")
    assert f"warning[converted-layer]: {source}: read by OpenUSD" in done.stderr and done.stderr.count("converted-layer") == 1
    (told,) = [warning for warning in json.loads(report.read_text())["warnings"] if warning["code"] == "converted-layer"]
    assert told["severity"] == "note" and "\n" not in told["message"]
    assert Sdf.Layer.FindOrOpen(str(out)).subLayerPaths == ["./coat.usda"] and source.read_bytes() == before
    # The products equal those of the layer that OpenUSD exports.
    plain = tmp_path / "plain.usdc"
    Sdf.Layer.FindOrOpen(str(source)).Export(str(plain))
    good(usdtailor, "build", plain, "-o", tmp_path / "plain_out.usda")
    for name in ("sim", "render"):
        assert np.array_equal(points(out, f"/Coat/{name}"), points(tmp_path / "plain_out.usda", f"/Coat/{name}"))
    stage = Usd.Stage.Open(str(out))
    assert stage.GetPrimAtPath("/Coat/render").GetAttribute("doubleSided").Get() is True
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize("way", ["option", "variable"])
def test_without_openusd_the_error_is_that_of_the_library(usdtailor, openusd, monkeypatch, tmp_path, way):
    source, out = garment(tmp_path / "coat.usda"), tmp_path / "out.usda"
    if way == "variable":
        monkeypatch.setenv("USDTAILOR_PYTHON", "")
    refused(usdtailor, "build", source, "-o", out, *(["--no-fallback"] if way == "option" else []), says=["error[damaged-file]", "bool literals"])
    assert not out.exists()


def test_what_openusd_cannot_read_is_damaged(usdtailor, openusd, tmp_path):
    source = garment(tmp_path / "coat.usda")
    source.write_text(source.read_text().replace("int[] faceVertexCounts = [", "int[] faceVertexCounts = [[[ "))
    done = refused(usdtailor, "check", source, says=["error[damaged-file]"])
    assert "converted" not in done.stderr


def test_usdcat_on_the_path_does_it_too(usdtailor, monkeypatch, tmp_path):
    folder = tmp_path / "bin"
    folder.mkdir()
    script = f"#!{sys.executable}\nimport sys\nfrom pxr import Sdf\nassert sys.argv[2] == '-o'\nSdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[3])\n"
    (folder / "usdcat").write_text(script)
    (folder / "usdcat").chmod(0o755)
    monkeypatch.delenv("USDTAILOR_PYTHON")
    monkeypatch.setenv("PATH", str(folder))
    done = good(usdtailor, "check", garment(tmp_path / "coat.usda"))
    assert "read by usdcat" in done.stderr


def test_modules_of_the_folder_are_not_run(usdtailor, openusd, tmp_path):
    (tmp_path / "pxr.py").write_text("open('ran', 'w')\n")
    source = garment(tmp_path / "coat.usda")
    done = subprocess.run([usdtailor, "check", source.name], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "converted-layer" in done.stderr and not (tmp_path / "ran").exists()


def test_an_output_is_fresh_until_the_layer_changes(usdtailor, openusd, tmp_path):
    source, out = garment(tmp_path / "coat.usda"), tmp_path / "out.usda"
    good(usdtailor, "build", source, "-o", out)
    again = good(usdtailor, "build", source, "-o", out, "--skip-fresh", "--force")
    assert "fresh" in again.stdout and "converted-layer" in again.stderr
    assert "stale" not in good(usdtailor, "check", out).stderr
    source.write_text(source.read_text() + "\n# more\n")
    refused(usdtailor, "check", out, says=["stale-output", "coat.usda has changed"])


def test_variants_below_a_converted_layer_stay_variants(usdtailor, openusd, tmp_path):
    """A layer with variants, in a reference, beside a layer that the library reads."""
    part = garment(tmp_path / "part.usda")
    top, out = tmp_path / "top.usda", tmp_path / "out.usda"
    stage = Usd.Stage.CreateNew(str(top))
    prim = stage.DefinePrim("/Coat", "Xform")
    prim.GetReferences().AddReference("./part.usda", "/Coat")
    stage.SetDefaultPrim(prim)
    size = prim.GetVariantSets().AddVariantSet("size")
    base = points(part)
    for name, factor in (("s", 1), ("l", 2)):
        size.AddVariant(name)
        size.SetVariantSelection(name)
        with size.GetVariantEditContext():
            UsdGeom.Mesh(stage.OverridePrim("/Coat/model")).CreatePointsAttr((base * factor).tolist())
    stage.Save()
    done = good(usdtailor, "build", top, "-o", out, "--variants", "size")
    assert f"{part}: read by OpenUSD" in done.stderr
    built = Usd.Stage.Open(str(out))
    sizes = []
    for name in ("s", "l"):
        built.GetPrimAtPath("/Coat").GetVariantSet("size").SetVariantSelection(name)
        sizes.append(np.ptp(np.array(UsdGeom.Mesh(built.GetPrimAtPath("/Coat/render")).GetPointsAttr().Get())[:, 0]))
    assert abs(sizes[1] - 2 * sizes[0]) < 0.05 * sizes[0]
    assert "stale" not in good(usdtailor, "check", out).stderr


def test_paths_in_a_converted_layer_lead_to_the_files_beside_it(usdtailor, openusd, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "cloth.png").write_bytes(b"png")

    def finish(mesh):
        stage = mesh.GetPrim().GetStage()
        shader = UsdShade.Shader.Define(stage, "/Coat/look/texture")
        shader.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("./cloth.png")

    source = garment(tmp_path / "in" / "coat.usda", finish)
    for out, path in ((tmp_path / "flat.usda", "./in/cloth.png"), (tmp_path / "in" / "flat.usda", "./cloth.png")):
        good(usdtailor, "build", source, "-o", out, "--flatten")
        stage = Usd.Stage.Open(str(out))
        value = stage.GetPrimAtPath("/Coat/look/texture").GetAttribute("inputs:file").Get()
        assert value.path == path and os.path.samefile(value.resolvedPath, tmp_path / "in" / "cloth.png")


def test_shots_and_their_caches_and_bodies_are_read_so(usdtailor, openusd, tmp_path):
    source, out, cache, shot = garment(tmp_path / "coat.usda"), tmp_path / "out.usda", tmp_path / "cache.usda", tmp_path / "shot.usda"
    good(usdtailor, "build", source, "-o", out)
    stage = Usd.Stage.CreateNew(str(cache))
    mesh = UsdGeom.Mesh(stage.OverridePrim("/Coat/sim"))
    for time in (1, 2):
        mesh.CreatePointsAttr().Set((sim_points(out) + (0, time, 0)).tolist(), time)
    mesh.CreateDoubleSidedAttr(True)
    stage.Save()
    np.savez(cache.with_name("cache.npz"), points=np.stack([sim_points(out), sim_points(out)]))
    done = good(usdtailor, "drive", out, "--cache", foreign(cache), "-o", shot)
    assert all(f"{path}: read by OpenUSD" in done.stderr for path in (source, cache))
    alone = ("drive", out, "--cache", cache.with_name("cache.npz"), "-o", tmp_path / "alone.usda", "--no-fallback")
    refused(usdtailor, *alone, says=["error[not-bound]", "does not compose fully", "./coat.usda"])
    stage = Usd.Stage.Open(str(shot))
    moved = UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/render")).GetPointsAttr()
    assert np.allclose(np.array(moved.Get(2)) - np.array(moved.Get(1)), (0, 1, 0), atol=1e-5)


def test_bodies_are_read_so(usdtailor, openusd, tmp_path):
    def sided(mesh):
        mesh.CreateDoubleSidedAttr(True)

    sleeve, arm = (write_tube(tmp_path / f"{name}.usda", tube(radius, length, 24, 10)[0]) for name, radius, length in (("sleeve", 1.2, 4), ("arm", 1, 8)))
    thick = foreign(write_tube(tmp_path / "thick.usda", tube(1.3, 8, 24, 10)[0], finish=sided))
    done = run(usdtailor, "fit", sleeve, "--from", arm, "--to", thick, "-o", tmp_path / "fitted.usda")
    assert done.returncode == 0 and f"{thick}: read by OpenUSD" in done.stderr, done.stderr
    built = good(usdtailor, "build", sleeve, "--set", f"fit.from={arm}", "--set", f"fit.to={thick}", "-o", tmp_path / "built.usda")
    assert f"{thick}: read by OpenUSD" in built.stderr
