"""The functions of the Python package, imported from its source folder, with the program under test."""

import importlib
import json
import re
import sys
from pathlib import Path

import numpy
import pytest
from conftest import run
from pxr import Usd, UsdGeom
from runs import good, meshes, sim_points
from sources import write

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def usd_tailor(usdtailor, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "python")
    package = importlib.import_module("usd_tailor")
    monkeypatch.setattr(sys.modules["usd_tailor._command"], "PROGRAM", usdtailor)
    return package


# Options that functions give by themselves, or that are for people at a terminal.
OWN = {"color", "help", "output", "quiet", "verbose", "report", "set", "jobs", "dry_run", "from", "to", "cache", "json"}


@pytest.mark.parametrize("command", ["build", "fit", "drive", "check"])
def test_a_function_takes_all_options_of_the_command(usdtailor, usd_tailor, command):
    found = re.findall(r"^ +(?:-\w, )?--([a-z-]+)", run(usdtailor, command, "--help").stdout, re.MULTILINE)
    kinds = {"build": "BuildArguments", "fit": "FitArguments", "drive": "DriveArguments", "check": "ExamineArguments"}
    known = getattr(usd_tailor, kinds[command]).__optional_keys__ - {"options"}
    assert {name.replace("-", "_") for name in found} - OWN == known


def test_arguments_are_those_of_the_command(usd_tailor, tmp_path):
    source, out = write(tmp_path / "in.usda"), tmp_path / "out.usda"
    built = usd_tailor.build(source, out, options={"render.level": 1}, sim_name="cloth", allow=["sets-blurred"], max_memory="2G")
    assert built.layer.GetPrimAtPath("/Coat/cloth") and built.report["status"] == "built"
    assert usd_tailor.build(source, out, options={"render.level": 1}, sim_name="cloth", allow=["sets-blurred"], max_memory="2G", skip_fresh=True).report["status"] == "fresh"
    with pytest.raises(usd_tailor.TailorError, match="not-a-code"):
        usd_tailor.check(source, deny=["not-a-code"])
    with pytest.raises(TypeError, match="there is no argument 'skipfresh'"):
        usd_tailor.build(source, out, skipfresh=True)
    layer = usd_tailor.build(Usd.Stage.Open(str(source))).layer
    assert layer.anonymous and layer.GetPrimAtPath("/Coat/sim")


def test_a_shot_takes_gaps_and_a_space(usdtailor, usd_tailor, tmp_path):
    garment, cache, shot = tmp_path / "built.usda", tmp_path / "cache.npz", tmp_path / "shot.usda"
    good(usdtailor, "build", write(tmp_path / "in.usda"), "-o", garment)
    numpy.savez(cache, points=numpy.stack([sim_points(garment)] * 3), times=numpy.array([1.0, 2.0, 9.0]))
    with pytest.raises(usd_tailor.TailorError, match="--gaps"):
        usd_tailor.drive(garment, cache, shot)
    layer = usd_tailor.drive(garment, cache, shot, gaps=True, cache_space="local")
    assert list(layer.ListTimeSamplesForPath("/Coat/render.points")) == [1.0, 2.0, 9.0]


def test_the_report_of_any_command_is_returned(usd_tailor, tmp_path):
    source, out = write(tmp_path / "in.usda"), tmp_path / "out.usda"
    report = usd_tailor.run(["build", source, "-o", out, "-q"])
    assert report["status"] == "built" and meshes(out) == ["model", "render", "sim"]
    assert usd_tailor.run(["check", out])["inputs"][0]["fresh"] is True
    assert usd_tailor.run(["options"]) == usd_tailor.options()
    usd_tailor.run(["build", source, "-o", out, "--force", "--report", tmp_path / "report.json", "-q"])
    assert json.loads((tmp_path / "report.json").read_text())["status"] == "built"
    assert UsdGeom.Mesh(Usd.Stage.Open(str(out)).GetPrimAtPath("/Coat/render"))
