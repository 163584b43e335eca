"""Cloth as physics: schemas, units, pins, attachments, fabrics and the shape at rest, read back by OpenUSD."""

import importlib.resources

import numpy as np
import pytest
import sources
from conftest import EXAMPLES, run
from pxr import Gf, Sdf, Usd, UsdGeom

TSHIRT, COAT, TROUSERS = (EXAMPLES / f"{name}.usda" for name in ("tshirt", "coat", "trousers"))
COTTON = {"thickness": 0.4e-3, "density": 0.14, "stretch": 10.5e3, "bend": 6.5e-6, "friction": 0.4}


def value(prim, name):
    attribute = prim.GetAttribute(name)
    assert attribute, f"{prim.GetPath()} has no {name}"
    return attribute.Get()


def schemas(prim):
    return prim.GetPrimTypeInfo().GetAppliedAPISchemas()


def physics(product, name=""):
    path = product.model_path.ReplaceName("physics")
    return product.stage.GetPrimAtPath(path.AppendChild(name) if name else path)


def world(prim, points):
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
    return np.asarray(points, float) @ matrix[:3, :3] + matrix[3, :3]


def test_every_garment_is_a_deformable_body(product):
    sim, root = product.prim("sim"), product.prim("sim").GetParent()
    assert "PhysicsDeformableBodyAPI" in schemas(root)
    assert {"PhysicsSurfaceDeformableSimAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"} <= set(schemas(sim))
    triangles = np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)
    rest, points = np.array(value(sim, "physics:restTriVertexIndices")), np.array(value(sim, "physics:restShapePoints"))
    assert rest.shape == triangles.shape and rest.min() >= 0 and rest.max() < len(points)
    # Each triangle rests about as long as it is.
    def edges(p, t):
        return np.linalg.norm(p[t] - p[np.roll(t, 1, axis=1)], axis=2)

    ratio = edges(points, rest) / edges(np.array(value(sim, "points")), triangles)
    assert 0.95 < np.median(ratio) < 1.05
    assert value(sim, "physics:thicknesses")[0] > 0 and value(sim, "physics:thicknesses:elementType") == "constant"
    assert len(value(sim, "physics:deformablePose:default:points")) == len(value(sim, "points"))
    render = product.prim("render")
    assert not {"PhysicsCollisionAPI", "PhysicsSurfaceDeformableSimAPI"} & set(schemas(render))
    material = sim.GetRelationship("material:binding:physics").GetTargets()
    assert product.stage.GetPrimAtPath(material[0]).GetTypeName() == "Material"
    cloth = product.report["cloth"]
    assert cloth["mass"] == pytest.approx(cloth["area"] * COTTON["density"], rel=1e-6)


@pytest.mark.parametrize("meters, scale", [(1.0, 1.0), (0.01, 1.0), (0.01, 100.0), (1.0, 0.01)])
def test_numbers_are_in_the_units_of_the_stage(build, tmp_path, meters, scale):
    def finish(mesh):
        UsdGeom.SetStageMetersPerUnit(mesh.GetPrim().GetStage(), meters)
        UsdGeom.Xformable(mesh).AddScaleOp().Set(Gf.Vec3f(scale))

    product = build(sources.write(tmp_path / "sheet.usda", finish=finish), "--set", "cloth.scene=true")
    sim, material = product.prim("sim"), physics(product, "cotton")
    thickness = COTTON["thickness"] / meters
    assert value(sim, "physics:thicknesses")[0] == pytest.approx(thickness)
    density = COTTON["density"] / COTTON["thickness"] * meters**3
    assert value(material, "physics:density") == pytest.approx(density)
    assert value(material, "physics:surfaceStretchStiffness") == pytest.approx(COTTON["stretch"])
    assert value(material, "physics:surfaceBendStiffness") == pytest.approx(COTTON["bend"] / meters**2)
    assert value(physics(product, "scene"), "physics:gravityMagnitude") == pytest.approx(9.81 / meters)
    # Mass by the solver's own formula, in world space.
    p = world(sim, value(sim, "points"))[np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)]
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    assert area * thickness * density == pytest.approx(product.report["cloth"]["mass"], rel=1e-4)


def pinned(product, attachment="pins"):
    prim = physics(product, attachment)
    sim = product.prim("sim")
    indices = list(value(prim, "physics:indices0"))
    target = product.stage.GetPrimAtPath(prim.GetRelationship("physics:src1").GetTargets()[0])
    held = world(sim, np.array(value(sim, "points"))[indices])
    return prim, target, held, world(target, value(prim, "physics:coords1"))


