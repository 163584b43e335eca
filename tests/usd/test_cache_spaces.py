"""Caches in other spaces than the garment: the driven mesh is where the cache is in the world, by usd-core and numpy."""

import numpy as np
import pytest
from conftest import run
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from runs import good, refused

TIMES = (1, 2, 3, 4)
CODES = 24


def numbers(values):
    return np.array(values, float)


def world(stage, path, time):
    """The points of a mesh in the space of its stage."""
    prim = stage.GetPrimAtPath(path)
    to_world = numbers(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time))
    return numbers(UsdGeom.PointBased(prim).GetPointsAttr().Get(time)) @ to_world[:3, :3] + to_world[3, :3]


def moved(points, time):
    """A rigid motion of the world in which each frame is as far from the next: a turn at bind that stays, and a way."""
    a = 0.4
    turn = numbers([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    return points @ turn + numbers([0.5, 2.0, -1.0]) * time


def sheet(count=4):
    points = [(x, y, 0.1 * (x * y % 2)) for y in range(count) for x in range(count)]
    faces = [[count * y + x, count * y + x + 1, count * (y + 1) + x + 1, count * (y + 1) + x] for y in range(count - 1) for x in range(count - 1)]
    return points, faces


def write_garment(path, ops):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Y"), UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    group = UsdGeom.Xform.Define(stage, "/G")
    stage.SetDefaultPrim(group.GetPrim())
    ops(group)
    mesh = UsdGeom.Mesh.Define(stage, "/G/m")
    points, faces = sheet()
    mesh.CreatePointsAttr(points), mesh.CreateFaceVertexCountsAttr([4] * len(faces)), mesh.CreateFaceVertexIndicesAttr(np.ravel(faces).tolist())
    bead = UsdGeom.Points.Define(stage, "/G/bead")
    bead.CreatePointsAttr([(1, 1, 0.3), (2, 2, 0.3)]), bead.CreateWidthsAttr([0.1, 0.1])
    swing = bead.AddTranslateOp()
    swing.Set(Gf.Vec3d(0)), [swing.Set(Gf.Vec3d(time, 0, 2 * time), time) for time in TIMES]
    stage.GetRootLayer().Save()
    return path


def still(group):
    group.AddTranslateOp().Set(Gf.Vec3d(7, 0, 0))


def turned(group):
    group.AddTranslateOp().Set(Gf.Vec3d(7, 3, 0)), group.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, 40)), group.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))


def moving(group):
    op = group.AddTranslateOp()
    op.Set(Gf.Vec3d(7, 0, 0)), [op.Set(Gf.Vec3d(7 + 3 * time, 0, time), time) for time in TIMES]


def write_cache(path, built, up="Y", unit=0.01, way="points", over=False, left=False, names=("/G", "sim")):
    """The simulation mesh where the world moves it, as points of the world, below a transform, or by a transform that moves."""
    garment = Usd.Stage.Open(str(built))
    sim = garment.GetPrimAtPath("/G/sim")
    rest = world(garment, "/G/sim", Usd.TimeCode.Default())
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up), UsdGeom.SetStageMetersPerUnit(stage, unit)
    stage.SetTimeCodesPerSecond(CODES)
    mesh_path = "/".join(names)
    if over:
        mesh = UsdGeom.Mesh(stage.OverridePrim(mesh_path))
    else:
        UsdGeom.Xform.Define(stage, names[0])
        mesh = UsdGeom.Mesh.Define(stage, mesh_path)
    corners = numbers(sim.GetAttribute("faceVertexIndices").Get()).astype(int).reshape(-1, 3)
    if left:
        corners = np.roll(corners[:, ::-1], 1, axis=1)
        mesh.CreateOrientationAttr("leftHanded")
    mesh.CreateFaceVertexCountsAttr([3] * len(corners)), mesh.CreateFaceVertexIndicesAttr(corners.ravel().tolist())
    shift = UsdGeom.Xform(stage.GetPrimAtPath(names[0])).AddTranslateOp() if way != "points" else None
    for time in TIMES:
        frame = moved(rest, time)
        velocity = np.tile(numbers([0.5, 2.0, -1.0]) * CODES, (len(rest), 1))
        if way == "moves":
            shift.Set(Gf.Vec3d(*(numbers([0.5, 2.0, -1.0]) * time)), time)
            frame, velocity = moved(rest, 0), velocity * 0
        elif way == "below":
            frame = frame - [0, 5, 0]
            shift.Set(Gf.Vec3d(0, 5, 0))
        if over:
            to_local = np.linalg.inv(numbers(UsdGeom.Xformable(sim).ComputeLocalToWorldTransform(time)))
            frame = frame @ to_local[:3, :3] + to_local[3, :3]
        if up == "Z":
            frame, velocity = ([v[:, 0], -v[:, 2], v[:, 1]] for v in (frame, velocity))
            frame, velocity = (np.stack(v, 1) for v in (frame, velocity))
        scale = 0.01 / unit
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy((frame * scale).astype(np.float32)), time)
        mesh.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy((velocity * scale).astype(np.float32)), time)
    stage.GetRootLayer().Save()
    return path


