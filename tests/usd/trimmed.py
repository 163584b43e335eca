"""A sheet of cloth with trims, which bends around the vertical axis, and where its points and trims should be then."""

import numpy as np
from pxr import Gf, Usd, UsdGeom
from runs import good
from sources import BOX, define_mesh, vec3f, with_own_space

R = 60.0
FRAMES = 5
BUTTONS = [(-30, 0), (-10, 10), (10, -10), (30, 0)]
STUDS = [(-20, 20), (0, -25), (20, 15)]


def radius(frame):
    """The cloth bends around the vertical axis, from a radius of 60 to one of 25."""
    return R / (1 + 1.4 * frame / (FRAMES - 1))


def on_cloth(p, frame):
    """Where points at (arc length, height, distance from the cloth) are."""
    p, r = np.asarray(p, float), radius(frame)
    a = p[..., 0] / r
    return np.stack([(r + p[..., 2]) * np.sin(a), p[..., 1], (r + p[..., 2]) * np.cos(a) - r], -1)


def flat(points):
    """The (arc length, height, distance from the cloth) of points at rest."""
    x, z = points[..., 0], points[..., 2] + R
    return np.stack([R * np.arctan2(x, z), points[..., 1], np.hypot(x, z) - R], -1)


def turn(arc, frame):
    """The rotation of the cloth at an arc length, from rest."""
    a = arc / radius(frame) - arc / R
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def grid(columns, rows, width, height, at=(0, 0), above=0.0):
    u, v = np.meshgrid(np.linspace(-width / 2, width / 2, columns + 1), np.linspace(-height / 2, height / 2, rows + 1))
    points = np.stack([u.ravel() + at[0], v.ravel() + at[1], np.full(u.size, above)], 1)
    n = columns + 1
    faces = [[n * j + i, n * j + i + 1, n * j + n + i + 1, n * j + n + i] for j in range(rows) for i in range(columns)]
    return on_cloth(points, 0), faces


def boxes():
    """Buttons of boxes without shared vertices, each on the tangent plane of its middle."""
    corners = np.array([[v & 1, v >> 1 & 1, v >> 2 & 1] for v in range(8)]) - [0.5, 0.5, 0]
    points = []
    for arc, height in BUTTONS:
        at, own = on_cloth([arc, height, 0.05], 0), corners[np.ravel(BOX)] * [2.2, 1.8, 0.6]
        a = arc / R
        frame = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
        points.append(at + own @ frame.T)
    return np.concatenate(points), np.arange(96).reshape(24, 4)


def write_front(path):
    """A front piece of cloth with trims of each kind."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/G").GetPrim())
    define_mesh(stage, "/G/front", *grid(20, 16, 100, 80))
    own = with_own_space(stage, "/G/trims")
    points, faces = boxes()
    define_mesh(stage, "/G/trims/buttons", own(points), faces)
    tape, faces = grid(40, 1, 60, 1.5, at=(0, 30), above=0.1)
    define_mesh(stage, "/G/trims/tape", own(tape), faces)
    cords = UsdGeom.BasisCurves.Define(stage, "/G/trims/cords")
    lines = [on_cloth(np.stack([np.linspace(-30, 30, 20), np.full(20, y), np.full(20, 0.3)], 1), 0) for y in (-20, -22)]
    cords.CreatePointsAttr(vec3f(own(np.concatenate(lines))))
    cords.CreateCurveVertexCountsAttr([20, 20])
    cords.CreateTypeAttr("linear")
    cords.CreateWidthsAttr([0.2])
    studs = UsdGeom.PointInstancer.Define(stage, "/G/trims/studs")
    UsdGeom.Sphere.Define(stage, "/G/trims/studs/ball").CreateRadiusAttr(0.3)
    studs.CreatePrototypesRel().SetTargets(["/G/trims/studs/ball"])
    studs.CreateProtoIndicesAttr([0] * len(STUDS))
    studs.CreatePositionsAttr(vec3f(own(on_cloth(np.array([(*at, 0.2) for at in STUDS]), 0))))
    studs.CreateOrientationsAttr([Gf.Quath(0.6, 0, 0.8, 0)] * len(STUDS))
    studs.CreateExtentAttr(UsdGeom.PointInstancer(studs).ComputeExtentAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default()))
    stage.GetRootLayer().Save()
    return path


ARGS = ("--prim", "/G/front", "--set", "sim.maxEdgeLength=2", "--set", "render.level=0", "--set", "trim.all.prims=trims")


def driven(usdtailor, built, out, *args):
    stage = Usd.Stage.Open(str(built))
    sim = np.array(stage.GetPrimAtPath("/G/sim").GetAttribute("points").Get(), float)
    np.save(out.with_suffix(".npy"), np.stack([on_cloth(flat(sim), frame) for frame in range(FRAMES)]).astype(np.float32))
    good(usdtailor, "drive", built, "--cache", out.with_suffix(".npy"), "-o", out, *args)
    return Usd.Stage.Open(str(out))


def world(stage, path, frame, name="points"):
    prim = stage.GetPrimAtPath(path)
    points = np.array(prim.GetAttribute(name).Get(float(frame)), float)
    matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(frame))
    return points @ matrix[:3, :3] + matrix[3, :3]


def times(stage):
    return [stage.GetStartTimeCode() + frame for frame in range(FRAMES)]
