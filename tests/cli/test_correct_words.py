"""`labbook correct` in the words of the run sheet, which were refused as unknown fields."""

from __future__ import annotations

import re
import shlex

import pytest

from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

RUN = (
    "SELECT day.date_local, started_utc, duration_s, jumps_made, position_in_day FROM run JOIN day ON run.day = day.id"
)


def correct(book: SmallBook, target: str, *fields: str) -> dict[str, list[object]]:
    done: dict[str, list[object]] = good(
        labbook("correct", target, *fields, "--why", "misread", "--json", at=book.folder)
    ).json["changed"]
    return done


def facts(book: SmallBook, run: str) -> tuple[object, ...]:
    (found,) = rows(book.folder, f"{RUN} WHERE name = '{run}'")
    return found


def test_words_of_the_sheet_stand_for_their_columns(whole: SmallBook) -> None:
    day, started, duration_s, _jumps, _position = facts(whole, "r001")
    assert str(started).startswith(f"{day}T13:30")  # 9:30 by the lab's clock, in New York
    correct(whole, "r001", "started=09:20", "minutes=12,5", "jumps=4", "position=20")
    assert duration_s != 750.0
    assert facts(whole, "r001") == (day, f"{day}T13:20:00Z", 750.0, 4, 20)


def test_a_new_date_takes_the_start_along(whole: SmallBook) -> None:
    _day, started, *rest = facts(whole, "r001")
    correct(whole, "r001", "date=5.6.2021", "position=1")
    assert facts(whole, "r001") == ("2021-06-05", f"2021-06-05{str(started)[10:]}", *rest)
    correct(whole, "r001", "date=2021-06-07", "started=10:00")
    assert facts(whole, "r001")[:2] == ("2021-06-07", "2021-06-07T14:00:00Z")


def test_mah_is_the_charge_of_a_run(whole: SmallBook) -> None:
    changed = correct(whole, "r001", "mah=812,5")
    assert changed["charge_mah"][1] == 812.5
    (charge,) = good(labbook("show", "r001", "--json", at=whole.folder)).json["charges"]
    assert charge["charge_mah"] == 812.5
    assert correct(whole, f"charge:{charge['uid']}", "mah=800")["charge_mah"] == [812.5, 800.0]


def test_a_second_charge_is_refused_with_commands_that_are_taken(whole: SmallBook) -> None:
    """They lacked the reason that a correction needs."""
    good(labbook("assign", "2021-06-14.csv#4", "none", "--why", "mixed up", at=whole.folder))
    good(labbook("charge", "r004", "100", at=whole.folder))
    answer = labbook("charge", "r004", "130", at=whole.folder)
    refused(answer, 2, "a charge already", "100 mAh")
    ways_out = re.findall(r"`labbook (correct [^`]+)`", answer.err)
    assert len(ways_out) == 2
    for command in ways_out:
        words = shlex.split(command.replace("VALUE", "130").replace("...", "misread"))
        good(labbook(*words, at=whole.folder))
    good(labbook("charge", "r004", "130", at=whole.folder))


def test_the_old_value_is_shown_and_what_becomes_of_the_runs_joules(whole: SmallBook) -> None:
    """It said "r002: mah=812." and no more."""
    lines = good(labbook("correct", "r002", "mah=812", "--why", "misread", at=whole.folder)).out.splitlines()
    says(lines, "changed", "charge_mah", "105 to 812")
    says(lines, "run r002", "J a jump")
    told = good(labbook("correct", "r002", "foot=large", "--why", "typed", at=whole.folder)).out.splitlines()
    says(told, "changed", "foot=small", "to foot=large")
    assert "J a jump" not in good(labbook("correct", "r002", "starts=2", "--why", "x", at=whole.folder)).out


def test_a_number_of_jumps_is_set_beside_those_in_the_log(whole: SmallBook) -> None:
    """`jumps=0` was taken in silence for a run whose log shows jumps."""
    for made in ("0", "500"):
        out = good(labbook("correct", "r001", f"jumps={made}", "--why", "misread", at=whole.folder)).out
        says(out, f"of {made} jumps found")
    out = good(labbook("correct", "r001", "minutes=11", "--why", "misread", at=whole.folder)).out
    assert "jumps found" not in out


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        (("startd=09:20",), ["'startd' is not a known field of a run", "'started'"]),
        (("jumps=4", "jumps_made=5"), ["jumps_made is given twice"]),
        (("date=03/04/2021",), ["does not say whether the day or the month comes first", "year-month-day"]),
        (("started=25:00",), ["is not a time of day"]),
        (("minutes=soon",), ["is not a number of minutes"]),
        (("mah=much",), ["is not a number"]),
    ],
)
def test_what_is_not_understood_is_refused_with_what_is(
    whole: SmallBook, fields: tuple[str, ...], said: list[str]
) -> None:
    with unchanged(whole.folder):
        refused(labbook("correct", "r001", *fields, "--why", "x", at=whole.folder), 2, *said)


def test_a_run_without_charge_is_told_how_to_state_one(stated: SmallBook) -> None:
    refused(labbook("correct", "r001", "mah=812", "--why", "x", at=stated.folder), 2, "`labbook charge r001 MAH`")


def test_a_start_that_clocks_show_twice_needs_its_offset(whole: SmallBook) -> None:
    date = ["correct", "r001", "date=2021-11-07", "--why", "misread"]
    with unchanged(whole.folder):
        refused(labbook(*date, "started=01:30", at=whole.folder), 2, "show twice", "01:30-04:00 or 01:30-05:00")
    good(labbook(*date, "started=01:30-05:00", at=whole.folder))
    assert facts(whole, "r001")[1] == "2021-11-07T06:30:00Z"
