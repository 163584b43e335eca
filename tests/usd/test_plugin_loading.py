"""The OpenUSD plugin in every wheel that it was built for, each in an interpreter of its own, and the check of wheels.

`cargo xtask test plugin` builds them and `cargo xtask test python` says where they are.
"""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from conftest import EXAMPLES, ROOT, run
from pxr import Usd

RECIPE = {"sim": {"maxEdgeLength": 8, "iterations": 1}, "render": {"level": 0}}

PRELUDE = """
import json, sys
from pxr import Sdf, Tf, Usd

def say(**facts):
    print("FACTS" + json.dumps(facts))

def errors_of(work):
    try:
        work()
    except Tf.ErrorException as exception:
        return [error.commentary for error in exception.args]
    return []

def points(stage, name):
    prim = next((prim for prim in stage.Traverse() if prim.GetName() == name), None)
    return [list(point) for point in prim.GetAttribute("points").Get()] if prim else None
"""


@dataclass
class Plugin:
    """The plugin for one wheel, and the interpreter that has the wheel."""

    version: str
    python: str
    folder: Path

    def run(self, script, *args, **environment):
        """Runs a script with the plugin and nothing else; returns what it says, and what it writes to stderr."""
        environment = {**os.environ, "PXR_PLUGINPATH_NAME": str(self.folder), **environment}
        command = [self.python, "-c", PRELUDE + script, *map(str, args)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=300)
        assert done.returncode == 0, f"usd-core {self.version}: exit {done.returncode}\n{done.stderr[-3000:]}"
        facts = [json.loads(line.removeprefix("FACTS")) for line in done.stdout.splitlines() if line.startswith("FACTS")]
        return {key: value for some in facts for key, value in some.items()}, done.stderr


def plugins():
    listed = [entry.split("=") for entry in os.environ.get("USDTAILOR_PLUGINS", "").split(";") if entry]
    if not listed:
        reason = "USDTAILOR_PLUGINS names no plugin: it is NOT tested (cargo xtask test python builds and names them)"
        return [pytest.param(None, id="none", marks=pytest.mark.skip(reason=reason))]
    return [pytest.param(Plugin(version, python, Path(folder)), id=version) for version, python, folder in listed]


@pytest.fixture(params=plugins())
def plugin(request):
    return request.param


@pytest.fixture
def shirt(tmp_path):
    """A function that writes a `.tailor` file over a copy of the shirt, both in this test's folder."""
    shutil.copy(EXAMPLES / "tshirt.usda", tmp_path / "shirt.usda")

    def write(name="shirt.tailor", source="shirt.usda"):
        path = tmp_path / name
        path.write_text(json.dumps({"source": source, **RECIPE}))
        return path

    return write


def test_opens_as_what_the_command_builds(plugin, usdtailor, tmp_path):
    recipe = tmp_path / "coat.tailor"
    recipe.write_text(json.dumps({"source": str(EXAMPLES / "coat.usda"), **RECIPE}))
    built = tmp_path / "built.usdc"
    done = run(usdtailor, "build", "--recipe", recipe, "-o", built)
    assert done.returncode == 0, done.stderr
    found, stderr = plugin.run(
        """
stage = Usd.Stage.Open(sys.argv[1])
say(sim=points(stage, "sim"), render=points(stage, "render"), default=str(stage.GetDefaultPrim().GetPath()))
say(text=len(stage.GetRootLayer().ExportToString()), used=list(stage.GetRootLayer().GetExternalAssetDependencies()))
""",
        recipe,
        USDTAILOR_DEBUG="1",
    )
    stage = Usd.Stage.Open(str(built))
    for name in ("sim", "render"):
        expected = stage.GetPrimAtPath(f"/Coat/{name}").GetAttribute("points").Get()
        assert found[name] == [list(point) for point in expected]
    assert found["default"] == "/Coat"
    assert found["text"] > 10_000
    assert found["used"] == [str(EXAMPLES / "coat.usda")]
    assert f"usdtailor: read {recipe}: compose" in stderr


def test_brings_the_schemas_along(plugin):
    found, _ = plugin.run("""
definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("TailorSimAPI")
say(properties=list(definition.GetPropertyNames()))
""")
    assert "tailor:sim:maxEdgeLength" in found["properties"]


