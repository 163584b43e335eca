"""Cloth that is ready to play: bodies, layers, fabrics, a quick look, and crossings."""

import math

import bmesh
import bpy
import garment
import numpy
import pytest
from bl_ext.user_default.usd_tailor import bodies, cloth, crossings, links, messages
from loop import active, drawn, products, set_up, weights


def plain_shirt():
    ob = set_up(armature=False, shape_key=False)
    bpy.ops.tailor.pin(group="pins")
    bpy.ops.tailor.tailor()
    return ob


def cube(name, place, size=0.1):
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    bpy.context.object.name = name
    return bpy.context.object


def colliders():
    return {ob.name for ob in bpy.data.objects if ob.type == "MESH" and bodies.is_collider(ob)}


# Bodies.


def test_the_body_is_found_and_nothing_of_the_garment():
    other = plain_shirt()
    body, _ = garment.body(), cube("Far", (3, 0, 0))
    cube("Box around", (0, 0, 1), 4)
    shirt = active(plain_shirt())
    assert bpy.ops.tailor.cloth() == {"FINISHED"}
    assert colliders() == {"Body"} and body.collision.thickness_outer <= 0.002
    assert not any(modifier.type == "COLLISION" for ob in (shirt, other, *products(shirt), *products(other)) for modifier in ob.modifiers)


def test_what_the_user_chooses_stays():
    body, shirt = garment.body(), plain_shirt()
    cube("Belt", (0, 0, 1), 0.3)
    active(shirt)
    bpy.ops.tailor.cloth()
    bpy.ops.tailor.collide(name="Body")
    assert colliders() == {"Belt"} and not body.modifiers
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    assert colliders() == {"Belt"}
    bpy.ops.tailor.collide(name="Body")
    assert colliders() == {"Belt", "Body"}


def test_a_collision_of_the_users_own_is_kept():
    body = garment.body()
    body.modifiers.new("Mine", "COLLISION")
    body.collision.thickness_outer = 0.007
    active(plain_shirt())
    bpy.ops.tailor.cloth()
    bpy.ops.tailor.collide(name="Body")
    assert not colliders()
    bpy.ops.tailor.collide(name="Body")
    assert [modifier.name for modifier in body.modifiers] == ["Mine"] and body.collision.thickness_outer == pytest.approx(0.007)


def test_a_linked_body_is_told(tmp_path):
    garment.body()
    path = str(tmp_path / "body.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Body"]
    bpy.context.collection.objects.link(wanted.objects[0])
    sim, _ = products(active(plain_shirt()))
    bpy.context.view_layer.update()
    assert "Body is linked" in bodies.set_up(sim)
    with pytest.raises(RuntimeError, match="Body is linked"):
        bpy.ops.tailor.collide(name="Body")


# Layers.


def band(layers):
    """A collar: a band around the neck, of two layers that hang from a fold. With one layer, it stands alone."""
    bm = bmesh.new()
    rows = [(0.1, 0.0), (0.1, 0.03), (0.1, 0.06)] + [(0.104, 0.065), (0.107, 0.05), (0.107, 0.02)] * (layers > 1)
    rings = [[bm.verts.new((r * math.cos(a), r * math.sin(a), z)) for a in numpy.linspace(0, 2 * math.pi, 48, endpoint=False)] for r, z in rows]
    for low, high in zip(rings, rings[1:]):
        for i in range(48):
            bm.faces.new([low[i], low[(i + 1) % 48], high[(i + 1) % 48], high[i]])
    mesh = bpy.data.meshes.new("Collar")
    bm.to_mesh(mesh)
    ob = active_object(mesh)
    garment.set_group(ob, "low", [1.0 if v.co.z == 0 else 0.0 for v in mesh.vertices])
    ob.modifiers.new("Subdivision", "SUBSURF")
    bpy.ops.tailor.set_up()
    bpy.ops.tailor.pin(group="low")
    ob["tailor:sim:maxEdgeLength"] = 0.008
    bpy.ops.tailor.tailor()
    return ob


def active_object(mesh):
    ob = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.collection.objects.link(ob)
    return active(ob)


