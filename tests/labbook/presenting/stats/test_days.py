"""What `labbook stats` says of groups that share few days: what cannot be told, how often tests err, what helps."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.analysis.observations import Observation, Observations
from labbook.presenting.stats.days import day_left_out, day_notes, one_day_groups, with_confounding
from tests.helpers.wording import says

PAIR = ("1", "0")


def of_table(rows: str, by: str = "gain") -> Observations:
    """A table of letters for groups and days: "0a 0a 1b"."""
    cells = tuple(Observation(float(place), row[0], row[1:]) for place, row in enumerate(rows.split()))
    return Observations("table.csv", "height", "m", by, "0", cells)


def repeated(groups: dict[str, str], runs: int) -> Observations:
    """A table of groups by their days, so many values of each."""
    return of_table(" ".join(f"{label}{day}" for label, days in groups.items() for day in days for _ in range(runs)))


def test_what_a_p_on_two_groups_cannot_tell_follows_its_sentence() -> None:
    table = of_table("0a 0a 1b 1b 2a 2a")
    confounded = one_day_groups(table, PAIR)
    text = with_confounding("They differ.", confounded)
    says(text, "1", "0", "not the same")
    assert text.endswith("between their days.")
    assert with_confounding("They differ.", "") == "They differ."
    assert one_day_groups(table, ("2", "0")) == ""
    assert one_day_groups(of_table("0 0 1 1"), PAIR) == ""  # no column of days
    assert one_day_groups(of_table("0a 0a 1b 1b", by="day"), PAIR) == ""  # days are what is compared
    assert one_day_groups(of_table("00 00 11 11"), PAIR) == ""
    missing = replace(table, rows=(*table.rows, Observation(None, "1", "a")))
    assert one_day_groups(missing, PAIR) == confounded


def test_of_all_pairs_those_groups_are_named_that_had_one_day() -> None:
    says(one_day_groups(of_table("0a 0a 1b 1b 2a 2a")), "gain 0", "gain 1", "gain 2", "one day each")
    says(one_day_groups(of_table("0a 0c 1b 1b 2a 2a")), "gain 1", "gain 2", "one day each")
    assert one_day_groups(of_table("0a 0c 1b 1b 2b 2b")) == ""


@pytest.mark.parametrize(
    ("days", "said"),
    [
        (
            {"0": "ab", "1": "cd"},
            ("share 0 of 4 days", "2 days of its own", "`labbook stats blocked` has the day in its"),
        ),
        ({"0": "ab", "1": "ac"}, ("share 1 of 3 days", "days of which all groups share one", "blocked` has the day")),
        (
            {"0": "a", "1": "b"},
            ("share 0 of 2 days", "a day of its own", "Measuring the groups on shared days is what"),
        ),
        ({"0": "a", "1": "b", "2": "cd"}, ("gain 2 and gain 0 share 0 of 3 days", "blocked` has the day in its model")),
    ],
)
def test_how_often_welchs_test_errs_is_looked_up_by_how_days_are_shared(
    days: dict[str, str], said: tuple[str, ...]
) -> None:
    (note,) = day_notes(repeated(days, 5))
    assert all(part in note for part in said)
    says(note, "0.05 found")


def test_on_shared_days_or_with_the_day_in_the_model_there_is_no_such_note() -> None:
    assert day_notes(repeated({"0": "ab", "1": "ab"}, 5)) == []
    assert day_notes(repeated({"0": "ab", "1": "ac"}, 5), by_day=True) == []
    (note,) = day_notes(repeated({"0": "ab", "1": "cd"}, 5), by_day=True)
    says(note, "little is known")


def test_days_that_are_all_shared_but_held_in_unequal_parts_are_called_so() -> None:
    (note,) = day_notes(of_table("0a 0a 0a 0a 0a 0a 0b 0b 1a 1b 1b 1b 1b 1b 1b 1b"))
    says(note, "1", "0 hold")
    assert "share 2 of" not in note


@pytest.mark.parametrize(
    ("few", "many", "spreads", "of"),
    [(3, 10, "3 and 10 values, should standard deviations be ", "of the second group"),
     (5, 5, "5 and 5 values, each group on", "within a group")],
)  # fmt: skip
def test_a_share_of_studies_is_told_with_the_standard_deviations_that_it_was_simulated_with(
    few: int, many: int, spreads: str, of: str
) -> None:
    (note,) = day_notes(of_table(" ".join(["0a"] * many + ["1b"] * few)))
    assert f"Simulated with {spreads}" in note
    says(note, "differing as much", of, "test at alpha", "0.05")
    assert "that within" not in note


LITTLE = "only days that are shared tell the groups from their days, so that little is known here."
OTHERS = "days of other groups join theirs, so that their difference rests on the values of those groups as well."


@pytest.mark.parametrize(
    ("days", "said"),
    [
        ({"0": "a", "1": "abc", "2": "bc"}, [f"gain 2 and gain 0 share 0 of 3 days: {OTHERS}"]),
        ({"0": "a", "1": "ab", "2": "bc", "3": "cd"}, [
            f"gain 2 and gain 0 share 0 of 3 days; gain 3 and gain 0 share 0 of 3 days: {OTHERS}"
        ]),
        ({"0": "ab", "1": "bc", "2": "de", "3": "ce"}, [
            f"gain 2 and gain 0 share 0 of 4 days; gain 3 and gain 0 share 0 of 4 days: {OTHERS}"
        ]),
        ({"0": "abc", "1": "cde", "2": "fg"}, [
            f"gain 1 and gain 0 share 1 of 5 days; gain 2 and gain 0 share 0 of 5 days: {LITTLE}"
        ]),
        ({"0": "a", "1": "ab", "2": "b", "3": "c"}, [
            f"gain 3 and gain 0 share 0 of 2 days: {LITTLE}", f"gain 2 and gain 0 share 0 of 2 days: {OTHERS}"
        ]),
        # Three groups share one day, and the third has it only, or another of its own: that tells nothing of the two.
        ({"0": "abc", "1": "cde", "2": "c"}, [f"gain 1 and gain 0 share 1 of 5 days: {LITTLE}"]),
        ({"0": "abc", "1": "cde", "2": "cf"}, [f"gain 1 and gain 0 share 1 of 5 days: {LITTLE}"]),
        # It has one with gain 1, which tells gain 1 from it, and it from the control.
        ({"0": "abc", "1": "cde", "2": "cd"}, [f"gain 1 and gain 0 share 1 of 5 days: {OTHERS}"]),
    ],
)  # fmt: skip
def test_with_the_day_in_the_model_other_groups_join_days(days: dict[str, str], said: list[str]) -> None:
    assert day_notes(repeated(days, 3), by_day=True) == said


def test_tests_without_the_day_say_so_once() -> None:
    shared = repeated({"0": "ab", "1": "ab"}, 5)
    (note,) = day_left_out(shared, "day")
    says(note, "labbook stats blocked")
    assert day_left_out(shared, None) == []  # of a book, whose report compares by day
    assert day_left_out(repeated({"0": "a", "1": "a"}, 5), "day") == []
    assert day_left_out(repeated({"0": "ab", "1": "cd"}, 5), "day") == []  # `day_notes` says it
    assert day_left_out(of_table("0a 0b 1a 1b", by="day"), "day") == []
