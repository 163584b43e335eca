"""`--variants`: products inside each variant of a set, in one output."""

import json

import numpy
import pytest
from conftest import run
from pxr import Sdf, Usd, UsdGeom, UsdShade
from sources import sheet, write

SIZES = {"S": 1.0, "M": 1.3, "L": 1.7}


@pytest.fixture
def sized(tmp_path):
    """A garment in three sizes: the points are inside the variants, and the large one has a finer render mesh."""
    path = write(tmp_path / "sized.usda", shape=lambda: sheet(8, 6))
    stage = Usd.Stage.Open(str(path))
    model = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    points = numpy.array(UsdGeom.Mesh(model).GetPointsAttr().Get())
    model.RemoveProperty("points")
    sizes = model.GetParent().GetVariantSets().AddVariantSet("size")
    for name, scale in SIZES.items():
        sizes.AddVariant(name)
        sizes.SetVariantSelection(name)
        with sizes.GetVariantEditContext():
            UsdGeom.Mesh(model).CreatePointsAttr().Set(points * scale)
            if name == "L":
                model.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(2)
    sizes.SetVariantSelection("M")
    stage.Save()
    return path


def selected(path, name):
    """The output with a variant selected in a layer over it, as a shot does."""
    stage = Usd.Stage.Open(str(path))
    stage.SetEditTarget(stage.GetSessionLayer())
    root = stage.GetDefaultPrim()
    assert root.GetVariantSets().GetVariantSet("size").SetVariantSelection(name)
    return stage, root.GetPath()


def mesh(stage, path):
    found = UsdGeom.Mesh(stage.GetPrimAtPath(path))
    return numpy.array(found.GetPointsAttr().Get()), list(found.GetFaceVertexCountsAttr().Get())


def test_each_variant_shows_what_a_build_of_it_alone_shows(usdtailor, sized, tmp_path):
    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", sized, "-o", out, "--variants", "size")
    assert done.returncode == 0, done.stderr
    assert all(f"size={name}" in done.stdout for name in SIZES)
    for name in SIZES:
        alone = tmp_path / f"{name}.usda"
        shot = tmp_path / f"shot_{name}.usda"
        stage, root = selected(sized, name)
        stage.Flatten().Export(str(shot))
        assert run(usdtailor, "build", shot, "-o", alone).returncode == 0
        stage, root = selected(out, name)
        expected = Usd.Stage.Open(str(alone))
        for product in ("sim", "render"):
            found, wanted = (mesh(of, root.AppendChild(product)) for of in (stage, expected))
            assert found[1] == wanted[1] and numpy.array_equal(found[0], wanted[0]), (name, product)
            properties, others = ({p.GetName() for p in of.GetPrimAtPath(root.AppendChild(product)).GetAuthoredProperties()} for of in (stage, expected))
            assert properties == others
            children = [{c.GetName() for c in of.GetPrimAtPath(root.AppendChild(product)).GetChildren()} for of in (stage, expected)]
            assert children[0] == children[1]
        model = next(prim for prim in stage.Traverse() if prim.GetName() not in ("sim", "render") and prim.IsA(UsdGeom.Mesh))
        assert UsdGeom.Mesh(model).GetPurposeAttr().Get() == "guide"
        for prim in Usd.PrimRange(stage.GetPrimAtPath(root)):
            for relationship in prim.GetRelationships():
                assert all(stage.GetObjectAtPath(target) for target in relationship.GetTargets()), relationship


