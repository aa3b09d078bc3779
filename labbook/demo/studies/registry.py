"""The campaigns of studies that `labbook demo --study` makes, by name."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

Step = Callable[[str], None]
MakeStudy = Callable[[Path, int, Step, Step], str]
"""Writes a study's campaign into a folder, from a seed; returns the command to go on with."""


def _plate(folder: Path, seed: int, step: Step, say: Step) -> str:
    from labbook.demo.studies.force_plate import plate_campaign
    from labbook.demo.studies.force_plate_files import make_plate_book

    step("simulating the jumps")
    book = make_plate_book(folder, plate_campaign(seed), step, say)
    return shlex.join(["labbook", "study", "force-plate", "--book", str(book)])


def _emulator(folder: Path, seed: int, step: Step, say: Step) -> str:
    from labbook.demo.studies.emulator import emulator_campaign
    from labbook.demo.studies.emulator_files import make_emulator_book

    step("simulating the jumps")
    book = make_emulator_book(folder, emulator_campaign(seed), step, say)
    return shlex.join(["labbook", "study", "emulator", "--book", str(book)])


def _sheet(study: str, campaign: str) -> MakeStudy:
    def make(folder: Path, seed: int, step: Step, say: Step) -> str:
        from labbook.demo.studies import sheets

        step("drawing the campaign")
        book = sheets.make_sheet_book(folder, getattr(sheets, campaign)(seed), step, say)
        return shlex.join(["labbook", "study", study, "--book", str(book)])

    return make


STUDIES: Mapping[str, MakeStudy] = {
    "force-plate": _plate,
    "characterisation": _sheet("characterisation", "oscillation_campaign"),
    "emulator": _emulator,
    "compaction": _sheet("compaction", "flask_campaign"),
    "field": _sheet("field", "walk_campaign"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.1.2, 2.2.3); a new one is a function and a line here."""
