"""The independent subdivision against the stored results of OpenSubdiv, so that the two references agree."""

import numpy as np
import pytest
from catmull_clark import Subdivision, cage
from conftest import ROOT
from golden import RULES, load

# Faces that use an edge twice: OpenSubdiv counts such edges twice, and usdtailor refuses such faces.
REFUSED = ("nonman_repeated", "quadpole")
FILES = ["catmark", "generated", "nonmanifold", "bilinear"]
# Shares of the box; OpenSubdiv worked in float32, our sharpness too is compared as such.
NEAR = 2e-6


def refine(case, level):
    made = cage(
        case.counts,
        case.indices,
        len(case.points),
        creases=case.creases,
        corners=case.corners,
        boundary=case.boundary,
        triangles=case.triangles,
        scheme=case.scheme,
    )
    return Subdivision(made, level)


def faults(case):
    """What differs, by level."""
    size = max(np.ptp(case.points, axis=0).max(), 1e-30)
    uv_size = max(np.ptp(case.uvs, axis=0).max(), 1e-30) if len(case.uvs) else 1
    for number, level in enumerate(case.levels, start=1):
        made = refine(case, number)
        verts = made.cage.verts.reshape(-1, 4)
        if (made.cage.face_count, len(made.cage.edges)) != (level.faces, level.edges):
            yield f"level {number}: {made.cage.face_count} faces and {len(made.cage.edges)} edges, not {level.faces} and {level.edges}"
            return
        points, varying = made.vertex(case.points), made.varying(case.varying)
        parents = made.parent_face()
        by_rule = {rule: made.face_varying(case.uvs, case.uv_indices, rule)[0].reshape(-1, 4, 2) for rule in RULES}
        for face in level.samples:
            if parents[face.index] != face.base_face:
                yield f"level {number}, face {face.index}: parent {parents[face.index]}, not {face.base_face}"
            if np.abs(points[verts[face.index]] - face.points).max() > NEAR * size:
                yield f"level {number}, face {face.index}: points"
            if np.abs(varying[verts[face.index]] - face.varying).max() > NEAR * max(np.abs(case.varying).max(), 1):
                yield f"level {number}, face {face.index}: varying"
            for rule, slot in zip(RULES, case.slots):
                if np.abs(by_rule[rule][face.index] - face.slots[:, slot]).max() > NEAR * uv_size:
                    yield f"level {number}, face {face.index}: face-varying, rule {rule}"


@pytest.mark.parametrize("file", FILES)
def test_agrees_with_open_subdiv(file):
    cases = [case for case in load(ROOT / "tests" / "golden" / f"{file}.bin") if case.scheme != "loop" and not any(name in case.name for name in REFUSED)]
    assert cases
    differing = {f"{case.name}, boundary {case.boundary}, triangles {case.triangles}": found[:3] for case in cases if (found := list(faults(case)))}
    assert not differing, "\n".join(f"{name}: {found}" for name, found in differing.items())
