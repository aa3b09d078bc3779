"""The campaigns of studies that `labbook demo --study` makes, by name."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

Step = Callable[[str], None]
_MakeBook = Callable[[Path, int, Step, Step], Path]
MakeStudy = Callable[[Path, int, Step, Step], str]
"""Writes a study's campaign into a folder, from a seed; returns the command to go on with."""


def _plate(folder: Path, seed: int, step: Step, say: Step) -> Path:
    from labbook.demo.studies.force_plate import plate_campaign
    from labbook.demo.studies.force_plate_files import make_plate_book

    return make_plate_book(folder, plate_campaign(seed), step, say)


def _emulator(folder: Path, seed: int, step: Step, say: Step) -> Path:
    from labbook.demo.studies.emulator import emulator_campaign, make_emulator_book

    return make_emulator_book(folder, emulator_campaign(seed), step, say)


def _bed(folder: Path, seed: int, step: Step, say: Step) -> Path:
    from labbook.demo.campaign import make_campaign
    from labbook.demo.running import run_demo

    return Path(run_demo(folder, make_campaign(seed), False, step, say).book)


def _sheet(campaign: str) -> _MakeBook:
    def make(folder: Path, seed: int, step: Step, say: Step) -> Path:
        from labbook.demo.studies import sheets

        return sheets.make_sheet_book(folder, getattr(sheets, campaign)(seed), step, say)

    return make


def _study(name: str, make: _MakeBook) -> MakeStudy:
    def made(folder: Path, seed: int, step: Step, say: Step) -> str:
        step("drawing the campaign")
        return shlex.join(["labbook", "study", name, "--book", str(make(folder, seed, step, say))])

    return made


_BOOKS: Mapping[str, _MakeBook] = {
    "force-plate": _plate,
    "characterisation": _sheet("oscillation_campaign"),
    "emulator": _emulator,
    "bed": _bed,
    "compaction": _sheet("flask_campaign"),
    "field": _sheet("walk_campaign"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3); a new one is a function and a line here."""
STUDIES: Mapping[str, MakeStudy] = {name: _study(name, make) for name, make in _BOOKS.items()}
