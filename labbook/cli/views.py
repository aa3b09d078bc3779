"""Commands that only read: show, plot, channels, formats, config, analysis, compare, why."""

from pathlib import Path
from textwrap import shorten
from typing import Annotated

import typer

from data_schema.errors import BookDamaged, UsageError
from labbook.cli.common import BookOption, RunArgument, WhereOption, opened, options_given, reading, say_waiting
from labbook.terminal import Shown, columns, progress


def show(run: RunArgument, book: BookOption = None) -> Shown:
    """Show a run: facts, jumps that a person reviewed, files with channels and gaps, charges, notes, its history.

    Example: labbook show r017
    """
    from labbook.actions.runs.run_view import run_view, view_lines
    from labbook.analysis.outcomes.detection import Detections

    with reading(book) as (opened_book, connection):
        found = run_view(Detections(connection, opened_book.store), opened_book.configuration, run)
    return Shown(found, view_lines(found))


def plot(
    run: RunArgument,
    jump: Annotated[int | None, typer.Option(help="The jump to show enlarged.")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A .png, .svg, .pdf or .html file; the page zooms.")
    ] = None,
    book: BookOption = None,
) -> Shown:
    """Plot the body height of a run with its jumps, misfires, gaps and verdicts, and one jump enlarged.

    The enlarged jump has the leg length below it where the log has it.

    Example: labbook plot r017 --jump 4 --out r017.png
    """
    from labbook.actions.runs.run_plot import picture_named, plot_run

    with reading(book) as (opened_book, connection):
        plotted = plot_run(opened_book, connection, run, jump, out or picture_named(run))
    lines = [str(plotted.path), *([plotted.remark] if plotted.remark else [])]
    return Shown({"run": run, "figure": plotted.path, "remark": plotted.remark}, lines)


def channels() -> Shown:
    """List what a column of a log or of a charger sheet can be declared as, with unit and meaning.

    Units are those that values are stored in; a file's own unit is declared with the column and converted.

    Example: labbook channels
    """
    from data_schema.vocabulary import CHANNELS
    from labbook.config.profiles import DATE, OWN, SHEET_COLUMNS, TIME

    of_log = {
        **{name: (kind.unit, kind.meaning) for name, kind in CHANNELS.items()},
        TIME: ("s", "the time column"),
        DATE: ("-", "the dates beside a column of times of day"),
        f"{OWN}NAME": ("any", "a quantity of your own, kept as NAME; it feeds no result"),
    }
    rows = [(name, unit, meaning) for name, (unit, meaning) in of_log.items()]
    sheet = list(SHEET_COLUMNS.items())
    data = [
        *({"of": "log", "name": name, "unit": unit, "meaning": meaning} for name, unit, meaning in rows),
        *({"of": "charger sheet", "name": name, "unit": None, "meaning": meaning} for name, meaning in sheet),
    ]
    lines = [
        *columns(("channel", "unit", "meaning"), rows),
        *columns(("charger sheet", "meaning"), sheet),
        "A second plate's forces, moments and centres of pressure have the ending _2, a third's _3.",
        'On the command line: `labbook ingest FILE --column "COLUMN=CHANNEL:UNIT"`; in labbook.toml: [profiles.NAME].',
    ]
    return Shown(data, lines)


def formats() -> Shown:
    """List the file formats, by what a file is recognised as one, and which plug-in a format comes from.

    Any other text with columns is read as delimited_log; what it does not say is declared with flags or a profile.

    Example: labbook formats
    """
    from ingest.formats.registry import described_formats, plugins

    found = described_formats()
    rows = [(each.name, each.version, each.plugin or "-", each.evidence, each.what) for each in found]
    faults = list(plugins().faults)
    more = "`--explain` of `labbook ingest` shows by what evidence a file was recognised, `--format` decides it."
    return Shown(
        {"formats": found, "faults": faults},
        [*columns(("format", "version", "plug-in", "recognised by", "what"), rows), more, *faults],
    )


def analysis(book: BookOption = None) -> Shown:
    """Show what was decided about the analysis, when and by whom, and what departs from it.

    [analysis] of labbook.toml is in the journal before the first file is ingested or the first charge stated. What it
    said then rules; the report calls exploratory what departs from it. A later change is never refused, it is listed.
    So are corrections of runs and charges made since, runs moved to another condition, logs taken off runs, charges
    and logs that came to runs which had theirs, and other rules in [protocol] which jumps count; a report, and
    `labbook stats`, list the runs and conditions that their selection leaves out. The last line says what is not
    watched.

    Example: labbook analysis
    """
    from labbook.analysis.preregistration.planned import NOT_WATCHED, planned_analysis, planned_sentences

    with reading(book) as (opened_book, connection):
        found = planned_analysis(connection, opened_book.configuration)
    watched = found.stated and found.first_measured_utc is not None
    return Shown(found, (*planned_sentences(found), *((NOT_WATCHED,) if watched else ())))


