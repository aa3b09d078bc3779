"""What a study needs, in lines: what was assumed, a row for each test, and what none of it can know."""

from __future__ import annotations

from data_schema.rounding import interval_text, number_text
from data_schema.vocabulary import Undefined
from labbook.actions.planning.power import Needed, StudyPower
from labbook.actions.planning.power_tests import Assumed
from labbook.analysis.outcomes.conditions import SPREAD_LEVEL
from labbook.analysis.preregistration.planned import FAMILY_OF
from reports.display import shown_unit

_NOT_KNOWN = (
    "Assumed: independent normal values with one standard deviation everywhere, complete runs, and nothing of the "
    "drain's own error, which cancels where durations are equal; {days}. An effect that is smaller is found less often."
)

_OF_DAYS = "what differs between days cancels where a drawn plan gives both sides to a day, and days act on both alike"


def power_head(found: StudyPower) -> list[str]:
    """Say what is assumed and by whose decision."""
    settings, unit = found.planned.settings, found.unit
    decided = (
        "as [analysis] decides"
        if found.planned.stated
        else "by default, for [analysis] decided nothing"
        if found.planned.first_measured_utc is None
        else "though [analysis] decided nothing before the first measurement"
    )
    saving, of_mean = found.saving_percent, ""
    if saving is not None and not isinstance(found.primary.mean, Undefined):
        of_mean = f", {saving:g} % of the control's {_value(found.primary.mean, unit)}"
    mean = found.primary.spread
    so_far = f" (mean of {mean.control_n} so far)" if mean is not None and saving is not None else ""
    lines = [
        f"To be found: a difference of {_value(abs(found.difference), unit)} in {found.outcome}{of_mean}{so_far}.",
        f"Scatter of {found.outcome}: {_scatter(found.primary, unit)}.",
    ]
    if settings.apex_bounds is not None and isinstance(found.apex, Assumed) and found.apex is not found.primary:
        lines.append(f"Scatter of apex height: {_scatter(found.apex, 'm')}.")
    return [
        *lines,
        f"Compared: {FAMILY_OF[settings.family]} of {found.design.swept}, alpha {settings.alpha:g}"
        f"{' one-sided' if settings.one_sided else ''}, {decided}.",
    ]


def power_table(found: StudyPower) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return head and rows: for each test the n of each condition, the size of that plan, and the chance at other n."""
    ns = list(found.needed[0].powers)
    at = [f"at n = {n}" for n in ns]
    head = ("test", "alpha", f"n for {100 * found.target:g} %", "at the CI limits of the SD", "runs", "days", *at)
    return head, [_row(item, ns) for item in found.needed]


def power_foot(found: StudyPower) -> list[str]:
    """Say what the columns mean, and why a row has no numbers."""
    of_plan = ""
    if found.n_of_plan is not None:
        of_plan = f" The plans that stand have n = {found.n_of_plan} or more."
    unknown = [f"{item.test}: {item.sentence}" for item in found.needed if isinstance(item.n, Undefined)]
    notes = [f"{item.test}: {item.note}." for item in found.needed if item.note and not isinstance(item.n, Undefined)]
    pooled = found.design.sizes(1)[1]
    treated = f"; a comparison has n controls or more and {pooled} n treated" if pooled > 1 else ""
    return [
        f"n counts runs of each condition{treated}; runs and days are the study's.{of_plan}",
        *unknown,
        *notes,
        *([] if found.crossing is None else [found.crossing.sentence]),
        *(item.sentence for item in found.needed if not isinstance(item.n, Undefined)),
        _NOT_KNOWN.format(days=_OF_DAYS),
    ]


def _row(item: Needed, ns: list[int]) -> tuple[str, ...]:
    over = "" if item.n_over_sd is None else " to ".join(map(_count, item.n_over_sd))
    powers = (item.powers[n] for n in ns)
    return (
        item.test,
        number_text(item.alpha),
        _count(item.n),
        over,
        _count(item.runs),
        _count(item.days),
        *("-" if isinstance(power, Undefined) else f"{100 * power:.1f} %" for power in powers),
    )


def _count(n: int | Undefined) -> str:
    return "-" if isinstance(n, Undefined) else str(n)


def _scatter(assumed: Assumed, unit: str) -> str:
    sd, (shown, factor) = f"standard deviation {_value(assumed.sd, unit)}", shown_unit(unit)
    spread = assumed.spread
    if spread is None:
        return f"{sd}, as stated"
    return (
        f"{sd} between runs of a condition "
        f"({interval_text((factor * spread.sd_low, factor * spread.sd_high), SPREAD_LEVEL, shown)}, "
        f"{spread.df} degrees of freedom, from {spread.n} so far)"
    )


def _value(value: float, unit: str) -> str:
    shown, factor = shown_unit(unit)
    return f"{number_text(factor * value)} {shown}"
