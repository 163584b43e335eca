"""Faces that name a point more than once: the products have none, and all else follows."""

import json

import numpy as np
import pytest
from conftest import run
from mesh import find_model
from pxr import Usd, UsdGeom
from sources import MODEL, sheet, write

WIDTH, HEIGHT = 6, 4
TRIANGLES, LINE, BENT = (1, 8), 10, 14
GONE = {LINE, BENT + WIDTH + 1}


def corners():
    """The sheet as an exporter may write it, each face as a list of points."""
    _, _, indices = sheet(WIDTH, HEIGHT)
    faces = indices.reshape(-1, 4).tolist()
    for face in TRIANGLES:
        faces[face][1] = faces[face][0]
    faces[LINE] = [faces[LINE][0], faces[LINE][1], faces[LINE][0]]
    # Around two faces that meet in a point, and back.
    a, b = faces[BENT], faces[BENT + WIDTH + 1]
    assert a[2] == b[0]
    faces[BENT] = [*a[:3], *b[1:], a[2], a[3]]
    faces[BENT + WIDTH + 1] = b[:1] * 4
    return faces


@pytest.fixture
def repeated(tmp_path):
    faces = corners()
    points = sheet(WIDTH, HEIGHT)[0]
    count = sum(map(len, faces))
    return write(
        tmp_path / "repeated.usda",
        shape=lambda: (points, np.array([len(face) for face in faces]), np.concatenate(faces)),
        holes=[2, LINE, 5],
        primvars=[
            {"name": "face", "type_name": "int", "interpolation": "uniform", "values": list(range(len(faces)))},
            {"name": "corner", "type_name": "int", "interpolation": "faceVarying", "values": list(range(count))},
            {"name": "indexed", "type_name": "float", "interpolation": "faceVarying", "values": [0.0, 1.0], "indices": [i % 2 for i in range(count)]},
        ],
        subsets=[
            {"name": "upper", "indices": list(range(12)), "family": "halves"},
            {"name": "lower", "indices": list(range(12, len(faces))), "family": "halves"},
        ],
        families={"halves": "partition"},
    )


def faces_of(mesh):
    counts, indices = np.array(mesh.GetFaceVertexCountsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get())
    return np.split(indices, np.cumsum(counts)[:-1])


@pytest.mark.parametrize("level", [0, 2])
def test_products_name_each_point_once_and_their_attributes_fit(build, repeated, level):
    product = build(repeated, "--set", f"render.level={level}")
    for name in ("sim", "render"):
        mesh = UsdGeom.Mesh(product.prim(name))
        faces = faces_of(mesh)
        assert all(len(face) > 2 and len(set(face)) == len(face) for face in faces), name
        good, why = UsdGeom.Mesh.ValidateTopology(mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(mesh.GetPointsAttr().Get()))
        assert good, why
        sizes = {"uniform": len(faces), "faceVarying": sum(map(len, faces)), "vertex": len(mesh.GetPointsAttr().Get())}
        sizes["varying"] = sizes["vertex"]
        for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithValues():
            if primvar.GetInterpolation() in sizes:
                assert len(primvar.ComputeFlattened()) == sizes[primvar.GetInterpolation()], primvar.GetName()
        assert UsdGeom.Subset.ValidateFamily(mesh, "face", "halves")[0]
        assert all(hole < len(faces) for hole in mesh.GetHoleIndicesAttr().Get() or [])


def test_faces_keep_their_corners_values_and_sets(build, repeated):
    product = build(repeated, "--set", "render.level=0")
    before, mesh = corners(), UsdGeom.Mesh(product.prim("render"))
    flat = np.concatenate(before)
    primvar = lambda name: np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name).ComputeFlattened())
    assert np.array_equal(flat[primvar("corner")], np.concatenate(faces_of(mesh))), "each corner is one of the file"
    assert np.array_equal(primvar("indexed"), primvar("corner") % 2)
    own = primvar("face")
    assert set(own) == set(range(len(before))) - GONE
    assert [len(face) for face, number in zip(faces_of(mesh), own) if number == BENT] == [4, 4]
    upper = set(UsdGeom.Subset.GetGeomSubsets(mesh)[0].GetIndicesAttr().Get())
    assert {number for face, number in enumerate(own) if face in upper} == set(range(12)) - GONE
    assert {own[hole] for hole in mesh.GetHoleIndicesAttr().Get()} == {2, 5}


