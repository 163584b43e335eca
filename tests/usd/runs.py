"""Runs of the program that are refused or good, and what is in their outputs."""

import subprocess

import numpy
from conftest import run
from pxr import Usd, UsdGeom


def refused(usdtailor, *args, says=(), seconds=60):
    """Runs the program, which must refuse in words and in time."""
    done = subprocess.run([usdtailor, *map(str, args)], capture_output=True, text=True, check=False, timeout=seconds)
    assert done.returncode == 1, (args, done.returncode, done.stdout, done.stderr)
    for words in says:
        assert words in done.stderr, done.stderr
    return done


def good(usdtailor, *args):
    done = run(usdtailor, *args)
    assert done.returncode == 0, (args, done.stderr)
    return done


def mounted(path, text):
    """Writes a layer with some prims."""
    path.write_text(f'#usda 1.0\n(\n    defaultPrim = "Coat"\n)\n{text}\n')
    return path


def meshes(path):
    """The names of the meshes with points."""
    stage = Usd.Stage.Open(str(path))
    return sorted(prim.GetName() for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh) and UsdGeom.Mesh(prim).GetPointsAttr().Get())


def sim_points(path):
    stage = Usd.Stage.Open(str(path))
    return numpy.array(UsdGeom.Mesh(stage.GetPrimAtPath("/Coat/sim")).GetPointsAttr().Get())


def warnings(product):
    """The codes and messages of the warnings in a product's report."""
    return [(warning["code"], warning["message"]) for warning in product.report["warnings"]]
