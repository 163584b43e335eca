# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds that follow the edits of a garment, in the background: one runs, and the newest edit is next."""

import time

import bpy

from . import messages, recipe
from .job import Failed, Job, plain

# A build waits until edits pause for so long, and at most so long while they go on. [s]
_PAUSE, _LONGEST = 0.08, 0.5
# After a pause as long as this, a build of what was before is ended for the newest. While edits go on, it shows how they go. [s]
_SETTLED = 0.3
_TICK = 0.03


class Following:
    """The state of one garment that is live."""

    def __init__(self) -> None:
        self.job: Job | None = None
        self.first = self.last = time.monotonic()
        """When the edits that are not built began, and when the last was."""
        self.is_changed = True
        self.options: dict = {}

    def note_edit(self) -> None:
        self.last = time.monotonic()
        if not self.is_changed:
            self.first, self.is_changed = self.last, True

    def is_due(self) -> bool:
        now = time.monotonic()
        return self.is_changed and (now - self.last >= _PAUSE or now - self.first >= _LONGEST)

    def is_outdated(self) -> bool:
        """Whether what is built is not what will stay."""
        return self.job is not None and self.is_changed and time.monotonic() - self.last >= _SETTLED


_followed: dict[int, Following] = {}


def is_live(ob) -> bool:
    return ob.session_uid in _followed


def follow(ob, is_on: bool) -> None:
    """Begins or ends to build a garment at each edit."""
    if not is_on:
        _forget(ob.session_uid)
    elif not is_live(ob):
        _followed[ob.session_uid] = Following()
        if not bpy.app.timers.is_registered(tick):
            bpy.app.timers.register(tick)


def _forget(uid: int) -> None:
    following = _followed.pop(uid, None)
    if following and following.job:
        following.job.cancel()


def stop() -> None:
    """Ends all builds, for another file or the end of the extension."""
    for uid in list(_followed):
        _forget(uid)
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)


def tick() -> float | None:
    """Starts what is due, and takes what is done. Blender calls it from time to time."""
    garments = {ob.session_uid: ob for ob in bpy.data.objects if ob.session_uid in _followed}
    for uid, following in list(_followed.items()):
        if uid in garments:
            _tick_one(garments[uid], following)
        else:
            # It was deleted, perhaps while it was built.
            _forget(uid)
    return _TICK if _followed else None


def _tick_one(ob, following: Following) -> None:
    options = recipe.properties(ob)
    if options != following.options:
        following.options = options
        following.note_edit()
    try:
        if following.job and following.job.is_done():
            job, following.job = following.job, None
            messages.set_report(ob, job.finish())
            _redraw()
        elif following.is_outdated():
            following.job.cancel()
            following.job = None
        if not following.job and following.is_due():
            following.is_changed = False
            following.job = Job(ob)
    except Failed as failed:
        messages.set_faults(ob, failed.messages)
        _redraw()
    except Exception as error:  # A timer that raises is never called again.
        following.job = None
        messages.set_faults(ob, [plain(f"USD Tailor is at fault: {error!r}. Press Tailor to see where")])


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@bpy.app.handlers.persistent
def note_edits(_scene, depsgraph) -> None:
    """A handler of Blender: geometry that changed, of garments that are live."""
    if not _followed:
        return
    for update in depsgraph.updates:
        ob = update.id.original
        if isinstance(ob, bpy.types.Object) and is_live(ob) and (update.is_updated_geometry or update.is_updated_transform):
            _followed[ob.session_uid].note_edit()


@bpy.app.handlers.persistent
def note_undo(*_) -> None:
    """A handler of Blender: after undo and redo, the products are those of another state."""
    for following in _followed.values():
        following.note_edit()


@bpy.app.handlers.persistent
def note_load(*_) -> None:
    """A handler of Blender: another file is open."""
    stop()
    messages.clear()


HANDLERS = {
    "depsgraph_update_post": note_edits,
    "undo_post": note_undo,
    "redo_post": note_undo,
    "load_post": note_load,
}
