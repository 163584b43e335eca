# SPDX-License-Identifier: GPL-3.0-or-later
"""A build of a garment beside Blender, in a process of its own."""

import json
import tempfile
from pathlib import Path

import bpy
import usd_tailor

from . import hiding, names, recipe
from .cage import Cage, read_cage
from .links import KINDS, product


class Failed(RuntimeError):
    """A build that was refused: the messages are those of the command."""

    def __init__(self, messages: list[dict]) -> None:
        super().__init__("\n".join(message["message"] for message in messages))
        self.messages = messages


class Refused(RuntimeError):
    """An action that cannot be done to the garment as it is, with the remedy; the messages of the last build stay."""


class Job:
    """A build that runs. Poll :meth:`is_done`, then take the :meth:`result`."""

    def __init__(self, garment: bpy.types.Object, *, flatten: bool = False) -> None:
        from . import stage

        self.garment_name, self.garment_id = garment.name, garment.session_uid
        self.cage: Cage = read_cage(garment)
        self.notes = self.cage.notes + hiding.notes(garment, self.cage)
        self.folder = tempfile.TemporaryDirectory(prefix="tailor-")
        path = Path(self.folder.name)
        self.output, self._report = path / "built.usdc", path / "report.json"
        stage.write_stage(garment, self.cage).Export(str(path / "garment.usdc"))
        self.process = usd_tailor.start(
            ["build", str(path / "garment.usdc"), "-o", str(self.output), "--report", str(self._report), "--quiet"]
            + ["--flatten"] * flatten
            + _physics(garment, self.cage)
        )

    @property
    def garment(self) -> bpy.types.Object | None:
        """The garment, or none if it was deleted."""
        return next((ob for ob in bpy.data.objects if ob.session_uid == self.garment_id), None)

    def is_done(self) -> bool:
        return self.process.poll() is not None

    def cancel(self) -> None:
        """Ends the build if it runs, and removes its files. It may be called again."""
        if not self.is_done():
            self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdout, self.process.stderr):
            pipe.close()
        self.folder.cleanup()

    def result(self) -> dict:
        """The report of the build, once it is done, with what could not be read. The products are in ``output`` until :meth:`cancel`.

        Raises:
            Failed: The garment or an option was refused.
        """
        _, errors = self.process.communicate()
        report = json.loads(self._report.read_text("utf-8")) if self._report.exists() else {}
        if self.process.returncode:
            raise Failed(_faults(report, errors.strip() or f"the build ended with {self.process.returncode}"))
        report["warnings"] += [plain(text) for text in self.notes]
        return report

    def finish(self) -> dict:
        """Puts the products beside the garment, and returns the report.

        Raises:
            Failed: As :meth:`result`; or the garment was deleted.
        """
        from . import products, stage

        try:
            report, garment = self.result(), self.garment
            if garment is None:
                raise Failed([plain(f"{self.garment_name} was deleted while it was built")])
            edited = next((ob for ob in (product(garment, kind) for kind in KINDS) if ob and ob.mode != "OBJECT"), None)
            if edited:
                raise Failed([plain(f"{edited.name} is in {edited.mode.capitalize()} Mode. Leave it, so that its mesh can be made again")])
            opened = stage.Usd.Stage.Open(str(self.output))
            products.update(garment, self.cage, opened, report)
            del opened
            return report
        finally:
            self.cancel()


def _physics(garment, cage: Cage) -> list[str]:
    """Asks for the panels with their fabrics, where parts of the garment are of other fabrics. Sets of the garment may have the panels' names."""
    has_fabrics = any(value for key, value in recipe.properties(garment).items() if key.startswith(names.key("fabric", "")) and key.endswith(":faces"))
    is_free = not any(name.startswith("pattern") for name in cage.face_sets)
    return ["--physics", "aousd,chaos"] if has_fabrics and is_free else []


def plain(text: str) -> dict:
    """A message of our own, in the form of the command's."""
    return {"code": "", "message": text, "place": "", "problem": text, "remedy": "", "elements": {}}


def _faults(report: dict, text: str) -> list[dict]:
    error = report.get("error") or {}
    faults = error.get("faults") or [plain(text)]
    for fault in faults:
        words = [word for word in (fault["place"], fault["problem"]) if word]
        fault["message"] = ": ".join(words) + (f". {_sentence(fault['remedy'])}" if fault["remedy"] else "")
        fault.setdefault("elements", {})
    return faults


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]
