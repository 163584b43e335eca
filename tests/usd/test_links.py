"""Outputs and reports through links: what they name is found by the path that was given, and by the real one."""

import json
import sys

import numpy
import pytest
from pxr import Sdf, Usd
from runs import good, meshes, refused, sim_points
from sources import write

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="links are those of Unix")


def test_an_output_through_a_link_composes_by_its_given_path(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    (tmp_path / "far" / "deep").mkdir(parents=True)
    target = tmp_path / "far" / "deep" / "real.usda"
    target.write_text("#usda 1.0\n")
    link = tmp_path / "link.usda"
    link.symlink_to(target)
    good(usdtailor, "build", source, "-o", link, "--force")
    assert link.is_symlink() and target.stat().st_size > 100, "the target is replaced, and the link stays"
    assert meshes(link) == ["model", "render", "sim"]
    good(usdtailor, "info", link, "--prim", "/Coat/model")


def test_an_output_in_a_linked_folder_composes_by_its_given_path(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    (tmp_path / "far" / "deep").mkdir(parents=True)
    (tmp_path / "near").symlink_to(tmp_path / "far" / "deep")
    good(usdtailor, "build", source, "-o", tmp_path / "near" / "out.usda")
    assert meshes(tmp_path / "near" / "out.usda") == ["model", "render", "sim"]
    good(usdtailor, "info", tmp_path / "near" / "out.usda", "--prim", "/Coat/model")


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_an_output_through_a_link_composes_by_its_real_path_too(usdtailor, tmp_path, kind):
    source = write(tmp_path / "in.usda")
    deep = tmp_path / "far" / "deep"
    deep.mkdir(parents=True)
    # A layer of this name is at the same relative place from the real folder.
    (tmp_path / "far" / "in.usda").write_text("#usda 1.0\n")
    if kind == "folder":
        (tmp_path / "near").symlink_to(deep)
        named, real = tmp_path / "near", deep
    else:
        named, real = tmp_path / "given", deep
        named.mkdir()
        for name in ("out.usda", "shot.usda"):
            (real / name).write_text("#usda 1.0\n")
            (named / name).symlink_to(real / name)
    good(usdtailor, "build", source, "-o", named / "out.usda", "--force")
    for folder in (named, real):
        assert meshes(folder / "out.usda") == ["model", "render", "sim"]
        assert "fresh" in good(usdtailor, "check", folder / "out.usda").stdout
    points = sim_points(named / "out.usda")
    numpy.save(tmp_path / "cache.npy", numpy.stack([points, points + 1]))
    good(usdtailor, "drive", named / "out.usda", "--cache", tmp_path / "cache.npy", "-o", named / "shot.usda", "--clips", "--force")
    for folder in (named, real):
        stage = Usd.Stage.Open(str(folder / "shot.usda"))
        moved = stage.GetPrimAtPath("/Coat/render").GetAttribute("points")
        first, last = (numpy.array(moved.Get(time)) for time in (1, 2))
        assert numpy.allclose(last, first + 1, atol=1e-4)


def test_a_project_below_a_link_keeps_relative_paths(usdtailor, tmp_path):
    (tmp_path / "disk" / "out").mkdir(parents=True)
    (tmp_path / "project").symlink_to(tmp_path / "disk")
    project = tmp_path / "project"
    good(usdtailor, "build", write(project / "in.usda"), "-o", project / "out" / "out.usda")
    assert list(Sdf.Layer.FindOrOpen(str(project / "out" / "out.usda")).subLayerPaths) == ["../in.usda"]


def test_a_report_is_written_where_a_link_leads(usdtailor, tmp_path):
    source, report, link = write(tmp_path / "in.usda"), tmp_path / "real.json", tmp_path / "report.json"
    report.write_text("{}")
    link.symlink_to(report)
    good(usdtailor, "build", source, "-o", tmp_path / "out.usda", "--report", link, "--force")
    assert link.is_symlink() and "sim" in json.loads(report.read_text())


def test_a_dangling_link_is_refused(usdtailor, tmp_path):
    source = write(tmp_path / "in.usda")
    link = tmp_path / "link.usda"
    link.symlink_to(tmp_path / "gone.usda")
    for force in ([], ["--force"]):
        refused(usdtailor, "build", source, "-o", link, *force, says=["link.usda is a link to a file that does not exist", "hint: "])
    assert link.is_symlink() and not link.exists()
