"""The garments of tests/garments are those that its script makes."""

import subprocess
import sys

from conftest import MADE


def test_the_script_makes_the_garments_that_are_committed():
    done = subprocess.run([sys.executable, MADE / "make.py", "--check"], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0 and "all good" in done.stdout, done.stdout + done.stderr
