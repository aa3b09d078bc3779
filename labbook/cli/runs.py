"""`labbook runs`: list, diff, import, inbox, dismiss, restore."""

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from labbook.cli.common import (
    AsOption,
    BookOption,
    MaybeWhyOption,
    WhereOption,
    reading,
    stating,
    tell,
    tell_statement,
)
from labbook.terminal import Shown, asking, columns, for_program, listed, plain, say, with_files

app = typer.Typer(no_args_is_help=True)


class DateOrder(StrEnum):
    """The order of a date with slashes."""

    DAY_FIRST = "d/m/y"
    MONTH_FIRST = "m/d/y"


@app.command("list")
def list_command(where: WhereOption = None, book: BookOption = None) -> Shown:
    """List runs by day and position.

    Example: labbook runs list --where "foot=small and not state=void"
    """
    from data_schema.queries.runs import compile_known, list_runs, shown_runs, where_columns
    from data_schema.where import parse

    with reading(book) as (_opened_book, connection):
        expression = compile_known(parse(where), where_columns(connection)) if where else None
        if for_program():
            return Shown(list_runs(connection, expression))
        shown = shown_runs(connection, expression)
    return Shown(None, run_lines(shown))


def run_lines(rows: "Sequence[Sequence[Any]]") -> list[str]:
    """Return the table of what `shown_runs` lists."""
    head = ("run", "day", "position", "kind", "condition", "battery", "duration", "jumps", "starts", "state")
    durations = {duration_s: "" if duration_s is None else f"{duration_s:g} s" for *_, duration_s, _, _, _ in rows}
    cells = [(*row[:-4], durations[row[-4]], *row[-3:]) for row in rows]
    return columns(head, cells, "no runs.")


@app.command("diff")
def diff_command(
    first: Annotated[str, typer.Argument(metavar="RUN", help="A run.")],
    second: Annotated[str, typer.Argument(metavar="OTHER", help="Another run.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw both body heights: a .png, .svg or .pdf file, or .html, which zooms."),
    ] = None,
    book: BookOption = None,
) -> Shown:
    """Set two runs side by side and show what differs: facts, files and how they were read, channels, charges,
    numbers, verdicts.

    Numbers have their standard errors; sampling rates are alike where they differ by less than a thousandth. In the
    figure, time 0 is the lift-off of each run's first flight, or the start of each log where one has no flight.

    Example: labbook runs diff r017 r018 --out both.png
    """
    from labbook.actions.runs.run_plot import PICTURES, plot_runs
    from labbook.actions.runs.run_view import compare_runs, difference_lines, run_view
    from labbook.analysis.outcomes.detection import Detections
    from reports.figures.kind import check_form

    check_form("--out", out, PICTURES)
    with reading(book) as (opened_book, connection):
        detections = Detections(connection, opened_book.store)
        views = [run_view(detections, opened_book.configuration, name) for name in (first, second)]
        found = compare_runs(*views)
        if out is not None:
            plot_runs(opened_book, connection, (found.first, found.second), out)
    return with_files(plain(found), difference_lines(found, views[0].time_zone), {"figure": out})


@app.command("import")
def import_command(
    sheet: Annotated[Path, typer.Argument(help="The run sheet: CSV, or a workbook.")],
    dates: Annotated[DateOrder | None, typer.Option(help="How dates with slashes are written, as 03/04/2021.")] = None,
    encoding: Annotated[str | None, typer.Option(help="The page of text that is not UTF-8; else cp1252.")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be stated; store nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Import a filled-in run sheet; rows that are not filled in yet wait, the same sheet again changes nothing.

    Dates as 2021-06-01 or 1.6.2021, cells between commas, semicolons or tabs, numbers with a decimal point or comma.

    Example: labbook runs import runs.csv
    """
    from ingest.tables.sheet import SheetFile
    from labbook.actions.files.named_files import own_name, read_bytes
    from labbook.actions.runs.runs_importing import RunsImported, import_runs
    from labbook.plan.local_time import SheetQuestion

    file = SheetFile(own_name(sheet), read_bytes(sheet), encoding)

    done = RunsImported()

    def attempt(dates: str | None) -> None:
        nonlocal done
        with stating(book, person, dry_run=dry_run) as (opened_book, session):
            done = import_runs(opened_book, session, file, dates=dates)

    try:
        attempt(dates)
    except SheetQuestion as question:
        if dates is not None or not asking():
            raise
        say(f"{question.sentence} (d/m/y: the day, m/d/y: the month).", err=True)
        chosen = ""
        while chosen not in question.choices:
            chosen = typer.prompt(" or ".join(question.choices), err=True).strip()
        attempt(chosen)
    line = (
        f"{len(done.stated)} runs stated, {len(done.filled_in)} filled in, {len(done.unchanged)} there already, "
        f"{len(done.not_made)} still to be made{' (dry run: nothing stored)' if dry_run else ''}."
    )
    if done.withdrawn:
        line += f" {len(done.withdrawn)} were planned and are withdrawn."
    if done.encoding != "utf-8":
        line += f" {file.name} is no UTF-8 text and was read as {done.encoding} (`--encoding`)."
    count = sum(map(len, done.taken_in.values()))
    taken = listed([f"{' and '.join(names)} to {run}" for run, names in done.taken_in.items()])
    waited = [f"{count} that waited in the inbox belong{'s' * (count == 1)} now: {taken}."] if count else []
    return tell(vars(done), [line, *waited])


@app.command("dismiss")
def dismiss_command(
    what: Annotated[
        str, typer.Argument(metavar="ITEM", help="A name of the inbox: FILE#ROW, FILE, or a charge's uid.")
    ],
    why: Annotated[str, typer.Option("--why", "--reason", help="Why it belongs to no run.")],
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Take an item out of the inbox that belongs to no run; it stays in the book, and can come back.

    Example: labbook runs dismiss charges.csv#4 --why "the pack of another robot"
    """
    from labbook.actions.files.stored_files import dismiss

    return tell_statement(book, person, lambda session: dismiss(session, what, why), item=what, why=why)


@app.command("restore")
def restore_command(
    what: Annotated[str, typer.Argument(metavar="ITEM", help="What was dismissed: FILE#ROW, or FILE.")],
    why: MaybeWhyOption = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Bring a dismissed item back to the inbox.

    Example: labbook runs restore charges.csv#4
    """
    from labbook.actions.files.stored_files import restore_item

    return tell_statement(book, person, lambda session: restore_item(session, what, why), item=what, why=why)


@app.command("inbox")
def inbox_command(book: BookOption = None) -> Shown:
    """List files and charges that belong to no run, and why, where it is known; `labbook assign` gives them one.

    Of a run that has another charge, correct that one (`labbook correct RUN mah=VALUE`), which settles rows that say
    so; add the row where the pack was charged in two parts (`labbook assign ITEM RUN --add`); or dismiss it.

    Example: labbook runs inbox
    """
    from data_schema.queries.files import inbox
    from labbook.actions.files.stored_files import why_waiting

    with reading(book) as (_opened_book, connection):
        waiting = why_waiting(connection, inbox(connection))
    rows = [(each.item.what, each.item.name, each.item.stated_run, each.item.detail, each.why) for each in waiting]
    lines = columns(("what", "name", "stated run", "detail", "waits because"), rows, "the inbox is empty.")
    return Shown([{**plain(each.item), "why": each.why} for each in waiting], lines)
