"""The command as functions."""

import json
import os
import tempfile
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from ._command import run

if TYPE_CHECKING:
    from pxr import Sdf, Usd, UsdGeom

Source = Union[str, "os.PathLike[str]", "Usd.Stage"]
Value = Union[str, int, float, bool, Sequence[str]]
Options = Mapping[str, Union[Value, "Options"]]
"""Options by their keys, ``{"sim.maxEdgeLength": 2}``, or nested as in a recipe, ``{"sim": {"maxEdgeLength": 2}}``."""

# The key of the build's record. It names the source, which for a stage is a temporary file.
_RECORD = "tailor"


@dataclass(frozen=True)
class Built:
    """What a build made."""

    layer: "Sdf.Layer | None"
    """The simulation mesh and the render mesh, and what changes on the model. Of a file, the output itself, over its source; of a
    stage, an anonymous layer to sublayer into it. None of a file where usd-core is not installed."""
    report: dict[str, Any]
    """Counts, quality figures, times, the complete recipe and warnings, as ``usdtailor build --report`` writes them."""


def build(
    source: Source,
    output: "str | os.PathLike[str] | None" = None,
    *,
    recipe: "str | os.PathLike[str] | None" = None,
    options: "Options | None" = None,
    prim: "str | None" = None,
    time: "float | None" = None,
    all: bool = False,
    flatten: bool = False,
    force: bool = False,
) -> Built:
    """Makes a simulation mesh and a render mesh of a garment.

    Args:
        source: A USD or ``.tailor`` file, with an ``output``; or an open stage, as it is now, edits included.
        output: The file to write, for a file. ``force`` overwrites it.
        recipe: A ``.tailor`` file with options.
        options: Options by their keys, such as ``{"sim.maxEdgeLength": "8mm", "render.level": 2}``, or nested as in a
            ``.tailor`` file: ``{"sim": {"maxEdgeLength": "8mm"}, "seam": {"side": {"width": 0.6}}}``.
        prim: Path of the mesh, if there are several.
        time: Time at which values are read. [time codes]
        all: All meshes; panels whose borders coincide are sewn.
        flatten: Write one self-contained file.

    Raises:
        TailorError: The garment, an option or the output is refused. Nothing is written then.
    """
    arguments = _arguments(recipe, options, prim, time, all)
    if not _is_stage(source):
        if output is None:
            raise TypeError("a build of a file needs an output; a build of an open stage returns a layer instead")
        arguments += [name for name, given in (("--flatten", flatten), ("--force", force)) if given]
        report = _report(os.fspath(source), os.fspath(output), arguments)
        try:
            from pxr import Sdf
        except ModuleNotFoundError:
            return Built(None, report)
        return Built(_opened(Sdf.Layer.FindOrOpen(os.fspath(output)), force), report)
    if output is not None or flatten or force:
        raise TypeError("a build of an open stage returns a layer; write it with its Export()")
    with tempfile.TemporaryDirectory(prefix="usdtailor-") as folder:
        written = Path(folder, "built.usdc")
        report = _report(_flattened(source, folder), str(written), arguments)
        return Built(_detached(written), report)


@dataclass(frozen=True)
class Fitted:
    """A garment on another body."""

    layer: "Sdf.Layer | None"
    """The new points, over the garment's file. None where usd-core is not installed."""
    report: dict[str, Any]
    """Crossings, distances, lengths, angles and warnings, as ``usdtailor fit --report`` writes them."""


