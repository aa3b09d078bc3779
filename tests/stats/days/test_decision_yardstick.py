"""The decision test on campaigns of known truth: how often it covers, errs and makes a claim, layout by layout."""

from __future__ import annotations

import csv
import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy import stats as scipy_stats

from data_schema.vocabulary import Rule, Undefined
from stats.days.decision import LEAST_DAYS
from stats.groups.multiple import holm
from tests.helpers.campaigns import APEX_SD, DESIGNS, LAYOUTS, RUN_SD, campaign, drain

SAVING = 0.11
BOUND_PERCENT = 3.0
LEAST_COVERAGE, MOST_ERRORS, CHANCE = 0.94, 0.06, 0.001
SHARES = ("covered", "unbounded", "rejected", "equivalent", "found")
WRITTEN_TO = "LABBOOK_DECISIONS"
"""The environment variable with the file that the table of the long run goes to."""


def judged(name: str, campaigns: int) -> Counter[str]:
    """Draw campaigns of a layout, the designs in turn, and count what the decision test says of each."""
    layout, counts = LAYOUTS[name], Counter[str]()
    rng = np.random.default_rng([20261124, list(LAYOUTS).index(name)])
    for number in range(campaigns):
        design = DESIGNS[number % len(DESIGNS)]
        common, shared = drain(rng)
        saving = campaign(layout, design, 1.0 - SAVING, RUN_SD, rng, common)
        found = saving.contrast(shared)
        counts["campaigns"] += 1
        counts[found.rule] += 1
        if found.rule is Rule.NONE:
            assert isinstance(found.savings().p, Undefined)
            assert isinstance(found.savings().ci, Undefined)
            continue
        savings = found.savings()
        truth = 100.0 * SAVING if found.rule is Rule.PAIRED else saving.saving_of_days(found)
        if isinstance(savings.ci, Undefined):  # days scatter so much that the control's mean might be 0
            counts["unbounded"] += 1
        else:
            counts["covered"] += savings.ci[0] <= truth <= savings.ci[1]
            counts["found"] += savings.ci[0] > 0.0
        common, shared = drain(rng)
        p = campaign(layout, design, 1.0, RUN_SD, rng, common).contrast(shared).difference().p
        assert not isinstance(p, Undefined)
        counts["rejected"] += p < 0.05
        apex = campaign(layout, design, 1.0 + BOUND_PERCENT / 100.0, APEX_SD, rng).contrast()
        counts["equivalent"] += apex.equivalence(-BOUND_PERCENT, BOUND_PERCENT).equivalent is True
    return counts


def hold(judgements: Sequence[tuple[str, Counter[str]]]) -> None:
    """Hold coverage, size and equivalence of all layouts to their limits, Holm over all."""
    p: dict[str, float] = {}
    for name, counts in judgements:
        rule, n = next(rule for rule in Rule if counts[rule]), counts["campaigns"]
        days = sum(1 for control, treated in LAYOUTS[name] if control and treated)
        assert counts[rule] == n  # by which runs there are, not by what they measured
        assert (rule is Rule.PAIRED) == (days >= LEAST_DAYS)
        if rule is not Rule.NONE:
            p[f"coverage, {name}"] = float(
                scipy_stats.binom.cdf(counts["covered"] + counts["unbounded"], n, LEAST_COVERAGE)
            )
            for what in ("rejected", "equivalent"):
                p[f"{what}, {name}"] = float(scipy_stats.binom.sf(counts[what] - 1, n, MOST_ERRORS))
    adjusted = holm(p, "limits", alpha=CHANCE)
    assert not [name for name, rejected in zip(adjusted.names, adjusted.rejected, strict=True) if rejected is True]


def test_a_few_campaigns_of_each_rule_stay_within_the_limits() -> None:
    names = ["4 days 3+10", "3 days 12+2 3+20 1+28", "2 days 3+10, 2 of AD", "3 days 1+3", "2 of CE, 4 of AD"]
    hold([(name, judged(name, 260)) for name in names])


@pytest.mark.soak
def test_every_layout_stays_within_the_limits() -> None:
    judgements = [(name, judged(name, 4000)) for name in LAYOUTS]
    if file := os.environ.get(WRITTEN_TO):
        with Path(file).open("w", newline="") as written:
            table = csv.writer(written, lineterminator="\n")
            table.writerow(
                ["layout", "rule", "claims", "coverage", "unbounded", "size", "equivalent_at_bound", "found"]
            )
            for name, counts in judgements:
                n, rule = counts["campaigns"], next(rule for rule in Rule if counts[rule])
                counts["covered"] += counts["unbounded"]
                claims = 1 - counts[Rule.NONE] / n
                shares = [f"{counts[what] / n:.4f}" for what in SHARES] if claims else [""] * len(SHARES)
                table.writerow([name, rule, f"{claims:g}", *shares])
    hold(judgements)
