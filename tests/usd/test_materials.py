"""Materials of products: those of the garment face by face, whatever a program takes from subsets without a material."""

import numpy as np
import pytest
from conftest import EXAMPLES
from mesh import find_model
from pxr import Sdf, Usd, UsdGeom, UsdShade
from sources import add_subset, bind, sheet, write

BOUND = {"name": "cuff", "indices": [2, 3, 6], "family": "materialBind", "material": "silk"}
BARE = [{"name": "panel", "indices": [0, 1]}, {"name": "line", "indices": [0, 1], "element": "edge", "family": "edges"}]


def garment(path, subsets, change=lambda mesh: None, material="wool"):
    def finish(mesh):
        if material:
            bind(mesh.GetPrim(), material)
        for subset in subsets:
            add_subset(mesh, **subset)
        change(mesh)

    return write(path, shape=sheet, finish=finish)


def materials(prim, purpose=""):
    """The name of the material of each face."""
    mesh = UsdGeom.Mesh(prim)

    def name(prim):
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)
        return material.GetPrim().GetName() if material else None

    found = np.full(len(mesh.GetFaceVertexCountsAttr().Get()), name(prim), dtype=object)
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        found[list(subset.GetIndicesAttr().Get())] = name(subset.GetPrim())
    return found


def inheriting(prim):
    """Subsets that a program which reads all of them draws with a material that is not theirs."""
    subsets = UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim))
    own = lambda p: UsdShade.MaterialBindingAPI(p).GetDirectBindingRel().HasAuthoredTargets()
    bound = lambda p: UsdShade.MaterialBindingAPI(p).ComputeBoundMaterial()[0]
    return [s.GetPrim().GetName() for s in subsets if bound(s.GetPrim()) and not own(s.GetPrim())]


@pytest.mark.parametrize("sets", ["none", "authored", "all"])
def test_faces_keep_their_materials_and_sets_inherit_none(build, tmp_path, sets):
    path = garment(tmp_path / "a.usda", [BOUND, *BARE])
    product = build(path, "--sets", sets, "--set", "render.level=0")
    source = materials(find_model(product.source_stage))
    assert set(source) == {"wool", "silk"}
    assert np.array_equal(materials(product.prim("render")), source)
    assert set(materials(product.prim("sim"))) == {"wool", "silk"}
    for prim in (product.prim("sim"), product.prim("render")):
        assert inheriting(prim) == [] and prim.GetChildren()[-1].GetName() == "tailorMaterial"
        mesh = UsdGeom.Imageable(prim)
        assert UsdGeom.Subset.ValidateFamily(mesh, UsdGeom.Tokens.face, "materialBind")[0]
        assert UsdGeom.Subset.GetFamilyType(mesh, "materialBind") == "nonOverlapping"


def stronger(mesh):
    UsdShade.MaterialBindingAPI(mesh.GetPrim()).Bind(
        UsdShade.Material(mesh.GetPrim().GetStage().GetPrimAtPath("/Coat/materials/wool")),
        UsdShade.Tokens.strongerThanDescendants,
    )


def of_a_purpose(mesh):
    stage = mesh.GetPrim().GetStage()
    tweed = UsdShade.Material.Define(stage, "/Coat/materials/tweed")
    UsdShade.MaterialBindingAPI(mesh.GetPrim()).Bind(tweed, materialPurpose=UsdShade.Tokens.preview)


@pytest.mark.parametrize("change", [stronger, of_a_purpose])
@pytest.mark.parametrize("purpose", ["", "preview", "full"])
def test_a_material_that_holds_for_subsets_too_stays_on_the_mesh(build, tmp_path, change, purpose):
    product = build(garment(tmp_path / "a.usda", [BOUND, *BARE], change), "--set", "render.level=0")
    source = materials(find_model(product.source_stage), purpose)
    assert np.array_equal(materials(product.prim("render"), purpose), source)
    own = UsdShade.MaterialBindingAPI(product.prim("render").GetChild("cuff")).GetDirectBindingRel().GetTargets()
    assert own == ["/Coat/materials/silk"], "a binding that another one hides is kept"


def test_a_garment_of_one_material_keeps_it_on_the_mesh(build, tmp_path):
    product = build(garment(tmp_path / "a.usda", BARE), "--set", "render.level=0")
    for prim in (product.prim("sim"), product.prim("render")):
        targets = UsdShade.MaterialBindingAPI(prim).GetDirectBindingRel().GetTargets()
        assert targets == ["/Coat/materials/wool"] and not prim.GetChild("tailorMaterial")


def test_a_material_of_no_face_is_not_lost(build, tmp_path):
    rest = {**BOUND, "name": "body", "indices": sorted(set(range(12)) - {2, 3, 6}), "material": "linen"}
    product = build(garment(tmp_path / "a.usda", [BOUND, rest, *BARE]), "--set", "render.level=0")
    prim = product.prim("render")
    assert UsdGeom.Subset.ValidateFamily(UsdGeom.Imageable(prim), UsdGeom.Tokens.face, "materialBind")[0]
    rest = prim.GetChild("tailorMaterial")
    assert UsdShade.MaterialBindingAPI(rest).GetDirectBindingRel().GetTargets() == ["/Coat/materials/wool"]
    assert len(UsdGeom.Subset(rest).GetIndicesAttr().Get()) == 0 and inheriting(prim) == []
    assert np.array_equal(materials(product.prim("render")), materials(find_model(product.source_stage)))


