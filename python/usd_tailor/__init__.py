"""One coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.

The functions run the command ``usdtailor`` of this package, so their options, figures and messages are those of the command.
"""

from importlib.metadata import version as _version

from ._command import TailorError
from ._plugin import plugin_path, register
from ._run import Built, build, check, drive, info

__all__ = ["Built", "TailorError", "build", "check", "drive", "info", "plugin_path", "register"]
__version__ = _version("usd-tailor")
