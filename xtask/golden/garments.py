"""Writes the garments in examples/ for the generator of the golden data: garments.py FILE; garments.cpp reads it."""

import struct
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "usd"))

from golden import BOUNDARIES, GARMENTS, SCHEMES, garment_values  # noqa: E402
from mesh import find_model, read_mesh  # noqa: E402
from pxr import Usd  # noqa: E402


def packed(kind, values):
    return np.ascontiguousarray(values, np.dtype(kind).newbyteorder("<")).tobytes()


def counted(items):
    return struct.pack("<I", len(items)) + b"".join(items)


def case(name):
    stage = Usd.Stage.Open(str(ROOT / "examples" / f"{name.split()[0]}.usda"))
    mesh = read_mesh(find_model(stage))
    vertex, varying, uv = garment_values(mesh, name)
    rows = np.concatenate([vertex, varying], axis=1)
    options = (SCHEMES.index(mesh.scheme), BOUNDARIES.index(mesh.boundary), mesh.triangles == "smooth")
    return b"".join(
        [
            struct.pack("<H", len(name)) + name.encode() + bytes(options),
            counted([packed("f4", row) for row in rows]),
            counted([packed("u2", count) for count in mesh.counts]),
            counted([packed("u2", vertex) for vertex in mesh.indices]),
            counted([struct.pack("<HHf", *pair, sharpness) for pair, sharpness in mesh.creases.items()]),
            counted([struct.pack("<Hf", vertex, sharpness) for vertex, sharpness in mesh.corners.items()]),
            counted([packed("u2", hole) for hole in mesh.holes]),
            counted([packed("f4", row) for row in uv.rows]),
            packed("u2", uv.corner_indices()),
        ]
    )


Path(sys.argv[1]).write_bytes(b"".join(map(case, GARMENTS)))
