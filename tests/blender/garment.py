"""A shirt as an artist of Blender makes it, and a body to wear it: for tests, and for the pictures of the documents.

Half of the shirt is modelled, of grids of quads that share the points of their seams. A Mirror modifier makes the other half, so that
both have the same UVs. Lengths are in metres, Z is up, the front faces -Y, and the wearer's left is +X.
"""

import functools
import math
from dataclasses import dataclass

import bmesh
import bpy
import numpy
from mathutils import Vector

# Quads of half a panel: across, from the hem to the armpit, along the armhole. Of these across, the neckline has some.
ACROSS, SIDE, ARMHOLE, NECKLINE = 10, 11, 7, 5
ROWS = SIDE + ARMHOLE
SLEEVE = 11
CUFF = 2
COLLAR = 5

HEM_SIDE = (0.235, 0.0, 0.76)
UNDERARM = (0.232, 0.0, 1.195)
SHOULDER = (0.2, 0.008, 1.425)
NECK = (0.085, 0.012, 1.462)
SLEEVE_END, SLEEVE_RADIUS = (0.405, 0.0, 1.16), 0.088
# Distance of the pocket's points from the front.
POCKET_GAP = 0.004


@dataclass
class Patch:
    """A grid of points, of shape (across, up, 3), with the flat pattern that its UVs show."""

    points: numpy.ndarray
    name: str
    material: int = 0

    def __post_init__(self):
        self.flat = flatten(self.points)


def shirt(name="Shirt", *, armature=True, shape_key=True, subdivision=1):
    """Makes the shirt and returns its object. Without ``armature`` and ``shape_key`` it is a plain mesh with a Mirror modifier and,
    if ``subdivision`` is not 0, a Subdivision modifier.
    """
    front, back, sleeve, collar, pocket = patches()
    bm = bmesh.new()
    verts = joined(bm, front, back, sleeve, collar)
    verts["pocket"] = grid(bm, pocket)
    uv = bm.loops.layers.uv.new("UVMap")
    at = 0.01
    for patch in (front, back, sleeve, collar, pocket):
        add_faces(bm, patch, verts[patch.name], uv, at)
        at += numpy.ptp(patch.flat[..., 0]) * UV_SCALE + 0.015
    mark_edges(bm, verts)
    mesh = bpy.data.meshes.new(name)
    bm.verts.index_update()
    rows = {key: [[v.index for v in column] for column in columns] for key, columns in verts.items()}
    bm.to_mesh(mesh)
    bm.free()
    for material, colour in (("Body", (0.10, 0.22, 0.45, 1.0)), ("Collar", (0.75, 0.72, 0.65, 1.0))):
        mesh.materials.append(colour_of(material, colour))
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))

    ob = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(ob)
    add_sets(mesh, rows)
    add_groups(ob, rows)
    if shape_key:
        add_wide(ob)
    mirror = ob.modifiers.new("Mirror", "MIRROR")
    mirror.use_clip = mirror.use_mirror_merge = True
    mirror.merge_threshold = 1e-4
    if armature:
        add_armature(ob)
    if subdivision:
        ob.modifiers.new("Subdivision", "SUBSURF").levels = subdivision
    return ob


def body(name="Body"):
    """Makes the body, of closed shells for trunk and arms, and returns its object."""
    bm = bmesh.new()
    trunk = [(0.60, 0.15, 0.10), (0.80, 0.178, 0.12), (0.95, 0.15, 0.103), (1.10, 0.165, 0.108), (1.22, 0.175, 0.11), (1.32, 0.165, 0.088)]
    trunk += [(1.38, 0.14, 0.066), (1.415, 0.095, 0.056), (1.45, 0.06, 0.053), (1.52, 0.058, 0.055), (1.58, 0.075, 0.09), (1.68, 0.08, 0.105), (1.76, 0.045, 0.06)]
    add_tube(bm, [((0, 0.004, z), (w, 0, 0), (0, d, 0)) for z, w, d in trunk], 32)
    for side in (1, -1):
        start, end = Vector((0.15 * side, 0.004, 1.382)), Vector((0.52 * side, 0.0, 1.035))
        along = (end - start).normalized()
        across = along.cross((0, 1, 0)).normalized()
        radii = [(0.0, 0.03), (0.05, 0.043), (0.3, 0.042), (0.6, 0.04), (0.95, 0.036), (1.0, 0.018)]
        add_tube(bm, [(start.lerp(end, t), across * r, Vector((0, r, 0))) for t, r in radii], 20)
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces)
    mesh = bpy.data.meshes.new(name)
    bm.to_mesh(mesh)
    bm.free()
    mesh.materials.append(colour_of("Skin", (0.5, 0.42, 0.36, 1.0)))
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(ob)
    return ob


