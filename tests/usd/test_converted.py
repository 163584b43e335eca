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
from runs import good, mounted, refused, sim_points
from sources import add_subset, write

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


EDITED = '''
over "Coat"
{
    over "model"
    {
        over "half"
        {
            int[] indices = edit [append 5]
        }
    }
}
'''


def edited(path, half=(0, 1)):
    """A garment below a layer that edits the faces of a subset: only OpenUSD has such values."""
    base, text = write(path.with_name("base.usda"), finish=lambda mesh: add_subset(mesh, name="half", indices=list(half))), EDITED
    path.write_text(f'#usda 1.0\n(\n    defaultPrim = "Coat"\n    subLayers = [@./{base.name}@]\n)\n{text}')
    return path, base


def half_of(path, prim="/Coat/model"):
    stage = Usd.Stage.Open(str(path))
    return list(UsdGeom.Subset(stage.GetPrimAtPath(f"{prim}/half")).GetIndicesAttr().Get())


def test_a_stage_with_edits_of_arrays_is_flattened(usdtailor, openusd, tmp_path):
    source, base = edited(tmp_path / "coat.usda")
    before, out, plain = source.read_bytes(), tmp_path / "out.usda", tmp_path / "plain.usda"
    done = good(usdtailor, "build", source, "-o", out)
    assert done.stderr.count("converted-layer") == 1 and f"{source}: flattened by OpenUSD" in done.stderr
    # Outputs are over the file itself.
    assert Sdf.Layer.FindOrOpen(str(out)).subLayerPaths == ["./coat.usda"] and source.read_bytes() == before
    assert half_of(out) == [0, 1, 5]
    # The products equal those of the same garment without edits.
    write(plain, finish=lambda mesh: add_subset(mesh, name="half", indices=[0, 1, 5]))
    good(usdtailor, "build", plain, "-o", tmp_path / "plain_out.usda")
    for name in ("sim", "render"):
        assert half_of(out, f"/Coat/{name}") == half_of(tmp_path / "plain_out.usda", f"/Coat/{name}")
        assert np.array_equal(points(out, f"/Coat/{name}"), points(tmp_path / "plain_out.usda", f"/Coat/{name}"))
    # A layer below the file counts for what is stale.
    assert "stale" not in good(usdtailor, "check", out).stderr
    base.write_text(base.read_text() + "\n# more\n")
    refused(usdtailor, "check", out, says=["stale-output", "base.usda has changed"])
    refused(usdtailor, "info", source, "--no-fallback", says=["error[not-supported]", "usdcat --flatten"])


def test_a_stage_with_variants_or_faults_is_not_flattened(usdtailor, openusd, tmp_path):
    """Variants that are not selected, and the warning of a fault, would be lost."""
    source, base = edited(tmp_path / "coat.usda")
    whole = base.read_text()
    stage = Usd.Stage.Open(str(base))
    sizes = stage.GetPrimAtPath("/Coat").GetVariantSets().AddVariantSet("size")
    for name in ("s", "l"):
        sizes.AddVariant(name)
    stage.GetRootLayer().Save()
    refused(usdtailor, "info", source, says=["error[not-supported]"])
    base.write_text(whole)
    good(usdtailor, "info", source)
    source.write_text(source.read_text().replace("@./base.usda@", "@./base.usda@, @./missing.usda@"))
    refused(usdtailor, "info", source, says=["error[not-supported]"])


def test_a_package_with_nothing_but_a_package_is_flattened(usdtailor, openusd, tmp_path):
    inner, outer, out = tmp_path / "inner.usdz", tmp_path / "outer.usdz", tmp_path / "out.usda"
    garment = write(tmp_path / "coat.usda")
    for package, file in ((inner, garment), (outer, inner)):
        with Sdf.ZipFileWriter.CreateNew(str(package)) as writer:
            writer.AddFile(str(file), file.name)
    assert f"{outer}: flattened by OpenUSD" in good(usdtailor, "build", outer, "-o", out).stderr
    good(usdtailor, "build", garment, "-o", tmp_path / "plain.usda")
    assert Sdf.Layer.FindOrOpen(str(out)).subLayerPaths == ["./outer.usdz"]
    assert np.array_equal(points(out, "/Coat/render"), points(tmp_path / "plain.usda", "/Coat/render"))
    assert "stale" not in good(usdtailor, "check", out).stderr
    refused(usdtailor, "info", outer, "--no-fallback", says=["error[damaged-file]"])


def test_a_stage_of_too_many_arcs_is_flattened(usdtailor, openusd, tmp_path):
    write(tmp_path / "part.usda")
    names = [f"P{i}" for i in range(2001)]
    arcs = ", ".join(["@./part.usda@</Coat>", *(f"</{name}>" for name in names)])
    prims = "\n".join(f'def Xform "{name}"\n{{\n}}' for name in names)
    source = mounted(tmp_path / "coat.usda", f'def Xform "Coat" (\n    references = [{arcs}]\n)\n{{\n}}\n{prims}')
    refused(usdtailor, "info", source, "--no-fallback", says=["error[composition-failed]", "/Coat", "more than 2000 references"])
    assert f"{source}: flattened by OpenUSD" in good(usdtailor, "build", source, "-o", tmp_path / "out.usda").stderr
    assert len(points(tmp_path / "out.usda", "/Coat/sim"))
