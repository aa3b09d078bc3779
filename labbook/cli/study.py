"""`labbook study`: studies of the thesis, each from what was measured to its verdict."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption
from labbook.terminal import emit, within_width

app = typer.Typer(no_args_is_help=True)


@app.callback()
def studies() -> None:
    """Studies of the thesis, each from what was measured to its verdict."""


@app.command()
def compaction(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one filled flask a row.")],
    grain: Annotated[float, typer.Option("--grain", metavar="MM", help="The grains' diameter, mm.")],
    level: Annotated[float, typer.Option("--level", help="Level of the intervals.")] = 0.95,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw it (fig. 5.2): a .png, .svg or .pdf file.")
    ] = None,
    decimal: Annotated[
        str | None, typer.Option("--decimal", metavar="SIGN", help="The table's decimal sign, where it is unclear.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show how densely a bed's grains lie, poured and compacted, from the water that fills flasks of several sizes.

    FILE has the columns radius_mm, state (two words, such as loose and compacted) and water_ml, in any units that their
    names say, and flask_ml where the flasks' volumes were measured. The fractions are extrapolated over grain size /
    radius to a bed without walls (thesis 5.1.2).

    Example: labbook study compaction flasks.csv --grain 3.4 --plot compaction.pdf
    """
    from labbook.actions.simulate.pictures import save_plot
    from labbook.actions.studies.compaction import compaction_of
    from labbook.cli.reading import read_text
    from labbook.presenting.studies.compaction import as_data, drawn, sentences
    from reports.figures.compaction import draw_compaction
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    study = compaction_of(read_text(file, marked_utf_16=True), file, grain, level, decimal)
    if plot is not None:
        save_plot(lambda: draw_compaction(drawn(study)), plot)
    files = {} if plot is None else {"plot": str(plot)}
    emit({**as_data(study), **files}, [*within_width(sentences(study)), *files.values()], as_json)
