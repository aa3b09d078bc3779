"""`labbook jumps`: see what was found in a run, reject or accept jumps."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, reading, stating, tell
from labbook.terminal import columns, emit

app = typer.Typer(no_args_is_help=True)

RunArgument = Annotated[str, typer.Argument(metavar="RUN", help="The run.")]
NumbersArgument = Annotated[
    list[str], typer.Argument(metavar="NUMBER...", help="Jumps by their number in the list, ranges too: 3-5 8.")
]
ReasonOption = Annotated[
    str,
    typer.Option(
        "--reason", "--why", help="dropped_packet, wrong_apex, touched_by_hand, misfire, sensor_fault, other ..."
    ),
]
NoteOption = Annotated[str | None, typer.Option("--note", help="In your own words.")]


@app.command("list")
def list_command(run: RunArgument, book: BookOption = None, as_json: JsonOption = False) -> None:
    """List the jumps found in a run, which of them count, and why others do not.

    Touchdown and apex are times on the log's own clock; a misfire has no apex. docs/your-own-data.md has the keys of
    --json.

    Example: labbook jumps list r017
    """
    from labbook.actions.runs.jump_review import jump_lines, review

    with reading(book) as (opened_book, connection):
        found = review(opened_book, connection, run)
    head, rows, waiting = jump_lines(found)
    emit(found, [*columns(head, rows), *waiting] if rows else ["no jumps found.", *waiting], as_json)


@app.command("reject")
def reject_command(
    run: RunArgument,
    numbers: NumbersArgument,
    reason: ReasonOption,
    note: NoteOption = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Reject jumps; the verdict is kept with name, time and reason, and can be taken back with `clear`.

    Example: labbook jumps reject r017 3-5 9 --reason touched_by_hand
    """
    _decide(run, numbers, "reject", reason, note, book, person, as_json)


@app.command("accept")
def accept_command(
    run: RunArgument,
    numbers: NumbersArgument,
    reason: ReasonOption = "looks_right",
    note: NoteOption = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Accept jumps, also ones that the protocol would leave out.

    Example: labbook jumps accept r017 4
    """
    _decide(run, numbers, "accept", reason, note, book, person, as_json)


@app.command("clear")
def clear_command(
    run: RunArgument,
    numbers: NumbersArgument,
    note: NoteOption = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Take verdicts back: the protocol's rules decide again.

    `waiting` in place of numbers takes back those that were given on an earlier reading of the log.

    Example: labbook jumps clear r017 4; labbook jumps clear r017 waiting
    """
    if numbers == ["waiting"]:
        _clear_waiting(run, note, book, person, as_json)
        return
    _decide(run, numbers, "clear", "other", note, book, person, as_json)


def _clear_waiting(run: str, note: str | None, book: BookOption, person: AsOption, as_json: bool) -> None:
    from labbook.actions.runs.jump_review import clear_waiting

    with stating(book, person) as (_opened_book, session):
        count = clear_waiting(session, run, note)
    emit({"run": run, "cleared": count}, [f"{run}: {count} waiting verdicts taken back."], as_json)


def _decide(
    run: str,
    numbers: list[str],
    verdict: str,
    reason: str,
    note: str | None,
    book: BookOption,
    person: AsOption,
    as_json: bool,
) -> None:
    from labbook.actions.runs.jump_review import decide, reason_remarks, resolve_jumps, review, without_apex
    from labbook.book.opening import opened

    with opened(book) as opened_book:
        opened_book.speaker(person)  # who may not speak need not wait for the jumps to be found
        with opened_book.reading() as connection:
            found = review(opened_book, connection, run)
        decided = resolve_jumps(numbers, found)
        with opened_book.session(person) as session:
            recorded = decide(opened_book, session, run, decided, verdict, reason, note, found)
            stale = session.stale
            rejecting = verdict == "reject"
            about = (session.connection, opened_book.configuration, reason, "every comparison of apex heights")
            remarks = reason_remarks(*about) if rejecting else []
            remarks += [] if verdict == "clear" else without_apex(found, decided)
    nothing = "" if recorded else " says nothing new: nothing was stated"
    data = {"run": run, "jumps": decided, "verdict": verdict, "stale": stale, "remarks": remarks}
    tell(data, [f"{run}: {verdict} {', '.join(map(str, decided))}{nothing}."], as_json)
