"""Features that the garments lack, on small stages made here: read right, carried right, written right."""

import inspect

import numpy as np
import pytest
import sources
import test_accounting
import test_output_layer
import test_render
import test_sim
from conftest import run
from mesh import bound_material, find_model, own_material, read_mesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils

INTERPOLATIONS = ["constant", "uniform", "vertex", "varying", "faceVarying"]
VALUE_TYPES = (
    "bool int uint uchar int64 half float double timecode float2 float3 float4 double2 double3 half3 int2 int3 "
    "point3f vector3f normal3f color3f color4f texCoord2f texCoord3f quatf quath matrix4d string token asset"
).split()
MODES = ["all", "none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries"]

# What must hold for a sheet of a dozen faces too; the rest of test_sim measures garments.
SIM_CHECKS = """
    test_is_a_plain_triangle_mesh test_is_manifold_and_wound_one_way test_has_no_degenerate_triangle
    test_faces_the_way_its_source_does test_source_coordinates_name_the_place test_points_lie_on_the_baseline
    test_has_the_pieces_and_borders_of_its_source
    test_uv_triangles_are_not_flipped test_uv_cuts_are_where_the_source_has_them test_vertex_primvars_stay_in_range
    test_joint_influences_add_to_one test_partitions_stay_partitions test_subset_indices_are_elements_of_the_mesh
    test_materials_are_bound_as_before
""".split()
LAYER_CHECKS = """
    test_subset_families_are_valid test_output_sublayers_the_input_by_a_relative_path
    test_output_holds_only_the_two_meshes_and_the_purpose test_everything_of_the_input_is_still_there
    test_stage_metadata_is_copied test_new_meshes_stand_where_the_model_stands
""".split()


def check(product, *, level=2, sim=True):
    """The checks of the other files on one product."""
    refined = test_render.Refined(product, level)
    coarse = refined if level < 2 else test_render.Refined(product.again("--set", "render.level=1"), 1)
    given = {"product": product, "all_shells": product, "refined": refined, "coarse": coarse, "name": "render"}
    checks = [function for name, function in vars(test_render).items() if name.startswith("test_")]
    checks += [getattr(test_output_layer, name) for name in LAYER_CHECKS]
    checks += [test_accounting.test_render_mesh_carries_every_primvar_and_subset, test_accounting.test_primvar_lengths_match_their_interpolation]
    if sim:
        given["baseline"] = test_sim.Baseline(product)
        checks += [getattr(test_sim, name) for name in SIM_CHECKS]
        checks += [
            test_accounting.test_skinned_meshes_stay_bound_to_their_skeleton,
            test_accounting.test_sim_mesh_carries_every_primvar_and_subset,
        ]
    for function in checks:
        try:
            function(**{name: given[name] for name in inspect.signature(function).parameters})
        except pytest.skip.Exception:
            continue


@pytest.fixture
def make(build, tmp_path):
    """`make(*args, **source)` writes a source as `sources.write` does and builds it."""

    def make(*args, name="coat.usda", **source):
        return build(sources.write(tmp_path / name, **source), *args)

    return make


CASES = {
    "plain": {},
    "no uv": {"uv": False},
    "seam": {"seam_column": 2},
    "left handed": {"options": {"orientation": "leftHanded"}},
    "holes": {"holes": [0, 5]},
    "boundary none": {"options": {"interpolateBoundary": "none"}},
    "boundary edgeOnly": {"options": {"interpolateBoundary": "edgeOnly"}},
    "corners": {"corners": {6: 1.5, 7: 10.0, 12: 0.3}},
    "creases": {"creases": {(5, 6, 7): 2.5, (8, 13): 10.0, (11, 12): 0.4, (1, 6, 11): 1.0}},
    "crease on a border": {"creases": {(0, 1, 2): 1.5}},
    "n-gons": {"shape": sources.patchwork},
    "n-gons, smooth triangles": {"shape": sources.patchwork, "options": {"triangleSubdivisionRule": "smooth"}},
    "skinning": {"finish": sources.add_skinning},
    "no stage metadata": {"metadata": False},
    "model at the root": {"model": "/model"},
    "deep": {"model": "/Shop/Rack/Coat/geo/model"},
}


@pytest.mark.parametrize("source", [pytest.param(source, id=name) for name, source in CASES.items()])
def test_source(make, source):
    check(make(**source))


