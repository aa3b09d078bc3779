"""`labbook export`: the tables of a book, and samples if asked for, as a folder of files that other programs read.

The folder appears when all of it is on the disk; until then it has another name beside its own.
"""

from __future__ import annotations

import contextlib
import errno
import importlib.metadata
import io
import itertools
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from data_schema import journal
from data_schema.columns import ValueKind
from data_schema.disk import PART, make_folder, path_in_errors, sync, sync_all
from data_schema.errors import UsageError
from data_schema.libraries import optional
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.queries.study import people
from labbook.actions.report_command import refuse_store
from labbook.book.write_session import now_utc
from labbook.export.sharing import LEFT_OUT, private_of
from labbook.export.signals import CONVENTIONS, dataset
from labbook.export.table_files import DICTIONARY, data_dictionary, table_csv
from labbook.export.tables import ExportTable, Selection, every_table
from reports.display import count_text

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

README = "README.md"
EXTRA = "export"
"""Names what some formats need beside, in `pip install 'robot-labbook[export]'`."""
FLAG = ValueKind.FLAG
WORKBOOK, SIGNALS = "tables.xlsx", "signals"
_MOST_ROWS_OF_A_SHEET = 1_048_576


@dataclass(frozen=True, slots=True)
class Exported:
    """What was written: the folder, rows by table, and how many signals."""

    folder: str
    rows: Mapping[str, int]
    signals: int


@dataclass(frozen=True, slots=True)
class Format:
    """A form of files: the ending, and what writes a table, and a signal, to a path; None where it holds none.

    `library` is what it needs beside what labbook always has.
    """

    ending: str
    table: Callable[[ExportTable, Path], object] | None
    signal: Callable[[xr.Dataset, Path], object] | None
    library: str = ""


def export_tables(
    selection: Selection, folder: Path, form: str, *, with_signals: bool = False, for_sharing: bool = False
) -> Exported:
    """Write every table of the selected runs into a new or empty folder, with what its columns mean.

    `form` is one of `FORMATS`; `for_sharing` leaves out what `[privacy]` of labbook.toml names. Raises `UsageError`
    for a folder with files in it, and for signals in a form that has none.
    """
    chosen = FORMATS[form]
    write_signal = chosen.signal if with_signals else None
    if with_signals and write_signal is None:
        held = ", ".join(name for name, one in FORMATS.items() if one.signal is not None)
        raise UsageError(f"--signals needs another format than {form}, which does not hold so many rows: {held}.")
    if chosen.library:
        optional(chosen.library, f"--format {form}", EXTRA)
    with _in_place(folder) as partial:
        tables = {table.name: table for table in every_table(selection)}
        if for_sharing:
            private = private_of(people(selection.connection), selection.configuration)
            tables = {name: private.table(table) for name, table in tables.items()}
        paths = _signal_paths(selection, chosen.ending) if with_signals else {}
        if with_signals:
            tables["signals"] = _with_paths(tables["signals"], paths)
        selection.step("tables")
        if chosen.table is None:
            _write_workbook(tables, partial / WORKBOOK)
        else:
            for name, table in tables.items():
                chosen.table(table, partial / f"{name}.{chosen.ending}")
        if write_signal is not None:
            (partial / SIGNALS).mkdir()
            runs = {run.uid: run for run in selection.data.selected}
            for signal, path in paths.values():
                selection.step(f"samples of {signal.run_name}")
                samples = dataset(selection.connection, selection.store, runs[signal.run_uid], signal)
                write_signal(samples, partial / path)
        (partial / DICTIONARY).write_bytes(data_dictionary(tables.values()))
        readme = _readme(selection, tables, form, len(paths))
        if for_sharing:
            left_out = ", ".join(selection.configuration.privacy.leave_out)
            readme += f"\nMade for sharing, without {left_out}: initials stand for names, {LEFT_OUT} for texts.\n"
        (partial / README).write_text(readme, encoding="utf-8")
    return Exported(str(folder), {name: len(table.rows) for name, table in tables.items()}, len(paths))


