"""The Python package as pip installs it: the command, the functions, and the plugin for each tested usd-core.

`cargo xtask test package` makes the package and runs this in an environment that has it.
"""

import importlib.metadata
import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy
import pytest
import usd_tailor
from pxr import Sdf, Usd, UsdGeom

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WHEEL = Path(os.environ["USDTAILOR_WHEEL"])
COMMAND = Path(sys.executable).with_name("usdtailor")
# Of each tested version of usd-core: its interpreter.
PYTHONS = dict(line.split("=")[:2] for line in os.environ["USDTAILOR_PLUGINS"].split(";"))
SITE = Path(usd_tailor.__file__).parents[1]
MEGABYTE = 1 << 20


def mesh(stage, path):
    return UsdGeom.Mesh(stage.GetPrimAtPath(path))


def points(stage, path):
    return numpy.array(mesh(stage, path).GetPointsAttr().Get())


def bare(program, *args, **variables):
    """Runs a program with nothing of a developer on its path."""
    env = {"PATH": "/usr/bin:/bin", "HOME": "/nonexistent", **variables}
    return subprocess.run([program, *args], env=env, capture_output=True, text=True, check=False, timeout=300)


# The file.


def test_the_rust_code_is_there_once_and_the_package_is_small():
    with zipfile.ZipFile(WHEEL) as wheel:
        sizes = {info.filename: info.file_size for info in wheel.infolist()}
    assert WHEEL.stat().st_size < 20 * MEGABYTE
    large = [name for name, size in sizes.items() if size > MEGABYTE]
    assert large == ["usd_tailor/_native/libusdtailor_core.so"]
    versions = {Path(name).parts[2] for name in sizes if name.endswith("libusdTailor.so")}
    assert versions == set(PYTHONS)
    assert {f"usd_tailor/plugin/{version}/libusdTailorFormat.so" for version in PYTHONS} <= set(sizes)
    assert WHEEL.name.endswith("-py3-none-manylinux_2_28_x86_64.whl")
    assert "usd_tailor/py.typed" in sizes


def test_messages_of_the_plugin_name_no_place_of_the_machine_that_built_it():
    root = os.fsencode(Path(__file__).resolve().parents[2])
    with zipfile.ZipFile(WHEEL) as wheel:
        for name in (n for n in wheel.namelist() if n.endswith("libusdTailorFormat.so")):
            code = wheel.read(name)
            assert root not in code and b"usd_plugin/" in code, name


def test_no_library_is_for_one_version_of_python():
    """The libraries of usd-core have names of their own in the wheel of each version of Python."""
    for library in (SITE / "usd_tailor").rglob("*.so"):
        needed = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout
        assert "libusd_" not in needed and "libpython" not in needed, library


def test_the_metadata_names_the_version_of_the_program():
    version = importlib.metadata.version("usd-tailor")
    assert bare(COMMAND, "--version").stdout == f"usdtailor {version}\n" == f"usdtailor {usd_tailor.__version__}\n"


def test_the_metadata_has_no_relative_links():
    text = importlib.metadata.metadata("usd-tailor").get_payload()
    links = re.findall(r"\]\(([^)]*)\)", text)
    assert "usdtailor" in text and not [link for link in links if "://" not in link], links


# The command.


def test_the_command_builds_without_rust_and_without_usd_core(tmp_path):
    venv = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    subprocess.run([venv / "bin/pip", "install", "--quiet", "--no-index", "--no-deps", WHEEL], check=True)
    done = bare(venv / "bin/usdtailor", "build", EXAMPLES / "tshirt.usda", "-o", tmp_path / "out.usda")
    assert done.returncode == 0, done.stderr
    assert mesh(Usd.Stage.Open(str(tmp_path / "out.usda")), "/Tshirt/render")
    refused = bare(venv / "bin/usdtailor", "plugin-path")
    assert refused.returncode == 1 and "usd-core is not installed" in refused.stderr


@pytest.mark.parametrize("start", [[COMMAND], [sys.executable, "-m", "usd_tailor"]], ids=["script", "module"])
def test_exit_codes_are_those_of_the_program(start):
    assert bare(*start, "build", "absent.usda", "-o", "out.usda").returncode == 1
    assert bare(*start, "bild").returncode == 2


