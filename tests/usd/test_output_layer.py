"""The written layer as a piece of USD: valid, small, composed over its input, which it leaves alone."""

import os

import pytest
from conftest import make, run
from pxr import Sdf, Usd, UsdGeom, UsdValidation
from sources import write

FORMS = [
    pytest.param((), ".usda", id="layer-usda"),
    pytest.param((), ".usdc", id="layer-usdc"),
    pytest.param(("--flatten",), ".usda", id="flat-usda"),
    pytest.param(("--flatten",), ".usdc", id="flat-usdc"),
    pytest.param(("--flatten",), ".usdz", id="flat-usdz"),
    pytest.param(("--sets", "all", "--mark", "--provenance", "--physics", "aousd,omni,chaos", "--set", "cloth.panels=true"), ".usda", id="all-prims"),
]
FLAT = [form for form in FORMS if "--flatten" in form.values[0]]
STAGE_METADATA = ["defaultPrim", "upAxis", "metersPerUnit", "kilogramsPerUnit", "timeCodesPerSecond", "framesPerSecond", "startTimeCode", "endTimeCode"]


def validation_errors(stage):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [f"{error.GetName()}: {error.GetMessage()}" for error in UsdValidation.ValidationContext(validators).Validate(stage)]


def specs(layer):
    """Every spec of the layer: path to spec."""
    found = {}
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: found.__setitem__(path, layer.GetObjectAtPath(path)))
    return found


@pytest.mark.parametrize("args, suffix", FORMS)
def test_validators_find_nothing_new(garment, built, args, suffix):
    """What the input is blamed for is not ours; usdz asks more of a stage, so it is held to nothing less."""
    product = built(garment, *args, suffix=suffix)
    before = [] if suffix == ".usdz" else validation_errors(product.source_stage)
    model = str(product.model_path)
    ours = [str(product.model_path.ReplaceName(name)) for name in ("sim", "render")]

    def as_of_the_model(error):
        """What the model is blamed for, its two products inherit."""
        for path in ours:
            error = error.replace(path, model)
        return error

    assert [error for error in validation_errors(product.stage) if as_of_the_model(error) not in before] == []


def test_sets_of_expressions_are_in_families_of_one_kind(build, tmp_path):
    """A family with faces and edges is none, for OpenUSD."""
    source = write(tmp_path / "in.usda")
    options = ["seam.edge.edges=borders", "fold.hem.faces=faces", "render.level=1", "sim.constraints=uvSeams"]
    product = build(source, "--sets", "all", *(word for option in options for word in ("--set", option)))
    kinds = {}
    for name in ("sim", "render"):
        for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(product.prim(name))):
            kinds.setdefault((name, subset.GetFamilyNameAttr().Get()), set()).add(subset.GetElementTypeAttr().Get())
    assert all(len(kinds_of_one) == 1 for kinds_of_one in kinds.values()), kinds
    assert {kind for of_one in kinds.values() for kind in of_one} >= {"face", "edge"}
    assert validation_errors(product.stage) == []


@pytest.mark.parametrize("name", ["sim", "render"])
def test_subset_families_are_valid(product, name):
    before = family_faults(product.source.prim)
    assert [fault for fault in family_faults(product.prim(name)) if fault not in before] == []


def family_faults(prim):
    """What OpenUSD holds against the subset families, by family and element type."""
    mesh, faults = UsdGeom.Mesh(prim), []
    for family in UsdGeom.Subset.GetAllGeomSubsetFamilyNames(mesh):
        for element in {subset.GetElementTypeAttr().Get() for subset in UsdGeom.Subset.GetGeomSubsets(mesh, familyName=family)}:
            valid, reason = UsdGeom.Subset.ValidateFamily(mesh, element, family)
            if not valid:
                faults.append((family, element, reason))
    return faults


def test_output_sublayers_the_input_by_a_relative_path(product):
    (sublayer,) = product.stage.GetRootLayer().subLayerPaths
    assert not os.path.isabs(sublayer)
    assert (product.path.parent / sublayer).resolve() == product.source_path.resolve()


def test_output_holds_only_the_two_meshes_and_the_purpose(product):
    """Ancestors are overs, the model has its purpose, all else belongs to the two meshes and their physics."""
    layer, model = product.stage.GetRootLayer(), product.model_path
    meshes = {model.ReplaceName("sim"), model.ReplaceName("render")}
    ours = meshes | {model.ReplaceName("physics")}
    for path, spec in specs(layer).items():
        if path == Sdf.Path.absoluteRootPath or any(path.HasPrefix(root) for root in ours):
            continue
        if isinstance(spec, Sdf.PrimSpec):
            assert path == model or model.HasPrefix(path), f"{path} is not an ancestor of the model"
            assert spec.specifier == Sdf.SpecifierOver, f"{path} is written as {spec.specifier}"
            assert not spec.typeName, f"{path} has a type: {spec.typeName}"
        else:
            assert path.GetPrimPath() == model, f"{path} is copied from the input"
            assert path.name == "purpose", f"{path} is copied from the input"
    for root in meshes:
        assert layer.GetPrimAtPath(root).specifier == Sdf.SpecifierDef
        assert layer.GetPrimAtPath(root).typeName == "Mesh"


