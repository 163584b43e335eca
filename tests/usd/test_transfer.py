"""What transfer writes beyond primvars and subsets: sharpness, blend shapes, provenance."""

import json

import numpy as np
import pytest
from conftest import EXAMPLES, run
from mesh import cut_edges, find_model, read_mesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt
from sources import MODEL, add_primvar, add_skinning, add_subset, sheet, write

COUNT = len(sheet()[0])


def sharpness(prim):
    attribute = prim.GetAttribute("tailor:sharpness")
    return attribute.Get() if attribute else None


def test_creases_and_corners_are_subsets_with_their_sharpness(build, tmp_path):
    source = write(tmp_path / "in.usda", creases={(5, 6, 7): 2.5, (11, 12): 10.0}, corners={3: 4.0})
    product = build(source)
    sim = product.sim
    found = {name: (s.element_type, s.family, sharpness(s.prim)) for name, s in sim.subsets.items() if "tailorC" in name}
    assert found == {
        "tailorCreases": ("edge", "tailorCreases", 2.5),
        "tailorCreases_2": ("edge", "tailorCreases", 10.0),
        "tailorCorners": ("point", "tailorCorners", 4.0),
    }
    assert all(len(sim.subsets[name].indices) > 0 for name in found)


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_sharpness_survives_a_round_trip(build, tmp_path, suffix):
    """Written, exported by OpenUSD, and built again from the simulation mesh."""
    source = write(tmp_path / "in.usda", creases={(5, 6, 7): 2.5})
    first = build(source, "--flatten", suffix=suffix)
    again = tmp_path / f"again{suffix}"
    assert first.stage.GetRootLayer().Export(str(again))
    path = str(first.model_path.ReplaceName("sim"))
    names = ("--prim", path, "--sim-name", "sim2", "--render-name", "render2")
    second = build(again, *names, suffix=suffix, stem="second")
    for name in ("sim2", "render2"):
        mesh = read_mesh(second.stage.GetPrimAtPath(first.model_path.ReplaceName(name)))
        assert sharpness(mesh.subsets["tailorCreases"].prim) == 2.5, name
        assert len(mesh.subsets["tailorCreases"].indices) > 0, name


@pytest.mark.parametrize("product", ["sim", "render"])
def test_a_product_that_is_built_again_is_bound_anew(build, tmp_path, product):
    """Where the points of a product are, and what holds its pieces, is not a recipe and not a primvar of another mesh."""
    first = build(write(tmp_path / "in.usda"), "--flatten")
    path = str(first.model_path.ReplaceName(product))
    names = ("--prim", path, "--sim-name", "sim2", "--render-name", "render2")
    second = build(first.path, *names, "--flatten", stem="second")
    render = second.stage.GetPrimAtPath(first.model_path.ReplaceName("render2"))
    sim = second.stage.GetPrimAtPath(first.model_path.ReplaceName("sim2"))
    assert render.GetRelationship("tailor:bindTarget").GetTargets() == [sim.GetPath()]
    faces = render.GetAttribute("primvars:tailor:bindFace").Get()
    triangles = len(sim.GetAttribute("faceVertexCounts").Get())
    assert 0 <= min(faces) and triangles // 2 < max(faces) < triangles
    assert not sim.HasAttribute("primvars:tailor:bindFace")
    assert sim.GetRelationship("tailor:model:source").GetTargets() == [first.model_path.ReplaceName(product)]


