"""Asking a study by its name, and which studies a book has."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from data_schema.queries.files import readings_in_force
from data_schema.queries.runs import has_runs
from labbook.analysis.comparison.pairing import swept_factor
from labbook.config.studies import STUDIES

if TYPE_CHECKING:
    import sqlalchemy as sa

    from labbook.config.model import Configuration
    from labbook.studies.study import Asked, Found
    from reports.page.study import Study


def ask(name: str, asked: Asked) -> Found[Study]:
    """Ask the study of this name, which is the function `ask` of its file."""
    found: Found[Study] = import_module(f"labbook.studies.{name.replace('-', '_')}").ask(asked)
    return found


def studies_of_book(connection: sa.Connection, configuration: Configuration) -> list[str]:
    """Name the studies of a book: those that labbook.toml has a table of, whose sheet it has, or its runs are made for.

    Every new book is of the bed's kind: it has that study only with a control, and without a table of another of runs.
    """
    sheets = {entry.sheet: name for name, entry in STUDIES.items() if entry.sheet}
    there = {sheets[row.reader] for row in readings_in_force(connection, list(sheets))} | set(configuration.studies)
    of_runs = {name: entry.runs for name, entry in STUDIES.items() if entry.runs is not None}
    if has_runs(connection):
        of_another = swept_factor(configuration) is None or bool(there & of_runs.keys())
        there |= {
            name
            for name, kind in of_runs.items()
            if kind is configuration.study.kind and not (name == "bed" and of_another)
        }
    return [name for name in STUDIES if name in there]
