"""The commands of the documents run as they are printed, on the examples."""

import re
import subprocess
import sys

import pytest
from conftest import EXAMPLES, ROOT
from documents import run_script
from mesh import find_model
from pxr import Usd, UsdGeom

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the commands are for a POSIX shell: they are NOT tested")
BLOCK = re.compile(r"^( *)```(sh|python)\n(.*?)^ *```$", re.M | re.S)


def section(page, heading):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.search(rf"^## {heading}\n(.*?)(?=^## |\Z)", text, re.M | re.S).group(1)


def run_blocks(text, usdtailor, folder):
    """Runs the blocks `sh` of a text, and writes its scripts, whose first line is their name. Returns what was printed."""
    printed, count = "", 0
    for indent, kind, code in BLOCK.findall(text):
        code = re.sub(rf"^{indent}", "", code, flags=re.M)
        if kind == "python":
            (folder / re.match(r"# (\w+\.py)\n", code).group(1)).write_text(code)
            continue
        printed, count = printed + run_script(code, usdtailor, folder).stdout, count + 1
    assert count, "no commands"
    return printed


def told(text):
    """The numbers that a text gives as "some 8,700"."""
    return [int(count.replace(",", "")) for count in re.findall(r"\bsome ([\d,]+)", text)]


def triangles(printed):
    return [int(count) for count in re.findall(r"(\d+) triangles$", printed, re.M)]


def test_the_simulation_mesh_alone(usdtailor, tmp_path):
    run_blocks(section("howto.md", "Only the simulation mesh"), usdtailor, tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "cloth.usdc"))
    root = stage.GetDefaultPrim()
    names = [child.GetName() for child in root.GetChildren()]
    assert {"model", "sim", "physics"} <= set(names) and "render" not in names
    assert len(UsdGeom.Mesh(root.GetChild("sim")).GetPointsAttr().Get()) > 1000


def test_denser_at_the_elbow(usdtailor, tmp_path):
    text = section("howto.md", "Denser at the elbow")
    rows, dense = triangles(run_blocks(text, usdtailor, tmp_path))
    plain = ["--set", "sim.density=", "--set", "sim.maxEdgeLength=26mm", "--set", "sim.minEdgeLength=0"]
    done = subprocess.run([usdtailor, "build", tmp_path / "coat.usda", "-o", tmp_path / "plain.usdc", *plain],
                          capture_output=True, text=True, check=True)
    [even] = triangles(done.stdout)
    assert min(rows, dense) > 1.1 * even
    assert [rows, dense, even] == pytest.approx(told(text), rel=0.05)


def test_a_pinned_waist(usdtailor, tmp_path):
    text = section("howto.md", "Pin the waist")
    pinned = re.findall(r"(\d+) pinned vertices", run_blocks(text, usdtailor, tmp_path))
    assert [int(count) for count in pinned] == pytest.approx(told(text), rel=0.1)


def test_without_usd(usdtailor, tmp_path):
    stage = Usd.Stage.Open(str(EXAMPLES / "tshirt.usda"))
    mesh = UsdGeom.Mesh(find_model(stage))
    counts, corners = mesh.GetFaceVertexCountsAttr().Get(), iter(mesh.GetFaceVertexIndicesAttr().Get())
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    places = iter(st.GetIndices())
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.GetPointsAttr().Get()] + [f"vt {u} {v}" for u, v in st.Get()]
    lines += ["f " + " ".join(f"{next(corners) + 1}/{next(places) + 1}" for _ in range(n)) for n in counts]
    (tmp_path / "garment.obj").write_text("\n".join(lines))
    assert "1 operator: seam.sewn" in run_blocks(section("howto.md", "Without USD"), usdtailor, tmp_path)
    for name in ("sim", "render"):
        kinds = [line.split()[0] for line in (tmp_path / f"{name}.obj").read_text().splitlines()]
        assert kinds.count("f") > 5000 and set(kinds) == {"v", "f"}


def test_the_recipe_and_the_flags_make_the_same_meshes(usdtailor, tmp_path):
    text = (ROOT / "docs/recipe.md").read_text(encoding="utf-8")
    (tmp_path / "shirt.tailor").write_text(re.search(r"```json\n(.*?)```", text, re.S).group(1))
    code = re.search(r"```console\n(.*?)```", text, re.S).group(1)
    code = re.sub(r"^\$ ", "", code, flags=re.M).replace("-o shirt.usdc --set", "-o flags.usdc --set")
    run_blocks(f"```sh\n{code}```\n", usdtailor, tmp_path)
    made = [Usd.Stage.Open(str(tmp_path / name)) for name in ("shirt.usdc", "flags.usdc")]
    for path in ("/Tshirt/sim", "/Tshirt/render"):
        points = [UsdGeom.Mesh(stage.GetPrimAtPath(path)).GetPointsAttr().Get() for stage in made]
        assert points[0] == points[1] and len(points[0]) > 1000


def test_what_a_report_of_a_fault_needs(usdtailor, tmp_path):
    (tmp_path / "tshirt.usda").write_bytes((EXAMPLES / "tshirt.usda").read_bytes())
    run_blocks(section("report.md", "What to send"), usdtailor, tmp_path)
    assert "recipe" in (tmp_path / "log.txt").read_text() and (tmp_path / "out.json").stat().st_size > 1000
    assert not Usd.Stage.Open(str(tmp_path / "whole.usdc")).GetRootLayer().subLayerPaths
