"""The simulation mesh and the render mesh of a garment, as objects."""

import bpy
import numpy
import pytest
from bl_ext.user_default.usd_tailor import links, messages, recipe
from loop import active, points, products, set_up, weights
from mathutils.kdtree import KDTree


@pytest.fixture
def shirt():
    ob = set_up()
    ob["tailor:sim:density"] = "Säume"
    assert bpy.ops.tailor.tailor() == {"FINISHED"}
    return ob


def test_products_lie_where_the_garment_lies_with_all_that_it_has(shirt):
    base = {group.name for group in shirt.vertex_groups}
    cage = shirt.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = numpy.array([cage.matrix_world @ vertex.co for vertex in cage.data.vertices])
    for ob in products(shirt):
        mesh = ob.data
        placed = points(ob)
        assert numpy.abs(placed.min(0) - corners.min(0)).max() < 0.01 and numpy.abs(placed.max(0) - corners.max(0)).max() < 0.01
        assert {group.name for group in ob.vertex_groups} == base
        assert [slot.material for slot in ob.material_slots] == [slot.material for slot in shirt.material_slots]
        assert [layer.name for layer in mesh.uv_layers] == ["UVMap"] and mesh.uv_layers[0].active_render
        assert [key.name for key in mesh.shape_keys.key_blocks] == ["Basis", "Wide"]
        assert {"topstitch": "EDGE", "cuff_faces": "FACE"}.items() <= {a.name: a.domain for a in mesh.attributes}.items()
        assert any(edge.use_seam for edge in mesh.edges)
        # Weights of bones are whole everywhere.
        assert numpy.abs(sum(weights(ob, bone) for bone in ("spine", "arm.L", "arm.R")) - 1).max() < 1e-3
    sim, render = products(shirt)
    assert all(len(face.vertices) == 3 for face in sim.data.polygons)
    assert sum(len(face.vertices) == 4 for face in render.data.polygons) > 0.99 * len(render.data.polygons)


def test_both_sides_of_a_mirrored_garment_have_the_same_triangles():
    """The median of the distances was a third of an edge."""
    ob = set_up(armature=False, shape_key=False)
    assert bpy.ops.tailor.tailor() == {"FINISHED"}
    sim, _ = products(ob)
    at = points(sim)
    tree = KDTree(len(at))
    for number, point in enumerate(at):
        tree.insert(point, number)
    tree.balance()
    image = [tree.find((-x, y, z)) for x, y, z in at.tolist()]
    assert max(distance for *_, distance in image) < 1e-4
    corners = numpy.array([polygon.vertices for polygon in sim.data.polygons])
    triangles = {tuple(sorted(corner)) for corner in corners.tolist()}
    twin = numpy.array([number for _, number, _ in image])
    assert {tuple(sorted(corner)) for corner in twin[corners].tolist()} == triangles


def test_each_material_keeps_its_area(shirt):
    """Within a twentieth: a render mesh is narrower at its seams, and a simulation mesh has straight edges."""

    def areas(ob):
        mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        return numpy.array([sum(face.area for face in mesh.polygons if face.material_index == slot) for slot in (0, 1)])

    expected = areas(shirt)
    for ob in products(shirt):
        assert numpy.abs(areas(ob) / expected - 1).max() < 0.05


@pytest.mark.parametrize("length", [0.012, 0.016, 0.02, 0.025, 0.03, 0.04])
def test_halves_of_a_mirror_are_flat_panels_and_the_centre_a_seam_at_every_length(length):
    """The Mirror modifier puts the UVs of both halves on one place, of opposite orientation."""
    ob = set_up(armature=False, shape_key=False)
    ob["tailor:sim:maxEdgeLength"], ob["tailor:render:level"] = length, 0
    bpy.ops.tailor.check()
    report = messages.of(ob)["report"]
    rest = report["cloth"]["rest"]
    # Front, back, sleeve, collar and pocket of each half.
    assert rest["panels"] == 10 and rest["modelled"] == 0 and rest["stretchRms"] < 0.03
    assert {"folded-uvs", "flipped-uvs", "no-pattern"}.isdisjoint(warning["code"] for warning in report["warnings"])


