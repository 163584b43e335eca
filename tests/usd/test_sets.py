"""Sets that expressions name, against sets that numpy and Python find in the stage that usd-core reads."""

import json
from collections import Counter

import numpy as np
import pytest
from conftest import EXAMPLES, run
from mesh import find_model, read_mesh
from panels import suit  # noqa: F401
from pxr import Gf, Sdf, Usd, UsdGeom
from reference_sets import pair, Reference, WORDS
from sources import add_primvar, add_subset, bind, fin, patchwork, sheet, turned_face, write


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


SMALL_SETS = {
    "edge": {
        "borders": lambda r: r.borders(), "uvSeams": lambda r: r.uv_seams(),
        "uvSeams(st1)": lambda r: r.uv_seams("st1"), "creases": lambda r: r.creases(),
        "creases(1)": lambda r: r.creases(1), "featureLines": lambda r: r.feature_lines(),
        "featureLines(12.5)": lambda r: r.feature_lines(12.5),
        "border(value(flag))": lambda r: r.border(r.value("flag")), "border(faces)": lambda r: r.border(r.faces),
        "between(value(flag), value(layer, 1))": lambda r: r.between(r.value("flag"), r.value("layer", 1)),
        "regions(layer)": lambda r: r.regions("layer"), "edges": lambda r: r.edges,
        "edges(weight(pin))": lambda r: r.edges_between(r.weight("pin")),
        "borders & creases": lambda r: r.borders() & r.creases(),
        "creases, uvSeams(st1)": lambda r: r.creases() | r.uv_seams("st1"),
        "borders - edges(panel) & creases(1)": lambda r: r.borders() - (r.edges_of({0}) & r.creases(1)),
        "(edges - edges(panel)) & borders": lambda r: (r.edges - r.edges_of({0})) & r.borders(),
    },
    "face": {
        "faces": lambda r: r.faces, "faces(uvSeams(st1))": lambda r: r.faces_of(r.uv_seams("st1")),
        "faces(weight(pin, 0.3))": lambda r: r.faces_between(r.weight("pin", 0.3)),
        "material(wool)": lambda r: r.material("wool"), 'material("silk")': lambda r: r.material("silk"),
        "value(flag)": lambda r: r.value("flag"), "value(flag, false)": lambda r: r.value("flag", False),
        "value(layer, 1)": lambda r: r.value("layer", 1), "value(cloth, linen)": lambda r: r.value("cloth", "linen"),
        'value(cloth, "b 2")': lambda r: r.value("cloth", "b 2"), "weight(worn)": lambda r: r.weight("worn"),
        "rings(borders)": lambda r: r.rings(edges=r.borders()),
        "rings(creases, 2)": lambda r: r.rings(2, edges=r.creases()), "rings(panel)": lambda r: r.rings(faces={0}),
        "rings(value(layer, 2), 2)": lambda r: r.rings(2, faces=r.value("layer", 2)),
        "rings(weight(pin, 0.9), 2)": lambda r: r.rings(2, points=r.weight("pin", 0.9)),
        "within(creases, 1.2)": lambda r: r.within(r.creases(), 1.2),
        "within(creases, 17mm)": lambda r: r.within(r.creases(), 1.7), "uvShells": lambda r: r.faces,
        "uvShells(st1).2": lambda r: r.shells("st1")[1], "shell(panel)": lambda r: r.shell({0}),
        "shell(trim, st1)": lambda r: r.shell(r.subset("trim"), "st1"), "udim(1001)": lambda r: r.udim(1001),
        "udim(1012, st1)": lambda r: r.udim(1012, "st1"), "\"panel\" + 'trim'": lambda r: {0} | r.subset("trim"),
    },
    "point": {
        "points": lambda r: set(range(len(r.points))), "points(panel)": lambda r: r.points_of({0}),
        "points(creases)": lambda r: {0, 1, 2}, "value(mark, 3)": lambda r: r.value("mark", 3),
        "value(mark)": lambda r: r.value("mark"), "weight(pin, 0.25)": lambda r: r.weight("pin", 0.25),
    },
}  # fmt: skip


