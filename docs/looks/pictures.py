#!/usr/bin/env python3
"""Draws the pictures of meshes in examples/ and docs/, for `cargo xtask picture`.

    pictures.py USDTAILOR [NAME ...] [--before OLD]

Pictures that compare with an older program are drawn only with it. Wires of close-ups are the edges of the render mesh; its
surface is refined further for the picture. Needs usd-core, numpy and Pillow."""
import argparse
import os
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

import cages
import draw
import named
import picture

ROOT = Path(__file__).resolve().parents[2]
COAT, SEWN = ROOT / "examples/coat.usda", ROOT / "examples/sewn/coat.usda"
# Garments that are not in the project: without them, pictures of them are not drawn.
REAL = Path(os.environ.get("TAILOR_GARMENTS", "no garments"))
SQUARE, WIDE = (434, 434), (874, 264)                   # pixels


# ------------------------------------------------------------------------------- the three meshes

def coat(program):
    return draw.sheet([picture.row(cages.products(program, COAT, ["render.level=1"]), color="displayColor")], font=30)


def paint(path):
    """Writes a layer over the coat that adds a gradient and a colour for each face."""
    layer = Sdf.Layer.CreateNew(str(path))
    layer.subLayerPaths = [str(COAT)]
    stage, base = Usd.Stage.Open(layer), Usd.Stage.Open(str(COAT))
    for key in ("defaultPrim", "upAxis", "metersPerUnit"):
        stage.SetMetadata(key, base.GetMetadata(key))
    mesh = cages.product(stage, "model")
    low, high = np.array([0.13, 0.20, 0.52]), np.array([0.98, 0.72, 0.30])
    height = (mesh.points[:, 1] - mesh.points[:, 1].min()) / np.ptp(mesh.points[:, 1])
    x, y, z = (np.add.reduceat(mesh.points[mesh.indices], mesh.starts) / mesh.counts[:, None]).T
    # Patches two faces wide; neighbours differ in colour.
    patches = (np.floor(y / 8).astype(int) + np.floor(np.arctan2(x, z) * 4).astype(int)) % 5
    for name, kind, colours in (("gradient", "vertex", low + (high - low) * height[:, None]),
                                ("patches", "uniform", draw.palette(5)[patches])):
        primvar = UsdGeom.PrimvarsAPI(mesh.prim).CreatePrimvar(name, Sdf.ValueTypeNames.Color3fArray, kind)
        primvar.Set(Vt.Vec3fArray.FromNumpy(colours.astype(np.float32)))
    layer.Save()


def painted(program):
    stage = cages.products(program, SimpleNamespace(write=paint), ["render.level=1"])
    scale = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Coat/model")).GetPrimvar("stScale").Get()
    kinds = {"uv": "1 cm checker by st", "primvar:gradient": "gradient, one value per point",
             "primvar:patches": "one colour per face"}
    return draw.sheet([picture.row(stage, (464, 544), note=words, color=color, wire=color != "uv", line=0.6,
                                   wire_strength=0.35, checker=1 / scale) for color, words in kinds.items()], font=24)


