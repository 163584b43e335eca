"""An export chaser of Maya USD that writes sets of components as GeomSubsets.

Run this once in a session, for example by userSetup.py, and name the chaser when you export:

    import export_sets; export_sets.register()
    cmds.mayaUSDExport(file="coat.usd", chaser=["tailorSets"], defaultMeshScheme="catmullClark")

Each set of edges, faces or vertices of an exported mesh becomes a subset with the name of the set; of a set of several kinds, each
kind becomes one, such as seam_edge. Materials are left to Maya. Export without smoothing, so that components keep their numbers.
"""

import re

from pxr import Tf, UsdGeom

NAME = "tailorSets"
# The names of components in Maya, and of elements in USD.
KINDS = {"e": "edge", "f": "face", "vtx": "point"}
COMPONENT = re.compile(r"^(?P<shape>.+)\.(?P<kind>e|f|vtx)\[(?P<index>\d+)\]$")


def members(cmds, set_name):
    """The components of a set: lists of numbers by the full path of the mesh, and the kind."""
    found = {}
    for member in cmds.ls(cmds.sets(set_name, query=True) or [], flatten=True, long=True):
        match = COMPONENT.match(member)
        if not match:
            continue
        shape = (cmds.listRelatives(match["shape"], shapes=True, fullPath=True) or cmds.ls(match["shape"], long=True))[0]
        found.setdefault((shape, KINDS[match["kind"]]), []).append(int(match["index"]))
    return found


def ends(cmds, shape, edge):
    """The two points of an edge."""
    return [int(point) for point in cmds.polyInfo(f"{shape}.e[{edge}]", edgeToVertex=True)[0].split()[2:4]]


def author(cmds, stage, paths):
    """Writes a subset for each set of components; `paths` are the prims of the full paths of shapes."""
    for name in cmds.ls(type="objectSet"):
        if cmds.nodeType(name) != "objectSet":
            continue
        found = members(cmds, name)
        for (shape, kind), numbers in found.items():
            is_mixed = len([other for other, _ in found if other == shape]) > 1
            subset = Tf.MakeValidIdentifier(f"{name}_{kind}" if is_mixed else name)
            mesh = UsdGeom.Mesh(stage.GetPrimAtPath(paths.get(shape, "/")))
            if mesh:
                indices = [point for edge in numbers for point in ends(cmds, shape, edge)] if kind == "edge" else numbers
                UsdGeom.Subset.CreateGeomSubset(mesh, subset, kind, indices, f"{kind}s")


def register():
    """Makes the chaser known to Maya USD."""
    import mayaUsd.lib
    from maya import cmds

    class Chaser(mayaUsd.lib.ExportChaser):
        def __init__(self, context, *args, **kwargs):
            super().__init__(context, *args, **kwargs)
            self.stage = context.GetStage()
            self.paths = {item.key().fullPathName(): str(item.data()) for item in context.GetDagToUsdMap()}

        def PostExport(self):
            author(cmds, self.stage, self.paths)
            return True

    mayaUsd.lib.ExportChaser.Register(Chaser, NAME)
