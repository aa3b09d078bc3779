"""Walks in the field: as sentences, as data, and as what the figure draws."""

from __future__ import annotations

import re
from typing import Any

from data_schema.rounding import error_of, interval_text, level_text, number_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.field import FieldStudy, geometric
from labbook.presenting.numbers import value_data
from reports.figures.field import OnWalks
from simulator.steady.published_results import published_numbers
from stats.compare.summary import Summary
from stats.results import plural

PUBLISHED = {"thin": "field.sr_thin", "wide": "field.sr_wide"}
"""What docs/published.md calls the specific resistance of the thesis's RHex, by its legs (2.2.3)."""


def sentences(study: FieldStudy) -> list[str]:
    """Say how much less or more the second robot needs than the first, and what either needs; last what is doubtful."""
    first, second = study.robots
    walks = plural(len(study.walks), "walk")
    needs = " and ".join(f"{_with_interval(study.log_means[robot], ' ({})')} {robot}" for robot in study.robots)
    thesis = " and ".join(f"{published_numbers()[name]:g} {legs}" for legs, name in PUBLISHED.items())
    known = f"The thesis: {thesis}, on one walk of 430 m (2.2.3; {' and '.join(PUBLISHED.values())})."
    each = f"Specific resistance, energy over weight times distance: {needs} (geometric means of {walks})."
    others = [each, known] if study.doubt is None else [each, known, study.doubt]
    ratio, interval = geometric(study.log_ratio)
    percent = 100.0 * (ratio - 1.0)
    change = f"{number_text(abs(percent), 2)} % {'less' if percent < 0.0 else 'more'} than" if percent else "as much as"
    if isinstance(interval, Undefined):
        return [f"On these walks {second} needed {change} {first}; no interval: {interval.reason}.", *others]
    within = f"{second} / {first} {_with_interval(study.log_ratio, ', {}')}, within {walks}"
    tells = "" if interval[1] < 1.0 or interval[0] > 1.0 else "; the difference is not significant"
    return [f"On the same walks {second} needs {change} {first} ({within}){tells}.", *others]


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
        "ratio_ci": value_data(interval),
        "log_ratio": study.log_ratio.to_dict(),
        "published": {name: published_numbers()[name] for name in PUBLISHED.values()},
        "doubt": study.doubt,
    }


def _geometric_data(logs: Summary) -> dict[str, Any]:
    mean, interval = geometric(logs)
    return {"geometric_mean": mean, "ci": value_data(interval), "n": logs.n}


def figure_data(study: FieldStudy) -> tuple[list[OnWalks], OnWalks, str]:
    """Return what the figure shows: the robots, their ratio, and what their means are."""
    first, second = study.robots
    published = [_published(robot) for robot in study.robots]
    robots = [
        OnWalks(robot, study.specific_resistance[robot], *geometric(study.log_means[robot]), value)
        for robot, value in zip(study.robots, published, strict=True)
    ]
    of_thesis = None if published[0] is None or published[1] is None else published[1] / published[0]
    ratios = [b / a for a, b in zip(robots[0].values, robots[1].values, strict=True)]
    ratio = OnWalks(f"{second} / {first}", ratios, *geometric(study.log_ratio), of_thesis)
    return robots, ratio, f"mean, {level_text(study.log_ratio.level)} CI"


def _published(robot: str) -> float | None:
    """Return the thesis's value for a robot that is named by its legs as there: a word of it is theirs."""
    words = re.findall(r"[^\W\d_]+", robot.casefold())
    return next((published_numbers()[name] for legs, name in PUBLISHED.items() if legs in words), None)
