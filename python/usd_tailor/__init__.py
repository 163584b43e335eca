"""One coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.

The functions run the command ``usdtailor`` of this package, so their options, figures and messages are those of the command.
"""

from importlib.metadata import version as _version

from ._command import TailorError, start
from ._plugin import plugin_path, register
from ._run import Built, Elements, Fitted, bake, build, check, drive, fit, info, options, sets

__all__ = ["Built", "Elements", "Fitted", "TailorError", "bake", "build", "check", "drive", "fit", "info", "options", "plugin_path", "register", "sets", "start"]
__version__ = _version("usd-tailor")
