"""The test by shared days that decides a comparison in a report, of any values with days, in the report's words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.deciding import DecisionResult, decided_by
from labbook.analysis.observations import Observation, Observations
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.numbers import Shown
from labbook.presenting.report.comparisons import decision
from labbook.presenting.stats.days import has_days
from reports.decided_sentences import ELSEWHERE, Words, decided_text, saving_text
from reports.display import MINUS, NO_BREAK, shown_unit
from reports.numbers import Number
from reports.wording import count_text, in_sentence
from stats.days.decision import Rule, contrast_by_day
from stats.groups.multiple import HolmFamily, holm


@dataclass(frozen=True, slots=True)
class DecidedGroups:
    """The deciding test of every group, by label, against the control; several are a family, adjusted by Holm."""

    observed: Observations
    results: Mapping[str, DecisionResult]
    family: HolmFamily | None

    def savings(self) -> dict[str, Number]:
        """Return the savings of every group by label, where they were asked for."""
        return {label: result.savings for label, result in self.results.items() if result.savings is not None}

    def sentence(self, label: str) -> str:
        """Say by which rule a group is compared with the control, and what it found, as a report does."""
        result, name, control = (
            self.results[label],
            self.observed.name(label),
            self.observed.name(self.observed.control),
        )
        value = "run" if self.observed.plan else "value"
        lead = decision(result, Shown().of_sides((name, control), value))
        if self.family is not None:
            at = list(self.results).index(label)
            adjusted, rejected = self.family.adjusted_p[at], self.family.rejected[at]
            lead = replace(
                lead,
                adjusted=Number(adjusted, "1", n=len(self.results)),
                adjusted_rejected=None if isinstance(rejected, Undefined) else rejected,
            )
        days = f", {count_text(len(result.days), 'day')}" if result.days else ""
        elsewhere = f" {ELSEWHERE}" if result.rule is Rule.WITHIN else ""
        said = decided_text(lead, _words(self.observed, name, control, of_savings=result.savings is not None))
        text = f"By shared days ({result.rule}{days}): {said}{elsewhere}"
        return text.replace(NO_BREAK, " ").replace(MINUS, "-")

    def data(self) -> list[dict[str, Any]]:
        """Return the tests for programs; differences are of the group from the control."""
        found = []
        for at, (label, result) in enumerate(self.results.items()):
            data: dict[str, Any] = {
                "a": self.observed.name(label),
                "b": self.observed.name(self.observed.control),
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
                "rejected": result.rejected,
            }
            if self.family is not None:
                data["adjusted_p"] = self.family.adjusted_p[at]
            found.append(data)
        return found


def decided_groups(observed: Observations, alpha: float, *, savings: bool = False) -> DecidedGroups | None:
    """Decide about every group by the days that it shares with the control, with savings of any quantity if asked.

    None where days are not known, or where the plan counts runs or days and not what is shared.
    """
    settings = observed.settings
    if not has_days(observed) or (settings and settings.unit_of_analysis is not UnitOfAnalysis.SHARED_DAYS):
        return None
    known = observed.known()
    has_savings = savings or (observed.plan is not None and observed.measured.has_savings)
    control = [row for row in known.rows if row.label == known.control]
    # A table's values stay in their unit, where a report has thousandths of metres and seconds
    unit = observed.unit if observed.plan or shown_unit(observed.unit)[1] == 1.0 else ""
    results, logs = {}, {}
    for label in observed.others():
        treated = [row for row in known.rows if row.label == label]
        contrast = contrast_by_day(
            [_value(row) for row in treated],
            [_value(row) for row in control],
            days_treated=[row.day for row in treated],
            days_control=[row.day for row in control],
            shared_treated=[row.shared for row in treated],
            shared_control=[row.shared for row in control],
            strata_treated=[", ".join(row.pooled) or "all" for row in treated],
            strata_control=[", ".join(row.pooled) or "all" for row in control],
        )
        shares_error = any(row.shared.se > 0.0 for row in known.rows)
        results[label] = decided_by(contrast, unit, alpha, has_savings, shares_error)
        logs[observed.name(label)] = contrast.difference(1.0 - alpha).log10_p
    if len(results) == 1:
        return DecidedGroups(observed, results, None)
    names = {observed.name(label): result.p.value for label, result in results.items()}
    return DecidedGroups(observed, results, holm(names, "by shared days", log10_p=logs, alpha=alpha))


def _value(row: Observation) -> float:
    assert row.value is not None  # noqa: S101 - of known values
    return float(row.value)


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
