#!/usr/bin/env python3
"""Adds seams and folds to examples/coat.usda in a layer over it.

    sew.py author [-o examples/sewn/coat.usda]

A seam is an applied `TailorSeamAPI:<name>` with the edge sets that it follows. A fold is a
`TailorFoldAPI:<name>` with face sets at a border. The schemas need not be registered, as attributes are
authored by name."""
import argparse
import os
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

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


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("command", choices=["author"])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "sewn" / "coat.usda")
    author(HERE / "coat.usda", parser.parse_args().output)


if __name__ == "__main__":
    main()
