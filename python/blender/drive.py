# SPDX-License-Identifier: GPL-3.0-or-later
"""The render mesh follows the simulated mesh: a cache beside the .blend, read by a modifier."""

import os
import time
from pathlib import Path

import bpy
import numpy as np
import usd_tailor

from . import names
from .cage import column
from .job import Failed, Job, plain
from .links import OWN, product

MODIFIER = OWN + "Drive"


class Drive:
    """Reads the simulated mesh frame by frame, and writes the cache at the end. Call :meth:`step` until it is done."""

    def __init__(self, garment: bpy.types.Object, scene: bpy.types.Scene) -> None:
        if not bpy.data.filepath:
            raise Failed([plain("Save the .blend first: the cache is a file beside it")])
        if not product(garment, "sim") or not product(garment, "render"):
            raise Failed([plain(f"{garment.name} has no simulation mesh yet. Press Tailor first")])
        self.frames = list(range(scene.frame_start, scene.frame_end + 1))
        self.before, self.points, self.is_checked, self.process = scene.frame_current, [], False, None
        blend = Path(bpy.data.filepath)
        self.folder = blend.with_name(f"{blend.stem}_tailor")
        if not os.access(self.folder if self.folder.exists() else self.folder.parent, os.W_OK):
            raise Failed([plain(f"Nothing can be written to {self.folder.parent}. Save the .blend elsewhere")])
        _set_range(product(garment, "sim"), scene)
        self.job = Job(garment, flatten=True)

    @property
    def garment(self) -> bpy.types.Object | None:
        """The garment, or none if it was deleted."""
        return self.job.garment

    def _product(self, kind: str) -> bpy.types.Object:
        """A product, which undo may have replaced or removed since the last step."""
        found = self.garment and product(self.garment, kind)
        if not found:
            raise Failed([plain(f"{self.job.garment_name} or its meshes were deleted while the cloth was simulated")])
        return found

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return len(self.points) / (len(self.frames) + 1)

    def step(self) -> bool:
        """Reads one frame, or waits a moment for the programs; True when all is done.

        Raises:
            Failed: The simulated mesh is not that of the garment as it is now, or a program refused.
        """
        if not self.is_checked:
            if self.job.is_done():
                self._check()
        elif len(self.points) < len(self.frames):
            self._read(self.frames[len(self.points)])
        elif self.process is None:
            self._start()
        elif self.process.poll() is not None:
            self._finish()
            return True
        else:
            time.sleep(0.005)
        return False

    def cancel(self) -> None:
        """Ends what still runs, and goes back to the frame of before. The last cache stays."""
        if self.process and self.process.poll() is None:
            self.process.kill()
        self.job.cancel()
        bpy.context.scene.frame_set(self.before)

    def _check(self) -> None:
        """Refuses a mesh that is not that of the garment as it is now, before any frame is simulated."""
        from .stage import Usd, UsdGeom

        self.job.result()
        self.is_checked = True
        stage = Usd.Stage.Open(str(self.job.output))
        prim = stage.GetPrimAtPath(stage.GetDefaultPrim().GetPath().AppendChild("sim"))
        built = np.asarray(UsdGeom.Mesh(prim).GetPointsAttr().Get(), np.float32)
        sim = self._product("sim")
        here = column(sim.data.vertices, "co", 3)
        if built.shape != here.shape or np.abs(built - here).max() > 1e-5 * max(1.0, np.abs(here).max()):
            raise Failed([plain(f"{self.garment.name} has changed since {sim.name} was made. Press Tailor, and simulate again")])

    def _read(self, frame: int) -> None:
        bpy.context.scene.frame_set(frame)
        sim = self._product("sim")
        mesh = sim.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        if len(mesh.vertices) != len(sim.data.vertices):
            raise Failed([plain(f"A modifier of {sim.name} changes its number of vertices. Turn it off for the simulation")])
        self.points.append(column(mesh.vertices, "co", 3))

    def _start(self) -> None:
        """Writes the frames for the command, and starts it."""
        cache = Path(self.job.folder.name) / "cache.npz"
        np.savez(cache, points=np.stack(self.points), times=np.asarray(self.frames, np.float64))
        self.shot = Path(self.job.folder.name) / "shot.usdc"
        self.process = usd_tailor.start(
            ["drive", str(self.job.output), "--cache", str(cache), "-o", str(self.shot), "--quiet"]
        )

    def _finish(self) -> None:
        _, errors = self.process.communicate()
        if self.process.returncode:
            raise Failed([plain(errors.strip())])
        path = self._cache_path()
        beside = path.with_name(f"{path.stem}.part.usdc")
        render = self._product("render")
        try:
            self.folder.mkdir(exist_ok=True)
            _write_cache(self.shot, beside)
            # A file that is open cannot be replaced on Windows.
            _forget_cache(render)
            beside.replace(path)
        except (OSError, RuntimeError) as error:
            raise Failed([plain(f"The cache cannot be written to {self.folder}: {error}. Save the .blend elsewhere")]) from None
        _read_cache(render, path)


    def _cache_path(self) -> Path:
        """The cache of the render mesh, which no other object reads."""
        render = self._product("render")
        others = {bpy.path.abspath(m.cache_file.filepath) for ob in bpy.data.objects if ob != render for m in _caches(ob)}
        stem = names.unique(names.usd_name(self.garment.name), {Path(path).stem for path in others})
        return self.folder / f"{stem}.usdc"


