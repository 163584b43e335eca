# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulation mesh and the render mesh as objects beside the garment."""

import bpy
import numpy as np

from . import bind, cloth, follow, names, recipe
from .cage import DOMAINS, TYPES, Cage, column, read_cage
from .links import KIND, KINDS, OF, OWN, product, set_rendered
from .stage import MATERIAL_INDEX, MODEL, SHARPNESS, SMOOTH, Primvars, Usd, UsdGeom, UsdSkel, shape_name, subdivision_of, write_stage


def update(garment: bpy.types.Object, cage: Cage, stage: Usd.Stage, report: dict) -> None:
    """Makes the objects of both products, or puts the new meshes into them."""
    model = stage.GetDefaultPrim().GetPath().AppendChild(MODEL)
    found, groups = {}, [named for kind in KINDS if (ob := product(garment, kind)) for named in _named_groups(ob)]
    for kind in KINDS:
        prim = stage.GetPrimAtPath(model.ReplaceName(kind))
        ob = product(garment, kind) or _new_object(garment, kind)
        # Where it stays if the garment is deleted.
        ob.matrix_world = garment.matrix_world
        _fill(ob, garment, cage, prim)
        _add_modifiers(ob, garment, report["recipe"]["render"]["level"] if kind == "render" else None)
        found[kind] = ob
    sim, render = (found[kind] for kind in KINDS)
    bind.fill(sim, render, stage.GetPrimAtPath(model.ReplaceName("render")))
    follow.update(render, sim)
    _note_cloth(sim, stage, model, report)
    if cloth.is_set_up(sim):
        cloth.set_up(garment, sim)
    for settings, name, group in groups:
        setattr(settings, name, group)


def _named_groups(ob) -> list[tuple]:
    """The vertex groups that modifiers name, which Blender forgets when groups are made again: settings, name of the setting, group."""
    parts = [getattr(modifier, part, None) for modifier in ob.modifiers for part in ("settings", "collision_settings")]
    named = [(of, row.identifier) for of in (*ob.modifiers, *filter(None, parts)) for row in of.bl_rna.properties if "vertex_group" in row.identifier]
    return [(of, name, group) for of, name in named if isinstance(group := getattr(of, name), str) and group]


def stand_in(garment: bpy.types.Object) -> bpy.types.Object:
    """An object like the garment, with its modifiers such as Mirror applied, whatever shape keys it has."""
    cage = read_cage(garment)
    stage = write_stage(garment, cage)
    ob = bpy.data.objects.new("garment", bpy.data.meshes.new("garment"))
    bpy.context.scene.collection.objects.link(ob)
    ob.parent, ob.parent_type, ob.parent_bone = garment.parent, garment.parent_type, garment.parent_bone
    ob.matrix_parent_inverse, ob.matrix_world = garment.matrix_parent_inverse, garment.matrix_world
    _fill(ob, garment, cage, stage.GetPrimAtPath(stage.GetDefaultPrim().GetPath().AppendChild(MODEL)))
    _add_modifiers(ob, garment, level=0)
    for key, value in recipe.properties(garment).items():
        ob[key] = value
    return ob


def remove(garment: bpy.types.Object) -> None:
    """Removes both products and their collection."""
    collections = set()
    for kind in KINDS:
        if ob := product(garment, kind):
            collections.update(ob.users_collection)
            mesh = ob.data
            bpy.data.objects.remove(ob)
            if not mesh.users:
                bpy.data.meshes.remove(mesh)
    for collection in collections:
        if not collection.all_objects and OF in collection:
            bpy.data.collections.remove(collection)


def _new_object(garment, kind: str) -> bpy.types.Object:
    name = f"{garment.name}_{kind}"
    ob = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    ob[OF], ob[KIND] = garment, kind
    _collection(garment).objects.link(ob)
    # Wherever the garment goes, and whatever moves it.
    follow = ob.constraints.new("COPY_TRANSFORMS")
    follow.name, follow.target = OWN + "Follow", garment
    if kind == "sim":
        ob.display_type = "WIRE"
        set_rendered(ob, False)
    return ob