def add_shapes(mesh):
    """Two bound shapes, one of some points with an inbetween, and one that is not bound.

    The offsets of each are a plain primvar too, such as `wide_offsets`.
    """
    stage, path = mesh.GetPrim().GetStage(), mesh.GetPath()

    def shape(name, offsets, indices=None, inbetween=None):
        prim = UsdSkel.BlendShape.Define(stage, path.AppendChild(name))
        prim.CreateOffsetsAttr(Vt.Vec3fArray([tuple(map(float, o)) for o in offsets]))
        prim.CreateNormalOffsetsAttr(Vt.Vec3fArray([tuple(map(float, o * 0.5)) for o in offsets]))
        if indices is not None:
            prim.CreatePointIndicesAttr(Vt.IntArray(indices))
        if inbetween is not None:
            half = prim.CreateInbetween("half")
            half.SetWeight(0.5)
            half.SetOffsets(Vt.Vec3fArray([tuple(map(float, o)) for o in inbetween]))
        for values in ("offsets", "normalOffsets"):
            rows = [Gf.Vec3f(*map(float, row)) for row in dense(prim, COUNT, values)]
            add_primvar(mesh, name=f"{name}_{values}", type_name="float3", interpolation="vertex", values=rows)

    rng = np.random.default_rng(5)
    shape("wide", rng.normal(size=(COUNT, 3)))
    shape("bump", rng.normal(size=(3, 3)), indices=[7, 2, 12], inbetween=rng.normal(size=(3, 3)))
    shape("loose", rng.normal(size=(COUNT, 3)))
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateBlendShapesAttr(Vt.TokenArray(["b", "w"]))
    binding.CreateBlendShapeTargetsRel().SetTargets([path.AppendChild("bump"), path.AppendChild("wide")])
    add_subset(mesh, name="loose_set", indices=[0, 1])


def dense(shape, count, name="offsets"):
    offsets = np.array(shape.GetPrim().GetAttribute(name).Get(), float).reshape(-1, 3)
    indices = shape.GetPointIndicesAttr().Get()
    out = np.zeros((count, 3))
    out[np.arange(count) if indices is None else np.array(indices, int)] = offsets
    return out


@pytest.mark.parametrize("flatten", [(), ("--flatten",)])
def test_blend_shapes_are_carried_to_both_products(build, tmp_path, flatten):
    source = write(tmp_path / "in.usda", finish=add_shapes)
    product = build(source, "--set", "render.level=1", *flatten)
    assert not any("lend" in warning for warning in product.warnings), product.warnings
    for name in ("sim", "render"):
        prim = product.prim(name)
        binding = UsdSkel.BindingAPI(prim)
        assert list(binding.GetBlendShapesAttr().Get()) == ["b", "w"]
        targets = binding.GetBlendShapeTargetsRel().GetTargets()
        assert [str(t) for t in targets] == [f"{prim.GetPath()}/bump", f"{prim.GetPath()}/wide"]
        for shape in ("wide", "bump", "loose"):
            own = UsdSkel.BlendShape(prim.GetChild(shape))
            valid, reason = UsdSkel.BlendShape.ValidatePointIndices(own.GetPointIndicesAttr().Get(), len(product.mesh(name).points))
            assert valid, reason
            before = UsdSkel.BlendShape(product.source.prim.GetChild(shape))
            for values in ("offsets", "normalOffsets"):
                moved = dense(own, len(product.mesh(name).points), values)
                given = dense(before, COUNT, values)
                assert np.allclose(moved, product.mesh(name).primvars[f"{shape}_{values}"].flat, atol=1e-5), (name, shape, values)
                if name == "sim":
                    assert np.abs(moved).max() <= np.abs(given).max() + 1e-5
                    assert np.abs(moved).max() > 0
        half = UsdSkel.BlendShape(prim.GetChild("bump")).GetInbetween("half")
        assert half.GetWeight() == 0.5
        assert len(half.GetOffsets()) == len(UsdSkel.BlendShape(prim.GetChild("bump")).GetPointIndicesAttr().Get())


def test_a_pose_of_the_blend_shapes_is_that_of_the_input(build, tmp_path):
    """The simulation mesh moved by a shape lies on the moved surface: it does where the shape shifts everything."""

    def finish(mesh):
        shape = UsdSkel.BlendShape.Define(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild("shift"))
        shape.CreateOffsetsAttr(Vt.Vec3fArray([(1.0, -2.0, 0.5)] * COUNT))

    product = build(write(tmp_path / "in.usda", finish=finish))
    for name in ("sim", "render"):
        shape = UsdSkel.BlendShape(product.prim(name).GetChild("shift"))
        assert np.allclose(dense(shape, len(product.mesh(name).points)), (1.0, -2.0, 0.5), atol=1e-5)


