#!/usr/bin/env python3
"""Draws the simulation meshes of one garment on several bodies, where `sim.asMade` gives them the same triangles.

    crowd.py USDTAILOR GARMENT OUT.jpg BODY BODY ...

The garment is on the first body. Patches of triangles have the same colour on each body. Prints the angles and edges. Needs usd-core,
numpy and Pillow, and `examples` on the PYTHONPATH."""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

import draw

SIZE, VIEW = (560, 700), "30,8"                         # pixels, degrees
PATCH, SKIN = 1.2, 0.35                                 # units of the stage


def built(program, garment, bodies, folder):
    """The stage of the garment on each body."""
    for body in bodies:
        out = folder / f"{body.stem}.usdc"
        fit = [f"--set=fit.from={bodies[0]}", f"--set=fit.to={body}"] if body != bodies[0] else []
        subprocess.run([program, "build", garment, "-o", out, "--set=sim.asMade=true", *fit], check=True, stdout=subprocess.DEVNULL)
        yield Usd.Stage.Open(str(out))


def angles(mesh):
    """The smallest angle of each triangle in degrees."""
    corners = mesh.points[mesh.tris]
    sides = np.roll(corners, -1, 1) - corners
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    return np.degrees(np.arccos(-np.einsum("tsk,tsk->ts", sides, np.roll(sides, 1, 1)))).min(1)


def skin(body, sim):
    """The body between hem and collar, without its head and wires. It is thinner below the cloth, where it may be outside: programs hide this skin."""
    near = np.concatenate([np.linalg.norm(part[:, None] - sim.points[None], axis=2).min(1) for part in np.array_split(body.points, 100)])
    normals = np.zeros_like(body.points)
    np.add.at(normals, body.tris.ravel(), body.corner_normals(False).reshape(-1, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
    height, (low, high) = body.points[:, 1], np.percentile(sim.points[:, 1], [0, 100])
    body.points = body.points - normals * np.clip(1 - near / (2 * SKIN), 0, 1)[:, None] * SKIN
    body.real[:] = False
    return body.part(((height > low + SKIN) & (height < high - 3 * SKIN))[body.tris].all(1))


def main(program, garment, out, *bodies):
    bodies, tiles, colours = [Path(body) for body in bodies], [], None
    with tempfile.TemporaryDirectory() as folder:
        for body, stage in zip(bodies, built(program, garment, bodies, Path(folder))):
            (sim,) = draw.load(stage, [stage.GetDefaultPrim().GetPath().AppendChild("sim")])
            if colours is None:
                triangles, cells = sim.tris, np.floor(sim.points[sim.tris].mean(1) / PATCH).astype(int)
                colours = 0.45 + 0.55 * draw.palette(7)[cells @ [1, 2, 4] % 7]
            assert np.array_equal(sim.tris, triangles), body
            primvar = UsdGeom.PrimvarsAPI(sim.prim).CreatePrimvar("patches", Sdf.ValueTypeNames.Color3fArray, "uniform")
            primvar.Set(Vt.Vec3fArray.FromNumpy(colours.astype(np.float32)))
            smallest = angles(sim)
            words = f"{len(sim.tris):,} triangles; 95 % of angles above {np.percentile(smallest, 5):.0f}°, all above {int(smallest.min())}°"
            print(body.stem, words, f"mean edge {np.linalg.norm(np.diff(sim.points[sim.tris], axis=1), axis=2).mean():.4f}")
            below = [skin(mesh, sim) for mesh in draw.load(Usd.Stage.Open(str(body)))]
            camera = draw.Camera.fit([sim], VIEW, SIZE, margin=1.02)
            tiles.append((draw.render([sim, *below], camera, color="primvar:patches", wire=True, line=0.6, wire_strength=0.5, samples=3), f"{body.stem}\n{words}"))
    draw.sheet([tiles], font=24).save(out, quality=88, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
