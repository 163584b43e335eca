"""Seams and folds that Python authors in a layer over a garment: what `usdtailor build` makes of them."""

import subprocess
import sys

import numpy as np
import pytest
import sources
from conftest import EXAMPLES, ROOT, run
from pxr import Sdf, Usd, UsdGeom

MODEL = Sdf.Path(sources.MODEL)
FLOAT, TOKEN = Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Token
SETS = {"edges": "TailorSeamAPI", "faces": "TailorFoldAPI"}
# On a sheet of four by three quads: up its second column of edges, and its lowest row of faces.
PLACKET = {"edges": ["fold"], "width": 0.4, "normalOffset": -0.05}
HEM = {"faces": ["low"], "thickness": 0.1}


def flat():
    points, counts, indices = sources.sheet()
    return points * (1, 1, 0), counts, indices


def garment(folder, shape=flat, fold=(2, 7, 7, 12, 12, 17), **options):
    """A sheet with an edge set and two face sets; values of its points and faces say where they are."""
    subsets = [
        {"name": "fold", "indices": list(fold), "element": "edge", "family": "edges"},
        {"name": "low", "indices": [0, 1, 2, 3]},
        {"name": "inside", "indices": [5, 6]},
    ]
    primvars = [
        {"name": "piece", "type_name": "int", "interpolation": "uniform", "values": list(range(12))},
        {"name": "one", "type_name": "float", "interpolation": "vertex", "values": [1.0] * 20},
        {"name": "half", "type_name": "float", "interpolation": "vertex", "values": [0.5] * 20},
    ]
    return sources.write(folder / "coat.usda", shape=shape, seam_column=2, subsets=subsets, primvars=primvars, finish=sources.add_skinning, **options)


def sewn(source, name="sewn.usda", operators=(), **instances):
    """A layer over a garment; `instances` are options by name, those with `edges` seams and those with `faces` folds."""
    layer = Sdf.Layer.CreateNew(str(source.with_name(name)))
    layer.subLayerPaths = [f"./{source.name}"]
    stage = Usd.Stage.Open(layer)
    stage.SetDefaultPrim(stage.GetPrimAtPath(MODEL.GetParentPath()))
    prim = stage.OverridePrim(MODEL)
    for instance, options in instances.items():
        [sets] = SETS.keys() & options.keys()
        prim.AddAppliedSchema(f"{SETS[sets]}:{instance}")
        space = f"tailor:{'seam' if sets == 'edges' else 'fold'}:{instance}:"
        for key, value in options.items():
            if key == sets:
                prim.CreateRelationship(space + key, False).SetTargets([MODEL.AppendChild(target) for target in value])
            else:
                kind = {str: TOKEN, bool: Sdf.ValueTypeNames.Bool}.get(type(value), FLOAT)
                prim.CreateAttribute(space + key, kind, False, Sdf.VariabilityUniform).Set(value)
    prim.CreateAttribute("tailor:render:faceSets", Sdf.ValueTypeNames.Bool, False).Set(True)
    if operators:
        prim.CreateAttribute("tailor:render:operators", Sdf.ValueTypeNames.TokenArray, False).Set(operators)
    layer.Save()
    return source.with_name(name)


def codes(product):
    """What was warned of, without what the simulation mesh has to say."""
    return [warning["code"] for warning in product.report["warnings"] if warning["code"] not in ("sets-blurred", "area-changed")]


def refused(usdtailor, source, *args):
    done = run(usdtailor, "build", source, "-o", source.with_name("refused.usda"), *args)
    assert done.returncode == 1, done.stderr
    assert not source.with_name("refused.usda").exists()
    assert "\n  hint: " in done.stderr
    return done.stderr


def centres(mesh, name):
    return mesh.face_centres[mesh.subsets[name].indices]


@pytest.fixture(params=[1, 2])
def both(request, build, tmp_path):
    """A seam through a fold, at several levels."""
    return build(sewn(garment(tmp_path), operators=["placket", "hem"], placket=PLACKET, hem=HEM), "--set", f"render.level={request.param}")


def test_all_faces_are_quads_and_sets_have_the_names_of_operators(both):
    render = both.render
    assert set(render.counts) == {4}
    assert codes(both) == []
    for name in ("placket_seam", "hem_hem", "hem_inner"):
        assert (render.subsets[name].element_type, len(render.subsets[name].indices) > 0) == ("face", True)
    assert not np.intersect1d(render.subsets["hem_hem"].indices, render.subsets["hem_inner"].indices).size
    assert both.report["operatorFaces"] == {name: len(render.subsets[name].indices) for name in ("placket_seam", "hem_hem", "hem_inner")}
    assert set(both.sim.subsets) & {"placket_seam", "hem_hem", "hem_inner"} == set()