@pytest.fixture(scope="module")
def built(usdtailor, tmp_path_factory):
    def build(ops):
        folder = tmp_path_factory.mktemp(ops.__name__)
        garment = write_garment(folder / "garment.usda", ops)
        good(usdtailor, "build", garment, "-o", folder / "built.usdc", "--set", "trim.t.prims=/G/bead", "--set", "sim.maxEdgeLength=0.6")
        return folder / "built.usdc"

    return {ops: build(ops) for ops in (still, turned, moving)}


def check(shot, velocities=True):
    """The render mesh and the trim are where the world took them, and velocities are the change of their points."""
    stage = Usd.Stage.Open(str(shot))
    for path in ("/G/render", "/G/bead"):
        rest = world(stage, path, Usd.TimeCode.Default())
        for time in TIMES:
            assert np.abs(world(stage, path, time) - moved(rest, time)).max() < 2e-4, (path, time)
        mesh = UsdGeom.PointBased(stage.GetPrimAtPath(path))
        if velocities:
            change = (numbers(mesh.GetPointsAttr().Get(3)) - numbers(mesh.GetPointsAttr().Get(2))) * CODES
            for time in TIMES:
                assert np.abs(numbers(mesh.GetVelocitiesAttr().Get(time)) - change).max() < 0.05, (path, time)


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
@pytest.mark.parametrize("ops", [still, turned, moving])
@pytest.mark.parametrize(
    "cache",
    [
        {},
        {"way": "below"},
        {"way": "moves", "names": ("/sim", "geo")},
        {"up": "Z", "unit": 1.0, "names": ("/cloth", "mesh_0")},
        {"left": True, "names": ("/cloth", "mesh_0")},
        {"over": True},
    ],
    ids=["world", "below a transform", "by a transform", "metres with Z up", "left handed", "overs"],
)
def test_a_cache_lands_where_it_is_in_the_world(usdtailor, built, tmp_path, ops, cache, suffix):
    source = write_cache(tmp_path / f"cache{suffix}", built[ops], **cache)
    good(usdtailor, "drive", built[ops], "--cache", source, "-o", tmp_path / "shot.usdc")
    check(tmp_path / "shot.usdc", velocities=not cache.get("over"))


@pytest.mark.parametrize("ops", [still, turned, moving])
def test_arrays_are_of_the_space_that_is_given(usdtailor, built, tmp_path, ops):
    stage = Usd.Stage.Open(str(built[ops]))
    rest = world(stage, "/G/sim", Usd.TimeCode.Default())
    frames = np.stack([moved(rest, time) for time in TIMES])
    np.savez(tmp_path / "world.npz", points=frames)
    good(usdtailor, "drive", built[ops], "--cache", tmp_path / "world.npz", "--cache-space", "world", "-o", tmp_path / "shot.usdc")
    check(tmp_path / "shot.usdc", velocities=False)
    local = []
    for time, frame in zip(TIMES, frames):
        to_local = np.linalg.inv(numbers(UsdGeom.Xformable(stage.GetPrimAtPath("/G/sim")).ComputeLocalToWorldTransform(time)))
        local.append(frame @ to_local[:3, :3] + to_local[3, :3])
    np.savez(tmp_path / "local.npz", points=np.stack(local))
    good(usdtailor, "drive", built[ops], "--cache", tmp_path / "local.npz", "-o", tmp_path / "local.usdc")
    check(tmp_path / "local.usdc", velocities=False)


