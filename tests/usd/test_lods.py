"""Levels of detail: coarser meshes of the same garment, as variants or below a prim with LODRootAPI, which one cache drives."""

import json

import numpy as np
import pytest
from conftest import EXAMPLES, garment_files, run, write
from panels import suit
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLod, UsdPhysics, UsdShade

COAT = EXAMPLES / "coat.usda"
SEAMS = [word for name in ("side_seams", "armholes", "pocket_outline") for word in ("--set", f"seam.{name}.edges={name}")]
COUNT = 3


def root_of(stage):
    """The prim above the garment and its products."""
    (model,) = (p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh) and not p.GetCustomDataByKey("tailor:product"))
    return model.GetParent()


def opened(product):
    """A stage of its own, as tests share what is built."""
    stage = Usd.Stage.Open(str(product.path))
    stage.SetEditTarget(stage.GetSessionLayer())
    return stage


def select(stage, level):
    assert root_of(stage).GetVariantSet("LOD").SetVariantSelection(f"LOD{level}")


def mesh_of(stage, level):
    select(stage, level)
    return UsdGeom.Mesh(root_of(stage).GetChild(f"LOD{level}"))


def points_of(mesh, time=None):
    return np.array(mesh.GetPointsAttr().Get(Usd.TimeCode.Default() if time is None else time), float)


def extent(points):
    return np.array([points.min(0), points.max(0)])


@pytest.mark.parametrize("file", garment_files())
def test_each_level_is_a_variant_with_one_mesh_and_all_that_the_garment_has(file, built):
    product = built(file, "--lods", str(COUNT))
    stage = opened(product)
    root = root_of(stage)
    assert root.GetVariantSet("LOD").GetVariantNames() == [f"LOD{level}" for level in range(COUNT)]
    assert root.GetVariantSet("LOD").GetVariantSelection() == "LOD0"
    first = None
    sizes = []
    for level in range(COUNT):
        mesh = mesh_of(stage, level)
        shown = [prim.GetName() for prim in root.GetChildren() if prim.GetName().startswith("LOD")]
        assert shown == [f"LOD{level}"], "one mesh is drawn, which Unreal finds by the name of its variant"
        assert mesh.GetPrim().IsDefined() and mesh.GetPurposeAttr().Get() != UsdGeom.Tokens.guide
        sim = UsdGeom.Mesh(root.GetChild("sim" if level == 0 else f"sim_LOD{level}"))
        subsets = {s.GetPrim().GetName(): s for s in UsdGeom.Subset.GetAllGeomSubsets(mesh)}
        names = {a.GetName() for a in UsdGeom.PrimvarsAPI(mesh).GetPrimvars()}
        material = UsdShade.MaterialBindingAPI(mesh).GetDirectBinding().GetMaterialPath()
        here = (set(subsets), names, material, {s.GetPrim().GetName() for s in UsdGeom.Subset.GetAllGeomSubsets(sim)})
        first = first or here
        assert here == first, f"level {level} has other sets, primvars or materials"
        sizes.append((len(sim.GetFaceVertexCountsAttr().Get()), len(mesh.GetFaceVertexCountsAttr().Get())))
        # A mesh with crossings or long edges may stand off a little; it is the same garment.
        size = np.ptp(extent(points_of(mesh)), axis=0).max()
        assert np.abs(extent(points_of(mesh)) - extent(points_of(mesh_of(stage, 0)))).max() < 0.05 * size
    for finer, coarser in zip(sizes, sizes[1:]):
        assert coarser[0] < 0.6 * finer[0] and coarser[1] <= finer[1], sizes
    assert product.report["levels"][0]["sim"]["faces"] == sizes[1][0]


def test_the_first_level_is_the_garment_without_levels(built):
    alone, of_levels = built(COAT, *SEAMS), opened(built(COAT, "--lods", "3", *SEAMS))
    for name, of_level in (("sim", "sim"), ("render", "LOD0")):
        one, other = (root_of(stage).GetChild(child) for stage, child in ((alone.stage, name), (of_levels, of_level)))
        for attribute in one.GetAttributes():
            assert other.GetAttribute(attribute.GetName()).Get() == attribute.Get(), attribute.GetPath()
        more = {a.GetName() for a in other.GetAttributes()} - {a.GetName() for a in one.GetAttributes()}
        assert all(":LOD" in name for name in more), more
    assert {p.GetName() for p in root_of(alone.stage).GetChild("physics").GetChildren()} == {
        p.GetName() for p in root_of(of_levels).GetChild("physics").GetChildren()
    }


