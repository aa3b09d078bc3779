"""Where a method used is known to err more often than it states, as simulated for designs such as the report's."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from data_schema.vocabulary import Undefined
from labbook.analysis.comparisons import Compared
from labbook.analysis.conditions import ConditionValues
from labbook.analysis.leading_by_day import MIXED_MODEL
from labbook.analysis.passive_drain import idle_charges
from labbook.analysis.study import StudyAnalysis
from labbook.analysis.workbench import number
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.day_layout import MOSTLY, OWN, PARTLY, WHOSE, Runs, with_days, without_days
from reports.display import general_text
from reports.numbers import Quantity
from reports.wording import count_text, list_text
from stats.passive_drain import PassiveDrain, rounding_sd_mah
from stats.recorded import WITH_LINE, Recorded, weak_points

IN_STEPS = "in_steps_"
"""In the name of what is on record of a drain line whose runs scatter less than the charger's steps."""
_NAMES = {
    "f_then_t": "the t-test that the F-test chooses",
    "difference_ci_f_then_t": "the interval of the t-test that the F-test chooses",
    "welch": "Welch's t-test",
    "brown_forsythe": "Brown and Forsythe's test",
    "difference_ci_welch": "Welch's interval",
    "blocked_by_day": "the test by day",
    "blocked_by_day_ci": "the interval by day",
    "blocked_by_day_exact": "the exact test by day",
    "equivalence": "TOST",
    "equivalence_percent": "TOST",
    "fieller": "Fieller's interval",
    "one_way_anova": "the analysis of variance",
    "passive_drain_slope_ci": "the interval of the passive drain",
    "passive_drain_intercept_ci": "the interval of the passive charge at once",
    "passive_drain_at_ci": "the interval of the passive charge of the longest idle run",
}
_NAMES |= {name.replace("passive_drain_", f"passive_drain_{IN_STEPS}"): said for name, said in _NAMES.items()}
_WITH_LINE = ("f_then_t", "difference_ci_f_then_t", "welch", "difference_ci_welch", "fieller")
"""What takes the error of the passive-drain line into account."""
_MIXED, _EXACT = ("blocked_by_day", "blocked_by_day_ci"), ("blocked_by_day_exact",)
_BY_DAY = (*_MIXED, *_EXACT)

_Found = tuple[str, Recorded, int]
"""What a method is called, what is on record of it, and how often it is used here on about such a design."""


@dataclass(frozen=True, slots=True)
class Use:
    """A method and a design that it was used on.

    `n` counts what was tested of each group, runs or day means; `days` and `layout` are those of the design on record
    that stands for how groups share their days (`day_layout`). Day means have neither: a day is one value. `tested` are
    the groups' own sizes where that design has others: groups of unequal size err whatever their days are. `idle_runs`
    counts those of the line whose error is in the result, 0 where there is none.
    """

    method: str
    n: tuple[int, ...]
    days: int | None = None
    layout: str = ""
    tested: tuple[int, ...] = ()
    idle_runs: int = 0

    def weak_points(self) -> tuple[Recorded, ...]:
        """Return what is on record of the method at such a design; days matter where groups do not share them all."""
        by_day = self.method in _BY_DAY
        rows: tuple[Recorded, ...] = ()
        if by_day or self.layout in (OWN, PARTLY, MOSTLY):
            rows = weak_points(self.method, self.n, self.days, layout=self.layout)
        if by_day:
            return rows
        method = f"{self.method}{WITH_LINE}" if self.idle_runs else self.method
        return *rows, *weak_points(method, self.tested or self.n, layout="", idle_runs=self.idle_runs)


def weaknesses(analysis: StudyAnalysis) -> str:
    """Say for each method used, at its worst, how far size or coverage is off; "" where nothing on record is.

    A sentence stands for each design on record. Comparisons whose sides do not share their days stand apart: there all
    but the test by day take days for the treatment.
    """
    worst: dict[tuple[str, str], Recorded] = {}
    concerned: Counter[tuple[str, str]] = Counter()
    for use, count in Counter((*_of_comparisons(analysis), *_of_anovas(analysis), *_of_drains(analysis))).items():
        for row in use.weak_points():
            key = (use.method, row.layout)
            if key not in worst or _off(row) > _off(worst[key]):
                worst[key] = row
        concerned.update({(use.method, layout): count for layout in {row.layout for row in use.weak_points()}})
    if not worst:
        return ""
    by_design: dict[str, list[_Found]] = {}
    for key, row in worst.items():
        by_design.setdefault(_design_text(row), []).append((_NAMES[key[0]], row, concerned[key]))
    told = [f"At {design}: {_all_said(found)}." for design, found in by_design.items()]
    head = (
        "Simulated at sizes and days such as these (docs/statistics.md), not every method keeps what it states "
        "whatever the standard deviations of runs and days, which so few runs do not tell."
    )
    return " ".join([head, *told])


def _of_comparisons(analysis: StudyAnalysis) -> Iterator[Use]:
    for item in analysis.compared:
        payload = json.loads(item.result.payload_json)
        sides = (item.pair.a, item.pair.b)
        for method in _methods(analysis, item):
            idle_runs = _idle_runs(analysis, item, method) if method in _WITH_LINE else 0
            if method in _BY_DAY or not _on_day_means(analysis):  # by day it is runs, whatever the other tests are on
                yield replace(on_runs(method, _by_day(sides)), idle_runs=idle_runs)
            else:
                yield Use(method, (payload["n_a"], payload["n_b"]), idle_runs=idle_runs)


