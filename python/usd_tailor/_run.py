"""The command as functions."""

import json
import os
import tempfile
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Union

from ._command import run as _command

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from pxr import Sdf, Usd, UsdGeom

FilePath = Union[str, "os.PathLike[str]"]
Source = Union[str, "os.PathLike[str]", "Usd.Stage"]
Value = Union[str, int, float, bool, Sequence[str]]
Options = Mapping[str, Union[Value, "Options"]]
"""Options by their keys, ``{"sim.maxEdgeLength": 2}``, or nested as in a recipe, ``{"sim": {"maxEdgeLength": 2}}``."""

# The key of the build's record. It names the source, which for a stage is a temporary file.
_RECORD = "tailor"


class _ReadArguments(TypedDict, total=False):
    """How garments are read."""

    recipe: "FilePath | None"
    """A ``.tailor`` file with options."""
    options: "Options | None"
    """Options by their keys, such as ``{"sim.maxEdgeLength": "8mm", "render.level": 2}``, or nested as in a ``.tailor`` file:
    ``{"sim": {"maxEdgeLength": "8mm"}, "seam": {"side": {"width": 0.6}}}``."""
    prim: "str | None"
    """Path of the mesh, if there are several."""
    time: "float | None"
    """Time at which values are read. [time codes]"""
    all: bool
    """All meshes; panels whose borders coincide are sewn."""
    exclude: Sequence[str]
    """Prims to leave out, by name, path or collection."""
    sew_tolerance: "float | None"
    """Distance at which borders are sewn. [share of the mean edge length]"""
    no_fallback: bool
    """Refuse layers that only OpenUSD reads."""


class ExamineArguments(_ReadArguments, total=False):
    """The arguments of :func:`info` and :func:`check`."""

    physics: "str | None"
    """Dialects of USD physics to write, or ``none``."""
    lods: "int | None"
    """Levels of detail."""
    provenance: bool
    """Store the source face of each vertex of the simulation mesh."""
    strict: bool
    """Fail where a warning is more than a note."""
    deny: Sequence[str]
    """Codes of warnings to fail for."""
    allow: Sequence[str]
    """Codes of warnings that pass ``strict``."""
    max_memory: "str | int | None"
    """Memory that the run may take, such as ``"8G"``."""
    threads: "int | None"
    """Number of threads."""


class _WriteArguments(ExamineArguments, total=False):
    """What is done with an output that is there."""

    force: bool
    """Overwrite it."""
    skip_fresh: bool
    """Leave it if it was made of the same files with the same options and version."""


class BuildArguments(_WriteArguments, total=False):
    """The arguments of :func:`build`: the options of ``usdtailor build``."""

    flatten: bool
    """Write one self-contained file."""
    variants: "str | None"
    """Build for each variant of this set."""
    render_per_panel: bool
    """Write a render mesh for each of the panels that are sewn together."""
    sim_only: bool
    """Write the simulation mesh with its physics, and no render mesh."""
    lod_schema: "str | None"
    """``variants`` or ``usdLod``."""
    mark: bool
    """Give the render mesh a set of the elements that each kind of warning names."""
    sets: "str | None"
    """``none``, ``authored`` or ``all``."""
    sim_name: "str | None"
    """Name of the simulation mesh."""
    render_name: "str | None"
    """Name of the render mesh."""
    keep_model_purpose: bool
    """Keep the purpose of the model."""
    max_faces: "int | None"
    """Largest simulation mesh. [triangles]"""


class FitArguments(_WriteArguments, total=False):
    """The arguments of :func:`fit`: the options of ``usdtailor fit``."""

    body_prim: "str | None"
    """Path of the mesh in the files of bodies."""
    pairs: "FilePath | None"
    """A file of places that correspond, for bodies with neither the same faces nor a common UV set."""
    rigid: Sequence[str]
    """Sets whose connected parts move as wholes."""
    keep_length: Sequence[str]
    """Sets whose edges keep their lengths."""
    variant_set: "str | None"
    """Write one layer with a variant set of this name, a choice for each body."""


