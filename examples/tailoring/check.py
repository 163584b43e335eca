"""Checks a garment stage: topology, subsets, UVs, layers which must not pass through each other."""
import numpy as np
from pxr import Usd, UsdGeom, UsdValidation

UNKNOWN_SCHEMAS = ("TailorSimAPI", "TailorRenderAPI")
STRETCH = 0.15      # how far UV lengths may be off true scale, for all but one edge in fifty


class Model:
    """The arrays of the mesh /X/model."""

    def __init__(self, path):
        self.stage = Usd.Stage.Open(str(path))
        self.prim = self.stage.GetDefaultPrim().GetChild("model")
        self.mesh = UsdGeom.Mesh(self.prim)
        self.points = np.array(self.mesh.GetPointsAttr().Get(), float)
        self.counts = np.array(self.mesh.GetFaceVertexCountsAttr().Get())
        self.indices = np.array(self.mesh.GetFaceVertexIndicesAttr().Get())
        self.starts = np.r_[0, np.cumsum(self.counts)]
        self.faces = [tuple(self.indices[s:e]) for s, e in zip(self.starts, self.starts[1:])]
        self.half_edges = [(f[k], f[(k + 1) % len(f)]) for f in self.faces for k in range(len(f))]
        self.edge_keys = {tuple(sorted(e)) for e in self.half_edges}
        pv = UsdGeom.PrimvarsAPI(self.prim).GetPrimvar("st")
        self.uv_index = np.array(pv.GetIndices())
        self.uv = np.array(pv.Get(), float)[self.uv_index]
        self.unit = UsdGeom.PrimvarsAPI(self.prim).GetPrimvar("stScale").Get()

    def subsets(self, element):
        return {s.GetPrim().GetName(): (s, np.array(s.GetIndicesAttr().Get(), int))
                for s in UsdGeom.Subset.GetAllGeomSubsets(self.mesh)
                if s.GetElementTypeAttr().Get() == element}


def summary(path):
    m = Model(path)
    kinds = ", ".join(f"{n} of {k} sides" for k, n in zip(*np.unique(m.counts, return_counts=True)))
    size = np.ptp(m.points, axis=0)
    return (f"{len(m.points)} points, {len(m.faces)} faces ({kinds}), "
            f"{size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} cm, 1 UV unit is {m.unit:g} cm")


def stage_problems(path):
    m = Model(path)
    out = []
    for check in (_validators, _topology, _shape, _subsets, _uvs, _uv_overlap, _primvars, _layers):
        out += [f"{check.__name__[1:]}: {p}" for p in check(m)]
    size = path.stat().st_size
    if size > 1_200_000:
        out.append(f"file of {size} bytes")
    return out


def _validators(m):
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    for e in context.Validate(m.stage):
        text = e.GetErrorAsString()
        if not any(s in text for s in UNKNOWN_SCHEMAS):
            yield text
    for family in UsdGeom.Subset.GetAllGeomSubsetFamilyNames(m.mesh):
        element = next(s for s in UsdGeom.Subset.GetAllGeomSubsets(m.mesh)
                       if s.GetFamilyNameAttr().Get() == family).GetElementTypeAttr().Get()
        valid, why = UsdGeom.Subset.ValidateFamily(m.mesh, element, family)
        if not valid:
            yield f"family {family}: {why}"


def _topology(m):
    seen = {}
    for e in m.half_edges:
        seen[e] = seen.get(e, 0) + 1
    for e, n in seen.items():
        if n > 1:
            yield f"edge {e} is used {n} times in one direction"
    if len(np.unique(m.indices)) != len(m.points):
        yield "points without faces"
    # The faces of a point must form one fan.
    around = {}
    for f in m.faces:
        for k, v in enumerate(f):
            around.setdefault(v, []).append((f[k - 1], f[(k + 1) % len(f)]))
    for v, links in around.items():
        group = {a: a for link in links for a in link}

        def find(a):
            while group[a] != a:
                a = group[a]
            return a
        for a, b in links:
            group[find(a)] = find(b)
        if len({find(a) for a in group}) != 1:
            yield f"point {v} joins separate fans"


def face_normals(m):
    p = m.points
    out = np.zeros((len(m.faces), 3))
    for i, f in enumerate(m.faces):
        q = p[list(f)]
        out[i] = np.cross(q[1] - q[0], q[2] - q[0]) if len(f) == 3 else np.sum(
            np.cross(q, np.roll(q, -1, 0)), axis=0)
    return out / 2


