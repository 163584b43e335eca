"""`usdtailor fit`: garments on other bodies."""

import json
import math
import re

import numpy as np
import pytest
from conftest import run
from fitting import Triangles, crossings, fit, radii, tube, write_tube
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import add_subset, define

AROUND = 24


@pytest.fixture
def sleeve(tmp_path):
    """A sleeve on an arm, and arms that it is to fit: `sleeve(finish)` writes them; `finish` gets the sleeve."""

    def sleeve(finish=None):
        return {
            "sleeve": write_tube(tmp_path / "sleeve.usda", tube(1.2, 4, AROUND, 10)[0], finish=finish),
            "arm": write_tube(tmp_path / "arm.usda", *tube(1, 8, 20, 24)),
            "thick": write_tube(tmp_path / "thick.usda", *tube(1.5, 8, 20, 24, bulge=0.4)),
            "plump": write_tube(tmp_path / "plump.usda", *tube(1.12, 8, 20, 24)),
            "long": write_tube(tmp_path / "long.usda", *tube(1, 12, 20, 24)),
            "other": write_tube(tmp_path / "other.usda", *tube(1.5, 8, 30, 37, bulge=0.4)),
        }

    return sleeve


def test_a_sleeve_grows_with_the_arm_and_keeps_its_ease(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "out.usda"
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out)
    fitted = Triangles(out)
    _, own = crossings(fitted, Triangles(paths["thick"]))
    assert not crossings(fitted, Triangles(paths["thick"]))[0] and not own
    arm = 1.5 + 0.4 * np.sin(np.pi * (fitted.points[:, 1] / 8 + 0.5))
    assert (radii(fitted.points) > arm).all()
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--force")
    assert done.stdout.count("0 before, 0 after, 0 new") == 2, done.stdout
    # Between the ease that it had and that of the larger arm.
    assert 0.2 <= np.median(radii(fitted.points) - arm) < 0.2 * 1.9
    assert abs(np.ptp(fitted.points[:, 1]) - 4) < 0.3


def test_a_sleeve_of_a_longer_arm_is_longer_and_as_wide(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "out.usda"
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["long"], "-o", out)
    fitted = Triangles(out)
    assert abs(np.ptp(fitted.points[:, 1]) - 6) < 0.2 and abs(radii(fitted.points) - 1.2).max() < 0.1


def test_bodies_of_other_faces_correspond_by_their_uvs(usdtailor, sleeve, tmp_path):
    paths = sleeve()
    for name in ("thick", "other"):
        fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths[name], "-o", tmp_path / f"{name}_out.usda")
    same, other = (Triangles(tmp_path / f"{name}_out.usda").points for name in ("thick", "other"))
    assert abs(same - other).max() < 0.05
    assert not crossings(Triangles(tmp_path / "other_out.usda"), Triangles(paths["other"]))[0]


def test_pairs_of_points_stand_in_for_common_faces(usdtailor, sleeve, tmp_path):
    paths, out, pairs = sleeve(), tmp_path / "out.usda", tmp_path / "pairs.txt"
    bare = write_tube(tmp_path / "bare.usda", tube(1.5, 8, 30, 37, bulge=0.4)[0])
    lines = ["# arm, then the thicker arm"]
    for y in np.linspace(-4, 4, 9):
        for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
            sides = [(r * math.sin(angle), y, r * math.cos(angle)) for r in (1, 1.5 + 0.4 * math.sin(math.pi * (y / 8 + 0.5)))]
            lines.append(" ".join(f"{v:.6f}" for v in (*sides[0], *sides[1])))
    pairs.write_text("\n".join(lines))
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", bare, "--pairs", pairs, "-o", out)
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "same.usda")
    fitted = Triangles(out)
    assert not crossings(fitted, Triangles(bare))[0] and abs(fitted.points - Triangles(tmp_path / "same.usda").points).max() < 0.1
    for text, words, code in (("1 2 3 4 5", "line 1 has not six numbers", 2), ("1 0 0 1.5 0 0\n" * 3, "3 pairs", 1), ("1 0 0 1.5 0 0\n" * 9, "one plane", 1), ("1 0 0 1.5 90 0\n" * 9, "second points are not at", 1)):
        pairs.write_text(text)
        done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", bare, "--pairs", pairs, "-o", tmp_path / "bad.usda", code=code)
        assert words in done.stderr and not (tmp_path / "bad.usda").exists(), done.stderr


