"""`labbook export`: what a book has, as files that other programs read."""

import json
from pathlib import Path
from typing import Annotated

import typer

from data_schema.errors import unknown_name
from labbook.cli.common import BookOption, WhereOption, opened
from labbook.terminal import Shown, progress


def export(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="A new folder; with --mcap, a new file.")],
    form: Annotated[str, typer.Option("--format", metavar="csv|parquet|netcdf|xlsx", help="Of the files.")] = "csv",
    signals: Annotated[bool, typer.Option("--signals", help="Write the samples too, a file a log.")] = False,
    mcap: Annotated[
        str | None,
        typer.Option("--mcap", metavar="RUN", help="Write a run as the one MCAP file FOLDER, and no tables."),
    ] = None,
    where: WhereOption = None,
    book: BookOption = None,
) -> Shown:
    """Write runs, jumps, charges, conditions, verdicts, findings and signals as tables, and what their columns mean.

    From Python: labbook.open("mybook").runs() and its like give the same as frames.

    Example: labbook export tables; labbook export tables --format parquet --signals --where "day>=2021-06-01";
    labbook export r003.mcap --mcap r003
    """
    from labbook.export.mcap import write_mcap
    from labbook.export.selection import Selection
    from labbook.export.writing import FORMATS, export_tables

    if form not in FORMATS:
        raise unknown_name("format of an export", form, FORMATS)
    with opened(book) as opened_book, opened_book.reading() as connection, progress("export", None) as step:
        if mcap is not None:
            of_run = f"run={json.dumps(mcap, ensure_ascii=False)}"
            selection = Selection(connection, opened_book.store, opened_book.configuration, of_run, step)
            count = write_mcap(selection, mcap, folder)
            return Shown({"file": str(folder), "messages": count}, [f"wrote {folder}: {count} messages."])
        selection = Selection(connection, opened_book.store, opened_book.configuration, where, step)
        exported = export_tables(selection, folder, form, with_signals=signals)
    rows = ", ".join(f"{count} {name}" for name, count in exported.rows.items())
    return Shown(exported, [f"wrote {exported.folder}: {rows}."])