def test_pins_to_the_world_are_held_by_a_body_with_a_joint(build):
    product = build(COAT, "--set", "cloth.pins=gorge,buttons")
    _, anchor, held, at = pinned(product)
    assert len(held) > 5 and np.abs(held - at).max() < 1e-3
    assert "PhysicsRigidBodyAPI" in schemas(anchor) and value(anchor, "physics:kinematicEnabled")
    joint = physics(product, "anchor_joint")
    assert joint.GetTypeName() == "PhysicsFixedJoint"
    assert joint.GetRelationship("physics:body1").GetTargets() == [anchor.GetPath()]


def test_pins_to_a_prim_are_in_its_frame(build, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "dressed.usda"))
    stage.GetRootLayer().subLayerPaths.append(str(COAT))
    UsdGeom.Xform.Define(stage, "/Body").AddTranslateOp().Set(Gf.Vec3d(3, 90, -2))
    body = UsdGeom.Xform.Define(stage, "/Body/hips")
    body.AddRotateXYZOp().Set(Gf.Vec3f(20, 70, -35))
    body.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    stage.GetRootLayer().Save()
    product = build(tmp_path / "dressed.usda", "--set", "cloth.pins=gorge", "--set", "cloth.pinTarget=/Body/hips")
    _, target, held, at = pinned(product)
    assert str(target.GetPath()) == "/Body/hips" and np.abs(held - at).max() < 1e-3


@pytest.mark.parametrize(
    "option, words",
    [
        ("cloth.pins=front_left", "edge or point subset"),
        ("cloth.pinTarget=/Nobody", "/Nobody"),
        ("cloth.pinTarget=/", "absolute prim path"),
        ("cloth.fabric=tweed", "cotton"),
        ("cloth.physics=havok", "aousd"),
        ("fabric.a.preset=tweed", "denim"),
        ("fabric.a.density=-1", "out of range"),
        ("cloth.rest=panels", "UV"),
    ],
)
def test_wrong_options_are_told_and_nothing_is_written(usdtailor, tmp_path, option, words):
    source = TSHIRT
    if option == "cloth.rest=panels":
        source = sources.write(tmp_path / "sheet.usda")
    out = tmp_path / "out.usda"
    more = ["--set", "cloth.pins=neck_seam"] if "pinTarget" in option else []
    done = run(usdtailor, "build", source, "-o", out, "--set", option, *more)
    assert done.returncode != 0 and words in done.stderr and "hint" in done.stderr
    assert not out.exists()


def test_a_fabric_takes_the_place_of_no_other_prim(build):
    for name in ("pins", "scene", "anchor"):
        args = ["--set", f"cloth.fabric={name}", "--set", f"fabric.{name}.preset=wool", "--set", "cloth.pins=neck_seam"]
        product = build(TSHIRT, "--set", "cloth.scene=true", *args, stem=name)
        types = {child.GetName(): child.GetTypeName() for child in physics(product).GetChildren()}
        assert types["fabric"] == "Material" and types["pins"] == "PhysicsAttachment"
        assert (types["scene"], types["anchor"]) == ("PhysicsScene", "Xform")
        material = product.prim("sim").GetRelationship("material:binding:physics").GetTargets()
        assert material == [physics(product, "fabric").GetPath()]


def test_panels_of_chaos_replace_no_subset(usdtailor, tmp_path):
    def finish(mesh):
        UsdGeom.Subset.CreateGeomSubset(mesh, "pattern_0", "face", [0, 1], "clo")

    source, out = sources.write(tmp_path / "sheet.usda", finish=finish), tmp_path / "out.usda"
    done = run(usdtailor, "build", source, "-o", out, "--physics", "aousd,chaos")
    assert done.returncode != 0 and "pattern_0" in done.stderr and "hint" in done.stderr and not out.exists()
    assert run(usdtailor, "build", source, "-o", out).returncode == 0


def test_fabrics_of_face_sets_have_their_own_mass_and_thickness(build):
    args = ["--set", "fabric.rib.faces=neckband", "--set", "fabric.rib.preset=wool", "--set", "fabric.rib.density=0.5"]
    product = build(TSHIRT, "--set", "cloth.fabric=jersey", *args)
    sim = product.prim("sim")
    rib = np.array(value(sim.GetChild("neckband"), "indices"))
    thickness, mass = np.array(value(sim, "physics:thicknesses")), np.array(value(sim, "physics:masses"))
    assert value(sim, "physics:thicknesses:elementType") == value(sim, "physics:masses:elementType") == "face"
    p = np.array(value(sim, "points"))[np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)] * 0.01
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    is_rib = np.isin(np.arange(len(area)), rib)
    assert np.allclose(mass / area, np.where(is_rib, 0.5, 0.17), rtol=1e-3)
    assert np.allclose(thickness, 0.06, rtol=1e-5), "wool and jersey are equally thick"
    assert any(warning.startswith("mean-fabric") for warning in product.warnings)


