"""Trims ride on cloth: their places are compared with those of a sheet that bends as a whole, by numpy."""

import json

import numpy as np
import pytest
from conftest import EXAMPLES, run
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade
from runs import good, refused
from sources import define_mesh
from trimmed import ARGS, BUTTONS, STUDS, boxes, driven, flat, grid, on_cloth, times, turn, world, write_front


@pytest.fixture(scope="module")
def stage_file(tmp_path_factory):
    return write_front(tmp_path_factory.mktemp("trims") / "front.usda")


@pytest.fixture(scope="module")
def shot(usdtailor, stage_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    out, report = folder / "out.usdc", folder / "report.json"
    done = run(usdtailor, "build", stage_file, "-o", out, "--report", report, *ARGS)
    assert done.returncode == 0, done.stderr
    return out, driven(usdtailor, out, folder / "shot.usdc"), json.loads(report.read_text()), done.stdout


def test_buttons_move_as_wholes_with_the_cloth_below_them(shot):
    _, stage, _, _ = shot
    rest = boxes()[0].reshape(len(BUTTONS), 24, 3)
    for frame, time in enumerate(times(stage)):
        found = world(stage, "/G/trims/buttons", time).reshape(rest.shape)
        for piece, before, (arc, height) in zip(found, rest, BUTTONS):
            size = np.linalg.norm(np.ptp(before, axis=0))
            at = on_cloth([arc, height, 0], 0)
            right = on_cloth([arc, height, 0], frame) + (before - at) @ turn(arc, frame).T
            assert np.linalg.norm(piece - right, axis=1).max() < 0.02 * size, (frame, arc)
            apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (piece, before)]
            assert np.abs(apart[0] - apart[1]).max() < 1e-4 * size


def test_a_tape_and_cords_bend_with_the_cloth(shot):
    _, stage, _, _ = shot
    for path, size in (("/G/trims/tape", 60), ("/G/trims/cords", 60)):
        rest = flat(world(stage, path, times(stage)[0]))
        for frame, time in enumerate(times(stage)):
            right = on_cloth(rest, frame)
            assert np.linalg.norm(world(stage, path, time) - right, axis=1).max() < 0.002 * size, (path, frame)


def test_instances_move_and_turn(shot):
    _, stage, _, _ = shot
    studs = UsdGeom.PointInstancer(stage.GetPrimAtPath("/G/trims/studs"))
    to_world = np.array(UsdGeom.Xformable(studs).ComputeLocalToWorldTransform(0))
    matrices = [studs.ComputeInstanceTransformsAtTime(time, time) for time in times(stage)]
    at_rest = [np.array(m) @ to_world for m in matrices[0]]
    for frame, of_frame in enumerate(matrices):
        for matrix, rest, (arc, height) in zip(of_frame, at_rest, STUDS):
            found = np.array(matrix) @ to_world
            assert np.linalg.norm(found[3, :3] - on_cloth([arc, height, 0.2], frame)) < 0.012
            right = rest[:3, :3] @ turn(arc, frame).T
            # Orientations have half precision.
            assert np.abs(found[:3, :3] - right).max() < 0.02 * 2, (frame, arc)
    time = times(stage)[-1]
    low, high = np.array(studs.GetExtentAttr().Get(time))
    positions = np.array(studs.GetPositionsAttr().Get(time))
    assert (low <= positions.min(0) - 0.29).all() and (high >= positions.max(0) + 0.29).all()


def test_pieces_and_modes_are_told(shot, usdtailor, stage_file):
    _, _, report, text = shot
    found = {trim["prim"].rsplit("/", 1)[1]: (trim["pieces"], trim["rigid"]) for trim in report["trims"]}
    assert found == {"buttons": (4, 4), "tape": (1, 0), "cords": (2, 0), "studs": (3, 3)}
    assert "/G/trims/buttons: 4 rigid pieces (small)" in text and "1 soft piece (large and thin)" in text
    info = good(usdtailor, "info", stage_file, *ARGS)
    assert "/G/trims/buttons: 4 rigid pieces (small)" in info.stdout


