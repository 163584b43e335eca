#!/usr/bin/env python3
"""Draw close-ups of the simulation mesh of a built stage, in a row: the regions that are hardest to remesh.

    closeups.py BUILT.usda -o closeups.png [--at NAME=X,Y,Z,RADIUS,AZ,EL ...]

Without --at, they show examples/coat.usda: collar, cuff, lapel, and four panels that meet under the arm."""
import argparse

from PIL import Image, ImageDraw
from pxr import Usd

import draw

COAT = ["collar=0,143,2,19,20,20", "cuff=45,91,3,13,60,5", "four panels=19,122,-1,9,90,-20",
        "lapel=8,125,10,14,15,5"]
SIDE, LABEL = 700, 44       # pixels


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("stage")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--at", action="append", help="name=x,y,z,radius,azimuth,elevation, in world space")
    parser.add_argument("--child", default="sim", help="which child of the default prim (model, sim, render)")
    args = parser.parse_args()
    stage = Usd.Stage.Open(args.stage)
    meshes = draw.load(stage, [stage.GetDefaultPrim().GetPath().AppendChild(args.child)])
    if not meshes:
        raise SystemExit(f"no mesh {args.child} in {args.stage}: build it first")
    places = [place.split("=") for place in args.at or COAT]
    image = Image.new("RGB", (SIDE * len(places), SIDE + LABEL), (247, 246, 244))
    pen = ImageDraw.Draw(image)
    for k, (name, numbers) in enumerate(places):
        x, y, z, radius, azimuth, elevation = map(float, numbers.split(","))
        size = (SIDE - 8, SIDE - 8)
        camera = draw.Camera.fit(meshes, f"{azimuth},{elevation}", size, (x, y, z, radius))
        style = draw.Style(size=size, wire=True, edges=True, flat=True)
        image.paste(draw.render(meshes, camera, style), (k * SIDE + 4, 4))
        pen.text((k * SIDE + SIDE // 2, SIDE + LABEL // 2), name, fill=(25, 28, 38), anchor="mm", font_size=24)
    image.save(args.output)


if __name__ == "__main__":
    main()
