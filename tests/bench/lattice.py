#!/usr/bin/env python3
"""Our meshes, stitched lattices and PyMeshLab's side by side, as figure 1 of Waggoner and de Goes 2022, for `cargo xtask peers`.

    lattice.py DIR [PICTURE]

DIR has NAME.obj by `--bench quality -- --export DIR` (the surface, its length and its constraints) and NAME.ours.obj and
NAME.lattice.obj by `--bench lattice -- --export DIR`. PyMeshLab remeshes the surface at a length that gives as many vertices as
ours. *Irregular* is the share of inner vertices within three edges of a constraint that have not six neighbours, *far* that of
the others; angles are the smallest of each triangle, in degrees."""
import sys
from pathlib import Path

import numpy as np
from peers import pymeshlab, read
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))
import draw  # noqa: E402

NEAR = 3  # edges
# A vertex is on a constraint if it is as near to it. [target lengths]
ON = 0.05
PICTURED = "coat"
BLUE, RED = (33, 102, 172), (214, 96, 77)


def at_count(surface, wanted):
    """PyMeshLab's mesh at the length that gives about `wanted` vertices."""
    length, points, faces, lines = surface
    for _ in range(4):
        _, found, triangles = pymeshlab(length, points, faces, lines)
        if abs(len(found) / wanted - 1) < 0.01:
            break
        length *= np.sqrt(len(found) / wanted)
    return found, triangles


def samples(surface):
    """Points along the constraints, closer together than `ON`."""
    length, points, _, lines = surface
    steps = np.linspace(0, 1, 41)[:, None, None]
    ends = points[lines]
    return (ends[:, 0] * (1 - steps) + ends[:, 1] * steps).reshape(-1, 3), length


def neighbours(count, triangles):
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0, return_counts=True)
    near = [[] for _ in range(count)]
    for a, b in edges[0]:
        near[a].append(b)
        near[b].append(a)
    return near, np.unique(edges[0][edges[1] != 2])


def smallest_angles(points, triangles):
    corners = points[triangles]
    ahead, back = np.roll(corners, -1, 1) - corners, np.roll(corners, 1, 1) - corners
    cosines = (ahead * back).sum(2) / np.maximum(np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2), 1e-30)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1))).min(1)


def irregular(points, triangles, tree, length):
    """The irregular inner vertices near constraints and far from them, and the numbers of all of both."""
    near, border = neighbours(len(points), triangles)
    on = tree.query(points)[0] < ON * length
    on[border] = True
    rings, front = np.where(on, 0, NEAR + 1), np.flatnonzero(on)
    for ring in range(1, NEAR + 1):
        front = [w for v in front for w in near[v] if rings[w] > ring]
        rings[front] = ring
    inner = np.array([rings[v] > 0 and len(near[v]) > 0 for v in range(len(points))])
    odd = inner & (np.array([len(n) for n in near]) != 6)
    sides = (rings <= NEAR, rings > NEAR)
    return [np.flatnonzero(odd & side) for side in sides], [(inner & side).sum() for side in sides]


def picture(meshes, tree, length):
    """A close-up of each mesh around the constraint point that has most of them about it."""
    ours = meshes["ours"][0]
    # In front, as the same place is on the back too.
    front = ours[ours[:, 2] > np.quantile(ours[:, 2], 0.7)]
    middle = front[np.abs(front[:, :2] - [np.median(ours[:, 0]), np.quantile(ours[:, 1], 0.62)]).sum(1).argmin()]
    camera, tiles = draw.Camera(0, 0, middle, 9 * length, (540, 540)), []
    for name, (points, triangles) in meshes.items():
        mesh = draw.Mesh(name, points, np.full(len(triangles), 3), triangles.ravel())
        near = np.abs(points[mesh.tris].mean(1) - middle).max(1) < 11 * length
        shown = mesh.part(near & (mesh.corner_normals(flat=True)[:, 0, 2] > 0))
        visible = np.unique(shown.tris)
        on = visible[tree.query(points[visible])[0] < ON * length]
        odd = np.intersect1d(irregular(points, triangles, tree, length)[0][0], visible)
        image = draw.render(shown, camera, [(points[on], BLUE, 5), (points[odd], RED, 9)], wire=True, flat=True, samples=3, ambient=0.55)
        tiles.append((image, f"{name}: {len(odd)} irregular here\nblue: on a constraint; red: irregular, within {NEAR} edges of one"))
    return draw.sheet([tiles], font=22)


def main():
    folder = Path(sys.argv[1])
    print(f"{'garment':24} {'mesh':10} {'vertices':>8} {'irregular':>10} {'far':>7} {'p1':>6} {'p5':>6} {'<30 %':>7}")
    for file in sorted(folder.glob("*.ours.obj")):
        name = file.name.split(".")[0]
        surface = read(folder / f"{name}.obj")
        along, length = samples(surface)
        tree = cKDTree(along)
        meshes = {kind: read(folder / f"{name}.{kind}.obj")[1:3] for kind in ("ours", "lattice")}
        meshes["pymeshlab"] = at_count(surface, len(np.unique(meshes["ours"][1])))
        for kind, (points, triangles) in meshes.items():
            (near, far), (all_near, all_far) = irregular(points, triangles, tree, length)
            angles = smallest_angles(points, triangles)
            shares = [100 * len(part) / max(1, all_of) for part, all_of in ((near, all_near), (far, all_far))]
            p1, p5 = np.percentile(angles, [1, 5])
            print(f"{name:24} {kind:10} {len(np.unique(triangles)):8} {shares[0]:9.1f}% {shares[1]:6.1f}% {p1:6.1f} {p5:6.1f} {100 * (angles < 30).mean():7.2f}", flush=True)
        if name == PICTURED and len(sys.argv) > 2:
            picture(meshes, tree, length).quantize(128).save(sys.argv[2], optimize=True)


if __name__ == "__main__":
    main()