def test_a_hem_keeps_its_length_and_buttons_their_shape(usdtailor, sleeve, tmp_path):
    def sets(mesh):
        hem = [v for i in range(AROUND) for v in (i, (i + 1) % AROUND)]
        add_subset(mesh, name="hem", element="edge", family="edges", indices=hem)
        add_subset(mesh, name="buttons", element="face", indices=[5 * AROUND, 5 * AROUND + 1, 7 * AROUND + 9, 8 * AROUND + 9])

    paths, out, report = sleeve(sets), tmp_path / "out.usda", tmp_path / "report.json"
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["plump"], "-o", out, "--keep-length", "hem", "--rigid", "buttons", "--report", report)
    before, after = Triangles(paths["sleeve"]), Triangles(out)
    for corners in ([0, 1, 2, 25, 26, 24], [9, 10, 34, 33, 57, 58]):
        button = np.array(corners) + (5 if corners[0] == 0 else 7) * AROUND
        gaps = [np.linalg.norm(m.points[button][:, None] - m.points[button][None], axis=2) for m in (before, after)]
        assert abs(gaps[0] - gaps[1]).max() < 1e-5
    (figures,) = json.loads(report.read_text())["garments"]
    lengths = {entry["name"]: entry for entry in figures["sets"]}
    assert lengths["hem"]["body"] > 1.1 and abs(lengths["hem"]["length"] - 1) < 0.02, lengths
    assert abs(lengths["buttons"]["length"] - 1) < 1e-4


def test_ease_is_added_in_any_unit(usdtailor, sleeve, tmp_path):
    paths, mean = sleeve(), {}
    for ease in ("0", "0.2", "2mm"):
        out = tmp_path / f"{ease}.usda"
        fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--set", f"fit.ease={ease}")
        assert not crossings(Triangles(out), Triangles(paths["thick"]))[0]
        mean[ease] = np.linalg.norm(Triangles(out).points[:, [0, 2]], axis=1).mean()
    unit = UsdGeom.GetStageMetersPerUnit(Usd.Stage.Open(str(paths["sleeve"])))
    assert abs(mean["0.2"] - mean["0"] - 0.2) < 0.04, mean
    assert abs(mean["2mm"] - mean["0"] - 0.002 / unit) < 0.2 * 0.002 / unit, (mean, unit)
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "bad.usda", "--set", "fit.ease=-1", code=1)
    assert "fit.ease" in done.stderr and not (tmp_path / "bad.usda").exists(), done.stderr


def test_units_axes_and_transforms_of_bodies_are_taken_over(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), {name: tmp_path / f"{name}.usda" for name in ("plain", "turned")}
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out["plain"])
    for name in ("arm", "thick"):
        shape, uvs = tube(*((1, 8, 20, 24) if name == "arm" else (1.5, 8, 20, 24, 0.4)))
        shape[0][:] = np.stack([shape[0][:, 0], -shape[0][:, 2], shape[0][:, 1]], axis=1) / 10 - (0, 0, 3)
        moved = lambda mesh: UsdGeom.Xformable(mesh).AddTranslateOp().Set((0, 0, 3))  # noqa: E731
        write_tube(tmp_path / f"{name}_z.usda", shape, uvs, up="Z", unit=0.1, finish=moved)
    fit(usdtailor, paths["sleeve"], "--from", tmp_path / "arm_z.usda", "--to", tmp_path / "thick_z.usda", "-o", out["turned"])
    assert abs(Triangles(out["plain"]).points - Triangles(out["turned"]).points).max() < 0.01


def test_the_layer_is_a_garment_with_new_points_alone(usdtailor, sleeve, tmp_path):
    def finish(mesh):
        mesh.CreateNormalsAttr([(0, 0, 1)] * (11 * AROUND))
        add_subset(mesh, name="front", element="face", indices=list(range(10)))

    paths, out = sleeve(finish), tmp_path / "out.usda"
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out)
    layer = Sdf.Layer.FindOrOpen(str(out))
    assert {p.name for p in layer.GetPrimAtPath("/Coat/model").properties} == {"points", "extent", "normals", "primvars:tailor:fitFrom"}
    fitted = Triangles(out)
    mesh = fitted.mesh
    assert mesh.GetNormalsAttr().Get() is None and UsdGeom.Subset(mesh.GetPrim().GetChild("front")).GetIndicesAttr().Get() == list(range(10))
    assert np.allclose(mesh.GetExtentAttr().Get(), UsdGeom.Mesh.ComputeExtent(mesh.GetPointsAttr().Get()))
    built = run(usdtailor, "build", out, "-o", tmp_path / "built.usda")
    assert built.returncode == 0, built.stderr
    assert radii(Triangles(tmp_path / "built.usda", "/Coat/sim").points).min() > 1.5


