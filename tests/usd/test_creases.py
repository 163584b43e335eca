"""Creases that the author drew are lines of edges on the simulation mesh."""

import numpy as np
import pytest
from pxr import UsdGeom
from sources import write
from surface import distance_to_segments

PLEATS, ROWS = 48, 12


def pleated(depth=1.5):
    """A skirt of pleats, each point of a ring in turn further out and in: columns of points run along the folds."""
    turn, row = 2 * np.pi * np.arange(PLEATS) / PLEATS, np.arange(ROWS + 1)[:, None]
    radius = 20 + np.where(np.arange(PLEATS) % 2, -depth, depth) + 6 * row / ROWS
    points = np.stack([radius * np.cos(turn), np.broadcast_to(60 - 60 * row / ROWS, radius.shape), radius * np.sin(turn)], axis=-1)
    corner = np.arange(PLEATS)
    quad = np.stack([corner, (corner + 1) % PLEATS, (corner + 1) % PLEATS + PLEATS, corner + PLEATS], axis=1)
    faces = np.concatenate([quad + PLEATS * i for i in range(ROWS)])
    return points.reshape(-1, 3), np.full(len(faces), 4), faces.ravel()


def skirt(tmp_path, sharpness, depth=1.5):
    folds = {tuple(range(column, PLEATS * (ROWS + 1), PLEATS)): sharpness for column in range(PLEATS)}
    on_fold = {"name": "fold", "type_name": "float", "interpolation": "varying", "values": [float(i % PLEATS == 0) for i in range(PLEATS * (ROWS + 1))]}
    creases = folds if sharpness else None
    return write(tmp_path / "skirt.usda", shape=lambda: pleated(depth), creases=creases, uv=False, primvars=[on_fold])


def fold_gap(product):
    """The largest distance of the first fold from the edges of the simulation mesh. [target lengths]"""
    render = product.prim("render")
    share = np.array(UsdGeom.PrimvarsAPI(render).GetPrimvar("fold").ComputeFlattened())
    fold = np.array(UsdGeom.Mesh(render).GetPointsAttr().Get(), float)[share > 1 - 1e-5]
    sim = UsdGeom.Mesh(product.prim("sim"))
    points, triangles = np.array(sim.GetPointsAttr().Get(), float), np.array(sim.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return distance_to_segments(fold, points[edges]).max() / product.report["recipe"]["sim"]["maxEdgeLength"]


@pytest.mark.parametrize("depth", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("sharpness", [1.0, 1.6, 3.0])
def test_pleats_with_soft_creases_are_lines_of_edges(build, tmp_path, sharpness, depth):
    product = build(skirt(tmp_path, sharpness, depth), "--set", "render.level=3")
    assert fold_gap(product) < 0.1
    assert product.report["sim"]["distanceMax"] < 0.1
    assert product.report["sim"]["bluntRidges"] == []


def test_ridges_that_are_cut_off_are_told(build, tmp_path):
    source = skirt(tmp_path, 0.0)
    product = build(source)
    ridges = product.report["sim"]["bluntRidges"]
    assert len(ridges) == PLEATS / 2 and all(ridge["edges"] > 3 and ridge["length"] > 2 for ridge in ridges)
    lines = build(source, "--set", "sim.featureAngle=60", stem="lines").report["sim"]["bluntRidges"]
    assert not {ridge["vertex"] % PLEATS for ridge in lines} & {ridge["vertex"] % PLEATS for ridge in ridges}
    assert build(source, "--set", "sim.featureAngle=180", stem="none").report["sim"]["bluntRidges"] == []


def test_no_crease_is_a_line_where_none_is_wanted(build, tmp_path):
    product = build(skirt(tmp_path, 1.6), "--set", "render.level=3", "--set", "sim.featureAngle=180")
    assert fold_gap(product) > 0.1
