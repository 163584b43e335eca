"""Attacks the command with damaged files and absurd options: `python tests/usd/attack.py --runs 2000 --seed 1`.

Every run has a seed of its own, which the table of failures gives: `--runs 1 --seed N` repeats it, `--keep DIR` keeps its files.
"""

import argparse
import collections
import json
import os
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Of the processor, so that a busy machine makes no failures; and of the clock, for what waits for ever.
SECONDS, WAITING = 20, 120
MEMORY = 3 << 30
# Larger inputs take most of the time of a run, and find no more.
MOST_BYTES = 1 << 20

NUMBERS = ["0", "-1", "nan", "inf", "-inf", "1e30", "-1e30", "1e-30", "2147483647", "-2147483648", "99999999999999999999", "0.5", "3"]
TOKENS = ["none", "catmullClark", "loop", "face", "edge", "point", "vertex", "uniform", "faceVarying", "constant", "", "x y", "../x", "\\n", "é"]
OPTIONS = {
    "number": ["sim.minEdgeLength", "sim.maxEdgeLength", "sim.grading", "sim.cornerAngle", "sim.featureAngle", "seam.a.width", "seam.a.normalOffset", "seam.a.depth",
               "seam.a.asymmetry", "fold.a.thickness", "fabric.a.density", "fabric.a.thickness", "fabric.a.shear"],
    "count": ["sim.baselineLevel", "sim.iterations", "sim.transferSamples", "sim.seed", "render.level"],
    "name": ["sim.density", "sim.uvSet", "sim.constraints", "seam.a.edges", "fold.a.faces", "fold.a.weights", "cloth.fabric", "cloth.rest",
             "cloth.pins", "cloth.pinTarget", "cloth.physics", "render.operators", "nothing.there", "sim", "."],
}  # fmt: skip
COUNTS = ["0", "1", "2", "101", "4294967295", "4294967296", "-1", "1.5"]


def numbers_of(text):
    return list(re.finditer(r"(?<![\w.#])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])", text))


def replace(text, match, new):
    return text[: match.start()] + new + text[match.end() :]


def damaged_text(text, names, rng):
    """The text of a layer with one thing changed."""
    kind = rng.choice(["number", "number", "array", "array", "token", "name", "line", "bytes"])
    if kind == "number" and (found := numbers_of(text)):
        # Half of them are numbers that the layer has elsewhere, which readers take more often.
        new = rng.choice([rng.choice(NUMBERS), rng.choice(found).group()])
        return replace(text, rng.choice(found), new)
    if kind == "array" and (found := list(re.finditer(r"\[[^\[\]]*\]", text))):
        match = rng.choice(found)
        parts = match.group()[1:-1].split(",")
        keep = rng.randrange(len(parts) + 1)
        return replace(text, match, "[" + ",".join(rng.choice([parts[:keep], parts[keep:], parts + parts[keep:]])) + "]")
    if kind == "token" and (found := list(re.finditer(r'"[^"\n]*"', text))):
        return replace(text, rng.choice(found), f'"{rng.choice(TOKENS)}"')
    if kind == "name" and (found := list(re.finditer(rf"\b(?:{'|'.join(names)})\b", text))):
        return replace(text, rng.choice(found), rng.choice(names))
    if kind == "line":
        lines = text.splitlines(keepends=True)
        at = rng.randrange(len(lines))
        return "".join(lines[:at] + rng.choice([[], [lines[at]] * 2, [rng.choice(lines)]]) + lines[at + 1 :])
    return damaged_bytes(text.encode(), rng).decode(errors="replace")