def _collection(garment) -> bpy.types.Collection:
    """The collection of the products, beside the garment."""
    for collection in bpy.data.collections:
        if collection.get(OF) == garment:
            return collection
    collection = bpy.data.collections.new(f"{garment.name} tailored")
    collection[OF] = garment
    (garment.users_collection or [bpy.context.scene.collection])[0].children.link(collection)
    return collection


# The mesh.


def _fill(ob, garment, cage: Cage, prim: Usd.Prim) -> None:
    """Puts the mesh of a prim into the object."""
    source, api, named = UsdGeom.Mesh(prim), UsdGeom.PrimvarsAPI(prim), Primvars(cage)
    mesh = ob.data
    if mesh.shape_keys:
        ob.shape_key_clear()
    ob.vertex_groups.clear()
    mesh.clear_geometry()
    points = np.asarray(source.GetPointsAttr().Get(), np.float32)
    corners = np.asarray(source.GetFaceVertexIndicesAttr().Get(), np.int32)
    counts = np.asarray(source.GetFaceVertexCountsAttr().Get(), np.int32)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(len(counts))
    mesh.polygons.foreach_set("loop_start", np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int32))
    mesh.update(calc_edges=True)
    _fill_faces(mesh, garment, api)
    _fill_attributes(mesh, cage, named, api)
    _fill_sets(mesh, cage, prim)
    _fill_creases(mesh, source)
    _fill_groups(ob, garment, named, api)
    _fill_shapes(ob, garment, cage, prim, points)
    mesh.update()


def _values(api: UsdGeom.PrimvarsAPI, name: str) -> np.ndarray | None:
    primvar = api.GetPrimvar(name)
    return np.asarray(primvar.ComputeFlattened()) if primvar and primvar.HasValue() else None


def _fill_faces(mesh, garment, api) -> None:
    smooth = _values(api, SMOOTH)
    if smooth is not None:
        mesh.polygons.foreach_set("use_smooth", smooth.astype(np.bool_))
    mesh.materials.clear()
    for slot in garment.material_slots:
        mesh.materials.append(slot.material)
    index = _values(api, MATERIAL_INDEX)
    if index is not None:
        mesh.polygons.foreach_set("material_index", index.astype(np.int32))


def _fill_attributes(mesh, cage: Cage, named: Primvars, api) -> None:
    for name in cage.uv:
        values = _values(api, named.uv[name])
        if values is not None:
            if api.GetPrimvar(named.uv[name]).GetInterpolation() in ("vertex", "varying"):
                # All corners of each point agree.
                values = values[column(mesh.loops, "vertex_index", kind=np.int32)]
            layer = mesh.uv_layers.new(name=name, do_init=False)
            layer.uv.foreach_set("vector", values.astype(np.float32).ravel())
            layer.active_render = name == cage.active_uv
    for name, of in cage.values.items():
        values = _values(api, named.values[name])
        if values is None:
            continue
        # Values of corners may have become values of points, where all corners of a point agree.
        domain = DOMAINS[api.GetPrimvar(named.values[name]).GetInterpolation()]
        member, _, kind = TYPES[of.type]
        attribute = mesh.attributes.new(name, of.type, domain)
        attribute.data.foreach_set(member, values.astype(kind).ravel())


def _fill_sets(mesh, cage: Cage, prim: Usd.Prim) -> None:
    """The sets of the garment as attributes, and its marked seams."""
    rows = {"edge": len(mesh.edges), "face": len(mesh.polygons), "point": len(mesh.vertices)}
    domains = {"edge": "EDGE", "face": "FACE", "point": "POINT"}
    known = {"edge": cage.edge_sets, "face": cage.face_sets, "point": cage.point_sets}
    find = None
    for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Mesh(prim)):
        kind, name = subset.GetElementTypeAttr().Get(), subset.GetPrim().GetName()
        if name not in known.get(kind, {}):
            continue
        indices = np.asarray(subset.GetIndicesAttr().Get(), np.int64)
        if kind == "edge":
            find = find or EdgeRows(mesh)
            indices = find(indices.reshape(-1, 2))
        is_member = np.zeros(rows[kind], np.bool_)
        is_member[indices] = True
        if name == names.SEAMS and kind == "edge":
            mesh.edges.foreach_set("use_seam", is_member)
        else:
            attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "BOOLEAN", domains[kind])
            attribute.data.foreach_set("value", is_member)


