"""Cloth that is modelled with a thickness is told: a closed shell becomes two sheets."""

import json

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from runs import good


def tube(radius, count, rows, height, inwards=False):
    angles = 2 * np.pi * np.arange(count) / count
    points = [(radius * np.cos(a), height * j / rows, -radius * np.sin(a)) for j in range(rows + 1) for a in angles]
    faces = [[count * j + i, count * j + (i + 1) % count, count * (j + 1) + (i + 1) % count, count * (j + 1) + i] for j in range(rows) for i in range(count)]
    return points, [face[::-1] for face in faces] if inwards else faces


def shell(thickness, closed=True, count=16, rows=8):
    """A tube of cloth with an outer and an inner wall, joined along its rims."""
    points, faces = tube(2, count, rows, 8)
    inner, others = tube(2 - thickness, count, rows, 8, inwards=True)
    start = len(points)
    faces += [[start + v for v in face] for face in others]
    if closed:
        for first, turn in ((0, 1), (count * rows, -1)):
            rim = [[first + (i + 1) % count, first + i, start + first + i, start + first + (i + 1) % count] for i in range(count)]
            faces += [face[::turn] for face in rim]
    return points + inner, faces


def ball(count=12):
    """A closed piece that is no shell."""
    points, faces = tube(2, count, 1, 3)
    bottom, top = list(range(count))[::-1], list(range(count, 2 * count))
    return points, faces + [bottom, top]


def write(path, points, faces):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Y"), UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/G").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/G/coat")
    mesh.CreatePointsAttr([tuple(map(float, p)) for p in points]), mesh.CreateFaceVertexCountsAttr([len(f) for f in faces])
    mesh.CreateFaceVertexIndicesAttr([int(v) for f in faces for v in f])
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("thickness", [0.02, 0.1])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_closed_shell_is_told_with_its_thickness(usdtailor, tmp_path, thickness, reverse):
    points, faces = shell(thickness)
    source = write(tmp_path / "in.usda", points, [face[::-1] for face in faces] if reverse else faces)
    done = good(usdtailor, "check", source, "-v")
    [line] = [line for line in done.stderr.splitlines() if "thick-cloth" in line]
    told = float(line.split("at most ")[1].split(" ")[0])
    assert abs(told - thickness) < 0.1 * thickness and "without thickness" in done.stderr


@pytest.mark.parametrize("left_out", [0, 1])
def test_the_faces_of_the_shell_are_named_and_others_are_not(usdtailor, tmp_path, left_out):
    """By their numbers in the file, also after a face that is left out."""
    points, faces = shell(0.05)
    first = len(points)
    sheet = [(x, 9 + y, 5) for y in range(4) for x in range(4)]
    own = [[4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4] for y in range(3) for x in range(3)]
    own = [[first + v for v in face] for face in own]
    source = write(tmp_path / "in.usda", points + sheet, [[first, first + 1, first]] * left_out + faces + own)
    good(usdtailor, "build", source, "-o", tmp_path / "out.usdc", "--report", tmp_path / "report.json")
    warnings = json.loads((tmp_path / "report.json").read_text())["warnings"]
    [warning] = [warning for warning in warnings if warning["code"] == "thick-cloth"]
    assert sorted(warning["elements"]["faces"]) == list(range(left_out, left_out + len(faces)))


@pytest.mark.parametrize("made", [shell(0.05, closed=False), ball(), tube(2, 16, 8, 8)], ids=["two sheets", "a drum", "a tube"])
def test_what_is_open_or_no_sheet_is_not(usdtailor, tmp_path, made):
    done = good(usdtailor, "check", write(tmp_path / "in.usda", *made))
    assert "thick-cloth" not in done.stderr, done.stderr