def damaged_bytes(data, rng):
    """Bytes flipped, cut, repeated or overwritten."""
    at, length = rng.randrange(len(data)), 1 << rng.randrange(12)
    return rng.choice([
        lambda: data[:at] + bytes(b ^ (1 << rng.randrange(8)) for b in data[at : at + min(length, 8)]) + data[at + min(length, 8) :],
        lambda: data[:at],
        lambda: data[:at] + data[at + length :],
        lambda: data[:at] + data[at : at + length] * 2 + data[at + length :],
        lambda: data[:at] + rng.choice([b"\0", b"\xff"]) * length + data[at + length :],
    ])()  # fmt: skip


def text_of_layer(path):
    """A layer as text, from the cache of this process."""
    if path not in TEXTS:
        from pxr import Sdf

        TEXTS[path] = path.read_text() if path.suffix == ".usda" else Sdf.Layer.FindOrOpen(str(path)).ExportToString()
    return TEXTS[path]


TEXTS = {}
NAMES = ["points", "faceVertexCounts", "faceVertexIndices", "primvars", "indices", "interpolation", "elementType", "creaseIndices", "creaseLengths",
         "creaseSharpnesses", "subdivisionScheme", "holeIndices", "float", "int", "token", "Mesh", "Xform", "GeomSubset", "over", "def", "class"]  # fmt: skip


def options(rng):
    found = []
    for _ in range(rng.choice([0, 0, 0, 1, 1, 3])):
        kind = rng.choice(list(OPTIONS))
        value = rng.choice({"number": NUMBERS, "count": COUNTS, "name": TOKENS + ["st", "seams", "a,b", "/Coat"]}[kind])
        found += ["--set", f"{rng.choice(OPTIONS[kind])}={value}"]
    return found


def recipe(rng, source):
    """A `.tailor` file that is more or less a recipe."""
    text = json.dumps({"source": source, "sim": {"iterations": 1, "maxEdgeLength": 5}, "render": {"level": 1}, "seam": {"a": {"edges": ["x"], "width": 1}}})
    if rng.random() < 0.5:
        found = numbers_of(text)
        return replace(text, rng.choice(found), rng.choice(NUMBERS))
    return damaged_bytes(text.encode(), rng).decode(errors="replace")


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


@dataclass
class Case:
    """A command in its folder: its arguments, and its inputs with their bytes."""

    seed: int
    folder: Path
    args: list

    def shown(self):
        return shlex.join(["usdtailor", *map(str, self.args)])


def garments():
    files = sorted((ROOT / "examples").glob("*.usda")) + sorted((ROOT.parent / "shared" / "garments").glob("*.usdc"))
    return [file for file in files if file.stat().st_size < 8 * MOST_BYTES]


def case(seed, folder, built):
    """The case of a seed. `built` is a garment that was built, for `drive`."""
    rng = random.Random(seed)
    mode = rng.choices(["build", "check", "info", "drive"], [60, 20, 10, 10])[0]
    if mode == "drive":
        source, name = built, "in.usdc"
    else:
        source = rng.choice(garments())
        name = "in" + source.suffix
    target = folder / name
    data = source.read_bytes()
    if rng.random() < 0.85:
        if source.suffix == ".usda" or (mode != "drive" and rng.random() < 0.5):
            target = folder / "in.usda"
            data = damaged_text(text_of_layer(source), NAMES, rng).encode()
        else:
            data = damaged_bytes(data, rng)
    target.write_bytes(data)
    args = [mode, target.name, "--threads", str(rng.choice([1, 2]))]
    if mode == "drive":
        cache = folder / "cache.npy"
        cache.write_bytes(damaged_bytes(numpy_cache(rng), rng))
        return Case(seed, folder, [*args, "--cache", rng.choice(["cache.npy", target.name]), "-o", "out.usdc"])
    args += options(rng)
    if rng.random() < 0.15:
        (folder / "r.tailor").write_text(recipe(rng, target.name))
        args = [args[0], "r.tailor", *args[2:]] if rng.random() < 0.5 else [*args, "--recipe", "r.tailor"]
    if mode == "build":
        args += ["-o", f"out{rng.choice(['.usda', '.usda', '.usdc', '.usdz'])}"] + rng.choice([[], [], ["--flatten"], ["--physics", "none"], ["--report", "out.json"]])
    return Case(seed, folder, args)


