"""Whether a log recorded the levels of its run: a controller may log each gain in the channel of its factor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from data_schema.queries.runs import RunRow
from data_schema.queries.signals import RecordedRange

_NEAR = 0.25
"""Of the distance to the nearest other level: a value within it is of the level, whatever noise it has."""


@dataclass(frozen=True, slots=True)
class OtherLevel:
    """A log that recorded another `level` of a factor than its run `has`, both as they are declared.

    `of_run` is the uid of the one run of its day that it can be of: that of its name, else one whose log is of this
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
    recorded: Sequence[RecordedRange], runs: Sequence[RunRow], declared: Mapping[str, Mapping[str, float]]
) -> dict[str, OtherLevel]:
    """Return, by the run's uid, the first channel of its logs that shows another level than the run has.

    `recorded` is of logs of these `runs`; `declared` has the values of a factor's levels by their labels. Nothing is
    said of a channel that may be another thing or in another unit, whatever its logs show.
    """
    of, named = {run.uid: run for run in runs}, {run.name: run for run in runs}
    known = [one for one in recorded if one.run_uid in of]
    comparable = {name for name, levels in declared.items() if _is_comparable(known, name, of, levels)}
    logs: dict[str, dict[str, list[RecordedRange]]] = defaultdict(dict)
    for one in known:
        if one.channel in comparable:
            logs[one.run_uid].setdefault(one.signal_uid, []).append(one)
    wrong: dict[str, RecordedRange] = {}
    for uid, of_run in logs.items():
        for one in (one for channels in of_run.values() for one in channels):
            if _contradicts(one, of[uid], declared):
                wrong.setdefault(uid, one)
    by_day: dict[str, list[RunRow]] = defaultdict(list)
    for run in runs:
        by_day[run.day].append(run)

    def can_be_of(uid: str, other: RunRow) -> bool:
        channels = logs[uid][wrong[uid].signal_uid]
        return all((shown := _shown(one, other, declared)) is not None and shown[0] == shown[1] for one in channels)

    def is_clear(uid: str) -> bool:
        return any(_shown(one, of[uid], declared) for channels in logs[uid].values() for one in channels)

    found = {}
    for uid, one in wrong.items():
        others = [other for other in by_day[of[uid].day] if other.uid != uid and can_be_of(uid, other)]
        stated = named.get(one.stated_run or "")
        candidates = (
            [stated.uid for other in others if stated is other]
            or [other.uid for other in others if other.uid in wrong and can_be_of(other.uid, of[uid])]
            or [other.uid for other in others if other.uid not in logs or not is_clear(other.uid)]
        )
        shown = _shown(one, of[uid], declared)
        assert shown is not None  # noqa: S101 - it contradicts the run
        found[uid] = OtherLevel(
            signal_uid=one.signal_uid,
            factor=one.channel,
            has=shown[0],
            level=shown[1],
            of_run=candidates[0] if len(candidates) == 1 else None,
            is_of_another=bool(candidates)
            or any(
                not any(_contradicts(channel, of[uid], declared) for channel in channels)
                for channels in logs[uid].values()
            ),
        )
    return found


def _is_comparable(
    known: Sequence[RecordedRange], name: str, of: Mapping[str, RunRow], levels: Mapping[str, float]
) -> bool:
    """Tell whether a channel has the levels of its factor: it shows two of them, and seldom 0 where there is a gain.

    0 is the same in every unit, and where nothing is logged.
    """
    shown = [
        pair
        for one in known
        if one.channel == name
        if (pair := _shown(one, of[one.run_uid], {name: levels})) is not None
    ]
    gains = sum(levels[level] != 0.0 for _has, level in shown)
    missing = sum(levels[level] == 0.0 != levels[has] for has, level in shown)
    return len({level for _has, level in shown}) > 1 and gains > missing


def _contradicts(one: RecordedRange, run: RunRow, declared: Mapping[str, Mapping[str, float]]) -> bool:
    shown = _shown(one, run, declared)
    return shown is not None and shown[0] != shown[1]


def _shown(one: RecordedRange, run: RunRow, declared: Mapping[str, Mapping[str, float]]) -> tuple[str, str] | None:
    """Return the level of a run and the one that a channel shows, which may be the same; None where neither is clear.

    A gain is in force in one half of a jump, and another, or none, in the other half; a gain of 0 never is.
    """
    levels = declared.get(one.channel, {})
    has = run.levels.get(one.channel)
    if has is None or has not in levels or len(levels) < 2:
        return None
    lowest, highest = (_level_near(end, levels) for end in (one.lowest, one.highest))
    in_force = highest if abs(one.highest) >= abs(one.lowest) else lowest
    if levels[has] != 0.0 and has in (lowest, highest):
        return has, has
    return None if in_force is None else (has, in_force)


def _level_near(value: float, levels: Mapping[str, float]) -> str | None:
    label = min(levels, key=lambda name: abs(levels[name] - value))
    gap = min(abs(levels[label] - other) for name, other in levels.items() if name != label)
    return label if abs(levels[label] - value) <= _NEAR * gap else None
