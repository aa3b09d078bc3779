import numpy as np
import pytest

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
