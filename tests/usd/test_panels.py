"""Panels that are sewn: a render mesh for each, and what a cache of the one simulation mesh moves."""

import json

import numpy as np
import pytest
from conftest import run
from panels import ARM, HEIGHT, WIDTH, add_belt, built, meshes, suit
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from sources import add_subset
from tailor_file import holder, needs_plugin, recipe

SIDES = ("front", "back")
PARTS = tuple(f"render_{side}" for side in SIDES)
RIDGE_AND_HEM = ("--set", "seam.side.edges=sewn", "--set", "seam.side.normalOffset=0.1", "--set", "fold.hem.faces=front", "--set", "fold.hem.thickness=0.1")


def add_logo(stage, front, back):
    """A face set on the front alone, and a crease that crosses it."""
    add_subset(front, name="logo", indices=range(5), family="")
    front.CreateCreaseIndicesAttr([20, 21, 22])
    front.CreateCreaseLengthsAttr([3])
    front.CreateCreaseSharpnessesAttr([2.0])


def corner_points(mesh):
    return mesh.points[mesh.indices]


def rounded(rows):
    return sorted(map(tuple, np.asarray(rows, float).round(4).tolist()))


@pytest.mark.parametrize("options", [(), RIDGE_AND_HEM], ids=["plain", "seam and hem"])
def test_the_render_meshes_of_panels_are_the_render_mesh_in_parts(usdtailor, suit, tmp_path, options):
    source, one, parts = suit(add_logo), tmp_path / "one.usda", tmp_path / "parts.usda"
    # With one level, the creases are still sharp.
    built(usdtailor, source, one, "--all", "--set", "render.level=1", *options)
    built(usdtailor, source, parts, "--all", "--render-per-panel", "--set", "render.level=1", *options)
    (whole,), (front, back) = meshes(one, "render"), meshes(parts, *PARTS)
    assert len(front.counts) + len(back.counts) == len(whole.counts) and len(front.counts) and len(back.counts)
    # Each corner of each face keeps its place and its UVs.
    uvs = [m.primvars["st"].flat for m in (whole, front, back)]
    rows = [np.hstack([corner_points(m), uv.reshape(len(m.indices), -1)]) for m, uv in zip((whole, front, back), uvs)]
    assert rounded(rows[0]) == rounded(np.vstack(rows[1:]))
    assert np.array_equal(np.unique(whole.points, axis=0), np.unique(np.vstack([front.points, back.points]), axis=0))
    # Along the seam both have the same points, bit for bit; the inner layer of a hem has the set too, and ends there.
    shared = {tuple(p) for p in front.points.tolist()} & {tuple(p) for p in back.points.tolist()}
    seam = {tuple(p) for p in whole.points[np.unique(whole.subsets["sewn"].pairs)].tolist()}
    assert seam <= shared if not options else len(seam & shared) > ARM
    for mesh, other in ((front, "back"), (back, "front")):
        assert other not in mesh.subsets and len(mesh.subsets["sewn"].pairs)
    assert "logo" in front.subsets and "logo" not in back.subsets
    assert sum(map(len, front.creases)) > 0 and not back.creases
    # The simulation mesh is that of the whole garment.
    (sim,), (expected,) = meshes(parts, "sim"), meshes(one, "sim")
    assert np.array_equal(sim.points, expected.points)
    assert not Usd.Stage.Open(str(parts)).GetPrimAtPath("/Suit/render")


def test_render_meshes_of_panels_are_told_and_recorded(usdtailor, suit, tmp_path):
    source, out, report = suit(add_belt), tmp_path / "out.usda", tmp_path / "report.json"
    planned = run(usdtailor, "build", source, "-o", out, "--all", "--render-per-panel", "--dry-run").stdout
    assert "front_render_front and front_render_back" in planned and "belt_render;" not in planned and "belt_render" in planned
    done = run(usdtailor, "build", source, "-o", out, "--all", "--render-per-panel", "--report", report)
    assert done.returncode == 0 and "front_render_front: " in done.stdout, done.stderr
    shirt, belt = json.loads(report.read_text())["garments"]
    assert shirt["names"] == ["front_sim", "front_render_front", "front_render_back"] and belt["names"] == ["belt_sim", "belt_render"]
    assert sum(panel["faces"] for panel in shirt["renderPanels"]) == shirt["render"]["faces"] and belt["renderPanels"] == []
    again = run(usdtailor, "build", source, "-o", out, "--all", "--skip-fresh", "--force")
    assert "triangles" in again.stdout, "an output with other meshes is not fresh"
    fresh = run(usdtailor, "build", source, "-o", out, "--all", "--skip-fresh", "--force")
    assert "fresh" in fresh.stdout