def test_a_closed_pipe_is_quiet():
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {COMMAND} explain | head -1"], capture_output=True, text=True, check=False)
    assert done.stderr == "" and done.stdout.count("\n") == 1


# Packages that are unpacked without the right to run their program, as by Blender.


@pytest.fixture
def unpacked(tmp_path):
    """The folder of an unpacked package whose program may not be run."""
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(WHEEL) as wheel:
        wheel.extractall(folder)
    program = folder / "usd_tailor/_native/usdtailor"
    program.chmod(0o640)
    return folder


def in_package(folder, text, **variables):
    """Runs a Python program with the package of a folder."""
    return bare(sys.executable, "-P", "-c", "import usd_tailor; from usd_tailor import _command\n" + text, PYTHONPATH=str(folder), **variables)


def test_a_program_gets_the_right_to_run_for_those_who_may_read_it(unpacked, tmp_path):
    out = tmp_path / "out.usda"
    done = in_package(unpacked, f"usd_tailor.build({str(EXAMPLES / 'tshirt.usda')!r}, {str(out)!r})")
    assert done.returncode == 0, done.stderr
    assert mesh(Usd.Stage.Open(str(out)), "/Tshirt/render")
    assert (unpacked / "usd_tailor/_native/usdtailor").stat().st_mode & 0o777 == 0o750


# A package of somebody else. Root may change that too, so it is refused here.
REFUSES = """
from pathlib import Path
chmod = Path.chmod
def refuse(path, mode):
    if path == _command.PROGRAM:
        raise PermissionError(1, "Operation not permitted")
    chmod(path, mode)
Path.chmod = refuse
"""


@pytest.mark.parametrize("call", ["usd_tailor.options()", "import sys; sys.argv = ['usdtailor', 'options']; _command.main()"], ids=["module", "script"])
def test_a_program_of_a_folder_that_cannot_be_changed_runs_as_a_copy(call, unpacked, tmp_path):
    copies = tmp_path / "copies"
    copies.mkdir()
    done = in_package(unpacked, REFUSES + call, TMPDIR=str(copies))
    assert done.returncode == 0, done.stderr
    assert not list(copies.iterdir())
    assert (unpacked / "usd_tailor/_native/usdtailor").stat().st_mode & 0o777 == 0o640


def test_a_program_that_cannot_run_is_told_with_its_place_and_a_remedy(unpacked, tmp_path):
    program = unpacked / "usd_tailor/_native/usdtailor"
    place = str(program.parent)
    noexec = "import os; os.access = lambda path, mode: False\n"
    faults = {
        noexec: [place, "noexec", "Install usd-tailor in another folder"],
        REFUSES + noexec: [str(tmp_path), "noexec", "set TMPDIR"],
        REFUSES + "import tempfile; tempfile.tempdir = '/nonexistent'\n": [place, "/nonexistent", "set TMPDIR"],
        "_command.PROGRAM.unlink()\n": [place, "No such file", "Install the package usd-tailor again"],
    }
    for fault, words in faults.items():
        program.chmod(0o640)
        done = in_package(unpacked, fault + "usd_tailor.options()", TMPDIR=str(tmp_path))
        assert done.returncode == 1 and "TailorError" in done.stderr, done.stderr
        assert not [word for word in words if word not in done.stderr], done.stderr
    done = in_package(unpacked, "_command.main()")
    assert done.returncode == 1 and done.stderr.startswith("error: ") and "Traceback" not in done.stderr


INTERRUPTED = """
import os, signal, subprocess, threading, time
# A shell in the background ignores the signal, and what it starts does so too.
signal.signal(signal.SIGINT, signal.default_int_handler)
pid = _command.PROGRAM.with_name("pid")
def interrupt():
    while not (pid.exists() and pid.read_text()):
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)
class Slow(subprocess.Popen):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        interrupt()
_command.PROGRAM.write_text(f"#!/bin/sh\\ntrap '' INT\\necho $$ > {pid}\\nexec sleep 60\\n")
if while_it_starts:
    subprocess.Popen = Slow
else:
    threading.Thread(target=interrupt).start()
try:
    usd_tailor.options()
except KeyboardInterrupt:
    try:
        os.kill(int(pid.read_text()), 0)
    except ProcessLookupError:
        print("gone")
"""


