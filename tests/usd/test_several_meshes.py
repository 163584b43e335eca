"""Several meshes of one file: panels that are sewn together, garments of their own, and what is not a garment."""

import json

import numpy as np
import pytest
from conftest import run
from mesh import border_loops
from panels import ARM, HEIGHT, NECK, PLACES, WIDTH, add_belt, add_panel, built, meshes, panel, refused, seam_edges, suit, whole
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import add_primvar, add_subset, bind, define


@pytest.mark.parametrize("args", [("--all",), ("--prim", "/Suit")], ids=["all", "prim"])
def test_panels_are_sewn_as_if_they_were_one_mesh(usdtailor, suit, whole, tmp_path, args):
    out, one = tmp_path / "out.usda", tmp_path / "one.usda"
    built(usdtailor, suit(), out, *args)
    built(usdtailor, whole, one, "--set", "sim.constraints=sewn")
    for name in ("sim", "render"):
        (mesh,), (expected,) = meshes(out, name), meshes(one, name)
        assert abs(mesh.face_areas.sum() / expected.face_areas.sum() - 1) < 1e-3
        # Neck, hem and two arms; a seam that is open would join them or add to them.
        assert border_loops(mesh.topology) == border_loops(expected.topology) == 4
        assert (mesh.topology.edge_faces <= 2).all()
        for side in ("front", "back"):
            area, wanted = (m.face_areas[m.subsets[side].indices].sum() for m in (mesh, expected))
            assert abs(area / wanted - 1) < 0.01, (name, side)
        sewn = {tuple(sorted(pair)) for pair in mesh.subsets["sewn"].pairs.tolist()}
        inner = {tuple(sorted(edge)) for edge, count in zip(mesh.topology.edges.tolist(), mesh.topology.edge_faces) if count == 2}
        assert sewn and sewn <= inner
        # Each panel keeps its own UVs and both have the weights along the seam.
        assert len(np.unique(mesh.uv_shells())) == 2
        weights = mesh.primvars["weight"].flat[:, 0]
        assert np.allclose(weights, mesh.points[:, 1] / HEIGHT, atol=0.02)
    (render,), (expected,) = meshes(out, "render"), meshes(one, "render")
    assert np.array_equal(render.indices, expected.indices)
    assert np.allclose(render.points, expected.points, atol=1e-5)


def test_seams_are_edges_of_the_simulation_mesh_unless_the_recipe_says_otherwise(usdtailor, tmp_path):
    """Two flat sheets side by side, where nothing but the seam keeps edges on it."""
    path, out = tmp_path / "sheets.usda", tmp_path / "out.usda"
    stage = Usd.Stage.CreateNew(str(path))
    for name, first in (("left", -5), ("right", 0)):
        columns, rows = np.meshgrid(np.arange(6) + first, np.arange(6))
        points = np.stack([columns.ravel(), rows.ravel(), np.zeros(36)], axis=1).astype(float)
        corner = (np.arange(5)[:, None] * 6 + np.arange(5)).ravel()
        define(stage, f"/Suit/{name}", (points, np.full(25, 4), np.stack([corner, corner + 1, corner + 7, corner + 6], axis=1).ravel()))
    stage.Save()

    def crossing(*args):
        """Triangles on both sides of the seam."""
        built(usdtailor, path, out, "--all", "--force", "--set", "sim.maxEdgeLength=0.7", *args)
        (mesh,) = meshes(out, "sim")
        x = mesh.points[mesh.indices][:, 0].reshape(-1, 3)
        return ((x.min(axis=1) < -1e-3) & (x.max(axis=1) > 1e-3)).sum()

    assert crossing() == 0
    assert crossing("--set", "sim.constraints=") > 3


def turn(mesh):
    """Turns the winding of the faces of a panel."""
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)[:, ::-1].ravel().tolist()
    mesh.GetFaceVertexIndicesAttr().Set(indices)
    UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").SetIndices(indices)


def mirrored(stage, front, back):
    turn(back)


def left_handed(stage, front, back):
    turn(back)
    back.CreateOrientationAttr("leftHanded")


