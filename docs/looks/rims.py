#!/usr/bin/env python3
"""Draws where hems end and seams meet, on small garments that it makes itself.

    rims.py -o docs/looks/rims [--before OLD] [--usdtailor target/release/usdtailor] [--only SCENE ...] [--wire]

Writes one PNG for each scene, with the meshes of an older program above those of this one. Run from the root of the
project, with usd-core, numpy and Pillow."""
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


# ------------------------------------------------------------------------------- garments

class Grid:
    """A grid of `nx` by `ny` quads; columns close around where `closed`."""

    def __init__(self, nx, ny, place, closed=False):
        self.nx, self.ny, self.columns = nx, ny, nx if closed else nx + 1
        y, x = np.divmod(np.arange(self.columns * (ny + 1)), self.columns)
        self.points = np.array([place(float(a), float(b)) for a, b in zip(x, y)], np.float32)
        cells = [(x, y) for y in range(ny) for x in range(nx)]
        self.faces = [[self.at(x, y), self.at(x + 1, y), self.at(x + 1, y + 1), self.at(x, y + 1)] for x, y in cells]
        self.sets = []

    def at(self, x, y):
        return y * self.columns + x % self.columns

    def line(self, name, *places):
        """An edge set along straight lines of the grid between `places`."""
        path = [places[0]]
        for target in places[1:]:
            while path[-1] != target:
                (x, y), (u, v) = path[-1], target
                path.append((x + np.sign(u - x), y + np.sign(v - y)))
        ids = [self.at(int(x), int(y)) for x, y in path]
        self.sets.append((name, "edge", [v for pair in zip(ids, ids[1:]) for v in pair]))
        return self

    def patch(self, name, wanted):
        """A face set of the cells (x, y) that are `wanted`."""
        self.sets.append((name, "face", [y * self.nx + x for y in range(self.ny) for x in range(self.nx) if wanted(x, y)]))
        return self

    def write(self, path):
        stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Rim").GetPrim())
        mesh = UsdGeom.Mesh.Define(stage, "/Rim/model")
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(self.points))
        mesh.CreateFaceVertexCountsAttr([4] * len(self.faces))
        mesh.CreateFaceVertexIndicesAttr(sum(self.faces, []))
        uvs = np.array([[self.points[v][0], self.points[v][1]] for face in self.faces for v in face], np.float32)
        primvars = UsdGeom.PrimvarsAPI(mesh)
        primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying").Set(Vt.Vec2fArray.FromNumpy(uvs))
        for name, element, indices in self.sets:
            subset = UsdGeom.Subset.Define(stage, f"/Rim/model/{name}")
            subset.CreateElementTypeAttr(element)
            subset.CreateIndicesAttr([int(i) for i in indices])
        stage.Save()


def sheet(n=8, bend=0.0, kink=0.0, uneven=0.0):
    """A sheet of `n` by `n`, bent about y; beyond the middle its lower border turns by `kink` degrees, and `uneven`
    moves the points along it."""
    def place(x, y):
        fade = 1 - y / n
        x += uneven * 0.3 * np.sin(5.3 * x + 1.7 * y)
        y += uneven * 0.36 * np.sin(4.1 * x + 2.9 * y)
        if x > n / 2:
            y += np.tan(np.radians(kink)) * (x - n / 2) * fade
        a = bend * (x / n - 0.5)
        if bend == 0.0:
            return x, y, 0.0
        return n / bend * np.sin(a), y, n / bend * np.cos(a)
    return Grid(n, n, place)


def pinched():
    """A sheet of which the rows beside the middle one are near it at every third point."""
    def place(x, y):
        near = x % 3 == 1 and y in (3, 5)
        return x, 4 + (0.4 if near else 1) * (y - 4), 0.0
    return Grid(8, 8, place)


def tube(around, rows, height=3.0, flare=0.0):
    def place(x, y):
        a, r = 2 * np.pi * x / around, 1 + flare * y / rows
        return r * np.sin(a), height * y / rows, r * np.cos(a)
    return Grid(around, rows, place, closed=True)


# ------------------------------------------------------------------------------- scenes

HEM = ["fold.h.faces=hem", "fold.h.thickness=0.15"]


def hem(kink, seam=None, bend=1.2):
    garment = sheet(bend=bend, kink=kink).patch("hem", lambda x, y: x < 4 and y < 1)
    options = list(HEM)
    if seam:
        garment.line("seam", (4, 0), (4, 8))
        options += ["seam.s.edges=seam", "seam.s.width=0.4", f"seam.s.normalOffset={seam}"]
    lift = garment.points[garment.at(4, 0)]
    return garment, options, (*(lift + [0, 0.2, 0]), 1.0)


def seams(garment, focus, width=0.42, **lines):
    options = []
    for name, (height, *places) in lines.items():
        garment.line(name, *places)
        options += [f"seam.{name}.edges={name}", f"seam.{name}.width={width}", f"seam.{name}.normalOffset={height}"]
    return garment, options, focus


def cuff(around, flare=0.0, faces=99):
    garment = tube(around, 3, flare=flare).patch("hem", lambda x, y: y < 1 and (x + 1) % around < faces)
    return garment, ["fold.h.faces=hem", "fold.h.thickness=0.12"], (0, 0.7, 0, 1.6)


