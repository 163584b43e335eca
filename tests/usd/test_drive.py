"""`usdtailor drive`: the render mesh follows a cache of the simulation mesh."""

import os
import subprocess

import numpy as np
import pytest
from conftest import EXAMPLES, run
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

COAT = EXAMPLES / "sewn/coat.usda"
FRAMES = 7


def points(prim, time=None):
    return np.array(prim.GetAttribute("points").Get(Usd.TimeCode.Default() if time is None else time), float)


def bend(p, amount):
    """A twist about the vertical axis that grows with height, and a shift."""
    turn = amount * 0.01 * (p[:, 1] - p[:, 1].min())
    cos, sin = np.cos(turn), np.sin(turn)
    return np.stack([cos * p[:, 0] - sin * p[:, 2], p[:, 1] + 3 * amount, sin * p[:, 0] + cos * p[:, 2]], axis=1)


@pytest.fixture(scope="module")
def coat(built):
    return built(COAT, suffix=".usdc")


def moved(coat):
    rest = points(coat.prim("sim"))
    return np.stack([bend(rest, frame / (FRAMES - 1)) for frame in range(FRAMES)])


def write_cache(path, coat, frames, times=None, path_of_mesh=None, velocities=None, triangles=None):
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetTimeCodesPerSecond(25)
    sim = coat.prim("sim")
    # Overs have the transforms of the garment; a mesh of its own has the same.
    mesh = UsdGeom.Mesh.Define(stage, path_of_mesh) if path_of_mesh else UsdGeom.Mesh(stage.OverridePrim(sim.GetPath()))
    if path_of_mesh:
        mesh.AddTransformOp().Set(UsdGeom.Xformable(sim).ComputeLocalToWorldTransform(0))
    mesh.CreateFaceVertexCountsAttr(sim.GetAttribute("faceVertexCounts").Get())
    mesh.CreateFaceVertexIndicesAttr(sim.GetAttribute("faceVertexIndices").Get())
    if triangles is not None:
        mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(triangles.astype(np.int32).ravel()))
    for i, frame in enumerate(frames):
        time = i + 1 if times is None else times[i]
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(frame.astype(np.float32)), time)
        if velocities is not None:
            mesh.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(velocities[i].astype(np.float32)), time)
    stage.GetRootLayer().Save()
    return path


def drive(usdtailor, coat, cache, out, *args):
    return run(usdtailor, "drive", coat.path, "--cache", cache, "-o", out, *args)


@pytest.fixture(scope="module")
def cache(coat, tmp_path_factory):
    return write_cache(tmp_path_factory.mktemp("cache") / "cache.usdc", coat, moved(coat))


@pytest.fixture(scope="module")
def shot(usdtailor, coat, cache, tmp_path_factory):
    out = tmp_path_factory.mktemp("shot") / "shot.usdc"
    done = drive(usdtailor, coat, cache, out, "--model")
    assert done.returncode == 0, done.stderr
    return Usd.Stage.Open(str(out))


def test_at_bind_the_driven_mesh_is_the_render_mesh(coat, shot):
    for name in ("render", "model"):
        prim = shot.GetPrimAtPath(coat.prim(name).GetPath())
        rest = points(prim)
        size = np.linalg.norm(np.ptp(rest, axis=0))
        assert np.abs(points(prim, 1) - rest).max() <= 1e-6 * size
        assert prim.GetAttribute("points").GetNumTimeSamples() == FRAMES


def test_the_driven_mesh_follows_a_smooth_motion(coat, shot):
    for name in ("render", "model"):
        prim = shot.GetPrimAtPath(coat.prim(name).GetPath())
        rest = points(prim)
        apart = np.linalg.norm(points(prim, FRAMES) - bend(rest + 0.0, 1.0), axis=1)
        # The lowest point of both meshes differs a little, which turns them by as much.
        assert np.percentile(apart, 99) < 1.0 and np.linalg.norm(points(prim, FRAMES) - rest, axis=1).max() > 20