def test_a_shape_that_does_not_fit_is_a_warning(build, tmp_path):
    def finish(mesh):
        shape = UsdSkel.BlendShape.Define(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild("odd"))
        shape.CreateOffsetsAttr(Vt.Vec3fArray([(1.0, 0.0, 0.0)] * 2))
        shape.CreatePointIndicesAttr(Vt.IntArray([0, COUNT + 5]))

    product = build(write(tmp_path / "in.usda", finish=finish))
    assert any(f"{MODEL}/odd" in warning for warning in product.warnings), product.warnings
    assert not product.prim("sim").GetChild("odd")


def test_provenance_is_written_when_asked_for(build, tmp_path):
    source = write(tmp_path / "in.usda")
    assert "tailor:sourceFace" not in build(source).sim.primvars
    sim = build(source, "--set", "sim.provenance=true", stem="asked").sim
    faces, coords = sim.primvars["tailor:sourceFace"], sim.primvars["tailor:sourceCoords"]
    assert (faces.type_name, faces.interpolation) == ("int[]", "vertex")
    assert (coords.type_name, coords.interpolation) == ("float2[]", "vertex")
    assert len(faces.rows) == len(coords.rows) == len(sim.points)
    assert ((faces.rows >= 0) & (faces.rows < len(sheet()[1]))).all()
    assert (coords.rows >= -1e-5).all() and (coords.rows <= 1 + 1e-5).all()


def test_colours_are_means_of_what_faces_cover(build, tmp_path):
    """A gradient over the faces stays within one face's step of itself."""
    x = np.array(sheet()[0])[:, 0]

    def finish(mesh):
        colours = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform")
        colours.Set(Vt.Vec3fArray([(float(i % 4), 0.0, 1.0) for i in range(len(sheet()[1]))]))

    product = build(write(tmp_path / "in.usda", finish=finish), "--set", "sim.maxEdgeLength=0.4")
    rows = product.sim.primvars["displayColor"].flat
    assert (np.abs(rows[:, 0] + 0.5 - product.sim.face_centres[:, 0]) <= 0.7 + 1e-6).all()
    assert np.ptp(x) == 4 and rows[:, 0].min() == 0 and rows[:, 0].max() == 3


@pytest.mark.parametrize("kind", ["int", "token", "bool"])
@pytest.mark.parametrize("length", ["0.35", "0.9"])
def test_discrete_values_of_points_are_those_of_the_nearest_point(build, tmp_path, kind, length):
    points = len(sheet(6, 5)[0])
    values = {"int": range(points), "token": map("n{}".format, range(points)), "bool": (i % 2 == 0 for i in range(points))}
    primvar = {"name": "mark", "type_name": kind, "interpolation": "vertex", "values": list(values[kind])}
    path = write(tmp_path / "marks.usda", shape=lambda: sheet(6, 5), primvars=[primvar])
    product = build(path, "--set", f"sim.maxEdgeLength={length}")
    source, sim = product.source.points, product.mesh("sim")
    carried = sim.primvars["mark"]
    rows = np.arange(len(sim.points)) if carried.indices is None else carried.indices
    distances = np.linalg.norm(sim.points[:, None] - source[None], axis=2)
    wanted = np.array(primvar["values"], dtype=object)
    for at, row in zip(distances, rows):
        near = wanted[np.isclose(at, at.min(), atol=1e-4)]
        assert carried.rows[row][0] in near


LINES = {
    "band": lambda across, up: abs(up - 0.5) < 0.08,
    "slant": lambda across, up: up + 0.6 * across > 0.75,
    "wave": lambda across, up: up > 0.3 + 0.06 * np.sin(14 * across),
}


