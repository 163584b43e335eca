"""The tutorial of the README runs as it is printed."""

import re
import sys

import pytest
from conftest import EXAMPLES, ROOT
from documents import run_script
from pxr import Usd

SECTION = "Five minutes"
LINES = 150


def tutorial():
    """The `sh` blocks of the tutorial, as one script."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    section = re.search(rf"^## {SECTION}\n(.*?)^## ", text, re.M | re.S).group(1)
    return "\n".join(re.findall(r"^```sh\n(.*?)^```$", section, re.M | re.S))


@pytest.mark.skipif(sys.platform == "win32", reason="the tutorial is for a POSIX shell: it is NOT tested")
def test_the_tutorial_runs_as_printed(usdtailor, tmp_path):
    script = tutorial()
    for command in ("example", "info", "check", "build", "explain"):
        assert f"usdtailor {command} " in script
    # An empty folder: the tutorial needs no clone.
    work = tmp_path / "work"
    work.mkdir()
    done = run_script(script, usdtailor, work)
    # The text says that there is none.
    assert re.findall(r"warning\[([\w-]+)\]", done.stderr) == []

    stage = Usd.Stage.Open(str(work / "shirt.usdc"))
    assert all(stage.GetPrimAtPath(f"/Tshirt/{name}") for name in ("model", "sim", "render"))
    assert "2 operators: fold.neck_hem, seam.side" in done.stdout
    assert (work / "shirt.png").read_bytes().startswith(b"\x89PNG")


def test_the_recipe_of_the_readme_is_that_of_the_example():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    [recipe] = re.findall(r"^```json\n(.*?)^```$", text, re.M | re.S)
    assert recipe == (EXAMPLES / "tshirt.tailor").read_text(encoding="utf-8")


def test_the_readme_is_an_entry_and_names_both_commands():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < LINES
    assert "cargo usdtailor build examples/" in text and "cargo xtask test" in text
