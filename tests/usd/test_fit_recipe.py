"""A recipe that names a body: the garment is fitted before it is built, in the command and in a payload."""

import os
import shutil

import numpy as np
import pytest
from conftest import run
from fitting import fit, radii, tube, write_tube
from pxr import Sdf, Usd, UsdGeom
from tailor_file import holder, needs_plugin, recipe

QUICK = ("--set", "render.level=1", "--set", "sim.iterations=1")


@pytest.fixture
def scene(tmp_path):
    """A tube as a garment, and two bodies within it, of which the second is thicker by a half."""
    (points, *faces), uvs = tube(3.0, 10.0, 24, 10)
    # Its UVs are the pattern, to scale.
    write_tube(tmp_path / "coat.usda", (points, *faces), uvs * [2 * np.pi * 3.0, 10.0])
    for name, radius in (("thin", 2.6), ("thick", 3.9)):
        (points, *faces), _ = tube(radius, 14.0, 32, 14)
        write_tube(tmp_path / f"{name}.usda", (points, *faces), prim="/Body/skin")
    return tmp_path


def points(stage, path):
    return np.array(UsdGeom.Mesh(stage.GetPrimAtPath(path)).GetPointsAttr().Get(), float)


def build(usdtailor, source, out, *args, code=0):
    done = run(usdtailor, "build", source, "-o", out, "--force", *QUICK, *args)
    assert done.returncode == code, done.stdout + done.stderr
    return done


def on(body, scene):
    return ("--set", f"fit.from={scene}/thin.usda", "--set", f"fit.to={scene}/{body}.usda")


def test_a_build_of_a_body_is_a_fit_and_a_build(usdtailor, scene):
    build(usdtailor, scene / "coat.usda", scene / "one.usda", *on("thick", scene))
    fit(usdtailor, scene / "coat.usda", "--from", scene / "thin.usda", "--to", scene / "thick.usda", "-o", scene / "fitted.usda")
    build(usdtailor, scene / "fitted.usda", scene / "two.usda")
    one, two = (Usd.Stage.Open(str(scene / name)) for name in ("one.usda", "two.usda"))
    for name in ("model", "sim", "render"):
        assert (points(one, f"/Coat/{name}") == points(two, f"/Coat/{name}")).all(), name
    assert radii(points(one, "/Coat/model")).mean() > 4.0
    assert radii(points(Usd.Stage.Open(str(scene / "coat.usda")), "/Coat/model")).mean() < 3.1, "the input stays"


