"""What the command says and how it ends: exit codes, JSON, slips, units, colours."""

import json
import re

import pytest
import sources
from conftest import EXAMPLES, run
from pxr import Sdf, Usd, UsdGeom

SHIRT = EXAMPLES / "tshirt.usda"
COAT = EXAMPLES / "coat.usda"


def triangles(report):
    return report["sim"]["faces"]


def test_exit_codes_tell_who_is_at_fault(usdtailor, tmp_path):
    out = tmp_path / "out.usda"
    assert run(usdtailor, "build", SHIRT, "-o", out).returncode == 0
    bad_input = [
        ("build", SHIRT, "-o", out),
        ("check", tmp_path / "missing.usda"),
        ("build", SHIRT, "-o", tmp_path / "b.usda", "--set", "sim.uvSet=nothing"),
    ]
    assert [run(usdtailor, *arguments).returncode for arguments in bad_input] == [1, 1, 1]
    wrong_usage = [
        ("build",),
        ("tailor",),
        ("check", SHIRT, "--tread", "2"),
        ("check",),
        ("check", SHIRT, "--set", "sim.maxEdge=2"),
        ("check", SHIRT, "--set", "sim.iterations=many"),
        ("check", SHIRT, "--threads", "0"),
    ]
    assert [run(usdtailor, *arguments).returncode for arguments in wrong_usage] == [2] * len(wrong_usage)


def test_info_as_json_has_what_the_text_has(usdtailor):
    done = run(usdtailor, "info", COAT, "--json")
    (entry,) = json.loads(done.stdout)["inputs"]
    text = run(usdtailor, "info", COAT).stdout
    assert entry["input"] == str(COAT) and entry["facts"]["prim"] in text
    assert f"{entry['mesh']['points']} points" in text
    assert {subset["name"] for subset in entry["subsets"]} == set(re.findall(r"subset +(\S+) of", text))
    assert f"about {entry['sim']['triangles']} triangles" in text
    assert entry["recipe"]["sim"]["maxEdgeLength"] > 0


def test_check_as_json_has_warnings_and_errors(usdtailor, tmp_path):
    bare = tmp_path / "bare.usda"
    sources.write(bare, uv=False)
    missing = tmp_path / "missing.usda"
    done = run(usdtailor, "check", SHIRT, bare, missing, "--json")
    assert done.returncode == 1
    shirt, without_uvs, absent = json.loads(done.stdout)["inputs"]
    assert shirt["fresh"] is False and "error" not in shirt
    assert "no-uv-set" in {warning["code"] for warning in without_uvs["warnings"]}
    assert absent["error"]["faults"][0]["code"] == "unreadable-file"
    assert "warning[" not in done.stderr and str(missing) in done.stderr


def test_a_report_can_be_printed(usdtailor, tmp_path):
    out, file = tmp_path / "a.usda", tmp_path / "report.json"
    printed = json.loads(run(usdtailor, "build", SHIRT, "-o", out, "--report", "-").stdout)
    run(usdtailor, "build", SHIRT, "-o", out, "--force", "--report", file)
    written = json.loads(file.read_text())
    for report in (printed, written):
        del report["stages"]
    assert printed == written and triangles(printed) > 0
    again = run(usdtailor, "build", SHIRT, "-o", out, "--report", "-")
    assert again.returncode == 1 and again.stderr.count("error[output-exists]") == 1
    assert json.loads(again.stdout)["error"]["faults"][0]["code"] == "output-exists"


def test_a_dry_run_writes_nothing(usdtailor, tmp_path):
    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", SHIRT, "-o", out, "--dry-run")
    assert done.returncode == 0 and str(out) in done.stdout and "triangles" in done.stdout
    assert not list(tmp_path.iterdir())
    out.write_text("#usda 1.0\n")
    done = run(usdtailor, "build", SHIRT, "-o", out, "--dry-run")
    assert done.returncode == 1 and "--force" in done.stderr, "a build would be refused"


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("sim.maxEdgeLenght=2", "did you mean sim.maxEdgeLength?"),
        ("seam.waist.widht=2", "did you mean seam.waist.width?"),
        ("sim.uvSet=sst", "did you mean st?"),
        ("sim.constraints=plackett", "did you mean placket?"),
    ],
)
def test_slips_are_named(usdtailor, given, meant):
    done = run(usdtailor, "check", COAT, "--set", given)
    assert done.returncode in (1, 2)
    assert meant in done.stderr, done.stderr


def test_a_set_of_another_kind_is_told_with_its_option(usdtailor):
    face_set = next(name for name, kind in kinds(COAT).items() if kind == "face")
    done = run(usdtailor, "check", COAT, "--set", f"seam.a.edges={face_set}")
    assert f'"{face_set}" is a subset of faces' in done.stderr and "fold.<name>.faces" in done.stderr, done.stderr


def kinds(file):
    stage = Usd.Stage.Open(str(file))
    subsets = [UsdGeom.Subset(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Subset)]
    return {subset.GetPrim().GetName(): subset.GetElementTypeAttr().Get() for subset in subsets}


def test_the_colon_form_of_an_option_is_understood(usdtailor, build):
    assert (
        build(SHIRT, "--set", "tailor:sim:maxEdgeLength=3").report["recipe"]
        == build(SHIRT, "--set", "sim.maxEdgeLength=3", stem="dots").report["recipe"]
    )


