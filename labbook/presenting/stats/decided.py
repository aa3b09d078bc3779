"""The test by shared days that decides a comparison in a report, of any values with days, in the report's words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparing import EquivalenceResult
from labbook.analysis.comparison.deciding import DecisionResult, decide_by_contrast, equivalence_by_contrast
from labbook.analysis.observations import Observations
from labbook.config.model import Bounds, UnitOfAnalysis
from labbook.presenting.numbers import ShownNumbers
from labbook.presenting.report.comparisons import decision, equivalence
from labbook.presenting.stats.days import has_days
from reports.decided_sentences import ELSEWHERE, Words, decided_text, saving_text, within_text
from reports.display import (
    MINUS,
    NO_BREAK,
    as_shown,
    count_text,
    in_sentence,
    places_of,
    shown_unit,
    value_text,
    with_unit,
)
from reports.numbers import Number
from stats.days.decision import Contrast, Rule, contrast_by_day
from stats.groups.multiple import HolmFamily, holm

IGNORING = "Ignoring days"
"""What a test of values as if they had no days begins with, where days decide."""


@dataclass(frozen=True, slots=True)
class DecidedGroups:
    """The deciding test of every group, by label, against the control; several are a family, adjusted by Holm."""

    observed: Observations
    results: Mapping[str, DecisionResult]
    family: HolmFamily | None

    def savings(self) -> dict[str, Number]:
        """Return the savings of every group by label, where they were asked for."""
        return {label: result.savings for label, result in self.results.items() if result.savings is not None}

    def differences(self) -> dict[str, Number]:
        """Return the difference of every group from the control by label, in the values' unit."""
        unit = self.observed.unit
        return {label: replace(result.difference, unit=unit) for label, result in self.results.items()}

    def sentence(self, label: str) -> str:
        """Say by which rule a group is compared with the control, and what it found, as a report does."""
        result, (name, control) = self.results[label], _sides(self.observed, label)
        lead = decision(result, _shown(self.observed, label))
        if self.family is not None:
            at = list(self.results).index(label)
            adjusted, rejected = self.family.adjusted_p[at], self.family.rejected[at]
            lead = replace(
                lead,
                adjusted=Number(adjusted, "1", n=len(self.results)),
                adjusted_rejected=None if isinstance(rejected, Undefined) else rejected,
            )
        sentence = decided_text(lead, _words(self.observed, name, control, of_savings=result.savings is not None))
        return _opened(result.rule, result.days, sentence, shown=lead.rejected is True)

    def data(self) -> list[dict[str, Any]]:
        """Return the tests for programs; differences are of the group from the control."""
        found = []
        for at, (label, result) in enumerate(self.results.items()):
            data: dict[str, Any] = {
                **dict(zip("ab", _sides(self.observed, label), strict=True)),
                "rule": str(result.rule),
                "days": list(result.days),
                "n_a": result.n_treated,
                "n_b": result.n_control,
                "other_days": result.other,
                **_estimate("difference", result.difference),
                **({} if result.savings is None else _estimate("savings_percent", result.savings)),
                "t": result.t.value,
                "df": result.t.df,
                "p": result.p.value,
                "one_sided": result.one_sided,
                "rejected": result.rejected,
            }
            if self.family is not None:
                data["adjusted_p"] = self.family.adjusted_p[at]
            found.append(data)
        return found


@dataclass(frozen=True, slots=True)
class DecidedEquivalence:
    """The deciding test of every group, by label, that it differs from the control by less than the bounds."""

    observed: Observations
    contrasts: Mapping[str, Contrast]
    results: Mapping[str, EquivalenceResult]

    def differences(self) -> dict[str, Number]:
        """Return the difference of every group from the control by label, in the unit of the bounds."""
        return {
            label: replace(result.estimate, unit="%" if result.percent else self.observed.unit)
            for label, result in self.results.items()
        }

    def sentence(self, label: str) -> str:
        """Say by which rule a group is tested against the bounds, and what was found, as a report does."""
        contrast, (name, control) = self.contrasts[label], _sides(self.observed, label)
        item = equivalence(self.results[label], _shown(self.observed, label))
        number = as_shown(item.estimate)
        if isinstance(item.p, Undefined) or isinstance(number.value, Undefined):
            why = item.p if isinstance(item.p, Undefined) else number.value
            sentence = f"Whether {name} minus {control} lies within the bounds cannot be told: {value_text(why)}."
        else:
            size = with_unit(value_text(number.value, places_of(item.estimate)), number.unit)
            sentence = within_text(item, f"{name} minus {control} is {size} and", control)
        return _opened(contrast.rule, contrast.days, sentence, shown=item.shown is True)

    def data(self) -> list[dict[str, Any]]:
        """Return the tests for programs; differences are of the group from the control, in the unit of the bounds."""
        return [
            {
                **dict(zip("ab", _sides(self.observed, label), strict=True)),
                "rule": str(contrast.rule),
                "days": list(contrast.days),
                "n_a": contrast.n[1],
                "n_b": contrast.n[0],
                **_estimate("estimate", result.estimate),
                "t_low": result.t_low.value,
                "t_high": result.t_high.value,
                "df": result.t_low.df,
                "p": result.p.value,
                "equivalent": result.equivalent,
            }
            for label, result in self.results.items()
            for contrast in [self.contrasts[label]]
        ]


