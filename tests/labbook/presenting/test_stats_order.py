"""The order in which a comparison over days tells its groups; its numbers stay as they are."""

from __future__ import annotations

from labbook.presenting.stats_order import in_order
from stats.blocked import blocked_by_day
from stats.blocked_result import BlockedByDay, ExactTest

NAMES = ["gain 1", "gain 2", "gain 9", "gain 10", "gain 10, old"]


def by_day(days_of: dict[str, str]) -> BlockedByDay:
    rows = [
        (place + 0.3 * turn + (0.1 if day > "b" else 0.0) + 0.01 * (place * turn) ** 2, name, day)
        for place, name in enumerate(NAMES)
        for day in days_of[name]
        for turn in range(2)
    ]
    values, conditions, days = zip(*rows, strict=True)
    return blocked_by_day(values, conditions, days, control=NAMES[0])


def test_means_and_differences_follow_the_names_and_keep_their_numbers() -> None:
    found = by_day(dict.fromkeys(NAMES, "abc"))
    assert [mean.condition for mean in found.conditions] != NAMES
    told = in_order(found, NAMES)
    assert [mean.condition for mean in told.conditions] == NAMES
    assert [one.condition for one in told.contrasts] == NAMES[1:]
    assert isinstance(told.exact, ExactTest)
    assert isinstance(found.exact, ExactTest)
    assert [one.condition for one in told.exact.contrasts] == NAMES[1:]
    assert {*told.conditions} == {*found.conditions}
    assert {*told.contrasts} == {*found.contrasts}
    assert {*told.exact.contrasts} == {*found.exact.contrasts}
    assert (told.f, told.p, told.lmertest_p) == (found.f, found.p, found.lmertest_p)


def test_a_list_of_conditions_without_shared_days_follows_the_names() -> None:
    days_of = dict(zip(NAMES, ("ab", "ab", "cd", "cd", "ab"), strict=True))
    text = in_order(by_day(days_of), NAMES).confounding
    assert "no day joins" in text
    assert "with gain 9, gain 10, so that" in text


def test_a_list_that_cannot_be_told_apart_stays_as_it_is() -> None:
    found = by_day(dict(zip(NAMES, ("ab", "ab", "cd", "cd", "ab"), strict=True)))
    assert "no day joins gain 1, gain 10, old, gain 2 with" in found.confounding
    assert "no day joins gain 1, gain 10, old, gain 2 with" in in_order(found, NAMES).confounding