def test_faces_have_the_sets_and_values_of_their_parents(both):
    source, render = both.source, both.render
    parent = render.primvars["piece"].flat.ravel().astype(int)
    assert set(parent) == set(range(12))
    for name in ("low", "inside"):
        expected = np.flatnonzero(np.isin(parent, source.subsets[name].indices))
        assert sorted(render.subsets[name].indices) == list(expected), name
    for name in ("hem_hem", "hem_inner"):
        assert set(parent[render.subsets[name].indices]) == {0, 1, 2, 3}, name


def test_values_of_points_and_texture_coordinates_are_carried(both):
    source, render = both.source, both.render
    for name, value in (("one", 1), ("half", 0.5)):
        assert render.primvars[name].flat == pytest.approx(value, abs=1e-6), name
    weights = render.primvars["skel:jointWeights"]
    assert weights.rows.reshape(len(render.points), -1).sum(axis=1) == pytest.approx(1, abs=1e-5)
    st, before = render.primvars["st"], source.primvars["st"]
    assert st.interpolation == "faceVarying"
    assert (st.rows.min(axis=0) >= before.rows.min(axis=0) - 1e-5).all() and (st.rows.max(axis=0) <= before.rows.max(axis=0) + 1e-5).all()
    assert len(np.unique(render.uv_shells())) == 2


def test_the_edge_set_goes_on_along_the_centre_and_around_the_fold(both):
    pairs = both.render.subsets["fold"].pairs
    assert (both.render.topology.edge_ids(pairs) >= 0).all()
    along = both.render.points[pairs].mean(axis=1)
    assert np.abs(along[:, 0] - 2).max() < 0.02
    assert along[:, 2].min() < -0.1, "on the second layer"


def test_left_is_the_left_hand_of_who_walks_with_the_normals_up(build, tmp_path):
    """The chain runs towards +y and the normals towards +z, so left is -x."""
    seam = {**PLACKET, "width": 0.6, "asymmetry": -0.8}
    sides = {}
    for way, fold in (("up", (2, 7, 7, 12, 12, 17)), ("down", (17, 12, 12, 7, 7, 2))):
        source = garment(tmp_path / way, fold=fold)
        cage = build(sewn(source, placket=seam), "--set", "render.level=0", stem=way).render
        within = np.repeat(np.isin(np.arange(len(cage.counts)), cage.subsets["placket_seam"].indices), cage.counts)
        x = cage.points[cage.indices[within]][:, 0]
        sides[way] = 2 - x.min(), x.max() - 2
    assert sides["up"] == pytest.approx((0.54, 0.06), abs=1e-3)
    assert sides["down"] == pytest.approx((0.06, 0.54), abs=1e-3)


def test_relationships_and_lists_of_names_mean_the_same(build, tmp_path):
    source = garment(tmp_path)
    related = build(sewn(source, placket=PLACKET), stem="related").render
    flags = [flag for key, value in PLACKET.items() for flag in ("--set", f"seam.placket.{key}={value[0] if key == 'edges' else value}")]
    named = build(source, *flags, "--set", "render.faceSets=true", stem="named").render
    assert (related.points == named.points).all() and (related.indices == named.indices).all()


def test_flags_are_stronger_than_the_layer(build, tmp_path):
    layer = sewn(garment(tmp_path), placket=PLACKET)
    ridge = build(layer, "--set", "seam.placket.normalOffset=0.05", stem="ridge").render
    assert build(layer).render.points[:, 2].min() < -0.02
    assert ridge.points[:, 2].max() > 0.02 and ridge.points[:, 2].min() > -0.01


def groove_of_second_layer(render):
    """How much higher the points of the middle of the seam on the second layer are than the rest of that layer."""
    corners = np.asarray(render.indices).reshape(-1, 4)
    inner, seam = (set(render.subsets[name].indices) for name in ("hem_inner", "placket_seam"))
    points = {of: render.points[np.unique(corners[sorted(faces)])] for of, faces in (("seam", inner & seam), ("rest", inner - seam))}
    middle = points["seam"][abs(points["seam"][:, 0] - flat()[0][7, 0]) < 1e-4]
    return middle[:, 2] - np.median(points["rest"][:, 2])


