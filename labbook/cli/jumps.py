"""`labbook jumps`: see what was found in a run, reject or accept jumps."""

import contextlib
from dataclasses import dataclass
from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, opened, reading, tell
from labbook.terminal import Shown, columns

app = typer.Typer(no_args_is_help=True)

RunArgument = Annotated[str, typer.Argument(metavar="RUN", help="The run.")]
ReasonOption = Annotated[
    str,
    typer.Option(
        "--reason", "--why", help="dropped_packet, wrong_apex, touched_by_hand, misfire, sensor_fault, other ..."
    ),
]


@dataclass(frozen=True, slots=True)
class OfJumps:
    """Jumps of a run, and who says in which book what follows of them."""

    run: RunArgument
    numbers: Annotated[
        list[str], typer.Argument(metavar="NUMBER...", help="Jumps by their number in the list, ranges too: 3-5 8.")
    ]
    note: Annotated[str | None, typer.Option(help="In your own words.")] = None
    book: BookOption = None
    person: AsOption = None


@app.command("list")
def list_command(run: RunArgument, book: BookOption = None) -> Shown:
    """List the jumps found in a run, which of them count, why others do not, and who reviewed which.

    Touchdown and apex are times on the log's own clock; a misfire has no apex. docs/your-own-data.md has the keys of
    --json.

    Example: labbook jumps list r017
    """
    from labbook.actions.runs.jump_review import jump_lines, review, review_lines

    with reading(book) as (opened_book, connection):
        found = review(opened_book, connection, run)
    head, rows, waiting = jump_lines(found)
    jumps = [*columns(head, rows), *review_lines(found.reviewed, found.not_reviewed)] if rows else ["no jumps found."]
    return Shown(found, [*jumps, *waiting])


@app.command("reject")
def reject_command(jumps: OfJumps, reason: ReasonOption) -> Shown:
    """Reject jumps; the verdict is kept with name, time and reason, and can be taken back with `clear`.

    Example: labbook jumps reject r017 3-5 9 --reason touched_by_hand
    """
    return _decide(jumps, "reject", reason)


@app.command("accept")
def accept_command(jumps: OfJumps, reason: ReasonOption = "looks_right") -> Shown:
    """Accept jumps, also ones that the protocol would leave out.

    Example: labbook jumps accept r017 4
    """
    return _decide(jumps, "accept", reason)


@app.command("clear")
def clear_command(jumps: OfJumps) -> Shown:
    """Take verdicts back: the protocol's rules decide again.

    `waiting` in place of numbers takes back those that were given on an earlier reading of the log, and those that fit
    none of the jumps found now.

    Example: labbook jumps clear r017 4; labbook jumps clear r017 waiting
    """
    if jumps.numbers != ["waiting"]:
        return _decide(jumps, "clear", "other")
    from data_schema.errors import UsageError
    from labbook.actions.runs.jump_review import clear_waiting, review

    run, found = jumps.run, None
    with opened(jumps.book) as opened_book:
        with contextlib.suppress(UsageError), opened_book.reading() as connection:
            found = review(opened_book, connection, run)
        with opened_book.session(jumps.person) as session:
            count = clear_waiting(opened_book, session, run, jumps.note, found)
    return Shown({"run": run, "cleared": count}, [f"{run}: {count} waiting verdicts taken back."])


def _decide(jumps: OfJumps, verdict: str, reason: str) -> Shown:
    from labbook.actions.runs.jump_review import decide, reason_remarks, resolve_jumps, review, without_apex
    from labbook.book.report_numbers import outdated_reports

    run, person = jumps.run, jumps.person
    with opened(jumps.book) as opened_book:
        opened_book.speaker(person)  # who may not speak need not wait for the jumps to be found
        with opened_book.reading() as connection:
            found = review(opened_book, connection, run)
        decided = resolve_jumps(jumps.numbers, found)
        with opened_book.session(person) as session:
            recorded = decide(opened_book, session, run, decided, verdict, reason, jumps.note, found)
            reports = outdated_reports(session)
            rejecting = verdict == "reject"
            about = (session.connection, opened_book.configuration, reason, "every comparison of apex heights")
            remarks = reason_remarks(*about) if rejecting else []
            remarks += [] if verdict == "clear" else without_apex(found, decided)
    nothing = "" if recorded else " says nothing new: nothing was stated"
    data = {"run": run, "jumps": decided, "verdict": verdict, "reports": reports, "remarks": remarks}
    return tell(data, [f"{run}: {verdict} {', '.join(map(str, decided))}{nothing}."])
