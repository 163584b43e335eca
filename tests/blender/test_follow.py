"""The render mesh that follows while the cloth plays, and its bake to shape keys."""

import bpy
import garment
import numpy
import pytest
from bl_ext.user_default.usd_tailor import bind, cloth, follow, shapes
from bl_ext.user_default.usd_tailor.links import product
from loop import drawn, products, set_up

FRAMES = 6
# Numbers of 32 bits, of a shirt of a metre. [m]
ROUNDING = 2e-6


@pytest.fixture
def dressed(tmp_path):
    """A shirt with cloth on a body, in a file."""
    ob = set_up()
    ob.data.shape_keys.key_blocks["Wide"].value = 1.0
    garment.body()
    bpy.ops.tailor.pin(group="pins")
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    for modifier in products(ob)[1].modifiers:
        modifier.show_viewport = modifier.type != "SUBSURF"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shirt.blend"))
    return ob


def frames(ob):
    """The points of an object in each frame."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(drawn(ob))
    return numpy.stack(found)


def bend(ob):
    """Turns an arm far in place of the cloth, so that rotations count."""
    sim, _ = products(ob)
    sim.modifiers.remove(sim.modifiers[cloth.MODIFIER])
    armature = next(modifier.object for modifier in ob.modifiers if modifier.type == "ARMATURE")
    bone = armature.pose.bones["arm.L"]
    bone.rotation_mode = "XYZ"
    bone.keyframe_insert("rotation_euler", frame=1)
    bone.rotation_euler = (0.7, 0.4, 1.5)
    bone.keyframe_insert("rotation_euler", frame=FRAMES)


@pytest.mark.parametrize("moved", ["cloth", "arm"])
def test_the_render_mesh_follows_as_the_command_drives_it(dressed, moved):
    if moved == "arm":
        bend(dressed)
    _, render = products(dressed)
    live = frames(render)
    assert numpy.linalg.norm(live[-1] - live[0], axis=1).max() > (0.01 if moved == "cloth" else 0.2)
    bpy.ops.tailor.drive()
    assert not follow.is_on(render), "the cache takes the place of the nodes"
    assert numpy.abs(frames(render) - live).max() < ROUNDING
    bpy.ops.tailor.follow()
    assert follow.is_on(render) and not render.modifiers["Tailor Drive"].show_viewport
    assert numpy.abs(frames(render) - live).max() < ROUNDING


def test_all_garments_follow_by_one_group(dressed):
    other = set_up(armature=False, shape_key=False)
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    groups = {products(ob)[1].modifiers[follow.MODIFIER].node_group for ob in (dressed, other)}
    assert len(groups) == len(bpy.data.node_groups) == 1


@pytest.mark.parametrize("hide", ["hide_viewport", "hide_render", "eye"])
def test_a_simulation_mesh_that_is_hidden_moves_the_render_mesh(dressed, hide):
    sim, render = products(dressed)
    if hide == "eye":
        sim.hide_set(True)
    else:
        setattr(sim, hide, True)
    live = frames(render)
    assert numpy.linalg.norm(live[-1] - live[0], axis=1).max() > 0.005


def test_meshes_that_are_made_again_follow_and_settings_stay(dressed):
    sim, render = products(dressed)
    before = len(render.data.vertices)
    render.modifiers[follow.MODIFIER].show_render = False
    dressed["tailor:sim:maxEdgeLength"], dressed["tailor:render:level"] = 0.025, 2
    bpy.ops.tailor.tailor()
    assert len(render.data.vertices) > before and not render.modifiers[follow.MODIFIER].show_render
    assert [modifier.name for modifier in render.modifiers] == ["Tailor Armature", follow.MODIFIER, "Tailor Subdivision"]
    live = frames(render)
    assert numpy.linalg.norm(live[-1] - live[0], axis=1).max() > 0.005
    render.modifiers.remove(render.modifiers[follow.MODIFIER])
    bpy.ops.tailor.tailor()
    assert follow.MODIFIER not in render.modifiers, "what the user removed is not put back"


def test_a_simulation_mesh_with_other_points_moves_nothing_and_says_so(dressed):
    sim, render = products(dressed)
    for modifier in dressed.modifiers:
        modifier.show_viewport = modifier.type != "ARMATURE"
    sim.modifiers.new("Subdivided", "SUBSURF")
    bpy.context.scene.frame_set(FRAMES)
    assert numpy.isfinite(drawn(render)).all() and (drawn(render) == frames(render)[0]).all()
    warnings = [warning.message for warning in getattr(render.modifiers[follow.MODIFIER], "node_warnings", ())]
    assert not warnings or "another number of vertices" in warnings[0]


def test_the_binding_is_that_of_the_build(dressed):
    sim, render = products(dressed)
    faces = numpy.empty(len(render.data.vertices), numpy.int32)
    render.data.attributes[bind.FACE].data.foreach_get("value", faces)
    assert faces.min() >= 0 and faces.max() < len(sim.data.polygons) and len(set(faces)) > 0.9 * len(sim.data.polygons)
    hidden = {attribute.name for mesh in (sim.data, render.data) for attribute in mesh.attributes if attribute.name.startswith(".tailor")}
    assert hidden == {bind.REST, bind.UNTURN, *bind.SHARES}


def test_shape_keys_have_what_was_simulated(dressed):
    _, render = products(dressed)
    live = frames(render)
    mine = render.modifiers.new("Mine", "TRIANGULATE")
    mine.show_viewport = False
    bpy.ops.tailor.bake()
    baked = product(dressed, shapes.BAKED)
    baked_name = baked.name
    assert [modifier.type for modifier in baked.modifiers] == ["SUBSURF", "TRIANGULATE"] and render.hide_get() and render.hide_render
    assert len(baked.data.materials) == len(render.data.materials) and not render.data.shape_keys.key_blocks.get("Frame 1")
    assert numpy.abs(frames(baked) - live).max() < ROUNDING
    bpy.context.scene.frame_set(2, subframe=0.5)
    assert numpy.abs(drawn(baked) - (live[1] + live[2]) / 2).max() < ROUNDING
    bpy.ops.tailor.bake()
    assert sum(ob.get("tailor_kind") == shapes.BAKED for ob in bpy.data.objects) == 1
    assert len([action for action in bpy.data.actions if action.name.startswith(baked_name)]) == 1, "the earlier one is removed"
    bpy.ops.tailor.tailor()
    assert numpy.abs(frames(product(dressed, shapes.BAKED)) - live).max() < ROUNDING, "a new build leaves it"


def test_shape_keys_need_no_file():
    ob = set_up(armature=False, shape_key=False)
    bpy.context.scene.frame_end = 2
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    assert bpy.ops.tailor.bake() == {"FINISHED"} and product(ob, shapes.BAKED)