class DriveArguments(TypedDict, total=False):
    """The arguments of :func:`drive`: the options of ``usdtailor drive``."""

    no_fallback: bool
    """Refuse layers that only OpenUSD reads."""
    prim: "str | None"
    """Path of the render mesh to drive, or of a simulation mesh for all that are bound to it."""
    cache_prim: "str | None"
    """Path of the mesh in the cache."""
    cache_space: "str | None"
    """The space of the cache's points: ``world`` or ``local``."""
    model: bool
    """Move the model too."""
    clips: bool
    """Write value clips, for long caches."""
    gaps: bool
    """Accept gaps between frames."""
    force: bool
    """Overwrite an output that is there."""
    max_size: "str | int | None"
    """Largest shot to write, such as ``"20G"``."""
    threads: "int | None"
    """Number of threads."""


# The arguments of a build that have no use for an open stage.
_OF_FILES = ("flatten", "force", "skip_fresh", "variants")


@dataclass(frozen=True)
class Built:
    """What a build made."""

    layer: "Sdf.Layer | None"
    """The simulation mesh and the render mesh, and what changes on the model. Of a file, the output itself, over its source; of a
    stage, an anonymous layer to sublayer into it. None of a file where usd-core is not installed."""
    report: dict[str, Any]
    """Counts, quality figures, times, the complete recipe and warnings, as ``usdtailor build --report`` writes them."""


def build(source: Source, output: "FilePath | None" = None, **arguments: "Unpack[BuildArguments]") -> Built:
    """Makes a simulation mesh and a render mesh of a garment.

    Args:
        source: A USD or ``.tailor`` file, with an ``output``; or an open stage, as it is now, edits included.
        output: The file to write, for a file. ``force`` overwrites it.
        arguments: Those of :class:`BuildArguments`, which are the options of ``usdtailor build``.

    Raises:
        TailorError: The garment, an option or the output is refused. Nothing is written then.
    """
    words = _words(BuildArguments, arguments)
    if not _is_stage(source):
        if output is None:
            raise TypeError("a build of a file needs an output; a build of an open stage returns a layer instead")
        report = _report("build", [os.fspath(source)], output, words)
        return Built(_written(output), report)
    given = [name for name in _OF_FILES if arguments.get(name)]
    if output is not None or given:
        raise TypeError("a build of an open stage returns a layer; write it with its Export()")
    with tempfile.TemporaryDirectory(prefix="usdtailor-") as folder:
        written = Path(folder, "built.usdc")
        report = _report("build", [_flattened(source, folder)], written, words)
        return Built(_detached(written), report)


@dataclass(frozen=True)
class Fitted:
    """A garment on another body."""

    layer: "Sdf.Layer | None"
    """The new points, over the garment's file. None of several files, or where usd-core is not installed."""
    report: dict[str, Any]
    """Crossings, distances, lengths, angles and warnings, as ``usdtailor fit --report`` writes them."""


def fit(
    garment: "FilePath",
    body: "FilePath",
    to: "FilePath | Sequence[FilePath]",
    output: "FilePath",
    **arguments: "Unpack[FitArguments]",
) -> Fitted:
    """Moves a garment to another body, as ``usdtailor fit`` does.

    Args:
        garment: The file of the garment.
        body: The file of the body that it was made for.
        to: The file of the body that it is to fit, with the same faces or a common UV set; or several, with a folder as ``output`` or
            with ``variant_set``.
        output: The file to write. ``force`` overwrites it.
        arguments: Those of :class:`FitArguments`, which are the options of ``usdtailor fit``.

    Raises:
        TailorError: The garment, a body or the output is refused. Nothing is written then.
    """
    bodies = [to] if isinstance(to, (str, os.PathLike)) else list(to)
    words = ["--from", os.fspath(body), *(part for one in bodies for part in ("--to", os.fspath(one))), *_words(FitArguments, arguments)]
    report = _report("fit", [os.fspath(garment)], output, words)
    return Fitted(_written(output), report)


