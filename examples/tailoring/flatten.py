"""Flattens the panels of a garment into a sewing pattern: LSCM, then ARAP, then packing.

All panels keep one scale: after ARAP, lengths in the plane are lengths on the cloth, in
centimetres."""
import numpy as np


def uv_points(faces, panels, cuts):
    """Joins face corners into UV points: corners of one mesh point are one UV point when their
    faces meet at an edge inside a panel which is not a cut.  (corner -> UV point), count."""
    starts = np.concatenate([[0], np.cumsum([len(f) for f in faces])])
    parent = list(range(starts[-1]))

    def find(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    sides = {}
    for f, face in enumerate(faces):
        for k in range(len(face)):
            n = (k + 1) % len(face)
            a, b = face[k], face[n]
            corners = {a: starts[f] + k, b: starts[f] + n}
            key = (min(a, b), max(a, b))
            if key in cuts:
                continue
            for other, other_corners in sides.get(key, []):
                if panels[other] == panels[f]:
                    for v in key:
                        parent[find(corners[v])] = find(other_corners[v])
            sides.setdefault(key, []).append((f, corners))
    roots = [find(i) for i in range(len(parent))]
    order = {}
    for r in roots:
        order.setdefault(r, len(order))
    return np.array([order[r] for r in roots]), len(order)


def _triangles(face_uvs):
    """Triangles of polygons; a quad gives both its pairs, each counted half."""
    out, weight = [], []
    for ring in face_uvs:
        n = len(ring)
        if n == 4:
            for t in ((0, 1, 2), (0, 2, 3), (1, 2, 3), (1, 3, 0)):
                out.append([ring[i] for i in t])
                weight.append(0.5)
        else:
            for k in range(1, n - 1):
                out.append([ring[0], ring[k], ring[k + 1]])
                weight.append(1.0)
    return np.array(out), np.array(weight)


def _local_frames(p):
    """Triangles (T, 3, 3) laid isometrically in the plane, (T, 3, 2)."""
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    length = np.linalg.norm(e1, axis=1)
    x = e1 / length[:, None]
    n = np.cross(e1, e2)
    area2 = np.linalg.norm(n, axis=1)
    out = np.zeros((len(p), 3, 2))
    out[:, 1, 0] = length
    out[:, 2, 0] = (e2 * x).sum(1)
    out[:, 2, 1] = area2 / length
    return out


def lscm(points, tris, weight):
    """Least squares conformal map with the two most distant points held."""
    q = _local_frames(points[tris])
    area = np.sqrt(np.maximum((q[:, 1, 0] * q[:, 2, 1]) / 2, 1e-9)) / np.sqrt(weight)
    n, rows = len(points), len(tris)
    a = np.zeros((2 * rows, 2 * n))
    r = np.arange(rows)
    for k in range(3):
        d = (q[:, (k + 2) % 3] - q[:, (k + 1) % 3]) / area[:, None]
        np.add.at(a, (r, tris[:, k]), d[:, 0])
        np.add.at(a, (r, tris[:, k] + n), -d[:, 1])
        np.add.at(a, (r + rows, tris[:, k]), d[:, 1])
        np.add.at(a, (r + rows, tris[:, k] + n), d[:, 0])
    i = int(np.argmax(np.linalg.norm(points - points[0], axis=1)))
    j = int(np.argmax(np.linalg.norm(points - points[i], axis=1)))
    held = np.array([i, j, i + n, j + n])
    values = np.array([0.0, np.linalg.norm(points[i] - points[j]), 0.0, 0.0])
    free = np.setdiff1d(np.arange(2 * n), held)
    b = -a[:, held] @ values
    m = a[:, free]
    solution = np.zeros(2 * n)
    solution[held] = values
    solution[free] = np.linalg.solve(m.T @ m + 1e-10 * np.eye(len(free)), m.T @ b)
    return np.stack([solution[:n], solution[n:]], 1)


def arap(points, tris, weight, uv, steps=120):
    """As rigid as possible: each triangle wants to be a rotated copy of itself."""
    q = _local_frames(points[tris])
    n = len(points)
    cot = np.zeros((len(tris), 3))
    for k in range(3):
        u, v = q[:, (k + 1) % 3] - q[:, k], q[:, (k + 2) % 3] - q[:, k]
        cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        cot[:, k] = np.clip((u * v).sum(1) / np.maximum(cross, 1e-9), 0.05, 20) * weight
    lap = np.zeros((n, n))
    for k in range(3):
        i, j = tris[:, (k + 1) % 3], tris[:, (k + 2) % 3]
        for a, b in ((i, j), (j, i)):
            np.add.at(lap, (a, a), cot[:, k])
            np.add.at(lap, (a, b), -cot[:, k])
    inverse = np.linalg.inv(lap + np.ones((n, n)) / n)
    for _ in range(steps):
        s = np.zeros((len(tris), 2, 2))
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            s += cot[:, k, None, None] * np.einsum(
                "ti,tj->tij", uv[tris[:, j]] - uv[tris[:, i]], q[:, j] - q[:, i])
        angle = np.arctan2(s[:, 1, 0] - s[:, 0, 1], s[:, 0, 0] + s[:, 1, 1])
        c, d = np.cos(angle), np.sin(angle)
        rot = np.stack([np.stack([c, -d], 1), np.stack([d, c], 1)], 1)
        b = np.zeros((n, 2))
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            e = cot[:, k, None] * np.einsum("tij,tj->ti", rot, q[:, j] - q[:, i])
            np.add.at(b, tris[:, j], e)
            np.add.at(b, tris[:, i], -e)
        uv = inverse @ b
    return uv


def _upright(points, tris, uv, grain):
    """Turns a panel so that the direction of its grain in space runs up in the plane."""
    p, t = points[tris], uv[tris]
    q = _local_frames(p)
    e1 = (p[:, 1] - p[:, 0]) / np.linalg.norm(p[:, 1] - p[:, 0], axis=1)[:, None]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(normal, axis=1)
    e2 = np.cross(normal / area[:, None], e1)
    local = np.stack([e1 @ grain, e2 @ grain], 1)
    flat = np.stack([q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]], 2)
    mapped = np.stack([t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]], 2)
    jacobian = mapped @ np.linalg.inv(flat)
    d = (np.einsum("tij,tj->ti", jacobian, local) * area[:, None]).sum(0)
    d /= np.linalg.norm(d)
    # Takes d to (0, 1).
    return uv @ np.array([[d[1], d[0]], [-d[0], d[1]]])