def _shape(m):
    normals = face_normals(m)
    area = np.linalg.norm(normals, axis=1)
    for i, f in enumerate(m.faces):
        q = m.points[list(f)]
        sides = np.linalg.norm(np.roll(q, -1, 0) - q, axis=1)
        if sides.min() < 0.2:
            yield f"face {i} has a side of {sides.min():.2f} cm"
        if area[i] < 0.2:
            yield f"face {i} has an area of {area[i]:.2f}"
        if len(f) == 4:
            n = normals[i] / area[i]
            height = np.abs((q - q.mean(0)) @ n).max()
            if height > 0.12 * sides.max():
                yield f"face {i} is not flat: {height / sides.max():.2f}"
            turn = np.cross(q - np.roll(q, 1, 0), np.roll(q, -1, 0) - q) @ n
            if turn.min() <= 0:
                yield f"face {i} is not convex"
    low, high = m.points.min(0), m.points.max(0)
    if np.abs(np.array(m.mesh.GetExtentAttr().Get()) - [low, high]).max() > 1e-4:
        yield "extent is not that of the points"
    world = UsdGeom.XformCache().GetLocalToWorldTransform(m.prim).ExtractTranslation()
    if low[1] + world[1] < 0 or high[1] + world[1] > 165 or high[0] - low[0] > 140:
        yield f"out of a person's size: {low} {high}"
    if abs(low[0] + high[0]) > 1.0:
        yield "not centred"
    # Outwards: the volume under the faces seen from the axis of the body is positive.
    q = m.points[m.indices[m.starts[:-1]]]
    axis = q * (0, 1, 0)
    if ((q - axis) * normals).sum() <= 0:
        yield "normals point inwards"


def _subsets(m):
    for name, (_, pairs) in m.subsets("edge").items():
        missing = [tuple(p) for p in pairs.reshape(-1, 2)
                   if tuple(sorted(map(int, p))) not in m.edge_keys]
        if missing:
            yield f"{name}: no edge {missing[0]}"
        if len({tuple(sorted(map(int, p))) for p in pairs.reshape(-1, 2)}) * 2 != len(pairs):
            yield f"{name}: an edge twice"
    for name, (_, points) in m.subsets("point").items():
        if not len(points) or points.max() >= len(m.points):
            yield f"{name}: no such point"
    count = np.zeros(len(m.faces), int)
    for s, faces in m.subsets("face").values():
        if s.GetFamilyNameAttr().Get() == "panels":
            count[faces] += 1
    if (count != 1).any():
        yield "panels are not a partition"
    chain = iter(m.mesh.GetCreaseIndicesAttr().Get())
    for n in m.mesh.GetCreaseLengthsAttr().Get():
        points = [next(chain) for _ in range(n)]
        for a, b in zip(points, points[1:]):
            if (min(a, b), max(a, b)) not in m.edge_keys:
                yield f"crease without an edge: {a} {b}"
    seams = uv_seams(m)
    for target in m.prim.GetRelationship("tailor:sim:constraints").GetTargets():
        pairs = m.subsets("edge")[target.name][1].reshape(-1, 2)
        hit = [p for p in pairs if tuple(sorted(map(int, p))) in seams]
        if hit:
            yield f"{target.name}: {len(hit)} of its edges are seams or borders"


def uv_seams(m):
    """Edges of the border, and edges whose two faces do not share both UV points."""
    first, seams, uses = {}, set(), {}
    for s, e in zip(m.starts, m.starts[1:]):
        for k in range(e - s):
            a, b = s + k, s + (k + 1) % (e - s)
            key = tuple(sorted((int(m.indices[a]), int(m.indices[b]))))
            ids = {m.indices[a]: m.uv_index[a], m.indices[b]: m.uv_index[b]}
            uses[key] = uses.get(key, 0) + 1
            if key in first and first[key] != ids:
                seams.add(key)
            first.setdefault(key, ids)
    return seams | {k for k, n in uses.items() if n == 1}


def uv_areas(m):
    out = np.zeros(len(m.faces))
    for i, (s, e) in enumerate(zip(m.starts, m.starts[1:])):
        q = m.uv[s:e]
        n = np.roll(q, -1, 0)
        out[i] = (q[:, 0] * n[:, 1] - q[:, 1] * n[:, 0]).sum() / 2
    return out


def _uvs(m):
    if m.uv.min() < 0 or m.uv.max() > 1:
        yield "outside of 0..1"
    areas = uv_areas(m)
    if (areas <= 0).any():
        yield f"{(areas <= 0).sum()} faces flipped"
    ratio = []
    for s, e in zip(m.starts, m.starts[1:]):
        p, q = m.points[m.indices[s:e]], m.uv[s:e] * m.unit
        ratio.append(np.linalg.norm(np.roll(q, -1, 0) - q, axis=1)
                     / np.linalg.norm(np.roll(p, -1, 0) - p, axis=1))
    off = np.abs(np.concatenate(ratio) - 1)
    if np.mean(off > STRETCH) > 0.02:
        yield f"{np.mean(off > STRETCH):.1%} of the edges are off scale by more than {STRETCH:.0%}"
    if off.max() > 0.6:
        yield f"an edge is off scale by {off.max():.0%}"