@pytest.mark.parametrize("layers", [1, 2])
def test_cloth_collides_with_itself_where_layers_are_near(layers):
    sim, _ = products(band(layers))
    bpy.ops.tailor.cloth()
    settings = sim.modifiers[cloth.MODIFIER].collision_settings
    assert settings.use_self_collision == (layers > 1) and settings.self_distance_min == pytest.approx(0.002)


def test_layers_of_a_collar_do_not_cross():
    sim, _ = products(band(2))
    bpy.ops.tailor.cloth()
    bpy.context.scene.frame_end = 10
    found = {}
    # A gust that blows the outer layer against the inner.
    bpy.ops.object.effector_add(type="WIND", location=(0.5, 0, 0.03), rotation=(0, -math.pi / 2, 0))
    bpy.context.object.field.strength = 3000
    active(sim)
    for is_on in (False, True):
        sim.modifiers[cloth.MODIFIER].collision_settings.use_self_collision = is_on
        bpy.ops.tailor.preview()
        found[is_on] = sim[cloth.FACTS]["crossings"][1]
    assert found[False] > 20 and found[True] < found[False] / 4


# Fabrics.


def test_parts_of_another_fabric_are_as_stiff_as_it():
    shirt = plain_shirt()
    shirt["tailor:fabric:hard:faces"], shirt["tailor:fabric:hard:preset"] = "material(Collar)", "leather"
    bpy.ops.tailor.tailor()
    assert "mean-fabric" not in {message["code"] for message in messages.of(shirt)["messages"]}
    bpy.ops.tailor.cloth()
    sim, _ = products(shirt)
    settings = sim.modifiers[cloth.MODIFIER].settings
    assert settings.bending_stiffness_max > 10 * settings.bending_stiffness > 0
    for name in (settings.vertex_group_bending, settings.vertex_group_structural_stiffness, settings.vertex_group_shear_stiffness):
        found = weights(sim, name)
        of = {slot: numpy.array([face.material_index == slot for face in sim.data.polygons]) for slot in (0, 1)}
        corners = numpy.array([face.vertices for face in sim.data.polygons])
        inner = {slot: numpy.setdiff1d(corners[of[slot]], corners[~of[slot]]) for slot in of}
        assert (found[inner[1]] > 0.99).all() and (found[inner[0]] < 0.01).all() and len(inner[1]) > 20
    settings.bending_stiffness_max = 77
    bpy.ops.tailor.cloth()
    assert settings.vertex_group_bending
    bpy.ops.tailor.tailor()
    assert settings.bending_stiffness_max == 77 and weights(sim, settings.vertex_group_bending).max() > 0.99


# Frames.


def test_a_quick_look_stays_at_its_last_frame_and_tells_crossings():
    garment.body()
    shirt = active(plain_shirt())
    with pytest.raises(RuntimeError, match="Press Set Up Cloth first"):
        bpy.ops.tailor.preview()
    bpy.ops.tailor.cloth()
    scene = bpy.context.scene
    # An import makes a scene of one frame.
    scene.frame_start = scene.frame_end = 11
    assert bpy.ops.tailor.preview() == {"FINISHED"} and scene.frame_current == 20
    sim, render = products(shirt)
    assert "at frame 20" in crossings.told(sim)[0]
    followed = drawn(render)
    scene.frame_set(11)
    assert numpy.abs(drawn(render) - followed).max() > 0.002, "the render mesh moved too"
    bpy.ops.tailor.tailor()
    assert crossings.told(sim) == ("", False), "they are of another mesh"


def test_crossings_are_pairs_of_triangles_that_share_nothing():
    points = numpy.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, -1), (0.2, 0.2, 1), (0.3, 0.9, 1), (5, 5, 5)], numpy.float32)
    assert crossings.count(points, numpy.array([(0, 1, 2), (3, 4, 5)])) == 1
    assert crossings.count(points, numpy.array([(0, 1, 2), (2, 4, 5)])) == 0
    assert crossings.count(points, numpy.array([(0, 1, 2), (4, 5, 6)])) == 0
