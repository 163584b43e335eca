"""Blender's own cloth on the simulation mesh, and the render mesh that follows it."""

from pathlib import Path

import bpy
import garment
import numpy
import pytest
from bl_ext.user_default.usd_tailor import cloth
from loop import points, products, set_up, weights
from mathutils import Matrix

FRAMES = 10
MILLIMETRE = 0.001


@pytest.fixture
def dressed(tmp_path):
    """A shirt on a body, with cloth, in a file."""
    ob = set_up()
    ob.data.shape_keys.key_blocks["Wide"].value = 1.0
    body = garment.body()
    body.modifiers.new("Collision", "COLLISION")
    body.collision.thickness_outer = 0.004
    bpy.ops.tailor.pin(group="pins")
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.ops.tailor.tailor()
    assert bpy.ops.tailor.cloth() == {"FINISHED"}
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shirt.blend"))
    return ob


def at(ob, frame):
    bpy.context.scene.frame_set(frame)
    return points(ob)


def test_cloth_has_fabric_pins_and_attachments(dressed):
    sim, _ = products(dressed)
    settings = sim.modifiers[cloth.MODIFIER].settings
    assert settings.vertex_group_mass == cloth.PIN_GROUP and settings.mass > 0
    loose = [edge for edge in sim.data.edges if edge.is_loose]
    assert len(loose) > 20 and [modifier.type for modifier in sim.modifiers] == ["ARMATURE", "CLOTH"]
    soft = settings.bending_stiffness
    dressed["tailor:cloth:fabric"] = "leather"
    bpy.ops.tailor.tailor()
    assert settings.bending_stiffness == soft, "what is set up stays the user's"
    assert len([edge for edge in sim.data.edges if edge.is_loose]) == len(loose), "a new mesh is prepared again"
    sim.modifiers.remove(sim.modifiers[cloth.MODIFIER])
    bpy.ops.tailor.cloth()
    assert sim.modifiers[cloth.MODIFIER].settings.bending_stiffness > 10 * soft


def test_a_pocket_stays_in_its_place_on_moving_cloth(dressed):
    """The distance of each of its border points from the three points that hold it, after as many frames."""
    sim, _ = products(dressed)
    pairs = numpy.array(sim[cloth.FACTS]["sewing"]).reshape(-1, 2)
    rest, moved = at(sim, 1), at(sim, FRAMES)
    assert numpy.linalg.norm(moved - rest, axis=1).max() > 5 * MILLIMETRE, "the cloth moves"

    def lengths(positions):
        return numpy.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)

    assert len(pairs) and numpy.abs(lengths(moved) - lengths(rest)).max() < 2 * MILLIMETRE


def test_pinned_points_follow_the_armature_and_nothing_else(dressed):
    sim, _ = products(dressed)
    held = numpy.flatnonzero(weights(sim, cloth.PIN_GROUP) > 0.999)
    assert len(held) > 30 and numpy.abs(at(sim, FRAMES)[held] - at(sim, 1)[held]).max() < 0.1 * MILLIMETRE


def test_the_render_mesh_follows_the_cloth(dressed):
    sim, render = products(dressed)
    assert bpy.ops.tailor.drive() == {"FINISHED"}
    assert [modifier.type for modifier in render.modifiers] == ["ARMATURE", "NODES", "MESH_SEQUENCE_CACHE", "SUBSURF"]
    for frame in (1, FRAMES // 2, FRAMES):
        bpy.context.scene.frame_set(frame)
        below, above = points(sim), points(render)
        # Each point of a seam or hem is near a vertex of the mesh that moves it.
        chosen = above[:: max(1, len(above) // 300)]
        nearest = numpy.linalg.norm(chosen[:, None] - below[None], axis=2).min(axis=1)
        assert nearest.max() < 0.03
    first, last = at(render, 1), at(render, FRAMES)
    assert numpy.linalg.norm(last - first, axis=1).max() > 10 * MILLIMETRE


def test_a_shot_opens_without_the_extension(dressed, extension):
    bpy.ops.tailor.drive()
    _, render = products(dressed)
    expected, path = at(render, FRAMES), bpy.data.filepath
    bpy.ops.wm.save_mainfile()
    extension.unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        render = bpy.data.objects["Shirt_render"]
        assert numpy.abs(at(render, FRAMES) - expected).max() < 1e-5
    finally:
        extension.register()
    folder = Path(path).with_name("shirt_tailor")
    assert [file.name for file in folder.iterdir()] == ["Shirt.usdc"]


def test_a_file_that_is_moved_with_its_folder_plays(dressed, tmp_path):
    bpy.ops.tailor.drive()
    expected = at(products(dressed)[1], FRAMES)
    bpy.ops.wm.save_mainfile()
    (tmp_path / "elsewhere").mkdir()
    for name in ("shirt.blend", "shirt_tailor"):
        (tmp_path / name).rename(tmp_path / "elsewhere" / name)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "elsewhere/shirt.blend"))
    assert numpy.abs(at(bpy.data.objects["Shirt_render"], FRAMES) - expected).max() < 1e-5


def test_garments_whose_names_are_one_in_usd_have_caches_of_their_own(dressed):
    bpy.context.scene.frame_end = 2
    dressed.name = "a b"
    bpy.ops.tailor.drive()
    other = set_up(armature=False, shape_key=False)
    other.name = "a_b"
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.drive()
    assert len({cache.filepath for cache in bpy.data.cache_files}) == 2


def test_other_frames_than_those_of_the_cloth_are_simulated_too(dressed):
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 101, 106
    bpy.ops.tailor.drive()
    _, render = products(dressed)
    assert numpy.abs(at(render, 106) - at(render, 101)).max() > MILLIMETRE


def test_the_unit_of_the_scene_does_not_change_the_cloth(dressed):
    sim, _ = products(dressed)
    mass = sim.modifiers[cloth.MODIFIER].settings.mass * len(sim.data.vertices)
    sim.modifiers.remove(sim.modifiers[cloth.MODIFIER])
    # The same shirt, in centimetres.
    bpy.context.scene.unit_settings.scale_length = 0.01
    dressed.data.transform(Matrix.Scale(100, 4), shape_keys=True)
    for key in ("tailor:sim:maxEdgeLength", "tailor:seam:sewn:width", "tailor:seam:sewn:normalOffset"):
        dressed[key] *= 100
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    modifier = sim.modifiers[cloth.MODIFIER]
    assert modifier.settings.mass * len(sim.data.vertices) == pytest.approx(mass, rel=0.02)
    assert modifier.collision_settings.distance_min == pytest.approx(0.3)


def test_drive_again_replaces_the_cache_and_the_frame_stays(dressed):
    _, render = products(dressed)
    bpy.context.scene.frame_set(3)
    bpy.ops.tailor.drive()
    bpy.ops.tailor.drive()
    assert bpy.context.scene.frame_current == 3 and len(bpy.data.cache_files) == 1
    assert sum(modifier.type == "MESH_SEQUENCE_CACHE" for modifier in render.modifiers) == 1


def test_a_garment_that_has_changed_is_not_driven(dressed):
    dressed["tailor:sim:maxEdgeLength"] = 0.028
    bpy.context.scene.frame_set(4)
    with pytest.raises(RuntimeError, match="Press Tailor, and simulate again"):
        bpy.ops.tailor.drive()
    assert bpy.context.scene.frame_current == 4


def test_a_file_that_was_never_saved_is_told_so():
    set_up(armature=False, shape_key=False)
    bpy.ops.tailor.tailor()
    with pytest.raises(RuntimeError, match="Save the .blend first"):
        bpy.ops.tailor.drive()
