"""What `cloth.pins` holds, by the distance from the curve or area that its points span on the garment."""

import numpy as np
import pytest
from conftest import EXAMPLES, run
from pxr import Sdf, Usd, UsdGeom, UsdValidation
from surface import distance_to_segments

TSHIRT, COAT = (EXAMPLES / f"{name}.usda" for name in ("tshirt", "coat"))
LENGTHS = (1.0, 2.0, 4.0)


def nearest(points, samples):
    """The distance of each point from the samples."""
    return np.array([np.sqrt(((samples - point) ** 2).sum(axis=1).min()) for point in points])


def elements(mesh, name):
    return np.array(UsdGeom.Subset.Get(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild(name)).GetIndicesAttr().Get())


def points_of(mesh, name):
    """The points of an edge or face set."""
    subset = UsdGeom.Subset.Get(mesh.GetPrim().GetStage(), mesh.GetPath().AppendChild(name))
    if subset.GetElementTypeAttr().Get() == "edge":
        return np.unique(elements(mesh, name))
    counts, indices = (np.array(getattr(mesh, f"GetFaceVertex{part}Attr")().Get()) for part in ("Counts", "Indices"))
    return np.unique(np.concatenate([np.split(indices, np.cumsum(counts)[:-1])[face] for face in elements(mesh, name)]))


def marked(tmp_path, source, of):
    """A garment with the points of a set, or some points, as the point set `held`, the painted weight `weight`, and as a varying
    primvar, by which USD's rules give the share of these points at each point of the render mesh."""
    # Other tests of this process have the layer of the file.
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(source)))
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    points = points_of(mesh, of) if isinstance(of, str) else of
    UsdGeom.Subset.CreateGeomSubset(mesh, "held", "point", points.tolist(), "held")
    share = np.isin(np.arange(len(mesh.GetPointsAttr().Get())), points).astype(np.float32)
    for name, interpolation in (("weight", "vertex"), ("share", "varying")):
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, interpolation).Set(share.tolist())
    path = tmp_path / "marked.usda"
    stage.Export(str(path))
    return path


def pins(product):
    prim = product.stage.GetPrimAtPath(product.model_path.ReplaceName("physics").AppendChild("pins"))
    return np.array(prim.GetAttribute("physics:indices0").Get())


def span(product):
    """The points of the fine render mesh on the curve or area."""
    render = product.prim("render")
    share = np.array(UsdGeom.PrimvarsAPI(render).GetPrimvar("share").ComputeFlattened())
    return np.array(UsdGeom.Mesh(render).GetPointsAttr().Get(), float)[share > 1 - 1e-5]


def pieces(indices, count):
    """A number for each point, the same for connected ones."""
    label = np.arange(count)
    while True:
        least = label[indices].min(axis=1)
        new = label.copy()
        np.minimum.at(new, indices.ravel(), np.repeat(least, indices.shape[1]))
        if (new == label).all():
            return label
        label = new


def sim_of(product):
    """Points and triangles of the simulation mesh, and which points are held."""
    sim = UsdGeom.Mesh(product.prim("sim"))
    points = np.array(sim.GetPointsAttr().Get(), float)
    held = np.isin(np.arange(len(points)), pins(product))
    return points, np.array(sim.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3), held


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("source, of", [(TSHIRT, "hem"), (TSHIRT, "chest_line"), (COAT, "elbow_line"), (COAT, "half_belt"), (TSHIRT, "neckband")])
def test_all_vertices_along_a_curve_or_in_an_area_are_held_and_no_others(build, tmp_path, source, of, length):
    lengths = ["--set", f"sim.maxEdgeLength={length}", "--set", f"sim.minEdgeLength={length}", "--set", "render.level=3"]
    product = build(marked(tmp_path, source, of), *lengths, "--set", "cloth.pins=held", "--set", "sim.constraints=")
    points, triangles, held = sim_of(product)
    far = nearest(points, span(product))
    assert far[held].max() < length
    # Pieces of which nothing is held are other layers.
    label = pieces(triangles, len(points))
    missed = np.isin(label, label[held]) & ~held & (far < 0.45 * length)
    assert held.sum() > 5 and not missed.any(), (missed.sum(), held.sum())


