"""A garment under construction: points, faces with their pattern piece, named edges."""
import numpy as np


class Garment:
    """Points and faces with a panel each.  Grids of point indices are the unit of work: rows run
    up, columns run to the left of the wearer at the front, so that quads wind outwards."""

    def __init__(self, name, form):
        self.name, self.form = name, form
        self.points = []
        self.fixed = []           # points which relaxation leaves alone
        self.faces = []           # tuples of point indices
        self.panels = []          # name of the pattern piece of each face
        self.edge_sets = {}       # name: list of (a, b)
        self.cuts = set()         # edges inside a panel where its UVs are cut open
        self.creases = []         # (chain of points, sharpness)
        self.corners = []         # (point, sharpness)
        self.weak = set()         # edges which relaxation hardly heeds
        self.pins = []            # points where buttons are attached

    # -- points

    def add(self, points, fixed=False):
        """New points of an array (..., 3); their indices in the same shape."""
        points = np.asarray(points, float)
        flat = points.reshape(-1, 3)
        start = len(self.points)
        self.points.extend(flat)
        self.fixed.extend([fixed] * len(flat))
        return np.arange(start, start + len(flat)).reshape(points.shape[:-1])

    def at(self, ids):
        return np.array(self.points)[np.asarray(ids)]

    def move(self, ids, points):
        for i, p in zip(np.ravel(ids), np.reshape(points, (-1, 3))):
            self.points[i] = p

    def fix(self, ids):
        for i in np.ravel(ids):
            self.fixed[i] = True

    # -- faces and edges

    def face(self, ids, panel):
        """A face; repeated neighbours are dropped, so a collapsed quad becomes a triangle."""
        ids = [int(i) for i in ids]
        ring = [a for k, a in enumerate(ids) if a != ids[k - 1]]
        if len(ring) >= 3:
            self.faces.append(tuple(ring))
            self.panels.append(panel)

    def grid(self, rows, panel, closed=False, flip=False):
        """Quads between rows (lowest first); panel is a name or a function of (row, column)."""
        rows = [list(r) + ([r[0]] if closed else []) for r in rows]
        for r, (low, high) in enumerate(zip(rows, rows[1:])):
            for c in range(len(low) - 1):
                ring = [low[c], low[c + 1], high[c + 1], high[c]]
                self.face(ring[::-1] if flip else ring, panel(r, c) if callable(panel) else panel)

    def mark(self, name, chain, closed=False):
        """Adds a chain of points to a named edge set."""
        chain = [int(i) for i in chain]
        pairs = zip(chain, chain[1:] + (chain[:1] if closed else []))
        self.edge_sets.setdefault(name, []).extend((a, b) for a, b in pairs if a != b)

    def cut(self, chain):
        self.cuts.update(tuple(sorted((int(a), int(b)))) for a, b in zip(chain, chain[1:]))

    def weaken(self, chain):
        """Edges along a chain, such as the columns of a front: beside a hollow border like an
        armhole points would crowd if edges along it counted as much as those across."""
        self.weak.update(tuple(sorted((int(a), int(b)))) for a, b in zip(chain, chain[1:]))

    def crease(self, chain, sharpness, closed=False):
        chain = [int(i) for i in chain]
        self.creases.append((chain + (chain[:1] if closed else []), sharpness))

    # -- shape

    def edges(self):
        """Each edge once, as sorted pairs, with the number of its faces."""
        pairs = np.array([sorted((f[k - 1], f[k])) for f in self.faces for k in range(len(f))])
        return np.unique(pairs, axis=0, return_counts=True)

    def relax(self, steps=60, rate=0.5, project=True):
        """Evens out the free points while they stay on the form.  A free point of the border
        moves along the border only."""
        pairs, uses = self.edges()
        p = np.array(self.points)
        border = np.zeros(len(p), bool)
        border[pairs[uses == 1].ravel()] = True
        keep = (uses == 1) | ~(border[pairs].any(1))
        one_sided = (uses != 1) & (border[pairs].sum(1) == 1)
        src, dst = [], []
        for a, b in ((0, 1), (1, 0)):
            src += [pairs[keep, a], pairs[one_sided & border[pairs[:, a]], a]]
            dst += [pairs[keep, b], pairs[one_sided & border[pairs[:, a]], b]]
        src, dst = np.concatenate(src), np.concatenate(dst)   # dst listens to src
        free = ~np.array(self.fixed)
        free &= np.bincount(dst, minlength=len(p)) > 0
        pull = np.array([0.25 if tuple(sorted(e)) in self.weak else 1.0
                         for e in zip(src.tolist(), dst.tolist())])
        n = np.maximum(np.bincount(dst, pull, len(p)), 1e-9)
        for _ in range(steps):
            mean = np.stack([np.bincount(dst, p[src, k] * pull, len(p)) for k in range(3)], 1)
            mean /= n[:, None]
            q = p + rate * (mean - p)
            q[free] = self.form.project(q[free], steps=1) if project else q[free]
            p[free] = q[free]
        if project:
            p[free] = self.form.project(p[free])
        self.points = list(p)


def between(a, b, count):
    """count + 1 points from a to b."""
    t = np.linspace(0, 1, count + 1)[:, None]
    return np.asarray(a, float) * (1 - t) + np.asarray(b, float) * t


def blend_rows(low, high, count):
    """Rows from one row of points to another, both included."""
    return [low + (high - low) * t for t in np.linspace(0, 1, count + 1)]


def mirror(points):
    return np.asarray(points) * np.array([-1.0, 1.0, 1.0])


def ring_about(a, b, radius, start, count):
    """A circle of points about b, across a to b.  Its first point lies towards `start`; the
    rest follow counter-clockwise seen from b towards a."""
    axis = np.asarray(b, float) - a
    axis /= np.linalg.norm(axis)
    u = np.asarray(start, float) - axis * np.dot(start, axis)
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    t = np.arange(count) / count * 2 * np.pi
    return np.asarray(b) + radius * (np.cos(t)[:, None] * u + np.sin(t)[:, None] * v)
