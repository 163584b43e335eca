# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth on the simulation mesh: set up, look at it, and have the render mesh follow."""

import bpy
from bpy.props import StringProperty

from . import bind, bodies, cloth, crossings, drive, follow
from .job import Refused
from .links import product
from .operators import OfGarment, Waiting


def made(garment) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The simulation mesh and the render mesh."""
    sim, render = product(garment, "sim"), product(garment, "render")
    if not sim or not render:
        raise Refused(f"{garment.name} has no simulation mesh yet. Press Tailor first")
    return sim, render


class TAILOR_OT_cloth(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.cloth"
    bl_label = "Set Up Cloth"
    bl_description = "Gives the simulation mesh a Cloth modifier with fabric, pins and springs, bodies below it a Collision modifier, and lets the render mesh follow"

    def act(self, context, garment) -> None:
        sim, render = made(garment)
        is_new = not cloth.is_set_up(sim)
        done = cloth.set_up(garment, sim)
        if is_new:
            done += "; " + bodies.set_up(sim)
        if bind.is_filled(render) and drive.MODIFIER not in render.modifiers:
            follow.add(render, sim)
        self.report({"INFO"}, done)


class TAILOR_OT_collide(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.collide"
    bl_label = "Collide"
    bl_description = "The cloth collides with this object, or does not"

    name: StringProperty()

    def act(self, context, garment) -> None:
        ob = next((ob for ob in bodies.around(made(garment)[0]) if ob.name == self.name), None)
        if ob is None:
            raise Refused(f"{self.name} is not at the garment")
        if not bodies.is_editable(ob):
            raise Refused(bodies.LINKED.format(ob.name))
        bodies.collide(ob, not bodies.is_collider(ob))


class TAILOR_OT_follow(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.follow"
    bl_label = "Follow Cloth"
    bl_description = "The render mesh follows the simulation mesh while the cloth plays, in place of the cache of Drive Render Mesh"

    def act(self, context, garment) -> None:
        sim, render = made(garment)
        if not bind.is_filled(render):
            raise Refused(f"{render.name} is of an earlier version of the extension. Press Tailor first")
        is_on = not follow.is_on(render)
        if is_on:
            follow.add(render, sim)
        for name, is_shown in ((follow.MODIFIER, is_on), (drive.MODIFIER, not is_on)):
            follow.show(render, name, is_shown)


class OfFrames(Waiting):
    """Simulates frames of the scene."""

    kind = drive.Preview

    def begin(self, context, garment):
        return self.kind(garment, context.scene)

    def advance(self, context, work):
        is_done = work.step()
        if is_done:
            text, is_worse = crossings.told(product(work.garment, "sim"))
            self.report({"WARNING" if is_worse else "INFO"}, f"{work.result}; {text}")
        return is_done


class TAILOR_OT_preview(OfFrames, bpy.types.Operator):
    bl_idname = "tailor.preview"
    bl_label = "Quick Look"
    bl_description = "Simulates the first ten frames of the scene, and stays at the last"

    kind = drive.Preview


class TAILOR_OT_drive(OfFrames, bpy.types.Operator):
    bl_idname = "tailor.drive"
    bl_label = "Drive Render Mesh"
    bl_description = "Simulates the frame range, and moves the render mesh with it by a cache beside the .blend"

    kind = drive.Drive


class TAILOR_OT_bake(OfFrames, bpy.types.Operator):
    bl_idname = "tailor.bake"
    bl_label = "Bake to Shape Keys"
    bl_description = "Simulates the frame range, and makes a copy of the render mesh with a shape key for each frame, for games and other programs"

    kind = drive.Bake


CLASSES = (
    TAILOR_OT_cloth,
    TAILOR_OT_collide,
    TAILOR_OT_follow,
    TAILOR_OT_preview,
    TAILOR_OT_drive,
    TAILOR_OT_bake,
)
