"""The builders of small stages make what they say."""

import pytest
import sources
from mesh import find_model, read_mesh
from pxr import Usd
from test_sources import CASES, INTERPOLATIONS, VALUE_TYPES


@pytest.mark.parametrize("source", [pytest.param(source, id=name) for name, source in CASES.items()])
def test_sources_can_be_read(tmp_path, source):
    stage = Usd.Stage.Open(str(sources.write(tmp_path / "coat.usda", **source)))
    mesh = read_mesh(find_model(stage))
    assert len(mesh.indices) == mesh.counts.sum()


@pytest.mark.parametrize("type_name", VALUE_TYPES)
def test_primvars_have_their_type_and_length(tmp_path, type_name):
    primvars = [
        {"name": f"{interpolation}{'Indexed' * indexed}", "type_name": type_name, "interpolation": interpolation, "indexed": indexed}
        for interpolation in INTERPOLATIONS
        for indexed in (False, True)
    ]
    stage = Usd.Stage.Open(str(sources.write(tmp_path / "coat.usda", primvars=primvars)))
    mesh = read_mesh(find_model(stage))
    lengths = {"constant": 1, "uniform": len(mesh.counts), "vertex": len(mesh.points), "varying": len(mesh.points), "faceVarying": len(mesh.indices)}
    for primvar in primvars:
        found = mesh.primvars[primvar["name"]]
        assert found.type_name == f"{type_name}[]"
        assert len(found.flat) == lengths[primvar["interpolation"]]
