"""Sets of faces, edges and points that numpy and Python find in a stage, for tests of expressions."""

from collections import Counter, defaultdict
from itertools import permutations

import numpy as np
from mesh import find_model, read_mesh
from pxr import Usd, UsdGeom

WORDS = {"lowest": -1, "highest": 1, "minX": (0, -1), "maxX": (0, 1), "minY": (1, -1), "maxY": (1, 1), "minZ": (2, -1)}
WORDS |= {"maxZ": (2, 1), "largest": None}


def pair(a, b):
    return (int(min(a, b)), int(max(a, b)))


def groups(elements, links):
    """The connected groups of elements, each as a set."""
    group = {element: {element} for element in elements}
    for a, b in links:
        if group[a] is not group[b]:
            group[a] |= group[b]
            group |= dict.fromkeys(group[b], group[a])
    return list({id(group[element]): group[element] for element in elements}.values())


class Reference:
    """Sets of faces, of edges (pairs in ascending order) and of points of a mesh."""

    def __init__(self, points, faces, mesh=None, to_stage=np.eye(4), up=1):
        self.points, self.mesh, self.up = np.asarray(points), mesh, up
        self.faces_points = [[int(v) for v in face] for face in faces]
        self.stage_points = self.points @ to_stage[:3, :3]
        # For each edge, its faces with the corner at which each goes along it; edges are in the order of the faces.
        self.around, corner = defaultdict(list), 0
        for number, face in enumerate(self.faces_points):
            for i, j in zip(range(len(face)), [*range(1, len(face)), 0]):
                self.around[pair(face[i], face[j])].append((number, corner + i, corner + j))
            corner += len(face)
        self.faces, self.edges = set(range(len(self.faces_points))), set(self.around)
        corners = [self.points[face] for face in self.faces_points]
        self.centres = np.array([p.mean(axis=0) for p in corners])
        self.normals = [np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) for p in corners]
        self.order, self.beside, self.at = list(self.around), defaultdict(set), defaultdict(list)
        for edge in self.order:
            for v in edge:
                self.at[v].append(edge)
        for edge in self.edges:
            for f, g in permutations(self.faces_at(edge), 2):
                self.beside[f].add(g)

    @classmethod
    def of(cls, path):
        stage = Usd.Stage.Open(str(path))
        prim = find_model(stage)
        mesh = read_mesh(prim)
        matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        up = "XYZ".index(UsdGeom.GetStageUpAxis(stage))
        return cls(mesh.points, np.split(mesh.indices, np.cumsum(mesh.counts)[:-1]), mesh, matrix, up)

    def faces_at(self, edge):
        return [face for face, _, _ in self.around[edge]]

    def edges_of(self, faces):
        return {edge for edge in self.edges if set(self.faces_at(edge)) & faces}

    def faces_of(self, edges):
        return {face for edge in edges for face in self.faces_at(edge)}

    def points_of(self, faces):
        return {v for face in faces for v in self.faces_points[face]}

    def edges_between(self, points):
        return {edge for edge in self.edges if set(edge) <= points}

    def faces_between(self, points):
        return {face for face in self.faces if set(self.faces_points[face]) <= points}

    def borders(self):
        return {edge for edge, around in self.around.items() if len(around) == 1}

    def corner_values(self, name):
        primvar = self.mesh.primvars[name]
        return [tuple(v) for v in primvar.flat]

    def uv_seams(self, name="st"):
        """Edges at which some face has other values at the ends."""
        values, verts = self.corner_values(name), sum(self.faces_points, [])
        ends = {e: {frozenset((verts[c], values[c]) for c in at[1:]) for at in self.around[e]} for e in self.edges}
        return {edge for edge in self.edges if len(ends[edge]) > 1}

    def creases(self, least=0.0):
        return {edge for edge, sharpness in self.mesh.creases.items() if sharpness >= least}

    def feature_lines(self, degrees=45.0):
        verts = sum(self.faces_points, [])

        def turn(f, a, g, b):
            n, m = (v / np.linalg.norm(v) for v in (self.normals[f], self.normals[g]))
            return np.degrees(np.arccos(np.clip(n @ m * (-1 if verts[a] == verts[b] else 1), -1, 1)))

        pairs = {e: [*around[0][:2], *around[1][:2]] for e, around in self.around.items() if len(around) == 2}
        return {edge for edge, two in pairs.items() if turn(*two) > degrees}

    def border(self, faces):
        inside = {edge: [face in faces for face in self.faces_at(edge)] for edge in self.edges}
        return {e for e, are in inside.items() if any(are) and (not all(are) or len(are) == 1)}

    def between(self, first, second):
        return {e for e in self.edges if any(f in first and g in second for f, g in permutations(self.faces_at(e), 2))}

    def regions(self, name):
        values = self.mesh.primvars[name].flat[:, 0]
        return {edge for edge in self.edges if len({values[face] for face in self.faces_at(edge)}) > 1}

    @property
    def materials(self):
        bound = {self.mesh.material, *(subset.material for subset in self.mesh.subsets.values())} - {None}
        return {path.rsplit("/", 1)[1] for path in bound}

    def material(self, name):
        bound = {key: s.material.rsplit("/", 1)[1] for key, s in self.mesh.subsets.items() if s.material}
        faces = {key: set(self.mesh.subsets[key].indices.tolist()) for key in bound}
        found = set().union(*(faces[key] for key in bound if bound[key] == name))
        rest = self.faces - set().union(*faces.values())
        return found | rest if self.mesh.material and self.mesh.material.endswith(f"/{name}") else found

    def value(self, name, wanted=None, least=None):
        fits = (lambda v: v > least) if least is not None else bool if wanted is None else (lambda v: v == wanted)
        return {i for i, value in enumerate(self.mesh.primvars[name].flat[:, 0]) if fits(value)}

    def weight(self, name, least=0.5):
        return self.value(name, least=least)

    def subset(self, name):
        return set(self.mesh.subsets[name].indices.tolist())

    def rings(self, count=1, edges=(), faces=(), points=()):
        """Faces at the edges of the front, and at points between two of these. The next front is their outline."""
        faces, edges = set(faces), set(edges)
        if points:
            faces, count = {f for f in self.faces if set(self.faces_points[f]) & points}, count - 1
        for _ in range(count):
            front = edges or {e for e in self.edges_of(faces) if set(self.faces_at(e)) - faces}
            turns = {v for v, meeting in Counter(v for edge in front for v in edge).items() if meeting > 1}
            faces |= self.faces_of(front) | {f for f in self.faces if set(self.faces_points[f]) & turns}
            edges = set()
        return faces

    def within(self, edges, most):
        """Faces with centres that near to one of the edges, and connected to this edge by such faces."""
        centres, found = self.centres, set()
        for edge in edges:
            a, b = self.points[list(edge)]
            share = np.clip((centres - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            near = set(np.flatnonzero(np.linalg.norm(centres - a - share[:, None] * (b - a), axis=1) <= most).tolist())
            front = near & set(self.faces_at(edge))
            while front:
                near, found = near - front, found | front
                front = near & {g for f in front for g in self.beside[f]}
        return found

    def face_groups(self, faces, cut=()):
        inside = set(faces)
        links = (p for e in self.edges - set(cut) for p in permutations(set(self.faces_at(e)) & inside, 2))
        return groups(sorted(inside), links)

    def shells(self, name="st"):
        return self.face_groups(self.faces, self.uv_seams(name))

    def shell(self, faces, name="st"):
        return set().union(*(shell for shell in self.shells(name) if shell & faces))

    def udim(self, tile, name="st"):
        primvar = self.mesh.primvars[name]
        uvs = np.split(primvar.rows[primvar.corner_indices()], np.cumsum(self.mesh.counts)[:-1])
        u, v = np.floor([uv.mean(axis=0) for uv in uvs]).astype(int).T
        return {f for f in self.faces if 0 <= u[f] < 10 and 0 <= v[f] and 1001 + u[f] + 10 * v[f] == tile}

    def pieces(self, kind, elements):
        """Faces and points hang together by edges, and edges by points at which two of them meet."""
        if kind == "face":
            return self.face_groups(elements)
        if kind == "point":
            return groups(sorted(elements), self.edges_between(elements))
        at = {v: [edge for edge in edges if edge in elements] for v, edges in self.at.items()}
        return groups([edge for edge in self.order if edge in elements], (two for two in at.values() if len(two) == 2))

    def loops(self, edges):
        """The piece of the first line that has an edge: border, UV seam, crease; or else its row across quads."""
        found = set()
        lines = [self.pieces("edge", line) for line in (self.borders(), self.uv_seams(), self.creases())]
        for edge in edges:
            taken = ([piece for piece in pieces if edge in piece] for pieces in lines)
            found |= next((piece[0] for piece in taken if piece), None) or self.row(edge)
        return found

    def row(self, edge):
        """Edges that go on where four quads meet: the next one has no face in common."""
        found, open_ends = {edge}, [(edge, edge[0]), (edge, edge[1])]
        while open_ends:
            last, v = open_ends.pop()
            around = [e for e in self.at[v]]
            faces = {f for e in around for f in self.faces_at(e)}
            is_inner = all(len(self.around[e]) == 2 for e in around)
            if len(around) != 4 or len(faces) != 4 or not is_inner or any(len(self.faces_points[f]) != 4 for f in faces):
                continue
            (on,) = (e for e in around if not set(self.faces_at(e)) & set(self.faces_at(last)))
            if on not in found:
                found.add(on)
                open_ends.append((on, sum(on) - v))
        return found

    def length(self, edges):
        return sum(np.linalg.norm(self.points[a] - self.points[b]) for a, b in edges)

    def shortest(self, starts, ends):
        """The length of the shortest way along edges, by relaxing all of them until none is shorter (Bellman-Ford)."""
        a, b = np.array(sorted(self.edges)).T
        step = np.linalg.norm(self.points[a] - self.points[b], axis=1)
        best = np.full(len(self.points), np.inf)
        best[list(starts)] = 0
        while True:
            before = best.copy()
            np.minimum.at(best, b, best[a] + step)
            np.minimum.at(best, a, best[b] + step)
            if np.array_equal(before, best):
                return best[list(ends)].min()

    def checksum(self):
        """FNV-1a of the number of points of each face and of these points, each as four bytes."""
        value = 0x811C9DC5
        for number in (n for face in self.faces_points for n in (len(face), *face)):
            for byte in number.to_bytes(4, "little"):
                value = (value ^ byte) * 0x01000193 % 2**32
        return f"{value:08x}"

    def picked(self, kind, numbers):
        return f'picked{kind}("{self.checksum()}", "{numbers}")'

    def measure(self, kind, piece, word):
        """How far a piece is in the direction of a word, or how large it is."""
        if word == "largest":
            of = {"point": lambda v: 1, "face": lambda f: np.linalg.norm(self.normals[f]) / 2}
            return sum(map(of.get(kind, lambda e: np.linalg.norm(self.points[e[0]] - self.points[e[1]])), piece))
        points = self.points_of(piece) if kind == "face" else set(np.ravel(list(piece)))
        at = self.stage_points[sorted(points)]
        axis, sign = WORDS[word] if isinstance(WORDS[word], tuple) else (self.up, WORDS[word])
        return sign * (at.min(axis=0) + at.max(axis=0))[axis] / 2