class EdgeRows:
    """Finds the edges of a mesh by their points."""

    def __init__(self, mesh) -> None:
        self.codes = self._codes(column(mesh.edges, "vertices", 2, np.int32))
        self.order = np.argsort(self.codes)
        self.codes = self.codes[self.order]

    @staticmethod
    def _codes(ends) -> np.ndarray:
        low, high = np.sort(ends.astype(np.int64), axis=1).T
        return low << 32 | high

    def __call__(self, ends: np.ndarray) -> np.ndarray:
        """The rows of those of the pairs that are edges."""
        codes = self._codes(ends)
        at = np.minimum(np.searchsorted(self.codes, codes), max(len(self.codes) - 1, 0))
        return self.order[at[self.codes[at] == codes]] if len(self.codes) else at[:0]


def _fill_creases(mesh, source: UsdGeom.Mesh) -> None:
    lengths = np.asarray(source.GetCreaseLengthsAttr().Get() or [], np.int64)
    sharpness = np.asarray(source.GetCreaseSharpnessesAttr().Get() or [], np.float32)
    indices = np.asarray(source.GetCreaseIndicesAttr().Get() or [], np.int64)
    if len(lengths):
        # Each crease is a chain of points, with one sharpness or one for each of its edges.
        is_last = np.zeros(len(indices), np.bool_)
        is_last[np.cumsum(lengths) - 1] = True
        starts = np.flatnonzero(~is_last)
        each = sharpness if len(sharpness) == len(starts) else np.repeat(sharpness, lengths - 1)
        rows, weights = EdgeRows(mesh)(np.c_[indices[starts], indices[starts + 1]]), np.zeros(len(mesh.edges), np.float32)
        weights[rows] = _weight(each)
        mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", weights)
    corners = np.asarray(source.GetCornerIndicesAttr().Get() or [], np.int64)
    if len(corners):
        weights = np.zeros(len(mesh.vertices), np.float32)
        weights[corners] = _weight(np.asarray(source.GetCornerSharpnessesAttr().Get(), np.float32))
        mesh.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", weights)


def _weight(sharpness):
    """The weight of a crease in Blender, from 0 to 1."""
    return np.sqrt(np.clip(sharpness, 0, SHARPNESS) / SHARPNESS)


def _fill_groups(ob, garment, named: Primvars, api) -> None:
    for group in garment.vertex_groups:
        made, weights = ob.vertex_groups.new(name=group.name), _values(api, named.groups.get(group.name, ""))
        if weights is not None:
            cloth.fill_group(made, weights)


def _fill_shapes(ob, garment, cage: Cage, prim: Usd.Prim, points: np.ndarray) -> None:
    """The shape keys, which follow those of the garment."""
    if not cage.shapes:
        return
    blocks = garment.data.shape_keys.key_blocks
    ob.shape_key_add(name=blocks[0].name, from_mix=False)
    for number, name in enumerate(cage.shapes):
        shape = UsdSkel.BlendShape(prim.GetStage().GetPrimAtPath(prim.GetPath().AppendChild(shape_name(number))))
        if not shape:
            continue
        offsets = np.asarray(shape.GetOffsetsAttr().Get(), np.float32)
        rows = shape.GetPointIndicesAttr().Get()
        moved = points.copy()
        moved[np.asarray(rows, np.int64) if rows is not None else slice(None)] += offsets
        key = ob.shape_key_add(name=name, from_mix=False)
        key.data.foreach_set("co", moved.ravel())
        key.slider_min, key.slider_max = blocks[name].slider_min, blocks[name].slider_max
        _follow(key, garment, name)


def _follow(key, garment, name: str) -> None:
    """Drives the value of a shape key by that of the garment."""
    driver = key.driver_add("value").driver
    driver.type = "AVERAGE"
    target = driver.variables.new().targets[0]
    target.id_type, target.id = "KEY", garment.data.shape_keys
    target.data_path = f'key_blocks["{bpy.utils.escape_identifier(name)}"].value'


# Modifiers.


