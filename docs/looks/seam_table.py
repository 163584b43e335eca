#!/usr/bin/env python3
"""Measures how far seams move the surface of small garments, and prints the result as Markdown tables.

    seam_table.py target/release/usdtailor [OLD] [--level 2] [--set OPTION=VALUE ...]

The points of a render mesh with seams of 0.1 mm offset, refined once more, are compared with the limit surface of the
garment without them: the program refines the garment too, and the mask of Catmull-Clark takes points to their limit. Points
are *away* where their place on that surface is more than a seam's width beside it, others are *on* it. Another table is for
the border of a face set that a seam meets, and one for the profile of grooves over uneven quads. With an OLD program, its
figures come first. --set goes to the first program only. Needs usd-core, numpy and Pillow."""
import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import cages  # noqa: E402

REFERENCE = 5       # refinements of the garment: edges of 1.4 mm
PLACES = 40         # parts of a seam in which its profile is measured


# ------------------------------------------------------------------------------- limits

def border(quads):
    """The edges with one face."""
    pairs = np.sort(np.stack([quads, np.roll(quads, -1, 1)], 2).reshape(-1, 2), axis=1)
    unique, uses = np.unique(pairs, axis=0, return_counts=True)
    return unique[uses == 1]


def add_at(count, where, values):
    return np.stack([np.bincount(where.ravel(), values[..., k].ravel(), count) for k in range(3)], 1)


def limits(mesh):
    """Limit positions of the points of a mesh of quads without creases, whose corners of one face are sharp."""
    if mesh.counts.min() < 4 or mesh.counts.max() > 4 or mesh.prim.GetAttribute("creaseIndices").Get():
        raise SystemExit("only meshes of quads without creases have this limit mask")
    points, quads = mesh.points, mesh.indices.reshape(-1, 4)
    count, corner = len(points), points[quads]
    n = np.bincount(quads.ravel(), minlength=count)[:, None]
    # Each inner edge is met twice.
    edges = add_at(count, quads, np.roll(corner, 1, 1) + np.roll(corner, -1, 1)) / 2
    limit = (n * n * points + 4 * edges + add_at(count, quads, np.roll(corner, 2, 1))) / np.maximum(n * (n + 5), 1)
    rim = border(quads)
    ends = np.unique(rim)
    along = add_at(count, np.concatenate([rim[:, 0], rim[:, 1]]), points[np.concatenate([rim[:, 1], rim[:, 0]])])
    limit[ends] = np.where(n[ends] == 1, points[ends], (4 * points[ends] + along[ends]) / 6)
    return limit


# ------------------------------------------------------------------------------- distances

def to_segments(points, a, b):
    """Distance of each point to the nearest of the segments from `a` to `b`."""
    out = np.empty(len(points))
    step = max(1, 4_000_000 // len(a))
    for s in range(0, len(points), step):
        p = points[s:s + step, None]
        t = np.clip(((p - a) * (b - a)).sum(2) / np.maximum(((b - a) ** 2).sum(1), 1e-20), 0, 1)
        out[s:s + step] = np.linalg.norm(p - a - t[..., None] * (b - a), axis=2).min(1)
    return out


def to_triangles(p, a, b, c):
    """Distance of points (N, 3) to triangles of as many, or of (N, K, 3)."""
    n = np.cross(b - a, c - a)
    n /= np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-20)
    inside, sides = np.ones(p.shape[:-1], bool), np.inf
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, p - u) * n).sum(-1) >= 0
        t = np.clip(((p - u) * (v - u)).sum(-1) / np.maximum(((v - u) ** 2).sum(-1), 1e-20), 0, 1)
        sides = np.minimum(sides, np.linalg.norm(p - u - t[..., None] * (v - u), axis=-1))
    return np.where(inside, np.abs(((p - a) * n).sum(-1)), sides)


