"""Charger sheets in one archive or workbook: lines repeat from member to member, and each charge is one of its own.

After each test a rebuild has to make the same rows.
"""

from __future__ import annotations

import gzip
import io
import zipfile
from collections.abc import Callable

import pytest

from labbook.actions.files.assigning import assign
from tests.helpers.desk import Desk, of_column
from tests.ingest.synthetic_workbooks import workbook

HEADER = "run,charge,other,minutes"
MON, WED = ("r001,150,150,12", "r002,160,,12"), ("r003,170,170,12", "r004,180,180,12")
ALL = {"r001": [150.0], "r002": [160.0], "r003": [170.0], "r004": [180.0]}


def zipped(*members: tuple[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members:
            archive.writestr(name, data)
    return packed.getvalue()


def text(rows: tuple[str, ...]) -> bytes:
    return "\n".join([HEADER, *rows, ""]).encode()


def sheets() -> bytes:
    def cells(rows: tuple[str, ...]) -> list[list[str | float]]:
        named = [row.split(",") for row in rows]
        return [HEADER.split(","), *([run, *(float(cell) if cell else "" for cell in row)] for run, *row in named)]

    return workbook({"mon": cells(MON), "wed": cells(WED)})


FILES: dict[str, Callable[[], bytes]] = {
    "c.zip": lambda: zipped(("mon.csv", text(MON)), ("wed.csv", text(WED))),
    "same_names.zip": lambda: zipped(("a/c.csv", text(MON)), ("b/c.csv", text(WED))),
    "c.xlsx": sheets,
    "nested.zip": lambda: zipped(("c.xlsx", sheets())),
    "c.zip.gz": lambda: gzip.compress(zipped(("mon.csv", text(MON)), ("wed.csv", text(WED)))),
}


@pytest.mark.parametrize("name", FILES)
def test_the_book_holds_every_charge_of_every_sheet(desk: Desk, name: str) -> None:
    desk.take(name, FILES[name](), of_column("charge"))
    assert desk.charges() == ALL
    desk.use(f"-{name}")
    assert not any(desk.charges().values())
    desk.use(f"+{name}")
    assert desk.charges() == ALL


@pytest.mark.parametrize("name", ["c.zip", "c.xlsx"])
def test_what_was_said_of_a_charge_stays_with_its_sheet(desk: Desk, name: str) -> None:
    """Read by the other column, the first sheet lacks the row in whose line a charge of the second one stands."""
    desk.take(name, FILES[name](), of_column("charge"))
    desk.correct_charge("r004", "charge_mah=181")
    desk.say(assign, f"{name}#2", "none", "another pack's")
    corrected = {**ALL, "r002": [], "r004": [181.0]}
    assert desk.charges() == corrected
    desk.read_again(name, of_column("other"))
    assert desk.charges() == corrected
    desk.use(f"-{name}", f"+{name}")
    assert desk.charges() == corrected
    desk.read_again(name, of_column("charge"))
    assert desk.charges() == corrected
