"""Comparisons, analyses of variance and recomputed headlines as a report shows them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.queries.results import ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.comparison.family import adjusted, rejected
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.numbers import Shown, side_names, values_as
from labbook.presenting.report.design import factor_title
from labbook.presenting.report.one_day_each import one_day_each
from reports.content import Anova, Comparison, ReportContent, Sensitivity, Variant
from reports.inference import ByDay, Equivalence, Side
from reports.naming import levels_name
from reports.numbers import SignificanceTest


def comparisons(analysis: StudyAnalysis, shown: Shown) -> tuple[Comparison, ...]:
    """Return all comparisons; the pooled one with the largest savings is the headline."""
    best = headline(analysis)
    return tuple(
        _comparison(analysis, item, shown, _family(analysis, item), headline=item is best) for item in analysis.compared
    )


def jump_comparisons(analysis: StudyAnalysis, shown: Shown) -> tuple[Comparison, ...]:
    """Return the thesis's route to apex heights: the pooled comparisons over single jumps."""
    why = analysis.planned.exploratory_jumps()
    return tuple(replace(_tested(item, shown, item.pair.family), exploratory=why) for item in analysis.jump_tests)


def _family(analysis: StudyAnalysis, item: Compared) -> str:
    """Name a family of comparisons with the factors' titles in place of their names."""
    for name in analysis.evidence.configuration.factors:
        for pattern in (pairing.ACROSS, pairing.BETWEEN):
            if item.pair.family == pattern.format(factor=name):
                return pattern.format(factor=factor_title(analysis, name).lower())
    return item.pair.family


def headline(analysis: StudyAnalysis) -> Compared | None:
    """Return the pooled comparison of joules with the largest savings, as the thesis reports it (5.2.1)."""
    pooled = [
        item
        for item in analysis.compared
        if item.pair.family == pairing.POOLED and item.quantity is Outcome.JOULES and _savings(item) is not None
    ]
    return max(pooled, key=lambda item: _savings(item) or 0.0, default=None)


def anovas(analysis: StudyAnalysis, shown: Shown) -> tuple[Anova, ...]:
    """Return the analyses of variance over the swept factor."""
    found = []
    for item in analysis.anovas:
        payload = json.loads(item.result.payload_json)
        df = (float(payload["df_between"]), float(payload["df_within"]))
        test = shown.test(item.result, "one-way ANOVA", "f", "p", df)
        p = shown.number(item.result, "p")
        why = analysis.planned.exploratory_anova()
        levels = {one.levels.get(analysis.swept or "", one.key): (one,) for one in analysis.levels_of(item)}
        days = _days_untold(test, {f"level {label}": side for label, side in levels.items()})
        found.append(Anova(item.label, item.quantity, item.group, test, payload["n"], p.provenance, why, days))
    return tuple(found)


def sensitivity(analysis: StudyAnalysis, shown: Shown, content: ReportContent) -> tuple[Sensitivity, ...]:
    """Return every pooled headline with its recomputations; `content` knows what groups are called."""
    found = []
    for item in analysis.compared:
        if item.pair.family != pairing.POOLED:
            continue
        name = _headline_number(item.quantity)
        found.append(
            Sensitivity(
                f"{'savings' if item.quantity.has_savings else f'difference of {item.quantity}'}, "
                f"{levels_name(content, item.pair.group)}",
                shown.number(item.result, name),
                tuple(
                    Variant(varied.variant, shown.number(varied.result, name))
                    for varied in analysis.variations.varied
                    if varied.headline == item.pair.label and varied.quantity is item.quantity
                ),
            )
        )
    return tuple(found)


def _headline_number(quantity: Outcome) -> str:
    """Name the number that the claim states, with the test and the interval it states."""
    return "savings" if quantity.has_savings else "welch_difference"


def _savings(item: Compared) -> float | None:
    return next((number.value for number in item.result.numbers if number.name == "savings"), None)


