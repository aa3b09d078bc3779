"""Over 40 campaigns and over 200, from arrays: do the intervals cover the truth as often as they claim?

Every quantity's count of covering intervals must lie in the 99 % binomial band, save for the few of many that a 1 %
rate explains; and the mean coverage of a kind of quantity must agree with 95 % within its 99 % interval over seeds
(quantities of one campaign share its drain fit, seeds share nothing).
"""

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats as reference

from benchmarks.validation_bed import SWEPT, as_charged, drain_of, intervals, truths
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.pairing import pairs_each, pairs_pooled
from labbook.demo.campaign import make_campaign
from labbook.demo.truth import CHAPTER_5, Condition
from stats.compare.shared_error import describe_shared, shared_of_mean
from stats.compare.summary import describe
from tests.helpers.once import made_once

LEVEL = 0.95
pytestmark = pytest.mark.soak


def covers(low: float | Undefined, high: float | Undefined, truth: float) -> bool:
    assert isinstance(low, float)
    assert isinstance(high, float)
    return low <= truth <= high


def key_of(condition: Condition) -> str:
    return " ".join(f"{name}={level}" for name, level in asdict(condition).items())


def coverage_of(seed: int) -> dict[str, list[bool]]:
    """Whether each interval of one campaign covers its truth, by kind."""
    campaign = make_campaign(seed)
    truth = campaign.truth
    at_run = drain_of(campaign).at(truth.run_duration_s, LEVEL)
    covered: dict[str, list[bool]] = {
        "passive charge": [covers(at_run.ci_low, at_run.ci_high, truth.drain.charge_mah(truth.run_duration_s))]
    }
    drawn = as_charged(campaign)
    joules, apexes = ({one.key: one for one in drawn[outcome]} for outcome in (Outcome.JOULES, Outcome.APEX))

    true = truths()
    covered["decided by the report"] = []
    for name, interval in intervals(drawn).items():
        assert not isinstance(interval, Undefined), name
        covered["decided by the report"].append(covers(*interval, true[name]))
    covered |= {"joules a jump": [], "apex height": [], "saving": [], "pooled saving": []}
    for condition in truth.conditions:
        of_condition = joules[key_of(condition)]
        mean = describe_shared(of_condition.values, shared_of_mean([run.shared for run in of_condition.runs]), LEVEL)
        covered["joules a jump"].append(covers(mean.ci_low, mean.ci_high, truth.joules_per_jump(condition)))
        apex = describe(apexes[key_of(condition)].values, LEVEL)
        covered["apex height"].append(covers(apex.ci_low, apex.ci_high, truth.apex_height_m(condition)))

    for kind, pairs_of in (("saving", pairs_each), ("pooled saving", pairs_pooled)):
        for pair in pairs_of(drawn[Outcome.JOULES], SWEPT):
            gain = int(pair.level) if kind == "saving" else None
            saved = truth.saving(pair.group["foot"], int(pair.group["k_gain"]), gain)
            interval = contrast_of(pair).savings(LEVEL).ci
            assert not isinstance(interval, Undefined), pair.label
            covered[kind].append(covers(*interval, 100 * saved))
    return covered


@pytest.fixture(scope="module", params=[40, 200])
def coverage(request: pytest.FixtureRequest) -> dict[str, NDArray[np.bool_]]:
    """By kind of quantity: arrays of shape (seeds, quantities)."""

    def simulated(_folder: Path) -> dict[str, NDArray[np.bool_]]:
        campaigns = [coverage_of(seed) for seed in range(request.param)]
        return {kind: np.array([covered[kind] for covered in campaigns]) for kind in campaigns[0]}

    return made_once(f"coverage-{request.param}", simulated)


KINDS = {
    "passive charge": 1,
    "decided by the report": 19,
    "joules a jump": len(CHAPTER_5.conditions),
    "apex height": len(CHAPTER_5.conditions),
    "saving": len(CHAPTER_5.groups) * len(CHAPTER_5.ad_gains),
    "pooled saving": len(CHAPTER_5.groups),
}


@pytest.mark.parametrize("kind", KINDS)
def test_intervals_cover_as_often_as_they_claim(coverage: dict[str, NDArray[np.bool_]], kind: str) -> None:
    seeds, quantities = coverage[kind].shape
    assert quantities == KINDS[kind]
    counts = coverage[kind].sum(axis=0)
    low, high = reference.binom.interval(0.99, seeds, LEVEL)
    outside = np.count_nonzero((counts < low) | (counts > high))
    assert outside <= reference.binom.ppf(0.99, counts.size, 0.01), counts.tolist()
    by_seed = coverage[kind].mean(axis=1)
    margin = reference.norm.ppf(0.995) * by_seed.std(ddof=1) / len(by_seed) ** 0.5
    assert abs(by_seed.mean() - LEVEL) < margin, by_seed.mean()
