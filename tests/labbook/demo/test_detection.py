"""What the detectors of `stats` make of generated logs, whose true apexes are known."""

import numpy as np
import pytest

from data_schema.vocabulary import RunKind, Undefined
from labbook.demo.campaign import DemoRun, make_campaign
from labbook.demo.logger import RunLog, run_log
from stats.apexes.detectors import Jumps, find_jumps

SEED = 11
Found = list[tuple[DemoRun, RunLog, Jumps]]


def detect(log: RunLog, detector: str) -> Jumps:
    return find_jumps(
        log.time_ms / 1000,
        log.channels["body_height [m]"],
        rest_length_m=0.27,
        leg_length_m=log.channels["leg_length [m]"],
        detector=detector,
    )


@pytest.fixture(scope="module")
def found() -> Found:
    campaign = make_campaign(SEED)
    runs = campaign.of_kind(RunKind.JUMPS)[::5]
    logs = [(run, run_log(SEED, campaign.truth, run)) for run in runs]
    return [(run, log, detect(log, "robust")) for run, log in logs]


def test_robust_detector_finds_the_true_apexes_and_no_others(found: Found) -> None:
    assert any(run.misfired.any() for run, _, _ in found)
    for run, log, jumps in found:
        assert len(jumps.jumps) == run.jumps_made
        reached = np.flatnonzero(~run.misfired)
        has_apex = np.array([not isinstance(jump.apex_height_m, Undefined) for jump in jumps.jumps])
        assert not has_apex[run.misfired].any()
        # An apex can only be lost where the samples around it were.
        assert np.all(has_apex[reached] | log.touched[reached])
        seen = has_apex[reached]
        np.testing.assert_allclose(jumps.apex_times_s, log.apex_ms[seen] / 1000, atol=0.01)
        np.testing.assert_allclose(jumps.apex_heights_m, log.apex_height_m[seen], atol=0.002)


def test_errors_of_the_robust_apexes_are_as_large_as_it_says(found: Found) -> None:
    errors_m, scores = [], []
    for run, log, jumps in found:
        whole = [jump for jump in jumps.with_apex if not log.touched[jump.number - 1]]
        true_m = run.apex_heights_m[[jump.number - 1 for jump in whole]]
        for jump, height_m in zip(whole, true_m, strict=True):
            assert isinstance(jump.apex_height_m, float)
            assert isinstance(jump.apex_height_se_m, float)
            errors_m.append(jump.apex_height_m - height_m)
            scores.append(errors_m[-1] / jump.apex_height_se_m)
    assert len(scores) > 800
    assert abs(np.mean(errors_m)) < 0.0001
    assert np.std(scores) == pytest.approx(1.0, abs=0.2)


def test_twelve_minutes_hold_the_same_jumps() -> None:
    campaign = make_campaign(SEED)
    run = campaign.of_kind(RunKind.JUMPS)[7]
    jumps = detect(run_log(SEED, campaign.truth, run, full=True), "robust")
    assert len(jumps.jumps) == run.jumps_made
    assert len(jumps.with_apex) == run.reached_apexes_m.size
