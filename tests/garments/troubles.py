"""Small garments with one trouble each: skirts, a wrap, a cape and a pair of boots."""
import numpy as np

from tailoring.flatten import flatten
from tailoring.form import Form, smooth_table
from tailoring.mesh import Garment


def skirt_form(folds=1.0):
    torso = [(40, 31, 25, 25, 0), (58, 27, 21, 22, 0), (74, 23, 17, 18, -0.3), (84, 20, 14, 15.5, -0.6),
             (92, 17.6, 12, 13, -0.4), (100, 14.2, 10.6, 10.2, 0), (108, 14.0, 10.4, 10, 0)]

    def drape(p):
        angle = np.arctan2(p[:, 0], p[:, 2])
        low = np.clip((92 - p[:, 1]) / 50, 0, 1) ** 1.4
        return folds * low * (1.2 * np.sin(5 * angle + 0.9) + 0.6 * np.sin(8 * angle + 2.1))
    return Form(torso, power=2.2, drape=drape)


def cape_form():
    torso = [(90, 33, 24, 25, 0), (112, 29, 20, 21, -0.6), (128, 25, 16, 17, -1), (138, 20, 12, 13, -1.6),
             (144, 14, 9, 10, -2), (148, 10, 7.6, 8.4, -2.2), (152, 8.4, 7.2, 7.6, -2.2), (158, 8, 7, 7.4, -2)]

    def drape(p):
        angle = np.arctan2(p[:, 0], p[:, 2])
        return np.clip((132 - p[:, 1]) / 40, 0, 1) * (1.1 * np.sin(6 * angle + 0.4) + 0.5 * np.sin(9 * angle))
    return Form(torso, power=2.2, drape=drape)


def uneven(low, high, count, amount=0.3):
    """Values from low to high, in steps that vary by about a factor of two."""
    t = np.linspace(0, 1, count + 1)
    return low + (high - low) * (t + amount * np.sin(2 * np.pi * t) / (2 * np.pi))


def section(form, y, angle):
    """Points of the form at a height, by angles from the front to the left."""
    inside, outside = 0 * angle, 60 + 0 * angle
    for _ in range(40):
        middle = (inside + outside) / 2
        p = np.stack([middle * np.sin(angle), y + 0 * angle, middle * np.cos(angle)], 1)
        is_in = form.value(p) < 0
        inside, outside = np.where(is_in, middle, inside), np.where(is_in, outside, middle)
    return p


def around(g, heights, shares, turns=(0, 1)):
    """Rows of points on the form, lowest first, by heights and by shares of the length around it, from one turn to another; the
    front is at 0, the left at a quarter."""
    angle = 2 * np.pi * np.linspace(*turns, 600)
    rows = []
    for y in heights:
        dense = section(g.form, y, angle)
        along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))]
        wanted = np.asarray(shares) * along[-1]
        rows.append(g.add(np.stack([np.interp(wanted, along, dense[:, k]) for k in range(3)], 1)))
    return rows


def circle(count, amount=0.3):
    return uneven(0, 1, count, amount)[:-1]