def each(table):
    """A test for each set of a table: the kind of its elements, the expression, and what finds it in the reference."""
    cases = [(kind, text, of) for kind, sets in table.items() for text, of in sets.items()]
    return pytest.mark.parametrize("kind, expression, of", cases, ids=[text for _, text, _ in cases])


def agree(usdtailor, path, kind, expression, expected):
    if expected:
        assert found(usdtailor, path, expression) == [(kind, expected)]
    else:
        done = command(usdtailor, path, expression)
        assert done.returncode == 1 and "has no elements" in done.stderr


@pytest.mark.parametrize("name", SMALL)
@each(SMALL_SETS)
def test_sets_of_small_meshes(usdtailor, small, name, kind, expression, of):
    path = small(name)
    agree(usdtailor, path, kind, expression, of(Reference.of(path)))


@pytest.fixture(scope="module", params=["tshirt", "coat"])
def example(request):
    path = EXAMPLES / f"{request.param}.usda"
    return path, Reference.of(path)


EXAMPLE_SETS = {
    "edge": {
        "creases(2.5)": lambda r: r.creases(2.5), "featureLines(30)": lambda r: r.feature_lines(30),
        "regions(pieceName)": lambda r: r.regions("pieceName"),
        "border(trim) - borders": lambda r: r.border(r.subset("trim")) - r.borders(),
        "between(value(layer, 0), stiff)": lambda r: r.between(r.value("layer", 0), r.subset("stiff")),
        "hem & borders": lambda r: {pair(*p) for p in r.mesh.subsets["hem"].pairs} & r.borders(),
    },
    "face": {
        "rings(uvSeams, 2)": lambda r: r.rings(2, edges=r.uv_seams()),
        "rings(stiff, 3)": lambda r: r.rings(3, faces=r.subset("stiff")),
        "rings(buttons, 2)": lambda r: r.rings(2, points=r.subset("buttons")),
        "within(borders, 4cm)": lambda r: r.within(r.borders(), 4),
        "shell(stiff)": lambda r: r.shell(r.subset("stiff")), "udim(1001)": lambda r: r.udim(1001),
    },
    "point": {"points(uvSeams)": lambda r: {v for edge in r.uv_seams() for v in edge}},
}  # fmt: skip


@each(EXAMPLE_SETS)
def test_sets_of_the_examples(usdtailor, example, kind, expression, of):
    path, r = example
    agree(usdtailor, path, kind, expression, of(r))


LOOPS = ["edges(faces - rings(borders))", "creases & edges(stiff)", "uvSeams.2", "borders.1", "edges(stiff)"]


@pytest.mark.parametrize("edges", LOOPS)
def test_loops_are_lines_of_the_garment_or_rows_of_quads(usdtailor, example, edges):
    path, r = example
    for _, given in found(usdtailor, path, edges):
        # A few edges of each set, as one of all would have all loops.
        for chosen in (sorted(given)[:1], sorted(given)[-2:]):
            numbers = ", ".join(f"{a}-{b}" for a, b in chosen)
            text = f"loops({r.picked('Edges', numbers)})"
            assert found(usdtailor, path, text) == [("edge", r.loops(chosen))], chosen


@pytest.mark.parametrize("name", SMALL)
def test_loops_of_small_meshes(usdtailor, small, name):
    path = small(name)
    r = Reference.of(path)
    texts = {edge: f"loops({r.picked('Edges', f'{edge[1]}-{edge[0]}')})" for edge in sorted(r.edges)}
    expected = [("edge", r.loops([edge])) for edge in texts]
    assert found(usdtailor, path, *texts.values()) == expected