def test_another_space_is_a_doubt_and_no_decision(usdtailor, built, tmp_path):
    stage = Usd.Stage.Open(str(built[still]))
    for name, space, cure in (("world", "/G/sim", "--cache-space world"), ("local", None, "--cache-space local")):
        prim = stage.GetPrimAtPath("/G/sim")
        local = numbers(prim.GetAttribute("points").Get())
        points = world(stage, space, Usd.TimeCode.Default()) if space else local
        cache = tmp_path / f"{name}.{'npz' if space else 'usdc'}"
        if space:
            np.savez(cache, points=np.stack([points] * 2))
        else:
            layer = Usd.Stage.CreateNew(str(cache))
            UsdGeom.Xform.Define(layer, "/G")
            mesh = UsdGeom.Mesh.Define(layer, "/G/sim")
            [mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), time) for time in (1, 2)]
            layer.GetRootLayer().Save()
        shot = tmp_path / f"{name}_shot.usdc"
        done = good(usdtailor, "drive", built[still], "--cache", cache, "-o", shot)
        assert "warning[cache-space]" in done.stderr and cure in done.stderr, done.stderr
        rest = numbers(stage.GetPrimAtPath("/G/render").GetAttribute("points").Get())
        driven = Usd.Stage.Open(str(shot))
        found = numbers(driven.GetPrimAtPath("/G/render").GetAttribute("points").Get(1))
        assert np.abs(found - rest - ([7, 0, 0] if space else [-7, 0, 0])).max() < 1e-4
        done = good(usdtailor, "drive", built[still], "--cache", cache, *cure.split(), "-o", shot, "--force")
        assert "warning" not in done.stderr, done.stderr


def test_a_declared_up_axis_is_trusted(usdtailor, built, tmp_path):
    """A character that begins on its back stays there, and one whose stage names the wrong axis is told."""
    stage = Usd.Stage.Open(str(built[still]))
    points = world(stage, "/G/sim", Usd.TimeCode.Default())
    cache = Usd.Stage.CreateNew(str(tmp_path / "cache.usdc"))
    UsdGeom.SetStageUpAxis(cache, "Z")
    UsdGeom.Xform.Define(cache, "/G")
    mesh = UsdGeom.Mesh.Define(cache, "/G/sim")
    [mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), time) for time in (1, 2)]
    cache.GetRootLayer().Save()
    shot = tmp_path / "shot.usdc"
    done = good(usdtailor, "drive", built[still], "--cache", tmp_path / "cache.usdc", "-o", shot)
    assert "turned from the up axis" in done.stdout and "correct `upAxis`" in done.stderr, done.stderr
    rest = world(stage, "/G/render", Usd.TimeCode.Default())
    found = world(Usd.Stage.Open(str(shot)), "/G/render", 1)
    assert np.abs(found - np.stack([rest[:, 0], rest[:, 2], -rest[:, 1]], 1)).max() < 1e-4


def test_a_declared_unit_is_trusted(usdtailor, built, tmp_path):
    write_cache(tmp_path / "cache.usda", built[still])
    text = (tmp_path / "cache.usda").read_text()
    (tmp_path / "cache.usda").write_text(text.replace("metersPerUnit = 0.01", "metersPerUnit = 1"))
    refused(usdtailor, "drive", built[still], "--cache", tmp_path / "cache.usda", "-o", tmp_path / "shot.usdc", says=["cache-mismatch", "unit"])
    assert not (tmp_path / "shot.usdc").exists()


