"""`--mark`: what warnings name as sets of the render mesh."""

import json

import numpy
import pytest
from conftest import run
from pxr import Usd, UsdGeom
from sources import sheet, write

FLAT = 9    # a face without area


@pytest.fixture
def flawed(tmp_path):
    """A sheet with one face that has no area."""
    path = write(tmp_path / "flawed.usda", shape=lambda: sheet(8, 6))
    stage = Usd.Stage.Open(str(path))
    model = UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
    corners = model.GetFaceVertexIndicesAttr().Get()[4 * FLAT:4 * FLAT + 4]
    points = model.GetPointsAttr().Get()
    for corner in corners[1:]:
        points[corner] = points[corners[0]]
    model.GetPointsAttr().Set(points)
    stage.Save()
    return path


def render(path):
    """The points of the render mesh, and its sets by name: the type and the indices of their elements."""
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(stage.GetDefaultPrim().GetPath().AppendChild("render")))
    sets = {set.GetPrim().GetName(): set for set in UsdGeom.Subset.GetAllGeomSubsets(mesh)}
    elements = {name: (set.GetElementTypeAttr().Get(), list(set.GetIndicesAttr().Get())) for name, set in sets.items()}
    return numpy.array(mesh.GetPointsAttr().Get()), elements


def test_the_elements_of_a_warning_become_a_set_of_the_render_mesh(usdtailor, flawed, tmp_path):
    plain, out = tmp_path / "plain.usda", tmp_path / "out.usda"
    assert run(usdtailor, "build", flawed, "-o", plain).returncode == 0
    done = run(usdtailor, "build", flawed, "-o", out, "--mark")
    assert done.returncode == 0 and "warning[degenerate-faces]" in done.stderr
    points, sets = render(out)
    kind, faces = sets["mark_degenerate_faces"]
    # Faces of two refinements follow those of the input, sixteen to each.
    assert kind == "face" and FLAT in {face // 16 for face in faces}
    unmarked, others = render(plain)
    assert set(sets) - set(others) == {name for name in sets if name.startswith("mark_")}
    assert numpy.array_equal(points, unmarked)


def test_a_garment_without_warnings_gets_no_sets(usdtailor, tmp_path):
    good, out = write(tmp_path / "good.usda", shape=lambda: sheet(8, 6)), tmp_path / "out.usda"
    assert run(usdtailor, "build", good, "-o", out, "--mark", "--set", "cloth.physics=").returncode == 0
    assert not [name for name in render(out)[1] if name.startswith("mark_")]


def test_a_set_of_the_name_of_a_mark_is_kept(usdtailor, flawed, tmp_path):
    stage = Usd.Stage.Open(str(flawed))
    model = UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
    UsdGeom.Subset.CreateGeomSubset(model, "mark_degenerate_faces", "face", [0])
    stage.Save()
    out = tmp_path / "out.usda"
    assert run(usdtailor, "build", flawed, "-o", out, "--mark").returncode == 0
    _, sets = render(out)
    assert sets["mark_degenerate_faces"] == ("face", list(range(16)))
    assert FLAT in {face // 16 for face in sets["mark_degenerate_faces_2"][1]}


def test_warnings_of_sets_name_their_faces_or_edges(usdtailor, tmp_path):
    """Narrow face sets, and three lines of edges that a coarse simulation mesh cannot keep apart."""
    path, out, report = (tmp_path / name for name in ("narrow.usda", "out.usda", "out.json"))
    write(path, shape=lambda: sheet(24, 24))
    stage = Usd.Stage.Open(str(path))
    model = UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
    stripe = [24 * row + 11 for row in range(24)]
    UsdGeom.Subset.CreateGeomSubset(model, "stripe", "face", stripe)
    lines = [[25 * row + column, 25 * (row + 1) + column] for column in (3, 4, 5) for row in range(4, 20)]
    UsdGeom.Subset.CreateGeomSubset(model, "lines", "edge", [end for edge in lines for end in edge])
    stage.Save()
    width = float(numpy.ptp(numpy.array(model.GetPointsAttr().Get())[:, 0]))
    done = run(usdtailor, "build", path, "-o", out, "--mark", "--report", report, "--set", f"sim.maxEdgeLength={width / 8}")
    assert done.returncode == 0, done.stderr
    told = {warning["code"]: warning for warning in json.loads(report.read_text())["warnings"]}
    assert told["sets-blurred"]["elements"] == {"faces": stripe}
    merged = told["not-carried"]
    assert "subset lines" in merged["place"] and "meet others of the set" in merged["problem"]
    of_lines = {frozenset(edge) for edge in lines}
    assert {frozenset(edge) for edge in merged["elements"]["edges"]} <= of_lines
    sets = render(out)[1]
    assert sets["mark_sets_blurred"] == sets["stripe"]
    assert sets["mark_not_carried"][0] == "edge" and len(sets["mark_not_carried"][1]) > 0
