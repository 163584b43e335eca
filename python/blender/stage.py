# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment as a USD stage, by Blender's own OpenUSD. Import it when a stage is needed: OpenUSD takes a moment to load."""

import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt  # noqa: E402

from . import names, recipe  # noqa: E402
from .cage import Cage, Values  # noqa: E402

MODEL = "model"
MATERIAL_INDEX = "blenderMaterialIndex"
"""Primvar with the material slot of each face. Products carry it."""
SMOOTH = "blenderSmooth"
"""Primvar of the faces that are shaded smooth."""

# Choices of the Subdivision modifier, as Blender's exporter writes them.
BOUNDARY = {"ALL": "edgeOnly", "PRESERVE_CORNERS": "edgeAndCorner"}
UV_SMOOTH = {
    "NONE": "all",
    "PRESERVE_CORNERS": "cornersOnly",
    "PRESERVE_CORNERS_AND_JUNCTIONS": "cornersPlus1",
    "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE": "cornersPlus2",
    "PRESERVE_BOUNDARIES": "boundaries",
    "SMOOTH_ALL": "none",
}

# Sharpness of a crease of weight 1, as Blender's exporter writes it: 10 times the square.
SHARPNESS = 10.0

_TYPES = {
    "FLOAT": (Sdf.ValueTypeNames.FloatArray, Vt.FloatArray),
    "INT": (Sdf.ValueTypeNames.IntArray, Vt.IntArray),
    "BOOLEAN": (Sdf.ValueTypeNames.BoolArray, Vt.BoolArray),
    "FLOAT_VECTOR": (Sdf.ValueTypeNames.Float3Array, Vt.Vec3fArray),
    "FLOAT2": (Sdf.ValueTypeNames.Float2Array, Vt.Vec2fArray),
    "FLOAT_COLOR": (Sdf.ValueTypeNames.Color4fArray, Vt.Vec4fArray),
    "BYTE_COLOR": (Sdf.ValueTypeNames.Color4fArray, Vt.Vec4fArray),
}
# Primvars whose type USD has fixed, and which Blender's importer makes attributes of other types.
_TYPED = {"displayColor", "displayOpacity"}
_INTERPOLATIONS = {"POINT": "vertex", "FACE": "uniform", "CORNER": "faceVarying"}


class Primvars:
    """The primvar of each UV map, vertex group and attribute of a garment."""

    def __init__(self, cage: Cage) -> None:
        self.groups = recipe.group_primvars(cage.groups)
        taken = {names.UV_SET, MATERIAL_INDEX, SMOOTH, *_TYPED, *self.groups.values()}
        others = names.uniquely([name for name in cage.uv if name != cage.active_uv], taken)
        self.uv = {cage.active_uv: names.UV_SET} | others
        self.values = names.uniquely(cage.values, taken)


