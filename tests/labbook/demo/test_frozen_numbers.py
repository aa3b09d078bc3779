"""Every number of the demonstration, as it was when it was frozen: name, id, value, error and interval.

A change of structure leaves all of them as they are. Where a number is meant to move, `LABBOOK_FROZEN=write pytest
FILE` writes the data anew, and the change log says why.
"""

from __future__ import annotations

import csv
import io
import lzma
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.tables.results import result, result_number
from labbook.book.opening import Book, opened
from tests.helpers.demos import made_demo

DATA = Path(__file__).parent / "data"
RELATIVE = 1e-12
CANCELLING = {
    "dae1ab37c557": "shared error of a difference: the drain's errors of both sides but for a thousandth",
    "9904b937b008": "the same",
    "ab8aa7cf2084": "an end of an interval at -5e-7 m, a difference less nearly as much",
    "29560a7ce7cf": "an end of an interval at 0.16 mm, a bias of 12.9 mm less nearly as much",
}
"""Numbers, by id, that are a small rest of their terms: processors were seen to differ in them by up to 5e-12."""
OF_CANCELLING = 1e-11
NUMBERS = ("value", "se", "shared_se", "ci_low", "ci_high", "ci_level", "df", "n")
TEXTS = ("kind", "scope_json", "name", "unit", "undefined_reason")


def numbers(book: Book) -> Iterator[dict[str, str]]:
    """Each stored number as it is written down, floats with all their digits."""
    columns = [*(result.c[name] for name in TEXTS[:2]), result_number.c.uid]
    columns += [result_number.c[name] for name in (*TEXTS[2:], *NUMBERS)]
    query = sa.select(*columns).join(result).order_by(result.c.kind, result.c.scope_json, result_number.c.name)
    with book.reading() as connection:
        for row in connection.execute(query).mappings():
            yield {name: "" if value is None else str(value) for name, value in row.items()}


def same(frozen: str, now: str, tolerance: float) -> bool:
    """Whether a number is what it was, but for the last digits that another processor may give."""
    if not frozen or not now:
        return frozen == now
    return math.isclose(float(frozen), float(now), rel_tol=tolerance, abs_tol=0.0)


def differs(frozen: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    tolerance = OF_CANCELLING if frozen["uid"] in CANCELLING else RELATIVE
    return [name for name in TEXTS if frozen[name] != now[name]] + [
        name for name in NUMBERS if not same(frozen[name], now[name], tolerance)
    ]


@pytest.mark.parametrize("name", ["two_runs_a_condition", pytest.param("demonstration", marks=pytest.mark.soak)])
def test_every_number_is_what_it_was(name: str) -> None:
    with opened(Path(made_demo(name).book)) as book:
        now = {row["uid"]: row for row in numbers(book)}
    assert len(now) > 2000
    path = DATA / f"{name}.csv.xz"
    if os.environ.get("LABBOOK_FROZEN") == "write":
        text = io.StringIO()
        writer = csv.DictWriter(text, ["uid", *TEXTS, *NUMBERS], lineterminator="\n")
        writer.writeheader()
        writer.writerows(now.values())
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(lzma.compress(text.getvalue().encode(), preset=9))
    frozen = {row["uid"]: row for row in csv.DictReader(io.StringIO(lzma.decompress(path.read_bytes()).decode()))}
    assert now.keys() == frozen.keys()
    moved = {uid: found for uid, row in frozen.items() if (found := differs(row, now[uid]))}
    assert moved == {}