def test_threads_do_not_change_the_render_meshes_of_panels(usdtailor, suit, tmp_path):
    source, texts = suit(), []
    for threads in (1, 2):
        (tmp_path / str(threads)).mkdir()
        out = tmp_path / str(threads) / "out.usda"
        built(usdtailor, source, out, "--all", "--render-per-panel", *RIDGE_AND_HEM, "--threads", threads)
        texts.append(out.read_bytes())
    assert texts[0] == texts[1]


# A cache that bends the whole shirt about the vertical axis and shifts it.
FRAMES = 3


def bend(points, amount):
    turn = amount * 0.1 * points[:, 1]
    cos, sin = np.cos(turn), np.sin(turn)
    x, y, z = points.T
    return np.stack([cos * x - sin * z, y + 3 * amount, sin * x + cos * z], axis=1)


@pytest.fixture
def shirt(usdtailor, suit, tmp_path):
    out = tmp_path / "shirt.usdc"
    built(usdtailor, suit(), out, "--all", "--render-per-panel", "--set", "sim.maxEdgeLength=0.6")
    return out


def points_of(stage, path, time=None):
    return np.array(stage.GetPrimAtPath(path).GetAttribute("points").Get(Usd.TimeCode.Default() if time is None else time), float)


@pytest.fixture
def cache(shirt, tmp_path):
    rest = points_of(Usd.Stage.Open(str(shirt)), "/Suit/sim")
    path = tmp_path / "cache.npz"
    np.savez(path, points=np.stack([bend(rest, i / (FRAMES - 1)) for i in range(FRAMES)]).astype(np.float32))
    return path


def in_shirt(stage, path, points):
    """Points of a prim in the space of the shirt."""
    matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).GetLocalTransformation()
    return np.array([matrix.Transform(Gf.Vec3d(*map(float, p))) for p in points])


def drive(usdtailor, shirt, cache, out, *args):
    return run(usdtailor, "drive", shirt, "--cache", cache, "-o", out, *args)


@pytest.mark.parametrize("clips", [(), ("--clips",)], ids=["samples", "clips"])
def test_a_cache_moves_all_panels_each_in_its_own_space(usdtailor, shirt, cache, tmp_path, clips):
    out = tmp_path / "shot.usdc"
    done = drive(usdtailor, shirt, cache, out, "--model", *clips)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(out))
    times = stage.GetPrimAtPath("/Suit/render_front").GetAttribute("points").GetTimeSamples()
    assert len(times) == FRAMES
    moved = {}
    for path in [f"/Suit/{name}" for name in (*PARTS, *SIDES)]:
        rest = in_shirt(stage, path, points_of(Usd.Stage.Open(str(shirt)), path))
        first, last = (in_shirt(stage, path, points_of(stage, path, time)) for time in (times[0], times[-1]))
        assert np.abs(first - rest).max() < 1e-4, path
        assert np.linalg.norm(last - rest, axis=1).max() > 2.5
        assert np.percentile(np.linalg.norm(last - bend(rest, 1.0), axis=1), 95) < 0.2, path
        moved[path] = (rest, last)
    # Points that both render meshes have along the seam stay together.
    (rest_a, a), (rest_b, b) = (moved[f"/Suit/{name}"] for name in PARTS)
    pairs = [(i, j) for i, p in enumerate(rest_a) for j in np.flatnonzero(np.abs(rest_b - p).max(axis=1) == 0)]
    assert len(pairs) > ARM
    assert max(np.abs(a[i] - b[j]).max() for i, j in pairs) < 1e-5


