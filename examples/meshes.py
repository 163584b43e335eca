"""Reads the meshes of a USD stage as triangulated numpy arrays."""
import copy
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom


@dataclass
class Mesh:
    """A UsdGeomMesh in world space, triangulated."""
    path: str
    points: np.ndarray          # (V, 3)
    counts: np.ndarray          # (F,)
    indices: np.ndarray         # (sum of counts,)
    prim: Usd.Prim = None
    stage: Usd.Stage = None     # keeps the prim valid
    tris: np.ndarray = None     # (T, 3) point of each corner
    corners: np.ndarray = None  # (T, 3) face-vertex of each corner
    faces: np.ndarray = None    # (T,) face of each triangle
    real: np.ndarray = None     # (T, 3) True if the side opposite to corner i is an edge of the face

    def __post_init__(self):
        self.starts = np.concatenate([[0], np.cumsum(self.counts)[:-1]]).astype(np.int64)
        self._triangulate()

    def _triangulate(self):
        """Splits faces into fans, and quads along their shorter diagonal."""
        faces, corners, real = [], [], []
        for n in np.unique(self.counts):
            f = np.nonzero(self.counts == n)[0]
            base = self.starts[f]
            first = np.zeros(len(f), np.int64)
            if n == 4:
                quad = self.points[self.indices[base[:, None] + np.arange(4)]]
                d02 = np.linalg.norm(quad[:, 0] - quad[:, 2], axis=1)
                d13 = np.linalg.norm(quad[:, 1] - quad[:, 3], axis=1)
                first[d13 < d02 * 0.999] = 1
            for k in range(1, n - 1):
                local = (first[:, None] + np.array([0, k, k + 1])) % n
                corners.append(base[:, None] + local)
                faces.append(f)
                flags = np.array([True, k == n - 2, k == 1])
                real.append(np.broadcast_to(flags, (len(f), 3)))
        self.corners = np.concatenate(corners)
        self.faces = np.concatenate(faces)
        self.real = np.concatenate(real)
        self.tris = self.indices[self.corners]

    def part(self, kept):
        """A copy with the triangles `kept`."""
        part = copy.copy(self)
        for name in ("tris", "corners", "faces", "real"):
            setattr(part, name, getattr(self, name)[kept])
        return part

    def unfolded(self, name="st"):
        """The faces in the space of a UV set, each with points of its own."""
        got = self.primvar(name)
        if not got or got[2] != "faceVarying":
            raise SystemExit(f"no faceVarying primvar {name}")
        uv = got[0] if got[1] is None else got[0][got[1]]
        return Mesh(self.path, np.c_[uv, np.zeros(len(uv))], self.counts, np.arange(len(uv)), self.prim, self.stage)

    def edges(self):
        """The half-edge of each corner as a pair of points, from that corner to the next."""
        nxt = np.arange(len(self.indices)) + 1
        nxt[self.starts + self.counts - 1] = self.starts
        return np.stack([self.indices, self.indices[nxt]], axis=1)

    def border(self):
        """The edges with one face, as pairs of point indices."""
        pairs = np.sort(self.edges(), axis=1)
        unique, uses = np.unique(pairs, axis=0, return_counts=True)
        return unique[uses == 1]

    def corner_normals(self, flat=False):
        """Unit normals of the triangle corners: face normals if `flat`, else area-weighted means.

        A mean excludes faces that turn by 60 degrees or more from the corner's face, which keeps folds sharp."""
        p = self.points[self.tris]
        n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        face = np.zeros((len(self.counts), 3))
        np.add.at(face, self.faces, n)
        unit = face / np.maximum(np.linalg.norm(face, axis=1, keepdims=True), 1e-20)
        if flat:
            return np.repeat(unit[self.faces][:, None], 3, axis=1)
        # a, b: all pairs of face corners at the same point.
        point = self.indices
        owner = np.repeat(np.arange(len(self.counts)), self.counts)
        order = np.argsort(point, kind="stable")
        valence = np.bincount(point, minlength=len(self.points))
        first = np.concatenate([[0], np.cumsum(valence)[:-1]])
        n_pairs = valence[point]
        a = np.repeat(np.arange(len(point)), n_pairs)
        step = np.arange(len(a)) - np.repeat(np.cumsum(n_pairs) - n_pairs, n_pairs)
        b = order[first[point[a]] + step]
        near = (unit[owner[a]] * unit[owner[b]]).sum(1) > 0.5
        a, b = a[near], b[near]
        out = np.stack([np.bincount(a, face[owner[b], k], len(point)) for k in range(3)], 1)
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-20)
        return out[self.corners]

    def subsets(self, element="face", family=None):
        """(name, indices) of the GeomSubsets with an element type, and with a family if given."""
        found = []
        for s in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(self.prim)):
            if s.GetElementTypeAttr().Get() != element:
                continue
            if family and s.GetFamilyNameAttr().Get() != family:
                continue
            found.append((s.GetPrim().GetName(), np.array(s.GetIndicesAttr().Get() or [], int)))
        return found

    def primvar(self, name):
        """(values, indices or None, interpolation) of a primvar, or None."""
        pv = UsdGeom.PrimvarsAPI(self.prim).GetPrimvar(name)
        if not pv or not pv.HasValue():
            return None
        values = np.array(pv.Get())
        index = np.array(pv.GetIndices()) if pv.IsIndexed() else None
        return values, index, pv.GetInterpolation()

    def primvar_at_corners(self, name):
        """Values (T, 3, ...) of a primvar at the triangle corners, or None."""
        got = self.primvar(name)
        if got is None:
            return None
        values, index, interpolation = got
        if index is not None:
            values = values[index]
        if interpolation == "constant":
            return np.broadcast_to(values.reshape(1, 1, -1)[..., :3],
                                   self.tris.shape + (min(values.size, 3),))
        pick = {"uniform": np.repeat(self.faces[:, None], 3, 1), "faceVarying": self.corners,
                "vertex": self.tris, "varying": self.tris}[interpolation]
        return values[pick]


def load(path_or_stage, prim_paths=None, time=None):
    """The meshes of a stage in world space, or those at and below the given paths, without a time or at one."""
    stage = path_or_stage
    if not isinstance(stage, Usd.Stage):
        stage = Usd.Stage.Open(str(path_or_stage))
    roots = [stage.GetPrimAtPath(p) for p in prim_paths] if prim_paths else [stage.GetPseudoRoot()]
    at = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
    cache = UsdGeom.XformCache(at)
    out = []
    for root in roots:
        if not root:
            continue
        for prim in Usd.PrimRange(root):
            if not prim.IsA(UsdGeom.Mesh):
                continue
            mesh = UsdGeom.Mesh(prim)
            points = np.array(mesh.GetPointsAttr().Get(at) or [], float).reshape(-1, 3)
            counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], np.int64)
            if not len(points) or not len(counts):
                continue
            matrix = np.array(cache.GetLocalToWorldTransform(prim))
            points = np.c_[points, np.ones(len(points))] @ matrix
            indices = np.array(mesh.GetFaceVertexIndicesAttr().Get(), np.int64)
            if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
                points, counts, indices = points, counts, _reverse(counts, indices)
            out.append(Mesh(str(prim.GetPath()), points[:, :3], counts, indices, prim, stage))
    return out


def _reverse(counts, indices):
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    return np.concatenate([indices[s:s + c][::-1] for s, c in zip(starts, counts)])