@contextlib.contextmanager
def _in_place(folder: Path) -> Iterator[Path]:
    """Give a folder of its own to write to, whose files get into `folder` when the block has ended well.

    A new folder gets its name then; one that is there and empty is filled, and holds this one meanwhile, so that nobody
    else takes it. Nothing that somebody else put there is removed.
    """
    folder = folder.resolve()
    refuse_store(folder)
    is_there = folder.exists()
    if is_there and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{str(folder)!r} is there already and not an empty folder: name a new one.")
    with path_in_errors(folder):
        if not is_there:
            make_folder(folder.parent)
        own = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=PART, dir=folder if is_there else folder.parent))
        try:
            partial = own / "files"
            partial.mkdir()
            yield partial
            sync_all(partial)
            if is_there and [*folder.iterdir()] != [own]:
                raise UsageError(f"somebody put files into {str(folder)!r} meanwhile: name a new folder.")
            if is_there:
                for path in sorted(partial.iterdir()):
                    path.rename(folder / path.name)
            else:
                try:
                    partial.rename(folder)
                except OSError as error:
                    if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
                        raise
                    raise UsageError(f"somebody made {str(folder)!r} meanwhile: name a new folder.") from error
            sync(folder)
        finally:
            shutil.rmtree(own, ignore_errors=True)
        sync(folder.parent)


def as_dataset(table: ExportTable) -> xr.Dataset:
    """Return a table as variables over `row`, with units; a missing value is NaN, NaT, or the fill value of flags."""
    import xarray as xr

    frame = table.frame().reset_index()
    found = {}
    for name, column in table.columns.items():
        about: dict[str, Any] = {"long_name": column.meaning, "source": column.source}
        about |= {"units": column.unit or "1"} if column.kind is ValueKind.NUMBER else {}
        about |= {"comment": f"missing: {column.missing}"} if column.missing else {}
        about |= {"flag_values": np.array([0, 1], "int8"), "flag_meanings": "no yes"} if column.kind is FLAG else {}
        fill = {"_FillValue": np.int8(-1)} if column.kind is FLAG else {}
        found[name] = ("row", _plain_values(frame[name], column.kind), about | fill)
    return xr.Dataset(
        found, attrs={"Conventions": CONVENTIONS, "title": table.name, "comment": f"a row is {table.row}"}
    )


def _plain_values(values: pd.Series[Any], kind: ValueKind) -> Any:
    match kind:
        case ValueKind.TEXT:
            return np.array(values.fillna("").to_list(), dtype=str)
        case ValueKind.FLAG:
            return values.astype("Int8").fillna(-1).to_numpy("int8")
        case ValueKind.COUNT:
            return (
                values.to_numpy(dtype="float64", na_value=np.nan) if values.isna().any() else values.to_numpy("int64")
            )
        case ValueKind.TIME:
            return values.dt.tz_localize(None).to_numpy()
        case _:
            return values.to_numpy()


def _write_workbook(tables: Mapping[str, ExportTable], path: Path) -> None:
    """Write a sheet a table, the dictionary first; times are UTC, as their columns say."""
    import pandas as pd

    too_long = [name for name, table in tables.items() if len(table.rows) >= _MOST_ROWS_OF_A_SHEET]
    if too_long:
        raise UsageError(f"{', '.join(too_long)} have more rows than a sheet holds: export csv or parquet.")
    with pd.ExcelWriter(path, engine="openpyxl") as book:
        pd.read_csv(io.BytesIO(data_dictionary(tables.values()))).to_excel(
            book, sheet_name="data_dictionary", index=False
        )
        for name, table in tables.items():
            frame = table.frame().reset_index()
            for column, about in table.columns.items():
                if about.kind is ValueKind.TIME:
                    frame[column] = frame[column].dt.tz_localize(None)
            frame.to_excel(book, sheet_name=name, index=False, freeze_panes=(1, table.keys))
        for cell in (cell for sheet in book.sheets.values() for row in sheet.iter_rows() for cell in row):
            if cell.data_type == "f":  # a text that begins as a formula does
                cell.data_type = "s"


def _as_arrow(samples: xr.Dataset) -> pa.Table:
    """Return samples as columns with their unit behind the name, as the book's own files have them; NaN is missing."""
    import pyarrow as pa

    columns = {}
    for name in ("time", *samples.data_vars):
        unit = samples[name].attrs.get("units")
        columns[f"{name} [{unit}]" if unit else str(name)] = pa.array(samples[name].to_numpy(), from_pandas=True)
    return pa.table(columns)


def _signal_csv(samples: xr.Dataset, path: Path) -> None:
    from pyarrow import csv

    csv.write_csv(_as_arrow(samples), path, csv.WriteOptions(quoting_style="needed"))


def _signal_parquet(samples: xr.Dataset, path: Path) -> None:
    from pyarrow import parquet

    parquet.write_table(_as_arrow(samples), path, compression="zstd")


