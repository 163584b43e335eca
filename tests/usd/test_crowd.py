"""A garment on the bodies of a crowd: its products on each."""

import numpy as np
import pytest
from fitting import fit, radii
from pxr import Usd, UsdGeom
from runs import good
from sources import add_subset
from test_fit import sleeve  # noqa: F401


@pytest.mark.parametrize("way", ["fit", "recipe"])
def test_a_crowd_has_the_same_triangles_on_every_body(usdtailor, sleeve, tmp_path, way):
    """Caches, weights and wraps are then of all bodies. A sheared fit would change the triangles of a mesh of its own."""
    paths = sleeve(lambda mesh: add_subset(mesh, name="half", indices=list(range(120))))
    built, made = {}, ("--set", "sim.asMade=true")
    good(usdtailor, "build", paths["sleeve"], "-o", tmp_path / "arm_built.usda", *made)
    for name in ("thick", "long"):
        fitted, built[name] = tmp_path / f"{name}_fit.usda", tmp_path / f"{name}_built.usda"
        if way == "fit":
            fit(usdtailor, paths["sleeve"], "--from", paths["arm"], "--to", paths[name], "-o", fitted)
            good(usdtailor, "build", fitted, "-o", built[name], *made)
        else:
            good(usdtailor, "build", paths["sleeve"], "-o", built[name], "--set", f"fit.from={paths['arm']}", "--set", f"fit.to={paths[name]}", *made)
    stages = {name: Usd.Stage.Open(str(tmp_path / f"{name}_built.usda")) for name in ("arm", "thick", "long")}
    sims = {name: UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/sim")) for name, stage in stages.items()}
    triangles = {name: np.array(sim.GetFaceVertexIndicesAttr().Get()) for name, sim in sims.items()}
    points = {name: np.array(sim.GetPointsAttr().Get(), float) for name, sim in sims.items()}
    for name in ("thick", "long"):
        assert np.array_equal(triangles[name], triangles["arm"])
        # It lies on the fitted garment: as the cage on this body, and between its points.
        cage = np.array(UsdGeom.Mesh(stages[name].GetPrimAtPath("/Coat/model")).GetPointsAttr().Get(), float)
        model = np.array(UsdGeom.Mesh(stages["arm"].GetPrimAtPath("/Coat/model")).GetPointsAttr().Get(), float)
        assert np.ptp(cage[:, 1]) != np.ptp(model[:, 1])
        nearest = [np.linalg.norm(model - p, axis=1).argsort()[:4] for p in points["arm"]]
        moved = np.array([(cage[n] - model[n]).mean(axis=0) for n in nearest])
        assert np.abs(points[name] - points["arm"] - moved).max() < 0.25
        assert np.abs(radii(points[name]) - np.interp(points[name][:, 1], *rings(cage))).max() < 0.06
        # Sets are of the same triangles too.
        sets = [list(UsdGeom.Subset(stage.GetPrimAtPath("/Coat/sim/half")).GetIndicesAttr().Get()) for stage in (stages["arm"], stages[name])]
        assert len(set(sets[0]) ^ set(sets[1])) <= 0.03 * len(sets[0])
    # Each without the option has its own.
    good(usdtailor, "build", built["thick"].with_name("thick_fit.usda") if way == "fit" else paths["sleeve"], "-o", tmp_path / "own.usda", *([] if way == "fit" else ["--set", f"fit.from={paths['arm']}", "--set", f"fit.to={paths['thick']}"]))
    own = Usd.Stage.Open(str(tmp_path / "own.usda"))
    assert not np.array_equal(np.array(UsdGeom.Mesh(own.GetPrimAtPath("/Coat/sim")).GetFaceVertexIndicesAttr().Get()), triangles["arm"])


def test_products_that_a_fit_leaves_are_told(usdtailor, sleeve, tmp_path):
    paths, built = sleeve(), tmp_path / "built.usda"
    good(usdtailor, "build", paths["sleeve"], "-o", built)
    done = fit(usdtailor, built, "--from", paths["arm"], "--to", paths["thick"], "-o", tmp_path / "out.usda")
    assert "warning[not-carried]: the products of /Coat/model: not carried: they stay on the first body" in done.stderr



def rings(cage):
    """Heights and radii of the rings of a tube."""
    order = np.argsort(cage[:, 1])
    return cage[order, 1], radii(cage[order])
