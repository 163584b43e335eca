"""Bounds of the simulation mesh: a bad UV costs little, and a garment's place, scale and axes change nothing."""

import numpy as np
import pytest
from conftest import EXAMPLES
from mesh import find_model
from pxr import Gf, Usd, UsdGeom, Vt

SOURCE = EXAMPLES / "tshirt.usda"
# Share of the triangles by which rounding may change a mesh.
ROUNDING = 0.02


def changed(folder, change, name="changed"):
    """A copy of the garment after `change` has been called with its mesh."""
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().TransferContent(Usd.Stage.Open(str(SOURCE)).Flatten())
    change(UsdGeom.Mesh(find_model(stage)))
    path = folder / f"{name}.usdc"
    stage.Export(str(path))
    return path


def of_points(function):
    """A change of the points by a function of an array, in double precision."""

    def change(mesh):
        points = function(np.array(mesh.GetPointsAttr().Get(), float)).astype(np.float32)
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points))
        mesh.GetExtentAttr().Set(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))

    return change


def bad_uv(index, value):
    def change(mesh):
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        values = list(primvar.Get())
        values[index] = Gf.Vec2f(*value)
        primvar.GetAttr().Set(Vt.Vec2fArray(values))

    return change


@pytest.fixture(scope="module")
def own(built):
    return built(SOURCE)


def folded(product):
    return [warning for warning in product.report["warnings"] if warning["code"] == "flipped-uvs"]


@pytest.mark.parametrize("value", [(0, 0), (12, 0.3), (-64, 64)])
@pytest.mark.parametrize("index", [40, 333])
def test_a_bad_uv_costs_a_few_triangles_and_is_told(build, own, tmp_path, index, value):
    product = build(changed(tmp_path, bad_uv(index, value)), "--physics", "none")
    count = len(own.sim.counts)
    assert abs(len(product.sim.counts) - count) <= ROUNDING * count
    corners = np.array(UsdGeom.PrimvarsAPI(product.source.prim).GetPrimvar("st").GetIndices())
    at = np.repeat(np.arange(len(product.source.counts)), product.source.counts)[corners == index]
    (warning,) = folded(product)
    assert "primvars:st" in warning["place"] and warning["remedy"]
    assert set(at) & set(warning["elements"]["faces"]), "it names a face of the bad UV"
    assert not folded(own)


@pytest.mark.parametrize("offset", [(1e6, 0, 0), (-1e6, 1e6, 1e6), (1e7, 0, 0)])
def test_a_garment_far_away_has_the_same_mesh(build, tmp_path, offset):
    # Points that are exact there, so that all garments have the same shape.
    spacing = np.spacing(np.float32(np.abs(offset).max()))
    near = changed(tmp_path, of_points(lambda p: np.round(p / spacing) * spacing), "near")
    far = changed(tmp_path, of_points(lambda p: np.round(p / spacing) * spacing + offset), "far")
    near, far = build(near, stem="near_built"), build(far, stem="far_built")
    count = len(near.sim.counts)
    assert abs(len(far.sim.counts) - count) <= ROUNDING * count
    assert np.abs(np.ptp(far.sim.points, axis=0) - np.ptp(near.sim.points, axis=0)).max() <= 2 * spacing
    assert (near.render.indices == far.render.indices).all()
    assert np.abs(far.render.points - offset - near.render.points).max() <= spacing
    assert any(warning["code"] == "far-from-origin" for warning in far.report["warnings"])


@pytest.mark.parametrize("scale", [1e-4, 1e5])
def test_a_garment_of_any_scale_has_the_same_mesh(build, built, tmp_path, scale):
    # The garment's own lengths are those of its own scale.
    automatic = ("--set", "sim.minEdgeLength=0", "--set", "sim.maxEdgeLength=0")
    own = built(SOURCE, *automatic)
    product = build(changed(tmp_path, of_points(lambda p: p * scale)), *automatic)
    count = len(own.sim.counts)
    assert abs(len(product.sim.counts) - count) <= ROUNDING * count
    assert (product.render.indices == own.render.indices).all()
    assert product.render.points / scale == pytest.approx(own.render.points, abs=1e-4 * np.ptp(own.render.points))


def left_handed(mesh):
    mesh.GetOrientationAttr().Set("leftHanded")


def z_up(mesh):
    UsdGeom.SetStageUpAxis(mesh.GetPrim().GetStage(), UsdGeom.Tokens.z)


@pytest.mark.parametrize("change", [left_handed, z_up])
def test_handedness_and_up_axis_change_no_mesh(build, own, tmp_path, change):
    product = build(changed(tmp_path, change))
    assert (product.sim.indices == own.sim.indices).all() and (product.sim.points == own.sim.points).all()


@pytest.mark.parametrize("function", [lambda p: p * [-1, 1, 1], lambda p: p[:, [0, 2, 1]] * [1, -1, 1]])
def test_a_mirrored_or_turned_garment_has_a_mesh_as_good(build, own, tmp_path, function):
    product = build(changed(tmp_path, of_points(function)))
    count = len(own.sim.counts)
    assert abs(len(product.sim.counts) - count) <= ROUNDING * count
