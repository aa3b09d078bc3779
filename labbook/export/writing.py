"""`labbook export`: the tables of a book, and samples if asked for, as a folder of files that other programs read.

The folder appears when all of it is on the disk; until then it has another name beside its own.
"""

from __future__ import annotations

import contextlib
import errno
import importlib.metadata
import itertools
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from data_schema import journal
from data_schema.columns import Column, ValueKind
from data_schema.disk import make_folder, partial_path, path_in_errors, sync, sync_all
from data_schema.errors import UsageError
from data_schema.libraries import optional
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.views import words
from labbook.book.write_session import now_utc
from labbook.export.selection import Selection
from labbook.export.signals import CONVENTIONS, dataset
from labbook.export.tables import TABLES, ExportTable
from reports.display import count_text
from reports.tables.formats import safe_text

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

DICTIONARY, README = "data_dictionary.csv", "README.md"
EXTRA = "export"
"""Names what some formats need beside, in `pip install 'robot-labbook[export]'`."""
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
    table: Callable[[ExportTable, Path], None] | None
    signal: Callable[[xr.Dataset, Path], None] | None
    library: str = ""


def export_tables(selection: Selection, folder: Path, form: str, *, with_signals: bool = False) -> Exported:
    """Write every table of the selected runs into a new or empty folder, with what its columns mean.

    `form` is one of `FORMATS`. Raises `UsageError` for a folder with files in it, and for signals in a form that has
    none.
    """
    if with_signals and FORMATS[form].signal is None:
        held = ", ".join(name for name, one in FORMATS.items() if one.signal is not None)
        raise UsageError(f"--signals needs another format than {form}, which does not hold so many rows: {held}.")
    if FORMATS[form].library:
        optional(FORMATS[form].library, f"--format {form}", EXTRA)
    with _in_place(folder) as partial:
        tables = {name: make(selection) for name, make in TABLES.items()}
        paths = _signal_paths(selection, FORMATS[form].ending) if with_signals else {}
        if with_signals:
            tables["signals"] = _with_paths(tables["signals"], paths)
        selection.step("tables")
        _write_tables(tables, partial, form)
        runs = {run.uid: run for run in selection.data.selected}
        for signal, path in paths.values():
            selection.step(f"samples of {signal.run_name}")
            _write_signal(selection, runs, signal, partial / path, form)
        (partial / DICTIONARY).write_bytes(csv_bytes(dictionary(tables)))
        (partial / README).write_text(_readme(selection, tables, form, len(paths)), encoding="utf-8")
    return Exported(str(folder), {name: len(table.rows) for name, table in tables.items()}, len(paths))


