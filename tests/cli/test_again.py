"""A command given again after it has taken effect, as after a lost connection: done, and nothing is stated twice."""

from __future__ import annotations

import pytest

from tests.cli.shell import good, labbook, rows, unchanged
from tests.helpers.books import SmallBook

AGAIN = {
    "init": ("init . --as AN", "is a book already"),
    "void": ("void r003 --reason fell", "r003 is void already"),
    "correct": ("correct r002 foot=large --why typed", "says that already"),
    "correct charge": ("correct r002 mah=700 --why typed", "says that already"),
    "assign": ("assign r001.csv r002 --why wrong", "belongs to run r002 already"),
    "assign to none": ("assign r001.csv none --why wrong", "belongs to no run"),
    "assign a charge to none": ("assign 2021-06-14.csv#1 none --why wrong", "belongs to no run"),
    "reject": ("jumps reject r001 1-2 --reason misfire --note saw", "says nothing new"),
    "accept": ("jumps accept r001 1", "says nothing new"),
    "clear": ("jumps clear r001 1", "says nothing new"),
    "withdraw": ("files withdraw r001.csv --why other", "withdrawn already"),
}


@pytest.mark.parametrize("name", AGAIN)
def test_what_has_taken_effect_is_not_stated_again(name: str, whole: SmallBook) -> None:
    command, said = AGAIN[name]
    if name == "clear":
        good(labbook("jumps", "reject", "r001", "1", "--reason", "misfire", at=whole.folder))
    first = good(labbook(*command.split(), at=whole.folder))
    assert name == "init" or said not in first.out
    with unchanged(whole.folder):
        assert said in good(labbook(*command.split(), at=whole.folder)).out
        again = good(labbook(*command.split(), *(["--json"]), at=whole.folder)).json
    assert "error" not in again


def test_a_verdict_that_says_more_is_stated(whole: SmallBook) -> None:
    before = rows(whole.folder, "SELECT count(*) FROM decision")[0][0]
    for words in ("1 --reason misfire", "1-2 --reason misfire", "1-2 --reason misfire --note seen"):
        good(labbook("jumps", "reject", "r001", *words.split(), at=whole.folder))
    assert rows(whole.folder, "SELECT count(*) FROM decision")[0][0] == before + 1 + 1 + 2


def test_a_second_note_is_a_second_one(whole: SmallBook) -> None:
    for _time in range(2):
        good(labbook("note", "r001", "squeaks", at=whole.folder))
    assert rows(whole.folder, "SELECT count(*) FROM note WHERE text = 'squeaks'") == [(2,)]
