"""Small garments in memory, one trouble each: every builder takes keywords and writes one file."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

MODEL = "/Coat/model"
# The faces of a box whose corners have the bits of their numbers as coordinates.
BOX = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def sheet(width=4, height=3):
    """A bent sheet of quads: points, counts, indices."""
    across, down = np.meshgrid(np.arange(width + 1), np.arange(height + 1))
    x, y = across.ravel().astype(float), down.ravel().astype(float)
    points = np.stack([x, y, 0.4 * np.sin(0.9 * x) + 0.15 * y * y], axis=1)
    corner = (np.arange(height)[:, None] * (width + 1) + np.arange(width)).ravel()
    quads = np.stack([corner, corner + 1, corner + width + 2, corner + width + 1], axis=1)
    return points, np.full(len(quads), 4), quads.ravel()


def patchwork():
    """A triangle, a quad, a pentagon and a hexagon around each other."""
    points = np.array([[0, 0, 0], [2, 0, 0.2], [2, 2, 0.4], [0, 2, 0.1], [4, 0, 0], [4, 2, 0.6], [5, 1, 0], [1, 3.5, 0.3], [3, 3.2, 0.2], [2.2, 4, 0]])
    faces = [[0, 1, 2, 3], [1, 4, 6, 5, 2], [3, 2, 7], [2, 5, 8, 9, 7]]
    return points, np.array([len(face) for face in faces]), np.concatenate(faces)


def bow_tie():
    """Two sheets of one quad that meet in a point."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 1, 0.2], [2, 2, 0.3], [1, 2, 0.1]], dtype=float)
    return points, np.array([4, 4]), np.array([0, 1, 2, 3, 2, 4, 5, 6])


def fin():
    """Three quads on one edge."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, -1, 0], [0, -1, 0], [1, 0, 1], [0, 0, 1]], dtype=float)
    return points, np.array([4, 4, 4]), np.array([0, 1, 2, 3, 1, 0, 5, 4, 0, 1, 6, 7])


def turned_face():
    """A sheet one face of which is wound the other way."""
    points, counts, indices = sheet()
    quads = indices.reshape(-1, 4).copy()
    quads[5] = quads[5][::-1]
    return points, counts, quads.ravel()


def write(
    path,
    *,
    shape=sheet,
    model=MODEL,
    uv=True,
    seam_column=None,
    options=None,
    creases=None,
    corners=None,
    holes=None,
    primvars=(),
    subsets=(),
    families=None,
    finish=None,
    metadata=True,
):
    """Writes a garment to `path` and returns the path.

    `options` are mesh attributes by name, `creases` maps runs of points to sharpness, `primvars` are dicts for
    `add_primvar`, `subsets` are dicts for `add_subset`, `finish` is called with the mesh before it is saved.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    if metadata:
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    mesh = define(stage, model, shape())
    if stage.GetPrimAtPath(Sdf.Path(model).GetPrefixes()[0]):
        stage.SetDefaultPrim(stage.GetPrimAtPath(Sdf.Path(model).GetPrefixes()[0]))
    for name, value in (options or {}).items():
        mesh.GetPrim().GetAttribute(name).Set(value)
    if creases:
        mesh.CreateCreaseIndicesAttr([point for run in creases for point in run])
        mesh.CreateCreaseLengthsAttr([len(run) for run in creases])
        mesh.CreateCreaseSharpnessesAttr(list(creases.values()))
    if corners:
        mesh.CreateCornerIndicesAttr(list(corners))
        mesh.CreateCornerSharpnessesAttr(list(corners.values()))
    if holes:
        mesh.CreateHoleIndicesAttr(holes)
    if uv:
        add_uv(mesh, seam_column)
    for primvar in primvars:
        add_primvar(mesh, **primvar)
    for subset in subsets:
        add_subset(mesh, **subset)
    for family, kind in (families or {}).items():
        UsdGeom.Subset.SetFamilyType(mesh, family, kind)
    if finish:
        finish(mesh)
    stage.Save()
    return path


def define(stage, path, shape):
    for ancestor in Sdf.Path(path).GetParentPath().GetPrefixes():
        UsdGeom.Xform.Define(stage, ancestor)
    mesh = UsdGeom.Mesh.Define(stage, path)
    points, counts, indices = shape
    mesh.CreatePointsAttr([Gf.Vec3f(*map(float, point)) for point in points])
    mesh.CreateFaceVertexCountsAttr(counts.tolist())
    mesh.CreateFaceVertexIndicesAttr(indices.tolist())
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    return mesh


def add_uv(mesh, seam_column=None, name="st"):
    """Texture coordinates from x and y; faces to the right of a column of points are a shell of their own."""
    points = np.array(mesh.GetPointsAttr().Get())
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    right = np.zeros(len(indices), int)
    values = points[:, :2] * 0.1
    if seam_column is not None:
        centres = np.add.reduceat(points[indices][:, 0], np.concatenate([[0], np.cumsum(counts)[:-1]])) / counts
        right = np.repeat(centres > seam_column, counts) * len(points)
        values = np.concatenate([values, values + [1, 0.25]])
    used, corners = np.unique(indices + right, return_inverse=True)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set([Gf.Vec2f(*map(float, value)) for value in values[used]])
    st.SetIndices(corners.tolist())


def element_count(mesh, interpolation):
    points, counts, corners = (len(attribute.Get()) for attribute in (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()))
    return {"constant": 1, "uniform": counts, "vertex": points, "varying": points, "faceVarying": corners}[interpolation]


