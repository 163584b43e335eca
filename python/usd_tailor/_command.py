"""The command ``usdtailor`` of this package."""

import atexit
import contextlib
import functools
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import types
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

PROGRAM = Path(__file__).parent / "_native" / ("usdtailor.exe" if os.name == "nt" else "usdtailor")


class TailorError(RuntimeError):
    """What the command refuses. The text is that of the command: problem, place and remedy.

    ``exit_code`` is 1 for bad input, 2 for a wrong argument, and 70 for a fault of usd-tailor.
    """

    def __init__(self, text: str, exit_code: int) -> None:
        super().__init__(text)
        self.exit_code = exit_code


def run(arguments: Sequence[str], *, examines: bool = False) -> str:
    """Runs the command, without colours, and returns what it prints. Raises what it refuses as :class:`TailorError`.

    A command that only ``examines`` prints the faults of garments as JSON; these are not a refusal.
    """
    with _interrupts_held() as release, start(arguments) as process:
        try:
            release()
            printed, message = process.communicate()
        except BaseException:
            # subprocess.run() does not wait after a KeyboardInterrupt, and leaves a zombie.
            process.kill()
            process.wait()
            raise
    if process.returncode and not (examines and printed.startswith("{")):
        raise TailorError(message.strip() or f"usdtailor ended with {process.returncode}", process.returncode)
    return printed


@contextlib.contextmanager
def _interrupts_held() -> Iterator[Callable[[], None]]:
    """Holds Ctrl-C back until the function that it yields is called: one while a process starts would leave the process."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield lambda: None
        return
    held: list[tuple[int, "types.FrameType | None"]] = []

    def release() -> None:
        signal.signal(signal.SIGINT, handler)
        while held:
            handler(*held.pop())

    signal.signal(signal.SIGINT, lambda *interrupt: held.append(interrupt))
    try:
        yield release
    finally:
        release()


def start(arguments: Sequence[str]) -> "subprocess.Popen[str]":
    """Starts the command, without colours, and does not wait for it. Its output and its messages are read from the process.

    A user interface stays alive so, and may end a build by ``kill()``: files are written whole or not at all.

    Raises:
        TailorError: The program of the package cannot be started.
    """
    command = [program(), *arguments, "--color", "never"]
    # Programs with windows have no console, and Windows would open one.
    flags = getattr(subprocess, "CREATE_NO_WINDOW", 0)
    try:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            creationflags=flags,
            env=_environment(),
        )
    except OSError as error:
        raise _cannot_start(command[0], error) from None


def _environment() -> dict[str, str]:
    """The environment of the command, which reads by this Python what only OpenUSD reads. A host with windows is no Python to start."""
    known = Path(sys.executable or "").stem.lower().startswith(("python", "hython", "mayapy"))
    return {**({"USDTAILOR_PYTHON": sys.executable} if known else {}), **os.environ}


def program() -> Path:
    """The program of the command, with the right to run it.

    pip gives it that right. Blender unpacks packages without. The right is added here, or else a private copy has it.

    Raises:
        TailorError: No program can be run in the folder of the package, or it is missing.
    """
    if os.name == "nt" or os.access(PROGRAM, os.X_OK):
        return PROGRAM
    try:
        mode = PROGRAM.stat().st_mode
    except OSError as error:
        raise _cannot_start(PROGRAM, error) from None
    try:
        # For those who may read it.
        PROGRAM.chmod(mode | (mode & 0o444) >> 2)
    except OSError:
        return _private_copy()
    if not os.access(PROGRAM, os.X_OK):
        raise _not_runnable(PROGRAM.parent, "Install usd-tailor in another folder")
    return PROGRAM


@functools.cache
def _private_copy() -> Path:
    """A copy of the program that this process may run, until it ends. The libraries beside it are links."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="usdtailor-program-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        for file in PROGRAM.parent.iterdir():
            if file != PROGRAM:
                (folder / file.name).symlink_to(file)
        copy = folder / PROGRAM.name
        shutil.copyfile(PROGRAM, copy)
        copy.chmod(0o500)
    except OSError as error:
        raise TailorError(
            f"usd-tailor may not run its program {PROGRAM}, and cannot copy it to {tempfile.gettempdir()}: {error.strerror}. "
            f"Make the program executable, or set TMPDIR to a folder that can be written",
            1,
        ) from None
    if not os.access(copy, os.X_OK):
        raise _not_runnable(folder.parent, f"Make {PROGRAM} executable, or set TMPDIR to another folder")
    return copy


def _not_runnable(folder: Path, remedy: str) -> TailorError:
    return TailorError(f"usd-tailor cannot run its program: no program may run in {folder} (mounted with noexec). {remedy}", 1)


def _cannot_start(path: "str | Path", error: OSError) -> TailorError:
    return TailorError(f"usd-tailor cannot run its program {path}: {error.strerror}. Install the package usd-tailor again", 1)


def main() -> None:
    """The entry point: becomes the program, so that signals and the exit code are its own."""
    arguments = sys.argv[1:]
    if arguments == ["plugin-path"]:
        from ._plugin import plugin_path

        try:
            print(plugin_path())
        except RuntimeError as error:
            sys.exit(f"error: {error}")
        return
    try:
        path = program()
        if path == PROGRAM and os.name != "nt":
            os.execve(path, ["usdtailor", *arguments], _environment())
        # Windows cannot replace a process, and a private copy is removed afterwards.
        sys.exit(subprocess.run([path, *arguments], check=False, env=_environment()).returncode)
    except TailorError as error:
        sys.exit(f"error: {error}")
    except OSError as error:
        sys.exit(f"error: {_cannot_start(path, error)}")
