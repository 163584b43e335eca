"""Families of subsets whose rule does not hold: a warning, and a weaker rule on the products."""

import pytest
from pxr import UsdGeom, UsdShade
from sources import sheet, write


def garment(path, rule, left, right, *, family="panels", materials=False):
    sets = {"left": left, "right": right}
    subsets = [{"name": name, "indices": indices, "family": family, "material": name if materials else None} for name, indices in sets.items()]
    return write(path, shape=sheet, subsets=subsets, families={family: rule})


@pytest.mark.parametrize("rule, left, right, expected, elements", [
    ("partition", [0, 1, 4, 5, 8, 9], [2, 3, 6, 7, 10], "nonOverlapping", [11]),
    ("partition", [0, 1, 4, 5, 8, 9, 10], [2, 3, 6, 7, 10, 11], "unrestricted", [10]),
    ("nonOverlapping", [0, 1, 2], [2, 3], "unrestricted", [2]),
], ids=["gap", "overlap", "overlap of some"])  # fmt: skip
def test_the_strongest_rule_that_holds_is_on_the_products(build, tmp_path, rule, left, right, expected, elements):
    product = build(garment(tmp_path / "a.usda", rule, left, right), "--set", "render.level=0")
    (warning,) = [w for w in product.report["warnings"] if w["code"] == "family-rule"]
    assert warning["elements"]["faces"] == elements
    for name in ("sim", "render"):
        assert UsdGeom.Subset.GetFamilyType(UsdGeom.Mesh(product.prim(name)), "panels") == expected
    found = {s.GetPrim().GetName(): list(s.GetIndicesAttr().Get()) for s in UsdGeom.Subset.GetGeomSubsets(UsdGeom.Mesh(product.prim("render")))}
    assert {name: found[name] for name in ("left", "right")} == {"left": left, "right": right}


def test_materials_of_a_partition_with_gaps_are_as_bound(build, tmp_path):
    source = garment(tmp_path / "a.usda", "partition", [0, 1, 4, 5], [2, 3, 6, 7, 10], family="materialBind", materials=True)
    product = build(source, "--set", "render.level=0")
    bound = {}
    for subset in UsdGeom.Subset.GetGeomSubsets(UsdGeom.Mesh(product.prim("render")), "face", "materialBind"):
        material = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
        bound.update(dict.fromkeys(subset.GetIndicesAttr().Get(), material.GetPath().name if material else None))
    assert bound == {**dict.fromkeys([0, 1, 4, 5], "left"), **dict.fromkeys([2, 3, 6, 7, 10], "right")}
