"""A pleated skirt with trims: waistband, slit with a placket, belt loops, buttons, a zip and a pocket as prims of their own.

The body of the skirt is one mesh. What lies on it and is not cloth is beside it: `loops`, `buttons` and `zip_tape` are meshes,
`zip_teeth` is a PointInstancer. Variant sets give it three sizes and two colours."""
import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade, Vt

T = Sdf.ValueTypeNames
PLEATS = 20                 # knife pleats around the skirt
COLUMNS = 4 * PLEATS        # two columns of the face of a pleat, two of its fold
BODY_ROWS, BAND_ROWS = 12, 2
WAIST, BAND, LENGTH = 101.0, 4.0, 52.0
SLIT = 5                    # rows of the slit, from the hem
SLIT_COLUMN = COLUMNS // 4  # at the wearer's left
SIZES = {"S": 0.94, "M": 1.0, "L": 1.07}
COLOURS = {"navy": (0.07, 0.1, 0.22), "rust": (0.45, 0.16, 0.07)}


def ellipse(angle, width, depth):
    """Points of an ellipse about the body; the angle runs from the front to the wearer's left."""
    return np.stack([width * np.sin(angle), 0 * angle, depth * np.cos(angle)], -1)


def row(t):
    """The points of a row of the skirt, t from 0 at the waist to 1 at the hem, in the order of the columns."""
    c = np.arange(COLUMNS)
    angle = 2 * np.pi * c / COLUMNS
    flare = 1 + 0.9 * t + 0.25 * t * t
    ground = ellipse(angle, 15.8 * flare, 12.0 * flare)
    out = ground * (1 / 15.8 ** 2, 0, 1 / 12.0 ** 2)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    # A pleat is a face that ends in an edge, and a fold back to the next face below it.
    lift = np.array([0.2, 0.7, 1.2, -0.2])[c % 4] * (0.35 + 2.4 * t)
    along = np.array([0.0, 0.1, 0.55, -0.35])[c % 4] * 2 * np.pi / COLUMNS * min(1.0, 0.3 + 2 * t)
    ground = ellipse(angle + along, 15.8 * flare, 12.0 * flare)
    return ground + out * lift[:, None] + [0, WAIST - BAND - LENGTH * t, 0]


def build():
    """The points, faces with their set, edge sets, creases and UVs of the body."""
    rows = [row(t) for t in np.linspace(0, 1, BODY_ROWS + 1)]
    angle = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    for k in range(1, BAND_ROWS + 1):
        rows.insert(0, ellipse(angle, 16.0, 12.2) + [0, WAIST - BAND + BAND * k / BAND_ROWS, 0])
    points = list(np.concatenate(rows))
    at = np.arange(len(points)).reshape(len(rows), COLUMNS)
    # The slit: the points below its top are there twice, a little apart.
    first = len(rows) - SLIT
    right = at.copy()
    for r in range(first, len(rows)):
        i = at[r, SLIT_COLUMN]
        side = points[at[r, SLIT_COLUMN + 1]] - points[i]
        right[r, SLIT_COLUMN] = len(points)
        points.append(points[i] - 0.12 * side)
        points[i] = points[i] + 0.12 * side
    faces, panels, uvs = [], [], []
    height = [0.0]
    for low, high in zip(rows, rows[1:]):
        height.append(height[-1] - np.linalg.norm(high - low, axis=1).mean())
    lengths = [np.linalg.norm(np.roll(r, -1, 0) - r, axis=1) for r in rows]
    across = [np.r_[0, np.cumsum(length)] - length.sum() / 2 for length in lengths]
    for r in range(len(rows) - 1):
        for c in range(COLUMNS):
            n = (c + 1) % COLUMNS
            # The faces before the slit take its right side.
            of = right if n == SLIT_COLUMN else at
            faces.append([at[r + 1, c], of[r + 1, n], of[r, n], at[r, c]])
            panels.append("waistband" if r < BAND_ROWS else "slit_placket" if r > first and c == SLIT_COLUMN else "body")
            gap = 6.0 if r < BAND_ROWS else 0.0
            uvs += [(across[q][c + k] / 100 + 2, (height[q] + gap) / 100 + 1) for q, k in ((r + 1, 0), (r + 1, 1), (r, 1), (r, 0))]
    ring = lambda r, of=at: [(of[r, c], of[r, (c + 1) % COLUMNS]) for c in range(COLUMNS)]
    slit = [(side[r], side[r + 1]) for side in (at[first - 1:, SLIT_COLUMN], np.r_[at[first - 1, SLIT_COLUMN], right[first:, SLIT_COLUMN]])
            for r in range(SLIT)]
    hem = [(a, right[-1, SLIT_COLUMN] if b == at[-1, SLIT_COLUMN] else b) for a, b in ring(-1)]
    placket = [(at[r, SLIT_COLUMN + 1], at[r + 1, SLIT_COLUMN + 1]) for r in range(first, len(rows) - 1)]
    edges = {"waist_seam": ring(BAND_ROWS), "waist_edge": ring(0), "hem": hem, "slit": slit, "placket_edge": placket}
    creases = [[int(i) for i in at[BAND_ROWS:, c]] for c in range(COLUMNS) if c % 4 in (2, 3) and c != SLIT_COLUMN]
    return np.array(points), faces, panels, np.array(uvs), edges, creases, at


