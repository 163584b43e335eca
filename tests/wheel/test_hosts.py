"""The examples for Houdini and Maya, with stand-ins for the parts of these programs that they use."""

import sys
from pathlib import Path

import pytest
import usd_tailor
from pxr import Sdf, Usd, UsdGeom

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
sys.path += [str(EXAMPLES / "houdini"), str(EXAMPLES / "maya")]
import export_sets  # noqa: E402
import tailor_lop  # noqa: E402

GARMENT = EXAMPLES / "tshirt.usda"


class Node:
    """A LOP: its input is a stage, and its own layer lies over the layers of that."""

    def __init__(self, **parameters):
        self.parameters = parameters
        self.source = Usd.Stage.Open(str(GARMENT))
        root = Sdf.Layer.CreateAnonymous()
        self.active = Sdf.Layer.CreateAnonymous()
        root.subLayerPaths = [self.active.identifier, str(GARMENT)]
        self.edited = Usd.Stage.Open(root)
        self.edited.SetEditTarget(self.active)

    def inputs(self):
        return [self]

    def stage(self):
        return self.source

    def editableStage(self):
        return self.edited

    def parm(self, name):
        return Parameter(self.parameters[name]) if name in self.parameters else None


class Parameter:
    def __init__(self, value):
        self.value = value

    def evalAsString(self):
        return self.value


def test_a_lop_adds_products_to_its_layer_and_keeps_what_is_there():
    node = Node(options="# coarse\nsim.maxEdgeLength = 4\nrender.level=1\n")
    node.edited.OverridePrim("/Tshirt/model").SetDisplayName("mine")
    node.edited.DefinePrim("/Set/floor", "Plane")
    built = tailor_lop.cook(node)
    for name in ("sim", "render"):
        mesh = UsdGeom.Mesh(node.edited.GetPrimAtPath(f"/Tshirt/{name}"))
        assert len(mesh.GetFaceVertexCountsAttr().Get()) == built.report[name]["faces"]
    assert built.report["recipe"]["sim"]["maxEdgeLength"] == 4
    assert node.edited.GetPrimAtPath("/Tshirt/model").GetDisplayName() == "mine"
    assert node.edited.GetPrimAtPath("/Set/floor").GetTypeName() == "Plane"
    assert UsdGeom.Imageable(node.edited.GetPrimAtPath("/Tshirt/model")).ComputePurpose() == "guide"
    assert not node.source.GetPrimAtPath("/Tshirt/sim")


@pytest.mark.parametrize("parameters, words", [({"options": "sim.maxEdgeLength=-1"}, "sim.maxEdgeLength"), ({"garment": "/Tshirt/none"}, "/Tshirt/none")])
def test_what_is_refused_is_the_nodes_error(parameters, words):
    node = Node(**parameters)
    with pytest.raises(usd_tailor.TailorError, match=words):
        tailor_lop.cook(node)
    assert not node.active.rootPrims


class Commands:
    """The commands of Maya for a scene of one mesh with three sets, and the set of a material."""

    sets_of = {
        "seam": ["|coat.e[0:1]", "|coat.f[9]"],
        "front panel": ["|coat.f[0:2]"],
        "buttons": ["|coat.vtx[4]", "|other.vtx[1]"],
        "lambertSG": ["|coat.f[0:3]"],
    }

    def ls(self, *names, type=None, flatten=False, long=False):
        if type == "objectSet":
            return list(self.sets_of)
        if not flatten:
            return [f"{name}|{name.strip('|')}Shape" for name in names]
        found = []
        for name in names[0]:
            shape, _, rest = name.partition("[")
            first, _, last = rest.rstrip("]").partition(":")
            found += [f"{shape}[{number}]" for number in range(int(first), int(last or first) + 1)]
        return found

    def nodeType(self, name):
        return "shadingEngine" if name == "lambertSG" else "objectSet"

    def sets(self, name, query):
        return self.sets_of[name]

    def listRelatives(self, name, shapes, fullPath):
        return [f"{name}|{name.strip('|')}Shape"]

    def polyInfo(self, edge, edgeToVertex):
        number = int(edge.rpartition("[")[2].rstrip("]"))
        return [f"EDGE      {number}:      {10 * number}      {10 * number + 1}  Hard\n"]


def test_sets_of_maya_are_subsets_of_the_export():
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/coat")
    export_sets.author(Commands(), stage, {"|coat|coatShape": "/coat"})
    found = {
        (subset.GetPrim().GetName(), subset.GetElementTypeAttr().Get()): list(subset.GetIndicesAttr().Get())
        for subset in UsdGeom.Subset.GetAllGeomSubsets(mesh)
    }
    assert found[("front_panel", "face")] == [0, 1, 2] and found[("buttons", "point")] == [4]
    assert found[("seam_edge", "edge")] == [0, 1, 10, 11] and found[("seam_face", "face")] == [9]
    assert not any("lambert" in name for name, _ in found)
