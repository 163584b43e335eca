#!/usr/bin/env python3
"""Adds seams and folds to examples/coat.usda in a layer over it, and draws the result.

    sew.py author [-o examples/sewn/coat.usda]
    cargo usdtailor build examples/sewn/coat.usda -o cage.usda --set render.level=0
    cargo usdtailor build examples/sewn/coat.usda -o surface.usda --set render.level=3
    sew.py draw cage.usda surface.usda [-o examples/sewn.png]

A seam is an applied `TailorSeamAPI:<name>` with the edge sets that it follows. A fold is a
`TailorFoldAPI:<name>` with face sets at a border. The schemas need not be registered, as attributes are
authored by name."""
import argparse
import copy
import os
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from pxr import Sdf, Usd, UsdGeom, Vt

import draw
import meshes

HERE = Path(__file__).resolve().parent
T = Sdf.ValueTypeNames

# In centimetres. Seams sewn right sides together and pressed open are grooves. Pockets are pressed onto the body along
# their outlines. A stitched line is narrow and shallow.
SEAMS = {
    "side": {"edges": ["side_seams"], "width": 0.7, "depth": 0.04, "normalOffset": -0.16},
    "shoulder": {"edges": ["shoulder_seams"], "width": 0.7, "depth": 0.04, "normalOffset": -0.16},
    # The allowance is pressed to one side. Asymmetry follows the direction of the edges, so a seam on both halves of a
    # garment would need one instance for each half.
    "back": {"edges": ["centre_back"], "width": 0.7, "depth": 0.04, "normalOffset": -0.16, "asymmetry": 0.3},
    "sleeve": {"edges": ["sleeve_seams"], "width": 0.6, "depth": 0.04, "normalOffset": -0.14},
    "armhole": {"edges": ["armholes"], "width": 0.5, "depth": 0.06, "normalOffset": -0.14},
    "neckline": {"edges": ["neck_seam"], "width": 0.7, "depth": 0.03, "normalOffset": -0.12},
    "placket": {"edges": ["placket_stitch"], "width": 0.5, "normalOffset": -0.05},
    "pocket": {"edges": ["pocket_outline"], "width": 0.8, "normalOffset": -0.18},
    "dart": {"edges": ["darts"], "width": 0.6, "depth": 0.03, "normalOffset": -0.11},
}
FOLDS = {
    "collar": {"faces": ["collar_facing"], "thickness": 0.35, "weights": "thicknessWeight"},
    "cuffs": {"faces": ["cuff_left", "cuff_right"], "thickness": 0.35, "weights": "thicknessWeight"},
    "hem": {"faces": ["hem_turnup"], "thickness": 0.15},
    "flap": {"faces": ["flap_left", "flap_right"], "thickness": 0.12},
}
TYPES = {"width": T.Float, "depth": T.Float, "normalOffset": T.Float, "asymmetry": T.Float, "thickness": T.Float,
         "weights": T.Token}


# ------------------------------------------------------------------------------- sets that the coat lacks

def turnup(mesh):
    """The row of faces above the hem, except where a facing lies behind it."""
    sets = dict(mesh.subsets("edge"))
    on = {name: np.isin(mesh.indices, sets[name]) for name in ("hem", "placket", "placket_stitch", "facing_edge")}
    corners = {name: np.add.reduceat(hit.astype(int), mesh.starts) for name, hit in on.items()}
    at_hem = corners.pop("hem") == 2
    return np.nonzero(at_hem & (sum(corners.values()) == 0))[0]


def outline(mesh, faces):
    """The edges between `faces` and all other faces."""
    inside = np.zeros(len(mesh.counts), int)
    inside[faces] = 1
    pairs, which = np.unique(np.sort(mesh.edges(), axis=1), axis=0, return_inverse=True)
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    uses, of_them = np.bincount(which.ravel()), np.bincount(which.ravel(), inside[face])
    return pairs[(of_them == 1) & (uses == 2)]


def collar_facing(mesh):
    """The collar without the faces at both ends of its fold, where it narrows to a point and fits no second layer."""
    fold, uses = np.unique(dict(mesh.subsets("edge"))["collar_fold"], return_counts=True)
    collar = dict(mesh.subsets("face"))["collar"]
    at_ends = np.add.reduceat(np.isin(mesh.indices, fold[uses == 1]).astype(int), mesh.starts)
    return collar[at_ends[collar] == 0]