def test_panels_rest_graded_to_the_other_body_also_after_two_fits(usdtailor, tmp_path):
    def patterned(mesh):
        # The sleeve cut open and laid flat to scale.
        uvs = tube(1.2, 4, AROUND, 10)[1] * (2 * AROUND * 1.2 * math.sin(math.pi / AROUND), 4)
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying").Set([Gf.Vec2f(*map(float, uv)) for uv in uvs])

    source = write_tube(tmp_path / "pattern.usda", tube(1.2, 4, AROUND, 10)[0], finish=patterned)
    arms = [write_tube(tmp_path / f"arm{i}.usda", *tube(r, h, 20, 24)) for i, (r, h) in enumerate(((1, 8), (1.5, 8), (1.5, 12)))]
    outs = [tmp_path / "wide.usda", tmp_path / "long.usda"]
    for garment, body, to, out in ((source, arms[0], arms[1], outs[0]), (outs[0], arms[1], arms[2], outs[1])):
        fit(usdtailor, garment, "--from", body, "--to", to, "-o", out)
    for out in outs:
        built = tmp_path / f"{out.stem}_built.usda"
        done = run(usdtailor, "build", out, "-o", built)
        assert "rests as 1 flat panels" in done.stdout, done.stdout + done.stderr
        stage = Usd.Stage.Open(str(built))
        sim = stage.GetPrimAtPath("/Coat/sim")
        rest = np.array(sim.GetAttribute("physics:restShapePoints").Get())
        fitted = Triangles(out)
        girth = 2 * math.pi * np.median(radii(fitted.points))
        assert abs(np.ptp(rest[:, 0]) / girth - 1) < 0.04 and abs(np.ptp(rest[:, 1]) / np.ptp(fitted.points[:, 1]) - 1) < 0.04


def test_what_stays_behind_is_told(usdtailor, sleeve, tmp_path):
    def finish(mesh):
        points = mesh.GetPointsAttr().Get()
        for time in (1, 2, 3):
            mesh.GetPointsAttr().Set(points, time)
        UsdGeom.Sphere.Define(mesh.GetPrim().GetStage(), "/Coat/button")
        mesh.GetPrim().CreateAttribute("tailor:trim:buttons:prims", Sdf.ValueTypeNames.TokenArray).Set(["button"])

    paths = sleeve(finish)
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "out.usda")
    assert "/Coat/button: not carried: it is a Sphere" in done.stderr and "over 3 times: not carried: the fitted points have one time" in done.stderr and "the model keeps it" not in done.stderr, done.stderr


def test_a_garment_that_cannot_follow_is_told_in_time(usdtailor, sleeve, tmp_path):
    whole = lambda mesh: add_subset(mesh, name="whole", element="face", indices=list(range(10 * AROUND)))  # noqa: E731
    paths, out = sleeve(whole), tmp_path / "out.usda"
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--rigid", "whole")
    assert "fit-" in done.stderr, done.stderr
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "strict.usda", "--rigid", "whole", "--strict", code=1)
    assert not (tmp_path / "strict.usda").exists()
    # Two layers at one place, which cross each other wherever they move.
    (points, counts, quads), _ = tube(1.2, 4, AROUND, 10)
    twice = write_tube(tmp_path / "twice.usda", (np.concatenate([points, points]), np.tile(counts, 2), np.concatenate([quads, quads + len(points)])))
    fit(usdtailor, twice, "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--force")
    assert radii(Triangles(out).points).min() > 1.5


def test_mirrored_and_left_handed_bodies_are_not_inside_out(usdtailor, sleeve, tmp_path):
    paths = sleeve()
    for name, finish in (("left", lambda mesh: mesh.CreateOrientationAttr("leftHanded")), ("mirrored", lambda mesh: UsdGeom.Xformable(mesh).AddScaleOp().Set((-1, 1, 1)))):
        bodies = []
        for body, radius in (("arm", 1), ("thick", 1.5)):
            shape, uvs = tube(radius, 8, 20, 24)
            if name == "left":
                shape = (shape[0], shape[1], shape[2].reshape(-1, 4)[:, ::-1].ravel())
            bodies.append(write_tube(tmp_path / f"{name}_{body}.usda", shape, uvs, finish=finish))
        fit(usdtailor, paths["sleeve"], "--from", bodies[0], "--to", bodies[1], "-o", tmp_path / f"{name}.usda", "--strict")


