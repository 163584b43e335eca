#!/usr/bin/env python3
"""Renders close-ups of a render mesh in Cycles, to look at folds and seams under light.

    lit.py PRODUCT.usdc OUT.png X,Y,Z,RADIUS AZIMUTH,ELEVATION [X,Y,Z,RADIUS AZIMUTH,ELEVATION ...]

PRODUCT is what `usdtailor build` wrote. Places are in the stage's units with Y up, angles in degrees; 0,0 looks at the front. The
surface is refined twice more for the picture. Needs Blender's module `bpy` and Pillow."""
import math
import sys
import tempfile
from pathlib import Path

import bpy
from mathutils import Matrix, Vector
from PIL import Image

SIZE, SAMPLES, FINER = 480, 24, 2                       # pixels, paths per pixel, refinements


def load(product):
    """Imports the render mesh alone, Z up."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=str(product), import_all_materials=False, import_subdivision=False)
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    shown = [o for o in meshes if o.name.split(".")[0] == "render"]
    if not shown:
        raise SystemExit(f"{product} has no mesh named `render`: build it with `usdtailor build`")
    for other in set(meshes) - set(shown):
        bpy.data.objects.remove(other)
    cloth = bpy.data.materials.new("cloth")
    cloth.use_nodes = True
    shader = cloth.node_tree.nodes["Principled BSDF"]
    for name, value in {"Base Color": (0.30, 0.33, 0.38, 1), "Roughness": 0.75, "Sheen Weight": 0.3}.items():
        shader.inputs[name].default_value = value
    for one in shown:
        one.data.materials.clear()
        one.data.materials.append(cloth)
        finer = one.modifiers.new("finer", "SUBSURF")
        finer.levels = finer.render_levels = FINER
    return shown[0]


def light():
    """A low key light that grazes the cloth, and a dim sky."""
    sun = bpy.data.lights.new("key", "SUN")
    sun.energy, sun.angle = 3.5, math.radians(4)
    key = bpy.data.objects.new("key", sun)
    bpy.context.scene.collection.objects.link(key)
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.75, 0.8, 0.9, 1)
    world.node_tree.nodes["Background"].inputs[1].default_value = 0.35
    return key


def aim(scene, key, scale, place, view):
    """Sets the camera to see a ball, with the key light from the upper left of it. `scale` is metres per unit."""
    x, y, z, radius = place
    azimuth, elevation = map(math.radians, view)
    away = Vector((math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation)))
    z_up = Matrix.Rotation(math.pi / 2, 3, "X")
    centre, back = scale * (z_up @ Vector((x, y, z))), z_up @ away
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2 * radius * scale
    camera.data.clip_end = 100 * radius * scale
    camera.location = centre + 20 * radius * scale * back
    camera.rotation_euler = back.to_track_quat("Z", "Y").to_euler()
    right = back.to_track_quat("Z", "Y") @ Vector((1, 0, 0))
    up = back.cross(right)
    key.rotation_euler = (0.45 * back - 0.8 * right + 0.6 * up).to_track_quat("Z", "Y").to_euler()


def main(product, out, *views):
    mesh = load(product)
    key, scene = light(), bpy.context.scene
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", SAMPLES, True
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    images = []
    for place, view in zip(views[::2], views[1::2]):
        aim(scene, key, mesh.matrix_world.to_scale()[0], [float(n) for n in place.split(",")], [float(n) for n in view.split(",")])
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = str(Path(folder, "one.png"))
            bpy.ops.render.render(write_still=True)
            images.append(Image.open(scene.render.filepath).convert("RGB"))
    row = Image.new("RGB", (SIZE * len(images), SIZE))
    for k, image in enumerate(images):
        row.paste(image, (k * SIZE, 0))
    row.save(out)


if __name__ == "__main__":
    if len(sys.argv) < 5 or len(sys.argv) % 2 == 0:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