# Shapes.

UV_SCALE = 0.54
# Rounds of the flat patterns, whose edges then differ by 1 % (front, back) to 6 % (collar) from those in space.
ROUNDS = 1500


@functools.cache
def patches():
    """The panels of the half at positive X, with equal points along their seams."""
    front = panel([(0, -0.145, 0.76), (0, -0.144, 0.98), (0, -0.15, 1.22), (0, -0.094, 1.385)], 0.145, -1, [(0.048, -0.1, 1.383), (0.084, -0.052, 1.425)])
    back = panel([(0, 0.135, 0.76), (0, 0.125, 0.98), (0, 0.14, 1.25), (0, 0.078, 1.452)], 0.135, 1, [(0.04, 0.079, 1.452), (0.078, 0.055, 1.458)])
    # Their seams, from either side.
    back[-1, : SIDE + 1] = front[-1, : SIDE + 1]
    back[NECKLINE:, -1] = front[NECKLINE:, -1]
    armhole = numpy.concatenate([front[-1, SIDE:], back[-1, SIDE + 1 : -1][::-1]])
    neckline = numpy.concatenate([front[: NECKLINE + 1, -1], back[:NECKLINE, -1][::-1]])
    return (
        Patch(front, "front"),
        Patch(back, "back"),
        Patch(sleeve_of(armhole), "sleeve"),
        Patch(collar_of(neckline), "collar", 1),
        Patch(pocket_of(front), "pocket"),
    )


def panel(centre, depth, side, neck_controls):
    """Half a front or back: a Coons patch between its centre line, hem, side with armhole, and neckline with shoulder."""
    centre = resampled(catmull_rom(centre), ROWS + 1)
    angles = numpy.linspace(0, math.pi / 2, ACROSS + 1)
    hem = numpy.stack([HEM_SIDE[0] * numpy.sin(angles), side * depth * numpy.cos(angles), numpy.full(ACROSS + 1, HEM_SIDE[2])], axis=1)
    # The front of an armhole is cut out deeper than its back.
    inset = 0.165 if side < 0 else 0.175
    armhole = bezier([UNDERARM, (0.222, side * 0.075, 1.235), (inset, side * 0.095, 1.41), SHOULDER])
    outer = numpy.concatenate([resampled(numpy.array([HEM_SIDE, UNDERARM]), SIDE + 1), resampled(armhole, ARMHOLE + 1)[1:]])
    neckline = resampled(bezier([centre[-1], *neck_controls, NECK]), NECKLINE + 1)
    shoulder = resampled(bezier([NECK, (0.125, 0.012, 1.456), (0.17, 0.01, 1.442), SHOULDER]), ACROSS - NECKLINE + 1)
    top = numpy.concatenate([neckline, shoulder[1:]])

    s, t = numpy.meshgrid(numpy.linspace(0, 1, ACROSS + 1), numpy.linspace(0, 1, ROWS + 1), indexing="ij")
    s, t = s[..., None], t[..., None]
    # The neckline shapes the upper rows, and the hem the others.
    upper = t**4
    lines = (1 - s) * centre[None] + s * outer[None]
    below, above = hem[:, None] - ((1 - s[:, :1]) * hem[0] + s[:, :1] * hem[-1]), top[:, None] - ((1 - s[:, :1]) * top[0] + s[:, :1] * top[-1])
    return lines + (1 - upper) * below + upper * above


def sleeve_of(armhole):
    """A tube from the armhole to the cuff, cut open under the arm: its first and last column are one line."""
    centre, end = Vector((0.2, 0, 1.33)), Vector(SLEEVE_END)
    along = (end - centre).normalized()
    down = Vector((0, 1, 0)).cross(along).normalized()
    if down.z > 0:
        down = -down
    count = len(armhole)
    columns = []
    for i, start in enumerate([*armhole, armhole[0]]):
        angle = 2 * math.pi * i / count
        rim = end + SLEEVE_RADIUS * (math.cos(angle) * down + math.sin(angle) * Vector((0, -1, 0)))
        start, rim = Vector(start), rim
        length = (rim - start).length
        leaves = start + Vector((0.95, 0, 0.05 * math.cos(angle))) * length * 0.33
        columns.append(resampled(bezier([start, leaves, rim - along * length * 0.4, rim]), SLEEVE + 1))
    return numpy.array(columns)


