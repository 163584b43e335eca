# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams and folds of a garment, and the edges and faces that they are on."""

import bmesh
import bpy
import numpy as np
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import cloth, names, recipe
from .cage import column
from .job import Refused
from .links import garment_of
from .operators import OfGarment

WORDS = {"seam": "edges", "fold": "faces"}

# Where the elements of a new seam or fold come from: label, description, and the expression for the name that is chosen. Functions have
# parentheses, as a set of the garment hides a bare one of its name.
SOURCES = {
    "seam": {
        "SELECTED": ("Selected Edges", "The edges that are selected in Edit Mode", None),
        "MARKED": ("Marked Seams", "All edges that are marked as seams, now and later", names.SEAMS),
        "UV": ("UV Seams", "All edges at which the UV map is cut", "uvSeams({})"),
        "SHARP": ("Sharp Edges", "All edges that are marked sharp", "sharp_edge"),
        "BORDERS": ("Borders", "All open edges of the mesh", "borders()"),
        "MATERIAL": ("Border of Material", "The border of the faces with the active material", "border(material({}))"),
        "GROUP": ("Vertex Group", "The edges whose two vertices are in the active group by more than a half", "edges(weight({}))"),
    },
    "fold": {
        "SELECTED": ("Selected Faces", "The faces that are selected in Edit Mode", None),
        "BORDERS": ("Along Borders", "Two rows of faces along all open edges of the mesh", "rings(borders(), 2)"),
        "MATERIAL": ("Material", "The faces with the active material", "material({})"),
        "GROUP": ("Vertex Group", "The faces whose vertices are all in the active group by more than a half", "faces(weight({}))"),
    },
}


def _items(self, _context):
    return [(key, label, about) for key, (label, about, _) in SOURCES[self.kind].items()]


class Edit(OfGarment):
    """An operator that changes the recipe, which Live then builds."""

    def change(self, garment) -> None:
        raise NotImplementedError

    def act(self, context, garment) -> None:
        self.change(garment)
        garment.update_tag()


class TAILOR_OT_add(Edit, bpy.types.Operator):
    bl_idname = "tailor.add"
    bl_label = "Add"
    bl_description = "Adds a seam or a fold"

    kind: StringProperty(default="seam")
    source: EnumProperty(items=_items)
    name: StringProperty(default="", description="Name; empty for one that is free")

    @classmethod
    def description(cls, _context, properties):
        return SOURCES[properties.kind][properties.source][1]

    def change(self, garment) -> None:
        taken = {name for _, name in recipe.operators(garment)}
        name = checked(names.unique(names.usd_name(self.name or self.kind), taken))
        recipe.add_operator(garment, self.kind, name, self._expression(garment, name))

    def _expression(self, garment, name: str) -> str:
        """The sets of the new seam or fold."""
        if garment.mode == "EDIT":
            garment.update_from_editmode()
        expression = SOURCES[self.kind][self.source][2]
        if expression is None:
            assign(garment, self.kind, name)
            return set_name(name)
        if self.source == "MARKED" and not column(garment.data.edges, "use_seam", kind=np.bool_).any():
            raise Refused("No edges are marked as seams. Select some in Edit Mode, and choose Edge > Mark Seam")
        if self.source == "UV" and not garment.data.uv_layers:
            raise Refused("The garment has no UV map. Unwrap it in Edit Mode: UV > Unwrap")
        if self.source == "SHARP" and "sharp_edge" not in garment.data.attributes:
            raise Refused("No edges are marked sharp. Select some in Edit Mode, and choose Edge > Mark Sharp")
        if self.source == "MATERIAL" and not garment.active_material:
            raise Refused("The garment has no active material. Give it one, and assign it to faces")
        if self.source == "GROUP" and not garment.vertex_groups.active:
            raise Refused("The garment has no active vertex group. Add one, and paint it")
        if self.source == "UV":
            return expression.format(names.quoted(garment.get(names.key("sim", "uvSet"), "") or names.UV_SET))
        if self.source == "MATERIAL":
            return expression.format(names.quoted(names.usd_name(garment.active_material.name)))
        if self.source == "GROUP":
            primvars = recipe.group_primvars([group.name for group in garment.vertex_groups])
            return expression.format(names.quoted(primvars[garment.vertex_groups.active.name]))
        return expression


def checked(name: str) -> str:
    """The name, if Blender has room for it."""
    if len(name.encode()) > names.LONGEST:
        raise Refused(f"The name has {len(name.encode())} bytes, and at most {names.LONGEST} fit. Choose a shorter one")
    return name


def set_name(name: str) -> str:
    """The attribute that holds the elements of a seam or fold."""
    return f"{name}_set"


