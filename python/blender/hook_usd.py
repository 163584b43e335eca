# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsets of the meshes of a stage that Blender exports or imports."""

import bpy
import numpy as np

from . import bind, names, recipe
from .cage import column
from .products import EdgeRows
from .stage import Sdf, Usd, UsdGeom, UsdShade, Vt

OBJECT_NAME = "userProperties:blender:object_name"

# True-or-false attributes of Blender itself, which say nothing about cloth.
IGNORED = {"sharp_face", "freestyle_face", "freestyle_edge"}
_DOMAINS = {"EDGE": "edge", "FACE": "face"}


def write(stage: Usd.Stage, depsgraph: bpy.types.Depsgraph) -> None:
    """Adds the subsets to each mesh that was exported, and makes the recipes name what is in the file."""
    for prim in stage.Traverse():
        if not prim.IsA(UsdGeom.Mesh):
            continue
        ob = _object_of(prim)
        mesh = ob and _exported(UsdGeom.Mesh(prim), ob, depsgraph)
        if mesh:
            _write_sets(UsdGeom.Mesh(prim), mesh)
        elif ob:
            print(f"USD Tailor: {prim.GetPath()}: its points are not those of {ob.name} with its modifiers; its edge sets are not written")
        if ob and recipe.is_garment(ob):
            _write_names(prim, ob)


def _object_of(prim: Usd.Prim) -> bpy.types.Object | None:
    """The object of a mesh: its transform is a prim above, or the mesh itself."""
    for place in (prim.GetParent(), prim):
        attribute = place.GetAttribute(OBJECT_NAME)
        if attribute and attribute.HasValue():
            return bpy.data.objects.get(attribute.Get())
    named = {prim.GetName(), prim.GetParent().GetName()}
    found = [ob for ob in bpy.data.objects if ob.type == "MESH" and names.usd_name(ob.name) in named]
    return found[0] if len(found) == 1 else None


def _exported(source: UsdGeom.Mesh, ob, depsgraph):
    """The mesh with the faces that were exported: with its modifiers, or without."""
    at = Usd.TimeCode.EarliestTime()
    corners = np.asarray(source.GetFaceVertexIndicesAttr().Get(at), np.int32)
    count = len(source.GetPointsAttr().Get(at) or [])
    for mesh in (ob.evaluated_get(depsgraph).data, ob.data):
        if len(mesh.vertices) == count and len(mesh.loops) == len(corners):
            if (column(mesh.loops, "vertex_index", kind=np.int32) == corners).all():
                return mesh
    return None


def _write_sets(source: UsdGeom.Mesh, mesh) -> None:
    ends = column(mesh.edges, "vertices", 2, np.int32)
    taken = {prim.GetName() for prim in source.GetPrim().GetChildren()}
    sets = [(names.SEAMS, "EDGE", column(mesh.edges, "use_seam", kind=np.bool_))]
    for attribute in mesh.attributes:
        is_set = attribute.data_type == "BOOLEAN" and attribute.domain in _DOMAINS
        if is_set and not attribute.name.startswith(".") and attribute.name not in IGNORED | {names.SEAMS}:
            sets.append((attribute.name, attribute.domain, column(attribute.data, "value", kind=np.bool_)))
    for name, domain, members in sets:
        rows = np.flatnonzero(members)
        if not rows.size:
            continue
        elements = ends[rows].ravel() if domain == "EDGE" else rows
        made = names.unique(names.usd_name(name), taken)
        taken.add(made)
        kind = _DOMAINS[domain]
        UsdGeom.Subset.CreateGeomSubset(source, made, kind, Vt.IntArray.FromNumpy(elements.astype(np.int32)), f"{kind}s")


