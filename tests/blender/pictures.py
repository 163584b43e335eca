"""Draws the pictures of docs/blender.md: `USDTAILOR_EXTENSION=usd_tailor-0.1.0-linux-x64.zip python tests/blender/pictures.py docs/blender`."""

import sys
from pathlib import Path

import conftest
import garment

import bpy  # isort: skip
from mathutils import Vector  # isort: skip

SIZE, SAMPLES, FRAMES = 640, 48, 30


def main(folder):
    conftest.pytest_sessionstart()
    try:
        shirt = dressed(folder)
        scene_of_picture()
        draw(folder / "garment.jpg", shirt, wire=0.0022)
        draw(folder / "simulation.jpg", product("sim"), wire=0.0012)
        draw(folder / "render.jpg", product("render"))
        bpy.context.scene.frame_set(FRAMES)
        draw(folder / "shot.jpg", product("render"))
    finally:
        conftest.pytest_sessionfinish()


def dressed(folder):
    """The shirt on a body, built, simulated and driven."""
    bpy.ops.wm.read_homefile(use_empty=True)
    shirt, body = garment.shirt(subdivision=2), garment.body()
    body.modifiers.new("Collision", "COLLISION")
    body.collision.thickness_outer = 0.004
    bpy.context.view_layer.objects.active = shirt
    bpy.ops.tailor.set_up()
    bpy.ops.tailor.add(kind="seam", source="MARKED", name="sewn")
    bpy.ops.tailor.add(kind="fold", source="BORDERS", name="hem")
    shirt["tailor:fold:hem:faces"] = "rings(borders.lowest + borders.minX + borders.maxX)"
    shirt["tailor:sim:density"] = "density"
    bpy.ops.tailor.pin(group="pins")
    bpy.ops.tailor.tailor()
    bpy.ops.tailor.cloth()
    bpy.context.scene.frame_end = FRAMES
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shirt.blend"))
    bpy.ops.tailor.drive()
    return shirt


def product(kind):
    return next(ob for ob in bpy.data.objects if ob.get("tailor_kind") == kind)


def scene_of_picture():
    """A camera at three quarters, a large lamp and an even sky."""
    scene, target = bpy.context.scene, Vector((0, 0, 1.13))

    def placed(name, data, place):
        ob = bpy.data.objects.new(name, data)
        scene.collection.objects.link(ob)
        ob.location = place
        ob.rotation_euler = (target - Vector(place)).to_track_quat("-Z", "Y").to_euler()
        return ob

    scene.camera = placed("Camera", bpy.data.cameras.new("Camera"), (0.6, -1.55, 1.4))
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 60, 1.2
    placed("Lamp", lamp, (-1.5, -2, 2.6))
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky[0].default_value, sky[1].default_value = (0.75, 0.78, 0.82, 1), 0.6
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", SAMPLES, False
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 88


def draw(path, shown, wire=0.0):
    """One mesh on the body; with its edges as wire of a thickness in metres, without what subdivides it."""
    shown_before = {ob: (ob.visible_camera, ob.hide_render) for ob in bpy.data.objects if ob.type == "MESH"}
    for ob in shown_before:
        is_shown = ob == shown or ob.name == "Body"
        ob.hide_render, ob.visible_camera = not is_shown, is_shown
    subdivisions = [modifier for modifier in shown.modifiers if modifier.type == "SUBSURF"]
    materials = list(shown.data.materials)
    if wire:
        for modifier in subdivisions:
            modifier.show_render = False
        modifier = shown.modifiers.new("Wire", "WIREFRAME")
        modifier.thickness, modifier.use_replace, modifier.material_offset = wire, False, len(materials)
        for _ in materials:
            shown.data.materials.append(garment.colour_of("Wire", (0.02, 0.03, 0.06, 1)))
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    path.write_bytes(without_notes(path.read_bytes()))
    if wire:
        shown.modifiers.remove(shown.modifiers["Wire"])
        for _ in materials:
            shown.data.materials.pop()
        for modifier in subdivisions:
            modifier.show_render = True
    for ob, (camera, hidden) in shown_before.items():
        ob.visible_camera, ob.hide_render = camera, hidden


def without_notes(jpeg):
    """A JPEG file without the segments in which Blender notes paths and times of this machine."""
    kept, at = jpeg[:2], 2
    while jpeg[at + 1] != 0xDA:
        end = at + 2 + int.from_bytes(jpeg[at + 2 : at + 4])
        kept += b"" if jpeg[at + 1] in (0xE1, 0xFE) else jpeg[at:end]
        at = end
    return kept + jpeg[at:]


main(Path(sys.argv[1]).resolve())
