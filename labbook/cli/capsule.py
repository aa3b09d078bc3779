"""`labbook capsule` and `labbook verify`: a book with its report as one file, and whether such a file is whole."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import BookOption, opened
from labbook.terminal import Shown, plain, progress


def capsule(
    file: Annotated[Path, typer.Argument(metavar="FILE.eln", help="The file to write, which is not there yet.")],
    report: Annotated[
        str | None,
        typer.Option(metavar="REPORT", help="Which report: its number, id, last or last-1; without it the newest."),
    ] = None,
    for_sharing: Annotated[
        bool, typer.Option("--for-sharing", help="Leave out what [privacy] of labbook.toml names.")
    ] = False,
    book: BookOption = None,
) -> Shown:
    """Write the book and its report into one file, from which anybody can compute every number anew.

    It is a zipped RO-Crate (.eln): the files of the instruments, the journal, labbook.toml, tables with what their
    columns mean, and the report. `labbook verify` checks it. [sharing] license in labbook.toml says what others may do
    with it.

    With --for-sharing initials stand for names, and notes and paths are left out, as [privacy] leave_out says; the
    journal is chained anew, and says so. Files of the instruments are as they came.

    Example: labbook capsule ../study.eln
    """
    from labbook.export.capsule import write_capsule

    with opened(book) as opened_book, progress("capsule", None) as step:
        done = write_capsule(opened_book, file, report, step, for_sharing=for_sharing)
    lines = [
        f"{done.file}: {done.entries} entries, {done.raw_copies} raw files and report {done.report}, "
        f"{done.n_bytes / 1e6:.1f} MB.",
        f"SHA-256 {done.sha256}",
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
