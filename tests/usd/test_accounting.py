"""Nothing is dropped in silence: each primvar and subset of the source is on both meshes, or a warning names it."""

import re

import pytest
from pxr import Usd

# The simulation mesh has other vertices, so what was per vertex or varying may be either.
SIM_INTERPOLATIONS = {
    "constant": {"constant"},
    "uniform": {"uniform"},
    "vertex": {"vertex"},
    "varying": {"varying", "vertex"},
    "faceVarying": {"faceVarying"},
}


def unaccounted(product, mesh, primvar_is_kept):
    """Names of what is neither on `mesh` nor in a warning."""
    said = "\n".join(product.warnings)
    lost = [name for name, primvar in product.source.primvars.items() if not primvar_is_kept(primvar, mesh.primvars.get(name))]
    lost += [name for name, subset in product.source.subsets.items() if not subset_is_kept(subset, mesh.subsets.get(name))]
    return [name for name in lost if name not in said]


def subset_is_kept(before, after):
    return after is not None and (after.element_type, after.family) == (before.element_type, before.family)


def same_kind(before, after):
    return after is not None and (after.type_name, after.element_size) == (before.type_name, before.element_size)


def test_render_mesh_carries_every_primvar_and_subset(product):
    def kept(before, after):
        return same_kind(before, after) and after.interpolation == before.interpolation

    assert unaccounted(product, product.render, kept) == [], product.warnings


def test_sim_mesh_carries_every_primvar_and_subset(product):
    def kept(before, after):
        return same_kind(before, after) and after.interpolation in SIM_INTERPOLATIONS[before.interpolation]

    assert unaccounted(product, product.sim, kept) == [], product.warnings


# What the simulation mesh says of its own borders and UV seams, and of the creases and corners of its source; those of
# several sharpnesses are numbered.
OWN_SETS = {"tailorBorders", "tailorSeams", "tailorCreases", "tailorCorners"}


@pytest.mark.parametrize("name", ["sim", "render"])
def test_skinned_meshes_stay_bound_to_their_skeleton(product, name):
    """SkelBindingAPI, without which the influences mean nothing, and the properties that say which skeleton."""
    before, after = product.source.prim, product.prim(name)
    if "SkelBindingAPI" not in before.GetAppliedSchemas():
        pytest.skip("not skinned")
    assert "SkelBindingAPI" in after.GetAppliedSchemas()
    for prop in before.GetAuthoredPropertiesInNamespace("skel"):
        if prop.GetName() == "skel:blendShapeTargets":
            continue  # each product has shapes of its own: see test_transfer.py
        written = after.GetProperty(prop.GetName())
        assert written, f"{prop.GetName()} is gone"
        if isinstance(prop, Usd.Relationship):
            assert written.GetTargets() == prop.GetTargets(), prop.GetName()
        else:
            assert written.Get() == prop.Get(), prop.GetName()


@pytest.mark.parametrize("name", ["sim", "render"])
def test_nothing_is_invented(product, name):
    mesh = product.mesh(name)
    own = {"tailor:bindFace", "tailor:bindCoords"} if name == "render" else set()
    assert mesh.primvars.keys() - own <= product.source.primvars.keys()
    new = {re.sub(r"_\d+$", "", subset) for subset in mesh.subsets.keys() - product.source.subsets.keys()}
    allowed = {"tailorMaterial"} | ({"sewn"} if product.has_doubled_points else set())
    assert new - allowed <= (OWN_SETS if name == "sim" else set())


@pytest.mark.parametrize("name", ["sim", "render"])
def test_primvar_lengths_match_their_interpolation(product, name):
    mesh = product.mesh(name)
    elements = {"constant": 1, "uniform": len(mesh.counts), "vertex": len(mesh.points), "varying": len(mesh.points), "faceVarying": len(mesh.indices)}
    for primvar in mesh.primvars.values():
        if primvar.interpolation != "constant":
            assert len(primvar.flat) == elements[primvar.interpolation], primvar.name


def test_warnings_are_objects_with_a_code_and_a_message(product):
    assert isinstance(product.report["warnings"], list)
    for warning in product.report["warnings"]:
        assert warning["code"] and warning["message"]
