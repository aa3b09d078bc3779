"""`labbook export`: what a book has, for other programs; `labbook verify`: is a capsule whole?"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from data_schema.errors import UsageError, unknown_name
from labbook.cli.common import BookOption, WhereOption, opened
from labbook.terminal import Shown, plain, progress


def export(
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="A new folder, or an empty one; with --mcap, a new file.")
    ] = None,
    form: Annotated[str, typer.Option("--format", metavar="csv|parquet|netcdf|xlsx", help="Of the files.")] = "csv",
    signals: Annotated[bool, typer.Option("--signals", help="Write the samples too, a file a log.")] = False,
    mcap: Annotated[
        str | None,
        typer.Option("--mcap", metavar="RUN", help="Write a run as one MCAP file, and no tables."),
    ] = None,
    capsule: Annotated[
        Path | None,
        typer.Option("--capsule", metavar="FILE.eln", help="Write the book and a report as one file."),
    ] = None,
    report: Annotated[
        str | None,
        typer.Option(metavar="REPORT", help="Of --capsule: its number, id, last or last-1; without it the newest."),
    ] = None,
    for_sharing: Annotated[
        bool, typer.Option("--for-sharing", help="Leave out what [privacy] of labbook.toml names.")
    ] = False,
    where: WhereOption = None,
    book: BookOption = None,
) -> Shown:
    """Write runs, jumps, charges, conditions, verdicts, findings, signals and notes as tables, and what columns mean.

    From Python: labbook.open("mybook").runs() and its like give the same as frames.

    With --capsule the book and a report become one file, a zipped RO-Crate (.eln), from which anybody can compute every
    number anew: the files of the instruments, the journal, labbook.toml, the tables and the report. `labbook verify`
    checks it. [sharing] license in labbook.toml says what others may do with it.

    With --for-sharing initials stand for names, and notes and paths are left out, as [privacy] leave_out says; the
    journal of a capsule is chained anew, and says so. Files of the instruments are as they came.

    Example: labbook export tables; labbook export tables --format parquet --signals --where "day>=2021-06-01";
    labbook export r003.mcap --mcap r003; labbook export --capsule ../study.eln
    """
    of_tables = {"--signals": signals, "--where": where is not None, "--format": form != "csv"}
    if capsule is not None:
        _refuse("--capsule", {"FOLDER": folder is not None, "--mcap": mcap is not None, **of_tables})
        return _capsule(capsule, report, book, for_sharing=for_sharing)
    _refuse("an export without --capsule", {"--report": report is not None})
    from data_schema.where import comparing
    from labbook.export.tables import Selection
    from labbook.export.writing import FORMATS, export_tables

    if folder is None:
        raise UsageError("name the folder that the tables go to: labbook export FOLDER.")
    _refuse("--mcap", {**of_tables, "--for-sharing": for_sharing} if mcap is not None else {})
    if mcap is None and form not in FORMATS:
        raise unknown_name("format of an export", form, FORMATS)
    with opened(book) as opened_book, opened_book.reading() as connection, progress("export", None) as step:
        where = where if mcap is None else comparing("run", mcap)
        selection = Selection(connection, opened_book.store, opened_book.configuration, where, step)
        if mcap is not None:
            from labbook.export.mcap import write_mcap

            count = write_mcap(selection, mcap, folder)
            return Shown({"file": folder, "messages": count}, [f"wrote {folder}: {count} messages."])
        exported = export_tables(selection, folder, form, with_signals=signals, for_sharing=for_sharing)
    rows = ", ".join(f"{name} {count}" for name, count in exported.rows.items())
    return Shown(exported, [f"wrote {exported.folder}: {rows}."])


def _refuse(what: str, given: Mapping[str, bool]) -> None:
    """Raise `UsageError` for options that mean nothing beside another."""
    names = [name for name, is_given in given.items() if is_given]
    if names:
        raise UsageError(f"{what} has no use for {' and '.join(names)}: leave that out.")


def _capsule(file: Path, report: str | None, book: Path | None, *, for_sharing: bool) -> Shown:
    from labbook.export.capsule import write_capsule

    with opened(book) as opened_book, progress("capsule", None) as step:
        done = write_capsule(opened_book, file, report, step, for_sharing=for_sharing)
    lines = [
        f"{done.file}: {done.entries} entries, {done.raw_copies} raw files and report {done.report}, "
        f"{done.n_bytes / 1e6:.1f} MB.",
        f"SHA-256 {done.sha256}",
        *done.remarks,
        f"check it: labbook verify {done.file}",
    ]
    return Shown(done, lines)


DIFFERS = 1
"""Exit code where a capsule is not as it was written."""


def verify(file: Annotated[Path, typer.Argument(metavar="FILE.eln", help="A capsule that somebody sent.")]) -> Shown:
    """Check a capsule: its files, its journal, and every number, computed anew from the raw files in it.

    It needs no book, no database and no network, and writes nothing but in a temporary folder. It exits with 1 where
    something differs, and says what, and by how much.

    Example: labbook verify study.eln
    """
    from labbook.export.verifying import verify as verify_capsule

    with progress("verify", None) as step:
        found = verify_capsule(file, step)
    data = {**plain(found), "whole": found.whole, "sentence": found.sentence}
    return Shown(data, [found.sentence, *found.differences, *found.remarks], 0 if found.whole else DIFFERS)