@pytest.mark.parametrize("order", ["reversed", "rolled", "mixed"])
def test_a_face_is_the_same_from_any_corner_and_side(usdtailor, built, tmp_path, order):
    cache = write_cache(tmp_path / "cache.usdc", built[still])
    stage = Usd.Stage.Open(str(cache))
    corners = UsdGeom.Mesh(stage.GetPrimAtPath("/G/sim")).GetFaceVertexIndicesAttr()
    faces = numbers(corners.Get()).astype(int).reshape(-1, 3)
    other = {"reversed": faces[:, ::-1], "rolled": np.roll(faces, 1, axis=1), "mixed": np.where(np.arange(len(faces))[:, None] % 2, faces[:, ::-1], faces)}
    corners.Set(other[order].ravel().tolist()), stage.GetRootLayer().Save()
    good(usdtailor, "drive", built[still], "--cache", cache, "-o", tmp_path / "shot.usdc")
    check(tmp_path / "shot.usdc")
    swapped = faces.copy()
    swapped[[0, 1]] = faces[[1, 0]]
    corners.Set(swapped.ravel().tolist()), stage.GetRootLayer().Save()
    refused(usdtailor, "drive", built[still], "--cache", cache, "-o", tmp_path / "no.usdc", says=["another order"])


def test_a_cache_in_other_time_codes_meets_a_moving_garment(usdtailor, built, tmp_path):
    """The shot has the time codes of the cache, so that OpenUSD stretches the motion of the garment below it."""
    cache = write_cache(tmp_path / "cache.usdc", built[moving])
    stage = Usd.Stage.Open(str(cache))
    stage.SetTimeCodesPerSecond(48), stage.GetRootLayer().Save()
    good(usdtailor, "drive", built[moving], "--cache", cache, "-o", tmp_path / "shot.usdc")
    check(tmp_path / "shot.usdc", velocities=False)


def add(prim, name, kind, values):
    prim.CreateAttribute(name, kind).Set(values)


def test_nothing_that_depends_on_points_stays_as_at_bind(usdtailor, tmp_path):
    garment = write_garment(tmp_path / "garment.usda", still)
    stage = Usd.Stage.Open(str(garment))
    stage.GetPrimAtPath("/G/bead").GetAttribute("xformOpOrder").Block()
    vectors, count = Sdf.ValueTypeNames.Vector3fArray, 16
    for name in ("velocities", "accelerations"):
        add(stage.GetPrimAtPath("/G/m"), name, vectors, [(0, 0, 50)] * count)
        add(stage.GetPrimAtPath("/G/bead"), name, vectors, [(0, 0, 50)] * 2)
    curve = UsdGeom.HermiteCurves.Define(stage, "/G/cord")
    curve.CreatePointsAttr([(0.5, 1, 0.2), (2.5, 1, 0.2)]), curve.CreateCurveVertexCountsAttr([2]), curve.CreateTangentsAttr([(1, 0, 0), (0, 1, 0)])
    beads = UsdGeom.PointInstancer.Define(stage, "/G/beads")
    UsdGeom.Sphere.Define(stage, "/G/beads/bead")
    beads.CreatePrototypesRel().SetTargets(["/G/beads/bead"]), beads.CreateProtoIndicesAttr([0, 0]), beads.CreatePositionsAttr([(1, 2, 0.2), (2, 1, 0.2)])
    beads.CreateVelocitiesAttr([(0, 0, 50)] * 2), beads.CreateAngularVelocitiesAttr([(0, 0, 50)] * 2)
    stage.GetRootLayer().Save()
    built = tmp_path / "built.usdc"
    good(usdtailor, "build", garment, "--prim", "/G/m", "-o", built, "--set", "trim.t.prims=/G/bead,/G/cord,/G/beads", "--set", "sim.maxEdgeLength=0.6")
    for velocities in (True, False):
        cache = write_cache(tmp_path / f"cache{velocities}.usdc", built)
        if not velocities:
            source = Usd.Stage.Open(str(cache))
            source.GetPrimAtPath("/G/sim").RemoveProperty("velocities"), source.GetRootLayer().Save()
        for name, args in ((f"shot{velocities}.usdc", []), (f"clips{velocities}.usda", ["--clips"])):
            good(usdtailor, "drive", built, "--cache", cache, "-o", tmp_path / name, "--model", *args)
            shot = Usd.Stage.Open(str(tmp_path / name))
            for path in ("m", "bead", "beads", "render", "cord"):
                prim = shot.GetPrimAtPath(f"/G/{path}")
                found = prim.GetAttribute("velocities").Get(2)
                assert (np.abs(numbers(found) - numbers([0.5, 2.0, -1.0]) * CODES).max() < 0.05) if velocities else not found, path
                assert not prim.GetAttribute("accelerations").Get(2) and not prim.GetAttribute("angularVelocities").Get(2), path
            tangents = numbers(shot.GetPrimAtPath("/G/cord").GetAttribute("tangents").Get(2))
            assert np.abs(tangents - (moved(numbers([(1, 0, 0), (0, 1, 0)]), 0) - moved(np.zeros((2, 3)), 0))).max() < 1e-3