class Cells:
    """Points in cubes, to find those near others."""

    def __init__(self, points, side):
        self.points, self.side, self.low = points, side, points.min(0) - 3 * side
        self.size = (np.ceil((points.max(0) - self.low) / side) + 4).astype(np.int64)
        keys = self.key(self.place(points))
        self.order = np.argsort(keys, kind="stable")
        self.keys = keys[self.order]

    def place(self, points):
        return np.clip(np.floor((points - self.low) / self.side).astype(np.int64), 1, self.size - 2)

    def key(self, place):
        return (place[:, 0] * self.size[1] + place[:, 1]) * self.size[2] + place[:, 2]

    def nearest(self, points):
        """The nearest point to each and its distance; a distance above a cube's side may be too large."""
        best, found, home = np.full(len(points), np.inf), np.zeros(len(points), np.int64), self.place(points)
        for offset in np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T:
            keys = self.key(home + offset)
            starts, ends = np.searchsorted(self.keys, keys), np.searchsorted(self.keys, keys, "right")
            for k in range(int((ends - starts).max(initial=0))):
                rows = np.nonzero(starts + k < ends)[0]
                candidates = self.order[starts[rows] + k]
                away = np.linalg.norm(points[rows] - self.points[candidates], axis=1)
                better = away < best[rows]
                best[rows[better]], found[rows[better]] = away[better], candidates[better]
        return found, best


class Surface:
    """Points and quads, to find the distance of other points to them."""

    def __init__(self, points, quads):
        self.points, self.quads = points, quads
        self.cells = [Cells(points, side) for side in (3.0, 12.0, 48.0)]
        by_point = np.argsort(quads.ravel(), kind="stable")
        self.around = by_point // 4
        self.first = np.searchsorted(quads.ravel()[by_point], np.arange(len(points) + 1))

    def nearest(self, points):
        """The nearest point of the surface to each point."""
        found, left = np.zeros(len(points), np.int64), np.arange(len(points))
        for cells in self.cells:
            found[left], away = cells.nearest(points[left])
            left = left[away > cells.side]
        if len(left):
            raise SystemExit("a point is far from the surface")
        return found

    def distances(self, points):
        """Distance of each point to the surface, and the nearest of the surface's points."""
        found = self.nearest(points)
        out = np.full(len(points), np.inf)
        for k in range(int(np.diff(self.first).max())):
            rows = np.nonzero(self.first[found] + k < self.first[found + 1])[0]
            a, b, c, d = (self.points[self.quads[self.around[self.first[found[rows]] + k]][:, i]] for i in range(4))
            for triangle in ((a, b, c), (a, c, d)):
                out[rows] = np.minimum(out[rows], to_triangles(points[rows], *triangle))
        return out, found


# ------------------------------------------------------------------------------- rows

def set_border(mesh, name):
    """The edges between a face set and other faces."""
    inside = np.zeros(len(mesh.counts), int)
    inside[dict(mesh.subsets("face"))[name]] = 1
    pairs, which = np.unique(np.sort(mesh.edges(), axis=1), axis=0, return_inverse=True)
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    uses, of_them = np.bincount(which.ravel()), np.bincount(which.ravel(), inside[face])
    return pairs[(of_them == 1) & (uses == 2)]


class Reference:
    """The limit surface of a garment without seams, and the curves of its sets."""

    def __init__(self, program, cage):
        self.program = program
        self.mesh = cages.build(program, cage, level=REFERENCE)
        self.points = limits(self.mesh)
        quads = self.mesh.indices.reshape(-1, 4)
        self.surface = Surface(self.points, quads)
        across = self.points[np.roll(quads, -2, 1)] - self.points[quads]
        faces = np.cross(across[:, :1], across[:, 1:2])
        normals = add_at(len(self.points), quads, np.repeat(faces, 4, 1))
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def refined(self, mesh, level=1):
        """The mesh refined once more, which leaves only quads, or more often."""
        return cages.build(self.program, cages.Again(mesh), level=level)

    def project(self, points, nearest):
        """Places of points on the tangent planes of their nearest points of the surface, and heights above these."""
        height = ((points - self.points[nearest]) * self.normals[nearest]).sum(1)
        return points - height[:, None] * self.normals[nearest], height

    def moves(self, mesh, edges, width):
        """Moves of points away from the seam along an edge set, and on it."""
        points = limits(self.refined(mesh))
        a, b = dict(self.mesh.subsets("edge"))[edges].reshape(-1, 2).T
        moved, nearest = self.surface.distances(points)
        beside = to_segments(self.project(points, nearest)[0], self.points[a], self.points[b])
        return moved[beside > width], moved[beside <= width]

    def border_moves(self, mesh, name):
        """Moves of the border of a face set, from the curve that it was."""
        (a, b), mesh = set_border(self.mesh, name).T, self.refined(mesh)
        return (to_segments(limits(mesh)[np.unique(set_border(mesh, name))], self.points[a], self.points[b]),)

    def profile(self, mesh, edges):
        """Depth of a seam along x, and width at half of it, in PLACES parts along it without its ends."""
        ids = dict(self.mesh.subsets("edge"))[edges]
        points = limits(self.refined(mesh, 3))
        deep, nearest = self.surface.distances(points)
        (place, height), curve = self.project(points, nearest), self.points[ids]
        deep *= -np.sign(height)
        beside = to_segments(place, curve[::2], curve[1::2])
        low, high = curve[:, 0].min(), curve[:, 0].max()
        along = np.floor((place[:, 0] - low) / (high - low) * PLACES)
        parts = [(deep[along == k], beside[along == k]) for k in range(1, PLACES - 1)]
        return [(d.max(), 2 * b[d >= d.max() / 2].max()) for d, b in parts]


