"""`labbook why` tells what was said since of the inputs of a number."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.queries.history import list_reports
from labbook.book.report_numbers import read_numbers
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, reported_book
from tests.helpers.wording import says

WHY = ("--why", "for this test")
SHEET = "2021-06-14.csv"


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    return reported_book(tmp_path)


def test_a_charge_that_was_given_to_another_run_is_told_with_both(book: SmallBook) -> None:
    (charge,) = good(labbook("show", "r001", "--json", at=book.folder)).json["charges"]
    uid = charge["uid"]
    with book.open() as opened, opened.reading() as connection:
        numbers = read_numbers(opened.store.root, list_reports(connection)[0])
    leaves = {number.id: {leaf.input_uid for leaf in numbers.leaves_of(number)} for number in numbers.numbers.values()}
    number = min((number for number, of in leaves.items() if uid in of), key=lambda number: len(leaves[number]))

    def told() -> list[str]:
        lines = good(labbook("why", number, at=book.folder)).out.splitlines()
        return [line for line in lines if "corrected after" in line]

    assert not told()
    for words, change in (
        (("correct", f"charge:{uid}", "run=none"), "run r001 to none"),
        (("assign", f"{SHEET}#1", "r001"), None),
        (("assign", f"{SHEET}#2", "none"), None),
        (("correct", f"charge:{uid}", "run=r002"), "run r001 to r002"),
    ):
        good(labbook(*words, *WHY, at=book.folder))
        if change is None:
            assert not told()
        else:
            says(told(), change)