def test_seams_of_both_halves_are_grooves_of_the_render_mesh(shirt):
    _, render = products(shirt)
    flat = points(render)
    bpy.ops.tailor.remove(kind="seam", name="sewn")
    bpy.ops.tailor.tailor()
    assert len(points(products(shirt)[1])) != len(flat), "the seam has lines of its own"
    assert (flat[:, 0] > 0.01).sum() == (flat[:, 0] < -0.01).sum(), "the mirrored half has the same"


def test_armature_and_shape_keys_move_the_products_as_the_garment(shirt):
    armature = next(modifier.object for modifier in shirt.modifiers if modifier.type == "ARMATURE")
    shirt.data.shape_keys.key_blocks["Wide"].value = 0.0
    bpy.context.view_layer.update()
    before = [points(ob) for ob in products(shirt)]
    shirt.data.shape_keys.key_blocks["Wide"].value = 1.0
    bpy.context.view_layer.update()
    wide = [points(ob) for ob in products(shirt)]
    for old, new in zip(before, wide):
        assert numpy.ptp(new[:, 0]) >= numpy.ptp(old[:, 0]) and numpy.abs(new - old).max() > 0.02
    shirt.data.shape_keys.key_blocks["Wide"].value = 0.0
    armature.pose.bones["arm.L"].rotation_mode = "XYZ"
    armature.pose.bones["arm.L"].rotation_euler = (0.5, 0, 0)
    bpy.context.view_layer.update()
    for ob, old in zip(products(shirt), before):
        moved = numpy.linalg.norm(points(ob) - old, axis=1)
        assert moved[old[:, 0] > 0.3].min() > 0.01 and moved[old[:, 0] < -0.3].max() < 1e-4


def test_products_go_where_the_garment_goes():
    ob = set_up(armature=False, shape_key=False)
    bpy.ops.tailor.tailor()
    ob.location, ob.rotation_euler, ob.scale = (1, 2, 3), (0, 0, 1), (2, 2, 2)
    bpy.context.view_layer.update()

    def placed():
        return all(numpy.abs(numpy.array(other.matrix_world) - numpy.array(ob.matrix_world)).max() < 1e-5 for other in products(ob))

    assert placed()
    ob.keyframe_insert("location", frame=1)
    ob.location.x = 5
    ob.keyframe_insert("location", frame=10)
    bpy.context.scene.frame_set(10)
    assert placed() and products(ob)[0].matrix_world.translation.x == pytest.approx(5)
    bpy.ops.tailor.tailor()
    bpy.context.view_layer.update()
    assert placed()


def test_the_scale_is_applied_to_lengths_too():
    ob = set_up(armature=False, shape_key=False)
    before = {key: value for key, value in ob.items() if isinstance(value, float)}
    ob.scale = (0.1, 0.1, 0.1)
    bpy.ops.tailor.apply_scale()
    assert tuple(ob.scale) == (1, 1, 1) and ob["tailor:sim:maxEdgeLength"] == pytest.approx(before["tailor:sim:maxEdgeLength"] / 10)
    assert ob["tailor:seam:sewn:width"] == pytest.approx(before["tailor:seam:sewn:width"] / 10)
    assert ob["tailor:seam:sewn:asymmetry"] == before["tailor:seam:sewn:asymmetry"]
    bpy.ops.tailor.check()
    assert not messages.of(ob)["failed"]


@pytest.mark.parametrize("scale", [1, 0.25])
def test_a_new_seam_has_real_sizes(scale):
    ob = set_up(armature=False, shape_key=False)
    ob.scale = (scale, scale, scale)
    bpy.context.view_layer.update()
    recipe.add_operator(ob, "seam", "new", "seams()")
    width = min(recipe.mean_edge_length(ob) / 4, 0.005 / scale)
    depth = -ob["tailor:seam:new:normalOffset"]
    # Both are written with two digits.
    assert (ob["tailor:seam:new:width"], depth) == (pytest.approx(width, rel=0.05), pytest.approx(width / 5, rel=0.05))


