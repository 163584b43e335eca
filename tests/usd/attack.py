"""Attacks all doors of the command with damaged files and absurd options: `python tests/usd/attack.py --runs 2000 --seed 1`.

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
SETS = ["a", "st", "seams", "hem", "collar", "borders.lowest", "borders", "uvSeams", "faces", "edges", "points", "/Coat", "trims", "creases", "featureLines"]
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
        return replace(text, match, f"[{damaged_array(match.group()[1:-1], rng)}]")
    if kind == "token" and (found := list(re.finditer(r'"[^"\n]*"', text))):
        return replace(text, rng.choice(found), f'"{rng.choice(TOKENS)}"')
    if kind == "name" and (found := list(re.finditer(rf"\b(?:{'|'.join(names)})\b", text))):
        return replace(text, rng.choice(found), rng.choice(names))
    if kind == "line":
        lines = text.splitlines(keepends=True)
        at = rng.randrange(len(lines))
        return "".join(lines[:at] + rng.choice([[], [lines[at]] * 2, [rng.choice(lines)]]) + lines[at + 1 :])
    return damaged_bytes(text.encode(), rng).decode(errors="replace")


def damaged_array(text, rng):
    """The values of an array cut, repeated, in disorder, or all of them scaled or thrown about."""
    parts = re.findall(r"\([^()]*\)|[^,\s][^,]*", text)
    keep = rng.randrange(len(parts) + 1)
    kind = rng.choice(["cut", "cut", "repeated", "disorder", "scaled", "thrown"])
    if kind in ("scaled", "thrown"):
        factor = rng.choice([0, -1, 1e-20, 1e20, 0.1, 3])
        other = lambda number: float(number.group()) * (factor if kind == "scaled" else rng.uniform(-1, 1))  # noqa: E731
        return re.sub(r"-?\d+\.?\d*(?:e[+-]?\d+)?", lambda number: f"{other(number):.6g}", text)
    if kind == "disorder":
        rng.shuffle(parts)
        return ", ".join(parts)
    return ", ".join(rng.choice([parts[:keep], parts[keep:]]) if kind == "cut" else parts + parts[keep:])


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


@dataclass
class Pool:
    """What cases are made of: files by what they are, and what the program says that it takes."""

    garments: list  # each with the arguments that it needs
    built: list  # each with the points of its simulation mesh
    bodies: list
    sleeve: Path  # on the first body
    words: "Words"


@dataclass
class Words:
    """What the program says that it takes: keys of options with their domains, and functions of expressions."""

    options: list
    functions: list

    @classmethod
    def of(cls, program):
        said = lambda *args: subprocess.run([program, *args], capture_output=True, text=True, check=True).stdout  # noqa: E731
        key = lambda group, option: f"{group['name']}{'.a' * group['hasInstances']}.{option['key']}"  # noqa: E731
        options = [(key(group, option), option["domain"]) for group in json.loads(said("options")) for option in group["options"]]
        return cls(options, re.findall(r"^  (\w+)[(, ]", said("sets", "--help").split("combine them")[1], re.MULTILINE))


def pool(program, folder):
    """A pool of files of this project."""
    from fitting import tube, write_tube
    from trimmed import ARGS, write_front

    front, sleeve = write_front(folder / "front.usda"), write_tube(folder / "sleeve.usda", *tube(1.2, 5, 14, 9))
    shapes = [tube(1, 8, 16, 12), tube(1, 8, 16, 12, bulge=0.5), tube(1.1, 9, 21, 12, bulge=0.3)]
    bodies = [write_tube(folder / f"body{i}.usda", *shape, prim="/Body/skin") for i, shape in enumerate(shapes)]
    files = [sleeve, *(ROOT / "examples").rglob("*.usda"), *(ROOT / "tests" / "garments").glob("*.usdc")]
    garments = [(front, list(ARGS)), *((file, []) for file in sorted(files) if file.stat().st_size < MOST_BYTES)]
    built = []
    for name, more in {"tshirt": ["--flatten"], "trousers": ["--flatten", "--lods", "2", "--sets", "all"]}.items():
        file = folder / f"built_{name}.usdc"
        subprocess.run([program, "build", ROOT / "examples" / f"{name}.usda", "-o", file, "-q", *more], check=True)
        built.append((file, sim_points(file)))
    return Pool(garments, built, bodies, sleeve, Words.of(program))


def sim_points(file):
    import numpy as np
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(file))
    return next(np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get()) for prim in stage.Traverse() if prim.GetName().startswith("sim"))


def expression(rng, functions, levels=2):
    """An expression of sets, which may have more arguments than it takes, or fewer."""
    if levels == 0 or rng.random() < 0.3:
        return rng.choice([*SETS, *SETS[5:] * 2, *NUMBERS, "2cm", '"0-1"', "borders.largest"])
    parts = [expression(rng, functions, levels - 1) for _ in range(rng.choice([1, 1, 2, 3]))]
    return f" {rng.choice('+-&')} ".join(parts) if rng.random() < 0.3 else f"{rng.choice(functions)}({', '.join(parts)})"


def of_range(usual, rng):
    """A number of the usual range of an option, or up to its end."""
    return rng.randint(0, usual) if isinstance(usual, int) else round(rng.uniform(*usual), 3)


def options(rng, words):
    found = []
    for _ in range(rng.choice([0, 0, 0, 1, 1, 3])):
        key, domain = rng.choice(words.options) if rng.random() < 0.95 else (rng.choice(["nothing.there", "sim", "."]), {"type": "none"})
        usual = domain.get("usual")
        values = {"number": NUMBERS, "length": NUMBERS, "whole": COUNTS, "sets": [expression(rng, words.functions)]}
        absurd = values.get(domain["type"]) or [*domain.get("words", []) * 4, *TOKENS, *SETS, "true", "body0.usda", "body1.usda"]
        found += ["--set", f"{key}={rng.choice(absurd) if usual is None or rng.random() < 0.4 else of_range(usual, rng)}"]
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

    def outputs(self):
        """The stages that it has to write, or those in the folder that it has to make."""
        if "-o" not in self.args:
            return []
        out = self.folder / self.args[self.args.index("-o") + 1]
        return sorted(out.iterdir()) if out.is_dir() else [out]


def put(rng, folder, source, stem, sound=0.25):
    """Copies a file into the folder, mostly damaged, and returns its name."""
    data, suffix = source.read_bytes(), source.suffix
    if rng.random() >= sound:
        if suffix == ".usda" or rng.random() < 0.7:
            data, suffix = damaged_text(text_of_layer(source), NAMES, rng).encode(), ".usda"
        else:
            data = damaged_bytes(data, rng)
    (folder / f"{stem}{suffix}").write_bytes(data)
    return f"{stem}{suffix}"


def examined(rng, folder, pool):
    """A garment, and options of reading and of the recipe."""
    (source, needed), more = rng.choice([*pool.garments, *((file, []) for file, _ in pool.built)]), options(rng, pool.words)
    name = put(rng, folder, source, "in")
    if any(value.endswith(("body0.usda", "body1.usda")) for value in more):
        [put(rng, folder, body, body.stem, sound=0.7) for body in pool.bodies[:2]]
    if rng.random() < 0.15:
        (folder / "r.tailor").write_text(recipe(rng, name))
        return rng.choice([["r.tailor", *more], [name, "--recipe", "r.tailor", *more]])
    extra = [["--all"], ["--all", "--exclude", "*a*"], ["--lods", rng.choice(COUNTS)], ["--physics", rng.choice(["none", "omni,chaos"])], ["--provenance"], ["--time", "3"]]
    return [name, *(needed if rng.random() < 0.9 else []), *more, *(rng.choice(extra) if rng.random() < 0.4 else [])]


def build(rng, folder, pool):
    extra = [[], [], ["--flatten"], ["--report", "out.json"], ["--sets", "all", "--mark"], ["--lod-schema", "usdLod"], ["--render-per-panel"], ["--sim-only"], ["--strict"]]
    return [*examined(rng, folder, pool), "-o", f"out{rng.choice(['.usda', '.usda', '.usdc', '.usdz'])}", *rng.choice(extra)]


def sets(rng, folder, pool):
    baked = [f"--bake={name}={expression(rng, pool.words.functions)}" for name in "ab"[: rng.choice([0, 1, 1, 2])]]
    return [*examined(rng, folder, pool), *baked, *rng.choice([["--json"], ["-o", "out.usda"], ["-o", "out.usdc"]] if baked else [[], ["--json"]])]


def fit(rng, folder, pool):
    """A garment on a body, and others of the same faces, with common UVs, or with pairs."""
    source, needed = (pool.sleeve, []) if rng.random() < 0.8 else rng.choice(pool.garments)
    first, *others = rng.choice([pool.bodies, pool.bodies[::-1], pool.bodies[:1] * 2])
    args = [put(rng, folder, source, "in", sound=0.6), *needed, "--from", put(rng, folder, first, "from", sound=0.6), "--to"]
    others = others[: rng.choice([1, 1, 2])]
    args += [put(rng, folder, other, f"to{i}", sound=0.4) for i, other in enumerate(others)]
    if rng.random() < 0.3:
        text = "".join(f"{x} {y} {z} {1.1 * x} {y} {1.1 * z}\n" for x, y, z in [(1, 0, 0), (-1, 0, 0), (0, 3, 1), (0, -3, 1), (0, 0, -1)])
        (folder / "pairs.txt").write_text(text if rng.random() < 0.4 else damaged_text(text, ["1"], rng))
        args += ["--pairs", "pairs.txt"]
    for option in ("--rigid", "--keep-length"):
        args += [option, expression(rng, pool.words.functions)] if rng.random() < 0.15 else []
    more = rng.choice([[], [], ["--variant-set", "body"], ["--report", "out.json"]])
    several = len(others) > 1 and "--variant-set" not in more
    return [*args, *options(rng, pool.words), "-o", "outs" if several else rng.choice(["out.usda", "out.usdc"]), *more]


def drive(rng, folder, pool):
    built, points = rng.choice(pool.built)
    name = put(rng, folder, built, "in")
    cache = f"cache.{rng.choice(['npy', 'npy', 'npz'])}"
    data = numpy_cache(rng, points, cache)
    (folder / cache).write_bytes(data if rng.random() < 0.4 else damaged_bytes(data, rng))
    extra = [[], [], ["--clips"], ["--model"], ["--gaps"], ["--cache-space", "world"], ["--max-size", "1k"]]
    return [name, "--cache", rng.choice([cache, cache, name]), "-o", f"out{rng.choice(['.usda', '.usdc'])}", *rng.choice(extra)]


# Each subcommand, with its share of the cases in percent, and the function that makes its arguments.
DOORS = {"build": (35, build), "check": (15, examined), "info": (5, examined), "sets": (10, sets), "fit": (20, fit), "drive": (15, drive)}


def case(seed, folder, pool):
    """The case of a seed."""
    rng = random.Random(seed)
    door = rng.choices(list(DOORS), [often for often, _ in DOORS.values()])[0]
    return Case(seed, folder, [door, *DOORS[door][1](rng, folder, pool), "--threads", str(rng.choice([1, 2]))])


def numpy_cache(rng, points, name):
    import io

    import numpy as np

    out, frames = io.BytesIO(), np.zeros((2, rng.choice([0, 3, 5000]), 3), dtype=rng.choice(["f4", "f8", "i4"]))
    if rng.random() < 0.7:
        scale = rng.choice([0, 1e-3, 1, 1e20, np.nan])
        frames = np.stack([points + np.float32(frame * scale) for frame in range(3)]).astype(rng.choice(["f4", "f8"]))
    if name.endswith("npy"):
        np.save(out, frames)
    else:
        np.savez_compressed(out, points=frames, times=np.array(rng.choice([range(len(frames)), [5], [1, 1, 1], [np.nan] * 3]), float))
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
    if code == 0:
        faults += [fault for file in case.outputs() for fault in invalid(file)]
    codes = re.findall(r"^error\[([\w-]+)\]", said, re.MULTILINE)
    library = ", the USD library failed" if "the USD library failed" in said else ""
    return f"exit {code} {codes[0] if codes else ''}{library}".strip(), "; ".join(faults)


def left_behind(case, before, code):
    """Inputs that changed, temporary files, and outputs of a run that failed. Its report tells why it failed."""
    after = {path.name for path in case.folder.iterdir()}
    faults = [f"{name} was changed" for name, data in before.items() if name not in after or (case.folder / name).read_bytes() != data]
    new = after - before.keys()
    # Of several outputs, those that can be written are.
    is_wanted = lambda name: name.startswith("out") and (code == 0 or name == "out.json" or any((case.folder / name).glob("*.usdc")))  # noqa: E731
    faults += [f"{name} is left" for name in new if not is_wanted(name)]
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
    root = stage.GetRootLayer()
    has = lambda prim: any(child.IsA(UsdGeom.Subset) and root.GetPrimAtPath(child.GetPath()) for child in prim.GetChildren())  # noqa: E731
    is_layer = root.subLayerPaths or any(prim.referenceList.GetAddedOrExplicitItems() for prim in root.rootPrims)
    # A layer over the input has what it says itself; one that has all of its input has the faults of its input, and the products.
    is_said = lambda prim: is_layer and (root.GetPropertyAtPath(prim.GetPath().AppendProperty("points")) or has(prim))  # noqa: E731
    is_ours = lambda prim: prim.GetName().startswith(("sim", "render")) or is_said(prim)  # noqa: E731
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh) and is_ours(prim)]
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
        for subset in filter(lambda subset: root.GetPrimAtPath(subset.GetPath()), UsdGeom.Subset.GetAllGeomSubsets(mesh)):
            indices = np.array(subset.GetIndicesAttr().Get())
            end = len(counts) if subset.GetElementTypeAttr().Get() == "face" else len(points)
            if len(indices) and not 0 <= indices.min() <= indices.max() < end:
                faults.append(f"{name}/{subset.GetPrim().GetName()}: indices {indices.min()} to {indices.max()} of {end}")
        for primvar in filter(lambda primvar: root.GetPropertyAtPath(primvar.GetAttr().GetPath()), UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithAuthoredValues()):
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


def attack_plugin(words, runs, seed):
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
            given = options(rng, words)[1::2] + rng.choice([[], ["time=nan"], ["prim=/x y"], ["=", "a.b=\x01"]])
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
        files = pool(program, Path(scratch))
        for number in range(seed, seed + runs):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            one = case(number, folder, files)
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
    program = Path(os.environ.get("USDTAILOR", ROOT / "target" / "debug" / "usdtailor")).resolve()
    if args.plugin:
        return attack_plugin(Words.of(program), args.runs, args.seed)
    # Damaged files are for the program itself.
    os.environ["USDTAILOR_PYTHON"] = ""
    ends, failures = attack(program, args.runs, args.seed, args.keep)
    for end, count in sorted(ends.items()):
        print(f"{count:6}  {end}")
    for number, end, command, fault in failures:
        print(f"\nseed {number}: {end}: {command}\n  {fault}")
    print(f"\n{len(failures)} failures in {args.runs} runs")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
