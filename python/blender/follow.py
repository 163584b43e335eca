# SPDX-License-Identifier: GPL-3.0-or-later
"""The render mesh follows the simulation mesh while the cloth plays, by one group of Geometry Nodes.

The nodes are the kernel of ``usdtailor drive``. Each vertex of the simulation mesh turns from its frame at bind. A point of the render mesh takes
the blend of the three corners of its triangle: Phong tessellation along the surface, one rotation off it.
"""

import bpy

from . import bind
from .links import OWN

MODIFIER = OWN + "Follow"
TURN = ".tailor_turn"
"""The rotation of each vertex of the simulation mesh from bind, while the nodes run."""

# Share of the corners' tangent planes in the surface, as the command has it.
_PHONG_SHARE = 0.6
# Inputs of the group.
_SIM, _COUNT = "Simulation Mesh", "Vertices"
_VERSION = "tailor_version"
_NOW = 1


def is_on(render: bpy.types.Object) -> bool:
    modifier = render.modifiers.get(MODIFIER)
    return modifier is not None and modifier.show_viewport


def show(render: bpy.types.Object, name: str, is_shown: bool) -> None:
    """Switches a modifier, if the render mesh has it."""
    if modifier := render.modifiers.get(name):
        modifier.show_viewport = modifier.show_render = is_shown


def add(render: bpy.types.Object, sim: bpy.types.Object) -> None:
    """Gives the render mesh the modifier, if it has none, and its inputs."""
    modifier = render.modifiers.get(MODIFIER)
    if modifier is None:
        modifier = render.modifiers.new(MODIFIER, "NODES")
        before_subdivision(render, MODIFIER)
    modifier.node_group = _group()
    for item in modifier.node_group.interface.items_tree:
        if item.in_out == "INPUT" and item.name in (_SIM, _COUNT):
            _set_input(modifier, item.identifier, sim if item.name == _SIM else len(sim.data.vertices))
    # Blender does not see a change of such an input.
    render.update_tag()


def _set_input(modifier, name: str, value) -> None:
    # Blender 5.3 has properties, and earlier versions have items.
    if hasattr(modifier, "properties"):
        getattr(modifier.properties.inputs, name).value = value
    else:
        modifier[name] = value


def update(render: bpy.types.Object, sim: bpy.types.Object) -> None:
    """After both meshes were made again."""
    if MODIFIER in render.modifiers:
        add(render, sim)


def before_subdivision(ob: bpy.types.Object, name: str) -> None:
    """Moves a modifier behind what moves the mesh, and before what subdivides it."""
    places = [place for place, other in enumerate(ob.modifiers) if other.type == "SUBSURF"]
    if places:
        ob.modifiers.move(ob.modifiers.find(name), places[0])


# The group.


def _group() -> bpy.types.NodeTree:
    found = next((tree for tree in bpy.data.node_groups if tree.get(_VERSION) == _NOW), None)
    return found or _new_group()


