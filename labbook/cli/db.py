"""`labbook db`, and commands on the book as a whole: init, demo, backup, restore, merge, rebuild."""

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from data_schema.errors import BookDamaged
from labbook.cli.common import AsOption, BookOption, opened
from labbook.config.studies import STUDIES
from labbook.terminal import Shown, columns, for_program, progress, say

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
    rows = [[one.name, one.n_bytes and f"{one.n_bytes / 1e6:.1f} MB", one.what] for one in found]
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


if TYPE_CHECKING:
    from labbook.book.rebuilding import Place, Rebuilt


def init(
    folder: Annotated[Path, typer.Argument(help="The folder of the new book.")],
    person: Annotated[str, typer.Option("--as", metavar="NAME", envvar="LABBOOK_AS", help="Who makes the book.")],
    database: Annotated[
        str | None,
        typer.Option(metavar="URL", help="An empty PostgreSQL database for the tables, for a shared book."),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Where raw copies and journal lie, if not in the book."),
    ] = None,
) -> Shown:
    """Make a book: a folder with labbook.toml, its database, its journal and its store.

    An existing labbook.toml in the folder is used as it is; otherwise a commented one is written to be filled in.
    Where there is a book already, it stays as it is; one whose making was interrupted is finished.

    Example: labbook init mybook --as "Ada Nwosu"
    """
    from labbook.book.making import make_book

    path, was_there = folder.resolve(), (folder / "labbook.toml").exists()
    if not make_book(folder, person, database, store):
        done = "nothing was made" if was_there else "labbook.toml was written as it last was"
        return Shown({"book": path}, [f"{path} is a book already: {done}."])
    return Shown(
        {"book": path},
        [
            f"made the book {path}.",
            f"Next: describe the study in {folder / 'labbook.toml'}, then `labbook plan`.",
            "Decide there under [analysis], before the first run is ingested, what will be compared and how.",
        ],
    )


def demo(
    folder: Annotated[Path, typer.Argument(help="An empty folder, or one that does not exist yet.")],
    seed: Annotated[int, typer.Option(help="The same seed makes the same files.")] = 1,
    full: Annotated[bool, typer.Option("--full", help="Write 12-minute logs (4.4 GB) instead of short ones.")] = False,
    study: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"The campaign of a study: {', '.join(STUDIES)}; usual: that of the bed.",
        ),
    ] = None,
) -> Shown:
    """Make the demonstration: synthetic instruments' files, a book, everything ingested, and the report.

    The campaign is the thesis's chapter 5, of simulated jumps with known truth (truth.json, docs/demonstration.md), or
    that of a study.

    Example: labbook demo demo-book
    """
    from labbook.demo.running import new_folder, run_demo

    def report(line: str) -> None:
        if not for_program():
            say(line)

    new_folder(folder)
    if study is not None:
        return _study_demo(folder, study, seed, full, report)
    from labbook.demo.campaign import make_campaign
    from labbook.demo.files import campaign_files

    with progress("demonstration", None) as step:
        done = run_demo(folder, campaign_files(make_campaign(seed), full=full), step, report)
    return Shown(done, [f"the report: {done.page}"])


def _study_demo(folder: Path, study: str, seed: int, full: bool, report: Callable[[str], None]) -> Shown:
    from data_schema.errors import UsageError, unknown_name
    from labbook.demo.running import make_study

    if study not in STUDIES:
        raise unknown_name("study with a demonstration", study, STUDIES)
    if full:
        raise UsageError("--full is about the logs of the demonstration without --study: leave one of the two out.")
    with progress("demonstration", None) as step:
        command = make_study(study, folder, seed, step, report)
    truth = str(folder / "truth.json")
    return Shown({"folder": str(folder), "truth": truth, "next": command}, [f"the truth: {truth}", f"Next: {command}"])