def pack(boxes, width, gap):
    """Places boxes on shelves, tallest first; positions and the height used."""
    order = sorted(range(len(boxes)), key=lambda i: (-boxes[i][1], i))
    at, x, y, shelf = [None] * len(boxes), gap, gap, 0.0
    for i in order:
        w, h = boxes[i]
        if x + w + gap > width and x > gap:
            x, y, shelf = gap, y + shelf + gap, 0.0
        # Low pieces stand on each other while they fit on their shelf.
        at[i] = (x, y)
        x += w + gap
        shelf = max(shelf, h)
    return at, y + shelf + gap


def flatten(garment, grains, gap=2.0):
    """UVs of a garment: (uv values in 0..1, index per corner, centimetres per UV unit)."""
    points = np.array(garment.points)
    corner_uv, count = uv_points(garment.faces, garment.panels, garment.cuts)
    uv_to_point = np.zeros(count, int)
    flat_index = np.concatenate([np.array(f) for f in garment.faces])
    uv_to_point[corner_uv] = flat_index
    starts = np.concatenate([[0], np.cumsum([len(f) for f in garment.faces])])
    uv = np.zeros((count, 2))
    names = list(dict.fromkeys(garment.panels))
    members = {n: [] for n in names}
    for f, n in enumerate(garment.panels):
        members[n].append(f)
    pieces = []
    for name in names:
        rings = [corner_uv[starts[f]:starts[f + 1]] for f in members[name]]
        for group in _connected(rings):
            own, inverse = np.unique(np.concatenate(group), return_inverse=True)
            ends = np.cumsum([len(r) for r in group])[:-1]
            tris, weight = _triangles(np.split(inverse, ends))
            p = points[uv_to_point[own]]
            flat = arap(p, tris, weight, lscm(p, tris, weight))
            flat = _upright(p, tris, flat, np.array(grains.get(name, (0, 1, 0)), float))
            uv[own] = flat - flat.min(0)
            pieces.append(own)
    boxes = [np.ptp(uv[o], axis=0) for o in pieces]
    best = None
    for width in np.arange(60, 600, 5.0):
        if width < max(b[0] for b in boxes) + 2 * gap:
            continue
        at, height = pack(boxes, width, gap)
        if best is None or max(width, height) < best[0]:
            best = (max(width, height), at)
    unit = np.ceil(best[0] / 5) * 5
    for own, at in zip(pieces, best[1]):
        uv[own] += np.array(at)
    return uv / unit, corner_uv, float(unit)


def _connected(rings):
    """Groups of faces which share UV points."""
    owner = {}
    groups = {}
    for i, ring in enumerate(rings):
        touched = {owner[u] for u in ring.tolist() if u in owner}
        home = min(touched) if touched else i
        members = groups.setdefault(home, [])
        for t in touched - {home}:
            for j in groups[t]:
                for u in rings[j].tolist():
                    owner[u] = home
            members.extend(groups.pop(t))
        members.append(i)
        for u in ring.tolist():
            owner[u] = home
    return [[rings[i] for i in sorted(g)] for _, g in sorted(groups.items())]
