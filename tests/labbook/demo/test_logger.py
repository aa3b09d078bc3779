import numpy as np
import pytest

from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import RunKind
from labbook.demo.campaign import Campaign, DemoRun, make_campaign
from labbook.demo.logger import RunLog, run_log


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return make_campaign(3, runs_per_condition=1)


@pytest.fixture(scope="module")
def logs(campaign: Campaign) -> list[tuple[DemoRun, RunLog]]:
    return [(run, run_log(3, campaign.truth, run)) for run in campaign.of_kind(RunKind.JUMPS)]


def missing_within(log: RunLog) -> set[int]:
    """Numbers of the samples that are missing between the first kept one and the last."""
    missing = {sample for first, number in log.dropped for sample in range(first, first + number)}
    first = min(set(range(len(missing) + 1)) - missing)
    last = first + round((log.time_ms[-1] - log.time_ms[0]) * 0.3)
    return {sample for sample in missing if first < sample < last}


def test_clock_shows_whole_milliseconds_at_300_hz(logs: list[tuple[DemoRun, RunLog]]) -> None:
    for _, log in logs:
        steps = np.diff(log.time_ms)
        assert np.all(steps > 0)
        counts = np.unique_counts(steps)
        usual = dict(zip(counts.values.tolist(), counts.counts.tolist(), strict=True))
        assert usual[3] == pytest.approx(2 * usual[4], rel=0.05)
        missing = missing_within(log)
        assert sum(n for step, n in usual.items() if step > 4) == len(missing - {sample + 1 for sample in missing})
        assert log.time_ms[0] >= 15_000


def test_dropped_packets_miss_what_they_say(logs: list[tuple[DemoRun, RunLog]]) -> None:
    assert any(log.dropped.size for _, log in logs)
    for _, log in logs:
        expected = round((log.time_ms[-1] - log.time_ms[0]) * 0.3) + 1
        assert expected - log.time_ms.size == len(missing_within(log))


def test_samples_around_every_apex_lie_on_its_parabola(logs: list[tuple[DemoRun, RunLog]]) -> None:
    for run, log in logs:
        assert log.apex_ms.size == run.jumps_made - run.misfired.sum()
        for apex_ms, height_m in zip(log.apex_ms, log.apex_height_m, strict=True):
            since_s = (log.time_ms - apex_ms) / 1000
            near = np.abs(since_s) < 0.03
            parabola_m = height_m - STANDARD_GRAVITY_M_S2 * since_s[near] ** 2 / 2
            # 1 mm of noise, 0.1 mm of rounding, and the clock's millisecond.
            assert np.abs(log.channels["body_height [m]"][near] - parabola_m).max() < 0.006


def test_a_jump_is_dropped_from_the_mark_and_caught_before_it_lands(
    logs: list[tuple[DemoRun, RunLog]],
) -> None:
    for _, log in logs:
        height_m, foot_m = (
            log.channels["body_height [m]"],
            log.channels["body_height [m]"] - log.channels["leg_length [m]"],
        )
        for apex_ms in log.apex_ms:
            before = (log.time_ms > apex_ms - 700) & (log.time_ms < apex_ms)
            after = (log.time_ms > apex_ms + 20) & (log.time_ms < apex_ms + 400)
            assert 0.41 < height_m[before].max() < 0.427
            assert foot_m[before].min() < -0.01
            assert foot_m[after].min() > -0.002


def test_misfired_jumps_stay_below_the_ground_line_until_picked_up(campaign: Campaign) -> None:
    run = next(run for run in campaign.of_kind(RunKind.JUMPS) if run.misfired.any())
    log = run_log(3, campaign.truth, run)
    low = np.convolve(log.channels["body_height [m]"], np.full(10, 0.1), mode="valid") < 0.22
    edges = np.flatnonzero(np.diff(low.astype(int)) == 1)
    assert edges.size == run.jumps_made
    assert log.apex_ms.size == run.jumps_made - run.misfired.sum()
