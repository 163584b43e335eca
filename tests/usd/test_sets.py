"""Sets that expressions name, against sets that numpy and Python find in the stage that usd-core reads."""

import json
from collections import Counter, defaultdict
from itertools import permutations

import numpy as np
import pytest
from conftest import EXAMPLES, run
from mesh import find_model, read_mesh
from panels import suit  # noqa: F401
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import add_primvar, add_subset, bind, fin, patchwork, sheet, turned_face, write

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
            for i, v in enumerate(face):
                self.around[pair(v, face[(i + 1) % len(face)])].append((number, corner + i, corner + (i + 1) % len(face)))
            corner += len(face)
        self.faces, self.edges = set(range(len(self.faces_points))), set(self.around)
        self.order, self.beside = list(self.around), defaultdict(set)
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
        return [tuple(v) for v in primvar.rows] if primvar.indices is None else primvar.indices.tolist()

    def uv_seams(self, name="st"):
        """Edges at which some face has other values at the ends."""
        values, verts = self.corner_values(name), sum(self.faces_points, [])
        ends = {e: {frozenset((verts[c], values[c]) for c in at[1:]) for at in self.around[e]} for e in self.edges}
        return {edge for edge in self.edges if len(ends[edge]) > 1}

    def creases(self, least=0.0):
        return {edge for edge, sharpness in self.mesh.creases.items() if sharpness >= least}

    def normal(self, face):
        p = self.points[self.faces_points[face]]
        return np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)

    def centre(self, face):
        return self.points[self.faces_points[face]].mean(axis=0)

    def feature_lines(self, degrees=45.0):
        verts = sum(self.faces_points, [])

        def turn(f, a, g, b):
            n, m = (v / np.linalg.norm(v) for v in (self.normal(f), self.normal(g)))
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

    def material(self, name):
        bound = {key: s.material.rsplit("/", 1)[1] for key, s in self.mesh.subsets.items() if s.material}
        faces = {key: set(self.mesh.subsets[key].indices.tolist()) for key in bound}
        found = set().union(*(faces[key] for key in bound if bound[key] == name))
        rest = self.faces - set().union(*faces.values())
        return found | rest if self.mesh.material and self.mesh.material.endswith(f"/{name}") else found

    def value(self, name, wanted=None):
        values = self.mesh.primvars[name].flat[:, 0]
        return {i for i, value in enumerate(values) if (bool(value) if wanted is None else value == wanted)}

    def weight(self, name, least=0.5):
        return {i for i, value in enumerate(self.mesh.primvars[name].flat[:, 0]) if value > least}

    def subset(self, name):
        return set(self.mesh.subsets[name].indices.tolist())

    def rings(self, count=1, edges=(), faces=(), points=()):
        """Faces at the edges of the front, and at points between two of these; then the front is the edge of the faces."""
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
        centres, found = np.array([self.centre(face) for face in sorted(self.faces)]), set()
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
        return {face for face in self.faces if 0 <= u[face] < 10 and v[face] >= 0 and 1001 + u[face] + 10 * v[face] == tile}

    def pieces(self, kind, elements):
        """Faces and points hang together by edges, and edges by points at which two of them meet."""
        if kind == "face":
            return self.face_groups(elements)
        if kind == "point":
            return groups(sorted(elements), self.edges_between(elements))
        at = defaultdict(list)
        for edge in elements:
            for v in edge:
                at[v].append(edge)
        return groups([edge for edge in self.order if edge in elements], (two for two in at.values() if len(two) == 2))

    def measure(self, kind, piece, word):
        """How far a piece is in the direction of a word, or how large it is."""
        if word == "largest":
            of = {"point": lambda v: 1, "face": lambda f: np.linalg.norm(self.normal(f)) / 2}
            return sum(map(of.get(kind, lambda e: np.linalg.norm(self.points[e[0]] - self.points[e[1]])), piece))
        points = {"point": set, "face": self.points_of, "edge": lambda edges: {v for e in edges for v in e}}[kind](piece)
        at = self.stage_points[sorted(points)]
        axis, sign = WORDS[word] if isinstance(WORDS[word], tuple) else (self.up, WORDS[word])
        return sign * (at.min(axis=0) + at.max(axis=0))[axis] / 2