def test_extent_and_times_are_those_of_the_cache(coat, shot):
    prim = shot.GetPrimAtPath(coat.prim("render").GetPath())
    for frame in (1, FRAMES):
        low, high = np.array(prim.GetAttribute("extent").Get(frame))
        assert np.allclose([low, high], [points(prim, frame).min(0), points(prim, frame).max(0)], atol=1e-4)
    assert (shot.GetStartTimeCode(), shot.GetEndTimeCode(), shot.GetTimeCodesPerSecond()) == (1, FRAMES, 25)
    assert shot.GetDefaultPrim().GetName() == "Coat" and UsdGeom.GetStageMetersPerUnit(shot) == 0.01


def test_details_that_the_simulation_mesh_leaves_out_move_with_it(built, usdtailor, coat, tmp_path):
    smooth = built(COAT, "--set", "sim.smooth=rings(borders, 3)", suffix=".usdc")
    rest, render = points(smooth.prim("sim")), points(smooth.prim("render"))
    assert np.array_equal(render, points(coat.prim("render"))), "the render mesh keeps the details"
    assert rest.shape != points(coat.prim("sim")).shape or np.abs(rest - points(coat.prim("sim"))).max() > 0
    turned = rest[:, [2, 0, 1]]
    cache = write_cache(tmp_path / "cache.usdc", smooth, [rest, turned])
    done = drive(usdtailor, smooth, cache, tmp_path / "shot.usdc")
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    prim = stage.GetPrimAtPath(smooth.prim("render").GetPath())
    size = np.linalg.norm(np.ptp(render, axis=0))
    assert np.abs(points(prim, 1) - render).max() <= 1e-6 * size
    assert np.abs(points(prim, 2) - render[:, [2, 0, 1]]).max() <= 1e-5 * size


def nearest_of_the_same_face(face, coords, points, others):
    """For each point the nearest of `others` that is bound to the same face, and how far it is; infinitely far where none is."""
    others = others[np.argsort(face[others], kind="stable")]
    first, last = (np.searchsorted(face[others], face[points], side) for side in ("left", "right"))
    nearest, apart = np.zeros(len(points), int), np.full(len(points), np.inf)
    for i in np.flatnonzero(last > first):
        candidates = others[first[i] : last[i]]
        distances = np.abs(coords[candidates] - coords[points[i]]).max(axis=1)
        nearest[i], apart[i] = candidates[distances.argmin()], distances.min()
    return nearest, apart


def test_hems_keep_their_thickness(built, usdtailor, coat, cache, tmp_path):
    named = built(COAT, "--set", "render.faceSets=true", suffix=".usdc")
    out = tmp_path / "shot.usdc"
    assert drive(usdtailor, named, cache, out).returncode == 0
    stage = Usd.Stage.Open(str(out))
    prim = stage.GetPrimAtPath(named.prim("render").GetPath())
    faces = np.array(prim.GetAttribute("faceVertexIndices").Get()).reshape(-1, 4)
    inner = {s.GetName(): np.array(s.GetAttribute("indices").Get()) for s in prim.GetChildren() if s.GetName().endswith("_inner")}
    rest, last = points(prim), points(prim, FRAMES)
    bound, coords = (np.array(prim.GetAttribute(f"primvars:tailor:{name}").Get()) for name in ("bindFace", "bindCoords"))
    for name, indices in inner.items():
        copies = np.unique(faces[indices])
        others = np.unique(np.delete(faces, indices, axis=0))
        copies = np.setdiff1d(copies, others)
        # The other layer of a copy is at the same place of the simulation mesh.
        nearest, apart = nearest_of_the_same_face(bound, coords[:, :2], copies, others)
        is_pair = apart < 0.02
        assert is_pair.mean() > 0.3, name
        before, after = (np.linalg.norm(p[copies] - p[nearest], axis=1)[is_pair] for p in (rest, last))
        assert np.mean(np.abs(after / before - 1) < 0.1) >= 0.98, name


