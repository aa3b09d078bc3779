"""All 27 cases, in order."""

from __future__ import annotations

from benchmarks.stats_evidence.weaknesses import (
    constants,
    days,
    float32,
    missing,
    planes,
    scale,
    shown,
    tails,
    time_stamps,
)
from benchmarks.stats_evidence.weaknesses.case import Weakness

WEAKNESSES: dict[str, Weakness] = {
    case.name: case
    for case in sorted(
        (
            *constants.CASES,
            *scale.CASES,
            *tails.CASES,
            *missing.CASES,
            *float32.CASES,
            *time_stamps.CASES,
            *planes.CASES,
            *days.CASES,
            *shown.CASES,
        ),
        key=lambda case: int(case.name[1:]),
    )
}