def test_the_output_stays_a_layer_over_the_input_and_is_fresh_in_each_variant(usdtailor, sized, tmp_path):
    out = tmp_path / "out.usdc"
    assert run(usdtailor, "build", sized, "-o", out, "--variants", "size").returncode == 0
    layer = Sdf.Layer.FindOrOpen(str(out))
    assert layer.subLayerPaths == ["./sized.usda"] or list(layer.subLayerPaths) == ["sized.usda"]
    root = Usd.Stage.Open(str(out)).GetDefaultPrim().GetPath()
    assert set(layer.GetPrimAtPath(root).variantSets["size"].variants.keys()) == set(SIZES)
    for name in SIZES:
        shot = tmp_path / f"{name}.usda"
        shot.write_text(f'#usda 1.0\n(\n    defaultPrim = "{root.name}"\n    subLayers = [@./out.usdc@]\n)\nover "{root.name}" (\n    variants = {{ string size = "{name}" }}\n)\n{{\n}}\n')
        checked = run(usdtailor, "check", shot)
        assert "stale" not in checked.stdout + checked.stderr, checked.stdout + checked.stderr
    again = run(usdtailor, "build", sized, "-o", out, "--variants", "size", "--skip-fresh", "--force")
    assert "fresh" in again.stdout
    other = run(usdtailor, "build", sized, "-o", out, "--skip-fresh", "--force")
    assert other.returncode == 0 and "fresh" not in other.stdout


def test_the_report_has_each_variant(usdtailor, sized, tmp_path):
    done = run(usdtailor, "build", sized, "-o", tmp_path / "out.usda", "--variants", "size", "--report", "-")
    garments = json.loads(done.stdout)["garments"]
    assert [garment["variant"]["choice"] for garment in garments] == sorted(SIZES)
    assert garments[0]["recipe"]["render"]["level"] == 2, "options inside a variant are its own"
    planned = run(usdtailor, "build", sized, "-o", tmp_path / "other.usda", "--variants", "size", "--dry-run")
    assert all(f" in {name}" in planned.stdout for name in SIZES) and not (tmp_path / "other.usda").exists()


def test_a_wrong_set_is_refused_with_those_that_there_are(usdtailor, sized, tmp_path):
    out = tmp_path / "out.usda"
    refused = run(usdtailor, "build", sized, "-o", out, "--variants", "sise")
    assert refused.returncode == 2 and not out.exists()
    assert "did you mean size?" in refused.stderr


def test_a_package_with_variants_is_refused(usdtailor, sized, tmp_path):
    refused = run(usdtailor, "build", sized, "-o", tmp_path / "out.usdz", "--variants", "size")
    assert refused.returncode and "no variants" in refused.stderr and not (tmp_path / "out.usdz").exists()


def test_a_set_on_the_model_itself_is_refused(usdtailor, tmp_path):
    path = write(tmp_path / "in.usda")
    stage = Usd.Stage.Open(str(path))
    model = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    fits = model.GetVariantSets().AddVariantSet("fit")
    fits.AddVariant("slim")
    fits.SetVariantSelection("slim")
    stage.Save()
    refused = run(usdtailor, "build", path, "-o", tmp_path / "out.usda", "--variants", "fit")
    assert refused.returncode == 2 and "beside it" in refused.stderr


def test_products_outside_of_variants_are_not_hidden_in(usdtailor, sized, tmp_path):
    plain = tmp_path / "plain.usda"
    assert run(usdtailor, "build", sized, "-o", plain).returncode == 0
    refused = run(usdtailor, "build", plain, "-o", tmp_path / "out.usda", "--variants", "size")
    assert refused.returncode == 1 or refused.returncode == 2
    assert "has products already" in refused.stderr and not (tmp_path / "out.usda").exists()


@pytest.mark.parametrize("selection", ["none", ""], ids=["empty", "unselected"])
@pytest.mark.parametrize("options", [(), ("--prim", "/Asset/model")], ids=["any", "named"])
def test_an_empty_variant_is_named_as_the_cause(usdtailor, tmp_path, selection, options):
    path = tmp_path / "in.usda"
    stage = Usd.Stage.CreateNew(str(path))
    root = stage.DefinePrim("/Asset", "Xform")
    stage.SetDefaultPrim(root)
    fits = root.GetVariantSets().AddVariantSet("fit")
    for name in ("none", "slim"):
        fits.AddVariant(name)
    fits.SetVariantSelection("slim")
    with fits.GetVariantEditContext():
        UsdGeom.Mesh.Define(stage, "/Asset/model")
    fits.SetVariantSelection(selection)
    stage.Save()
    refused = run(usdtailor, "build", path, "-o", tmp_path / "out.usda", *options)
    said = "/Asset has fit=none, of none, slim" if selection else "/Asset has no selection of fit, of none, slim"
    assert refused.returncode == 1 and said in refused.stderr, refused.stderr