def test_points_are_read_and_written_at_the_time_that_is_given(usdtailor, sleeve, tmp_path):
    def finish(mesh):
        points = np.array(mesh.GetPointsAttr().Get())
        mesh.GetPointsAttr().Clear()
        for time in (1, 2):
            mesh.GetPointsAttr().Set((points + (0, time - 1, 0)).astype(np.float32), time)

    paths, out = sleeve(finish), tmp_path / "out.usda"
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["plump"], "-o", out, "--time", 2)
    assert abs(Triangles(out).points[:, 1].mean() - 1) < 0.05


def test_panels_that_are_sewn_stay_together(usdtailor, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "sewn.usda"))
    UsdGeom.SetStageUpAxis(stage, "Y")
    (points, _, quads), _ = tube(1.2, 4, AROUND, 10)
    quads = quads.reshape(-1, 4)
    for name, half, lift in (("front", quads[quads[:, 0] % AROUND < AROUND // 2], 0), ("back", quads[quads[:, 0] % AROUND >= AROUND // 2], 5)):
        used, corners = np.unique(half, return_inverse=True)
        mesh = define(stage, f"/Coat/{name}", (points[used] - (0, lift, 0), np.full(len(half), 4), corners.ravel()))
        UsdGeom.Xformable(mesh).AddTranslateOp().Set((0, lift, 0))
    stage.Save()
    arms = [write_tube(tmp_path / f"{name}.usda", *tube(r, 8, 20, 24)) for name, r in (("arm", 1), ("thick", 1.5))]
    out = tmp_path / "out.usda"
    fit(usdtailor, tmp_path / "sewn.usda", "--all", "--from", arms[0], "--to", arms[1], "-o", out)
    halves = [Triangles(out, f"/Coat/{name}").points + (0, lift, 0) for name, lift in (("front", 0), ("back", 5))]
    gaps = np.linalg.norm(halves[0][:, None] - halves[1][None], axis=2).min(axis=1)
    assert (gaps < 1e-5).sum() == 22 and radii(np.concatenate(halves)).min() > 1.5


def test_outputs_are_the_same_at_any_number_of_threads(usdtailor, sleeve, tmp_path):
    paths, outs = sleeve(), [tmp_path / f"{n}.usda" for n in (1, 3)]
    for n, out in zip((1, 3), outs, strict=True):
        fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--threads", n)
    assert outs[0].read_bytes() == outs[1].read_bytes()


def test_what_is_wrong_with_bodies_is_told_and_nothing_is_written(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "out.usda"
    bare = write_tube(tmp_path / "bare.usda", tube(1.5, 8, 30, 37)[0])
    elsewhere = write_tube(tmp_path / "elsewhere.usda", tube(1.5, 8, 30, 37)[0], tube(1.5, 8, 30, 37)[1] + 3)
    broken = write_tube(tmp_path / "broken.usda", tube(math.nan, 8, 20, 24)[0])
    several = write_tube(tmp_path / "several.usda", *tube(1.5, 8, 20, 24), finish=lambda mesh: define(mesh.GetPrim().GetStage(), "/Coat/eyes", tube(0.1, 1, 8, 2)[0]))
    for body, words in ((bare, "bare.usda /Coat/model: it has other faces than"), (several, "--body-prim"), (bare, "no UV set in common"), (elsewhere, "are on no face"), (broken, "not finite"), (tmp_path / "none.usda", "none.usda")):
        done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", body, "-o", out, code=1)
        assert words in done.stderr and not out.exists(), done.stderr
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--rigid", "buttons", code=1)
    assert "buttons" in done.stderr and not out.exists()
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", paths["sleeve"], "--force", code=1)
    assert "input" in done.stderr
    for body in ("arm", "thick"):
        before = paths[body].read_bytes()
        done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", paths[body], "--force", code=1)
        assert "is a body" in done.stderr and paths[body].read_bytes() == before
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "out.usdz", code=1)
    assert "package" in done.stderr and not (tmp_path / "out.usdz").exists()


def test_a_garment_that_is_not_on_its_body_is_told(usdtailor, sleeve, tmp_path):
    far = write_tube(tmp_path / "far.usda", tube(1.2, 4, AROUND, 10)[0], finish=lambda mesh: UsdGeom.Xformable(mesh).AddTranslateOp().Set((40, 0, 0)))
    inside = write_tube(tmp_path / "inside.usda", tube(0.8, 4, AROUND, 10)[0])
    beside = write_tube(tmp_path / "beside.usda", tube(1.2, 4, AROUND, 10)[0], finish=lambda mesh: UsdGeom.Xformable(mesh).AddTranslateOp().Set((2.5, 0, 0)))
    large = write_tube(tmp_path / "large.usda", tube(1.8, 6, AROUND, 10)[0])
    for source, words in ((far, "away from the body"), (inside, "inside the body"), (beside, "away from the body"), (large, "away from the body")):
        paths, out = sleeve(), tmp_path / "out.usda"
        done = fit(usdtailor, source, "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--force")
        assert "off-body" in done.stderr and words in done.stderr, done.stderr
        out.unlink()
        fit(usdtailor, source, "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--strict", code=1)
        assert not out.exists()


def test_a_body_may_have_holes(usdtailor, sleeve, tmp_path):
    holes = {}
    for name, radius in (("arm", 1), ("thick", 1.5)):
        (points, counts, quads), _ = tube(radius, 8, 20, 24)
        kept = np.delete(quads.reshape(-1, 4), [105, 106, 230, 333], axis=0)
        holes[name] = write_tube(tmp_path / f"{name}_holes.usda", (points, counts[: len(kept)], kept.ravel()))
    out = tmp_path / "out.usda"
    fit(usdtailor, sleeve()["sleeve"], "--from", holes["arm"], "--to", holes["thick"], "-o", out, "--strict")
    assert radii(Triangles(out).points).min() > 1.5


def test_bodies_may_be_variants_of_one_layer_and_are_built_so(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "bodies.usda"
    args = [paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["long"], "-o", out, "--variant-set", "body"]
    fit(usdtailor, *args)
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["long"], "-o", tmp_path / "apart")
    stage = Usd.Stage.Open(str(out))
    variants = stage.GetPrimAtPath("/Coat").GetVariantSet("body")
    assert not stage.GetCompositionErrors() and sorted(variants.GetVariantNames()) == ["arm", "long", "thick"] and variants.GetVariantSelection() == "arm"
    for name, path in (("arm", paths["sleeve"]), ("thick", tmp_path / "apart/sleeve_thick.usdc"), ("long", tmp_path / "apart/sleeve_long.usdc")):
        variants.SetVariantSelection(name)
        assert np.array_equal(UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/model")).GetPointsAttr().Get(), Triangles(path).points.astype(np.float32))
    assert ": fresh" in fit(usdtailor, *args, "--skip-fresh", "--force").stdout
    built = run(usdtailor, "build", out, "-o", tmp_path / "built.usdc", "--variants", "body", "--set", "sim.maxEdgeLength=0.6")
    assert built.returncode == 0, built.stderr
    products = Usd.Stage.Open(str(tmp_path / "built.usdc"))
    widths = {}
    for name in ("arm", "thick", "long"):
        products.GetPrimAtPath("/Coat").GetVariantSet("body").SetVariantSelection(name)
        widths[name] = radii(np.array(UsdGeom.Mesh(products.GetPrimAtPath("/Coat/sim")).GetPointsAttr().Get())).min()
    assert widths["thick"] > 1.5 > 1.3 > widths["arm"]
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["thick"], "-o", tmp_path / "twice.usda", "--variant-set", "body", code=1)
    assert not (tmp_path / "twice.usda").exists() and "named thick" in done.stderr
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["arm"], "-o", tmp_path / "twice.usda", "--variant-set", "body", code=1)
    assert not (tmp_path / "twice.usda").exists() and "named arm" in done.stderr


def test_fresh_outputs_are_left_and_check_tells_stale_ones(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "made"
    args = [paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["long"], "-o", out, "--skip-fresh", "--force"]
    fit(usdtailor, *args)
    times = [path.stat().st_mtime_ns for path in sorted(out.iterdir())]
    assert fit(usdtailor, *args).stdout.count(": fresh") == 2
    assert [path.stat().st_mtime_ns for path in sorted(out.iterdir())] == times
    assert run(usdtailor, "check", out / "sleeve_thick.usdc").returncode == 0
    write_tube(paths["thick"], *tube(1.6, 8, 20, 24))
    stale = run(usdtailor, "check", out / "sleeve_thick.usdc")
    assert stale.returncode == 1 and "thick.usda has changed" in stale.stderr, stale.stderr + stale.stdout
    assert fit(usdtailor, *args).stdout.count(": fresh") == 1
    assert fit(usdtailor, *args, "--keep-length", "borders.lowest").stdout.count(": fresh") == 0


def test_fresh_outputs_have_the_warnings_of_their_fit(usdtailor, sleeve, tmp_path):
    far = write_tube(tmp_path / "far.usda", tube(1.2, 4, AROUND, 10)[0], finish=lambda mesh: UsdGeom.Xformable(mesh).AddTranslateOp().Set((90, 0, 0)))
    paths, out, report = sleeve(), tmp_path / "out.usda", tmp_path / "report.json"
    args = [far, "--from", paths["arm"], "--to", paths["thick"], "-o", out, "--skip-fresh", "--force", "--report", report]
    first, made = fit(usdtailor, *args), json.loads(report.read_text())
    again, fresh = fit(usdtailor, *args), json.loads(report.read_text())
    assert fresh["status"] == "fresh" and "off-body" in first.stderr and "off-body" in again.stderr
    codes = [warning["code"] for garment in made["garments"] for warning in garment["warnings"]]
    assert sorted(warning["code"] for warning in fresh["warnings"]) == sorted(codes)


def test_several_bodies_make_a_folder_and_a_bad_one_does_not_stop_the_others(usdtailor, sleeve, tmp_path):
    paths, out, report = sleeve(), tmp_path / "made/here", tmp_path / "report.json"
    bodies = [paths["thick"], tmp_path / "none.usda", paths["long"]]
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", *bodies, "-o", out, "--report", report, code=1)
    assert sorted(p.name for p in out.iterdir()) == ["sleeve_long.usdc", "sleeve_thick.usdc"] and "none.usda" in done.stderr
    assert [entry["status"] for entry in json.loads(report.read_text())["fits"]] == ["fitted", "failed", "fitted"]
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], paths["thick"], "-o", tmp_path / "twice", code=1)
    assert "two outputs" in done.stderr and not (tmp_path / "twice").exists()


def test_pairs_in_another_unit_or_axis_are_refused_with_the_likely_one(usdtailor, sleeve, tmp_path):
    paths, pairs, out = sleeve(), tmp_path / "pairs.txt", tmp_path / "out.usda"
    shape, _ = tube(1.5, 8, 30, 37)
    shape[0][:] = np.stack([shape[0][:, 0], -shape[0][:, 2], shape[0][:, 1]], axis=1) / 100
    metres = write_tube(tmp_path / "metres.usda", shape, up="Z", unit=1)
    for scale, turns, words in ((1, False, "a unit of 0.01 m and Y up"), (0.01, False, "a unit of 1 m and Y up"), (1, True, "a unit of 0.01 m and Z up"), (0.01, True, None)):
        lines = []
        for y in (-4, 0, 4):
            for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
                x, z = math.sin(angle), math.cos(angle)
                second = np.array((1.5 * x, -1.5 * z, y) if turns else (1.5 * x, y, 1.5 * z)) * scale
                lines.append(f"{x} {y} {z} {second[0]} {second[1]} {second[2]}")
        pairs.write_text("\n".join(lines))
        done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", metres, "--pairs", pairs, "-o", out, code=1 if words else 0)
        assert words is None or (f"they fit in {words}" in done.stderr and "metres.usda" in done.stderr and not out.exists()), done.stderr
    assert abs(np.median(radii(Triangles(out).points)) - 1.75) < 0.1


def shared_uvs(around, along):
    """UVs of a tube both halves of which, left and right, have the same."""
    uvs = tube(1, 1, around, along)[1]
    uvs[:, 0] = np.minimum(uvs[:, 0], 1 - uvs[:, 0])
    return uvs


def test_halves_that_share_their_uvs_stay_on_their_sides(usdtailor, sleeve, tmp_path):
    # Bodies of other faces, also where one has been turned about by 180 degrees.
    arm = write_tube(tmp_path / "shared_arm.usda", tube(1, 8, 20, 24)[0], shared_uvs(20, 24))
    shape = tube(1.5, 8, 30, 37)[0]
    paths, thick, out = sleeve(), write_tube(tmp_path / "shared_thick.usda", shape, shared_uvs(30, 37)), tmp_path / "out.usda"
    fit(usdtailor, paths["sleeve"], "--from", arm, "--to", thick, "-o", out, "--strict")
    fitted = Triangles(out)
    assert abs(radii(fitted.points) - 1.75).max() < 0.12 and not any(crossings(fitted, Triangles(thick)))
    shape[0][:, [0, 2]] *= -1
    turned = write_tube(tmp_path / "turned.usda", shape, shared_uvs(30, 37))
    done = fit(usdtailor, paths["sleeve"], "--from", arm, "--to", turned, "-o", tmp_path / "bad.usda", code=1)
    assert "would be flipped" in done.stderr and "turn both bodies the same way" in done.stderr and not (tmp_path / "bad.usda").exists(), done.stderr


def test_bodies_with_a_part_turned_over_are_told(usdtailor, sleeve, tmp_path):
    """A band of a tenth of the second body has its UVs upside down."""
    paths, (shape, uvs) = sleeve(), tube(1.5, 8, 30, 40)
    band = (uvs[:, 1] > 0.425) & (uvs[:, 1] < 0.575)
    mended = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", write_tube(tmp_path / "good.usda", shape, uvs), "-o", tmp_path / "good_out.usda")
    assert "bodies-folded" not in mended.stderr
    uvs[band, 1] = 1 - uvs[band, 1]
    folded = write_tube(tmp_path / "folded.usda", shape, uvs)
    report = tmp_path / "report.json"
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", folded, "-o", tmp_path / "out.usda", "--report", report)
    (told,) = [warning for warning in json.loads(report.read_text())["garments"][0]["warnings"] if warning["code"] == "bodies-folded"]
    assert told["severity"] == "quality" and "warning[bodies-folded]" in done.stderr
    share = int(re.search(r"(\d+) % of the second body is flipped", told["message"])[1])
    assert 7 <= share <= 16, told["message"]


@pytest.mark.parametrize("way", ["uvs", "pairs"])
def test_what_is_smaller_than_a_face_of_the_first_body_is_not_inside_the_cloth(usdtailor, tmp_path, way):
    # A belly on one side, between the vertices of a coarse arm.
    shape, uvs = tube(1, 8, 72, 90)
    bump = np.exp(-(((shape[0] - (0, 0.3, 1)) / 0.25) ** 2).sum(axis=1))
    shape[0][:] *= 1 + 0.6 * bump[:, None] * (1, 0, 1)
    coarse, fine = write_tube(tmp_path / "coarse.usda", *tube(1, 8, 8, 8)), write_tube(tmp_path / "fine.usda", shape, uvs)
    coat, out, report = write_tube(tmp_path / "coat.usda", tube(1.2, 4, 48, 20)[0]), tmp_path / "out.usda", tmp_path / "report.json"
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("\n".join(" ".join(f"{v:.5f}" for v in (*p, *p)) for p in tube(1, 8, 8, 4)[0][0]))
    fit(usdtailor, coat, "--from", coarse, "--to", fine, "-o", out, "--report", report, "--strict", *(["--pairs", pairs] if way == "pairs" else []))
    fitted, body = Triangles(out), Triangles(fine)
    assert not any(crossings(fitted, body)) and radii(fitted.points).max() > 1.6
    (figures,) = json.loads(report.read_text())["garments"]
    gaps = np.linalg.norm(fitted.points[:, None] - body.points[None], axis=2).min(axis=1)
    assert figures["bodyCrossings"] == {"before": 0, "after": 0, "new": 0} and abs(figures["distance"]["mean"][1] - gaps.mean()) < 0.02


def test_a_coarser_body_whose_faces_reach_out_of_hollows_holds_the_cloth(usdtailor, tmp_path):
    # An hourglass: the faces of the coarse one pass the waist of the fine one outside of cloth that is close to it.
    def hourglass(radius, around, along):
        (points, counts, quads), uvs = tube(radius, 8, around, along)
        points[:, [0, 2]] *= (1 - 0.4 * np.cos(np.pi * points[:, 1:2] / 8) ** 8)
        return (points, counts, quads), uvs

    fine, coarse = write_tube(tmp_path / "fine.usda", *hourglass(1, 60, 80)), write_tube(tmp_path / "coarse.usda", *hourglass(1.4, 24, 9))
    close = hourglass(1.06, 48, 60)[0]
    close[0][:, 1] *= 0.6
    close[0][:, [0, 2]] = 1.06 / np.hypot(close[0][:, 0], close[0][:, 2])[:, None] * close[0][:, [0, 2]] * (1 - 0.4 * np.cos(np.pi * close[0][:, 1:2] / 8) ** 8)
    coat, out = write_tube(tmp_path / "coat.usda", close), tmp_path / "out.usda"
    fit(usdtailor, coat, "--from", fine, "--to", coarse, "-o", out, "--strict")
    assert not crossings(Triangles(coat), Triangles(fine))[0] and not crossings(Triangles(out), Triangles(coarse))[0]


def test_points_without_faces_do_not_make_another_body(usdtailor, sleeve, tmp_path):
    paths, outs = sleeve(), [tmp_path / f"{n}.usda" for n in range(2)]
    (points, counts, quads), _ = tube(1.5, 8, 20, 24, bulge=0.4)
    extra = write_tube(tmp_path / "extra.usda", (np.concatenate([[(99, 99, 99)], points, [(0, 99, 0)]]), counts, quads + 1))
    for to, out in zip((paths["thick"], extra), outs, strict=True):
        fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", to, "-o", out, "--strict")
    assert np.array_equal(Triangles(outs[0]).points, Triangles(outs[1]).points)


def test_a_body_that_moves_is_read_at_the_time_that_is_given(usdtailor, sleeve, tmp_path):
    def moves(mesh):
        points = np.array(mesh.GetPointsAttr().Get())
        mesh.GetPointsAttr().Clear()
        for time in (1, 5):
            mesh.GetPointsAttr().Set((points * (1, time, 1)).astype(np.float32), time)

    paths, out = sleeve(), tmp_path / "out.usda"
    moving = write_tube(tmp_path / "moving.usda", *tube(1, 8, 20, 24), finish=moves)
    done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", moving, "-o", out, code=1)
    assert "--time" in done.stderr and not out.exists(), done.stderr
    fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", moving, "--time", 1.5, "-o", out)
    assert abs(np.ptp(Triangles(out).points[:, 1]) - 4 * 1.5) < 0.3


def test_a_body_inside_out_is_a_body(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "out.usda"
    for name, radius in (("arm", 1), ("thick", 1.5)):
        (points, counts, quads), uvs = tube(radius, 8, 20, 24)
        write_tube(tmp_path / f"{name}_flipped.usda", (points, counts, quads.reshape(-1, 4)[:, ::-1].ravel()))
    fit(usdtailor, paths["sleeve"], "--from", tmp_path / "arm_flipped.usda", "--to", tmp_path / "thick_flipped.usda", "-o", out, "--strict")
    fit(usdtailor, write_tube(tmp_path / "inside.usda", tube(0.8, 4, AROUND, 10)[0]), "--from", tmp_path / "arm_flipped.usda", "--to", tmp_path / "thick_flipped.usda", "-o", tmp_path / "bad.usda", "--strict", code=1)


def test_options_of_a_build_are_refused(usdtailor, sleeve, tmp_path):
    paths, out = sleeve(), tmp_path / "out.usda"
    for option in (["--lods", "3"], ["--physics", "omni"], ["--provenance"]):
        done = fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths["thick"], "-o", out, *option, code=2)
        assert f"{option[0]}: it sets up products" in done.stderr and "usdtailor build" in done.stderr and not out.exists(), done.stderr


def test_what_a_fit_leaves_on_the_garment_is_named(usdtailor, sleeve, tmp_path):
    # A pocket of the same file, a mesh beside the garment, a blend shape, and a transform of the bind pose.
    def finish(mesh):
        stage, prim = mesh.GetPrim().GetStage(), mesh.GetPrim()
        points = np.array(mesh.GetPointsAttr().Get())[[100, 101, 125, 124]] * (1.01, 1, 1.01)
        define(stage, "/Coat/pocket", (points, np.array([4]), np.arange(4)))
        define(stage, "/Coat/chair", (points + (3, 0, 0), np.array([4]), np.arange(4)))
        shape = stage.DefinePrim("/Coat/model/fat", "BlendShape")
        shape.CreateAttribute("offsets", Sdf.ValueTypeNames.Vector3fArray).Set([(0.1, 0, 0)] * len(mesh.GetPointsAttr().Get()))
        bind = prim.CreateAttribute("primvars:skel:geomBindTransform", Sdf.ValueTypeNames.Matrix4d)
        bind.Set(Gf.Matrix4d(2))

    paths, out = sleeve(finish), tmp_path / "out.usda"
    args = [paths["sleeve"], "--prim", "/Coat/model", "--from", paths["arm"], "--to", paths["plump"], "-o"]
    done = fit(usdtailor, *args, out)
    for words in ("/Coat/pocket: not carried: it lies on /Coat/model", "/Coat/model/fat: not carried: its offsets", "geomBindTransform: not carried"):
        assert words in done.stderr, done.stderr
    assert "chair" not in done.stderr
    fit(usdtailor, *args, tmp_path / "strict.usda", "--strict", code=1)
    assert not (tmp_path / "strict.usda").exists()