def test_a_painted_weight_holds_as_the_points_above_a_half_do(build, tmp_path):
    source = marked(tmp_path, TSHIRT, "hem")
    by_set, by_weight = (build(source, "--set", f"cloth.pins={name}", stem=name) for name in ("held", "weight"))
    assert pins(by_set).tolist() == pins(by_weight).tolist()
    weights = UsdGeom.PrimvarsAPI(by_weight.prim("sim")).GetPrimvar("weight").ComputeFlattened()
    assert np.min(np.array(weights)[pins(by_weight)]) > 0.45


def test_a_layer_on_a_pinned_area_is_not_held(build, tmp_path):
    """The pocket lies half a centimetre off the front."""
    product = build(marked(tmp_path, TSHIRT, "front"), "--set", "cloth.pins=held", "--set", "sim.maxEdgeLength=3")
    points, triangles, held = sim_of(product)
    label = pieces(triangles, len(points))
    pocket = label == label[triangles[elements(UsdGeom.Mesh(product.prim("sim")), "pocket")[0], 0]]
    assert pocket.sum() > 10 and not held[pocket].any() and held.sum() > 100


@pytest.mark.parametrize("name, words", [("st", "is not a float primvar"), ("nothing", "is not one of")])
def test_what_is_no_weight_is_told(usdtailor, tmp_path, name, words):
    done = run(usdtailor, "build", TSHIRT, "-o", tmp_path / "out.usda", "--set", f"cloth.pins={name}")
    assert done.returncode == 1 and words in done.stderr, done.stderr


def test_what_holds_pins_is_valid(build, tmp_path):
    product = build(TSHIRT, "--set", "cloth.pins=hem", "--physics", "aousd,omni,chaos")
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(product.stage)
    assert not [error.GetErrorAsString() for error in errors]


@pytest.mark.parametrize("length", LENGTHS)
def test_vertices_on_the_chains_of_an_edge_set_are_held_whole(build, tmp_path, length):
    lengths = ["--set", f"sim.maxEdgeLength={length}", "--set", f"sim.minEdgeLength={length}", "--set", "render.level=3"]
    product = build(marked(tmp_path, TSHIRT, "hem"), *lengths, "--set", "cloth.pins=hem")
    points, _, held = sim_of(product)
    far = nearest(points, span(product))
    assert held.sum() > 20 and far[held].max() < 0.45 * length
    assert held[far < 0.1 * length].all()


@pytest.mark.parametrize("length", LENGTHS)
def test_all_border_vertices_on_edges_between_two_pinned_points_are_held(build, built, tmp_path, length):
    """Seven of ten points of the borders are pinned, so that edges with two pinned ends begin and end everywhere."""
    source = built(TSHIRT).source
    on_border = np.unique(source.topology.edges[source.topology.edge_faces == 1])
    some = np.random.default_rng(0).choice(on_border, 7 * len(on_border) // 10, replace=False)
    lengths = ["--set", f"sim.maxEdgeLength={length}", "--set", f"sim.minEdgeLength={length}", "--set", "render.level=3"]
    product = build(marked(tmp_path, TSHIRT, np.sort(some)), *lengths, "--set", "cloth.pins=held")
    borders = [mesh.topology.edges[mesh.topology.edge_faces == 1] for mesh in (product.render, product.sim)]
    pinned = product.render.primvars["share"].flat[borders[0]].min(axis=(1, 2)) > 1 - 1e-5
    vertices = np.unique(borders[1])
    away = distance_to_segments(product.sim.points[vertices], product.render.points[borders[0][pinned]])
    _, _, held = sim_of(product)
    between = away < 0.02 * length
    assert between.sum() > 20 and held[vertices[between]].all()
