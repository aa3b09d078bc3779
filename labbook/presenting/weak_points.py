"""Where a method used is known to err more often than it states, as simulated for designs such as the report's."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from labbook.analysis.comparisons import Compared
from labbook.analysis.conditions import ConditionValues
from labbook.analysis.leading_by_day import MIXED_MODEL
from labbook.analysis.study import StudyAnalysis
from labbook.analysis.workbench import number
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.day_layout import MOSTLY, OWN, PARTLY, WHOSE, Runs, with_days, without_days
from reports.display import general_text
from reports.numbers import Quantity
from reports.wording import count_text, list_text
from stats.recorded import Recorded, weak_points

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
}
_MIXED, _EXACT = ("blocked_by_day", "blocked_by_day_ci"), ("blocked_by_day_exact",)
_BY_DAY = (*_MIXED, *_EXACT)

_Found = tuple[str, Recorded, int]
"""What a method is called, what is on record of it, and how often it is used here on about such a design."""


@dataclass(frozen=True, slots=True)
class Use:
    """A method and a design that it was used on.

    `n` counts what was tested of each group, runs or day means; `days` and `layout` are those of the design on record
    that stands for how groups share their days (`day_layout`). Day means have neither: a day is one value. `tested` are
    the groups' own sizes where that design has others: groups of unequal size err whatever their days are.
    """

    method: str
    n: tuple[int, ...]
    days: int | None = None
    layout: str = ""
    tested: tuple[int, ...] = ()

    def weak_points(self) -> tuple[Recorded, ...]:
        """Return what is on record of the method at such a design; days matter where groups do not share them all."""
        by_day = self.method in _BY_DAY
        rows: tuple[Recorded, ...] = ()
        if by_day or self.layout in (OWN, PARTLY, MOSTLY):
            rows = weak_points(self.method, self.n, self.days, layout=self.layout)
        return rows if by_day else (*rows, *weak_points(self.method, self.tested or self.n, layout=""))


def weaknesses(analysis: StudyAnalysis) -> str:
    """Say for each method used, at its worst, how far size or coverage is off; "" where nothing on record is.

    A sentence stands for each design on record. Comparisons whose sides do not share their days stand apart: there all
    but the test by day take days for the treatment.
    """
    worst: dict[tuple[str, str], Recorded] = {}
    concerned: Counter[tuple[str, str]] = Counter()
    for use, count in Counter((*_of_comparisons(analysis), *_of_anovas(analysis))).items():
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
            if method in _BY_DAY:  # on runs, whatever the other tests are on
                yield on_runs(method, _by_day(sides))
            elif _on_day_means(analysis):
                yield Use(method, (payload["n_a"], payload["n_b"]))
            else:
                yield on_runs(method, _by_day(sides))


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


def _off(row: Recorded) -> float:
    return abs(row.value - row.nominal)


def _design_text(row: Recorded) -> str:
    """Say which design on record this was simulated at."""
    spreads = f", should standard deviations be {row.sd_ratio:g} : 1" if row.sd_ratio != 1.0 else ""
    days = ""
    if row.days is not None:
        apart = "as much as runs" if row.day_sd == 1.0 else f"{row.day_sd:g} times as much as runs"
        days = f", each group on {count_text(row.days, 'day')} {WHOSE[row.layout]}, days differing {apart}"
    return f"n = {list_text([str(n) for n in row.n])}{spreads}{days}"


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
