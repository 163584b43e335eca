#!/usr/bin/env python3
"""Remesh the OBJ files of a folder with the remeshers of this environment, for `cargo xtask peers`.

    peers.py DIR

NAME.obj becomes NAME.REMESHER.obj with a first line of what remeshing alone took. Constrained edges are kept as far as a
remesher can: PyMeshLab by selected creases it finds itself, gpytoolbox by feature vertices, MeshLib by edges that are not
to be flipped, CGAL by a map of edges. CGAL takes part if a C++ compiler and its headers are there (`libcgal-dev`)."""
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROUNDS = 5
CGAL = Path(__file__).with_name("cgal.cpp")


def read(path):
    length, points, faces, lines = 1.0, [], [], []
    for row in path.read_text().splitlines():
        words = row.split()
        if words[:2] == ["#", "length"]:
            length = float(words[2])
        elif words[0] == "v":
            points.append([float(w) for w in words[1:4]])
        elif words[0] == "f":
            faces.append([int(w) - 1 for w in words[1:4]])
        elif words[0] == "l":
            lines.append([int(w) - 1 for w in words[1:3]])
    return length, np.array(points), np.array(faces), np.array(lines)


def write(path, seconds, points, faces):
    rows = [f"# milliseconds {seconds * 1e3:.1f}"]
    rows += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    rows += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(rows) + "\n")


def pymeshlab(length, points, faces, lines):
    import pymeshlab as ml
    meshes = ml.MeshSet(verbose=False)
    meshes.add_mesh(ml.Mesh(points, faces))
    start = time.perf_counter()
    meshes.meshing_isotropic_explicit_remeshing(iterations=ROUNDS, targetlen=ml.PureValue(length), featuredeg=60)
    seconds = time.perf_counter() - start
    mesh = meshes.current_mesh()
    return seconds, mesh.vertex_matrix(), mesh.face_matrix()


def gpytoolbox(length, points, faces, lines):
    import gpytoolbox as gpy
    feature = np.unique(lines).astype(np.int32)
    start = time.perf_counter()
    points, faces = gpy.remesh_botsch(points, faces.astype(np.int32), ROUNDS, length, True, feature)
    return time.perf_counter() - start, points, faces


def meshlib(length, points, faces, lines):
    from meshlib import mrmeshnumpy, mrmeshpy as mm
    mesh = mrmeshnumpy.meshFromFacesVerts(faces.astype(np.int32), points)
    fixed = mm.UndirectedEdgeBitSet(mesh.topology.undirectedEdgeSize())
    for a, b in lines:
        edge = mesh.topology.findEdge(mm.VertId(int(a)), mm.VertId(int(b)))
        if edge.valid():
            fixed.set(edge.undirected())
    settings = mm.RemeshSettings()
    settings.targetEdgeLen = float(length)
    settings.finalRelaxIters = ROUNDS
    settings.notFlippable = fixed
    settings.projectOnOriginalMesh = True
    start = time.perf_counter()
    mm.remesh(mesh, settings)
    seconds = time.perf_counter() - start
    mesh.pack()
    return seconds, mrmeshnumpy.getNumpyVerts(mesh), mrmeshnumpy.getNumpyFaces(mesh.topology)


def cgal_program(folder):
    """The program of cgal.cpp beside this file, or None if it cannot be compiled here."""
    program = folder / "cgal"
    command = [os.environ.get("CXX", "c++"), "-std=c++17", "-O3", "-DNDEBUG", "-o", program, CGAL]
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as fault:
        reason = getattr(fault, "stderr", "") or str(fault)
        print(f"no CGAL: {reason.splitlines()[0]}", file=sys.stderr)
        return None
    return program


def main():
    folder = Path(sys.argv[1])
    program = cgal_program(folder)
    inputs = [p for p in sorted(folder.glob("*.obj")) if p.stem.count(".") == 0]
    for path in inputs:
        given = read(path)
        for remesher in (pymeshlab, gpytoolbox, meshlib):
            name = f"{path.stem}.{remesher.__name__}"
            try:
                seconds, points, faces = remesher(*given)
                write(folder / f"{name}.obj", seconds, points, faces)
                print(f"{name}: {seconds * 1e3:.0f} ms, {len(faces)} triangles", file=sys.stderr)
            except Exception as fault:  # Other people's programs: what fails is left out of the table.
                print(f"{name}: {type(fault).__name__}: {fault}", file=sys.stderr)
        if program and subprocess.run([program, path, folder / f"{path.stem}.cgal.obj", str(ROUNDS)]).returncode:
            print(f"{path.stem}.cgal: failed", file=sys.stderr)


if __name__ == "__main__":
    main()
