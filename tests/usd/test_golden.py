"""What the program writes against the stored results of OpenSubdiv: points, values, sharpness and holes."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT, make, run
from golden import GARMENTS, RULES, garment_values, load
from mesh import read_mesh
from sources import add_primvar, of_numbers, width, write
from test_render import INFINITE, close, close_directions, dense, is_direction, tolerance_scale

FILES = ["catmark", "generated", "nonmanifold", "bilinear", "loop"]
# Each type whose values are mixed.
TYPES = (
    "half float double timecode float2 float3 float4 double2 double3 half3 point3f vector3f normal3f color3f color4f "
    "texCoord2f texCoord3f quatf quath matrix4d"
).split()
# Faces of several sizes; creases and corners on a border and inside; creases across a seam.
TYPE_CASES = ["catmark_nonquads", "catmark_xord_interpolateboundary2", "catmark_fvar_dependent0"]


def cases(file):
    found = load(ROOT / "tests" / "golden" / f"{file}.bin")
    assert found
    return found


def author(path, case, rule, primvars):
    """The mesh of a case as a stage; a primvar is a name, a type, an interpolation, rows of numbers, indices, elementSize."""
    options = {
        "subdivisionScheme": case.scheme,
        "interpolateBoundary": case.boundary,
        "triangleSubdivisionRule": case.triangles,
        "faceVaryingLinearInterpolation": rule,
    }
    shape = (case.points, case.counts, case.indices)
    made = [
        {
            "name": name,
            "type_name": type_name,
            "interpolation": interpolation,
            "values": [of_numbers(type_name, value) for value in rows.reshape(-1, width(type_name))],
            "indices": indices,
            "element_size": element_size,
        }
        for name, type_name, interpolation, rows, indices, element_size in primvars
    ]
    return write(
        path, shape=lambda: shape, uv=False, options=options, creases=case.creases, corners=case.corners,
        holes=case.holes.tolist(), primvars=made, finish=lambda mesh: add_ids_and_joints(mesh, case.points),
    )  # fmt: skip


def add_ids_and_joints(mesh, points):
    """The number of each face, and weights of four joints, which are linear in the points."""
    faces = len(mesh.GetFaceVertexCountsAttr().Get())
    add_primvar(mesh, name="face", type_name="int", interpolation="uniform", values=list(range(faces)))
    for name, type_name, values in (("Indices", "int", np.tile(np.arange(4), len(points))), ("Weights", "float", joint_weights(points, points).ravel())):
        add_primvar(mesh, name=f"skel:joint{name}", type_name=type_name, interpolation="vertex", element_size=4, values=values.tolist())


def joint_weights(points, box):
    """Four that add to one and are positive in the box and somewhat beyond it."""
    low, high = box.min(axis=0), box.max(axis=0)
    share = (points - (low + high) / 2)[:, :2] / max((high - low).max(), 1e-30) / 4
    return 0.25 + np.concatenate([share, -share], axis=1)


def has_repeats(case):
    """Faces that use a point twice, which are cleaned or split before they are refined."""
    faces = np.split(case.indices, np.cumsum(case.counts)[:-1])
    return any(len(set(face)) < len(face) for face in faces)


def is_refused(case):
    """Meshes none of whose faces is drawn."""
    return all(face.hole for face in case.levels[0].samples)


@pytest.mark.parametrize("file", FILES)
def test_agrees_with_open_subdiv(usdtailor, file):
    """Each case under each rule for face-varying values, at one level or another."""
    for number, case in enumerate(cases(file)):
        primvars = [
            ("pair", "float2", "varying", case.varying, None, 1),
            ("st", "texCoord2f", "faceVarying", case.uvs, case.uv_indices, 1),
        ]
        with tempfile.TemporaryDirectory() as folder:
            for place, rule in enumerate(RULES):
                source = author(Path(folder) / f"{rule}.usda", case, rule, primvars)
                if has_repeats(case):
                    built = run(usdtailor, "build", source, "-o", f"{folder}/built.usda")
                    assert built.returncode == 0 and "[repeated-points]" in built.stderr, case.name
                    break
                if is_refused(case):
                    assert run(usdtailor, "build", source, "-o", f"{folder}/built.usda").returncode == 1, case.name
                    break
                level = 1 + (number + place) % len(case.levels)
                product = make(usdtailor, source, Path(folder), "--set", f"render.level={level}", stem=f"{rule}_built")
                render, what = product.render, f"of {case.name}, rule {rule}, level {level}"
                values = (render.points, render.primvars["pair"].flat, render.primvars["st"].flat)
                agrees(case, level, rule, render, values, what)
                parents_and_joints_agree(case, level, render, what)
                if level == 1 and place < 3:  # Points do not depend on the rule.
                    refines_further(usdtailor, product, case, what)


@pytest.mark.parametrize("level", [1, 2])
@pytest.mark.parametrize("name", GARMENTS)
def test_garments_agree_with_open_subdiv(built, name, level):
    """The examples as they are: their points, painted values, UVs, creases and corners."""
    case = next(case for case in cases("garments") if case.name == name)
    product = built(EXAMPLES / f"{name.split()[0]}.usda", "--set", f"render.level={level}")
    source, render = product.source, product.render
    points, varying, uv = garment_values(source, name)
    stored = ((points, case.points), (varying, case.varying), (uv.rows, case.uvs), (source.indices, case.indices), (source.counts, case.counts))
    assert all(np.array_equal(*pair) for pair in stored), "the example has changed: run `cargo xtask golden`"
    points, varying, uv = garment_values(render, name)
    agrees(case, level, source.face_varying, render, (points, varying, uv.flat), f"of {name}, level {level}")


def agrees(case, number, rule, render, values, what):
    """`values` are what was written as points, varying and face-varying values."""
    level, topology = case.levels[number - 1], render.topology
    options = (render.scheme, render.boundary, render.triangles, render.face_varying)
    assert options == (case.scheme, case.boundary, case.triangles, rule), what
    assert (len(render.points), len(topology.edges), len(render.counts)) == (level.vertices, level.edges, level.faces), what
    at = sampled_corners(level)
    if case.scheme != "loop":
        assert np.array_equal(render.indices[at], sampled(level, "vertices")), f"vertices {what}"

    def same(values, expected, total, kind, scale):
        close(values[at], expected, f"{kind} {what}", scale)
        close(values.mean(axis=0)[None], total[None] / len(values), f"mean {kind} {what}", scale)

    points, varying, st = values
    slot = case.slots[RULES.index(rule)]
    same(points[render.indices], sampled(level, "points"), level.point_sum, "points", np.ptp(case.points, axis=0).max())
    same(varying[render.indices], sampled(level, "varying"), level.varying_sum, "varying values", max(np.abs(case.varying).max(), 1))
    same(st, sampled(level, "slots")[:, slot], level.slot_sums[slot], "face-varying values", np.ptp(case.uvs, axis=0).max())
    holes = np.isin([face.index for face in level.samples], render.holes)
    assert holes.tolist() == [face.hole for face in level.samples], f"holes {what}"
    sharpness_agrees(level, render, what)


def parents_and_joints_agree(case, number, render, what):
    level = case.levels[number - 1]
    parents = render.primvars["face"].flat[[face.index for face in level.samples], 0]
    assert parents.tolist() == [face.base_face for face in level.samples], f"parents {what}"
    weights = dense(render.primvars["skel:jointIndices"], render.primvars["skel:jointWeights"], 4)[render.indices[sampled_corners(level)]]
    assert np.allclose(weights, joint_weights(sampled(level, "points"), case.points), atol=1e-5), f"weights {what}"


def refines_further(usdtailor, product, case, what):
    """Level 1, as a model, gives level 2: what is written means the same surface."""
    path, level, size = product.render.prim.GetPath(), case.levels[1], np.ptp(case.points, axis=0).max()
    args = ("--prim", path, "--sim-name", "sim2", "--render-name", "render2", "--set", "render.level=1")
    onward = make(usdtailor, product.path, product.path.parent, *args, stem=f"{product.path.stem}_onward")
    mesh = read_mesh(onward.stage.GetPrimAtPath(path.ReplaceName("render2")))
    close(mesh.points[mesh.indices][sampled_corners(level)], sampled(level, "points"), f"points one level on {what}", size)


def sharpness_agrees(level, render, what):
    """What is written as creases and corners, and what the rules sharpen by themselves."""
    topology, at = render.topology, sampled_corners(level)
    alone = (topology.edge_faces == 1) | topology.non_manifold_edges()
    creases = topology.edge_ids(list(render.creases))
    assert (creases >= 0).all(), f"creases {what}"
    edges = np.zeros(len(topology.edges))
    edges[creases] = list(render.creases.values())
    edges[alone] = INFINITE
    edges = np.minimum(edges[topology.corner_edge], INFINITE)
    assert np.allclose(edges[at], sampled(level, "edge_sharpness"), atol=1e-5), f"creases {what}"
    assert abs(edges.sum() - level.sharpness_sum) <= 1e-5 * len(edges), f"creases {what}"

    corners = np.zeros(len(render.points))
    corners[list(render.corners)] = list(render.corners.values())
    corners, expected = np.minimum(corners[render.indices[at]], INFINITE), sampled(level, "vertex_sharpness")
    may_be_held = topology.fans() != 1
    may_be_held[topology.edges[alone]] = True
    held = may_be_held[render.indices[at]] & (expected == INFINITE)
    assert np.allclose(corners[~held], expected[~held], atol=1e-5), f"corners {what}"


def sampled(level, what):
    return np.concatenate([getattr(face, what) for face in level.samples])


def sampled_corners(level):
    """The corners of the sampled faces, all of which have as many."""
    return np.concatenate([face.index * len(face.points) + np.arange(len(face.points)) for face in level.samples])


def linear_in(columns, type_name, element_size):
    """Rows of the numbers of a type that are linear in the columns; directions are far from zero."""
    numbers = width(type_name) * element_size
    mixing = np.random.default_rng(7).uniform(-0.5, 0.5, (columns.shape[1], numbers))
    return columns @ mixing + np.where(np.arange(numbers) % width(type_name) == 0, 3, 0.5)


@pytest.mark.parametrize("name", TYPE_CASES)
def test_values_of_every_type_agree_with_open_subdiv(build, tmp_path, name):
    case = next(case for case in cases("catmark") if case.name == name)
    level, rule = case.levels[1], "cornersPlus1"
    reverse = np.arange(len(case.points))[::-1]
    given = [
        ("vertex", case.points, None, sampled(level, "points")),
        ("vertex", case.points, reverse, sampled(level, "points")),
        ("varying", case.varying, None, sampled(level, "varying")),
        ("varying", case.varying, reverse, sampled(level, "varying")),
        ("faceVarying", case.uvs, case.uv_indices, sampled(level, "slots")[:, case.slots[RULES.index(rule)]]),
    ]
    primvars, wanted = [], {}
    for type_name in TYPES:
        for interpolation, columns, indices, after in given:
            for element_size in (1, 2):
                key = f"{interpolation}{'' if indices is None else 'Indexed'}_{type_name}_{element_size}"
                rows = linear_in(columns, type_name, element_size)
                primvars.append((key, type_name, interpolation, rows[::-1] if indices is reverse else rows, indices, element_size))
                wanted[key] = linear_in(after, type_name, element_size)
    product = build(author(tmp_path / "case.usda", case, rule, primvars), "--set", "render.level=2")
    at = sampled_corners(level)
    for key, expected in wanted.items():
        primvar, written = product.source.primvars[key], product.render.primvars[key]
        assert (written.type_name, written.interpolation, written.element_size) == (primvar.type_name, primvar.interpolation, primvar.element_size), key
        rows = written.flat[at if primvar.interpolation == "faceVarying" else product.render.indices[at]]
        if is_direction(primvar):
            each = width(primvar.element)
            close_directions(rows.reshape(-1, each), expected.reshape(-1, each), key)
        else:
            # Rows of half precision are rounded in the source too.
            close(rows, expected, key, tolerance_scale(primvar) * (2 if primvar.element.startswith("half") else 1))