def _idle_runs(analysis: StudyAnalysis, item: Compared, method: str) -> int:
    """Return the idle runs of the line whose error is left in what a method says, the fewest of any robot's; or 0."""
    if item.quantity is not Quantity.JOULES:
        return 0
    if not number(item.result, "savings" if method == "fieller" else "difference").shared_se:
        return 0
    return min((drain.line.n for drain in analysis.drains.values() if isinstance(drain.line, PassiveDrain)), default=0)


def _on_day_means(analysis: StudyAnalysis) -> bool:
    return analysis.planned.settings.unit_of_analysis is UnitOfAnalysis.DAY


def on_runs(method: str, by_day: Runs) -> Use:
    """Return the use of a method on groups of runs, given how many there are of each day."""
    if method in _BY_DAY:
        return Use(method, *with_days(by_day))
    return Use(method, *without_days(method, by_day), tested=tuple(group.total() for group in by_day))


def _by_day(groups: Sequence[Sequence[ConditionValues]]) -> list[Counter[str]]:
    return [Counter(one.run.day for condition in group for one in condition.runs) for group in groups]


def _methods(analysis: StudyAnalysis, item: Compared) -> Iterator[str]:
    if number(item.result, "t").value is not None:
        yield from ("f_then_t", "difference_ci_f_then_t")
    if number(item.result, "welch_t").value is not None:
        yield from ("welch", "difference_ci_welch")
    if number(item.result, "brown_forsythe").value is not None:
        yield "brown_forsythe"
    if item.by_day is not None and number(item.by_day, "t").value is not None:
        yield from _MIXED if json.loads(item.by_day.payload_json)["method"] == MIXED_MODEL else _EXACT
    bounds = analysis.planned.settings.apex_bounds
    if bounds is not None and item.equivalent is not None and number(item.equivalent, "p").value is not None:
        yield "equivalence_percent" if bounds.percent else "equivalence"
    if (
        item.quantity is Quantity.JOULES
        and item.pair.with_savings
        and number(item.result, "savings").ci_low is not None
    ):
        yield "fieller"


def _of_anovas(analysis: StudyAnalysis) -> Iterator[Use]:
    for item in analysis.anovas:
        levels = [(one,) for one in analysis.levels_of(item)]
        if _on_day_means(analysis):
            yield Use("one_way_anova", tuple(map(len, _by_day(levels))))
        else:
            yield on_runs("one_way_anova", _by_day(levels))


def _of_drains(analysis: StudyAnalysis) -> Iterator[Use]:
    for robot, drain in analysis.drains.items():
        if isinstance(drain.line, Undefined):
            continue
        idle = [charge for run, charge in idle_charges(analysis.evidence) if run.robot_uid == robot]
        rounded = drain.line.residual_sd_mah <= rounding_sd_mah(max(charge.resolution_mah for charge in idle))
        for of in ("slope", "intercept", "at"):
            yield Use(f"passive_drain_{IN_STEPS if rounded else ''}{of}_ci", (drain.line.n,))


def _off(row: Recorded) -> float:
    return abs(row.value - row.nominal)


def _design_text(row: Recorded) -> str:
    """Say which design on record this was simulated at."""
    spreads = f", should {_spreads_text(row)}" if row.sd_ratio != 1.0 else ""
    days = ""
    if row.days is not None:
        apart = "as much as runs" if row.day_sd == 1.0 else f"{row.day_sd:g} times as much as runs"
        days = f", each group on {count_text(row.days, 'day')} {WHOSE[row.layout]}, days differing {apart}"
    if len(row.n) == 1:
        within = " that scatter less than the charger's steps" if IN_STEPS in row.method else ""
        return f"{count_text(row.n[0], 'idle run')}{within}{spreads}"
    line = f", corrected with {count_text(row.idle_runs, 'idle run')}" if row.idle_runs else ""
    return f"n = {list_text([str(n) for n in row.groups])}{line}{spreads}{days}"


def _spreads_text(row: Recorded) -> str:
    if len(row.n) == 1:
        return f"the longest scatter {row.sd_ratio:g} times as much as the shortest"
    if row.idle_runs:
        sds = [row.sd_ratio ** (1.0 - place / len(row.groups)) for place in range(len(row.n))]
        return f"standard deviations of groups and idle runs be {' : '.join(general_text(sd, 2) for sd in sds)}"
    return f"standard deviations be {row.sd_ratio:g} : 1"


def _all_said(found: Sequence[_Found]) -> str:
    """Say what was found at one design, tests and intervals apart, and where this report comes near it."""
    kinds: dict[tuple[str, float], list[_Found]] = {}
    for name, row, uses in found:
        kinds.setdefault((row.kind, row.nominal), []).append((name, row, uses))
    return "; ".join(_said(kind, nominal, of_kind) for (kind, nominal), of_kind in kinds.items())


def _said(kind: str, nominal: float, found: Sequence[_Found]) -> str:
    """Say what methods of one kind do, what they state once; the numbers of uses are those of the methods in turn."""
    stated = f"({general_text(100.0 * nominal)} % stated)"
    verb, of = ("rejects", " of studies without an effect") if kind == "size" else ("holds the truth in", "")
    (first, row, _uses), *others = found
    said = [f"{first} {verb} {_share(row)}{of} {stated}"]
    said += [f"{name} {'' if kind == 'size' else 'in '}{_share(row)}" for name, row, _uses in others]
    counts = [uses for _name, _row, uses in found]
    if len({*counts}) == 1:
        uses = f"{count_text(counts[0], 'use')}{' of each' if others else ''}"
    else:
        uses = f"{list_text([str(count) for count in counts])} uses"
    return f"{', '.join(said)} ({uses} here of about such sizes)"


def _share(row: Recorded) -> str:
    return f"{general_text(100.0 * row.value, 3)} %"
