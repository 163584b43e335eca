# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams and folds of a garment, and the edges and faces that they are on."""

import bmesh
import bpy
import numpy as np
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import cloth, names, recipe
from .cage import column
from .links import garment_of
from .operators import OfGarment

NOTHING = "No {} are selected. Select some in Edit Mode, and press this there"
LINKED = "{} is linked from another file. Make it local first"
DOMAIN = {"seam": "EDGE", "fold": "FACE"}
WORDS = {"seam": "edges", "fold": "faces"}

# Where the elements of a new seam or fold come from: label, description, and the expression for the name that is chosen.
SOURCES = {
    "seam": {
        "SELECTED": ("Selected Edges", "The edges that are selected in Edit Mode", None),
        "MARKED": ("Marked Seams", "All edges that are marked as seams, now and later", names.SEAMS),
        "UV": ("UV Seams", "All edges at which the UV map is cut", "uvSeams"),
        "SHARP": ("Sharp Edges", "All edges that are marked sharp", "sharp_edge"),
        "BORDERS": ("Borders", "All open edges of the mesh", "borders"),
        "MATERIAL": ("Border of Material", "The border of the faces with the active material", "border(material({}))"),
        "GROUP": ("Vertex Group", "The edges whose two vertices are in the active group by more than a half", "edges(weight({}))"),
    },
    "fold": {
        "SELECTED": ("Selected Faces", "The faces that are selected in Edit Mode", None),
        "BORDERS": ("Along Borders", "Two rows of faces along all open edges of the mesh", "rings(borders, 2)"),
        "MATERIAL": ("Material", "The faces with the active material", "material({})"),
        "GROUP": ("Vertex Group", "The faces whose vertices are all in the active group by more than a half", "faces(weight({}))"),
    },
}


def _items(self, _context):
    return [(key, label, about) for key, (label, about, _) in SOURCES[self.kind].items()]