def test_a_mode_is_of_all_pieces(usdtailor, stage_file, tmp_path):
    built = tmp_path / "out.usdc"
    good(usdtailor, "build", stage_file, "-o", built, *ARGS, "--set", "trim.all.mode=soft")
    stage = driven(usdtailor, built, tmp_path / "shot.usdc")
    piece = world(stage, "/G/trims/buttons", times(stage)[-1])[:24]
    rest = boxes()[0][:24]
    apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (piece, rest)]
    assert np.abs(apart[0] - apart[1]).max() > 0.02, "each point bends with the cloth"
    good(usdtailor, "build", stage_file, "-o", tmp_path / "none.usdc", *ARGS, "--set", "trim.all.mode=none")
    stage = Usd.Stage.Open(str(tmp_path / "none.usdc"))
    prim = stage.GetPrimAtPath("/G/trims/buttons")
    assert prim and not prim.HasRelationship("tailor:bindTarget")


@pytest.mark.parametrize("args", [["--flatten"], []], ids=["flat", "over"])
@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_every_output_has_the_places(shot, usdtailor, stage_file, tmp_path, args, suffix):
    out = tmp_path / f"out{suffix}"
    good(usdtailor, "build", stage_file, "-o", out, *ARGS, *args)
    stages = [Usd.Stage.Open(str(path)) for path in (shot[0], out)]
    first, second = (stage.GetPrimAtPath("/G/trims/buttons") for stage in stages)
    for name in ("primvars:tailor:bindFace", "primvars:tailor:bindCoords"):
        assert np.allclose(np.array(first.GetAttribute(name).Get()), np.array(second.GetAttribute(name).Get()), atol=1e-5)
        assert UsdGeom.Primvar(second.GetAttribute(name)).GetInterpolation() == "vertex"
    stage = driven(usdtailor, out, tmp_path / "shot.usdc")
    assert np.allclose(world(stage, "/G/trims/tape", times(stage)[-1]), world(shot[1], "/G/trims/tape", times(shot[1])[-1]), atol=1e-3)


def test_clips_and_text_have_the_same_frames(shot, usdtailor, tmp_path):
    for name, args in (("clips.usda", ["--clips"]), ("text.usda", [])):
        stage = driven(usdtailor, shot[0], tmp_path / name, *args)
        time = times(stage)[-2]
        for path, attribute in (("buttons", "points"), ("studs", "positions")):
            path = f"/G/trims/{path}"
            assert np.allclose(world(stage, path, time, attribute), world(shot[1], path, times(shot[1])[-2], attribute), atol=1e-4)
        turns = [UsdGeom.PointInstancer(s.GetPrimAtPath("/G/trims/studs")).GetOrientationsAttr().Get(time) for s in (stage, shot[1])]
        assert turns[0] == turns[1] and turns[0][0] != Gf.Quath(0.6, 0, 0.8, 0)


def test_relationships_name_trims_and_they_are_no_garments(usdtailor, stage_file, tmp_path):
    """Without --prim: a mesh that options name as a trim is not one of the meshes to choose from."""
    path = tmp_path / "authored.usda"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    front = stage.OverridePrim("/G/front")
    front.CreateRelationship("tailor:trim:all:prims").SetTargets(["/G/trims"])
    front.CreateAttribute("tailor:trim:all:mode", Sdf.ValueTypeNames.Token).Set("rigid")
    stage.GetRootLayer().Save()
    out = tmp_path / "out.usdc"
    done = good(usdtailor, "build", path, "-o", out, "--set", "render.level=0")
    assert "/G/trims/tape: 1 rigid piece" in done.stdout
    assert refused(usdtailor, "build", stage_file, "-o", tmp_path / "no.usdc", says=["several-meshes"])