# What a recipe says, and what the error about it says, as a pattern.
FAULTS = {
    '{"source": "nowhere.usda"}': "nowhere.usda cannot be found",
    '{"source": "broken.usda"}': "Expected|syntax error at",
    '{"source": "plain.txt"}': "Cannot determine file format",
    '{"source": "named.usda"}': "may use the file itself",
    '{"source": "a\\u0000b"}': "character",
    '{"sim": {}}': '"source"',
    '{"source": ': "line 1",
    "": "line 1",
    '{"source": "shirt.usda", "sim": {"maxEdge": 1}}': "maxEdge",
    '{"source": "shirt.usda", "sim": {"maxEdgeLength": -1}}': "-1",
}


def test_a_fault_is_one_error_that_names_file_and_cause(plugin, shirt, tmp_path):
    shirt()
    (tmp_path / "broken.usda").write_text('#usda 1.0\ndef Mesh "x" { oops }\n')
    (tmp_path / "plain.txt").write_text("no USD\n")
    (tmp_path / "named.usda").write_text('#usda 1.0\ndef "A" (payload = @`"${NAME}.tailor"`@)\n{\n}\n')
    paths = [tmp_path / f"fault{i}.tailor" for i in range(len(FAULTS))]
    for path, text in zip(paths, FAULTS, strict=True):
        path.write_text(text)
    script = "say(errors=[errors_of(lambda: Sdf.Layer.FindOrOpen(path)) for path in sys.argv[1:]])"
    found, _ = plugin.run(script, *paths)
    for path, (text, said), errors in zip(paths, FAULTS.items(), found["errors"], strict=True):
        assert len(errors) == 1, f"{text}: {errors}"
        assert errors[0].startswith(f"{path}: ")
        assert re.search(said, errors[0]), text
        assert "\n  hint: " in errors[0]


def test_arguments_are_options_and_others_are_left_out(plugin, shirt):
    found, _ = plugin.run(
        """
layer = Sdf.Layer.FindOrOpen(sys.argv[1], {"sim.maxEdgeLength": "12"})
say(fine=len(points(Usd.Stage.Open(layer), "sim")), plain=len(points(Usd.Stage.Open(sys.argv[1]), "sim")))
other = Sdf.Layer.FindOrOpen(sys.argv[1], {"sim.maxEdge": "12"})
say(unknown=len(points(Usd.Stage.Open(other), "sim")), time=errors_of(lambda: Sdf.Layer.FindOrOpen(sys.argv[1], {"time": "noon"})))
""",
        shirt(),
    )
    assert found["fine"] < found["plain"]
    assert found["unknown"] == found["plain"]
    [error] = found["time"]
    assert "noon" in error


def test_a_source_that_uses_the_file_again_is_refused_with_the_chain(plugin, shirt, tmp_path):
    first, second = shirt("first.tailor", "middle.usda"), shirt("second.tailor", "last.usda")
    (tmp_path / "middle.usda").write_text('#usda 1.0\ndef "A" (payload = @second.tailor@)\n{\n}\n')
    variants = 'variants = {string v = "a"}\nprepend variantSets = "v"'
    inside = 'variantSet "v" = {\n"a" {\ndef "B" (references = @first.tailor:SDF_FORMAT_ARGS:sim.seed=3@)\n{\n}\n}\n}'
    (tmp_path / "last.usda").write_text(f'#usda 1.0\ndef "A" (\n{variants}\n)\n{{\n{inside}\n}}\n')
    found, _ = plugin.run("say(errors=errors_of(lambda: Sdf.Layer.FindOrOpen(sys.argv[1])))", first)
    [error] = found["errors"]
    places = [error.index(f"{tmp_path}/{name}") for name in ("middle.usda", "second.tailor", "last.usda")]
    assert places == sorted(places)
    assert error.count(str(first)) == 3  # whose error it is, and both ends of the chain
    assert second.name in error


