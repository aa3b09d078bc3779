"""Which calibration of a column is in force on the day of its log."""

from __future__ import annotations

import dataclasses

from ingest.channels.columns import ColumnPlan
from ingest.findings import FILE, NOTE, FindingCollector

UNDATED = "calibration_undated"
"""The rule of a log without a date whose column has calibrations with dates."""


def with_calibration(plan: ColumnPlan, day: str | None, findings: FindingCollector) -> ColumnPlan:
    """Return the column with the calibration that is in force on a local date; the file is refused where that is none.

    A column without calibrations stays as it is.
    """
    if not plan.calibrations:
        return plan
    raw = dataclasses.replace(
        plan, channel=f"raw_{plan.channel}", unit="counts", scale=1.0, offset=0.0, calibrations=()
    )
    dated = any(each.first_day or each.last_day for each in plan.calibrations)
    if dated and day is None:
        periods = "; ".join(each.period for each in plan.calibrations)
        message = f"The calibrations of column {plan.source_name!r} have dates ({periods}), and the file has none: say"
        findings.add(FILE, UNDATED, f"{message} `--day YYYY-MM-DD`.", column=plan.source_name)
        return raw
    held = [each for each in plan.calibrations if day is None or each.holds_on(day)]
    if len(held) != 1:
        periods = "; ".join(each.period for each in plan.calibrations)
        message = f"{len(held) or 'None'} of the calibrations of column {plan.source_name!r} ({periods}) hold on {day}"
        message += ": correct `from` and `until` in its profile, or the day with `--day YYYY-MM-DD`."
        findings.add(FILE, "calibration_unclear", message, column=plan.source_name, value=day)
        return raw
    (chosen,) = held
    message = f"Calibrated: {chosen.sentence(plan.source_name, plan.channel, plan.calibrated_unit)}."
    findings.add(NOTE, "calibrated", message, column=plan.source_name)
    return dataclasses.replace(
        plan, scale=plan.scale * chosen.scale, offset=plan.scale * chosen.offset + plan.offset, calibrations=(chosen,)
    )
