"""`labbook compare`: what was predicted beside what was measured."""

from typing import Annotated

import typer

from labbook.cli.common import FACTORS_AS_OPTIONS, BookOption, JsonOption, WhereOption, emit, progress

NOT_MET = 1
"""Exit code where a prediction is not met."""

CONTEXT_SETTINGS = FACTORS_AS_OPTIONS


def compare(
    context: typer.Context,
    where: WhereOption = None,
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 where a prediction is not met, as scripts want it.")
    ] = False,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show what the simulator predicts beside what was measured, condition by condition.

    Each condition is simulated as it was run, in the scene that [simulation] of labbook.toml names. A prediction is
    met where it differs from the measurement by no more than the expanded uncertainty of both: half the measured
    95 % interval and two standard uncertainties of the prediction, added in quadrature. Nothing is written; the same
    table stands in the report, with ids that `labbook why` traces. The first call compiles the simulator, up to half a
    minute.

    The exit code is 0 whether or not predictions are met; with --check it is 1 where one is not.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook compare --foot small --check
    """
    from labbook.actions.report_command import selection
    from labbook.actions.simulate.comparing_predictions import as_data, as_lines, compare_predictions
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        text = selection(opened_book.configuration, where, context.args)
        with progress("compare", None, shown=not as_json) as step:
            compared = compare_predictions(opened_book, text, step)
    emit(as_data(compared), [] if as_json else as_lines(compared), as_json)
    if check and not compared.met:
        raise typer.Exit(NOT_MET)