def test_garments_of_one_variant_do_not_replace_each_other(usdtailor, tmp_path):
    """Two meshes below one prim, with `--all`: both have their products in each variant."""
    path = tmp_path / "suit.usda"
    stage = Usd.Stage.CreateNew(str(path))
    root = stage.DefinePrim("/Suit", "Xform")
    stage.SetDefaultPrim(root)
    points, counts, corners = sheet(6, 4)
    for x, name in enumerate(("shirt", "belt")):
        model = UsdGeom.Mesh.Define(stage, f"/Suit/{name}")
        model.GetFaceVertexCountsAttr().Set(counts)
        model.GetFaceVertexIndicesAttr().Set(corners)
        model.GetPointsAttr().Set([(p[0] + 100 * x, p[1], p[2]) for p in points])
    sizes = root.GetVariantSets().AddVariantSet("size")
    for name in ("S", "L"):
        sizes.AddVariant(name)
    sizes.SetVariantSelection("S")
    stage.Save()
    plain, out = tmp_path / "plain.usda", tmp_path / "out.usda"
    assert run(usdtailor, "build", path, "-o", plain, "--all").returncode == 0
    done = run(usdtailor, "build", path, "-o", out, "--all", "--variants", "size")
    assert done.returncode == 0, done.stderr
    expected = Usd.Stage.Open(str(plain))
    names = {prim.GetPath() for prim in Usd.PrimRange(expected.GetPrimAtPath("/Suit"))}
    for name in ("S", "L"):
        found, _ = selected(out, name)
        assert {prim.GetPath() for prim in Usd.PrimRange(found.GetPrimAtPath("/Suit"))} == names


def test_a_file_of_any_variant_makes_the_output_stale(usdtailor, sized, tmp_path):
    part = tmp_path / "large.usda"
    stage = Usd.Stage.Open(str(sized))
    root = stage.GetDefaultPrim()
    part.write_text(f'#usda 1.0\ndef Xform "{root.GetName()}" {{\n    custom int note = 1\n}}\n')
    sizes = root.GetVariantSets().GetVariantSet("size")
    sizes.SetVariantSelection("S")
    with sizes.GetVariantEditContext():
        root.GetReferences().AddReference("./large.usda", root.GetPath())
    sizes.SetVariantSelection("M")
    stage.Save()
    args = ("build", sized, "-o", tmp_path / "out.usda", "--variants", "size", "--force", "--skip-fresh")
    assert run(usdtailor, *args).returncode == 0
    assert "fresh" in run(usdtailor, *args).stdout
    part.write_text(part.read_text().replace("note = 1", "note = 2"))
    done = run(usdtailor, *args)
    assert done.returncode == 0 and "fresh" not in done.stdout, done.stdout


@pytest.mark.parametrize("args", [[], ["--prim", "/Coat/model"]], ids=["alone", "named"])
def test_a_stage_may_select_a_variant_without_the_mesh(usdtailor, tmp_path, args):
    path = write(tmp_path / "whole.usda", shape=lambda: sheet(4, 3))
    stage = Usd.Stage.CreateNew(str(tmp_path / "worn.usda"))
    root = stage.DefinePrim("/Coat", "Xform")
    stage.SetDefaultPrim(root)
    worn = root.GetVariantSets().AddVariantSet("worn")
    for name in ("off", "on", "twice"):
        worn.AddVariant(name)
        worn.SetVariantSelection(name)
        if name != "off":
            with worn.GetVariantEditContext():
                root.GetReferences().AddReference("./whole.usda")
    worn.SetVariantSelection("off")
    stage.Save()
    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", tmp_path / "worn.usda", "-o", out, "--variants", "worn", *args)
    assert done.returncode == 0, done.stderr
    assert "{worn=off}" in done.stderr and path.exists()
    built = Usd.Stage.Open(str(out))
    root = built.GetDefaultPrim()
    for name in ("off", "on", "twice"):
        root.GetVariantSets().GetVariantSet("worn").SetVariantSelection(name)
        assert bool(built.GetPrimAtPath("/Coat/render")) == (name != "off")


