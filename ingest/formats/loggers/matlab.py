"""MAT files of versions 4 and 5, read with scipy: vectors, matrices and structs of these become channels.

Vectors and matrices of one length under one name, or at the top, are a table. The columns of a matrix carry its name
and their number, only the number where nothing else is in the table. Time and rate follow the rules of every table.
Simulink's structure with time is one table, `signals.values` beside `time`; its `tout` alone is none.

The elements of a file are walked before scipy reads them. Version 4 has no signature: five integers, a name and numbers
follow each other to the end of the file. Version 5 packs its variables one by one, and a file of some kilobytes can
unpack to more than any memory; scipy's reader of it trusts every tag, and a wrong one ends the whole process, so tags
and sizes are compared here.
"""

from __future__ import annotations

import io
import itertools
import math
import re
import struct
import zlib
from collections.abc import Iterator, Mapping

import numpy as np

from ingest.channels.names import clean_name
from ingest.formats.format import Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, FindingCollector, Limits, Reading
from ingest.signals import read_several
from ingest.tables.table import Column, Table, array_table

_V5, _V73 = b"MATLAB 5.0", b"MATLAB 7.3"
_AS_TEXT = "write its variables as text with `writetable`, or `save -v7` them as vectors"

Leaf = tuple[str, str, np.ndarray]
"""The struct a variable is in (empty at the top), its name, its values of shape (n_samples, n_columns)."""


def _recognise(head: Head) -> str | None:
    signed = head.data.startswith((_V5, _V73))
    if signed or (head.source is None and v4_end(head.data) is not None):
        return "a header of MATLAB" if signed else "a matrix of MATLAB version 4"
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
    return read_several(_tables(leaves, findings), head.declared, findings)


def _leaves(head: Head, findings: FindingCollector) -> list[Leaf]:
    import scipy.io  # slow to load, and few files are of this format

    if head.data.startswith(_V73):
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
            members = {field: getattr(value, field) for field in fields}
            label = members.get("label")
            if "values" in members and isinstance(label, str) and label:  # a signal of Simulink
                members = {label: members["values"]}
            yield from _numeric(path, members, findings)
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


def _tables(leaves: list[Leaf], findings: FindingCollector) -> list[tuple[Table, Instrument]]:
    groups: dict[tuple[str, int], list[Leaf]] = {}
    for leaf in leaves:
        groups.setdefault((leaf[0].removesuffix(".signals"), len(leaf[2])), []).append(leaf)
    alone = [key for key, members in groups.items() if [member[:2] for member in members] == [("", "tout")]]
    for key in alone if len(groups) > 1 else ():
        message = "The times of Simulink's steps stand alone: they stay in the raw copy only."
        findings.add(NOTE, "variable_ignored", message, column="tout")
        del groups[key]
    tables: dict[str, tuple[Table, Instrument]] = {}
    for (parent, _), members in groups.items():
        single = len(members) == 1
        names: list[str] = []
        columns: list[Column] = []
        for _, name, values in members:
            for at, column in enumerate(values.T, start=1):
                numbered = str(at) if single else f"{name} {at}"
                names.append(name if values.shape[1] == 1 else numbered)
                columns.append(_column(column))
        first = clean_name(members[0][1] if single and not parent else parent) or "log"
        part = next(name for n in itertools.count(1) if (name := first if n == 1 else f"{first}_{n}") not in tables)
        tables[part] = (array_table(names, [None] * len(names), columns), Instrument(part))
    return list(tables.values())


def _column(values: np.ndarray) -> Column:
    """Return the numbers as float64, as int64 where float64 would round them."""
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8 and np.abs(values.astype(np.float64)).max() >= 2.0**53:
        return np.ascontiguousarray(values, dtype=np.int64)
    return np.ascontiguousarray(values, dtype=np.float64)


V5_HEADER = 128
_V4_HEADER = 20
_V4_ITEM_BYTES = (8, 4, 4, 2, 2, 1)
_V4_NAME = re.compile(rb"[A-Za-z]\w{0,62}\0")

# Types of elements of version 5 with the bytes of an item; a matrix holds elements itself.
_ITEM_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 14: 1, 16: 1, 17: 2, 18: 4}
_BYTES, _INTEGERS, _FLAGS, _MATRIX, _COMPRESSED = 1, 5, 6, 14, 15
# Classes of matrices of version 5.
_CELL, _STRUCT, _TEXT, _SPARSE = 1, 2, 4, 5
_OBJECTS = (3, 16, 17)
_COMPLEX = 0x0800
_DEEPEST = 16


class MatRefusedError(ValueError):
    """The file is damaged or beyond a limit; the message is a sentence without its end."""


def v4_end(data: bytes, at: int = 0) -> int | None:
    """Return where the matrix of version 4 that begins at `at` should end, None where none begins."""
    if len(data) < at + _V4_HEADER:
        return None
    order = "<" if data[at + 1] == data[at + 2] == data[at + 3] == 0 else ">"
    kind, rows, columns, imaginary, name_length = struct.unpack_from(f"{order}5i", data, at)
    machine, kind = divmod(kind, 1000)
    item, what = divmod(kind, 10)
    name = data[at + _V4_HEADER : at + _V4_HEADER + max(0, name_length)]
    valid = machine == (order == ">") and item < len(_V4_ITEM_BYTES) and what <= 2 and imaginary in (0, 1)
    if not valid or rows < 0 or columns < 0 or not _V4_NAME.fullmatch(name):
        return None
    length: int = name_length
    return at + _V4_HEADER + length + int(rows * columns * _V4_ITEM_BYTES[item] * (1 + imaginary))


