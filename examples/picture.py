#!/usr/bin/env python3
"""Draws what a build wrote: the input, the simulation mesh and the render mesh, side by side.

    picture.py BUILT.usda -o OUT.png [--size 592x700] [--view AZ,EL] [--color displayColor]

BUILT is a stage with /NAME/model, /NAME/sim and /NAME/render.  A missing mesh is left out and reported."""
import argparse
import sys

from pxr import Usd

import draw

COLUMNS = {"model": "input", "sim": "simulation mesh", "render": "render mesh"}


def count(mesh):
    names = {3: "triangles", 4: "quads"}
    kinds = set(mesh.counts.tolist())
    kind = names[kinds.pop()] if len(kinds) == 1 and kinds <= set(names) else "faces"
    return f"{len(mesh.counts):,} {kind}, {len(mesh.points):,} points"


def row(stage, size=(592, 700), view="24,6", note=None, **style):
    """The meshes of a stage as a row of a sheet, each with a note, else with its counts."""
    root = stage.GetDefaultPrim()
    if not root:
        raise SystemExit("the stage has no default prim")
    found = {name: draw.load(stage, [root.GetPath().AppendChild(name)]) for name in COLUMNS}
    if not any(found.values()):
        raise SystemExit(f"nothing to draw: no mesh at {', '.join(f'{root.GetPath()}/{name}' for name in found)}")
    camera = draw.Camera.fit(sum(found.values(), []), view, size)
    tiles = []
    for name, meshes in found.items():
        if not meshes:
            print(f"no mesh at {root.GetPath()}/{name}", file=sys.stderr)
            continue
        # Dense wires are drawn lighter. Those of a dense render mesh would hide its seams.
        most = max(len(m.counts) for m in meshes)
        dense = most > 6000
        wires = {"wire": name != "render" or most < 12000, "line": 0.75 if dense else 1.1,
                 "wire_strength": 0.45 if dense else 0.62, "samples": 3}
        image = draw.render(meshes, camera, **{**wires, **style})
        tiles.append((image, f"{COLUMNS[name]}\n{note or ', '.join(map(count, meshes))}"))
    return tiles


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("stage")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--size", default="592x700", help="pixels of each mesh")
    parser.add_argument("--view", default="24,6")
    parser.add_argument("--color", default="displayColor", help="as for draw.py")
    args = parser.parse_args()
    size = tuple(int(n) for n in args.size.split("x"))
    tiles = row(Usd.Stage.Open(args.stage), size, args.view, color=args.color)
    draw.sheet([tiles], font=30).save(args.output, optimize=True)
    return 1 if len(tiles) < len(COLUMNS) else 0


if __name__ == "__main__":
    sys.exit(main())