@pytest.mark.parametrize("finish, matrix", [(mirrored, Gf.Matrix4d().SetScale((1, 1, -1))), (left_handed, None)])
def test_panels_of_another_handedness_are_turned(usdtailor, suit, tmp_path, finish, matrix):
    """A mirror and a left-handed panel turn the winding; the shirt is that of panels that agree."""
    source, out, plain = suit(finish, name="other.usda", matrix=matrix), tmp_path / "out.usda", tmp_path / "plain.usda"
    assert "winding" not in built(usdtailor, source, out, "--all")
    built(usdtailor, suit(), plain, "--all")
    for name in ("sim", "render"):
        (mesh,), (expected,) = meshes(out, name), meshes(plain, name)
        assert border_loops(mesh.topology) == 4
        assert mesh.face_areas.sum() == pytest.approx(expected.face_areas.sum(), rel=1e-3)
        uv, wanted = (np.sign(m.uv_areas()[m.subsets["back"].indices]) for m in (mesh, expected))
        assert len({*uv, *wanted}) == 1


def test_a_belt_is_a_garment_of_its_own(usdtailor, suit, tmp_path):
    source, out, report = suit(add_belt), tmp_path / "out.usda", tmp_path / "report.json"
    built(usdtailor, source, out, "--all", "--report", report)
    stage = Usd.Stage.Open(str(out))
    names = {prim.GetName() for prim in stage.GetPrimAtPath("/Suit").GetChildren() if prim.IsA(UsdGeom.Mesh)}
    assert names == {"front", "back", "belt", "front_sim", "front_render", "belt_sim", "belt_render"}
    assert stage.GetPrimAtPath("/Suit/front_sim_physics") and stage.GetPrimAtPath("/Suit/belt_sim_physics")
    for name in ("front", "back", "belt"):
        assert stage.GetPrimAtPath(f"/Suit/{name}").GetAttribute("purpose").Get() == "guide"
    garments = json.loads(report.read_text())["garments"]
    assert [garment["prim"] for garment in garments] == ["/Suit/front+back", "/Suit/belt"]
    assert [garment["names"] for garment in garments] == [["front_sim", "front_render"], ["belt_sim", "belt_render"]]
    # The belt is what a build of it alone makes.
    alone = tmp_path / "alone.usda"
    built(usdtailor, source, alone, "--prim", "/Suit/belt")
    for product in ("sim", "render"):
        (mesh,), (expected,) = meshes(out, f"belt_{product}"), meshes(alone, product)
        assert np.array_equal(mesh.points, expected.points) and np.array_equal(mesh.indices, expected.indices)


def add_body(stage, *_):
    points = np.array([[x, y, z] for y in (0, 9) for x, z in ((-2, -1), (2, -1), (2, 1), (-2, 1))], float)
    quads = np.array([[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)])
    for path, purpose in (("/Suit/body/skin", None), ("/Suit/bounds", "proxy"), ("/Suit/rig", "guide")):
        mesh = define(stage, path, (points, np.full(4, 4), quads.ravel()))
        if purpose:
            mesh.CreatePurposeAttr(purpose)


@pytest.mark.parametrize("pattern", ["body", "/Suit/body", "/Suit/b*/skin", "sk*"])
def test_what_is_no_garment_is_left_alone(usdtailor, suit, tmp_path, pattern):
    source, out = suit(add_body), tmp_path / "out.usda"
    built(usdtailor, source, out, "--exclude", pattern)
    stage = Usd.Stage.Open(str(out))
    names = {prim.GetName() for prim in stage.GetPrimAtPath("/Suit").GetChildren()}
    assert names == {"front", "back", "body", "bounds", "rig", "sim", "render", "physics"}
    assert stage.GetPrimAtPath("/Suit/body/skin").GetAttribute("purpose").Get() == "default"


@pytest.mark.parametrize("rule", ["expandPrims", "explicitOnly"])
def test_the_members_of_a_collection_are_left_alone(usdtailor, suit, tmp_path, rule):
    def finish(stage, *panels):
        add_body(stage, *panels)
        props = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Suit"), "props")
        others = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Suit"), "others")
        skin = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Suit/body"), "skin")
        skin.CreateExpansionRuleAttr(rule)
        skin.IncludePath("/Suit/body/skin" if rule == "explicitOnly" else "/Suit/body")
        for outer, inner in ((others, skin), (props, others)):
            outer.CreateIncludesRel().AddTarget(inner.GetCollectionPath())

    source, out = suit(finish), tmp_path / "out.usda"
    built(usdtailor, source, out, "--exclude", "/Suit.collection:props")
    stage = Usd.Stage.Open(str(out))
    names = {prim.GetName() for prim in stage.GetPrimAtPath("/Suit").GetChildren()}
    assert names == {"front", "back", "body", "bounds", "rig", "sim", "render", "physics"}


