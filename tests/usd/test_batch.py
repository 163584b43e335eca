"""Many garments in one run: bad ones among them, a run that was cut off, and outputs that are fresh."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from conftest import EXAMPLES
from conftest import run as run_program
from pxr import Sdf, Usd

GARMENT = """#usda 1.0
(
    defaultPrim = "G"
    metersPerUnit = 0.01
)
def Xform "G"
{{
    def Mesh "model"
    {{
        point3f[] points = [{points}]
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{indices}]
    }}
}}
"""


def sheet(width, height, side=6):
    """The text of a sheet of quads."""
    points = [(x * width / side, y * height / side, 0) for y in range(side + 1) for x in range(side + 1)]
    corner = [y * (side + 1) + x for y in range(side) for x in range(side)]
    indices = [i for c in corner for i in (c, c + 1, c + side + 2, c + side + 1)]
    text = lambda values: ", ".join(map(str, values))  # noqa: E731
    return GARMENT.format(points=text(points), counts=text([4] * len(corner)), indices=text(indices))


@pytest.fixture
def run(usdtailor):
    """`run(...)` runs `usdtailor build`, whatever its exit code."""
    return lambda *arguments: run_program(usdtailor, "build", *arguments)


def garments(folder, count, bad=()):
    files = []
    for i in range(count):
        file = folder / f"g{i:03}.usda"
        text = sheet(10 + i % 7, 20 + i % 5)
        file.write_text(text if i not in bad else text.replace("(0.0, 0.0, 0)", "(nan, 0, 0)"))
        files.append(file)
    return files


def stored(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_a_bad_garment_does_not_stop_the_others_and_is_in_the_report(run, tmp_path):
    files = garments(tmp_path, 12, bad=(3, 7))
    out = tmp_path / "out"
    out.mkdir()
    result = run(*files, "-o", out, "--report", tmp_path / "report.json", "--jobs", 3)
    assert result.returncode == 1
    builds = json.loads((tmp_path / "report.json").read_text())["builds"]
    assert [build["input"] for build in builds] == [str(file) for file in files]
    failed = [build for build in builds if build["status"] == "failed"]
    assert [build["input"] for build in failed] == [str(files[3]), str(files[7])]
    assert all("points" in build["error"]["message"] and build["error"]["faults"] for build in failed)
    assert len(list(out.iterdir())) == 10
    assert "12 inputs: 10 built, 0 fresh, 2 failed" in result.stdout
    assert str(files[3]) in result.stderr and str(files[7]) in result.stderr


def test_the_number_of_jobs_does_not_change_a_byte(run, tmp_path):
    files = garments(tmp_path, 6)
    for jobs in (1, 4):
        (tmp_path / f"out{jobs}").mkdir()
        assert run(*files, "-o", tmp_path / f"out{jobs}", "--jobs", jobs).returncode == 0
    one, four = (stored(tmp_path / f"out{jobs}") for jobs in (1, 4))
    assert {name: text.replace(b"out1", b"out4") for name, text in one.items()} == four


def test_fresh_outputs_are_left_and_stale_ones_are_built(run, tmp_path):
    files = garments(tmp_path, 4)
    out = tmp_path / "out"
    out.mkdir()
    assert run(*files, "-o", out).returncode == 0
    times = {file.name: file.stat().st_mtime_ns for file in out.iterdir()}
    files[2].write_text(sheet(3, 5))
    result = run(*files, "-o", out, "--skip-fresh", "--force")
    assert "1 built, 3 fresh" in result.stdout
    now = {file.name: file.stat().st_mtime_ns for file in out.iterdir()}
    assert [name for name in now if now[name] != times[name]] == ["g002_tailored.usdc"]


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(["--set", "sim.maxEdgeLength=1.1"], id="option"),
        pytest.param(["--flatten"], id="flatten"),
        pytest.param(["--sim-name", "cloth"], id="name"),
        pytest.param(["--keep-model-purpose"], id="purpose"),
        pytest.param(["--physics", "none"], id="physics"),
        pytest.param(["--time", "3"], id="time"),
    ],
)
def test_another_option_makes_an_output_stale(run, tmp_path, change):
    file = garments(tmp_path, 1)[0]
    out = tmp_path / "out.usda"
    assert run(file, "-o", out).returncode == 0
    assert "fresh" in run(file, "-o", out, "--skip-fresh", "--force").stdout
    assert "fresh" not in run(file, "-o", out, "--skip-fresh", "--force", *change).stdout
    assert "fresh" in run(file, "-o", out, "--skip-fresh", "--force", *change).stdout


def test_a_recipe_and_a_layer_below_make_an_output_stale(run, tmp_path):
    below = garments(tmp_path, 1)[0]
    file = tmp_path / "over.usda"
    file.write_text('#usda 1.0\n(\n    defaultPrim = "G"\n    subLayers = [@./g000.usda@]\n)\n')
    recipe = tmp_path / "r.tailor"
    recipe.write_text('{"render": {"level": 1}}')
    out = tmp_path / "out.usda"
    arguments = (file, "-o", out, "--skip-fresh", "--force", "--recipe", recipe)
    run(*arguments)
    assert "fresh" in run(*arguments).stdout
    recipe.write_text('{"render": {"level": 0}}')
    assert "fresh" not in run(*arguments).stdout
    assert "fresh" in run(*arguments).stdout
    below.write_text(sheet(2, 2))
    assert "fresh" not in run(*arguments).stdout
    assert "fresh" in run(*arguments).stdout


def test_an_output_is_fresh_after_its_folder_moved(run, tmp_path):
    (tmp_path / "a").mkdir()
    file = garments(tmp_path / "a", 1)[0]
    assert run(file, "-o", tmp_path / "a" / "out.usda").returncode == 0
    (tmp_path / "a").rename(tmp_path / "b")
    moved = tmp_path / "b" / file.name
    assert "fresh" in run(moved, "-o", tmp_path / "b" / "out.usda", "--skip-fresh").stdout


def test_the_record_is_in_the_layers_own_data(run, tmp_path):
    out = tmp_path / "coat.usda"
    assert run(EXAMPLES / "coat.usda", "-o", out).returncode == 0
    record = Sdf.Layer.FindOrOpen(str(out)).customLayerData["tailor"]["build"]
    assert record["prim"] == "/Coat/model" and record["version"]
    assert [name.rsplit("/")[-1] for name in record["files"]] == ["coat.usda"]
    assert all(len(digest) == 64 for digest in record["hashes"])
    assert list(record["sizes"]) == [(EXAMPLES / "coat.usda").stat().st_size]


def test_a_run_that_was_killed_goes_on_where_it_was(run, usdtailor, tmp_path):
    bad = {11, 50, 99, 150, 199}
    files = garments(tmp_path, 200, bad)
    out = tmp_path / "out"
    out.mkdir()
    arguments = [*files, "-o", out, "--skip-fresh", "--force"]
    child = subprocess.Popen([str(usdtailor), "build", *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while len(list(out.glob("g*.usdc"))) < 60 and child.poll() is None:
        time.sleep(0.01)
    child.send_signal(signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL, "it ended before it was killed"
    done = len(list(out.glob("g*.usdc")))
    assert 60 <= done < 195
    result = run(*arguments, "--report", tmp_path / "report.json")
    assert result.returncode == 1
    builds = json.loads((tmp_path / "report.json").read_text())["builds"]
    states = [build["status"] for build in builds]
    assert states.count("fresh") == done and states.count("built") == 195 - done
    assert {i for i, state in enumerate(states) if state == "failed"} == bad
    assert len(list(out.glob("g*.usdc"))) == 195
    for file in out.glob("g*.usdc"):
        assert Usd.Stage.Open(str(file)).GetPrimAtPath("/G/sim")


def test_garments_that_need_more_than_the_memory_are_built_one_at_a_time(run, tmp_path):
    files = garments(tmp_path, 4)
    out = tmp_path / "out"
    out.mkdir()
    refused = run(*files, "-o", out, "--max-memory", "1K")
    assert refused.returncode == 1 and not list(out.iterdir())
    assert refused.stderr.count("--max-memory") == 4
    assert run(*files, "-o", out, "--max-memory", "50M", "--jobs", 4).returncode == 0


@pytest.mark.parametrize("option", ["sim.baselineLevel=6", "render.level=6", "sim.maxEdgeLength=0.002"])
def test_a_build_beyond_the_memory_is_refused_before_work(run, tmp_path, option):
    arguments = ["--set", option, *(["--set", "sim.minEdgeLength=0.002"] if "Edge" in option else [])]
    start = time.monotonic()
    result = run(
        EXAMPLES / "coat.usda", "-o", tmp_path / "out.usdc", "--max-memory", "500M", "--max-faces", 10**12, *arguments
    )
    assert result.returncode == 1 and time.monotonic() - start < 10
    assert option.split("=")[0] in result.stderr and "--max-memory" in result.stderr and "GB" in result.stderr
    assert not list(tmp_path.iterdir())


PEAK = """
import os, sys
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, usage = os.wait4(child, 0)
print(status, usage.ru_maxrss)
"""


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="no peak memory of a child on this system")
@pytest.mark.parametrize("options", [("render.level=4",), ("sim.baselineLevel=4",), ("render.level=3", "sim.baselineLevel=3")])
def test_the_estimate_is_within_a_factor_of_two(usdtailor, tmp_path, options):
    """A limit of half the peak memory is refused, and one of twice is not."""
    arguments = [EXAMPLES / "coat.usda", *(text for option in options for text in ("--set", option))]

    def peak(*more):
        command = [str(usdtailor), "build", *map(str, arguments), "-o", str(tmp_path / "out.usdc"), "--force", *map(str, more)]
        # From a small process: a child begins with the peak of its parent.
        measured = subprocess.run([sys.executable, "-c", PEAK, *command], capture_output=True, text=True, check=True)
        status, peak = measured.stdout.split()[-2:]
        return int(status), int(peak) * 1024

    status, most = peak("--quiet")
    assert status == 0
    assert peak("--max-memory", most // 2)[0] != 0
    assert peak("--max-memory", most * 2)[0] == 0


def crowd(quads):
    """Quads in one place, each with points of its own."""
    corners = ", ".join(["(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)"] * quads)
    counts, indices = ", ".join(["4"] * quads), ", ".join(map(str, range(4 * quads)))
    return f"""#usda 1.0
