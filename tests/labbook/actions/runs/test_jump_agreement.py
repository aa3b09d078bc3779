"""How two people agree: each one's last verdict, whoever's counts, and only on jumps on which both gave one."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from data_schema.vocabulary import Undefined
from labbook.actions.runs.jump_review import Agreement, agreement, decide, review
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.statements import state
from tests.helpers.upkeep import rebuilt_alike

SAID = {
    ("r001", 1): ("accept", "accept"),
    ("r001", 2): ("accept", "reject"),
    ("r001", 3): ("reject", "reject"),
    ("r002", 1): ("accept", "accept"),
    ("r002", 2): ("reject", "accept"),
    ("r002", 3): ("accept", "accept"),
}
"""What Ada, and after her Ben, said of jumps."""


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    small = small_book(tmp_path, two_people=True)
    with small.open() as book:
        for person, place in ((ADA, 0), (BEN, 1)):
            for (run, number), verdicts in SAID.items():
                state(book, decide, run, [number], verdicts[place], "other", None, person=person, blind=run == "r001")
        state(book, decide, "r003", [1], "reject", "other", None, person=ADA)
    return small


def agreed(book: Book, people: tuple[str, str] | None = None, where: str | None = None) -> tuple[Agreement, ...]:
    with book.reading() as connection:
        return agreement(Detections(connection, book.store), book.configuration, people, where)


def test_the_last_verdict_counts_and_both_stay_in_the_agreement(made: SmallBook) -> None:
    with made.open() as book:
        with book.reading() as connection:
            counts = {item.jump.number: item.excluded is None for item in review(book, connection, "r001").jumps}
        assert {number: counts[number] for number in (1, 2, 3)} == {1: True, 2: False, 3: False}  # as Ben said
        (found,) = agreed(book)
        assert (found.first, found.second, found.both_blind) == (ADA, BEN, 3)
        assert found.kappa.answers == ("accept", "reject")
        assert found.kappa.counts == ((3, 1), (1, 1))
        assert found.kappa.kappa == pytest.approx((4 / 6 - 5 / 9) / (1 - 5 / 9))
        assert [(item.run, item.number) for item in found.differ] == [("r001", 2), ("r002", 2)]
        (other_way,) = agreed(book, (BEN, ADA))
        assert other_way.kappa.kappa == pytest.approx(found.kappa.kappa)
        (some,) = agreed(book, where="run=r002")
        assert (some.kappa.n, some.both_blind) == (3, 0)
    rebuilt_alike(made)
    with made.open() as book:
        assert agreed(book) == (found,)


def test_a_verdict_that_was_taken_back_is_none_and_a_later_one_stands_for_the_person(made: SmallBook) -> None:
    with made.open() as book:
        state(book, decide, "r001", [1], "clear", "other", None, person=BEN)
        state(book, decide, "r002", [2], "reject", "other", None, person=BEN)
        (found,) = agreed(book)
        assert found.kappa.counts == ((2, 1), (0, 2))
        assert [(item.run, item.number) for item in found.differ] == [("r001", 2)]


def test_people_who_share_no_jump_have_no_kappa(tmp_path: Path) -> None:
    with small_book(tmp_path, two_people=True).open() as book:
        state(book, decide, "r001", [1], "reject", "other", None, person=ADA)
        state(book, decide, "r001", [2], "reject", "other", None, person=BEN)
        assert agreed(book) == ()
        (found,) = agreed(book, (ADA, BEN))
        assert (found.kappa.n, found.differ) == (0, ())
        assert isinstance(found.kappa.kappa, Undefined)


def test_the_command_shows_it_and_names_are_as_the_book_has_them(made: SmallBook) -> None:
    found = good(labbook("jumps", "agreement", "BO", "Ada Nwosu", "--json", at=made.folder)).json[0]
    assert (found["first"], found["second"]) == (BEN, ADA)
    assert found["kappa"]["counts"] == [[3, 1], [1, 1]]
    assert found["kappa"]["kappa"] == pytest.approx(0.25)
    assert [(item["run"], item["number"]) for item in found["differ"]] == [("r001", 2), ("r002", 2)]
    text = good(labbook("jumps", "agreement", at=made.folder)).out
    assert "0.2" in text
    assert re.search(r"^r001 +2 ", text, re.MULTILINE)
    refused(labbook("jumps", "agreement", "AN", at=made.folder), 2, "AN")
    refused(labbook("jumps", "agreement", "AN", "Ada Nwosu", at=made.folder), 2, "AN")
    refused(labbook("jumps", "agreement", "AN", "Bo", at=made.folder), 2, "Bo")
