"""Whole garments on other bodies, by `usdtailor fit`: a suit of layers on bodies made here, or those of a folder on its bodies."""

import json
import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES, GARMENTS, GIVEN, MADE
from fitting import Triangles, crossings, fit, write_tube
from pxr import Usd, UsdGeom

BODIES = os.environ.get("TAILOR_BODIES")
# Garments that are not at their body as they are, and where they belong.
MOVED = {"male_worksuit01": (0, -7.8, 0)}
# Faces that cross anew on a body, which the command tells. A garment that is not here has none; a number may only be lowered.
CROSSING = {("male_worksuit01", "man_strong_heavy"): 1}
# The suit, and the garments of a folder that has bodies for them.
FITTED = [MADE / "layered_suit.usdc"] if not GIVEN else GARMENTS if BODIES else []


def made_bodies(folder):
    """The body below the suit, and a heavier and a smaller one with the same faces."""
    sys.path[:0] = [str(MADE), str(EXAMPLES)]
    import suit

    whole = suit.Garment("Body", suit.Body())
    for part in (suit.shirt(), suit.overall()):
        suit.append(whole, part)
    kept = [face for face, panel in zip(whole.faces, whole.panels, strict=True) if panel not in ("collar", "bib", "back_bib")]
    used, corners = np.unique(np.concatenate(kept), return_inverse=True)
    form = suit.Body(-2 * suit.GAP)
    points = form.project(np.array(whole.points)[used])
    height = points[:, 1:2]
    belly = np.exp(-(((height - 104) / 16) ** 2))
    shapes = {"base": points, "heavy": points + form.normal(points) * (1 + 3 * belly), "small": points * (0.72, 0.68, 0.72)}
    counts = np.array([len(face) for face in kept])
    return [write_tube(folder / f"{name}.usda", (shape, counts, corners.ravel()), prim="/Body/mesh") for name, shape in shapes.items()]


@pytest.fixture
def bodies(tmp_path):
    """The body that the garments are made for, and others."""
    if BODIES:
        return [Path(BODIES) / f"{name}.usdc" for name in ("base", "child", "man_strong_heavy", "woman_old")]
    return made_bodies(tmp_path)


def at_its_body(path, folder):
    """A garment at its body, and how far it was moved there."""
    move = MOVED.get(path.stem, (0, 0, 0))
    if not any(move):
        return path, move
    stage = Usd.Stage.CreateNew(str(folder / f"{path.stem}.usda"))
    stage.GetRootLayer().subLayerPaths = [str(path)]
    UsdGeom.Xformable(stage.OverridePrim(f"/{path.stem}")).AddTranslateOp(opSuffix="fit").Set(move)
    stage.Save()
    return folder / f"{path.stem}.usda", move


def local_lengths(garment, start, end, reach=200):
    """The lengths of edges as the body changes around them: by the affine map of its nearest points."""
    middles = garment.points[garment.edges].mean(axis=1)
    along = garment.points[garment.edges[:, 0]] - garment.points[garment.edges[:, 1]]
    wanted = np.empty(len(along))
    for i, middle in enumerate(middles):
        near = np.argsort(((start - middle) ** 2).sum(axis=1))[:reach]
        a, b = start[near] - start[near].mean(axis=0), end[near] - end[near].mean(axis=0)
        scale = math.sqrt((b**2).sum() / (a**2).sum())
        u, _, v = np.linalg.svd(b.T @ a)
        share = 0.05 * (a**2).sum()
        turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
        wanted[i] = np.linalg.norm((b.T @ a + share * scale * turn) @ np.linalg.inv(a.T @ a + share * np.eye(3)) @ along[i])
    return wanted


@pytest.mark.parametrize("file", [pytest.param(path, id=path.stem) for path in FITTED])
def test_nothing_new_crosses_and_lengths_follow_the_body(usdtailor, tmp_path, bodies, file):
    base, *others = bodies
    source, move = at_its_body(file, tmp_path)
    out, report = tmp_path / "fitted", tmp_path / "report.json"
    fit(usdtailor, source, "--from", base, "--to", *others, "-o", out, "--report", report)

    def on_body(path):
        garment = Triangles(path)
        garment.points = garment.points + move
        return garment

    start, start_body = on_body(source), Triangles(base)
    before = crossings(start, start_body)
    for body, told in zip(others, json.loads(report.read_text())["fits"], strict=True):
        end, end_body = on_body(out / f"{source.stem}_{body.stem}.usdc"), Triangles(body)
        after = crossings(end, end_body)
        new, known = [now - was for was, now in zip(before, after, strict=True)], CROSSING.get((file.stem, body.stem), 0)
        assert sum(map(len, new)) <= known, (body, new)
        (figures,) = told["garments"]
        for count, was, now in zip((figures["bodyCrossings"], figures["ownCrossings"]), before, after, strict=True):
            assert abs(count["before"] - len(was)) <= 2 and abs(count["after"] - len(now)) <= 2 and count["new"] <= known
        ratio = end.lengths() / local_lengths(start, start_body.points, end_body.points)
        assert (abs(ratio - 1) < 0.15).mean() > 0.8, (body, (abs(ratio - 1) < 0.15).mean())
        assert figures["edgesKept"] > 0.94
        assert [prim.GetName() for prim in end.mesh.GetPrim().GetChildren()] == [prim.GetName() for prim in start.mesh.GetPrim().GetChildren()]
