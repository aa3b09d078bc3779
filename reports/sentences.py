"""Words around numbers: names of levels and conditions, gain formulas, the sentence a claim is made in."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, Condition, Factor, Level, ReportContent
from reports.display import (
    EQUALS,
    MINUS,
    NO_BREAK,
    as_shown,
    general_text,
    interval_text,
    level_text,
    places_of,
    significance_text,
    value_text,
    with_unit,
)
from reports.numbers import Number, Quantity
from reports.wording import count_text, list_text, sentence_start

_MEANINGS = {"kg/s": "Damping coefficient", "N/m": "Stiffness"}


_ACTIVE_DAMPING = re.compile(r"\bactive|(^|_)ad(_|$)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class SweptWords:
    """What the treated runs, the control and the swept factor's levels are called in sentences and on axes."""

    treatment: str
    treatment_short: str
    control: str
    control_long: str
    coefficient: str


def swept_words(factor: Factor | None) -> SweptWords:
    """Return the words for a swept factor: those of active damping only where the factor is one, else neutral ones."""
    if factor is not None and (_ACTIVE_DAMPING.search(factor.title) or _ACTIVE_DAMPING.search(factor.name)):
        return SweptWords("active damping", "AD", "CE", "compression-extension (CE)", "active-damping coefficient")
    coefficient = "condition" if factor is None else title_of(factor).lower()
    return SweptWords("the treatment", "treatment", "control", "control", coefficient)


def title_of(factor: Factor) -> str:
    """Return what a factor's physical values are called: its title, or by its unit where the title is only its name."""
    if factor.slope is not None and factor.title == factor.name.replace("_", " "):
        return _MEANINGS.get(factor.unit, factor.title)
    return factor.title


def formula_text(factor: Factor) -> str:
    """Write how gains become physical values: "k = 2.56 g + 67.36 N/m"; "" where the levels are no gains."""
    if factor.slope is None or factor.offset is None:
        return ""
    sign = "+" if factor.offset >= 0 else MINUS
    slope, offset = general_text(factor.slope, 6), general_text(abs(factor.offset), 6)
    text = f"{factor.symbol} = {slope} g {sign} {offset}".replace(" ", NO_BREAK)
    control = swept_words(factor).control
    zero = f"; gain {factor.control} is {control} and stands for 0" if factor.control is not None else ""
    return with_unit(text, factor.unit) + zero


def physical_text(level: Level) -> str:
    """Write a level's physical value, "835.4 N/m", or its label where it has none."""
    return level.label if level.value is None else with_unit(general_text(level.value), level.unit)


def level_name(factor: Factor, level: Level, *, gain: bool = False) -> str:
    """Name a level: "small foot", "k = 1091 N/m"; with `gain`, "k = 1091 N/m (gain 400)"."""
    if level.gain is None:
        return f"{level.label} {factor.title.lower()}"
    beside = f" (gain{NO_BREAK}{general_text(level.gain)})" if gain else ""
    return f"{factor.symbol or factor.title}{EQUALS}{physical_text(level)}{beside}"


def group_name(content: ReportContent, condition: Condition, *, gain: bool = False) -> str:
    """Name what a condition shares with its control: every level but that of the swept factor."""
    pairs = ((factor, condition.level(factor.name)) for factor in content.factors if not factor.swept)
    return ", ".join(level_name(factor, level, gain=gain) for factor, level in pairs if level is not None)


def levels_name(content: ReportContent, group: Mapping[str, str]) -> str:
    """Name a group given as factor -> label; a label that no condition has is shown as it is."""
    return ", ".join(_level_names(content, group))


def _level_names(content: ReportContent, group: Mapping[str, str]) -> list[str]:
    known = _known_levels(content)
    factors = {factor.name: factor for factor in content.factors}
    names = []
    for name, label in group.items():
        level = known.get((name, label))
        names.append(f"{name} {label}" if level is None else level_name(factors[name], level))
    return names


def _known_levels(content: ReportContent) -> dict[tuple[str, str], Level]:
    return {(level.factor, level.label): level for condition in content.conditions for level in condition.levels}


def level_of(content: ReportContent, comparison: Comparison) -> str:
    """Name the level that a comparison sets against its control: "d = 185.7 kg/s (gain 50)" or "pooled".

    Between two levels of a further factor the level carries the other, and its side: "k = 1091 N/m less k = 835.4 N/m,
    treated".
    """
    swept = swept_factor(content)
    if swept is not None:
        for condition in content.conditions:
            level = condition.level(swept.name)
            if level is not None and level.label == comparison.level and not condition.control:
                return level_name(swept, level, gain=True)
    label, _, side = comparison.level.rpartition(", ")
    known = _known_levels(content)
    for factor in content.factors:
        further = None if factor.swept or factor.name in comparison.group else known.get((factor.name, label))
        if further is not None:
            other = _only_other(content, further, comparison.group)
            less = "" if other is None else f" less {level_name(factor, other)}"
            return f"{level_name(factor, further)}{less}, {side}"
    return comparison.level


