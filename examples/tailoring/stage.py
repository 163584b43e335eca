"""Writes a garment as a USD stage."""
from dataclasses import dataclass, field

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

from .flatten import flatten
from .form import joint

T = Sdf.ValueTypeNames
JOINT_TREE = [  # joint path, mannequin joint, side, end of the bone
    ("hips", "hips", 1, "spine"), ("hips/spine", "spine", 1, "chest"),
    ("hips/spine/chest", "chest", 1, "neck"), ("hips/spine/chest/neck", "neck", 1, "head")]
for _word, _side in (("left", 1), ("right", -1)):
    _arm, _leg = f"hips/spine/chest/shoulder_{_word}", f"hips/hip_{_word}"
    JOINT_TREE += [
        (_arm, "shoulder", _side, "elbow"), (f"{_arm}/elbow_{_word}", "elbow", _side, "wrist"),
        (f"{_arm}/elbow_{_word}/wrist_{_word}", "wrist", _side, "hand"),
        (_leg, "hip", _side, "knee"), (f"{_leg}/knee_{_word}", "knee", _side, "ankle"),
        (f"{_leg}/knee_{_word}/ankle_{_word}", "ankle", _side, "toe")]


@dataclass
class Look:
    """What a stage holds beyond the shape of its garment."""
    doc: str
    colours: dict               # material name: rgb
    materials: dict             # panel: material, where it is not the first one
    sets: dict                  # face set: panels
    display: str                # interpolation of displayColor
    fine: dict                  # edge set: distance over which simDensity falls from 1 to 0
    thick: dict                 # panel: thickness
    constraints: list           # edge sets
    min_length: float
    max_length: float
    grains: dict = field(default_factory=dict)
    translate: tuple = (0, 0, 0)
    cylinder: bool = False      # write a second UV set
    uv_corners: str = "cornersPlus1"    # faceVaryingLinearInterpolation
    hint: str = ""


def rounded(values, digits=6):
    """Floats of a few significant digits, so that files stay small."""
    v = np.asarray(values, float)
    scale = 10.0 ** (digits - 1 - np.floor(np.log10(np.maximum(np.abs(v), 1e-3))))
    return (np.round(v * scale) / scale).astype(np.float32)


def write(garment, look, path):
    """Writes the stage; the garment's points are taken as rounded."""
    name = garment.name
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    layer.documentation = look.doc
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    root = UsdSkel.Root.Define(stage, f"/{name}")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    mesh = UsdGeom.Mesh.Define(stage, f"/{name}/model")
    points = rounded(np.array(garment.points) - look.translate)
    _mesh(mesh, garment, points, look)
    uv, unit = _uvs(mesh, garment, look)
    _subsets(mesh, garment, look)
    _painted(mesh, garment, look)
    _display(mesh, garment, look, uv)
    _pieces(mesh, garment, unit)
    _materials(stage, name, mesh, garment, look)
    skeleton = _skeleton(stage, name)
    _skin(mesh, skeleton, garment, look)
    _recipe(mesh, look)
    root.CreateExtentAttr(_world_extent(mesh, stage))
    layer.Export(str(path))


def _world_extent(mesh, stage):
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
    box = cache.ComputeLocalBound(mesh.GetPrim()).ComputeAlignedRange()
    skel = joint_points()
    low = np.minimum(np.array(box.GetMin()), skel.min(0))
    high = np.maximum(np.array(box.GetMax()), skel.max(0))
    return Vt.Vec3fArray.FromNumpy(rounded([low, high]))


def _mesh(mesh, garment, points, look):
    prim = mesh.GetPrim()
    doc = f"The garment as modelled: a coarse subdivision cage. {look.hint}"
    prim.SetDocumentation(doc.strip())
    if any(look.translate):
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*look.translate))
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(0), points.max(0)])))
    mesh.CreateFaceVertexCountsAttr([len(f) for f in garment.faces])
    mesh.CreateFaceVertexIndicesAttr([i for f in garment.faces for i in f])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.catmullClark)
    mesh.CreateInterpolateBoundaryAttr(UsdGeom.Tokens.edgeAndCorner)
    mesh.CreateFaceVaryingLinearInterpolationAttr(look.uv_corners)
    mesh.CreateOrientationAttr(UsdGeom.Tokens.rightHanded)
    mesh.CreateDoubleSidedAttr(True)
    if garment.creases:
        mesh.CreateCreaseIndicesAttr([i for chain, _ in garment.creases for i in chain])
        mesh.CreateCreaseLengthsAttr([len(chain) for chain, _ in garment.creases])
        mesh.CreateCreaseSharpnessesAttr([s for _, s in garment.creases])
    if garment.corners:
        mesh.CreateCornerIndicesAttr([i for i, _ in garment.corners])
        mesh.CreateCornerSharpnessesAttr([s for _, s in garment.corners])


