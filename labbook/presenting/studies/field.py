"""Walks in the field: as sentences, as data, and as what the figure draws."""

from __future__ import annotations

from typing import Any

from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.field import FieldStudy
from reports.figures.field import RobotWalks
from stats.compare.summary import Summary
from stats.exact.numbers import as_interval
from stats.results import counted


def sentences(study: FieldStudy) -> list[str]:
    """Say what either robot needs, and how much less or more the second needs than the first."""
    first, second = study.robots
    walks = counted(len(study.walks), "walk")
    needs = " and ".join(f"{_mean_text(study.means[robot])} {robot}" for robot in study.robots)
    said = [f"Specific resistance, energy over weight times distance: {needs} ({walks})."]
    interval = study.ratio_ci
    percent = 100.0 * (study.ratio - 1.0)
    change = f"{number_text(abs(percent), 2)} % {'less' if percent < 0.0 else 'more'}"
    if isinstance(interval, Undefined):
        return [*said, f"{second} needed {change} than {first}; {walks} cannot tell how that scatters: make more."]
    ratio = number_text(study.ratio, error=error_of(interval))
    within = f"{second} / {first} {ratio}, {interval_text(interval, study.log_ratio.level)}, within {walks}"
    tells = "" if interval[1] < 1.0 or interval[0] > 1.0 else "; the difference is not significant"
    return [*said, f"{second} needs {change} than {first} ({within}){tells}."]


def _mean_text(mean: Summary) -> str:
    interval = as_interval(mean.ci_low, mean.ci_high)
    if isinstance(interval, Undefined) or isinstance(mean.mean, Undefined):
        return number_text(mean.mean)
    return f"{number_text(mean.mean, error=error_of(interval))} ({interval_text(interval, mean.level)})"


def as_data(study: FieldStudy) -> dict[str, Any]:
    """Return all numbers for JSON."""
    interval = study.ratio_ci
    return {
        "robots": [
            {
                "robot": robot,
                **study.means[robot].to_dict(),
                "walks": dict(zip(study.walks, study.specific_resistance[robot], strict=True)),
            }
            for robot in study.robots
        ],
        "ratio": study.ratio,
        "ratio_ci": None if isinstance(interval, Undefined) else list(interval),
        "log_ratio": study.log_ratio.to_dict(),
    }


def drawn(study: FieldStudy) -> list[RobotWalks]:
    """Return what the figure shows."""
    return [
        RobotWalks(robot, study.specific_resistance[robot], mean.mean, as_interval(mean.ci_low, mean.ci_high))
        for robot, mean in study.means.items()
    ]
