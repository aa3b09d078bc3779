import numpy as np
import pytest

from data_schema.vocabulary import RunKind
from labbook.demo.campaign import DemoRun, make_campaign
from labbook.demo.logger import RunLog, run_log


@pytest.fixture(scope="module")
def logs() -> list[tuple[DemoRun, RunLog]]:
    campaign = make_campaign(3, runs_per_condition=1)
    return [(run, run_log(3, campaign.truth, run)) for run in campaign.of_kind(RunKind.JUMPS)]


def missing_within(log: RunLog) -> set[int]:
    """Numbers of the samples that are missing between the first kept one and the last."""
    missing = {sample for first, number in log.dropped for sample in range(first, first + number)}
    first = min(set(range(len(missing) + 1)) - missing)
    last = first + round((log.time_ms[-1] - log.time_ms[0]) * 0.3)
    return {sample for sample in missing if first < sample < last}


def test_the_clock_shows_whole_milliseconds_at_300_hz_and_misses_what_was_dropped(
    logs: list[tuple[DemoRun, RunLog]],
) -> None:
    assert any(log.dropped.size for _, log in logs)
    for _, log in logs:
        steps = np.diff(log.time_ms)
        assert np.all(steps > 0)
        counts = np.unique_counts(steps)
        usual = dict(zip(counts.values.tolist(), counts.counts.tolist(), strict=True))
        assert usual[3] == pytest.approx(2 * usual[4], rel=0.05)
        missing = missing_within(log)
        assert sum(n for step, n in usual.items() if step > 4) == len(missing - {sample + 1 for sample in missing})
        expected = round((log.time_ms[-1] - log.time_ms[0]) * 0.3) + 1
        assert expected - log.time_ms.size == len(missing)
