# SPDX-License-Identifier: GPL-3.0-or-later
"""The render mesh follows the simulated mesh in the frames of the scene: by a cache beside the .blend, or by shape keys."""

import os
import re
import time
from pathlib import Path

import bpy
import numpy as np
import usd_tailor

from . import crossings, follow, names, shapes
from .cage import column
from .job import Failed, Job, plain
from .links import OWN, product

MODIFIER = OWN + "Drive"
_PREVIEW = 10
"""Frames of a quick look at the cloth."""


class Preview:
    """Simulates the first frames of the scene, and stays there. Call :meth:`step` until it is done."""

    def __init__(self, garment: bpy.types.Object, scene: bpy.types.Scene) -> None:
        self.garment_name, self.garment_id = garment.name, garment.session_uid
        self.frames = self._range(scene)
        self.before, self.points, self.is_done = scene.frame_current, [], False
        if not product(garment, "sim") or not product(garment, "render"):
            raise Failed([plain(f"{garment.name} has no simulation mesh yet. Press Tailor first")])
        self._check_place(garment)
        _set_range(product(garment, "sim"), (scene.frame_start, max(scene.frame_end, self.frames[-1])))
        self._prepare(garment)

    @staticmethod
    def _range(scene) -> list[int]:
        """Of a scene of fewer frames, such as that of an import, as many too."""
        return list(range(scene.frame_start, scene.frame_start + _PREVIEW))

    def _check_place(self, garment) -> None:
        """Raises Failed where there is nothing to simulate, or nowhere to put it."""
        if not any(modifier.type == "CLOTH" for modifier in product(garment, "sim").modifiers):
            raise Failed([plain(f"{garment.name} has no cloth yet. Press Set Up Cloth first")])

    def _prepare(self, _garment) -> None:
        """Starts what runs beside the simulation."""

    @property
    def garment(self) -> bpy.types.Object | None:
        """The garment, or none if it was deleted."""
        return next((ob for ob in bpy.data.objects if ob.session_uid == self.garment_id), None)

    def _product(self, kind: str) -> bpy.types.Object:
        """A product, which undo may have replaced or removed since the last step."""
        found = self.garment and product(self.garment, kind)
        if not found:
            raise Failed([plain(f"{self.garment_name} or its meshes were deleted while the cloth was simulated")])
        return found

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return len(self.points) / (len(self.frames) + 1)

    @property
    def result(self) -> str:
        """What was done, for the user."""
        return f"{len(self.frames)} frames"

    def step(self) -> bool:
        """Simulates one frame; True when all is done.

        Raises:
            Failed: The meshes are gone, or their modifiers do not fit.
        """
        if len(self.points) < len(self.frames):
            self._read(self.frames[len(self.points)])
            return False
        self._end()
        return True

    def _read(self, frame: int) -> None:
        bpy.context.scene.frame_set(frame)
        sim = self._product("sim")
        mesh = sim.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        if len(mesh.vertices) != len(sim.data.vertices):
            raise Failed([plain(f"A modifier of {sim.name} changes its number of vertices. Turn it off for the simulation")])
        self.points.append(column(mesh.vertices, "co", 3))

    def _end(self) -> None:
        self.is_done = True
        crossings.note(self._product("sim"), self.frames, self.points)

    def cancel(self) -> None:
        """Goes back to the frame of before, unless all was done."""
        if not self.is_done:
            bpy.context.scene.frame_set(self.before)


