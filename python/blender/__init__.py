# SPDX-License-Identifier: GPL-3.0-or-later
"""USD Tailor in Blender: the simulation mesh and the render mesh of a garment, where the garment is modelled."""

import bpy

from . import hook, live, messages, operators, panels, sets, simulation

CLASSES = (hook.USD_HOOK_tailor, *operators.CLASSES, *sets.CLASSES, *simulation.CLASSES, *panels.CLASSES)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for name, handler in live.HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    live.stop()
    messages.clear()
    for name, handler in live.HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    for cls in reversed(CLASSES):
        # The hook may be gone already, where Blender ends.
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
