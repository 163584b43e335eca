"""Garments and bodies for tests of `usdtailor fit`. Crossings are found by FCL, which shares no code with ours."""

import fcl
import numpy as np
from conftest import run
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import define


class Triangles:
    """The only mesh of a file as triangles: points, triangles, and the face of each."""

    def __init__(self, path, prim=None):
        self.stage = Usd.Stage.Open(str(path))
        meshes = [UsdGeom.Mesh(p) for p in self.stage.Traverse() if p.IsA(UsdGeom.Mesh) and (prim is None or p.GetPath() == prim)]
        (self.mesh,) = meshes
        self.points = np.array(self.mesh.GetPointsAttr().Get(), float)
        counts, corners = (np.array(a.Get()) for a in (self.mesh.GetFaceVertexCountsAttr(), self.mesh.GetFaceVertexIndicesAttr()))
        starts = np.concatenate([[0], np.cumsum(counts)])
        fans = [(f, starts[f], starts[f] + k) for f, count in enumerate(counts) for k in range(1, count - 1)]
        self.face = np.array([f for f, _, _ in fans])
        self.triangles = np.array([corners[[first, at, at + 1]] for _, first, at in fans])
        sides = {tuple(sorted((corners[starts[f] + k], corners[starts[f] + (k + 1) % count]))) for f, count in enumerate(counts) for k in range(count)}
        self.edges = np.array(sorted(sides))

    def model(self):
        model = fcl.BVHModel()
        model.beginModel(len(self.points), len(self.triangles))
        model.addSubModel(self.points, self.triangles)
        model.endModel()
        return fcl.CollisionObject(model)

    def lengths(self):
        return np.linalg.norm(self.points[self.edges[:, 0]] - self.points[self.edges[:, 1]], axis=1)


def pairs(a, b):
    """The triangles of two meshes that cross."""
    result = fcl.CollisionResult()
    fcl.collide(a.model(), b.model(), fcl.CollisionRequest(num_max_contacts=10**7, enable_contact=True), result)
    return {(contact.b1, contact.b2) for contact in result.contacts}


def crossings(garment, body):
    """Faces of a garment that cross a body, and pairs of its faces without a common point that cross each other."""
    with_body = {garment.face[a] for a, _ in pairs(garment, body)}
    is_apart = lambda a, b: not set(garment.triangles[a]) & set(garment.triangles[b])  # noqa: E731
    own = {(garment.face[a], garment.face[b]) for a, b in pairs(garment, garment) if garment.face[a] < garment.face[b] and is_apart(a, b)}
    return with_body, own


def fit(usdtailor, *args, code=0):
    done = run(usdtailor, "fit", *args)
    assert done.returncode == code, done.stderr
    return done


def tube(radius, height, around, along, bulge=0.0, uv=False):
    """A tube about the y axis: points, counts, indices and the UVs of corners."""
    turn, up = np.meshgrid(np.arange(around), np.arange(along + 1))
    angle, share = 2 * np.pi * turn.ravel() / around, up.ravel() / along
    r = radius + bulge * np.sin(np.pi * share)
    points = np.stack([r * np.sin(angle), height * (share - 0.5), r * np.cos(angle)], axis=1)
    rows, columns = np.divmod(np.arange(along * around), around)
    next_column = (columns + 1) % around
    quads = np.stack([rows * around + columns, rows * around + next_column, (rows + 1) * around + next_column, (rows + 1) * around + columns], axis=1)
    corner_uvs = np.stack([np.stack([(columns + dx) / around, (rows + dy) / along], axis=1) for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
    return (points, np.full(len(quads), 4), quads.ravel()), corner_uvs.reshape(-1, 2)


def write_tube(path, shape, uvs=None, *, finish=None, up="Y", unit=0.01, prim="/Coat/model"):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    mesh = define(stage, prim, shape)
    if uvs is not None:
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
        primvar.Set([Gf.Vec2f(*map(float, uv)) for uv in uvs])
    if finish:
        finish(mesh)
    stage.SetDefaultPrim(stage.GetPrimAtPath(Sdf.Path(prim).GetPrefixes()[0]))
    stage.Save()
    return path


def radii(points):
    return np.hypot(points[:, 0], points[:, 2])
