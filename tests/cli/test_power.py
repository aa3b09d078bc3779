"""`labbook power` from the command line: it prints, and touches nothing."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

POWER = ("power", "--saving", "10", "--sd", "4", "--mean", "42")


def test_it_says_what_is_needed_and_writes_nothing(fresh: SmallBook) -> None:
    with unchanged(fresh.folder):
        shown = good(labbook(*POWER, at=fresh.folder)).out
        data = good(labbook(*POWER, "--json", at=fresh.folder)).json
    lines = shown.splitlines()
    says(lines[0], "4.2 J", "joules a jump", "10 %", "42 J")
    (first,) = [line.split() for line in lines if line.startswith("by shared days  ")]
    assert str(data["needed"][0]["n"]) in first
    says(shown, "4.2", "0.05")
    assert data["difference"] == pytest.approx(4.2)


def test_the_runs_of_the_days_of_a_drawn_plan_are_counted(fresh: SmallBook) -> None:
    """It said "n = 11 and 55, the test by 12 shared days": eleven controls are not on twelve days."""
    out = good(labbook(*POWER, at=fresh.folder)).out
    counts = re.findall(r"With n = (\d+) and \d+, the .*? by (\d+) shared days", out)
    assert counts
    assert all(int(controls) >= int(days) for controls, days in counts)


def test_where_more_runs_find_less_both_powers_are_said_and_the_plan_says_the_same(fresh: SmallBook) -> None:
    words = ("power", "--difference", "1", "--sd", "1")
    said = good(labbook(*words, "--n", "12", at=fresh.folder)).out
    crossing = (
        "From n = 11 on, where 4 days are shared, the test is paired on day means: power 29.8 %, and 46.9 % at n = 10, "
        "within days, valid for the days measured only."
    )
    assert crossing in said.splitlines()
    (row,) = [line.split() for line in said.splitlines() if line.startswith("by shared days  ")]
    plan = ("plan", "--seed", "1", "--dry-run", "--out", "plan.csv", "--n")
    planned = good(labbook(*plan, "12", at=fresh.folder)).out
    says(planned, "standard deviation of", row[-2])
    assert crossing in planned.splitlines()
    (fresh.folder / "plan.csv").unlink()
    (fresh.folder / "plan.html").unlink()
    assert "From n = " not in good(labbook(*plan, "10", at=fresh.folder)).out
    needed = good(labbook(*words, "--power", "0.45", "--json", at=fresh.folder)).json["needed"][0]
    assert needed["n"] == 10
    few = good(labbook(*words, "--n", "4", "--power", "0.05", at=fresh.folder)).out
    assert "From n = " not in few


def test_json_holds_a_mean_or_why_there_is_none(fresh: SmallBook) -> None:
    words = ("power", "--difference", "4", "--sd", "4", "--json")
    without = good(labbook(*words, at=fresh.folder)).json["primary"]
    assert [*without["mean"]] == ["reason"]
    says(without["mean"]["reason"], "no control has", "--mean")
    given = good(labbook(*words, "--mean", "42", at=fresh.folder)).json["primary"]
    assert given == {"sd": 4.0, "mean": 42.0, "spread": None}


def test_a_mean_from_the_books_own_runs_stands_without_an_excuse(whole: SmallBook) -> None:
    data = good(labbook("power", "--difference", "4", "--sd", "4", "--json", at=whole.folder)).json
    assert data["primary"]["mean"] > 10.0
    assert "no control has" not in str(data["primary"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("power",), "add --saving 10 (percent of the control) or --difference 4"),
        ((*POWER, "--low", "3", "--alpha", "0.1"), "no use for --low and --alpha: leave that out, or name one test"),
        (("power", "--test", "t", "--saving", "3", "--idle"), "no use for --saving and --idle"),
        ((*POWER, "--sd", "5"), "--sd is given 2 times"),
        ((*POWER, "--method", "blockd"), "blocked"),
    ],
)
def test_options_that_do_not_go_together_are_refused(fresh: SmallBook, words: tuple[str, ...], said: str) -> None:
    with unchanged(fresh.folder):
        refused(labbook(*words, at=fresh.folder), 2, said)


def test_a_column_may_be_called_power(tmp_path: Path) -> None:
    rows = [f"{name},{value}" for name, value in zip("aaabbb", (1, 2, 3, 2, 4, 6), strict=True)]
    (tmp_path / "t.csv").write_text("\n".join(["controller,power", *rows]))
    said = good(labbook("stats", "compare", "t.csv", "--value", "power", "--by", "controller", at=tmp_path)).out
    assert "Welch" in said
