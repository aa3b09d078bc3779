"""Where a method used is known to err more often than it states, as simulated for designs such as the report's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from labbook.presenting.report.day_layout import WHOSE
from labbook.presenting.report.error_rate_uses import Use
from labbook.presenting.report.spreads import spreads_text
from reports.display import general_text, stated_text
from reports.wording import count_text, list_text
from stats.planning.recorded import SIZE, Recorded

NAMES = {
    "f_then_t": "the t-test that the F-test chooses",
    "difference_ci_f_then_t": "the interval of the t-test that the F-test chooses",
    "welch": "Welch's t-test",
    "brown_forsythe": "Brown and Forsythe's test",
    "difference_ci_welch": "Welch's interval",
    "blocked_by_day": "the test by day",
    "blocked_by_day_ci": "the interval by day",
    "blocked_by_day_exact": "the exact test by day",
    "blocked_by_day_exact_ci": "the exact test's interval by day",
    "equivalence": "TOST",
    "equivalence_percent": "TOST",
    "fieller": "Fieller's interval",
    "one_way_anova": "the analysis of variance",
    "passive_drain_slope_ci": "the interval of the passive drain",
    "passive_drain_intercept_ci": "the interval of the passive charge at once",
    "passive_drain_middle_ci": "the interval of the passive charge of a run",
    "passive_drain_at_ci": "the interval of the passive charge of a run",
}
"""What is looked up on record, by name of the method, in words."""

_Found = tuple[str, Recorded, int, int]
"""What a method is called, what is on record of it, for how many uses here that is nearest, and how many err less."""


def known_error_rates(used: Mapping[Use, int]) -> tuple[str, ...]:
    """Say for each method used so often, at its worst, how far size or coverage is off; nothing where none is.

    An introduction first, then a sentence for each design on record. Comparisons whose sides do not share their days
    stand apart: there all but the test by day take days for the treatment.
    """
    worst: dict[tuple[str, str], Recorded] = {}
    nearest: Counter[tuple[str, Recorded]] = Counter()
    concerned: Counter[tuple[str, str]] = Counter()
    for use, count in used.items():
        of_use: dict[str, Recorded] = {}
        for row in use.weak_points():
            of_use[row.layout] = max(of_use.get(row.layout, row), row, key=lambda row: row.excess)
        for layout, row in of_use.items():
            nearest[use.method, row] += count
            concerned[use.method, layout] += count
            worst[use.method, layout] = max(worst.get((use.method, layout), row), row, key=lambda row: row.excess)
    if not worst:
        return ()
    by_design: dict[str, list[_Found]] = {}
    for (method, layout), row in worst.items():
        own = nearest[method, row]
        less = concerned[method, layout] - own
        by_design.setdefault(_design_text(row), []).append((NAMES[method], row, own, less))
    told = [f"At {design}: {_all_said(found)}." for design, found in by_design.items()]
    head = (
        "Simulated at the sizes and days on record nearest to these (docs/statistics.md), not every method keeps what "
        "it states whatever the standard deviations of runs and days, which so few runs do not tell."
    )
    days = {bool(row.days) for row in worst.values()}
    if len(days) > 1:
        head += " Designs without days show what unequal standard deviations do, those with days what days do beside."
    return head, *told


def _design_text(row: Recorded) -> str:
    """Say which design on record this was simulated at."""
    if len(row.n) == 1:
        spread = f", should the longest scatter {row.sd_ratio:g} times as much as the shortest"
        return f"{count_text(row.n[0], 'idle run')}{spread if row.sd_ratio != 1.0 else ''}"
    line = f", corrected with {count_text(row.idle_runs, 'idle run')}" if row.idle_runs else ""
    days = ""
    if row.days is not None:
        apart = "as much as runs" if row.day_sd == 1.0 else f"{row.day_sd:g} times as much as runs"
        days = f", each group on {count_text(row.days, 'day')} {WHOSE[row.layout]}, days differing {apart}"
    return f"n = {list_text([str(n) for n in row.groups])}{line}{spreads_text(row)}{days}"


def _all_said(found: Sequence[_Found]) -> str:
    """Say what was found at one design, tests and intervals apart, and where this report comes near it."""
    kinds: dict[tuple[tuple[str, str], float], list[_Found]] = {}
    for each in found:
        kinds.setdefault((_of_what(each[1]), each[1].nominal), []).append(each)
    return "; ".join(_said(*what, nominal, of_kind) for (what, nominal), of_kind in kinds.items())


def _of_what(row: Recorded) -> tuple[str, str]:
    """Return what a method does, and in how many of which studies its share is."""
    if row.kind != SIZE:
        return "holds the truth in", ""
    if row.method.startswith("equivalence"):
        return "claims equivalence in", " of studies whose true difference lies on a bound"
    return "rejects", " of studies without an effect"


def _said(verb: str, of: str, nominal: float, found: Sequence[_Found]) -> str:
    """Say what methods of one kind do, what they state once; the numbers of uses are those of the methods in turn."""
    stated = f"({stated_text(100.0 * nominal)} % stated)"
    (first, row, *_uses), *others = found
    said = [f"{first} {verb} {_share(row)}{of} {stated}"]
    said += [f"{name} {'in ' if verb.endswith(' in') else ''}{_share(row)}" for name, row, *_uses in others]
    uses = _uses_text([own for _name, _row, own, _less in found])
    less = [less for _name, _row, _own, less in found]
    more = f", {_uses_text(less)} that err{'s' if less == [1] else ''} less" if any(less) else ""
    return f"{', '.join(said)} ({uses} here{more})"


def _uses_text(counts: Sequence[int]) -> str:
    if len({*counts}) == 1:
        return f"{count_text(counts[0], 'use')}{' of each' if len(counts) > 1 else ''}"
    return f"{list_text([str(count) for count in counts])} uses"


def _share(row: Recorded) -> str:
    return f"{general_text(100.0 * row.value)} %"
