"""Blender as a Python module, with the extension installed as a user installs it.

`cargo xtask test blender` makes the extension and runs this in an environment that has Blender.
"""

import os
import sys
import tempfile
from pathlib import Path

import pytest

EXTENSION = Path(os.environ["USDTAILOR_EXTENSION"])
MODULE = "bl_ext.user_default.usd_tailor"

# Blender looks for its user folders once, when the first module imports it.
_resources = tempfile.TemporaryDirectory(prefix="usdtailor-blender-", ignore_cleanup_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = _resources.name

import bpy  # noqa: E402
# A module that comes with bpy.
import addon_utils  # noqa: E402, I001


def pytest_sessionstart():
    """Installs the extension before the test modules are imported, so that they can import its modules and `usd_tailor`."""
    bpy.ops.extensions.package_install_files(filepath=str(EXTENSION), repo="user_default", enable_on_install=True)
    assert addon_utils.check(MODULE) == (True, True), "the extension is enabled, and will be when Blender starts again"


def pytest_sessionfinish():
    """Disables the extension: hooks that stay registered may hold up the exit of Blender."""
    bpy.ops.preferences.addon_disable(module=MODULE)
    _resources.cleanup()


@pytest.fixture(scope="session")
def extension():
    """The module of the extension."""
    return sys.modules[MODULE]


@pytest.fixture(autouse=True)
def empty_file():
    """An empty file for each test. read_factory_settings() would disable the extension."""
    bpy.ops.wm.read_homefile(use_empty=True)
