# SPDX-License-Identifier: GPL-3.0-or-later
"""Tailoring a garment: build, live, check and export."""

import bpy
from bpy.props import IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import live, messages, recipe
from .job import Failed, Job, Refused
from .links import garment_of, product, set_rendered


class OfGarment:
    """An operator on the active garment, or on the garment of the active product."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        garment = garment_of(context.active_object)
        if recipe.is_garment(garment) and garment.library:
            cls.poll_message_set(f"{garment.name} is linked from another file. Make it local, or a library override")
            return False
        if recipe.is_garment(garment):
            return True
        cls.poll_message_set("Select a garment: a mesh that Set Up Garment was pressed for")
        return False

    def act(self, context, garment) -> None:
        """Does the work. Raises Refused or Failed where it cannot be done."""
        raise NotImplementedError

    def execute(self, context):
        garment = garment_of(context.active_object)
        try:
            self.act(context, garment)
        except Failed as failed:
            return self.refuse(garment, failed.messages)
        except Refused as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        return {"FINISHED"}

    def refuse(self, garment, faults: list[dict]):
        """Shows why nothing was done, in the panel too if the garment is there."""
        if garment:
            messages.set_faults(garment, faults)
        self.report({"ERROR"}, faults[0]["message"])
        return {"CANCELLED"}


class Waiting(OfGarment):
    """An operator that works beside Blender, with progress; the escape key cancels it. Called by a script, it waits."""

    def begin(self, context, garment):
        """What runs. Raises Failed where it cannot."""
        raise NotImplementedError

    def advance(self, context, work) -> bool:
        """Goes a step; True when all is done."""
        raise NotImplementedError

    def act(self, context, garment) -> None:
        work = self.begin(context, garment)
        try:
            while not self.advance(context, work):
                pass
        finally:
            work.cancel()

    def invoke(self, context, _event):
        garment = garment_of(context.active_object)
        try:
            self.work = self.begin(context, garment)
        except Failed as failed:
            return self.refuse(garment, failed.messages)
        self.timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.progress_begin(0, 1)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.report({"INFO"}, "Cancelled: nothing was changed")
            return self._end(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(getattr(self.work, "progress", 0.5))
        try:
            return self._end(context, {"FINISHED"}) if self.advance(context, self.work) else {"RUNNING_MODAL"}
        except Failed as failed:
            return self._end(context, self.refuse(self.work.garment, failed.messages))
        except Exception:
            self._end(context, {"CANCELLED"})
            raise

    def _end(self, context, result):
        self.work.cancel()
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        return result


class TAILOR_OT_set_up(bpy.types.Operator):
    bl_idname = "tailor.set_up"
    bl_label = "Set Up Garment"
    bl_description = "Makes this mesh a garment: its options become custom properties of the object"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        ob = context.active_object
        return ob is not None and ob.type == "MESH" and not recipe.is_garment(garment_of(ob))

    def execute(self, context):
        recipe.set_up(context.active_object)
        return {"FINISHED"}


class TAILOR_OT_clear(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.clear"
    bl_label = "Remove Garment"
    bl_description = "Removes the options of this garment, and its simulation and render meshes. The garment itself stays"

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def act(self, context, garment) -> None:
        from .products import remove

        live.follow(garment, False)
        remove(garment)
        recipe.clear(garment)
        set_rendered(garment, True)


class TAILOR_OT_tailor(Waiting, bpy.types.Operator):
    bl_idname = "tailor.tailor"
    bl_label = "Tailor"
    bl_description = "Makes the simulation mesh and the render mesh of the garment, or makes them again"

    def begin(self, context, garment):
        self.is_first = product(garment, "render") is None
        return Job(garment)

    def advance(self, context, work):
        if not work.is_done():
            return False
        report, garment = work.finish(), work.garment
        if self.is_first:
            # The render mesh is in its place.
            set_rendered(garment, False)
        messages.set_report(garment, report)
        count = len(report["warnings"])
        text = f"{report['sim']['faces']:,} triangles to simulate, {report['render']['faces']:,} faces to render"
        self.report({"WARNING" if count else "INFO"}, text + (f"; {count} messages under Check" if count else ""))
        return True


class TAILOR_OT_live(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.live"
    bl_label = "Live"
    bl_description = "While it is on, each edit of the garment and of its options is built in the background"
    bl_options = {"REGISTER"}

    def act(self, context, garment) -> None:
        live.follow(garment, not live.is_live(garment))


class TAILOR_OT_check(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.check"
    bl_label = "Check"
    bl_description = "Builds the garment without making its objects, and lists what could be better"
    bl_options = {"REGISTER"}

    def act(self, context, garment) -> None:
        job = Job(garment)
        try:
            report = job.result()
        finally:
            job.cancel()
        messages.set_report(garment, report)
        self.report({"INFO"}, f"{len(report['warnings'])} messages" if report["warnings"] else "Nothing to mend")


class TAILOR_OT_select_message(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.select_message"
    bl_label = "Show in Edit Mode"
    bl_description = "Selects the elements of the garment that this message names"

    number: IntProperty()

    def act(self, context, garment) -> None:
        found = messages.of(garment)["messages"]
        if self.number >= len(found):
            raise Refused("This message is of an earlier build. Press Check")
        kind, _ = messages.elements(found[self.number])
        count, lost = messages.select(garment, found[self.number])
        self.report({"INFO"}, f"{count} {kind}" + (f"; {lost} more are made by modifiers" if lost else ""))


class TAILOR_OT_export(OfGarment, ExportHelper, bpy.types.Operator):
    bl_idname = "tailor.export"
    bl_label = "Export Garment"
    bl_description = "Writes the garment as USD, with its sets and its recipe, for usdtailor and other programs"
    bl_options = {"REGISTER"}

    filename_ext = ".usdc"
    filter_glob: StringProperty(default="*.usd;*.usda;*.usdc", options={"HIDDEN"})

    def act(self, context, garment) -> None:
        from .export import write

        try:
            write(garment, self.filepath)
        except RuntimeError as error:
            raise Refused(f"{self.filepath} cannot be written: {error}") from None


class TAILOR_OT_apply_scale(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.apply_scale"
    bl_label = "Apply Scale"
    bl_description = "Applies the scale of the object to its mesh, and to the lengths of the recipe"

    def act(self, context, garment) -> None:
        scale = recipe.apply_scale(garment)
        if scale is None:
            raise Refused("The scale differs by axis, or the mesh has other users. Apply it by Object > Apply > Scale, and set the lengths")
        self.report({"INFO"}, f"Mesh and lengths are multiplied by {scale:g}")


class TAILOR_OT_show(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.show"
    bl_label = "Show"
    bl_description = "Shows or hides this mesh in the viewport"

    kind: StringProperty()

    def act(self, context, garment) -> None:
        ob = garment if self.kind == "model" else product(garment, self.kind)
        if ob:
            ob.hide_set(not ob.hide_get())
        if ob and self.kind == "render" and not ob.hide_get():
            # A bake to shape keys left it out of pictures.
            ob.hide_render = False


CLASSES = (
    TAILOR_OT_set_up,
    TAILOR_OT_clear,
    TAILOR_OT_tailor,
    TAILOR_OT_live,
    TAILOR_OT_check,
    TAILOR_OT_select_message,
    TAILOR_OT_export,
    TAILOR_OT_apply_scale,
    TAILOR_OT_show,
)
