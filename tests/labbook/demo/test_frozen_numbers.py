"""Every number of the demonstration, as it was when it was frozen: kind, scope, name, value, error and interval.

A change of structure leaves all of them as they are. Where a number is meant to move, `LABBOOK_FROZEN=write pytest
FILE` writes the data anew, and the change log says why.
"""

from __future__ import annotations

import csv
import io
import lzma
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from data_schema.journal import canonical
from labbook.analysis.results import numbers_of
from labbook.book.opening import Book, opened
from labbook.book.report_numbers import reported_number
from labbook.presenting.report.content import make_report
from tests.helpers.demos import made_demo
from tests.helpers.frozen_numbers import DATA, NUMBERS, TEXTS, by_name, differs, numbers_in


def numbers(book: Book) -> Iterator[dict[str, str]]:
    """Each number of a fresh report's results as it is written down, floats with all their digits."""
    with book.reading() as connection:
        made = make_report(connection, book.store, book.configuration, where=None, made_at="2026-01-01T00:00:00Z")
    for result in made.computed.made.values():
        about = {"kind": result.origin.kind, "scope_json": canonical(result.origin.scope)}
        for name, number in numbers_of(result):
            one = reported_number(name, number, result)
            values = {"name": name, "undefined_reason": one.undefined} | {each: getattr(one, each) for each in NUMBERS}
            row = about | {"unit": one.unit} | values
            yield {each: "" if value is None else str(value) for each, value in row.items()}


@pytest.mark.parametrize("name", ["two_runs_a_condition", pytest.param("demonstration", marks=pytest.mark.soak)])
def test_every_number_is_what_it_was(name: str) -> None:
    with opened(Path(made_demo(name).book)) as book:
        now = by_name(numbers(book))
    assert len(now) > 2000
    path = DATA / f"{name}.csv.xz"
    if os.environ.get("LABBOOK_FROZEN") == "write":
        text = io.StringIO()
        writer = csv.DictWriter(text, [*TEXTS, *NUMBERS], lineterminator="\n")
        writer.writeheader()
        writer.writerows(now.values())
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(lzma.compress(text.getvalue().encode(), preset=9))
    frozen = numbers_in(path.read_bytes())
    assert now.keys() == frozen.keys()
    moved = {name: found for name, row in frozen.items() if (found := differs(row, now[name]))}
    assert moved == {}
