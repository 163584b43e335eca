"""Values as other programs and people write them: those without a use are told, and refuse nothing that does not need them."""

import pytest
from conftest import run
from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt
from runs import warnings
from sources import add_primvar, faulty, sheet, write


def empty(mesh):
    add_primvar(mesh, name="wet", type_name="float", interpolation="vertex", values=[])


def broken_normals(mesh):
    add_primvar(mesh, name="normals", type_name="normal3f", interpolation="faceVarying", values=[Gf.Vec3f(0, 0, 1)] * 3)


def one_sample(mesh):
    attribute = mesh.GetPointsAttr()
    points = attribute.Get()
    attribute.Clear()
    attribute.Set(points, 7)


def too_few(mesh):
    add_primvar(mesh, name="wet", type_name="float", interpolation="vertex", values=[0.5] * 3)


@pytest.mark.parametrize("change, told", [
    (empty, "primvars:wet"), (too_few, "primvars:wet"), (broken_normals, "primvars:normals"), (one_sample, None),
])  # fmt: skip
def test_a_part_that_does_not_matter_refuses_nothing(build, tmp_path, change, told):
    product = build(faulty(change)(tmp_path / "a.usda"), "--set", "render.level=0")
    assert told is None or any(told in message for _, message in warnings(product))
    assert len(product.mesh("render").points) == 20


def test_a_primvar_with_a_fault_is_told_by_the_option_that_names_it(usdtailor, tmp_path):
    path = faulty(too_few)(tmp_path / "a.usda")
    done = run(usdtailor, "build", path, "-o", tmp_path / "out.usda", "--set", "sim.density=wet")
    assert done.returncode == 1 and "error[value-count]: sim.density" in done.stderr and "holds 3 values" in done.stderr, done.stderr


def test_uvs_with_a_fault_are_refused(usdtailor, tmp_path):
    def change(mesh):
        UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").SetIndices([99] * 48)

    done = run(usdtailor, "check", faulty(change)(tmp_path / "a.usda"))
    assert done.returncode == 1 and "error[index-out-of-range]" in done.stderr, done.stderr


def wrong_sets(mesh):
    api = UsdGeom.PrimvarsAPI(mesh)
    st = api.GetPrimvar("st").ComputeFlattened()
    api.RemovePrimvar("st")
    wrong = api.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord3fArray, "faceVarying")
    wrong.Set([Gf.Vec3f(u, v, 0) for u, v in st])
    api.CreatePrimvar("lightmap", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying").Set(st)


def constant_uvs(mesh):
    UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").SetInterpolation("constant")


def double_uvs(mesh):
    api = UsdGeom.PrimvarsAPI(mesh)
    st = api.GetPrimvar("st").ComputeFlattened()
    api.RemovePrimvar("st")
    api.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2dArray, "faceVarying").Set([Gf.Vec2d(uv) for uv in st])


@pytest.mark.parametrize("change, words", [
    (wrong_sets, ["3 float numbers", "lightmap"]), (constant_uvs, ["interpolation is constant", "faceVarying"]),
    (double_uvs, ["2 double numbers"]),
])  # fmt: skip
def test_uvs_that_cannot_be_used_are_named_and_no_other_set_is_taken(build, tmp_path, change, words):
    product = build(write(tmp_path / "a.usda", shape=sheet, seam_column=2, finish=change))
    told = [message for code, message in warnings(product) if code == "no-uv-set"]
    assert all(any(word in message for message in told) for word in words), told
    assert product.report["recipe"]["sim"]["uvSet"] == ""


def test_the_motion_of_a_primvar_is_told(build, tmp_path):
    def change(mesh):
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("wet", Sdf.ValueTypeNames.FloatArray, "vertex")
        for time in (1, 2):
            primvar.GetAttr().Set(Vt.FloatArray([time] * 20), time)
        primvar.GetAttr().Set(Vt.FloatArray([0.5] * 20))

    product = build(faulty(change)(tmp_path / "a.usda"))
    assert any(code == "not-carried" and "the motion of" in m and "primvars:wet" in m for code, m in warnings(product))


@pytest.mark.parametrize("joint", [2, -1])
def test_joints_beyond_the_skeleton_are_faults(usdtailor, tmp_path, joint):
    def skin(mesh):
        stage = mesh.GetPrim().GetStage()
        skeleton = UsdSkel.Skeleton.Define(stage, "/Coat/bones")
        skeleton.CreateJointsAttr(["a", "a/b"])
        api = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        api.CreateSkeletonRel().AddTarget("/Coat/bones")
        api.CreateJointIndicesPrimvar(False, 2).Set(Vt.IntArray([0, 1] * 10 + [0, joint] + [0, 1] * 9))
        api.CreateJointWeightsPrimvar(False, 2).Set(Vt.FloatArray([0.5] * 40))

    done = run(usdtailor, "check", faulty(skin)(tmp_path / "a.usda"))
    assert done.returncode == 1 and "error[index-out-of-range]" in done.stderr
    assert f"value 10 names joint {joint}" in done.stderr


def test_a_count_that_is_a_multiple_names_the_element_size(usdtailor, tmp_path):
    change = lambda mesh: add_primvar(mesh, name="w", type_name="float", interpolation="vertex", values=[0.25] * 80)
    done = run(usdtailor, "check", "-v", faulty(change)(tmp_path / "a.usda"))
    assert done.returncode == 0 and "elementSize to 4, as 80 are 4 x 20" in done.stderr
