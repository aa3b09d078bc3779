"""`labbook report`: from the book to one page; `labbook reports`: those that were made, and what moved between two."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import AsOption, BookOption, WhereOption, opened, options_given, reading, say_waiting
from labbook.config.local_time import local_text
from labbook.terminal import Shown, columns, listed, progress

if TYPE_CHECKING:
    from data_schema.queries.history import ReportRow
    from labbook.actions.upkeep.report_differences import Cause, MovedNumber, ReportsCompared
    from labbook.book.report_numbers import ReportedNumber

app = typer.Typer(no_args_is_help=True)

ReportArgument = Annotated[
    str,
    typer.Argument(metavar="REPORT", help="Its number in `reports list`, last, last-1, or the beginning of its id."),
]
MOST_MOVED, MOST_CAUSES = 20, 12
"""Largest number of moved numbers, and of causes of a kind, that are listed without --full."""


@app.command("list")
def list_command(book: BookOption = None) -> Shown:
    """List the reports that were made of the book, the newest last.

    Example: labbook reports list
    """
    from data_schema.queries.history import list_reports

    with reading(book) as (opened_book, connection):
        found, zone = list_reports(connection), opened_book.configuration.study.time_zone
    rows = [(one.number, one.uid, local_text(one.made_utc, zone), one.person, one.numbers, _runs(one)) for one in found]
    return Shown(found, columns(("report", "id", "made", "by", "numbers", "of"), rows, "no report was made yet."))


@app.command("show")
def show_command(report: ReportArgument, book: BookOption = None) -> Shown:
    """Show what a report was made with, and its numbers as they were printed.

    Example: labbook reports show last
    """
    from labbook.actions.upkeep.report_differences import report_named
    from labbook.book.report_numbers import read_numbers

    with reading(book) as (opened_book, connection):
        made, zone = report_named(connection, report), opened_book.configuration.study.time_zone
        numbers = list(read_numbers(opened_book.store.root, made).numbers.values())
    rows = [(one.id, one.name, _value(one), one.about) for one in numbers]
    lines = [
        f"report {_called(made, zone)}",
        f"written to {made.folder}, as it counts from the book's folder",
        f"made with {', '.join(f'{name} {version}' for name, version in made.versions.items())}",
        *(columns(("id", "number", "value", "of"), rows) if rows else ()),
    ]
    return Shown({"report": made, "numbers": numbers}, lines)


@app.command("diff")
def diff_command(
    before: ReportArgument,
    after: ReportArgument,
    full: Annotated[
        bool, typer.Option("--full", help="All numbers that moved, and those that only one of the two has.")
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Say which numbers moved between two reports, by what: corrections, voids, verdicts, files, settings, versions.

    Numbers are the same where they are called the same and about the same, whatever their ids; whether one moved is
    told from what was printed. A cause is one of a number where the number rests on what it changed.

    Example: labbook reports diff last-1 last
    """
    from labbook.actions.upkeep.report_differences import compare_reports, report_named

    with reading(book) as (opened_book, connection):
        found = compare_reports(
            opened_book, connection, report_named(connection, before), report_named(connection, after)
        )
        zone = opened_book.configuration.study.time_zone
    return Shown(found, _lines(found, full, zone))


def _lines(found: "ReportsCompared", full: bool, zone: str) -> list[str]:
    lines = [_answer(found), f"from report {_called(found.before, zone)}", f"to report {_called(found.after, zone)}"]
    if found.before.seq > found.after.seq:
        lines.insert(0, "The first of the two is the newer one: causes stand as they came, numbers backwards.")
    if found.before.selection != found.after.selection:
        lines.insert(
            0,
            f"The selections differ, {_runs(found.before)} before and {_runs(found.after)} after: numbers of a "
            "selection as a whole are in one of them alone.",
        )
    moving = [place for place, cause in enumerate(found.causes) if cause.moved]
    names = {place: str(number) for number, place in enumerate(moving, start=1)}
    moving_texts = [f"{names[place]} {_cause_text(found.causes[place])}" for place in moving]
    lines += _shortened(moving_texts, MOST_CAUSES, full)
    other_texts = [f"  {_cause_text(cause)}" for cause in found.causes if not cause.moved]
    if other_texts:
        lines += [
            "said between the two, and no number that both have moved by it:",
            *_shortened(other_texts, MOST_CAUSES, full),
        ]
    listed = found.moved if full else found.moved[:MOST_MOVED]
    rows = [
        (one.now.name, *_pair(one), ",".join(names[place] for place in one.causes) or "?", one.now.about)
        for one in listed
    ]
    if rows:
        lines += columns(("number", "was", "is", "by", "of"), rows)
    if listed != found.moved:
        lines.append(f"and {len(found.moved) - len(listed)} more: see --full")
    reports = (found.before, found.after)
    for report, alone in zip(reports, (found.only_before, found.only_after), strict=True):
        if alone:
            lines.append(
                f"{_count(len(alone), 'number')} only in report {report.number}{'' if full else ': see --full'}"
            )
            lines += [f"  {one.name} of {one.about}: {_value(one)}" for one in alone if full]
    return lines