def collar_of(neckline):
    """A stand along the neckline and a fall over it, with a gap at the centre of the front."""
    steps = [(0.0, 0.0), (-0.004, 0.018), (-0.001, 0.036), (0.012, 0.040), (0.024, 0.018), (0.034, -0.008)]
    columns = []
    for i, point in enumerate(neckline):
        outward = Vector((point[0], point[1] - 0.01, 0)).normalized()
        front = max(0.0, 1 - i / NECKLINE)
        column = []
        for row, (out, up) in enumerate(steps):
            share = row / COLLAR
            moved = Vector(point) + outward * out + Vector((0, 0, up))
            # The fall lies on the chest, and its points spread.
            moved += Vector((0.024 * share * (1 - i / NECKLINE) ** 2 if i < NECKLINE else 0, -0.010 * front * share, -0.022 * front * max(0, share - 0.4)))
            if 0 < row and i == len(neckline) - 1:
                moved.x = 0.0
            column.append(moved)
        columns.append(column)
    return numpy.array(columns)


def pocket_of(front):
    """A patch over a part of the front, with a point below, at a small distance."""
    across, up = 5, 6
    columns = []
    for i in range(across + 1):
        column = []
        for j in range(up + 1):
            s = 0.25 + 0.38 * i / across
            low = 0.53 - 0.025 * (1 - abs(2 * i / across - 1))
            t = low + (0.70 - low) * j / up
            column.append(sampled(front, s, t) + normal_at(front, s, t) * POCKET_GAP)
        columns.append(column)
    return numpy.array(columns)


def sampled(points, s, t):
    """A point of a grid between its points."""
    x, y = s * (points.shape[0] - 1), t * (points.shape[1] - 1)
    i, j = min(int(x), points.shape[0] - 2), min(int(y), points.shape[1] - 2)
    u, v = x - i, y - j
    low = (1 - u) * points[i, j] + u * points[i + 1, j]
    return (1 - v) * low + v * ((1 - u) * points[i, j + 1] + u * points[i + 1, j + 1])


def normal_at(points, s, t):
    step = 0.02
    across = sampled(points, s + step, t) - sampled(points, s - step, t)
    up = sampled(points, s, t + step) - sampled(points, s, t - step)
    normal = numpy.cross(across, up)
    return normal / numpy.linalg.norm(normal)


def bezier(controls):
    t = numpy.linspace(0, 1, 65)[:, None]
    a, b, c, d = (numpy.array(point, float) for point in controls)
    return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def catmull_rom(points):
    points = [numpy.array(point, float) for point in points]
    points = [2 * points[0] - points[1], *points, 2 * points[-1] - points[-2]]
    spans = [bezier([b, b + (c - a) / 6, c - (d - b) / 6, c])[:-1] for a, b, c, d in zip(points, points[1:], points[2:], points[3:])]
    return numpy.concatenate([*spans, points[-2][None]])


def resampled(line, count):
    """Points at equal distances along a line."""
    lengths = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(line, axis=0), axis=1))])
    at = numpy.linspace(0, lengths[-1], count)
    return numpy.stack([numpy.interp(at, lengths, line[:, axis]) for axis in range(3)], axis=1)


