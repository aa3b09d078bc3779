"""The campaigns of studies that `labbook demo --study` makes, by name."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from labbook.demo.campaign import make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.running import make_campaign_book, run_demo

_DRAWN_BY = {
    "force-plate": ("force_plate", "demonstration"),
    "characterisation": ("sheets", "oscillation_campaign"),
    "emulator": ("emulator", "demonstration"),
    "compaction": ("sheets", "flask_campaign"),
    "field": ("sheets", "walk_campaign"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3): a module here, and its function that draws the
files of a campaign from a seed. Of another study's runs, as of the bed's, it is the demonstration itself.
"""


def make_study(study: str, folder: Path, seed: int, step: Callable[[str], None], say: Callable[[str], None]) -> str:
    """Make the book of a study's campaign; returns the command to go on with."""
    place = _DRAWN_BY.get(study)
    step("drawing the campaign")
    if place is None:
        book = run_demo(folder, campaign_files(make_campaign(seed)), step, say).book
    else:
        module, draw = place
        files = vars(import_module(f"labbook.demo.studies.{module}"))[draw](seed)
        book = str(make_campaign_book(folder, files, step, say))
    return shlex.join(["labbook", "study", study, "--book", book])
