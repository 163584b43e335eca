"""Files are safe: nothing is left behind, nothing that is used is overwritten, and nothing is read or built without a bound."""

import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile

import numpy
import pytest
from conftest import run
from pxr import Sdf, Usd, UsdGeom, Vt
from runs import good, meshes, mounted, refused, sim_points
from sources import add_subset, sheet, write

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="links, pipes and signals are those of Unix")

LARGE = ("--set", "render.level=6", "--set", "cloth.physics=", "--set", "sim.maxEdgeLength=2")


def started_write(usdtailor, folder, *args, before=None, quads=20):
    """Starts a build and waits until a temporary file is there."""
    source = write(folder / "in.usda", shape=lambda: sheet(quads, quads))
    process = subprocess.Popen([usdtailor, "build", source, *LARGE, *args], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, preexec_fn=before)
    end = time.monotonic() + 120
    while time.monotonic() < end and process.poll() is None:
        if any(path.name.startswith(".usdtailor-") for path in folder.iterdir()):
            return process
        time.sleep(0.002)
    pytest.fail(f"no temporary file was seen before the end: {process.poll()}")


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1"])
def test_a_signal_leaves_no_temporary_file(usdtailor, tmp_path, name):
    number = getattr(signal, name)
    # A shell lets what it starts in the background ignore some.
    process = started_write(usdtailor, tmp_path, "-o", tmp_path / "out.usda", "--flatten", before=lambda: signal.signal(number, signal.SIG_DFL))
    process.send_signal(number)
    assert process.wait(60) == 128 + number
    assert [path.name for path in tmp_path.iterdir()] == ["in.usda"]


def test_an_ignored_signal_stays_ignored(usdtailor, tmp_path):
    process = started_write(usdtailor, tmp_path, "-o", tmp_path / "out.usda", "--flatten", before=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN), quads=12)
    process.send_signal(signal.SIGHUP)
    assert process.wait(300) == 0
    assert meshes(tmp_path / "out.usda") == ["model", "render", "sim"]


