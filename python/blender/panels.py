# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab Tailor of the sidebar. Each field is a custom property of the garment."""

import bpy

from . import bodies, cloth, crossings, follow, live, messages, names, recipe
from .links import KINDS, garment_of, product
from .sets import SOURCES

# Options that are shown at once; the panel More Options has the others.
FIRST = {"sim": ("maxEdgeLength", "minEdgeLength", "density"), "render": ("level",), "cloth": ("fabric", "pins")}
# Set by the panels in other ways, or of no use in Blender.
ELSEWHERE = {"render.operators", "cloth.physics", "cloth.pinTarget", "cloth.panels", "cloth.scene"}


class Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Tailor"

    @classmethod
    def poll(cls, context):
        return recipe.is_garment(garment_of(context.active_object))


def fields(panel, context):
    """The layout of a panel whose fields have their labels beside them, and the garment."""
    panel.layout.use_property_split = True
    panel.layout.use_property_decorate = False
    return panel.layout, garment_of(context.active_object)


class TAILOR_PT_garment(Panel, bpy.types.Panel):
    bl_label = "Garment"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context):
        layout, garment = fields(self, context)
        if not recipe.is_garment(garment):
            layout.operator("tailor.set_up", icon="MOD_CLOTH")
            return
        row = layout.row(align=True)
        row.scale_y = 1.4
        row.operator("tailor.tailor", icon="MOD_CLOTH")
        row.operator("tailor.live", icon="PLAY", depress=live.is_live(garment))
        if max(abs(scale - 1) for scale in garment.scale) > 1e-4:
            layout.operator("tailor.apply_scale", text=f"Lengths are before the scale: apply {garment.scale[0]:.3g}", icon="INFO")
        for group in ("sim", "render"):
            for key in FIRST[group]:
                draw_option(layout, garment, recipe.option(group, key))
        _draw_products(layout, garment)
        layout.operator("tailor.export", icon="EXPORT")
        layout.operator("tailor.clear", icon="X")


def _draw_products(layout, garment) -> None:
    row = layout.row(align=True)
    for kind, label in (("model", "Garment"), ("sim", "Simulation"), ("render", "Render")):
        ob = garment if kind == "model" else product(garment, kind)
        part = row.row(align=True)
        part.enabled = ob is not None
        part.operator("tailor.show", text=label, depress=bool(ob and not ob.hide_get())).kind = kind
    state = messages.of(garment)
    made = [product(garment, kind) for kind in KINDS]
    if all(made):
        triangles, faces = (f"{len(ob.data.polygons):,}" for ob in made)
        layout.label(text=f"{triangles} triangles, {faces} faces", icon="MESH_DATA")
    if state["failed"]:
        box = layout.box()
        box.alert = True
        draw_text(box, "Not built: " + messages.shown(garment, state["messages"][0]), "ERROR")


def draw_option(layout, garment, of: recipe.Option, *instance: str, text: str | None = None) -> None:
    """The field of an option that the garment has, or a button that adds it."""
    key = names.key(of.group, *instance, of.key)
    label = of.label if text is None else text
    if key not in garment:
        row = layout.row()
        row.active = False
        row.operator("tailor.add_option", text=f"{label}: {_shown(of.default)}", emboss=False, icon="ADD").key = f"{of.group}.{of.key}"
        return
    path = f'["{bpy.utils.escape_identifier(key)}"]'
    kind = of.domain["type"]
    if kind == "choice" or of.key == "fabric":
        row = layout.row(align=True)
        row.prop(garment, path, text=label)
        words = of.domain.get("words") or recipe.option("fabric", "preset").domain["words"]
        for word in words if len(words) == 2 else ():
            made = row.operator("tailor.choose", text=word, depress=garment[key] == word)
            made.key, made.value = key, word
        if len(words) > 2:
            row.menu("TAILOR_MT_fabric", text="", icon="DOWNARROW_HLT")
    elif kind == "weights":
        layout.prop_search(garment, path, garment, "vertex_groups", text=label)
    else:
        layout.prop(garment, path, text=label)


def _shown(value) -> str:
    return "none" if value in ("", [], None) else ", ".join(value) if isinstance(value, list) else str(value)


def draw_text(layout, text: str, icon: str = "NONE", width: int = 42) -> None:
    """A message over as many lines as it needs."""
    line, column = "", layout.column(align=True)
    column.scale_y = 0.75
    for word in [*text.split(), None]:
        if line and (word is None or len(line) + len(word) >= width):
            column.label(text=line, icon=icon)
            line, icon = "", "BLANK1" if icon != "NONE" else "NONE"
        line = f"{line} {word}".strip() if word else line


class TAILOR_MT_fabric(bpy.types.Menu):
    bl_label = "Fabric"

    def draw(self, _context):
        for word in recipe.option("fabric", "preset").domain["words"]:
            made = self.layout.operator("tailor.choose", text=word.capitalize())
            made.key, made.value = names.key("cloth", "fabric"), word


class AddMenu:
    """What a new seam or fold can be on."""

    def draw(self, _context):
        for source, (label, _, _) in SOURCES[self.kind].items():
            made = self.layout.operator("tailor.add", text=label)
            made.kind, made.source = self.kind, source


class TAILOR_MT_add_seam(AddMenu, bpy.types.Menu):
    bl_label = "Add Seam"
    kind = "seam"


