"""What is around a garment: prims below its mesh, and collections that name it."""

import json

import numpy as np
import pytest
from conftest import run
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from runs import good, refused


def sheet(count, size, at=(0.0, 0.0, 0.0)):
    points = [(at[0] + size * x / (count - 1), at[1] + size * y / (count - 1), at[2]) for y in range(count) for x in range(count)]
    faces = [[count * y + x, count * y + x + 1, count * (y + 1) + x + 1, count * (y + 1) + x] for y in range(count - 1) for x in range(count - 1)]
    return points, faces


def define(stage, path, count, size, at=(0.0, 0.0, 0.0)):
    points, faces = sheet(count, size, at)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points), mesh.CreateFaceVertexCountsAttr([4] * len(faces)), mesh.CreateFaceVertexIndicesAttr(np.ravel(faces).tolist())
    return mesh


def new(path):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Y"), UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/G").GetPrim())
    define(stage, "/G/coat", 5, 4.0)
    return stage


def nested(path, purpose=None):
    """A coat with a button, stitches in a group and fur in a prim without a type below it, and a tag of a purpose of its own."""
    stage = new(path)
    if purpose:
        UsdGeom.Imageable(stage.GetPrimAtPath("/G")).CreatePurposeAttr(purpose)
    define(stage, "/G/coat/button", 3, 0.2, (2, 2, 0.02))
    UsdGeom.Scope.Define(stage, "/G/coat/sewing")
    stage.DefinePrim("/G/coat/hairs")
    for name in ("sewing/stitches", "hairs/fur"):
        curves = UsdGeom.BasisCurves.Define(stage, f"/G/coat/{name}")
        curves.CreatePointsAttr([(0, 0, 0.05), (0, 4, 0.05)]), curves.CreateCurveVertexCountsAttr([2]), curves.CreateTypeAttr("linear")
    UsdGeom.Points.Define(stage, "/G/coat/tag").CreatePurposeAttr("proxy")
    UsdGeom.Subset.CreateGeomSubset(UsdGeom.Mesh(stage.GetPrimAtPath("/G/coat")), "cuff", "face", Vt.IntArray([0, 1]))
    stage.GetRootLayer().Save()
    return path


def purposes(stage):
    below = Usd.PrimRange(stage.GetPrimAtPath("/G/coat"))
    return {str(prim.GetPath()): str(UsdGeom.Imageable(prim).ComputePurpose()) for prim in below if prim.IsA(UsdGeom.Imageable)}


@pytest.mark.parametrize("args", [[], ["--flatten"], ["--all"]], ids=["over", "flat", "all"])
@pytest.mark.parametrize("purpose", [None, "render"])
def test_prims_below_the_mesh_keep_their_purpose(usdtailor, tmp_path, purpose, args):
    source, out = nested(tmp_path / "in.usda", purpose), tmp_path / "out.usda"
    before = purposes(Usd.Stage.Open(str(source)))
    good(usdtailor, "build", source, "-o", out, *(args if "--all" in args else [*args, "--prim", "/G/coat"]))
    after = purposes(Usd.Stage.Open(str(out)))
    assert after.pop("/G/coat") == "guide" and before.pop("/G/coat") == (purpose or "default")
    assert after == before and set(after.values()) == {purpose or "default", "proxy"}
    good(usdtailor, "build", source, "-o", tmp_path / "kept.usda", "--prim", "/G/coat", "--keep-model-purpose")
    assert purposes(Usd.Stage.Open(str(tmp_path / "kept.usda")))["/G/coat"] == (purpose or "default")


@pytest.mark.parametrize("args", [["--all"], ["--prim", "/G/coat", "--set", "trim.t.prims=/G/coat/button"]], ids=["found", "named"])
def test_trims_below_the_mesh_ride_on_it(usdtailor, tmp_path, args):
    source, out = nested(tmp_path / "in.usda"), tmp_path / "out.usdc"
    good(usdtailor, "build", source, "-o", out, *args)
    stage = Usd.Stage.Open(str(out))
    assert stage.GetPrimAtPath("/G/coat/button").GetRelationship("tailor:bindTarget").GetTargets() == ["/G/sim"]
    sim = np.array(stage.GetPrimAtPath("/G/sim").GetAttribute("points").Get())
    np.savez(tmp_path / "cache.npz", points=np.stack([sim, sim + [1, 2, 3]]))
    good(usdtailor, "drive", out, "--cache", tmp_path / "cache.npz", "-o", tmp_path / "shot.usdc")
    button = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    points = button.GetPrimAtPath("/G/coat/button").GetAttribute("points")
    assert np.allclose(np.array(points.Get(2)) - points.Get(1), [1, 2, 3], atol=1e-5)


