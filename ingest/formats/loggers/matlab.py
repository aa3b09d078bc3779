"""MAT files of versions 4 and 5, read with scipy: vectors, matrices and structs of these become channels.

Vectors and matrices of one length under one name, or at the top, are a table. The columns of a matrix carry its name
and their number, only the number where nothing else is in the table. Time and rate follow the rules of every table.
"""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator, Mapping

import numpy as np

from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.format import SIGNATURE, Format, Recognition
from ingest.formats.head import Head
from ingest.formats.loggers.matlab_elements import MatRefusedError, check_v4, unpacked_v5, v4_end
from ingest.instruments import Instrument
from ingest.model import Reading
from ingest.several import NamedTable, read_several
from ingest.tables.header_cells import clean_name
from ingest.tables.table import Column, array_table

_V5, _V73, _HDF = b"MATLAB 5.0", b"MATLAB 7.3", b"\x89HDF"
_AS_TEXT = "write its variables as text with `writetable`, or `save -v7` them as vectors"

Leaf = tuple[str, str, np.ndarray]
"""The struct a variable is in (empty at the top), its name, its values of shape (n_samples, n_columns)."""


def _recognise(head: Head) -> Recognition | None:
    signed = head.data.startswith((_V5, _V73, _HDF))
    if signed or (head.source is None and v4_end(head.data) is not None):
        return Recognition(SIGNATURE, "a header of MATLAB" if signed else "a matrix of MATLAB version 4")
    return None


def _read(head: Head, findings: FindingCollector) -> Reading:
    try:
        leaves = _leaves(head, findings)
    except MatRefusedError as error:
        findings.add(FILE, "mat_refused", f"The MATLAB file is not read: {error}; {_AS_TEXT}.")
        return Reading()
    if not leaves:
        findings.add(FILE, "no_data_rows", f"The MATLAB file holds no vector or matrix of real numbers: {_AS_TEXT}.")
        return Reading()
    return read_several(_tables(leaves), head.declared, findings)


def _leaves(head: Head, findings: FindingCollector) -> list[Leaf]:
    import scipy.io  # slow to load, and few files are of this format

    if head.data.startswith((_V73, _HDF)):
        raise MatRefusedError("it is of version 7.3 (HDF5)")
    data = head.data
    if data.startswith(_V5):
        data = unpacked_v5(data, head.declared.limits)
    else:
        check_v4(data)
    try:
        found = scipy.io.loadmat(io.BytesIO(data), squeeze_me=True, struct_as_record=False)
    except Exception as error:  # scipy raises many kinds for a damaged file
        raise MatRefusedError(f"it is damaged ({str(error)[:120]})") from error
    variables = {name: value for name, value in found.items() if not name.startswith("__")}
    leaves = list(_numeric("", variables, findings))
    for _, name, columns in leaves:
        if columns.shape[1] > (most := head.declared.limits.most_columns):
            raise MatRefusedError(f"{name!r} has {columns.shape[1]} columns, more than {most} (limit most_columns)")
    return leaves


def _numeric(parent: str, variables: Mapping[str, object], findings: FindingCollector) -> Iterator[Leaf]:
    for name, value in variables.items():
        path = f"{parent}.{name}" if parent else name
        fields = getattr(value, "_fieldnames", None)
        if fields is not None:
            yield from _numeric(path, {field: getattr(value, field) for field in fields}, findings)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.ndim in (1, 2) and value.size:
            columns = value.reshape(-1, 1) if value.ndim == 1 else value
            if columns.shape[1] > columns.shape[0]:
                message = "The matrix is wider than long: its rows are taken for channels."
                findings.add(NOTE, "matrix_transposed", message, column=path)
                columns = columns.T
            yield parent, name, columns
        else:
            message = "The variable is no vector or matrix of real numbers: it stays in the raw copy only."
            findings.add(NOTE, "variable_ignored", message, column=path)


def _tables(leaves: list[Leaf]) -> list[NamedTable]:
    groups: dict[tuple[str, int], list[Leaf]] = {}
    for leaf in leaves:
        groups.setdefault((leaf[0], len(leaf[2])), []).append(leaf)
    tables: dict[str, NamedTable] = {}
    for (parent, _), members in groups.items():
        alone = len(members) == 1
        names: list[str] = []
        columns: list[Column] = []
        for _, name, values in members:
            for at, column in enumerate(values.T, start=1):
                numbered = str(at) if alone else f"{name} {at}"
                names.append(name if values.shape[1] == 1 else numbered)
                columns.append(_column(column))
        first = clean_name(members[0][1] if alone and not parent else parent) or "log"
        part = next(name for n in itertools.count(1) if (name := first if n == 1 else f"{first}_{n}") not in tables)
        tables[part] = NamedTable(array_table(names, [None] * len(names), columns), Instrument(part))
    return list(tables.values())


def _column(values: np.ndarray) -> Column:
    """Return the numbers as float64, as int64 where float64 would round them."""
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8 and np.abs(values.astype(np.float64)).max() >= 2.0**53:
        return np.ascontiguousarray(values, dtype=np.int64)
    return np.ascontiguousarray(values, dtype=np.float64)


FORMAT = Format("mat", 2, _recognise, _read)
