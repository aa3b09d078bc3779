"""`labbook plot`: a run's log as a picture."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import BookOption, JsonOption, emit


def plot(
    run: Annotated[str, typer.Argument(help="The run.")],
    jump: Annotated[int | None, typer.Option("--jump", help="The jump to show enlarged.")] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="A .png, .svg or .pdf file.")] = None,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Plot the body height of a run with its jumps, gaps and verdicts, and one jump enlarged.

    Example: labbook plot r017 --jump 4 --out r017.png
    """
    from labbook.actions.runs.run_plot import plot_run
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.reading() as connection:
        path = plot_run(opened_book, connection, run, jump, out or Path(f"{run}.png"))
    emit({"run": run, "figure": str(path)}, [str(path)], as_json)
