"""The garments of the project are those that its scripts make."""

import subprocess
import sys

import pytest
from conftest import EXAMPLES, MADE


@pytest.mark.parametrize("script", [MADE / "make.py", EXAMPLES / "make_garments.py"], ids=lambda path: path.stem)
def test_scripts_make_the_garments_that_are_committed(script):
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0 and "all good" in done.stdout, done.stdout + done.stderr