def test_operators_run_in_their_order(build, tmp_path):
    """A hem over a seam has the groove on both layers; a seam over a hem on the face that it was marked on, and around if it goes through."""
    source, made = garment(tmp_path), {}
    after = ["hem", "placket"]
    for stem, operators, options in (
        ("seam_first", ["placket", "hem"], {}), ("hem_first", after, {}), ("default", [], {}),
        ("through", after, {"through": True}), ("without", after, {"normalOffset": 0.0}),
    ):
        shallow = {**PLACKET, "normalOffset": -0.02, **options}
        product = build(sewn(source, f"{stem}.usda", operators, placket=shallow, hem=HEM), stem=f"{stem}_built")
        # Where the layers meet at the end of the hem, a groove has no room.
        assert set(codes(product)) <= (set() if stem == "seam_first" else {"shallow-seam"})
        assert set(product.render.counts) == {4}
        made[stem] = product.render
    assert (made["default"].points == made["hem_first"].points).all()
    assert made["hem_first"].points.shape != made["seam_first"].points.shape or (made["hem_first"].points != made["seam_first"].points).any()
    depths = {stem: groove_of_second_layer(render) for stem, render in made.items()}
    # Points of the cage go further than the limit surface, which is at 0.02.
    assert -0.026 < np.median(depths["seam_first"]) < -0.018, "the groove of the first layer goes on in the second"
    assert np.abs(depths["hem_first"] - depths["without"]).max() < 0.004, "the hem covers the groove"
    # A seam that is made last tapers to the end of the layer, so that only its deepest point counts.
    assert 0.008 < depths["through"].max() < 0.026, "the second layer has a groove on its own outside"


def test_what_the_order_does_not_name_is_told(build, usdtailor, tmp_path):
    source = garment(tmp_path)
    product = build(sewn(source, operators=["seam:placket"], placket=PLACKET, hem=HEM))
    assert codes(product) == ["operators-left-out"]
    assert "fold.hem" in product.stderr
    assert "hem_hem" not in product.render.subsets and "placket_seam" in product.render.subsets
    said = refused(usdtailor, sewn(source, "unknown.usda", operators=["pocket"], placket=PLACKET))
    assert '"pocket"' in said and "seam.placket" in said


@pytest.mark.parametrize(
    "instances, words",
    [
        ({"seam": {**PLACKET, "edges": ["nothing"]}}, ["tailor:seam:seam:edges", "/Coat/model/nothing", "fold"]),
        ({"seam": {**PLACKET, "edges": ["low"]}}, ["seam.seam.edges", '"low"', "a subset of faces", "fold.<name>.faces", "fold"]),
        ({"seam": {**PLACKET, "edges": []}}, ["seam.seam.edges", "names no edge subset"]),
        ({"hem": {**HEM, "faces": ["nothing"]}}, ["tailor:fold:hem:faces", "/Coat/model/nothing", "low"]),
        ({"hem": {**HEM, "faces": ["inside"]}}, ["fold.hem.faces", "inside", "not next to a border", "closed"]),
        ({"hem": {**HEM, "weights": "paint"}}, ["fold.hem.weights", '"paint"', "half"]),
        ({"hem": {**HEM, "side": "under"}}, ["tailor:fold:hem:side", "inner", "outer"]),
        ({"seam": {**PLACKET, "width": -1.0}}, ["seam.seam.width", "-1"]),
        ({"seam": {**PLACKET, "asymmetry": 2.0}}, ["seam.seam.asymmetry", "2"]),
    ],
)
def test_faults_name_the_option_and_the_remedy(usdtailor, tmp_path, instances, words):
    said = refused(usdtailor, sewn(garment(tmp_path), **instances))
    assert all(word in said for word in words), said


def test_closed_gives_faces_inside_a_second_layer(build, tmp_path):
    layer = sewn(garment(tmp_path), hem={**HEM, "faces": ["inside"]})
    render = build(layer, "--set", "fold.hem.closed=true").render
    assert len(render.subsets["hem_inner"].indices) == 16 * 2
    assert centres(render, "hem_inner")[:, 2].min() < -0.05


def test_weights_scale_the_thickness(build, tmp_path):
    source = garment(tmp_path)
    depths = {}
    for weights in ("one", "half"):
        render = build(sewn(source, f"by_{weights}.usda", hem={**HEM, "weights": weights}), stem=weights).render
        depths[weights] = -np.median(centres(render, "hem_inner")[:, 2])
    assert depths["one"] == pytest.approx(0.1, rel=0.1)
    assert depths["half"] == pytest.approx(0.05, rel=0.1)


def test_the_second_layer_is_on_the_side_that_is_asked_for_and_looks_away(build, tmp_path):
    source = garment(tmp_path)
    for side, sign in (("inner", -1), ("outer", 1)):
        render = build(sewn(source, f"to_{side}.usda", hem={**HEM, "side": side}), stem=side).render
        inner = render.subsets["hem_inner"].indices
        assert (sign * render.face_centres[inner][:, 2] > 0).all()
        corners = render.points[render.indices.reshape(-1, 4)[inner]]
        normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        assert (normals[:, 2] < 0).all(), "wound the other way than the faces it covers"


