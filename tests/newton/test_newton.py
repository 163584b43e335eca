"""Newton takes the simulation mesh unedited: particles, mass, gravity, the shape at rest, and a short drape that drives a shot."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

newton = pytest.importorskip("newton")
import warp as wp  # noqa: E402
from pxr import Usd, UsdGeom, Vt  # noqa: E402

wp.config.quiet = True
ROOT = Path(__file__).resolve().parents[2]
USDTAILOR = Path(os.environ.get("USDTAILOR", ROOT / "target/debug/usdtailor"))
DENSITY = {"cotton": 0.14, "denim": 0.36}


def build(source, out, *settings):
    command = [USDTAILOR, "build", source, "-o", out, "--force", "--quiet", "--set", "cloth.scene=true"]
    subprocess.run([str(word) for word in [*command, *(w for s in settings for w in ("--set", s))]], check=True)
    return out


def imported(file):
    """A model of the garment as its user makes it, and what Newton warned of."""
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = builder.add_usd(str(file), return_deformable_results=True)
    builder.color(include_bending=True)
    return builder.finalize(), found, [str(warning.message) for warning in caught]


def read(file, name):
    stage = Usd.Stage.Open(str(file))
    prim = next(p for p in stage.Traverse() if p.GetCustomDataByKey("tailor:product") == name)
    triangles = np.array(prim.GetAttribute("faceVertexIndices").Get())
    return np.array(prim.GetAttribute("points").Get(), float), triangles


@pytest.mark.parametrize("garment", ["tshirt", "coat", "trousers"])
def test_a_garment_is_taken_unedited(garment, tmp_path):
    file = build(ROOT / f"examples/{garment}.usda", tmp_path / "built.usdc", "sim.maxEdgeLength=4", "cloth.fabric=denim")
    model, found, told = imported(file)
    points, corners = read(file, "sim")
    triangles = corners.reshape(-1, 3)
    assert model.particle_count == len(points) and model.tri_count == len(triangles)
    # Its rest shape is taken: otherwise triangles rest as they are on the mesh.
    assert not any("rest" in text.lower() and "using" in text for text in told), told
    p = points[triangles] * 0.01
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    assert model.particle_mass.numpy().sum() == pytest.approx(area * DENSITY["denim"], rel=0.02)
    (render,) = found["path_deformable_visual_map"]
    assert str(render).endswith("/render"), "the render mesh is the graphics of the body"
    assert model.gravity.numpy().reshape(-1)[1] == pytest.approx(-981, rel=1e-3)


@pytest.mark.parametrize("meters", [1.0, 0.01])
def test_a_free_panel_falls_as_it_should(meters, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "panel.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, meters)
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.Xform.Define(stage, "/Panel")
    mesh = UsdGeom.Mesh.Define(stage, "/Panel/model")
    x, z = np.meshgrid(np.linspace(0, 0.5, 6), np.linspace(0, 0.5, 6))
    points = np.stack([x.ravel(), np.full(36, 5.0), z.ravel()], axis=1) / meters
    corner = (np.arange(5)[:, None] * 6 + np.arange(5)).ravel()
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.GetFaceVertexCountsAttr().Set([4] * 25)
    mesh.GetFaceVertexIndicesAttr().Set(np.stack([corner, corner + 6, corner + 7, corner + 1], axis=1).ravel().tolist())
    stage.GetRootLayer().Save()
    model, _, _ = imported(build(tmp_path / "panel.usda", tmp_path / "built.usdc"))
    solver = newton.solvers.SolverVBD(model, iterations=4)
    states, control, dt, steps = [model.state(), model.state()], model.control(), 1 / 240, 60
    start = states[0].particle_q.numpy()[:, 1].mean()
    for _ in range(steps):
        states[0].clear_forces()
        solver.step(states[0], states[1], control, None, dt)
        states.reverse()
    fallen = (start - states[0].particle_q.numpy()[:, 1].mean()) * meters
    # Implicit steps of dt fall further by a half step.
    assert fallen == pytest.approx(0.5 * 9.81 * (steps * dt) ** 2, rel=0.02)


def test_pins_hold(tmp_path):
    settings = ["sim.maxEdgeLength=6", "cloth.pins=waist_edge"]
    file = build(ROOT / "examples/trousers.usda", tmp_path / "built.usdc", *settings)
    model, _, told = imported(file)
    assert not any("pins" in text for text in told), told
    solver = newton.solvers.SolverVBD(model, iterations=6)
    states, control = [model.state(), model.state()], model.control()
    first = states[0].particle_q.numpy().copy()
    stage = Usd.Stage.Open(str(file))
    held = np.array(stage.GetPrimAtPath("/Trousers/physics/pins").GetAttribute("physics:indices0").Get())
    for _ in range(40):
        states[0].clear_forces()
        solver.step(states[0], states[1], control, None, 1 / 240)
        states.reverse()
    last = states[0].particle_q.numpy().copy()
    assert np.isfinite(last).all()
    assert np.abs(last - first)[held].max() < 0.1 and np.abs(last - first).max() > 1


def test_a_short_drape_drives_a_shot(tmp_path):
    out = tmp_path / "drape"
    command = [sys.executable, ROOT / "examples/drape.py", "tshirt", "-o", out, "--frames", 8, "--length", 5, "--quick"]
    done = subprocess.run([str(w) for w in [*command, "--usdtailor", USDTAILOR]], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    stage = Usd.Stage.Open(str(out / "shot.usdc"))
    points = stage.GetPrimAtPath("/Tshirt/render").GetAttribute("points")
    assert points.GetTimeSamples() == list(range(1, 9))
    first, last = (np.array(points.Get(frame)) for frame in (1, 8))
    assert np.isfinite(last).all() and 0.5 < np.abs(last - first).max() < 40
    assert np.abs(first - np.array(points.Get())).max() < 1e-3
    # The pocket stays on the shirt.
    cache, built = (Usd.Stage.Open(str(out / f"{name}.usdc")) for name in ("cache", "built"))
    sim = built.GetPrimAtPath("/Tshirt/sim")
    held = np.array(sim.GetAttribute("tailor:attach:points").Get())
    triangles = np.array(sim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)
    below = triangles[np.array(sim.GetAttribute("tailor:attach:faces").Get())]
    end = np.array(cache.GetPrimAtPath("/Tshirt/sim").GetAttribute("points").Get(8))
    assert np.linalg.norm(end[held] - end[below].mean(axis=1), axis=1).max() < 6
    assert (out / "strip.png").stat().st_size > 10_000


def on_triangles(points, corners):
    """The distance of each point from the nearest of some triangles, by points all over them."""
    weights = np.array([(i, j, 12 - i - j) for i in range(13) for j in range(13 - i)]) / 12
    samples = np.einsum("wk,tkc->twc", weights, corners).reshape(-1, 3)
    return np.array([np.linalg.norm(samples - point, axis=1).min() for point in points])


def test_trims_ride_on_a_draped_skirt_that_is_pinned_at_the_waist(tmp_path):
    out = tmp_path / "drape"
    command = [sys.executable, ROOT / "examples/drape.py", ROOT / "examples/trims/skirt.usda", "-o", out]
    command += ["--frames", 6, "--length", 3, "--level", 1, "--quick", "--usdtailor", USDTAILOR]
    done = subprocess.run([str(w) for w in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    stages = {name: Usd.Stage.Open(str(out / f"{name}.usdc")) for name in ("built", "cache", "shot")}
    built, shot = stages["built"], stages["shot"]
    sim = built.GetPrimAtPath("/Skirt/sim")
    triangles = np.array(sim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)
    cache = stages["cache"].GetPrimAtPath("/Skirt/sim").GetAttribute("points")
    first, last = (np.array(cache.Get(frame)) for frame in (1, 6))
    pins = np.array(built.GetPrimAtPath("/Skirt/physics/pins").GetAttribute("physics:indices0").Get())
    assert np.abs(last - first)[pins].max() < 0.1 < np.abs(last - first).max()
    for name, attribute, pieces in (("buttons", "points", 3), ("loops", "points", 6), ("zip_teeth", "positions", 32)):
        values = shot.GetPrimAtPath(f"/Skirt/{name}").GetAttribute(attribute)
        rest, end = (np.array(values.Get(frame), float).reshape(pieces, -1, 3) for frame in (1, 6))
        for before, after in zip(rest, end):
            size = max(np.linalg.norm(np.ptp(before, axis=0)), 0.5)
            apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (before, after)]
            assert np.abs(apart[0] - apart[1]).max() < 1e-3 * size, name
            near = [on_triangles([p.min(0) / 2 + p.max(0) / 2], q[triangles])[0] for p, q in ((before, first), (after, last))]
            assert abs(near[0] - near[1]) < 0.02 * size + 0.13, name


@pytest.mark.parametrize("schema", ["variants", "usdLod"])
def test_the_first_level_of_detail_alone_is_simulated(schema, tmp_path):
    file = tmp_path / "levels.usda"
    command = [USDTAILOR, "build", ROOT / "examples/tshirt.usda", "-o", file, "--lods", 3, "--lod-schema", schema, "--quiet"]
    subprocess.run([str(word) for word in command], check=True)
    model, found, _ = imported(file)
    assert model.particle_count == len(read(file, "sim")[0])
    (render,) = found["path_deformable_visual_map"]
    assert str(render).endswith("/LOD0")
    if schema == "variants":
        stage = Usd.Stage.Open(str(file))
        stage.GetPrimAtPath("/Tshirt").GetVariantSet("LOD").SetVariantSelection("LOD1")
        stage.Flatten().Export(str(tmp_path / "coarse.usda"))
        model, _, _ = imported(tmp_path / "coarse.usda")
        assert model.particle_count == 0
