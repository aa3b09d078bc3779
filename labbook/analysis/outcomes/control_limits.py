"""Control limits of runs (Shewhart 1931): each run's value beside those of the other runs of its condition.

Several slips in one condition would widen each other's limits until all lie inside: values far beyond the scatter of
the others make no limits.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from itertools import accumulate, product
from typing import NamedTuple

from data_schema.grouping import grouped
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.run_energy import joules_per_mah, usable_charge
from labbook.analysis.study_data import StudyData
from reports.results import Drain
from stats.tails import t_upper_quantile

BEYOND = 0.00135
"""Chance of a value above its upper limit, and below its lower one: that of three standard deviations (Shewhart)."""
LIMITS_FROM_RUNS = 3
"""Fewer other runs than this give no limits."""
FAR, FAR_FROM_RUNS = 10.0, 8
"""Median absolute deviations, scaled to standard deviations, beyond which a value makes no limits; from so many runs.

Of normal runs .4 % lie beyond of eight and .01 % of twenty, so that limits still hold 99.7 %.
"""

_AND_DIGITS = 1.0 + 1e-9
"""A value one step away is not out of limits by its last digits."""


class ControlLimits(NamedTuple):
    """Limits from `n` other runs: of their mean, and the sum of squared deviations from it.

    They are no nearer to the mean than `rounding`: so far apart may readings of equal values lie.
    """

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0
    rounding: float = 0.0

    @property
    def ends(self) -> tuple[float, float] | None:
        """The limits, from 0 or above: a jump takes energy. None where runs are too few or both ends are below 0.

        They are those of a prediction interval, as a standard deviation of few runs is uncertain.
        """
        if self.n < LIMITS_FROM_RUNS:
            return None
        sd = math.sqrt(self.squares / (self.n - 1) * (1.0 + 1.0 / self.n))
        width = max(t_upper_quantile(BEYOND, self.n - 1) * sd, self.rounding)
        return (max(self.mean - width, 0.0), self.mean + width) if self.mean + width > 0.0 else None

    def outside(self, value: float) -> bool:
        """Return whether a run of this value is out of the limits, as far as there are any."""
        ends = self.ends
        return ends is not None and not ends[0] <= value <= ends[1]


_Moments = tuple[int, float, float]
"""Number, mean and sum of squares about it, of runs that limits come from."""
_NO_RUN: _Moments = (0, 0.0, 0.0)


def _of_both(one: _Moments, other: _Moments) -> _Moments:
    """Return the moments of the runs of both (Chan et al. 1983)."""
    (n_one, mean_one, squares_one), (n_other, mean_other, squares_other) = one, other
    if not n_one or not n_other:
        return one if n_one else other
    n, apart = n_one + n_other, mean_other - mean_one
    return n, mean_one + apart * n_other / n, squares_one + squares_other + apart * apart * n_one * n_other / n


def joule_limits(evidence: StudyData, joules: Mapping[str, float]) -> dict[str, ControlLimits]:
    """Return the limits of joules a jump, by uid as `joules` are, each read in steps of the charger's display."""
    voltage_v, steps = evidence.study.reference_voltage_v, dict[str, float]()
    for run in evidence.runs:
        charge = usable_charge(run, evidence.charges.get(run.uid, []))
        if not isinstance(charge, Undefined):
            steps[run.uid] = charge.resolution_mah * joules_per_mah(voltage_v, run.jumps_made)
    return limits_of(evidence.runs, joules, steps)


def limits_of(
    runs: Sequence[RunRow], values: Mapping[str, float], steps: Mapping[str, float] = {}
) -> dict[str, ControlLimits]:
    """Return the limits of each run that has a value, by uid, from those of all other runs of its condition.

    `steps` are those in which the values were read, by uid: a reading errs by up to half a step, and so does the mean
    of others that were rounded alike, so that limits are no narrower than both halves.
    """
    found: dict[str, ControlLimits] = {}
    known = [run for run in runs if run.uid in values]
    for of_condition in grouped(known, [run.condition_key for run in known]).values():
        uids = [run.uid for run in of_condition]
        far = _far([values[uid] for uid in uids])
        single = [_NO_RUN if left else (1, values[uid], 0.0) for uid, left in zip(uids, far, strict=True)]
        before = accumulate(single[:-1], _of_both, initial=_NO_RUN)
        after = list(accumulate(single[:0:-1], _of_both, initial=_NO_RUN))[::-1]
        others = map(_of_both, before, after)
        of_others = statistics.median(steps.get(uid, 0.0) for uid in uids)
        rounding = [_AND_DIGITS * (steps.get(uid, 0.0) + of_others) / 2.0 for uid in uids]
        found |= {uid: ControlLimits(*moments, most) for uid, moments, most in zip(uids, others, rounding, strict=True)}
    return found


def _far(values: Sequence[float]) -> list[bool]:
    """Tell which values lie beyond all scatter of the others; none where runs are few or most are equal."""
    middle = statistics.median(values)
    apart = [abs(value - middle) for value in values]
    most = FAR * statistics.median(apart) / statistics.NormalDist().inv_cdf(0.75)
    return [len(values) >= FAR_FROM_RUNS and 0.0 < most < each for each in apart]


def runs_outside(
    runs: Sequence[RunRow], values: Mapping[str, float], limits: Mapping[str, ControlLimits]
) -> list[RunRow]:
    """Return the runs whose value is out of its limits."""
    return [run for run in runs if run.uid in limits and limits[run.uid].outside(values[run.uid])]


def exchanged_charges(
    evidence: StudyData,
    drains: Mapping[str, Drain],
    joules: Mapping[str, float],
    limits: Mapping[str, ControlLimits],
) -> tuple[tuple[str, str], ...]:
    """Name pairs of runs of a day, one above its limits and one below, that are inside with each other's charge.

    Of several partners of a run only the first counts. `joules` and `limits` are by uid.
    """

    def stays_outside(run: RunRow, other: RunRow) -> bool:
        charge, line = usable_charge(other, evidence.charges[other.uid]), drains[run.robot_uid].line
        assert not isinstance(charge, Undefined)  # noqa: S101 - runs out of limits have joules
        assert not isinstance(line, Undefined)  # noqa: S101
        used_mah = charge.charge_mah - line.charge_at(run.duration_s or 0.0)
        return limits[run.uid].outside(joules_per_mah(evidence.study.reference_voltage_v, run.jumps_made) * used_mah)

    outside = runs_outside(evidence.runs, joules, limits)
    high = [run for run in outside if joules[run.uid] > limits[run.uid].mean]
    found: dict[str, str] = {}
    for one, other in product(high, [run for run in outside if run not in high]):
        if one.day != other.day or stays_outside(one, other) or stays_outside(other, one):
            continue
        if one.name not in found and other.name not in found.values():
            found[one.name] = other.name
    return tuple(found.items())