def band(g, base, rises, panel):
    """A closed band above a ring, cut behind."""
    rows = [base]
    p = g.at(base)
    out = g.form.normal(p) * (1, 0, 1)
    for rise in rises:
        rows.append(g.add(p + (0, rise, 0) - 0.05 * rise * out))
    g.grid(rows, panel, closed=True)
    g.cut([row[len(base) // 2] for row in rows])
    return rows


def halves(count):
    """The names of the panels before and behind the side seams."""
    return lambda _, c: "back" if count // 4 <= c < 3 * count // 4 else "front"


def beside(values, numbers, width):
    """Values with others a little above some of them, and whether each is one of those some."""
    all_values = np.sort(np.r_[values, values[numbers] + width])
    return all_values, np.isin(all_values, values[numbers])


def narrow_sets():
    """A skirt with stripes and a placket of narrow faces, which are about one triangle wide."""
    g = Garment("NarrowSets", skirt_form())
    heights, is_stripe = beside(uneven(46, 99, 13), [2, 5, 8], 1.9)
    columns, is_placket = beside(circle(26), [0, 9, 18], 0.016)
    count = len(columns)
    rows = around(g, heights, columns)
    g.grid(rows, halves(count), closed=True)
    band(g, rows[-1], (1.8, 3.6), "band")
    face = lambda r, c: r * count + c % count
    height = len(heights) - 1
    g.face_sets = {f"stripe_{r}": [face(r, c) for c in range(count)] for r in np.nonzero(is_stripe)[0]}
    g.face_sets |= {f"placket_{c}": [face(r, c) for r in range(3, height)] for c in np.nonzero(is_placket)[0]}
    return g


def split_uv_indices():
    """A wrap of three panels, whose UV indices are also split along lines inside the panels, with one value on both sides."""
    g = Garment("SplitUvIndices", skirt_form())
    g.scale = 0.1
    columns, height = 26, 14
    rows = around(g, uneven(48, 100, height), uneven(0, 1, columns), (-0.42, 0.43))
    names = ["right"] * 8 + ["back"] * 10 + ["left"] * 8
    g.grid(rows, lambda _, c: names[c])
    uv, corner_uv, unit = flatten(g, {})
    # Corners on the far side of a line get indices of their own.
    far = np.array([(f // columns >= 5) + 2 * (f % columns >= 13) for f in range(len(g.faces)) for _ in range(4)])
    pairs, corner_uv = np.unique(np.stack([corner_uv, far], 1), axis=0, return_inverse=True)
    g.uvs = uv[pairs[:, 0]], corner_uv.ravel(), unit
    return g


def tiny_shells():
    """A skirt with eyelets: single small faces that are UV shells of their own, and rivets upon the cloth."""
    g = Garment("TinyShells", skirt_form())
    heights, is_low = beside(uneven(46, 99, 12), [9], 1.1)
    columns, is_narrow = beside(circle(24, 0.1), np.arange(0, 24, 2), 0.011)
    rows = around(g, heights, columns)
    names = halves(len(columns))

    def panel(r, c):
        return f"eyelet_{r}_{c}" if is_low[r] and is_narrow[c] else names(r, c)
    g.grid(rows, panel, closed=True)
    for share, y in [(share, y) for share in circle(24, 0.1)[1::2] for y in (76.0, 92.4)]:
        rivet = around(g, [y, y + 1], share + np.array([0.01, 0.019]))
        p = g.at(np.ravel(rivet))
        g.move(rivet, p + 0.9 * g.form.normal(p))
        g.grid(rivet, f"rivet_{share:.2f}_{y}")
    return g


def doubled_points():
    """A skirt and its yoke as two components, whose borders have the same points."""
    g = Garment("DoubledPoints", skirt_form())
    count = 26
    low = around(g, uneven(44, 84, 11), circle(count))
    g.grid(low, halves(count), closed=True)
    yoke = around(g, uneven(84, 101, 5)[1:], circle(count))
    g.grid([g.add(g.at(low[-1])), *yoke], lambda r, c: "yoke_" + halves(count)(r, c), closed=True)
    return g


def box(g, x, y, offset, thickness, name, back=False):
    """A closed thin box over the front (or the back) of the form: a tray over a flat bottom."""
    columns, height = len(x) - 1, len(y) - 1
    p = g.form.front_point(*np.meshgrid(x, y), back=back).reshape(-1, 3)
    normal = g.form.normal(p)
    shape = (height + 1, columns + 1)
    bottom = g.add(p + offset * normal).reshape(shape)
    top = g.add(p + (offset + thickness) * normal).reshape(shape)
    g.grid(list(top), name, flip=back)
    g.grid(list(bottom), f"{name}_bottom", flip=not back)
    ring = lambda ids: np.r_[ids[0], ids[1:, -1], ids[-1, -2::-1], ids[-2:0:-1, 0]]
    g.grid([ring(bottom), ring(top)], name, closed=True, flip=back)


def closed_pockets():
    """A wrap with pockets and toggles, each a closed box."""
    g = Garment("ClosedPockets", skirt_form(0.6))
    columns = 34
    rows = around(g, uneven(50, 99, 19), uneven(0, 1, columns), (-0.47, 0.47))
    g.grid(rows, lambda _, c: "front_right" if c < 10 else "back" if c < 24 else "front_left")
    for side in (1, -1):
        x = np.sort(side * np.linspace(5.0, 16.5, 4))
        box(g, x, np.linspace(68, 84, 5), 0.9, 3.0, f"pocket_{side}")
    for number, y in enumerate((60, 74, 87, 96)):
        box(g, np.linspace(-2.6, 2.6, 3), y + np.linspace(-2.4, 2.4, 3), 0.9, 2.4, f"toggle_{number}")
    return g


def toe(g, ring, n):
    """A bulging grid of n by n inside a ring."""
    middle = g.at(ring).mean(0)[2] + 3.0
    grid = np.zeros((n + 1, n + 1), int)
    border = [(0, c) for c in range(n)] + [(r, n) for r in range(n)] + [(n, n - c) for c in range(n)] + [(n - r, 0) for r in range(n)]
    grid[tuple(np.transpose(border))] = ring
    for r in range(1, n):
        for c in range(1, n):
            p = (g.at(grid[r, 0]) * (n - c) + g.at(grid[r, n]) * c + g.at(grid[0, c]) * (n - r) + g.at(grid[n, c]) * r) / (2 * n)
            out = np.square([2 * r / n - 1, 2 * c / n - 1]).max()
            grid[r, c] = g.add(p + (0, 0, (middle - p[2]) * (1 - 0.6 * out)))
    return list(grid)


def shared_uvs():
    """A pair of boots; the right one has the UVs of the left one."""
    g = Garment("SharedUvs", None)
    quarter = 5
    count = 4 * quarter
    turn = np.radians(np.arange(count) * 360 / count + 45)
    # Each ring: the place of its middle, its lean from upright, half of its width and of its height.
    table = np.array([
        (2.9, 12.5, 0, 4.2, 3.3), (3.3, 9.8, 3, 4.5, 3.6), (3.8, 7.0, 6, 4.6, 4.0), (4.3, 4.2, 10, 4.5, 4.4),
        (5.0, 1.0, 20, 4.4, 4.9), (7.0, -2.2, 45, 4.4, 5.0), (10.2, -3.4, 74, 4.5, 4.6), (12.6, -3.3, 86, 4.6, 4.7),
        (14.8, -3.2, 90, 4.8, 4.9), (17.2, -3.0, 90, 5.1, 5.1), (19.6, -2.9, 90, 5.6, 5.6)])
    rings = []
    for y, z, lean, width, height in zip(*(smooth_table(np.linspace(0, 10, 15), np.arange(11), row) for row in table.T)):
        across, up, lean = width * np.cos(turn), height * np.sin(turn), np.radians(lean)
        rings.append(np.stack([8 + across, y + up * np.cos(lean), z + up * np.sin(lean)], 1))
    rows = list(g.add(np.array(rings)))
    low, back = range(2 * quarter, 3 * quarter), 9
    g.grid(rows, lambda r, c: "sole" if r < back and c in low else "upper", closed=True, flip=True)
    g.grid(toe(g, rows[0], quarter), "upper")
    g.cut([row[low[2]] for row in rows[back:]])
    uv, corner_uv, unit = flatten(g, {})
    first, faces = len(g.points), list(zip(g.faces, g.panels))
    g.add(np.array(g.points) * (-1, 1, 1))
    for face, name in faces:
        g.face([first + i for i in face[::-1]], name + "_mirrored")
    mirrored = corner_uv.reshape(-1, 4)[:, ::-1].ravel()
    g.uvs, g.scale = (uv, np.r_[corner_uv, mirrored], unit), 0.1
    return g


def turned_faces():
    """A cape whose collar is wound against it, as are a few of its faces."""
    g = Garment("TurnedFaces", cape_form())
    count = 30
    rows = around(g, uneven(94, 149, 13, 0.2), circle(count, 0.15))
    g.grid(rows, halves(count), closed=True)
    body = len(g.faces)
    band(g, rows[-1], (1.4, 2.9), "collar")
    turned = {body + k for k in range(2 * count)} | {3 * count + 5, 6 * count + 18, 6 * count + 19, 7 * count + 18}
    uv, corner_uv, unit = flatten(g, {})
    turn = lambda all: [row[::-1] if f in turned else row for f, row in enumerate(all)]
    g.faces = turn(g.faces)
    g.uvs = uv, np.concatenate(turn(corner_uv.reshape(-1, 4))), unit
    return g
