"""Points that one mesh has twice along its seams, and UVs that are mirrored across one."""

import collections

import numpy as np
from conftest import run
from fitting import Triangles, fit, tube, write_tube
from mesh import find_model
from pxr import Gf, Usd, UsdGeom
from sources import sheet, write


def codes(product):
    return {warning["code"] for warning in product.report["warnings"]}


def doubled(path, shift=0.0):
    """As glTF and other unwelded files have them: each quad has points of its own along one column."""
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(find_model(stage))
    points, indices = list(mesh.GetPointsAttr().Get()), list(mesh.GetFaceVertexIndicesAttr().Get())
    column = [v for v, p in enumerate(points) if p[0] == 2]
    copies = {v: len(points) + i for i, v in enumerate(column)}
    points += [points[v] + Gf.Vec3f(0, 0, shift) for v in column]
    for corner, v in enumerate(indices):
        face = indices[corner - corner % 4 : corner - corner % 4 + 4]
        if v in copies and sum(points[w][0] for w in face) > 8:
            indices[corner] = copies[v]
    for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvars():
        if primvar.GetInterpolation() in ("vertex", "varying"):
            values = list(primvar.Get())
            primvar.Set(values + [values[v] for v in column])
    mesh.GetPointsAttr().Set(points)
    mesh.GetFaceVertexIndicesAttr().Set(indices)
    stage.GetRootLayer().Save()
    return column, copies


def test_doubled_points_are_sewn(build, usdtailor, tmp_path):
    plain = write(tmp_path / "plain.usda", shape=sheet, seam_column=2)
    path = write(tmp_path / "a.usda", shape=sheet, seam_column=2)
    column, copies = doubled(path)
    assert f"its own borders: {len(column) - 1} border edges" in run(usdtailor, "info", path).stdout
    whole, product = build(plain, stem="whole"), build(path)
    for name in ("sim", "render"):
        mesh = UsdGeom.Mesh(product.prim(name))
        assert not codes(product) & {"unsewn-borders"}
        counts = collections.Counter(frozenset(edge) for edge in edges_of(mesh))
        ends = np.array(mesh.GetPointsAttr().Get())
        borders = [ends[list(edge)] for edge, count in counts.items() if count == 1]
        assert all(np.isclose(edge[0], edge[1])[:2].any() and not np.allclose(edge[:, 0], 2) for edge in borders), name
    assert len(UsdGeom.Mesh(product.prim("render")).GetPointsAttr().Get()) == len(UsdGeom.Mesh(whole.prim("render")).GetPointsAttr().Get())
    # The model's own points, the doubled ones too, are bound where the sewn ones are.
    faces = product.prim("sim").GetAttribute("tailor:model:bindFace").Get()
    stage = Usd.Stage.Open(str(path))
    assert len(faces) == len(UsdGeom.Mesh(find_model(stage)).GetPointsAttr().Get())
    assert all(faces[copies[v]] == faces[v] for v in column)


def test_sets_of_a_mesh_with_doubled_points_name_both_sides(usdtailor, tmp_path):
    path = write(tmp_path / "a.usda", shape=sheet, seam_column=2)
    column, copies = doubled(path)
    out = tmp_path / "sets.usda"
    done = run(usdtailor, "sets", path, "--bake", "middle=uvSeams", "-o", out)
    assert done.returncode == 0, done.stderr
    stage = Usd.Stage.Open(str(out))
    mesh = UsdGeom.Mesh(find_model(stage))
    (subset,) = [s for s in UsdGeom.Subset.GetAllGeomSubsets(mesh) if s.GetPrim().GetName() == "middle"]
    indices = list(subset.GetIndicesAttr().Get())
    assert set(indices) == set(column) | set(copies.values())
    real = {frozenset(edge) for edge in edges_of(mesh)}
    assert all(frozenset(edge) in real for edge in zip(indices[::2], indices[1::2]))


def test_doubled_points_that_are_apart_are_told(usdtailor, tmp_path):
    path = write(tmp_path / "a.usda", shape=sheet, seam_column=2)
    column, _ = doubled(path, shift=0.02)
    done = run(usdtailor, "check", path)
    assert "warning[unsewn-borders]" in done.stderr and f"{2 * (len(column) - 1)} border edges" in done.stderr, done.stderr
    assert "unsewn" not in run(usdtailor, "check", path, "--sew-tolerance", "0.05").stderr


def edges_of(mesh):
    """The edges of a mesh, one for each face."""
    corner, indices = 0, mesh.GetFaceVertexIndicesAttr().Get()
    for count in mesh.GetFaceVertexCountsAttr().Get():
        face = list(indices[corner : corner + count])
        corner += count
        yield from zip(face, face[1:] + face[:1])


def test_mirrored_halves_are_cut_and_no_fault(build, tmp_path):
    """The left half of the sheet has the UVs of the right one, mirrored, with the same values along the middle."""

    def change(mesh):
        points, indices = mesh.GetPointsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
        middle = max(p[0] for p in points) / 2
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        primvar.GetIndicesAttr().Block()
        primvar.Set([Gf.Vec2f(abs(points[v][0] - middle) / 10, points[v][1] / 10) for v in indices])

    path = write(tmp_path / "a.usda", shape=sheet)
    stage = Usd.Stage.Open(str(path))
    change(UsdGeom.Mesh(find_model(stage)))
    stage.GetRootLayer().Save()
    product = build(path)
    assert not any("flip" in code for code in codes(product))
    mesh = UsdGeom.Mesh(product.prim("sim"))
    points = np.array(mesh.GetPointsAttr().Get())
    middle = points[:, 0].max() / 2
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    # Each triangle is on one side.
    sides = np.sign(np.round(points[corners][:, :, 0] - middle, 4))
    assert not ((sides.max(axis=1) > 0) & (sides.min(axis=1) < 0)).any()


def test_bodies_whose_points_meet_in_one_shape_have_the_same_faces(usdtailor, tmp_path):
    (points, counts, indices), _ = tube(1, 8, 16, 12)
    body = write_tube(tmp_path / "body.usda", (points, counts, indices))
    flat = write_tube(tmp_path / "flat.usda", (points * [1, 1, 0], counts, indices))
    sleeve = write_tube(tmp_path / "sleeve.usda", tube(1.2, 5, 14, 9)[0])
    for a, b in ((body, flat), (flat, body)):
        fit(usdtailor, sleeve, "--from", a, "--to", b, "-o", tmp_path / "out.usda", "--force")


def test_a_body_with_doubled_points_takes_the_cloth_along_as_one_without(usdtailor, tmp_path):
    """As glTF has bodies: each quad has points of its own."""
    sleeve, found = write_tube(tmp_path / "sleeve.usda", tube(1.1, 5, 14, 9)[0]), []
    for name, is_doubled in (("plain", False), ("doubled", True)):
        files = []
        for bulge in (0, 0.4):
            (points, counts, indices), _ = tube(1, 8, 16, 12, bulge=bulge)
            shape = (points[indices], counts, np.arange(len(indices))) if is_doubled else (points, counts, indices)
            files.append(write_tube(tmp_path / f"{name}{bulge}.usda", shape))
        out = tmp_path / f"{name}.usda"
        fit(usdtailor, sleeve, "--from", files[0], "--to", files[1], "-o", out)
        found.append(Triangles(out).points)
    assert np.abs(found[0] - found[1]).max() < 1e-4