@pytest.mark.parametrize("while_it_starts", [True, False])
def test_an_interrupted_call_leaves_no_process(unpacked, while_it_starts):
    done = in_package(unpacked, f"while_it_starts = {while_it_starts}\n{INTERRUPTED}")
    assert (done.returncode, done.stdout) == (0, "gone\n"), done.stderr


# The functions.


def test_options_are_those_of_the_command():
    groups = usd_tailor.options()
    assert groups == json.loads(bare(COMMAND, "options").stdout)
    [sim] = [group for group in groups if group["name"] == "sim"]
    assert {"key", "domain", "meaning", "default"} <= set(sim["options"][0])


def test_a_build_of_a_file_writes_what_the_command_writes(tmp_path):
    made = usd_tailor.build(EXAMPLES / "tshirt.usda", tmp_path / "python.usda", options={"render.level": 2, "sim.maxEdgeLength": "3cm"})
    options = ["--set", "render.level=2", "--set", "sim.maxEdgeLength=3cm"]
    assert bare(COMMAND, "build", EXAMPLES / "tshirt.usda", "-o", tmp_path / "command.usda", *options).returncode == 0
    assert (tmp_path / "python.usda").read_bytes() == (tmp_path / "command.usda").read_bytes()
    assert made.layer.realPath == str(tmp_path / "python.usda")
    assert made.report["recipe"]["render"]["level"] == 2
    assert made.report["recipe"]["sim"]["maxEdgeLength"] == pytest.approx(3)


def test_a_file_is_built_without_usd_core(tmp_path):
    garment, out = EXAMPLES / "tshirt.usda", tmp_path / "out.usda"
    text = f"import sys; sys.modules['pxr'] = None; import usd_tailor; print(usd_tailor.build({str(garment)!r}, {str(out)!r}).layer)"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "None"), done.stderr
    assert Usd.Stage.Open(str(out)).GetPrimAtPath("/Tshirt/render")


def test_options_may_be_nested_as_in_a_recipe(tmp_path):
    nested = {"sim": {"maxEdgeLength": "3cm", "constraints": ["hem_stitch"]}, "seam": {"side": {"edges": ["side_seams"], "width": 0.6}}, "render.level": 2}
    recipe = usd_tailor.build(EXAMPLES / "tshirt.usda", tmp_path / "nested.usda", options=nested).report["recipe"]
    assert recipe["sim"]["maxEdgeLength"] == pytest.approx(3) and recipe["sim"]["constraints"] == ["hem_stitch"]
    assert recipe["seam"]["side"]["width"] == pytest.approx(0.6) and recipe["render"]["level"] == 2


def test_a_file_is_written_again_only_by_force_and_the_layer_follows(tmp_path):
    output = tmp_path / "out.usda"
    first = usd_tailor.build(EXAMPLES / "tshirt.usda", output)
    stage = Usd.Stage.Open(first.layer)
    before = len(points(stage, "/Tshirt/render"))
    with pytest.raises(usd_tailor.TailorError, match="--force"):
        usd_tailor.build(EXAMPLES / "tshirt.usda", output)
    usd_tailor.build(EXAMPLES / "tshirt.usda", output, options={"render.level": 3}, force=True)
    assert len(points(stage, "/Tshirt/render")) > 3 * before