def test_one_warning_names_the_faces_of_the_file(build, repeated):
    found = [w for w in build(repeated).report["warnings"] if w["code"] == "repeated-points"]
    assert len(found) == 1
    assert sorted(found[0]["elements"]["faces"]) == sorted({*TRIANGLES, BENT, *GONE})
    for what in (f"face {BENT}", f"faces {', '.join(map(str, sorted(GONE)))}"):
        assert what in found[0]["message"], found[0]


def test_numbers_of_faces_are_those_of_the_file(usdtailor, repeated, tmp_path):
    # A face without area behind the ones that are left out.
    flat = len(corners()) - 1
    stage = Usd.Stage.Open(str(repeated))
    mesh = UsdGeom.Mesh(find_model(stage))
    points = list(mesh.GetPointsAttr().Get())
    for corner in corners()[flat]:
        points[corner] = points[corners()[flat][0]]
    mesh.GetPointsAttr().Set(points)
    stage.Save()
    out, report = tmp_path / "out.usda", tmp_path / "report.json"
    done = run(usdtailor, "build", repeated, "-o", out, "--mark", "--report", report, "--set", "render.level=0")
    assert done.returncode == 0, done.stderr
    warning = next(w for w in json.loads(report.read_text())["warnings"] if w["code"] == "degenerate-faces")
    assert warning["elements"]["faces"] == [flat] and f"(face {flat})" in done.stderr
    built = Usd.Stage.Open(str(out))
    render = UsdGeom.Mesh(built.GetPrimAtPath("/Coat/render"))
    own = UsdGeom.PrimvarsAPI(render).GetPrimvar("face").ComputeFlattened()
    marks = {s.GetPrim().GetName(): {own[face] for face in s.GetIndicesAttr().Get()} for s in UsdGeom.Subset.GetAllGeomSubsets(render)}
    assert marks["mark_degenerate_faces"] == {flat}
    assert marks["mark_repeated_points"] == {*TRIANGLES, BENT}, "those that are there"


def test_baked_sets_have_the_numbers_of_the_file(usdtailor, repeated, tmp_path):
    out = tmp_path / "sets.usda"
    done = run(usdtailor, "sets", repeated, "--bake", "low=value(face, 23) + lower - value(face, 12)", "--bake", "all=faces", "-o", out, "--json")
    assert done.returncode == 0, done.stderr
    listed = {entry["name"]: entry["indices"] for entry in json.loads(done.stdout)["sets"]}
    stage = Usd.Stage.Open(str(out))
    for name, expected in {"low": set(range(13, 24)) - GONE, "all": set(range(24)) - GONE}.items():
        indices = list(UsdGeom.Subset.Get(stage, f"{MODEL}/{name}").GetIndicesAttr().Get())
        assert set(indices) == expected and len(indices) == len(expected), name
        assert set(listed[name]) == expected


def test_a_face_around_a_hole_is_refused(usdtailor, tmp_path):
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [1, 1, 0], [1, 3, 0], [3, 3, 0]], dtype=float)
    face = np.array([0, 1, 2, 3, 0, 4, 5, 6, 4])
    path = write(tmp_path / "a.usda", shape=lambda: (points, np.array([len(face)]), face), uv=False)
    done = run(usdtailor, "build", path, "-o", tmp_path / "out.usda")
    assert done.returncode == 1 and "error[face-corners]" in done.stderr and "face 0 has point 0 twice" in done.stderr
