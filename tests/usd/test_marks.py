"""`--mark`: what warnings name as sets of the render mesh."""

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
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(stage.GetDefaultPrim().GetPath().AppendChild("render")))
    return mesh, {set.GetPrim().GetName(): set for set in UsdGeom.Subset.GetAllGeomSubsets(mesh)}


def test_the_elements_of_a_warning_become_a_set_of_the_render_mesh(usdtailor, flawed, tmp_path):
    plain, out = tmp_path / "plain.usda", tmp_path / "out.usda"
    assert run(usdtailor, "build", flawed, "-o", plain).returncode == 0
    done = run(usdtailor, "build", flawed, "-o", out, "--mark")
    assert done.returncode == 0 and "warning[degenerate-faces]" in done.stderr
    mesh, sets = render(out)
    mark = sets["mark_degenerate_faces"]
    assert mark.GetElementTypeAttr().Get() == "face"
    # Faces of a refinement follow those of the input, four to each.
    assert FLAT in {face // 4 for face in mark.GetIndicesAttr().Get()}
    unmarked, others = render(plain)
    assert set(sets) - set(others) == {name for name in sets if name.startswith("mark_")}
    assert numpy.array_equal(mesh.GetPointsAttr().Get(), unmarked.GetPointsAttr().Get())


def test_a_garment_without_warnings_gets_no_sets(usdtailor, tmp_path):
    good, out = write(tmp_path / "good.usda", shape=lambda: sheet(8, 6)), tmp_path / "out.usda"
    assert run(usdtailor, "build", good, "-o", out, "--mark").returncode == 0
    assert not [name for name in render(out)[1] if name.startswith("mark_")]


def test_a_set_of_the_name_of_a_mark_is_kept(usdtailor, flawed, tmp_path):
    stage = Usd.Stage.Open(str(flawed))
    model = UsdGeom.Mesh(next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)))
    UsdGeom.Subset.CreateGeomSubset(model, "mark_degenerate_faces", "face", [0])
    stage.Save()
    out = tmp_path / "out.usda"
    assert run(usdtailor, "build", flawed, "-o", out, "--mark").returncode == 0
    _, sets = render(out)
    assert list(sets["mark_degenerate_faces"].GetIndicesAttr().Get()) == [0, 1, 2, 3]
    assert FLAT in {face // 4 for face in sets["mark_degenerate_faces_2"].GetIndicesAttr().Get()}
