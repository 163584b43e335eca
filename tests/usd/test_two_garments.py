"""Two garments below one root, built one over the other."""

import pytest
from conftest import run
from pxr import Usd, UsdGeom
from test_batch import sheet


@pytest.fixture
def suit(tmp_path):
    """A stage with the models /Suit/shirt and /Suit/belt."""
    for name, size in (("shirt", (30, 40)), ("belt", (40, 4))):
        (tmp_path / f"{name}.usda").write_text(sheet(*size))
    path = tmp_path / "suit.usda"
    body = "".join(f'    def "{name}" ( references = @./{name}.usda@</G/model> ) {{}}\n' for name in ("shirt", "belt"))
    path.write_text(f'#usda 1.0\n(\n    defaultPrim = "Suit"\n    metersPerUnit = 0.01\n)\ndef Xform "Suit"\n{{\n{body}}}\n')
    return path


def counts(stage, name):
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/Suit/{name}"))
    return len(mesh.GetPointsAttr().Get()), len(mesh.GetFaceVertexCountsAttr().Get())


def test_a_garment_does_not_hide_the_products_of_another(usdtailor, suit, tmp_path):
    first, both = tmp_path / "first.usda", tmp_path / "both.usda"
    assert run(usdtailor, "build", suit, "-o", first, "--prim", "/Suit/shirt").returncode == 0
    refused = run(usdtailor, "build", first, "-o", both, "--prim", "/Suit/belt")
    assert refused.returncode == 1 and not both.exists()
    assert "/Suit/sim was made from /Suit/shirt" in refused.stderr
    assert "--sim-name belt_sim --render-name belt_render" in refused.stderr
    names = ("--sim-name", "belt_sim", "--render-name", "belt_render")
    assert run(usdtailor, "build", first, "-o", both, "--prim", "/Suit/belt", *names).returncode == 0

    before, after = Usd.Stage.Open(str(first)), Usd.Stage.Open(str(both))
    for name in ("sim", "render"):
        assert counts(after, name) == counts(before, name)
        assert after.GetPrimAtPath(f"/Suit/belt_{name}").IsActive()
    assert after.GetPrimAtPath("/Suit/physics").GetChildren()
    assert after.GetPrimAtPath("/Suit/belt_sim_physics").GetChildren()


def test_the_same_garment_is_built_again_over_its_own_products(usdtailor, suit, tmp_path):
    first, again = tmp_path / "first.usda", tmp_path / "again.usda"
    assert run(usdtailor, "build", suit, "-o", first, "--prim", "/Suit/shirt").returncode == 0
    done = run(usdtailor, "build", first, "-o", again, "--prim", "/Suit/shirt", "--set", "sim.maxEdgeLength=4")
    assert done.returncode == 0, done.stderr
    assert counts(Usd.Stage.Open(str(again)), "sim")[1] < counts(Usd.Stage.Open(str(first)), "sim")[1]