def scaled(tmp_path, scale, meters):
    """A sheet below a scale, in a stage of another unit."""
    path = tmp_path / "sheet.usda"

    def place(mesh):
        stage = mesh.GetPrim().GetStage()
        UsdGeom.SetStageMetersPerUnit(stage, meters)
        UsdGeom.Xformable(stage.GetPrimAtPath("/Coat")).AddScaleOp().Set((scale, scale, scale))

    sources.write(path, finish=place)
    return path


@pytest.mark.parametrize(("scale", "meters"), [(1.0, 0.01), (0.01, 1.0), (2.0, 0.0254)])
def test_lengths_have_units(build, tmp_path, scale, meters):
    source = scaled(tmp_path, scale, meters)
    mesh_units = 0.008 / (scale * meters)
    given = build(source, "--set", "sim.maxEdgeLength=8mm", "--set", "sim.minEdgeLength=0.8 cm")
    assert given.report["recipe"]["sim"]["maxEdgeLength"] == pytest.approx(mesh_units, rel=1e-6)
    assert given.report["recipe"]["sim"]["minEdgeLength"] == pytest.approx(mesh_units, rel=1e-6)
    recipe = tmp_path / "mine.tailor"
    recipe.write_text(json.dumps({"sim": {"maxEdgeLength": "8mm", "minEdgeLength": "8mm"}}))
    again = build(source, "--recipe", recipe, stem="again")
    assert again.sim.points.tolist() == given.sim.points.tolist()


def test_the_summary_says_lengths_in_the_world(usdtailor, tmp_path):
    source = scaled(tmp_path, 0.01, 1.0)
    length = "--set", "sim.maxEdgeLength=1.2cm"
    done = run(usdtailor, "build", source, "-o", tmp_path / "o.usda", *length)
    assert "mesh units (1.20 cm)" in done.stdout, done.stdout
    assert "mesh units (1.20 cm)" in run(usdtailor, "info", source, *length).stdout


@pytest.mark.parametrize("text", ["8km", "mm", "8 m m", "-8mm"])
def test_a_unit_that_is_none_is_refused(usdtailor, text):
    done = run(usdtailor, "check", SHIRT, "--set", f"sim.maxEdgeLength={text}")
    assert done.returncode in (1, 2) and "sim.maxEdgeLength" in done.stderr, done.stderr


def test_colours_are_for_those_who_want_them(usdtailor, tmp_path):
    missing = tmp_path / "missing.usda"
    plain = run(usdtailor, "check", missing).stderr
    coloured = run(usdtailor, "check", missing, "--color", "always").stderr
    assert "\x1b[" not in plain and "\x1b[" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain


def test_options_above_the_only_mesh_are_taken(build, tmp_path):
    """Whoever puts them on the asset means the mesh in it; those of the mesh itself are stronger."""

    def above(mesh):
        root = mesh.GetPrim().GetParent()
        root.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(2)
        root.CreateAttribute("tailor:sim:iterations", Sdf.ValueTypeNames.Int).Set(2)
        root.CreateRelationship("tailor:sim:constraints").SetTargets([mesh.GetPath().AppendChild("waist")])
        UsdGeom.Subset.CreateGeomSubset(mesh, "waist", UsdGeom.Tokens.edge, [0, 1])
        mesh.GetPrim().CreateAttribute("tailor:sim:iterations", Sdf.ValueTypeNames.Int).Set(1)

    path = tmp_path / "above.usda"
    sources.write(path, finish=above)
    recipe = build(path).report["recipe"]
    assert recipe["render"]["level"] == 2 and recipe["sim"]["iterations"] == 1
    assert recipe["sim"]["constraints"] == ["waist"]


def test_options_above_several_meshes_are_those_of_each(usdtailor, tmp_path):
    """A relationship there targets sets of each mesh, and each takes its own."""

    def above(mesh):
        stage = mesh.GetPrim().GetStage()
        other = sources.define(stage, "/Coat/other", sources.sheet())
        other.AddTranslateOp().Set((100, 0, 0))
        sets = [UsdGeom.Subset.CreateGeomSubset(m, name, UsdGeom.Tokens.edge, [0, 1]) for m, name in ((mesh, "waist"), (other, "hem"))]
        root = mesh.GetPrim().GetParent()
        root.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(2)
        root.CreateRelationship("tailor:sim:constraints").SetTargets([s.GetPath() for s in sets])

    path = tmp_path / "above.usda"
    sources.write(path, finish=above)
    done = run(usdtailor, "info", path, "--all", "--json")
    (entry,) = json.loads(done.stdout)["inputs"]
    recipes = [garment["recipe"] for garment in entry["garments"]]
    assert [recipe["render"]["level"] for recipe in recipes] == [2, 2]
    assert [recipe["sim"]["constraints"] for recipe in recipes] == [["waist"], ["hem"]]


def test_a_target_above_the_mesh_that_is_no_set_is_refused(usdtailor, tmp_path):
    def above(mesh):
        mesh.GetPrim().GetParent().CreateRelationship("tailor:sim:constraints").SetTargets(["/Coat"])

    path = tmp_path / "above.usda"
    sources.write(path, finish=above)
    done = run(usdtailor, "check", path)
    assert done.returncode == 1 and "/Coat.tailor:sim:constraints targets /Coat" in done.stderr, done.stderr


def test_a_schema_without_sets_is_told(usdtailor, tmp_path):
    path = tmp_path / "schema.usda"
    sources.write(path, finish=lambda mesh: mesh.GetPrim().AddAppliedSchema("TailorSeamAPI:side"))
    done = run(usdtailor, "check", path)
    assert "warning[schema-without-sets]" in done.stderr and "tailor:seam:side:edges" in done.stderr, done.stderr
