"""Small garments for seam_table.py and pictures.py, and the program that builds their meshes.

A garment is one or more grids of quads. `weld` joins them where their points coincide, with their sets."""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import draw  # noqa: E402

QUAD = 45.0                                                 # edge length of most cages
# The simulation mesh, which nobody looks at, is made as coarse as it may be.
CHEAP = ["sim.maxEdgeLength=60mm", "sim.iterations=1", "sim.baselineLevel=1"]
CLOTH, ACCENT = (0.50, 0.60, 0.72), (0.93, 0.88, 0.78)      # colours of the cloth and of face sets


def write_mesh(path, points, counts, indices, uvs=None, sets=(), colours=None, unit=0.01):
    """Writes a stage with the mesh /Garment/model, and returns both."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Garment").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Garment/model")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(points, np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.asarray(counts, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(indices, np.int32).ravel()))
    types, primvars = Sdf.ValueTypeNames, UsdGeom.PrimvarsAPI(mesh)
    if uvs is not None:
        st = primvars.CreatePrimvar("st", types.TexCoord2fArray, "faceVarying")
        st.Set(Vt.Vec2fArray.FromNumpy(np.asarray(uvs, np.float32)))
    if colours is not None:
        colour = primvars.CreatePrimvar("displayColor", types.Color3fArray, "uniform")
        colour.Set(Vt.Vec3fArray.FromNumpy(np.asarray(colours, np.float32)))
    for name, element, ids in sets:
        UsdGeom.Subset.CreateGeomSubset(mesh, name, element, Vt.IntArray.FromNumpy(np.asarray(ids, np.int32)))
    stage.Save()
    return stage, mesh


class Grid:
    """A grid of `nx` by `ny` quads; columns close around where `closed`."""

    unit, accents = 0.01, ()

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
        colours = np.tile(np.float32(CLOTH), (len(self.faces), 1))
        for name, _, indices in self.sets:
            if name in self.accents:
                colours[indices] = ACCENT
        uvs = self.points[np.array(self.faces).ravel(), :2]
        write_mesh(path, self.points, [4] * len(self.faces), self.faces, uvs, self.sets, colours, self.unit)


class Cage(Grid):
    """Grids welded to one mesh; faces of the sets `accents` have a second colour."""

    unit = 0.001

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


def weld(*grids, accents=()):
    return Cage(grids, accents)


# ------------------------------------------------------------------------------- the program

def seam(name, **options):
    """Options of a seam that follows the edge set of its name."""
    options = {"edges": name, "normalOffset": 0.1, **options}
    return [f"seam.{name}.{key}={value}" for key, value in options.items()]


def products(program, source, options=(), *words):
    """The stage that a program builds of a garment or of a file."""
    with tempfile.TemporaryDirectory() as folder:
        built = str(Path(folder) / "built.usda")
        if not isinstance(source, Path):
            garment, source = source, Path(folder) / "garment.usda"
            garment.write(source)
        sets = [word for option in options for word in ("--set", option)]
        run = subprocess.run([program, "build", str(source), "-o", built, *sets, *words], capture_output=True, text=True)
        if run.returncode:
            raise SystemExit(f"{program} {' '.join(options)}\n{run.stderr}")
        return Usd.Stage.Open(built)


def product(stage, name):
    return draw.load(stage, [stage.GetDefaultPrim().GetPath().AppendChild(name)])[0]


def build(program, source, options=(), level=2):
    """The render mesh that a program builds of a garment or of a file."""
    return product(products(program, source, [f"render.level={level}", *CHEAP, *options], "--physics", "none"), "render")


class Again:
    """A render mesh as a garment of its own, with its colours and sets, to refine it further."""

    def __init__(self, mesh):
        self.mesh = mesh

    def write(self, path):
        mesh, colour = self.mesh, self.mesh.primvar("displayColor")
        sets = [(name, element, ids) for element in ("face", "edge") for name, ids in mesh.subsets(element)]
        colours = None
        if colour and colour[2] == "uniform":
            colours = colour[0] if colour[1] is None else colour[0][colour[1]]
        unit = UsdGeom.GetStageMetersPerUnit(mesh.stage)
        stage, copy = write_mesh(path, mesh.points, mesh.counts, mesh.indices, None, sets, colours, unit)
        for name in ("creaseIndices", "creaseLengths", "creaseSharpnesses", "cornerIndices", "cornerSharpnesses"):
            value = mesh.prim.GetAttribute(name).Get()
            if value:
                getattr(copy, f"Create{name[0].upper()}{name[1:]}Attr")(value)
        stage.Save()


# ------------------------------------------------------------------------------- surfaces around an axis

AROUND = 24                 # faces around each form
RADIUS = 6.0                # target lengths


class Revolved:
    """A surface around y through (radius, height), with `faces` of 24 around, from inside if `turned`; or with lids."""

    def __init__(self, profile, faces=AROUND, turned=False, lids=False):
        angles = 2 * np.pi * np.arange(AROUND) / AROUND
        points = np.array([(r * np.cos(a), y, -r * np.sin(a)) for r, y in profile for a in angles])
        at = lambda row, k: row * AROUND + k % AROUND  # noqa: E731
        self.rings = [[at(row, k), at(row, k + 1), at(row + 1, k + 1), at(row + 1, k)][::-1 if turned else 1]
                      for row in range(len(profile) - 1) for k in range(faces)]
        if lids:
            last = (len(profile) - 1) * AROUND
            self.rings += [list(range(AROUND))[::-1], list(range(last, last + AROUND))]
        # UVs that are cut along one line.
        columns = [[v % AROUND for v in ring] for ring in self.rings]
        self.uvs = [(c + AROUND * (c == 0 and AROUND - 1 in ring), v // AROUND)
                    for of, ring in zip(self.rings, columns) for v, c in zip(of, ring)]
        used, self.indices = np.unique(np.concatenate(self.rings), return_inverse=True)
        self.points = points[used]

    def write(self, path):
        write_mesh(path, self.points, [len(ring) for ring in self.rings], self.indices, self.uvs)


def turned_hem(gap):
    inner, up = RADIUS - gap, (0, 1.5, 3)
    return Revolved([(inner, y) for y in up[::-1]] + [(RADIUS, y) for y in (*up, 6, 9)])


def standing_collar(gap):
    inner = RADIUS - gap
    return Revolved([(inner, 0), (inner, 1.5), (inner, 3), (RADIUS, 3), (RADIUS, 1.5), (RADIUS + 0.2, 0)], 18, turned=True)


def button():
    """A disk of one length across, with a rim a quarter of a length high."""
    return Revolved([(0.5, 0), (1, 0), (1, 0.25), (0.5, 0.3)], lids=True)


# ------------------------------------------------------------------------------- sheets

def sheet(n=8, bend=0.0, kink=0.0, uneven=0.0, skew=0.0):
    """A sheet of `n` by `n`, bent about y; beyond the middle its lower border turns by `kink` degrees, `uneven` moves the
    points along it, and `skew` leans its columns by degrees."""
    def place(x, y):
        fade = 1 - y / n
        x += y * np.tan(np.radians(skew))
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


def roof(turn, n=8, quad=QUAD):
    """Two planes that meet at the edge set `ridge`, where the surface turns; `half` ends across it."""
    tilt = np.radians(turn / 2)

    def place(x, y):
        beside = (x - n / 2) * quad
        return beside * np.cos(tilt), y * quad, -abs(beside) * np.sin(tilt)
    grid = Grid(n, n, place)
    grid.line("ridge", (n // 2, 0), (n // 2, n)).patch("half", lambda x, y: y < n // 2)
    return weld(grid)


def chest(nx=9, ny=9, quad=QUAD, radius=220.0, lift=0.0, first=(0, 0)):
    """A sheet bent about y, or a part of one that lies `lift` above it."""
    def place(x, y):
        a = ((x + first[0]) - 4.5) * quad / radius
        return (radius + lift) * np.sin(a), (y + first[1]) * quad, (radius + lift) * np.cos(a) - radius
    return Grid(nx, ny, place)


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
    return weld(Grid(len(widths), 4, place).line("seam", (0, 2), (len(widths), 2)))


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
    tube = Grid(around, len(heights) - 1, place, closed=True)
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
    tube = Grid(10, 5, place, closed=True)
    if side < 0:        # the other way around, so that its normals point outwards
        tube.faces = [quad[::-1] for quad in tube.faces]
    return tube.line("armhole", (0, 0), (10, 0)).line("sleeve", (0, 0), (0, 5))


def shirt():
    """A shirt of 45 mm quads with its seams, a standing collar as a face set, and lines that end at it or cross it."""
    def collar(x, y):
        k = int(x) % 8
        base = neck((k - 2) * 45.0, True) if k <= 4 else neck((6 - k) * 45.0, False)
        return base * (1 - 0.03 * y, 1, 1 - 0.03 * y) + (0, 21 * y, 0)
    front = Grid(12, 15, lambda x, y: panel(int(x), int(y), True))
    back = Grid(12, 15, lambda x, y: panel(int(x), int(y), False))
    band = Grid(8, 2, collar, closed=True).patch("collar", lambda x, y: True)
    front.line("shoulder", (0, 15), (4, 15)).line("shoulder", (12, 15), (8, 15))
    front.line("side", (0, 0), (0, 10)).line("side", (12, 0), (12, 10))
    front.line("ending", (5, 9), (5, 15)).line("ending", (7, 9), (7, 15))
    front.line("crossing", (6, 9), (6, 15))
    band.line("neckline", (0, 0), (8, 0)).line("crossing", (2, 0), (2, 2))
    return weld(front, back, band, sleeve(1), sleeve(-1), accents=["collar"])
