"""The codeless schemas as OpenUSD sees them: registered, typed, documented, applicable."""

import os
import subprocess
import sys

import pytest
from pxr import Sdf, Usd, UsdGeom, Vt

# attribute: (type, fallback); the one place in these tests that repeats schema.usda.
SIM = {
    "tailor:sim:minEdgeLength": ("float", 0.0),
    "tailor:sim:maxEdgeLength": ("float", 0.0),
    "tailor:sim:density": ("token", ""),
    "tailor:sim:grading": ("float", 0.0),
    "tailor:sim:baselineLevel": ("int", 2),
    "tailor:sim:smoothWeights": ("token", ""),
    "tailor:sim:iterations": ("int", 5),
    "tailor:sim:relax": ("token", "surface"),
    "tailor:sim:uvSet": ("token", "st"),
    "tailor:sim:constrainUvSeams": ("bool", True),
    "tailor:sim:smallestShell": ("float", 4.0),
    "tailor:sim:cornerAngle": ("float", 50.0),
    "tailor:sim:featureAngle": ("float", 90.0),
    "tailor:sim:transferSamples": ("int", 32),
    "tailor:sim:seed": ("int", 0),
    "tailor:sim:cleanIslands": ("bool", False),
    "tailor:sim:provenance": ("bool", False),
    "tailor:sim:symmetry": ("bool", False),
    "tailor:sim:asMade": ("bool", False),
}
RENDER = {
    "tailor:render:level": ("int", 2),
    "tailor:render:seamLevel": ("int", 0),
    "tailor:render:operators": ("token[]", Vt.TokenArray()),
    "tailor:render:faceSets": ("bool", False),
}
SEAM = {
    "tailor:seam:x:crease": ("bool", False),
    "tailor:seam:x:width": ("float", 0.0),
    "tailor:seam:x:depth": ("float", 0.0),
    "tailor:seam:x:normalOffset": ("float", 0.0),
    "tailor:seam:x:asymmetry": ("float", 0.0),
    "tailor:seam:x:offset": ("float", 0.0),
    "tailor:seam:x:side": ("token", "both"),
    "tailor:seam:x:rows": ("int", 1),
    "tailor:seam:x:rowGap": ("float", 0.0),
    "tailor:seam:x:end": ("token", "taper"),
    "tailor:seam:x:through": ("bool", False),
    "tailor:seam:x:enabled": ("bool", True),
}
LOD = {"tailor:lod:levels": ("int", 1), "tailor:lod:ratio": ("float", 2.0)}
FIT = {
    "tailor:fit:from": ("asset", Sdf.AssetPath("")),
    "tailor:fit:to": ("asset", Sdf.AssetPath("")),
    "tailor:fit:ease": ("float", 0.0),
    "tailor:fit:rest": ("token", "graded"),
}
FOLD = {
    "tailor:fold:x:thickness": ("float", 0.0),
    "tailor:fold:x:enabled": ("bool", True),
    "tailor:fold:x:weights": ("token", ""),
    "tailor:fold:x:side": ("token", "inner"),
    "tailor:fold:x:turn": ("float", 1.0),
    "tailor:fold:x:closed": ("bool", False),
}
# Those that are applied more than once are here by the name of an instance, x.
MULTIPLE = {"TailorSeamAPI": "TailorSeamAPI:x", "TailorFoldAPI": "TailorFoldAPI:x"}
SCHEMAS = {"TailorSimAPI": SIM, "TailorRenderAPI": RENDER, "TailorLodAPI": LOD, "TailorFitAPI": FIT, "TailorSeamAPI": SEAM, "TailorFoldAPI": FOLD}
RELATIONSHIPS = {
    "TailorSimAPI": {"tailor:sim:smooth", "tailor:sim:constraints"},
    "TailorRenderAPI": set(),
    "TailorLodAPI": set(),
    "TailorFitAPI": {"tailor:fit:rigid", "tailor:fit:keepLength"},
    "TailorSeamAPI": {"tailor:seam:x:edges"},
    "TailorFoldAPI": {"tailor:fold:x:faces"},
}

ATTRIBUTES = [
    pytest.param(schema, name, *what, id=name) for schema, attributes in SCHEMAS.items() for name, what in attributes.items()
]


def definition(schema):
    """The properties as they are on a prim that has the schema."""
    if schema not in MULTIPLE:
        return Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema)
    return Usd.SchemaRegistry().BuildComposedPrimDefinition("", [MULTIPLE[schema]])


def apply(prim, schema):
    return prim.ApplyAPI(schema, "x") if schema in MULTIPLE else prim.ApplyAPI(schema)