def test_the_first_level_alone_is_cloth(built):
    stage = opened(built(COAT, "--lods", "3"))
    root = root_of(stage)
    for level in range(COUNT):
        select(stage, level)
        bodies = root.GetMetadata("apiSchemas").GetAddedOrExplicitItems() if root.HasMetadata("apiSchemas") else []
        has_body = any("Deformable" in name for name in bodies)
        simulated = [p.GetName() for p in root.GetChildren() if p.HasAPI(UsdPhysics.CollisionAPI)]
        if level == 0:
            assert has_body and simulated == ["sim"] and root.GetChild("physics")
        else:
            assert not has_body and simulated == [] and not root.GetChild("physics")


def test_thin_seams_are_creases_and_rows_go(built):
    rows = ["--set", "seam.hem.edges=hem", "--set", "seam.hem.offset=1.5", "--set", "seam.hem.width=0.3"]
    product = built(COAT, "--lods", "3", "--set", "seam.centre_back.edges=centre_back", *SEAMS, *rows)
    stage, smooth = opened(product), opened(built(COAT, "--lods", "3"))
    for level, report in enumerate(product.report["levels"], 1):
        assert report["creases"] == ["armholes", "centre_back", "pocket_outline", "side_seams"]
        assert report["leftOut"] == ["hem"]
        mesh, plain = mesh_of(stage, level), mesh_of(smooth, level)
        # Only sharpness is new: the faces are those without seams, and the outline is exactly where it was.
        assert mesh.GetFaceVertexIndicesAttr().Get() == plain.GetFaceVertexIndicesAttr().Get()
        assert sum(mesh.GetCreaseLengthsAttr().Get()) > sum(plain.GetCreaseLengthsAttr().Get() or [])
        faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
        edges = np.sort(np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
        edges, counts = np.unique(edges, axis=0, return_counts=True)
        outline = np.unique(edges[counts == 1])
        moved = np.linalg.norm(points_of(mesh) - points_of(plain), axis=1)
        assert len(outline) > 100 and moved[outline].max() == 0
        # A third of an edge of the cage where cloth is bent along a seam; a fiftieth elsewhere.
        assert moved.max() < 1.2 and np.percentile(moved, 95) < 0.06


def test_folds_are_at_every_level(build, built):
    fold = ["--set", "fold.hem.faces=trim", "--set", "fold.hem.thickness=0.4"]
    folded, plain = opened(build(COAT, "--lods", "3", *fold)), opened(built(COAT, "--lods", "3"))
    for level in range(COUNT):
        meshes = [mesh_of(stage, level) for stage in (folded, plain)]
        counts = [len(mesh.GetFaceVertexCountsAttr().Get()) for mesh in meshes]
        assert counts[0] > counts[1]
        # The outline is that of the garment, and thicker by no more than the fold.
        corners = [extent(points_of(mesh)) for mesh in meshes]
        assert np.abs(corners[0] - corners[1]).max() < 0.5


def test_wide_seams_stay_geometry(build):
    product = build(COAT, "--lods", "2", "--set", "seam.waist.edges=waist_line", "--set", "seam.waist.width=2.5")
    assert product.report["levels"][0]["creases"] == []
    plain = build(COAT, "--lods", "2", stem="plain")
    stages = [opened(p) for p in (product, plain)]
    faces = [len(mesh_of(stage, 1).GetFaceVertexCountsAttr().Get()) for stage in stages]
    assert faces[0] > faces[1]


def bent(points, time):
    """A bend about the vertical axis that grows with the time."""
    angle = 0.05 * time * (points[:, 1] + 100) / 100
    x, z = points[:, 0] * np.cos(angle) - points[:, 2] * np.sin(angle), points[:, 0] * np.sin(angle) + points[:, 2] * np.cos(angle)
    return np.stack([x, points[:, 1], z], axis=1)


@pytest.mark.parametrize("schema", ["variants", "usdLod"])
@pytest.mark.parametrize("driver", ["sim", "sim_LOD1", "sim_LOD2"])
def test_a_cache_of_any_level_drives_all_levels(schema, driver, built, usdtailor, tmp_path):
    product = built(COAT, "--lods", "3", "--lod-schema", schema, *SEAMS)
    sim = root_of(product.stage).GetChild(driver)
    at_bind = points_of(UsdGeom.Mesh(sim))
    np.save(tmp_path / "cache.npy", np.array([bent(at_bind, time) for time in range(4)], np.float32))
    shot = tmp_path / "shot.usdc"
    chosen = [] if driver == "sim" else ["--prim", sim.GetPath()]
    done = run(usdtailor, "drive", product.path, "--cache", tmp_path / "cache.npy", "-o", shot, *chosen)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(shot))
    stage.SetEditTarget(stage.GetSessionLayer())
    for level in range(COUNT):
        if schema == "variants":
            mesh = mesh_of(stage, level)
        else:
            mesh = UsdGeom.Mesh(root_of(stage).GetChild("render").GetChild(f"LOD{level}"))
        times = mesh.GetPointsAttr().GetTimeSamples()
        assert len(times) == 4
        start, end = points_of(mesh), points_of(mesh, times[-1])
        # The coarsest one has edges of 10 on a body of 30 across.
        assert np.abs(end - bent(start, 3)).max() < (0.1 if driver == "sim" else 0.4)
        assert np.abs(end - start).max() > 5


