"""Fixtures of the USD tests."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Plugins are found when the first part of pxr is imported, so this comes before every such import.
os.environ["PXR_PLUGINPATH_NAME"] = os.pathsep.join(
    filter(None, [str(ROOT / "schemas"), os.environ.get("PXR_PLUGINPATH_NAME")])
)