def can_apply(prim, schema):
    return prim.CanApplyAPI(schema, "x") if schema in MULTIPLE else prim.CanApplyAPI(schema)


@pytest.fixture
def mesh():
    stage = Usd.Stage.CreateInMemory()
    yield UsdGeom.Mesh.Define(stage, "/Coat/model").GetPrim()


@pytest.mark.parametrize("schema", SCHEMAS)
def test_schema_is_an_api_of_meshes(schema):
    registry = Usd.SchemaRegistry()
    assert definition(schema), "not registered: is PXR_PLUGINPATH_NAME set before pxr is imported?"
    assert registry.IsAppliedAPISchema(schema)
    assert registry.IsMultipleApplyAPISchema(schema) == (schema in MULTIPLE)
    assert list(registry.GetAPISchemaCanOnlyApplyToTypeNames(schema)) == ["Mesh"]


@pytest.mark.parametrize("schema", SCHEMAS)
def test_schema_holds_these_properties_and_no_other(schema):
    assert set(definition(schema).GetPropertyNames()) == set(SCHEMAS[schema]) | RELATIONSHIPS[schema]


@pytest.mark.parametrize("schema, name, type_name, fallback", ATTRIBUTES)
def test_attribute_has_its_type_fallback_and_variability(schema, name, type_name, fallback):
    attribute = definition(schema).GetAttributeDefinition(name)
    assert attribute.GetTypeName() == Sdf.ValueTypeNames.Find(type_name)
    assert attribute.GetFallbackValue() == fallback
    assert attribute.GetVariability() == Sdf.VariabilityUniform


@pytest.mark.parametrize("schema", SCHEMAS)
def test_every_property_is_documented_with_its_unit(schema):
    held = definition(schema)
    for name in held.GetPropertyNames():
        text = held.GetPropertyDocumentation(name)
        assert text.endswith("]."), f"{name}: the doc must be one sentence that ends in a unit in brackets: {text!r}"


@pytest.mark.parametrize("schema", SCHEMAS)
def test_schema_applies_to_a_mesh_and_gives_its_fallbacks(schema, mesh):
    assert can_apply(mesh, schema)
    assert apply(mesh, schema)
    assert mesh.HasAPI(schema)
    assert MULTIPLE.get(schema, schema) in mesh.GetAppliedSchemas()
    for name, (_, fallback) in SCHEMAS[schema].items():
        attribute = mesh.GetAttribute(name)
        assert attribute.Get() == fallback
        assert not attribute.HasAuthoredValue()
    for name in RELATIONSHIPS[schema]:
        assert mesh.GetRelationship(name).GetTargets() == []


@pytest.mark.parametrize("schema", SCHEMAS)
def test_schema_is_refused_by_other_types(schema):
    stage = Usd.Stage.CreateInMemory()
    xform = UsdGeom.Xform.Define(stage, "/Coat").GetPrim()
    assert not can_apply(xform, schema)


def test_values_survive_a_layer(mesh):
    mesh.ApplyAPI("TailorSimAPI")
    mesh.GetAttribute("tailor:sim:maxEdgeLength").Set(2.5)
    mesh.GetRelationship("tailor:sim:constraints").AddTarget("/Coat/model/hem")
    text = mesh.GetStage().GetRootLayer().ExportToString()
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(text), text
    stage = Usd.Stage.Open(layer)
    prim = stage.GetPrimAtPath("/Coat/model")
    assert prim.HasAPI("TailorSimAPI"), text
    assert prim.GetAttribute("tailor:sim:maxEdgeLength").Get() == 2.5, text
    assert prim.GetRelationship("tailor:sim:constraints").GetTargets() == ["/Coat/model/hem"], text


def test_without_the_plugin_the_recipe_is_still_readable():
    """Unregistered, the schema leaves GetAppliedSchemas and the fallbacks are gone; what was authored stays."""
    program = """
from pxr import Sdf, Usd, UsdGeom
stage = Usd.Stage.CreateInMemory()
prim = UsdGeom.Mesh.Define(stage, "/Coat/model").GetPrim()
prim.AddAppliedSchema("TailorSimAPI")
prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float, False, Sdf.VariabilityUniform).Set(2.5)
assert Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("TailorSimAPI") is None
assert prim.GetAppliedSchemas() == []
assert prim.GetPrimTypeInfo().GetAppliedAPISchemas() == ["TailorSimAPI"]
assert prim.GetAttribute("tailor:sim:maxEdgeLength").Get() == 2.5
assert not prim.GetAttribute("tailor:sim:iterations")
"""
    environment = {name: value for name, value in os.environ.items() if name != "PXR_PLUGINPATH_NAME"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