def darts(mesh):
    """Edges of a dart on each front, from hip to chest beside the pocket; both ends are inside the mesh."""
    waist = dict(mesh.subsets("edge"))["waist_line"].reshape(-1, 2)
    ends = np.unique(waist)
    front = ends[mesh.points[ends, 2] > 0]
    pairs = []
    for side in (1, -1):
        start = front[np.argmin(np.abs(mesh.points[front, 0] - 11.0 * side))]
        for up in (1, -1):
            pairs += straight(mesh, start, np.array([0, up, 0]), 3)
    return pairs


def straight(mesh, at, direction, count):
    """A path of `count` edges from a point, each the one that deviates least from the last direction."""
    edges, path = mesh.edges(), []
    for _ in range(count):
        ahead = np.unique(np.concatenate([edges[edges[:, 0] == at][:, 1], edges[edges[:, 1] == at][:, 0]]))
        steps = mesh.points[ahead] - mesh.points[at]
        steps /= np.linalg.norm(steps, axis=1, keepdims=True)
        best = np.argmax(steps @ direction)
        path.append((int(at), int(ahead[best])))
        at, direction = ahead[best], steps[best]
    return path


# ------------------------------------------------------------------------------- the layer

def subset(model, name, element, family, indices):
    prim = UsdGeom.Subset.Define(model.GetStage(), model.GetPath().AppendChild(name))
    prim.CreateElementTypeAttr(element)
    prim.CreateFamilyNameAttr(family)
    prim.CreateIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(indices, np.int32).ravel()))


def apply(model, schema, space, targets, instances):
    """Applies a schema once for each of `instances`, with its sets as targets of the relationship `targets`."""
    for name, options in instances.items():
        model.AddAppliedSchema(f"{schema}:{name}")
        prefix = f"tailor:{space}:{name}:"
        sets = [model.GetPath().AppendChild(s) for s in options[targets]]
        model.CreateRelationship(prefix + targets, False).SetTargets(sets)
        for key, kind in TYPES.items():
            if key in options:
                model.CreateAttribute(prefix + key, kind, False, Sdf.VariabilityUniform).Set(options[key])


def author(source, out):
    """Writes a layer over `source` that adds the seams and folds to the model."""
    base = Usd.Stage.Open(str(source))
    path = base.GetDefaultPrim().GetPath().AppendChild("model")
    mesh = meshes.load(base, [path])[0]
    out.parent.mkdir(exist_ok=True)
    layer = Sdf.Layer.CreateNew(str(out))
    layer.documentation = "The coat of ../coat.usda with its seams, and with collar, cuffs, flaps and hem folded over."
    layer.subLayerPaths = [Path(os.path.relpath(source, out.parent)).as_posix()]
    over = Usd.Stage.Open(layer)
    for key in ("defaultPrim", "upAxis", "metersPerUnit"):
        if base.HasAuthoredMetadata(key):
            over.SetMetadata(key, base.GetMetadata(key))
    model = over.OverridePrim(path)
    subset(model, "collar_facing", "face", "sets", collar_facing(mesh))
    folded = turnup(mesh)
    subset(model, "hem_turnup", "face", "sets", folded)
    # As a constraint, the border keeps the face set exact on the simulation mesh.
    subset(model, "turnup_edge", "edge", "edges", outline(mesh, folded))
    model.CreateRelationship("tailor:sim:constraints", False).AddTarget(path.AppendChild("turnup_edge"))
    subset(model, "darts", "edge", "edges", darts(mesh))
    apply(model, "TailorSeamAPI", "seam", "edges", SEAMS)
    apply(model, "TailorFoldAPI", "fold", "faces", FOLDS)
    for name, kind, value in (("level", T.Int, 2), ("faceSets", T.Bool, True)):
        model.CreateAttribute(f"tailor:render:{name}", kind, False, Sdf.VariabilityUniform).Set(value)
    layer.Save()


# ------------------------------------------------------------------------------- the picture

