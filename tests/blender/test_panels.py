"""What the panels draw, and the messages that select elements."""

import bmesh
import bpy
import pytest
from bl_ext.user_default.usd_tailor import messages, panels
from loop import set_up


class Layout:
    """Stands for Blender's layout, which needs a window: each name that is drawn must exist."""

    def __init__(self, drawn=None):
        object.__setattr__(self, "drawn", [] if drawn is None else drawn)

    def __setattr__(self, name, value):
        assert name in bpy.types.UILayout.bl_rna.properties, f"a layout has no {name}"

    def _part(self, **_):
        return Layout(self.drawn)

    row = column = box = _part

    def panel(self, idname, default_closed=False):
        return Layout(self.drawn), Layout(self.drawn)

    def label(self, text="", icon="NONE"):
        self._add("label", text, icon)

    def prop(self, data, path, text=None):
        assert data.path_resolve(path) is not None, path
        self._add("prop", path, "NONE")

    def prop_search(self, data, path, other, collection, text=None):
        assert isinstance(data.path_resolve(path), str) and hasattr(other, collection)
        self._add("prop", path, "NONE")

    def operator(self, idname, text="", icon="NONE", depress=False, emboss=True):
        module, name = idname.split(".")
        kind = getattr(getattr(bpy.ops, module), name).get_rna_type()
        self._add("operator", idname, icon)
        return Properties(kind)

    def operator_menu_enum(self, idname, property, text="", icon="NONE"):
        assert property in Properties(getattr(bpy.ops.tailor, idname.split(".")[1]).get_rna_type()).known
        self._add("operator", idname, icon)

    def menu(self, name, text="", icon="NONE"):
        kind = getattr(bpy.types, name)
        self._add("menu", name, icon)
        drawn = type("Drawn", (), {"layout": self, "kind": getattr(kind, "kind", "")})()
        kind.draw(drawn, bpy.context)

    def _add(self, what, name, icon):
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items, icon
        self.drawn.append((what, name))


class Properties:
    def __init__(self, kind):
        object.__setattr__(self, "known", {property.identifier for property in kind.properties})

    def __setattr__(self, name, value):
        assert name in self.known, f"the operator has no {name}"


def drawn(panel):
    layout = Layout()
    stand_in = type("Drawn", (), {name: getattr(panel, name) for name in ("kind", "_draw_one") if hasattr(panel, name)})()
    stand_in.layout = layout
    panel.draw(stand_in, bpy.context)
    return layout.drawn


PANELS = [kind for kind in panels.CLASSES if issubclass(kind, bpy.types.Panel)]


def test_a_mesh_that_is_no_garment_shows_how_to_begin():
    mesh = bpy.data.meshes.new("cloth")
    ob = bpy.data.objects.new("cloth", mesh)
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    assert [kind for kind in PANELS if kind.poll(bpy.context)] == [panels.TAILOR_PT_garment]
    assert drawn(panels.TAILOR_PT_garment) == [("operator", "tailor.set_up")]


@pytest.mark.parametrize("panel", PANELS)
def test_each_panel_draws_what_exists(panel):
    set_up(armature=False, shape_key=False)
    bpy.ops.tailor.add(kind="fold", source="BORDERS", name="hems")
    for action in (None, bpy.ops.tailor.tailor, bpy.ops.tailor.cloth, bpy.ops.tailor.preview):
        if action:
            action()
        assert panel.poll(bpy.context) and drawn(panel)


def test_every_option_can_be_reached():
    ob = set_up(armature=False, shape_key=False)
    shown = {name for kind in PANELS for what, name in drawn(kind)}
    assert 'tailor:seam:sewn:width' in str(shown)
    for group in ("sim", "render", "cloth"):
        for of in panels.recipe.table()[group]:
            if f"{group}.{of.key}" not in panels.ELSEWHERE:
                bpy.ops.tailor.add_option(key=f"{group}.{of.key}")
                assert panels.names.key(group, of.key) in ob
    shown = str({name for kind in PANELS for what, name in drawn(kind)})
    assert "tailor:sim:featureAngle" in shown and "tailor:cloth:rest" in shown


def test_a_message_selects_what_it_names():
    ob = set_up(armature=False, shape_key=False)
    ob["tailor:seam:sewn:width"] = 0.2
    bpy.ops.tailor.check()
    found = messages.of(ob)["messages"]
    narrow = next(number for number, message in enumerate(found) if message["code"] == "narrow-seam")
    kind, numbers = messages.elements(found[narrow])
    assert kind == "points" and numbers
    bpy.ops.tailor.select_message(number=narrow)
    assert ob.mode == "EDIT"
    edited = bmesh.from_edit_mesh(ob.data)
    chosen = [vert for vert in edited.verts if vert.select]
    assert chosen and all(any(edge.seam for edge in vert.link_edges) for vert in chosen), "they are on the seams"


def test_messages_are_in_the_words_of_the_panel():
    ob = set_up(armature=False, shape_key=False)
    for text, shown in {
        "seam.sewn: too wide. Lower `seam.sewn.width`": "seam sewn: too wide. Lower Width of seam sewn",
        "or set `cloth.rest=mesh`, or sim.maxEdgeLength": "or set Rest = mesh, or Max edge length",
        "its normalOffset is reduced": "its normal offset is reduced",
        "/Shirt/model.primvars:st: UVs are flipped": "UV map UVMap: UVs are flipped",
        "subdivisionScheme of no.such.option": "subdivisionScheme of no.such.option",
    }.items():
        assert messages.shown(ob, {"message": text}) == shown


def test_no_message_of_a_check_names_a_key():
    ob = set_up(armature=False, shape_key=False)
    ob["tailor:seam:sewn:width"], ob["tailor:seam:sewn:normalOffset"], ob["tailor:sim:maxEdgeLength"] = 0.2, -0.1, 0.08
    bpy.ops.tailor.check()
    texts = [messages.shown(ob, message) for message in messages.of(ob)["messages"]]
    assert any("Width of seam sewn" in text for text in texts)
    for group, options in panels.recipe.table().items():
        for of in options:
            assert not any(f"{group}.{of.key}" in text or f"sewn.{of.key}" in text for text in texts), of