def _set_range(sim, scene) -> None:
    """Lets the cloth run over the frames of the scene: outside of its own, Blender shows its last state."""
    for modifier in sim.modifiers:
        if modifier.type != "CLOTH":
            continue
        cache, frames = modifier.point_cache, (scene.frame_start, scene.frame_end)
        if not cache.is_baked:
            if (cache.frame_start, cache.frame_end) != frames:
                cache.frame_start, cache.frame_end = frames
        elif cache.frame_start > frames[0] or cache.frame_end < frames[1]:
            baked = f"{cache.frame_start} to {cache.frame_end}"
            raise Failed([plain(f"The cloth of {sim.name} is baked for frames {baked}. Set the scene to these, or delete the bake")])


def _caches(ob):
    return [m for m in ob.modifiers if m.type == "MESH_SEQUENCE_CACHE" and m.cache_file]


def _write_cache(shot: Path, path: Path) -> None:
    """The moved render mesh alone, as one file that needs no other."""
    from .stage import Usd, UsdGeom

    source = Usd.Stage.Open(str(shot))
    moved = UsdGeom.Mesh(source.GetPrimAtPath(source.GetDefaultPrim().GetPath().AppendChild("render")))
    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(source.GetTimeCodesPerSecond())
    mesh = UsdGeom.Mesh.Define(stage, "/render")
    mesh.CreateFaceVertexCountsAttr(moved.GetFaceVertexCountsAttr().Get())
    mesh.CreateFaceVertexIndicesAttr(moved.GetFaceVertexIndicesAttr().Get())
    points = mesh.CreatePointsAttr()
    for at in moved.GetPointsAttr().GetTimeSamples():
        points.Set(moved.GetPointsAttr().Get(at), at)
    path.unlink(missing_ok=True)
    stage.GetRootLayer().Export(str(path))


def _forget_cache(render) -> None:
    if old := render.modifiers.get(MODIFIER):
        cache = old.cache_file
        render.modifiers.remove(old)
        # The modifiers of other objects may read it too.
        if cache and not any(m.cache_file == cache for ob in bpy.data.objects for m in _caches(ob)):
            bpy.data.batch_remove((cache,))


def _read_cache(render, path: Path) -> None:
    """Gives the render mesh the points of the cache, after what moves it and before what subdivides it."""
    known = set(bpy.data.cache_files)
    bpy.ops.cachefile.open(filepath=str(path), relative_path=True)
    cache = next(file for file in bpy.data.cache_files if file not in known)
    cache.filepath = bpy.path.relpath(str(path))
    modifier = render.modifiers.new(MODIFIER, "MESH_SEQUENCE_CACHE")
    modifier.cache_file = cache
    modifier.object_path = "/render"
    modifier.read_data = {"VERT"}
    subdivisions = [place for place, other in enumerate(render.modifiers) if other.type == "SUBSURF"]
    if subdivisions:
        render.modifiers.move(render.modifiers.find(MODIFIER), subdivisions[0])
