"""Contrasts of condition means on shared days: equal to R's lm, and to the deciding test where they are one effect."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from scipy import stats as scipy_stats

from data_schema.errors import InputRefused
from data_schema.vocabulary import Rule, Undefined
from stats.compare.shared_error import SharedError
from stats.days.contrasts import Effect, RunsOfCondition, linear_contrast
from stats.days.decision import blocks_of_runs, contrast_by_day

with (Path(__file__).parents[1] / "r" / "contrasts.csv").open() as rows:
    BY_R: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in csv.DictReader(rows):
        BY_R[row["design"]].append(row)


def condition(
    values: list[float], days: list[str], errors: list[SharedError] | None = None, name: str = "runs"
) -> RunsOfCondition:
    return blocks_of_runs(name, values, days, None, errors)


@pytest.mark.parametrize("design", BY_R)
def test_equal_to_lm(design: str) -> None:
    runs: dict[str, tuple[list[float], list[str]]] = defaultdict(lambda: ([], []))
    effects, expected = [], {}
    for row in BY_R[design]:
        value = float(row["value"])
        if row["what"] == "run":
            runs[row["condition"]][0].append(value)
            runs[row["condition"]][1].append(row["day"])
        elif row["what"] == "weight":
            effects.append(Effect(value, row["condition"], row["day"]))
        else:
            expected[row["what"]] = value
    conditions = {name: condition(*of, name=name) for name, of in runs.items()}
    found = linear_contrast(conditions, effects, percent=bool(expected.pop("percent"))).estimate
    assert isinstance(found.ci, tuple)
    got = {"value": found.value, "se": found.se, "df": found.df, "t": found.t, "p": found.p}
    got |= dict(zip(("low", "high"), found.ci, strict=True))
    assert got == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("days", [2, 5])
def test_one_effect_is_the_deciding_test(days: int) -> None:
    rng = np.random.default_rng(days)
    labels = [f"d{day}" for day in range(days)]
    of_control, of_treated = labels * 3, labels * 2
    control, treated = rng.normal(40.0, 2.0, 3 * days).tolist(), rng.normal(36.0, 1.0, 2 * days).tolist()
    drain = SharedError({("drain", "level"): 0.5}, {"drain": 6.0})
    errors_c, errors_t = [drain] * (3 * days), [drain.times(0.9)] * (2 * days)
    conditions = {"c": condition(control, of_control, errors_c), "t": condition(treated, of_treated, errors_t)}
    found = linear_contrast(conditions, [Effect(1.0, "t", "c")], percent=False)
    shared = {"shared_treated": errors_t, "shared_control": errors_c}
    decided = contrast_by_day(treated, control, days_treated=of_treated, days_control=of_control, **shared)
    expected = decided.difference()
    assert (found.rule, found.n) == (decided.rule, 5 * days)
    for name in ("value", "se", "shared_se", "t", "df", "p", "ci"):
        assert getattr(found.estimate, name) == pytest.approx(getattr(expected, name), rel=1e-10), name


def test_a_shared_control_enters_within_days_once() -> None:
    """The difference of two effects against one control has none of the control's scatter."""
    days = ["d"] * 5
    conditions = {
        "c": condition([10.0, 50.0, 90.0, 20.0, 30.0], days),
        "a": condition([1.0, 2.0, 3.0, 4.0, 5.0], days),
        "b": condition([2.0, 2.5, 3.5, 4.5, 6.0], days),
    }
    found = linear_contrast(conditions, [Effect(1.0, "b", "c"), Effect(-1.0, "a", "c")], percent=False).estimate
    welch = scipy_stats.ttest_ind([2.0, 2.5, 3.5, 4.5, 6.0], [1.0, 2.0, 3.0, 4.0, 5.0], equal_var=False)
    assert found.t == pytest.approx(welch.statistic, rel=1e-12)
    assert found.df == 4.0


def test_errors_in_common_cancel_in_an_interaction() -> None:
    days = [f"d{day}" for day in range(5)]
    rng = np.random.default_rng(8)
    drain = [SharedError({("drain", "level"): 1.0}, {"drain": 6.0})] * 5
    conditions = {
        name: condition(rng.normal(mean, 1.0, 5).tolist(), days, drain)
        for name, mean in (("sc", 40.0), ("st", 35.0), ("lc", 44.0), ("lt", 41.0))
    }
    found = linear_contrast(conditions, [Effect(1.0, "st", "sc"), Effect(-1.0, "lt", "lc")], percent=False).estimate
    assert found.shared_se == 0.0


def test_without_a_shared_day_nothing_is_claimed() -> None:
    conditions = {"c": condition([1.0, 2.0], ["d", "d"]), "t": condition([3.0, 4.0], ["e", "e"])}
    found = linear_contrast(conditions, [Effect(1.0, "t", "c")], percent=False)
    assert found.rule is Rule.NONE
    assert found.estimate.value == 2.0
    assert isinstance(found.estimate.p, Undefined)


@pytest.mark.parametrize("effects", [[], [Effect(0.0, "c", "c")], [Effect(1.0, "t", "nothing")]])
def test_what_is_no_contrast_is_refused(effects: list[Effect]) -> None:
    with pytest.raises(InputRefused):
        linear_contrast({"c": condition([1.0], ["d"]), "t": condition([1.0], ["d"])}, effects, percent=False)


def test_what_cancels_on_every_day_has_no_test() -> None:
    """Rounding is no scatter: two effects that are the same on every day differ by nothing."""
    rng = np.random.default_rng(2)
    days = [f"d{day}" for day in range(5)]
    control = rng.normal(40.0, 3.0, 5)
    conditions = {
        name: condition((control - less).tolist(), days) for name, less in (("c", 0.0), ("a", 4.1), ("b", 5.3))
    }
    found = linear_contrast(conditions, [Effect(1.0, "b", "c"), Effect(-1.0, "a", "c")], percent=False).estimate
    assert found.value == pytest.approx(-1.2)
    assert isinstance(found.p, Undefined)
    assert isinstance(linear_contrast(conditions, [Effect(1.0, "c", "c")], percent=False).estimate.p, Undefined)


def test_effects_on_many_days_and_on_few_are_put_together() -> None:
    rng = np.random.default_rng(6)
    many, few = [f"d{day}" for day in range(5)], ["e1"] * 3 + ["e2"] * 3
    conditions = {
        name: condition(rng.normal(mean, 1.0, len(days)).tolist(), days)
        for name, mean, days in (("c", 40.0, many), ("t", 36.0, many), ("k", 40.0, few), ("u", 37.0, few))
    }
    found = linear_contrast(conditions, [Effect(0.5, "t", "c"), Effect(0.5, "u", "k")], percent=False)
    assert found.rule is Rule.WITHIN
    parts = [linear_contrast(conditions, [Effect(0.5, *pair)], percent=False).estimate for pair in ("tc", "uk")]
    assert found.estimate.value == pytest.approx(sum(part.value for part in parts))  # type: ignore[misc]
    assert found.estimate.se == pytest.approx(np.hypot(*(part.se for part in parts)))  # type: ignore[arg-type]
