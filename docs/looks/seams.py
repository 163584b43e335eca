#!/usr/bin/env python3
"""Draws seams on small garments that cages.py makes and on the sewn coat, close to where they end, meet and turn.

    seams.py [--usdtailor target/release/usdtailor] [--before OLD] [-o docs/looks/seams] [--only SCENE ...]
             [--set OPTION=VALUE ...] [--plain]

Writes one PNG for each scene, with the meshes of an older program above those of this one. Wires are the edges of the render
mesh; its surface is refined twice more for the picture. --set goes to this program only, --plain leaves the wires out. Run
from the root of the project, with usd-core, numpy and Pillow."""
import argparse
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cages  # noqa: E402
import draw  # noqa: E402
import sew  # noqa: E402

LABEL, SQUARE, WIDE = 26, (440, 440), (880, 270)        # pixels
COAT = Path(sew.__file__).parent / "sewn" / "coat.usda"


@dataclass
class Tile:
    source: object              # a cage, or a file
    options: list
    focus: tuple                # x, y, z, radius
    view: str                   # azimuth, elevation
    key: tuple = (-0.80, 0.50, 0.45)
    prim: str = "/Rim/render"
    shape: tuple = SQUARE
    finer: int = 2              # refinements for the picture


# ------------------------------------------------------------------------------- scenes

def stitch(*names, width=8, normalOffset=-1.5, **options):
    return sum((cages.seam(name, width=width, normalOffset=normalOffset, **options) for name in names), [])


def line(cage, name):
    """The points of an edge set."""
    return cage.points[{n: i for n, _, i in cage.sets}[name]]


def collar():
    shirt, front = cages.shirt(), ((0, 632, 80, 68), "0,12")
    return {
        "no seams": Tile(shirt, [], *front),
        "lines end at the collar": Tile(shirt, stitch("ending"), *front),
        "a line crosses it": Tile(shirt, stitch("crossing"), *front),
        "a shoulder seam ends at it": Tile(shirt, stitch("shoulder"), (85, 690, 0, 50), "75,25"),
    }


def pocket():
    patch, piece = cages.stitched_pocket(), cages.folded_pocket()
    folded = stitch("around", width=6, normalOffset=-1) + ["fold.fold.faces=pocket", "fold.fold.thickness=2"]
    return {
        "a pocket, stitched around": Tile(patch, stitch("around", width=6), (0, 200, 0, 100), "10,10"),
        "its corner": Tile(patch, stitch("around", width=6), (65, 138, -10, 24), "15,10"),
        "a piece with seam and fold": Tile(piece, folded, (56, 146, 0, 32), "30,20"),
    }


def roof():
    cage, place = cages.roof(90), ((0, 25, -18, 48), "30,-55")
    seams = {"8 mm, nearly no offset": (8, 0.1), "3 mm, nearly no offset": (3, 0.1), "8 mm, a groove": (8, -1.5)}
    tiles = {words: Tile(cage, stitch("ridge", width=width, normalOffset=height), *place)
             for words, (width, height) in seams.items()}
    return {"no seam": Tile(cage, [], *place), **tiles}


def coat():
    def tile(*at, view, key=Tile.key):
        return Tile(COAT, [], at, view, key, prim="/Coat/render", finer=1)
    return {
        "shoulder, armhole, sleeve": tile(20.0, 144.5, -1.5, 5.0, view="70,40"),
        "flap and pocket": tile(24.0, 84.5, 12.0, 3.6, view="60,12"),
        "back seam, neck": tile(0.0, 146.5, -11.4, 3.6, view="180,20"),
        "side seam, hem": tile(29.0, 55.6, -1.0, 2.8, view="72,-15", key=(-0.3, 0.6, 0.7)),
    }


def crossing():
    body, shirt = cages.hoodie(), cages.shirt()
    options, arm = stitch("waist", "side", "pocket"), stitch("armhole", "side", "sleeve")
    return {
        "side seam over a waistband": Tile(body, options, (*line(body, "side")[4], 32), "90,5"),
        "a pocket's seam ends there": Tile(body, options, (*line(body, "pocket")[0], 32), "36,5"),
        "four seams under an arm": Tile(shirt, arm, (*line(shirt, "sleeve")[0], 36), "90,-65", (-0.7, 0.2, 0.6)),
    }


def uneven():
    tiles = {}
    for name, (cage, width) in cages.uneven_sheets().items():
        across = np.ptp(line(cage, "seam")[:, 0])
        place = (0, -0.06 * across, 0, 0.155 * across), "0,10", (-0.35, 0.8, 0.6)
        tiles[name] = Tile(cage, stitch("seam", width=width), *place, shape=WIDE)
    return tiles


SCENES = {scene.__name__: scene for scene in (collar, pocket, roof, coat, crossing, uneven)}


# ------------------------------------------------------------------------------- pictures

def picture_of(tile, program, options, refiner, wire):
    """One tile: the render mesh of a program, refined further by another one."""
    mesh = cages.build(program, tile.source, tile.options + options, prim=tile.prim)
    surface = cages.build(refiner, cages.Again(mesh), level=tile.finer)
    sew.keep_cage_edges(surface, mesh)
    size = tuple(n - 6 for n in tile.shape)
    camera = draw.Camera.fit([surface], tile.view, size, tile.focus)
    colour = "none" if tile.source is COAT else "displayColor"
    light = {"key": tile.key, "key_strength": 0.95, "ambient": 0.28}
    style = draw.Style(size=size, color=colour, wire=wire, line=0.7, wire_strength=0.3, samples=3, **light)
    around = replace(camera, radius=camera.radius * size[0] / size[1])
    return draw.render(sew.near(surface, around), camera, style)


def picture(programs, tiles, wire):
    """The tiles for each program, in rows."""
    wide, high = next(iter(tiles.values())).shape
    columns = min(len(tiles), 4 * SQUARE[0] // wide)
    rows = -(-len(tiles) // columns)
    image = Image.new("RGB", (columns * wide, len(programs) * rows * (high + LABEL)), (247, 246, 244))
    pen = ImageDraw.Draw(image)
    for p, (word, program, options) in enumerate(programs):
        for k, (name, tile) in enumerate(tiles.items()):
            x, y = k % columns * wide, (p * rows + k // columns) * (high + LABEL)
            image.paste(picture_of(tile, program, options, programs[0][1], wire), (x + 3, y + 3))
            pen.text((x + wide // 2, y + high + LABEL // 2), word + name, fill=(25, 28, 38), anchor="mm", font_size=17)
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="docs/looks/seams", help="start of the names of the pictures")
    parser.add_argument("--usdtailor", default="target/release/usdtailor")
    parser.add_argument("--before", help="an older usdtailor to compare with")
    parser.add_argument("--only", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--set", action="append", default=[], metavar="OPTION=VALUE", help="options of this program")
    parser.add_argument("--plain", action="store_true", help="no wires")
    args = parser.parse_args()
    programs = [("before: ", args.before, [])] if args.before else []
    programs.append(("after: " if args.before else "", args.usdtailor, args.set))
    for scene in args.only:
        path = f"{args.output}_{scene}.png"
        picture(programs, SCENES[scene](), not args.plain).save(path, optimize=True)
        print(path, flush=True)


if __name__ == "__main__":
    main()
