"""Outcomes of which the table has one value a run, as the peak force on a plate."""

from collections.abc import Sequence

from labbook.scripts.templates.runs import Row, Run


def measured_of_runs(rows: Sequence[Row]) -> list[Run]:
    """Return every run with the value that was measured of it."""
    return [Run(row, float(row["value"]), {}) for row in rows]
