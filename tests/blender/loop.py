"""Steps that several tests take."""

import bpy
import garment
import numpy
from bl_ext.user_default.usd_tailor import links, recipe


def active(ob):
    """Makes an object the one that operators work on."""
    for other in bpy.context.selected_objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = ob
    ob.select_set(True)
    return ob


def set_up(**options):
    """A shirt that is set up, with its marked seams sewn, small enough for quick builds."""
    ob = active(garment.shirt(**options))
    bpy.ops.tailor.set_up()
    bpy.ops.tailor.add(kind="seam", source="MARKED", name="sewn")
    ob["tailor:sim:maxEdgeLength"] = 0.03
    ob["tailor:render:level"] = 1
    return ob


def products(ob):
    return [links.product(ob, kind) for kind in links.KINDS]


def points(ob):
    """The points of an object as it is drawn, without subdivision."""
    for modifier in ob.modifiers:
        modifier.show_viewport = modifier.type != "SUBSURF"
    mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    found = numpy.empty(len(mesh.vertices) * 3, numpy.float32)
    mesh.vertices.foreach_get("co", found)
    return found.reshape(-1, 3)


def weights(ob, name):
    """The weights of a vertex group."""
    number = ob.vertex_groups[name].index
    return numpy.array([sum(e.weight for e in vertex.groups if e.group == number) for vertex in ob.data.vertices])


def properties(ob):
    return recipe.properties(ob)


def drawn(ob):
    """The points of an object as it is drawn, with the modifiers that are on."""
    mesh = ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    found = numpy.empty(len(mesh.vertices) * 3, numpy.float32)
    mesh.vertices.foreach_get("co", found)
    return found.reshape(-1, 3)
