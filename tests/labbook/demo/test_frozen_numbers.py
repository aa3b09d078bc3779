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
import sqlalchemy as sa

from data_schema.tables.results import result, result_number
from labbook.book.opening import Book, opened
from tests.helpers.demos import made_demo
from tests.helpers.frozen_numbers import DATA, NUMBERS, TEXTS, by_name, differs, numbers_in


def numbers(book: Book) -> Iterator[dict[str, str]]:
    """Each stored number as it is written down, floats with all their digits."""
    columns = [*(result.c[name] for name in TEXTS[:2]), *(result_number.c[name] for name in (*TEXTS[2:], *NUMBERS))]
    order = (result.c.kind, result.c.scope_json, result_number.c.name, result_number.c.value)
    query = sa.select(*columns).join(result).order_by(*order)
    with book.reading() as connection:
        for row in connection.execute(query).mappings():
            yield {name: "" if value is None else str(value) for name, value in row.items()}


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
