"""Damaged files and absurd options end in a build or an error, and in nothing else. `attack.py` says how to run more."""

import subprocess
import sys

import attack
from conftest import ALL
from tailor_file import needs_plugin

# `cargo xtask test --all` runs them all.
RUNS, PLUGIN_RUNS = (200, 60) if ALL else (40, 15)


def test_no_input_makes_the_command_fail_badly(usdtailor):
    ends, failures = attack.attack(usdtailor.resolve(), RUNS, 1)
    assert not failures, "\n".join(f"seed {seed}: {end}: {command}\n  {fault}" for seed, end, command, fault in failures)
    # The attack is of use only while some cases get through and some do not.
    assert ends["exit 0"] > RUNS / 10, ends


@needs_plugin
def test_no_recipe_makes_the_plugin_crash():
    command = [sys.executable, attack.__file__, "--plugin", "--runs", str(PLUGIN_RUNS), "--seed", "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, f"exit {done.returncode} after the seeds {done.stdout[-80:].split()}\n{done.stderr[-2000:]}"
    assert "internal error" not in done.stderr, done.stderr
    opened = int(done.stdout.splitlines()[-1].removesuffix(" opened"))
    assert PLUGIN_RUNS / 12 < opened, "some recipes open"
