"""The file of the extension, and what is there once Blender has installed it."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import addon_utils
import bpy
import pytest
import usd_tailor
from conftest import EXTENSION, MODULE

BLENDER = Path(bpy.utils.resource_path("LOCAL"))
MEGABYTE = 1 << 20


# The file.


def test_the_file_holds_the_extension_one_package_and_both_licences():
    with zipfile.ZipFile(EXTENSION) as file:
        names = file.namelist()
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
        licence = file.read("LICENSE").decode()
        [wheel] = [name for name in names if name.endswith(".whl")]
        with file.open(wheel) as package, zipfile.ZipFile(package) as inner:
            licences = {Path(name).name for name in inner.namelist() if "/licenses/" in name}
    assert EXTENSION.stat().st_size < 20 * MEGABYTE
    assert "__init__.py" in names and not [name for name in names if "__pycache__" in name]
    assert "GNU GENERAL PUBLIC LICENSE" in licence and licences == {"LICENSE-APACHE", "LICENSE-MIT"}
    assert manifest["wheels"] == [f"./{wheel}"]
    assert manifest["version"] == usd_tailor.__version__ == wheel.split("-")[1]
    assert EXTENSION.name == f"usd_tailor-{manifest['version']}-{manifest['platforms'][0]}.zip"


def test_the_file_passes_blenders_own_check():
    tags = BLENDER / "scripts/modules/_bpy_internal/extensions/tags.py"
    program = BLENDER / "scripts/addons_core/bl_pkg/cli/blender_ext.py"
    done = subprocess.run([sys.executable, program, "validate", f"--valid-tags={tags}", EXTENSION], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Success" in done.stdout, done.stdout + done.stderr


def test_the_modules_compile_for_later_blenders(tmp_path):
    python = shutil.which("python3.13") if sys.version_info < (3, 13) else sys.executable
    # A shim may be on the path without its interpreter.
    if not python or subprocess.run([python, "-c", ""], capture_output=True, check=False).returncode:
        pytest.skip("Blender 5.1 and later have Python 3.13, which is not on the path")
    with zipfile.ZipFile(EXTENSION) as file:
        file.extractall(tmp_path, [name for name in file.namelist() if name.endswith(".py")])
    done = subprocess.run([python, "-W", "error", "-m", "compileall", "-q", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


# Installed.


def test_the_package_of_the_extension_runs_its_command():
    # Blender unpacks it without the right to run.
    assert Path(usd_tailor.__file__).is_relative_to(os.environ["BLENDER_USER_RESOURCES"])
    assert {"sim", "render", "seam"} <= {group["name"] for group in usd_tailor.options()}


def test_the_extension_can_be_disabled_and_enabled_again():
    bpy.ops.preferences.addon_disable(module=MODULE)
    assert not addon_utils.check(MODULE)[1]
    bpy.ops.preferences.addon_enable(module=MODULE)
    assert addon_utils.check(MODULE) == (True, True)


def test_a_new_file_keeps_the_extension():
    bpy.ops.wm.read_homefile(use_empty=True)
    assert addon_utils.check(MODULE) == (True, True) and not bpy.data.objects
