"""Fixtures of the USD tests: the program, the garments, and what the one makes of the other."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# The plugin brings the schemas along. Plugins are found when the first part of pxr is imported, so this comes before
# every such import.
PLUGIN = os.environ.get("USDTAILOR_PLUGIN")
os.environ["PXR_PLUGINPATH_NAME"] = os.pathsep.join(
    filter(None, [PLUGIN or str(ROOT / "schemas"), os.environ.get("PXR_PLUGINPATH_NAME")])
)

import json  # noqa: E402

import pytest  # noqa: E402
from mesh import find_model, read_mesh  # noqa: E402
from pxr import Usd  # noqa: E402

EXAMPLES = ROOT / "examples"
SHARED = ROOT.parent / "shared" / "garments"
SHARED_ABSENT = f"../shared/garments is absent: the real garments are NOT tested ({SHARED})"


def garment_files():
    examples = sorted(EXAMPLES.glob("*.usda"))
    real = sorted(SHARED.glob("*.usdc"))
    params = [pytest.param(path, id=path.stem) for path in examples + real]
    if not examples:
        params.append(pytest.param(None, id="examples", marks=pytest.mark.skip(reason="examples/ holds no *.usda: our own garments are NOT tested")))
    if not real:
        params.append(pytest.param(None, id="shared", marks=pytest.mark.skip(reason=SHARED_ABSENT)))
    return params


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

    @property
    def source(self):
        if "source" not in self.__dict__:
            self.__dict__["source"] = read_mesh(find_model(self.source_stage))
        return self.__dict__["source"]

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


@pytest.fixture(scope="session")
def usdtailor():
    """The program, as users run it."""
    name = "usdtailor.exe" if sys.platform == "win32" else "usdtailor"
    path = Path(os.environ.get("USDTAILOR", ROOT / "target" / "release" / name))
    if not path.exists():
        pytest.fail(f"no program at {path}: run `cargo xtask test build`, or set USDTAILOR", pytrace=False)
    return path


def run(usdtailor, *args):
    """Runs the program to its end, whatever its exit code."""
    return subprocess.run([usdtailor, *map(str, args)], capture_output=True, text=True, check=False, timeout=600)


def make(usdtailor, source, folder, *args, suffix=".usda", stem="built"):
    """Builds `source` into `folder` and opens both stages; fails with the program's own words."""
    path, report = folder / f"{stem}{suffix}", folder / f"{stem}{suffix}.json"
    done = run(usdtailor, "build", source, "-o", path, "--report", report, *args)
    assert done.returncode == 0, f"usdtailor build {source} {' '.join(map(str, args))}\nexit {done.returncode}\n{done.stderr}"

    def again(*more):
        return make(usdtailor, source, folder, *args, *more, suffix=suffix, stem=f"{stem}_again")

    stages = (Usd.Stage.Open(str(source)), Usd.Stage.Open(str(path)))
    return Product(Path(source), path, *stages, json.loads(report.read_text()), done.stderr, again)


@pytest.fixture
def build(usdtailor, tmp_path):
    """`build(input, *args)` runs `usdtailor build` into a folder of this test and opens what it wrote."""

    def build(source, *args, **options):
        return make(usdtailor, source, tmp_path, *args, **options)

    return build


@pytest.fixture(scope="session")
def built(usdtailor, tmp_path_factory):
    """As `build`, for results that tests share: each combination is built once and must not be changed."""
    cache = {}

    def built(source, *args, **options):
        key = (source, args, tuple(options.items()))
        if key not in cache:
            folder = tmp_path_factory.mktemp(Path(source).stem)
            cache[key] = make(usdtailor, source, folder, *args, **options)
        return cache[key]

    return built


@pytest.fixture(params=garment_files())
def garment(request):
    """The path of each garment in turn: our examples, and the real ones where they are."""
    return request.param


@pytest.fixture
def product(garment, built):
    """Each garment, built with the default options."""
    return built(garment)
