"""`labbook db`: its state, whether the book is whole, clearing up."""

from typing import Annotated

import typer

from data_schema.errors import BookDamaged
from labbook.cli.common import BookOption, opened
from labbook.terminal import Shown, columns, progress

app = typer.Typer(no_args_is_help=True)


@app.command("prune")
def prune_command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME", help="Only these of the list; without one, all of it.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Remove them; without, they are only listed.")] = False,
    book: BookOption = None,
) -> Shown:
    """List what nothing needs: old databases, files of commands that were cut off, numbers of no report.

    Never a raw copy that a row or the journal speaks of, nor a file that is not labbook's: those are named. Files
    written to within an hour are left out. What was set aside from the journal is removed only by its name. The book is
    checked before anything is removed.

    Example: labbook db prune --yes
    """
    from labbook.actions.upkeep.pruning import leftovers, named, prune

    with opened(book) as opened_book:
        if yes:
            found = prune(opened_book, names or (), lambda total: progress("checking", total))
        else:
            with opened_book.reading() as connection:
                found = named(leftovers(opened_book, connection), names or ())
    rows = [[one.name, None if one.n_bytes is None else f"{one.n_bytes / 1e6:.1f} MB", one.what] for one in found]
    lines = columns(["name", "size", "what it is"], rows)
    if not found:
        lines = ["nothing lies about."]
    elif all(one.foreign for one in found):
        lines.append("nothing of labbook's lies about.")
    elif yes:
        lines.append(f"{len(found)} removed.")
    else:
        lines.append("nothing was removed: --yes removes all of these, names before it only those.")
    return Shown({"removed": yes, "leftovers": found}, lines)


@app.command("status")
def status_command(book: BookOption = None) -> Shown:
    """Show the database's schema number and its rows by table, and when the last backup was made.

    Example: labbook db status
    """
    from data_schema.engine import reading
    from data_schema.schema import SCHEMA, count_rows, schema_of
    from labbook.book.copies.backing_up import backup_line, last_backup
    from labbook.book.opening import engine_of, find_folder, read_configuration, shown, store_of

    folder = find_folder(book)
    configuration = read_configuration(folder)
    engine = engine_of(folder, configuration)
    with reading(engine) as connection:
        schema = schema_of(connection)
        rows = count_rows(connection) if schema == SCHEMA else {}
    engine.dispose()
    last = last_backup(store_of(folder, configuration))
    found = {"database": shown(engine), "schema": schema, "rows": rows, "last_backup": last}
    lines = [f"{found['database']}: schema {schema}, this labbook works with schema {SCHEMA}."]
    lines += [f"  {name}: {count}" for name, count in rows.items() if count]
    return Shown(found, [*lines, backup_line(last, rows.get("journal", 0))])


@app.command("check")
def check_command(
    deep: Annotated[
        bool, typer.Option("--deep", help="Read the raw copies again, instead of taking what was read before.")
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Read everything that the book rests on and say whether it is whole; exit code 3 where it is not.

    Rows that are not as the journal gives them are named, with what should stand there and the reports that rest on
    them; so are reports whose files were altered. What labbook.toml says otherwise than when a report was made is
    said, too.

    Example: labbook db check --deep
    """
    from labbook.actions.upkeep.health import check_book
    from labbook.book.opening import find_folder

    found = check_book(find_folder(book), lambda total: progress("checking", total), deep=deep)
    problems = len(found.problems) + len(found.lost_sentences)
    verdict = "the book is whole" if found.whole else f"{problems} problem{'s' if problems > 1 else ''}"
    checked = f"{found.entries} entries, {found.raw_copies} raw copies, {found.signal_files} files of samples"
    checked += f", the files of {found.reports} report{'' if found.reports == 1 else 's'}"
    lines = [f"{verdict}: {checked} read.", *(f"  {one}" for one in (*found.problems, *found.lost_sentences))]
    lines += [*found.missing_numbers, *found.other_settings]
    if found.waiting:
        what = (
            "1 entry of journal.jsonl waits" if found.waiting == 1 else f"{found.waiting} entries of journal.jsonl wait"
        )
        lines.append(f"{what} for the next command that writes, which applies what it finds there.")
    waiting = ((found.verdicts_waiting, "verdict"), (found.files_waiting, "file"))
    for count, what in waiting:
        if count:
            doing = f"{what}s wait" if count > 1 else f"{what} waits"
            lines.append(f"{count} {doing} for a person: `labbook attention` says which.")
    if found.left_out.sentence:
        lines.append(found.left_out.sentence)
    if found.orphans:
        several = len(found.orphans) > 1
        what = f"{len(found.orphans)} files in the store belong" if several else "1 file in the store belongs"
        lines.append(f"{what} to nothing and {'do' if several else 'does'} no harm:")
        lines += [f"  {path}" for path in found.orphans]
    return Shown(found, lines, BookDamaged.exit_code if not found.whole else 0)