@pytest.mark.parametrize("kind", ["usda", "clips", "npz", "npy", "packed npz", "other path"])
def test_all_forms_of_caches_and_shots_give_the_same_points(usdtailor, coat, cache, shot, tmp_path, kind):
    args, out, source = [], tmp_path / "shot.usdc", cache
    frames = moved(coat)
    if kind == "usda":
        out = tmp_path / "shot.usda"
    elif kind == "clips":
        args = ["--clips"]
    elif kind == "npy":
        source = tmp_path / "cache.npy"
        np.save(source, frames.astype(np.float32))
    elif kind == "npz":
        source = tmp_path / "cache.npz"
        np.savez(source, points=frames, times=np.arange(1, FRAMES + 1.0))
    elif kind == "packed npz":
        source = tmp_path / "cache.npz"
        np.savez_compressed(source, anything=frames.astype(np.float32))
    else:
        source = write_cache(tmp_path / "cache.usda", coat, frames, path_of_mesh="/World/cloth_0")
    done = drive(usdtailor, coat, source, out, *args)
    assert done.returncode == 0, done.stderr
    path = coat.prim("render").GetPath()
    stage = Usd.Stage.Open(str(out))
    driven, expected = stage.GetPrimAtPath(path), shot.GetPrimAtPath(path)
    assert driven.GetAttribute("points").GetTimeSamples() == expected.GetAttribute("points").GetTimeSamples()
    for frame in (1, 4, FRAMES):
        # Text has as many digits as a float needs; NumPy's doubles are rounded once more.
        assert np.abs(points(driven, frame) - points(expected, frame)).max() < 1e-4
        assert np.allclose(driven.GetAttribute("extent").Get(frame), expected.GetAttribute("extent").Get(frame), atol=1e-4)


def test_results_are_the_same_at_every_thread_count(usdtailor, coat, cache, tmp_path):
    files = []
    for threads in (1, 2, 5):
        files.append(tmp_path / f"shot_{threads}.usdc")
        assert drive(usdtailor, coat, cache, files[-1], "--threads", threads).returncode == 0
    assert len({file.read_bytes() for file in files}) == 1


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the memory of a process can be asked for on Unix alone")
def test_memory_does_not_grow_with_the_number_of_frames(usdtailor, coat, tmp_path):
    def memory(frames):
        source = write_cache(tmp_path / f"{frames}.usdc", coat, np.repeat(moved(coat)[:1], frames, axis=0))
        command = [usdtailor, "drive", coat.path, "--cache", source, "-o", tmp_path / f"shot_{frames}.usdc", "--quiet"]
        process = subprocess.Popen([str(word) for word in command])
        _, status, used = os.wait4(process.pid, 0)
        assert status == 0
        return used.ru_maxrss

    assert memory(400) < 1.2 * memory(40)


def test_velocities_follow(usdtailor, coat, tmp_path):
    frames = moved(coat)
    velocities = np.gradient(frames, 1 / 25, axis=0)
    source = write_cache(tmp_path / "cache.usdc", coat, frames, velocities=velocities)
    out = tmp_path / "shot.usdc"
    assert drive(usdtailor, coat, source, out).returncode == 0
    stage = Usd.Stage.Open(str(out))
    prim = stage.GetPrimAtPath(coat.prim("render").GetPath())
    driven = np.stack([points(prim, frame) for frame in (3, 4, 5)])
    measured = (driven[2] - driven[0]) / (2 / 25)
    authored = np.array(prim.GetAttribute("velocities").Get(4))
    assert np.linalg.norm(authored - measured, axis=1).max() < 0.02 * np.linalg.norm(measured, axis=1).max()