def panel_area(path):
    stage = Usd.Stage.Open(str(path))
    p, corners = points(stage, "/Coat/panels"), np.array(stage.GetPrimAtPath("/Coat/panels").GetAttribute("faceVertexIndices").Get())
    a, b, c = (p[corners.reshape(-1, 3)[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_panels_rest_graded_or_as_they_were_made(usdtailor, scene):
    areas = {}
    for name, args in (("made", ()), ("graded", on("thick", scene)), ("pattern", (*on("thick", scene), "--set", "fit.rest=pattern"))):
        done = build(usdtailor, scene / "coat.usda", scene / f"{name}.usda", "--set", "cloth.panels=true", "--set", "cloth.rest=panels", *args)
        assert "flat panel" in done.stdout, name
        areas[name] = panel_area(scene / f"{name}.usda")
    # The garment is wider by a factor of about 4.3 / 3.
    assert 1.25 < areas["graded"] / areas["made"] < 1.5
    assert areas["pattern"] == pytest.approx(areas["made"], rel=0.02)


def test_sets_move_as_wholes(usdtailor, scene):
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    subset = UsdGeom.Subset.Define(stage, "/Coat/model/badge")
    subset.CreateElementTypeAttr("face")
    subset.CreateIndicesAttr([0, 1, 24, 25])
    stage.Save()
    corners = np.array(stage.GetPrimAtPath("/Coat/model").GetAttribute("faceVertexIndices").Get()).reshape(-1, 4)
    badge = np.unique(corners[[0, 1, 24, 25]])
    before = points(stage, "/Coat/model")[badge]
    sizes = {}
    for name, args in (("soft", ()), ("rigid", ("--set", "fit.rigid=badge"))):
        build(usdtailor, scene / "coat.usda", scene / "out.usda", *on("thick", scene), *args)
        after = points(Usd.Stage.Open(str(scene / "out.usda")), "/Coat/model")[badge]
        apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (before, after)]
        sizes[name] = np.abs(apart[0] - apart[1]).max()
        os.remove(scene / "out.usda")
    assert sizes["rigid"] < 1e-4 < 0.1 < sizes["soft"]


def test_paths_are_beside_the_file_that_has_them(usdtailor, scene):
    bodies = scene / "bodies"
    bodies.mkdir()
    for name in ("thin", "thick"):
        shutil.move(scene / f"{name}.usda", bodies / f"{name}.usda")
    (scene / "recipes").mkdir()
    recipe(scene / "recipes/coat.tailor", "../coat.usda", fit={"from": "../bodies/thin.usda", "to": "../bodies/thick.usda"})
    build(usdtailor, scene / "recipes/coat.tailor", scene / "by_file.usda")
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    model = stage.GetPrimAtPath("/Coat/model")
    for key, name in (("from", "thin"), ("to", "thick")):
        model.CreateAttribute(f"tailor:fit:{key}", Sdf.ValueTypeNames.Token).Set(f"bodies/{name}.usda")
    stage.Save()
    build(usdtailor, scene / "coat.usda", scene / "by_attribute.usda")
    assert (points(Usd.Stage.Open(str(scene / "by_file.usda")), "/Coat/render") == points(Usd.Stage.Open(str(scene / "by_attribute.usda")), "/Coat/render")).all()


def test_an_output_is_stale_when_its_body_changes(usdtailor, scene):
    out = scene / "out.usda"
    build(usdtailor, scene / "coat.usda", out, *on("thick", scene))
    assert run(usdtailor, "check", out).returncode == 0
    assert "fresh" in build(usdtailor, scene / "coat.usda", out, *on("thick", scene), "--skip-fresh").stdout
    (p, *faces), _ = tube(3.5, 14.0, 32, 14)
    (scene / "thick.usda").unlink()
    write_tube(scene / "thick.usda", (p, *faces), prim="/Body/skin")
    done = run(usdtailor, "check", out)
    assert done.returncode != 0 and "thick.usda has changed" in done.stderr
    assert "fresh" not in build(usdtailor, scene / "coat.usda", out, *on("thick", scene), "--skip-fresh").stdout


@pytest.mark.parametrize("kind", [Sdf.ValueTypeNames.Token, Sdf.ValueTypeNames.Asset], ids=str)
def test_a_body_of_another_variant_is_not_written_over(kind, usdtailor, scene):
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    bodies = body_variants(stage, kind)
    stage.GetPrimAtPath("/Coat/model").CreateAttribute("tailor:fit:from", kind).Set("thin.usda")
    bodies.SetVariantSelection("thin")
    stage.Save()
    before = (scene / "thick.usda").read_bytes()
    done = run(usdtailor, "build", scene / "coat.usda", "-o", scene / "thick.usda", "--force", *QUICK)
    assert done.returncode != 0 and (scene / "thick.usda").read_bytes() == before


def test_a_body_is_not_written_over(usdtailor, scene):
    before = (scene / "thick.usda").read_bytes()
    done = run(usdtailor, "build", scene / "coat.usda", "-o", scene / "thick.usda", "--force", *on("thick", scene))
    assert done.returncode != 0 and "thick.usda" in done.stderr
    assert (scene / "thick.usda").read_bytes() == before


def test_a_garment_is_not_fitted_twice(usdtailor, scene):
    coat = recipe(scene / "coat.tailor", "coat.usda", fit={"from": "thin.usda", "to": "thick.usda"})
    done = fit(usdtailor, coat, "--from", scene / "thin.usda", "--to", scene / "thick.usda", "-o", scene / "out.usda", code=1)
    assert "already" in done.stderr and not (scene / "out.usda").exists()


def test_a_first_body_alone_fits_nothing(usdtailor, scene):
    build(usdtailor, scene / "coat.usda", scene / "out.usda", "--set", f"fit.from={scene}/thin.usda")
    assert radii(points(Usd.Stage.Open(str(scene / "out.usda")), "/Coat/model")).mean() < 3.1


def body_variants(stage, kind):
    """A variant set `body` in which each variant names its body."""
    bodies = stage.GetPrimAtPath("/Coat").GetVariantSets().AddVariantSet("body")
    for name in ("thin", "thick"):
        bodies.AddVariant(name)
        bodies.SetVariantSelection(name)
        with bodies.GetVariantEditContext():
            stage.OverridePrim("/Coat/model").CreateAttribute("tailor:fit:to", kind).Set(f"{name}.usda")
    return bodies


def attributes(scene, kind=Sdf.ValueTypeNames.Token, to="thick"):
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    model = stage.GetPrimAtPath("/Coat/model")
    for key, name in (("from", "thin"), ("to", to)):
        model.CreateAttribute(f"tailor:fit:{key}", kind).Set(f"{name}.usda")
    stage.Save()


@pytest.mark.parametrize("kind", [Sdf.ValueTypeNames.Token, Sdf.ValueTypeNames.String, Sdf.ValueTypeNames.Asset], ids=str)
def test_a_build_of_a_fitted_output_fits_it_once(kind, usdtailor, scene):
    attributes(scene, kind)
    (scene / "far").mkdir()
    build(usdtailor, scene / "coat.usda", scene / "far/one.usda")
    assert run(usdtailor, "check", scene / "far/one.usda").returncode == 0, "its bodies are beside the layer that names them"
    build(usdtailor, scene / "far/one.usda", scene / "two.usda")
    one, two = (Usd.Stage.Open(str(scene / name)) for name in ("far/one.usda", "two.usda"))
    for name in ("model", "sim", "render"):
        assert np.abs(points(one, f"/Coat/{name}") - points(two, f"/Coat/{name}")).max() < 1e-5, name


def test_an_output_knows_its_bodies_from_any_folder(usdtailor, scene, monkeypatch):
    monkeypatch.chdir(scene)
    for folder in ("a", "b"):
        (scene / folder).mkdir()
    build(usdtailor, "coat.usda", "a/out.usda", "--set", "fit.from=thin.usda", "--set", "fit.to=thick.usda")
    monkeypatch.chdir(scene / "b")
    # Other bodies have these names here.
    shutil.copy(scene / "thick.usda", "thin.usda")
    shutil.copy(scene / "thin.usda", "thick.usda")
    done = run(usdtailor, "check", "../a/out.usda")
    assert done.returncode == 0 and "fresh" in done.stdout, done.stderr
    again = build(usdtailor, "../coat.usda", "../a/out.usda", "--skip-fresh", "--set", "fit.from=../thin.usda", "--set", "fit.to=../thick.usda")
    assert "fresh" in again.stdout


def test_new_points_in_a_variant_are_refused(usdtailor, scene):
    attributes(scene)
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    body_variants(stage, Sdf.ValueTypeNames.Token)
    stage.GetPrimAtPath("/Coat/model").RemoveProperty("tailor:fit:to")
    stage.Save()
    done = run(usdtailor, "build", scene / "coat.usda", "-o", scene / "out.usda", "--variants", "body", *QUICK)
    assert done.returncode != 0 and "--variant-set" in done.stderr and not (scene / "out.usda").exists(), done.stderr


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"to": "thick.usda"}, "fit.from: it names no body"),
        ({"from": "thin.usda", "to": "gone.usda"}, "fit.to: cannot read"),
        ({"from": "thin.usda", "to": "coat.usda"}, "other faces"),
        ({"from": "thin.usda", "to": "thick.usda", "rigid": "nope"}, "fit.rigid"),
        ({"from": "thin.usda", "to": "thick.usda", "rigid": "borders - borders"}, "has no elements"),
    ],
    ids=["no first", "gone", "other faces", "no set", "empty set"],
)
def test_bad_bodies_are_named(settings, words, usdtailor, scene):
    args = [f"fit.{key}={scene / value if value.endswith('usda') else value}" for key, value in settings.items()]
    done = run(usdtailor, "build", scene / "coat.usda", "-o", scene / "out.usda", *(w for arg in args for w in ("--set", arg)))
    assert done.returncode == 1 and words in done.stderr and "hint:" in done.stderr, done.stderr
    assert not (scene / "out.usda").exists()


