"""Small garments for seam_table.py and seams.py, in millimetres, and the program that builds their render meshes.

A garment is one or more grids of quads. `weld` joins them where their points coincide, with their sets."""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import draw  # noqa: E402
import rims  # noqa: E402

QUAD = 45.0                                                 # edge length of most cages
# The simulation mesh, which nobody looks at, is made as coarse as it may be.
CHEAP = ["sim.maxEdgeLength=60mm", "sim.iterations=1", "sim.baselineLevel=1"]
CLOTH, ACCENT = (0.50, 0.60, 0.72), (0.93, 0.88, 0.78)      # colours of the cloth and of face sets


class Cage(rims.Grid):
    """Grids welded to one mesh; faces of the sets `accents` have a second colour."""

    def __init__(self, grids, accents=()):
        self.accents = accents
        stacked = np.concatenate([g.points for g in grids])
        _, first, to = np.unique(np.round(stacked, 2), axis=0, return_index=True, return_inverse=True)
        order = np.argsort(np.argsort(first))       # keeps the order of the grids
        self.points, to = stacked[np.sort(first)], order[to.ravel()]
        self.faces, sets, point, face = [], {}, 0, 0
        for g in grids:
            self.faces += [[int(to[point + v]) for v in quad] for quad in g.faces]
            for name, element, indices in g.sets:
                moved = [int(to[point + i]) if element == "edge" else face + i for i in indices]
                sets.setdefault((name, element), []).extend(moved)
            point, face = point + len(g.points), face + len(g.faces)
        self.sets = [(name, element, indices) for (name, element), indices in sets.items()]

    def mean_edge(self):
        quads = self.points[np.array(self.faces)]
        return float(np.linalg.norm(quads - np.roll(quads, 1, 1), axis=2).mean())

    def write(self, path):
        super().write(path)
        accented = sum((list(indices) for name, _, indices in self.sets if name in self.accents), [])
        stage = Usd.Stage.Open(str(path))
        UsdGeom.SetStageMetersPerUnit(stage, 0.001)
        write_colours(stage.GetPrimAtPath("/Rim/model"), len(self.faces), accented)
        stage.Save()


def weld(*grids, accents=()):
    return Cage(grids, accents)


def write_colours(prim, faces, accented):
    colours = np.tile(np.float32(CLOTH), (faces, 1))
    colours[accented] = ACCENT
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform")
    primvar.Set(Vt.Vec3fArray.FromNumpy(colours))


# ------------------------------------------------------------------------------- the program

def seam(name, **options):
    """Options of a seam that follows the edge set of its name."""
    options = {"edges": name, "normalOffset": 0.1, **options}
    return [f"seam.{name}.{key}={value}" for key, value in options.items()]


def build(program, source, options=(), level=2, prim="/Rim/render"):
    """The render mesh that a program builds of a cage or of a file."""
    with tempfile.TemporaryDirectory() as folder:
        built = str(Path(folder) / "built.usda")
        if not isinstance(source, (str, Path)):
            source.write(Path(folder) / "cage.usda")
            source = Path(folder) / "cage.usda"
        sets = [word for option in [f"render.level={level}", *CHEAP, *options] for word in ("--set", option)]
        command = [program, "build", str(source), "-o", built, "--physics", "none", *sets]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            raise SystemExit(f"{program} {' '.join(options)}\n{run.stderr}")
        return draw.load(Usd.Stage.Open(built), [prim])[0]


class Again:
    """A render mesh as a garment of its own, with its colours and sets, to refine it further."""

    def __init__(self, mesh):
        self.mesh = mesh

    def write(self, path):
        stage = Usd.Stage.CreateNew(str(path))
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Rim").GetPrim())
        UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(self.mesh.stage))
        copy = UsdGeom.Mesh.Define(stage, "/Rim/model")
        copy.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(self.mesh.points.astype(np.float32)))
        copy.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(self.mesh.counts.astype(np.int32)))
        copy.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(self.mesh.indices.astype(np.int32)))
        for name in ("creaseIndices", "creaseLengths", "creaseSharpnesses", "cornerIndices", "cornerSharpnesses"):
            value = self.mesh.prim.GetAttribute(name).Get()
            if value:
                getattr(copy, f"Create{name[0].upper()}{name[1:]}Attr")(value)
        for element in ("face", "edge"):
            for name, indices in self.mesh.subsets(element):
                UsdGeom.Subset.CreateGeomSubset(copy, name, element, Vt.IntArray.FromNumpy(indices.astype(np.int32)))
        colour = self.mesh.primvar("displayColor")
        if colour and colour[2] == "uniform":
            values = colour[0] if colour[1] is None else colour[0][colour[1]]
            to = UsdGeom.PrimvarsAPI(copy).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform")
            to.Set(Vt.Vec3fArray.FromNumpy(np.asarray(values, np.float32)))
        stage.Save()