def _primvar(mesh, name, kind, interpolation, values, indices=None, doc=None):
    pv = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, kind, interpolation)
    pv.Set(values)
    if indices is not None:
        pv.SetIndices(Vt.IntArray.FromNumpy(np.asarray(indices, np.int32)))
    if doc:
        pv.GetAttr().SetDocumentation(doc)
    return pv


def _uvs(mesh, garment, look):
    uv, index, unit = flatten(garment, look.grains)
    uv = np.round(uv, 5).astype(np.float32)
    _primvar(mesh, "st", T.TexCoord2fArray, "faceVarying", Vt.Vec2fArray.FromNumpy(uv), index,
             f"The sewing pattern, true to scale: 1 unit is {unit:g} cm. Grain runs up.")
    if look.cylinder:
        # Each face unrolls about its own middle, so only the cut behind divides faces.
        points = np.array(garment.points)
        flat = np.concatenate([np.array(f) for f in garment.faces])
        middle = np.concatenate([np.repeat(points[list(f)].mean(0)[None], len(f), 0)
                                 for f in garment.faces])
        centre = np.arctan2(middle[:, 0], middle[:, 2])
        angle = np.arctan2(points[flat, 0], points[flat, 2])
        u = centre + np.angle(np.exp(1j * (angle - centre)))
        y = points[:, 1]
        v = (y - y.min()) / np.ptp(y)
        values = np.round(np.stack([u / (2 * np.pi) + 0.5, v[flat]], 1), 4)
        values, index = np.unique(values, axis=0, return_inverse=True)
        _primvar(mesh, "st1", T.TexCoord2fArray, "faceVarying",
                 Vt.Vec2fArray.FromNumpy(values.astype(np.float32)), index.ravel(),
                 "A cylinder about the body, cut down the back. Not to scale.")
    return uv, unit


def _subset(mesh, name, element, indices, family, kind=None):
    s = UsdGeom.Subset.CreateGeomSubset(
        mesh, name, element, Vt.IntArray.FromNumpy(np.asarray(indices, np.int32)), family)
    if kind:
        UsdGeom.Subset.SetFamilyType(mesh, family, kind)
    return s


def _subsets(mesh, garment, look):
    g = UsdGeom.Tokens
    panels = np.array(garment.panels)
    for name in dict.fromkeys(garment.panels):
        _subset(mesh, name, g.face, np.nonzero(panels == name)[0], "panels", g.partition)
    for name, members in look.sets.items():
        _subset(mesh, name, g.face, np.nonzero(np.isin(panels, members))[0], "sets",
                g.unrestricted)
    for name, pairs in garment.edge_sets.items():
        unique = list(dict.fromkeys(tuple(p) for p in pairs))
        _subset(mesh, name, "edge", np.array(unique).ravel(), "edges", g.unrestricted)
    _subset(mesh, "buttons", g.point, garment.pins, "points", g.unrestricted)


def edge_distance(garment, names):
    """Distance of every point from edge sets, along straight lines between points."""
    p = np.array(garment.points)
    ends = np.array([e for n in names for e in garment.edge_sets[n]])
    a, b = p[ends[:, 0]], p[ends[:, 1]]
    ab = b - a
    t = np.einsum("nkd,kd->nk", p[:, None] - a, ab) / (ab * ab).sum(1)
    t = np.clip(t, 0, 1)[..., None]
    return np.linalg.norm(p[:, None] - a - t * ab, axis=2).min(1)


