"""Where the numbers of a recipe come from, and which of several counts."""

import json

import pytest
import sources
from conftest import run
from pxr import Sdf


def level_on_prim(level):
    def author(mesh):
        mesh.GetPrim().AddAppliedSchema("TailorRenderAPI")
        mesh.GetPrim().CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int, False, Sdf.VariabilityUniform).Set(level)

    return author


def recipe_file(folder, **content):
    path = folder / "coat.tailor"
    path.write_text(json.dumps(content))
    return path


def level_of(product):
    """How often the twelve faces were subdivided."""
    return {12: 0, 48: 1, 192: 2, 768: 3}[len(product.render.counts)]


@pytest.mark.parametrize(
    "prim, recipe, flag, expected",
    [(None, None, None, 2), (1, None, None, 1), (2, 3, None, 3), (2, 3, 0, 0), (None, 2, None, 2), (2, None, 0, 0)],
)
def test_flag_before_file_before_prim_before_fallback(build, tmp_path, prim, recipe, flag, expected):
    source = sources.write(tmp_path / "coat.usda", finish=None if prim is None else level_on_prim(prim))
    args = [] if recipe is None else ["--recipe", recipe_file(tmp_path, render={"level": recipe})]
    args += [] if flag is None else ["--set", f"render.level={flag}"]
    assert level_of(build(source, *args)) == expected


def test_recipe_on_the_prim_is_the_same_as_flags(build, tmp_path):
    def author(mesh):
        prim = mesh.GetPrim()
        prim.AddAppliedSchema("TailorSimAPI")
        for name, kind, value in (("maxEdgeLength", Sdf.ValueTypeNames.Float, 0.4), ("minEdgeLength", Sdf.ValueTypeNames.Float, 0.4)):
            prim.CreateAttribute(f"tailor:sim:{name}", kind, False, Sdf.VariabilityUniform).Set(value)

    authored = build(sources.write(tmp_path / "authored.usda", finish=author), stem="authored-out")
    flagged = build(sources.write(tmp_path / "plain.usda"), "--set", "sim.maxEdgeLength=0.4", "--set", "sim.minEdgeLength=0.4", stem="plain-out")
    assert (authored.sim.points == flagged.sim.points).all()
    assert (authored.sim.indices == flagged.sim.indices).all()


def test_constraints_are_edge_subsets_named_by_a_relationship(build, tmp_path):
    """An edge set inside a panel is kept as edges when the recipe names it."""

    def author(mesh):
        sources.add_subset(mesh, name="fold", indices=[7, 12], element="edge", family="edges")
        mesh.GetPrim().AddAppliedSchema("TailorSimAPI")
        mesh.GetPrim().CreateRelationship("tailor:sim:constraints", False).AddTarget(mesh.GetPath().AppendChild("fold"))

    product = build(sources.write(tmp_path / "coat.usda", finish=author))
    pairs = product.sim.subsets["fold"].pairs
    assert len(pairs) > 0
    assert (product.sim.topology.edge_ids(pairs) >= 0).all()


@pytest.mark.parametrize(
    "args, words",
    [
        (["--set", "sim.maxEdgeLenght=2"], ["sim.maxEdgeLenght", "maxEdgeLength"]),
        (["--set", "sim.maxEdgeLength=wide"], ["sim.maxEdgeLength", "wide"]),
        (["--set", "sim.maxEdgeLength=-1"], ["sim.maxEdgeLength", "-1"]),
        (["--set", "sim.maxEdgeLength=nan"], ["sim.maxEdgeLength"]),
        (["--set", "render.level"], ["render.level"]),
    ],
)
def test_bad_settings_are_refused_by_name(usdtailor, tmp_path, args, words):
    source = sources.write(tmp_path / "coat.usda")
    done = run(usdtailor, "build", source, "-o", tmp_path / "built.usda", *args)
    assert done.returncode in (1, 2)
    assert all(word in done.stderr for word in words), done.stderr
    assert not (tmp_path / "built.usda").exists()


@pytest.mark.parametrize("text, words", [('{"sim": {\n  "maxEdgeLenght": 2}}', ["maxEdgeLenght", "line 2"]), ('{"sim": ', ["line 1"])])
def test_bad_recipe_files_are_refused_with_their_place(usdtailor, tmp_path, text, words):
    source, recipe = sources.write(tmp_path / "coat.usda"), tmp_path / "coat.tailor"
    recipe.write_text(text)
    done = run(usdtailor, "build", source, "-o", tmp_path / "built.usda", "--recipe", recipe)
    assert done.returncode == 1
    assert all(word in done.stderr for word in words), done.stderr
    assert not (tmp_path / "built.usda").exists()