def add_looks(path):
    """Variants bind materials: one binds the mesh, one a set of its faces, and one nothing. One has another colour."""
    stage = Usd.Stage.Open(str(path))
    root = stage.GetDefaultPrim()
    model = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    materials = {name: UsdShade.Material.Define(stage, f"{root.GetPath()}/materials/{name}") for name in ("wool", "tartan", "trim")}
    faces = UsdGeom.Subset.CreateGeomSubset(UsdGeom.Mesh(model), "cuff", "face", [0, 1, 2], "materialBind", "nonOverlapping")
    looks = root.GetVariantSets().AddVariantSet("look")
    for name in ("plain", "wool", "tartan", "cuffed"):
        looks.AddVariant(name)
        looks.SetVariantSelection(name)
        with looks.GetVariantEditContext():
            if name in ("wool", "tartan"):
                UsdShade.MaterialBindingAPI.Apply(model).Bind(materials[name])
            if name == "cuffed":
                UsdShade.MaterialBindingAPI.Apply(faces.GetPrim()).Bind(materials["trim"])
    looks.SetVariantSelection("plain")
    stage.Save()
    return path, model.GetPath()


def materials_of(stage, prim):
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    cuff = prim.GetChild("cuff")
    return [str(m.GetPath()) for m in (bound, UsdShade.MaterialBindingAPI(cuff).ComputeBoundMaterial()[0])]


@pytest.mark.parametrize("selected_at_build", ["plain", "wool", "cuffed"])
@pytest.mark.parametrize("args", [["--variants", "size"], []], ids=["sizes", "one"])
def test_products_follow_the_materials_of_other_sets(usdtailor, sized, tmp_path, args, selected_at_build):
    path, model = add_looks(sized)
    stage = Usd.Stage.Open(str(path))
    stage.GetDefaultPrim().GetVariantSet("look").SetVariantSelection(selected_at_build)
    stage.Save()
    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", path, "-o", out, "--set", "render.level=0", *args)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(out))
    seen = set()
    for look in ("plain", "wool", "tartan", "cuffed"):
        stage.GetDefaultPrim().GetVariantSet("look").SetVariantSelection(look)
        right = materials_of(stage, stage.GetPrimAtPath(model))
        for name in ("render", "sim"):
            product = stage.GetPrimAtPath(model.GetParentPath().AppendChild(name))
            assert materials_of(stage, product) == right, (look, name)
        seen.add(tuple(right))
    assert len(seen) == 4


def test_what_products_keep_of_a_variant_is_told(usdtailor, sized, tmp_path):
    out = tmp_path / "out.usda"
    base = ("build", sized, "-v", "--set", "render.level=0", "-o")
    said = run(usdtailor, *base, out).stderr
    assert "frozen-variant" in said and "`points` of size=M" in said and "--variants size" in said
    assert "frozen-variant" not in run(usdtailor, *base, tmp_path / "sizes.usda", "--variants", "size").stderr
    said = run(usdtailor, *base, tmp_path / "flat.usda", "--flatten").stderr
    assert "the flattened output is of size=M" in said
    # Notes do not fail a strict build.
    assert run(usdtailor, *base, tmp_path / "strict.usda", "--strict", "--set", "sim.uvSet=").returncode == 0


def test_a_set_of_materials_alone_is_not_frozen(usdtailor, sized, tmp_path):
    path, _ = add_looks(sized)
    said = run(usdtailor, "build", path, "-o", tmp_path / "out.usda", "--variants", "size", "--set", "render.level=0").stderr
    assert "frozen-variant" not in said
    stage = Usd.Stage.Open(str(path))
    root = stage.GetDefaultPrim()
    model = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    looks = root.GetVariantSet("look")
    looks.SetVariantSelection("tartan")
    with looks.GetVariantEditContext():
        UsdGeom.PrimvarsAPI(model).CreatePrimvar("tint", Sdf.ValueTypeNames.Color3fArray, "constant").Set([(1, 0, 0)])
    stage.Save()
    said = run(usdtailor, "build", path, "-o", tmp_path / "two.usda", "--variants", "size", "--set", "render.level=0").stderr
    assert "frozen-variant" in said and "`primvars:tint` of look=tartan" in said
