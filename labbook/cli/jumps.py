"""`labbook jumps`: see what was found in a run or in all, reject or accept jumps, move or add them."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from data_schema.vocabulary import TO_ACCEPT, TO_REJECT, ReasonCode, ReviewOrder
from labbook.cli.common import AsOption, BookOption, WhereOption, opened, reading, tell
from labbook.terminal import Shown, columns, progress

if TYPE_CHECKING:
    from labbook.analysis.outcomes.run_apexes import JudgedJump

app = typer.Typer(no_args_is_help=True)

RunArgument = Annotated[str, typer.Argument(metavar="RUN", help="The run.")]
RejectReason = Annotated[str, typer.Option("--reason", "--why", help=f"{', '.join(TO_REJECT)}.")]
AcceptReason = Annotated[str, typer.Option("--reason", "--why", help=f"{', '.join(TO_ACCEPT)}.")]
ReasonOption = Annotated[str, typer.Option("--reason", "--why", help=f"{', '.join(ReasonCode)}.")]


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


@app.command("queue")
def queue_command(
    order: Annotated[
        ReviewOrder, typer.Option(help="The most doubtful first, by run, or shuffled.")
    ] = ReviewOrder.DOUBT,
    seed: Annotated[int | None, typer.Option(help="Of a shuffled order: the same seed gives the same one.")] = None,
    where: WhereOption = None,
    unreviewed: Annotated[bool, typer.Option("--unreviewed", help="Leave out what has a verdict that stands.")] = False,
    book: BookOption = None,
) -> Shown:
    """List the jumps of the whole book, or of some runs, in the order in which to look at them.

    Doubt adds up the detector's flags, missing samples, a height far from those of the run's other jumps and a wide
    standard error; docs/review.md says how.

    Example: labbook jumps queue --where "foot=small" --unreviewed
    """
    from labbook.actions.runs.jump_review import queue_lines, review_queue
    from labbook.analysis.outcomes.detection import Detections

    with reading(book) as (opened_book, connection), progress("jumps", None) as step:
        found = review_queue(
            Detections(connection, opened_book.store, step),
            opened_book.configuration,
            order,
            seed,
            where,
            unreviewed=unreviewed,
        )
    return Shown(found, queue_lines(found))


@app.command("agreement")
def agreement_command(
    first: Annotated[str | None, typer.Argument(metavar="A", help="A person, by name or initials.")] = None,
    second: Annotated[str | None, typer.Argument(metavar="B", help="Another one.")] = None,
    where: WhereOption = None,
    book: BookOption = None,
) -> Shown:
    """Show how far two people agree on the jumps on which both gave verdicts, and on which they differ.

    Each person's last verdict is compared, whether or not it is the one that counts. Without names, all pairs of people
    who looked at the same jumps. Cohen's kappa is 1 where they agree on all, 0 where as often as by chance.

    Example: labbook jumps agreement; labbook jumps agreement AN BO --where "foot=small"
    """
    from data_schema.errors import UsageError
    from labbook.actions.runs.jump_review import agreement, agreement_lines
    from labbook.analysis.outcomes.detection import Detections

    with reading(book) as (opened_book, connection), progress("jumps", None) as step:
        people = None
        if first is not None:
            if second is None:
                raise UsageError(f"only {first!r} is named, and two people agree: name a second one, or none for all.")
            people = opened_book.speaker(first), opened_book.speaker(second)
            if people[0] == people[1]:
                raise UsageError(f"{first!r} and {second!r} are both {people[0]}: name two people.")
        found = agreement(Detections(connection, opened_book.store, step), opened_book.configuration, people, where)
    lines = [line for one in found for line in agreement_lines(one)]
    return Shown(found, lines or ["no two people gave verdicts on the same jump."])


@app.command("reject")
def reject_command(jumps: OfJumps, reason: RejectReason) -> Shown:
    """Reject jumps; the verdict is kept with name, time and reason, and can be taken back with `clear`.

    Example: labbook jumps reject r017 3-5 9 --reason touched_by_hand
    """
    return _decide(jumps, "reject", reason)


@app.command("accept")
def accept_command(jumps: OfJumps, reason: AcceptReason = "looks_right") -> Shown:
    """Accept jumps, also ones that the protocol would leave out.

    Example: labbook jumps accept r017 4
    """
    return _decide(jumps, "accept", reason)


AtOption = Annotated[
    float, typer.Option("--at", metavar="TIME", help="When the body is highest, in s on the log's own clock.")
]
NoteOption = Annotated[str | None, typer.Option(help="In your own words.")]


@app.command("move")
def move_command(
    run: RunArgument,
    number: Annotated[int, typer.Argument(metavar="NUMBER", help="The jump by its number in the list.")],
    at: AtOption,
    reason: ReasonOption = "wrong_apex",
    note: NoteOption = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Put the apex of a jump into the flight at another time, where a parabola through the samples gives its height.

    Whether the jump counts is decided as before: by the protocol's rules, or by `accept` and `reject` after it. `clear`
    takes it back.

    Example: labbook jumps move r017 4 --at 12.31
    """
    from labbook.actions.runs.jump_review import move

    return _put(
        run,
        "move",
        book,
        person,
        lambda book, session, found: move(book, session, run, number, at, reason, note, found),
    )


