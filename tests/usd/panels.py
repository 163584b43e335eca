"""A shirt of two panels that are sewn together, for tests of several meshes."""

import numpy as np
import pytest
from conftest import run
from mesh import read_mesh
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import add_primvar, add_subset, define

# A shirt of two panels that meet at the sides and shoulders, and are open at neck, arms and hem.
WIDTH, HEIGHT, ARM, NECK = 12, 10, 6, 2
PLACES = {"front": Gf.Matrix4d().SetTranslate((3, 0, -2)), "back": Gf.Matrix4d().SetRotate(Gf.Rotation((0, 1, 0), 90))}


def panel(side, rows=HEIGHT):
    """Points, counts and indices of the front (1) or the back (-1) in the space of the shirt."""
    columns, steps = np.meshgrid(np.arange(WIDTH + 1), np.linspace(0, HEIGHT, rows + 1))
    x, y = columns.ravel() - WIDTH / 2, steps.ravel()
    depth = 0.3 + 0.08 * (WIDTH / 2 - abs(x)) * (1.3 - y / HEIGHT)
    is_sewn = ((abs(x) == WIDTH / 2) & (y <= ARM)) | ((y == HEIGHT) & (abs(x) >= NECK))
    points = np.stack([x, y, side * np.where(is_sewn, 0, depth)], axis=1)
    corner = (np.arange(rows)[:, None] * (WIDTH + 1) + np.arange(WIDTH)).ravel()
    quads = np.stack([corner, corner + 1, corner + WIDTH + 2, corner + WIDTH + 1], axis=1)
    quads = quads if side > 0 else quads[:, ::-1]
    return points, np.full(len(quads), 4), quads.ravel()


def add_panel(stage, name, side, rows=HEIGHT, matrix=None, parent="/Suit"):
    """A panel with UVs and weights; its points are moved so that the matrix brings them back."""
    matrix = matrix or PLACES[name]
    points, counts, indices = panel(side, rows)
    local = np.array([matrix.GetInverse().Transform(Gf.Vec3d(*map(float, point))) for point in points])
    mesh = define(stage, f"{parent}/{name}", (local, counts, indices))
    UsdGeom.Xformable(mesh).AddTransformOp().Set(matrix)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set([Gf.Vec2f(*map(float, point[:2])) for point in points])
    st.SetIndices(indices.tolist())
    weights = (points[:, 1] / HEIGHT).astype(float).tolist()
    add_primvar(mesh, name="weight", type_name="float", interpolation="vertex", values=weights)
    return mesh


def add_belt(stage, *_):
    points = np.array([[x, y, z] for y in (3, 4) for x, z in ((-9, -4), (9, -4), (9, 4), (-9, 4))], float)
    quads = np.array([[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)])
    define(stage, "/Suit/belt", (points, np.full(4, 4), quads.ravel()))


@pytest.fixture
def suit(tmp_path):
    """`suit(finish)` writes a shirt of two panels; `finish` gets the stage and both meshes."""

    def suit(finish=None, name="suit.usda", **options):
        path = tmp_path / name
        stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        panels = [add_panel(stage, "front", 1), add_panel(stage, "back", -1, **options)]
        stage.SetDefaultPrim(stage.GetPrimAtPath("/Suit"))
        if finish:
            finish(stage, *panels)
        stage.Save()
        return path

    return suit


@pytest.fixture
def whole(tmp_path):
    """The same shirt as one mesh, with the sets that sewing makes."""
    (front, counts, indices), (back, _, turned) = panel(1), panel(-1)
    known = {tuple(point): i for i, point in enumerate(front)}
    number = []
    points = list(front)
    for point in back:
        at = known.get(tuple(point + 0.0), len(points))
        number.append(at)
        if at == len(points):
            points.append(point)
    faces = np.concatenate([indices, np.array(number)[turned]])
    path = tmp_path / "whole.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    mesh = define(stage, "/Suit/shirt", (np.array(points), np.concatenate([counts, counts]), faces))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set([Gf.Vec2f(*map(float, point[:2])) for point in [*front, *back]])
    st.SetIndices(np.concatenate([indices, turned + len(front)]).tolist())
    weights = [float(point[1]) / HEIGHT for point in points]
    add_primvar(mesh, name="weight", type_name="float", interpolation="vertex", values=weights)
    half = len(counts)
    add_subset(mesh, name="front", indices=range(half), family="")
    add_subset(mesh, name="back", indices=range(half, 2 * half), family="")
    sets = [{tuple(sorted(pair)) for quad in faces[part].reshape(-1, 4) for pair in zip(quad, np.roll(quad, -1))} for part in (slice(0, 4 * half), slice(4 * half, None))]
    add_subset(mesh, name="sewn", element="edge", indices=[int(p) for pair in sorted(sets[0] & sets[1]) for p in pair], family="")
    stage.Save()
    return path


def meshes(path, *names, parent="/Suit"):
    stage = Usd.Stage.Open(str(path))
    return [read_mesh(stage.GetPrimAtPath(f"{parent}/{name}")) for name in names]


def built(usdtailor, source, out, *args):
    done = run(usdtailor, "build", source, "-o", out, *args)
    assert done.returncode == 0, done.stderr
    return done.stderr


def refused(usdtailor, source, out, *args):
    done = run(usdtailor, "build", source, "-o", out, *args)
    assert done.returncode == 1 and not out.exists(), done.stdout
    return done.stderr


def seam_edges():
    """How many border edges the two panels share."""
    return 2 * ARM + 2 * (WIDTH // 2 - NECK)