@contextlib.contextmanager
def _in_place(folder: Path) -> Iterator[Path]:
    """Give a folder to write to that takes the place of `folder`, new or empty, when the block has ended well."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{str(folder)!r} is there already and not an empty folder: name a new one.")
    folder = folder.resolve()
    partial = partial_path(folder)
    with path_in_errors(folder):
        if partial.exists():  # of an export that was killed
            shutil.rmtree(partial)
        make_folder(partial)
        try:
            yield partial
            sync_all(partial)
            partial.rename(folder)
            sync(folder.parent)
        except BaseException:
            shutil.rmtree(partial, ignore_errors=True)
            raise


def csv_bytes(table: ExportTable) -> bytes:
    """Write a table as CSV (UTF-8, comma, LF): what `frame.to_csv()` gives, but for texts that look like formulas."""
    frame = table.frame().reset_index()
    for name, column in table.columns.items():
        if column.kind is ValueKind.TEXT:
            frame[name] = frame[name].map(safe_text, na_action="ignore")
    text: str = frame.to_csv(index=False, lineterminator="\n")
    return text.encode()


def dictionary(tables: Mapping[str, ExportTable]) -> ExportTable:
    """Return the table of all columns: what each means, its unit, its source, and what a missing value means."""
    rows = [
        [name, column, str(about.kind), about.unit, about.meaning, about.allowed, about.missing, about.source]
        for name, table in tables.items()
        for column, about in table.columns.items()
    ]
    return ExportTable("data_dictionary", "a column of a table", _DICTIONARY_COLUMNS, rows, keys=2)


_DICTIONARY_COLUMNS = {
    "table": Column("the table"),
    "column": Column("the column"),
    "kind": Column("what its values are", allowed=words(ValueKind)),
    "unit": Column("their unit", missing="they have none"),
    "meaning": Column("what it means"),
    "allowed": Column("which values there are", missing="any"),
    "missing": Column("what a missing value means", missing="there is none"),
    "source": Column("where it comes from"),
}


def _write_csv(table: ExportTable, path: Path) -> None:
    path.write_bytes(csv_bytes(table))


def _write_parquet(table: ExportTable, path: Path) -> None:
    table.frame().reset_index().to_parquet(path, index=False)


def as_dataset(table: ExportTable) -> xr.Dataset:
    """Return a table as variables over `row`, with units; flags are 0 and 1, and -1 where they are missing."""
    import xarray as xr

    frame = table.frame().reset_index()
    found = {}
    for name, column in table.columns.items():
        about = {"long_name": column.meaning, "source": column.source}
        about |= {"units": column.unit or "1"} if column.kind is ValueKind.NUMBER else {}
        about |= {"comment": f"missing: {column.missing}"} if column.missing else {}
        found[name] = ("row", _plain_values(frame[name], column.kind), about)
    return xr.Dataset(
        found, attrs={"Conventions": CONVENTIONS, "title": table.name, "comment": f"a row is {table.row}"}
    )


def _plain_values(values: pd.Series[Any], kind: ValueKind) -> Any:
    match kind:
        case ValueKind.TEXT:
            return values.fillna("").to_numpy(dtype=object)
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


def _write_netcdf(table: ExportTable, path: Path) -> None:
    _signal_netcdf(as_dataset(table), path)


def _write_workbook(tables: Mapping[str, ExportTable], path: Path) -> None:
    """Write a sheet a table, the dictionary first; times are UTC, as their columns say."""
    import pandas as pd

    too_long = [name for name, table in tables.items() if len(table.rows) >= _MOST_ROWS_OF_A_SHEET]
    if too_long:
        raise UsageError(f"{', '.join(too_long)} have more rows than a sheet holds: export csv or parquet.")
    with pd.ExcelWriter(path, engine="openpyxl") as book:
        for name, table in {"data_dictionary": dictionary(tables), **tables}.items():
            frame = table.frame().reset_index()
            for column, about in table.columns.items():
                if about.kind is ValueKind.TIME:
                    frame[column] = frame[column].dt.tz_localize(None)
                elif about.kind is ValueKind.TEXT:
                    frame[column] = frame[column].map(safe_text, na_action="ignore")
            frame.to_excel(book, sheet_name=name, index=False, freeze_panes=(1, table.keys))


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
    "csv": Format("csv", _write_csv, _signal_csv),
    "parquet": Format("parquet", _write_parquet, _signal_parquet),
    "netcdf": Format("nc", _write_netcdf, _signal_netcdf, "netCDF4"),
    "xlsx": Format("xlsx", None, None, "openpyxl"),
}
"""The forms of an export by name; a workbook holds all tables."""


def _write_tables(tables: Mapping[str, ExportTable], folder: Path, form: str) -> None:
    write = FORMATS[form].table
    if write is None:
        _write_workbook(tables, folder / WORKBOOK)
        return
    for name, table in tables.items():
        write(table, folder / f"{name}.{FORMATS[form].ending}")


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


def _write_signal(selection: Selection, runs: Mapping[str, RunRow], signal: SignalRow, path: Path, form: str) -> None:
    path.parent.mkdir(exist_ok=True)
    write = FORMATS[form].signal
    assert write is not None  # noqa: S101 - refused before
    write(dataset(selection.connection, selection.store, runs[signal.run_uid], signal), path)


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
Times are in s from the first sample, and samples are NaN within gaps.
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
Times are UTC. Values are not rounded.
{samples}
Joules are the charge that went back in less what an idle robot draws meanwhile, times {study.reference_voltage_v:g} V,
a jump that was made. Apex heights are means of the jumps that count: those that the detector found, but for what the
protocol and persons left out, as `jumps` has it. The mean of a condition is that of its runs, with Student's interval;
runs of one day are not independent, so that comparisons belong to `labbook report`, which compares within shared days.
"""
