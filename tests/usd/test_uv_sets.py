"""Which UV set gives the seams, and what is reported where there is none."""

import numpy as np
import pytest
from conftest import EXAMPLES, MADE, run
from mesh import cut_edges
from pxr import Sdf, Usd, UsdGeom


def renamed(tmp_path, names, interpolation=None):
    """The t-shirt with its UV set under other names, each a copy."""
    stage = Usd.Stage.Open(Sdf.Layer.FindOrOpen(str(EXAMPLES / "tshirt.usda")).identifier)
    flat = stage.Flatten()
    path = tmp_path / "tee.usda"
    flat.Export(str(path))
    stage = Usd.Stage.Open(str(path))
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    values = primvars.GetPrimvar("st").ComputeFlattened()
    primvars.RemovePrimvar("st")
    mesh.GetPrim().RemoveProperty("primvars:st:indices")
    mesh.GetPrim().RemoveProperty("tailor:sim:uvSet")
    for name in names:
        kind = interpolation or UsdGeom.Tokens.faceVarying
        size = len(values) if kind == UsdGeom.Tokens.faceVarying else len(mesh.GetPointsAttr().Get())
        primvars.CreatePrimvar(name, Sdf.ValueTypeNames.TexCoord2fArray, kind).Set(values[:size])
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("names", [["UVMap"], ["map1"], ["anything"], ["other", "map1"], ["b", "a", "UVMap"]])
def test_a_uv_set_of_another_name_gives_the_seams(build, built, tmp_path, names):
    product = build(renamed(tmp_path, names))
    plain = built(EXAMPLES / "tshirt.usda")
    assert product.sim.counts.tolist() == plain.sim.counts.tolist()
    assert product.sim.points.tolist() == plain.sim.points.tolist()
    chosen = next(name for name in ("UVMap", "map1", *names) if name in names)
    assert product.report["recipe"]["sim"]["uvSet"] == chosen
    assert not [warning for warning in product.warnings if warning.startswith("no-uv-set")]


def test_sets_of_unknown_names_are_listed(build, tmp_path):
    product = build(renamed(tmp_path, ["one", "two"]))
    (warning,) = [warning for warning in product.warnings if warning.startswith("no-uv-set")]
    assert "one, two" in warning and "sim.uvSet" in warning


@pytest.mark.parametrize(
    ("names", "interpolation", "words"), [([], None, "no UVs"), (["st"], UsdGeom.Tokens.vertex, "faceVarying")]
)
def test_missing_uvs_and_uvs_per_point_are_told(build, tmp_path, names, interpolation, words):
    source = renamed(tmp_path, names, interpolation)
    (warning,) = [warning for warning in build(source).warnings if warning.startswith("no-uv-set")]
    assert words in warning and "sim.constraints" in warning
    silent = build(source, "--set", "sim.uvSet=", stem="silent")
    assert not [warning for warning in silent.warnings if warning.startswith("no-uv-set")]


def test_check_finds_what_build_warns_of(usdtailor, build, tmp_path):
    source = renamed(tmp_path, ["one", "two"])
    checked = run(usdtailor, "check", source)
    assert checked.returncode == 0
    built = build(source)
    for warning in built.report["warnings"]:
        if warning["code"] != "not-carried":
            assert warning["problem"] in checked.stderr


def test_info_lists_operators_with_their_sets(usdtailor):
    described = run(usdtailor, "info", EXAMPLES / "sewn" / "coat.usda")
    lines = [line.split() for line in described.stdout.splitlines()]
    assert [line for line in lines if line[:1] == ["seam"]] and [line for line in lines if line[:1] == ["fold"]]
    assert "edges)" in described.stdout and "faces)" in described.stdout


def largest_ratios(mesh):
    """For each face the largest ratio of an edge in UVs to the edge in space."""
    uvs, after = mesh.primvars["st"].flat, mesh.topology.next_corner
    in_uvs, in_space = (np.linalg.norm(at - at[after], axis=1) for at in (uvs, mesh.points[mesh.indices]))
    found = np.zeros(len(mesh.counts))
    np.maximum.at(found, mesh.topology.corner_face, in_uvs / in_space)
    return found


@pytest.mark.parametrize("source", [EXAMPLES / "tshirt.usda", EXAMPLES / "coat.usda", MADE / "split_uv_indices.usdc"])
def test_no_triangle_stretches_across_the_texture_without_seams(built, source):
    product = built(source, "--set", "sim.constrainUvSeams=false", "--sets", "all")
    most = 3 * np.percentile(largest_ratios(product.source), 99.5)
    assert (largest_ratios(product.sim) > most).sum() == 0
    assert not [warning for warning in product.warnings if warning.startswith("uv-flips")]
    seams = product.prim("sim").GetChild("tailorSeams")
    edges = np.sort(np.array(UsdGeom.Subset(seams).GetIndicesAttr().Get()).reshape(-1, 2))
    corner_values = np.unique(product.sim.primvars["st"].flat, axis=0, return_inverse=True)[1].ravel()
    cut = product.sim.topology.edges[cut_edges(product.sim.topology, corner_values)]
    assert sorted(edges.tolist()) == sorted(np.sort(cut).tolist())
