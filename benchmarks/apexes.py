"""Jumps and apexes of all samples of the full campaign: the detectors alone, on logs that are in memory."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import scipy.signal

from benchmarks.inputs import full_log
from benchmarks.section import Benchmark, Budget, Section, Table
from benchmarks.timing import Times, Work, in_turns
from labbook.analysis.outcomes.detection import BODY_HEIGHT, LEG_LENGTH, LOGS_AT_ONCE, Log, detect

SAMPLES = 57_000_000
LIMIT_S = 20.0
DIFFERENT = 8
"""Logs of the campaign that come round again until all samples are counted: 40 MB of arrays instead of 1.4 GB."""
ROUNDS = 3
REST_LENGTH_M = 0.27
ROBUST, PUBLISHED, ALONE, PEAKS = (
    f"robust, {LOGS_AT_ONCE} threads",
    f"published, {LOGS_AT_ONCE} threads",
    "robust, one thread",
    "scipy's find_peaks on a moving average of 10, one thread",
)


def measure(say: Callable[[str], None]) -> Section:
    """Find the jumps of 57 million samples with both detectors, as the analysis of a book does."""
    say("drawing logs of 12 minutes")
    drawn = [_log(number) for number in range(DIFFERENT)]
    size = drawn[0].time_s.size
    count = -(-SAMPLES // size)
    logs = [drawn[number % DIFFERENT] for number in range(count)]
    say(f"{ROUNDS} rounds of {count} logs")
    works: dict[str, Callable[[object], object]] = {
        ROBUST: partial(_side_by_side, "robust", logs),
        PUBLISHED: partial(_side_by_side, "published", logs),
        ALONE: partial(_one_after_another, "robust", logs),
        PEAKS: partial(_peaks, logs),
    }
    times = in_turns({name: Work(run) for name, run in works.items()}, ROUNDS, warm_ups=0)
    jumps = sum(len(detect(log, "robust", REST_LENGTH_M).found.with_apex) for log in drawn) / DIFFERENT
    peaks = _peaks(drawn) / DIFFERENT
    return Section(
        "Finding the apexes of 57 million samples",
        f"{count} logs of {size} samples (12 minutes at 300 Hz: body height and leg length), {DIFFERENT} different "
        f"ones in turn: cleaned, stances found, and a parabola fitted to every flight. {LOGS_AT_ONCE} logs at once, "
        "as the analysis of a book does it; reading the logs is not in it.",
        (Budget("57 million samples through the robust detector (min)", LIMIT_S, "s", times[ROBUST].minimum),),
        (
            _table(
                times,
                f"A log has {jumps:.0f} flights. find_peaks returns {peaks:.0f} maxima a log, most of them made by "
                "hands and noise; which of them are apexes, how high and how sure is then still to be found out.",
            ),
        ),
    )


def _log(number: int) -> Log:
    log = full_log(number)
    return Log(log.time_ms / 1e3, log.channels[f"{BODY_HEIGHT} [m]"], log.channels[f"{LEG_LENGTH} [m]"], gaps=())


def _side_by_side(detector: str, logs: list[Log], _prepared: object) -> None:
    with ThreadPoolExecutor(LOGS_AT_ONCE) as pool:
        for _found in pool.map(lambda log: detect(log, detector, REST_LENGTH_M), logs):
            pass


def _one_after_another(detector: str, logs: list[Log], _prepared: object) -> None:
    for log in logs:
        detect(log, detector, REST_LENGTH_M)


def _peaks(logs: list[Log], _prepared: object = None) -> int:
    average = np.full(10, 0.1)
    return sum(scipy.signal.find_peaks(np.convolve(log.body_height_m, average, "valid"))[0].size for log in logs)


def _table(times: dict[str, Times], shows: str) -> Table:
    columns = {name: (found.minimum, found.median, found.cpu_minimum) for name, found in times.items()}
    rows = tuple((name, *(f"{seconds:.3g}" for seconds in found)) for name, found in columns.items())
    return Table(("", "min, s", "median, s", "processor, s"), rows, shows)


BENCHMARK = Benchmark("apexes", measure)