class TAILOR_OT_add(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.add"
    bl_label = "Add"
    bl_description = "Adds a seam or a fold"

    kind: StringProperty(default="seam")
    source: EnumProperty(items=_items)
    name: StringProperty(default="", description="Name; empty for one that is free")

    @classmethod
    def description(cls, _context, properties):
        return SOURCES[properties.kind][properties.source][1]

    def execute(self, context):
        garment = garment_of(context.active_object)
        taken = {name for _, name in recipe.operators(garment)}
        name = names.unique(names.usd_name(self.name or self.kind), taken)
        try:
            check_length(name)
            expression = self._expression(garment, name)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        recipe.add_operator(garment, self.kind, name, expression)
        garment.update_tag()
        return {"FINISHED"}

    def _expression(self, garment, name: str) -> str:
        """The sets of the new seam or fold. Raises ValueError in words for the user."""
        if garment.mode == "EDIT":
            garment.update_from_editmode()
        expression = SOURCES[self.kind][self.source][2]
        if expression is None:
            count = assign(garment, self.kind, name)
            if not count:
                raise ValueError(NOTHING.format(WORDS[self.kind]))
            return set_name(name)
        if self.source == "MARKED" and not column(garment.data.edges, "use_seam", kind=np.bool_).any():
            raise ValueError("No edges are marked as seams. Select some in Edit Mode, and choose Edge > Mark Seam")
        if self.source == "SHARP" and "sharp_edge" not in garment.data.attributes:
            raise ValueError("No edges are marked sharp. Select some in Edit Mode, and choose Edge > Mark Sharp")
        if self.source == "MATERIAL" and not garment.active_material:
            raise ValueError("The garment has no active material. Give it one, and assign it to faces")
        if self.source == "GROUP" and not garment.vertex_groups.active:
            raise ValueError("The garment has no active vertex group. Add one, and paint it")
        if self.source == "MATERIAL":
            return expression.format(names.quoted(names.usd_name(garment.active_material.name)))
        if self.source == "GROUP":
            primvars = recipe.group_primvars([group.name for group in garment.vertex_groups])
            return expression.format(names.quoted(primvars[garment.vertex_groups.active.name]))
        return expression


def check_length(name: str) -> None:
    """Raises ValueError for a name for which Blender has no room."""
    if len(name.encode()) > names.LONGEST:
        raise ValueError(f"The name has {len(name.encode())} bytes, and at most {names.LONGEST} fit. Choose a shorter one")


def set_name(name: str) -> str:
    """The attribute that holds the elements of a seam or fold."""
    return f"{name}_set"


def assign(garment, kind: str, name: str) -> int:
    """Makes the elements that are selected in Edit Mode the set of a seam or fold, and returns their number; nothing changes where
    none are.
    """
    mesh, domain = garment.data, DOMAIN[kind]
    if garment.mode == "EDIT":
        edited = bmesh.from_edit_mesh(mesh)
        rows = edited.edges if domain == "EDGE" else edited.faces
        if not any(element.select for element in rows):
            return 0
        layer = rows.layers.bool.get(set_name(name)) or rows.layers.bool.new(set_name(name))
        for element in rows:
            element[layer] = element.select
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return sum(element.select for element in rows)
    # What a mesh has selected outside of Edit Mode is not seen, and of a new mesh it is all.
    return 0


class OfOperator(OfGarment):
    kind: StringProperty()
    name: StringProperty()


class TAILOR_OT_remove(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.remove"
    bl_label = "Remove"
    bl_description = "Removes this seam or fold. Its edges or faces stay as an attribute of the mesh"

    def execute(self, context):
        garment = garment_of(context.active_object)
        recipe.remove_operator(garment, self.kind, self.name)
        garment.update_tag()
        return {"FINISHED"}


class TAILOR_OT_move(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.move"
    bl_label = "Move"
    bl_description = "Changes when this seam or fold is made"

    by: IntProperty()

    def execute(self, context):
        garment = garment_of(context.active_object)
        recipe.move_operator(garment, self.kind, self.name, self.by)
        garment.update_tag()
        return {"FINISHED"}


class TAILOR_OT_rename(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.rename"
    bl_label = "Rename"
    bl_description = "Renames this seam or fold"
    bl_property = "new_name"

    new_name: StringProperty(name="Name")

    def invoke(self, context, _event):
        self.new_name = self.name
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        garment = garment_of(context.active_object)
        try:
            check_length(names.usd_name(self.new_name))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        recipe.rename_operator(garment, self.kind, self.name, self.new_name)
        garment.update_tag()
        return {"FINISHED"}


class TAILOR_OT_assign(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.assign"
    bl_label = "Assign Selected"
    bl_description = "Puts this seam or fold on the elements that are selected in Edit Mode, in place of those that it is on"

    def execute(self, context):
        garment = garment_of(context.active_object)
        if not assign(garment, self.kind, self.name):
            self.report({"ERROR"}, NOTHING.format(WORDS[self.kind]))
            return {"CANCELLED"}
        recipe.put(garment, recipe.option(self.kind, recipe.SETS[self.kind]), set_name(self.name), self.name)
        garment.update_tag()
        return {"FINISHED"}


class TAILOR_OT_select(OfOperator, bpy.types.Operator):
    bl_idname = "tailor.select"
    bl_label = "Select"
    bl_description = "Selects the edges or faces of this seam or fold in Edit Mode"

    def execute(self, context):
        from .find import select_set

        garment = garment_of(context.active_object)
        if garment.data.library:
            self.report({"ERROR"}, LINKED.format(garment.data.name))
            return {"CANCELLED"}
        found = select_set(self, garment, self.kind, self.name)
        if found is None:
            return {"CANCELLED"}
        self.report({"INFO"}, f"{found[0]} {WORDS[self.kind]}")
        return {"FINISHED"}


class TAILOR_OT_choose(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.choose"
    bl_label = "Choose"
    bl_description = "Sets this option"

    key: StringProperty()
    value: StringProperty()

    def execute(self, context):
        garment = garment_of(context.active_object)
        garment[self.key] = self.value
        garment.update_tag()
        return {"FINISHED"}


class TAILOR_OT_add_option(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.add_option"
    bl_label = "Change Option"
    bl_description = "Gives the garment this option, to be changed"

    key: StringProperty()

    @classmethod
    def description(cls, _context, properties):
        return recipe.option(*properties.key.split(".")).meaning.replace("`", "")

    def execute(self, context):
        garment, of = garment_of(context.active_object), recipe.option(*self.key.split("."))
        recipe.put(garment, of, ", ".join(of.default) if isinstance(of.default, list) else of.default)
        return {"FINISHED"}


def _groups(_self, context):
    garment = garment_of(context.active_object)
    groups = [(group.name, group.name, "Vertices are held as far as their weight") for group in garment.vertex_groups] if garment else []
    # Blender keeps no copy of texts of items.
    TAILOR_OT_pin.shown = [("NONE", "None", "Nothing is held"), *groups]
    return TAILOR_OT_pin.shown


class TAILOR_OT_pin(OfGarment, bpy.types.Operator):
    bl_idname = "tailor.pin"
    bl_label = "Pin Group"
    bl_description = "The vertex group that holds the cloth"

    group: EnumProperty(items=_groups)

    def execute(self, context):
        garment = garment_of(context.active_object)
        primvars = recipe.group_primvars([group.name for group in garment.vertex_groups])
        value = cloth.WEIGHT.format(names.quoted(primvars[self.group])) if self.group != "NONE" else ""
        recipe.put(garment, recipe.option("cloth", "pins"), value)
        garment.update_tag()
        return {"FINISHED"}


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
