"""Whether a log recorded the levels of its run: a controller may log each gain in the channel of its factor."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.queries.signals import RecordedRange

_CLOSE = 1e-3
"""Relative: a gain that a text file was rounded to is the same gain."""

_Levels = Mapping[str, str]
"""The labels of the levels of a condition, by the factor's name."""


@dataclass(frozen=True, slots=True)
class OtherLevel:
    """A log that recorded another level of a factor than its run has.

    `exchanged_with` is the uid of the one run of its day with which the log would be right, and that run's with this
    one; None where there is none.
    """

    signal_uid: str
    factor: str
    level: str
    recorded: float
    exchanged_with: str | None

    def sentence(self, log: str, run: str) -> str:
        """Say what the log, by its name, recorded, and what the run, by its name, has."""
        return f"{log} recorded {self.factor} {self.recorded:g}, and its run {run} has {self.level}"


def other_levels(
    recorded: Sequence[RecordedRange], levels: Mapping[int, _Levels], days: Mapping[str, str]
) -> dict[str, OtherLevel]:
    """Return, by the run's uid, the first channel of its logs that contradicts the level of the factor of its name.

    `recorded` is of the whole book, `levels` by the condition's key, `days` has the day of each run by its uid. Nothing
    is said of a channel that does not fit the levels in most logs: it is in another unit, or it is another thing.
    """
    of_run = {one.run_uid: levels.get(one.condition, {}) if one.condition is not None else {} for one in recorded}
    fit = [_fits(one, of_run[one.run_uid]) for one in recorded]
    balance: Counter[str] = Counter()
    for one, fits in zip(recorded, fit, strict=True):
        balance[one.channel] += 0 if fits is None else 1 if fits else -1
    comparable = [(one, fits) for one, fits in zip(recorded, fit, strict=True) if balance[one.channel] > 0]
    wrong: dict[str, RecordedRange] = {}
    channels: dict[str, list[RecordedRange]] = defaultdict(list)
    for one, fits in comparable:
        channels[one.signal_uid].append(one)
        if fits is False and one.run_uid in days:
            wrong.setdefault(one.run_uid, one)
    by_day: dict[str, list[str]] = defaultdict(list)
    for uid in wrong:
        by_day[days[uid]].append(uid)

    def would_fit(uid: str, other: str) -> bool:
        return all(_fits(one, of_run[other]) for one in channels[wrong[uid].signal_uid])

    found = {}
    for uid, one in wrong.items():
        others = [
            other for other in by_day[days[uid]] if other != uid and would_fit(uid, other) and would_fit(other, uid)
        ]
        in_force = max(one.lowest, one.highest, key=abs)
        exchanged_with = others[0] if len(others) == 1 else None
        found[uid] = OtherLevel(one.signal_uid, one.channel, of_run[uid][one.channel], in_force, exchanged_with)
    return found


def _fits(one: RecordedRange, levels: _Levels) -> bool | None:
    """Tell whether a channel shows the level of its factor; None where that is no number, or not known.

    A gain is in force in one half of a jump, and another, or none, in the other half; a gain of 0 never is.
    """
    try:
        level = float(levels[one.channel])
    except (KeyError, ValueError):
        return None
    if level == 0.0:
        return one.lowest == one.highest == 0.0
    return any(math.isclose(level, end, rel_tol=_CLOSE) for end in (one.lowest, one.highest))