def _sides(observed: Observations, label: str) -> tuple[str, str]:
    """Name a group and the control."""
    return observed.name(label), observed.name(observed.control)


def _shown(observed: Observations, label: str) -> ShownNumbers:
    return ShownNumbers().of_sides(_sides(observed, label), "run" if observed.plan else "value")


def shared_days_decide(observed: Observations) -> bool:
    """Tell whether days are known, and the plan leaves the test to those that are shared."""
    settings = observed.settings
    return has_days(observed) and (not settings or settings.unit_of_analysis is UnitOfAnalysis.SHARED_DAYS)


def decide_groups(observed: Observations, alpha: float, *, savings: bool = False) -> DecidedGroups | None:
    """Decide about every group by the days that it shares with the control, with savings of any quantity if asked.

    At the alpha decided on, a saving of the outcome is tested against the side that was decided on.
    None where shared days do not decide.
    """
    if not shared_days_decide(observed):
        return None
    settings, planned = observed.settings, observed.plan is not None and observed.measured.has_savings
    has_savings = savings or planned
    one_sided = planned and settings is not None and settings.one_sided and math.isclose(alpha, settings.alpha)
    unit, shares_error = _unit(observed), any(row.shared.se > 0.0 for row in observed.known().rows)
    results, logs = {}, {}
    for label, contrast in _contrasts(observed).items():
        results[label] = decide_by_contrast(contrast, unit, alpha, has_savings, shares_error, one_sided=one_sided)
        logs[observed.name(label)] = contrast.difference(1.0 - alpha).log10_p
    if len(results) == 1:
        return DecidedGroups(observed, results, None)
    names = {observed.name(label): result.p.value for label, result in results.items()}
    return DecidedGroups(observed, results, holm(names, "by shared days", log10_p=logs, alpha=alpha))


def decide_group_equivalence(observed: Observations, bounds: Bounds, alpha: float) -> DecidedEquivalence | None:
    """Test every group against the bounds, in percent or in the values' unit, by the days shared with the control.

    None where shared days do not decide.
    """
    if not shared_days_decide(observed):
        return None
    contrasts, results = _contrasts(observed), {}
    for label, contrast in contrasts.items():
        result = equivalence_by_contrast(contrast, bounds, alpha)
        unit = "%" if bounds.percent else _unit(observed)
        results[label] = replace(result, estimate=replace(result.estimate, unit=unit))
    return DecidedEquivalence(observed, contrasts, results)


def _contrasts(observed: Observations) -> dict[str, Contrast]:
    """Return the contrast of every group with the control by the days that both share, by label."""
    known = observed.known()
    control = [row for row in known.rows if row.label == known.control]
    found = {}
    for label in observed.others():
        treated = [row for row in known.rows if row.label == label]
        found[label] = contrast_by_day(
            [float(value) for value in known.values(label)],
            [float(value) for value in known.values(known.control)],
            days_treated=[row.day for row in treated],
            days_control=[row.day for row in control],
            shared_treated=[row.shared for row in treated],
            shared_control=[row.shared for row in control],
            strata_treated=[", ".join(row.pooled) or "all" for row in treated],
            strata_control=[", ".join(row.pooled) or "all" for row in control],
        )
    return found


def _unit(observed: Observations) -> str:
    """Return the unit of differences: a table's values stay in theirs, where a report has thousandths of m and s."""
    return observed.unit if observed.plan or shown_unit(observed.unit)[1] == 1.0 else ""


def _opened(rule: Rule, days: tuple[str, ...], sentence: str, *, shown: bool) -> str:
    """Open a sentence with the rule and the days that it is by, in letters that a terminal has."""
    count = f", {count_text(len(days), 'day')}" if days else ""
    elsewhere = f" {ELSEWHERE}" if shown and rule is Rule.WITHIN else ""
    return f"By shared days ({rule}{count}): {sentence}{elsewhere}".replace(NO_BREAK, " ").replace(MINUS, "-")


def _estimate(name: str, number: Number) -> dict[str, Any]:
    ends = (number.ci_low, number.ci_high)
    undefined = next((end for end in ends if isinstance(end, Undefined)), None)
    return {name: number.value, f"{name}_ci": list(ends) if undefined is None else undefined}


def _words(observed: Observations, name: str, control: str, *, of_savings: bool) -> Words:
    against = f" against {control}"
    if observed.plan is not None and observed.measured.has_savings:
        return Words(
            f"{name} saves energy{against}",
            f"a saving by {name}{against}",
            lambda value, size: saving_text(name, value, size, against),
        )
    what, (more, less) = observed.quantity, ("higher", "lower")
    if observed.plan is not None:
        what, (more, less) = f"the {in_sentence(what)}", observed.measured.comparative
    elif shown_unit(observed.unit)[1] != 1.0 and not of_savings:
        what = f"{what} ({observed.unit})"

    def effect(value: float, size: str) -> str:
        lower = value > 0 if of_savings else value < 0
        return f"{what} was {size} {less if lower else more} under {name} than under {control}"

    if of_savings:
        return Words(f"{name} saves {what}{against}", f"a saving of {what} by {name}{against}", effect)
    return Words(
        f"{what} differs between {name} and {control}",
        f"a difference of {what} between {name} and {control}",
        effect,
    )