def test_loose_pieces_are_attached_to_what_they_lie_on(built):
    for garment, pieces in ((TSHIRT, 1), (COAT, 6), (TROUSERS, 8)):
        product = built(garment)
        sim = product.prim("sim")
        assert product.report["cloth"]["attached"] == pieces
        points, triangles = np.array(value(sim, "points"), float), np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)
        held, faces, coords = (np.array(value(sim, f"tailor:attach:{name}")) for name in ("points", "faces", "coords"))
        corners = points[triangles[faces]]
        weights = np.c_[coords[:, :2], 1 - coords[:, :2].sum(axis=1)]
        place = (weights[:, :, None] * corners).sum(axis=1)
        apart = np.linalg.norm(points[held] - place, axis=1)
        # The README of the examples: loose pieces lie 0.6 to 1.8 cm above the garment.
        assert apart.max() < 3 and np.abs(coords[:, 2]).max() <= apart.max() + 1e-4
        attachment = physics(product, "piece_0")
        assert attachment.GetTypeName() == "PhysicsAttachment" and value(attachment, "physics:type1") == "face"
        assert not set(held) & set(triangles[faces].ravel()), "a piece is not attached to itself"
    off = built(TSHIRT, "--set", "cloth.attach=false")
    assert off.report["cloth"]["attached"] == 0 and not physics(off, "piece_0")


@pytest.mark.parametrize("garment", [TSHIRT, COAT, TROUSERS], ids=lambda path: path.stem)
def test_panels_rest_flat_with_equal_seams(built, garment):
    product = built(garment)
    sim, rest = product.prim("sim"), product.report["cloth"]["rest"]
    assert rest["modelled"] == 0 and rest["stretchRms"] <= 0.01 and rest["stretchMax"] <= 1.2
    assert rest["flipped"] == 0 and rest["seamDifference"] <= 1e-3
    points, t = np.array(value(sim, "physics:restShapePoints"), float), np.array(value(sim, "physics:restTriVertexIndices"))
    assert (points[:, 2] == 0).all()
    p = points[t]
    assert (np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] > 0).all(), "panels lie face up"
    # Both sides of each seam have one length.
    triangles = np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    lengths = np.linalg.norm(p - np.roll(p, -1, axis=1), axis=2).ravel()
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    edge = edge.ravel()
    low, high = np.full(edge.max() + 1, np.inf), np.zeros(edge.max() + 1)
    np.minimum.at(low, edge, lengths)
    np.maximum.at(high, edge, lengths)
    assert (high / low).max() < 1.001


def test_a_seam_of_a_panel_and_a_shell_as_modelled_rests_flat(build, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "stretched.usda"))
    stage.GetRootLayer().subLayerPaths.append(str(TSHIRT))
    mesh = stage.GetPrimAtPath("/Tshirt/model")
    uvs = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    st, indices = np.array(uvs.Get()), np.array(uvs.GetIndices())
    corners = np.repeat(np.arange(len(value(mesh, "faceVertexCounts"))), value(mesh, "faceVertexCounts"))
    band = np.unique(indices[np.isin(corners, value(mesh.GetChild("neckband"), "indices"))])
    st[band, 0] *= 1.6
    uvs.Set(st.astype(np.float32))
    stage.GetRootLayer().Save()
    product = build(tmp_path / "stretched.usda")
    rest, sim = product.report["cloth"]["rest"], product.prim("sim")
    assert (rest["panels"], rest["modelled"]) == (5, 1)
    triangles = np.array(value(sim, "faceVertexIndices")).reshape(-1, 3)
    points, t = np.array(value(sim, "physics:restShapePoints")), np.array(value(sim, "physics:restTriVertexIndices"))
    is_flat = (points[t][:, :, 2] == 0).all(axis=1)
    edges = {}
    for face, triangle in enumerate(triangles):
        for k in range(3):
            edges.setdefault(frozenset((triangle[k], triangle[(k + 1) % 3])), []).append(face)
    mixed = {tuple(sorted(faces)) for faces in edges.values() if len(faces) == 2 and is_flat[faces].sum() == 1}
    assert mixed and {tuple(sorted(pair)) for pair in value(sim, "physics:restAdjTriPairs")} == mixed
    assert not np.any(value(sim, "physics:restBendAngles"))


