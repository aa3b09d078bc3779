"""Every number of the demonstration, as it was when it was frozen: kind, scope, name, value, error and interval.

A change of structure leaves all of them as they are. Where a number is meant to move, `LABBOOK_FROZEN=write pytest
FILE` writes the data anew, and the change log says why.
"""

from __future__ import annotations

import csv
import io
import lzma
import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pytest

from data_schema.journal import canonical
from labbook.analysis.study import analyse
from labbook.book.opening import Book, opened
from labbook.book.report_numbers import fields_of_numbers
from tests.helpers.demos import made_demo

DATA = Path(__file__).parent / "data"
RELATIVE = 1e-9
NUMBERS = ("value", "se", "shared_se", "ci_low", "ci_high", "ci_level", "df", "n")
TEXTS = ("kind", "scope_json", "name", "unit", "undefined_reason")


def numbers_in(data: bytes) -> dict[str, dict[str, str]]:
    """The frozen numbers of a file by what they are."""
    return by_name(csv.DictReader(io.StringIO(lzma.decompress(data).decode())))


def by_name(rows: Iterable[dict[str, str]]) -> dict[str, dict[str, str]]:
    """Numbers by kind, scope and name; of several with the same, in their order, each has its place."""
    seen: Counter[str] = Counter()
    found = {}
    for row in rows:
        name = " ".join(row[text] for text in TEXTS[:3])
        seen[name] += 1
        found[f"{name} {seen[name]}"] = row
    return found


def same(frozen: str, now: str) -> bool:
    """Whether a number is what it was, but for the last digits that another processor may give."""
    if not frozen or not now:
        return frozen == now
    return math.isclose(float(frozen), float(now), rel_tol=RELATIVE, abs_tol=0.0)


def differs(frozen: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    return [name for name in TEXTS if frozen[name] != now[name]] + [
        name for name in NUMBERS if not same(frozen[name], now[name])
    ]


def numbers(book: Book) -> Iterator[dict[str, str]]:
    """Each number of a fresh report's results as it is written down, floats with all their digits."""
    with book.reading() as connection:
        made = analyse(connection, book.store, book.configuration, where=None, made_at="2026-01-01T00:00:00Z")
    for result in made.computed.made.values():
        about = {"kind": result.origin.kind, "scope_json": canonical(result.origin.scope)}
        for one in fields_of_numbers(result).values():
            values = {"name": one["name"], "undefined_reason": one["undefined"]} | {each: one[each] for each in NUMBERS}
            row = about | {"unit": one["unit"]} | values
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
