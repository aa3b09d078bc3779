"""Tables of a book as files: CSV, a dictionary of all columns, and a Frictionless data package over them."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from data_schema.columns import Column, ValueKind
from labbook.export.selection import Selection
from labbook.export.tables import TABLES, ExportTable
from reports.tables.formats import csv_field

DICTIONARY = "data_dictionary.csv"
PACKAGE = "datapackage.json"
_TYPES: Mapping[ValueKind, str] = {
    ValueKind.TEXT: "string",
    ValueKind.NUMBER: "number",
    ValueKind.COUNT: "integer",
    ValueKind.FLAG: "boolean",
    ValueKind.DATE: "date",
    ValueKind.TIME: "datetime",
}


def every_table(selection: Selection) -> list[ExportTable]:
    """Return the tables of a selection, with their rows in the same order on any engine."""
    return [_in_order(make(selection)) for make in TABLES.values()]


def _in_order(table: ExportTable) -> ExportTable:
    """Order the rows of each run, or of what else the first column names, by all that they say."""
    places = {key: place for place, key in enumerate(dict.fromkeys(row[0] for row in table.rows))}
    rows = sorted(table.rows, key=lambda row: (places[row[0]], [_comparable(cell) for cell in row[1:]]))
    return replace(table, rows=rows)


def _comparable(cell: Any) -> tuple[bool, float, str]:
    return (False, 0.0, cell) if isinstance(cell, str) else (cell is None, cell or 0.0, "")


def table_csv(table: ExportTable) -> bytes:
    """Write a table as CSV (UTF-8, comma, LF, one line of names): floats as their shortest exact text.

    A missing value is an empty field, a flag true or false; text that a spreadsheet would run as a formula gets an
    apostrophe in front.
    """
    kinds = [column.kind for column in table.columns.values()]
    return _csv(
        [
            list(table.columns),
            *([_cell(kind, value) for kind, value in zip(kinds, row, strict=True)] for row in table.rows),
        ]
    )


def _cell(kind: ValueKind, value: Any) -> str:
    if value is None:
        return ""
    if kind is ValueKind.FLAG:
        return "true" if value else "false"
    return csv_field(float(value) if kind is ValueKind.NUMBER else value)


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
                [csv_field(text) for text in (table.name, name, *_about(column))]
                for table in tables
                for name, column in table.columns.items()
            ),
        ]
    )


def _about(column: Column) -> tuple[str, ...]:
    return (str(column.kind), column.unit, column.meaning, column.missing, column.allowed, column.source)


def data_package(title: str, license_: str | None, tables: Iterable[ExportTable], files: Mapping[str, bytes]) -> bytes:
    """Describe tables as a Frictionless data package; `files` are their CSV files by path below the package."""
    package = {
        "profile": "tabular-data-package",
        "name": re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "study",
        "title": title,
        **({} if license_ is None else {"licenses": [_license(license_)]}),
        "resources": [_resource(table, files[table_path(table.name)]) for table in tables],
    }
    return (json.dumps(package, indent=1, ensure_ascii=False) + "\n").encode()


def table_path(name: str) -> str:
    """Return where a table's file lies below the package."""
    return f"tables/{name}.csv"


def _license(given: str) -> dict[str, str]:
    return {"path": given} if "://" in given else {"name": given}


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
        "description": column.text,
        **({"unit": column.unit} if column.unit else {}),
        **({} if column.missing or column.kind is ValueKind.TEXT else {"constraints": {"required": True}}),
    }