def test_panels_that_cannot_be_written_are_told(build):
    product = build(TSHIRT, "--set", "cloth.rest=mesh", "--set", "cloth.panels=true")
    assert not product.prim("panels")
    assert [w["place"] for w in product.report["warnings"] if w["code"] == "no-panels"] == ["cloth.panels"]


def test_rest_on_the_mesh_is_the_mesh(built):
    sim = built(TSHIRT, "--set", "cloth.rest=mesh").prim("sim")
    assert value(sim, "physics:restShapePoints") == value(sim, "points")


def test_a_garment_without_physics_has_none_and_an_earlier_one_is_removed(build):
    none = build(TSHIRT, "--physics", "none", stem="none")
    assert not physics(none)
    assert not any("physics" in str(name).lower() for name in none.prim("sim").GetPropertyNames())
    with_physics = build(TSHIRT)
    again = build(with_physics.path, "--physics", "none", "--prim", "/Tshirt/model", stem="over").stage
    assert not again.GetPrimAtPath("/Tshirt/physics").IsActive()
    assert "PhysicsDeformableBodyAPI" not in schemas(again.GetPrimAtPath("/Tshirt"))
    assert "PhysicsSurfaceDeformableSimAPI" not in schemas(again.GetPrimAtPath("/Tshirt/sim"))


def omni_properties():
    """The properties of each schema and type of physx-usd-schemas, with their types."""
    path = importlib.resources.files("physx_usd_schemas") / "OmniUsdPhysicsDeformableSchema/resources/generatedSchema.usda"
    layer = Sdf.Layer.FindOrOpen(str(path))
    types = {}
    for prim in layer.rootPrims:
        for name, attribute in prim.attributes.items():
            types[name.replace("__INSTANCE_NAME__", "default")] = attribute.typeName
        for name in prim.relationships.keys():
            types[name] = None
    return {prim.name for prim in layer.rootPrims}, types


def test_names_of_omniverse_are_those_of_its_schemas(build):
    pytest.importorskip("physx_usd_schemas", reason="physx-usd-schemas is absent: names of Omniverse are NOT tested")
    known, types = omni_properties()
    args = ["--physics", "aousd,omni", "--set", "cloth.pins=gorge", "--set", "cloth.pins=buttons"]
    product = build(COAT, *args)
    seen = set()
    for prim in product.stage.TraverseAll():
        for schema in schemas(prim):
            if schema.startswith("OmniPhysics"):
                assert schema.split(":")[0] in known, schema
                seen.add(schema)
        if prim.GetTypeName().startswith("OmniPhysics"):
            assert prim.GetTypeName() in known
            seen.add(prim.GetTypeName())
        for prop in prim.GetAuthoredProperties():
            name = prop.GetName()
            if "omniphysics:" in name:
                assert name in types, f"{prim.GetPath()}.{name}"
                if types[name] is not None:
                    assert prop.GetTypeName() == types[name], name
    assert {"OmniPhysicsVtxXformAttachment", "OmniPhysicsVtxTriAttachment", "OmniPhysicsSurfaceDeformableSimAPI"} <= seen
    sim = product.prim("sim")
    rest = np.array(value(sim, "omniphysics:restTriVtxIndices")).ravel()
    assert (rest == np.array(value(sim, "faceVertexIndices"))).all(), "its rest shape has the topology of the mesh"


def test_panels_of_chaos_partition_both_meshes(build):
    product = build(TSHIRT, "--physics", "chaos")
    for name, schema in (("sim", "SimPatternAPI"), ("render", "RenderPatternAPI")):
        mesh = product.prim(name)
        panels = [p for p in mesh.GetChildren() if p.GetAttribute("familyName").Get() == "pattern"]
        assert len(panels) == 6 and all(schema in schemas(panel) for panel in panels)
        faces = np.concatenate([value(panel, "indices") for panel in panels])
        assert sorted(faces) == list(range(len(value(mesh, "faceVertexCounts"))))
    panel = product.prim("sim").GetChild("pattern_0")
    assert value(panel, "primvars:clo:density") == pytest.approx(0.14e-3)
    assert value(product.prim("sim"), "restPositionScale")[0] == pytest.approx(value(product.prim("model"), "primvars:stScale"))
    assert "ClothRootAPI" in schemas(product.prim("sim").GetParent())