@pytest.mark.parametrize(
    "fault, words",
    [
        ("fewer points", "points"),
        ("more points", "points"),
        ("other triangles", "another order"),
        ("reordered points", "another order"),
        ("gap", "frames are missing between 3"),
        ("not finite", "not finite"),
        ("one frame short", "points instead of"),
        ("velocities not finite", "the velocities of frame 4 are not finite"),
        ("shape beyond the file", "is cut"),
        ("clips in a package", "is a package"),
        ("no samples", "no mesh with points over time"),
        ("no cache", "no-such-file"),
        ("a picture", "can be read"),
        ("not bound", "not bound"),
    ],
)
def test_faults_are_told_and_nothing_is_written(usdtailor, coat, tmp_path, fault, words):
    frames, more, source, out = moved(coat), {}, tmp_path / "cache.usdc", tmp_path / "shot.usdc"
    order = np.random.default_rng(1).permutation(frames.shape[1])
    args = []
    if fault == "fewer points":
        frames = frames[:, :-5]
    elif fault == "more points":
        frames = np.concatenate([frames, frames[:, :3]], axis=1)
    elif fault == "other triangles":
        more["triangles"] = np.roll(np.array(coat.prim("sim").GetAttribute("faceVertexIndices").Get()).reshape(-1, 3), 1, axis=0)
    elif fault == "gap":
        more["times"] = [1, 2, 3, 6, 7, 8, 9]
    elif fault == "not finite":
        frames[5, 17] = np.nan
    elif fault == "velocities not finite":
        more["velocities"] = np.zeros_like(frames)
        more["velocities"][3, 2] = np.inf
    elif fault == "no samples":
        frames = frames[:0]
    elif fault == "clips in a package":
        args, out = ["--clips"], tmp_path / "shot.usdz"
    if fault == "reordered points":
        source = tmp_path / "cache.npz"
        np.savez(source, points=frames[:, order])
    elif fault == "shape beyond the file":
        source = tmp_path / "cache.npy"
        np.save(source, frames[:1].astype(np.float32))
        source.write_bytes(source.read_bytes().replace(b"(1, ", b"(1000000000000, ").replace(b" " * 12 + b"\n", b"\n"))
    elif fault == "no cache":
        source = tmp_path / "no-such-file.usdc"
    elif fault == "a picture":
        source = tmp_path / "cache.png"
        source.write_bytes(b"\x89PNG")
    else:
        frames = list(frames)
        if fault == "one frame short":
            frames[4] = frames[4][:-1]
        write_cache(source, coat, frames, **more)
    if fault == "not bound":
        args = ["--prim", "/Coat/body"]
    done = drive(usdtailor, coat, source, out, *args)
    assert done.returncode != 0 and words in done.stderr and "hint" in done.stderr, done.stderr
    assert not out.exists() and not list(tmp_path.glob(".usdtailor-*"))
    if fault == "gap":
        assert drive(usdtailor, coat, source, out, "--gaps").returncode == 0


@pytest.mark.parametrize("is_declared", [True, False])
def test_clips_may_lack_a_file_and_declare_points_in_their_manifest_alone(usdtailor, coat, tmp_path, is_declared):
    frames, times, path = moved(coat)[:4], [1, 2, 4, 5], coat.prim("sim").GetPath()
    for time, frame in zip(times, frames, strict=True):
        write_cache(tmp_path / f"frame.{time:03}.usdc", coat, [frame], times=[time])
    stages = {name: Usd.Stage.CreateNew(str(tmp_path / f"{name}.usda")) for name in ("manifest", "clips")}
    for name in stages if is_declared else ["manifest"]:
        UsdGeom.Mesh(stages[name].OverridePrim(path)).CreatePointsAttr()
    mesh, root = stages["clips"].OverridePrim(path), path.GetPrefixes()[0]
    clips = Usd.ClipsAPI(stages["clips"].GetPrimAtPath(root))
    clips.SetClipPrimPath(str(root))
    clips.SetClipManifestAssetPath("./manifest.usda")
    clips.SetClipTemplateAssetPath("./frame.###.usdc")
    clips.SetClipTemplateStartTime(1), clips.SetClipTemplateEndTime(5), clips.SetClipTemplateStride(1)
    for stage in stages.values():
        stage.GetRootLayer().Save()
    source, out, plain = tmp_path / "clips.usda", tmp_path / "shot.usdc", tmp_path / "plain.usdc"
    assert Usd.Stage.Open(str(source)).GetPrimAtPath(path).IsValid() and mesh.GetTypeName() == ""
    done = drive(usdtailor, coat, source, out)
    assert done.returncode == 1 and "frames are missing between 2 and 4" in done.stderr, done.stderr
    done = drive(usdtailor, coat, source, out, "--gaps")
    assert done.returncode == 0, done.stderr
    assert drive(usdtailor, coat, write_cache(tmp_path / "all.usdc", coat, frames, times=times), plain, "--gaps").returncode == 0
    driven, expected = (Usd.Stage.Open(str(file)) for file in (out, plain))
    prims = [stage.GetPrimAtPath(coat.prim("render").GetPath()) for stage in (driven, expected)]
    assert prims[0].GetAttribute("points").GetTimeSamples() == times
    for time in times:
        assert (points(prims[0], time) == points(prims[1], time)).all()


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint16, np.int8, np.float32])
def test_times_are_whole_numbers_or_not(usdtailor, coat, tmp_path, kind):
    frames, out = moved(coat)[:3], tmp_path / "shot.usdc"
    np.savez(tmp_path / "cache.npz", points=frames, times=np.array([101, 102, 103]).astype(kind))
    done = drive(usdtailor, coat, tmp_path / "cache.npz", out)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(out))
    driven = stage.GetPrimAtPath(coat.prim("render").GetPath())
    assert driven.GetAttribute("points").GetTimeSamples() == [101, 102, 103]


