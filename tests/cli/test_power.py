"""`labbook power`: of a study, and of a named test; it prints, and touches nothing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from stats.planning.power import power_anova, power_equivalence, power_t, power_welch
from stats.results import as_dict
from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

POWER = ("power", "--saving", "10", "--sd", "4", "--mean", "42")


def test_it_says_what_is_needed_and_writes_nothing(fresh: SmallBook) -> None:
    with unchanged(fresh.folder):
        shown = good(labbook(*POWER, at=fresh.folder)).out
        data = good(labbook(*POWER, "--json", at=fresh.folder)).json
    says(shown, "4.2 J", "joules a jump", "10 %", "42 J")
    says(shown, "by shared days  ", f" {data['needed'][0]['n']} ")
    assert data["difference"] == pytest.approx(4.2)
    # It said "n = 11 and 55, the test by 12 shared days": eleven controls are not on twelve days.
    counts = re.findall(r"With n = (\d+) and \d+, the .*? by (\d+) shared days", shown)
    assert counts
    assert all(int(controls) >= int(days) for controls, days in counts)


def test_where_more_runs_find_less_both_powers_are_said_and_the_plan_says_the_same(fresh: SmallBook) -> None:
    words = ("power", "--difference", "1", "--sd", "1")
    said = good(labbook(*words, "--n", "12", at=fresh.folder)).out
    crossing = says(said, "From n = 11 on", "4 days", "on day means", "29.8 %", "46.9 % at n = 10", "within days")
    (row,) = [line.split() for line in said.splitlines() if line.startswith("by shared days  ")]
    plan = ("plan", "--seed", "1", "--dry-run", "--out")
    planned = good(labbook(*plan, "plan.csv", "--n", "12", at=fresh.folder)).out
    says(planned, "standard deviation of", row[-2])
    assert crossing in planned.splitlines()
    assert "From n = " not in good(labbook(*plan, "few.csv", "--n", "10", at=fresh.folder)).out
    assert good(labbook(*words, "--power", "0.45", "--json", at=fresh.folder)).json["needed"][0]["n"] == 10
    assert "From n = " not in good(labbook(*words, "--n", "4", "--power", "0.05", at=fresh.folder)).out


def test_json_holds_a_mean_or_why_there_is_none(fresh: SmallBook) -> None:
    words = ("power", "--difference", "4", "--sd", "4", "--json")
    lacking = good(labbook(*words, at=fresh.folder)).json["primary"]["mean"]
    assert [*lacking] == ["reason"]
    says(lacking["reason"], "no control has", "--mean")
    given = good(labbook(*words, "--mean", "42", at=fresh.folder)).json["primary"]
    assert given == {"sd": 4.0, "mean": 42.0, "spread": None}


def test_a_mean_is_that_of_the_books_own_runs(whole: SmallBook) -> None:
    data = good(labbook("power", "--difference", "4", "--sd", "4", "--json", at=whole.folder)).json
    assert data["primary"]["mean"] > 10.0


def plan_of(tmp_path: Path, words: str) -> Any:
    return good(labbook("power", "--test", *words.split(), "--json", at=tmp_path)).json["plan"]


def test_the_power_of_so_many_values_is_that_of_stats(tmp_path: Path) -> None:
    percent = "--percent --mean 0.3"
    for words, right in (
        ("t --sd 1.2 --difference 1.5 --n 10", power_t(1.5, 1.2, 10, 10)),
        ("t --sd 1.2 --difference 1.5 --n 10 --n 5 --one-sided", power_t(1.5, 1.2, 10, 5, sides=1)),
        ("welch --sd 1.2 --difference 1.5 --sd 2 --n 10", power_welch(1.5, 1.2, 2, 10, 10)),
        ("anova --sd 1.2 --mean 1 --mean 2 --mean 4 --n 4", power_anova([1, 2, 4], 1.2, 4)),
        ("tost --sd 1.2 --low -5 --high 4 --n 3 --alpha 0.01", power_equivalence(1.2, -5, 4, 3, 3, alpha=0.01)),
        (
            f"tost --sd 0.0075 --low -3 --high 3 {percent} --n 6 --n 8",
            power_equivalence(0.0075, -3, 3, 6, 8, control_mean=0.3),
        ),
    ):
        assert plan_of(tmp_path, words) == {**as_dict(right), "group_ns": list(right.group_ns)}


def test_the_smallest_n_that_reaches_the_power(tmp_path: Path) -> None:
    found = plan_of(tmp_path, "t --difference 1.5 --sd 1.2 --power 0.9")
    n, _same = found["group_ns"]
    assert found["power"] >= 0.9
    assert power_t(1.5, 1.2, n - 1, n - 1).power < 0.9  # type: ignore[operator]
    shown = good(labbook("power", "--test", "t", "--difference", "1.5", "--sd", "1.2", at=tmp_path)).out
    says(shown, "12", "Student's t-test for", "1.5", "1.2")


def test_what_no_n_reaches_and_what_has_no_power_is_undefined(tmp_path: Path) -> None:
    words = ["power", "--test", "tost", "--low", "-1", "--high", "1", "--difference", "2", "--sd", "1"]
    never = good(labbook(*words, "--json", at=tmp_path)).json
    assert never["plan"] is None
    says(never["plan_reason"], "2 does", "-1")
    says(good(labbook(*words, at=tmp_path)).out, "No n was", "80 %", never["plan_reason"])
    single = ["power", "--test", "t", "--difference", "1", "--sd", "1", "--n", "1"]
    says(good(labbook(*single, at=tmp_path)).out, "1", "too few values")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "add --saving 10 (percent of the control) or --difference 4"),
        ("--saving 10 --sd 4 --mean 42 --low 3 --alpha 0.1", "no use for --low and --alpha: leave that out"),
        ("--saving 10 --sd 4 --sd 5 --mean 42", "--sd is given 2 times"),
        ("--saving 10 --sd 4 --mean 42 --method blockd", "blocked"),
        ("--test t --saving 3 --idle", "no use for --saving and --idle"),
        ("--test t --sd 1", "needs --difference"),
        ("--test t --difference 1", "needs --sd"),
        ("--test t --difference 1 --sd 1 --n 5 --power 0.9", "give one of the two"),
        ("--test anova --sd 1 --difference 1", "has no use for --difference"),
        ("--test tost --sd 1 --low 1", "needs --high"),
        ("--test tost --sd 1 --low=-3 --high 3 --percent", "needs --mean"),
        ("--test tost --sd 1 --low=-3 --high 3 --mean 1", "add --percent"),
        ("--test t --difference 1 --sd 1 --percent", "has no use for --percent"),
        ("--test welsh", "did you mean 'welch'?"),
        ("--test t --difference 1 --sd 1 --power 2", "power is 2.0"),
    ],
)
def test_options_that_do_not_go_together_are_refused(fresh: SmallBook, words: str, said: str) -> None:
    refused(labbook("power", *words.split(), at=fresh.folder), 2, said)