def test_one_mesh_of_a_level_is_driven_alone(built, usdtailor, tmp_path):
    product = built(COAT, "--lods", "3", *SEAMS)
    sim = UsdGeom.Mesh(root_of(product.stage).GetChild("sim"))
    np.save(tmp_path / "cache.npy", points_of(sim)[None].astype(np.float32))
    shot = tmp_path / "shot.usda"
    # Whether it is selected or not.
    for level, other in ((0, 1), (1, 0)):
        done = run(usdtailor, "drive", product.path, "--cache", tmp_path / "cache.npy", "-o", shot, "--prim", f"/Coat/LOD{level}", "--force")
        assert done.returncode == 0, done.stderr
        assert f'"LOD{level}"' in shot.read_text() and f'"LOD{other}"' not in shot.read_text()


def item_of(root, heuristic, size):
    """The level of a size on screen, by the words of OpenUSD's schema."""
    thresholds = list(heuristic.GetThresholdsAttr().Get())
    return next((i for i, threshold in enumerate(thresholds) if size > threshold), len(thresholds))


@pytest.mark.parametrize("source", [COAT, EXAMPLES / "trousers.usda"], ids=["coat", "trousers"])
def test_lod_root_has_nothing_but_levels_and_a_heuristic_beside_it(source, built):
    stage = built(source, "--lods", "4", "--lod-schema", "usdLod", "--set", "lod.ratio=1.5").stage
    root = root_of(stage)
    render = root.GetChild("render")
    api = UsdLod.RootAPI(render)
    assert render.HasAPI(UsdLod.RootAPI) and api.GetLodDefaultIndexAttr().Get() == 0
    assert [child.GetName() for child in render.GetChildren()] == [f"LOD{level}" for level in range(4)]
    assert all(child.IsA(UsdGeom.Mesh) for child in render.GetChildren())
    (path,) = api.GetLodHeuristicsRel().GetTargets()
    heuristic = UsdLod.ScreenSizeHeuristic(stage.GetPrimAtPath(path))
    assert heuristic and not path.HasPrefix(render.GetPath()), "a child of the root would be an item"
    assert heuristic.GetLodDomainAttr().Get() == "imaging"
    thresholds = list(heuristic.GetThresholdsAttr().Get())
    assert len(thresholds) == 3 and thresholds == sorted(thresholds, reverse=True)
    # Half the size on each axis is a quarter of the screen.
    assert thresholds == pytest.approx([0.25 / 1.5 ** (2 * k) for k in range(3)])
    assert [item_of(render, heuristic, size) for size in (0.5, 0.2, 0.1, 0.01)] == [0, 1, 2, 3]
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default", "render"])
    box = cache.ComputeRelativeBound(render.GetChild("LOD0"), root).ComputeAlignedRange()
    assert np.allclose(heuristic.GetExtentAttr().Get(), [box.GetMin(), box.GetMax()], atol=1e-3)
    visible = [UsdGeom.Imageable(child).ComputeVisibility() for child in render.GetChildren()]
    assert visible == ["inherited"] + 3 * ["invisible"], "readers that do not know the schema draw one level"
    assert root.GetChild("physics") and not render.GetChild("physics")
    assert not root.GetVariantSets().HasVariantSet("LOD")


@pytest.mark.parametrize("level", range(COUNT))
def test_a_built_garment_is_fresh_whatever_level_is_selected(level, build, usdtailor):
    product = build(COAT, "--lods", "3")
    layer = Sdf.Layer.FindOrOpen(str(product.path))
    layer.GetPrimAtPath("/Coat").variantSelections["LOD"] = f"LOD{level}"
    over = product.path.with_name(f"shot{level}.usda")
    stage = Usd.Stage.CreateNew(str(over))
    stage.GetRootLayer().subLayerPaths.append(product.path.name)
    assert stage.GetPrimAtPath("/Coat").GetVariantSet("LOD").SetVariantSelection(f"LOD{level}")
    stage.GetRootLayer().Save()
    done = run(usdtailor, "check", over)
    assert done.returncode == 0, done.stderr
    again = run(usdtailor, "build", COAT, "--lods", "3", "-o", product.path, "--skip-fresh", "--force")
    assert "fresh" in again.stdout or level, again.stdout