ROOFS = {f"roof of {turn} degrees": (cages.roof(turn), ["ridge"]) for turn in (45, 90)}
GARMENTS = {**ROOFS, "shirt": (cages.shirt(), ["shoulder", "armhole", "neckline", "side"])}
BORDERS = [("roof of 90 degrees", "ridge", "half", "crosses it"), ("shirt's collar", "ending", "collar", "ends at it"),
           ("shirt's collar", "shoulder", "collar", "ends at it"), ("shirt's collar", "crossing", "collar", "crosses it"),
           ("shirt's collar", "neckline", "collar", "runs along it")]


def figures(moves):
    return " | ".join(f"{m.max():.2f}, {m.mean():.3f}" if len(m) else "" for m in moves)


def profile_figures(parts):
    return " | ".join(f"{min(values):.1f} to {max(values):.1f}" for values in zip(*parts))


def table(title, head, columns, rows, programs):
    """Prints a table: rows have words, and a function that gives the cells of a program."""
    print(f"{title}\n\n| {head} | " + " | ".join(f"{word}{column}" for word, *_ in programs for column in columns) + " |")
    print("|" + "---|" * (head.count("|") + 1 + len(columns) * len(programs)))
    for words, cells in rows:
        print(f"| {words} | " + " | ".join(cells(program, options) for _, program, options in programs) + " |", flush=True)
    print()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("usdtailor")
    parser.add_argument("old", nargs="?", help="an older usdtailor to compare with")
    parser.add_argument("--level", type=int, default=2, help="render.level of the meshes with seams")
    parser.add_argument("--set", action="append", default=[], metavar="OPTION=VALUE", help="options of the first program")
    args = parser.parse_args()
    programs = [("old, ", args.old, [])] if args.old else []
    programs += [("new, " if args.old else "", args.usdtailor, args.set)]
    references = {name: Reference(args.usdtailor, cage) for name, (cage, _) in GARMENTS.items()}

    def built(cage, program, options, name, **seam):
        return cages.build(program, cage, cages.seam(name, **seam) + options, args.level)

    def surface_row(garment, name, width):
        def cells(*run):
            return figures(references[garment].moves(built(GARMENTS[garment][0], *run, name, width=width), name, width))
        return f"{garment} | {name} | {width} mm", cells

    def border_row(words, name, faces, how, width):
        garment = "shirt" if words.startswith("shirt") else words

        def cells(*run):
            return figures(references[garment].border_moves(built(GARMENTS[garment][0], *run, name, width=width), faces))
        return f"{words} | {name} | {how} | {width} mm", cells

    def profile_row(words, cage, width):
        reference = Reference(args.usdtailor, cage)

        def cells(*run):
            mesh = built(cage, *run, "seam", width=width, normalOffset=-1.5)
            away, _ = reference.moves(mesh, "seam", width)
            return f"{profile_figures(reference.profile(mesh, 'seam'))} | {figures([away])}"
        return f"{words} | {width} mm", cells

    edge = np.mean([cage.mean_edge() for cage, _ in GARMENTS.values()])
    table(f"Moves in mm, largest and mean. 1 % of the mean edge is {edge / 100:.2f} mm.",
          "garment | seam | width", ["away from it", "on it"],
          (surface_row(garment, name, width) for garment, (_, names) in GARMENTS.items() for name in names
           for width in (8, 3)), programs)
    table("Moves of the border of a face set in mm, largest and mean.", "set | seam | which | width", ["border"],
          (border_row(*border, width) for border in BORDERS for width in (8, 3)), programs)
    table("Least and largest depth along a seam that is 1.5 mm deep, width at half of the depth, and moves in mm.",
          "sheet | width", ["depth", "at half depth", "away from it"],
          (profile_row(name, *sheet) for name, sheet in cages.uneven_sheets().items()), programs)


if __name__ == "__main__":
    main()