def _write_names(prim: Usd.Prim, ob) -> None:
    """Options that name vertex groups and materials have their names in the file."""
    written = {}
    named = [*ob.vertex_groups, *(slot.material for slot in ob.material_slots if slot.material)]
    known = {primvar.GetPrimvarName() for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvars()} | {p.GetName() for p in prim.GetChildren()}
    for item in named:
        ours = names.usd_name(item.name)
        others = [other for other in names.ascii_names(item.name) if other in known]
        if ours not in known and others:
            written[ours] = others[0]
    for place in (prim.GetParent(), prim):
        for key, value in recipe.properties(ob).items():
            attribute = place.GetAttribute(key)
            if attribute and attribute.GetTypeName() == Sdf.ValueTypeNames.String:
                attribute.Set(_renamed(recipe.usd_value(ob, key, value), written))


def _renamed(value: str, written: dict[str, str]) -> str:
    if value in written:
        return written[value]
    for ours, other in written.items():
        value = value.replace(f"({names.quoted(ours)})", f"({names.quoted(other)})")
    return value


def read(stage: Usd.Stage, objects: dict) -> None:
    """Adds the subsets of edges, faces and points to each mesh that was imported, as attributes."""
    done = set()
    for path, made in objects.items():
        prim = stage.GetPrimAtPath(path)
        if not prim or not prim.IsA(UsdGeom.Mesh):
            continue
        for item in made:
            mesh = item if isinstance(item, bpy.types.Mesh) else item.data if isinstance(item, bpy.types.Object) else None
            if isinstance(mesh, bpy.types.Mesh) and mesh.name not in done:
                done.add(mesh.name)
                _read_sets(UsdGeom.Mesh(prim), mesh)
    _remove_empties(stage, objects)


def _remove_empties(stage: Usd.Stage, objects: dict) -> None:
    """Removes the empties that Blender makes of scopes and of physics in a tailored file, where they hold nothing."""
    roots = {prim.GetParent().GetPath() for prim in stage.Traverse() if prim.HasAttribute(f"primvars:{bind.FACE}")}
    empties = [(Sdf.Path(str(path)), ob) for path, made in objects.items() for ob in made if isinstance(ob, bpy.types.Object) and ob.type == "EMPTY"]
    # Children are before their parents.
    for path, ob in sorted(empties, key=lambda row: -row[0].pathElementCount):
        if _holds_nothing(stage.GetPrimAtPath(path), roots) and not ob.children and not ob.keys():
            bpy.data.objects.remove(ob)


def _holds_nothing(prim: Usd.Prim, roots: set[Sdf.Path]) -> bool:
    """Whether a prim is a scope or physics of a garment below one of the roots, or a scope of materials of any."""
    path, is_scope = prim.GetPath(), prim.IsA(UsdGeom.Scope)
    if roots and is_scope and all(child.IsA(UsdShade.Material) for child in prim.GetChildren()):
        return True
    root = next((root for root in roots if path.HasPrefix(root) and path != root), None)
    return root is not None and (is_scope or path.HasPrefix(root.AppendChild("physics")))


def _read_sets(source: UsdGeom.Mesh, mesh) -> None:
    domains = {"edge": "EDGE", "face": "FACE", "point": "POINT"}
    rows = {"EDGE": mesh.edges, "FACE": mesh.polygons, "POINT": mesh.vertices}
    find = None
    for subset in UsdGeom.Subset.GetAllGeomSubsets(source):
        name, domain = subset.GetPrim().GetName(), domains.get(subset.GetElementTypeAttr().Get())
        if not domain or subset.GetFamilyNameAttr().Get() == "materialBind" or name in mesh.attributes:
            continue
        indices = np.asarray(subset.GetIndicesAttr().Get(), np.int64)
        if domain == "EDGE":
            find = find or EdgeRows(mesh)
            indices = find(indices.reshape(-1, 2))
        members = np.zeros(len(rows[domain]), np.bool_)
        members[indices[indices < len(members)]] = True
        if name == names.SEAMS and domain == "EDGE":
            mesh.edges.foreach_set("use_seam", members | column(mesh.edges, "use_seam", kind=np.bool_))
        else:
            mesh.attributes.new(name, "BOOLEAN", domain).data.foreach_set("value", members)
