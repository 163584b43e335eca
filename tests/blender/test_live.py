"""Builds that follow edits, in the background."""

import time

import bpy
import numpy
import pytest
from bl_ext.user_default.usd_tailor import live, messages
from loop import points, products, set_up


@pytest.fixture
def shirt():
    ob = set_up(armature=False, shape_key=False)
    bpy.ops.tailor.live()
    wait(lambda: products(ob)[1] is not None)
    yield ob
    live.stop()


def wait(is_there, seconds=20.0):
    """Lets timers run, as Blender does, until something is there; returns the time that it took."""
    start = time.monotonic()
    while not is_there():
        live.tick()
        time.sleep(0.005)
        assert time.monotonic() - start < seconds, "it does not come"
    return time.monotonic() - start


def quiet(ob):
    state = live._followed.get(ob.session_uid)
    return state is None or (state.job is None and not state.is_changed)


def move(ob, by):
    ob.data.vertices[0].co.z += by
    ob.data.update()
    ob.update_tag()
    bpy.context.view_layer.update()


def test_an_edit_of_the_mesh_or_of_an_option_shows(shirt):
    wait(lambda: quiet(shirt))
    before = points(products(shirt)[1])
    move(shirt, 0.03)
    wait(lambda: quiet(shirt) and (points(products(shirt)[1]) != before).any())
    count = len(before)
    shirt["tailor:render:level"] = 2
    wait(lambda: len(points(products(shirt)[1])) != count)


def test_only_the_newest_of_many_edits_is_left(shirt):
    wait(lambda: quiet(shirt))
    place = shirt.data.vertices[0].co.z
    for step in range(20):
        move(shirt, 0.002)
        live.tick()
        time.sleep(0.01)
    wait(lambda: quiet(shirt))
    nearest = numpy.abs(points(products(shirt)[0]) - numpy.array(shirt.data.vertices[0].co)).max(axis=1).min()
    assert shirt.data.vertices[0].co.z - place == pytest.approx(0.04, abs=1e-5) and nearest < 0.012


def test_a_long_build_of_an_older_state_ends_for_the_newest(shirt):
    wait(lambda: quiet(shirt))
    shirt["tailor:sim:maxEdgeLength"] = 0.004
    state = live._followed[shirt.session_uid]
    wait(lambda: state.job is not None)
    old = state.job
    shirt["tailor:sim:maxEdgeLength"] = 0.03
    wait(lambda: quiet(shirt))
    assert old.process.poll() != 0 and len(points(products(shirt)[0])) < 5000


def test_a_build_that_shows_starts_no_other(shirt):
    wait(lambda: quiet(shirt))
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        bpy.context.view_layer.update()
        live.tick()
        assert quiet(shirt)
        time.sleep(0.02)


def test_faults_show_in_place_and_go_once_they_are_mended(shirt):
    wait(lambda: quiet(shirt))
    before = points(products(shirt)[1])
    shirt["tailor:sim:density"] = "nothing"
    wait(lambda: messages.of(shirt)["failed"])
    assert (points(products(shirt)[1]) == before).all()
    shirt["tailor:sim:density"] = ""
    wait(lambda: not messages.of(shirt)["failed"])


def test_a_garment_that_is_deleted_while_it_is_built_ends_the_build(shirt):
    wait(lambda: quiet(shirt))
    move(shirt, 0.02)
    state = live._followed[shirt.session_uid]
    wait(lambda: state.job is not None)
    job = state.job
    bpy.data.objects.remove(shirt)
    live.tick()
    assert not live._followed and job.process.poll() is not None


def test_undo_while_live_ends_with_products_of_the_garment_as_it_is(shirt):
    wait(lambda: quiet(shirt))
    bpy.ops.ed.undo_push(message="before")
    top = shirt.data.vertices[0].co.z
    move(shirt, 0.05)
    bpy.ops.ed.undo_push(message="moved")
    wait(lambda: quiet(shirt))
    bpy.ops.ed.undo()
    undone = bpy.data.objects["Shirt"]
    assert undone.data.vertices[0].co.z == pytest.approx(top) and live.is_live(undone)
    wait(lambda: quiet(undone))
    nearest = numpy.abs(points(products(undone)[0]) - numpy.array(undone.data.vertices[0].co)).max(axis=1).min()
    assert nearest < 0.01


def test_another_file_ends_all_builds(shirt):
    move(shirt, 0.02)
    wait(lambda: live._followed[shirt.session_uid].job is not None)
    job = live._followed[shirt.session_uid].job
    bpy.ops.wm.read_homefile(use_empty=True)
    assert not live._followed and job.process.poll() is not None
