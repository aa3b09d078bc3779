"""The standard deviations that a simulated design has, in words."""

from __future__ import annotations

from reports.display import general_text
from stats.planning.recorded import Recorded


def spreads_text(row: Recorded) -> str:
    """Name the standard deviations of all groups in turn where they differ; they lie on equal ratios."""
    if row.sd_ratio == 1.0:
        return ""
    last = len(row.groups) - 1
    sds = [general_text(row.sd_ratio ** (1.0 - place / last)) for place in range(len(row.groups))]
    return f", should standard deviations be {' : '.join(sds)}"
