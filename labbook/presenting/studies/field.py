"""Walks in the field: as sentences, as data, and as what the figure draws."""

from __future__ import annotations

from typing import Any

from data_schema.rounding import error_of, interval_text, level_text, number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.field import FieldStudy, geometric
from reports.figures.field import RobotWalks
from stats.compare.summary import Summary
from stats.results import counted


def sentences(study: FieldStudy) -> list[str]:
    """Say how much less or more the second robot needs than the first, and what either needs; last what is doubtful."""
    first, second = study.robots
    walks = counted(len(study.walks), "walk")
    needs = " and ".join(f"{_with_interval(study.log_means[robot], ' ({})')} {robot}" for robot in study.robots)
    each = f"Specific resistance, energy over weight times distance: {needs} (geometric means of {walks})."
    doubt = [] if study.doubt is None else [study.doubt]
    ratio, interval = geometric(study.log_ratio)
    percent = 100.0 * (ratio - 1.0)
    change = f"{number_text(abs(percent), 2)} % {'less' if percent < 0.0 else 'more'} than" if percent else "as much as"
    if isinstance(interval, Undefined):
        return [f"{second} needed {change} {first}; no interval: {interval.reason}.", each, *doubt]
    within = f"{second} / {first} {_with_interval(study.log_ratio, ', {}')}, within {walks}"
    tells = "" if interval[1] < 1.0 or interval[0] > 1.0 else "; the difference is not significant"
    return [f"{second} needs {change} {first} ({within}){tells}.", each, *doubt]


def _with_interval(logs: Summary, after: str) -> str:
    """Write the geometric mean, and after it its interval where there is one."""
    mean, interval = geometric(logs)
    text = number_text(mean, error=error_of(interval))
    return text if isinstance(interval, Undefined) else text + after.format(interval_text(interval, logs.level))


def as_data(study: FieldStudy) -> dict[str, Any]:
    """Return all numbers for JSON."""
    ratio, interval = geometric(study.log_ratio)
    return {
        "robots": [
            {
                "robot": robot,
                **_geometric_data(study.log_means[robot]),
                "walks": dict(zip(study.walks, study.specific_resistance[robot], strict=True)),
            }
            for robot in study.robots
        ],
        "ratio": ratio,
        "ratio_ci": None if isinstance(interval, Undefined) else list(interval),
        "log_ratio": study.log_ratio.to_dict(),
        "doubt": study.doubt,
    }


def _geometric_data(logs: Summary) -> dict[str, Any]:
    mean, interval = geometric(logs)
    return {"geometric_mean": mean, "ci": None if isinstance(interval, Undefined) else list(interval), "n": logs.n}


def drawn(study: FieldStudy) -> list[RobotWalks]:
    """Return what the figure shows."""
    label = f"mean, {level_text(study.log_ratio.level)} CI"
    means = {robot: geometric(logs) for robot, logs in study.log_means.items()}
    return [RobotWalks(robot, study.specific_resistance[robot], *means[robot], label) for robot in study.robots]