def _add_modifiers(ob, garment, level: int | None) -> None:
    """The modifiers that move the garment, and of a render mesh what is left of its Subdivision, last in the stack."""
    for modifier in [modifier for modifier in ob.modifiers if modifier.name.startswith(OWN)]:
        if modifier.type in ("ARMATURE", "LATTICE", "SUBSURF"):
            ob.modifiers.remove(modifier)
    moved = [_copy(modifier, ob) for modifier in garment.modifiers if modifier.type in ("ARMATURE", "LATTICE")]
    for place, modifier in enumerate(moved):
        ob.modifiers.move(ob.modifiers.find(modifier.name), place)
    subdivision = subdivision_of(garment)
    if level is not None and subdivision:
        left = _copy(subdivision, ob)
        left.levels, left.render_levels = max(0, subdivision.levels - level), max(0, subdivision.render_levels - level)


def _copy(modifier, ob):
    made = ob.modifiers.new(OWN + modifier.name, modifier.type)
    for property in modifier.bl_rna.properties:
        if not property.is_readonly and property.identifier not in ("name", "type", "is_active", "execution_time", "persistent_uid"):
            setattr(made, property.identifier, getattr(modifier, property.identifier))
    return made


# Pins, attachments and fabric, for a cloth solver.


def _note_cloth(sim, stage: Usd.Stage, model, report: dict) -> None:
    """Notes attachments, pins and fabric on the simulation mesh."""
    prim = stage.GetPrimAtPath(model.ReplaceName("sim"))
    physics, figures = model.ReplaceName("physics"), report.get("cloth") or {}
    facts = {name: float(figures[name]) for name in ("mass", "area") if name in figures}
    facts["sewing"] = _sewing(prim).ravel().tolist()
    pins = stage.GetPrimAtPath(physics.AppendChild("pins"))
    facts["pins"] = [int(i) for i in pins.GetAttribute("physics:indices0").Get() or []] if pins else []
    for material in stage.GetPrimAtPath(physics).GetChildren() if stage.GetPrimAtPath(physics) else []:
        for name in ("surfaceStretchStiffness", "surfaceShearStiffness", "surfaceBendStiffness"):
            value = material.GetAttribute(f"physics:{name}").Get()
            if value is not None:
                facts[name] = float(value)
    # As one group, which exports leave out.
    sim[cloth.FACTS] = facts
    _note_fabrics(sim.data, prim)


# Stiffness in the panels of a build of several fabrics: the two directions of each, and the SI unit of their numbers.
_PANELS = {
    "surfaceStretchStiffness": ("stretchWarp", "stretchWeft", 1e-3),
    "surfaceShearStiffness": ("shearLeft", "shearRight", 1e-3),
    "surfaceBendStiffness": ("bendingWarp", "bendingWeft", 1e-9),
}


def _note_fabrics(mesh, prim: Usd.Prim) -> None:
    """Notes the stiffness of several fabrics at the points: the mean of the faces around each."""
    panels = [p for p in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Mesh(prim)) if p.GetPrim().GetAttribute("primvars:clo:shearLeft")]
    corners = column(mesh.loops, "vertex_index", kind=np.int32)
    for name, (warp, weft, unit) in _PANELS.items() if panels else ():
        of_faces = np.zeros(len(mesh.polygons))
        for panel in panels:
            directions = [panel.GetPrim().GetAttribute(f"primvars:clo:{key}").Get() for key in (warp, weft)]
            of_faces[np.asarray(panel.GetIndicesAttr().Get(), np.int64)] = unit * np.mean(directions)
        count = np.maximum(np.bincount(corners, minlength=len(mesh.vertices)), 1)
        mean = np.bincount(corners, np.repeat(of_faces, 3), len(mesh.vertices)) / count
        mesh.attributes.new(cloth.STIFFNESS[name], "FLOAT", "POINT").data.foreach_set("value", mean.astype(np.float32))


def _sewing(prim: Usd.Prim) -> np.ndarray:
    """Each vertex that is attached with the three corners of its triangle, which hold it in its place."""
    points = prim.GetAttribute("tailor:attach:points").Get()
    if not points:
        return np.zeros((0, 2), np.int64)
    faces = np.asarray(prim.GetAttribute("tailor:attach:faces").Get())
    corners = np.asarray(UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)[faces]
    return np.c_[np.repeat(np.asarray(points), 3), corners.ravel()]
