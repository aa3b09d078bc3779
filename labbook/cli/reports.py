"""`labbook reports`: the reports of the book, what one shows, and what moved between two."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import BookOption, reading
from labbook.config.local_time import local_text
from labbook.terminal import Shown, columns

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
    rows = [
        (str(one.number), one.uid, local_text(one.made_utc, zone), one.person, str(one.numbers), _runs(one))
        for one in found
    ]
    lines = columns(("report", "id", "made", "by", "numbers", "of"), rows) if rows else ["no report was made yet."]
    return Shown(found, lines)


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