def test_attributes_of_the_prim_with_the_payload_are_arguments(plugin, shirt, tmp_path):
    shirt()
    shot = tmp_path / "shot.usda"
    shot.write_text('#usda 1.0\ndef "A" (payload = @shirt.tailor:SDF_FORMAT_ARGS:sim.maxEdgeLength=12@)\n{\n}\n')
    found, _ = plugin.run(
        """
stage = Usd.Stage.Open(sys.argv[1])
prim = stage.GetPrimAtPath("/A")
def layer():
    [identifier] = [layer.identifier for layer in stage.GetUsedLayers() if ".tailor" in layer.identifier]
    return identifier.partition(":SDF_FORMAT_ARGS:")[2]
def after(name, kind, value):
    prim.CreateAttribute(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    return layer()
say(path=layer(), coarse=len(points(stage, "sim")))
with Usd.EditContext(stage, stage.GetSessionLayer()):
    say(float=after("tailor:sim:maxEdgeLength", "Float", 5.1), fine=len(points(stage, "sim")))
say(other=after("tailor:sim:unknown", "Float", 5))
prim.RemoveProperty("tailor:sim:maxEdgeLength")
with Usd.EditContext(stage, stage.GetSessionLayer()):
    prim.RemoveProperty("tailor:sim:maxEdgeLength")
say(removed=layer())
say(double=after("tailor:sim:minEdgeLength", "Double", 0.1 + 7))
say(bool=after("tailor:sim:constrainUvSeams", "Bool", False))
say(int=after("tailor:sim:seed", "Int", -0), token=after("tailor:sim:uvSet", "Token", "st"))
say(array=after("tailor:sim:constraints", "TokenArray", ["hem", "armholes"]))
say(strings=after("tailor:sim:constraints", "StringArray", ["hem", "armholes"]))
""",
        shot,
    )
    # The attribute wins over the argument in the asset path, and only options are arguments.
    assert (found["path"], found["float"]) == ("sim.maxEdgeLength=12", "sim.maxEdgeLength=5.1")
    assert found["coarse"] < found["fine"]
    assert found["other"] == found["float"]
    assert found["removed"] == found["path"]
    assert "sim.minEdgeLength=7.1" in found["double"].split("&")
    assert "sim.constrainUvSeams=false" in found["bool"].split("&")
    assert {"sim.seed=0", "sim.uvSet=st"} <= set(found["token"].split("&"))
    assert "sim.constraints=hem,armholes" in found["array"].split("&")
    assert found["strings"] == found["array"]


@pytest.mark.parametrize("named_by", ["file", "schema"])
def test_a_seam_of_a_payload_follows_its_offset(plugin, shirt, tmp_path, named_by):
    recipe = shirt()
    seam = {"edges": ["armholes"], "width": 0.8}
    if named_by == "file":
        recipe.write_text(json.dumps({"source": "shirt.usda", **RECIPE, "seam": {"sleeve": seam}}))
    (tmp_path / "shot.usda").write_text('#usda 1.0\ndef "A" (payload = @shirt.tailor@)\n{\n}\n')
    found, said = plugin.run(
        """
stage = Usd.Stage.Open(sys.argv[1])
prim = stage.GetPrimAtPath("/A")
plain = len(points(stage, "render"))
if sys.argv[2] == "schema":
    prim.AddAppliedSchema("TailorSeamAPI:sleeve")
    prim.CreateAttribute("tailor:seam:sleeve:edges", Sdf.ValueTypeNames.TokenArray).Set(["armholes"])
    prim.CreateAttribute("tailor:seam:sleeve:width", Sdf.ValueTypeNames.Float).Set(0.8)
offset = prim.CreateAttribute("tailor:seam:sleeve:normalOffset", Sdf.ValueTypeNames.Float)
def after(value):
    offset.Set(value)
    return points(stage, "render")
groove, ridge, again = after(-0.1), after(0.1), after(-0.1)
away = max(sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5 for a, b in zip(groove, ridge))
say(plain=plain, sewn=len(groove), same=groove == again, away=away)
""",
        tmp_path / "shot.usda",
        named_by,
    )
    assert (found["sewn"] > found["plain"]) == (named_by == "schema"), "the file's seam is there from the beginning"
    assert found["same"] and 0.1 < found["away"] < 1
    assert "TF_CODING_ERROR" not in said and "Coding Error" not in said


@pytest.mark.parametrize("held", ["nobody", "another stage"])
def test_a_reload_reads_the_edited_source_though_an_old_one_is_in_memory(plugin, shirt, tmp_path, held):
    shirt()
    shot = tmp_path / "shot.usda"
    shot.write_text('#usda 1.0\ndef "A" (payload = @shirt.tailor@)\n{\n}\n')
    found, _ = plugin.run(
        """
import os
shot, source, held = sys.argv[1:]
other = Usd.Stage.Open(source) if held == "another stage" else None
stage = Usd.Stage.Open(shot)
before = points(stage, "model")
edited = Sdf.Layer.OpenAsAnonymous(source)
def move(path):
    spec = edited.GetAttributeAtPath(path)
    if path.name == "points" and spec and spec.default:
        spec.default = type(spec.default)([point * 2 for point in spec.default])
edited.Traverse("/", move)
edited.Export(source)
os.utime(source, (2_000_000_000, 2_000_000_000))
stage.Reload()
say(before=before[0], after=points(stage, "model")[0])
os.rename(source, source + ".away")
say(gone=errors_of(stage.Reload), kept=points(stage, "model")[0])
os.rename(source + ".away", source)
os.utime(source, (2_000_000_100, 2_000_000_100))
say(back=errors_of(stage.Reload))
""",
        shot,
        tmp_path / "shirt.usda",
        held,
    )
    assert found["after"] == pytest.approx([2 * number for number in found["before"]])
    [error] = found["gone"]
    assert "shirt.usda cannot be found" in error
    assert found["kept"] == found["after"]
    assert found["back"] == []