WIDTH, GAP, LABEL = 1800, 8, 40     # pixels
WHOLE, CLOSE, COLUMNS = (WIDTH // 2, 900), (WIDTH // 3, 500), 3
INK, CUT = (25, 28, 38), (160, 30, 30)
# Title, ball to show (x, y, z, radius), view (azimuth, elevation), and cutting plane (point, normal) or None.
CLOSE_UPS = (
    ("seam: a dart, which ends in the surface", (11.3, 110.0, 14.0, 4.2), (20, 5), None),
    ("T junctions: shoulder, armhole, sleeve", (20.0, 144.5, -1.5, 6.0), (70, 40), None),
    ("T junction: side seam and hem", (29.0, 55.6, -1.0, 2.8), (72, -15), None),
    ("collar, cut behind the neck", (0.0, 149.2, -10.4, 6.0), (90, 0), ((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))),
    ("hem folded over, cut", (8.0, 56.0, -17.6, 2.4), (78, 6), ((8.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    ("pocket and flap", (21.5, 86.0, 12.0, 5.5), (60, 12), None),
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
    kept = at.mean(1) < 0
    return replace(mesh, kept), cut


def replace(mesh, kept):
    """A copy of a mesh with the triangles `kept`."""
    part = copy.copy(mesh)
    part.tris, part.corners, part.faces, part.real = (a[kept] for a in (mesh.tris, mesh.corners, mesh.faces, mesh.real))
    return part


def near(mesh, camera):
    """The triangles near a camera's field of view; drawing only these saves time."""
    away = np.abs((mesh.points[mesh.tris].mean(1) - camera.centre) @ camera.axes()[:2].T).max(1)
    return replace(mesh, away < 2 * camera.radius)


def close_up(surface, ball, view, plane):
    size = (CLOSE[0] - GAP, CLOSE[1] - GAP)
    # Drawn at twice the size, as Pillow's lines are not smooth.
    camera, large = draw.Camera(*view, np.array(ball[:3]), ball[3]), np.array(size) * 2
    mesh, cut = near(surface, camera), np.zeros((0, 2, 3))
    if plane:
        mesh, cut = behind(mesh, plane)
    style = draw.Style(size=tuple(large), wire=True, line=1.3, wire_strength=0.34, samples=2)
    image = draw.render(mesh, camera, style)
    screen = (cut - camera.centre) @ camera.axes().T[:, :2] * (large[1] / 2 / ball[3]) * (1, -1) + large / 2
    pen = ImageDraw.Draw(image)
    for a, b in screen:
        pen.line([tuple(a), tuple(b)], fill=CUT, width=7)
    return image.resize(size, Image.LANCZOS)


def compose(cage_stage, surface_stage):
    """Draws the input, the render mesh with the wires of its cage, and close-ups of the latter."""
    def one(stage, child):
        return draw.load(stage, [stage.GetDefaultPrim().GetPath().AppendChild(child)])[0]
    model, cage, surface = one(cage_stage, "model"), one(cage_stage, "render"), one(surface_stage, "render")
    keep_cage_edges(surface, cage)
    height = WHOLE[1] + LABEL + -(-len(CLOSE_UPS) // COLUMNS) * (CLOSE[1] + LABEL)
    image = Image.new("RGB", (WIDTH, height), tuple(int(c * 255 + 0.5) for c in draw.BACKGROUND))
    pen = ImageDraw.Draw(image)
    size = (WHOLE[0] - GAP, WHOLE[1] - GAP)
    camera = draw.Camera.fit([model, surface], "24,6", size)
    for k, (mesh, text) in enumerate(((model, "input cage"), (surface, "render mesh, with the wires of its cage"))):
        style = draw.Style(size=size, wire=True, line=0.8, wire_strength=0.5, samples=3)
        image.paste(draw.render(mesh, camera, style), (k * WHOLE[0] + GAP // 2, GAP // 2))
        note = f"{text}: {len((model, cage)[k].counts):,} faces"
        pen.text((k * WHOLE[0] + WHOLE[0] // 2, WHOLE[1] + LABEL // 2), note, fill=INK, anchor="mm", font_size=24)
    for k, (text, ball, view, plane) in enumerate(CLOSE_UPS):
        x, y = k % COLUMNS * CLOSE[0], WHOLE[1] + LABEL + k // COLUMNS * (CLOSE[1] + LABEL)
        image.paste(close_up(surface, ball, view, plane), (x + GAP // 2, y + GAP // 2))
        pen.text((x + CLOSE[0] // 2, y + CLOSE[1] + LABEL // 2), text, fill=INK, anchor="mm", font_size=22)
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("author")
    one.add_argument("-o", "--output", type=Path, default=HERE / "sewn" / "coat.usda")
    two = commands.add_parser("draw")
    two.add_argument("cage", help="built with --set render.level=0")
    two.add_argument("surface", help="built with --set render.level=3")
    two.add_argument("-o", "--output", type=Path, default=HERE / "sewn.png")
    args = parser.parse_args()
    if args.command == "author":
        author(HERE / "coat.usda", args.output)
    else:
        compose(Usd.Stage.Open(args.cage), Usd.Stage.Open(args.surface)).save(args.output, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