def _uv_overlap(m, size=1500):
    """Rasters the faces, a little shrunk, and looks for pixels taken twice."""
    taken = np.full((size, size), -1, np.int32)
    clashes = set()
    for i, (s, e) in enumerate(zip(m.starts, m.starts[1:])):
        q = m.uv[s:e]
        q = (q + (q.mean(0) - q) * 0.02) * size
        low = np.floor(q.min(0)).astype(int)
        high = np.ceil(q.max(0)).astype(int)
        y, x = np.mgrid[low[1]:high[1], low[0]:high[0]] + 0.5
        inside = np.ones(x.shape, bool)
        for a, b in zip(q, np.roll(q, -1, 0)):
            inside &= (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0
        box = taken[low[1]:high[1], low[0]:high[0]]
        clashes.update((int(j), i) for j in np.unique(box[inside]) if j >= 0)
        box[inside] = i
    if clashes:
        yield f"{len(clashes)} pairs of faces overlap, such as {sorted(clashes)[:3]}"


def _primvars(m):
    api = UsdGeom.PrimvarsAPI(m.prim)
    for name in ("simDensity", "thicknessWeight"):
        values = np.array(api.GetPrimvar(name).Get())
        if len(values) != len(m.points) or values.min() < 0 or values.max() > 1:
            yield f"{name} is not one value of 0..1 per point"
    weights = np.array(api.GetPrimvar("skel:jointWeights").Get()).reshape(len(m.points), 4)
    if np.abs(weights.sum(1) - 1).max() > 1e-4 or weights.min() < 0:
        yield "joint weights are not normalised"
    for pv in api.GetPrimvarsWithAuthoredValues():
        want = {"constant": 1, "uniform": len(m.faces), "vertex": len(m.points),
                "varying": len(m.points), "faceVarying": len(m.indices)}[pv.GetInterpolation()]
        flat = pv.ComputeFlattened()
        if hasattr(flat, "__len__") and len(flat) != want * pv.GetElementSize() and (
                pv.GetInterpolation() != "constant"):
            yield f"{pv.GetPrimvarName()} has {len(flat)} values for {want}"


# -------------------------------------------------------------------------- layers

def triangles(m):
    tris, face = [], []
    for i, f in enumerate(m.faces):
        for k in range(1, len(f) - 1):
            tris.append((f[0], f[k], f[k + 1]))
            face.append(i)
    return np.array(tris), np.array(face)


def _layers(m):
    """No edge of a triangle may pass through another triangle."""
    tris, face = triangles(m)
    hits = crossings(m.points, tris)
    if len(hits):
        pairs = {tuple(sorted((int(face[a]), int(face[b])))) for a, b in hits}
        where = m.points[tris[hits[0][0]]].mean(0)
        yield (f"{len(pairs)} pairs of faces cross, such as at {np.round(where, 1)}: "
               f"{sorted(pairs)[:6]}")


def crossings(points, tris):
    """Pairs (triangle of an edge, triangle it passes through), shared points left out."""
    p = points[tris]
    low, high = p.min(1), p.max(1)
    found = []
    # Along x, boxes that meet begin no farther before a box than the longest box is long.
    order = np.argsort(low[:, 0], kind="stable")
    first = np.searchsorted(low[order, 0], low[:, 0] - (high - low)[:, 0].max())
    last = np.searchsorted(low[order, 0], high[:, 0], "right")
    for i in range(len(tris)):
        near = np.sort(order[first[i]:last[i]])
        near = near[((low[near] <= high[i]) & (high[near] >= low[i])).all(1)]
        near = near[~np.isin(tris[near], tris[i]).any(1)]
        if not len(near):
            continue
        for k in range(3):
            a, b = p[i, k], p[i, (k + 1) % 3]
            hit = near[_pierces(a, b, p[near])]
            found += [(i, int(j)) for j in hit]
    return found


def _pierces(a, b, t):
    """Does the segment a b pass through each triangle."""
    d = b - a
    e1, e2 = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    h = np.cross(d, e2)
    det = (e1 * h).sum(1)
    ok = np.abs(det) > 1e-12
    inv = 1 / np.where(ok, det, 1)
    s = a - t[:, 0]
    u = (s * h).sum(1) * inv
    q = np.cross(s, e1)
    v = (q @ d) * inv
    w = (e2 * q).sum(1) * inv
    return ok & (u >= 0) & (v >= 0) & (u + v <= 1) & (w >= 0) & (w <= 1)