def smooth_step(x):
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def _painted(mesh, garment, look):
    p = np.array(garment.points)
    density = np.zeros(len(p))
    for name, reach in look.fine.items():
        density = np.maximum(density, smooth_step(1 - edge_distance(garment, [name]) / reach))
    for side in (1, -1):
        for bend, reach in (("elbow", 17.0), ("knee", 20.0)):
            d = np.linalg.norm(p - joint(bend, side), axis=1)
            density = np.maximum(density, 0.7 * smooth_step((reach - d) / 8))
    thickness = np.zeros(len(p))
    for face, panel in zip(garment.faces, garment.panels):
        value = look.thick.get(panel, 0.25)
        thickness[list(face)] = np.maximum(thickness[list(face)], value)
    for name, pairs in garment.edge_sets.items():
        if name in ("hem", "cuff_hem", "side_seams", "shoulder_seams", "armholes", "inseam"):
            ids = np.unique(np.array(pairs))
            thickness[ids] = np.maximum(thickness[ids], 0.6)
    pairs, _ = garment.edges()
    n = np.bincount(pairs.ravel(), minlength=len(p))
    for _ in range(2):
        total = np.zeros(len(p))
        np.add.at(total, pairs[:, 0], thickness[pairs[:, 1]])
        np.add.at(total, pairs[:, 1], thickness[pairs[:, 0]])
        thickness = 0.6 * thickness + 0.4 * total / np.maximum(n, 1)
    for name, values, doc in (
            ("simDensity", density, "Painted: 1 asks for the shortest edges of the simulation."),
            ("thicknessWeight", thickness, "Painted: how many layers of cloth lie here.")):
        _primvar(mesh, name, T.FloatArray, "vertex",
                 Vt.FloatArray.FromNumpy(np.round(values, 3).astype(np.float32)), doc=doc)


def _display(mesh, garment, look, uv):
    base = np.array(list(look.colours.values())[0])
    mode = look.display
    if mode == "constant":
        _primvar(mesh, "displayColor", T.Color3fArray, "constant", [Gf.Vec3f(*map(float, base))])
        return
    if mode == "uniform":
        names = list(dict.fromkeys(garment.panels))
        shade = {n: 0.86 + 0.28 * ((i * 0.381966) % 1) for i, n in enumerate(names)}
        rows = []
        for f, n in enumerate(garment.panels):
            material = look.materials.get(n)
            colour = np.array(look.colours[material]) if material else base
            rows.append(np.clip(colour * shade[n] * (0.97 + 0.06 * ((f * 0.618034) % 1)), 0, 1))
        values = np.round(rows, 3).astype(np.float32)
        _primvar(mesh, "displayColor", T.Color3fArray, "uniform", Vt.Vec3fArray.FromNumpy(values))
        return
    # Vertex colours, indexed: a worn look in eight steps, lighter at the knees and the seat.
    p = np.array(garment.points)
    wear = np.zeros(len(p))
    for side in (1, -1):
        for at, reach in ((joint("knee", side) + (0, 0, 9), 18), ((9 * side, 84, -13), 14)):
            d = np.linalg.norm(p - at, axis=1)
            wear = np.maximum(wear, smooth_step(1 - d / reach))
    steps = 8
    table = base * (1 - 0.0) + (np.array([0.62, 0.68, 0.76]) - base) * np.linspace(
        0, 0.8, steps)[:, None]
    index = np.clip((wear * (steps - 1) + 0.5).astype(int), 0, steps - 1)
    _primvar(mesh, "displayColor", T.Color3fArray, "vertex",
             Vt.Vec3fArray.FromNumpy(np.round(table, 3).astype(np.float32)), index)


def _pieces(mesh, garment, unit):
    names = list(dict.fromkeys(garment.panels))
    index = [names.index(n) for n in garment.panels]
    _primvar(mesh, "pieceName", T.StringArray, "uniform", Vt.StringArray(names), index,
             "The pattern piece of each face.")
    layers = [1 if any(w in n for w in ("pocket", "flap", "loop", "fly", "welt", "belt")) else 0
              for n in garment.panels]
    _primvar(mesh, "layer", T.IntArray, "uniform", layers, doc="0: body, 1: lies upon it.")
    _primvar(mesh, "stScale", T.Float, "constant", unit, doc="Centimetres in one unit of st.")
    p = np.array(garment.points)
    flow = np.stack([np.arctan2(p[:, 0], p[:, 2]) / np.pi, (p[:, 1] - p[:, 1].min()) / 100], 1)
    _primvar(mesh, "bodyCoord", T.Float2Array, "varying",
             Vt.Vec2fArray.FromNumpy(np.round(flow, 3).astype(np.float32)),
             doc="Direction about the body in half turns, and height above the hem in metres.")