@pytest.mark.parametrize("level", [0, 2, 3])
def test_levels(make, level):
    check(make("--set", f"render.level={level}", seam_column=2, creases={(5, 6, 7): 2.5}), level=level, sim=False)


@pytest.mark.parametrize("mode", MODES)
def test_face_varying_rules(make, mode):
    """A seam, a crease across it, a dart, a shell of one face and a vertex of three shells."""

    def cuts(mesh):
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        values, indices = list(st.Get()), np.array(st.GetIndices())
        for corner, shift in ((4 * 7, 0.03), (4 * 7 + 1, 0.04), (4 * 7 + 2, 0.05), (4 * 7 + 3, 0.06), (0, 0.02)):
            indices[corner] = len(values)
            values.append(Gf.Vec2f(*(np.array(values[st.GetIndices()[corner]]) + [shift, -shift / 2])))
        st.Set(values)
        st.SetIndices(indices.tolist())

    options = {"faceVaryingLinearInterpolation": mode}
    check(make(seam_column=2, finish=cuts, options=options, creases={(5, 6, 7, 8): 1.5}), sim=False)


@pytest.mark.parametrize("shape", [sources.bow_tie, sources.fin, sources.turned_face], ids=lambda shape: shape.__name__)
def test_what_is_not_manifold_is_said_and_cut(make, shape):
    product = make(shape=shape, uv=False)
    assert product.warnings, "nothing was said"
    check(product)


@pytest.mark.parametrize("type_name", VALUE_TYPES)
def test_primvars_of_every_type(make, type_name):
    primvars = [
        {"name": f"{interpolation}{'Indexed' * indexed}", "type_name": type_name, "interpolation": interpolation, "indexed": indexed}
        for interpolation in INTERPOLATIONS
        for indexed in (False, True)
    ]
    check(make(primvars=primvars))


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("type_name", ["float", "float3", "int", "string"])
def test_primvars_of_two_values_per_element(make, type_name, interpolation):
    check(make(primvars=[{"name": "pair", "type_name": type_name, "interpolation": interpolation, "element_size": 2}]))


def test_scalar_constant_primvar(make):
    def fabric(mesh):
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("thread", Sdf.ValueTypeNames.Float, UsdGeom.Tokens.constant).Set(0.25)

    product = make(finish=fabric)
    for name in ("sim", "render"):
        written = UsdGeom.PrimvarsAPI(product.prim(name)).GetPrimvar("thread")
        assert written.GetTypeName() == Sdf.ValueTypeNames.Float
        assert written.Get() == 0.25


def test_display_colour_and_opacity(make):
    primvars = [
        {"name": "displayColor", "type_name": "color3f", "interpolation": "uniform"},
        {"name": "displayOpacity", "type_name": "float", "interpolation": "vertex"},
    ]
    check(make(primvars=primvars))


def test_primvar_names_with_namespaces(make):
    check(make(primvars=[{"name": "studio:cloth:wear", "type_name": "float", "interpolation": "vertex"}]))


def test_asset_values_still_name_the_same_file(usdtailor, tmp_path):
    """A relative path is anchored to its layer, and the output may be in another folder."""
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "in" / "wool.png").write_bytes(b"not a picture")
    primvar = {"name": "swatch", "type_name": "asset", "interpolation": "constant", "values": [Sdf.AssetPath("./wool.png")]}
    source = sources.write(tmp_path / "in" / "coat.usda", primvars=[primvar])
    done = run(usdtailor, "build", source, "-o", tmp_path / "out" / "built.usda")
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(tmp_path / "out" / "built.usda"))
    for name in ("sim", "render"):
        (asset,) = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/Coat/{name}")).GetPrimvar("swatch").Get()
        assert asset.resolvedPath and (tmp_path / "in" / "wool.png").samefile(asset.resolvedPath), f"{name}: {asset}"