def fit(
    garment: "str | os.PathLike[str]",
    body: "str | os.PathLike[str]",
    to: "str | os.PathLike[str]",
    output: "str | os.PathLike[str]",
    *,
    rigid: Sequence[str] = (),
    keep_length: Sequence[str] = (),
    prim: "str | None" = None,
    all: bool = False,
    body_prim: "str | None" = None,
    pairs: "str | os.PathLike[str] | None" = None,
    force: bool = False,
) -> Fitted:
    """Moves a garment to another body, as ``usdtailor fit`` does.

    Args:
        garment: The file of the garment.
        body: The file of the body that it was made for.
        to: The file of the body that it is to fit, with the same faces or a common UV set.
        output: The file to write. ``force`` overwrites it.
        rigid: Sets whose connected parts move as wholes.
        keep_length: Sets whose edges keep their lengths.
        prim: Path of the mesh, if there are several.
        all: All meshes; panels whose borders coincide are sewn.
        body_prim: Path of the mesh in the files of bodies.
        pairs: A file of places that correspond, for bodies with neither.

    Raises:
        TailorError: The garment, a body or the output is refused. Nothing is written then.
    """
    arguments = ["fit", os.fspath(garment), "--from", os.fspath(body), "--to", os.fspath(to), "-o", os.fspath(output), "--quiet", "--report", "-"]
    arguments += _arguments(prim=prim, all=all) + (["--force"] if force else [])
    arguments += ([] if body_prim is None else ["--body-prim", body_prim]) + ([] if pairs is None else ["--pairs", os.fspath(pairs)])
    for flag, names in (("--rigid", rigid), ("--keep-length", keep_length)):
        arguments += [part for name in names for part in (flag, name)]
    report: dict[str, Any] = json.loads(run(arguments))
    try:
        from pxr import Sdf
    except ModuleNotFoundError:
        return Fitted(None, report)
    return Fitted(_opened(Sdf.Layer.FindOrOpen(os.fspath(output)), force), report)


def info(source: Source, **arguments: Any) -> dict[str, Any]:
    """What garments hold, and the meshes that :func:`build` would make: the JSON of ``usdtailor info``.

    It takes ``recipe``, ``options``, ``prim``, ``time`` and ``all`` as :func:`build` does.

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
    groups: list[dict[str, Any]] = json.loads(run(["options"]))
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

    It takes ``recipe``, ``options``, ``prim``, ``time`` and ``all`` as :func:`build` does.

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
        found = json.loads(run(["sets", path, "--json", "--quiet", *baked, *_arguments(**arguments)]))
    kinds = {"faces": "face", "edges": "edge", "points": "point"}
    entries = [(entry.get("elementType") or kinds[entry["kind"]], entry) for entry in found["sets"]]
    return found["prim"], {
        entry.get("name", entry["expression"]): Elements(entry["expression"], kind, array("i", entry["indices"]))
        for kind, entry in entries
    }


def drive(
    garment: "str | os.PathLike[str]",
    cache: "str | os.PathLike[str]",
    output: "str | os.PathLike[str]",
    *,
    clips: bool = False,
    model: bool = False,
    force: bool = False,
) -> "Sdf.Layer":
    """Moves the render mesh of a built garment with a simulated cache, as ``usdtailor drive`` does, and opens the output.

    Args:
        garment: The output of :func:`build`.
        cache: The simulation mesh with time samples of its points, or a ``.npz`` of points.
        output: The file to write. ``force`` overwrites it.
        clips: Write value clips, for long caches.
        model: Move the model too.
    """
    flags = [name for name, given in (("--clips", clips), ("--model", model), ("--force", force)) if given]
    run(["drive", os.fspath(garment), "--cache", os.fspath(cache), "-o", os.fspath(output), "--quiet", *flags])
    from pxr import Sdf

    return _opened(Sdf.Layer.FindOrOpen(os.fspath(output)), force)


def _report(source: str, output: str, arguments: list[str]) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(run(["build", source, "-o", output, "--report", "-", "--quiet", *arguments]))
    return report


def _examined(command: str, source: Source, **arguments: Any) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="usdtailor-") as folder:
        path = _flattened(source, folder) if _is_stage(source) else os.fspath(source)
        found: dict[str, Any] = json.loads(run([command, path, "--json", "--quiet", *_arguments(**arguments)], examines=command == "check"))
        return found


def _arguments(
    recipe: "str | os.PathLike[str] | None" = None,
    options: "Options | None" = None,
    prim: "str | None" = None,
    time: "float | None" = None,
    all: bool = False,
) -> list[str]:
    arguments = [] if recipe is None else ["--recipe", os.fspath(recipe)]
    arguments += [] if prim is None else ["--prim", str(prim)]
    arguments += [] if time is None else ["--time", str(time)]
    arguments += ["--all"] if all else []
    for key, value in _flat(options or {}):
        arguments += ["--set", f"{key}={_text(value)}"]
    return arguments


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


def _opened(layer: "Sdf.Layer", written_again: bool) -> "Sdf.Layer":
    """A layer that may have been open before the command wrote it."""
    if written_again:
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