def assign(garment, kind: str, name: str) -> None:
    """Makes the elements that are selected in Edit Mode the set of a seam or fold."""
    rows = ()
    # Outside of Edit Mode a selection is not seen, and all of a new mesh is selected.
    if garment.mode == "EDIT":
        edited = bmesh.from_edit_mesh(garment.data)
        rows = getattr(edited, WORDS[kind])
    if not any(element.select for element in rows):
        raise Refused(f"No {WORDS[kind]} are selected. Select some in Edit Mode, and press this there")
    layer = rows.layers.bool.get(set_name(name)) or rows.layers.bool.new(set_name(name))
    for element in rows:
        element[layer] = element.select
    bmesh.update_edit_mesh(garment.data, loop_triangles=False, destructive=False)


class OfOperator(Edit):
    kind: StringProperty()
    name: StringProperty()


class TAILOR_OT_remove(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.remove"
    bl_label = "Remove"
    bl_description = "Removes this seam or fold. Its edges or faces stay as an attribute of the mesh"

    def change(self, garment) -> None:
        recipe.remove_operator(garment, self.kind, self.name)


class TAILOR_OT_move(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.move"
    bl_label = "Move"
    bl_description = "Changes when this seam or fold is made"

    by: IntProperty()

    def change(self, garment) -> None:
        recipe.move_operator(garment, self.kind, self.name, self.by)


class TAILOR_OT_rename(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.rename"
    bl_label = "Rename"
    bl_description = "Renames this seam or fold"
    bl_property = "new_name"

    new_name: StringProperty(name="Name")

    def invoke(self, context, _event):
        self.new_name = self.name
        return context.window_manager.invoke_props_dialog(self)

    def change(self, garment) -> None:
        recipe.rename_operator(garment, self.kind, self.name, checked(names.usd_name(self.new_name)))


class TAILOR_OT_assign(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.assign"
    bl_label = "Assign Selected"
    bl_description = "Puts this seam or fold on the elements that are selected in Edit Mode, in place of those that it is on"

    def change(self, garment) -> None:
        assign(garment, self.kind, self.name)
        recipe.put(garment, recipe.option(self.kind, recipe.SETS[self.kind]), set_name(self.name), self.name)


class TAILOR_OT_select(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.select"
    bl_label = "Select"
    bl_description = "Selects the edges or faces of this seam or fold in Edit Mode"

    kind: StringProperty()
    name: StringProperty()

    def act(self, context, garment) -> None:
        from .find import select_set

        count, _ = select_set(garment, self.kind, self.name)
        self.report({"INFO"}, f"{count} {WORDS[self.kind]}")


class TAILOR_OT_choose(Edit, bpy.types.Operator):
    bl_idname = "tailor.choose"
    bl_label = "Choose"
    bl_description = "Sets this option"

    key: StringProperty()
    value: StringProperty()

    def change(self, garment) -> None:
        garment[self.key] = self.value


class TAILOR_OT_add_option(Edit, bpy.types.Operator):
    bl_idname = "tailor.add_option"
    bl_label = "Change Option"
    bl_description = "Gives the garment this option, to be changed"

    key: StringProperty()

    @classmethod
    def description(cls, _context, properties):
        return recipe.option(*properties.key.split(".")).meaning.replace("`", "")

    def change(self, garment) -> None:
        of = recipe.option(*self.key.split("."))
        recipe.put(garment, of, ", ".join(of.default) if isinstance(of.default, list) else of.default)


def _groups(_self, context):
    garment = garment_of(context.active_object)
    groups = [(group.name, group.name, "Vertices are held as far as their weight") for group in garment.vertex_groups] if garment else []
    # Blender keeps no copy of texts of items.
    TAILOR_OT_pin.shown = [("NONE", "None", "Nothing is held"), *groups]
    return TAILOR_OT_pin.shown


class TAILOR_OT_pin(Edit, bpy.types.Operator):
    bl_idname = "tailor.pin"
    bl_label = "Pin Group"
    bl_description = "The vertex group that holds the cloth"

    group: EnumProperty(items=_groups)

    def change(self, garment) -> None:
        primvars = recipe.group_primvars([group.name for group in garment.vertex_groups])
        value = cloth.WEIGHT.format(names.quoted(primvars[self.group])) if self.group != "NONE" else ""
        recipe.put(garment, recipe.option("cloth", "pins"), value)


CLASSES = (
    TAILOR_OT_add,
    TAILOR_OT_remove,
    TAILOR_OT_move,
    TAILOR_OT_rename,
    TAILOR_OT_assign,
    TAILOR_OT_select,
    TAILOR_OT_choose,
    TAILOR_OT_add_option,
    TAILOR_OT_pin,
)