def config(
    schema: Annotated[
        bool,
        typer.Option("--schema", help="Print the JSON schema of labbook.toml, by which an editor helps to write it."),
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Check what labbook.toml says: every fault with its place, what was given and what is allowed.

    Example: labbook config; labbook config --schema > labbook.schema.json
    """
    from labbook.book.opening import find_folder, read_configuration
    from labbook.config.model import Configuration
    from labbook.config.reading import json_schema

    if schema:
        return Shown(json_schema(Configuration))
    folder = find_folder(book)
    found, path = read_configuration(folder), folder / "labbook.toml"
    return Shown({"path": path, "sha256": found.sha256}, [f"{path} can be read, and every key has a meaning."])


NOT_MET = 1
"""Exit code where a prediction is not met."""


def compare(
    context: typer.Context,
    where: WhereOption = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Exit with 1 also where a condition is not as simulated, or none can be compared."
        ),
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Show what the simulator predicts beside what was measured, condition by condition.

    Each condition is simulated as it was run, in the scene that [simulation] of labbook.toml names. A prediction is
    met where it differs from the measurement by no more than the expanded uncertainty of both: half the measured
    95 % interval and two standard uncertainties of the prediction, added in quadrature. A prediction is marked where
    the simulation itself errs by a tenth of its standard error or more. Nothing is written; the same table stands in
    the report, with ids that `labbook why` traces. The first call compiles the simulator, up to half a minute.

    Hypotheses of labbook.toml come first, without a scene alone: whether each holds, fails or cannot be told, as in the
    report (docs/hypotheses.md).

    Of a scene of single jumps it is said whether active damping saves at equal height on its ground (docs/falsify.md).

    The exit code is 1 where a hypothesis fails; with --check also where a prediction is not
    met, or none can be compared.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook compare --foot small --check
    """
    from labbook.actions.report_command import selection
    from labbook.actions.simulate.comparing_predictions import as_data, as_lines, compare_predictions

    with opened(book) as opened_book:
        text = selection(opened_book.configuration, where, context.args, options_given(context))
        with progress("compare", None) as step:
            compared = compare_predictions(opened_book, text, step)
    return Shown(
        as_data(compared), as_lines(compared), NOT_MET if compared.fails or (check and not compared.met) else 0
    )


def why(
    number: Annotated[str, typer.Argument(help="The provenance id beside a number in a report, or its beginning.")],
    check: Annotated[
        bool, typer.Option("--check", help="Compute the number anew from raw copies and journal, and compare.")
    ] = False,
    script: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write a Python script that computes the number without labbook, and its table, into an empty folder.",
        ),
    ] = None,
    in_r: Annotated[bool, typer.Option("--r", help="With --script: write the same in R, too.")] = False,
    book: BookOption = None,
) -> Shown:
    """Trace a number to the algorithm, the facts and the bytes it was computed from.

    The numbers of a report are in its numbers.json. With --check, the number is computed anew from raw copies and
    journal as of the newest report that shows it: exit code 3 where it comes out otherwise, or an input was altered.

    With --script, a Python file (numpy and scipy alone) and a table of what was measured are written that give the
    number again: each step with its formula and its source. The script is run once; exit code 3 where it prints
    another number. What was simulated stands in the table.

    Example: labbook why 3fa9c2d1 --check; labbook why 3fa9c2d1 --script number
    """
    from labbook.actions.upkeep.tracing import find_number, trace, trace_lines

    if in_r and script is None:
        raise UsageError("--r was given without --script: name the folder that the scripts go to, as --script number.")
    with opened(book) as opened_book:
        say_waiting(opened_book)
        with opened_book.reading() as connection:
            asked = find_number(opened_book, connection, number)
            found = trace(connection, asked)
        if not check and script is None:
            return Shown(found, trace_lines(found))
        data: dict[str, object] = {"trace": found}
        lines: list[str] = []
        stands = True
        if check:
            from labbook.actions.upkeep.tracing import recompute

            with progress("replaying", None) as step:
                (checked,) = recompute(opened_book, [asked], step)
            data["check"], stands = checked, checked.stands is not False
            lines.append(checked.sentence)
        if script is not None:
            from labbook.scripts.writing import write_and_run

            with progress("script", None) as step:
                written = write_and_run(opened_book, asked, script, step, in_r=in_r)
            data["script"], stands = written, stands and written.same
            lines += written.lines
    return Shown(data, [*lines, *trace_lines(found)], 0 if stands else BookDamaged.exit_code)


_LONGEST_LINE = 300
"""Of what a command stated; --json has all of it."""


def journal(
    newest: Annotated[int, typer.Option("--newest", "-n", min=1, help="So many commands.")] = 20,
    before: Annotated[int | None, typer.Option(min=1, help="Those that ended before this entry.")] = None,
    book: BookOption = None,
) -> Shown:
    """List what was stated, a line a command, the newest last: its entries, when, about which run, what, why, by whom.

    Example: labbook journal -n 50
    """
    from labbook.actions.upkeep.journal_view import newest_commands
    from labbook.config.local_time import local_text

    with reading(book) as (opened_book, connection):
        zone = opened_book.configuration.study.time_zone
        found = newest_commands(connection, newest, before)[::-1]
    rows = [
        (
            one.first if one.first == one.last else f"{one.first}-{one.last}",
            local_text(one.at_utc, zone),
            one.run,
            one.person,
            shorten(f"{one.what}{f' ({one.why})' if one.why else ''}", _LONGEST_LINE, placeholder="\u2026"),
        )
        for one in found
    ]
    return Shown(found, columns(("entry", "when", "run", "by", "what"), rows, "nothing was stated."))
