"""`labbook power --test`: the power of an n, the n of a power, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from stats.planning.power import power_anova, power_equivalence, power_t, power_welch
from stats.results import as_dict
from tests.cli.shell import good, labbook, refused
from tests.helpers.wording import says


def named(words: Sequence[str]) -> list[str]:
    """Student's t where no test is named."""
    return [*words] if "--test" in words else ["--test", "t", *words]


def plan(tmp_path: Path, *words: str) -> Any:
    return good(labbook("power", *named(words), "--json", at=tmp_path)).json["plan"]


def test_the_power_of_so_many_values(tmp_path: Path) -> None:
    sd = ("--sd", "1.2")
    expected = {
        ("--difference", "1.5", *sd, "--n", "10"): power_t(1.5, 1.2, 10, 10),
        ("--difference", "1.5", *sd, "--n", "10", "--n", "5", "--one-sided"): power_t(1.5, 1.2, 10, 5, sides=1),
        ("--test", "welch", "--difference", "1.5", *sd, "--sd", "2", "--n", "10"): power_welch(1.5, 1.2, 2, 10, 10),
        ("--test", "anova", "--mean", "1", "--mean", "2", "--mean", "4", *sd, "--n", "4"): power_anova(
            [1, 2, 4], 1.2, 4
        ),
        ("--test", "tost", "--low", "-5", "--high", "4", *sd, "--n", "3", "--alpha", "0.01"): power_equivalence(
            1.2, -5, 4, 3, 3, alpha=0.01
        ),
    }
    for words, right in expected.items():
        assert plan(tmp_path, *words) == {**as_dict(right), "group_ns": list(right.group_ns)}


def test_the_smallest_n_that_reaches_the_power(tmp_path: Path) -> None:
    found = plan(tmp_path, "--difference", "1.5", "--sd", "1.2", "--power", "0.9")
    n, _same = found["group_ns"]
    assert found["power"] >= 0.9
    assert power_t(1.5, 1.2, n - 1, n - 1).power < 0.9  # type: ignore[operator]
    shown = good(labbook("power", "--test", "t", "--difference", "1.5", "--sd", "1.2", at=tmp_path)).out
    says(shown, "12", "Student's t-test for", "1.5", "1.2")


def test_bounds_in_percent_are_of_a_mean_that_the_study_estimates(tmp_path: Path) -> None:
    words = ("--test", "tost", "--low", "-3", "--high", "3", "--percent", "--mean", "0.3", "--sd", "0.0075")
    found = plan(tmp_path, *words, "--n", "6", "--n", "8")
    right = power_equivalence(0.0075, -3, 3, 6, 8, control_mean=0.3)
    assert found == {**as_dict(right), "group_ns": [6, 8]}
    says(found["test"], "itself estimated and", "0.3")
    shown = good(labbook("power", *named(words), at=tmp_path)).out
    says(shown, "equivalence test")


def test_what_no_n_reaches_and_what_has_no_power_is_undefined(tmp_path: Path) -> None:
    words = ("--test", "tost", "--low", "-1", "--high", "1", "--difference", "2", "--sd", "1")
    never = good(labbook("power", *named(words), "--json", at=tmp_path)).json
    assert never["plan"] is None
    says(never["plan_reason"], "2 does", "-1")
    shown = good(labbook("power", *named(words), at=tmp_path)).out
    says(shown, "No n was", "80 %", never["plan_reason"])
    tost = ("--test", "tost", "--low", "-1", "--high", "1", "--sd", "1", "--n", "8")
    says(good(labbook("power", *named(tost), at=tmp_path)).out, "equivalence test")
    single = ("--difference", "1", "--sd", "1", "--n", "1")
    says(good(labbook("power", *named(single), at=tmp_path)).out, "1", "too few values")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--sd", "1"], "needs --difference"),
        (["--difference", "1"], "needs --sd"),
        (["--difference", "1", "--sd", "1", "--sd", "2"], "--sd is given 2 times"),
        (["--difference", "1", "--sd", "1", "--n", "5", "--power", "0.9"], "give one of the two"),
        (["--test", "anova", "--sd", "1", "--difference", "1"], "has no use for --difference"),
        (["--test", "tost", "--sd", "1", "--low", "1"], "needs --high"),
        (["--test", "tost", "--sd", "1", "--low=-3", "--high", "3", "--percent"], "needs --mean"),
        (["--test", "tost", "--sd", "1", "--low=-3", "--high", "3", "--mean", "1"], "add --percent"),
        (["--difference", "1", "--sd", "1", "--percent"], "has no use for --percent"),
        (["--test", "welsh"], "did you mean 'welch'?"),
        (["--difference", "1", "--sd", "0"], "sd is 0.0"),
        (["--difference", "1", "--sd", "1", "--power", "2"], "power is 2.0"),
    ],
)
def test_refused_with_a_sentence(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("power", *named(words), at=tmp_path), 2, said)