class _Graph:
    """Adds nodes to a group. A call takes the inputs of a node in their order, as sockets or plain values, and returns its outputs."""

    def __init__(self, tree) -> None:
        self.tree = tree

    def __call__(self, kind: str, *inputs, **settings):
        node = self.tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for socket, value in zip([socket for socket in node.inputs if socket.enabled], inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return [socket for socket in node.outputs if socket.enabled]

    def vector(self, operation: str, *inputs):
        return self("ShaderNodeVectorMath", *inputs, operation=operation)[0]

    def number(self, operation: str, *inputs):
        return self("ShaderNodeMath", *inputs, operation=operation)[0]

    def attribute(self, name: str, kind: str = "FLOAT_VECTOR"):
        return self("GeometryNodeInputNamedAttribute", name, data_type=kind)[0]

    def scaled(self, vectors, weights):
        """The sum of vectors by their weights."""
        parts = [self("ShaderNodeVectorMath", vector, weight, operation="SCALE")[0] for vector, weight in zip(vectors, weights)]
        return self.sum("vector", parts)

    def sum(self, kind: str, parts):
        total, *rest = parts
        for part in rest:
            total = getattr(self, kind)("ADD", total, part)
        return total


def _new_group() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(MODIFIER, "GeometryNodeTree")
    tree[_VERSION], tree.is_modifier = _NOW, True
    for name, kind in (("Geometry", "Geometry"), (_SIM, "Object"), (_COUNT, "Int")):
        tree.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    graph = _Graph(tree)
    geometry, ob, vertices, _ = graph("NodeGroupInput")
    sim = graph("GeometryNodeObjectInfo", ob, transform_space="ORIGINAL")[-1]
    moved = graph("GeometryNodeSetPosition", geometry, None, _place(graph, _turned(graph, sim)))[0]
    graph("NodeGroupOutput", _checked(graph, sim, vertices, geometry, moved))
    return tree


def _checked(graph: _Graph, sim, vertices, still, moved):
    """The moved mesh, or the mesh at rest if the simulation mesh is not the one that it was bound to."""
    count = graph("GeometryNodeAttributeDomainSize", sim)[0]
    differs = graph("FunctionNodeCompare", count, vertices, data_type="INT", operation="NOT_EQUAL")[0]
    message = "The simulation mesh has another number of vertices. Turn off its modifiers that change it, or press Tailor"
    differs = graph("GeometryNodeWarning", differs, message, warning_type="WARNING")[0]
    return graph("GeometryNodeSwitch", differs, moved, still, input_type="GEOMETRY")[0]


def _turned(graph: _Graph, sim):
    """The simulation mesh with the rotation of each vertex from bind."""
    position, vertex = graph("GeometryNodeInputPosition")[0], graph("GeometryNodeVertexOfCorner")[0]

    def edge(step: int):
        corner = graph("GeometryNodeOffsetCornerInFace", None, step)[0]
        end = graph("GeometryNodeFieldAtIndex", position, corner, data_type="FLOAT_VECTOR", domain="CORNER")[0]
        return graph.vector("SUBTRACT", end, position)

    def summed(values):
        return graph("GeometryNodeAccumulateField", values, vertex, data_type="FLOAT_VECTOR", domain="CORNER")[2]

    edges = [edge(1), edge(2)]
    normal = graph.vector("NORMALIZE", summed(graph.vector("CROSS_PRODUCT", *edges)))
    x, y = (summed(graph.scaled(edges, graph("ShaderNodeSeparateXYZ", graph.attribute(name)))) for name in bind.SHARES)
    # The direction in the moved plane that is nearest to both; the axes drop its part along the normal.
    across = graph.vector("ADD", x, graph.vector("CROSS_PRODUCT", y, normal))
    across = graph.vector("SUBTRACT", across, graph.vector("PROJECT", across, normal))
    frame = graph("FunctionNodeAxesToRotation", normal, across, primary_axis="Z", secondary_axis="X")[0]
    turn = graph("FunctionNodeRotateRotation", graph.attribute(bind.UNTURN, "QUATERNION"), frame, rotation_space="GLOBAL")[0]
    return graph("GeometryNodeStoreNamedAttribute", sim, None, TURN, turn, data_type="QUATERNION", domain="POINT")[0]


def _place(graph: _Graph, sim):
    """Where each point of the render mesh is."""
    first = graph("FunctionNodeIntegerMath", graph.attribute(bind.FACE, "INT"), 3, operation="MULTIPLY")[0]
    corners = [graph("FunctionNodeIntegerMath", first, step, operation="ADD")[0] for step in range(3)]
    u, v, _ = graph("ShaderNodeSeparateXYZ", graph.attribute(bind.COORDS))
    weights = [u, v, graph.number("SUBTRACT", graph.number("SUBTRACT", 1.0, u), v)]

    def sampled(field, kind: str = "FLOAT_VECTOR"):
        # All faces are triangles.
        return [graph("GeometryNodeSampleIndex", sim, field, corner, data_type=kind, domain="CORNER")[0] for corner in corners]

    rest, turns = sampled(graph.attribute(bind.REST)), sampled(graph.attribute(TURN, "QUATERNION"), "QUATERNION")
    before = graph.scaled(rest, weights)
    raised = [graph("FunctionNodeRotateVector", graph.vector("SUBTRACT", before, corner), turn)[0] for corner, turn in zip(rest, turns)]
    offset = graph.vector("SUBTRACT", graph.attribute(bind.REST), before)
    offset = graph("FunctionNodeRotateVector", offset, _blended(graph, turns, weights))[0]
    surface = graph.scaled(raised, [graph.number("MULTIPLY", weight, _PHONG_SHARE) for weight in weights])
    return graph.sum("vector", [graph.scaled(sampled(graph("GeometryNodeInputPosition")[0]), weights), surface, offset])


def _blended(graph: _Graph, turns, weights):
    """The blend of the rotations of the corners. A rotation and its negative are the same."""
    parts = [graph("FunctionNodeRotationToQuaternion", turn) for turn in turns]
    (w, *_), first = parts[0], graph("ShaderNodeCombineXYZ", *parts[0][1:])[0]
    real, imaginary = [], []
    for weight, (other, *rest) in zip(weights, parts):
        axis = graph("ShaderNodeCombineXYZ", *rest)[0]
        alike = graph.number("ADD", graph.number("MULTIPLY", w, other), graph("ShaderNodeVectorMath", first, axis, operation="DOT_PRODUCT")[0])
        is_other = graph.number("LESS_THAN", alike, 0.0)
        signed = graph.number("MULTIPLY", weight, graph.number("SUBTRACT", 1.0, graph.number("MULTIPLY", is_other, 2.0)))
        real.append(graph.number("MULTIPLY", other, signed))
        imaginary.append(graph("ShaderNodeVectorMath", axis, signed, operation="SCALE")[0])
    real, imaginary = graph.sum("number", real), graph.sum("vector", imaginary)
    squared = graph.number("ADD", graph.number("MULTIPLY", real, real), graph("ShaderNodeVectorMath", imaginary, imaginary, operation="DOT_PRODUCT")[0])
    unit = graph.number("INVERSE_SQRT", squared)
    parts = graph("ShaderNodeSeparateXYZ", graph("ShaderNodeVectorMath", imaginary, unit, operation="SCALE")[0])
    return graph("FunctionNodeQuaternionToRotation", graph.number("MULTIPLY", real, unit), *parts)[0]
