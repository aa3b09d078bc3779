"""The campaigns of studies that `labbook demo --study` makes, by name."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

STUDIES: Mapping[str, tuple[str, str, str]] = {
    "force-plate": ("labbook.demo.studies.force_plate", "plate_campaign", "make_plate_book"),
    "characterisation": ("labbook.demo.studies.sheets", "oscillation_campaign", "make_sheet_book"),
    "emulator": ("labbook.demo.studies.emulator", "emulator_campaign", "make_emulator_book"),
    "bed": ("labbook.demo.running", "make_campaign", "make_bed_book"),
    "compaction": ("labbook.demo.studies.sheets", "flask_campaign", "make_sheet_book"),
    "field": ("labbook.demo.studies.sheets", "walk_campaign", "make_sheet_book"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3): a module, its function that draws a campaign from
a seed, and the one that writes it into a folder and makes its book."""


def make_study(study: str, folder: Path, seed: int, step: Callable[[str], None], say: Callable[[str], None]) -> str:
    """Make the book of a study's campaign; returns the command to go on with."""
    module, draw, make = STUDIES[study]
    functions = vars(import_module(module))
    step("drawing the campaign")
    book = functions[make](folder, functions[draw](seed), step, say)
    return shlex.join(["labbook", "study", study, "--book", str(book)])