def backup(
    destination: Annotated[
        Path, typer.Argument(metavar="DEST", help="A folder for this book's backup, best on another disk.")
    ],
    check: Annotated[
        bool, typer.Option("--check", help="Copy nothing: verify the backup in DEST by itself, without its book.")
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Copy the journal, the raw copies and labbook.toml to DEST; the next time only what is new.

    Every copy is read again and compared with its hash. Others may go on writing to the book. The database is made anew
    from these by `labbook restore`, also where it is PostgreSQL; the pages of reports by `labbook report`.

    With --check the backup is verified as a restore would: the journal's chain, the hash of every raw copy and of the
    numbers of reports, and the journal played back; exit code 3 where something is wrong.

    Example: labbook backup /media/stick/mybook; labbook backup /media/stick/mybook --check
    """
    if check:
        return _check_backup(destination)
    from labbook.book.copies.backing_up import back_up
    from labbook.book.opening import find_folder

    done = back_up(find_folder(book), destination, lambda total: progress("backing up", total))
    raw = done.raw
    lines = [
        f"backup in {done.last.where}: {_counted(done.last.entries, 'entry', 'entries')} and "
        f"{_counted(raw.raw_copies, 'raw copy', 'raw copies')}; {raw.written} written "
        f"({raw.n_bytes / 1e6:.1f} MB), {raw.raw_copies - raw.written} there already, all read and compared.",
    ]
    if raw.replaced:
        lines.append(f"{raw.replaced} of them {'were' if raw.replaced > 1 else 'was'} damaged in the backup.")
    return Shown(done, [*lines, *done.remarks])


def _check_backup(source: Path) -> Shown:
    from data_schema.errors import BookDamaged
    from labbook.actions.upkeep.checking_backup import check_backup

    with progress("checking", None) as step:
        found = check_backup(source, step)
    several = len(found.problems) > 1
    verdict = f"{len(found.problems)} problem{'s' if several else ''}" if found.problems else "the backup is whole"
    lines = [
        f"{verdict}: {_counted(found.entries, 'entry', 'entries')} and "
        f"{_counted(found.raw_copies, 'raw copy', 'raw copies')} read, the journal played back.",
        *(f"  {problem}" for problem in found.problems),
        *found.missing_numbers,
        *(found.differences.sentences if not found.problems else ()),
    ]
    return Shown(found, lines, BookDamaged.exit_code if found.problems else 0)


def restore(
    source: Annotated[Path, typer.Argument(metavar="SRC", help="A folder that `labbook backup` made.")],
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the book; empty, or not there.")],
    database: Annotated[
        str | None,
        typer.Option(metavar="URL", help="The empty PostgreSQL database that the book is to have."),
    ] = None,
    sqlite: Annotated[
        bool, typer.Option("--sqlite", help="Make labbook.db in DIR, of a book that was on PostgreSQL.")
    ] = False,
    keep_going: Annotated[
        bool, typer.Option("--keep-going", help="Go on without raw copies that the backup lacks, and list them.")
    ] = False,
) -> Shown:
    """Make the book of a backup: copy and compare everything, make the database anew, check all of it.

    Cut off, the same command goes on where it was. Pages of reports are not in a backup: `labbook report` makes them.
    With --keep-going a file whose raw copy is missing or damaged waits: numbers that need it are undefined and say why,
    until `labbook ingest` is given the original file again.

    Example: labbook restore /media/stick/mybook mybook
    """
    from labbook.actions.upkeep.restoring import restore as restore_book

    place = _place(database, sqlite)
    with progress("restoring", None) as step:
        done = restore_book(
            source, folder, place, step, lambda _total: contextlib.nullcontext(step), keep_going=keep_going
        )
    lost = len(done.raw.problems)
    lines = [
        f"the book of {source} is restored in {done.folder}: {_counted(done.entries, 'entry', 'entries')}, "
        f"{_counted(done.raw.raw_copies - lost, 'raw copy', 'raw copies')}; all of it was checked.",
        *_lost(lost),
        *done.differences.sentences,
    ]
    if done.moved:
        where = "in the book" if database is None else "in the database given"
        lines.append(f"its labbook.toml says now that the store is in the book, and the tables are {where}.")
    return Shown(done, [*lines, *done.remarks])


def _lost(number: int) -> list[str]:
    """Say that raw copies are missing, before they are listed."""
    if not number:
        return []
    copies = f"{_counted(number, 'raw copy', 'raw copies')} missing or damaged"
    return [
        f"{copies}; numbers that need what was in {'it' if number == 1 else 'them'} are undefined until it is back:"
    ]


def _place(database: str | None, sqlite: bool) -> "Place | None":
    """Return where a database is to be made, None where it was."""
    from data_schema.errors import UsageError
    from labbook.book.rebuilding import Place

    if database is not None and sqlite:
        raise UsageError("--database and --sqlite exclude each other: give one of them.")
    return Place(database) if database is not None or sqlite else None


def merge(
    other: Annotated[Path, typer.Argument(metavar="OTHER", help="The folder of the other book; it is only read.")],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show what would come, and write nothing.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Bring in what another book of the same study says beyond this one, all of it or nothing.

    What follows the common beginning of both is added, each statement with its own time and person. What both books
    name alike (a run, a level, the bytes of a file) is one thing; where they contradict each other everything is
    listed and nothing is written. Merging again adds what is new since.

    Example: labbook merge /media/laptop/book --dry-run
    """
    from labbook.actions.upkeep.merging import merge as bring_in

    with opened(book) as opened_book:
        done = bring_in(opened_book, other, person, dry_run=dry_run)
    counts = ", ".join(f"{what}: {count}" for what, count in done.entries.items())
    total = sum(done.entries.values())
    came = f"{'would come' if dry_run else 'came'} from {other}"
    entries, copies = _counted(total, "entry", "entries"), _counted(done.raw_copies, "raw copy", "raw copies")
    lines = [f"{came}: {entries} ({counts}), {copies}."]
    if not total:
        lines = [] if done.conflicts else [f"{other} says nothing that this book does not have: nothing to add."]
    if done.there_already:
        had = _counted(done.there_already, "entry", "entries")
        lines.append(f"this book had already {had} of those after the first {done.common}, which both share.")
    lines += [f"in the way: {sentence}" for sentence in done.conflicts]
    return Shown(done, lines, 1 if done.conflicts else 0)


def _counted(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"


def rebuild(
    journal: Annotated[bool, typer.Option("--journal", help="Write journal.jsonl from the database instead.")] = False,
    database: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Make the tables in this PostgreSQL database from now on."),
    ] = None,
    sqlite: Annotated[bool, typer.Option("--sqlite", help="Make labbook.db in the book from now on.")] = False,
    keep_going: Annotated[
        bool, typer.Option("--keep-going", help="Go on without raw copies that are missing or damaged, and list them.")
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Make the database anew from the raw copies and the journal; the old one is kept beside it.

    With --database or --sqlite the book moves to the other kind of database, and its labbook.toml says so.
    With --keep-going a file whose raw copy is missing or damaged waits: numbers that need it are undefined and say why,
    until `labbook ingest` is given the original file again.

    Example: labbook rebuild
    """
    from data_schema.errors import UsageError
    from labbook.book.opening import find_folder
    from labbook.book.rebuilding import rebuild_database, rewrite_journal

    folder = find_folder(book)
    place = _place(database, sqlite)
    if journal:
        if place is not None or keep_going:
            raise UsageError("--journal writes no database: leave --database, --sqlite and --keep-going out.")
        count = rewrite_journal(folder)
        return Shown({"entries": count}, [f"journal.jsonl written anew: {count} entries."])
    with progress("rebuilding", None) as step:
        done = rebuild_database(folder, step, place, may_lack=None if keep_going else frozenset())
    return Shown(done, rebuilt_lines(done))


def rebuilt_lines(done: "Rebuilt") -> list[str]:
    """Say what a rebuild made, where the old database is, what is missing, and what differs."""
    old_database = f"the old database is kept as {done.old}" if done.old else "there was no old database"
    return [f"rebuilt from {done.entries} entries; {old_database}.", *_lost(done.n_lost), *done.sentences]