def test_subsets_of_every_element_and_family(make):
    product = make(
        seam_column=2,
        subsets=[
            {"name": "left", "indices": [0, 1, 4, 5, 8, 9], "family": "panels"},
            {"name": "right", "indices": [2, 3, 6, 7, 10, 11], "family": "panels"},
            {"name": "pocket", "indices": [5], "family": "details"},
            {"name": "flap", "indices": [6], "family": "details"},
            {"name": "worn", "indices": [5, 6], "family": "loose"},
            {"name": "soft", "indices": [5, 6, 9], "family": "loose"},
            {"name": "hem", "indices": [0, 1, 1, 2, 2, 3, 3, 4], "element": "edge", "family": "edges"},
            {"name": "placket", "indices": [2, 7, 7, 12, 12, 17], "element": "edge", "family": "edges"},
            {"name": "button", "indices": [7], "element": "point", "family": "points"},
            {"name": "pins", "indices": [0, 12, 4], "element": "point", "family": "points"},
            {"name": "nothing", "indices": [], "family": "empty"},
            {"name": "noEdges", "indices": [], "element": "edge", "family": "noEdges"},
        ],
        families={"panels": "partition", "details": "nonOverlapping", "loose": "unrestricted"},
    )
    check(product)
    assert product.render.subsets["nothing"].indices.size == 0


def test_materials_of_mesh_and_subsets(make):
    product = make(
        subsets=[
            {"name": "left", "indices": [0, 1, 4, 5, 8, 9], "family": "materialBind", "material": "wool"},
            {"name": "right", "indices": [2, 3, 6, 7, 10, 11], "family": "materialBind", "material": "silk"},
        ],
        families={"materialBind": "partition"},
        finish=lambda mesh: sources.bind(mesh.GetPrim(), "linen"),
    )
    check(product)
    assert own_material(product.render) == "/Coat/materials/linen"
    assert product.sim.subsets["left"].material == "/Coat/materials/wool"


@pytest.mark.parametrize("args", [(), ("--flatten",)], ids=["layer", "flat"])
def test_ancestors_pass_on_materials_and_constant_primvars(make, args):
    def inherit(mesh):
        root = mesh.GetPrim().GetParent()
        UsdGeom.PrimvarsAPI(root).CreatePrimvar("fabric", Sdf.ValueTypeNames.String, UsdGeom.Tokens.constant).Set("tweed")
        sources.bind(root, "tweed")

    product = make(*args, finish=inherit)
    for name in ("model", "sim", "render"):
        prim = product.prim(name)
        assert UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("fabric").Get() == "tweed", name
        assert bound_material(prim) == "/Coat/materials/tweed", name


def test_transforms(make):
    def move(mesh):
        UsdGeom.Xformable(mesh.GetPrim().GetParent()).AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
        mesh.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
        mesh.AddRotateXYZOp(UsdGeom.XformOp.PrecisionFloat, "tilt").Set(Gf.Vec3f(10, 20, 30))
        mesh.AddTransformOp(UsdGeom.XformOp.PrecisionDouble, "fit").Set(Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(0, 1, 0), 45), Gf.Vec3d(0, 1, 0)))

    product = make(finish=move)
    check(product)
    place = UsdGeom.XformCache().GetLocalToWorldTransform(product.prim("render"))
    assert place != Gf.Matrix4d(1)


def test_transform_that_resets_the_stack_and_inverts(make):
    def move(mesh):
        UsdGeom.Xformable(mesh.GetPrim().GetParent()).AddTranslateOp().Set(Gf.Vec3d(9, 9, 9))
        mesh.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble, "pivot").Set(Gf.Vec3d(1, 2, 3))
        mesh.AddRotateYOp().Set(30)
        mesh.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble, "pivot", True)
        mesh.SetResetXformStack(True)

    check(make(finish=move))


def test_invisible_model(make):
    check(make(options={"visibility": "invisible"}))


def points_in_time(mesh):
    """A default value and samples, which are different."""
    points = mesh.GetPointsAttr()
    rest = np.array(points.Get())
    for time, lift in ((1, 0.0), (5, 2.0)):
        points.Set([Gf.Vec3f(*map(float, point)) for point in rest + [0, lift, lift * 0.5]], time)


@pytest.mark.parametrize("time", [1, 3, 5])
def test_points_at_a_time(make, time):
    product = make("--time", time, "--set", "render.level=1", finish=points_in_time)
    moved = read_mesh(find_model(product.source_stage), time)
    product.__dict__["source"] = moved
    test_render.test_points_at_the_centres_of_faces_are_means(test_render.Refined(product, 1))
    test_sim.test_points_lie_on_the_baseline(product, test_sim.Baseline(product))
    for name in ("sim", "render"):
        assert UsdGeom.Mesh(product.prim(name)).GetPointsAttr().GetTimeSamples() == []