def command(usdtailor, path, *expressions, args=()):
    """The sets of some expressions as the command prints them."""
    bakes = [arg for number, text in enumerate(expressions) for arg in ("--bake", f"s{number}={text}")]
    return run(usdtailor, "sets", path, "--json", *bakes, *args)


def read(kind, indices):
    """The indices of a set as a set; no element is twice in it."""
    elements = [pair(*ends) for ends in zip(indices[::2], indices[1::2])] if kind == "edge" else indices
    assert len(set(elements)) == len(elements)
    return set(elements)


def found(usdtailor, path, *expressions, args=()):
    done = command(usdtailor, path, *expressions, args=args)
    assert done.returncode == 0, done.stderr
    entries = json.loads(done.stdout)["sets"]
    assert [entry["expression"] for entry in entries] == list(expressions)
    return [(entry["elementType"], read(entry["elementType"], entry["indices"])) for entry in entries]


def finish(mesh):
    """A UV set without indices whose last shell is one face, primvars of all kinds, subsets and materials."""
    count, points = len(mesh.GetFaceVertexCountsAttr().Get()), len(mesh.GetPointsAttr().Get())
    corners = np.array(mesh.GetPointsAttr().Get())[mesh.GetFaceVertexIndicesAttr().Get()][:, :2] * 0.1
    corners[-mesh.GetFaceVertexCountsAttr().Get()[-1] :] += 1
    st1 = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st1", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st1.Set([Gf.Vec2f(*map(float, uv)) for uv in corners])
    for name, kind, on, values in (
        ("flag", "bool", "uniform", [i % 3 == 0 for i in range(count)]),
        ("layer", "int", "uniform", [i % 2 + i // 5 for i in range(count)]),
        ("cloth", "token", "uniform", [["b 2", "linen"][i % 2] for i in range(count)]),
        ("worn", "float", "uniform", [i / count for i in range(count)]),
        ("mark", "int", "vertex", [i % 4 for i in range(points)]),
        ("pin", "float", "vertex", [i / points for i in range(points)]),
    ):
        add_primvar(mesh, name=name, type_name=kind, interpolation=on, values=values)
    add_subset(mesh, name="panel", indices=[0])
    add_subset(mesh, name="trim", indices=[count - 1], family="materialBind", material="wool")
    bind(mesh.GetPrim(), "silk")


CREASES = {(0, 1): 2.0, (1, 2): 0.5}
SMALL = {
    "sheet": {"shape": sheet, "seam_column": 2},
    "left": {"shape": sheet, "seam_column": 2, "options": {"orientation": "leftHanded"}},
    "ngons": {"shape": patchwork, "seam_column": 2},
    "fin": {"shape": fin},
    "turned": {"shape": turned_face, "seam_column": 1},
}


@pytest.fixture
def small(tmp_path):
    return lambda name: write(tmp_path / f"{name}.usda", creases=CREASES, finish=finish, **SMALL[name])


SMALL_SETS = [
    ("edge", "borders", lambda r: r.borders()), ("edge", "uvSeams", lambda r: r.uv_seams()),
    ("edge", "uvSeams(st1)", lambda r: r.uv_seams("st1")), ("edge", "creases", lambda r: r.creases()),
    ("edge", "creases(1)", lambda r: r.creases(1)), ("edge", "featureLines", lambda r: r.feature_lines()),
    ("edge", "featureLines(12.5)", lambda r: r.feature_lines(12.5)),
    ("edge", "border(value(flag))", lambda r: r.border(r.value("flag"))),
    ("edge", "border(faces)", lambda r: r.border(r.faces)),
    ("edge", "between(value(flag), value(layer, 1))", lambda r: r.between(r.value("flag"), r.value("layer", 1))),
    ("edge", "regions(layer)", lambda r: r.regions("layer")), ("edge", "edges", lambda r: r.edges),
    ("edge", "edges(weight(pin))", lambda r: r.edges_between(r.weight("pin"))),
    ("edge", "borders - creases", lambda r: r.borders() - r.creases()),
    ("edge", "borders & creases", lambda r: r.borders() & r.creases()),
    ("edge", "creases + uvSeams(st1)", lambda r: r.creases() | r.uv_seams("st1")),
    ("edge", "creases, uvSeams(st1)", lambda r: r.creases() | r.uv_seams("st1")),
    ("edge", "borders - edges(panel) & creases(1)", lambda r: r.borders() - (r.edges_of({0}) & r.creases(1))),
    ("edge", "(edges - edges(panel)) & borders", lambda r: (r.edges - r.edges_of({0})) & r.borders()),
    ("face", "faces", lambda r: r.faces), ("face", "faces(uvSeams(st1))", lambda r: r.faces_of(r.uv_seams("st1"))),
    ("face", "faces(weight(pin, 0.3))", lambda r: r.faces_between(r.weight("pin", 0.3))),
    ("face", "material(wool)", lambda r: r.material("wool")),
    ("face", 'material("silk")', lambda r: r.material("silk")), ("face", "value(flag)", lambda r: r.value("flag")),
    ("face", "value(flag, false)", lambda r: r.value("flag", False)),
    ("face", "value(layer, 1)", lambda r: r.value("layer", 1)),
    ("face", "value(cloth, linen)", lambda r: r.value("cloth", "linen")),
    ("face", 'value(cloth, "b 2")', lambda r: r.value("cloth", "b 2")),
    ("face", "weight(worn)", lambda r: r.weight("worn")),
    ("face", "rings(borders)", lambda r: r.rings(edges=r.borders())),
    ("face", "rings(creases, 2)", lambda r: r.rings(2, edges=r.creases())),
    ("face", "rings(panel)", lambda r: r.rings(faces={0})),
    ("face", "rings(value(cloth, linen) & weight(worn), 2)",
     lambda r: r.rings(2, faces=r.value("cloth", "linen") & r.weight("worn"))),
    ("face", "rings(weight(pin, 0.9), 2)", lambda r: r.rings(2, points=r.weight("pin", 0.9))),
    ("face", "within(creases, 1.2)", lambda r: r.within(r.creases(), 1.2)),
    ("face", "within(creases, 17mm)", lambda r: r.within(r.creases(), 1.7)), ("face", "uvShells", lambda r: r.faces),
    ("face", "uvShells(st1).2", lambda r: r.shells("st1")[1]), ("face", "shell(panel)", lambda r: r.shell({0})),
    ("face", "shell(trim, st1)", lambda r: r.shell(r.subset("trim"), "st1")),
    ("face", "udim(1001)", lambda r: r.udim(1001)), ("face", "udim(1012, st1)", lambda r: r.udim(1012, "st1")),
    ("face", "\"panel\" + 'trim'", lambda r: {0} | r.subset("trim")),
    ("point", "points", lambda r: set(range(len(r.points)))), ("point", "points(panel)", lambda r: r.points_of({0})),
    ("point", "points(creases)", lambda r: {0, 1, 2}), ("point", "value(mark, 3)", lambda r: r.value("mark", 3)),
    ("point", "value(mark)", lambda r: r.value("mark")),
    ("point", "weight(pin, 0.25)", lambda r: r.weight("pin", 0.25)),
]  # fmt: skip


def agree(usdtailor, path, kind, expression, expected):
    if expected:
        assert found(usdtailor, path, expression) == [(kind, expected)]
    else:
        done = command(usdtailor, path, expression)
        assert done.returncode == 1 and "has no elements" in done.stderr


@pytest.mark.parametrize("name", SMALL)
@pytest.mark.parametrize("kind, expression, of", SMALL_SETS, ids=[text for _, text, _ in SMALL_SETS])
def test_sets_of_small_meshes(usdtailor, small, name, kind, expression, of):
    path = small(name)
    agree(usdtailor, path, kind, expression, of(Reference.of(path)))


@pytest.fixture(scope="module", params=["tshirt", "coat"])
def example(request):
    path = EXAMPLES / f"{request.param}.usda"
    return path, Reference.of(path)


def sleeve(r):
    """The faces of the first sleeve."""
    values = r.mesh.primvars["pieceName"].flat[:, 0]
    return r.value("pieceName", next(value for value in values if value.startswith("sleeve")))


EXAMPLE_SETS = [
    ("edge", "uvSeams", lambda r: r.uv_seams()), ("edge", "creases(2.5)", lambda r: r.creases(2.5)),
    ("edge", "featureLines(30)", lambda r: r.feature_lines(30)),
    ("edge", "regions(pieceName)", lambda r: r.regions("pieceName")),
    ("edge", "border(trim) - borders", lambda r: r.border(r.subset("trim")) - r.borders()),
    ("edge", "between(material(ONE), stiff)", lambda r: r.between(r.material(r.one), r.subset("stiff"))),
    ("edge", "edges(weight(thicknessWeight, 0.8))", lambda r: r.edges_between(r.weight("thicknessWeight", 0.8))),
    ("edge", "hem & borders", lambda r: {pair(*p) for p in r.mesh.subsets["hem"].pairs} & r.borders()),
    ("face", "material(ONE)", lambda r: r.material(r.one)), ("face", "value(SLEEVE)", lambda r: sleeve(r)),
    ("face", "rings(uvSeams, 2)", lambda r: r.rings(2, edges=r.uv_seams())),
    ("face", "rings(stiff, 3)", lambda r: r.rings(3, faces=r.subset("stiff"))),
    ("face", "rings(buttons, 2)", lambda r: r.rings(2, points=r.subset("buttons"))),
    ("face", "within(borders, 4cm)", lambda r: r.within(r.borders(), 4)),
    ("face", "shell(value(SLEEVE))", lambda r: r.shell(sleeve(r))), ("face", "udim(1001)", lambda r: r.udim(1001)),
    ("point", "points(uvSeams) - points(borders)",
     lambda r: {v for e in r.uv_seams() for v in e} - {v for e in r.borders() for v in e}),
]  # fmt: skip


@pytest.mark.parametrize("kind, expression, of", EXAMPLE_SETS, ids=[text for _, text, _ in EXAMPLE_SETS])
def test_sets_of_the_examples(usdtailor, example, kind, expression, of):
    path, r = example
    r.one = r.mesh.material.rsplit("/", 1)[1]
    name = r.mesh.primvars["pieceName"].flat[min(sleeve(r)), 0]
    expected = of(r)
    assert expected, "the case is not empty"
    agree(usdtailor, path, kind, expression.replace("ONE", r.one).replace("SLEEVE", f"pieceName, {name}"), expected)


PIECES = [
    ("edge", "borders", lambda r: r.borders()),
    ("edge", "uvSeams", lambda r: r.uv_seams()),
    ("face", "value(layer, 1)", lambda r: r.value("layer", 1)),
    ("point", "weight(thicknessWeight, 0.8)", lambda r: r.weight("thicknessWeight", 0.8)),
    ("shell", "uvShells", lambda r: r.faces),
]


@pytest.mark.parametrize("kind, expression, of", PIECES, ids=[text for _, text, _ in PIECES])
def test_pieces_have_numbers_and_words(usdtailor, example, kind, expression, of):
    path, r = example
    pieces = r.shells() if kind == "shell" else r.pieces(kind, of(r))
    kind = "face" if kind == "shell" else kind
    numbered = found(usdtailor, path, *(f"{expression}.{i + 1}" for i in range(len(pieces))))
    assert numbered == [(kind, piece) for piece in pieces]
    done = command(usdtailor, path, f"{expression}.{len(pieces) + 1}")
    assert done.returncode == 1 and f"the set has {len(pieces)} pieces" in done.stderr
    for word, (_, piece) in zip(WORDS, found(usdtailor, path, *(f"{expression}.{word}" for word in WORDS))):
        assert piece in pieces
        assert r.measure(kind, piece, word) >= max(r.measure(kind, p, word) for p in pieces) - 1e-4, word


def test_the_list_has_all_sets_with_their_indices(usdtailor, example):
    path, r = example
    expected = {"creases": r.creases()}
    for name, pieces in (
        ("borders", r.pieces("edge", r.borders())),
        ("uvSeams", r.pieces("edge", r.uv_seams())),
        ("uvShells", r.shells()),
    ):
        expected |= {f"{name}.{i + 1}": piece for i, piece in enumerate(pieces)}
    materials = {path.rsplit("/", 1)[1] for path in (r.mesh.material, *(s.material for s in r.mesh.subsets.values())) if path}
    expected |= {f"material({name})": r.material(name) for name in materials}
    for name in ("layer", "pieceName"):
        values = set(r.mesh.primvars[name].flat[:, 0])
        expected |= {f"value({name}, {v if name == 'pieceName' else int(v)})": r.value(name, v) for v in values}
    expected |= {f"weight({name})": r.weight(name) for name in ("simDensity", "thicknessWeight")}
    done = command(usdtailor, path)
    listed = json.loads(done.stdout)["sets"]
    assert {s["expression"]: read(s["kind"][:-1], s["indices"]) for s in listed} == expected


@pytest.mark.parametrize("name", ["sheet", "left"])
@pytest.mark.parametrize("expression", ["border(panel)", "between(panel, faces - panel)"])
def test_the_first_faces_are_at_the_left_of_their_border(usdtailor, small, name, expression):
    """Seen from the outer side, which the winding and the orientation give."""
    path = small(name)
    r = Reference.of(path)
    indices = json.loads(command(usdtailor, path, expression).stdout)["sets"][0]["indices"]
    outer = r.normal(0) * (-1 if name == "left" else 1)
    for a, b in zip(r.points[indices[::2]], r.points[indices[1::2]]):
        assert np.cross(outer, b - a) @ (r.centre(0) - (a + b) / 2) > 0


@pytest.mark.parametrize("expression", ["borders", "uvSeams", "creases", "regions(pieceName)", "edges(trim)"])
def test_edges_of_a_chain_go_on_in_one_direction(usdtailor, example, expression):
    indices = json.loads(command(usdtailor, example[0], expression).stdout)["sets"][0]["indices"]
    starts, ends = Counter(indices[::2]), Counter(indices[1::2])
    assert all(starts[v] == 1 for v in indices if starts[v] + ends[v] == 2)


def tube(across=8, along=5):
    """A tube about the x axis, whose borders are rings of points at x = 0 and at x = `along`."""
    x, turn = np.divmod(np.arange(across * (along + 1)), across)
    angle = turn * 2 * np.pi / across
    a = np.arange(across * along)
    b = a - a % across + (a + 1) % across
    quads = np.stack([a, b, b + across, a + across], axis=1)
    return np.stack([x, np.cos(angle), np.sin(angle)], axis=1), np.full(len(quads), 4), quads.ravel()


@pytest.mark.parametrize("degrees, lowest", [(90, 5), (-90, 0)])
def test_places_are_those_of_the_stage(usdtailor, tmp_path, degrees, lowest):
    """A rotation about y by 90 degrees turns x down where z is up."""

    def turned(mesh):
        UsdGeom.SetStageUpAxis(mesh.GetPrim().GetStage(), UsdGeom.Tokens.z)
        UsdGeom.Xformable(mesh.GetPrim().GetParent()).AddRotateYOp().Set(degrees)

    path = write(tmp_path / "tube.usda", shape=tube, uv=False, finish=turned)
    r = Reference.of(path)
    words = ["lowest", "minZ", "highest", "maxZ"]
    sets = [piece for _, piece in found(usdtailor, path, *(f"borders.{word}" for word in words))]
    ends = [{edge for edge in r.borders() if r.points[edge[0]][0] == x} for x in (lowest, 5 - lowest)]
    assert sets == [ends[0], ends[0], ends[1], ends[1]] and len(ends[0]) == len(ends[1]) == 8
    assert all(r.measure("edge", s, w) == max(r.measure("edge", e, w) for e in ends) for s, w in zip(sets, words))


def test_sewn_edges_are_no_borders(usdtailor, suit):  # noqa: F811
    path = suit()
    stage, points, faces = Usd.Stage.Open(str(path)), [], []
    for name in ("front", "back"):
        prim = stage.GetPrimAtPath(f"/Suit/{name}")
        mesh = read_mesh(prim)
        matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        faces += (mesh.indices.reshape(-1, 4) + len(points)).tolist()
        points += (mesh.points @ matrix[:3, :3] + matrix[3, :3]).tolist()
    welded, number = np.unique(np.round(points, 4) + 0.0, axis=0, return_inverse=True)
    r = Reference(welded, number.ravel()[np.array(faces)])
    loops = r.pieces("edge", r.borders())
    done = command(usdtailor, path, args=["--all"])
    listed = [s for s in json.loads(done.stdout)["sets"] if s["expression"].startswith("borders.")]
    told = sorted((s["count"], *np.subtract(s["high"], s["low"]), 100 * s["size"]) for s in listed)
    boxes = [r.points[sorted({v for edge in loop for v in edge})] for loop in loops]
    sizes = [(len(p), *np.ptp(b, axis=0), r.measure("edge", p, "largest")) for p, b in zip(loops, boxes)]
    assert len(loops) == 4 and np.allclose(told, sorted(sizes), atol=1e-3)
    everything, sewn = found(usdtailor, path, "borders", "sewn", args=["--all"])
    assert len(everything[1]) == len(r.borders()) and not everything[1] & sewn[1]
