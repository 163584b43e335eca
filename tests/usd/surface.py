"""Distances between points, curves and triangles, by brute force and a grid."""

import numpy as np


def triangles_of(counts, indices):
    """Triangles that cover the faces: both ways to split a quad, a fan otherwise; and the face of each."""
    offsets = np.concatenate([[0], np.cumsum(counts)[:-1]])
    triangles, faces = [], []
    for count in np.unique(counts):
        which = np.flatnonzero(counts == count)
        corners = indices[offsets[which][:, None] + np.arange(count)]
        splits = [(0, 1, 2), (0, 2, 3), (1, 2, 3), (1, 3, 0)] if count == 4 else [(0, i, i + 1) for i in range(1, count - 1)]
        for split in splits:
            triangles.append(corners[:, split])
            faces.append(which)
    return np.concatenate(triangles), np.concatenate(faces)


def distance_to_triangles(points, triangles, reach):
    """For each point the distance to the nearest of `triangles` (n, 3, 3); infinite where it exceeds `reach`."""
    size = max(np.linalg.norm(triangles[:, 0] - triangles[:, 1], axis=1).mean() * 2, reach)
    origin = np.minimum(points.min(axis=0), triangles.min(axis=(0, 1))) - 2 * size
    cells = np.floor((np.maximum(points.max(axis=0), triangles.max(axis=(0, 1))) - origin) / size).astype(int) + 3

    def key(cell):
        return (cell[..., 0] * cells[1] + cell[..., 1]) * cells[2] + cell[..., 2]

    low = np.floor((triangles.min(axis=1) - reach - origin) / size).astype(int)
    high = np.floor((triangles.max(axis=1) + reach - origin) / size).astype(int)
    span = high - low + 1
    owner, step = ragged(span.prod(axis=1))
    width = span[owner]
    offset = np.stack([step // (width[:, 1] * width[:, 2]), step // width[:, 2] % width[:, 1], step % width[:, 2]], axis=1)
    keys = key(low[owner] + offset)
    order = np.argsort(keys, kind="stable")
    keys, owner = keys[order], owner[order]

    wanted = key(np.floor((points - origin) / size).astype(int))
    first, last = np.searchsorted(keys, wanted), np.searchsorted(keys, wanted, side="right")
    best = np.full(len(points), np.inf)
    for start in range(0, len(points), 2000):
        part = slice(start, start + 2000)
        point, step = ragged((last - first)[part])
        found = owner[first[part][point] + step]
        apart = point_triangle(points[part][point], triangles[found])
        np.minimum.at(best, point + start, apart)
    return np.where(best <= reach, best, np.inf)


def ragged(counts):
    """For groups of these sizes: the group of each member, and its place in the group."""
    group = np.repeat(np.arange(len(counts)), counts)
    return group, np.arange(len(group)) - np.repeat(np.cumsum(counts) - counts, counts)


def point_triangle(points, triangles):
    """The distance of each point to its triangle."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    best = np.minimum(np.minimum(point_segment(points, a, b), point_segment(points, b, c)), point_segment(points, c, a))
    normal = np.cross(b - a, c - a)
    area = np.maximum((normal**2).sum(axis=1), 1e-300)
    inside = np.ones(len(points), bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(q - p, points - p) * normal).sum(axis=1) >= 0
    height = np.abs(((points - a) * normal).sum(axis=1)) / np.sqrt(area)
    return np.where(inside, np.minimum(height, best), best)


def point_segment(points, a, b):
    """The distance of each point to its segment."""
    along = b - a
    length = np.maximum((along**2).sum(axis=-1), 1e-300)
    t = np.clip(((points - a) * along).sum(axis=-1) / length, 0, 1)
    return np.linalg.norm(points - a - t[..., None] * along, axis=-1)


def distance_to_segments(points, segments):
    """For each point the distance to the nearest of `segments` (n, 2, 3)."""
    best = np.full(len(points), np.inf)
    for start in range(0, len(points), 500):
        part = points[start : start + 500]
        best[start : start + 500] = point_segment(part[:, None], segments[None, :, 0], segments[None, :, 1]).min(axis=1)
    return best