def test_without_a_time_the_default_value_counts(make):
    check(make(finish=points_in_time))


def compose(kind, part, path):
    """A stage that brings in /Coat of `part` by one of the ways of composition."""
    if kind == "usdz":
        package = path.with_suffix(".usdz")
        assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(part)), str(package))
        return package
    stage = Usd.Stage.CreateNew(str(path))
    if kind == "sublayer":
        stage.GetRootLayer().subLayerPaths.append(f"./{part.name}")
    else:
        coat = stage.DefinePrim("/Coat", "Xform")
        if kind == "reference":
            coat.GetReferences().AddReference(f"./{part.name}")
        elif kind == "payload":
            coat.GetPayloads().AddPayload(f"./{part.name}")
        elif kind == "variant":
            variants = coat.GetVariantSets().AddVariantSet("fit")
            for name in ("slim", "wide"):
                variants.AddVariant(name)
                variants.SetVariantSelection(name)
                with variants.GetVariantEditContext():
                    coat.GetReferences().AddReference(f"./{part.name}")
                    if name == "wide":
                        over = stage.OverridePrim(sources.MODEL)
                        wide = over.CreateAttribute("points", Sdf.ValueTypeNames.Point3fArray)
                        wide.Set([Gf.Vec3f(2 * float(x), float(y), float(z)) for x, y, z in sources.sheet()[0]])
        elif kind == "inherit":
            stage.CreateClassPrim("/_class_Coat").GetReferences().AddReference(f"./{part.name}")
            coat.GetInherits().AddInherit("/_class_Coat")
    stage.SetMetadata("defaultPrim", "Coat")
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.Save()
    return path


@pytest.mark.parametrize("kind", ["sublayer", "reference", "payload", "inherit", "variant", "usdz"])
def test_composition(build, tmp_path, kind):
    part = sources.write(tmp_path / "part.usda", seam_column=2, subsets=[{"name": "pocket", "indices": [5]}], finish=sources.add_skinning)
    check(build(compose(kind, part, tmp_path / "whole.usda")))


def test_variant_and_strongest_opinion_are_those_of_the_stage(build, tmp_path):
    part = sources.write(tmp_path / "part.usda")
    product = build(compose("variant", part, tmp_path / "whole.usda"), "--set", "render.level=1")
    assert np.ptp(product.source.points[:, 0]) == 8, "the wide variant is selected"
    test_render.test_points_at_the_centres_of_faces_are_means(test_render.Refined(product, 1))


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
def test_formats_of_the_input(make, suffix):
    check(make(name=f"coat{suffix}", seam_column=2))


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_names_that_are_not_ascii(make, suffix):
    product = make(
        name=f"mäntel 外套.{suffix}",
        model="/Mäntel/modèle",
        primvars=[{"name": "épaisseur", "type_name": "float", "interpolation": "vertex"}],
        subsets=[{"name": "襟", "indices": [0, 1], "family": "größen"}],
    )
    check(product)
    assert "épaisseur" in product.render.primvars
    assert "襟" in product.sim.subsets


def two_meshes(mesh):
    sources.define(mesh.GetPrim().GetStage(), "/Coat/lining/model", sources.patchwork())


def test_two_meshes_need_a_choice(usdtailor, tmp_path):
    source = sources.write(tmp_path / "two.usda", finish=two_meshes)
    done = run(usdtailor, "build", source, "-o", tmp_path / "built.usda")
    assert done.returncode == 1
    for word in ("/Coat/model", "/Coat/lining/model", "--prim"):
        assert word in done.stderr
    assert not (tmp_path / "built.usda").exists()


@pytest.mark.parametrize("path", ["/Coat/model", "/Coat/lining/model"])
def test_one_of_two_meshes(usdtailor, tmp_path, path):
    source = sources.write(tmp_path / "two.usda", finish=two_meshes)
    done = run(usdtailor, "build", source, "-o", tmp_path / "built.usda", "--prim", path)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(tmp_path / "built.usda"))
    parent = Sdf.Path(path).GetParentPath()
    meshes = {str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
    assert meshes == {"/Coat/model", "/Coat/lining/model", f"{parent}/sim", f"{parent}/render"}
    source_mesh = read_mesh(stage.GetPrimAtPath(path))
    assert len(read_mesh(stage.GetPrimAtPath(parent.AppendChild("render"))).counts) == 4 * source_mesh.counts.sum()