class TAILOR_MT_add_fold(AddMenu, bpy.types.Menu):
    bl_label = "Add Fold"
    kind = "fold"


class Operators(Panel):
    """The seams or the folds, one below the other like modifiers."""

    kind = ""

    def draw(self, context):
        layout, garment = fields(self, context)
        layout.menu(f"TAILOR_MT_add_{self.kind}", icon="ADD")
        order = recipe.operators(garment)
        for place, (kind, name) in enumerate(order):
            if kind == self.kind:
                self._draw_one(layout, garment, name, place, len(order))

    def _draw_one(self, layout, garment, name: str, place: int, count: int) -> None:
        header, body = layout.panel(f"tailor_{self.kind}_{name}")
        row = header.row(align=True)
        made = row.operator("tailor.rename", text=name, emboss=False)
        made.kind, made.name = self.kind, name
        draw_option(row, garment, recipe.option(self.kind, "enabled"), name, text="")
        for by, icon, is_there in ((-1, "TRIA_UP", place > 0), (1, "TRIA_DOWN", place < count - 1)):
            part = row.row(align=True)
            part.enabled = is_there
            made = part.operator("tailor.move", text="", icon=icon, emboss=False)
            made.kind, made.name, made.by = self.kind, name, by
        made = row.operator("tailor.remove", text="", icon="X", emboss=False)
        made.kind, made.name = self.kind, name
        if body is None:
            return
        row = body.row(align=True)
        for action in ("tailor.assign", "tailor.select"):
            made = row.operator(action)
            made.kind, made.name = self.kind, name
        for of in recipe.table()[self.kind]:
            if of.key != "enabled":
                draw_option(body, garment, of, name)


class TAILOR_PT_seams(Operators, bpy.types.Panel):
    bl_label = "Seams"
    kind = "seam"


class TAILOR_PT_folds(Operators, bpy.types.Panel):
    bl_label = "Folds"
    kind = "fold"


class TAILOR_PT_cloth(Panel, bpy.types.Panel):
    bl_label = "Cloth"

    def draw(self, context):
        layout, garment = fields(self, context)
        draw_option(layout, garment, recipe.option("cloth", "fabric"))
        layout.operator_menu_enum("tailor.pin", "group", text=f"Pin group: {cloth.pin_group(garment) or 'none'}", icon="PINNED")
        draw_option(layout, garment, recipe.option("cloth", "pins"))
        layout.operator("tailor.cloth", icon="PHYSICS")
        sim, render = (product(garment, kind) for kind in KINDS)
        if sim and render and cloth.is_set_up(sim):
            _draw_settings(layout, sim)
            _draw_frames(layout, sim, render)


def _draw_settings(layout, sim) -> None:
    """What the cloth collides with, and the settings that are changed most."""
    column = layout.column(heading="Collides with")
    for ob in bodies.around(sim):
        column.operator("tailor.collide", text=ob.name, depress=bodies.is_collider(ob)).name = ob.name
    modifier = sim.modifiers[cloth.MODIFIER]
    layout.prop(modifier.collision_settings, "use_self_collision", text="Collides with itself")
    layout.prop(modifier.settings, "shrink_min", text="Shrink")


def _draw_frames(layout, sim, render) -> None:
    layout.operator("tailor.preview", icon="FRAME_NEXT")
    layout.operator("tailor.follow", icon="LINKED", depress=follow.is_on(render))
    for action, icon in (("tailor.drive", "PLAY"), ("tailor.bake", "SHAPEKEY_DATA")):
        layout.operator(action, icon=icon)
    text, is_worse = crossings.told(sim)
    if text:
        remedy = ". Raise the quality of the cloth's collisions, or their distances" if is_worse else ""
        draw_text(layout, text + remedy, "ERROR" if is_worse else "CHECKMARK")


class TAILOR_PT_check(Panel, bpy.types.Panel):
    bl_label = "Check"

    def draw(self, context):
        layout, garment = self.layout, garment_of(context.active_object)
        layout.operator("tailor.check", icon="VIEWZOOM")
        state = messages.of(garment)
        if not state["messages"] and state["report"]:
            layout.label(text="Nothing to mend", icon="CHECKMARK")
        for number, message in enumerate(state["messages"]):
            box = layout.box()
            box.alert = state["failed"]
            draw_text(box, messages.shown(garment, message), "ERROR" if state["failed"] else "INFO")
            kind, elements = messages.elements(message)
            if kind:
                made = box.operator("tailor.select_message", text=f"Select {len(elements)} {kind}", icon="RESTRICT_SELECT_OFF")
                made.number = number


class TAILOR_PT_more(Panel, bpy.types.Panel):
    bl_label = "More Options"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, garment = fields(self, context)
        for group in ("sim", "render", "cloth"):
            layout.label(text={"sim": "Simulation mesh", "render": "Render mesh", "cloth": "Cloth"}[group])
            for of in recipe.table()[group]:
                if of.key not in FIRST[group] and f"{group}.{of.key}" not in ELSEWHERE:
                    draw_option(layout, garment, of)


CLASSES = (
    TAILOR_MT_fabric,
    TAILOR_MT_add_seam,
    TAILOR_MT_add_fold,
    TAILOR_PT_garment,
    TAILOR_PT_seams,
    TAILOR_PT_folds,
    TAILOR_PT_cloth,
    TAILOR_PT_check,
    TAILOR_PT_more,
)