def test_a_build_of_a_stage_takes_its_edits_and_returns_a_layer_for_it():
    stage = Usd.Stage.Open(str(EXAMPLES / "tshirt.usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    model = mesh(stage, "/Tshirt/model")
    moved = points(stage, "/Tshirt/model") + [0, 100, 0]
    model.GetPointsAttr().Set(moved)
    built = usd_tailor.build(stage, options={"sim.constraints": ["hem_stitch"], "sim.provenance": True})
    assert built.layer.anonymous and not built.layer.subLayerPaths
    assert "tailor" not in built.layer.customLayerData
    assert built.report["recipe"]["sim"]["constraints"] == ["hem_stitch"] and built.report["recipe"]["sim"]["provenance"]

    stage.GetSessionLayer().subLayerPaths.append(built.layer.identifier)
    sim, low = points(stage, "/Tshirt/sim"), moved.min(axis=0)
    assert abs(sim.min(axis=0) - low).max() < 2, "it is where the edited model is"
    assert model.GetPurposeAttr().Get() == "guide"
    # The layer has opinions on the model, and no copy of it.
    assert built.layer.GetPrimAtPath("/Tshirt/model").specifier == Sdf.SpecifierOver


def test_faults_are_raised_with_their_exit_code(tmp_path):
    with pytest.raises(usd_tailor.TailorError, match="maxEdgeLenght.*\n.*maxEdgeLength") as caught:
        usd_tailor.build(EXAMPLES / "tshirt.usda", tmp_path / "out.usda", options={"sim.maxEdgeLenght": 2})
    assert caught.value.exit_code == 2
    with pytest.raises(usd_tailor.TailorError) as caught:
        usd_tailor.info(tmp_path / "absent.usda")
    assert caught.value.exit_code == 1 and "absent.usda" in str(caught.value)
    assert not list(tmp_path.iterdir())
    with pytest.raises(TypeError, match="output"):
        usd_tailor.build(EXAMPLES / "tshirt.usda")
    with pytest.raises(TypeError, match="Export"):
        usd_tailor.build(Usd.Stage.CreateInMemory(), tmp_path / "out.usda")


def test_info_and_check_are_those_of_the_command():
    for function, name in ((usd_tailor.info, "info"), (usd_tailor.check, "check")):
        printed = json.loads(bare(COMMAND, name, EXAMPLES / "coat.usda", "--json").stdout)
        assert function(EXAMPLES / "coat.usda") == printed
    [found] = usd_tailor.info(Usd.Stage.Open(str(EXAMPLES / "coat.usda")))["inputs"]
    [expected] = printed["inputs"]
    assert "warnings" in found and "warnings" in expected


def test_a_check_tells_the_fault_of_a_garment_and_does_not_raise_it(tmp_path):
    stage = Usd.Stage.CreateInMemory()
    model = UsdGeom.Mesh.Define(stage, "/Asset/model")
    model.GetFaceVertexCountsAttr().Set([4])
    model.GetFaceVertexIndicesAttr().Set([0, 1, 2, 9])
    model.GetPointsAttr().Set([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    [found] = usd_tailor.check(stage)["inputs"]
    assert "/Asset/model" in json.dumps(found["error"])


def test_a_garment_is_fitted_to_another_body(tmp_path):
    for name, scale in (("body", 1), ("large", 1.2)):
        stage = Usd.Stage.CreateNew(str(tmp_path / f"{name}.usda"))
        stage.GetRootLayer().subLayerPaths = [str(EXAMPLES / "tshirt.usda")]
        UsdGeom.SetStageUpAxis(stage, "Y")
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        mesh = UsdGeom.Mesh(stage.OverridePrim("/Tshirt/model"))
        mesh.GetPointsAttr().Set([scale * 0.97 * (p - (0, 110, 0)) + (0, 110, 0) for p in mesh.GetPointsAttr().Get()])
        stage.Save()
    made = usd_tailor.fit(EXAMPLES / "tshirt.usda", tmp_path / "body.usda", tmp_path / "large.usda", tmp_path / "out.usda", keep_length=["borders.lowest"])
    assert made.report["status"] == "fitted" and made.report["garments"][0]["bodyCrossings"]["new"] == 0
    stages = [Usd.Stage.Open(str(path)) for path in (EXAMPLES / "tshirt.usda", made.layer.realPath)]
    before, after = (UsdGeom.Mesh(stage.GetPrimAtPath("/Tshirt/model")).GetExtentAttr().Get() for stage in stages)
    assert (after[1] - after[0])[0] > 1.1 * (before[1] - before[0])[0]


def test_a_cache_drives_the_render_mesh(tmp_path):
    built = usd_tailor.build(EXAMPLES / "tshirt.usda", tmp_path / "garment.usda")
    stage = Usd.Stage.Open(built.layer)
    rest, sim = points(stage, "/Tshirt/render"), points(stage, "/Tshirt/sim")
    numpy.savez(tmp_path / "cache.npz", points=numpy.stack([sim, sim + [0, 5, 0]]))
    shot = Usd.Stage.Open(usd_tailor.drive(tmp_path / "garment.usda", tmp_path / "cache.npz", tmp_path / "shot.usda"))
    first, second = mesh(shot, "/Tshirt/render").GetPointsAttr().GetTimeSamples()
    moved = numpy.array(mesh(shot, "/Tshirt/render").GetPointsAttr().Get(second))
    assert abs(moved - rest - [0, 5, 0]).max() < 1e-3 and second - first == 1


# The plugin.

OPENS = """
import sys
import usd_tailor
path = usd_tailor.plugin_path()
assert not [name for name in sys.modules if name.split(".")[0] == "pxr"], "plugin_path imports nothing of pxr"
usd_tailor.register()
from pxr import Usd
stage = Usd.Stage.Open(sys.argv[1])
assert stage.GetPrimAtPath("/Tshirt/render").GetTypeName() == "Mesh"
assert Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("TailorClothAPI"), "the schemas come along"
print(path)
"""


@pytest.fixture
def recipe(tmp_path):
    path = tmp_path / "shirt.tailor"
    path.write_text(json.dumps({"source": str(EXAMPLES / "tshirt.usda")}))
    return path


@pytest.fixture
def alone(tmp_path):
    """A folder with the package and without the usd-core that is beside it."""
    folder = tmp_path / "alone"
    folder.mkdir()
    for path in SITE.glob("usd_tailor*"):
        (folder / path.name).symlink_to(path)
    return str(folder)


@pytest.mark.parametrize("version", PYTHONS)
def test_each_usd_core_has_its_plugin(version, recipe, alone):
    done = bare(PYTHONS[version], "-P", "-c", OPENS, recipe, PYTHONPATH=alone)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().endswith(f"/usd_tailor/plugin/{version}")


def test_the_printed_path_serves_hosts(recipe):
    path = bare(COMMAND, "plugin-path").stdout.strip()
    opens = "import sys; from pxr import Usd; stage = Usd.Stage.Open(sys.argv[1]); assert stage.GetPrimAtPath('/Tshirt/sim')"
    done = bare(sys.executable, "-P", "-c", opens, recipe, PXR_PLUGINPATH_NAME=path)
    assert done.returncode == 0, done.stderr
    without = bare(sys.executable, "-P", "-c", opens, recipe)
    assert without.returncode == 1, "without the plugin, nothing reads the file"


FOLLOWS = """
import sys
import usd_tailor
usd_tailor.register()
from pxr import Sdf, Tf, Usd
stage = Usd.Stage.CreateInMemory()
prim = stage.DefinePrim("/Shirt")
prim.GetPayloads().AddPayload(sys.argv[1])
count = lambda: len(stage.GetPrimAtPath("/Shirt/render").GetAttribute("points").Get())
before = count()
prim.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(3)
assert count() > 3 * before
prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float).Set(1e20)
try:
    Sdf.Layer.FindOrOpen(sys.argv[1].replace("shirt", "bad"))
except Tf.ErrorException as error:
    assert "line 1" in str(error)
else:
    raise AssertionError("a fault in Rust reaches OpenUSD as an error")
"""


def test_a_payload_follows_an_attribute_and_faults_pass_the_libraries(recipe):
    recipe.with_name("bad.tailor").write_text("{")
    done = bare(sys.executable, "-P", "-c", FOLLOWS, recipe)
    assert done.returncode == 0, done.stderr


def test_a_late_registration_is_told():
    late = "import usd_tailor; from pxr import Sdf; Sdf.Layer.CreateAnonymous(); usd_tailor.register()"
    done = bare(sys.executable, "-P", "-c", late)
    assert done.returncode == 1 and "Call usd_tailor.register() first" in done.stderr


@pytest.mark.parametrize("version", ["23.11", "99.1"])
def test_a_version_without_plugin_is_told(version, tmp_path):
    known = tmp_path / f"usd_core-{version}.dist-info"
    known.mkdir()
    (known / "METADATA").write_text(f"Metadata-Version: 2.1\nName: usd-core\nVersion: {version}\n")
    done = bare(sys.executable, "-P", "-m", "usd_tailor", "plugin-path", PYTHONPATH=str(tmp_path))
    assert done.returncode == 1
    assert f"no plugin for usd-core {version}" in done.stderr and f"has one for: {', '.join(PYTHONS)}." in done.stderr