def check_v4(data: bytes) -> None:
    """Raise `MatRefusedError` unless matrices of version 4 fill the file to its end."""
    at = 0
    while at < len(data):
        end = v4_end(data, at)
        if end is None or end > len(data):
            raise MatRefusedError(f"the matrix at byte {at} is damaged or cut")
        at = end


def unpacked_v5(data: bytes, limits: Limits) -> bytes:
    """Return the file with its variables unpacked.

    Raises `MatRefusedError` unless whole elements of version 5 fill it, without objects, within the limits.
    """
    if len(data) < V5_HEADER or data[126:128] not in (b"IM", b"MI"):
        raise MatRefusedError("its header is damaged")
    order = "<" if data[126:128] == b"IM" else ">"
    most = limits.most_expanded(len(data))
    pieces: list[bytes | memoryview] = [data[:V5_HEADER]]
    at = V5_HEADER
    while at < len(data):
        kind, size = struct.unpack_from(f"{order}2I", data[at : at + 8].ljust(8, b"\0"))
        if kind not in (_MATRIX, _COMPRESSED) or at + 8 + size > len(data):
            raise MatRefusedError(f"the variable at byte {at} is damaged or cut")
        whole = memoryview(data)[at : at + 8 + size]
        content = whole[8:]
        try:
            if kind == _COMPRESSED:
                whole = memoryview(_unpacked(content, most))
                most -= len(whole)
                ((kind, content),) = _elements(whole, order)
            if kind != _MATRIX:
                raise MatRefusedError(f"it is of type {kind}")
            _check_matrix(content, order, _DEEPEST)
        except (ValueError, struct.error, zlib.error) as error:
            raise MatRefusedError(f"the variable at byte {at} cannot be read ({error})") from error
        pieces.append(whole)
        at += 8 + size
    return b"".join(pieces)


def _unpacked(packed: memoryview, most: int) -> bytes:
    """Return a packed variable; its checksum is compared."""
    unpacking = zlib.decompressobj()
    content = unpacking.decompress(packed, most + 1)
    if len(content) > most:
        raise MatRefusedError(
            f"it unpacks to more than {most} bytes, limits largest_expansion and largest_expanded_bytes"
        )
    if not unpacking.eof:
        raise MatRefusedError("it is cut")
    return content


def _elements(content: memoryview, order: str) -> list[tuple[int, memoryview]]:
    """Return type and content of the elements in a matrix; four bytes and fewer stand in the tag itself."""
    found = []
    at = 0
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}2I", content, at)
        start, step = at + 8, 8 + (size + 7) // 8 * 8
        if kind >> 16:
            kind, size = kind & 0xFFFF, kind >> 16
            start, step = at + 4, 8
        if kind not in _ITEM_BYTES or start + size > len(content) or (step == 8 and size > 4):
            raise MatRefusedError("an element is damaged")
        found.append((kind, content[start : start + size]))
        at += step
    return found


def _check_matrix(content: memoryview, order: str, deepest: int) -> None:
    elements = _elements(content, order)
    if not elements:
        return
    (kind, flags), rest = elements[0], elements[1:]
    if kind != _FLAGS or len(flags) != 8 or deepest == 0:
        raise MatRefusedError("its flags are damaged")
    (word,) = struct.unpack_from(f"{order}I", flags)
    matrix = word & 0xFF
    if matrix in _OBJECTS:
        raise MatRefusedError("it is an object of a MATLAB class, as Simulink stores, which only MATLAB can open")
    if matrix == _SPARSE or not 1 <= matrix <= 15:
        raise MatRefusedError("it is a sparse matrix" if matrix == _SPARSE else f"it is of class {matrix}")
    if len(rest) < 2 or [one for one, _ in rest[:2]] != [_INTEGERS, _BYTES] or len(rest[0][1]) % 4:
        raise MatRefusedError("its size or name is damaged")
    shape = struct.unpack(f"{order}{len(rest[0][1]) // 4}i", rest[0][1])
    count, values = math.prod(shape), rest[2:]
    if matrix == _STRUCT:
        if len(values) < 2 or len(values[0][1]) != 4:
            raise MatRefusedError("its fields are damaged")
        (width,) = struct.unpack(f"{order}i", values[0][1])
        fields, left = divmod(len(values[1][1]), width) if width > 0 else (0, 1)
        count, values = (-1 if left else count * fields), values[2:]
    if min(shape) < 0 or len(shape) < 2 or count < 0:
        raise MatRefusedError("its size is damaged")
    if matrix in (_CELL, _STRUCT):
        if len(values) != count or any(one != _MATRIX for one, _ in values):
            raise MatRefusedError(f"it says {count} elements and holds {len(values)}")
        for _, inner in values:
            _check_matrix(inner, order, deepest - 1)
    elif len(values) != (2 if word & _COMPLEX else 1) and (values or count):
        raise MatRefusedError("its values are damaged")
    elif matrix != _TEXT and any(one == _MATRIX or len(inner) != count * _ITEM_BYTES[one] for one, inner in values):
        raise MatRefusedError(f"it says {count} values and holds others")


_BEGINS = rb"MATLAB (?:5\.0|7\.3)|[\0-\x34]\0\0\0|\0\0[\x03\x04]"
"""Version 4 has a number for machine, order and type there."""
FORMAT = Format("mat", 5, _recognise, _read, begins=_BEGINS)