def test_everything_of_the_input_is_still_there(product):
    for prim in product.source_stage.TraverseAll():
        there = product.stage.GetPrimAtPath(prim.GetPath())
        assert there, f"{prim.GetPath()} is gone"
        assert there.GetTypeName() == prim.GetTypeName()
        schemas = list(there.GetPrimTypeInfo().GetAppliedAPISchemas())
        if prim.GetPath() == product.model_path.GetParentPath():
            schemas.remove("PhysicsDeformableBodyAPI")
        assert schemas == list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())
        for attribute in prim.GetAuthoredAttributes():
            if attribute.GetName() != "purpose":
                assert there.GetAttribute(attribute.GetName()).Get() == attribute.Get(), attribute.GetPath()


def test_purposes(product):
    purpose = {name: UsdGeom.Imageable(product.prim(name)).GetPurposeAttr().Get() for name in ("sim", "render")}
    purpose["model"] = UsdGeom.Imageable(product.stage.GetPrimAtPath(product.model_path)).GetPurposeAttr().Get()
    assert purpose == {"model": "guide", "sim": "guide", "render": "default"}


def test_stage_metadata_is_copied(product):
    before, after = product.source_stage.GetRootLayer().pseudoRoot, product.stage.GetRootLayer().pseudoRoot
    for key in STAGE_METADATA:
        assert after.HasInfo(key) == before.HasInfo(key), key
        assert after.GetInfo(key) == before.GetInfo(key), key


def test_new_meshes_stand_where_the_model_stands(product):
    places = UsdGeom.XformCache()
    where = places.GetLocalToWorldTransform(product.stage.GetPrimAtPath(product.model_path))
    for name in ("sim", "render"):
        assert places.GetLocalToWorldTransform(product.prim(name)) == where


@pytest.mark.parametrize("name", ["model", "sim", "render"])
def test_extent_is_the_box_of_the_points(product, name):
    if name == "model" and UsdGeom.Mesh(product.prim(name)).GetExtentAttr().Get() is None:
        pytest.skip("the input has no extent: its own business")
    mesh = UsdGeom.Mesh(product.prim(name))
    expected = UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get())
    assert mesh.GetExtentAttr().Get() == expected


def test_input_is_untouched(garment, usdtailor, tmp_path):
    content, time = garment.read_bytes(), garment.stat().st_mtime_ns
    neighbours = sorted(garment.parent.iterdir())
    make(usdtailor, garment, tmp_path)
    assert garment.read_bytes() == content
    assert garment.stat().st_mtime_ns == time
    assert sorted(garment.parent.iterdir()) == neighbours
    assert sorted(path.name for path in tmp_path.iterdir()) == ["built.usda", "built.usda.json"], "something is left over"


@pytest.mark.parametrize("args, suffix", FLAT)
def test_flat_output_needs_no_other_file(garment, built, tmp_path, args, suffix):
    product = built(garment, *args, suffix=suffix)
    moved = tmp_path / f"moved{suffix}"
    moved.write_bytes(product.path.read_bytes())
    stage = Usd.Stage.Open(str(moved))
    layers = {layer.identifier for layer in stage.GetUsedLayers() if not layer.anonymous}
    assert all(layer.startswith(str(moved)) for layer in layers), layers
    for name in ("model", "sim", "render"):
        assert stage.GetPrimAtPath(product.model_path.ReplaceName(name)), name


def test_output_is_not_overwritten_without_force(garment, usdtailor, tmp_path):
    product = make(usdtailor, garment, tmp_path)
    before = product.path.read_bytes()
    refused = run(usdtailor, "build", garment, "-o", product.path)
    assert refused.returncode == 1
    assert "--force" in refused.stderr
    assert product.path.read_bytes() == before
    forced = run(usdtailor, "build", garment, "-o", product.path, "--force")
    assert forced.returncode == 0, forced.stderr


def test_same_bytes_for_any_number_of_threads(garment, usdtailor, tmp_path):
    written = {make(usdtailor, garment, tmp_path, "--threads", n, stem=f"threads{n}").path.read_bytes() for n in (1, 2, 8)}
    assert len(written) == 1


def test_families_without_sets_are_left_out(build, tmp_path):
    subsets = [{"name": "left", "family": "kept", "indices": [0, 1, 4, 5]}]
    source = write(tmp_path / "in.usda", subsets=subsets, families={"kept": "unrestricted", "gone": "unrestricted"})
    product = build(source)
    assert product.source_stage.GetPrimAtPath(product.model_path).HasAttribute("subsetFamily:gone:familyType")
    for name in ("sim", "render"):
        prim = product.prim(name)
        assert prim.GetAttribute("subsetFamily:kept:familyType").Get() == "unrestricted"
        assert not prim.HasAttribute("subsetFamily:gone:familyType"), name


def test_large_numbers_are_short_and_exact(build, tmp_path):
    values = {"double": 1e20, "less": -1.2345678901234567e18, "float": 2.0**70, "least": 1e16, "long": 12345678901234567, "text": "1" + "0" * 20}

    def author(mesh):
        for name, value in values.items():
            kind = {"text": Sdf.ValueTypeNames.String, "long": Sdf.ValueTypeNames.Int64, "float": Sdf.ValueTypeNames.Float}
            mesh.GetPrim().CreateAttribute(f"userProperties:{name}", kind.get(name, Sdf.ValueTypeNames.Double)).Set(value)

    product = build(write(tmp_path / "in.usda", finish=author), "--flatten")
    text = product.path.read_text()
    for words in ("= 1e+20\n", "= -1.2345678901234568e+18\n", "= 1e+16\n", "= 12345678901234567\n", '= "100000000000000000000"\n'):
        assert words in text, words
    model = product.stage.GetPrimAtPath(product.model_path)
    assert {name: model.GetAttribute(f"userProperties:{name}").Get() for name in values} == values
