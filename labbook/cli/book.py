"""Commands on the book as a whole: init, demo, backup, restore, merge, rebuild."""

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from data_schema.errors import BookDamaged
from labbook.cli.common import AsOption, BookOption, opened
from labbook.config.studies import STUDIES
from labbook.terminal import Shown, for_program, progress, say

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
