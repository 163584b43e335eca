"""A UsdGeomMesh with its subsets and primvars as numpy arrays, and what follows from them."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

NUMBERS = (
    "bool int uint uchar int64 uint64 half float double timecode "
    "int2 int3 int4 half2 half3 half4 float2 float3 float4 double2 double3 double4 "
    "point3h point3f point3d vector3h vector3f vector3d normal3h normal3f normal3d color3h color3f color3d "
    "color4h color4f color4d texCoord2h texCoord2f texCoord2d texCoord3h texCoord3f texCoord3d "
    "quath quatf quatd matrix2d matrix3d matrix4d"
).split()
DISCRETE = "bool int uint uchar int64 uint64 int2 int3 int4 string token asset".split()


@dataclass
class Primvar:
    name: str
    type_name: str
    interpolation: str
    element_size: int
    values: list | np.ndarray  # as authored
    indices: np.ndarray | None

    @property
    def element(self):
        """The type of one value."""
        return self.type_name.removesuffix("[]")

    @property
    def is_discrete(self):
        return self.element in DISCRETE

    @property
    def is_skinning(self):
        return self.name in ("skel:jointIndices", "skel:jointWeights")

    @cached_property
    def rows(self):
        """Numbers of each authored value, or the values themselves where they are not numbers."""
        if self.element not in NUMBERS:
            return np.array([str(value) for value in self.values], dtype=object).reshape(-1, self.element_size)
        return numbers(self.values).reshape(len(self.values) // self.element_size, -1)

    @cached_property
    def flat(self):
        """As `rows`, one for each element of the mesh."""
        return self.rows if self.indices is None else self.rows[self.indices]

    def corner_indices(self):
        """Face-varying topology: the authored indices; without any, each corner has a value of its own."""
        return np.arange(len(self.rows)) if self.indices is None else self.indices


def numbers(values):
    """Any numeric USD array as rows of floats."""
    values = list(values) if not isinstance(values, np.ndarray) else values
    if len(values) == 0:
        return np.zeros((0, 1))
    first = values[0]
    if hasattr(first, "GetImaginary"):  # quaternions, which numpy does not know
        return np.array([[value.GetReal(), *value.GetImaginary()] for value in values], dtype=float)
    if hasattr(first, "GetValue"):  # time codes
        return np.array([[value.GetValue()] for value in values], dtype=float)
    array = np.array(values, dtype=float)
    return array.reshape(len(values), -1)


def starts(counts):
    """The first of each of the groups of these sizes, which follow each other."""
    return np.cumsum(counts) - counts


def around_faces(counts):
    """For each corner its place in its face, and the corner after it."""
    corners, count = np.arange(counts.sum()), np.repeat(counts, counts)
    place = corners - np.repeat(starts(counts), counts)
    return place, corners + 1 - np.where(place == count - 1, count, 0)


@dataclass
class Topology:
    """Faces with their edges: `corner_edge[c]` is the edge that runs from corner `c` to the next of its face."""

    counts: np.ndarray
    indices: np.ndarray  # vertex of each corner
    vertex_count: int

    def __post_init__(self):
        self.corner_face = np.repeat(np.arange(len(self.counts)), self.counts)
        _, self.next_corner = around_faces(self.counts)
        ends = np.stack([self.indices, self.indices[self.next_corner]], axis=1)
        self.forward = ends[:, 0] < ends[:, 1]
        keys, self.corner_edge = np.unique(self.keys(ends), return_inverse=True)
        self.edges = np.stack(np.divmod(keys, max(self.vertex_count, 1)), axis=1)
        self.edge_faces = np.bincount(self.corner_edge, minlength=len(self.edges))

    def keys(self, pairs):
        """A number for each pair of vertices, the same both ways."""
        return pairs.min(axis=1) * max(self.vertex_count, 1) + pairs.max(axis=1)

    def edge_ids(self, pairs):
        """The edge of each pair of vertices; -1 where there is none."""
        keys, wanted = self.keys(self.edges), self.keys(np.asarray(pairs, dtype=int).reshape(-1, 2))
        at = np.searchsorted(keys, wanted)
        return np.where(np.append(keys, -1)[at] == wanted, at, -1)

    def non_manifold_edges(self):
        """Edges of more than two faces, or of two that run along it in the same direction."""
        forward = np.bincount(self.corner_edge, weights=self.forward, minlength=len(self.edges))
        return (self.edge_faces > 2) | ((self.edge_faces == 2) & (forward != 1))

    def fans(self):
        """For each vertex the number of groups of faces that hang together around it by edges."""
        corners = np.arange(len(self.indices))
        # A corner hangs on the edge from it and on the edge to it, each at its own vertex.
        members = np.concatenate([corners, self.next_corner])
        spokes = np.stack([self.indices[members], np.tile(self.corner_edge, 2)], axis=1)
        label = groups(members, np.unique(spokes, axis=0, return_inverse=True)[1].ravel(), len(corners))
        return np.bincount(self.indices[np.unique(label, return_index=True)[1]], minlength=self.vertex_count)


@dataclass
class Subset:
    name: str
    element_type: str
    family: str
    indices: np.ndarray
    material: str | None
    prim: object = None

    @property
    def pairs(self):
        return self.indices.reshape(-1, 2)


@dataclass
class Mesh:
    prim: object
    points: np.ndarray
    counts: np.ndarray
    indices: np.ndarray
    scheme: str
    orientation: str
    boundary: str
    face_varying: str
    triangles: str
    holes: np.ndarray
    creases: dict  # pair of vertices, ascending: sharpness
    corners: dict
    primvars: dict
    subsets: dict
    families: dict  # name: type
    material: str | None
    extent: np.ndarray | None = None
    extra: dict = field(default_factory=dict)

    @cached_property
    def topology(self):
        return Topology(self.counts, self.indices, len(self.points))

    @cached_property
    def doubled(self):
        """For each point the first point of a border at its place, or the point itself."""
        first, at = np.arange(len(self.points)), {}
        for point in np.unique(self.topology.edges[self.topology.edge_faces == 1]):
            first[point] = at.setdefault(tuple(self.points[point]), point)
        return first

    def sewn(self):
        """The mesh with each doubled point once, as products have it."""
        kept, number = np.unique(self.doubled, return_inverse=True)
        rows = lambda primvar: primvar.interpolation in ("vertex", "varying") and primvar.indices is None  # noqa: E731
        of_points = {
            name: replace(primvar, values=[primvar.values[i * primvar.element_size + k] for i in kept.tolist() for k in range(primvar.element_size)])
            for name, primvar in self.primvars.items()
            if rows(primvar)
        }
        subsets = {name: replace(s, indices=s.indices if s.element_type == "face" else number[s.indices]) for name, s in self.subsets.items()}
        assert not self.creases and not self.corners, "not sewn here"
        return replace(self, points=self.points[kept], indices=number[self.indices], primvars=self.primvars | of_points, subsets=subsets)

    @cached_property
    def face_centres(self):
        sums = np.zeros((len(self.counts), 3))
        np.add.at(sums, self.topology.corner_face, self.points[self.indices])
        return sums / self.counts[:, None]

    @cached_property
    def face_areas(self):
        """Length of the vector area of each face."""
        here, there = self.points[self.indices], self.points[self.indices[self.topology.next_corner]]
        vector = np.zeros((len(self.counts), 3))
        np.add.at(vector, self.topology.corner_face, np.cross(here, there) / 2)
        return np.linalg.norm(vector, axis=1)

    def uv_shells(self, name="st"):
        """The connected regions of faces in UV space: a number for each face."""
        primvar = self.primvars[name]
        corners = np.stack([self.indices, primvar.corner_indices()], axis=1)
        vertices = np.unique(corners, axis=0, return_inverse=True)[1].ravel()
        return components(self.topology, vertices)

    def uv_cuts(self, name="st"):
        """The inner edges across which the UVs are cut: an array of bool."""
        indices = self.primvars[name].corner_indices()
        return cut_edges(self.topology, indices)

    def uv_areas(self, name="st"):
        """The signed area of each face in UV space."""
        uv = self.primvars[name].rows[self.primvars[name].corner_indices()]
        here, there = uv, uv[self.topology.next_corner]
        areas = np.zeros(len(self.counts))
        np.add.at(areas, self.topology.corner_face, (here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]) / 2)
        return areas


class Children:
    """Where the elements of a mesh are in its refinement, whose faces are in OpenSubdiv's order.

    Children of face 0 come first, in the order of its corners. The child at corner j of a quad keeps that corner as its
    own corner j; children of other faces begin with it.
    """

    def __init__(self, source, refined, level):
        self.source, self.refined = source, refined
        self.face_children = source.counts * 4 ** (level - 1) if level else np.ones_like(source.counts)
        self.first_child = starts(self.face_children)
        self.parent_face = np.repeat(np.arange(len(source.counts)), self.face_children)
        # For each corner those of the refinement from which the pieces of its edge run, in their order.
        self.pieces, self.counts = np.arange(len(source.indices))[:, None], source.counts
        for _ in range(level):
            kept, (_, onward) = kept_corners(self.counts), around_faces(self.counts)
            # The piece from a corner to the middle of its edge, and that on to the next corner.
            halves = np.stack([kept, kept[onward] // 4 * 4 + (kept[onward] + 3) % 4], axis=1)
            self.pieces, self.counts = halves[self.pieces].reshape(len(self.pieces), -1), np.full(len(kept), 4)
        self.vertices = np.full(len(source.points), -1)
        self.vertices[source.indices] = refined.indices[self.pieces[:, 0]]

    def edges(self, base_edges):
        """The edges that edges of the source became."""
        pieces = self.pieces[np.isin(self.source.topology.corner_edge, base_edges)]
        return np.unique(self.refined.topology.corner_edge[pieces])


def kept_corners(counts):
    """For each corner the corner of its child that is at the same point; the centre of its face is two further on."""
    place, _ = around_faces(counts)
    return 4 * np.arange(len(place)) + np.where(np.repeat(counts, counts) == 4, place, 0)


def cut_edges(topology, corner_values):
    """The edges of two or more faces at one end of which the faces have different values."""
    ends = np.stack([corner_values, corner_values[topology.next_corner]], axis=1)
    ends = np.where(topology.forward[:, None], ends, ends[:, ::-1])
    low, high = np.full((len(topology.edges), 2), np.iinfo(np.int64).max), np.full((len(topology.edges), 2), -1)
    np.minimum.at(low, topology.corner_edge, ends)
    np.maximum.at(high, topology.corner_edge, ends)
    return (topology.edge_faces > 1) & (low != high).any(axis=1)


def components(topology, corner_vertices):
    """Numbers the groups of faces that share an edge whose ends are the same `corner_vertices` on both sides."""
    ends = np.stack([corner_vertices, corner_vertices[topology.next_corner]], axis=1)
    edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)[1].ravel()
    return groups(topology.corner_face, edge, len(topology.counts))


def border_loops(topology):
    """How many loops the edges of one face form: groups of them that share vertices."""
    edges = topology.edges[topology.edge_faces == 1]
    label = groups(edges.ravel(), np.repeat(np.arange(len(edges)), 2), topology.vertex_count)
    return len(np.unique(label[edges]))


def groups(members, links, count):
    """Numbers the groups of `count` elements: the members at which links are equal are in one group."""
    group = np.arange(count)
    while True:
        smallest = np.full(links.max(initial=-1) + 1, count)
        np.minimum.at(smallest, links, group[members])
        now = group.copy()
        np.minimum.at(now, members, smallest[links])
        now = now[now]
        if np.array_equal(now, group):
            return np.unique(group, return_inverse=True)[1]
        group = now


def find_model(stage, path=None):
    """The one mesh of a source stage."""
    if path:
        return stage.GetPrimAtPath(path)
    (mesh,) = (prim for prim in stage.Traverse(Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh))
    return mesh


def recipe(prim, key, fallback):
    """The value of `sim.uvSet` and its like that the prim asks for."""
    attribute = prim.GetAttribute("tailor:" + key.replace(".", ":"))
    value = attribute.Get() if attribute else None
    return fallback if value is None else value


def read_mesh(prim, time=Usd.TimeCode.Default()):
    assert prim and prim.IsA(UsdGeom.Mesh), f"no mesh at {prim}"
    mesh = UsdGeom.Mesh(prim)

    def array(attribute, dtype):
        value = attribute.Get(time)
        return np.array(value if value is not None else [], dtype=dtype)

    extent = mesh.GetExtentAttr().Get(time)
    return Mesh(
        prim=prim,
        points=array(mesh.GetPointsAttr(), float).reshape(-1, 3),
        counts=array(mesh.GetFaceVertexCountsAttr(), int),
        indices=array(mesh.GetFaceVertexIndicesAttr(), int),
        scheme=mesh.GetSubdivisionSchemeAttr().Get(),
        orientation=mesh.GetOrientationAttr().Get(),
        boundary=mesh.GetInterpolateBoundaryAttr().Get(time),
        face_varying=mesh.GetFaceVaryingLinearInterpolationAttr().Get(time),
        triangles=mesh.GetTriangleSubdivisionRuleAttr().Get(time),
        holes=array(mesh.GetHoleIndicesAttr(), int),
        creases=read_creases(mesh, array),
        corners=dict(zip(array(mesh.GetCornerIndicesAttr(), int).tolist(), array(mesh.GetCornerSharpnessesAttr(), float))),
        primvars={primvar.GetPrimvarName(): read_primvar(primvar, time) for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues()},
        subsets={subset.GetPrim().GetName(): read_subset(subset, time) for subset in UsdGeom.Subset.GetAllGeomSubsets(mesh)},
        families={name: UsdGeom.Subset.GetFamilyType(mesh, name) for name in UsdGeom.Subset.GetAllGeomSubsetFamilyNames(mesh)},
        material=bound_material(prim),
        extent=None if extent is None else np.array(extent, dtype=float),
    )


def read_creases(mesh, array):
    indices, lengths = array(mesh.GetCreaseIndicesAttr(), int), array(mesh.GetCreaseLengthsAttr(), int)
    sharpnesses = iter(array(mesh.GetCreaseSharpnessesAttr(), float))
    per_crease = len(array(mesh.GetCreaseSharpnessesAttr(), float)) == len(lengths)
    creases, start = {}, 0
    for length in lengths:
        line = indices[start : start + length]
        start += length
        value = next(sharpnesses) if per_crease else None
        for a, b in zip(line[:-1], line[1:]):
            pair = (int(min(a, b)), int(max(a, b)))
            creases[pair] = float(value if per_crease else next(sharpnesses))
    return creases


def read_primvar(primvar, time):
    indices = primvar.GetIndices(time) if primvar.IsIndexed() else None
    values = primvar.Get(time)
    if not primvar.GetTypeName().isArray:
        values = [values]
    return Primvar(
        primvar.GetPrimvarName(),
        str(primvar.GetTypeName()),
        primvar.GetInterpolation(),
        primvar.GetElementSize(),
        values,
        None if indices is None else np.array(indices, dtype=int),
    )


def read_subset(subset, time):
    return Subset(
        subset.GetPrim().GetName(),
        subset.GetElementTypeAttr().Get(),
        subset.GetFamilyNameAttr().Get() or "",
        np.array(subset.GetIndicesAttr().Get(time) or [], dtype=int),
        bound_material(subset.GetPrim(), inherited=False),
        subset.GetPrim(),
    )


def own_material(mesh):
    """The path of the material of a mesh, which products with other materials bind by a face set."""
    rest = mesh.subsets.get("tailorMaterial")
    return rest.material if rest else mesh.material


def bound_material(prim, inherited=True):
    """The path of the material that a prim is drawn with, or is bound to itself."""
    api = UsdShade.MaterialBindingAPI(prim)
    if not inherited:
        targets = api.GetDirectBindingRel().GetTargets()
        return str(targets[0]) if targets else None
    material, _ = api.ComputeBoundMaterial()
    return str(material.GetPath()) if material else None
