"""`labbook verify`: whether a book with its report as one file is whole."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.terminal import Shown, plain, progress

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