def _signal_netcdf(samples: xr.Dataset, path: Path) -> None:
    try:
        samples.to_netcdf(path, engine="netcdf4")
    except RuntimeError as error:  # how its library says that the disk is full
        raise OSError(errno.EIO, str(error), str(path)) from error


FORMATS: Mapping[str, Format] = {
    "csv": Format("csv", lambda table, path: path.write_bytes(table_csv(table)), _signal_csv),
    "parquet": Format(
        "parquet", lambda table, path: table.frame().reset_index().to_parquet(path, index=False), _signal_parquet
    ),
    "netcdf": Format("nc", lambda table, path: _signal_netcdf(as_dataset(table), path), _signal_netcdf, "netCDF4"),
    "xlsx": Format("xlsx", None, None, "openpyxl"),
}
"""The forms of an export by name; a workbook holds all tables."""


def _signal_paths(selection: Selection, ending: str) -> dict[str, tuple[SignalRow, str]]:
    """Return the signals of the selected runs by uid, each with its file in the folder, no two the same."""
    found: dict[str, tuple[SignalRow, str]] = {}
    taken: set[str] = set()
    runs = [run.uid for run in selection.data.selected]
    for signal in signals_of_runs(selection.connection, run_uids=runs):
        plain = re.sub(r"[^\w.-]+", "_", signal.run_name).strip(".") or "run"
        first = f"{plain}_{signal.role}"
        names = itertools.chain([first], (f"{first}_{number}" for number in itertools.count(2)))
        name = next(each for each in names if each.casefold() not in taken)
        taken.add(name.casefold())
        found[signal.uid] = (signal, f"{SIGNALS}/{name}.{ending}")
    return found


def _with_paths(table: ExportTable, paths: Mapping[str, tuple[SignalRow, str]]) -> ExportTable:
    """Return the table of signals with the files of this folder in place of the book's."""
    names = list(table.columns)
    uid, samples = names.index("uid"), names.index("samples")
    columns = {**table.columns, "samples": replace(table.columns["samples"], meaning="the file with its samples")}
    rows = [[*row[:samples], paths[row[uid]][1], *row[samples + 1 :]] for row in table.rows if row[uid] in paths]
    return replace(table, columns=columns, rows=rows)


def _readme(selection: Selection, tables: Mapping[str, ExportTable], form: str, n_signals: int) -> str:
    """Say what is in the folder, and how its numbers came about."""
    study = selection.configuration.study
    seq, last_hash = journal.head(selection.connection)
    ending = FORMATS[form].ending
    files = {name: f"`{WORKBOOK}`, sheet `{name}`" if form == "xlsx" else f"`{name}.{ending}`" for name in tables}
    rows = [f"| {files[name]} | {table.row} | {len(table.rows)} |" for name, table in tables.items()]
    samples = (
        f"""
`{SIGNALS}/` has {count_text(n_signals, "file")} of samples; column `samples` of `signals` says which is whose.
Times are in s from the first sample. Within gaps samples are missing; one row stands in a gap that has none, so that a
file may have more rows than `n_samples`.
"""
        if n_signals
        else ""
    )
    return f"""# {study.name}

Tables of {selection.where or "all runs"}, exported from its lab notebook on {now_utc()[:10]} by labbook
{importlib.metadata.version("robot-labbook")}, as of entry {seq} of the journal (hash {last_hash}).

| file | a row is | rows |
|---|---|---|
{chr(10).join(rows)}

`{DICTIONARY}` says of each column what it means, its unit, where it comes from and what a missing value means.
Times are UTC. {_NOTES[form]}
{samples}
Joules are the charge that went back in less what an idle robot draws meanwhile, times {study.reference_voltage_v:g} V,
a jump that was made. Apex heights are means of the jumps that count: those that the detector found, but for what the
protocol and persons left out, as `jumps` has it. The mean of a condition is that of its runs; its interval holds their
scatter (`se`) and the error that they have in common (`shared_se`: of the passive drain, of a calibration). Runs of one
day are not independent, so that comparisons belong to `labbook report`, which compares within shared days.
"""


_NOTES = {
    "csv": "Values are not rounded. A missing value is an empty field, a flag True or False; a text that begins with\n"
    "=, +, - or @ has an apostrophe in front, which no program then runs.",
    "parquet": "Values are not rounded. A missing value is null.",
    "netcdf": 'Values are not rounded. A missing number is NaN, a missing text "", a missing flag the fill value.',
    "xlsx": "Numbers have 16 digits. A missing value is an empty cell.",
}
