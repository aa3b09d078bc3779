"""`labbook note`: a remark on a run."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def note(
    run: Annotated[str, typer.Argument(help="The run.")],
    text: Annotated[str, typer.Argument(help="What is to be remembered.")],
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a note on a run.

    Example: labbook note r017 "left rail squeaked"
    """
    from data_schema.errors import UsageError
    from data_schema.vocabulary import Action
    from labbook.book.naming import run_named
    from labbook.book.opening import opened
    from labbook.book.write_session import Statement, new_uid

    if not text.strip():
        raise UsageError("the note is empty: say what is to be remembered.")
    with opened(book) as opened_book, opened_book.session(person) as session:
        target = run_named(session.connection, run)
        new = {"target_kind": "run", "target_uid": target.uid, "text": text}
        session.state(Statement(Action.NOTE, "note", new_uid(), new=new))
    emit({"run": run, "text": text}, [f"noted on run {run}."], as_json)
