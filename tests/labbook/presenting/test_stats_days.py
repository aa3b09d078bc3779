"""What `labbook stats` says of groups that share few days: what cannot be told, how often tests err, what helps."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.analysis.observations import Observation, Observations
from labbook.presenting.stats_days import day_notes, days_untold, with_days_said

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
    untold = days_untold(table, PAIR)
    text = with_days_said("They differ.", untold)
    assert text.startswith("They differ. gain 1 and gain 0 were measured on one day each, and not the same one, so")
    assert text.endswith("between their days.")
    assert with_days_said("They differ.", "") == "They differ."
    assert days_untold(table, ("2", "0")) == ""
    assert days_untold(of_table("0 0 1 1"), PAIR) == ""  # no column of days
    assert days_untold(of_table("0a 0a 1b 1b", by="day"), PAIR) == ""  # days are what is compared
    assert days_untold(of_table("00 00 11 11"), PAIR) == ""
    missing = replace(table, rows=(*table.rows, Observation(None, "1", "a")))
    assert days_untold(missing, PAIR) == untold


def test_of_all_pairs_those_groups_are_named_that_had_one_day() -> None:
    assert days_untold(of_table("0a 0a 1b 1b 2a 2a")).startswith(
        "gain 0, gain 1 and gain 2 were measured on one day each"
    )
    assert days_untold(of_table("0a 0c 1b 1b 2a 2a")).startswith("gain 1 and gain 2 were measured on one day each")
    assert days_untold(of_table("0a 0c 1b 1b 2b 2b")) == ""


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
    assert "Welch's test at alpha = 0.05 found a difference that is not there in" in note


def test_on_shared_days_or_with_the_day_in_the_model_there_is_no_such_note() -> None:
    assert day_notes(repeated({"0": "ab", "1": "ab"}, 5)) == []
    assert day_notes(repeated({"0": "ab", "1": "ac"}, 5), by_day=True) == []
    (note,) = day_notes(repeated({"0": "ab", "1": "cd"}, 5), by_day=True)
    assert "so that little is known here" in note


def test_days_that_are_all_shared_but_held_in_unequal_parts_are_called_so() -> None:
    (note,) = day_notes(of_table("0a 0a 0a 0a 0a 0a 0b 0b 1a 1b 1b 1b 1b 1b 1b 1b"))
    assert note.startswith("gain 1 and gain 0 hold the days that they share in unequal parts: ")
    assert "share 2 of 2" not in note
