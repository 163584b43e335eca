"""One coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.

The functions run the command ``usdtailor`` of this package, so their options, figures and messages are those of the command.
"""

from importlib.metadata import PackageNotFoundError as _NotInstalled
from importlib.metadata import version as _version

from ._command import TailorError, start
from ._plugin import plugin_path, register
from ._run import Built, BuildArguments, DriveArguments, Elements, ExamineArguments, FitArguments, Fitted, bake, build, check, drive, fit, info, options, run, sets

__all__ = [
    "Built",
    "BuildArguments",
    "DriveArguments",
    "Elements",
    "ExamineArguments",
    "FitArguments",
    "Fitted",
    "TailorError",
    "bake",
    "build",
    "check",
    "drive",
    "fit",
    "info",
    "options",
    "plugin_path",
    "register",
    "run",
    "sets",
    "start",
]
try:
    __version__ = _version("usd-tailor")
except _NotInstalled:
    # The source folder.
    __version__ = "unknown"