def flatten(points):
    """The grid as a flat pattern, with edges and diagonals as long as in space, as far as that goes. Its first column is straight if
    it lies on the plane of the mirror.
    """
    across = numpy.linalg.norm(numpy.diff(points, axis=0), axis=2)
    up = numpy.linalg.norm(numpy.diff(points, axis=1), axis=2)
    flat = numpy.zeros((*points.shape[:2], 2))
    flat[1:, :, 0] = numpy.cumsum(across, axis=0).mean(axis=1, keepdims=True)
    flat[:, 1:, 1] = numpy.cumsum(up, axis=1).mean(axis=0, keepdims=True)
    is_middle = bool(numpy.abs(points[0, :, 0]).max() < 1e-9)
    number = numpy.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    pairs = [(number[1:], number[:-1]), (number[:, 1:], number[:, :-1]), (number[1:, 1:], number[:-1, :-1]), (number[1:, :-1], number[:-1, 1:])]
    ends = numpy.concatenate([numpy.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])
    space, flat = points.reshape(-1, 3), flat.reshape(-1, 2)
    rest = numpy.linalg.norm(space[ends[:, 0]] - space[ends[:, 1]], axis=1)
    targets = ends.T.ravel()
    valence = numpy.bincount(ends.ravel(), minlength=len(flat))[:, None]
    for _ in range(ROUNDS):
        span = flat[ends[:, 0]] - flat[ends[:, 1]]
        length = numpy.linalg.norm(span, axis=1)
        move = span * ((rest - length) / (2 * length))[:, None]
        both = numpy.concatenate([move, -move])
        moves = numpy.stack([numpy.bincount(targets, both[:, axis], len(flat)) for axis in (0, 1)], axis=1)
        flat = flat + 1.6 * moves / valence
        if is_middle:
            flat[number[0], 0] = 0.0
    flat -= flat.min(axis=0)
    return flat.reshape(*points.shape[:2], 2)


# The mesh.


def grid(bm, patch):
    return [[bm.verts.new(point) for point in column] for column in patch.points.tolist()]


def joined(bm, front, back, sleeve, collar):
    """The points of the panels by column and row. Panels share the points of their seams."""
    verts = {"front": grid(bm, front)}
    fronts = verts["front"]

    def shared(points, known):
        return [[known.get((i, j)) or bm.verts.new(p) for j, p in enumerate(column)] for i, column in enumerate(points.tolist())]

    known = {(ACROSS, j): fronts[ACROSS][j] for j in range(SIDE + 1)}
    known |= {(i, ROWS): fronts[i][ROWS] for i in range(NECKLINE, ACROSS + 1)}
    backs = verts["back"] = shared(back.points, known)
    armhole = fronts[ACROSS][SIDE:] + backs[ACROSS][SIDE + 1 : ROWS][::-1]
    columns = shared(sleeve.points[:-1], {(i, 0): vert for i, vert in enumerate(armhole)})
    verts["sleeve"] = [*columns, columns[0]]
    neckline = [fronts[i][ROWS] for i in range(NECKLINE + 1)] + [backs[i][ROWS] for i in range(NECKLINE)][::-1]
    verts["collar"] = shared(collar.points, {(i, 0): vert for i, vert in enumerate(neckline)})
    return verts


def add_faces(bm, patch, verts, uv, at):
    """Adds the quads of a panel, with normals outwards, and its pattern as UVs."""
    backwards = patch.name in ("back", "sleeve")
    for i in range(len(verts) - 1):
        for j in range(len(verts[0]) - 1):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            corners = corners[::-1] if backwards else corners
            face = bm.faces.new([verts[a][b] for a, b in corners])
            face.material_index = patch.material
            for loop, (a, b) in zip(face.loops, corners):
                u, v = patch.flat[a, b]
                # A pattern is seen from outside.
                u = numpy.ptp(patch.flat[..., 0]) - u if backwards else u
                loop[uv].uv = (at + u * UV_SCALE, 0.01 + v * UV_SCALE)


def mark_edges(bm, verts):
    """Seams between the panels, and creases along hem and cuff."""
    crease = bm.edges.layers.float.new("crease_edge")
    front, back, sleeve, collar = (verts[name] for name in ("front", "back", "sleeve", "collar"))
    seams = [front[ACROSS][: SIDE + 1], [column[ROWS] for column in front[NECKLINE:]]]
    seams += [[column[0] for column in sleeve], sleeve[0], [column[0] for column in collar]]
    for line in seams:
        for edge in edges_of(bm, line):
            edge.seam = True
    for line in ([column[0] for column in front], [column[0] for column in back], [column[-1] for column in sleeve]):
        for edge in edges_of(bm, line):
            edge[crease] = 1.0


def edges_of(bm, line):
    return [bm.edges.get(pair) for pair in zip(line, line[1:])]


def add_sets(mesh, rows):
    """The edges of a topstitch beside hem and cuff, and the faces of the cuff, as attributes."""
    lines = [[column[1] for column in rows[name]] for name in ("front", "back")]
    lines.append([column[-1 - CUFF] for column in rows["sleeve"]])
    wanted = {frozenset(pair) for line in lines for pair in zip(line, line[1:])}
    cuff = {number for column in rows["sleeve"] for number in column[-1 - CUFF :]}
    # Filled before the next is made, which moves it.
    stitch = mesh.attributes.new("topstitch", "BOOLEAN", "EDGE")
    stitch.data.foreach_set("value", [frozenset(edge.vertices) in wanted for edge in mesh.edges])
    faces = mesh.attributes.new("cuff_faces", "BOOLEAN", "FACE")
    faces.data.foreach_set("value", [cuff.issuperset(face.vertices) for face in mesh.polygons])


