"""Reader of tests/golden/*.bin, meshes that OpenSubdiv subdivided; the format is described in xtask/src/golden.rs."""

import struct
from dataclasses import dataclass

import numpy as np

SCHEMES = ["bilinear", "catmullClark", "loop"]
BOUNDARIES = ["none", "edgeOnly", "edgeAndCorner"]
RULES = ["none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"]
# Cases of garments.bin: an example, and which of its values are refined as points, varying and face-varying ones.
GARMENTS = [
    "coat points bodyCoord st", "coat simDensity,thicknessWeight bodyCoord st1",
    "trousers points bodyCoord st", "trousers displayColor bodyCoord st",
    "tshirt points bodyCoord st", "tshirt simDensity,thicknessWeight bodyCoord st",
]  # fmt: skip


def garment_values(mesh, name):
    """The values that a case of GARMENTS names: rows of three and of two numbers, and a face-varying primvar."""
    _, vertex, varying, uv = name.split()
    painted = [mesh.points if part == "points" else mesh.primvars[part].flat for part in vertex.split(",")]
    rows = np.concatenate(painted, axis=1)
    return np.pad(rows, ((0, 0), (0, 3 - rows.shape[1]))), mesh.primvars[varying].flat, mesh.primvars[uv]


@dataclass
class Face:
    index: int
    base_face: int
    hole: bool
    vertices: np.ndarray
    points: np.ndarray
    varying: np.ndarray
    slots: np.ndarray  # corner, slot, component
    edge_sharpness: np.ndarray
    vertex_sharpness: np.ndarray


@dataclass
class Level:
    vertices: int
    edges: int
    faces: int
    point_sum: np.ndarray  # over all corners of all faces, as the other sums
    varying_sum: np.ndarray
    slot_sums: np.ndarray
    sharpness_sum: float
    samples: list


@dataclass
class Case:
    name: str
    scheme: str
    boundary: str
    triangles: str
    slots: list
    points: np.ndarray
    varying: np.ndarray
    counts: np.ndarray
    indices: np.ndarray
    creases: dict
    corners: dict
    holes: np.ndarray
    uvs: np.ndarray
    uv_indices: np.ndarray
    levels: list


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def one(self, kind):
        (value,) = struct.unpack_from("<" + kind, self.data, self.at)
        self.at += struct.calcsize("<" + kind)
        return value

    def many(self, kind, count, width=1):
        values = np.frombuffer(self.data, np.dtype(kind).newbyteorder("<"), count * width, self.at)
        self.at += values.nbytes
        return values.reshape(count, width) if width > 1 else values

    def text(self):
        length = self.one("H")
        self.at += length
        return self.data[self.at - length : self.at].decode()


def load(path):
    reader = Reader(path.read_bytes())
    assert reader.many("u1", 8).tobytes() == b"SUBDGOLD"
    assert reader.one("I") == 1
    return [read_case(reader) for _ in range(reader.one("I"))]


def read_case(r):
    name = r.text()
    scheme, boundary, smooth, slot_count = (r.one("B") for _ in range(4))
    slots = list(r.many("u1", 6))
    vertices = r.many("f4", r.one("I"), 5)
    counts = r.many("u2", r.one("I")).astype(int)
    indices = r.many("u2", r.one("I")).astype(int)
    creases = {}
    for _ in range(r.one("I")):
        a, b, sharpness = r.one("H"), r.one("H"), r.one("f")
        creases[min(a, b), max(a, b)] = sharpness
    corners = {r.one("H"): r.one("f") for _ in range(r.one("I"))}
    holes = r.many("u2", r.one("I")).astype(int)
    uvs = r.many("f4", r.one("I"), 2)
    uv_indices = r.many("u2", len(indices)).astype(int)
    levels = [read_level(r, slot_count) for _ in range(3)]
    return Case(
        name, SCHEMES[scheme], BOUNDARIES[boundary], "smooth" if smooth else "catmullClark", slots, vertices[:, :3], vertices[:, 3:],
        counts, indices, creases, corners, holes, uvs, uv_indices, levels,
    )  # fmt: skip


def read_level(r, slot_count):
    vertices, edges, faces, _ = (r.one("I") for _ in range(4))
    points, varying, slots, sharpness = r.many("f8", 3), r.many("f8", 2), r.many("f8", slot_count * 2), r.one("d")
    samples = [read_face(r, slot_count) for _ in range(r.one("I"))]
    return Level(vertices, edges, faces, points, varying, slots.reshape(-1, 2), sharpness, samples)


def read_face(r, slot_count):
    index, base, hole, corners = r.one("I"), r.one("H"), bool(r.one("B")), r.one("B")
    shapes = ((corners, 3), (corners, 2), (corners, slot_count, 2), corners, corners)
    face = Face(index, base, hole, np.zeros(corners, int), *map(np.zeros, shapes))
    for c in range(corners):
        face.vertices[c] = r.one("I")
        flags = r.one("B")
        face.points[c], face.varying[c] = r.many("f4", 3), r.many("f4", 2)
        face.slots[c] = r.many("f4", 2)
        face.edge_sharpness[c] = r.one("f") if flags & 1 else 0
        face.vertex_sharpness[c] = r.one("f") if flags & 2 else 0
        for slot in range(1, slot_count):
            if flags & (1 << (1 + slot)):
                face.slots[c, slot] = r.many("f4", 2)
    return face