def panels(program):
    sim = cages.product(cages.products(program, SEWN), "sim")
    points, corners = (np.array(sim.prim.GetAttribute(f"physics:{name}").Get())
                       for name in ("restShapePoints", "restTriVertexIndices"))
    rest = draw.Mesh("", np.asarray(points, float), np.full(corners.size // 3, 3), corners.ravel())
    camera = draw.Camera.fit([rest], size=(1400, 1420), margin=1.02)
    return draw.render(rest, camera, wire=True, line=0.75, wire_strength=0.5, samples=3, ambient=0.55).quantize(64)


# ------------------------------------------------------------------------------- the sewn coat

CUT = (160, 30, 30)
# Title, ball to show (x, y, z, radius), view (azimuth, elevation), and cutting plane (point, normal) or None.
CLOSE_UPS = (
    ("seam: a dart, which ends in the surface", (11.3, 110.0, 14.0, 4.2), "20,5", None),
    ("T junctions: shoulder, armhole, sleeve", (20.0, 144.5, -1.5, 6.0), "70,40", None),
    ("T junction: side seam and hem", (29.0, 55.6, -1.0, 2.8), "72,-15", None),
    ("collar, cut behind the neck", (0.0, 149.2, -10.4, 6.0), "90,0", ((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))),
    ("hem folded over, cut", (8.0, 56.0, -17.6, 2.4), "78,6", ((8.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    ("pocket and flap", (21.5, 86.0, 12.0, 5.5), "60,12", None),
)


def keep_cage_edges(surface, cage):
    """Limits the wires of a refined mesh to the edges of its cage.

    Child faces have the order of the cage's corners, so an edge between two children of one face is not a cage edge."""
    corners, fours = len(cage.indices), len(surface.counts) // len(cage.indices)
    if len(surface.counts) != corners * fours:
        raise SystemExit("the surface is not a refinement of the cage: build both from the same layer")
    parent = np.repeat(np.repeat(np.arange(len(cage.counts)), cage.counts), fours)
    face = np.repeat(np.arange(len(surface.counts)), surface.counts)
    pairs = np.sort(surface.edges(), axis=1)
    keys = pairs[:, 0] * len(surface.points) + pairs[:, 1]
    order = np.argsort(keys, kind="stable")
    same = (np.diff(keys[order]) == 0) & (np.diff(parent[face[order]]) == 0)
    inner = keys[order][:-1][same]
    sides = np.sort(np.stack([np.roll(surface.tris, -1, 1), np.roll(surface.tris, -2, 1)], 2), axis=2)
    surface.real = surface.real & ~np.isin(sides[..., 0] * len(surface.points) + sides[..., 1], inner)


def behind(mesh, plane):
    """The triangles of a mesh behind a plane, and the plane's cut as pairs of points."""
    point, normal = np.array(plane)
    height = (mesh.points - point) @ normal
    at = height[mesh.tris]
    ends = []
    intersected = (at.min(1) < 0) & (at.max(1) >= 0)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        share = at[:, a] / np.where(at[:, a] == at[:, b], 1, at[:, a] - at[:, b])
        p, q = mesh.points[mesh.tris[:, a]], mesh.points[mesh.tris[:, b]]
        ends.append(np.where(((at[:, a] < 0) != (at[:, b] < 0))[:, None], p + (q - p) * share[:, None], np.nan))
    ends = np.stack(ends, 1)[intersected]
    cut = np.array([row[~np.isnan(row[:, 0])] for row in ends])
    return mesh.part(at.mean(1) < 0), cut


def sewn(program):
    """The input, the render mesh with the wires of its first refinement, and close-ups of the latter."""
    stages = [cages.products(program, SEWN, [f"render.level={level}", "render.seamLevel=1"]) for level in (1, 3)]
    model, cage, surface = (cages.product(stages[i], name) for i, name in ((0, "model"), (0, "render"), (1, "render")))
    keep_cage_edges(surface, cage)
    camera = draw.Camera.fit([model, surface], "24,6", (894, 894))
    whole = {f"input cage: {len(model.counts):,} faces": model,
             f"render mesh, with the wires of its first refinement: {len(cage.counts):,} faces": surface}
    rows = [[(draw.render(mesh, camera, wire=True, line=0.8, wire_strength=0.5, samples=3), words)
             for words, mesh in whole.items()], [], []]
    for k, (words, ball, view, plane) in enumerate(CLOSE_UPS):
        mesh, cut = behind(surface, plane) if plane else (surface, np.zeros((0, 2, 3)))
        camera = draw.Camera.fit([mesh], view, (594, 494), ball)
        image = draw.render(mesh, camera, [(cut, CUT, 3.5)], wire=True, line=0.65, wire_strength=0.34, samples=4)
        rows[1 + k // 3].append((image, words))
    return draw.sheet(rows, font=22)


# ------------------------------------------------------------------------------- close-ups

@dataclass
class Tile:
    source: object              # a small garment, or a file
    options: list
    focus: tuple                # x, y, z, radius
    view: str                   # azimuth, elevation
    key: tuple = (-0.80, 0.50, 0.45)
    shape: tuple = SQUARE
    finer: int = 2              # refinements for the picture; 0 draws the simulation mesh


def close_up(tile, program, refiner):
    """The render mesh of a program, refined further by another one, or its simulation mesh."""
    if not tile.finer:
        mesh = cages.product(cages.products(program, tile.source, tile.options), "sim")
        return draw.render(mesh, draw.Camera.fit([mesh], tile.view, tile.shape, tile.focus), wire=True, flat=True)
    mesh = cages.build(program, tile.source, tile.options)
    surface = cages.build(refiner, cages.Again(mesh), level=tile.finer)
    keep_cage_edges(surface, mesh)
    camera = draw.Camera.fit([surface], tile.view, tile.shape, tile.focus)
    return draw.render(surface, camera, color="none" if tile.source == SEWN else "displayColor", wire=True, line=0.7,
                       wire_strength=0.3, samples=3, key=tile.key, key_strength=0.95, ambient=0.28)


def stitch(*names, width=8, normalOffset=-1.5, **options):
    return sum((cages.seam(name, width=width, normalOffset=normalOffset, **options) for name in names), [])


def line(cage, name):
    """The points of an edge set."""
    return cage.points[{n: i for n, _, i in cage.sets}[name]]


def folds():
    def tile(source, *focus, view, options=()):
        return Tile(source, options, focus, view, finer=0)
    one = {"options": ["sim.maxEdgeLength=1"]}
    found = {
        "hem, 0.1 lengths": tile(cages.turned_hem(0.1), 5.5, 0.5, 0, 2, view="80,-25", **one),
        "hem, 0.5 lengths": tile(cages.turned_hem(0.5), 5.5, 0.5, 0, 2, view="80,-25", **one),
        "collar, 0.2 lengths": tile(cages.standing_collar(0.2), 6, 2.6, 0, 2.2, view="80,35", **one),
        "button": tile(cages.button(), 0, 0.1, 0, 1.4, view="30,50", **one),
        "brim": tile(REAL / "fedora.usdc", 0.17, 7.71, 1.88, 0.3, view="0,-30"),
        "cuff": tile(REAL / "female_elegantsuit01.usdc", 4.24, 1.6, 1.6, 0.4, view="45,-10"),
        "button of a coat": tile(REAL / "male_worksuit01.usdc", -1.56, 9.58, 0.45, 0.22, view="-60,10"),
        "rim of a shoe": tile(REAL / "shoes01.usdc", 2.38, -7.43, 0.29, 0.3, view="80,10"),
    }
    return {name: t for name, t in found.items() if not isinstance(t.source, Path) or t.source.exists()}


def hem_ends():
    def tile(view, kink=0, seam=None):
        garment = cages.sheet(bend=1.2, kink=kink).patch("hem", lambda x, y: x < 4 and y < 1)
        x, y, z = garment.points[garment.at(4, 0)]
        options = ["fold.h.faces=hem", "fold.h.thickness=0.15"]
        if seam:
            garment.line("seam", (4, 0), (4, 8))
            options += stitch("seam", width=0.4, normalOffset=seam)
        return Tile(garment, options, (x, y + 0.2, z, 1.0), view)
    return {
        "straight": tile("25,-25"), "inside": tile("200,-20"), "border turns up": tile("25,-25", 50),
        "border turns down": tile("25,-25", -50), "a seam runs in": tile("25,-25", 0, -0.06),
        "a ridge runs in": tile("25,-25", 30, 0.06),
    }


def seams_under_hems():
    def tile(view, height):
        garment = cages.sheet(bend=0.6).patch("hem", lambda x, y: y < 1).line("seam", (4, 0), (4, 8))
        x, y, z = garment.points[garment.at(4, 0)]
        options = ["fold.h.faces=hem", "fold.h.thickness=0.12", *stitch("seam", width=0.3, normalOffset=height)]
        return Tile(garment, options, (x, y + 0.3, z, 0.8), view)
    return {
        "a groove runs to a hem": tile("10,-15", -0.08), "from inside": tile("190,-20", -0.08),
        "a ridge runs to a hem": tile("10,-15", 0.08), "a ridge, from inside": tile("190,-20", 0.08),
    }


def lines(garment, radius, width=0.42, view="-20,35", **seams):
    """A sheet with seams, each a height and the places along it."""
    options = []
    for name, (height, *places) in seams.items():
        garment.line(name, *places)
        options += stitch(name, width=width, normalOffset=height)
    return Tile(garment, options, (4, 4, 0, radius), view, key=(-0.5, 0.3, 0.9))


def short_seams():
    return {
        "one edge": lines(cages.sheet(), 1.3, a=(-0.12, (4, 4), (5, 4))),
        "two edges": lines(cages.sheet(), 1.3, a=(-0.12, (3, 4), (5, 4))),
        "ridge of three": lines(cages.sheet(), 2, a=(0.12, (3, 4), (6, 4))),
        "uneven quads": lines(cages.pinched(), 3, 0.9, "-20,50", a=(-0.12, (0, 4), (8, 4))),
        "crooked": lines(cages.sheet(uneven=1), 3.4, view="-20,50", a=(0.12, (0, 3), (8, 3))),
        "stairs": lines(cages.sheet(), 2.6, view="-20,50", a=(0.12, (2, 3), (3, 3), (3, 4), (5, 4), (5, 5), (6, 5))),
    }


def crossings():
    def tile(across, up, start=0, uneven=0.0):
        return lines(cages.sheet(uneven=uneven), 1.3, a=(across, (0, 4), (8, 4)), b=(up, (4, start), (4, 8)))
    return {
        "equal ridges": tile(0.12, 0.12), "a T": tile(0.12, 0.12, 4), "low through": tile(0.08, 0.16),
        "grooves": tile(-0.12, -0.06), "groove, ridge": tile(0.12, -0.12), "uneven": tile(0.12, 0.12, uneven=0.6),
    }


def ends():
    def tile(end, height=0.12, offset=0.0):
        garment = cages.sheet().line("a", (2, 4), (5, 4))
        options = stitch("a", width=0.42, normalOffset=height, end=end)
        if offset:
            garment.line("b", (2, 4), (5, 4))
            options += stitch("b", width=0.2, normalOffset=-0.05, end=end, offset=offset)
        return Tile(garment, options, (4.8, 4, 0, 1.3), "-20,40", key=(-0.5, 0.3, 0.9))
    kinds = "taper", "round", "square"
    return {**{end: tile(end) for end in kinds}, **{f"{end}, a groove with a row": tile(end, -0.12, 0.5) for end in kinds}}


def skewed():
    def tile(skew):
        garment = cages.sheet(skew=skew)
        x = 4 + 4 * np.tan(np.radians(skew))
        return replace(lines(garment, 2.2, 0.4, "-20,40", a=(0.12, (0, 4), (8, 4)), b=(0.12, (4, 0), (4, 8))), focus=(x, 4, 0, 2.2))
    return {f"faces skewed by {skew} degrees": tile(skew) for skew in (0, 45, 60, 70)}


def bent_faces():
    def tile(around, view, flare=0.0, faces=99):
        garment = cages.tube(around, 3, flare=flare).patch("hem", lambda x, y: y < 1 and (x + 1) % around < faces)
        return Tile(garment, ["fold.h.faces=hem", "fold.h.thickness=0.12"], (0, 0.7, 0, 1.6), view)
    return {
        "six around": tile(6, "15,-25"), "five, flared": tile(5, "15,-25", 0.4), "four around": tile(4, "15,-25"),
        "half of six": tile(6, "15,-25", faces=3), "half, inside": tile(6, "190,-35", faces=3),
        "two of four": tile(4, "60,-30", faces=2),
    }


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


def sewn_close():
    def tile(*at, view, key=Tile.key):
        return Tile(SEWN, [], at, view, key, finer=1)
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


def rows_before_seams():
    body = cages.hoodie()
    rows = stitch("pocket", width=5, normalOffset=-0.8, offset=9, rows=2)
    view = (*line(body, "pocket")[0], 40), "36,5"
    return {"rows of a pocket's seam end before the waist": Tile(body, stitch("waist", "side", normalOffset=1.2) + rows, *view)}


def uneven():
    tiles = {}
    for name, (cage, width) in cages.uneven_sheets().items():
        across = np.ptp(line(cage, "seam")[:, 0])
        place = (0, -0.06 * across, 0, 0.155 * across), "0,10", (-0.35, 0.8, 0.6)
        tiles[name] = Tile(cage, stitch("seam", width=width), *place, shape=WIDE)
    return tiles


def rows():
    def tile(garment, radius, *places, view="-20,40", middle=(4, 4, 0), **options):
        garment.line("edge", *places)
        return Tile(garment, stitch("edge", **{"width": 0.3, "normalOffset": -0.07, **options}), (*middle, radius), view,
                    key=(-0.5, 0.3, 0.9))
    turned = (1, 2), (5, 2), (5, 7)
    wild = cages.sheet(bend=0.9, uneven=0.8)
    return {
        "a seam with a row on each side": tile(cages.sheet(), 2.4, (2, 4), (6, 4), rows=2, rowGap=0.6),
        "two rows on the left, around a corner": tile(cages.sheet(), 2.6, *turned, offset=0.6, rows=2, side="left"),
        "two rows on the right": tile(cages.sheet(), 2.6, *turned, offset=0.6, rows=2, side="right"),
        "over uneven faces": tile(wild, 2.6, (0, 3), (8, 3), offset=0.8, rows=2, rowGap=0.5, side="left",
                                  middle=tuple(wild.points[wild.at(4, 4)])),
        "inside a border": tile(cages.sheet(), 2.4, (0, 0), (8, 0), (8, 8), offset=0.4, rows=2, rowGap=0.6,
                                middle=(6.5, 1.5, 0)),
        "where they meet": tile(cages.sheet(), 2.8, (2, 2), (6, 2), (6, 4), (2, 4), (2, 2), offset=0.7, width=0.4),
    }


# ------------------------------------------------------------------------------- all of them

PICTURES = {"examples/coat": coat, "examples/sewn": sewn, "examples/painted": painted, "docs/physics/panels": panels,
            "docs/looks/sets_named": named.named_sets}
SCENES = {"rims_hem_ends": hem_ends, "rims_short_seams": short_seams, "rims_crossings": crossings,
          "rims_bent_faces": bent_faces, "seams_rows": rows, "seams_ends": ends}
COMPARED = {"folds": folds, "seams_collar": collar, "seams_hem": seams_under_hems, "seams_pocket": pocket, "seams_roof": roof,
            "seams_coat": sewn_close, "seams_crossing": crossing, "seams_uneven": uneven, "seams_skewed": skewed,
            "seams_rows_end": rows_before_seams}


def sheet(tiles, program, older=None):
    """The tiles in rows, those of an older program above those of this one."""
    rows, columns = [], 2 if WIDE in [t.shape for t in tiles.values()] else 3 if len(tiles) % 3 == 0 else 4
    for word, run in [("before: ", older), ("after: ", program)] if older else [("", program)]:
        row = [(close_up(tile, run, program), word + name) for name, tile in tiles.items()]
        rows += [row[k:k + columns] for k in range(0, len(row), columns)]
    return draw.sheet(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("usdtailor")
    parser.add_argument("names", nargs="*", help="such as coat or seams_roof [default: all]")
    parser.add_argument("--before", help="an older usdtailor to compare with")
    args = parser.parse_intermixed_args()
    todo = {path: lambda of=of: of(args.usdtailor) for path, of in PICTURES.items()}
    todo |= {f"docs/looks/{name}": lambda of=of: sheet(of(), args.usdtailor).quantize(256) for name, of in SCENES.items()}
    if args.before:
        todo |= {f"docs/looks/{name}": lambda of=of: sheet(of(), args.usdtailor, args.before)
                 for name, of in COMPARED.items()}
    for path, drawn in todo.items():
        if not args.names or Path(path).name in args.names:
            drawn().save(ROOT / f"{path}.png", optimize=True)
            print(f"{path}.png", flush=True)


if __name__ == "__main__":
    main()
