#!/usr/bin/env python3
"""How a cloth solver feels a mesh: ours against PyMeshLab's of as many vertices, on the same surface.

    solver.py USDTAILOR GARMENT...      needs usd-core, numpy, scipy and pymeshlab

For each garment the system matrix M + dt² K of an implicit step (cotton as constant-strain triangles, dt = 1/240 s) is built on both
meshes. The table has its condition number with Jacobi scaling, the iterations of Jacobi-preconditioned conjugate gradients to a
residual of 1e-4, and the time step of an explicit solver (the smallest altitude over the speed of waves)."""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from pxr import Usd, UsdGeom

STRETCH, DENSITY, POISSON, DT = 10.5e3, 0.14, 0.3, 1 / 240     # N/m, kg/m², -, s
ROUNDS = 5


def build(usdtailor, garment, out, *settings):
    words = [w for s in settings for w in ("--set", s)]
    command = [usdtailor, "build", garment, "-o", out, "--force", "--quiet", "--physics", "none", *words]
    subprocess.run([str(w) for w in command], check=True, stderr=subprocess.DEVNULL)
    stage = Usd.Stage.Open(str(out))
    meters = UsdGeom.GetStageMetersPerUnit(stage)

    def mesh(name):
        prim = next(p for p in stage.Traverse() if p.GetCustomDataByKey("tailor:product") == name)
        counts, corners = (np.array(prim.GetAttribute(n).Get()) for n in ("faceVertexCounts", "faceVertexIndices"))
        return np.array(prim.GetAttribute("points").Get(), float) * meters, counts, corners

    return mesh


def triangulated(points, counts, corners):
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    fans = [(corners[s], corners[s + k], corners[s + k + 1]) for s, n in zip(starts, counts) for k in range(1, n - 1)]
    return points, np.array(fans)


def peer(points, triangles, wanted):
    """PyMeshLab's isotropic remeshing with about `wanted` vertices."""
    import pymeshlab as ml
    edges = points[triangles] - points[np.roll(triangles, 1, axis=1)]
    length = np.linalg.norm(edges, axis=2).mean()
    found = None
    for _ in range(6):
        meshes = ml.MeshSet(verbose=False)
        meshes.add_mesh(ml.Mesh(points, triangles))
        meshes.meshing_isotropic_explicit_remeshing(iterations=ROUNDS, targetlen=ml.PureValue(length), featuredeg=60)
        mesh = meshes.current_mesh()
        found = mesh.vertex_matrix(), mesh.face_matrix()
        ratio = len(found[0]) / wanted
        if abs(ratio - 1) < 0.02:
            break
        length *= np.sqrt(ratio)
    return found


def system(points, triangles):
    """M + dt² K; triangles without area are left out."""
    p = points[triangles]
    u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(u, v), axis=1)
    keep = area > 1e-14
    triangles, u, v, area = triangles[keep], u[keep], v[keep], area[keep]
    x = u / np.linalg.norm(u, axis=1, keepdims=True)
    n = np.cross(u, v)
    y = np.cross(n / np.linalg.norm(n, axis=1, keepdims=True), x)
    flat = np.stack([np.stack([(u * x).sum(1), (u * y).sum(1)], 1), np.stack([(v * x).sum(1), (v * y).sum(1)], 1)], 1)
    inverse = np.linalg.inv(flat)                              # gradients of the second and third corner
    g = np.concatenate([-inverse.sum(2, keepdims=True), inverse], axis=2)
    strain = np.zeros((len(area), 3, 9))
    for k in range(3):
        for axis in range(3):
            column = 3 * k + axis
            strain[:, 0, column] = g[:, 0, k] * x[:, axis]
            strain[:, 1, column] = g[:, 1, k] * y[:, axis]
            strain[:, 2, column] = g[:, 1, k] * x[:, axis] + g[:, 0, k] * y[:, axis]
    d = STRETCH / (1 - POISSON**2) * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])
    local = np.einsum("n,nai,ab,nbj->nij", area, strain, d, strain)
    index = (3 * triangles[:, :, None] + np.arange(3)).reshape(len(triangles), 9)
    rows, columns = np.repeat(index, 9, axis=1).ravel(), np.tile(index, (1, 9)).ravel()
    size = 3 * len(points)
    stiffness = sp.coo_matrix((local.ravel(), (rows, columns)), (size, size)).tocsr()
    mass = np.zeros(len(points))
    np.add.at(mass, triangles.ravel(), np.repeat(area * DENSITY / 3, 3))
    used = np.repeat(mass > 0, 3)
    matrix = (sp.diags(np.repeat(mass, 3)) + DT**2 * stiffness)[used][:, used]
    longest = np.maximum(np.linalg.norm(u, axis=1), np.maximum(np.linalg.norm(v, axis=1), np.linalg.norm(u - v, axis=1)))
    step = (2 * area / longest).min() / np.sqrt(STRETCH / DENSITY)
    return matrix, step


def figures(points, triangles):
    matrix, step = system(points, triangles)
    scale = sp.diags(1 / np.sqrt(matrix.diagonal()))
    scaled = (scale @ matrix @ scale).tocsc()
    def condition(matrix):
        most = sla.eigsh(matrix, 1, which="LM", return_eigenvectors=False, tol=1e-3)[0]
        return most / sla.eigsh(matrix.tocsc(), 1, sigma=0, which="LM", return_eigenvectors=False, tol=1e-3)[0]

    right, count = np.random.default_rng(0).standard_normal(matrix.shape[0]), [0]
    sla.cg(scaled, right, rtol=1e-4, maxiter=20000, callback=lambda _: count.__setitem__(0, count[0] + 1))
    return len(points), condition(matrix), condition(scaled), count[0], step * 1e6


def main():
    usdtailor, *garments = sys.argv[1:]
    print(f"{'garment':28} {'mesh':22} {'vertices':>8} {'condition':>10} {'scaled':>10} {'CG':>6} {'step [µs]':>10}")
    with tempfile.TemporaryDirectory() as folder:
        for garment in garments:
            name = Path(garment).stem
            for label, settings in (("even", ["sim.density="]), ("painted density", [])):
                out = Path(folder) / f"{name}_{len(settings)}.usdc"     # OpenUSD keeps open layers by their name
                mesh = build(usdtailor, garment, out, "render.level=2", "render.operators=", *settings)
                points, _, corners = mesh("sim")
                ours = points, corners.reshape(-1, 3)
                if label != "even" and len(points) == before:
                    continue                                   # no density is painted
                before = len(points)
                rows = [(f"ours, {label}", ours)]
                rows.append((f"PyMeshLab, {len(points)}", peer(*triangulated(*mesh("render")), len(points))))
                for title, (p, t) in rows:
                    count, raw, scaled, iterations, step = figures(p, t)
                    print(f"{name:28} {title:22} {count:8} {raw:10.0f} {scaled:10.0f} {iterations:6} {step:10.2f}", flush=True)


if __name__ == "__main__":
    main()