MIDDLE = (4, 4, 0, 1.3)
SCENES = {
    "hem_ends": {
        "straight": (hem(0), "25,-25"), "inside": (hem(0), "200,-20"), "border turns up": (hem(50), "25,-25"),
        "border turns down": (hem(-50), "25,-25"), "a seam runs in": (hem(0, -0.06), "25,-25"),
        "a ridge runs in": (hem(30, 0.06), "25,-25"),
    },
    "short_seams": {
        "one edge": (seams(sheet(), MIDDLE, a=(-0.12, (4, 4), (5, 4))), "-20,35"),
        "two edges": (seams(sheet(), MIDDLE, a=(-0.12, (3, 4), (5, 4))), "-20,35"),
        "ridge of three": (seams(sheet(), (4, 4, 0, 2), a=(0.12, (3, 4), (6, 4))), "-20,35"),
        "uneven quads": (seams(pinched(), (4, 4, 0, 3), 0.9, a=(-0.12, (0, 4), (8, 4))), "-20,50"),
        "crooked": (seams(sheet(uneven=1), (4, 4, 0, 3.4), a=(0.12, (0, 3), (8, 3))), "-20,50"),
        "stairs": (seams(sheet(), (4, 4, 0, 2.6), a=(0.12, (2, 3), (3, 3), (3, 4), (5, 4), (5, 5), (6, 5))), "-20,50"),
    },
    "crossings": {
        "equal ridges": (seams(sheet(), MIDDLE, a=(0.12, (0, 4), (8, 4)), b=(0.12, (4, 0), (4, 8))), "-20,35"),
        "a T": (seams(sheet(), MIDDLE, a=(0.12, (0, 4), (8, 4)), b=(0.12, (4, 4), (4, 8))), "-20,35"),
        "low through": (seams(sheet(), MIDDLE, a=(0.08, (0, 4), (8, 4)), b=(0.16, (4, 0), (4, 8))), "-20,35"),
        "grooves": (seams(sheet(), MIDDLE, a=(-0.12, (0, 4), (8, 4)), b=(-0.06, (4, 0), (4, 8))), "-20,35"),
        "groove, ridge": (seams(sheet(), MIDDLE, a=(0.12, (0, 4), (8, 4)), b=(-0.12, (4, 0), (4, 8))), "-20,35"),
        "uneven": (seams(sheet(uneven=0.6), MIDDLE, a=(0.12, (0, 4), (8, 4)), b=(0.12, (4, 0), (4, 8))), "-20,35"),
    },
    "bent_faces": {
        "six around": (cuff(6), "15,-25"), "five, flared": (cuff(5, 0.4), "15,-25"), "four around": (cuff(4), "15,-25"),
        "half of six": (cuff(6, faces=3), "15,-25"), "half, inside": (cuff(6, faces=3), "190,-35"),
        "two of four": (cuff(4, faces=2), "60,-30"),
    },
}


def render(usdtailor, garment, options):
    """The render mesh that a program builds of a garment."""
    with tempfile.TemporaryDirectory() as folder:
        source, built = (str(Path(folder) / file) for file in ("rim.usda", "built.usda"))
        garment.write(source)
        sets = [word for option in ["render.level=3", *options] for word in ("--set", option)]
        subprocess.run([usdtailor, "build", source, "-o", built, *sets], check=True, stdout=subprocess.DEVNULL)
        return draw.load(Usd.Stage.Open(built), ["/Rim/render"])


def picture(programs, scene, wire):
    """The tiles of a scene in rows of three, for each program."""
    tiles = SCENES[scene]
    rows = -(-len(tiles) // 3)
    image = Image.new("RGB", (3 * SIDE, len(programs) * rows * (SIDE + LABEL)), (247, 246, 244))
    pen = ImageDraw.Draw(image)
    for p, (word, usdtailor) in enumerate(programs):
        for k, (name, ((garment, options, focus), view)) in enumerate(tiles.items()):
            meshes = render(usdtailor, garment, options)
            camera = draw.Camera.fit(meshes, view, (SIDE - 6, SIDE - 6), focus)
            tile = draw.render(meshes, camera, draw.Style(size=(SIDE - 6, SIDE - 6), wire=wire))
            x, y = k % 3 * SIDE, (p * rows + k // 3) * (SIDE + LABEL)
            image.paste(tile, (x + 3, y + 3))
            pen.text((x + SIDE // 2, y + SIDE + LABEL // 2), word + name, fill=(25, 28, 38), anchor="mm", font_size=15)
    return image.quantize(128)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="docs/looks/rims", help="start of the names of the pictures")
    parser.add_argument("--usdtailor", default="target/release/usdtailor")
    parser.add_argument("--before", help="an older usdtailor to compare with")
    parser.add_argument("--only", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--wire", action="store_true", help="draw the edges of the faces")
    args = parser.parse_args()
    programs = [("before: ", args.before)] if args.before else []
    programs.append(("after: " if args.before else "", args.usdtailor))
    for scene in args.only:
        path = f"{args.output}_{scene}.png"
        picture(programs, scene, args.wire).save(path, optimize=True)
        print(path)


if __name__ == "__main__":
    main()
