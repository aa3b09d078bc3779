"""`labbook stats` tells a departure from the plan once: as the reason why a comparison is exploratory, or after it."""

from __future__ import annotations

import pytest

from labbook.actions.runs.correcting import void
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, SmallBook
from tests.helpers.decided import decided_book

DECIDED = '\n[analysis]\nexclusions = ["misfire"]\napex_bounds_percent = [-3, 3]\n'
COMMANDS = ("compare", "--pooled"), ("equivalence", "--pooled", "--quantity", "apex")
PARTED, WHOLE = "he selection leaves out run r002 of the condition", "he selection leaves out 2 conditions whole"
VOID = "un r006 is void (foot came loose)"


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """A book whose analysis was decided before everything was ingested."""
    return decided_book(tmp_path_factory.mktemp("honest"), DECIDED)


@pytest.fixture(scope="module")
def left_out(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """The same, of which a run was left out for a reason that was not allowed."""
    made = decided_book(tmp_path_factory.mktemp("left_out"), DECIDED)
    with made.open() as book, book.session(ADA) as session:
        void(session, "r006", "foot came loose")
    return made


def notes(book: SmallBook, words: tuple[str, ...], where: str) -> list[str]:
    found: list[str] = good(labbook("stats", *words, "--where", where, "--json", at=book.folder)).json["notes"]
    return found


@pytest.mark.parametrize("words", COMMANDS)
def test_of_an_exploratory_comparison_the_reason_tells_it(honest: SmallBook, words: tuple[str, ...]) -> None:
    said = notes(honest, words, "foot=small and run!=r002")
    assert [PARTED in note for note in said if note.startswith("Exploratory: ")] == [True]
    assert "\n".join(said).count(PARTED) == 1
    assert "\n".join(said).count(WHOLE) == 1


@pytest.mark.parametrize("words", COMMANDS)
def test_of_a_planned_comparison_it_is_told_alone(honest: SmallBook, words: tuple[str, ...]) -> None:
    said = notes(honest, words, "foot=small")
    assert [WHOLE in note for note in said if note.startswith("As decided ")] == [False]
    assert "\n".join(said).count(WHOLE) == 1


@pytest.mark.parametrize("words", COMMANDS)
def test_what_the_reason_does_not_name_is_told_after_it(left_out: SmallBook, words: tuple[str, ...]) -> None:
    """A run left out for a reason that was not allowed is the reason alone, whatever else the comparison rests on."""
    said = notes(left_out, words, "foot=small and run!=r002")
    assert [VOID in note for note in said if note.startswith("Exploratory: ")] == [True]
    assert "\n".join(said).count("foot came loose") == 1
    assert [PARTED in note for note in said].count(True) == 1
