"""Tables of a book as files: CSV, a dictionary of all columns, and a Frictionless data package over them."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any

from data_schema.columns import Column, ValueKind
from labbook.export.tables import ExportTable
from reports.tables.formats import csv_field

DICTIONARY = "data_dictionary.csv"
PACKAGE = "datapackage.json"
_TIME_FORMAT = "any"
"""With a blank between date and time, as frames write it."""
_TYPES: Mapping[ValueKind, str] = {
    ValueKind.TEXT: "string",
    ValueKind.NUMBER: "number",
    ValueKind.COUNT: "integer",
    ValueKind.FLAG: "boolean",
    ValueKind.DATE: "date",
    ValueKind.TIME: "datetime",
}


def table_csv(table: ExportTable) -> bytes:
    """Write a table as CSV (UTF-8, comma, LF, one line of names): floats as their shortest exact text.

    It is what `table.frame().to_csv()` gives, whatever the version of pandas, but that text which a spreadsheet would
    run as a formula gets an apostrophe in front.
    """
    columns = [[row[place] for row in table.rows] for place in range(len(table.columns))]
    texts = [_texts(column.kind, values) for column, values in zip(table.columns.values(), columns, strict=True)]
    return _csv([list(table.columns), *zip(*texts, strict=True)])


def _texts(kind: ValueKind, values: Sequence[Any]) -> list[str]:
    """Return the fields of a column, "" where a value is missing; times have as many digits as one of them needs."""
    if kind is ValueKind.TIME:
        times = [None if value is None else datetime.fromisoformat(value) for value in values]
        parts_us = {time.microsecond for time in times if time is not None}
        digits = "milliseconds" if any(parts_us) else "seconds"
        digits = "microseconds" if any(part % 1000 for part in parts_us) else digits
        return ["" if time is None else time.isoformat(" ", digits) for time in times]
    write: Callable[[Any], str] = {
        ValueKind.FLAG: lambda value: str(bool(value)),
        ValueKind.NUMBER: lambda value: csv_field(float(value)),
    }.get(kind, csv_field)
    return ["" if value is None else write(value) for value in values]


def _csv(rows: Iterable[Sequence[str]]) -> bytes:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue().encode()


def data_dictionary(tables: Iterable[ExportTable]) -> bytes:
    """Write what each column of tables means as CSV, a line each."""
    head = ("table", "column", "kind", "unit", "meaning", "missing", "allowed", "source")
    return _csv(
        [
            head,
            *(
                list(map(csv_field, (table.name, name, str(one.kind), *(getattr(one, of) for of in head[3:]))))
                for table in tables
                for name, one in table.columns.items()
            ),
        ]
    )


def data_package(title: str, license_: str | None, tables: Iterable[ExportTable], files: Mapping[str, bytes]) -> bytes:
    """Describe tables as a Frictionless data package; `files` are their CSV files by path below the package."""
    package = {
        "profile": "tabular-data-package",
        "name": re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "study",
        "title": title,
        **({} if license_ is None else {"licenses": [{"path" if "://" in license_ else "name": license_}]}),
        "resources": [_resource(table, files[table_path(table.name)]) for table in tables],
    }
    return (json.dumps(package, indent=1, ensure_ascii=False) + "\n").encode()


def table_path(name: str) -> str:
    """Return where a table's file lies below the package."""
    return f"tables/{name}.csv"


def _resource(table: ExportTable, data: bytes) -> dict[str, Any]:
    return {
        "profile": "tabular-data-resource",
        "name": table.name.replace("_", "-"),
        "title": table.row,
        "path": table_path(table.name),
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "bytes": len(data),
        "hash": f"sha256:{hashlib.sha256(data).hexdigest()}",
        "schema": {
            "fields": [_field(name, column) for name, column in table.columns.items()],
            "missingValues": [""],
        },
    }


def _field(name: str, column: Column) -> dict[str, Any]:
    return {
        "name": name,
        "type": _TYPES[column.kind],
        **({"format": _TIME_FORMAT} if column.kind is ValueKind.TIME else {}),
        "description": column.text,
        **({"unit": column.unit} if column.unit else {}),
        **({} if column.missing or column.kind is ValueKind.TEXT else {"constraints": {"required": True}}),
    }
