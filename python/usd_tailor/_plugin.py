"""The OpenUSD plugin for the usd-core that is installed. Nothing here imports ``pxr`` before :func:`register` is called."""

import importlib.metadata
from pathlib import Path

FOLDER = Path(__file__).parent / "plugin"


def plugin_path() -> str:
    """The folder for ``PXR_PLUGINPATH_NAME``, for the installed usd-core.

    Raises:
        RuntimeError: usd-core is not installed, or its version has no plugin in this package.
    """
    try:
        version = importlib.metadata.version("usd-core")
    except importlib.metadata.PackageNotFoundError:
        raise RuntimeError(
            "usd-core is not installed in this Python, and the plugin is for its libraries. "
            "Install it with pip, or build the plugin from source for another OpenUSD (docs/plugin.md)"
        ) from None
    return _folder(version)


def register() -> None:
    """Makes the file format ``.tailor`` and the schemas known to the OpenUSD of this process.

    OpenUSD looks for file formats and schemas once, when the first layer opens: call this before, or set
    ``PXR_PLUGINPATH_NAME`` to :func:`plugin_path`.

    Raises:
        RuntimeError: a layer was open before, or the running OpenUSD is not the installed usd-core, or has no plugin in
            this package.
    """
    folder = plugin_path()
    from pxr import Plug, Sdf, Usd

    running = _release(".".join(str(part) for part in Usd.GetVersion()[1:]))
    if running != Path(folder).name:
        raise RuntimeError(
            f"OpenUSD {running} is running, and usd-core {Path(folder).name} is installed. "
            f"Remove one of them from this process: the plugin is for one version"
        )
    Plug.Registry().RegisterPlugins(folder)
    if not Sdf.FileFormat.FindByExtension("tailor"):
        raise RuntimeError(
            "OpenUSD has opened a layer before, and looks for file formats only once. "
            "Call usd_tailor.register() first, or set PXR_PLUGINPATH_NAME to usd_tailor.plugin_path()"
        )


def _folder(version: str) -> str:
    folder = FOLDER / _release(version)
    if not folder.is_dir():
        known = ", ".join(sorted((path.name for path in FOLDER.glob("*.*")), key=_numbers))
        raise RuntimeError(
            f"there is no plugin for usd-core {version}. This package has one for: {known or 'no version'}. "
            f"Install one of these, or build the plugin from source (docs/plugin.md)"
        )
    return str(folder)


def _release(version: str) -> str:
    """Year and month of a version: ``25.5`` of ``25.5.1`` and of ``25.05``."""
    return ".".join(str(number) for number in _numbers(version))


def _numbers(version: str) -> list[int]:
    return [int(part) for part in version.split(".")[:2]]
