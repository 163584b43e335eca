"""Draws a shirt with the names of its sets on it, for `pictures.py`."""
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import ImageDraw
from pxr import Usd

import cages
import draw

SHIRT = Path(__file__).resolve().parents[2] / "examples/tshirt.usda"
SIZE, FONT = (1180, 720), 25
# Each expression with the direction, to the right and up, in which one finds the place of its label on the set.
EDGES = {
    "uvSeams": (-0.4, 1.0), "borders.minX": (-1.0, -0.3), "side_seams": (-1.0, -0.4), "borders.highest": (0.3, 0.2),
    "borders.maxX": (1.0, 0.0), "borders.maxZ": (0.7, -1.0), "borders.lowest": (0.5, -0.6),
}
FACES = {
    "material(rib)": (-0.5, 0.3), "uvShells.minX": (-0.2, 0.6), "uvShells.1": (-0.3, 0.02), "uvShells.maxX": (0.2, 0.6),
    "rings(borders.maxX, 2)": (1.0, -0.1), "material(pocket)": (0.7, -1.0), "rings(borders.lowest, 2)": (0.8, -0.2),
}


def model(program, expressions, element):
    """The shirt with the sets of some expressions alone, by names that keep their order."""
    with tempfile.TemporaryDirectory() as folder:
        layer = str(Path(folder) / "sets.usda")
        bakes = [word for k, text in enumerate(expressions) for word in ("--bake", f"label_{k}={text}")]
        subprocess.run([program, "sets", str(SHIRT), *bakes, "-o", layer], check=True, capture_output=True)
        mesh = cages.product(Usd.Stage.Open(layer), "model")
        sets = dict(mesh.subsets(element))
    named = [(text, np.asarray(sets.get(f"label_{k}", sets.get(text)))) for k, text in enumerate(expressions)]
    mesh.subsets = lambda wanted="face", family=None: named if wanted == element else []
    mesh.border = lambda: np.zeros((0, 2), int)
    return mesh, named


def places(mesh, element, ids):
    """The middles of the edges or faces of a set, and their outer normals."""
    normals = np.zeros_like(mesh.points)
    np.add.at(normals, mesh.tris, mesh.corner_normals())
    if element == "edge":
        return (values[ids.reshape(-1, 2)].mean(1) for values in (mesh.points, normals))
    corners = [mesh.indices[mesh.starts[f]:mesh.starts[f] + mesh.counts[f]] for f in ids]
    return (np.array([values[c].mean(0) for c in corners]) for values in (mesh.points, normals))


def tile(program, element, directions):
    mesh, named = model(program, directions, element)
    camera = draw.Camera.fit([mesh], "18,8", SIZE)
    camera.radius *= 1.12
    image = draw.render(mesh, camera, wire=True, edges=element == "edge", line=1.4, wire_strength=0.25, samples=3,
                        color="subset:all" if element == "face" else "none")
    pen, labels, axes = ImageDraw.Draw(image), {-1: [], 1: []}, camera.axes()
    for (text, ids), colour, (right, up) in zip(named, draw.palette(len(named)), directions.values()):
        points, normals = places(mesh, element, ids)
        seen = points[normals @ axes[2] > 0]
        best = seen[np.argmax(seen @ axes[:2].T @ (right, up))]
        x, y = camera.pixels(best, 1)[:2]
        labels[1 if x > SIZE[0] / 2 else -1].append((y, x, text, tuple(int(255 * c * 0.62) for c in colour)))
    for side, found in labels.items():
        at = 0.0
        for y, x, text, colour in sorted(found):
            at = max(y - 0.5 * FONT, at + 1.9 * FONT)
            edge = FONT if side < 0 else SIZE[0] - FONT
            width = pen.textlength(text, font_size=FONT)
            pen.line([(x, y), (edge - side * (width + 8), at)], fill=colour, width=2)
            pen.circle((x, y), 5, fill=colour)
            pen.text((edge, at), text, fill=colour, anchor="lm" if side < 0 else "rm", font_size=FONT)
    return image


def named_sets(program):
    """Sets of edges, and of faces, as a sheet."""
    both = {"sets of edges": ("edge", EDGES), "sets of faces": ("face", FACES)}
    return draw.sheet([[(tile(program, *of), words) for words, of in both.items()]], font=30).quantize(256)
