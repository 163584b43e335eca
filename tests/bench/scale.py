"""Time and peak memory of whole builds of garments of 10,000 to 1,000,000 quads.

    target/venv/bin/python tests/bench/scale.py target/release/usdtailor [OTHER ...] [--quads 10000 100000] [--rounds 3]

Programs that are named together build the same garments in turn, so that their times can be compared. The garment is a
tube with UVs, painted weights, skinning, a face set and an edge set; the triangles are two for each quad, the render mesh
has four faces for each.
"""

import argparse
import math
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt


def tube(file, quads):
    """A tube of about `quads` quads, open at both ends, with one UV seam."""
    around = max(8, round(math.sqrt(quads)))
    along = max(4, round(quads / around))
    turn, height = np.meshgrid(np.arange(around), np.arange(along + 1))
    angle = 2 * np.pi * turn / around
    radius = 30 + 3 * np.sin(3 * angle) + 2 * np.cos(height / along * 9)
    points = np.stack([radius * np.cos(angle), 120 * height / along, radius * np.sin(angle)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(along))
    next_i = (i + 1) % around
    faces = np.stack([j * around + i, (j + 1) * around + i, (j + 1) * around + next_i, j * around + next_i], -1)
    uv = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
    st = np.stack([np.stack([a / around, b / along], -1) for a, b in uv], -2).reshape(-1, 2)

    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Tube").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Tube/model")
    count = around * along
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(count, 4, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.reshape(-1).astype(np.int32)))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    varying = UsdGeom.Tokens.faceVarying
    primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, varying).Set(
        Vt.Vec2fArray.FromNumpy(st.astype(np.float32))
    )
    weights = (0.5 + 0.5 * np.sin(points[:, 1] / 10)).astype(np.float32)
    primvars.CreatePrimvar("stiffness", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex).Set(
        Vt.FloatArray.FromNumpy(weights)
    )
    joints = primvars.CreatePrimvar("skel:jointIndices", Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.vertex, 4)
    joints.Set(Vt.IntArray.FromNumpy(np.tile(np.arange(4, dtype=np.int32), len(points))))
    skin = primvars.CreatePrimvar("skel:jointWeights", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex, 4)
    skin.Set(Vt.FloatArray.FromNumpy(np.tile(np.full(4, 0.25, np.float32), len(points))))
    waist = Vt.IntArray.FromNumpy(np.arange(count // 3, count // 2, dtype=np.int32))
    UsdGeom.Subset.CreateGeomSubset(mesh, "waist", UsdGeom.Tokens.face, waist)
    row = along // 2 * around
    belt = np.stack([row + np.arange(around), row + (np.arange(around) + 1) % around], -1).reshape(-1)
    UsdGeom.Subset.CreateGeomSubset(mesh, "belt", UsdGeom.Tokens.edge, Vt.IntArray.FromNumpy(belt.astype(np.int32)))
    stage.GetRootLayer().Save()
    # Two triangles of equal sides for each quad.
    area = 2 * math.pi * 30 * 120 / (2 * count)
    return 2 * math.sqrt(area / math.sqrt(3)), count


def run(program, file, out, length):
    """Seconds and peak memory of one build. [s, MB]"""
    arguments = ["build", file, "-o", out, "--force", "--quiet", "--set", "render.level=1"]
    arguments += ["--set", f"sim.maxEdgeLength={length}", "--set", f"sim.minEdgeLength={length}"]
    start = time.perf_counter()
    child = os.spawnv(os.P_NOWAIT, program, [program, *map(str, arguments)])
    _, status, usage = os.wait4(child, 0)
    if status:
        sys.exit(f"{program} failed on {file} with status {status}")
    return time.perf_counter() - start, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--quads", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--rounds", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for quads in options.quads:
            file = Path(folder) / f"tube{quads}.usdc"
            length, count = tube(file, quads)
            runs = [
                [run(program, file, Path(folder) / "out.usdc", length) for program in options.programs]
                for _ in range(options.rounds)
            ]
            for program, results in zip(options.programs, zip(*runs)):
                seconds, memory = (statistics.median(values) for values in zip(*results))
                print(f"{count:>9} quads  {seconds:8.2f} s  {memory:8.0f} MB  {program}", flush=True)


if __name__ == "__main__":
    main()