def add_primvar(mesh, *, name, type_name, interpolation, indexed=False, element_size=1, values=None, indices=None):
    """A primvar whose values differ by element, unless given; indexed ones use each value several times, unless given."""
    count = element_count(mesh, interpolation)
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, Sdf.ValueTypeNames.Find(f"{type_name}[]"), interpolation, element_size)
    stored = min(count, 5) if indexed else count
    primvar.Set(array(type_name, values if values is not None else [value(type_name, i) for i in range(stored * element_size)]))
    if indexed:
        primvar.SetIndices([(i * i + i // 2) % stored for i in range(count)])
    if indices is not None:
        primvar.SetIndices([int(i) for i in indices])
    return primvar


def array(type_name, values):
    return type(Sdf.ValueTypeNames.Find(f"{type_name}[]").defaultValue)(values)


def value(type_name, i):
    """A value of any type that changes slowly with `i`; quaternions stay in one hemisphere."""
    number = ((i * 37) % 23) / 8
    if type_name == "bool":
        return bool(i % 3)
    if type_name in ("int", "uint", "uchar", "int64", "uint64"):
        return (i * 37) % 23
    if type_name in ("string", "token"):
        return f"cloth {i % 4}"
    if type_name == "asset":
        return Sdf.AssetPath(f"cloth{i % 4}.png")
    if type_name.startswith("quat"):
        parts = np.array([1.0, 0.2 * number, 0.1, 0.05 * number])
        return of_numbers(type_name, parts / np.linalg.norm(parts))
    if type_name == "matrix4d":
        return of_numbers(type_name, (1, number, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, number, 2, 3, 1))
    if type_name.startswith("int"):
        return kind(type_name)(*[(i * 37 + k) % 23 for k in range(kind(type_name).dimension)])
    return of_numbers(type_name, [number + k / 2 for k in range(width(type_name))])


def kind(type_name):
    return type(Sdf.ValueTypeNames.Find(type_name).defaultValue)


def width(type_name):
    """How many numbers a value has."""
    return 4 if type_name.startswith("quat") else 16 if type_name == "matrix4d" else getattr(kind(type_name), "dimension", 1)


def of_numbers(type_name, numbers):
    """The value of a numeric type that has these numbers."""
    numbers = [float(number) for number in numbers]
    if type_name.startswith("quat"):
        return kind(type_name)(numbers[0], type(kind(type_name)().GetImaginary())(*numbers[1:]))
    return kind(type_name)(*numbers)


def add_skinning(mesh, *, joints=7, element_size=4):
    """Weights that fall off around joints along x, more joints than each point keeps, and the skeleton they belong to.

    The weights of each joint are a plain primvar too.
    """
    root = mesh.GetPath().GetPrefixes()[0]
    skeleton = UsdSkel.Skeleton.Define(mesh.GetPrim().GetStage(), (root if root != mesh.GetPath() else root.GetParentPath()).AppendChild("bones"))
    skeleton.CreateJointsAttr([f"joint{i}" for i in range(joints)])
    still = Vt.Matrix4dArray([Gf.Matrix4d(1)] * joints)
    skeleton.CreateBindTransformsAttr(still)
    skeleton.CreateRestTransformsAttr(still)
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().AddTarget(skeleton.GetPath())
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1))
    x = np.array(mesh.GetPointsAttr().Get())[:, 0]
    centres = np.linspace(x.min(), x.max(), joints)
    weights = np.exp(-((x[:, None] - centres) ** 2)) + 0.001 * np.arange(joints)
    kept = np.argsort(-weights, axis=1, kind="stable")[:, :element_size]
    weights = np.take_along_axis(weights, kept, axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    api = UsdGeom.PrimvarsAPI(mesh)
    for joint in range(joints):
        plain = np.where(kept == joint, weights, 0).sum(axis=1)
        api.CreatePrimvar(f"joint{joint}", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex).Set(plain.tolist())
    for name, kind, values in (("skel:jointIndices", Sdf.ValueTypeNames.IntArray, kept), ("skel:jointWeights", Sdf.ValueTypeNames.FloatArray, weights)):
        api.CreatePrimvar(name, kind, UsdGeom.Tokens.vertex, element_size).Set(values.ravel().tolist())


def add_subset(mesh, *, name, indices, element="face", family="sets", material=None):
    subset = UsdGeom.Subset.Define(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild(name))
    subset.CreateElementTypeAttr(element)
    subset.CreateFamilyNameAttr(family)
    subset.CreateIndicesAttr(Vt.IntArray(indices))
    if material:
        bind(subset.GetPrim(), material)
    return subset


def bind(prim, name):
    """Binds a material that it makes under the root prim."""
    stage = prim.GetStage()
    material = UsdShade.Material.Define(stage, prim.GetPath().GetPrefixes()[0].AppendPath(f"materials/{name}"))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    return material


def vec3f(points):
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))


def with_own_space(stage, path):
    """A prim with a transform of its own: what takes points of the stage to its space."""
    prim = UsdGeom.Xform.Define(stage, path)
    prim.AddTranslateOp().Set((3, -4, 5))
    prim.AddRotateXYZOp().Set((20, 30, 40))
    prim.AddScaleOp().Set((2, 2, 2))
    to_own = np.linalg.inv(np.array(prim.GetLocalTransformation()))
    return lambda points: points @ to_own[:3, :3] + to_own[3, :3]


def define_mesh(stage, path, points, faces):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(vec3f(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray([len(face) for face in faces]))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray([int(v) for face in faces for v in face]))
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def faulty(change):
    """A writer of a sheet that `change` edits."""
    return lambda path: write(path, shape=sheet, seam_column=2, finish=change)
