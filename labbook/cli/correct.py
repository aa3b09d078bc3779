"""`labbook correct`: a fact was wrong."""

from typing import Annotated, Any

import typer

from labbook.cli.common import AsOption, BookOption, FoldOption, JsonOption, emit


def correct(
    target: Annotated[str, typer.Argument(help="A run, or study, robot:NAME, battery:NAME, charge:UID.")],
    fields: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE...", help="What it should say.")],
    why: Annotated[str, typer.Option("--why", "--reason", help="Why the old value was wrong.")],
    fold: FoldOption = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Correct a fact: the old value stays in the journal, and everything that rested on it becomes stale.

    The words of the run sheet stand beside the columns' names: started=09:20 date=2021-06-05 minutes=12 jumps=24
    position=3 run=NEWNAME, the factors, and mah=812 for the charge of a run. A new date takes the start along.

    A run that was idle: kind=idle jumps_made=0 levels=none in one command, for an idle run has neither.

    Example: labbook correct r017 foot=large --why "typed wrong"
    """
    from labbook.actions.runs.correcting import correct as state_correction
    from labbook.actions.runs.correcting import runs_corrected
    from labbook.actions.runs.remarks import remark_lines, remarks_on
    from labbook.actions.upkeep.stale import stale_lines
    from labbook.book.opening import opened
    from labbook.cli.reading import answered
    from labbook.config.places import to_change

    with opened(book) as opened_book:
        configuration = opened_book.configuration

        def attempt(said: dict[str, str | None]) -> tuple[Any, Any, Any]:
            with opened_book.session(person, correcting=True) as session:
                changed = state_correction(opened_book, session, target, fields, why, fold=said["fold"])
                runs = runs_corrected(session.connection, target, changed)
                return changed, remarks_on(session.connection, configuration, runs, changed), session.stale

        changed, remarks, stale = answered(attempt, {"fold": fold}, ask=not as_json)
    in_file = to_change(configuration, target, {name: new for name, (_old, new) in changed.items()})
    said = f"{target}: {', '.join(fields)}." if changed else f"{target} says that already: nothing was changed."
    lines = [said, *stale_lines(stale), *in_file, *remark_lines(remarks)]
    data = {"target": target, "changed": changed, "stale": stale, "labbook_toml": in_file, "remarks": remarks}
    emit(data, lines, as_json)
