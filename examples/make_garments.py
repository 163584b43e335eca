#!/usr/bin/env python3
"""Builds the example garments: tshirt.usda, trousers.usda and coat.usda beside this file, and trims/skirt.usda.

    make_garments.py            writes the stages
    make_garments.py --check    checks the committed stages and compares them with a new build

Needs usd-core and numpy.  The result is deterministic."""
import argparse
import re
import sys
import tempfile
from pathlib import Path

from tailoring import check, coat, looks, skirt, stage, trousers, tshirt

HERE = Path(__file__).resolve().parent
GARMENTS = {"tshirt": (tshirt, looks.TSHIRT), "trousers": (trousers, looks.TROUSERS),
            "coat": (coat, looks.COAT)}
SKIRT = "trims/skirt"       # several prims and variants, so that it writes its stage itself


def write(name, folder):
    path = Path(folder) / f"{name}.usda"
    path.parent.mkdir(exist_ok=True)
    if name == SKIRT:
        return skirt.write(path)
    module, look = GARMENTS[name]
    stage.write(module.build(), look, path)
    return path


def same(a, b):
    """True if two files are equal up to the last digit of numbers, which depends on library versions."""
    number = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
    a, b = a.read_text(), b.read_text()
    if a == b:
        return True
    if number.sub("#", a) != number.sub("#", b):
        return False
    pairs = zip(number.findall(a), number.findall(b))
    return all(abs(float(x) - float(y)) <= 2e-3 for x, y in pairs if x != y)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=[], help="only these garments")
    parser.add_argument("--check", action="store_true", help="check the committed files")
    args = parser.parse_args()
    names = args.names or [*GARMENTS, SKIRT]
    if not args.check:
        for name in names:
            print(write(name, HERE))
        return 0
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            committed = HERE / f"{name}.usda"
            problems = [] if name == SKIRT else check.stage_problems(committed)
            if not same(write(name, folder), committed):
                problems.append("differs from what the script builds")
            print(f"{committed.name}: {check.summary(committed) if name != SKIRT else 'with trims'}")
            for p in problems:
                print(f"  {p}")
            failures += len(problems)
    print("all good" if not failures else f"{failures} problems")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