(
    defaultPrim = "G"
)
def Xform "G"
{{
    def Mesh "model"
    {{
        point3f[] points = [{corners}]
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{indices}]
    }}
}}
"""


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="no peak memory of a child on this system")
@pytest.mark.parametrize("kind, limit", [("crowd", 300), ("seams", 200)])
def test_a_build_that_takes_more_than_its_estimate_ends_at_the_limit(usdtailor, tmp_path, kind, limit):
    garment = tmp_path / "in.usda"
    garment.write_text(crowd(8000) if kind == "crowd" else sheet(50, 50, side=50))
    command = [usdtailor, "build", garment, "-o", tmp_path / "out.usdc", "--max-memory", f"{limit}M"]
    command += ["--set", "seam.a.edges=edges"] if kind == "seams" else []
    measured = subprocess.run(
        [sys.executable, "-c", PEAK, *map(str, command)], capture_output=True, text=True, check=True
    )
    status, peak = map(int, measured.stdout.split()[-2:])
    assert os.waitstatus_to_exitcode(status) == 1 and peak * 1024 < 1.25 * limit * 2**20
    assert "too-large" in measured.stderr and "--max-memory" in measured.stderr
    assert not (tmp_path / "out.usdc").exists()


def test_builds_that_pass_the_limit_together_are_built_alone(usdtailor, run, tmp_path):
    files = [tmp_path / f"coat{i}.usda" for i in range(6)]
    for file in files:
        file.write_bytes((EXAMPLES / "coat.usda").read_bytes())
    out = tmp_path / "out"
    result = run(*files, "-o", out, "--max-memory", "160M", "--jobs", 6, "--quiet")
    assert result.returncode == 0, result.stderr
    assert len(list(out.glob("*.usdc"))) == 6


@pytest.mark.skipif(sys.platform != "linux", reason="ulimit -v")
def test_jobs_fit_into_little_address_space(usdtailor, tmp_path):
    files = garments(tmp_path, 20)
    command = ["sh", "-c", 'ulimit -v 2000000; exec "$@"', "sh", usdtailor, "build", *files, "-o", tmp_path / "out", "--jobs", "8"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    command[2] = 'ulimit -v 60000; exec "$@"'
    done = subprocess.run([*map(str, command), "--force"], capture_output=True, text=True, check=False)
    assert "internal error" not in done.stderr


VARIANTS = """#usda 1.0
(
    defaultPrim = "G"
)
def Xform "G" (
    variants = { string size = "S" }
    prepend variantSets = "size"
)
{
    variantSet "size" = {
        "S" ( prepend references = @./g000.usda@ ) {
        }
        "L" ( prepend references = @./g001.usda@ ) {
        }
    }
}
"""


def test_check_tells_fresh_from_stale_and_why(usdtailor, tmp_path):
    def check(file):
        return run_program(usdtailor, "check", file)

    file = garments(tmp_path, 1)[0]
    out = tmp_path / "out.usda"
    assert run_program(usdtailor, "build", file, "-o", out).returncode == 0
    assert check(out).stdout.endswith("good, and fresh\n")
    assert check(file).stdout.endswith("good\n")
    file.write_text(sheet(2, 9))
    stale = check(out)
    assert stale.returncode == 1 and "stale" in stale.stderr and "g000.usda has changed" in stale.stderr


def test_products_of_another_variant_are_stale(usdtailor, tmp_path):
    garments(tmp_path, 2)
    source, out, shot = (tmp_path / name for name in ("sizes.usda", "out.usda", "shot.usda"))
    source.write_text(VARIANTS)
    assert run_program(usdtailor, "build", source, "-o", out).returncode == 0
    shot.write_text('#usda 1.0\n(\n    defaultPrim = "G"\n    subLayers = [@./out.usda@]\n)\nover "G" (\n    variants = { string size = "L" }\n)\n{\n}\n')
    assert run_program(usdtailor, "check", out).stdout.endswith("good, and fresh\n")
    stale = run_program(usdtailor, "check", shot)
    assert stale.returncode == 1 and "/G{size=L}" in stale.stderr
