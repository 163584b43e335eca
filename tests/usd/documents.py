"""Commands of documents, run as they are printed."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path


def run_script(script, usdtailor, folder):
    """Runs a script in a folder, with `usdtailor` and the Python of the tests on the path. Returns the process, which succeeded."""
    with tempfile.TemporaryDirectory() as name:
        programs = Path(name)
        (programs / "usdtailor").symlink_to(Path(usdtailor).absolute())
        # The interpreter is not resolved, so that it finds the packages of its environment.
        (programs / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
        (programs / "python").chmod(0o755)
        path = os.pathsep.join([name, os.environ["PATH"]])
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", script], cwd=folder, env={**os.environ, "PATH": path},
            capture_output=True, text=True, check=False, timeout=300,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    return done