def test_a_signal_leaves_no_folder_of_clips(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    garment = tmp_path / "built.usda"
    good(usdtailor, "build", source, "-o", garment)
    points = sim_points(garment)
    numpy.save(tmp_path / "cache.npy", numpy.repeat(points[None], 3000, axis=0))
    process = subprocess.Popen([usdtailor, "drive", garment, "--cache", tmp_path / "cache.npy", "-o", tmp_path / "shot.usda", "--clips", "-q"])
    while process.poll() is None and not any(path.name.startswith(".usdtailor-") for path in tmp_path.iterdir()):
        time.sleep(0.002)
    process.send_signal(signal.SIGTERM)
    assert process.wait(60) == 143
    assert sorted(path.name for path in tmp_path.iterdir()) == ["built.usda", "cache.npy", "in.usda"]


def test_a_shot_of_clips_makes_its_folders_and_leaves_none_behind(usdtailor, tmp_path):
    garment = tmp_path / "built.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    points = sim_points(garment)
    numpy.save(tmp_path / "cache.npy", numpy.repeat(points[None], 3, axis=0))
    shot = tmp_path / "shots" / "one" / "shot.usda"
    refused(usdtailor, "drive", garment, "--cache", tmp_path / "none.npy", "-o", shot, "--clips", says=["none.npy"])
    assert not (tmp_path / "shots").exists()
    good(usdtailor, "drive", garment, "--cache", tmp_path / "cache.npy", "-o", shot, "--clips")
    assert sorted(path.name for path in shot.parent.iterdir()) == ["shot.clips", "shot.usda"]


@pytest.mark.parametrize("option", ["sim.maxEdgeLength=1e30", "sim.maxEdgeLength=1e30 sim.minEdgeLength=1e29"])
def test_a_target_length_without_bound_is_refused_with_its_range(usdtailor, tmp_path, option):
    source = write(tmp_path / "in.usda")
    sets = [word for one in option.split() for word in ("--set", one)]
    refused = run(usdtailor, "build", source, "-o", tmp_path / "out.usda", *sets)
    assert refused.returncode in (1, 2) and "times the size" in refused.stderr and "keep it within" in refused.stderr, refused.stderr


# Inputs.

USED = "is the input, or a file that the input uses"


def used_files(folder):
    """A garment that uses a file by every means, and these files."""
    write(folder / "base.usda")
    unselected = write(folder / "unselected.usda")
    for name in ("payload.usda", "nested.usda", "clip.003.usda"):
        (folder / name).write_text('#usda 1.0\ndef "Other" {}\n')
    mounted(folder / "wide.usda", 'def "Coat" (\n    references = @./nested.usda@</Other>\n)\n{\n}')
    for name in ("cloth.png", "tile.1001.png", "note.txt"):
        (folder / name).write_text("precious")
    text = """
def Xform "Coat" (
    variants = { string fit = "slim" }
    prepend variantSets = "fit"
    references = @./base.usda@</Coat>
    clips = { dictionary default = { string templateAssetPath = "./clip.###.usda"  string primPath = "/Coat" } }
    customData = { asset note = @./note.txt@ }
)
{
    asset look = @./cloth.png@
    asset tiles = @./tile.<UDIM>.png@
    variantSet "fit" = {
        "slim" { }
        "wide" ( references = @./wide.usda@</Coat> payload = @./payload.usda@</Other> ) { over "x" ( references = @./unselected.usda@</Coat> ) {} }
    }
}
"""
    top = mounted(folder / "top.usda", text)
    layers = [folder / name for name in ("base.usda", "wide.usda", "nested.usda", "payload.usda", "clip.003.usda")]
    return top, [top, *layers, unselected], [folder / name for name in ("cloth.png", "tile.1001.png", "note.txt")]


def test_a_file_that_the_stage_names_is_never_overwritten(usdtailor, tmp_path):
    top, layers, assets = used_files(tmp_path)
    before = {path: path.read_bytes() for path in layers + assets}
    for layer in layers:
        refused(usdtailor, "build", top, "-o", layer, "--force", says=[USED])
    for asset in assets:
        link = tmp_path / f"{asset.name}.usda"
        os.link(asset, link)
        refused(usdtailor, "build", top, "-o", link, "--force", says=[USED])
        report = tmp_path / f"{asset.name}.json"
        os.link(asset, report)
        refused(usdtailor, "build", top, "-o", tmp_path / "out.usda", "--report", report, "--force", says=[USED])
    assert {path: path.read_bytes() for path in before} == before
    assert not (tmp_path / "out.usda").exists()
    free = tmp_path / "free.usda"
    free.write_text("#usda 1.0\n")
    good(usdtailor, "build", top, "-o", free, "--force")


def test_a_recipe_is_never_overwritten(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    recipe = tmp_path / "r.json"
    recipe.write_text('{"sim": {"iterations": 3}}')
    refused(usdtailor, "build", source, "-o", tmp_path / "out.usda", "--recipe", recipe, "--report", recipe, "--force", says=[USED])
    link = tmp_path / "link.usda"
    os.link(recipe, link)
    refused(usdtailor, "build", source, "-o", link, "--recipe", recipe, "--force", says=[USED])
    assert recipe.read_text() == '{"sim": {"iterations": 3}}'
    assert not (tmp_path / "out.usda").exists()


def test_an_output_is_no_input_of_another_garment(usdtailor, tmp_path):
    (tmp_path / "out").mkdir()
    write(tmp_path / "a.usda")
    base = write(tmp_path / "out" / "a_tailored.usdc")
    before = base.read_bytes()
    mounted(tmp_path / "b.usda", 'def "Coat" (\n    references = @./out/a_tailored.usdc@</Coat>\n)\n{\n}')
    refused(usdtailor, "build", tmp_path / "a.usda", tmp_path / "b.usda", "-o", tmp_path / "out", "--force", says=[USED])
    assert base.read_bytes() == before


def test_a_shot_replaces_no_input_and_no_other_folder(usdtailor, tmp_path):
    garment = tmp_path / "built.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    points = sim_points(garment)
    clips = tmp_path / "shot.clips"
    clips.mkdir()
    cache = clips / "frame.00000.usdc"
    stage = Usd.Stage.CreateNew(str(cache))
    mesh = UsdGeom.Mesh.Define(stage, "/Coat/sim")
    for frame in (1, 2):
        mesh.CreatePointsAttr().Set(points, frame)
    stage.Save()
    drive = ("drive", garment, "-o", tmp_path / "shot.usda", "--clips", "--force", "--cache")
    refused(usdtailor, *drive, cache, says=["holds", "which is an input"])
    moved = cache.rename(tmp_path / "cache.usdc")
    (clips / "notes.txt").write_text("precious")
    refused(usdtailor, *drive, moved, says=["shot.clips is not a folder of clips, or holds more than clips"])
    (clips / "notes.txt").unlink()
    # A folder with the name of a clip.
    (clips / "frame.00007.usdc").mkdir()
    (clips / "frame.00007.usdc" / "notes.txt").write_text("precious")
    refused(usdtailor, *drive, moved, says=["holds the folder", "frame.00007.usdc", "move it away"])
    assert (clips / "frame.00007.usdc" / "notes.txt").read_text() == "precious"
    shutil.rmtree(clips / "frame.00007.usdc")
    good(usdtailor, *drive, moved)
    first = sorted(path.name for path in clips.iterdir())
    good(usdtailor, *drive, moved)
    assert sorted(path.name for path in clips.iterdir()) == first and len(first) == 3


def test_a_kill_leaves_one_of_two_shots(usdtailor, tmp_path):
    garment, shot = tmp_path / "built.usda", tmp_path / "shot.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    points = sim_points(garment)
    drives = []
    for i, frames in enumerate((40, 60)):
        numpy.save(tmp_path / f"{i}.npy", numpy.stack([points + [0, i, 0]] * frames))
        drives.append([usdtailor, "drive", garment, "-o", shot, "--clips", "--force", "-q", "--cache", tmp_path / f"{i}.npy"])
    begin = time.monotonic()
    good(*drives[0])
    seconds = time.monotonic() - begin

    def state():
        """The number of frames that the shot names, and the heights that its clips give."""
        layer = Sdf.Layer.OpenAsAnonymous(str(shot))
        names = layer.GetPrimAtPath("/Coat/render").GetInfo("clips")["default"]["assetPaths"]
        heights = set()
        for asset in names:
            samples = Sdf.Layer.OpenAsAnonymous(str(tmp_path / asset.path)).ListTimeSamplesForPath("/Coat/render.points")
            values = Sdf.Layer.OpenAsAnonymous(str(tmp_path / asset.path)).QueryTimeSample("/Coat/render.points", samples[0])
            heights.add(round(float(numpy.mean(numpy.array(values)[:, 1])), 3))
        return len(names), heights

    states = [state()]
    for kill in range(24):
        process = subprocess.Popen(drives[(kill + 1) % 2])
        # Near the end, where files get their names.
        time.sleep(seconds * (0.6 + 0.02 * kill))
        process.kill()
        process.wait()
        states.append(state())
        assert len(states[-1][1]) == 1, states[-1]
    good(*drives[1])
    ends = {states[0][0]: states[0][1], state()[0]: state()[1]}
    assert all(ends[count] == heights for count, heights in states), states


def test_of_two_shots_of_clips_at_once_one_stays_whole(usdtailor, tmp_path):
    garment, shot = tmp_path / "built.usda", tmp_path / "shot.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    points = sim_points(garment)
    for i in range(3):
        numpy.save(tmp_path / f"{i}.npy", numpy.stack([points + [0, 0.01 * i * k, 0] for k in range(5 + 2 * i)]))
    for _ in range(12):
        drives = [[usdtailor, "drive", garment, "--cache", tmp_path / f"{i}.npy", "-o", shot, "--clips", "--force", "-q"] for i in range(3)]
        processes = [subprocess.Popen(drive) for drive in drives]
        assert [process.wait(60) for process in processes] == [0, 0, 0]
        layer = Sdf.Layer.OpenAsAnonymous(str(shot))
        clips = layer.GetPrimAtPath("/Coat/render").GetInfo("clips")["default"]
        named = [*clips["assetPaths"], clips["manifestAssetPath"]]
        there = {path.name for path in (tmp_path / "shot.clips").iterdir()}
        assert {os.path.basename(asset.path) for asset in named} == there, "none is missing, and none is left"
    assert not list(tmp_path.glob(".usdtailor-*"))


def test_of_runs_on_one_report_it_is_of_the_output_that_stays(usdtailor, tmp_path):
    source, out, report = write(tmp_path / "in.usda"), tmp_path / "out.usda", tmp_path / "report.json"
    for _ in range(4):
        builds = [[usdtailor, "build", source, "-o", out, "--force", "--report", report, "--set", f"render.level={level}"] for level in (1, 2, 3)]
        processes = [subprocess.Popen(build, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for build in builds]
        assert [process.wait(300) for process in processes] == [0, 0, 0]
        stage = Usd.Stage.Open(str(out))
        stage.Reload()
        faces = len(UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/render")).GetFaceVertexCountsAttr().Get())
        assert json.loads(report.read_text())["render"]["faces"] == faces
    assert not list(tmp_path.glob(".usdtailor-*"))


def test_of_two_runs_on_one_output_one_succeeds(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda", shape=lambda: sheet(12, 12))
    # With one report for all: it is that of the one that succeeds.
    report = tmp_path / "report.json"
    args = [usdtailor, "build", source, "-o", tmp_path / "out.usda", "--report", report]
    for _ in range(3):
        processes = [subprocess.Popen(args, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) for _ in range(3)]
        words = [process.communicate(timeout=300)[1] for process in processes]
        codes = sorted(process.returncode for process in processes)
        assert codes == [0, 1, 1], words
        assert sum("exists already" in text for text in words) == 2, words
        assert "sim" in json.loads(report.read_text()), "a report of meshes"
        (tmp_path / "out.usda").unlink()
        report.unlink()


def test_a_run_that_loses_its_output_leaves_no_report(usdtailor, tmp_path):
    source, out = write(tmp_path / "in.usda"), tmp_path / "out.usda"
    out.write_text("#usda 1.0\n")
    refused(usdtailor, "build", source, "-o", out, "--report", tmp_path / "report.json", says=["out.usda exists already"])
    assert not (tmp_path / "report.json").exists()


# Threads.


def test_threads_are_capped(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    start = time.monotonic()
    for number in (1000, 100_000, 10**15):
        done = good(usdtailor, "check", source, "--threads", number)
        assert re.search(rf"warning\[threads-capped\]: --threads {number}: \d+ threads are started, 4 for each of \d+ cores", done.stderr), done.stderr
    assert time.monotonic() - start < 30
    assert "threads-capped" not in good(usdtailor, "check", source, "--threads", 2).stderr
    assert good(usdtailor, "check", source, "--threads", 1000, "-q").stderr == ""


# Names.


@pytest.mark.parametrize("name", ["a\nb.usda", "a\tb.usda", "a\x01b.usda", "a\x7fb.usda", "a@@@b.usda"])
def test_a_name_that_no_layer_can_refer_to_is_refused(usdtailor, tmp_path, name):
    source = write(tmp_path / "in.usda").rename(tmp_path / name)
    refused(usdtailor, "build", source, "-o", tmp_path / "out.usda", says=["in its name", "rename the file or its folder"])
    assert not (tmp_path / "out.usda").exists()
    good(usdtailor, "build", source, "-o", tmp_path / "flat.usda", "--flatten")
    assert meshes(tmp_path / "flat.usda") == ["model", "render", "sim"]


@pytest.mark.parametrize("name", ["a b.usda", "a@b.usda", "a@@b.usda", "a'b\"c.usda", "a[1].usda", "ä.usda", "a#b%20.usda", "-a.usda", "a$HOME`b`.usda"])
@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_any_other_name_composes(usdtailor, tmp_path, name, suffix):
    source = write(tmp_path / "in.usda").rename(tmp_path / name)
    good(usdtailor, "build", source, "-o", tmp_path / f"out{suffix}")
    assert meshes(tmp_path / f"out{suffix}") == ["model", "render", "sim"]


@pytest.mark.parametrize("name", ["..usdc", ".a.usda", "a b.usdc", "a..usda", "a[1].usdc", "a:b.usda", "ä.usdc", "a@b.usda", "a?b#c%20.usdc", "<UDIM>.usda"])
def test_an_output_of_any_name_opens(usdtailor, tmp_path, name):
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", tmp_path / name)
    assert meshes(tmp_path / name) == ["model", "render", "sim"]


@pytest.mark.parametrize("name", ["a:SDF_FORMAT_ARGS:x=y.usda", "anon:a.usda", "a\\b.usda", "a\nb.usda"])
def test_a_name_by_which_no_program_opens_a_layer_is_refused(usdtailor, tmp_path, name):
    source = write(tmp_path / "in.usda")
    refused(usdtailor, "build", source, "-o", tmp_path / name, says=["in its path"])
    assert not (tmp_path / name).exists()
    if not name.startswith("anon:"):
        refused(usdtailor, "build", source.rename(tmp_path / name), "-o", tmp_path / "out.usda", says=["in its name", "rename the file"])
        assert not (tmp_path / "out.usda").exists()


# Files that are not files.


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path


@pytest.mark.parametrize("kind", ["pipe", "zero"])
def test_only_regular_files_are_read(usdtailor, tmp_path, pipe, kind):
    device = pipe if kind == "pipe" else "/dev/zero"
    links = {suffix: tmp_path / f"no{suffix}" for suffix in (".usda", ".usdc", ".usdz", ".tailor", ".npy", ".npz", ".png")}
    for link in links.values():
        link.symlink_to(device)
    source = write(tmp_path / "in.usda")
    out = tmp_path / "out.usda"
    for suffix in (".usda", ".usdc", ".usdz", ".tailor"):
        refused(usdtailor, "build", links[suffix], "-o", out, says=["not a regular file"], seconds=20)
    for suffix in (".usda", ".tailor"):
        refused(usdtailor, "build", source, "-o", out, "--recipe", links[suffix], says=["not a regular file"], seconds=20)
    good(usdtailor, "build", source, "-o", out)
    for suffix in (".usda", ".usdc", ".usdz", ".npy", ".npz"):
        refused(usdtailor, "drive", out, "--cache", links[suffix], "-o", tmp_path / "shot.usdc", says=["not a regular file"], seconds=20)
    for arc in ("references = @./no.usdc@</A>", "payload = @./no.usda@</A>", "references = @./no.usdz@</A>"):
        top = mounted(tmp_path / "top.usda", f'def "Coat" ({arc})\n{{\n}}\ndef "Other" (references = @./in.usda@</Coat>)\n{{\n asset look = @./no.usdz[a.png]@\n}}')
        done = subprocess.run([usdtailor, "build", top, "-o", tmp_path / "o.usda", "--force"], capture_output=True, text=True, timeout=20)
        assert done.returncode == 0 and "does not compose fully" in done.stderr, done.stderr
    textured = write(tmp_path / "textured.usda", finish=lambda mesh: mesh.GetPrim().CreateAttribute("look", Sdf.ValueTypeNames.Asset).Set("./no.png"))
    done = subprocess.run([usdtailor, "build", textured, "-o", tmp_path / "o.usdz"], capture_output=True, text=True, timeout=20)
    assert done.returncode == 0 and "cannot be packed: it is a pipe or a device" in done.stderr, done.stderr


def sparse(path, size):
    with open(path, "wb") as file:
        file.truncate(size)
    return path


def test_a_numpy_cache_is_bounded(usdtailor, tmp_path):
    garment, cache = tmp_path / "built.usda", tmp_path / "cache.npy"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    count = len(sim_points(garment))
    drive = ("drive", garment, "-o", tmp_path / "shot.usda", "--cache")
    frames = 10**10
    with open(cache, "wb") as file:
        numpy.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (frames, count, 3)})
        file.truncate(file.tell() + frames * count * 12)
    refused(usdtailor, *drive, cache, says=[f"it has {frames} frames", "at most 1000000"])

    points = io.BytesIO()
    numpy.save(points, numpy.zeros((2, count, 3), numpy.float32))
    times = 1 << 25
    with zipfile.ZipFile(tmp_path / "cache.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", points.getvalue())
        with archive.open("times.npy", "w") as file:
            numpy.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (times,)})
            for _ in range(times >> 17):
                file.write(bytes(8 << 17))
    assert (tmp_path / "cache.npz").stat().st_size < 1 << 20
    # Refused by the header: the numbers would take 600 MB.
    refused(usdtailor, *drive, tmp_path / "cache.npz", says=[f"it has {times} times", "at most 1000000"])


def test_a_shot_is_bounded_by_its_cache(usdtailor, tmp_path):
    garment, cache, shot = tmp_path / "built.usda", tmp_path / "cache.npy", tmp_path / "shot.usdc"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    points = sim_points(garment)
    frames = 1_000_000
    with open(cache, "wb") as file:
        numpy.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (frames, len(points), 3)})
        file.truncate(file.tell() + frames * points.size * 4)
    drive = ("drive", garment, "-o", shot, "--cache")
    done = refused(usdtailor, *drive, cache, says=["error[too-large]", f"its {frames} frames make a shot of", "--max-size"], seconds=20)
    # With a larger limit, the run goes on to the frames.
    size = re.search(r"--max-size \S+", done.stderr).group().split()
    refused(usdtailor, *drive, cache, *size, says=["error[cache-mismatch]"], seconds=20)
    numpy.save(cache, numpy.stack([points] * 8))
    refused(usdtailor, *drive, cache, "--max-size", "1k", says=["its 8 frames make a shot of"])
    assert not shot.exists()
    good(usdtailor, *drive, cache)
    assert shot.stat().st_size < 1 << 20