def _only_other(content: ReportContent, level: Level, group: Mapping[str, str]) -> Level | None:
    """Return the level that a group has beside one, None where it has several: then the label alone says which."""
    others: dict[str, Level] = {}
    for condition in content.conditions:
        known = {found.factor: found for found in condition.levels}
        inside = all(name in known and known[name].label == label for name, label in group.items())
        if inside and level.factor in known and known[level.factor].label != level.label:
            others[known[level.factor].label] = known[level.factor]
    return next(iter(others.values())) if len(others) == 1 else None


def _where(content: ReportContent, comparison: Comparison) -> str:
    """Say for which group a claim holds: " with the small foot and k = 1091 N/m"; "" for all runs."""
    names = _level_names(content, comparison.group)
    parts = [name if "=" in name else f"the {name}" for name in names]
    return f" with {list_text(parts)}" if parts else ""


def swept_factor(content: ReportContent) -> Factor | None:
    """Return the factor on the x axis, None where the study has none."""
    return next((factor for factor in content.factors if factor.swept), None)


def _excludes_zero(number: Number) -> bool | None:
    low, high = number.ci_low, number.ci_high
    if isinstance(low, int | float) and isinstance(high, int | float):
        return low > 0 or high < 0
    return None


def savings_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say what the treatment saved: value, interval, group, n and the Welch test; no more than they show.

    The headline says that it was picked as the largest, and from how many.
    """
    savings, where = comparison.savings, _where(content, comparison)
    if savings is None or isinstance(savings.value, Undefined):
        reason = value_text(None if savings is None else savings.value)
        return Claim(f"The savings{where} are {reason}.", _ids(comparison))
    places = places_of(savings)
    size = with_unit(value_text(abs(savings.value), places), savings.unit)
    interval = interval_text(savings)
    counts = f"n{EQUALS}{comparison.n_control} control and {comparison.n_treatment} treatment runs"
    evidence = (
        f"{level_text(savings)} {interval}; {counts}; {significance_text(comparison.welch)}" if interval else counts
    )
    shown, treatment = _excludes_zero(savings), sentence_start(swept_words(swept_factor(content)).treatment)
    if shown is None and savings.value < 0:
        lead = f"{treatment} cost {size} more energy a jump{where} by the best estimate, which cannot be bounded"
    elif shown is None:
        lead = f"The savings{where} cannot be bounded: the best estimate is {size}"
    elif not shown:
        sign = MINUS if savings.value < 0 else ""
        lead = f"No difference in energy was shown{where}: the estimated saving is {sign}{size}"
    elif savings.value > 0:
        lead = f"{treatment} saved {size} of the energy of a jump{where}"
    else:
        lead = f"{treatment} cost {size} more energy a jump{where}"
    return Claim(f"{lead} ({evidence}).{_picked(content, comparison)}", _ids(comparison))


def _picked(content: ReportContent, comparison: Comparison) -> str:
    """Say from how many savings the headline was picked as the largest; "" for any other, and where it is the only."""
    savings = [
        other.savings.value
        for other in content.comparisons
        if (other.family, other.quantity) == (comparison.family, comparison.quantity) and other.savings is not None
    ]
    known = [value for value in savings if not isinstance(value, Undefined)]
    own = None if comparison.savings is None else comparison.savings.value
    if not comparison.headline or len(known) < 2 or own != max(known):
        return ""
    return (
        f" It stands first as the largest of {len(known)} savings, one a group; its interval makes no allowance for "
        "having been picked."
    )


def difference_claim(content: ReportContent, comparison: Comparison) -> Claim:
    """Say how a quantity differed between control and treatment, and whether zero lies in the interval."""
    difference = as_shown(comparison.welch_difference)
    where = _where(content, comparison)
    what = "The apex" if comparison.quantity is Quantity.APEX else "The energy of a jump"
    if isinstance(difference.value, Undefined):
        return Claim(f"{what}{where}: the difference is {value_text(difference.value)}.", (difference.provenance,))
    comparative = "higher" if difference.value >= 0 else "lower"
    size = with_unit(value_text(abs(difference.value), places_of(comparison.welch_difference)), difference.unit)
    interval = interval_text(comparison.welch_difference)
    evidence = (
        f"{level_text(difference)} of the difference {interval}; {significance_text(comparison.welch)}"
        if interval
        else f"{count_text(comparison.n_control, 'control run')} and "
        f"{count_text(comparison.n_treatment, 'treatment run')} are too few for an interval"
    )
    verdict = {True: "", False: ", which the interval does not tell from zero", None: ""}[_excludes_zero(difference)]
    treatment = swept_words(swept_factor(content)).treatment
    lead = f"{what} was {size} {comparative} under {treatment}{where}{verdict}"
    return Claim(f"{lead} ({evidence}).", tuple(filter(None, (difference.provenance,))))


def _ids(comparison: Comparison) -> tuple[str, ...]:
    savings = comparison.savings
    ids = (savings.provenance if savings is not None else "", comparison.welch_difference.provenance)
    return tuple(filter(None, ids))


def absence_text(content: ReportContent, what: str) -> str:
    """Say that something is missing without guessing why: the reasons are in the list of limitations."""
    reasons = "; the reasons are listed under Limitations" if content.limitations else ""
    return f"There {what} for this selection{reasons}."