@needs_plugin
@pytest.mark.parametrize("kind", [Sdf.ValueTypeNames.Token, Sdf.ValueTypeNames.Asset], ids=str)
def test_a_payload_follows_its_body(kind, usdtailor, scene):
    coat = recipe(scene / "coat.tailor", "coat.usda", fit={"from": "thin.usda", "to": "thick.usda"})
    stage = Usd.Stage.CreateNew(str(scene / "shot.usda"))
    prim = holder(stage, coat)
    path = str(prim.GetPath())
    build(usdtailor, coat, scene / "built.usda")
    built = points(Usd.Stage.Open(str(scene / "built.usda")), "/Coat/sim")
    assert radii(points(stage, f"{path}/model")).mean() > 4.0
    assert radii(points(stage, f"{path}/sim")).mean() == pytest.approx(radii(built).mean(), rel=0.01)
    attribute = prim.CreateAttribute("tailor:fit:to", kind, custom=False)
    attribute.Set("thin.usda")
    for name in ("model", "sim", "render"):
        assert radii(points(stage, f"{path}/{name}")).mean() < 3.1, name
    attribute.Set("thick.usda")
    assert radii(points(stage, f"{path}/render")).mean() > 4.0


@needs_plugin
def test_levels_of_a_payload_are_variants(scene):
    coat = recipe(scene / "coat.tailor", "coat.usda", lod={"levels": 2})
    stage = Usd.Stage.CreateNew(str(scene / "shot.usda"))
    prim = holder(stage, coat)
    faces = {}
    for level in ("LOD0", "LOD1"):
        assert prim.GetVariantSet("LOD").SetVariantSelection(level)
        faces[level] = len(UsdGeom.Mesh(prim.GetChild(level)).GetFaceVertexCountsAttr().Get())
    assert faces["LOD0"] == 4 * faces["LOD1"]