def test_records_are_followed_to_a_bound(usdtailor, tmp_path):
    out = tmp_path / "out.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", out)
    sparse(tmp_path / "sparse.usda", 200 << 30)
    sparse(tmp_path / "sparse.tailor", 200 << 30)
    os.mkfifo(tmp_path / "pipe")
    layer = Sdf.Layer.FindOrOpen(str(out))
    data = layer.customLayerData
    for file, words in [
        ("sparse.usda", "has changed"),
        ("pipe", "cannot be read any more"),
        ("/dev/zero", "cannot be read any more"),
        ("/proc/kmsg", "has changed"),
    ]:
        for size in (5, 200 << 30):
            data["tailor"]["build"].update(files=Vt.StringArray([file]), sizes=Vt.Int64Array([size]), hashes=Vt.StringArray(["0" * 64]))
            layer.customLayerData = data
            layer.Save()
            refused(usdtailor, "check", out, says=[f"{file} {words}"], seconds=10)
    request = json.loads(data["tailor"]["build"]["request"])
    data["tailor"]["build"]["request"] = json.dumps({**request, "recipe": "./sparse.tailor"})
    layer.customLayerData = data
    layer.Save()
    refused(usdtailor, "check", out, says=["sparse.tailor", "it is larger than 256 MB"], seconds=10)


