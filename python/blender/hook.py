# SPDX-License-Identifier: GPL-3.0-or-later
"""Every USD export carries marked seams and the true-or-false attributes of edges and faces as subsets; every import brings them back."""

import atexit
import traceback

import bpy

# Blender imports OpenUSD for a hook, and ends at once where it is not on the path.
bpy.utils.expose_bundled_modules()


class USD_HOOK_tailor(bpy.types.USDHook):
    """Edge sets and face sets in USD files"""

    bl_idname = "usd_tailor_hook"
    bl_label = "USD Tailor"
    bl_description = "Writes marked seams, edge sets and face sets of meshes as subsets, and reads them"

    # Blender ends at once where a hook raises, so each failure is only reported.

    @staticmethod
    def on_export(context):
        try:
            from . import hook_usd

            hook_usd.write(context.get_stage(), context.get_depsgraph())
        except Exception:
            print("USD Tailor: edge sets and face sets are not in this file:")
            traceback.print_exc()
            return False
        return True

    @staticmethod
    def on_import(context):
        try:
            from . import hook_usd

            hook_usd.read(context.get_stage(), context.get_prim_map())
        except Exception:
            print("USD Tailor: edge sets and face sets are not read from this file:")
            traceback.print_exc()
            return False
        return True


def end():
    """Takes the hook away before Blender ends, as some of its ends wait for ever where one is left."""
    if USD_HOOK_tailor.is_registered:
        bpy.utils.unregister_class(USD_HOOK_tailor)


atexit.register(end)