class Drive(Preview):
    """Simulates all frames of the scene, and writes the cache at the end."""

    @staticmethod
    def _range(scene) -> list[int]:
        return list(range(scene.frame_start, scene.frame_end + 1))

    def _prepare(self, garment) -> None:
        self.is_checked, self.process = False, None
        self.job = Job(garment, flatten=True)

    def _check_place(self, _garment) -> None:
        if not bpy.data.filepath:
            raise Failed([plain("Save the .blend first: the cache is a file beside it")])
        blend = Path(bpy.data.filepath)
        self.folder = blend.with_name(f"{blend.stem}_tailor")
        if not os.access(self.folder if self.folder.exists() else self.folder.parent, os.W_OK):
            raise Failed([plain(f"Nothing can be written to {self.folder.parent}. Save the .blend elsewhere")])

    @property
    def result(self) -> str:
        return f"{len(self.frames)} frames in {self.folder.name}"

    def step(self) -> bool:
        """Reads one frame, or waits a moment for the programs; True when all is done.

        Raises:
            Failed: The simulated mesh is not that of the garment as it is now, or a program refused.
        """
        if not self.is_checked:
            if self.job.is_done():
                self._check_mesh()
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

    def _check_mesh(self) -> None:
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
        self._take()
        self._end()

    def _take(self) -> None:
        """Puts the shot beside the .blend, and gives the render mesh its points."""
        path = self._cache_path()
        beside = path.with_name(f"{path.stem}.part.usdc")
        render = self._product("render")
        try:
            self.folder.mkdir(exist_ok=True)
            _write_cache(_Shot(self.shot), beside)
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


class Bake(Drive):
    """As :class:`Drive`, into shape keys of a copy of the render mesh."""

    def _check_place(self, _garment) -> None:
        """Nothing is written beside the .blend."""

    @property
    def result(self) -> str:
        return f"{len(self.frames)} shape keys in {self.baked}; {self._product('render').name} is hidden and not rendered"

    def _take(self) -> None:
        self.baked = shapes.bake(self.garment, self._product("render"), _Shot(self.shot)).name


def _set_range(sim, frames: tuple[int, int]) -> None:
    """Lets the cloth run over these frames: outside of its own, Blender shows its last state."""
    for modifier in sim.modifiers:
        if modifier.type != "CLOTH":
            continue
        cache = modifier.point_cache
        if not cache.is_baked:
            if (cache.frame_start, cache.frame_end) != frames:
                cache.frame_start, cache.frame_end = frames
            if _cached(cache) <= frames[1] - frames[0]:
                # Blender drops frames that were added to a part, once the scene goes back. A change makes it begin again.
                sim.update_tag()
        elif cache.frame_start > frames[0] or cache.frame_end < frames[1]:
            baked = f"{cache.frame_start} to {cache.frame_end}"
            raise Failed([plain(f"The cloth of {sim.name} is baked for frames {baked}. Set the scene to these, or delete the bake")])


def _cached(cache) -> int:
    """The frames that were simulated, which Blender tells in words alone."""
    found = re.search(r"\d+", cache.info)
    return int(found[0]) if found else 0


def _caches(ob):
    return [m for m in ob.modifiers if m.type == "MESH_SEQUENCE_CACHE" and m.cache_file]


class _Shot:
    """The moved render mesh, in the file that the command wrote."""

    def __init__(self, path: Path) -> None:
        from .stage import Usd, UsdGeom

        # A mesh does not keep its stage.
        self.stage = Usd.Stage.Open(str(path))
        self.mesh = UsdGeom.Mesh(self.stage.GetPrimAtPath(self.stage.GetDefaultPrim().GetPath().AppendChild("render")))

    def __iter__(self):
        """Each frame and its points."""
        points = self.mesh.GetPointsAttr()
        return ((at, points.Get(at)) for at in points.GetTimeSamples())


def _write_cache(shot: _Shot, path: Path) -> None:
    """The moved render mesh alone, as one file that needs no other."""
    from .stage import Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(shot.stage.GetTimeCodesPerSecond())
    mesh = UsdGeom.Mesh.Define(stage, "/render")
    mesh.CreateFaceVertexCountsAttr(shot.mesh.GetFaceVertexCountsAttr().Get())
    mesh.CreateFaceVertexIndicesAttr(shot.mesh.GetFaceVertexIndicesAttr().Get())
    attribute = mesh.CreatePointsAttr()
    for at, points in shot:
        attribute.Set(points, at)
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
    follow.before_subdivision(render, MODIFIER)
    # It costs time where a cache has the points.
    follow.show(render, follow.MODIFIER, False)