@pytest.mark.parametrize("start", [b"", b"#usda 1.0\n", b"PXR-USDC\x00\x08\x00"])
def test_a_layer_beyond_the_memory_is_refused(usdtailor, tmp_path, start):
    file = tmp_path / "in.usd"
    file.write_bytes(start)
    os.truncate(file, 1 << 43)
    refused(usdtailor, "check", file, says=["it is larger than the memory"], seconds=20)


def test_a_package_takes_only_files_of_stages_and_lists_them(usdtailor, tmp_path):
    (tmp_path / "id_rsa").write_text("secret words")
    (tmp_path / "cloth.png").write_text("a picture")

    def finish(mesh):
        for name, path in {"key": "./id_rsa", "host": "/etc/hostname", "look": "./cloth.png"}.items():
            mesh.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Asset).Set(path)

    source = write(tmp_path / "in.usda", finish=finish)
    done = good(usdtailor, "build", source, "-o", tmp_path / "o.usdz", "-v", "--report", tmp_path / "o.json")
    assert f"packed  {tmp_path / 'cloth.png'}\n" in done.stdout
    assert done.stdout.count("packed") == 1
    assert "id_rsa" in done.stderr and "cannot be packed" in done.stderr
    content = (tmp_path / "o.usdz").read_bytes()
    assert b"a picture" in content and b"secret words" not in content
    assert json.loads((tmp_path / "o.json").read_text())["packed"] == [str(tmp_path / "cloth.png")]