@app.command("add")
def add_command(
    run: RunArgument,
    at: AtOption,
    log: Annotated[int | None, typer.Option(help="Which log, of a run that has several: 1 for the first.")] = None,
    reason: ReasonOption = "other",
    note: NoteOption = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Add a jump that the detector has not, with its apex in the flight at a time; `clear` takes it out again.

    It counts as other jumps do, and those after it have the next numbers.

    Example: labbook jumps add r017 --at 12.31
    """
    from labbook.actions.runs.jump_review import add

    return _put(
        run, "add", book, person, lambda book, session, found: add(book, session, run, at, reason, note, found, log=log)
    )


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
        opened_book.catch_up()
        with contextlib.suppress(UsageError), opened_book.reading() as connection:
            found = review(opened_book, connection, run)
        with opened_book.session(jumps.person) as session:
            count = clear_waiting(opened_book, session, run, jumps.note, found)
    return Shown({"run": run, "cleared": count}, [f"{run}: {count} waiting verdicts taken back."])


def _decide(jumps: OfJumps, verdict: str, reason: str) -> Shown:
    from labbook.actions.runs.jump_review import decide, judging, reason_remarks, resolve_jumps, without_apex
    from labbook.book.report_numbers import outdated_reports

    run = jumps.run
    with opened(jumps.book) as book, judging(book, jumps.person, run) as (session, found):
        decided = resolve_jumps(jumps.numbers, found)
        recorded = decide(book, session, run, decided, verdict, reason, jumps.note, found)
        reports = outdated_reports(session)
        about = (session.connection, book.configuration, reason, "every comparison of apex heights")
        remarks = reason_remarks(*about) if verdict == "reject" else []
        remarks += [] if verdict == "clear" else without_apex(found, decided)
    nothing = "" if recorded else " says nothing new: nothing was stated"
    data = {"run": run, "jumps": decided, "verdict": verdict, "reports": reports, "remarks": remarks}
    return tell(data, [f"{run}: {verdict} {', '.join(map(str, decided))}{nothing}."])


def _put(
    run: str, verdict: str, folder: Path | None, person: str | None, state: "Callable[..., tuple[JudgedJump, bool]]"
) -> Shown:
    """State where an apex is, and answer the jump as it is now."""
    from labbook.actions.runs.jump_review import judging
    from labbook.book.report_numbers import outdated_reports

    with opened(folder) as book, judging(book, person, run) as (session, found):
        item, stated = state(book, session, found)
        reports = outdated_reports(session)
    jump, before = item.jump, item.before.apex_height_m
    was = f", {before * 1e3:.2f} mm before" if verdict == "move" and before is not None else ""
    counts = "it counts" if item.excluded is None else f"it does not count: {item.excluded}"
    height_mm = (jump.apex_height_m or 0.0) * 1e3
    line = f"{run}: jump {jump.number} has its apex at {jump.apex_s:.3f} s, {height_mm:.2f} mm{was}"
    nothing = "" if stated else " That was said before: nothing was stated."
    data = {"run": run, "jumps": [jump.number], "verdict": verdict, "reports": reports, "jump": item}
    return tell(data, [f"{line}; {counts}.{nothing}"])