def add_groups(ob, rows):
    """Vertex groups: a density of triangles, seams with an umlaut in their name, and pins along neckline and shoulders."""
    mesh = ob.data
    seams = {number for edge in mesh.edges if edge.use_seam for number in edge.vertices}
    near = {number for edge in mesh.edges for number in edge.vertices if seams.intersection(edge.vertices)}
    shoulders = {column[-1] for name in ("front", "back") for column in rows[name]} | {column[0] for column in rows["collar"]}

    def density(vertex):
        # Fine at chest and sleeves, coarse at the hem.
        return min(max((vertex.co.z - 0.9) / 0.4, 0.0), 1.0)

    weights = {
        "density": [density(vertex) for vertex in mesh.vertices],
        "Säume": [1.0 if v.index in seams else 0.5 if v.index in near else 0.0 for v in mesh.vertices],
        "pins": [1.0 if v.index in shoulders else 0.0 for v in mesh.vertices],
    }
    for name, values in weights.items():
        set_group(ob, name, values)


def set_group(ob, name, values):
    group = ob.vertex_groups.new(name=name)
    for number, weight in enumerate(values):
        if weight > 0:
            group.add([number], weight, "REPLACE")


def add_wide(ob):
    """A shape key that widens the shirt below the chest."""
    ob.shape_key_add(name="Basis")
    key = ob.shape_key_add(name="Wide")
    for point, vertex in zip(key.data, ob.data.vertices):
        factor = 1 + 0.25 * min(max((1.25 - vertex.co.z) / 0.45, 0.0), 1.0)
        point.co = (vertex.co.x * factor, vertex.co.y * factor, vertex.co.z)


def add_armature(ob):
    """Three bones, with weights that fade from the sleeves to the trunk. The Mirror modifier exchanges left and right."""
    data = bpy.data.armatures.new(f"{ob.name} Armature")
    rig = bpy.data.objects.new(data.name, data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    spine = data.edit_bones.new("spine")
    spine.head, spine.tail = (0, 0, 0.8), (0, 0, 1.4)
    for name, side in (("arm.L", 1), ("arm.R", -1)):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = (0.18 * side, 0, 1.36), (0.52 * side, 0, 1.015)
        bone.parent = spine
    bpy.ops.object.mode_set(mode="OBJECT")
    start, along = Vector((0.18, 0, 1.36)), Vector((0.34, 0, -0.345)).normalized()

    def share(vertex):
        """The part of the arm: none on the trunk, all from 10 cm along the sleeve."""
        if vertex.co.z < UNDERARM[2] - 0.05 and vertex.co.x < UNDERARM[0] + 0.03:
            return 0.0
        t = min(max(((vertex.co - start).dot(along) + 0.02) / 0.1, 0.0), 1.0)
        return t * t * (3 - 2 * t)

    arm = [share(vertex) for vertex in ob.data.vertices]
    set_group(ob, "arm.L", arm)
    ob.vertex_groups.new(name="arm.R")
    set_group(ob, "spine", [1 - weight for weight in arm])
    ob.parent = rig
    ob.modifiers.new("Armature", "ARMATURE").object = rig


def add_tube(bm, rings, count):
    """A closed tube of rings, each a centre and two half axes."""
    verts = []
    for centre, a, b in rings:
        angles = [2 * math.pi * i / count for i in range(count)]
        verts.append([bm.verts.new(Vector(centre) + math.cos(t) * Vector(a) + math.sin(t) * Vector(b)) for t in angles])
    for low, high in zip(verts, verts[1:]):
        for i in range(count):
            bm.faces.new([low[i], low[(i + 1) % count], high[(i + 1) % count], high[i]])
    bm.faces.new(verts[0][::-1])
    bm.faces.new(verts[-1])


def colour_of(name, colour):
    material = bpy.data.materials.new(name)
    material.diffuse_color = colour
    if not material.node_tree:
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = colour
    shader.inputs["Roughness"].default_value = 0.8
    return material
