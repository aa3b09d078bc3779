"""Whether a log recorded the levels of its run: a controller may log each gain in the channel of its factor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.queries.runs import RunRow
from data_schema.queries.signals import RecordedRange

_NEAR = 0.25
"""Of the distance to the nearest other level: a value within it is of the level, whatever noise it has."""

_Levels = Mapping[str, float]
"""The values of a factor's levels by their labels."""


@dataclass(frozen=True, slots=True)
class OtherLevel:
    """A log that recorded another `level` of a factor than its run `has`, both as they are declared.

    `of_run` names the one run of its day that it can be of: the run that its file names, else one whose log is of this
    run, else one without a log that says otherwise; None where there is none, or are several. `is_of_another`: there
    are some, or the run has a log of its own level.
    """

    signal_uid: str
    factor: str
    has: str
    level: str
    of_run: str | None
    is_of_another: bool

    def sentence(self, log: str, run: str) -> str:
        """Say what the log, by its name, recorded, and what the run, by its name, has."""
        return f"{log} recorded {self.factor} {self.level}, and its run {run} has {self.has}"


def other_levels(
    recorded: Sequence[RecordedRange], runs: Sequence[RunRow], declared: Mapping[str, _Levels]
) -> dict[str, OtherLevel]:
    """Return, by the run's uid, the first channel of its logs that shows another level than the run has.

    `recorded` is of logs of these `runs`; `declared` has the levels by the factor's name. Nothing is said of a channel
    that may be another thing or in another unit, whatever its logs show.
    """
    of = {run.uid: run for run in runs}
    by_channel: dict[str, list[RecordedRange]] = defaultdict(list)
    for one in recorded:
        if one.run_uid in of:
            by_channel[one.channel].append(one)
    levels = {name: declared[name] for name, some in by_channel.items() if _is_comparable(some, of, declared[name])}
    logs: dict[str, dict[str, list[RecordedRange]]] = defaultdict(dict)
    for one in (one for name in levels for one in by_channel[name]):
        logs[one.run_uid].setdefault(one.signal_uid, []).append(one)

    def is_of(log: Sequence[RecordedRange], run: RunRow) -> bool:
        shown = [(_shown(one, run, levels[one.channel]), run.levels.get(one.channel)) for one in log]
        return all(at is not None and at == has for at, has in shown)

    def contradiction(log: Sequence[RecordedRange], run: RunRow) -> tuple[str, str] | None:
        """Return the first factor of which a log shows another level than a run has, and that level."""
        shown = {one.channel: _shown(one, run, levels[one.channel]) for one in log}
        return next(((name, at) for name, at in shown.items() if at is not None and at != run.levels[name]), None)

    wrong: dict[str, tuple[str, tuple[str, str]]] = {}
    for uid, several in logs.items():
        for signal_uid, log in several.items():
            if uid not in wrong and (found := contradiction(log, of[uid])) is not None:
                wrong[uid] = signal_uid, found
    by_day: dict[str, list[RunRow]] = defaultdict(list)
    for run in runs:
        by_day[run.day].append(run)

    def wrong_log(uid: str) -> Sequence[RecordedRange]:
        return logs[uid][wrong[uid][0]]

    def of_other(uid: str) -> OtherLevel:
        run, (signal_uid, (factor, level)) = of[uid], wrong[uid]
        log = wrong_log(uid)
        others = [other for other in by_day[run.day] if other is not run and is_of(log, other)]
        candidates = (
            [other.name for other in others if other.name == log[0].stated_run]
            or [other.name for other in others if other.uid in wrong and is_of(wrong_log(other.uid), run)]
            or [other.name for other in others if not _says_anything(logs.get(other.uid, {}), other, levels)]
        )
        has_own = any(contradiction(one, run) is None for one in logs[uid].values())
        of_run = candidates[0] if len(candidates) == 1 else None
        return OtherLevel(signal_uid, factor, run.levels[factor], level, of_run, bool(candidates) or has_own)

    return {uid: of_other(uid) for uid in wrong}


def _says_anything(logs: Mapping[str, Sequence[RecordedRange]], run: RunRow, levels: Mapping[str, _Levels]) -> bool:
    return any(_shown(one, run, levels[one.channel]) is not None for log in logs.values() for one in log)


def _is_comparable(known: Sequence[RecordedRange], of: Mapping[str, RunRow], levels: _Levels) -> bool:
    """Tell whether a channel has the levels of its factor: it shows two of them, and seldom 0 where there is a gain.

    0 is the same in every unit, and where nothing is logged.
    """
    pairs = [(of[one.run_uid].levels.get(one.channel, ""), _shown(one, of[one.run_uid], levels)) for one in known]
    shown = [(has, level) for has, level in pairs if level is not None]
    gains = sum(levels[level] != 0.0 for _has, level in shown)
    missing = sum(levels[level] == 0.0 != levels[has] for has, level in shown)
    return len({level for _has, level in shown}) > 1 and gains > missing


def _shown(one: RecordedRange, run: RunRow, levels: _Levels) -> str | None:
    """Return the level that a channel shows, which is that of a run where it can be; None where none is clear.

    A gain is in force in one half of a jump, and another, or none, in the other half; a gain of 0 never is.
    """
    has = run.levels.get(one.channel)
    if has is None or has not in levels or len(levels) < 2:
        return None
    lowest, highest = (_level_near(end, levels) for end in (one.lowest, one.highest))
    if levels[has] != 0.0 and has in (lowest, highest):
        return has
    return highest if abs(one.highest) >= abs(one.lowest) else lowest


def _level_near(value: float, levels: _Levels) -> str | None:
    label = min(levels, key=lambda name: abs(levels[name] - value))
    gap = min(abs(levels[label] - other) for name, other in levels.items() if name != label)
    return label if abs(levels[label] - value) <= _NEAR * gap else None