def test_velocities_and_normals_of_panels_are_in_their_own_space(usdtailor, suit, tmp_path):
    def finish(stage, *panels):
        for panel in panels:
            panel.CreateSubdivisionSchemeAttr("none")
            count = len(panel.GetPointsAttr().Get())
            panel.CreateNormalsAttr([Gf.Vec3f(0, 0, 1)] * count)
            panel.SetNormalsInterpolation("vertex")

    out, cache, shot = tmp_path / "shirt.usdc", tmp_path / "cache.usda", tmp_path / "shot.usdc"
    built(usdtailor, suit(finish), out, "--all")
    source = Usd.Stage.Open(str(out))
    stage = Usd.Stage.CreateNew(str(cache))
    sim, rest = UsdGeom.Mesh.Define(stage, "/Suit/sim"), points_of(source, "/Suit/sim")
    # A quarter turn about x within a second, and a shift along y at 2 units a second.
    turned = np.stack([rest[:, 0], -rest[:, 2], rest[:, 1]], axis=1)
    for time, points in ((1, rest), (2, turned)):
        sim.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), time)
        sim.GetVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(np.tile(np.float32([0, 2, 0]), (len(rest), 1))), time)
    stage.GetRootLayer().Save()
    assert drive(usdtailor, out, cache, shot, "--model").returncode == 0
    stage = Usd.Stage.Open(str(shot))
    for side in SIDES:
        prim = stage.GetPrimAtPath(f"/Suit/{side}")
        matrix = UsdGeom.Xformable(prim).GetLocalTransformation()
        velocities, normals = (np.array(prim.GetAttribute(name).Get(2), float) for name in ("velocities", "normals"))
        assert np.allclose([matrix.TransformDir(Gf.Vec3d(*v)) for v in velocities], [0, 2, 0], atol=1e-3)
        before = matrix.TransformDir(Gf.Vec3d(0, 0, 1))
        after = (before[0], -before[2], before[1])
        assert np.allclose([matrix.TransformDir(Gf.Vec3d(*n)) for n in normals], after, atol=1e-3)


def test_one_mesh_or_all_of_a_simulation_mesh_are_driven(usdtailor, shirt, cache, tmp_path):
    for prim, expected in (("/Suit/render_back", {"render_back"}), ("/Suit/sim", set(PARTS)), (None, set(PARTS))):
        out = tmp_path / f"shot{len(expected)}{prim is None}.usda"
        assert drive(usdtailor, shirt, cache, out, *(("--prim", prim) if prim else ())).returncode == 0
        layer = Sdf.Layer.FindOrOpen(str(out))
        driven = set(layer.GetPrimAtPath("/Suit").nameChildren.keys())
        assert driven == expected


def test_a_cache_is_of_one_of_several_garments(usdtailor, suit, tmp_path, cache):
    both, out = tmp_path / "both.usdc", tmp_path / "shot.usda"
    built(usdtailor, suit(add_belt, name="both_in.usda"), both, "--all", "--set", "sim.maxEdgeLength=0.6")
    refused = drive(usdtailor, both, cache, out)
    assert refused.returncode == 1 and not out.exists()
    assert "--prim: /Suit/front_sim, /Suit/belt_sim" in refused.stderr
    assert drive(usdtailor, both, cache, out, "--prim", "/Suit/front_sim").returncode == 0


def test_panels_with_other_points_than_at_the_build_are_stale(usdtailor, suit, shirt, cache, tmp_path):
    stage, out = Usd.Stage.Open(str(tmp_path / "suit.usda")), tmp_path / "shot.usda"
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Suit/back"))
    mesh.GetPointsAttr().Set([*mesh.GetPointsAttr().Get(), Gf.Vec3f(0)])
    stage.Save()
    refused = drive(usdtailor, shirt, cache, out, "--model")
    count = 2 * (WIDTH + 1) * (HEIGHT + 1)
    assert refused.returncode == 1 and not out.exists()
    assert f"has places for {count} points of its model, not {count + 1}" in refused.stderr


@needs_plugin
def test_a_tailor_file_of_sewn_panels_is_a_payload(suit, tmp_path):
    suit()
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    prim = holder(stage, recipe(tmp_path / "suit.tailor", "suit.usda", prim="/Suit"))
    for name in ("sim", "render"):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(prim.GetPath().AppendChild(name)))
        assert {subset.GetPrim().GetName() for subset in UsdGeom.Subset.GetAllGeomSubsets(mesh)} >= {*SIDES, "sewn"}
