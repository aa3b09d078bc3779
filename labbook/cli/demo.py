"""`labbook demo`: a whole campaign to try everything on."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit, progress
from labbook.presenting.terminal import say


def demo(
    folder: Annotated[Path, typer.Argument(help="An empty folder, or one that does not exist yet.")],
    seed: Annotated[int, typer.Option("--seed", help="The same seed makes the same files.")] = 1,
    full: Annotated[bool, typer.Option("--full", help="Write 12-minute logs (4.4 GB) instead of short ones.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Make the demonstration: synthetic instruments' files, a book, everything ingested, and the report.

    The campaign is the thesis's chapter 5, drawn from a model with known truth (truth.json, docs/demonstration.md).

    Example: labbook demo demo-book
    """
    from labbook.demo.campaign import make_campaign
    from labbook.demo.running import run_demo

    with progress("demonstration", None, shown=not as_json) as step:
        done = run_demo(folder, make_campaign(seed), full, step, lambda line: None if as_json else say(line))
    emit(done, [f"the report: {done.page}"], as_json)