# ------------------------------------------------------------------------------- sheets

def roof(turn, n=8, quad=QUAD):
    """Two planes that meet at the edge set `ridge`, where the surface turns; `half` ends across it."""
    tilt = np.radians(turn / 2)

    def place(x, y):
        beside = (x - n / 2) * quad
        return beside * np.cos(tilt), y * quad, -abs(beside) * np.sin(tilt)
    grid = rims.Grid(n, n, place)
    grid.line("ridge", (n // 2, 0), (n // 2, n)).patch("half", lambda x, y: y < n // 2)
    return weld(grid)


def chest(nx=9, ny=9, quad=QUAD, radius=220.0, lift=0.0, first=(0, 0)):
    """A sheet bent about y, or a part of one that lies `lift` above it."""
    def place(x, y):
        a = ((x + first[0]) - 4.5) * quad / radius
        return (radius + lift) * np.sin(a), (y + first[1]) * quad, (radius + lift) * np.cos(a) - radius
    return rims.Grid(nx, ny, place)


def stitched_pocket():
    """A patch pocket as a face set of the sheet, stitched around."""
    sheet = chest().patch("pocket", lambda x, y: 3 <= x < 6 and 3 <= y < 6)
    sheet.line("around", (3, 6), (3, 3), (6, 3), (6, 6), (3, 6))
    return weld(sheet, accents=["pocket"])


def folded_pocket(gap=8.0):
    """A pocket that lies on the sheet as a piece of its own."""
    piece = chest(3, 3, lift=gap, first=(3, 3)).patch("pocket", lambda x, y: True)
    piece.line("around", (0, 3), (0, 0), (3, 0), (3, 3), (0, 3))
    return weld(chest(), piece, accents=["pocket"])


def uneven(widths, heights=None, turn=70.0, bend=900.0):
    """Quads along an arc that turns by `turn` degrees, of these widths, QUAD or `heights` high; the seam is along them."""
    edges = np.concatenate([[0], np.cumsum(widths)])
    heights = np.append(heights, heights[-1]) if heights is not None else np.full(len(edges), QUAD)
    radius = edges[-1] / np.radians(turn)

    def place(x, y):
        high, a = (y - 2) * heights[int(x)], edges[int(x)] / radius - np.radians(turn / 2)
        return (radius + high) * np.sin(a), (radius + high) * np.cos(a) - radius, -high * high / bend
    return weld(rims.Grid(len(widths), 4, place).line("seam", (0, 2), (len(widths), 2)))


def uneven_sheets():
    """Sheets of uneven and of large quads, each with the width of its seam."""
    growing, sudden, large = 15 * 3 ** (np.arange(7) / 6), np.array([15, 45, 15, 15, 45, 15, 45.0]), np.full(4, 120.0)
    return {
        "quads that grow 1:3 along the seam": (uneven(growing), 8),
        "along it and on both sides": (uneven(growing, growing), 8),
        "quads of 15 and 45 mm": (uneven(sudden, sudden), 8),
        "quads of 120 mm": (uneven(large, large), 12),
    }


# ------------------------------------------------------------------------------- garments

def hoodie():
    """A body gathered by a waistband: side seams cross the band's seam, and a pocket's seam ends at it."""
    around, heights = 20, [0, 35, 70, 112, 157, 202, 247, 292]
    girth = [150, 152, 156, 182, 192, 194, 194, 194]

    def place(x, y):
        a, r = 2 * np.pi * x / around, girth[int(y)]
        return r * np.sin(a), heights[int(y)], 0.72 * r * np.cos(a)
    tube = rims.Grid(around, len(heights) - 1, place, closed=True)
    tube.line("waist", (0, 2), (around, 2)).line("side", (5, 0), (5, 7)).line("side", (15, 0), (15, 7))
    tube.line("pocket", (2, 2), (2, 6)).patch("band", lambda x, y: y < 2)
    return weld(tube, accents=["band"])


WIDE, DEEP, CHEST = 200.0, 135.0, 450.0     # half axes of the shirt's body; height at which the armholes begin


def neck(angle, front):
    """The neckline, from the left (-90 degrees) over the front or back to the right."""
    s, c = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    return np.array([75 * s, 690 - (70 if front else 15) * c, (85 if front else -75) * c])


def panel(i, j, front):
    """A point of the front or back: 12 columns, ten rows up to the chest, and five beside the armholes."""
    s = (i / 6 - 1) * (1 if front else -1)
    side = 1 if front else -1
    low = np.array([WIDE * np.sin(np.pi / 2 * s), CHEST, side * DEEP * np.cos(np.pi / 2 * s)])
    if j <= 10:
        return low + (0, (j / 10 - 1) * CHEST, 0)
    if 4 <= i <= 8:
        high = neck((i - 6) * 45.0 * side, front)
    else:
        high = np.sign(s) * np.array([195, 0, 0]) * (1 - min(i, 12 - i) / 4) + (0, 640, 0)
        high += min(i, 12 - i) / 4 * np.array([np.sign(s) * 75, 50, 0])
    t = (j - 10) / 5
    middle = np.array([(low[0] + high[0]) / 2, low[1] + 0.75 * (high[1] - low[1]), 0.9 * low[2]])
    point = (1 - t) ** 2 * low + 2 * t * (1 - t) * middle + t * t * high
    return point + np.sin(np.pi * t) * np.array([-28 * s ** 3, 0, side * 58 * s ** 4])


def sleeve(side):
    """A short sleeve on the armhole of one side (1: x above 0), ten quads around and five long."""
    up = [panel(0 if side > 0 else 12, j, False) for j in range(10, 15)]
    down = [panel(12 if side > 0 else 0, j, True) for j in range(15, 10, -1)]
    loop = np.array(up + down)
    axis, across = np.array([0.75 * side, -0.66, 0]), np.array([0.66 * side, 0.75, 0])

    def place(x, r):
        k = int(x) % 10
        a = 2 * np.pi * k / 10
        round_ = loop.mean(0) + axis * QUAD * r + 76 * (-np.cos(a) * across - np.sin(a) * np.array([0, 0, 1]))
        share = min(1, r / 3)
        return (1 - share) * (loop[k] + axis * QUAD * r) + share * round_
    tube = rims.Grid(10, 5, place, closed=True)
    if side < 0:        # the other way around, so that its normals point outwards
        tube.faces = [quad[::-1] for quad in tube.faces]
    return tube.line("armhole", (0, 0), (10, 0)).line("sleeve", (0, 0), (0, 5))


def shirt():
    """A shirt of 45 mm quads with its seams, a standing collar as a face set, and lines that end at it or cross it."""
    def collar(x, y):
        k = int(x) % 8
        base = neck((k - 2) * 45.0, True) if k <= 4 else neck((6 - k) * 45.0, False)
        return base * (1 - 0.03 * y, 1, 1 - 0.03 * y) + (0, 21 * y, 0)
    front = rims.Grid(12, 15, lambda x, y: panel(int(x), int(y), True))
    back = rims.Grid(12, 15, lambda x, y: panel(int(x), int(y), False))
    band = rims.Grid(8, 2, collar, closed=True).patch("collar", lambda x, y: True)
    front.line("shoulder", (0, 15), (4, 15)).line("shoulder", (12, 15), (8, 15))
    front.line("side", (0, 0), (0, 10)).line("side", (12, 0), (12, 10))
    front.line("ending", (5, 9), (5, 15)).line("ending", (7, 9), (7, 15))
    front.line("crossing", (6, 9), (6, 15))
    band.line("neckline", (0, 0), (8, 0)).line("crossing", (2, 0), (2, 2))
    return weld(front, back, band, sleeve(1), sleeve(-1), accents=["collar"])