def vec3f(points):
    return Vt.Vec3fArray.FromNumpy(np.round(points, 3).astype(np.float32))


def define_mesh(stage, path, points, faces, scheme="catmullClark"):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(vec3f(points))
    mesh.CreateFaceVertexCountsAttr([len(face) for face in faces])
    mesh.CreateFaceVertexIndicesAttr([int(i) for face in faces for i in face])
    mesh.CreateSubdivisionSchemeAttr(scheme)
    mesh.CreateExtentAttr(vec3f([points.min(0), points.max(0)]))
    return mesh


def strip(lines, closed=False):
    """The faces of a strip or tube through rows of as many points each, numbered row by row."""
    count, rows = len(lines[0]), len(lines)
    faces = []
    for r in range(rows - 1):
        for c in range(count if closed else count - 1):
            n = (c + 1) % count
            faces.append([count * r + c, count * r + n, count * (r + 1) + n, count * (r + 1) + c])
    return np.concatenate(lines), faces


def frame(points, at, r, c):
    """Place, outward normal and direction along the row, at a vertex of the body."""
    here = points[at[r, c]]
    along = points[at[r, (c + 1) % COLUMNS]] - points[at[r, c - 1]]
    along /= np.linalg.norm(along)
    up = points[at[r - 1, c]] - points[at[r + 1, c]] if 0 < r < len(at) - 1 else np.array([0, 1.0, 0])
    out = np.cross(along, up)
    out /= np.linalg.norm(out)
    return here, out, along


def belt_loops(points, at):
    """Bands over the waistband."""
    all_points, all_faces = [], []
    for c in (6, 18, 34, 46, 62, 74):
        top, out, along = frame(points, at, 0, c)
        low = points[at[BAND_ROWS, c]]
        lines = [low + (top - low) * t + out * h + along * np.array([[-0.5], [0.5]])
                 for t, h in ((-0.1, 0.1), (0.1, 0.55), (0.5, 0.6), (0.9, 0.55), (1.1, 0.1))]
        loop, faces = strip(lines)
        all_faces += [[i + 10 * len(all_points) for i in face] for face in faces]
        all_points.append(loop)
    return np.concatenate(all_points), all_faces


def buttons(points, at):
    """Flat discs, closed, on the waistband and down beside the slit."""
    all_points, all_faces = [], []
    places = [(1, SLIT_COLUMN + 1)] + [(BAND_ROWS + 3 + 2 * k, SLIT_COLUMN + 1) for k in range(2)]
    a = np.linspace(0, 2 * np.pi, 12, endpoint=False)[:, None]
    for r, c in places:
        here, out, along = frame(points, at, r, c)
        ring = along * np.cos(a) + np.cross(out, along) * np.sin(a)
        lines = [here + out * h + ring * radius for h, radius in ((0.1, 0.75), (0.25, 0.85), (0.4, 0.75))]
        disc, faces = strip(lines, closed=True)
        faces += [list(range(11, -1, -1)), list(range(24, 36))]
        all_faces += [[i + 36 * len(all_points) for i in face] for face in faces]
        all_points.append(disc)
    return np.concatenate(all_points), all_faces


