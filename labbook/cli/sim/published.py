"""`labbook sim published`: the thesis's experiments on emulator and force plate, simulated beside what it says."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit, progress


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("published")(published)


def published(
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Write it as a document, too: a .md file.")
    ] = None,
    accuracy: Annotated[float, typer.Option("--accuracy", help="The relative error aimed at.")] = 1e-6,
    as_json: JsonOption = False,
) -> None:
    """Simulate the published experiments on ground emulator and force plate, and compare.

    Shows the last of a hundred (eighty) jumps at each gain, the published number beside the simulated one; which of
    them agree; what cannot be matched, and why; and which inputs are assumed.

    Example: labbook sim published --out published.md
    """
    from labbook.actions.simulate.published_experiments import compare_published
    from labbook.presenting.simulation.published_experiments import as_data, notes, terminal_tables
    from simulator.steady.tables import STEPS

    with progress("experiments", STEPS, shown=not as_json) as step:
        done = compare_published(accuracy, out, step)
    lines = []
    for title, (head, *rows) in terminal_tables(done.tables, done.comparisons).items():
        lines += [f"{title}:", *columns(head, rows), ""]
    lines += notes(done.tables, done.comparisons)
    files = {} if out is None else {"document": str(out)}
    emit({**as_data(done.tables, done.comparisons), **files}, [*lines, *files.values()], as_json)
