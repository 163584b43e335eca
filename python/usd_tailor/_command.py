"""The command ``usdtailor`` of this package."""

import os
import subprocess
import sys
from collections.abc import Sequence
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
    done = subprocess.run([PROGRAM, *arguments, "--color", "never"], capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode and not (examines and done.stdout.startswith("{")):
        raise TailorError(done.stderr.strip() or f"usdtailor ended with {done.returncode}", done.returncode)
    return done.stdout


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
    if os.name == "nt":
        sys.exit(subprocess.run([PROGRAM, *arguments], check=False).returncode)
    os.execv(PROGRAM, ["usdtailor", *arguments])
