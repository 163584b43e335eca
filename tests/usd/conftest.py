"""Fixtures of the USD tests: the program, the garments, and what the one makes of the other."""

import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# The plugin brings the schemas along. Plugins are found when the first part of pxr is imported, so this comes before
# every such import.
PLUGIN = os.environ.get("USDTAILOR_PLUGIN")
os.environ["PXR_PLUGINPATH_NAME"] = os.pathsep.join(
    filter(None, [PLUGIN or str(ROOT / "schemas"), os.environ.get("PXR_PLUGINPATH_NAME")])
)

# No OpenUSD beside the program, except where a test names it.
os.environ["USDTAILOR_PYTHON"] = ""

import json  # noqa: E402

import numpy as np  # noqa: E402
import pytest  # noqa: E402
from mesh import find_model, read_mesh  # noqa: E402
from pxr import Sdf, Usd  # noqa: E402

# Whether long tests run too: `cargo xtask test --all`.
ALL = bool(os.environ.get("TAILOR_TEST_ALL"))
long_test = pytest.mark.skipif(not ALL, reason="a long test: NOT run without `cargo xtask test --all`")

EXAMPLES = ROOT / "examples"
# Garments with a trouble each, by tests/garments/make.py.
MADE = ROOT / "tests" / "garments"
# A folder whose garments take the place of these: `cargo xtask test garments`.
GIVEN = os.environ.get("TAILOR_GARMENTS")


def stages(folder):
    found = sorted(path for path in folder.iterdir() if path.suffix in (".usda", ".usdc"))
    assert found, f"{folder} has no garments"
    return found


GARMENTS = stages(Path(GIVEN)) if GIVEN else stages(EXAMPLES) + stages(MADE)


def garment_files():
    return [pytest.param(path, id=path.stem) for path in GARMENTS]


def pytest_collection_modifyitems(config, items):
    """With the garments of a folder, the tests that take one of them are all that run."""
    if GIVEN:
        values = lambda item: item.callspec.params.values() if hasattr(item, "callspec") else ()  # noqa: E731
        takes_one = lambda item: any(isinstance(value, Path) and value in GARMENTS for value in values(item))  # noqa: E731
        config.hook.pytest_deselected(items=[item for item in items if not takes_one(item)])
        items[:] = [item for item in items if takes_one(item)]


@dataclass
class Product:
    """One run of `usdtailor build`: the stages and the meshes before and after."""

    source_path: Path
    path: Path
    source_stage: Usd.Stage
    stage: Usd.Stage
    report: dict
    stderr: str
    again: Callable  # the same run with more arguments, beside it

    @property
    def model_path(self):
        return find_model(self.source_stage).GetPath()

    def prim(self, name):
        return self.stage.GetPrimAtPath(self.model_path.ReplaceName(name))

    @cached_property
    def source(self):
        """The mesh of the input. Doubled points, which a build sews, are one."""
        return self.authored.sewn() if self.has_doubled_points else self.authored

    @cached_property
    def authored(self):
        return read_mesh(find_model(self.source_stage))

    @property
    def has_doubled_points(self):
        return (self.authored.doubled != np.arange(len(self.authored.points))).any()

    def mesh(self, name):
        if name not in self.__dict__:
            self.__dict__[name] = read_mesh(self.prim(name))
        return self.__dict__[name]

    @cached_property
    def traced(self):
        """The same run with what each vertex of the simulation mesh came from."""
        return self.again("--provenance")

    @property
    def sim(self):
        return self.mesh("sim")

    @property
    def render(self):
        return self.mesh("render")

    @property
    def warnings(self):
        """The messages of what could not be carried, each with its code."""
        return [f"{warning['code']}: {warning['message']}" for warning in self.report["warnings"]]


def program():
    name = "usdtailor.exe" if sys.platform == "win32" else "usdtailor"
    return Path(os.environ.get("USDTAILOR", ROOT / "target" / "debug" / name))


@pytest.fixture(scope="session")
def usdtailor():
    """The program, as users run it."""
    if not program().exists():
        pytest.fail(f"no program at {program()}: run `cargo xtask test build`, or set USDTAILOR", pytrace=False)
    return program()


def run(usdtailor, *args):
    """Runs the program to its end, whatever its exit code."""
    return subprocess.run([usdtailor, *map(str, args)], capture_output=True, text=True, check=False, timeout=600)