@pytest.mark.parametrize("times", [["1", "2", "3"], [[1, 2, 3]], [1, 2], np.array([1, 2, 3], dtype=">i4")])
def test_times_that_cannot_be_read_are_told(usdtailor, coat, tmp_path, times):
    np.savez(tmp_path / "cache.npz", points=moved(coat)[:3], times=np.array(times))
    done = drive(usdtailor, coat, tmp_path / "cache.npz", tmp_path / "shot.usdc")
    assert done.returncode == 1 and "times" in done.stderr and "hint" in done.stderr, done.stderr
    assert not (tmp_path / "shot.usdc").exists()


@pytest.mark.parametrize("times", [[1, 2, 9], [1, 8, 9], [1, 2, 3, 9]])
def test_a_gap_among_few_frames_is_told(usdtailor, coat, tmp_path, times):
    source, out = tmp_path / "cache.npz", tmp_path / "shot.usdc"
    np.savez(source, points=moved(coat)[: len(times)], times=times)
    done = drive(usdtailor, coat, source, out)
    assert done.returncode == 1 and "frames are missing between" in done.stderr, done.stderr
    assert drive(usdtailor, coat, source, out, "--gaps").returncode == 0


@pytest.mark.parametrize("interpolation, count", [("faceVarying", None), ("constant", 1), ("vertex", 5)])
def test_authored_normals_follow_and_none_is_left_behind(usdtailor, coat, cache, tmp_path, interpolation, count):
    dressed, out, path = tmp_path / "dressed.usda", tmp_path / "shot.usdc", coat.prim("render").GetPath()
    stage = Usd.Stage.CreateNew(str(dressed))
    stage.GetRootLayer().subLayerPaths.append(str(coat.path))
    mesh = UsdGeom.Mesh.Get(stage, path)
    mesh.GetSubdivisionSchemeAttr().Set("none")
    mesh.CreateNormalsAttr().Set(Vt.Vec3fArray(count or len(mesh.GetFaceVertexIndicesAttr().Get()), (0, 0, 1)))
    mesh.SetNormalsInterpolation(interpolation)
    stage.GetRootLayer().Save()
    done = run(usdtailor, "drive", dressed, "--cache", cache, "-o", out)
    if interpolation == "vertex":
        assert done.returncode != 0 and not out.exists()
        assert "5 normals of /Coat/render do not fit" in done.stderr and "hint" in done.stderr
        return
    assert done.returncode == 0, done.stderr
    driven = Usd.Stage.Open(str(out))
    normals = driven.GetPrimAtPath(path).GetAttribute("normals")
    if interpolation == "constant":
        assert not normals.GetNumTimeSamples(), "one normal for all points does not turn"
        return
    first, last = (np.array(normals.Get(frame)) for frame in (1, FRAMES))
    assert np.allclose(first, (0, 0, 1), atol=1e-5)
    assert np.abs(np.linalg.norm(last, axis=1) - 1).max() < 1e-4 and np.abs(last - first).max() > 0.2


