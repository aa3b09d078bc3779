"""Outcomes of which the table has one value a run, as the peak force on a plate."""

from labbook.scripts.templates.runs import Rows, Run


def measured_of_runs(rows: Rows) -> list[Run]:
    """Return every run with the value that was measured of it."""
    return [Run(row, float(row["value"]), {}) for row in rows]