@pytest.mark.parametrize("line", LINES)
def test_borders_of_face_sets_that_are_no_constraints_have_no_teeth(build, tmp_path, line):
    """An edge set is the border of a face set. By the votes of triangles alone it is up to 37 % longer than its curve."""
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(EXAMPLES / "tshirt.usda")))
    mesh = UsdGeom.Mesh(find_model(stage))
    source = read_mesh(mesh.GetPrim())
    topology, box = source.topology, np.ptp(source.points, axis=0)
    corner = (source.points - source.points.min(axis=0))[source.indices] / box
    middle = np.stack([np.bincount(topology.corner_face, of_axis) for of_axis in corner.T], axis=1) / source.counts[:, None]
    is_in = LINES[line](middle[:, 0], middle[:, 1])
    values = np.unique(source.primvars["st"].flat, axis=0, return_inverse=True)[1].ravel()
    inside = np.bincount(topology.corner_edge, is_in[topology.corner_face], minlength=len(topology.edges))
    border = topology.edges[(topology.edge_faces == 2) & (inside == 1) & ~cut_edges(topology, values)]
    assert len(border) > 20
    UsdGeom.Subset.CreateGeomSubset(mesh, "part", "face", np.nonzero(is_in)[0].tolist(), "part")
    UsdGeom.Subset.CreateGeomSubset(mesh, "border", "edge", border.ravel().tolist(), "border")
    stage.Export(str(tmp_path / "parts.usda"))
    report = build(tmp_path / "parts.usda", "--set", "sim.density=", "--set", "sim.constraints=").report
    (found,) = [edges for edges in report["sim"]["edgeSets"] if edges["name"] == "border"]
    assert 0.95 < found["length"] / found["sourceLength"] < 1.14 and found["farthest"] < 1


@pytest.mark.parametrize("joints", [1, 2])
def test_a_skin_without_its_armature_is_left_out(usdtailor, tmp_path, joints):
    """Blender makes a skeleton of one joint for shape keys, where the armature is not exported. Larger ones lack a joint by mistake."""

    def finish(mesh):
        add_skinning(mesh, joints=7)
        stage = mesh.GetPrim().GetStage()
        skeleton = next(UsdSkel.Skeleton(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
        skeleton.GetJointsAttr().Set([f"joint{i + 1}" for i in range(joints)])

    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", write(tmp_path / "in.usda", finish=finish), "-o", out)
    if joints == 2:
        assert done.returncode == 1 and "error[index-out-of-range]" in done.stderr and "there are 2 joints" in done.stderr
        return
    assert done.returncode == 0 and "warning[not-carried]: the skin of /Coat/model" in done.stderr, done.stderr
    stage = Usd.Stage.Open(str(out))
    for name in ("sim", "render"):
        prim = stage.GetPrimAtPath(f"/Coat/{name}")
        assert not any(prim.GetAttribute(f"primvars:skel:joint{what}").HasAuthoredValue() for what in ("Indices", "Weights"))
    # It is still on the model.
    assert stage.GetPrimAtPath("/Coat/model").GetAttribute("primvars:skel:jointIndices").HasAuthoredValue()


def test_sets_that_nothing_uses_are_one_warning(usdtailor, tmp_path):
    """Edge sets that a coarse simulation mesh cannot keep apart, as an export has them, one of which the recipe names."""

    def finish(mesh):
        for number, column in enumerate((3, 9, 15, 20)):
            lines = [end for beside in (0, 1, 2) for row in range(4, 20) for end in (25 * row + column + beside, 25 * (row + 1) + column + beside)]
            add_subset(mesh, name=f"group{number}", indices=lines, element="edge")

    source, report = write(tmp_path / "in.usda", shape=lambda: sheet(24, 24), finish=finish), tmp_path / "out.json"

    def told(*args):
        out = tmp_path / "out.usda"
        done = run(usdtailor, "build", source, "-o", out, "--force", "--report", report, "--set", "sim.maxEdgeLength=3", *args)
        assert done.returncode == 0, done.stderr
        lines = [line for line in done.stderr.splitlines() if "group" in line]
        found = [warning for warning in json.loads(report.read_text())["warnings"] if warning["code"] == "not-carried"]
        return lines, found

    lines, (together,) = told()
    assert len(lines) == 1 and together["names"] == ["group0", "group1", "group2", "group3"] and len(together["elements"]["edges"]) > 4
    # A set that an operator uses has a warning of its own.
    lines, found = told("--set", "seam.side.edges=group1", "--set", "seam.side.width=0.2")
    assert sum("subset group1" in line for line in lines) >= 1
    (together,) = [warning for warning in found if warning.get("names")]
    assert together["names"] == ["group0", "group2", "group3"]