def test_panels_of_a_sewn_garment_keep_what_is_below_them(usdtailor, tmp_path):
    stage = new(tmp_path / "in.usda")
    define(stage, "/G/back", 5, 4.0, (4, 0, 0))
    UsdGeom.Points.Define(stage, "/G/back/dots").CreatePointsAttr([(5, 1, 0)])
    stage.GetRootLayer().Save()
    good(usdtailor, "build", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--all")
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert str(UsdGeom.Imageable(out.GetPrimAtPath("/G/back")).ComputePurpose()) == "guide"
    assert str(UsdGeom.Imageable(out.GetPrimAtPath("/G/back/dots")).ComputePurpose()) == "default"


def linked(path, relationship, targets, more=()):
    stage = new(path)
    light = stage.DefinePrim("/key", "RectLight")
    light.CreateRelationship(relationship).SetTargets(targets)
    for name, own in more:
        light.CreateRelationship(name).SetTargets(own)
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("relationship", ["collection:lightLink:includes", "collection:shadowLink:excludes", "physics:filteredPairs"])
def test_a_collection_that_names_the_model_is_told(usdtailor, tmp_path, relationship):
    source = linked(tmp_path / "in.usda", relationship, ["/G/coat"])
    done = good(usdtailor, "build", source, "-o", tmp_path / "out.usda", "-v")
    assert f"/key.{relationship}: not carried: it names /G/coat" in done.stderr, done.stderr
    refused(usdtailor, "build", source, "-o", tmp_path / "strict.usda", "--strict", "--set", "sim.uvSet=", says=[relationship])


@pytest.mark.parametrize(
    "targets, more",
    [(["/G"], []), (["/G/coat", "/G/render"], []), (["/G/coat"], [("material:binding:collection:a", ["/key.collection:lightLink", "/wool"])])],
    ids=["above", "with the product", "of a material"],
)
def test_a_collection_that_holds_the_products_is_not(usdtailor, tmp_path, targets, more):
    source = linked(tmp_path / "in.usda", "collection:lightLink:includes", targets, more)
    done = good(usdtailor, "build", source, "-o", tmp_path / "out.usda")
    assert "collection" not in done.stderr, done.stderr


def test_a_collection_may_be_an_expression(usdtailor, tmp_path):
    """Members by `membershipExpression`, as OpenUSD resolves them."""
    stage = new(tmp_path / "in.usda")
    define(stage, "/G/body", 5, 4.0, (0, 0, -1))
    api = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/G"), "props")
    api.CreateMembershipExpressionAttr().Set(Sdf.PathExpression("/G/bod*"))
    stage.GetRootLayer().Save()
    assert api.ComputeMembershipQuery().IsPathIncluded(Sdf.Path("/G/body"))
    good(usdtailor, "build", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--exclude", "/G.collection:props")
    assert not Usd.Stage.Open(str(tmp_path / "out.usda")).GetPrimAtPath("/G/body_sim")
    api.CreateMembershipExpressionAttr().Set(Sdf.PathExpression("/G/none"))
    stage.GetRootLayer().Save()
    refused(usdtailor, "build", tmp_path / "in.usda", "-o", tmp_path / "no.usda", "--exclude", "/G.collection:props", says=["matches no mesh"])


def faulty(path):
    """A coat with velocities, which no product has, and without UVs."""
    stage = new(path)
    stage.GetPrimAtPath("/G/coat").CreateAttribute("velocities", Sdf.ValueTypeNames.Vector3fArray).Set([Gf.Vec3f(0, 0, 1)] * 25)
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("args", [[], ["--flatten"], ["--lods", "2"]], ids=["over", "flat", "levels"])
def test_a_fresh_output_keeps_its_warnings(usdtailor, tmp_path, args):
    source, out, report = faulty(tmp_path / "in.usda"), tmp_path / "out.usdc", tmp_path / "report.json"
    runs = []
    for number in range(3):
        done = good(usdtailor, "build", source, "-o", out, "--skip-fresh", "--force", "--report", report, *args)
        found = json.loads(report.read_text())
        assert found["status"] == ("fresh" if number else "built")
        runs.append((done.stderr, sorted(warning["message"] for warning in found["warnings"])))
    assert len(runs[0][1]) >= 2 and "warning[not-carried]" in runs[0][0]
    assert sorted(runs[0][0].splitlines()) == sorted(runs[1][0].splitlines()) and runs[1:] == [runs[1]] * 2 and runs[0][1] == runs[1][1]
    # In a run of several, and with their remedies.
    other = new(tmp_path / "other.usda")
    other.GetRootLayer().Save()
    for _ in range(2):
        done = good(usdtailor, "build", source, tmp_path / "other.usda", "-o", tmp_path / "all", "--skip-fresh", "--force", "-v", *args)
        assert f"warning[not-carried]: {source}: " in done.stderr and "hint: " in done.stderr
    # Warnings are as much of a fault as in the build that wrote the output.
    refused(usdtailor, "build", source, "-o", out, "--skip-fresh", "--force", "--strict", *args, says=["strict-warning"])


def test_warnings_of_coarser_levels_are_warnings(usdtailor, tmp_path):
    """A face set that is wide enough for the first level, and not for the second."""
    stage = new(tmp_path / "in.usda")
    UsdGeom.Subset.CreateGeomSubset(UsdGeom.Mesh(stage.GetPrimAtPath("/G/coat")), "cuff", "face", Vt.IntArray([5]))
    stage.GetRootLayer().Save()
    args = ["build", tmp_path / "in.usda", "--set", "sim.maxEdgeLength=0.4"]
    one = good(usdtailor, *args, "-o", tmp_path / "one.usdc")
    done = good(usdtailor, *args, "-o", tmp_path / "out.usdc", "--lods", "3", "--report", tmp_path / "report.json")
    report = json.loads((tmp_path / "report.json").read_text())
    of_levels = [warning for level in report["levels"] for warning in level["warnings"]]
    assert of_levels, "the coarser levels have warnings of their own"
    for number, level in enumerate(report["levels"], 1):
        for warning in level["warnings"]:
            assert f"warning[{warning['code']}]" in done.stderr and f"at level of detail {number}" in done.stderr, done.stderr
    assert one.stderr.count("warning[") + len(of_levels) == done.stderr.count("warning[")
    assert len(report["warnings"]) == done.stderr.count("warning[")
    worse = [warning["code"] for warning in of_levels if warning["severity"] != "note"]
    strict = run(usdtailor, *args, "-o", tmp_path / "strict.usdc", "--lods", "3", "--strict", "--set", "sim.uvSet=")
    assert strict.returncode == (1 if worse else 0) or "level of detail" in strict.stderr
    check = good(usdtailor, "check", tmp_path / "out.usdc")
    assert "at level of detail" in check.stderr


def test_a_bad_index_names_its_prim_with_all(usdtailor, tmp_path):
    stage = new(tmp_path / "in.usda")
    corners = UsdGeom.Mesh(stage.GetPrimAtPath("/G/coat")).GetFaceVertexIndicesAttr()
    corners.Set([*list(corners.Get())[:-1], 99])
    stage.GetRootLayer().Save()
    done = refused(usdtailor, "check", tmp_path / "in.usda", "--all", says=["/G/coat.faceVertexIndices", "names point 99"])
    assert "library failed" not in done.stderr
    define(stage, "/G/button", 3, 0.2, (2, 2, 0.02))
    stage.GetRootLayer().Save()
    refused(usdtailor, "check", tmp_path / "in.usda", "--all", says=["/G/coat.faceVertexIndices", "names point 99"])


@pytest.mark.parametrize("sharpness, is_good", [(2.0, True), (3.0, False)])
def test_a_corner_may_be_named_twice_with_one_sharpness(usdtailor, tmp_path, sharpness, is_good):
    stage = new(tmp_path / "in.usda")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/G/coat"))
    mesh.CreateCornerIndicesAttr([0, 4, 0]), mesh.CreateCornerSharpnessesAttr([2.0, 1.0, sharpness])
    stage.GetRootLayer().Save()
    if not is_good:
        refused(usdtailor, "check", tmp_path / "in.usda", says=["names point 0 again"])
        return
    good(usdtailor, "build", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--set", "render.level=0")
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    render = UsdGeom.Mesh(out.GetPrimAtPath("/G/render"))
    assert dict(zip(render.GetCornerIndicesAttr().Get(), render.GetCornerSharpnessesAttr().Get())) == {0: 2.0, 4: 1.0}


def sized(path, stronger):
    """A published coat in two sizes, and a layer over it that says where its points are, or nothing."""
    stage = new(path.with_name("published.usda"))
    root, mesh = stage.GetDefaultPrim(), UsdGeom.Mesh(stage.GetPrimAtPath("/G/coat"))
    points = np.array(mesh.GetPointsAttr().Get())
    stage.GetPrimAtPath("/G/coat").RemoveProperty("points")
    sizes = root.GetVariantSets().AddVariantSet("size")
    for name, scale in (("S", 1.0), ("L", 1.5)):
        sizes.AddVariant(name), sizes.SetVariantSelection(name)
        with sizes.GetVariantEditContext():
            mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy((points * scale).astype(np.float32)))
    stage.GetRootLayer().Save()
    over = Usd.Stage.CreateNew(str(path))
    over.GetRootLayer().subLayerPaths.append("published.usda")
    over.SetDefaultPrim(over.GetPrimAtPath("/G"))
    if stronger:
        UsdGeom.Mesh(over.OverridePrim("/G/coat")).CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    over.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("stronger", [True, False])
def test_variants_that_a_stronger_layer_hides_are_told(usdtailor, tmp_path, stronger):
    source, out = sized(tmp_path / "in.usda", stronger), tmp_path / "out.usda"
    done = good(usdtailor, "build", source, "-o", out, "--variants", "size", "-v")
    for size in ("S", "L"):
        told = f"/G/coat.points: not carried: size={size} has it, and what {source} says is stronger"
        assert (told in done.stderr) == stronger, done.stderr
    stage, widths = Usd.Stage.Open(str(out)), set()
    for size in ("S", "L"):
        stage.GetPrimAtPath("/G").GetVariantSet("size").SetVariantSelection(size)
        points = np.array(stage.GetPrimAtPath("/G/sim").GetAttribute("points").Get())
        widths.add(round(float(np.ptp(points[:, 0])), 3))
    assert len(widths) == (1 if stronger else 2)
