"""Names the platform of the wheel: it has native libraries, but no module for one version of Python."""

import os

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Platform(BuildHookInterface):
    def initialize(self, version, build_data):
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{os.environ['USDTAILOR_PLATFORM']}"