@pytest.mark.parametrize("choice", [["--all"], ["--prim", "/G"]], ids=["all", "prim"])
def test_what_is_too_small_or_too_thick_is_left_out(usdtailor, stage_file, tmp_path, choice):
    out = tmp_path / "out.usdc"
    done = good(usdtailor, "build", stage_file, "-o", out, *choice, "--set", "render.level=0")
    stage = Usd.Stage.Open(str(out))
    assert stage.GetPrimAtPath("/G/trims/buttons").GetRelationship("tailor:bindTarget").GetTargets()
    # The tape is cloth: a part of the garment that it lies on.
    assert stage.GetPrimAtPath("/G/sim/tape") and not stage.GetPrimAtPath("/G/trims/buttons_sim")
    assert "/G/trims/buttons: 4 rigid pieces (small)" in done.stdout
    # Options of its own make it cloth.
    path = tmp_path / "cloth.usda"
    own = Usd.Stage.CreateNew(str(path))
    own.GetRootLayer().subLayerPaths.append(str(stage_file))
    own.OverridePrim("/G/trims/buttons").CreateAttribute("tailor:cloth:fabric", Sdf.ValueTypeNames.Token).Set("leather")
    own.GetRootLayer().Save()
    good(usdtailor, "build", path, "-o", tmp_path / "two.usdc", *choice, "--set", "render.level=0")
    stage = Usd.Stage.Open(str(tmp_path / "two.usdc"))
    assert stage.GetPrimAtPath("/G/trims/sim") and stage.GetPrimAtPath("/G/sim/tape")


def test_a_trim_rides_on_the_nearest_garment_or_on_the_one_that_is_named(usdtailor, stage_file, tmp_path):
    path = tmp_path / "two.usda"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    define_mesh(stage, "/G/lining", on_cloth(flat(np.array(stage.GetPrimAtPath("/G/front").GetAttribute("points").Get())) - [0, 0, 1.5], 0), grid(20, 16, 100, 80)[1])
    stage.GetRootLayer().Save()
    args = ("--all", "--set", "render.level=0", "--set", "trim.all.prims=/G/trims")
    for number, (on, right) in enumerate([([], "/G/front"), (["--set", "trim.all.on=/G/lining"], "/G/lining")]):
        out = tmp_path / f"out{number}.usdc"
        good(usdtailor, "build", path, "-o", out, *args, *on)
        built = Usd.Stage.Open(str(out))
        for trim in ("buttons", "tape", "cords", "studs"):
            [target] = built.GetPrimAtPath(f"/G/trims/{trim}").GetRelationship("tailor:bindTarget").GetTargets()
            assert str(target) == f"{right}_sim", trim


def test_threads_give_the_same_bytes(usdtailor, stage_file, tmp_path):
    outs = [tmp_path / f"{threads}.usdc" for threads in (1, 4)]
    for out, threads in zip(outs, (1, 4)):
        good(usdtailor, "build", stage_file, "-o", out, *ARGS, "--threads", threads, "--flatten")
    layers = [Sdf.Layer.FindOrOpen(str(out)) for out in outs]
    for name in ("primvars:tailor:bindFace", "primvars:tailor:bindCoords"):
        first, second = (layer.GetAttributeAtPath(f"/G/trims/tape.{name}").default for layer in layers)
        assert first == second and len(first) > 0


SKIRT = EXAMPLES / "trims/skirt.usda"


def test_the_skirt_has_its_trims_and_looks_in_every_size(usdtailor, tmp_path):
    out = tmp_path / "skirt.usdc"
    done = good(usdtailor, "build", SKIRT, "-o", out, "--variants", "size", "--set", "render.level=1", "--set", "sim.minEdgeLength=1.6", "--set", "sim.maxEdgeLength=1.6", "--strict")
    assert "warning" not in done.stderr
    stage = Usd.Stage.Open(str(out))
    root, seen = stage.GetDefaultPrim(), set()
    for size in root.GetVariantSet("size").GetVariantNames():
        root.GetVariantSet("size").SetVariantSelection(size)
        for colour in root.GetVariantSet("colour").GetVariantNames():
            root.GetVariantSet("colour").SetVariantSelection(colour)
            bound = {UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(f"/Skirt/{name}")).ComputeBoundMaterial()[0].GetPath().name for name in ("body", "render", "sim")}
            assert bound == {colour}
        sim = stage.GetPrimAtPath("/Skirt/sim")
        points = np.array(sim.GetAttribute("points").Get(), float)
        triangles = np.array(sim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3)
        for name, attribute in (("buttons", "points"), ("loops", "points"), ("zip_tape", "points"), ("zip_teeth", "positions")):
            prim = stage.GetPrimAtPath(f"/Skirt/{name}")
            own = np.array(prim.GetAttribute(attribute).Get(), float)
            faces = np.array(prim.GetAttribute("primvars:tailor:bindFace").Get())
            coords = np.array(prim.GetAttribute("primvars:tailor:bindCoords").Get(), float)
            assert len(faces) == len(coords) == len(own)
            weights = np.stack([coords[:, 0], coords[:, 1], 1 - coords[:, 0] - coords[:, 1]], 1)
            places = np.einsum("pk,pkc->pc", weights, points[triangles[faces]])
            assert np.linalg.norm(places - own, axis=1).max() < 4, (size, name)
            seen.add((name, round(float(np.abs(own[:, 0]).max()), 2)))
    assert len(seen) >= 3 * 3, "trims have a size each"


