#!/usr/bin/env python3
"""Draws the picture of the README: the input, the simulation mesh and the render mesh.

    picture.py BUILT.usda [-o coat.png] [--size 1800x820] [--view AZ,EL]

BUILT is a stage with /NAME/model, /NAME/sim and /NAME/render.  A missing mesh leaves its column
empty and is reported."""
import argparse
import sys
from pathlib import Path

from PIL import Image, ImageDraw
from pxr import Usd

import draw

COLUMNS = (("model", "input"), ("sim", "simulation mesh"), ("render", "render mesh"))
MARGIN, LABEL = 20, 88      # pixels


def count(mesh):
    names = {3: "triangles", 4: "quads"}
    kinds = set(mesh.counts.tolist())
    kind = names[kinds.pop()] if len(kinds) == 1 and kinds <= set(names) else "faces"
    return f"{len(mesh.counts):,} {kind}, {len(mesh.points):,} points"


def compose(stage, size, view, color):
    root = stage.GetDefaultPrim()
    if not root:
        raise SystemExit("the stage has no default prim")
    columns, missing = [], []
    for child, label in COLUMNS:
        prim = root.GetChild(child)
        found = draw.load(stage, [prim.GetPath()]) if prim else []
        if not found:
            missing.append(f"{root.GetPath()}/{child}")
        columns.append((label, found))
    everything = [m for _, meshes in columns for m in meshes]
    if not everything:
        raise SystemExit(f"nothing to draw: no mesh at {', '.join(missing)}")
    width, height = size[0] // len(columns), size[1] - LABEL
    camera = draw.Camera.fit(everything, view, (width - MARGIN, height - MARGIN))
    background = tuple(int(c * 255 + 0.5) for c in draw.BACKGROUND)
    image = Image.new("RGB", size, background)
    pen = ImageDraw.Draw(image)
    for k, (label, meshes) in enumerate(columns):
        middle = k * width + width // 2
        if meshes:
            # Dense wires are drawn lighter.
            dense = max(len(m.counts) for m in meshes) > 6000
            style = draw.Style(size=(width - MARGIN, height - MARGIN), color=color, wire=True,
                               line=0.75 if dense else 1.1,
                               wire_strength=0.45 if dense else 0.62, samples=3)
            part = draw.render(meshes, camera, style)
            image.paste(part, (k * width + MARGIN // 2, MARGIN // 2))
        pen.text((middle, size[1] - LABEL + 22), label, fill=(25, 28, 38), anchor="mm",
                 font_size=30)
        note = ", ".join(count(m) for m in meshes) if meshes else "not built"
        pen.text((middle, size[1] - LABEL + 58), note, fill=(105, 110, 122), anchor="mm",
                 font_size=20)
    return image, missing


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("stage")
    parser.add_argument("-o", "--output", default=Path(__file__).resolve().parent / "coat.png")
    parser.add_argument("--size", default="1800x820")
    parser.add_argument("--view", default="24,6")
    parser.add_argument("--color", default="displayColor", help="as for draw.py")
    args = parser.parse_args()
    size = tuple(int(n) for n in args.size.split("x"))
    image, missing = compose(Usd.Stage.Open(args.stage), size, args.view, args.color)
    image.save(args.output, optimize=True)
    for path in missing:
        print(f"no mesh at {path}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