def test_levels_are_in_packages_and_in_flattened_files(build, tmp_path):
    for suffix, more in ((".usdz", ()), (".usda", ("--flatten",))):
        product = build(COAT, "--lods", "2", *more, suffix=suffix, stem="flat")
        stage = opened(product)
        assert all(len(points_of(mesh_of(stage, level))) > 0 for level in (0, 1))


def test_levels_within_variants_of_the_garment(build, usdtailor, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "sized.usda"))
    root = UsdGeom.Xform.Define(stage, "/Shirt").GetPrim()
    stage.SetDefaultPrim(root)
    sizes = root.GetVariantSets().AddVariantSet("size")
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(49)], axis=1)
    corner = (np.arange(6)[:, None] * 7 + np.arange(6)).ravel()
    for size, scale in (("S", 1.0), ("XL", 1.5)):
        sizes.AddVariant(size)
        sizes.SetVariantSelection(size)
        with sizes.GetVariantEditContext():
            mesh = UsdGeom.Mesh.Define(stage, "/Shirt/model")
            mesh.GetPointsAttr().Set([Gf.Vec3f(*map(float, p)) for p in scale * points])
            mesh.GetFaceVertexCountsAttr().Set([4] * 36)
            mesh.GetFaceVertexIndicesAttr().Set(np.stack([corner, corner + 1, corner + 8, corner + 7], 1).ravel().tolist())
    stage.GetRootLayer().Save()
    done = run(usdtailor, "build", tmp_path / "sized.usda", "--variants", "size", "--lods", "2", "-o", tmp_path / "out.usda")
    assert done.returncode != 0 and ".usdc" in done.stderr and not (tmp_path / "out.usda").exists()
    stage = opened(build(tmp_path / "sized.usda", "--variants", "size", "--lods", "2", suffix=".usdc"))
    root = stage.GetPrimAtPath("/Shirt")
    for size, width in (("S", 6.0), ("XL", 9.0)):
        root.GetVariantSet("size").SetVariantSelection(size)
        for level in (0, 1):
            root.GetVariantSet("LOD").SetVariantSelection(f"LOD{level}")
            points = points_of(UsdGeom.Mesh(root.GetChild(f"LOD{level}")))
            assert np.ptp(points[:, 0]) == pytest.approx(width, rel=0.05), (size, level)


def renders(stage):
    return {p.GetName() for p in stage.Traverse() if p.GetCustomDataByKey("tailor:product") == "render"}


def test_panels_have_levels_of_their_own(usdtailor, suit, tmp_path):
    source, variants, items = suit(), tmp_path / "variants.usda", tmp_path / "items.usda"
    write(usdtailor, source, variants, "--all", "--render-per-panel", "--lods", "2")
    stage = Usd.Stage.Open(str(variants))
    assert renders(stage) == {"LOD0_front", "LOD0_back"}
    stage.GetPrimAtPath("/Suit").GetVariantSet("LOD").SetVariantSelection("LOD1")
    assert renders(stage) == {"LOD1_front", "LOD1_back"}
    write(usdtailor, source, items, "--all", "--render-per-panel", "--lods", "2", "--lod-schema", "usdLod")
    stage = Usd.Stage.Open(str(items))
    lod = stage.GetPrimAtPath("/Suit/render")
    assert lod.HasAPI(UsdLod.RootAPI) and [c.GetName() for c in lod.GetChildren()] == ["LOD0", "LOD1"]
    assert all({c.GetName() for c in level.GetChildren()} == {"front", "back"} for level in lod.GetChildren())