def test_paths_join_their_ends_and_are_not_much_longer_than_the_shortest(usdtailor, example):
    path, r = example
    edges = sorted(r.edges - r.borders())
    for a, b in zip(edges[:: len(edges) // 4], edges[7 :: len(edges) // 4]):
        ends = [r.picked("Edges", f"{v}-{w}") for v, w in (a, b)]
        ((_, way),) = found(usdtailor, path, f"path({ends[0]}, {ends[1]})")
        assert {a, b} <= way
        # Edges beside lines count twice, and each turn as up to an edge.
        assert r.length(way) <= 3 * (r.shortest(set(a), set(b)) + r.length({a, b}))
        reached, rest = set(a), set(way)
        while beside := {edge for edge in rest if set(edge) & reached}:
            rest -= beside
            reached.update(*beside)
        assert not rest, "it is one piece"
    faces = [r.picked("Faces", f) for f in (3, len(r.faces) // 2)]
    ((_, way),) = found(usdtailor, path, f"path({faces[0]}, {faces[1]})")
    assert {3, len(r.faces) // 2} <= way and len(r.face_groups(way)) == 1


def test_picked_elements_are_those_of_their_numbers(usdtailor, example):
    path, r = example
    assert found(usdtailor, path, r.picked("Faces", "2-4, 7")) == [("face", {2, 3, 4, 7})]
    a, b, c, d = r.faces_points[5]
    text = r.picked("Edges", f"{b}-{a}, {c}-{d}-{a}")
    assert found(usdtailor, path, text) == [("edge", {pair(a, b), pair(c, d), pair(d, a)})]
    same = set().union({2}, *(faces for faces in map(r.material, r.materials) if 2 in faces))
    assert found(usdtailor, path, f"sameMaterial({r.picked('Faces', 2)})") == [("face", same)]


def test_picked_elements_are_refused_on_another_mesh(usdtailor, small):
    text = Reference.of(small("sheet")).picked("Faces", "0-1")
    done = command(usdtailor, small("ngons"), text)
    assert done.returncode == 1 and "error[set-expression]" in done.stderr and "picked on other faces" in done.stderr


PIECES = {
    "edge": {"borders": lambda r: r.borders(), "uvSeams": lambda r: r.uv_seams()},
    "face": {"value(layer, 1)": lambda r: r.value("layer", 1), "uvShells": lambda r: r.faces},
    "point": {"weight(thicknessWeight, 0.8)": lambda r: r.weight("thicknessWeight", 0.8)},
}


@each(PIECES)
def test_pieces_have_numbers_and_words(usdtailor, example, kind, expression, of):
    path, r = example
    pieces = r.shells() if expression == "uvShells" else r.pieces(kind, of(r))
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
    expected |= {f"material({name})": r.material(name) for name in r.materials}
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
    outer = r.normals[0] * (-1 if name == "left" else 1)
    for a, b in zip(r.points[indices[::2]], r.points[indices[1::2]]):
        assert np.cross(outer, b - a) @ (r.centres[0] - (a + b) / 2) > 0


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


def test_baked_sets_are_subsets_that_usd_reads(usdtailor, small, tmp_path):
    path, out = small("ngons"), tmp_path / "baked.usda"
    before, r = path.read_bytes(), Reference.of(path)
    expressions = {"open": "borders", "pads": "rings(panel)", "dots": "weight(pin)"}
    bakes = [arg for name, text in expressions.items() for arg in ("--bake", f"{name}={text}")]
    assert run(usdtailor, "sets", path, *bakes, "-o", out).returncode == 0 and path.read_bytes() == before
    stage = Usd.Stage.Open(str(out))
    mesh = UsdGeom.Mesh(find_model(stage))
    subsets = {name: UsdGeom.Subset(mesh.GetPrim().GetChild(name)) for name in expressions}
    kinds = {"open": "edge", "pads": "face", "dots": "point"}
    assert {name: subset.GetElementTypeAttr().Get() for name, subset in subsets.items()} == kinds
    sets = [read(kinds[name], list(subset.GetIndicesAttr().Get())) for name, subset in subsets.items()]
    assert sets == [r.borders(), r.rings(faces={0}), r.weight("pin")]
    for name, count in (("pads", len(r.faces)), ("dots", len(r.points)), ("open", len(r.points))):
        assert UsdGeom.Subset.ValidateSubsets([subsets[name]], count, UsdGeom.Tokens.unrestricted)[0], name
    assert {s.GetPrim().GetName() for s in UsdGeom.Subset.GetAllGeomSubsets(mesh)} == {*expressions, "panel", "trim"}
    assert not list(stage.GetRootLayer().GetPrimAtPath(mesh.GetPath()).properties.keys())


def seamed(path, text=None, **more):
    """A sheet with a face set `collar`, and the option of a seam on the prim above it."""

    def above(mesh):
        if text:
            parent = mesh.GetPrim().GetParent()
            parent.CreateAttribute("tailor:seam:side:edges", Sdf.ValueTypeNames.String, custom=True).Set(text)

    subsets = [{"name": "collar", "indices": [0, 1, 4]}, {"name": "trim", "indices": [2], "material": "wool"}]
    return write(path, seam_column=2, subsets=subsets, finish=above, **more)


def test_a_text_attribute_above_the_mesh_is_the_option(build, tmp_path):
    text = "uvSeams, border(collar)"
    above = build(seamed(tmp_path / "above.usda", text), stem="of_text")
    plain = seamed(tmp_path / "plain.usda")
    option = build(plain, "--set", f"seam.side.edges={text}", stem="of_option")
    assert above.report["recipe"]["seam"]["side"]["edges"] == text.split(", ")
    assert np.array_equal(above.render.points, option.render.points)
    assert not np.array_equal(above.render.points, build(plain, stem="of_none").render.points)


def test_an_authored_subset_wins_over_a_function(usdtailor, tmp_path):
    path = write(tmp_path / "own.usda", subsets=[{"name": "borders", "indices": [0, 1], "element": "edge"}])
    assert found(usdtailor, path, "borders", "edges - borders")[0] == ("edge", {(0, 1)})


def test_an_empty_set_is_a_warning(build, tmp_path):
    product = build(seamed(tmp_path / "empty.usda", "border(material(linen))"))
    (warning,) = (w for w in product.report["warnings"] if w["code"] == "empty-set")
    assert "seam.side.edges" in warning["message"] and "wool" in warning["message"]


@pytest.mark.parametrize("expression, code", [
    ("borders.", "set-expression"), ("border(uvSeams)", "set-expression"), ("borders + faces", "set-expression"),
    ("rings(borders", "set-expression"), ("udim()", "set-expression"), ("border(colar)", "unknown-subset"),
    ("sleeves", "unknown-subset"), ("curl(collar)", "unknown-subset"),
])  # fmt: skip
def test_wrong_expressions_are_errors_and_nothing_is_written(usdtailor, tmp_path, expression, code):
    path, out = seamed(tmp_path / "wrong.usda"), tmp_path / "out.usda"
    for args in (["sets", "--bake", f"a={expression}"], ["build", "--set", f"seam.side.edges={expression}"]):
        done = run(usdtailor, *args, path, "-o", out)
        assert done.returncode == 1 and f"error[{code}]" in done.stderr, done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["wrong.usda"]


@pytest.mark.parametrize("which", [None, "none", "authored", "all"])
def test_the_option_sets_decides_which_subsets_products_have(build, tmp_path, which):
    source = seamed(tmp_path / "sets.usda", "uvSeams, border(collar)", creases={(0, 1): 2.0})
    product = build(source, *(["--sets", which] if which else []))
    names = [set(product.sim.subsets), set(product.render.subsets)]
    bound = {"trim"}
    if which == "none":
        assert names == [bound, bound]
    elif which == "all":
        own = {"tailorBorders", "tailorSeams", "tailorCreases"}
        assert names == [{"collar"} | bound | own, {"collar", "uvSeams", "border_collar"} | bound]
    else:
        assert names == [{"collar", "tailorCreases"} | bound, {"collar"} | bound]