def _materials(stage, name, mesh, garment, look):
    scope = UsdGeom.Scope.Define(stage, f"/{name}/materials").GetPath()
    made = {}
    for key, colour in look.colours.items():
        material = UsdShade.Material.Define(stage, scope.AppendChild(key))
        shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", T.Color3f).Set(Gf.Vec3f(*map(float, colour)))
        shader.CreateInput("roughness", T.Float).Set(0.3 if key == "buttons" else 0.85)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        made[key] = material
    first = next(iter(made.values()))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(first)
    panels = np.array(garment.panels)
    for key in list(made)[1:]:
        members = [n for n, m in look.materials.items() if m == key]
        faces = np.nonzero(np.isin(panels, members))[0]
        if not len(faces):
            continue
        subset = _subset(mesh, f"material_{key}", "face", faces, "materialBind",
                         UsdGeom.Tokens.nonOverlapping)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(made[key])


def joint_points():
    return np.array([joint(n, s) for _, n, s, _ in JOINT_TREE])


def _skeleton(stage, name):
    skeleton = UsdSkel.Skeleton.Define(stage, f"/{name}/skel")
    paths = [path for path, *_ in JOINT_TREE]
    skeleton.CreateJointsAttr(paths)
    world = joint_points()

    def matrix(v):
        return Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(*map(float, v)))
    skeleton.CreateBindTransformsAttr([matrix(v) for v in world])
    rest = []
    for i, path in enumerate(paths):
        parent = path.rpartition("/")[0]
        rest.append(matrix(world[i] - (world[paths.index(parent)] if parent else 0)))
    skeleton.CreateRestTransformsAttr(rest)
    return skeleton


def _skin(mesh, skeleton, garment, look, influences=4):
    p = np.array(garment.points)
    weight = np.zeros((len(p), len(JOINT_TREE)))
    for k, (_, start, side, end) in enumerate(JOINT_TREE):
        a, b = joint(start, side), joint(end, side)
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[:, None]
        weight[:, k] = 1 / (np.linalg.norm(p - a - t * (b - a), axis=1) + 1) ** 4
    order = np.argsort(-weight, axis=1, kind="stable")[:, :influences]
    kept = np.take_along_axis(weight, order, 1)
    # The weight of what is dropped fades to zero, so that weights are smooth over the mesh.
    kept = kept - np.take_along_axis(weight, np.argsort(-weight, 1, "stable"), 1)[:, influences:
                                                                                 influences + 1]
    kept = np.round(kept / kept.sum(1, keepdims=True), 4)
    kept[:, 0] += 1 - kept.sum(1)
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateGeomBindTransformAttr(
        Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(*map(float, look.translate))))
    binding.CreateJointIndicesPrimvar(False, influences).Set(
        Vt.IntArray.FromNumpy(order.astype(np.int32).ravel()))
    binding.CreateJointWeightsPrimvar(False, influences).Set(
        Vt.FloatArray.FromNumpy(np.round(kept, 4).astype(np.float32).ravel()))


def _recipe(mesh, look):
    """The recipe of the tailor: codeless schemas, so attributes are authored by name."""
    prim = mesh.GetPrim()
    prim.AddAppliedSchema("TailorSimAPI")
    prim.AddAppliedSchema("TailorRenderAPI")
    for name, kind, value in (
            ("tailor:sim:minEdgeLength", T.Float, look.min_length),
            ("tailor:sim:maxEdgeLength", T.Float, look.max_length),
            ("tailor:sim:density", T.Token, "simDensity"),
            ("tailor:sim:uvSet", T.Token, "st"),
            ("tailor:render:level", T.Int, 1)):
        prim.CreateAttribute(name, kind, False, Sdf.VariabilityUniform).Set(value)
    prim.CreateRelationship("tailor:sim:constraints", False).SetTargets(
        [prim.GetPath().AppendChild(n) for n in look.constraints])