def zip_line(points, at):
    """Points down the back, on the cloth, with the normals there."""
    c, rows = COLUMNS // 2, range(BAND_ROWS, BAND_ROWS + 5)
    frames = [frame(points, at, r, c + 1) for r in rows]
    t, fine = np.arange(len(frames)), np.linspace(0, len(frames) - 1, 33)
    sampled = lambda k: np.stack([np.interp(fine, t, [f[k][j] for f in frames]) for j in range(3)], 1)
    return sampled(0) + 0.15 * sampled(1), sampled(1), sampled(2)


def write(path):
    points, faces, panels, uvs, edges, creases, at = build()
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().documentation = "A pleated skirt with trims, in three sizes and two colours. Made by make_garments.py."
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    root = UsdGeom.Xform.Define(stage, "/Skirt")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    body = define_mesh(stage, "/Skirt/body", points, faces)
    details(body, faces, panels, uvs, edges, creases, at)
    trims(stage, points, at)
    recipe(body)
    looks(stage, root, body)
    sizes(root)
    stage.GetRootLayer().Export(str(path))
    return path


def details(body, faces, panels, uvs, edges, creases, at):
    body.CreateDoubleSidedAttr(True)
    api = UsdGeom.PrimvarsAPI(body)
    values, indices = np.unique(np.round(uvs, 4), axis=0, return_inverse=True)
    st = api.CreatePrimvar("st", T.TexCoord2fArray, "faceVarying")
    st.Set(Vt.Vec2fArray.FromNumpy(values.astype(np.float32)))
    st.SetIndices(Vt.IntArray.FromNumpy(indices.ravel().astype(np.int32)))
    weights = np.zeros(int(max(map(max, faces))) + 1)
    weights[at[: BAND_ROWS + 1].ravel()] = 1
    api.CreatePrimvar("pinWeight", T.FloatArray, "vertex").Set(Vt.FloatArray.FromNumpy(weights.astype(np.float32)))
    for name in dict.fromkeys(panels):
        UsdGeom.Subset.CreateGeomSubset(body, name, "face", [i for i, p in enumerate(panels) if p == name], "panels", "partition")
    for name, pairs in edges.items():
        UsdGeom.Subset.CreateGeomSubset(body, name, "edge", [int(i) for pair in pairs for i in pair], "edges", "unrestricted")
    body.CreateCreaseIndicesAttr([i for chain in creases for i in chain])
    body.CreateCreaseLengthsAttr([len(chain) for chain in creases])
    body.CreateCreaseSharpnessesAttr([1.6] * len(creases))


def trims(stage, points, at):
    define_mesh(stage, "/Skirt/loops", *belt_loops(points, at))
    define_mesh(stage, "/Skirt/buttons", *buttons(points, at), scheme="none")
    line, out, along = zip_line(points, at)
    tape = np.stack([line - 0.6 * along, line, line + 0.6 * along], 1)
    define_mesh(stage, "/Skirt/zip_tape", *strip(list(tape)))
    teeth = UsdGeom.PointInstancer.Define(stage, "/Skirt/zip_teeth")
    tooth = UsdGeom.Cube.Define(stage, "/Skirt/zip_teeth/tooth")
    tooth.CreateSizeAttr(1)
    tooth.AddScaleOp().Set((0.5, 0.22, 0.2))
    teeth.CreatePrototypesRel().SetTargets([tooth.GetPath()])
    middle = 0.5 * (line[1:] + line[:-1]) + 0.12 * out[1:]
    teeth.CreateProtoIndicesAttr([0] * len(middle))
    teeth.CreatePositionsAttr(vec3f(middle))
    turns = []
    for x, z in zip(along[1:], out[1:]):
        x = x - z * (x @ z) / (z @ z)
        axes = np.stack([x / np.linalg.norm(x), np.cross(z, x) / np.linalg.norm(np.cross(z, x)), z / np.linalg.norm(z)])
        turns.append(Gf.Quath(Gf.Matrix3d(*[float(v) for v in axes.ravel()]).ExtractRotation().GetQuat()))
    teeth.CreateOrientationsAttr(turns)
    teeth.CreateExtentAttr(teeth.ComputeExtentAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default()))