def test_trims_ride_on_every_level(build):
    product = build(EXAMPLES / "trims/skirt.usda", "--lods", "2")
    bound = [p for p in product.stage.Traverse() if p.HasRelationship("tailor:bindTarget")]
    trims = [p for p in bound if not p.GetCustomDataByKey("tailor:product")]
    assert trims
    for trim in trims:
        targets = [trim.GetRelationship(f"tailor:bindTarget{level}").GetTargets()[0].name for level in ("", ":LOD1")]
        assert targets == ["sim", "sim_LOD1"], trim.GetPath()
        faces = [trim.GetAttribute(f"primvars:tailor:bindFace{level}").Get() for level in ("", ":LOD1")]
        assert len(faces[0]) == len(faces[1]) and faces[0] != faces[1]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda root: root.GetVariantSets().AddVariantSet("LOD").AddVariant("near"), "has variants of the set LOD"),
        (lambda root: UsdGeom.Xform.Define(root.GetStage(), "/Coat/LOD0"), "/Coat/LOD0 is taken"),
    ],
    ids=["set", "name"],
)
def test_what_is_there_already_is_not_hidden(make, words, usdtailor, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "coat.usda"))
    stage.GetRootLayer().subLayerPaths.append(str(COAT))
    make(stage.GetPrimAtPath("/Coat"))
    if root := stage.GetPrimAtPath("/Coat").GetVariantSet("LOD"):
        if root.GetVariantNames():
            root.SetVariantSelection("near")
    stage.GetRootLayer().Save()
    done = run(usdtailor, "build", tmp_path / "coat.usda", "--lods", "2", "-o", tmp_path / "out.usda")
    assert done.returncode != 0 and words in done.stderr, done.stderr
    assert not (tmp_path / "out.usda").exists()


def test_products_of_an_earlier_build_are_not_hidden(build, usdtailor, tmp_path):
    product = build(COAT)
    done = run(usdtailor, "build", product.path, "--lods", "2", "-o", tmp_path / "out.usda")
    assert done.returncode != 0 and "has products already" in done.stderr, done.stderr


@pytest.mark.parametrize("schema", ["variants", "usdLod"])
def test_levels_of_an_earlier_build_do_not_stay(schema, build, usdtailor, tmp_path):
    product = build(COAT, "--lods", "2", "--lod-schema", schema)
    done = run(usdtailor, "build", product.path, "-o", tmp_path / "out.usda")
    assert done.returncode != 0 and "levels of detail of an earlier build" in done.stderr, done.stderr
    assert not (tmp_path / "out.usda").exists()


def test_garments_of_one_parent_have_as_many_levels(usdtailor, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "two.usda"))
    UsdGeom.Xform.Define(stage, "/Suit")
    for name, levels, x in (("shirt", 3, 0.0), ("skirt", 2, 50.0)):
        mesh = UsdGeom.Mesh.Define(stage, f"/Suit/{name}")
        mesh.GetPointsAttr().Set([(x + i % 5, i // 5, 0) for i in range(25)])
        mesh.GetFaceVertexCountsAttr().Set([4] * 16)
        corners = [i + i // 4 for i in range(16)]
        mesh.GetFaceVertexIndicesAttr().Set([at + step for at in corners for step in (0, 1, 6, 5)])
        mesh.GetPrim().CreateAttribute("tailor:lod:levels", Sdf.ValueTypeNames.Int).Set(levels)
    stage.GetRootLayer().Save()
    done = run(usdtailor, "build", tmp_path / "two.usda", "--all", "-o", tmp_path / "out.usda")
    assert done.returncode != 0 and "the same lod.levels" in done.stderr, done.stderr
    done = run(usdtailor, "build", tmp_path / "two.usda", "--all", "--lods", "2", "-o", tmp_path / "out.usda")
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    for level in range(2):
        stage.GetPrimAtPath("/Suit").GetVariantSet("LOD").SetVariantSelection(f"LOD{level}")
        assert all(stage.GetPrimAtPath(f"/Suit/{name}_render_LOD{level}").IsDefined() for name in ("shirt", "skirt"))


def test_info_tells_the_sizes_of_levels(usdtailor, built):
    done = run(usdtailor, "info", COAT, "--lods", "3", "--json")
    told = json.loads(done.stdout)["inputs"][0]["levels"]
    made = built(COAT, "--lods", "3").report["levels"]
    assert [level["faces"] for level in told] == [level["render"]["faces"] for level in made]
    for level, report in zip(told, made):
        # The estimate is without what seams and borders add, which is most where triangles are large.
        assert 0.3 * report["sim"]["faces"] < level["triangles"] <= report["sim"]["faces"]


def test_a_level_that_repeats_the_one_before_it_is_told(usdtailor, tmp_path):
    for level, count in ((2, 0), (1, 1), (0, 2)):
        done = run(usdtailor, "build", COAT, "-o", tmp_path / f"{level}.usdc", "--lods", 3, "--set", f"render.level={level}", "--strict")
        assert done.returncode == 0 and done.stderr.count("the render mesh repeats that of the level before") == count, done.stderr
    assert "[level-repeats]" in done.stderr and "at level of detail 2" in done.stderr