def test_a_shot_of_the_skirt_moves_its_trims(usdtailor, tmp_path):
    out, shot = tmp_path / "skirt.usdc", tmp_path / "shot.usdc"
    good(usdtailor, "build", SKIRT, "-o", out, "--set", "render.level=1")
    stage = Usd.Stage.Open(str(out))
    rest = np.array(stage.GetPrimAtPath("/Skirt/sim").GetAttribute("points").Get(), float)
    a = np.radians(30)
    turned = rest @ np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]]).T + [5, -3, 2]
    np.save(tmp_path / "cache.npy", np.stack([rest, turned]).astype(np.float32))
    good(usdtailor, "drive", out, "--cache", tmp_path / "cache.npy", "-o", shot)
    stage = Usd.Stage.Open(str(shot))
    for name, attribute in (("render", "points"), ("buttons", "points"), ("loops", "points"), ("zip_tape", "points"), ("zip_teeth", "positions")):
        values = stage.GetPrimAtPath(f"/Skirt/{name}").GetAttribute(attribute)
        start, end = (np.array(values.Get(stage.GetStartTimeCode() + frame), float) for frame in (0, 1))
        right = start @ np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]]).T + [5, -3, 2]
        assert np.abs(end - right).max() < 1e-3, name


def test_any_number_of_trims_is_found(usdtailor, stage_file, tmp_path):
    path, out = tmp_path / "many.usda", tmp_path / "out.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    for i in range(1200):
        define_mesh(stage, f"/G/beads/b{i}", on_cloth(np.array([[i % 60 - 30, i // 60, 0.1], [i % 60 - 29.5, i // 60, 0.1], [i % 60 - 30, i // 60 + 0.5, 0.1]]), 0), [[0, 1, 2]])
    stage.GetRootLayer().Save()
    good(usdtailor, "build", path, "-o", out, "--all", "--set", "render.level=0")
    stage = Usd.Stage.Open(str(out))
    assert all(stage.GetPrimAtPath(f"/G/beads/b{i}").HasRelationship("tailor:bindTarget") for i in range(1200))


@pytest.mark.parametrize("kind", ["relationship", "array", "text"])
def test_prims_are_trims_whatever_type_names_them(usdtailor, stage_file, tmp_path, kind):
    path, out = tmp_path / "named.usda", tmp_path / "out.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    front, name = stage.OverridePrim("/G/front"), "tailor:trim:all:prims"
    if kind == "relationship":
        front.CreateRelationship(name).SetTargets(["/G/trims/buttons", "/G/trims/tape"])
    elif kind == "array":
        front.CreateAttribute(name, Sdf.ValueTypeNames.StringArray).Set(["trims/buttons", "/G/trims/tape"])
    else:
        front.CreateAttribute(name, Sdf.ValueTypeNames.String).Set("trims/buttons, /G/trims/tape")
    stage.GetRootLayer().Save()
    done = good(usdtailor, "build", path, "-o", out, "--set", "render.level=0")
    assert all(f"/G/trims/{trim}: " in done.stdout for trim in ("buttons", "tape"))


def test_a_trim_of_the_users_keeps_its_name_beside_those_that_are_found(usdtailor, stage_file, tmp_path):
    path, out = tmp_path / "found.usda", tmp_path / "out.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(stage_file))
    stage.OverridePrim("/G/front").CreateRelationship("tailor:trim:found:prims").SetTargets(["/G/trims/tape"])
    stage.GetRootLayer().Save()
    done = good(usdtailor, "build", path, "-o", out, "--all", "--set", "render.level=0")
    assert all(f"/G/trims/{trim}: " in done.stdout for trim in ("buttons", "tape"))