def info(source: Source, **arguments: Any) -> dict[str, Any]:
    """What garments hold, and the meshes that :func:`build` would make: the JSON of ``usdtailor info``.

    It takes those arguments of :func:`build` by which a garment is read.

    Raises:
        TailorError: A garment or an option is refused.
    """
    return _examined("info", source, **arguments)


def check(source: Source, **arguments: Any) -> dict[str, Any]:
    """What a build would warn of or refuse, or whether an output is fresh: the JSON of ``usdtailor check``.

    Faults of the garment are in the result (``inputs[0]["error"]``), and not raised. It takes the arguments of :func:`info`.
    """
    return _examined("check", source, **arguments)


def options() -> list[dict[str, Any]]:
    """The groups of options of a recipe, with the keys, ranges, units, defaults and meanings of their options: the JSON of
    ``usdtailor options``.
    """
    groups: list[dict[str, Any]] = json.loads(_command(["options"]))
    return groups


@dataclass(frozen=True)
class Elements:
    """The elements of a set of a garment."""

    expression: str
    """The set in the words of a recipe, such as ``borders.1``."""
    element_type: str
    """``face``, ``edge`` or ``point``."""
    indices: "array[int]"
    """Numbers as a ``GeomSubset`` has them: those of faces or points, or pairs of the points of edges."""


def sets(source: Source, expressions: "Mapping[str, str] | None" = None, **arguments: Any) -> dict[str, Elements]:
    """The sets of a garment that a recipe can name, as arrays: all that ``usdtailor sets`` lists, by their expressions, or
    those of ``expressions``, by your names.

    It takes those arguments of :func:`build` by which a garment is read.

    Raises:
        TailorError: The garment or an expression is refused.
    """
    return _sets(source, expressions or {}, arguments)[1]


def bake(stage: "Usd.Stage", expressions: Mapping[str, str], **arguments: Any) -> "list[UsdGeom.Subset]":
    """Authors sets as subsets of the mesh, in the edit target of an open stage. It takes the arguments of :func:`sets`.

    Args:
        stage: The stage of the garment.
        expressions: The set of each name, such as ``{"hem": "rings(borders.lowest, 2)"}``.

    Raises:
        TailorError: The garment, a name or an expression is refused. Nothing is authored then.
    """
    from pxr import UsdGeom, Vt

    prim, found = _sets(stage, expressions, arguments)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(prim))
    author = UsdGeom.Subset.CreateGeomSubset
    return [author(mesh, name, of.element_type, Vt.IntArray(list(of.indices))) for name, of in found.items()]


def _sets(source: Source, expressions: Mapping[str, str], arguments: dict[str, Any]) -> "tuple[str, dict[str, Elements]]":
    """The path of the mesh, and its sets by name."""
    baked = [flag for name, expression in expressions.items() for flag in ("--bake", f"{name}={expression}")]
    with tempfile.TemporaryDirectory(prefix="usdtailor-") as folder:
        path = _flattened(source, folder) if _is_stage(source) else os.fspath(source)
        found = json.loads(_command(["sets", path, "--json", "--quiet", *baked, *_words(_ReadArguments, arguments)]))
    kinds = {"faces": "face", "edges": "edge", "points": "point"}
    entries = [(entry.get("elementType") or kinds[entry["kind"]], entry) for entry in found["sets"]]
    return found["prim"], {
        entry.get("name", entry["expression"]): Elements(entry["expression"], kind, array("i", entry["indices"]))
        for kind, entry in entries
    }


def drive(garment: "FilePath", cache: "FilePath", output: "FilePath", **arguments: "Unpack[DriveArguments]") -> "Sdf.Layer":
    """Moves the render mesh of a built garment with a simulated cache, as ``usdtailor drive`` does, and opens the output.

    Args:
        garment: The output of :func:`build`.
        cache: The simulation mesh with time samples of its points, or a ``.npz`` of points.
        output: The file to write. ``force`` overwrites it.
        arguments: Those of :class:`DriveArguments`, which are the options of ``usdtailor drive``.
    """
    words = _words(DriveArguments, arguments)
    _command(["drive", os.fspath(garment), "--cache", os.fspath(cache), "-o", os.fspath(output), "--quiet", *words])
    return _opened(output)


