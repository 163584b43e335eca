"""Trims that cannot be bound: each is told, and the garment is built."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from runs import good, refused
from sources import define_mesh, vec3f
from trimmed import ARGS, driven, write_front


@pytest.fixture(scope="module")
def stage_file(tmp_path_factory):
    return write_front(tmp_path_factory.mktemp("trims") / "front.usda")


def test_bad_trims_are_told(usdtailor, stage_file, tmp_path):
    out = tmp_path / "out.usdc"
    base = ("build", stage_file, "-o", out, "--prim", "/G/front", "--set", "render.level=0")
    for value, says in [
        ("trim.x.prims=/G/button", ["wrong-prim", "trim.x.prims", "/G/button is not a prim"]),
        ("trim.x.prims=/G/front", ["wrong-prim", "the garment itself"]),
        ("trim.x.prims=a b", ["wrong-prim", "a b"]),
        ("trim.x.mode=soft", ["names no prim"]),
    ]:
        refused(usdtailor, *base, "--set", value, says=says)
        assert not out.exists()
    path = tmp_path / "far.usda"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    stage.OverridePrim("/G/trims").GetAttribute("xformOp:translate").Set((3, -4, 300))
    UsdGeom.Cube.Define(stage, "/G/trims/block")
    stage.GetRootLayer().Save()
    done = good(usdtailor, "build", path, "-o", out, *ARGS)
    assert "trim-off-cloth" in done.stderr and "/G/trims/buttons" in done.stderr
    assert "not-carried" in done.stderr and "/G/trims/block" in done.stderr and "Cube" in done.stderr


def curves_that_lie(stage):
    curves = UsdGeom.BasisCurves.Define(stage, "/G/t")
    curves.CreatePointsAttr([(0, 0, 0), (1, 0, 0)])
    curves.CreateCurveVertexCountsAttr([-1, 5, 2147483647])


def beyond(stage):
    define_mesh(stage, "/G/t", np.eye(3), [[0, 1, 99]])


def negative(stage):
    define_mesh(stage, "/G/t", np.eye(3), [[0, 1, -2]])


def not_a_number(stage):
    define_mesh(stage, "/G/t", np.array([[np.nan, 0, 0], [1, 0, 0], [0, 1, 0]]), [[0, 1, 2]])


def flattened(stage):
    define_mesh(stage, "/G/t", np.eye(3), [[0, 1, 2]]).AddScaleOp().Set((0, 0, 0))


def at_times(stage):
    points = define_mesh(stage, "/G/t", np.eye(3), [[0, 1, 2]]).GetPointsAttr()
    points.Clear()
    for time in (1, 2):
        points.Set(vec3f(time * np.eye(3)), time)


def instance(stage):
    define_mesh(stage, "/P/t", np.eye(3), [[0, 1, 2]])
    prim = stage.DefinePrim("/G/t")
    prim.GetReferences().AddInternalReference("/P")
    prim.SetInstanceable(True)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (curves_that_lie, None),
        (beyond, "beyond its 3"),
        (negative, "beyond its 3"),
        (not_a_number, "not finite"),
        (flattened, "flattens it"),
        (at_times, "at times alone"),
        (instance, "it is an instance"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_a_trim_that_cannot_be_bound_is_told_and_the_garment_is_built(usdtailor, stage_file, tmp_path, spoil, says):
    path, out = tmp_path / "bad.usda", tmp_path / "out.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    spoil(stage)
    stage.GetRootLayer().Save()
    done = good(usdtailor, "build", path, "-o", out, "--prim", "/G/front", "--set", "render.level=0", "--set", "trim.x.prims=t")
    assert says is None or ("not-carried" in done.stderr and "/G/t" in done.stderr and says in done.stderr)
    driven(usdtailor, out, tmp_path / "shot.usdc")