def _comparison(analysis: StudyAnalysis, item: Compared, shown: Shown, family: str, *, headline: bool) -> Comparison:
    """Show a comparison on run means with everything that stands beside it."""
    plain = _tested(item, shown, family)
    payload, label = json.loads(item.result.payload_json), item.pair.label
    n = (plain.n_control, plain.n_treatment)
    df = (1.0, float(sum(n) - 2))
    return replace(
        plain,
        savings=shown.number(item.result, "savings") if item.pair.with_savings and item.quantity.has_savings else None,
        brown_forsythe=shown.test(item.result, "Brown-Forsythe", "brown_forsythe", "brown_forsythe_p", df),
        headline=headline,
        sides=(_side(item, shown, "a"), _side(item, shown, "b")),
        by_day=None if item.by_day is None else _by_day(item.by_day, shown),
        adjusted=None if item.adjusted is None else shown.number(item.adjusted, adjusted(label)),
        rejected=payload["rejected"],
        adjusted_rejected=None if item.adjusted is None else rejected(item.adjusted, label),
        savings_shown=payload.get("savings_shown"),
        equivalence=None if item.equivalent is None else _equivalence(analysis, item, item.equivalent, shown),
        exploratory=analysis.planned.exploratory(item.quantity, item.pair.family, item.conditions) or "",
    )


def _tested(item: Compared, shown: Shown, family: str) -> Comparison:
    """Show the thesis's route, and Welch's test beside it."""
    payload = json.loads(item.result.payload_json)
    n_a, n_b = payload["n_a"], payload["n_b"]
    test = shown.test(item.result, payload["test"], "t", "p")
    return Comparison(
        label=item.pair.label,
        quantity=item.quantity,
        group=item.pair.group,
        level=item.pair.level,
        n_control=n_a,
        n_treatment=n_b,
        variance_test=shown.test(item.result, "F-test", "f", "f_p", (float(n_b - 1), float(n_a - 1))),
        test=test,
        difference=shown.number(item.result, "difference"),
        welch=shown.test(item.result, "Welch", "welch_t", "welch_p"),
        welch_difference=shown.number(item.result, "welch_difference"),
        family=family,
        one_day_each=_days_untold(
            test, dict(zip(side_names(item.pair.family), (item.pair.b, item.pair.a), strict=True))
        ),
    )


def _days_untold(test: SignificanceTest, sides: Mapping[str, Sequence[ConditionValues]]) -> str:
    """Say that a test cannot tell its sides from their days, where each had one day; "" where there is no test."""
    if isinstance(test.statistic, Undefined):
        return ""
    return one_day_each({name: {item.run.day for one in side for item in one.runs} for name, side in sides.items()})


def _side(item: Compared, shown: Shown, name: str) -> Side:
    return Side(shown.value(item.result, f"mean_{name}"), shown.value(item.result, f"sd_{name}"))


def _by_day(row: ResultRow, shown: Shown) -> ByDay:
    payload = json.loads(row.payload_json)
    found = ByDay(
        difference=shown.number(row, "difference"),
        test=shown.test(row, "by day", "t", "p"),
        days=payload["days"],
        day_sd=shown.number(row, "day_sd"),
        run_sd=shown.number(row, "run_sd"),
        method=values_as("run", payload["method"]),
        confounding=values_as("run", payload["confounding"]),
        notes=tuple(values_as("run", note) for note in payload["notes"]),
    )
    untested = isinstance(found.test.statistic, Undefined)
    return found if untested else replace(found, test=replace(found.test, name=f"by day ({found.kind})"))


def _equivalence(analysis: StudyAnalysis, item: Compared, row: ResultRow, shown: Shown) -> Equivalence:
    payload = json.loads(row.payload_json)
    return Equivalence(
        estimate=shown.number(row, "estimate"),
        low=payload["low"],
        high=payload["high"],
        at_low=shown.test(row, "lower bound", "t_low", "p_low"),
        at_high=shown.test(row, "upper bound", "t_high", "p_high"),
        p=shown.value(row, "p"),
        shown=payload["equivalent"],
        exploratory=analysis.planned.exploratory_equivalence(item.pair.family, item.conditions) or "",
    )
