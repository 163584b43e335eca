#!/usr/bin/env python3
"""Draws how simulation meshes follow folds thinner than the target length.

    folds.py [-o docs/looks/folds.png] [--before OLD] [--usdtailor target/release/usdtailor] [--garments FOLDER]

The first row has small garments that the script makes: turned hems with layers a tenth and half a target length apart, a
collar and a button. With --garments, a second row has close-ups of garments in a folder, as far as they are there. Each has
the mesh of an older program above that of this one. Run from the root of the project, with usd-core, numpy and Pillow."""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from pxr import Sdf, Usd, UsdGeom, Vt

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import draw  # noqa: E402

SIDE, LABEL = 300, 24       # pixels
AROUND = 24                 # faces around each form
RADIUS = 6.0                # target lengths


def revolved(profile, faces=AROUND):
    """Points, counts and indices of a surface around y through (radius, height), with `faces` of 24 around."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    points = [(r * np.cos(a), y, -r * np.sin(a)) for r, y in profile for a in angles]
    at = lambda row, k: row * AROUND + k % AROUND  # noqa: E731
    quads = [[at(row, k), at(row, k + 1), at(row + 1, k + 1), at(row + 1, k)]
             for row in range(len(profile) - 1) for k in range(faces)]
    return points, [4] * len(quads), sum(quads, [])


def hem(gap):
    inner = RADIUS - gap
    return revolved([(inner, 3), (inner, 1.5), (inner, 0), (RADIUS, 0), (RADIUS, 1.5), (RADIUS, 3), (RADIUS, 6), (RADIUS, 9)])


def collar(gap):
    profile = [(RADIUS - gap, 0), (RADIUS - gap, 1.5), (RADIUS - gap, 3), (RADIUS, 3), (RADIUS, 1.5), (RADIUS + 0.2, 0)]
    points, counts, indices = revolved(profile, faces=18)
    used, indices = np.unique(np.reshape(indices, (-1, 4))[:, ::-1], return_inverse=True)
    return [points[i] for i in used], counts, indices.ravel().tolist()


def button():
    """A disk of one length across, with a rim a quarter of a length high."""
    points, counts, indices = revolved([(0.5, 0), (1, 0), (1, 0.25), (0.5, 0.3)])
    for row, turn in ((0, -1), (3, 1)):
        first = row * AROUND
        counts.append(AROUND)
        indices += [first + k for k in range(AROUND)][::turn]
    return points, counts, indices


MADE = {
    "hem, 0.1 lengths": (hem(0.1), (5.5, 0.5, 0, 2), "80,-25"),
    "hem, 0.5 lengths": (hem(0.5), (5.5, 0.5, 0, 2), "80,-25"),
    "collar, 0.2 lengths": (collar(0.2), (6, 2.6, 0, 2.2), "80,35"),
    "button": (button(), (0, 0.1, 0, 1.4), "30,50"),
}
REAL = {
    "brim": ("fedora.usdc", (0.17, 7.71, 1.88, 0.3), "0,-30"),
    "cuff": ("female_elegantsuit01.usdc", (4.24, 1.6, 1.6, 0.4), "45,-10"),
    "button of a coat": ("male_worksuit01.usdc", (-1.56, 9.58, 0.45, 0.22), "-60,10"),
    "rim of a shoe": ("shoes01.usdc", (2.38, -7.43, 0.29, 0.3), "80,10"),
}


def write(path, shape):
    points, counts, indices = shape
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Fold").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Fold/model")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.array(points, np.float32)))
    mesh.CreateFaceVertexCountsAttr(counts)
    mesh.CreateFaceVertexIndicesAttr(indices)
    # UVs that are cut along one line.
    firsts = np.cumsum([0, *counts[:-1]])
    uvs = [(column + AROUND * (column == 0 and AROUND - 1 in columns), v // AROUND)
           for first, count in zip(firsts, counts)
           for columns in [[w % AROUND for w in indices[first:first + count]]]
           for v, column in zip(indices[first:first + count], columns)]
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(np.array(uvs, np.float32)))
    stage.Save()


def simulation(usdtailor, source, *options):
    """The simulation mesh that a program builds of a garment."""
    with tempfile.TemporaryDirectory() as folder:
        built = str(Path(folder) / "built.usda")
        command = [usdtailor, "build", str(source), "-o", built, "--quiet", *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        stage = Usd.Stage.Open(built)
        return draw.load(stage, [stage.GetDefaultPrim().GetPath().AppendChild("sim")])


def rows(folder, garments):
    """For each row its tiles: name, file, options, focus and view."""
    made = []
    for k, (name, (shape, focus, view)) in enumerate(MADE.items()):
        path = Path(folder) / f"made{k}.usda"
        write(path, shape)
        made.append((name, path, ["--set", "sim.maxEdgeLength=1"], focus, view))
    real = [(name, garments / file, [], focus, view) for name, (file, focus, view) in REAL.items()
            if garments and (garments / file).exists()]
    return [row for row in (made, real) if row]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="docs/looks/folds.png")
    parser.add_argument("--usdtailor", default="target/release/usdtailor")
    parser.add_argument("--before", help="an older usdtailor to compare with")
    parser.add_argument("--garments", type=Path, help="a folder with garments")
    args = parser.parse_args()
    programs = [("before: ", args.before)] if args.before else []
    programs += [("after: " if args.before else "", args.usdtailor)]
    with tempfile.TemporaryDirectory() as folder:
        tiles = rows(folder, args.garments)
        size = (len(MADE) * SIDE, len(tiles) * len(programs) * (SIDE + LABEL))
        image = Image.new("RGB", size, (247, 246, 244))
        pen = ImageDraw.Draw(image)
        lines = [(row, word, program) for row in tiles for word, program in programs]
        for line, (row, word, program) in enumerate(lines):
            for k, (name, source, options, focus, view) in enumerate(row):
                meshes = simulation(program, source, *options)
                camera = draw.Camera.fit(meshes, view, (SIDE - 6, SIDE - 6), focus)
                style = draw.Style(size=(SIDE - 6, SIDE - 6), wire=True, flat=True)
                x, y = k * SIDE, line * (SIDE + LABEL)
                image.paste(draw.render(meshes, camera, style), (x + 3, y + 3))
                pen.text((x + SIDE // 2, y + SIDE + LABEL // 2), word + name, fill=(25, 28, 38), anchor="mm", font_size=15)
    image.quantize(64).save(args.output, optimize=True)


if __name__ == "__main__":
    main()