@pytest.mark.parametrize("args", [[], ["--clips"]])
def test_a_primvar_of_normals_does_not_stay_as_at_bind(usdtailor, coat, cache, tmp_path, args):
    dressed, out, path = tmp_path / "dressed.usda", tmp_path / "shot.usdc", coat.prim("render").GetPath()
    stage = Usd.Stage.CreateNew(str(dressed))
    stage.GetRootLayer().subLayerPaths.append(str(coat.path))
    api = UsdGeom.PrimvarsAPI(UsdGeom.Mesh.Get(stage, path))
    corners = len(UsdGeom.Mesh.Get(stage, path).GetFaceVertexIndicesAttr().Get())
    normals = api.CreatePrimvar("normals", Sdf.ValueTypeNames.Normal3fArray, "faceVarying")
    normals.Set(Vt.Vec3fArray([(0, 0, 1)]))
    normals.SetIndices(Vt.IntArray(corners, 0))
    stage.GetRootLayer().Save()
    done = run(usdtailor, "drive", dressed, "--cache", cache, "-o", out, *args)
    assert done.returncode == 0, done.stderr
    driven = Usd.Stage.Open(str(out))
    left = UsdGeom.PrimvarsAPI(driven.GetPrimAtPath(path)).GetPrimvar("normals")
    assert not left.HasValue() and not left.IsIndexed()


def in_space(stage, coat, to_stage):
    """Makes the mesh of a cache one of its own, whose transform takes the points of the garment to the stage of the cache."""
    sim = coat.prim("sim")
    mesh = UsdGeom.Mesh.Define(stage, sim.GetPath())
    mesh.AddTransformOp().Set(UsdGeom.Xformable(sim).ComputeLocalToWorldTransform(0) * to_stage)


@pytest.mark.parametrize("suffix", [".usdc", ".usda"])
@pytest.mark.parametrize("points_turned", [True, False])
def test_a_cache_of_another_up_axis_does_not_lie_on_its_back(usdtailor, coat, shot, tmp_path, suffix, points_turned):
    """Some programs turn the points, and others the transform of the mesh."""
    frames = moved(coat)
    turned = np.stack([frames[..., 0], -frames[..., 2], frames[..., 1]], axis=-1)
    cache = write_cache(tmp_path / f"cache{suffix}", coat, turned if points_turned else frames)
    stage = Usd.Stage.Open(str(cache))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    if not points_turned:
        in_space(stage, coat, Gf.Matrix4d(Gf.Rotation((1, 0, 0), 90), (0, 0, 0)))
    stage.GetRootLayer().Save()
    out = tmp_path / "shot.usdc"
    done = drive(usdtailor, coat, cache, out)
    assert done.returncode == 0 and "turned" in done.stdout and "warning" not in done.stderr, done.stdout + done.stderr
    path = coat.prim("render").GetPath()
    driven = Usd.Stage.Open(str(out))
    assert np.abs(points(driven.GetPrimAtPath(path), 5) - points(shot.GetPrimAtPath(path), 5)).max() < 1e-3


@pytest.mark.parametrize("suffix", [".usdc", ".usda"])
@pytest.mark.parametrize("points_scaled", [True, False])
def test_a_cache_in_metres_moves_a_garment_in_centimetres(usdtailor, coat, shot, tmp_path, suffix, points_scaled):
    cache = write_cache(tmp_path / f"cache{suffix}", coat, moved(coat) * (0.01 if points_scaled else 1))
    stage = Usd.Stage.Open(str(cache))
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    if not points_scaled:
        in_space(stage, coat, Gf.Matrix4d().SetScale(0.01))
    stage.GetRootLayer().Save()
    out = tmp_path / "shot.usdc"
    done = drive(usdtailor, coat, cache, out)
    assert done.returncode == 0 and "scaled by 100" in done.stdout, done.stdout + done.stderr
    path = coat.prim("render").GetPath()
    driven = Usd.Stage.Open(str(out))
    assert np.abs(points(driven.GetPrimAtPath(path), 5) - points(shot.GetPrimAtPath(path), 5)).max() < 1e-3


