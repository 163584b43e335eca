"""OpenUSD opens payloads on many threads; each process here has its own limit of them."""

import pytest
import sources
from tailor_file import needs_plugin, recipe, script

pytestmark = needs_plugin

# 64 payloads: of one file with many arguments, of files of their own, and nested ones.
OPEN_ALL = """
import sys, threading
from pxr import Sdf, Usd
folder = sys.argv[1]

def populate():
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer, Usd.Stage.LoadNone)
    for i in range(64):
        prim = stage.DefinePrim(f"/Shot/Coat{i}")
        prim.GetPayloads().AddPayload(f"{folder}/{['coat', 'other', 'nested'][i % 3]}.tailor")
        prim.CreateAttribute("tailor:render:level", Sdf.ValueTypeNames.Int).Set(i % 4 // 2)
        prim.CreateAttribute("tailor:sim:maxEdgeLength", Sdf.ValueTypeNames.Float).Set(0.5 + i // 16)
    return layer

def check(stage):
    for i in range(64):
        for name in ("sim", "render"):
            assert stage.GetPrimAtPath(f"/Shot/Coat{i}/{name}").GetAttribute("points").Get(), (i, name)
        assert len(stage.GetPrimAtPath(f"/Shot/Coat{i}/render").GetAttribute("faceVertexCounts").Get()) == 12 * 4 ** (i % 4 // 2)
"""


@pytest.fixture
def folder(tmp_path):
    sources.write(tmp_path / "coat.usda", seam_column=2)
    recipe(tmp_path / "coat.tailor", "coat.usda")
    recipe(tmp_path / "other.tailor", "coat.usda", sim={"iterations": 2})
    # A source that has products of another `.tailor` file in it.
    (tmp_path / "over.usda").write_text('#usda 1.0\n(\n    defaultPrim = "Coat"\n    subLayers = [@./other.tailor@]\n)\n')
    recipe(tmp_path / "nested.tailor", "over.usda", prim="/Coat/model")
    return tmp_path


@pytest.mark.parametrize("limit", [1, 2, 8, -1])
def test_64_payloads_open_in_parallel(folder, limit):
    text = OPEN_ALL + "stage = Usd.Stage.Open(populate())\ncheck(stage)\nprint('done')\n"
    assert script(text, folder, PXR_WORK_THREAD_LIMIT=str(limit)) == "done\n"


def test_stages_open_on_threads_of_python(folder):
    text = OPEN_ALL + """
layers = [populate() for _ in range(4)]
faults = []

def work(layer):
    try:
        check(Usd.Stage.Open(layer))
    except BaseException as fault:
        faults.append(fault)

threads = [threading.Thread(target=work, args=[layer]) for layer in layers]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert not faults, faults
print("done")
"""
    assert script(text, folder) == "done\n"


def test_the_data_do_not_depend_on_the_threads(folder):
    text = """
import hashlib, sys
from pxr import Sdf
for name in ("coat", "other", "nested"):
    print(hashlib.sha256(Sdf.Layer.FindOrOpen(f"{sys.argv[1]}/{name}.tailor").ExportToString().encode()).hexdigest())
"""
    said = {script(text, folder, PXR_WORK_THREAD_LIMIT=str(limit)) for limit in (1, 2, 8)}
    assert len(said) == 1 and len(said.pop().split()) == 3


def test_a_forked_child_opens_payloads_too(folder):
    """The child has none of the threads that its parent started."""
    text = OPEN_ALL + """
import os, signal
check(Usd.Stage.Open(populate()))
child = os.fork()
if child == 0:
    signal.alarm(120)
    check(Usd.Stage.Open(populate()))
    os._exit(0)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    assert script(text, folder) == "0\n"
