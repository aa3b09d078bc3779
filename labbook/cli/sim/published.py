"""`labbook sim published`: the thesis's experiments on emulator and force plate, simulated beside what it says."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit, progress
from labbook.cli.sim.options import AccuracyOption


def published(
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Write it as a document, too: a .md file.")
    ] = None,
    accuracy: AccuracyOption = 1e-6,
    as_json: JsonOption = False,
) -> None:
    """Simulate the published experiments on ground emulator and force plate, and compare.

    Shows the last of a hundred (eighty) jumps at each gain, the published number beside the simulated one; which of
    them agree; what cannot be matched, and why; and which inputs are assumed.

    Example: labbook sim published --out published.md
    """
    from data_schema.errors import UsageError
    from labbook.presenting.simulation.published_experiments import as_data, document, notes, terminal_tables
    from simulator.steady.published_numbers import comparisons
    from simulator.steady.tables import STEPS, steady_tables

    if out is not None and out.suffix != ".md":
        raise UsageError(f"--out {out} is no name for a document in Markdown: end it in .md.")

    with progress("experiments", STEPS, shown=not as_json) as step:
        tables = steady_tables(accuracy, step)
        compared = comparisons(tables)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(document(tables, compared), encoding="utf-8")
    lines = []
    for title, (head, *rows) in terminal_tables(tables, compared).items():
        lines += [f"{title}:", *columns(head, rows), ""]
    lines += notes(tables, compared)
    files = {} if out is None else {"document": str(out)}
    emit({**as_data(tables, compared), **files}, [*lines, *files.values()], as_json)