@pytest.mark.parametrize("threads", [1, 4])
def test_many_payloads_open_at_once(plugin, shirt, tmp_path, threads):
    shirt()
    shot = tmp_path / "shot.usda"
    # Every other one shares its layer with its neighbour.
    prims = [
        f'def "A{i}" (payload = @shirt.tailor:SDF_FORMAT_ARGS:sim.maxEdgeLength={10 + i // 2}@)\n{{\n}}\n' for i in range(64)
    ]
    shot.write_text("#usda 1.0\n" + "".join(prims))
    script = 'stage = Usd.Stage.Open(sys.argv[1])\nsay(count=sum(prim.GetName() == "sim" for prim in stage.Traverse()))'
    found, _ = plugin.run(script, shot, PXR_WORK_THREAD_LIMIT=str(threads))
    assert found["count"] == 64


def test_depends_on_all_layers_of_its_source_and_of_other_recipes(plugin, shirt, tmp_path):
    shirt("inner.tailor")
    outer = shirt("outer.tailor", "root.usda")
    (tmp_path / "root.usda").write_text("#usda 1.0\n(\nsubLayers = [@over.usda@, @inner.tailor@]\n)\n")
    (tmp_path / "over.usda").write_text("#usda 1.0\n")
    script = "say(used=sorted(Sdf.Layer.FindOrOpen(sys.argv[1]).GetExternalAssetDependencies()))"
    found, _ = plugin.run(script, outer)
    names = ["inner.tailor", "over.usda", "root.usda", "shirt.usda"]
    assert found["used"] == [str(tmp_path / name) for name in names]


def test_is_not_written(plugin, shirt, tmp_path):
    out = tmp_path / "out.tailor"
    script = "layer = Sdf.Layer.FindOrOpen(sys.argv[1])\nsay(errors=errors_of(lambda: layer.Export(sys.argv[2])))"
    found, _ = plugin.run(script, shirt(), out)
    assert any("tailor" in error for error in found["errors"])
    assert not out.exists()


def test_exports_nothing(plugin):
    library = plugin.folder / "libusdTailor.so"
    done = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    # The same tool does list what the library needs.
    needed = subprocess.run(["nm", "-D", "--undefined-only", library], capture_output=True, text=True, check=True)
    assert "13SdfFileFormat" in needed.stdout


def verify(plugin, *args):
    xtask = os.environ["USDTAILOR_XTASK"]
    command = [xtask, "plugin", "verify", "--python", plugin.python, *map(str, args)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)


def test_the_check_accepts_the_wheel(plugin):
    done = verify(plugin)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("define", "said"),
    [
        ("TAILOR_BREAK_SLOTS", r"SdfFileFormat, slot 10: declared WriteToStream\(.*, found ReadFromString\("),
        ("TAILOR_BREAK_MEMBERS", r"SdfFileFormat, the member of GetTarget: declared offset -1, found offset 40\n"),
        ("TAILOR_BREAK_MEMBERS", r"SdfFileFormat, size: declared \d+ bytes, found \d+ bytes\n"),
    ],
)
def test_the_check_refuses_headers_that_differ(plugin, define, said):
    done = verify(plugin, "--define", define)
    assert done.returncode == 1
    assert re.search(said, done.stderr), done.stderr
    assert "hint: " in done.stderr


def test_the_check_refuses_headers_of_another_wheel(plugin):
    others = sorted(path.parent for path in plugin.folder.parent.glob("usd_plugin-build/wheel-*/tailorWheel.h"))
    release = plugin.version.split(".")[:2]
    for other in (folder for folder in others if folder.name.removeprefix("wheel-").split(".")[:2] != release):
        done = verify(plugin, "--headers", other)
        assert done.returncode == 1
        abi = "_GLIBCXX_USE_CXX11_ABI is not that of the wheel"
        namespace = re.search(r"PXR_INTERNAL_NS (\S+)", (other / "tailorWheel.h").read_text()).group(1)
        assert abi in done.stderr or f"all classes, namespace: declared {namespace}" in done.stderr
