"""Seams and folds as lists, and the sets that USD files carry."""

import bmesh
import bpy
import garment
import numpy
import pytest
import usd_tailor
from bl_ext.user_default.usd_tailor import messages, recipe
from loop import active, set_up


@pytest.fixture
def shirt():
    return set_up(armature=False, shape_key=False)


def select(ob, kind, is_chosen):
    """Selects elements in Edit Mode, and stays there."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(ob.data)
    for element in getattr(edited, kind):
        if is_chosen(element):
            element.select_set(True)
    bmesh.update_edit_mesh(ob.data)


def is_hem(element):
    return all(vert.co.z < 0.8 for vert in element.verts)


def selected(ob, kind):
    bpy.ops.object.mode_set(mode="OBJECT")
    return {element.index for element in getattr(ob.data, kind) if element.select}


def test_the_selection_becomes_a_seam_or_a_fold(shirt):
    for kind, elements, rows in (("seam", "edges", "edges"), ("fold", "faces", "polygons")):
        select(shirt, elements, is_hem)
        assert bpy.ops.tailor.add(kind=kind, source="SELECTED", name=f"hem {kind}") == {"FINISHED"}
        expected = selected(shirt, rows)
        select(shirt, elements, lambda element: False)
        bpy.ops.tailor.select(kind=kind, name=f"hem_{kind}")
        assert selected(shirt, rows) == expected and expected
    bpy.ops.tailor.tailor()


def test_what_is_selected_and_assigned_again_is_the_same(shirt):
    select(shirt, "faces", is_hem)
    bpy.ops.tailor.add(kind="fold", source="SELECTED", name="hem")
    before = built(shirt)["render"]["faces"]
    bpy.context.tool_settings.mesh_select_mode = (True, False, False)
    bpy.ops.tailor.select(kind="fold", name="hem")
    bpy.ops.tailor.assign(kind="fold", name="hem")
    assert built(shirt)["render"]["faces"] == before


def test_a_name_without_room_changes_nothing(shirt):
    before = recipe.properties(shirt)
    with pytest.raises(RuntimeError, match="shorter"):
        bpy.ops.tailor.add(kind="seam", source="MARKED", name="ä" * 20)
    with pytest.raises(RuntimeError, match="shorter"):
        bpy.ops.tailor.rename(kind="seam", name="sewn", new_name="ä" * 20)
    assert recipe.properties(shirt) == before
    bpy.ops.tailor.rename(kind="seam", name="sewn", new_name="n" * 38)
    assert recipe.operators(shirt) == [("seam", "n" * 38)]


def test_groups_that_differ_in_signs_alone_are_two(shirt):
    for name in ("top a", "top_a"):
        shirt.vertex_groups.new(name=name)
    bpy.ops.tailor.pin(group="top_a")
    from bl_ext.user_default.usd_tailor import cloth

    assert cloth.pin_group(shirt) == "top_a"


def test_a_garment_of_another_file_is_left_alone(shirt, tmp_path):
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Shirt"]
    linked = wanted.objects[0]
    bpy.context.collection.objects.link(linked)
    active(linked)
    assert not bpy.ops.tailor.select.poll() and not bpy.ops.tailor.tailor.poll()
    bpy.ops.object.make_local(type="SELECT_OBJECT")
    with pytest.raises(RuntimeError, match="linked"):
        bpy.ops.tailor.select(kind="seam", name="sewn")


def test_without_a_selection_nothing_is_added(shirt):
    select(shirt, "edges", lambda edge: False)
    before = recipe.properties(shirt)
    with pytest.raises(RuntimeError, match="Select some in Edit Mode"):
        bpy.ops.tailor.add(kind="seam", source="SELECTED", name="x")
    assert recipe.properties(shirt) == before


def test_seams_that_are_marked_in_edit_mode_count_at_once(shirt):
    bpy.ops.tailor.remove(kind="seam", name="sewn")
    shirt.data.edges.foreach_set("use_seam", [False] * len(shirt.data.edges))
    select(shirt, "edges", is_hem)
    bpy.ops.mesh.mark_seam(clear=False)
    assert bpy.ops.tailor.add(kind="seam", source="MARKED", name="marked") == {"FINISHED"}


@pytest.mark.parametrize(
    ("kind", "source"), [("seam", "UV"), ("seam", "BORDERS"), ("seam", "MATERIAL"), ("seam", "GROUP"), ("fold", "BORDERS"), ("fold", "MATERIAL"), ("fold", "GROUP")]
)
def test_each_source_gives_elements(shirt, kind, source):
    shirt.vertex_groups.active = shirt.vertex_groups["Säume" if kind == "seam" else "density"]
    shirt.active_material_index = 1
    bpy.ops.tailor.remove(kind="seam", name="sewn")
    bpy.ops.tailor.add(kind=kind, source=source, name="of")
    bpy.ops.tailor.select(kind=kind, name="of")
    assert selected(shirt, "edges" if kind == "seam" else "polygons")


def test_lists_are_renamed_reordered_and_switched(shirt):
    bpy.ops.tailor.add(kind="fold", source="BORDERS", name="hem")
    shirt["tailor:seam:sewn:width"] = 0.004
    bpy.ops.tailor.rename(kind="seam", name="sewn", new_name="side seam")
    bpy.ops.tailor.move(kind="fold", name="hem", by=-1)
    assert recipe.operators(shirt) == [("fold", "hem"), ("seam", "side_seam")]
    assert shirt["tailor:seam:side_seam:width"] == 0.004 and not [key for key in shirt.keys() if "sewn" in key]
    shirt["tailor:fold:hem:enabled"] = False
    job = built(shirt)
    assert job["recipe"]["render"]["operators"] == ["fold.hem", "seam.side_seam"]
    bpy.ops.tailor.rename(kind="seam", name="side_seam", new_name="hem")
    assert recipe.operators(shirt) == [("fold", "hem"), ("seam", "hem_001")], "names do not collide"


def built(ob):
    from bl_ext.user_default.usd_tailor.job import Job

    job = Job(ob)
    job.process.wait()
    try:
        return job.result()
    finally:
        job.cancel()


def test_every_option_of_the_table_has_its_range_and_meaning(shirt):
    bpy.ops.tailor.add(kind="fold", source="BORDERS", name="hem")
    for group, rows in recipe.table().items():
        instance = {"seam": ["sewn"], "fold": ["hem"], "fabric": ["wool"]}.get(group, [])
        for of in rows:
            value = ", ".join(of.default) if isinstance(of.default, list) else of.default
            recipe.put(shirt, of, {"edges": "uv_seam", "faces": "cuff_faces"}.get(of.key, value), *instance)
            shown = shirt.id_properties_ui(recipe.names.key(group, *instance, of.key)).as_dict()
            assert shown["description"].startswith(of.meaning.replace("`", "")[:30])
            if of.domain["type"] == "whole":
                assert (shown["min"], shown["max"]) == (0, min(of.domain["most"], 2**31 - 1))
    built(shirt)


# Names that a function and a set have.


def hide(ob, *names):
    """Edge attributes of these names, with one edge each."""
    for name in names:
        ob.data.attributes.new(name, "BOOLEAN", "EDGE").data[0].value = True


@pytest.mark.parametrize(("source", "name"), [("UV", "uvSeams"), ("BORDERS", "borders")])
def test_menus_name_functions_that_no_attribute_hides(shirt, source, name):
    bpy.ops.tailor.add(kind="seam", source=source, name="of")
    expression = shirt["tailor:seam:of:edges"]
    assert expression.startswith(f"{name}(") and expression.endswith(")")
    bpy.ops.tailor.select(kind="seam", name="of")
    before = selected(shirt, "edges")
    hide(shirt, name)
    bpy.ops.tailor.select(kind="seam", name="of")
    assert selected(shirt, "edges") == before and len(before) > 10
    bpy.ops.tailor.check()
    assert not hiding(shirt)


def hiding(ob):
    return [message["message"] for message in messages.of(ob)["messages"] if "hides the function" in message["message"]]


def test_check_tells_what_hides_a_function(shirt):
    hide(shirt, "borders", "uvSeams")
    bpy.ops.tailor.add(kind="seam", source="BORDERS", name="of")
    for value, names in (("borders", ["borders"]), ("borders.1 + uvSeams", ["borders", "uvSeams"]), ("borders(), border(material(borders))", []), ("edges", [])):
        shirt["tailor:seam:of:edges"] = value
        try:
            bpy.ops.tailor.check()
        except RuntimeError:
            # A piece of a set that is hidden may be no set.
            continue
        found = hiding(shirt)
        assert len(found) == len(names), (value, found)
        assert all(f"Edges of seam of: {name} is the edge attribute" in text and f"write {name}()" in text for name, text in zip(names, found))


def test_a_vertex_group_hides_a_function_of_points_alone(shirt):
    shirt.vertex_groups.new(name="points").add(range(50), 1.0, "REPLACE")
    shirt.vertex_groups.new(name="borders").add(range(50), 1.0, "REPLACE")
    bpy.ops.tailor.add(kind="seam", source="BORDERS", name="of")
    shirt["tailor:seam:of:edges"], shirt["tailor:cloth:pins"] = "borders", "points"
    bpy.ops.tailor.check()
    assert len(hiding(shirt)) == 1 and "Pins: points is the vertex group" in hiding(shirt)[0]


def test_sets_that_no_option_names_are_one_message(shirt):
    def lost():
        """Messages of the sets below, but those that tell something of a material too."""
        bpy.ops.tailor.check()
        found = [message for message in messages.of(shirt)["messages"] if "_strip" in message["message"]]
        return [message for message in found if not {"Body", "Collar"}.intersection(message.get("names", ()))]

    for number in range(5):
        # Single faces, which large triangles lose.
        shirt.data.attributes.new(f"a_strip{number}", "BOOLEAN", "FACE").data[40 * number].value = True
    shirt["tailor:sim:maxEdgeLength"] = 0.08
    [message] = lost()
    assert "no option names them" in message["message"] and messages.elements(message) == ("", [])
    bpy.ops.tailor.add(kind="fold", source="BORDERS", name="of")
    shirt["tailor:fold:of:faces"] = "a_strip0"
    assert len(lost()) > 1, "a set that is used has messages of its own"


# Files.


def sets_of(path):
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    points = numpy.array(mesh.GetPointsAttr().Get(Usd.TimeCode.EarliestTime()))
    return {s.GetPrim().GetName(): (s.GetElementTypeAttr().Get(), points[list(s.GetIndicesAttr().Get())]) for s in UsdGeom.Subset.GetAllGeomSubsets(mesh)}


def test_every_export_carries_seams_and_sets(tmp_path):
    ob = garment.shirt(armature=False, shape_key=False)
    path = tmp_path / "plain.usdc"
    bpy.ops.wm.usd_export(filepath=str(path))
    sets = sets_of(path)
    mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert {name: kind for name, (kind, _) in sets.items()} == {"Body": "face", "Collar": "face", "uv_seam": "edge", "topstitch": "edge", "cuff_faces": "face"}
    assert len(mesh.data.vertices)
    kind, ends = sets["uv_seam"]
    # Both halves have them, and each pair is an edge.
    assert (ends[:, 0] > 0).any() and (ends[:, 0] < 0).any()
    assert numpy.linalg.norm(ends[0::2] - ends[1::2], axis=1).max() < 0.2
    report = usd_tailor.build(path, tmp_path / "built.usdc", options={"seam.side.edges": "uv_seam", "fold.cuff.faces": "cuff_faces"}).report
    assert "not-carried" not in [warning["code"] for warning in report["warnings"]]


@pytest.mark.parametrize("options", [{}, {"merge_parent_xform": True}, {"export_animation": True}, {"export_subdivision": "IGNORE"}])
def test_exports_of_other_settings_carry_them_too(options, tmp_path):
    garment.shirt()
    bpy.ops.wm.usd_export(filepath=str(tmp_path / "plain.usdc"), **options)
    assert {"uv_seam", "topstitch", "cuff_faces"} <= set(sets_of(tmp_path / "plain.usdc"))


@pytest.mark.parametrize("allow_unicode", [True, False])
def test_a_recipe_names_what_is_in_the_file(allow_unicode, tmp_path):
    """Blender 4.5 writes other letters as underscores, unless it is asked not to."""
    ob = set_up(armature=False, shape_key=False)
    ob["tailor:sim:density"] = "Säume"
    bpy.ops.tailor.pin(group="Säume")
    bpy.ops.wm.usd_export(filepath=str(tmp_path / "plain.usdc"), allow_unicode=allow_unicode)
    report = usd_tailor.build(tmp_path / "plain.usdc", tmp_path / "built.usdc").report
    assert report["cloth"]["pinned"] > 30
    assert ob["tailor:sim:density"] == "Säume"


def test_an_import_brings_sets_back(tmp_path):
    ob = garment.shirt(armature=False, shape_key=False)
    seams = sum(edge.use_seam for edge in ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.edges)
    path = str(tmp_path / "plain.usdc")
    bpy.ops.wm.usd_export(filepath=path, export_subdivision="IGNORE")
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.usd_import(filepath=path)
    mesh = next(ob.data for ob in bpy.data.objects if ob.type == "MESH")
    ob = garment.shirt(armature=False, shape_key=False)
    for modifier in ob.modifiers:
        modifier.show_viewport = modifier.type == "MIRROR"
    expected = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    assert sum(edge.use_seam for edge in mesh.edges) == sum(edge.use_seam for edge in expected.edges) > 0 < seams
    for name in ("topstitch", "cuff_faces"):
        found, before = (sum(value.value for value in m.attributes[name].data) for m in (mesh, expected))
        assert found == before > 0


def test_an_import_of_a_tailored_file_leaves_no_empties_of_scopes(shirt, tmp_path):
    from pxr import Sdf, Usd, UsdGeom

    bpy.ops.tailor.pin(group="pins")
    bpy.ops.tailor.export(filepath=str(tmp_path / "garment.usdc"))
    built = str(tmp_path / "built.usdc")
    usd_tailor.build(tmp_path / "garment.usdc", built)
    stage = Usd.Stage.Open(built)
    parent = next(prim for prim in stage.Traverse() if prim.HasAttribute("primvars:tailor:bindFace")).GetParent().GetPath()
    UsdGeom.Scope.Define(stage, parent.AppendChild("mine")).GetPrim().CreateAttribute("userProperties:note", Sdf.ValueTypeNames.String).Set("kept")
    UsdGeom.Xform.Define(stage, stage.GetDefaultPrim().GetPath().AppendPath("elsewhere/physics"))
    stage.Export(str(tmp_path / "more.usdc"))
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(tmp_path / "more.usdc"), import_guide=True)
    empties = {ob.name for ob in bpy.data.objects if ob.type == "EMPTY"}
    assert "mine" in empties and sum("physics" in name for name in empties) == 1
    assert not [name for name in empties if "anchor" in name or "aterial" in name]
    assert all(not ob.parent or ob.parent.name in bpy.data.objects for ob in bpy.data.objects)
    assert len([ob for ob in bpy.data.objects if ob.type == "MESH"]) >= 2


def test_the_garment_is_exported_with_mirror_and_skin(tmp_path):
    """Blender alone leaves the Mirror modifier out of a mesh with an armature."""
    ob = active(set_up())
    ob["tailor:sim:density"] = "Säume"
    objects, names = list(bpy.data.objects), (ob.name, ob.data.name)
    path = tmp_path / "garment.usdc"
    assert bpy.ops.tailor.export(filepath=str(path)) == {"FINISHED"}
    assert list(bpy.data.objects) == objects and (ob.name, ob.data.name) == names and ob.select_get()
    ends = sets_of(path)["uv_seam"][1]
    assert (ends[:, 0] > 0.1).any() and (ends[:, 0] < -0.1).any()
    info = usd_tailor.info(path)
    report = usd_tailor.build(path, tmp_path / "built.usdc").report
    assert report["recipe"]["sim"]["density"] == "Säume" and report["recipe"]["render"]["operators"] == ["seam.sewn"]
    assert info and "skel:jointWeights" in str(info)
