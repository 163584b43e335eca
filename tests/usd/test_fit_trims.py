"""Trims that are prims of their own go with a garment to another body: numpy measures them against the cloth before and after."""

import json

import numpy as np
import pytest
from conftest import run
from fitting import fit, tube, write_tube
from pxr import Gf, Sdf, Usd, UsdGeom
from sources import BOX, define_mesh, vec3f, with_own_space
from surface import point_triangle
from tailor_file import holder, needs_plugin, recipe

RADIUS = 3.0
# Places on the garment: the angle about its axis, and the height.
BUTTONS = [(0.3, 3.5), (2.0, -3.6), (4.1, 0.2)]
STUDS = [(1.0, 3.0), (3.3, -3.2)]
QUICK = ("--set", "render.level=1", "--set", "sim.iterations=1")
TRIMS = ("--prim", "/Coat/model", "--set", "trim.all.prims=trims")
POINTS = {"buttons": "points", "tape": "points", "cords": "points", "studs": "positions"}


def on_garment(angle, height, above):
    r = RADIUS + np.asarray(above, float)
    return np.stack(np.broadcast_arrays(r * np.sin(angle), height, r * np.cos(angle)), -1)


def add_trims(stage):
    """Trims in a space of their own."""
    own = with_own_space(stage, "/Coat/trims")
    corners = np.array([[v & 1, v >> 1 & 1, v >> 2 & 1] for v in range(8)]) - [0.5, 0.5, 0]
    boxes = [on_garment(angle + c[:, 0] * 0.12, height + c[:, 1] * 0.3, 0.02 + c[:, 2] * 0.1) for angle, height in BUTTONS for c in [corners]]
    faces = [[8 * i + v for v in face] for i in range(len(BUTTONS)) for face in BOX]
    buttons = define_mesh(stage, "/Coat/trims/buttons", own(np.concatenate(boxes)), faces)
    buttons.CreateNormalsAttr(vec3f(np.ones((24, 3)) / np.sqrt(3)))
    turn = np.linspace(0, 2 * np.pi, 65)[:-1]
    tape = np.concatenate([on_garment(turn, height, 0.05) for height in (2.2, 2.7)])
    strip = [[i, (i + 1) % 64, 64 + (i + 1) % 64, 64 + i] for i in range(64)]
    define_mesh(stage, "/Coat/trims/tape", own(tape), strip)
    cords = UsdGeom.BasisCurves.Define(stage, "/Coat/trims/cords")
    cords.CreatePointsAttr(vec3f(own(np.concatenate([on_garment(turn, height, 0.1) for height in (-2, -2.5)]))))
    cords.CreateCurveVertexCountsAttr([64, 64])
    cords.CreateTypeAttr("linear")
    studs = UsdGeom.PointInstancer.Define(stage, "/Coat/trims/studs")
    UsdGeom.Sphere.Define(stage, "/Coat/trims/studs/ball").CreateRadiusAttr(0.05)
    studs.CreatePrototypesRel().SetTargets(["/Coat/trims/studs/ball"])
    studs.CreateProtoIndicesAttr([0] * len(STUDS))
    studs.CreatePositionsAttr(vec3f(own(np.stack([on_garment(*place, 0.05) for place in STUDS]))))
    studs.CreateOrientationsAttr([Gf.Quath(0.6, 0, 0.8, 0)] * len(STUDS))
    # Other programs write both.
    studs.CreateOrientationsfAttr([Gf.Quatf(0.6, 0, 0.8, 0)] * len(STUDS))


@pytest.fixture
def scene(tmp_path):
    """A tube as a garment with trims, and two bodies within it. The second is thicker in the middle, so that cloth tilts at the ends."""
    (points, *faces), uvs = tube(RADIUS, 10.0, 24, 10)
    write_tube(tmp_path / "coat.usda", (points, *faces), uvs * [2 * np.pi * RADIUS, 10.0], finish=lambda mesh: add_trims(mesh.GetPrim().GetStage()))
    for name, bulge in (("thin", 0.0), ("thick", 1.5)):
        (points, *faces), _ = tube(2.6, 14.0, 32, 14, bulge=bulge)
        write_tube(tmp_path / f"{name}.usda", (points, *faces), prim="/Body/skin")
    return tmp_path