def recipe(body):
    prim = body.GetPrim()
    # Without TailorClothAPI, in which pins are a relationship: here a text names painted weights.
    for schema in ("TailorSimAPI", "TailorTrimAPI:all", "TailorSeamAPI:waist", "TailorFoldAPI:placket"):
        prim.AddAppliedSchema(schema)
    for name, kind, value in (
            ("sim:maxEdgeLength", T.Float, 1.8), ("sim:minEdgeLength", T.Float, 1.8),
            ("cloth:fabric", T.Token, "wool"), ("cloth:pins", T.String, "pinWeight"), ("cloth:rest", T.Token, "mesh"),
            ("seam:waist:width", T.Float, 0.6), ("seam:waist:normalOffset", T.Float, -0.08),
            ("fold:placket:thickness", T.Float, 0.2)):
        prim.CreateAttribute(f"tailor:{name}", kind, False, Sdf.VariabilityUniform).Set(value)
    for name, targets in (
            ("trim:all:prims", ["/Skirt/loops", "/Skirt/buttons", "/Skirt/zip_tape", "/Skirt/zip_teeth"]),
            ("sim:constraints", ["/Skirt/body/placket_edge"]),
            ("seam:waist:edges", ["/Skirt/body/waist_seam"]), ("fold:placket:faces", ["/Skirt/body/slit_placket"])):
        prim.CreateRelationship(f"tailor:{name}", False).SetTargets(targets)


def looks(stage, root, body):
    """A material for each colour, which a variant binds."""
    colours = root.GetPrim().GetVariantSets().AddVariantSet("colour")
    made = {}
    for name, colour in {**COLOURS, "metal": (0.6, 0.55, 0.4)}.items():
        material = UsdShade.Material.Define(stage, f"/Skirt/materials/{name}")
        shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", T.Color3f).Set(Gf.Vec3f(*colour))
        shader.CreateInput("roughness", T.Float).Set(0.35 if name == "metal" else 0.85)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        made[name] = material
    for trim in ("buttons", "zip_teeth"):
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(f"/Skirt/{trim}")).Bind(made["metal"])
    UsdShade.MaterialBindingAPI.Apply(body.GetPrim())
    for name in COLOURS:
        colours.AddVariant(name)
        colours.SetVariantSelection(name)
        with colours.GetVariantEditContext():
            for cloth in ("body", "loops", "zip_tape"):
                UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(f"/Skirt/{cloth}")).Bind(made[name])
    colours.SetVariantSelection("navy")


def sizes(root):
    """Sizes scale the whole skirt about the middle of the body."""
    sizes = root.GetPrim().GetVariantSets().AddVariantSet("size")
    stage = root.GetPrim().GetStage()
    prims = [(stage.GetPrimAtPath(f"/Skirt/{name}"), attribute) for name, attribute in (
        ("body", "points"), ("loops", "points"), ("buttons", "points"), ("zip_tape", "points"), ("zip_teeth", "positions"))]
    authored = [np.array(prim.GetAttribute(attribute).Get(), float) for prim, attribute in prims]
    for prim, attribute in prims:       # what is authored outside of variants is stronger
        prim.GetAttribute(attribute).Clear()
    for name, scale in SIZES.items():
        sizes.AddVariant(name)
        sizes.SetVariantSelection(name)
        with sizes.GetVariantEditContext():
            for (prim, attribute), values in zip(prims, authored):
                prim.GetAttribute(attribute).Set(vec3f(values * (scale, 1, scale)))
    sizes.SetVariantSelection("M")