def tube(stage, path, radius, rows=8, count=16):
    angles = 2 * np.pi * np.arange(count) / count
    points = [(radius * np.cos(a), 8 * j / rows, -radius * np.sin(a)) for j in range(rows + 1) for a in angles]
    faces = [[count * j + i, count * j + (i + 1) % count, count * (j + 1) + (i + 1) % count, count * (j + 1) + i] for j in range(rows) for i in range(count)]
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([tuple(map(float, p)) for p in points]), mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr([int(v) for face in faces for v in face])
    return mesh


def test_nothing_that_depends_on_points_stays_after_a_fit(usdtailor, tmp_path):
    for name, radius in (("from", 2.0), ("to", 2.5), ("garment", 2.2)):
        stage = Usd.Stage.CreateNew(str(tmp_path / f"{name}.usda"))
        UsdGeom.SetStageUpAxis(stage, "Y"), UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/G").GetPrim())
        mesh = tube(stage, "/G/m", radius)
        if name == "garment":
            count = len(mesh.GetPointsAttr().Get())
            cord = UsdGeom.HermiteCurves.Define(stage, "/G/cord")
            cord.CreatePointsAttr([(2.25, 3, 0), (2.25, 5, 0)]), cord.CreateCurveVertexCountsAttr([2]), cord.CreateTangentsAttr([(0, 1, 0), (0, 0, 1)])
            for prim, number in ((mesh.GetPrim(), count), (cord.GetPrim(), 2)):
                for attribute in ("velocities", "accelerations"):
                    add(prim, attribute, Sdf.ValueTypeNames.Vector3fArray, [(0, 0, 50)] * number)
            add(mesh.GetPrim(), "normals", Sdf.ValueTypeNames.Normal3fArray, [(0, 0, 1)] * count)
        stage.GetRootLayer().Save()
    good(
        usdtailor, "fit", tmp_path / "garment.usda", "--from", tmp_path / "from.usda", "--to", tmp_path / "to.usda", "-o",
        tmp_path / "out.usda", "--prim", "/G/m", "--set", "trim.t.prims=/G/cord",
    )  # fmt: skip
    before, after = (Usd.Stage.Open(str(tmp_path / f"{name}.usda")) for name in ("garment", "out"))
    for path in ("/G/m", "/G/cord"):
        points = [numbers(stage.GetPrimAtPath(path).GetAttribute("points").Get()) for stage in (before, after)]
        assert np.abs(points[1] - points[0]).max() > 0.1
        for name in ("velocities", "accelerations", "normals"):
            assert not after.GetPrimAtPath(path).GetAttribute(name).Get(), (path, name)
    tangents = numbers(after.GetPrimAtPath("/G/cord").GetAttribute("tangents").Get())
    assert np.abs(np.linalg.norm(tangents, axis=1) - 1).max() < 1e-4 and np.abs(tangents - [(0, 1, 0), (0, 0, 1)]).max() < 0.2
