#!/usr/bin/env python3
"""Writes the first mesh of a stage as the text mesh that `golden bench` reads (see bench.h).

    export.py STAGE MESH.txt"""
import sys

from pxr import Usd, UsdGeom


def creases(mesh):
    """The crease edges as vertex pairs with a sharpness each."""
    indices = iter(mesh.GetCreaseIndicesAttr().Get() or [])
    lengths = mesh.GetCreaseLengthsAttr().Get() or []
    sharpness = list(mesh.GetCreaseSharpnessesAttr().Get() or [])
    per_edge = iter(sharpness) if len(sharpness) > len(lengths) else None
    for crease, length in enumerate(lengths):
        chain = [next(indices) for _ in range(length)]
        for a, b in zip(chain, chain[1:]):
            yield a, b, next(per_edge) if per_edge else sharpness[crease]


def uv_set(mesh, vertices):
    """A UV index per face-vertex, and the UVs; equal UVs at a vertex are one where the file has no indices."""
    for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvars():
        if primvar.GetInterpolation() == "faceVarying" and str(primvar.GetTypeName()) in ("texCoord2f[]", "float2[]"):
            if primvar.IsIndexed():
                return primvar.GetIndices(), primvar.Get()
            rows = {}
            indices = [rows.setdefault((v, tuple(uv)), len(rows)) for v, uv in zip(vertices, primvar.Get())]
            return indices, [uv for _, uv in rows]
    raise SystemExit("export.py: the mesh has no UV set")


def main():
    stage = Usd.Stage.Open(sys.argv[1])
    mesh = next((UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)), None)
    if not mesh or mesh.GetSubdivisionSchemeAttr().Get() != "catmullClark":
        raise SystemExit("export.py: the stage has no catmullClark mesh")
    counts, vertices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    points = mesh.GetPointsAttr().Get()
    indices, uvs = uv_set(mesh, vertices)
    edges = list(creases(mesh))
    corners = list(zip(mesh.GetCornerIndicesAttr().Get() or [], mesh.GetCornerSharpnessesAttr().Get() or []))
    rows = [(len(counts), len(vertices), len(points), len(uvs)), counts, vertices, *points, indices, *uvs]
    rows += [("creases", len(edges)), *edges, ("corners", len(corners)), *corners]
    rows += [("boundary", mesh.GetInterpolateBoundaryAttr().Get())]
    rows += [("linear", mesh.GetFaceVaryingLinearInterpolationAttr().Get())]
    with open(sys.argv[2], "w", encoding="ascii") as file:
        for row in rows:
            print(*(f"{x:.9g}" if isinstance(x, float) else x for x in row), file=file)


main()
