"""Chains of references, levels of prims and arcs that multiply are bounded before they are composed."""

import re
import time

import pytest
from conftest import long_test, run
from pxr import Sdf
from runs import good, mounted, refused
from sources import write


def chain(folder, length):
    """Layers that each reference the next one, down to the garment."""
    below = write(folder / "in.usda")
    for i in range(length):
        below = mounted(folder / f"c{i}.usda", f'def "Coat" (\n    references = @./{below.name}@</Coat>\n)\n{{\n}}')
    return below


def test_a_long_chain_of_references_composes_or_is_told(usdtailor, tmp_path):
    good(usdtailor, "check", chain(tmp_path, 60))
    done = refused(usdtailor, "check", chain(tmp_path, 110), says=["references are nested too deeply at /Coat"])
    assert "cycle" not in done.stderr


def test_a_cycle_is_called_one(usdtailor, tmp_path):
    write(tmp_path / "in.usda")
    mounted(tmp_path / "a.usda", 'def "Coat" (\n    references = [@./b.usda@</Coat>, @./in.usda@</Coat>]\n)\n{\n}')
    mounted(tmp_path / "b.usda", 'def "Coat" (\n    references = @./a.usda@</Coat>\n)\n{\n}')
    done = run(usdtailor, "check", tmp_path / "a.usda")
    assert "composition arc cycle at /Coat" in done.stderr


@pytest.mark.parametrize("levels, words", [(300, "prims at more than 256 levels"), (5000, "more than 1000 levels of braces"), (100_000, "more than 1000 levels of braces")])
def test_many_levels_are_refused(usdtailor, tmp_path, levels, words):
    deep = tmp_path / "deep.usda"
    deep.write_text("#usda 1.0\n" + "".join(f'def "p{i}" {{\n' for i in range(levels)) + "}\n" * levels)
    refused(usdtailor, "check", deep, says=[words], seconds=60)


def test_many_levels_of_a_crate_are_refused(usdtailor, tmp_path):
    layer = Sdf.Layer.CreateNew(str(tmp_path / "deep.usdc"))
    for prefix in Sdf.Path("/p" * 2000).GetPrefixes():
        Sdf.CreatePrimInLayer(layer, prefix).specifier = Sdf.SpecifierDef
    layer.Save()
    refused(usdtailor, "check", tmp_path / "deep.usdc", says=["prims at more than 256 levels"], seconds=60)


@long_test
def test_prims_that_references_multiply_are_refused(usdtailor, tmp_path):
    write(tmp_path / "in.usda")
    text = 'def "L0" (references = @./in.usda@</Coat>)\n{\n}\n'
    for i in range(1, 19):
        text += f'def "L{i}"\n{{\n    def "a" (references = </L{i - 1}>) {{}}\n    def "b" (references = </L{i - 1}>) {{}}\n}}\n'
    mounted(tmp_path / "many.usda", text)
    refused(usdtailor, "check", tmp_path / "many.usda", says=["error[too-large]", "takes more than 1 GB to compose"], seconds=300)


def garment_below(folder, text):
    """The garment beside prims that refer to it, which no text names `Coat`."""
    write(folder / "in.usda")
    return mounted(folder / "many.usda", text + 'def "Coat" (references = @./in.usda@</Coat>)\n{\n}')


def levels(count, arc, prim="{}{}", start="def"):
    """Levels of two prims, each of which has an arc to both of the level below."""
    text = "".join(f'{start} "{prim.format(name, 0)}" {{}}\n' for name in "ab")
    for i in range(1, count):
        targets = ", ".join(f"</{prim.format(name, i - 1)}>" for name in "ab")
        text += "".join(f'{start} "{prim.format(name, i)}" ({arc} = [{targets}]) {{}}\n' for name in "ab")
    return text


@pytest.mark.parametrize("arc", ["references", "payload", "inherits", "specializes", "prepend references"])
def test_arcs_that_multiply_within_a_prim_are_refused(usdtailor, tmp_path, arc):
    top = garment_below(tmp_path, levels(18, arc))
    start = time.monotonic()
    done = refused(usdtailor, "check", top, says=["error[composition-failed]", "has more than 2000 references", "many.usda", "hint: "], seconds=30)
    assert re.search(r"/[ab]\d+ in ", done.stderr), done.stderr
    assert time.monotonic() - start < 5


@pytest.mark.parametrize("kind", ["files", "sublayers", "crate", "children", "variants"])
def test_arcs_that_multiply_are_refused_wherever_they_are(usdtailor, tmp_path, kind):
    if kind == "files":
        for i in range(18):
            below = ", ".join(f"@./{name}{i - 1}.usda@</P>" for name in "ab")
            for name in "ab":
                (tmp_path / f"{name}{i}.usda").write_text(f'#usda 1.0\ndef "P" {f"(references = [{below}])" if i else ""} {{}}\n')
        top = garment_below(tmp_path, 'def "P" (references = @./a17.usda@</P>) {}\n')
    elif kind == "sublayers":
        (tmp_path / "below.usda").write_text("#usda 1.0\n" + levels(18, "references", start="over"))
        top = garment_below(tmp_path, "")
        top.write_text(top.read_text().replace("(", "(\n    subLayers = [@./below.usda@]", 1))
    elif kind == "crate":
        top = garment_below(tmp_path, levels(18, "references"))
        Sdf.Layer.FindOrOpen(str(top)).Export(str(tmp_path / "many.usdc"))
        top = tmp_path / "many.usdc"
    elif kind == "children":
        # The prims that the arcs lead to are below others with arcs.
        text = levels(9, "references") + "".join(f'def "u{i}" (references = </a8>) {{ def "x" {{}} }}\n' for i in range(5))
        top = garment_below(tmp_path, text + f'def "All" (references = [{", ".join(f"</u{i}/x>" for i in range(5))}]) {{}}\n')
    else:
        variant = '(variants = { string v = "one" }  prepend variantSets = "v") { variantSet "v" = { "one" (references = [</a16>, </b16>]) {} } }'
        top = garment_below(tmp_path, levels(17, "references") + f'def "All" {variant}\n')
    refused(usdtailor, "check", top, says=["has more than 2000 references"], seconds=30)


def test_many_plain_references_build(usdtailor, tmp_path):
    listed = ", ".join(f"</p{i}>" for i in range(1000))
    top = garment_below(tmp_path, "".join(f'def "p{i}" {{}}\n' for i in range(1000)) + f'def "All" (references = [{listed}]) {{}}\n')
    good(usdtailor, "check", top)
    # Of variants, one is taken.
    variants = "".join(f'"v{i}" (references = [{listed}]) {{}}\n' for i in range(4))
    text = "".join(f'def "p{i}" {{}}\n' for i in range(1000)) + f'def "All" (variants = {{ string v = "v1" }}  prepend variantSets = "v") {{ variantSet "v" = {{ {variants} }} }}\n'
    good(usdtailor, "check", garment_below(tmp_path, text))