def test_an_excluded_member_of_a_collection_is_no_member(usdtailor, suit, tmp_path):
    def finish(stage, *panels):
        all_but = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Suit"), "allBut")
        all_but.IncludePath("/Suit")
        all_but.ExcludePath("/Suit/front")

    out = tmp_path / "out.usda"
    built(usdtailor, suit(finish), out, "--exclude", "/Suit.collection:allBut")
    stage = Usd.Stage.Open(str(out))
    count = len(UsdGeom.Mesh(stage.GetPrimAtPath("/Suit/front")).GetFaceVertexCountsAttr().Get())
    assert len(UsdGeom.Mesh(stage.GetPrimAtPath("/Suit/render")).GetFaceVertexCountsAttr().Get()) == 16 * count


@pytest.mark.parametrize("is_outer", [True, False])
def test_an_exclude_is_stronger_than_a_collection_that_is_included(usdtailor, suit, tmp_path, is_outer):
    """As `ComputeIncludedPaths` has it: the includes of a collection inside another do not bring back what that excludes."""
    def finish(stage, *panels):
        add_body(stage, *panels)
        inner, outer = (Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Suit"), name) for name in ("inner", "outer"))
        for path in ("/Suit/front", "/Suit/body"):
            inner.IncludePath(path)
        outer.CreateIncludesRel().AddTarget(inner.GetCollectionPath())
        (outer if is_outer else inner).CreateExcludesRel().AddTarget("/Suit/front")
        paths = Usd.CollectionAPI.ComputeIncludedPaths(outer.ComputeMembershipQuery(), stage)
        assert "/Suit/front" not in paths and "/Suit/body/skin" in paths

    out = tmp_path / "out.usda"
    built(usdtailor, suit(finish), out, "--exclude", "/Suit.collection:outer")
    stage = Usd.Stage.Open(str(out))
    assert stage.GetPrimAtPath("/Suit/sim"), "both panels are sewn"
    assert stage.GetPrimAtPath("/Suit/body/skin").GetAttribute("purpose").Get() == "default"


@pytest.mark.parametrize("name", ["/Suit.collection:prop", "/Suit/x.collection:props", "x.collection:props", "/Suit.collection:"])
def test_a_collection_that_is_not_there_is_refused(usdtailor, suit, tmp_path, name):
    words = refused(usdtailor, suit(), tmp_path / "out.usda", "--all", "--exclude", name)
    assert name in words


def test_a_pattern_that_matches_nothing_is_refused(usdtailor, suit, tmp_path):
    words = refused(usdtailor, suit(), tmp_path / "out.usda", "--all", "--exclude", "bodi")
    assert "bodi matches no mesh" in words and "/Suit/front" in words


def test_borders_that_are_split_otherwise_are_not_sewn(usdtailor, suit, tmp_path):
    out, report = tmp_path / "out.usda", tmp_path / "report.json"
    words = built(usdtailor, suit(rows=HEIGHT * 2 - 5), out, "--all", "--set", "sim.maxEdgeLength=1", "--report", report, "-v")
    assert "warning[unsewn-borders]: /Suit/front, /Suit/back" in words and "--sew-tolerance" in words
    # The shoulders have the same points on both panels, the sides have not.
    done = run(usdtailor, "info", "--all", tmp_path / "suit.usda")
    assert f"sewn     /Suit/front to /Suit/back: {2 * (WIDTH // 2 - NECK)} border edges" in done.stdout
    (warning,) = (w for w in json.loads(report.read_text())["warnings"] if w["code"] == "unsewn-borders")
    assert len(warning["elements"]["edges"]) == 2 * ARM


def test_panels_that_touch_nowhere_are_garments_of_their_own(usdtailor, suit, tmp_path):
    def apart(stage, front, back):
        UsdGeom.Xformable(back).ClearXformOpOrder()
        UsdGeom.Xformable(back).AddTranslateOp().Set((0, 100, 0))

    words = built(usdtailor, suit(apart), tmp_path / "out.usda", "--all")
    assert "unsewn" not in words
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert stage.GetPrimAtPath("/Suit/front_sim") and stage.GetPrimAtPath("/Suit/back_sim")


def shifted(by):
    def finish(stage, front, back):
        matrix = Gf.Matrix4d(PLACES["back"])
        matrix.SetTranslateOnly((0, by, 0))
        op = UsdGeom.Xformable(back).GetOrderedXformOps()[0]
        op.Set(matrix)

    return finish


def test_the_tolerance_is_a_share_of_the_mean_edge(usdtailor, suit):
    source = suit(shifted(0.05))
    assert "sewn     /Suit" not in run(usdtailor, "info", "--all", source).stdout
    wide = run(usdtailor, "info", "--all", source, "--sew-tolerance", "0.1").stdout
    assert f"{seam_edges()} border edges, at most 5.00e-2 stage units apart" in wide
    bad = run(usdtailor, "info", "--all", source, "--sew-tolerance", "2")
    assert bad.returncode == 2 and "--sew-tolerance 2" in bad.stderr


def options(**values):
    def finish(stage, front, back):
        for name, mesh in (("front", front), ("back", back)):
            for key, (kind, value) in values.get(name, {}).items():
                mesh.GetPrim().CreateAttribute(key, kind).Set(value)

    return finish


def test_options_of_panels_are_those_of_the_garment(usdtailor, suit, tmp_path):
    length, level = ("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float), ("tailor:render:level", Sdf.ValueTypeNames.Int)
    source = suit(options(front={length[0]: (length[1], 1.5)}, back={level[0]: (level[1], 2)}))
    report = tmp_path / "report.json"
    built(usdtailor, source, tmp_path / "out.usda", "--all", "--report", report)
    recipe = json.loads(report.read_text())["recipe"]
    assert (recipe["sim"]["maxEdgeLength"], recipe["render"]["level"], recipe["sim"]["constraints"]) == (1.5, 2, ["sewn"])
    both = suit(options(front={length[0]: (length[1], 1.5)}, back={length[0]: (length[1], 2.5)}), name="both.usda")
    words = refused(usdtailor, both, tmp_path / "both_out.usda", "--all")
    assert "error[panels-differ]: /Suit/front, /Suit/back" in words and "tailor:sim:maxEdgeLength is 1.5 on one and 2.5" in words


def test_sets_of_one_name_are_one_and_their_options_join(usdtailor, suit, tmp_path):
    def finish(stage, front, back):
        for mesh, own in ((front, "pocket"), (back, "yoke")):
            add_subset(mesh, name="hem", indices=range(WIDTH), family="")
            add_subset(mesh, name=own, indices=[2 * WIDTH + 3, 2 * WIDTH + 4], family="")
            fabric = mesh.GetPrim().CreateRelationship("tailor:fabric:trim:faces")
            fabric.SetTargets([mesh.GetPath().AppendChild("hem"), mesh.GetPath().AppendChild(own)])

    report = tmp_path / "report.json"
    built(usdtailor, suit(finish), tmp_path / "out.usda", "--all", "--report", report)
    assert json.loads(report.read_text())["recipe"]["fabric"]["trim"]["faces"] == ["hem", "pocket", "yoke"]
    (render,) = meshes(tmp_path / "out.usda", "render")
    assert len(render.subsets["hem"].indices) == 16 * 2 * WIDTH

    def unlike(stage, front, back):
        add_subset(front, name="hem", indices=range(WIDTH))
        add_subset(back, name="hem", indices=[0, 1], element="edge")

    words = refused(usdtailor, suit(unlike, name="unlike.usda"), tmp_path / "unlike_out.usda", "--all")
    assert "panels-differ" in words and "/Suit/front, /Suit/back" in words and "subset hem" in words


def test_schemes_that_differ_are_refused(usdtailor, suit, tmp_path):
    words = refused(usdtailor, suit(lambda stage, front, back: back.CreateSubdivisionSchemeAttr("bilinear")), tmp_path / "out.usda", "--all")
    assert "/Suit/front, /Suit/back" in words and "subdivisionScheme is CatmullClark on one and Bilinear" in words


def test_primvars_of_some_panels_are_told_and_constant_ones_are_kept(usdtailor, suit, tmp_path):
    def finish(stage, front, back):
        add_primvar(front, name="dirt", type_name="float", interpolation="vertex")
        for mesh, colour in ((front, (1, 0, 0)), (back, (0, 0, 1))):
            mesh.CreateDisplayColorAttr([colour])
            add_primvar(mesh, name="lot", type_name="int", interpolation="constant", values=[7])

    words = built(usdtailor, suit(finish), tmp_path / "out.usda", "--all")
    assert "primvars:dirt" in words and "`/Suit/back`" in words
    for mesh in meshes(tmp_path / "out.usda", "sim", "render"):
        assert "dirt" not in mesh.primvars
        colour = mesh.primvars["displayColor"]
        assert colour.interpolation == "uniform"
        assert np.allclose(colour.flat[mesh.subsets["front"].indices], [1, 0, 0])
        assert np.allclose(colour.flat[mesh.subsets["back"].indices], [0, 0, 1])
        assert mesh.primvars["lot"].interpolation == "constant" and list(mesh.primvars["lot"].values) == [7]


def test_weights_that_disagree_at_a_seam_get_their_mean(usdtailor, suit, tmp_path):
    def finish(stage, front, back):
        for mesh, weight in ((front, 0.0), (back, 1.0)):
            count = len(mesh.GetPointsAttr().Get())
            add_primvar(mesh, name="side", type_name="float", interpolation="varying", values=[weight] * count)

    words = built(usdtailor, suit(finish), tmp_path / "out.usda", "--all", "--set", "render.level=0")
    assert "primvars:side" in words and "mean" in words
    (render,) = meshes(tmp_path / "out.usda", "render")
    side, on_seam = render.primvars["side"].flat[:, 0], np.unique(render.subsets["sewn"].pairs)
    assert np.allclose(side[on_seam], 0.5)
    assert set(np.delete(side, on_seam)) == {0.0, 1.0}


def test_materials_of_panels_are_those_of_their_face_sets(usdtailor, suit, tmp_path):
    def finish(stage, front, back):
        bind(front.GetPrim(), "wool")
        bind(back.GetPrim(), "silk")

    built(usdtailor, suit(finish), tmp_path / "out.usda", "--all")
    for mesh in meshes(tmp_path / "out.usda", "render"):
        for side, material in (("front", "wool"), ("back", "silk")):
            subset = mesh.subsets[side]
            assert (subset.family, subset.material) == ("materialBind", f"/Suit/materials/{material}")


def test_an_output_is_fresh_until_its_input_changes(usdtailor, suit, tmp_path):
    source, out = suit(add_belt), tmp_path / "out.usda"
    built(usdtailor, source, out, "--all")
    fresh = run(usdtailor, "check", "--all", out)
    assert fresh.returncode == 0 and "good, and fresh" in fresh.stdout, fresh.stderr
    again = run(usdtailor, "build", source, "-o", out, "--all", "--skip-fresh", "--force")
    assert "fresh" in again.stdout
    other = run(usdtailor, "build", source, "-o", out, "--all", "--skip-fresh", "--force", "--sew-tolerance", "0.002")
    assert "triangles" in other.stdout and "triangles" not in again.stdout
    stage = Usd.Stage.Open(str(source))
    UsdGeom.Mesh(stage.GetPrimAtPath("/Suit/back")).CreateDisplayColorAttr([(0, 1, 0)])
    stage.Save()
    stale = run(usdtailor, "check", "--all", out)
    assert stale.returncode == 1 and "suit.usda has changed" in stale.stderr


def test_products_are_built_again_over_their_own(usdtailor, suit, tmp_path):
    first, again = tmp_path / "first.usda", tmp_path / "again.usda"
    built(usdtailor, suit(add_belt), first, "--all")
    built(usdtailor, first, again, "--all")
    names = ("front_sim", "front_render", "belt_sim", "belt_render")
    for one, two in zip(meshes(first, *names), meshes(again, *names)):
        assert np.array_equal(one.points, two.points) and set(one.subsets) == set(two.subsets)


def test_panels_below_prims_of_their_own_have_products_at_the_common_parent(usdtailor, tmp_path):
    path, out = tmp_path / "deep.usda", tmp_path / "out.usda"
    stage = Usd.Stage.CreateNew(str(path))
    for name, side in (("front", 1), ("back", -1)):
        add_panel(stage, name, side, parent=f"/Suit/{name}_group")
    UsdGeom.Xformable(stage.GetPrimAtPath("/Suit")).AddTranslateOp().Set((0, 50, 0))
    stage.Save()
    built(usdtailor, path, out, "--all")
    (sim,) = meshes(out, "sim")
    assert sim.points[:, 1].min() == pytest.approx(0, abs=1e-3)
    assert border_loops(sim.topology) == 4


def test_threads_do_not_change_the_output(usdtailor, suit, tmp_path):
    source = suit(add_belt)
    texts = []
    for threads in (1, 2):
        folder = tmp_path / str(threads)
        folder.mkdir()
        built(usdtailor, source, folder / "out.usda", "--all", "--threads", threads)
        texts.append((folder / "out.usda").read_bytes())
    assert texts[0] == texts[1]


def test_info_tells_what_is_sewn_to_what(usdtailor, suit):
    text = run(usdtailor, "info", "--prim", "/Suit", suit(add_belt)).stdout
    assert "/Suit/front+back" in text and "/Suit/belt" in text
    assert "panel    /Suit/front\n" in text and "panel    /Suit/back\n" in text
    assert f"sewn     /Suit/front to /Suit/back: {seam_edges()} border edges" in text