def write(usdtailor, source, path, *args):
    """Builds `source` to `path` with a report beside it, and returns standard error; fails with the program's own words."""
    done = run(usdtailor, "build", source, "-o", path, "--report", f"{path}.json", *args)
    assert done.returncode == 0, f"usdtailor build {source} {' '.join(map(str, args))}\nexit {done.returncode}\n{done.stderr}"
    return done.stderr


# Larger outputs have the same kinds of values, and take longer. [bytes]
MOST_AGAIN = 4_000_000


def check_again(usdtailor, path):
    """The program reads an output in the same way after OpenUSD has written it as a crate."""
    if path.stat().st_size > MOST_AGAIN:
        return
    again = path.with_name(f"{path.stem}_again.usdc")
    assert Sdf.Layer.OpenAsAnonymous(str(path)).Export(str(again))
    own, other = (run(usdtailor, "info", "-v", "--all", file) for file in (path, again))
    words = [(done.returncode, (done.stdout + done.stderr).replace(str(file), "")) for done, file in ((own, path), (other, again))]
    assert words[0] == words[1], f"{path}: OpenUSD writes what is not read\n{words[0][1]}\n{words[1][1]}"


def opened(source, path, stderr, again):
    stages = (Usd.Stage.Open(str(source)), Usd.Stage.Open(str(path)))
    return Product(Path(source), path, *stages, json.loads(Path(f"{path}.json").read_text()), stderr, again)


def make(usdtailor, source, folder, *args, suffix=".usda", stem="built"):
    """Builds `source` into `folder` and opens both stages."""
    path = folder / f"{stem}{suffix}"
    stderr = write(usdtailor, source, path, *args)
    return opened(source, path, stderr, lambda *more: make(usdtailor, source, folder, *args, *more, suffix=suffix, stem=f"{stem}_{digest(*more)}"))


@pytest.fixture
def build(usdtailor, tmp_path):
    """`build(input, *args)` runs `usdtailor build` into a folder of this test and opens what it wrote."""

    def build(source, *args, **options):
        return make(usdtailor, source, tmp_path, *args, **options)

    return build


def digest(*parts):
    return hashlib.sha256(b"\0".join(part if isinstance(part, bytes) else str(part).encode() for part in parts)).hexdigest()[:20]


@cache
def content(path):
    """A hash of a file, or of the stages in a folder."""
    files = [path] if path.is_file() else sorted(path.rglob("*.usd[ac]"))
    return digest(*(part for file in files for part in (file.name, file.read_bytes())))


def kept():
    """Where the results of this program are, for all workers and for later runs."""
    # In a folder of its own for each program, as the command and that of the package take turns.
    return ROOT / "target" / "built" / digest(program().resolve()) / content(program())


def pytest_configure(config):
    # Results of what the program was before are of no more use. Workers have an input; the process that starts them has none.
    if not hasattr(config, "workerinput") and program().exists():
        for folder in kept().parent.glob("*"):
            if folder != kept():
                shutil.rmtree(folder)


@contextlib.contextmanager
def only_worker(path):
    """Makes other workers wait that would write the same result."""
    with open(path, "w") as file:
        if sys.platform != "win32":
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def built(usdtailor):
    """As `build`, for results of the garments here that tests share: each combination is built once and must not be changed."""
    products = {}

    def made(source, args, suffix):
        folder = kept() / digest(source, content(Path(source).parent), suffix, *args)
        path, words = folder / f"built{suffix}", folder / "stderr.txt"
        folder.mkdir(parents=True, exist_ok=True)
        with only_worker(folder / "lock"):
            # Written last, so that an interrupted build is repeated.
            if not words.exists():
                stderr = write(usdtailor, source, path, *args)
                check_again(usdtailor, path)
                words.write_text(stderr)
        return opened(source, path, words.read_text(), lambda *more: built(source, *args, *more, suffix=suffix))

    def built(source, *args, suffix=".usda"):
        key = (source, args, suffix)
        if key not in products:
            products[key] = made(*key)
        return products[key]

    return built


@pytest.fixture(params=garment_files())
def garment(request):
    """The path of each garment in turn."""
    return request.param


@pytest.fixture
def product(garment, built):
    """Each garment, built with the default options."""
    return built(garment)