# The option by which a subcommand prints its report.
_REPORTS = {"build": ["--report", "-"], "fit": ["--report", "-"], "info": ["--json"], "check": ["--json"], "sets": ["--json"]}


def run(arguments: "Sequence[FilePath]") -> Any:
    """Runs the command and returns its report: the JSON of ``build``, ``fit``, ``info``, ``check``, ``sets`` and ``options``, and the
    text of others.

    Args:
        arguments: Those of the command line, such as ``["build", "coat.usda", "-o", "out.usda", "--variants", "size"]``.

    Raises:
        TailorError: What the command refuses. Faults of garments are in the report of ``check``.
    """
    words = [os.fspath(argument) for argument in arguments]
    flags = _REPORTS.get(words[0] if words else "", [])
    flags = [] if {"--dry-run", *flags[:1]} & set(words) else flags
    text = _command([*words[:1], *flags, *words[1:]], examines=words[:1] == ["check"])
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def _report(command: str, inputs: list[str], output: "FilePath", words: list[str]) -> dict[str, Any]:
    report: dict[str, Any] = run([command, *inputs, "-o", output, "--quiet", *words])
    return report


def _examined(command: str, source: Source, **arguments: Any) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="usdtailor-") as folder:
        path = _flattened(source, folder) if _is_stage(source) else os.fspath(source)
        found: dict[str, Any] = json.loads(_command([command, path, "--json", "--quiet", *_words(ExamineArguments, arguments)], examines=command == "check"))
        return found


def _words(kind: Any, arguments: Mapping[str, Any]) -> list[str]:
    """The options of the command for the arguments of a function, which are those that `kind` declares."""
    known = kind.__optional_keys__
    for name in arguments.keys() - known:
        raise TypeError(f"there is no argument {name!r}; there are {', '.join(sorted(known))}")
    given = dict(arguments)
    words = [part for key, value in _flat(given.pop("options", None) or {}) for part in ("--set", f"{key}={_text(value)}")]
    for name, value in given.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
        elif isinstance(value, Sequence) and not isinstance(value, str):
            words += [part for one in value for part in (flag, os.fspath(one) if isinstance(one, os.PathLike) else str(one))]
        else:
            words += [flag, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
    return words


def _flat(options: Options, above: str = "") -> "Iterator[tuple[str, Value]]":
    """The options by their full keys."""
    for key, value in options.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield above + key, value


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else ",".join(map(str, value)) if isinstance(value, Sequence) else str(value)


def _is_stage(source: Source) -> bool:
    return not isinstance(source, (str, os.PathLike))


def _flattened(stage: "Usd.Stage", folder: str) -> str:
    """The stage as one file. Its asset paths become absolute."""
    path = str(Path(folder, "stage.usdc"))
    stage.Flatten(addSourceFileComment=False).Export(path)
    return path


def _written(output: "FilePath") -> "Sdf.Layer | None":
    """The layer that was written; none of a folder of several, or without usd-core."""
    try:
        return None if os.path.isdir(output) else _opened(output)
    except ModuleNotFoundError:
        return None


def _opened(output: "FilePath") -> "Sdf.Layer":
    """A layer that may have been open before the command wrote it."""
    from pxr import Sdf

    layer = Sdf.Layer.Find(os.fspath(output))
    if layer is None:
        return Sdf.Layer.FindOrOpen(os.fspath(output))
    layer.Reload(force=True)
    return layer


def _detached(written: Path) -> "Sdf.Layer":
    """The content of a file as an anonymous layer, without the file's source and the record of it."""
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous("tailored.usdc")
    layer.TransferContent(Sdf.Layer.OpenAsAnonymous(str(written)))
    layer.subLayerPaths.clear()
    data = dict(layer.customLayerData)
    data.pop(_RECORD, None)
    layer.customLayerData = data
    return layer
