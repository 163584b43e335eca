#!/usr/bin/env python3
"""Builds the garments of this folder, which tests run on, each named after a trouble that it has on purpose.

    make.py            writes the stages
    make.py --check    compares the committed stages with a new build

Needs usd-core and numpy.  The result is deterministic."""
import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "examples"))

import suit  # noqa: E402  (these need the examples' folder)
import troubles  # noqa: E402
from tailoring.flatten import flatten  # noqa: E402

GARMENTS = {"layered_suit": suit.build, "narrow_sets": troubles.narrow_sets,
            "split_uv_indices": troubles.split_uv_indices, "tiny_shells": troubles.tiny_shells,
            "doubled_points": troubles.doubled_points, "closed_pockets": troubles.closed_pockets,
            "shared_uvs": troubles.shared_uvs, "turned_faces": troubles.turned_faces}
RINGS = 8           # of edges, over which simDensity falls to 0
TOLERANCE = 1e-4


def edges_of(faces, corner_uv, uv):
    """The faces of each edge with the UVs of its ends there, by the two points in order."""
    sides, corner = {}, 0
    for f, face in enumerate(faces):
        for k, a in enumerate(face):
            n = (k + 1) % len(face)
            b = face[n]
            at = {a: tuple(uv[corner_uv[corner + k]]), b: tuple(uv[corner_uv[corner + n]])}
            key = (min(a, b), max(a, b))
            sides.setdefault(key, []).append((f, at[key[0]], at[key[1]]))
        corner += len(face)
    return sides


def shells_of(count, sides):
    """The number of the UV shell of each face; shells are cut where UVs differ."""
    first = list(range(count))

    def find(f):
        while first[f] != f:
            f = first[f]
        return f
    for (a, *uvs), *others in sides.values():
        for b, *other_uvs in others:
            if uvs == other_uvs:
                first[max(find(a), find(b))] = min(find(a), find(b))
    return np.unique([find(f) for f in range(count)], return_inverse=True)[1]


def density_of(count, edges, marked):
    """1 at marked points, falling to 0 some rings of edges away."""
    ring = np.full(count, RINGS)
    ring[list(marked)] = 0
    a, b = np.array(edges).T
    for _ in range(RINGS):
        for x, y in ((a, b), (b, a)):
            np.minimum.at(ring, x, ring[y] + 1)
    return 1 - ring / RINGS


def write(name, folder):
    garment = GARMENTS[name]()
    scale = getattr(garment, "scale", 1.0)
    uv, corner_uv, _ = garment.uvs if hasattr(garment, "uvs") else flatten(garment, {})
    used, corners = np.unique(np.concatenate(garment.faces), return_inverse=True)
    garment.points, garment.faces = np.array(garment.points)[used], corners.reshape(-1, 4).tolist()
    points = np.round(garment.points * scale, 4).astype(np.float32)
    uv = np.round(uv, 5).astype(np.float32)
    sides = edges_of(garment.faces, corner_uv, uv)
    edges = sorted(sides)
    borders = [e for e in edges if len(sides[e]) == 1]
    seams = [e for e in edges if len(sides[e]) > 1 and len({s[1:] for s in sides[e]}) > 1]

    path = Path(folder) / f"{name}.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01 / scale)
    root = UsdGeom.Xform.Define(stage, f"/{name}")
    stage.SetDefaultPrim(root.GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, f"/{name}/model")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(0), points.max(0)])))
    mesh.CreateFaceVertexCountsAttr([len(face) for face in garment.faces])
    mesh.CreateFaceVertexIndicesAttr([i for face in garment.faces for i in face])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.catmullClark)
    primvars = UsdGeom.PrimvarsAPI(mesh)
    st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(uv))
    st.SetIndices(Vt.IntArray.FromNumpy(np.asarray(corner_uv, np.int32)))
    density = density_of(len(points), edges, {i for e in borders + seams for i in e})
    primvars.CreatePrimvar("simDensity", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex).Set(
        Vt.FloatArray.FromNumpy(density.astype(np.float32)))
    shells = shells_of(len(garment.faces), sides)
    for number in range(shells.max() + 1):
        subset(mesh, f"panel{number:02}", "face", np.nonzero(shells == number)[0], "panels", UsdGeom.Tokens.partition)
    for set_name, faces in getattr(garment, "face_sets", {}).items():
        subset(mesh, set_name, "face", faces, "trims", UsdGeom.Tokens.unrestricted)
    subset(mesh, "borders", "edge", borders, "edgeSets", UsdGeom.Tokens.unrestricted)
    subset(mesh, "uvSeams", "edge", seams, "edgeSets", UsdGeom.Tokens.unrestricted)
    stage.GetRootLayer().Save()
    return path


def subset(mesh, name, element, indices, family, kind):
    UsdGeom.Subset.CreateGeomSubset(mesh, name, element, Vt.IntArray.FromNumpy(np.ravel(indices).astype(np.int32)), family)
    UsdGeom.Subset.SetFamilyType(mesh, family, kind)


def same(a, b):
    """True if two stages have the same properties, with numbers up to the tolerance."""
    a, b = (Usd.Stage.Open(str(path)) for path in (a, b))
    values = [{p.GetPath(): p.Get() for prim in stage.Traverse() for p in prim.GetAuthoredAttributes()} for stage in (a, b)]
    return values[0].keys() == values[1].keys() and all(equal(v, values[1][path]) for path, v in values[0].items())


def equal(a, b):
    if not hasattr(a, "__len__") or isinstance(a, str):
        return a == b
    a, b = np.array(a), np.array(b)
    return a.shape == b.shape and (np.allclose(a, b, 0, TOLERANCE) if a.dtype.kind == "f" else (a == b).all())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=[], help="only these garments")
    parser.add_argument("--check", action="store_true", help="compare the committed files with a new build")
    args = parser.parse_args()
    names = args.names or list(GARMENTS)
    if not args.check:
        for name in names:
            print(write(name, HERE))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        different = [name for name in names if not same(HERE / f"{name}.usdc", write(name, folder))]
    for name in different:
        print(f"{name}.usdc differs from what the script builds")
    print("all good" if not different else f"{len(different)} problems")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
