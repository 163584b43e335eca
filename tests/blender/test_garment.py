"""The shirt of the other tests is a sound garment: what these warn of comes from what they change."""

import bpy
import garment
import pytest
import usd_tailor


def evaluated(ob):
    return ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


@pytest.mark.parametrize("subdivision", [0, 1])
def test_a_plain_shirt_is_built_without_a_warning_of_its_shape(subdivision, tmp_path):
    ob = garment.shirt(armature=False, shape_key=False, subdivision=0)
    assert 1000 < len(evaluated(ob).polygons) < 2500
    if subdivision:
        ob.modifiers.new("Subdivision", "SUBSURF")
    bpy.ops.wm.usd_export(filepath=str(tmp_path / "shirt.usdc"))
    report = usd_tailor.build(tmp_path / "shirt.usdc", tmp_path / "built.usdc").report
    codes = {warning["code"] for warning in report["warnings"]}
    # Edges that are not smoothed may be too short beside the cuff, which is a set of two rows of faces.
    assert codes - {"sets-blurred"} == (set() if subdivision else {"polygonal-cage"})


def test_the_shirt_has_what_artists_make():
    ob = garment.shirt()
    mesh = ob.data
    assert [modifier.type for modifier in ob.modifiers] == ["MIRROR", "ARMATURE", "SUBSURF"]
    assert [group.name for group in ob.vertex_groups] == ["density", "Säume", "pins", "arm.L", "arm.R", "spine"]
    assert [key.name for key in mesh.shape_keys.key_blocks] == ["Basis", "Wide"]
    assert any(edge.use_seam for edge in mesh.edges)
    assert {"topstitch": "EDGE", "cuff_faces": "FACE", "crease_edge": "EDGE"}.items() <= {a.name: a.domain for a in mesh.attributes}.items()


def test_the_shirt_is_outside_the_body():
    ob, inside = garment.shirt(armature=False, shape_key=False), garment.body()
    points = [vertex.co for vertex in evaluated(ob).vertices]
    found = [inside.closest_point_on_mesh(point) for point in points]
    deepest = min((point - place).dot(normal) for point, (_, place, normal, _) in zip(points, found))
    assert deepest > 0.002
