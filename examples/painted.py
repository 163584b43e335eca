#!/usr/bin/env python3
"""Shows the transfer of colours: a 1 cm checker by UVs, a gradient by points, and one colour for each face.

    painted.py paint coat.usda painted.usda       adds a gradient and face colours to the garment
    cargo usdtailor build painted.usda -o built.usda
    painted.py draw built.usda [-o painted.png]   draws the three meshes in columns and the kinds of colour in rows"""
import argparse
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

import draw

COLUMNS = (("model", "input"), ("sim", "simulation mesh"), ("render", "render mesh"))
ROWS = (("uv", "1 cm checker by st"), ("primvar:gradient", "gradient, one value per point"),
        ("primvar:patches", "one colour per face"))
CELL, MARGIN, LABEL = (470, 560), 16, 46      # pixels
LOW, HIGH = np.array([0.13, 0.20, 0.52]), np.array([0.98, 0.72, 0.30])


def paint(source, out):
    """Writes a layer over `source` that adds a gradient and a colour for each face."""
    layer = Sdf.Layer.CreateNew(str(out))
    layer.subLayerPaths = [str(Path(source).resolve())]
    stage = Usd.Stage.Open(layer)
    base = Usd.Stage.Open(str(source))
    for key in ("defaultPrim", "upAxis", "metersPerUnit"):
        if base.HasAuthoredMetadata(key):
            stage.SetMetadata(key, base.GetMetadata(key))
    prim = base.GetDefaultPrim().GetChild("model")
    mesh = UsdGeom.Mesh(stage.OverridePrim(prim.GetPath()))
    points = np.array(mesh.GetPointsAttr().Get())
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get())
    height = (points[:, 1] - points[:, 1].min()) / np.ptp(points[:, 1])
    api, kind = UsdGeom.PrimvarsAPI(mesh), Sdf.ValueTypeNames.Color3fArray
    gradient = LOW + (HIGH - LOW) * height[:, None]
    api.CreatePrimvar("gradient", kind, "vertex").Set(Vt.Vec3fArray([Gf.Vec3f(*map(float, c)) for c in gradient]))
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    centres = np.add.reduceat(points[corners], starts) / counts[:, None]
    # Patches two faces wide; neighbours differ in colour.
    band = (np.floor(centres[:, 1] / 8).astype(int) + np.floor(np.arctan2(centres[:, 0], centres[:, 2]) * 4).astype(int)) % 5
    patches = draw.palette(5)[band]
    api.CreatePrimvar("patches", kind, "uniform").Set(Vt.Vec3fArray([Gf.Vec3f(*map(float, c)) for c in patches]))
    layer.Save()


def compose(stage, view):
    root = stage.GetDefaultPrim()
    meshes = {name: draw.load(stage, [root.GetChild(name).GetPath()]) for name, _ in COLUMNS}
    scale = UsdGeom.PrimvarsAPI(root.GetChild("model")).GetPrimvar("stScale").Get() or 1.0
    everything = [m for found in meshes.values() for m in found]
    size = (CELL[0] - MARGIN, CELL[1] - MARGIN)
    camera = draw.Camera.fit(everything, view, size)
    background = tuple(int(c * 255 + 0.5) for c in draw.BACKGROUND)
    image = Image.new("RGB", (CELL[0] * len(COLUMNS), (CELL[1] + LABEL) * len(ROWS)), background)
    pen = ImageDraw.Draw(image)
    for j, (color, row) in enumerate(ROWS):
        for i, (name, column) in enumerate(COLUMNS):
            style = draw.Style(size=size, color=color, wire=color != "uv", line=0.6, wire_strength=0.35, samples=3,
                               checker=1.0 / scale)
            at = (i * CELL[0] + MARGIN // 2, j * (CELL[1] + LABEL) + MARGIN // 2)
            image.paste(draw.render(meshes[name], camera, style), at)
            note = (at[0] + CELL[0] // 2, at[1] + CELL[1] + LABEL // 2 - MARGIN // 2)
            pen.text(note, f"{column}: {row}", fill=(25, 28, 38), anchor="mm", font_size=19)
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("paint")
    one.add_argument("source")
    one.add_argument("out")
    two = commands.add_parser("draw")
    two.add_argument("stage")
    two.add_argument("-o", "--output", default=Path(__file__).resolve().parent / "painted.png")
    two.add_argument("--view", default="24,6")
    args = parser.parse_args()
    if args.command == "paint":
        paint(args.source, args.out)
    else:
        compose(Usd.Stage.Open(args.stage), args.view).save(args.output, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
