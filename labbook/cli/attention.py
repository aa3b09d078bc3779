"""`labbook attention` and `labbook today`: what needs attention, gravest first, and the command that mends it."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import BookOption, WhereOption, reading
from labbook.terminal import Shown, listed, plain, progress

if TYPE_CHECKING:
    from labbook.actions.runs.attention import Attention, Finding

MOST_OF_BOOK, MOST_OF_DAY = 5, 20
"""So many findings of a check are shown one by one; the others are named."""


def attention(
    day: Annotated[str | None, typer.Option(metavar="DATE", help="One day, as 2021-06-01.")] = None,
    where: WhereOption = None,
    book: BookOption = None,
) -> Shown:
    """List what needs attention in the whole book, gravest first, each with the command that mends it.

    What cannot be so and counts comes first, then what costs the report a claim, what is missing, what may be wrong,
    and what is left to do. Words in capitals in a command, as MAH, are to be filled in. docs/day-at-the-rig.md has what
    is looked for.

    Planned runs that were not made, files without a run and what else is of no day are listed whatever the day; with
    --where only what is of these runs and their days.

    Example: labbook attention; labbook attention --where "foot=small"
    """
    from labbook.actions.runs.attention import attention as look
    from labbook.analysis.outcomes.detection import Detections
    from labbook.config.local_time import date_named

    date = date_named("--day", day) if day else None
    with reading(book) as (opened_book, connection), progress("attention", None) as step:
        detections = Detections(connection, opened_book.store, step)
        found = look(detections, opened_book.configuration, day=date, where=where)
    return Shown(_data(found), attention_lines(found))


def today(
    day: Annotated[str | None, typer.Option(metavar="DATE", help="Another day, as 2021-06-01.")] = None,
    book: BookOption = None,
) -> Shown:
    """List what a day still needs, as `labbook attention` does of all days, and when the last backup was made.

    Example: labbook today
    """
    from data_schema import journal
    from labbook.actions.runs.attention import attention as look
    from labbook.analysis.outcomes.detection import Detections
    from labbook.book.copies.backing_up import backup_line, last_backup
    from labbook.config.local_time import day_named

    with reading(book) as (opened_book, connection):
        configuration = opened_book.configuration
        date = day_named("--day", day, configuration.study.time_zone)
        found = look(Detections(connection, opened_book.store), configuration, day=date)
        last, (entries, _hash) = last_backup(opened_book.store), journal.head(connection)
    return Shown({**_data(found), "last_backup": last}, [*attention_lines(found), backup_line(last, entries)])


def _data(found: "Attention") -> dict[str, object]:
    findings = [{**plain(one), "command": one.command, "fill_in": one.fill_in} for one in found.findings]
    return {**plain(found), "findings": findings, "by_day": found.by_day}


def attention_lines(found: "Attention") -> list[str]:
    """Write it for people: how many runs, findings by gravity and check, and of a whole book how many of each day."""
    runs, findings = len(found.runs), len(found.findings)
    void = [f"{name} ({why})" for name, why in found.void.items()]
    head = f"{runs} run{'' if runs == 1 else 's'}{f', and {len(void)} void: {listed(void, 4)}' if void else ''}"
    head = head if found.day is None else f"{found.day}: {head}"
    if not findings:
        return [f"{head}.", "nothing needs attention."]
    lines = [f"{head}; {findings} finding{'' if findings == 1 else 's'}."]
    for gravity, of_gravity in groupby(found.findings, lambda one: one.gravity):
        lines.append(f"{gravity}:")
        for code, alike in groupby(of_gravity, lambda one: one.code):
            lines += _alike(code, list(alike), MOST_OF_BOOK if found.day is None else MOST_OF_DAY)
    if found.day is None and found.by_day:
        counts = [
            f"{date} ({', '.join(f'{count} {gravity}' for gravity, count in of_day.items())})"
            for date, of_day in found.by_day.items()
        ]
        lines.append(f"by day: {listed(counts)}")
    return lines


def _alike(code: str, alike: "Sequence[Finding]", most: int) -> Iterator[str]:
    """Yield the lines of what one check found; a command that mends several stands behind the last of them."""
    shown, more = alike[:most], alike[most:]
    for one, after in zip(shown, [*shown[1:], None], strict=True):
        costs = f"; {one.costs}" if one.costs else ""
        yield f"  {f'{one.day}  ' if one.day else ''}{one.what}{costs}."
        if after is None or after.command != one.command:
            yield f"      {one.command}"
    if more:
        names = dict.fromkeys(one.run or one.file or one.day or "" for one in more)
        yield f"  and {len(more)} more like these ({code}): {listed(list(names))}"