def write_stage(ob: bpy.types.Object, cage: Cage) -> Usd.Stage:
    """The garment in memory, with its recipe, as ``/<object>/model``."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, bpy.context.scene.unit_settings.scale_length)
    render = bpy.context.scene.render
    stage.SetTimeCodesPerSecond(render.fps / render.fps_base)
    root = UsdGeom.Xform.Define(stage, f"/{names.usd_name(ob.name)}")
    stage.SetDefaultPrim(root.GetPrim())
    root.AddTransformOp().Set(Gf.Matrix4d([list(column) for column in ob.matrix_world.transposed()]))
    mesh = UsdGeom.Mesh.Define(stage, root.GetPath().AppendChild(MODEL))
    _write_surface(mesh, ob, cage)
    _write_primvars(UsdGeom.PrimvarsAPI(mesh), cage)
    _write_sets(mesh, cage)
    _write_materials(stage, mesh, ob, cage)
    _write_shapes(mesh, cage)
    _write_recipe(root.GetPrim(), ob)
    return stage


def _floats(kind, array):
    return kind.FromNumpy(np.ascontiguousarray(array, np.float32))


def _ints(array) -> Vt.IntArray:
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(array, np.int32).ravel())


def _write_surface(mesh: UsdGeom.Mesh, ob, cage: Cage) -> None:
    mesh.CreatePointsAttr(_floats(Vt.Vec3fArray, cage.points))
    mesh.CreateFaceVertexCountsAttr(_ints(cage.counts))
    mesh.CreateFaceVertexIndicesAttr(_ints(cage.corners))
    subdivision = subdivision_of(ob)
    mesh.CreateSubdivisionSchemeAttr("catmullClark" if subdivision else "none")
    mesh.CreateInterpolateBoundaryAttr(BOUNDARY[subdivision.boundary_smooth] if subdivision else "edgeOnly")
    mesh.CreateFaceVaryingLinearInterpolationAttr(UV_SMOOTH[subdivision.uv_smooth] if subdivision else "boundaries")
    if cage.edge_creases is not None and (found := np.flatnonzero(cage.edge_creases > 0)).size:
        mesh.CreateCreaseIndicesAttr(_ints(cage.edges[found]))
        mesh.CreateCreaseLengthsAttr(_ints(np.full(len(found), 2)))
        mesh.CreateCreaseSharpnessesAttr(_floats(Vt.FloatArray, SHARPNESS * cage.edge_creases[found] ** 2))
    if cage.point_creases is not None and (found := np.flatnonzero(cage.point_creases > 0)).size:
        mesh.CreateCornerIndicesAttr(_ints(found))
        mesh.CreateCornerSharpnessesAttr(_floats(Vt.FloatArray, SHARPNESS * cage.point_creases[found] ** 2))


def subdivision_of(ob) -> bpy.types.SubsurfModifier | None:
    """The modifier by which the garment is a subdivision surface."""
    found = [modifier for modifier in ob.modifiers if modifier.type == "SUBSURF" and modifier.subdivision_type == "CATMULL_CLARK"]
    return found[-1] if found else None


def _write_primvars(api: UsdGeom.PrimvarsAPI, cage: Cage) -> None:
    named = Primvars(cage)
    for layer, array in cage.uv.items():
        api.CreatePrimvar(named.uv[layer], Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying").Set(_floats(Vt.Vec2fArray, array))
    for group, weights in cage.groups.items():
        _write_values(api, named.groups[group], Values("POINT", "FLOAT", weights))
    for attribute, values in cage.values.items():
        _write_values(api, named.values[attribute], values)
    if cage.material_index.any():
        _write_values(api, MATERIAL_INDEX, Values("FACE", "INT", cage.material_index))
    _write_values(api, SMOOTH, Values("FACE", "BOOLEAN", cage.smooth_faces))


def _write_values(api: UsdGeom.PrimvarsAPI, name: str, values: Values) -> None:
    kind, array = _TYPES[values.type]
    primvar = api.CreatePrimvar(name, kind, _INTERPOLATIONS[values.domain])
    primvar.Set(array.FromNumpy(np.ascontiguousarray(values.array)))


def _write_sets(mesh: UsdGeom.Mesh, cage: Cage) -> None:
    taken = set()
    for kind, sets in (("edge", cage.edge_sets), ("face", cage.face_sets), ("point", cage.point_sets)):
        for name, rows in sets.items():
            made = names.unique(name, taken)
            taken.add(made)
            elements = cage.edges[rows] if kind == "edge" else rows
            UsdGeom.Subset.CreateGeomSubset(mesh, made, kind, _ints(elements), f"{kind}s")


def _write_materials(stage: Usd.Stage, mesh: UsdGeom.Mesh, ob, cage: Cage) -> None:
    """Materials by name, for expressions such as ``material(collar)``."""
    taken = {prim.GetName() for prim in mesh.GetPrim().GetChildren()}
    scope = mesh.GetPath().GetParentPath().AppendChild("materials")
    for number, slot in enumerate(ob.material_slots):
        faces = np.flatnonzero(cage.material_index == number)
        if not slot.material or not faces.size:
            continue
        name = names.usd_name(slot.material.name)
        material = UsdShade.Material.Define(stage, scope.AppendChild(name))
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, names.unique(name, taken), "face", _ints(faces), "materialBind")
        taken.add(subset.GetPrim().GetName())
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)


def _write_shapes(mesh: UsdGeom.Mesh, cage: Cage) -> None:
    if not cage.shapes:
        return
    binding, targets, tokens = UsdSkel.BindingAPI.Apply(mesh.GetPrim()), [], []
    for number, offsets in enumerate(cage.shapes.values()):
        shape = UsdSkel.BlendShape.Define(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild(shape_name(number)))
        moved = np.flatnonzero(np.abs(offsets).max(axis=1) > 0)
        shape.CreateOffsetsAttr(_floats(Vt.Vec3fArray, offsets[moved]))
        shape.CreatePointIndicesAttr(_ints(moved))
        targets.append(shape.GetPath())
        tokens.append(shape_name(number))
    binding.CreateBlendShapesAttr(tokens)
    binding.CreateBlendShapeTargetsRel().SetTargets(targets)


def shape_name(number: int) -> str:
    """The prim of a shape key, of those but the first."""
    return f"blenderShape{number}"


def _write_recipe(prim: Usd.Prim, ob) -> None:
    kinds = {bool: Sdf.ValueTypeNames.Bool, int: Sdf.ValueTypeNames.Int64, float: Sdf.ValueTypeNames.Double, str: Sdf.ValueTypeNames.String}
    for key, value in recipe.properties(ob).items():
        if type(value) in kinds:
            prim.CreateAttribute(key, kinds[type(value)], custom=True).Set(recipe.usd_value(ob, key, value))
