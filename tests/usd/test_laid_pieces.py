"""Pockets and flaps that are meshes of their own: attached to the cloth that they lie on, as loose pieces of one mesh are."""

import json

import numpy as np
import pytest
from conftest import run
from panels import built, meshes
from pxr import Sdf, Usd, UsdGeom
from sources import add_primvar, add_uv, define

LIFT = 0.1


def grid(columns, rows, size, at=(0.0, 0.0, 0.0)):
    """The points, counts and indices of a flat sheet."""
    x, y = np.meshgrid(np.linspace(0, size, columns + 1), np.linspace(0, size * rows / columns, rows + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) + at
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.stack([corner, corner + 1, corner + columns + 2, corner + columns + 1], axis=1)
    return points, np.full(len(quads), 4), quads.ravel()


@pytest.fixture
def coat(tmp_path):
    """Writes two sheets, a pocket over the line where they are sewn, and a flap on the pocket; `change` edits the pocket."""
    def write(change=lambda stage, pocket: None, lift=LIFT):
        path = tmp_path / f"coat{lift}.usda"
        stage = Usd.Stage.CreateNew(str(path))
        for name, sheet in {
            "flap": grid(3, 1, 3, (3.5, 6.5, 2 * lift)), "left": grid(5, 10, 5), "right": grid(5, 10, 5, (5, 0, 0)),
            "pocket": grid(4, 5, 4, (3, 2, lift)),
        }.items():
            add_uv(define(stage, f"/Coat/{name}", sheet))
        change(stage, UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/pocket")))
        stage.Save()
        return path
    return write


def sims(path):
    """The names of the simulation meshes."""
    stage = Usd.Stage.Open(str(path))
    return {prim.GetName() for prim in stage.Traverse() if prim.GetName().endswith("sim")}


def test_a_pocket_and_its_flap_are_attached_along_their_borders(usdtailor, coat, tmp_path):
    out = tmp_path / "out.usda"
    built(usdtailor, coat(), out, "--all", "--set", "sim.maxEdgeLength=0.5", "--strict")
    (mesh,) = meshes(out, "sim", parent="/Coat")
    stage = Usd.Stage.Open(str(out))
    sim = stage.GetPrimAtPath("/Coat/sim")
    points, faces, coords = (np.array(sim.GetAttribute(f"tailor:attach:{key}").Get()) for key in ("points", "faces", "coords"))
    on_triangles = mesh.points[mesh.indices.reshape(-1, 3)[faces]]
    weights = np.stack([coords[:, 0], coords[:, 1], 1 - coords[:, 0] - coords[:, 1]], axis=1)
    below = np.einsum("ij,ijk->ik", weights, on_triangles)
    gap = np.linalg.norm(mesh.points[points] - below, axis=1)
    # The upper part of the flap has the coat below it, the rest of it and the pocket what is one layer below.
    above = mesh.points[points]
    layers = np.where((above[:, 2] > 1.5 * LIFT) & (above[:, 1] > 7 + 1e-3), 2, 1)
    assert np.abs(gap - layers * LIFT).max() < 1e-4 and {1, 2} == set(layers.tolist())
    z = mesh.points[:, 2]
    for level, (low, high) in {LIFT: ((3, 2), (7, 7)), 2 * LIFT: ((3.5, 6.5), (6.5, 7.5))}.items():
        border = np.abs(z - level) < 1e-4
        inner = ((mesh.points[:, :2] > np.array(low) + 1e-3) & (mesh.points[:, :2] < np.array(high) - 1e-3)).all(axis=1)
        held = set(points.tolist())
        over_cloth = (mesh.points[:, 1] < 10)
        assert {int(v) for v in np.flatnonzero(border & ~inner & over_cloth)} == {v for v in held if border[v]}
    assert {"flap", "left", "right", "pocket"} <= set(mesh.subsets)


@pytest.mark.parametrize("prim, own", [("pocket", {"left_sim", "pocket_sim"}), ("left", {"flap_sim", "left_sim", "pocket_sim"})])
def test_a_piece_stays_one_of_its_own_where_options_say_so(usdtailor, coat, tmp_path, prim, own):
    """Those of the pocket alone, where the flap is on the coat; and those of the coat."""
    def free(stage, _):
        of = stage.GetPrimAtPath(f"/Coat/{prim}")
        of.CreateAttribute("tailor:cloth:attach", Sdf.ValueTypeNames.Bool, True, Sdf.VariabilityUniform).Set(False)

    out = tmp_path / "out.usda"
    said = built(usdtailor, coat(free), out, "--all")
    assert "unattached" not in said
    assert sims(out) == own


def test_what_lies_farther_away_is_a_garment_of_its_own(usdtailor, coat, tmp_path):
    out = tmp_path / "out.usda"
    built(usdtailor, coat(lift=2.0), out, "--all")
    assert sims(out) == {"flap_sim", "left_sim", "pocket_sim"}


@pytest.mark.parametrize("kind", ["primvar", "option"])
def test_a_piece_that_cannot_be_a_part_without_a_loss_is_told(usdtailor, coat, tmp_path, kind):
    def change(stage, pocket):
        if kind == "primvar":
            add_primvar(pocket, name="wear", type_name="float", interpolation="vertex", values=[0.5] * 30)
        else:
            for name, length in (("pocket", 0.4), ("left", 0.6)):
                prim = stage.GetPrimAtPath(f"/Coat/{name}")
                prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float, True, Sdf.VariabilityUniform).Set(length)

    out, report = tmp_path / "out.usda", tmp_path / "report.json"
    built(usdtailor, coat(change), out, "--all", "--report", report, "--strict")
    garments = json.loads(report.read_text())["garments"]
    told = [warning for garment in garments for warning in garment["warnings"] if warning["code"] == "unattached"]
    assert told and all("/Coat/" in warning["place"] and "is not attached" in warning["problem"] for warning in told)
    assert any(warning["place"] == "/Coat/pocket" for warning in told)
    if kind == "primvar":
        (pocket,) = meshes(out, "pocket_sim", parent="/Coat")
        assert np.allclose(pocket.primvars["wear"].flat, 0.5), "nothing is lost"


def test_the_output_is_valid_in_usd_and_the_check_agrees(usdtailor, coat):
    done = run(usdtailor, "check", "--all", "--strict", coat())
    assert done.returncode == 0 and "good" in done.stdout, done.stderr