def test_subdivision_is_last_and_has_the_levels_that_are_left(shirt):
    shirt.modifiers["Subdivision"].levels, shirt.modifiers["Subdivision"].render_levels = 2, 3
    bpy.ops.tailor.tailor()
    sim, render = products(shirt)
    assert [modifier.type for modifier in sim.modifiers] == ["ARMATURE"]
    assert [modifier.type for modifier in render.modifiers] == ["ARMATURE", "SUBSURF"]
    assert (render.modifiers[-1].levels, render.modifiers[-1].render_levels) == (1, 2), "one level is built"


def test_again_keeps_the_objects_and_what_the_user_gave_them(shirt):
    sim, render = products(shirt)
    render.modifiers.new("Mine", "SMOOTH").vertex_group = "pins"
    shirt["tailor:render:level"] = 2
    bpy.ops.tailor.tailor()
    assert products(shirt) == [sim, render] and render.modifiers["Mine"].vertex_group == "pins"
    assert len([ob for ob in bpy.data.objects if links.OF in ob]) == 2
    assert len(bpy.data.meshes) == 3, "no mesh is left over"


def test_edit_mode_is_built_as_it_is_and_stays(shirt):
    before = points(products(shirt)[1])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0, 0, 0.1))
    bpy.ops.tailor.tailor()
    assert shirt.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert numpy.abs(points(products(shirt)[1])[:, 2].max() - before[:, 2].max() - 0.1) < 1e-3


def test_a_product_that_is_edited_is_not_replaced(shirt):
    _, render = products(shirt)
    active(render)
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Shirt_render is in Edit Mode"):
        bpy.ops.tailor.tailor()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.tailor.tailor() == {"FINISHED"}


def test_a_fault_changes_nothing_and_names_its_remedy(shirt):
    before = [points(ob) for ob in products(shirt)]
    shirt["tailor:sim:density"] = "nothing"
    with pytest.raises(RuntimeError, match="nothing"):
        bpy.ops.tailor.tailor()
    assert messages.of(shirt)["failed"]
    assert all((points(ob) == old).all() for ob, old in zip(products(shirt), before))


def test_two_garments_keep_their_own_products(shirt):
    other = active(set_up(armature=False, shape_key=False))
    bpy.ops.tailor.tailor()
    assert len({*products(shirt), *products(other)}) == 4


def test_without_the_extension_nothing_is_lost(shirt, extension, tmp_path):
    """What Blender itself keeps in a file: options, objects, groups and keys."""
    before = dict(shirt.items())
    path = str(tmp_path / "shirt.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    extension.unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        opened = bpy.data.objects["Shirt"]
        assert dict(opened.items()) == before
        assert {ob.name for ob in bpy.data.objects} >= {"Shirt", "Shirt_sim", "Shirt_render"}
        # A plain export carries the recipe.
        bpy.ops.wm.usd_export(filepath=str(tmp_path / "plain.usda"))
        assert 'string tailor:seam:sewn:edges = "uv_seam"' in (tmp_path / "plain.usda").read_text("utf-8")
    finally:
        extension.register()


def test_pictures_have_the_render_mesh_and_exports_have_all(shirt, tmp_path):
    assert [ob.visible_camera for ob in (shirt, *products(shirt))] == [False, False, True]
    bpy.ops.wm.usd_export(filepath=str(tmp_path / "all.usda"))
    text = (tmp_path / "all.usda").read_text("utf-8")
    assert all(f'def Mesh "{name}"' in text for name in ("Shirt", "Shirt_sim", "Shirt_render"))
    bpy.ops.tailor.clear()
    assert shirt.visible_camera and not [ob for ob in bpy.data.objects if links.OF in ob] and not list(bpy.data.collections)


def test_undo_is_one_step(shirt):
    bpy.ops.ed.undo_push(message="before")
    count = len(points(products(shirt)[1]))
    shirt["tailor:render:level"] = 2
    bpy.ops.ed.undo_push(message="level")
    bpy.ops.tailor.tailor("EXEC_DEFAULT", True)
    assert len(points(products(bpy.data.objects["Shirt"])[1])) != count
    bpy.ops.ed.undo()
    undone = bpy.data.objects["Shirt"]
    assert len(products(undone)[1].data.vertices) == count and undone["tailor:render:level"] == 2