def numpy_cache(rng):
    import io

    import numpy as np

    out = io.BytesIO()
    np.save(out, np.zeros((2, rng.choice([0, 3, 5000]), 3), dtype=rng.choice(["f4", "f8", "i4"])))
    return out.getvalue()


def run(program, case):
    """Runs a case; returns its exit code as a word and what is wrong with it, if anything."""
    before = {path.name: path.read_bytes() for path in case.folder.iterdir()}
    try:
        done = subprocess.run([program, *case.args], cwd=case.folder, capture_output=True, timeout=WAITING, preexec_fn=limited, check=False)  # noqa: PLW1509
    except subprocess.TimeoutExpired:
        return "time-out", f"waits for more than {WAITING} s"
    said, code = done.stderr.decode(errors="replace"), done.returncode
    if "memory allocation of" in said:
        return "memory", said.splitlines()[-1]
    if code == -signal.SIGXCPU:
        return "time-out", f"takes more than {SECONDS} s of the processor"
    if code < 0:
        return f"signal {-code}", said[-300:]
    if code not in (0, 1, 2) or "panicked" in said or "internal error" in said:
        return f"exit {code}", said[-300:]
    faults = left_behind(case, before, code)
    if code == 0 and case.args[0] in ("build", "drive"):
        faults += invalid(case.folder / case.args[case.args.index("-o") + 1])
    codes = re.findall(r"^error\[([\w-]+)\]", said, re.MULTILINE)
    library = ", the USD library failed" if "the USD library failed" in said else ""
    return f"exit {code} {codes[0] if codes else ''}{library}".strip(), "; ".join(faults)


def left_behind(case, before, code):
    """Inputs that changed, temporary files, and outputs of a run that failed. Its report tells why it failed."""
    after = {path.name for path in case.folder.iterdir()}
    faults = [f"{name} was changed" for name, data in before.items() if name not in after or (case.folder / name).read_bytes() != data]
    new = after - before.keys()
    faults += [f"{name} is left" for name in new if not name.startswith("out") or (code != 0 and name != "out.json")]
    return faults


def invalid(path):
    """What is wrong with an output, looked at in a process of its own: OpenUSD may crash too."""
    looked = subprocess.run([sys.executable, __file__, "--look", str(path)], capture_output=True, text=True, timeout=60, check=False)
    if looked.returncode:
        return [f"OpenUSD cannot open {path.name}: {looked.stderr[-300:]}"]
    return json.loads(looked.stdout)


def look(path):
    """The faults of the products in a stage."""
    import numpy as np
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(path)
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.GetName() in ("sim", "render") and prim.IsA(UsdGeom.Mesh)]
    faults = [] if stage.Traverse() else ["the stage is empty"]
    for mesh in meshes:
        name = mesh.GetPath().name
        points, counts, corners = (np.array(a.Get(Usd.TimeCode.EarliestTime())) for a in (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()))
        if counts.sum() != len(corners):
            faults.append(f"{name}: counts add up to {counts.sum()}, with {len(corners)} corners")
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            faults.append(f"{name}: corners {corners.min()} to {corners.max()} of {len(points)} points")
        if not np.isfinite(points).all():
            faults.append(f"{name}: points are not finite")
        for subset in UsdGeom.Subset.GetAllGeomSubsets(mesh):
            indices = np.array(subset.GetIndicesAttr().Get())
            end = len(counts) if subset.GetElementTypeAttr().Get() == "face" else len(points)
            if len(indices) and not 0 <= indices.min() <= indices.max() < end:
                faults.append(f"{name}/{subset.GetPrim().GetName()}: indices {indices.min()} to {indices.max()} of {end}")
        for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithAuthoredValues():
            faults += primvar_faults(name, primvar, len(points), len(counts), len(corners))
    return faults