def test_numbers_beyond_a_float_are_an_error(usdtailor, coat, tmp_path):
    """The points of the cache are finite, and what follows from them is not."""
    frames = moved(coat)
    frames[3] *= 1e36
    out = tmp_path / "shot.usdc"
    done = drive(usdtailor, coat, write_cache(tmp_path / "cache.usdc", coat, frames), out)
    if done.returncode == 0:
        assert np.isfinite(points(Usd.Stage.Open(str(out)).GetPrimAtPath(coat.prim("render").GetPath()), 4)).all()
    else:
        assert "cache-frames" in done.stderr and "frame 4" in done.stderr and not out.exists(), done.stderr


def test_inputs_are_never_overwritten(usdtailor, coat, cache):
    for target in (coat.path, cache):
        before = target.read_bytes()
        assert drive(usdtailor, coat, cache, target, "--force").returncode != 0
        assert target.read_bytes() == before


def test_what_a_cache_moves_is_not_skinned_again(coat, shot):
    for name in ("render", "model"):
        prim = coat.prim(name) if name == "render" else coat.source_stage.GetPrimAtPath("/Coat/model")
        assert UsdSkel.BindingAPI(prim).GetSkeletonRel().GetTargets(), "the garment itself is skinned"
        driven = shot.GetPrimAtPath(prim.GetPath())
        assert driven.HasAPI(UsdSkel.BindingAPI) and not UsdSkel.BindingAPI(driven).GetInheritedSkeleton()


def test_a_garment_is_built_again_over_its_output(build, coat):
    again = build(coat.path, "--prim", "/Coat/model", suffix=".usdc", stem="again")
    assert not any("bindFace" in warning for warning in again.warnings)
    sim, render = (again.stage.GetPrimAtPath(f"/Coat/{name}") for name in ("sim", "render"))
    assert not sim.GetAttribute("primvars:tailor:bindFace")
    assert len(render.GetAttribute("primvars:tailor:bindFace").Get()) == len(points(render))


@pytest.mark.parametrize("attributes", [["points"], ["physics:deformablePose:default:points"]], ids=["points", "pose"])
@pytest.mark.parametrize("name", ["sim", "render"])
def test_a_bind_pose_that_is_not_finite_is_refused(usdtailor, coat, cache, tmp_path, name, attributes):
    layer, out = tmp_path / "layer.usda", tmp_path / "shot.usdc"
    stage = Usd.Stage.CreateNew(str(layer))
    stage.GetRootLayer().subLayerPaths = [str(coat.path)]
    values = points(coat.prim(name))
    values[7, 1] = np.nan
    prim = stage.OverridePrim(coat.prim(name).GetPath())
    for name in attributes:
        prim.GetAttribute(name).Set(Vt.Vec3fArray.FromNumpy(values.astype(np.float32)))
    stage.Save()
    done = run(usdtailor, "drive", layer, "--cache", cache, "-o", out)
    assert done.returncode == 1 and "point 7 of" in done.stderr and "not finite" in done.stderr, done.stderr
    assert not out.exists()


@pytest.mark.parametrize("args", [[], ["--prim", "/World/Coat/render"]], ids=["any", "named"])
def test_a_garment_in_an_instance_is_refused_with_the_instance(usdtailor, coat, cache, tmp_path, args):
    above, out = tmp_path / "above.usda", tmp_path / "out.usda"
    stage = Usd.Stage.CreateNew(str(above))
    prim = stage.DefinePrim("/World/Coat")
    prim.GetReferences().AddReference(str(coat.path), coat.model_path.GetPrefixes()[0])
    prim.SetInstanceable(True)
    stage.Save()
    run_again = lambda: run(usdtailor, "drive", above, "--cache", cache, "-o", out, *args)  # noqa: E731
    done = run_again()
    assert done.returncode == 1 and not out.exists()
    for words in ("error[inside-instance]", "is inside the instance /World/Coat,", "set instanceable = false on /World/Coat"):
        assert words in done.stderr, done.stderr
    # The remedy helps: the refusal is no longer of the instance.
    prim.SetInstanceable(False)
    stage.Save()
    assert "inside-instance" not in run_again().stderr