# Bounds.


def test_names_of_a_recipe_are_given_once(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda", finish=lambda mesh: add_subset(mesh, name="hem", indices=[0, 1]))
    recipe = tmp_path / "r.tailor"
    recipe.write_text('{"fold": {"hem": {"faces": ["hem"], "thickness": 0.1},\n "hem": {"thickness": 0.2}}}')
    refused(usdtailor, "check", source, "--recipe", recipe, says=["the name `hem` is given twice at line 2"])


def test_many_seams_are_refused(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    recipe = tmp_path / "r.tailor"
    recipe.write_text(json.dumps({"seam": {f"s{i}": {"edges": ["e"]} for i in range(100_000)}}))
    refused(usdtailor, "check", source, "--recipe", recipe, says=["seam: there are 100000"], seconds=30)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
@pytest.mark.parametrize("command", ["build", "info", "--help"])
def test_a_full_standard_output_is_told(usdtailor, tmp_path, command):
    source = write(tmp_path / "in.usda")
    args = {"build": ["build", source, "-o", tmp_path / "out.usda"], "info": ["info", source], "--help": ["--help"]}[command]
    with open("/dev/full", "w") as full:
        done = subprocess.run([usdtailor, *args], stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert "cannot write to standard output: the disk is full" in done.stderr