def on_thick(scene):
    return ("--set", f"fit.from={scene}/thin.usda", "--set", f"fit.to={scene}/thick.usda")


def fitted(usdtailor, scene, *args, out="fitted.usda", code=0):
    bodies = ("--from", scene / "thin.usda", "--to", scene / "thick.usda")
    done = fit(usdtailor, scene / "coat.usda", *bodies, "-o", scene / out, "--force", *args, code=code)
    return code or Usd.Stage.Open(str(scene / out)), done


def build(usdtailor, source, out, *args):
    done = run(usdtailor, "build", source, "-o", out, "--force", *TRIMS, *QUICK, *args)
    assert done.returncode == 0, done.stdout + done.stderr
    return Usd.Stage.Open(str(out))


def own(stage, name):
    return np.array(stage.GetPrimAtPath(f"/Coat/trims/{name}").GetAttribute(POINTS[name]).Get(), float)


def world(stage, name):
    matrix = np.array(UsdGeom.Xformable(stage.GetPrimAtPath(f"/Coat/trims/{name}")).ComputeLocalToWorldTransform(0))
    return own(stage, name) @ matrix[:3, :3] + matrix[3, :3]


def frames(stage, points, path="/Coat/model"):
    """For each point: its distance from the cloth, and the unit normal of the cloth there."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(path))
    cloth, corners = np.array(mesh.GetPointsAttr().Get(), float), np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    triangles = cloth[np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])]
    count = len(triangles)
    apart = point_triangle(np.repeat(points, count, 0), np.tile(triangles, (len(points), 1, 1))).reshape(-1, count)
    a, b, c = triangles[apart.argmin(1)].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    return apart.min(1), normals / np.linalg.norm(normals, axis=1)[:, None]


def angles(points):
    return np.arctan2(points[:, 0], points[:, 2])


def test_trims_stay_on_the_cloth_where_they_are(usdtailor, scene):
    before, (after, done) = Usd.Stage.Open(str(scene / "coat.usda")), fitted(usdtailor, scene, *TRIMS)
    for name in POINTS:
        old, new = world(before, name), world(after, name)
        assert np.linalg.norm(new - old, axis=1).min() > 0.4, name
        # Faces of the tube are flat, and what rides on them follows a smooth surface.
        assert np.abs(frames(after, new)[0] - frames(before, old)[0]).max() < 0.08, name
        turned = np.angle(np.exp(1j * (angles(new) - angles(old))))
        assert np.abs(turned).max() < 0.03, name
    assert "trims/buttons: 3 rigid pieces (small)" in done.stdout and "trims/tape: 1 soft piece" in done.stdout


def test_buttons_keep_their_shape_and_lie_flat(usdtailor, scene):
    before, (after, _) = Usd.Stage.Open(str(scene / "coat.usda")), fitted(usdtailor, scene, *TRIMS)
    old, new = (world(stage, "buttons").reshape(-1, 8, 3) for stage in (before, after))
    for a, b in zip(old, new):
        apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (a, b)]
        assert np.abs(apart[0] - apart[1]).max() < 1e-5
    up = [p[:, 4:].mean(1) - p[:, :4].mean(1) for p in (old, new)]
    tilts = [(u / np.linalg.norm(u, axis=1)[:, None] * frames(stage, p.mean(1))[1]).sum(1) for u, stage, p in zip(up, (before, after), (old, new))]
    assert np.abs(tilts[0] - tilts[1]).max() < 0.01, "they stand on the cloth as before"
    moved = (up[0] * up[1]).sum(1) / (np.linalg.norm(up[0], axis=1) * np.linalg.norm(up[1], axis=1))
    assert moved.min() < 0.985, "the cloth has tilted, and they with it"
    # Normals turn with them.
    normals = [np.array(stage.GetPrimAtPath("/Coat/trims/buttons").GetAttribute("normals").Get(), float).reshape(-1, 8, 3) for stage in (before, after)]
    to_world = np.array(UsdGeom.Xformable(after.GetPrimAtPath("/Coat/trims/buttons")).ComputeLocalToWorldTransform(0))[:3, :3]
    for k in range(len(BUTTONS)):
        dots = [(n[k, 0] @ to_world / 2) @ (u[k] / np.linalg.norm(u[k])) for n, u in zip(normals, up)]
        assert dots[0] == pytest.approx(dots[1], abs=1e-3)


def test_instances_turn_with_the_cloth(usdtailor, scene):
    before, (after, _) = Usd.Stage.Open(str(scene / "coat.usda")), fitted(usdtailor, scene, *TRIMS)
    matrices = []
    for stage in (before, after):
        studs = UsdGeom.PointInstancer(stage.GetPrimAtPath("/Coat/trims/studs"))
        to_world = np.array(UsdGeom.Xformable(studs).ComputeLocalToWorldTransform(0))
        matrices.append([np.array(m) @ to_world for m in studs.ComputeInstanceTransformsAtTime(0, 0)])
    for old, new in zip(*matrices):
        turn = np.linalg.inv(old[:3, :3]) @ new[:3, :3]
        normals = [frames(stage, m[None, 3, :3])[1][0] for stage, m in ((before, old), (after, new))]
        assert normals[0] @ normals[1] < 0.99
        assert (normals[0] @ turn) @ normals[1] > 0.999


def test_a_build_of_a_body_takes_trims_along(usdtailor, scene):
    stage, _ = fitted(usdtailor, scene, *TRIMS)
    built = build(usdtailor, scene / "coat.usda", scene / "one.usda", *on_thick(scene))
    flat = build(usdtailor, scene / "coat.usda", scene / "flat.usda", *on_thick(scene), "--flatten")
    of_fitted = build(usdtailor, scene / "fitted.usda", scene / "two.usda")
    for name in POINTS:
        for other in (built, flat, of_fitted):
            assert (own(other, name) == own(stage, name)).all(), name
        prims = [each.GetPrimAtPath(f"/Coat/trims/{name}") for each in (built, of_fitted)]
        for key in ("primvars:tailor:bindFace", "primvars:tailor:bindCoords"):
            one, two = (np.array(prim.GetAttribute(key).Get()) for prim in prims)
            assert len(one) == len(own(stage, name)) and np.allclose(one, two, atol=1e-4), (name, key)
        height = np.array(prims[0].GetAttribute("primvars:tailor:bindCoords").Get())[:, 2]
        assert np.abs(height).max() < 0.4, f"{name} is bound to the cloth where it is now"


def test_trims_of_a_fitted_output_are_fitted_once(usdtailor, scene):
    one = build(usdtailor, scene / "coat.usda", scene / "one.usda", *on_thick(scene))
    two = build(usdtailor, scene / "one.usda", scene / "two.usda", *on_thick(scene))
    for name in POINTS:
        assert np.abs(world(two, name) - world(one, name)).max() < 1e-4, name


def test_each_body_of_a_variant_set_has_its_trims(usdtailor, scene):
    apart, _ = fitted(usdtailor, scene, *TRIMS)
    stage, done = fitted(usdtailor, scene, *TRIMS, "--variant-set", "body", out="set.usda")
    assert "trims/buttons: 3 rigid pieces" in done.stdout
    for body, other in (("thin", Usd.Stage.Open(str(scene / "coat.usda"))), ("thick", apart)):
        stage.GetPrimAtPath("/Coat").GetVariantSet("body").SetVariantSelection(body)
        for name in POINTS:
            assert (own(stage, name) == own(other, name)).all(), (name, body)


def test_each_trim_goes_with_the_nearest_garment(usdtailor, scene):
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    (points, counts, corners), _ = tube(2.8, 10.0, 24, 10)
    define_mesh(stage, "/Coat/lining", points, corners.reshape(-1, 4)).CreateSubdivisionSchemeAttr("catmullClark")
    stage.Save()
    report = scene / "report.json"
    args = ("--all", "--exclude", "trims", "--set", "trim.all.prims=/Coat/trims", "--report", report)
    after, _ = fitted(usdtailor, scene, *args)
    found = {garment["prim"]: [trim["prim"] for trim in garment["trims"]] for garment in json.loads(report.read_text())["garments"]}
    assert found == {"/Coat/lining": [], "/Coat/model": [f"/Coat/trims/{name}" for name in sorted(POINTS)]}
    assert np.abs(frames(after, world(after, "tape"))[0] - 0.05).max() < 0.08
    # Far from one of two garments is not far from cloth.
    stage.RemovePrim("/Coat/lining")
    define_mesh(stage, "/Coat/cuff", np.array([[0, 4.8, 3.1], [0.5, 4.8, 3.1], [0.5, 5, 3.1], [0, 5, 3.1]]), [[0, 1, 2, 3]])
    stage.Save()
    _, done = fitted(usdtailor, scene, *args, out="two.usda")
    assert "trim-off-cloth" not in done.stderr


def test_small_meshes_of_a_file_are_taken_along(usdtailor, scene):
    after, done = fitted(usdtailor, scene, "--all", "--exclude", "tape")
    assert "trims/buttons: 3 rigid pieces (small)" in done.stdout
    assert frames(after, world(after, "buttons"))[0].max() < 0.3


def test_trims_that_stay_are_named(usdtailor, scene):
    stage = Usd.Stage.Open(str(scene / "coat.usda"))
    UsdGeom.Cube.Define(stage, "/Coat/trims/block")
    define_mesh(stage, "/Coat/trims/far", np.eye(3) * [1, 1, 40], [[0, 1, 2]])
    points = stage.GetPrimAtPath("/Coat/trims/tape").GetAttribute("points")
    for time in (1, 2):
        points.Set(points.Get(), time)
    stage.Save()
    after, done = fitted(usdtailor, scene, *TRIMS)
    assert "/Coat/trims/block" in done.stderr and "Cube" in done.stderr
    assert "warning[trim-off-cloth]: /Coat/trims/far" in done.stderr
    assert "the motion of /Coat/trims/tape.points" in done.stderr
    assert frames(after, world(after, "tape"))[0].max() < 0.2, "the new points are those of all times"
    flat = build(usdtailor, scene / "coat.usda", scene / "flat.usda", *on_thick(scene), "--flatten")
    assert (np.array(flat.GetPrimAtPath("/Coat/trims/tape").GetAttribute("points").Get(1), float) == own(after, "tape")).all()
    stays, done = fitted(usdtailor, scene, *TRIMS, "--set", "trim.all.mode=none", out="stays.usda")
    assert "its mode is none" in done.stderr
    assert (own(stays, "buttons") == own(stage, "buttons")).all()
    _, done = fitted(usdtailor, scene, "--prim", "/Coat/model", "--set", "trim.all.prims=nothing", out="no.usda", code=1)
    assert "/Coat/nothing is not a prim" in done.stderr and not (scene / "no.usda").exists()


def edited(scene):
    return Usd.Stage.Open(str(scene / "coat.usda"))


def button(stage, path="/Coat/b", angle=0.3, height=3.0, above=0.05):
    at = on_garment(angle, height, above)
    return define_mesh(stage, path, at + 0.1 * np.array([[v & 1, v >> 1 & 1, v >> 2 & 1] for v in range(8)]), BOX)


ONE = ("--prim", "/Coat/model", "--set", "trim.b.prims=b")


def middle(stage, path="/Coat/b"):
    prim = stage.GetPrimAtPath(path)
    points = np.array(prim.GetAttribute("points").Get(), float).mean(0)
    return np.append(points, 1) @ np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)) if prim else None


def test_what_other_variants_have_is_told(usdtailor, scene):
    stage = edited(scene)
    mesh = button(stage)
    points = np.array(mesh.GetPointsAttr().Get())
    mesh.GetPointsAttr().Clear()
    styles = stage.GetPrimAtPath("/Coat").GetVariantSets().AddVariantSet("style")
    for name, shift in (("high", 0.3), ("low", -0.3)):
        styles.AddVariant(name)
        styles.SetVariantSelection(name)
        with styles.GetVariantEditContext():
            stage.OverridePrim("/Coat/b").GetAttribute("points").Set(vec3f(points + [0, shift, 0]))
    stage.Save()
    _, done = fitted(usdtailor, scene, *ONE)
    assert "warning[frozen-variant]: /Coat/b: the fit keeps" in done.stderr and "points" in done.stderr and "style=low" in done.stderr


def test_motion_of_trims_is_an_error_where_warnings_are(usdtailor, scene):
    stage = edited(scene)
    points = button(stage).GetPointsAttr()
    for time in (1, 2):
        points.Set(points.Get(), time)
    stage.Save()
    for args in ((), ("--variant-set", "body")):
        _, done = fitted(usdtailor, scene, *ONE, "--strict", *args, out="strict.usda", code=1)
        assert "the motion of /Coat/b.points" in done.stderr and not (scene / "strict.usda").exists()


def test_prototypes_move_with_their_instances(usdtailor, scene):
    stage = edited(scene)
    stage.GetPrimAtPath("/Coat/trims/studs").GetRelationship("prototypes").SetTargets(["/Coat/trims/proto"])
    define_mesh(stage, "/Coat/trims/proto", np.eye(3) * 0.1, [[0, 1, 2]])
    stage.Save()
    after, done = fitted(usdtailor, scene, *TRIMS)
    proto = [np.array(each.GetPrimAtPath("/Coat/trims/proto").GetAttribute("points").Get()) for each in (stage, after)]
    assert (proto[0] == proto[1]).all() and "/Coat/trims/proto" not in done.stdout + done.stderr


def test_patches_and_ribbons_go_along(usdtailor, scene):
    stage = edited(scene)
    patch = UsdGeom.NurbsPatch.Define(stage, "/Coat/b/patch")
    patch.CreatePointsAttr(vec3f(on_garment(np.repeat(np.linspace(1, 1.5, 4), 4), np.tile(np.linspace(2, 3, 4), 4), 0.05)))
    ribbons = UsdGeom.BasisCurves.Define(stage, "/Coat/b/ribbons")
    ribbons.CreatePointsAttr(vec3f(np.concatenate([on_garment(np.linspace(0, 1, 4), height, 0.05) for height in (4, 4.2)])))
    ribbons.CreateCurveVertexCountsAttr([4, 4])
    ribbons.CreateNormalsAttr([(0, 0, 1), (0, 0, 1)])
    ribbons.SetNormalsInterpolation("uniform")
    stage.Save()
    after, done = fitted(usdtailor, scene, *ONE)
    assert "/Coat/b" not in done.stderr
    for name in ("patch", "ribbons"):
        assert frames(after, np.array(after.GetPrimAtPath(f"/Coat/b/{name}").GetAttribute("points").Get(), float))[0].max() < 0.2, name
    turned = np.array(after.GetPrimAtPath("/Coat/b/ribbons").GetAttribute("normals").Get())
    assert (turned[:, 2] < 0.99).all() and np.linalg.norm(turned, axis=1) == pytest.approx([1, 1], abs=1e-5)


def test_trims_are_those_of_the_time(usdtailor, scene):
    stage = edited(scene)
    button(stage)
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/Coat")).AddTranslateOp()
    move.Set((50, 0, 0))
    move.Set((0, 0, 0), 1)
    stage.Save()
    after, done = fitted(usdtailor, scene, *ONE, "--time", "1")
    own = np.array(after.GetPrimAtPath("/Coat/b").GetAttribute("points").Get(), float)
    assert frames(after, own)[0].max() < 0.3 and "trim-off-cloth" not in done.stderr


def test_rotations_of_zeros_turn_nothing(usdtailor, scene):
    stage = edited(scene)
    studs = UsdGeom.PointInstancer(stage.GetPrimAtPath("/Coat/trims/studs"))
    studs.GetOrientationsfAttr().Clear()
    studs.GetOrientationsAttr().Set([Gf.Quath(0, 0, 0, 0), Gf.Quath(1, 0, 0, 0)])
    stage.Save()
    after, _ = fitted(usdtailor, scene, *TRIMS)
    found = UsdGeom.PointInstancer(after.GetPrimAtPath("/Coat/trims/studs")).ComputeInstanceTransformsAtTime(0, 0)
    assert np.isfinite([np.array(m) for m in found]).all()


def test_a_trim_of_another_garment_stays_and_is_named(usdtailor, scene):
    stage = edited(scene)
    button(stage)
    stage.Save()
    after, done = fitted(usdtailor, scene, *ONE, "--set", "trim.b.on=/Coat/nothing")
    assert "/Coat/b" in done.stderr and "/Coat/nothing, on which it rides, is not fitted" in done.stderr
    assert (middle(after) == middle(stage)).all()
    # Of two options, one moves it.
    args = ("--set", "trim.a.prims=b", "--set", "trim.a.mode=none")
    after, done = fitted(usdtailor, scene, *ONE, *args, out="both.usda")
    assert "mode is none" not in done.stderr and np.abs(middle(after) - middle(stage)).max() > 0.4


def test_trims_of_a_garment_that_is_not_fitted_stay(usdtailor, scene):
    stage = edited(scene)
    for key, name in (("from", "thin"), ("to", "thick")):
        stage.GetPrimAtPath("/Coat/model").CreateAttribute(f"tailor:fit:{key}", Sdf.ValueTypeNames.Asset).Set(f"{name}.usda")
    (points, counts, corners), _ = tube(3.5, 10.0, 24, 10)
    define_mesh(stage, "/Coat/cape", points, corners.reshape(-1, 4)).CreateSubdivisionSchemeAttr("catmullClark")
    button(stage, above=0.5)
    button(stage, "/Coat/c", above=0.05)
    stage.Save()
    args = ("--all", "--exclude", "/Coat/trims", "--exclude", "/Coat/b", "--exclude", "/Coat/c", "--set", "trim.b.prims=/Coat/b,/Coat/c")
    done = run(usdtailor, "build", scene / "coat.usda", "-o", scene / "out.usda", *QUICK, *args)
    assert done.returncode == 0, done.stderr
    built = Usd.Stage.Open(str(scene / "out.usda"))
    targets = [str(built.GetPrimAtPath(path).GetRelationship("tailor:bindTarget").GetTargets()[0]) for path in ("/Coat/b", "/Coat/c")]
    assert targets == ["/Coat/cape_sim", "/Coat/model_sim"]
    assert (middle(built) == middle(stage)).all() and np.abs(middle(built, "/Coat/c") - middle(stage, "/Coat/c")).max() > 0.4


def test_a_trim_beside_the_root_of_variants_is_named(usdtailor, scene):
    stage = edited(scene)
    button(stage, "/Other/b")
    stage.Save()
    args = ("--prim", "/Coat/model", "--set", "trim.b.prims=/Other/b", "--variant-set", "body")
    _, done = fitted(usdtailor, scene, *args)
    assert "/Other/b: not carried" in done.stderr and "rigid" not in done.stdout
    fitted(usdtailor, scene, *args, "--strict", out="strict.usda", code=1)


@needs_plugin
def test_a_payload_takes_its_trims_along(usdtailor, scene):
    stage, _ = fitted(usdtailor, scene, *TRIMS)
    shot = Usd.Stage.CreateNew(str(scene / "shot.usda"))
    options = {"fit": {"from": "thin.usda", "to": "thick.usda"}, "prim": "/Coat/model"}
    one = holder(shot, recipe(scene / "one.tailor", "coat.usda", **options, trim={"all": {"prims": ["trims/tape"]}}), "/Shot/One")
    two = holder(shot, recipe(scene / "two.tailor", "coat.usda", **options, trim={"all": {"prims": ["trims"]}}), "/Shot/Two")
    at = lambda prim, name: np.array(shot.GetPrimAtPath(f"{prim.GetPath()}/trims/{name}").GetAttribute("points").Get(), float)
    assert np.allclose(at(one, "tape"), own(stage, "tape"), atol=1e-5)
    assert np.allclose(at(two, "buttons"), own(stage, "buttons"), atol=1e-5)
    assert not np.allclose(at(one, "buttons"), own(stage, "buttons"), atol=1e-2), "this recipe has no buttons"