def primvar_faults(name, primvar, points, faces, corners):
    needed = {"vertex": points, "varying": points, "uniform": faces, "faceVarying": corners}.get(primvar.GetInterpolation())
    values, indices = primvar.Get(), primvar.GetIndices()
    if needed is None or not hasattr(values, "__len__"):
        return []
    found = len(indices) if primvar.IsIndexed() else len(values) // max(primvar.GetElementSize(), 1)
    faults = [] if found == needed else [f"{name}.{primvar.GetPrimvarName()}: {found} values for {needed} elements"]
    if primvar.IsIndexed() and len(indices) and not 0 <= min(indices) <= max(indices) < len(values):
        faults.append(f"{name}.{primvar.GetPrimvarName()}: an index out of {len(values)} values")
    return faults


def attack_plugin(runs, seed):
    """Opens recipes with arguments in this process, which ends in a signal if the plugin does. The seeds go to standard output."""
    from pxr import Sdf, Tf

    opened = 0
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(seed, seed + runs):
            print(number, flush=True)
            rng = random.Random(number)
            folder = Path(scratch) / str(number)
            folder.mkdir()
            source = ROOT / "examples" / "tshirt.usda"
            text = damaged_text(text_of_layer(source), NAMES, rng) if rng.random() < 0.5 else text_of_layer(source)
            (folder / "in.usda").write_text(text)
            whole = json.dumps({"source": "in.usda", "sim": {"iterations": 1}})
            (folder / "r.tailor").write_text(recipe(rng, "in.usda") if rng.random() < 0.3 else whole)
            given = options(rng)[1::2] + rng.choice([[], ["time=nan"], ["prim=/x y"], ["=", "a.b=\x01"]])
            arguments = dict(one.split("=", 1) for one in given)
            try:
                opened += Sdf.Layer.FindOrOpen(str(folder / "r.tailor"), arguments) is not None
            except Tf.ErrorException:
                pass
            shutil.rmtree(folder)
    print(f"{opened} opened")
    return 0


def attack(program, runs, seed, keep=None):
    """Runs the cases `seed` to `seed + runs`; returns the counts of their ends, and the failures."""
    ends, failures = collections.Counter(), []
    with tempfile.TemporaryDirectory() as scratch:
        built = Path(scratch) / "built.usdc"
        subprocess.run([program, "build", ROOT / "examples" / "tshirt.usda", "-o", built, "--flatten", "-q"], check=True)
        for number in range(seed, seed + runs):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            one = case(number, folder, built)
            end, fault = run(program, one)
            ends[end] += 1
            if fault:
                failures.append((number, end, one.shown(), fault))
            if keep and (fault or runs == 1):
                shutil.copytree(folder, Path(keep) / str(number), dirs_exist_ok=True)
                (Path(keep) / str(number) / "command.txt").write_text(f"{one.shown()}\n{end}\n{fault}\n")
            shutil.rmtree(folder)
    return ends, failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="folder for the files of runs that fail")
    parser.add_argument("--plugin", action="store_true", help="attack the OpenUSD plugin of PXR_PLUGINPATH_NAME instead")
    parser.add_argument("--look", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.look:
        print(json.dumps(look(args.look)))
        return 0
    if args.plugin:
        return attack_plugin(args.runs, args.seed)
    # Damaged files are for the program itself.
    os.environ["USDTAILOR_PYTHON"] = ""
    program = os.environ.get("USDTAILOR", str(ROOT / "target" / "debug" / "usdtailor"))
    ends, failures = attack(Path(program).resolve(), args.runs, args.seed, args.keep)
    for end, count in sorted(ends.items()):
        print(f"{count:6}  {end}")
    for number, end, command, fault in failures:
        print(f"\nseed {number}: {end}: {command}\n  {fault}")
    print(f"\n{len(failures)} failures in {args.runs} runs")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