def test_a_material_of_an_earlier_product_is_gone(build, tmp_path):
    """As versions wrote it that bound the mesh itself."""
    first = build(garment(tmp_path / "a.usda", [BOUND, *BARE]), "--set", "render.level=0")
    stage = Usd.Stage.Open(str(first.path))
    material = UsdShade.Material(stage.GetPrimAtPath("/Coat/materials/wool"))
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/Coat/render")).Bind(material)
    stage.GetRootLayer().Export(str(tmp_path / "earlier.usda"))
    second = build(tmp_path / "earlier.usda", "--set", "render.level=0", stem="again")
    before, after = (product.stage.GetPrimAtPath("/Coat/render") for product in (first, second))
    assert inheriting(after) == [] and np.array_equal(materials(after), materials(before))


@pytest.mark.parametrize("name", ["tshirt", "coat", "trousers"])
def test_no_set_of_an_example_is_drawn_with_a_material_that_is_not_its_own(build, name):
    product = build(EXAMPLES / f"{name}.usda", "--set", "render.level=0")
    for role in ("sim", "render"):
        assert inheriting(product.prim(role)) == []
        assert set(materials(product.prim(role))) == set(materials(find_model(product.source_stage)))


def test_panels_with_a_face_set_without_a_binding_keep_their_material(build, tmp_path):
    path = tmp_path / "suit.usda"
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Suit").GetPrim())
    for side, x in (("front", 0), ("back", 2)):
        mesh = UsdGeom.Mesh.Define(stage, f"/Suit/{side}")
        points = [(i + x, j, 0) for j in range(3) for i in range(3)]
        quads = [(a, a + 1, a + 4, a + 3) for a in (0, 1, 3, 4)]
        mesh.CreatePointsAttr(points)
        mesh.CreateFaceVertexCountsAttr([4] * 4)
        mesh.CreateFaceVertexIndicesAttr([v for quad in quads for v in quad])
        bind(mesh.GetPrim(), side)
    add_subset(UsdGeom.Mesh(stage.GetPrimAtPath("/Suit/front")), name="placket", indices=[1], family="materialBind")
    stage.GetRootLayer().Save()
    product = build(path, "--all", "--set", "render.level=0")
    (render,) = [p for p in product.stage.Traverse() if p.GetName() == "render"]
    assert sorted(materials(render)) == ["back"] * 4 + ["front"] * 4


def collection(stage, prim, material, *, includes, excludes=(), rule="expandPrims", purpose="", strength="fallbackStrength"):
    """Binds a material to a collection of the prim."""
    prim = stage.GetPrimAtPath(prim)
    made = Usd.CollectionAPI.Apply(prim, f"c{len(Usd.CollectionAPI.GetAll(prim))}")
    made.CreateExpansionRuleAttr(rule)
    made.CreateIncludesRel().SetTargets(list(includes))
    made.CreateExcludesRel().SetTargets(list(excludes))
    material = UsdShade.Material.Define(stage, f"/Coat/materials/{material}")
    api = UsdShade.MaterialBindingAPI.Apply(prim)
    api.Bind(made, material, made.GetName(), strength, purpose or UsdShade.Tokens.allPurpose)


def above(stage):
    collection(stage, "/Coat", "tweed", includes=["/Coat/model"])


def stronger_above(stage):
    collection(stage, "/Coat", "tweed", includes=["/Coat"], strength="strongerThanDescendants")


def without_the_model(stage):
    collection(stage, "/Coat", "tweed", includes=["/Coat"], excludes=["/Coat/model"])


def alone(stage):
    collection(stage, "/Coat", "tweed", includes=["/Coat"], rule="explicitOnly")


def on_the_mesh(stage):
    collection(stage, "/Coat/model", "tweed", includes=["/Coat/model"], rule="explicitOnly")
    collection(stage, "/Coat/model", "linen", includes=["/Coat/model/cuff"], purpose="preview")


def of_a_subset(stage):
    collection(stage, "/Coat", "tweed", includes=["/Coat/model/body"])


@pytest.mark.parametrize("purpose", ["", "preview", "full"])
@pytest.mark.parametrize("bind_mesh", [True, False])
@pytest.mark.parametrize("change", [above, stronger_above, without_the_model, alone, on_the_mesh, of_a_subset])
def test_materials_of_collections_are_those_of_the_garment(build, tmp_path, change, bind_mesh, purpose):
    body = {"name": "body", "indices": [0, 1, 4, 5], "family": "materialBind"}
    path = garment(
        tmp_path / "a.usda", [BOUND, body, *BARE], lambda mesh: change(mesh.GetPrim().GetStage()), "wool" if bind_mesh else None
    )
    product = build(path, "--set", "render.level=0")
    source = materials(product.stage.GetPrimAtPath("/Coat/model"), purpose)
    # A face without a material cannot stay so on a product whose parent has one.
    bound = source != None  # noqa: E711
    assert bound.any() and np.array_equal(materials(product.prim("render"), purpose)[bound], source[bound])