def test_a_seam_that_is_too_wide_is_narrowed_and_told(build, tmp_path):
    product = build(sewn(garment(tmp_path), placket={**PLACKET, "width": 2.45}))
    [warning] = [warning for warning in product.report["warnings"] if warning["code"] == "narrow-seam"]
    assert warning["place"] == "seam.placket" and set(warning["elements"]["points"]) <= {2, 7, 12, 17}
    assert 0 < warning["amount"] < 0.7
    assert f"warning[{warning['code']}]: seam.placket: {warning['problem']}" in product.stderr
    assert set(product.render.counts) == {4}


# ------------------------------------------------------------------------------- the coat of the examples


@pytest.fixture(scope="module")
def coat(built):
    return built(EXAMPLES / "sewn" / "coat.usda")


def test_the_layer_over_the_coat_is_what_its_script_authors(tmp_path):
    pytest.importorskip("PIL")
    out = EXAMPLES / "sewn" / f"{tmp_path.name}.usda"
    try:
        subprocess.run([sys.executable, ROOT / "examples" / "sew.py", "author", "-o", out], check=True, timeout=120)
        assert out.read_text() == (EXAMPLES / "sewn" / "coat.usda").read_text()
    finally:
        out.unlink(missing_ok=True)


def test_the_coat_is_sewn(coat):
    """Every operator made faces, and the places where there is no room are reported: at the neck, under the arm, and over folds."""
    assert set(coat.render.counts) == {4}
    prim = coat.source.prim
    instances = [schema.partition(":") for schema in prim.GetAppliedSchemas() if schema.startswith(("TailorSeam", "TailorFold"))]
    ends = {"TailorSeamAPI": ["seam"], "TailorFoldAPI": ["hem", "inner"]}
    expected = {f"{name}_{end}" for schema, _, name in instances for end in ends[schema]}
    assert len(expected) == 17 and coat.report["operatorFaces"].keys() == expected
    assert all(len(coat.render.subsets[name].indices) == count > 0 for name, count in coat.report["operatorFaces"].items())
    told = [(warning["code"], warning["place"]) for warning in coat.report["warnings"]]
    # A groove is no deeper than the layers of a hem or collar that it runs over allow.
    over_folds = {"back", "neckline", "placket", "shoulder", "side", "sleeve"}
    assert told == [("narrow-seam", "seam.armhole"), ("narrow-seam", "seam.neckline")] + [
        ("shallow-seam", f"seam.{name}") for name in sorted(over_folds)]


def test_the_coat_keeps_its_attributes(coat):
    source, render = coat.source, coat.render
    for name, subset in source.subsets.items():
        written = render.subsets[name]
        assert (written.element_type, written.family, written.material) == (subset.element_type, subset.family, subset.material), name
        if subset.element_type == "edge":
            assert (render.topology.edge_ids(written.pairs) >= 0).all(), name
    assert render.families == source.families
    panels = np.concatenate([s.indices for s in render.subsets.values() if s.family == "panels"])
    assert sorted(panels) == list(range(len(render.counts))), "a partition stays one"
    assert source.primvars.keys() <= render.primvars.keys()
    names = render.primvars["pieceName"]
    assert {tuple(row) for row in names.flat} == {tuple(row) for row in source.primvars["pieceName"].flat}
    weights = render.primvars["skel:jointWeights"]
    assert weights.rows.reshape(len(render.points), -1).sum(axis=1) == pytest.approx(1, abs=1e-4)


def test_nothing_of_the_sewn_coat_passes_through_anything(built):
    """As the program that makes the garments checks them: no edge of a triangle goes through another triangle."""
    sys.path.insert(0, str(EXAMPLES))
    from tailoring.check import crossings

    render = built(EXAMPLES / "sewn" / "coat.usda", "--set", "render.level=1").render
    quads = render.indices.reshape(-1, 4)
    found = crossings(render.points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    faces = sorted({tuple(sorted((a % len(quads), b % len(quads)))) for a, b in found})
    assert faces == []


def test_the_plain_coat_is_as_it_was(coat, built):
    """The layer changes nothing of what is below it."""
    plain = built(EXAMPLES / "coat.usda")
    assert (plain.source.points == coat.source.points).all()
    assert "operatorFaces" in plain.report and plain.report["operatorFaces"] == {}
    assert UsdGeom.Mesh(plain.prim("render")).GetFaceVertexCountsAttr().Get() is not None
    assert len(plain.render.counts) == 4 * plain.source.counts.sum()
