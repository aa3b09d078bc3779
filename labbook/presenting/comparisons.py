"""Comparisons, analyses of variance and recomputed headlines as a report shows them."""

from __future__ import annotations

import json

from labbook.analysis import pairing
from labbook.analysis.study import Compared, StudyAnalysis
from labbook.presenting.design import factor_title
from labbook.presenting.numbers import Shown
from reports.content import Anova, Comparison, Quantity, ReportContent, Sensitivity, Variant
from reports.naming import levels_name


def comparisons(analysis: StudyAnalysis, shown: Shown) -> tuple[Comparison, ...]:
    """Return all comparisons; the pooled one with the largest savings is the headline."""
    best = headline(analysis)
    return tuple(_comparison(item, shown, _family(analysis, item), headline=item is best) for item in analysis.compared)


def jump_comparisons(analysis: StudyAnalysis, shown: Shown) -> tuple[Comparison, ...]:
    """Return the thesis's route to apex heights: the pooled comparisons over single jumps."""
    return tuple(_comparison(item, shown, item.pair.family, headline=False) for item in analysis.jump_tests)


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
        if item.pair.family == pairing.POOLED and item.quantity is Quantity.JOULES and _savings(item) is not None
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
        found.append(Anova(item.label, item.quantity, item.group, test, payload["n"], p.provenance))
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
                f"{'savings' if item.quantity is Quantity.JOULES else 'difference of apex height'}, "
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


def _headline_number(quantity: Quantity) -> str:
    """Name the number that the claim states, with the test and the interval it states."""
    return "savings" if quantity is Quantity.JOULES else "welch_difference"


def _savings(item: Compared) -> float | None:
    return next((number.value for number in item.result.numbers if number.name == "savings"), None)


def _comparison(item: Compared, shown: Shown, family: str, *, headline: bool) -> Comparison:
    payload = json.loads(item.result.payload_json)
    n_a, n_b = payload["n_a"], payload["n_b"]
    return Comparison(
        label=item.pair.label,
        quantity=item.quantity,
        group=item.pair.group,
        level=item.pair.level,
        n_control=n_a,
        n_treatment=n_b,
        variance_test=shown.test(item.result, "F-test", "f", "f_p", (float(n_b - 1), float(n_a - 1))),
        test=shown.test(item.result, payload["test"], "t", "p"),
        difference=shown.number(item.result, "difference"),
        welch=shown.test(item.result, "Welch", "welch_t", "welch_p"),
        welch_difference=shown.number(item.result, "welch_difference"),
        savings=shown.number(item.result, "savings")
        if item.pair.with_savings and item.quantity is Quantity.JOULES
        else None,
        family=family,
        headline=headline,
    )
