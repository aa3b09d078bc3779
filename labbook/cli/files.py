"""`labbook files`: the instruments' files that the book has, and how they are read."""

from typing import Annotated

import typer

from data_schema.errors import UsageError
from labbook.cli.common import (
    AsOption,
    BookOption,
    MaybeWhyOption,
    WhyOption,
    opened,
    reading,
    tell_statement,
)
from labbook.cli.declaring import Declared
from labbook.terminal import Shown, columns, for_program, plain, progress

app = typer.Typer(no_args_is_help=True)

NameArgument = Annotated[
    str, typer.Argument(metavar="NAME", help="A file by name, path, uid or the beginning of its SHA-256.")
]


@app.command("list")
def list_command(book: BookOption = None) -> Shown:
    """List the files of the book, how they were read, and which wait or are withdrawn.

    Example: labbook files list
    """
    from labbook.actions.files.stored_files import list_cells, list_files

    with reading(book) as (_opened_book, connection):
        if for_program():
            return Shown(list_files(connection))
        head, rows = list_cells(connection)
    return Shown(None, columns(head, rows, "no files."))


@app.command("show")
def show_command(name: NameArgument, book: BookOption = None) -> Shown:
    """Show how a file was read, each time: by whom, with what declared, and what came of it.

    Example: labbook files show r007.csv
    """
    from labbook.actions.files.stored_files import show_file, show_lines

    with reading(book) as (_opened_book, connection):
        found = show_file(connection, name)
    return Shown(found, show_lines(found))


@app.command("reread")
def reread_command(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME...", help="Files by name, path, uid or the beginning of their SHA-256."),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="All files that labbook.toml would have read otherwise now.")
    ] = False,
    *,
    declared: Declared,
    nothing: Annotated[
        bool, typer.Option("--nothing-declared", help="Take back what was declared about the files before.")
    ] = False,
    why: MaybeWhyOption = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would change; store nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Read the kept copies of files again: with what was declared about them, and what is declared here.

    Today's labbook.toml holds. What changes, and which reports it bears on, is said; a reading that is refused
    changes nothing, and the exit code is 2.

    Example: labbook files reread r007.csv --column "z=body_height:mm" --why "the unit was missing"
    """
    from labbook.actions.files.named_files import file_named
    from labbook.actions.files.rereading import RereadRequest, reread_lines
    from labbook.actions.files.stored_files import files_to_reread, reread_named
    from labbook.book.write_session import new_uid
    from labbook.cli.file_options import declared_options

    options = declared_options(declared)
    if bool(names) == every:
        raise UsageError("name the files to be read again, or give --all for those that labbook.toml reads otherwise.")
    if every and (options or nothing):
        raise UsageError("what is declared here is about the files that are named: leave it out with --all.")
    done = []
    with opened(book) as opened_book:
        if not dry_run:
            opened_book.speaker(person)
            opened_book.catch_up()
        if every:
            with progress("comparing", None) as step:
                uids = [row.file_uid or "" for row in files_to_reread(opened_book, step)]
        else:  # a name that means no file is refused before one is read
            with opened_book.reading() as connection:
                uids = list(dict.fromkeys(file_named(connection, name).uid for name in names or ()))
        batch = new_uid() if every or len(uids) > 1 else None
        with progress("reading again", len(uids), shown=len(uids) > 1) as step:
            for each in uids:
                request = RereadRequest(options, person, why, dry_run, batch, afresh=nothing)
                done.append(reread_named(opened_book, each, request))
                step(done[-1].file)
    lines = [
        line for item in done for line in (f"{item.file}:", *(f"  {x}" for x in reread_lines(item, dry_run=dry_run)))
    ]
    return Shown(
        [{**plain(item), "refused": item.read.refused, "findings": item.read.findings} for item in done],
        lines or ["no file would be read otherwise."],
        2 if any(item.read.refused for item in done) else 0,
    )


@app.command("withdraw")
def withdraw_command(
    name: NameArgument,
    why: WhyOption,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Take a file out of use: no number uses it, nothing is deleted, and the same bytes coming again are named.

    Example: labbook files withdraw r007.csv --why "the log of another robot"
    """
    from labbook.actions.files.stored_files import withdraw

    return tell_statement(book, person, lambda session: withdraw(session, name, why), file=name, why=why)


@app.command("restore")
def restore_command(
    name: NameArgument,
    why: MaybeWhyOption = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Take a withdrawn file into use again, as it was read.

    Example: labbook files restore r007.csv
    """
    from labbook.actions.files.stored_files import restore

    return tell_statement(book, person, lambda session: restore(session, name, why), file=name, why=why)