def _answer(found: "ReportsCompared") -> str:
    """Say in one sentence how many numbers moved, and by what."""
    if not found.common:
        return "The two reports have no number in common."
    alone = len(found.only_before) + len(found.only_after)
    more = f"; {alone} more {'is' if alone == 1 else 'are'} in one of the two alone" if alone else ""
    if not found.moved:
        return f"None of {_count(found.common, 'number')} moved{more}."
    counts = Counter(str(cause.kind) for cause in found.causes if cause.moved)
    causes = [_count(count, _NAMED.get(kind, kind)) for kind, count in counts.items()]
    by = f"by {', '.join(causes[:-1])}{' and ' if causes[1:] else ''}{causes[-1]}" if causes else ""
    n_unexplained = sum(not one.causes for one in found.moved)
    if n_unexplained:
        of_them = f"{n_unexplained} of them" if causes else "them"
        unexplained = f"nothing said between the reports explains {of_them}: `labbook db check` says what was altered"
        by = f"{by}, and {unexplained}" if by else f"and {unexplained}"
    return f"{len(found.moved)} of {_count(found.common, 'number')} moved, {by}{more}."


_NAMED = {"configuration": "change of labbook.toml", "version": "algorithm version", "run": "new run"}
_SEVERAL = {"change of labbook.toml": "changes of labbook.toml"}


def _count(count: int, what: str) -> str:
    return f"{count} {what if count == 1 else _SEVERAL.get(what, f'{what}s')}"


def _called(report: "ReportRow", zone: str) -> str:
    made = local_text(report.made_utc, zone)
    return f"{report.number} ({report.uid}), made {made} by {report.person} of {_runs(report)}"


def _runs(report: "ReportRow") -> str:
    return report.selection or "all runs"


def _cause_text(cause: "Cause") -> str:
    moved = f" ({_count(cause.moved, 'number')})" if cause.moved else ""
    reason = f', "{cause.reason}"' if cause.reason else ""
    who = "" if cause.person is None else f" ({cause.person}, {(cause.at_utc or '')[:10]})"
    return f"{cause.kind}{moved}: {cause.what}{reason}{who}"


def _shortened(lines: Sequence[str], most: int, full: bool) -> list[str]:
    return [*lines] if full or len(lines) <= most else [*lines[:most], f"and {len(lines) - most} more: see --full"]


def _value(number: "ReportedNumber") -> str:
    unit = "" if number.unit == "1" else f" {number.unit}"
    return "undefined" if number.value is None else f"{number.value:.6g}{unit}"


def _pair(moved: "MovedNumber") -> tuple[str, str]:
    """Return both values with as many digits as distinguish them."""
    shown = _value(moved.was), _value(moved.now)
    return shown if shown[0] != shown[1] else (repr(moved.was.value), repr(moved.now.value))


def report(
    context: typer.Context,
    where: WhereOption = None,
    out: Annotated[str | None, typer.Option(metavar="DIR", help="Where to write it.")] = None,
    figures: Annotated[
        bool,
        typer.Option("--figures", help="Also write each figure as PDF, and for both widths of a paper."),
    ] = False,
    unsaved: Annotated[
        bool, typer.Option("--unsaved", help="Store nothing in the book, for who may only read it; needs --out.")
    ] = False,
    summary: Annotated[bool, typer.Option("--summary", help="Write page one alone, too: one sheet to send.")] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Print it to a PDF on A4 as well, by Chromium where it is installed.")
    ] = False,
    docx: Annotated[bool, typer.Option("--docx", help="Write the tables as a Word document, too.")] = False,
    template: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Your own page: templates beside labbook's (docs/own-page.md).")
    ] = None,
    as_of: Annotated[
        str | None,
        typer.Option(
            metavar="ENTRY|TIME", help="Of the book as it stood then; of a date, its end. Stores nothing, needs --out."
        ),
    ] = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Write the report: one self-contained page, its figures as SVG, every table as CSV and LaTeX.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook report --foot small; labbook report --where "k_gain=400 and day>=2021-06-01" --out paper;
    labbook report --summary --pdf
    """
    from data_schema.errors import UsageError
    from data_schema.queries.files import inbox
    from labbook.actions.report_command import selection, write
    from labbook.studies.registry import studies_of_book

    with opened(book) as opened_book:
        if out is not None and not out.strip():  # which would be where one stands
            raise UsageError("--out names no folder: give one, such as --out paper, or . for the folder where you are.")
        if unsaved:
            say_waiting(opened_book)
        text = selection(opened_book.configuration, where, context.args, options_given(context))
        with progress("report", None) as step:
            written = write(
                opened_book,
                text,
                None if out is None else Path(out),
                person,
                step,
                unsaved=unsaved,
                summary=summary,
                pdf=pdf,
                every_figure=figures,
                word=docx,
                templates=template,
                as_of=as_of,
            )
        waiting: list[str] = []
        studies: list[str] = []
        if as_of is None:
            with opened_book.reading() as connection:
                waiting = [item.name for item in inbox(connection)]
                # the bed's is the report itself
                studies = [study for study in studies_of_book(connection, opened_book.configuration) if study != "bed"]
    count = "1 entry" if written.later == 1 else f"{written.later} entries"
    later = (
        f"it is of the book as of entry {written.as_of}; {count} came in while it was made: the next report has them."
    )
    not_stored = ["nothing was stored: `labbook why` knows those of its numbers that a stored report has too."]
    return Shown(
        written,
        [
            *(written.claims[:1] or ["nothing is claimed from this selection."]),
            *(not_stored if unsaved or as_of is not None else ()),
            *([later] if written.later else []),
            f"{written.page}",
            *([written.pdf] if written.pdf else []),
            *([f"studies beside it: {', '.join(studies)} (`labbook study all`)"] if studies else []),
            *([f"look again: {written.no_pdf}"] if written.no_pdf else []),
            *(
                [f"look again: {listed(waiting, 4)} in the inbox, which `labbook runs inbox` explains"]
                if waiting
                else []
            ),
        ],
    )
